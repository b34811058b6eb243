"""Figures in a notebook: a PNG, a computed caption, and the caption as its alternative text."""

from __future__ import annotations

import base64
import io
import os
import struct
import textwrap

import matplotlib.pyplot as plt
from IPython.display import display
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


def png(fig, dpi: float = DPI) -> bytes:
    """Return the figure as a PNG file and close it."""
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    plt.close(fig)
    return buffer.getvalue()


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
