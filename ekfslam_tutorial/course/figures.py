"""Figures in a notebook: a PNG, a computed caption, and the caption as its alternative text."""

from __future__ import annotations

import base64
import io
import os
import struct
import textwrap

import matplotlib.pyplot as plt
from IPython.display import display
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

DPI = float(os.environ.get("EKFSLAM_DPI", 75))  # more for a projector: see cli/lecture.py


def show(fig, caption: str, dpi: float = DPI):
    """Show a figure as PNG and its caption as text below it.

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
    publish(png(fig, dpi), one_line(caption))


def publish(picture: bytes, caption: str):
    """Put a picture, then its caption, into the outputs of the cell."""
    output = bundle(with_palette(picture), caption)
    display(output["data"], metadata=output["metadata"], raw=True)
    # not printed: what a cell prints is gathered in one place, away from the picture
    display({"text/plain": textwrap.fill(caption, 100)}, raw=True)


def png(fig, dpi: float = DPI, places: Places | None = None) -> bytes:
    """Return the figure as a PNG file and close it. `places`: of the figures drawn before it at the same spot."""
    buffer = io.BytesIO()
    if places is not None and places.apply(fig):
        fig.set_dpi(dpi)
        FigureCanvasAgg(fig).print_png(buffer, metadata={"Software": None})  # draws once; savefig draws twice
    else:
        fig.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    if places is not None:
        places.remember(fig)
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


def with_palette(picture: bytes) -> bytes:
    """Return the PNG in 256 colours: a third of the size, and in a drawing no visible difference."""
    buffer = io.BytesIO()
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    image.quantize(256, dither=Image.Dither.NONE).save(buffer, format="png", optimize=True)
    return buffer.getvalue()


def size(picture: bytes) -> tuple[int, int]:
    """Return width and height of a PNG in pixels (bytes 16 to 24 of the file)."""
    return struct.unpack(">II", picture[16:24])


def bundle(picture: bytes, caption: str) -> dict:
    """Return the picture as a notebook output, the caption as its alternative text."""
    return {
        "data": {"image/png": base64.b64encode(picture).decode(), "text/plain": "<Figure>"},
        "metadata": {"image/png": {"alt": caption}},
    }


def one_line(text) -> str:
    """Return the text with single spaces."""
    return " ".join(str(text).split())
