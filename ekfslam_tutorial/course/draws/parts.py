"""Parts that the drawings of several notebooks share: a robot, landmarks with their ellipses, a gauge for NEES."""

from __future__ import annotations

import textwrap
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ...analysis.consistency import anees_band
from ...geometry import Frame2
from ...graphics import ESTIMATE, TRUTH, plot_ellipse, points, sigma_label
from ...graphics.artists import HALO
from ...graphics.bodies import move_faces, robot_body
from ...graphics.style import BLACK, GREEN, GREY, VERMILLION


def map_axes(ax: Axes, half: float, title: str = "", tick: float = 10.0) -> None:
    """Make square map axes around the origin, metres. (Few ticks: they take most of the time of a redraw.)"""
    ticks = np.arange(-half // tick + 1, half // tick + 1) * tick
    ax.set(xticks=ticks, yticks=ticks)
    ax.set(xlim=(-half, half), ylim=(-half, half), xlabel="x (m)", ylabel="y (m)", title=title, aspect="equal")


def robot(ax: Axes, pose, style=ESTIMATE, size: float = 0.5, **changes) -> None:
    """Draw a robot as an arrowhead: filled for an estimate, open for the truth."""
    face = move_faces(robot_body(2, size), Frame2(pose))[0]
    filled = style["fillstyle"] == "full"
    look = dict(facecolor=style["color"] if filled else "none", edgecolor=style["color"], alpha=0.85, zorder=6)
    ax.fill(*face.T, **{**look, **changes})


def landmarks(
    ax: Axes, x, P, ranges, k: float = 3, labels=(), style=ESTIMATE, name="estimate", away_from=None, **changes
) -> None:
    """Draw the landmarks in some ranges of a state, with their k-sigma ellipses and labels.

    A label stands outside of its ellipse, on the far side of a place (2,), or of one for each landmark (n, 2); by
    default that is the middle of all.
    """
    if not len(ranges):
        return
    l, B = np.array([x[r] for r in ranges]), np.array([P[r, r] for r in ranges])
    look = dict(color=style["color"], linestyle=style["linestyle"], linewidth=1.3, zorder=4)
    plot_ellipse(ax, l, B, k, **{**look, **changes}, label=sigma_label(k) if name else None)
    ax.plot(*l.T, **points(style, markersize=4), zorder=5, label=name or None)
    places = np.broadcast_to(l.mean(0) if away_from is None else away_from, l.shape)
    for p, C, place, text in zip(l, B, places, labels, strict=False):
        away = (p - place) / max(np.hypot(*(p - place)), 1e-9)
        edge = p + k * C @ away / max(np.sqrt(away @ C @ away), 1e-9)
        text_look: dict[str, Any] = dict(ha="center", va="center", fontsize=11, color=BLACK, zorder=8, **HALO)
        ax.annotate(text, tuple(edge), tuple(11 * away), textcoords="offset points", **text_look)


def true_landmarks(ax: Axes, p) -> None:
    """Draw the true landmarks as open stars."""
    ax.plot(*np.asarray(p).T, **points(TRUTH, markersize=9, markeredgewidth=1.0), zorder=5, label="truth")


def nees_gauge(ax: Axes, value: float, dof: int, runs: int, low: float = 0.8, high: float = 300.0) -> None:
    """Draw a horizontal dial for the mean NEES of some runs: the band of honest filters, and a pointer."""
    band = anees_band(dof, runs)
    honest = band[0] <= value <= band[1]
    ax.set(xscale="log", xlim=(low, high), ylim=(0, 1), yticks=[])
    ax.axvspan(low, high, color=GREY, alpha=0.15, linewidth=0)
    ax.axvspan(*band, color=GREEN, alpha=0.45, linewidth=0)
    ticks = [t for t in (1, 3, 10, 30, 100, 300) if low <= t <= high]
    ax.set_xticks(ticks, [str(t) for t in ticks])
    ax.minorticks_off()
    ax.grid(False)
    ax.spines[["left"]].set_visible(False)
    at = float(np.clip(value, low * 1.02, high / 1.02))
    ax.plot([at, at], [0, 1], color=BLACK, linewidth=3)
    words = "honest" if honest else ("too sure of itself" if value > band[1] else "too cautious")
    ax.set_title(f"NEES {value:.3g}: {words}", loc="left", weight="bold", color=BLACK if honest else VERMILLION)
    ax.set_xlabel(f"mean of {runs} runs; green: honest, {band[0]:.2g} to {band[1]:.2g}")


def say(fig, caption: str) -> None:
    """Print the caption of a figure that a notebook has shown already, for another log; the figure itself is closed."""
    plt.close(fig)
    print(textwrap.fill(" ".join(caption.split()), 100))
