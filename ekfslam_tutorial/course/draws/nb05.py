"""Drawings of notebook 05: range-bearing EKF-SLAM."""

from __future__ import annotations

from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import chi2_band, md2
from ...geometry import wrap
from ...graphics import (
    DEAD_RECKONING,
    ESTIMATE,
    MEASUREMENT,
    PREDICTED,
    REJECTED,
    TRUTH,
    UPDATED,
    covariance_panel,
    error_panels,
    line,
    plot_ellipse,
    points,
)
from ...graphics.style import BLACK, GREEN
from ..controls import Int
from ..widgets import explorable
from .nb04 import frame_changed
from .parts import landmarks, robot, true_landmarks
from .rounds import odometry_path, true_path, truth


def ranges_of(ids):
    """The range of each landmark in the state."""
    return [slice(3 + 2 * k, 5 + 2 * k) for k in range(len(ids))]


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def slam_map(x, P, ids, poses):
    """The whole run: map and path, truth, and the odometry alone. Returns (fig, caption)."""
    x, P, poses, real = np.asarray(x), np.asarray(P), np.asarray(poses), true_path()
    fig = plt.figure(figsize=(11, 6.4))
    ax = fig.add_axes((0.07, 0.1, 0.57, 0.88))
    true_landmarks(ax, list(truth().values()))
    ax.plot(*real[:, :2].T, **line(TRUTH), label="true path")
    ax.plot(*odometry_path()[:, :2].T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*poses[:, :2].T, **line(ESTIMATE), label="SLAM path")
    landmarks(ax, x, P, ranges_of(ids), labels=[str(i) for i in ids])
    robot(ax, real[-1], TRUTH, 0.35)
    robot(ax, poses[-1], ESTIMATE, 0.35)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)

    e, B = map_errors(x, P, ids)
    off = lambda path: np.hypot(*(path - real)[:, :2].T)
    return fig, (
        f"{len(ids)} landmarks; {int(np.sum(md2(e, B) < 9))} true ones lie inside their 3-sigma ellipse, worst error "
        f"{np.hypot(*e.T).max():.2f} m. Worst position error of the path: SLAM {off(poses).max():.2f} m, "
        f"odometry alone {off(odometry_path()).max():.2f} m."
    )


def map_errors(x, P, ids):
    """Errors of the landmarks, shape (n, 2), and their covariances, (n, 2, 2)."""
    e = np.array([x[r] - truth()[i] for i, r in zip(ids, ranges_of(ids), strict=True)])
    return e, np.array([P[r, r] for r in ranges_of(ids)])


def pose_errors(poses, covariances):
    """The errors of the pose over time, inside their 3-sigma bands. Returns (fig, caption)."""
    e = np.asarray(poses) - true_path()
    e[:, 2] = wrap(e[:, 2])
    s = np.sqrt(np.diagonal(np.asarray(covariances), axis1=1, axis2=2))
    e[:, 2], s[:, 2] = np.degrees(e[:, 2]), np.degrees(s[:, 2])
    axes = error_panels(np.arange(1, len(e) + 1), e, s, names=("x", "y", "heading"), units=("m", "m", "deg"))
    axes[-1].set_xlabel("time step k")
    for ax in axes[1:]:
        ax.get_legend().remove()
    fig = axes[0].figure
    fig.set_size_inches(10, 6.4)
    out = 100 * np.mean(np.abs(e) > 3 * s)
    return fig, (
        f"{out:.0f} % of the errors lie outside their band of 3 sigma. Largest errors: "
        f"{np.abs(e[:, 0]).max():.2f} m in x, {np.abs(e[:, 1]).max():.2f} m in y, "
        f"{np.abs(e[:, 2]).max():.1f} deg in heading."
    )


def trap(x_r, l, moved):
    """A landmark behind the robot, and where corrections with and without wrap put it. Returns (fig, caption).

    Parameters
    ----------
    x_r, l : ndarray, shape (3,) and (2,)
        Pose, and the landmark before.
    moved : dict of str to ndarray
        The landmark after each correction, by name: the right one first.
    """
    fig, ax = plt.subplots(figsize=(10, 4.6), layout="constrained")
    robot(ax, x_r, size=1.2)
    ax.annotate("robot, looks to the right", x_r[:2], (8, 10), textcoords="offset points", fontsize=12)
    ax.plot(*l, **points(TRUTH), label="before")
    for (name, p), style in zip(moved.items(), (UPDATED, REJECTED), strict=False):
        ax.annotate("", p, l, arrowprops=dict(arrowstyle="->", color=style["color"], linewidth=1.5))
        ax.plot(*p, **points(style, markersize=10), label=f"after: {name}")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    words = [f"{name}: {np.hypot(*(p - l)):.2g} m" for name, p in moved.items()]
    return fig, f"How far one correction moves the landmark. {'; '.join(words).capitalize()}."


def nees_runs(groups, dof):
    """The NEES of single runs, and the band of honest filters. Returns (fig, caption).

    Parameters
    ----------
    groups : dict of str to sequence of float
        NEES of each run, by the name of the filter.
    dof : int
        Number of states.
    """
    low, high = chi2_band(dof, 0.99)
    fig, ax = plt.subplots(figsize=(10, 1.7 + 0.8 * len(groups)), layout="constrained")
    ax.axvspan(low, high, color=GREEN, alpha=0.3, linewidth=0, label="99 % of the runs of an honest filter")
    ax.axvline(dof, color=BLACK, linestyle="--", linewidth=1.2, label=f"number of states, {dof}")
    words = []
    for row, ((name, values), style) in enumerate(zip(groups.items(), (ESTIMATE, REJECTED), strict=False)):
        v = np.asarray(values, float)
        ax.plot(v, np.full(len(v), -row), **points(style, markersize=7), label=f"{name}: one run each")
        words.append(f"{name}: {np.sum((v >= low) & (v <= high))} of {len(v)} runs inside, mean {np.mean(v):.3g}")
    ax.set(xscale="log", xlabel=f"NEES of the whole state, {dof} states", ylim=(-len(groups) + 0.4, 0.6))
    ax.set_yticks([-row for row in range(len(groups))], list(groups))
    ticks = [t for t in (10, 20, 35, 50, 100, 300, 1000, 3000, 10000, 30000, 100000) if ax.get_xlim()[1] > t]
    ax.set_xticks(ticks, [str(t) for t in ticks])
    ax.minorticks_off()
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    return fig, f"NEES for {dof} states, 99 % band {low:.0f} to {high:.0f}. {'; '.join(words).capitalize()}."


# ---- the step-through widget ----------------------------------------------------------------------------------------

FOUR = {7: (2.2, 1.2), 3: (0.4, 3.6), 12: (-2.4, 3.4), 4: (-2.6, 0.4)}  # the landmarks
OPERATIONS = 36  # of a round


class Step(NamedTuple):
    """The filter after one operation: what it was, with which landmark, and the state; the true pose, the frame."""

    text: str
    lmk: int | None
    x: np.ndarray
    P: np.ndarray
    ids: list
    pose: np.ndarray
    frame: int


@explorable(
    step=Int(35, 1, OPERATIONS, label="operation", play=1200, tip="Arrow keys move one operation"),
    ranges={"changed": (0, 25), "blocks": (1, 25)},
)
def blocks(steps, step):
    """Every operation of EKF-SLAM in a run of the notebook, and the blocks of P that it changes."""
    before, now = steps[step - 1], steps[step]
    fig = plt.figure(figsize=(12, 5.8))
    ax = fig.add_axes((0.06, 0.12, 0.38, 0.76))
    ax.set(xlim=(-4.3, 4.3), ylim=(-2.6, 6.0), xticks=range(-4, 5, 2), yticks=range(-2, 7, 2))  # few ticks: quick
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=f"frame {now.frame}")
    true_landmarks(ax, list(FOUR.values()))
    for s, style, name in ((before, PREDICTED, ""), (now, ESTIMATE, "estimate")):
        names = [str(id) for id in s.ids] if s is now else ()
        landmarks(ax, s.x, s.P, ranges_of(s.ids), labels=names, style=style, name=name)
        plot_ellipse(ax, s.x[:2], s.P[:2, :2], 3, **line(style, linewidth=1.3))
    ax.plot([], [], **line(PREDICTED), label="before")
    robot(ax, now.pose, TRUTH, 0.3)
    robot(ax, now.x[:3], ESTIMATE, 0.3)
    if now.lmk is not None:
        ax.plot(*np.transpose([now.x[:2], now.x[ranges_of(now.ids)[now.ids.index(now.lmk)]]]), **line(MEASUREMENT))
    ax.legend(loc="lower left", fontsize=11, ncols=2)

    panel = fig.add_axes((0.54, 0.1, 0.38, 0.78))
    sizes = {"robot": 3, **{f"l{i}": 2 for i in now.ids}}
    covariance_panel(now.P, sizes, ax=panel, title="P as correlations; framed: changed")
    fig.axes[-1].set_yticks([-1, -0.5, 0, 0.5, 1])  # of the colour bar
    edges = np.cumsum([0, *sizes.values()])
    old = aligned(before, now)
    changed = frame_changed(panel, old, now.P, edges, ["r", *map(str, now.ids)])
    fig.text(0.5, 0.96, f"operation {step}: {now.text}", ha="center", va="top", fontsize=16, weight="bold")
    n = len(sizes) ** 2
    sigma = np.sqrt(np.trace(now.P[:2, :2]))
    return fig, {
        "changed": len(changed),
        "blocks": n,
        "caption": f"Operation {step}, frame {now.frame}: {now.text}. {len(changed)} of {n} blocks of P change. "
        f"The robot's position has a sigma of {sigma:.2f} m.",
    }


def aligned(before, now):
    """The covariance of the step before, in the order of this one; NaN-free zeros for a landmark that was not there."""
    P = np.zeros_like(now.P)
    where = {id: r for id, r in zip(before.ids, ranges_of(before.ids), strict=True)}
    pairs = [(slice(0, 3), slice(0, 3))]
    pairs += [(r, where[id]) for id, r in zip(now.ids, ranges_of(now.ids), strict=True) if id in where]
    for a, c in pairs:
        for b, d in pairs:
            P[a, b] = before.P[c, d]
    return P


# ---- the sandbox ----------------------------------------------------------------------------------------------------


def sandbox_map(run, d, nees):
    """A simulated run: the map at its end. Returns (fig, facts), as a widget wants it.

    Parameters
    ----------
    run : object
        With `x`, `P`, `ids`; `truth`, the last true pose; `path` and `drift`, the poses of the filter and those of
        the odometry alone.
    d : ndarray, shape (n,)
        Errors of the state.
    nees : float
    """
    x, P, ids, drift = run.x, run.P, run.ids, np.asarray(run.drift)
    fig = plt.figure(figsize=(11, 6.4))
    ax = fig.add_axes((0.07, 0.1, 0.57, 0.88))
    ax.set(xlim=(-8.5, 8.5), ylim=(-7.5, 7.8), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    true_landmarks(ax, list(truth().values()))
    ax.plot(*drift[:, :2].T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*run.path[:, :2].T, **line(ESTIMATE), label="SLAM path")
    landmarks(ax, x, P, ranges_of(ids), labels=[str(i) for i in ids])
    robot(ax, run.truth, TRUTH, 0.35)
    robot(ax, x[:3], ESTIMATE, 0.35)
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    low, high = chi2_band(len(d), 0.99)
    verdict = "inside" if low <= nees <= high else "OUTSIDE"
    caption = (
        f"Step {len(run.path)}: {len(ids)} landmarks, position error {np.hypot(*d[:2]):.2f} m (odometry alone "
        f"{np.hypot(*(drift[-1] - run.truth)[:2]):.2f} m). NEES {nees:.3g} for {len(d)} states, {verdict} the 99 % "
        f"band of an honest filter, {low:.0f} to {high:.0f}."
    )
    return fig, {"landmarks": len(ids), "nees": nees, "caption": caption}
