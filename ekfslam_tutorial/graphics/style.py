"""What a colour, a marker and a line style mean, in every figure of the package.

Each role differs in colour *and* in shape, so that a figure can be read without colours. The colours are
those of Okabe and Ito, "Color Universal Design" (2008): people with any of the common kinds of colour
blindness tell them apart.

A style is a dictionary for ``ax.plot``. Give it whole, or through `line` (no markers) or `points` (no line)::

    ax.plot(x, y, **line(TRUTH), label="true path")
    ax.plot(px, py, **points(ESTIMATE), label="estimated landmarks")
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
from cycler import cycler

BLACK, ORANGE, SKY_BLUE, GREEN, YELLOW, BLUE, VERMILLION, PURPLE = OKABE_ITO = (
    "#000000",
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#F0E442",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
)
GREY = "#8A8A8A"  # ground, raw data, axes: what stays in the background
LIGHT_GREY = "#D9D9D9"

ROBOTS = (BLUE, ORANGE, "#882255", SKY_BLUE, "#5B3A00", "#332288", "#CC6677", VERMILLION)
"""The colour of each robot of a run, by its place in the list of robots, in every picture, film and player.

The first five differ by at least 24 in CIELAB from each other and from black, for those who see all colours and for
each kind of colour blindness (simulated after Machado et al. 2009), all eight by 18. Wine, indigo and rose are of Paul
Tol's "muted", the brown is none of theirs, the others are Okabe and Ito's.
"""

Style = dict[str, Any]

# fmt: off
TRUTH       : Style = dict(color=BLACK,      marker="*", linestyle="--", fillstyle="none")
ESTIMATE    : Style = dict(color=BLUE,       marker="o", linestyle="-",  fillstyle="full")
MEASUREMENT : Style = dict(color=ORANGE,     marker="+", linestyle=":",  fillstyle="full")
REJECTED    : Style = dict(color=VERMILLION, marker="x", linestyle=":",  fillstyle="full")
PREDICTED   : Style = dict(color=PURPLE,     marker="s", linestyle="--", fillstyle="none")
UPDATED     : Style = dict(color=GREEN,      marker="D", linestyle="-",  fillstyle="full")
DEAD_RECKONING : Style = dict(color=GREY,    marker="v", linestyle="-.", fillstyle="none")
# fmt: on

# A star needs more room than a dot to look the same size.
_MARKER_SIZE = {"*": 11.0, "o": 5.0, "+": 9.0, "x": 7.5, "s": 7.0, "D": 5.5, "v": 6.0}


def line(style: Style, **changes: Any) -> Style:
    """Return the style of a line without markers (a path, an ellipse, a curve).

    Parameters
    ----------
    style : dict
        One of the styles of this module.
    **changes
        Other arguments of ``ax.plot``, which win.
    """
    return {"color": style["color"], "linestyle": style["linestyle"], **changes}


def points(style: Style, **changes: Any) -> Style:
    """Return the style of markers without a line (landmarks, measurements).

    Parameters
    ----------
    style : dict
        One of the styles of this module.
    **changes
        Other arguments of ``ax.plot``, which win.
    """
    marker = style["marker"]
    size = _MARKER_SIZE.get(marker, 6.0)
    return {**style, "linestyle": "none", "markersize": size, "markeredgewidth": 1.6, **changes}


def use_style(dpi: float = 75) -> None:
    """Set the package's look for the figures that are made from now on.

    Parameters
    ----------
    dpi : float
        Dots per inch of the figure. 75 keeps stored notebooks small; a file for print wants 150 or more.
    """
    plt.rcParams.update(
        {
            "figure.dpi": dpi,
            "figure.figsize": (8.0, 5.0),
            "figure.facecolor": "white",
            "savefig.dpi": "figure",
            "font.size": 13,
            "axes.titlesize": 14,
            "axes.labelsize": 13,
            "xtick.labelsize": 12,
            "ytick.labelsize": 12,
            "legend.fontsize": 12,
            "legend.framealpha": 0.9,
            "legend.edgecolor": LIGHT_GREY,
            "axes.prop_cycle": cycler(color=[BLUE, ORANGE, GREEN, VERMILLION, PURPLE, SKY_BLUE, BLACK]),
            "axes.grid": True,
            "axes.axisbelow": True,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "grid.color": LIGHT_GREY,
            "grid.linewidth": 0.6,
            "lines.linewidth": 1.8,
            "image.cmap": "viridis",
        }
    )
