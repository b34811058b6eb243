"""Figures in a notebook: a picture in few bytes, a computed caption, and the caption for those who do not see it.

A picture is stored as PNG, or as SVG where that is smaller: so it is for a drawing of some lines. Both are the same
bytes on each build: no dates, no random names, letters as outlines and not as fonts of this computer.
"""

from __future__ import annotations

import base64
import html
import io
import os
import re
import sys
import textwrap
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb
from PIL import Image

from ..graphics.style import GREY, LIGHT_GREY, OKABE_ITO

DPI = float(os.environ.get("EKFSLAM_DPI", 120))  # more for a projector: see cli/lecture.py
SCREEN = 96  # CSS pixels of an inch: a picture is as wide in the notebook as its figure says, however many dots it has
LOOK_ONLY = sys.platform == "emscripten" or DPI < SCREEN
"""In a browser, or with few dots, as the tests of the notebooks draw: nobody keeps the pictures in a repository."""
MARKS = [np.round(255 * np.array(to_rgb(colour))).astype(int) for colour in (*OKABE_ITO, GREY, LIGHT_GREY)]
SMALLER = (
    0.8  # an SVG must be that much smaller: every viewer of notebooks shows a PNG, and some slides and papers want it
)
LINES = re.compile(r'<img alt="([^"]*)" width="\d+" src="data:image/svg\+xml;base64,([^"]*)">')
NUMBERS = re.compile(r"-?\d+\.\d{3,}")
SVG: Any = {"svg.fonttype": "path", "svg.hashsalt": "ekfslam", "svg.image_inline": True}


def show(fig, caption: str, dpi: float = DPI):
    """Show a figure and its caption as text below it.

    The caption is computed from what the figure shows, so that it says the truth, can be read by those who do
    not see the picture, and is compared by the tests (the picture is not).

    Parameters
    ----------
    fig : matplotlib Figure
        It is closed afterwards.
    caption : str
        One or two sentences with the numbers that matter, two or three digits each.
    dpi : float
    """
    publish(picture(fig, dpi), one_line(caption))


def publish(picture: bytes, caption: str):
    """Put a picture, then its caption, into the outputs of the cell."""
    output = bundle(picture, caption)
    display(output["data"], metadata=output["metadata"], raw=True)
    # not printed: what a cell prints is gathered in one place, away from the picture
    display({"text/plain": textwrap.fill(caption, 100)}, raw=True)


def picture(fig, dpi: float = DPI) -> bytes:
    """Return the figure as a PNG or an SVG file, whichever is smaller, and close it; for a look only, a quick PNG."""
    if LOOK_ONLY:  # drawing it twice takes a second
        return png(fig, dpi, quick=True)
    dots = with_palette(png(fig, dpi, close=False), (256,) if has_shades(fig) else (32, 64, 128, 256))
    lines = svg(fig)
    return lines if len(lines) < SMALLER * len(dots) else dots


def svg(fig) -> bytes:
    """Return the figure, which has been drawn already, as an SVG file without anything of this computer; close it."""
    buffer = io.StringIO()
    fig.set_layout_engine("none")  # the axes stay where they were drawn
    with mpl.rc_context(SVG):
        fig.savefig(buffer, format="svg", metadata={"Creator": None, "Date": None, "Format": None, "Type": None})
    plt.close(fig)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    # a hundredth of a point is enough for a place; the scale of a letter needs all its digits
    text = re.sub(r' (d|x|y|points)="[^"]*"', lambda found: NUMBERS.sub(shorter, found[0]), text)
    return re.sub(r"<!--.*?-->|\n\s*", " ", text, flags=re.DOTALL).replace("> <", "><").encode()


def has_shades(fig) -> bool:
    """Return True if the figure shows a colour map: few colours would make steps of it."""
    return any(ax.images or any(isinstance(c, QuadMesh) for c in ax.collections) for ax in fig.axes)


def shorter(number: re.Match) -> str:
    """Return a number with two decimals at most."""
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def png(fig, dpi: float = DPI, places: Places | None = None, close: bool = True, quick: bool = False) -> bytes:
    """Return the figure as a PNG file and close it.

    `places`: of the figures drawn before it at the same spot. `quick`: it is not to be stored, and may take more bytes.
    """
    buffer, how = io.BytesIO(), {"compress_level": 1} if quick else {}
    if places is not None and places.apply(fig):
        fig.set_dpi(dpi)
        FigureCanvasAgg(fig).print_png(buffer, metadata={"Software": None}, pil_kwargs=how)  # savefig draws twice
    else:
        fig.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None}, pil_kwargs=how)
    if places is not None:
        places.remember(fig)
    if close:
        plt.close(fig)
    return buffer.getvalue()


class Places:
    """Where the axes of a drawing lie, kept from one redraw to the next.

    matplotlib's constrained layout measures every text twice: half of the time of a redraw. It is needed only
    when something that takes room outside the axes has changed: limits (and so tick labels), titles, labels,
    legends, the view of a 3D scene. As long as these are the same, the axes stay exactly where they were.
    """

    def __init__(self):
        self.rooms, self.positions, self.headings = None, [], []

    def apply(self, fig) -> bool:
        """Put the axes where they were, if they need the same room; return whether the layout is settled."""
        if fig.get_layout_engine() is None:
            return True
        if self.rooms != rooms(fig):
            return False
        fig.set_layout_engine("none")
        for ax, position in zip(fig.axes, self.positions, strict=True):
            ax.set_position(position, which="original")
        for text, position in zip(fig.texts, self.headings, strict=True):
            text.set_position(position)
        return True

    def remember(self, fig):
        """Keep the positions of the figure just drawn."""
        self.rooms = rooms(fig)
        self.positions = [ax.get_position(original=True) for ax in fig.axes]
        self.headings = [text.get_position() for text in fig.texts]


def rooms(fig) -> list:
    """Return what decides how much room the figure needs outside the frames of its axes."""
    return [tuple(fig.get_size_inches()), [text.get_text() for text in fig.texts], *map(room, fig.axes)]


def room(ax) -> tuple:
    """Return what decides how much room axes need outside their frame.

    A legend inside the frame needs none, and a title needs as much as it has lines, whatever it says.
    """
    legend = ax.get_legend()
    entries = ()
    if legend is not None and legend.get_bbox_to_anchor() is not ax.bbox:
        entries = tuple(t.get_text() for t in legend.get_texts())
    beside = tuple(t.get_text() for t in ax.texts if t.get_transform() is not ax.transData)
    formats = tuple(tuple(getattr(axis.get_major_formatter(), "seq", ())) for axis in (ax.xaxis, ax.yaxis))
    view = (ax.elev, ax.azim, ax.get_zlim()) if hasattr(ax, "get_zlim") else ()
    titles = tuple(len(ax.get_title(loc).splitlines()) for loc in ("left", "center", "right"))
    return ax.get_xlim(), ax.get_ylim(), view, titles, ax.get_xlabel(), ax.get_ylabel(), formats, entries, beside


def with_palette(picture: bytes, colours=(32, 64, 128, 256)) -> bytes:
    """Return the PNG with as few colours as nobody misses: a third of the size, or a quarter.

    The colours of marks stay as they are, however small the mark: each has one meaning.

    Parameters
    ----------
    picture : bytes
    colours : sequence of int
        Numbers of colours to try, from few to many; the last one is taken in any case.

    Notes
    -----
    A picture for a look only stays as it is: each would take a second more.
    """
    if LOOK_ONLY:
        return picture
    image = Image.open(io.BytesIO(picture))
    dpi, image = image.info["dpi"], image.convert("RGB")
    pixels = np.asarray(image, np.int64) @ [1 << 16, 1 << 8, 1]
    found, index, times = np.unique(pixels, return_inverse=True, return_counts=True)
    rgb = np.stack([found >> 16, found >> 8 & 255, found & 255], -1)
    marks = [c for c in MARKS if times[(rgb == c).all(-1)].sum() >= 4]
    some = image.resize([1 + n // 3 for n in image.size], Image.Resampling.NEAREST)  # enough to choose the colours
    for n in colours:
        palette = some.quantize(n - len(marks), kmeans=4, dither=Image.Dither.NONE)
        if changed(some, palette) < 0.0015:
            break
    chosen = np.array([*np.reshape(palette.getpalette() or [], (-1, 3)), *marks])
    chosen[chosen.sum(1).argmax()] = 255  # the lightest is the paper: pure white
    few = Image.fromarray(nearest(rgb, chosen)[index].reshape(pixels.shape), "P")
    few.putpalette(chosen.ravel().tolist())
    buffer = io.BytesIO()
    few.save(buffer, format="png", optimize=True, dpi=dpi)
    return buffer.getvalue()


def nearest(rgb, colours):
    """Return for each of the colours `rgb` the index of the one that is nearest to it."""
    return ((rgb[:, None] - colours) ** 2).sum(-1).argmin(1).astype(np.uint8)


def changed(image, few) -> float:
    """Return the share of the pixels that have another colour in the picture of few colours, as an eye sees it."""
    off = np.abs(np.asarray(image, np.int16) - np.asarray(few.convert("RGB"), np.int16))
    return float(np.mean(off.max(-1) > 24))


def size(picture: bytes) -> tuple[int, int]:
    """Return width and height that a picture takes on the screen, in CSS pixels."""
    if picture.startswith(b"<svg"):
        width, height = (float(value) / 72 for value in re.findall(rb'(?:width|height)="([\d.]+)pt"', picture)[:2])
    else:
        image = Image.open(io.BytesIO(picture))
        width, height = (n / dpi for n, dpi in zip(image.size, image.info["dpi"], strict=True))
    return round(width * SCREEN), round(height * SCREEN)


def bundle(picture: bytes, caption: str) -> dict:
    """Return the picture as a notebook output, the caption as its alternative text."""
    width, code = size(picture)[0], base64.b64encode(picture).decode()
    if picture.startswith(b"<svg"):
        # in an image of its own: inside the page its names would meet those of other pictures, and viewers of notebooks
        # take parts of an SVG away that could do harm in a page
        page = f'<img alt="{html.escape(caption)}" width="{width}" src="data:image/svg+xml;base64,{code}">'
        return {"data": {"text/html": page, "text/plain": "<Figure>"}, "metadata": {}}
    return {
        "data": {"image/png": code, "text/plain": "<Figure>"},
        "metadata": {"image/png": {"alt": caption, "width": width}},
    }


def stored(output: dict) -> tuple[str, str, str] | None:
    """Return the picture of a stored output: its kind ("image/png"), its base64 code and its alternative text.

    None if the output is no picture.
    """
    data = {kind: "".join(value) for kind, value in output.get("data", {}).items()}
    if "image/png" in data:
        code = data["image/png"].replace("\n", "")
        return "image/png", code, output["metadata"].get("image/png", {}).get("alt", "")
    found = LINES.fullmatch(data.get("text/html", ""))
    return ("image/svg+xml", found[2], html.unescape(found[1])) if found else None


def one_line(text) -> str:
    """Return the text with single spaces."""
    return " ".join(str(text).split())
