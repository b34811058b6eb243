"""The correlation of notebook 04, to be dragged: what a measurement of A does to B, which nobody looks at."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ...ekf import Map, update
from ...graphics import ESTIMATE, MEASUREMENT, PREDICTED, UPDATED, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, GREY
from ..controls import Choice, Float
from ..widgets import explorable
from .parts import robot

A, B = slice(0, 2), slice(2, 4)
PLACES = np.array([-2.0, -0.6, 2.0, 0.6])  # estimates of A and B, m
SHAPE = np.array([[0.36, 0.12], [0.12, 0.2]])  # covariance of each, m^2
PAIRS = {"landmarks A and B": ("landmark A", "landmark B"), "robot and landmark B": ("the robot", "landmark B")}
SAMPLES = np.random.default_rng(4).standard_normal((400, 2))


def seen(rho: float, shift: float, noise: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Measure the place of A, and nothing else.

    Parameters
    ----------
    rho : float
        Correlation between A and B: of x with x, and of y with y.
    shift, noise : float
        A is measured so far to the right of its estimate, with this standard deviation; m.

    Returns
    -------
    P : ndarray, shape (4, 4)
        Covariance of A and B before.
    x, P_after : ndarray, shape (4,) and (4, 4)
        Estimates and covariance after the correction.
    """
    P = np.kron([[1.0, rho], [rho, 1.0]], SHAPE)
    map = Map()
    map.add(PLACES, P)
    blocks = [(A, np.eye(2))]  # the measurement is the place of A itself
    update(map, blocks, np.array([shift, 0.0]), noise**2 * np.eye(2))
    return P, map.x.copy(), map.P.copy()


@explorable(
    rho=Float(0.9, -0.95, 0.95, 0.05, "correlation of A and B"),
    shift=Float(1.0, -1.5, 1.5, 0.1, "A is seen to the right by", "m"),
    noise=Float(0.2, 0.1, 2.0, 0.1, "sigma of the measurement", "m"),
    pair=Choice("landmarks A and B", list(PAIRS), "A and B are"),
    ranges={"moved_m": (-1.5, 1.5), "shrunk_percent": (0, 96)},
)
def drag(rho, shift, noise, pair):
    """Two places with correlated errors; one is measured, and both move and shrink."""
    P, x, after = seen(rho, shift, noise)
    fig, (ax, joint) = plt.subplots(1, 2, figsize=(12.4, 5.2), layout="constrained", width_ratios=[1.45, 1])
    _plane(ax, P, x, after, shift, noise, PAIRS[pair])
    _errors(joint, P, x, after, shift, noise, PAIRS[pair])
    moved, shrunk = float(x[2] - PLACES[2]), float(100 * (1 - np.sqrt(after[2, 2] / P[2, 2])))
    a, b = PAIRS[pair]
    where = "stays" if abs(moved) < 0.005 else f"moves by {_side(moved, 2)}"
    caption = (
        f"Correlation {rho + 0.0:.2f}. {a[0].upper()}{a[1:]} is seen {_side(shift, 1)} of its estimate; {b}, which "
        f"nobody has seen, {where}, and its sigma falls from {np.sqrt(P[2, 2]):.2f} to {np.sqrt(after[2, 2]):.2f} m."
    )
    return fig, {"moved_m": moved, "shrunk_percent": shrunk, "caption": caption}


def _side(metres: float, digits: int) -> str:
    """Say a shift in words, as a reader sees it."""
    return f"{abs(metres):.{digits}f} m to the {'left' if metres < 0 else 'right'}"


def _plane(ax: Axes, P, x, after, shift, noise, names):
    """Draw both places before and after, and the measurement of A."""
    for r, mark in ((A, "o"), (B, "s")):
        ax.plot(*np.transpose([PLACES[r], x[r]]), color=GREY, linewidth=1.5, zorder=2)
        ax.plot(*PLACES[r], mark, color=PREDICTED["color"], fillstyle="none", markersize=9)
    for state, C, style, name in ((PLACES, P, PREDICTED, "before"), (x, after, UPDATED, "after")):
        means, covariances = state.reshape(2, 2), np.array([C[A, A], C[B, B]])
        plot_ellipse(ax, means, covariances, 3, **line(style, linewidth=2.2), label=f"{name}: {sigma_label(3)}")
    y = PLACES[A] + [shift, 0.0]
    ax.plot(*y, **points(MEASUREMENT, markersize=15, markeredgewidth=3), label="measured place of A")
    plot_ellipse(ax, y, noise**2 * np.eye(2), 3, **line(MEASUREMENT, linewidth=1.5))
    if names[0] == "the robot":
        robot(ax, [*x[A], 0.2], ESTIMATE, 0.4)
    else:
        ax.plot(*x[A], **points(UPDATED, markersize=9))
    ax.plot(*x[B], **points(UPDATED, markersize=9))
    for r, name in zip((A, B), names, strict=True):
        ax.text(PLACES[r][0], -2.9, name, ha="center", fontsize=13, color=BLACK)
    ax.set(xlim=(-5.2, 5.2), ylim=(-3.2, 3.8), xticks=range(-4, 5, 2), yticks=range(-2, 3, 2), aspect="equal")
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.legend(loc="upper center", ncols=2, fontsize=11)


def _errors(ax: Axes, P, x, after, shift, noise, names):
    """Draw what is known of both x coordinates together: what the measurement of A says is a strip."""
    both = np.ix_([0, 2], [0, 2])
    cloud = SAMPLES @ np.linalg.cholesky(P[both]).T
    ax.plot(*cloud.T, ".", color=GREY, markersize=3, zorder=1, label="places that may be true")
    ax.axvspan(shift - noise, shift + noise, color=MEASUREMENT["color"], alpha=0.3, linewidth=0, label="measured, ±1σ")
    moved = (x - PLACES)[[0, 2]]
    for mean, C, style in ((np.zeros(2), P, PREDICTED), (moved, after, UPDATED)):
        plot_ellipse(ax, mean, C[both], 3, **line(style, linewidth=2.2))
    ax.plot(*moved, **points(UPDATED, markersize=9))
    ax.set(xlim=(-2.2, 2.2), ylim=(-2.2, 2.2), xticks=range(-2, 3), yticks=range(-2, 3), aspect="equal")
    ax.set(xlabel=f"x of {names[0]}, against its estimate (m)", ylabel=f"x of {names[1]} (m)")
    ax.legend(loc="lower right", fontsize=11, handlelength=1.2)
