"""Drawings of notebook 00: how to read a figure, and an angle that goes round."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import md2
from ...geometry import wrap
from ...graphics import ESTIMATE, MEASUREMENT, REJECTED, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, GREY, LIGHT_GREY
from ..controls import Float, Toggle
from ..widgets import explorable
from .parts import robot

FONT = 13


def legend_figure():
    """What the marks mean in every figure of the course. Returns (fig, caption)."""
    l, P = np.array([4.0, 1.0]), np.array([[0.10, 0.06], [0.06, 0.12]])
    cloud = np.random.default_rng(4).multivariate_normal(l, P, 2000)
    fig = plt.figure(figsize=(10.5, 4.0))
    ax = fig.add_axes((0.08, 0.15, 0.56, 0.83))
    robot(ax, np.zeros(3), size=0.7)
    ax.annotate("robot (estimate: filled)", (0, 0), (-14, -34), textcoords="offset points", fontsize=FONT)
    ax.plot(*cloud.T, ".", color=GREY, markersize=2, alpha=0.6, label=f"{len(cloud)} samples of its Gaussian")
    ax.plot([0, 4.15], [0, 0.8], **line(MEASUREMENT))
    ax.plot(4.15, 0.8, **points(MEASUREMENT, markersize=13, markeredgewidth=2.5), label="measurement")
    ax.plot(1.9, 1.6, **points(REJECTED, markersize=11, markeredgewidth=2.5), label="rejected measurement")
    plot_ellipse(ax, l, P, k=3, color=ESTIMATE["color"], linewidth=2, label=sigma_label(3))
    ax.plot(*l, **points(ESTIMATE, markersize=8), label="estimate")
    ax.plot(4.3, 1.35, **points(TRUTH, markersize=15), label="truth")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", xlim=(-1.0, 5.8), ylim=(-1.0, 2.6))
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=FONT)
    inside = 100 * np.mean(md2(cloud - l, P) < 9)
    return fig, (
        f"How to read the figures: colour and shape say the same. {inside:.1f} % of the {len(cloud)} samples lie "
        "inside the 3-sigma ellipse; in the plane a Gaussian has 98.9 % there."
    )


@explorable(
    angle_deg=Float(250.0, -720.0, 720.0, 10.0, "angle", "deg", tip="Click the slider, then use the arrow keys"),
    wrapped=Toggle(True, label="wrap it"),
    ranges={"shown_deg": (-720, 720)},
)
def hello(angle_deg, wrapped):
    """An angle on the circle, and the same angle through wrap."""
    a = float(np.radians(angle_deg))
    shown = float(wrap(a)) if wrapped else a
    fig, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained", width_ratios=(1, 1.4))

    turn = np.linspace(0, shown, 400)
    radius = 0.45 + 0.04 * np.abs(turn)
    _circle(left)
    left.plot(radius * np.cos(turn), radius * np.sin(turn), color=MEASUREMENT["color"], linewidth=2.5)
    _arrow(left, a, BLACK)
    left.set_title(f"{np.degrees(shown):.0f} deg = {shown:.2f} rad")

    grid = np.linspace(-4 * np.pi, 4 * np.pi, 1601)
    saw = np.where(np.abs(np.diff(wrap(grid), prepend=0)) > 3, np.nan, wrap(grid))
    right.plot(np.degrees(grid), np.degrees(saw), **line(ESTIMATE), label="wrap(angle)")
    right.plot(np.degrees(grid), np.degrees(grid), color=GREY, linestyle="-.", label="angle, not wrapped")
    right.plot(angle_deg, np.degrees(shown), **points(ESTIMATE, markersize=10), label="this angle")
    right.set(xlabel="angle (deg)", ylabel="result (deg)", ylim=(-760, 760) if not wrapped else (-270, 270))
    right.set_xticks(np.arange(-720, 721, 360))
    right.set_yticks(np.arange(-720, 721, 360) if not wrapped else (-180, 0, 180))
    right.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, columnspacing=1.0)
    turns = round((angle_deg - np.degrees(shown)) / 360)
    caption = (
        f"An angle of {angle_deg:.0f} deg is shown as {np.degrees(shown):.0f} deg; "
        f"{abs(turns)} whole turn{'s' * (abs(turns) != 1)} removed."
    )
    return fig, {"shown_deg": float(np.degrees(shown)), "caption": caption}


def means_figure(headings, mean, good):
    """Headings on a circle and two answers for their mean. Returns (fig, caption).

    Parameters
    ----------
    headings : array_like, shape (n,)
        Radians.
    mean, good : float
        The mean of the numbers, and the mean through wrapped differences, radians.
    """
    mean, good = float(mean), float(good)
    fig, ax = plt.subplots(figsize=(10, 4.2), layout="constrained")
    _circle(ax)
    for k, heading in enumerate(np.asarray(headings, float)):
        ax.plot(
            [0, np.cos(heading)], [0, np.sin(heading)], **line(MEASUREMENT), label=None if k else "measured headings"
        )
    for a, style, label in ((mean, REJECTED, "mean of the numbers"), (good, ESTIMATE, "mean of wrapped differences")):
        _arrow(ax, a, style["color"])
        ax.plot(1.06 * np.cos(a), 1.06 * np.sin(a), **points(style, markersize=11, markeredgewidth=2.5), label=label)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    off = abs(np.degrees(wrap(mean - good)))
    return fig, (
        f"The mean of the numbers is {np.degrees(mean):.0f} deg, the mean of wrapped differences is "
        f"{np.degrees(wrap(good)):.0f} deg: {off:.0f} deg apart."
    )


def _circle(ax):
    t = np.linspace(0, 2 * np.pi, 200)
    ax.plot(np.cos(t), np.sin(t), color=LIGHT_GREY, linewidth=2)
    for degrees, text in ((0, "0"), (90, "90"), (180, "±180"), (270, "−90")):
        a = np.radians(degrees)
        ax.text(1.34 * np.cos(a), 1.17 * np.sin(a), f"{text}°", ha="center", va="center", fontsize=FONT)
    ax.set(xlim=(-1.6, 1.6), ylim=(-1.35, 1.35), aspect="equal")
    ax.axis("off")


def _arrow(ax, a, color):
    arrow = dict(arrowstyle="-|>", color=color, linewidth=2.5, mutation_scale=18, shrinkA=0, shrinkB=0)
    ax.annotate("", (np.cos(a), np.sin(a)), (0, 0), arrowprops=arrow)
