"""Drawings of notebook 07: data association."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

from ...analysis.consistency import md2
from ...ekf import Map
from ...geometry import Frame2
from ...graphics import ESTIMATE, MEASUREMENT, REJECTED, TRUTH, ellipse_points, line, plot_ellipse, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...simulation.simulator import SimObs
from ...slam import Jcbb, Lmk, NearestNeighbour, Rob, Sen, place, project_lmks
from ...slam.association import gate
from ..controls import Choice, Float, Toggle
from ..widgets import explorable
from .parts import landmarks, map_axes, robot, true_landmarks

NAMES, MARKS, COLOURS = "ABC", ("o", "s", "^"), (BLUE, GREEN, VERMILLION)


def pairs_by(rule, moment, sensor):
    """What a rule of the package makes of a moment of the notebook: pairs {measurement: landmark}.

    Parameters
    ----------
    rule : Association
        `NearestNeighbour()`, for example.
    moment : object
        With `x`, `P`, pose and landmarks of the map; `ys`, shape (k, 2), the measurements.
    sensor : RangeBearing
    """
    map = Map()
    rob, sen = Rob(1, Odometry2()), Sen(1, 1, sensor, Frame2, x=np.zeros(3))
    place(map, rob, moment.x[:3], moment.P[:3, :3])
    ranges = [_range(j) for j in range((len(moment.x) - 3) // 2)]
    lmks = [Lmk(j, EucPnt(2), r=map.add(moment.x[r], moment.P[r, r])) for j, r in enumerate(ranges)]
    raw = SimObs(1, np.full(len(moment.ys), -1), moment.ys)
    return {i: j for j, i in rule(map, project_lmks(map, rob, sen, lmks), raw, sensor).pairs.items()}


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def ghosts_figure(right, wrong, room):
    """Landmarks in the map with a wrapped and with an unwrapped bearing. Returns (fig, caption).

    Parameters
    ----------
    right, wrong : list
        The filter after each frame: `x`, `P`; `origin`, which true landmark started each one; `truth`, the true pose.
    room : ndarray, shape (N, 2)
        True landmarks.
    """
    fig, (ax, side) = plt.subplots(1, 2, figsize=(13, 6.2), layout="compressed", width_ratios=[1, 1.1])
    last = wrong[-1]
    _room_axes(ax, "bearing not wrapped")
    true_landmarks(ax, room)
    again = [j for j, true in enumerate(last.origin) if true in last.origin[:j]]
    landmarks(ax, last.x, last.P, [_range(j) for j in range(len(last.origin)) if j not in again])
    ax.plot(
        *np.reshape([last.x[_range(j)] for j in again], (-1, 2)).T,
        **points(REJECTED, markersize=11, markeredgewidth=2.5),
        label="created again",
        zorder=7,
    )
    ax.plot(*np.array([m.truth[:2] for m in wrong]).T, **line(TRUTH, linewidth=1.2))
    robot(ax, last.x[:3], ESTIMATE, 0.7)
    ax.legend(loc="lower center", ncols=4, fontsize=10, columnspacing=0.9, handlelength=1.4)
    for moments, color, dash, name in ((wrong, VERMILLION, "--", "not wrapped"), (right, BLUE, "-", "wrapped")):
        counts = [len(m.origin) for m in moments]
        side.step(range(len(counts)), counts, color=color, linestyle=dash, linewidth=2.5, label=name)
    side.axhline(len(room), color=BLACK, linestyle=":", label="true number")
    side.set(xlabel="frame", ylabel="landmarks in the map (-)", ylim=(0, None))
    side.legend(loc="lower right")
    return fig, (
        f"{len(room)} true landmarks. After {len(right) - 1} frames the map has {len(right[-1].origin)} with the "
        f"wrap, and without it {len(last.origin)}: {len(again)} were created again."
    )


def _range(j):
    """The range of landmark j in the state."""
    return slice(3 + 2 * j, 5 + 2 * j)


def push_figure(runs, posts):
    """A drive along a corridor with one push, by several rules. Returns (fig, caption).

    Parameters
    ----------
    runs : dict of str to list
        By the name of the rule, the filter after each frame: `x`, `P`, `origin`, `truth`, `used`, `wrong`.
    posts : ndarray, shape (N, 2)
        True landmarks.
    """
    fig, axes = plt.subplots(len(runs), 1, figsize=(13, 2.6 * len(runs)), layout="constrained", sharex=True)
    words = []
    for ax, (name, moments) in zip(axes, runs.items(), strict=True):
        last = moments[-1]
        true_landmarks(ax, posts)
        landmarks(ax, last.x, last.P, [_range(j) for j in range(len(last.origin))])
        ax.plot(*np.array([m.truth[:2] for m in moments]).T, **line(TRUTH), label="true path")
        ax.plot(*np.array([m.x[:2] for m in moments]).T, **line(ESTIMATE), label="SLAM path")
        robot(ax, last.truth, TRUTH, 0.5)
        robot(ax, last.x[:3], ESTIMATE, 0.5)
        used, wrong = sum(m.used for m in moments), sum(m.wrong for m in moments)
        off = np.hypot(*(last.x[:2] - last.truth[:2]))
        ax.set(ylabel="y (m)", ylim=(-2.4, 2.4), aspect="equal", title=f"{name}: {wrong} of {used} matches are wrong")
        words.append(f"{name} {wrong} of {used}, the robot {off:.2f} m off, {len(last.origin)} landmarks")
    axes[-1].set_xlabel("x (m)")
    axes[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=11)
    true = len(set(runs[next(reversed(runs))][-1].origin))
    return fig, f"Wrong matches, and the end of the drive past {true} posts: {'; '.join(words)}."


def clutter_figure(runs, true):
    """Number of landmarks in the map over time, when some measurements are false. Returns (fig, caption).

    Parameters
    ----------
    runs : dict of str to list
        By the name of the rule, the filter after each frame; `origin` says which true landmark started each one, -1
        for none.
    true : int
        Number of true landmarks.
    """
    fig, ax = plt.subplots(figsize=(11, 4.8), layout="constrained")
    words = []
    looks = zip((VERMILLION, BLUE, GREEN), ("--", "-", "-."), strict=True)
    for (name, moments), (color, dash) in zip(runs.items(), looks, strict=False):
        ax.plot([len(m.origin) for m in moments], color=color, linestyle=dash, linewidth=2.5, label=name)
        false = sum(origin < 0 for origin in moments[-1].origin)
        words.append(f"{name}: {len(moments[-1].origin)} landmarks, {false} of them false")
    ax.axhline(true, color=BLACK, linestyle=":", label="true number")
    ax.set(xlabel="frame", ylabel="landmarks in the map (-)", ylim=(0, None))
    ax.legend()
    return fig, f"One false measurement a frame on average. At the end: {'; '.join(words)}."


def counts_figure(slips, right: dict[str, list]):
    """Right pairs against the slip of the robot. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(11, 4.4), layout="constrained")
    words = []
    for (name, values), (color, mark) in zip(
        right.items(), ((GREEN, "s:"), (VERMILLION, "x--"), (BLUE, "o-")), strict=False
    ):
        ax.plot(slips, values, mark, color=color, linewidth=2.2, markersize=9, markeredgewidth=2, label=name)
        words.append(f"{name} {np.mean(values):.1f} of 8")
    ax.set(xlabel="slip of the robot along the corridor (m)", ylabel="right pairs (-)", ylim=(-0.4, 8.6))
    ax.legend()
    return fig, f"Right pairs, mean over the slips from {min(slips):g} to {max(slips):g} m: {', '.join(words)}."


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    range_m=Float(7.4, 2.0, 9.0, 0.1, "measured range", "m"),
    bearing_deg=Float(10.0, -30, 80, 1, "measured bearing", "deg"),
    heading_std_deg=Float(4.0, 0.0, 10.0, 0.5, "sigma of the heading", "deg"),
    confidence=Choice(0.99, {"95 %": 0.95, "99 %": 0.99, "99.99 %": 0.9999}, "gate"),
    ranges={"inside": (0, 3), "d2_nearest": (0, 1e6)},
)
def gate_space(places, expected, range_m, bearing_deg, heading_std_deg, confidence):
    """Gates in the measurement space, and the same moment in metres: which landmark is the nearest?

    The notebook hands over where the landmarks are, and expected(heading_std_deg) -> expectations, covariances Z.
    """
    y, limit = np.array([range_m, np.radians(bearing_deg)]), gate(confidence, 2)
    es, Zs = expected(heading_std_deg)
    d2 = md2(y - es, Zs)  # far from the seam: nothing to be wrapped
    p = range_m * np.array([np.cos(y[1]), np.sin(y[1])])
    metres = np.hypot(*(places - p).T)

    fig, (ax, side) = plt.subplots(1, 2, figsize=(13, 6), layout="constrained")
    for e, Z, name, mark, color, d in zip(es, Zs, NAMES, MARKS, COLOURS, d2, strict=True):
        ring = ellipse_points(e, Z, np.sqrt(limit))
        ax.plot(np.degrees(ring[:, 1]), ring[:, 0], color=color, linewidth=2.5, linestyle="-" if d <= limit else ":")
        ax.plot(np.degrees(e[1]), e[0], mark, color=color, markersize=9, label=f"{name}: $d^2$ = {d:.1f}")
    ax.plot(bearing_deg, range_m, **points(MEASUREMENT, markersize=16, markeredgewidth=3), label="measurement y")
    ax.plot([], [], color=GREY, linewidth=2.5, label=f"gate {100 * confidence:g} %: $d^2 \\leq$ {limit:.1f}")
    ax.plot([], [], color=GREY, linewidth=2.5, linestyle=":", label="gate that y does not pass")
    ax.set(xlabel="bearing (deg)", ylabel="range (m)", xlim=(-35, 90), ylim=(1, 11), title="measurement space")
    ax.legend(loc="upper right", fontsize=11)
    for place_, name, mark, color, m in zip(places, NAMES, MARKS, COLOURS, metres, strict=True):
        side.plot(*np.transpose([p, place_]), color=GREY, linewidth=1)
        side.plot(*place_, mark, color=color, markersize=9, label=f"{name}: {m:.2f} m")
    side.plot(*p, **points(MEASUREMENT, markersize=16, markeredgewidth=3), label="where y points")
    robot(side, np.zeros(3), ESTIMATE, 0.6)
    side.set(xlim=(-1, 10), ylim=(-3, 8), xticks=range(0, 11, 2), yticks=range(-2, 9, 2))
    side.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title="metres")
    side.legend(loc="upper right", fontsize=11)

    near, nearest = int(np.argmin(metres)), int(np.argmin(d2))
    inside = [name for name, d in zip(NAMES, d2, strict=True) if d <= limit]
    agree = "the two agree" if near == nearest else "the two disagree"
    passed = f"It passes the gate of {' and '.join(inside)}." if inside else "It passes no gate."
    caption = (
        f"Nearest in metres: {NAMES[near]} ({metres[near]:.2f} m). Nearest in units of sigma: {NAMES[nearest]} "
        f"(d2 = {d2[nearest]:.1f}); {agree}. {passed}"
    )
    return fig, {"inside": len(inside), "d2_nearest": float(d2[nearest]), "caption": caption}


def swap(moments, table, fine, frame, swap_at, room):
    """One wrong match: the map shears, and the NEES never comes back. Returns (fig, facts).

    Parameters
    ----------
    moments : list
        The filter after each frame: `x`, `P`; `ranges`, of the landmarks by id; `truth`, the true pose.
    table, fine : ndarray, shape (F, 2)
        NEES of the map per state, and error of its shape (m), in each frame; the same without a swap.
    frame, swap_at : int
        The frame that is shown, and that of the swap; 0 is none.
    room : ndarray, shape (N, 2)
        True landmarks.
    """
    now = moments[frame]
    fig = plt.figure(figsize=(13, 6.2))
    ax = fig.add_axes((0.055, 0.1, 0.42, 0.84))
    _room_axes(ax, f"frame {frame}")
    true_landmarks(ax, room)
    landmarks(ax, now.x, now.P, list(now.ranges.values()))
    errors = [(now.x[r], room[id]) for id, r in now.ranges.items()]
    ax.add_collection(LineCollection(errors, color=ORANGE, linewidth=2, zorder=3, label="error"))
    robot(ax, now.truth, TRUTH, 0.7)
    robot(ax, now.x[:3], ESTIMATE, 0.7)
    plot_ellipse(ax, now.x[:2], now.P[:2, :2], 3, color=BLUE, linewidth=1.3)
    ax.legend(loc="lower center", ncols=4, fontsize=10, columnspacing=0.9, handlelength=1.4)
    labels = ("NEES of the map,\nper state (-)", "error of the shape (m)")
    for side, column, label in zip((0.57, 0.1), (0, 1), labels, strict=True):
        side = fig.add_axes((0.57, side, 0.42, 0.37))
        side.plot(fine[:, column], color=BLUE, linewidth=2, label="no swap")
        if swap_at:
            bad = table[: frame + 1, column]
            side.plot(bad, color=VERMILLION, linestyle="--", linewidth=2.5, label="with the swap")
            side.axvline(swap_at, color=GREY, linestyle=":", linewidth=1.5)
        side.axvline(frame, color=BLACK, linewidth=1)
        side.set(xlim=(0, len(moments) - 1), xticks=range(0, len(moments) - 1, 25), ylabel=label)
        if column == 0:
            side.set(yscale="log", ylim=(0.1, 500))
            side.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
            side.minorticks_off()
            side.axhline(1, color=BLACK, linestyle=":", linewidth=1.5, label="honest: 1")
            side.legend(loc="upper right", fontsize=11, ncols=3)
        else:
            side.set(xlabel="frame", ylim=(0, 1.3), yticks=(0, 0.5, 1))
    happened = "No swap" if not swap_at else f"Swap in frame {swap_at}"
    caption = (
        f"{happened}; now frame {frame}. NEES of the map per state {table[frame, 0]:.2g} (honest: 1, without a swap "
        f"{fine[frame, 0]:.2g}); the shape of the map is wrong by {table[frame, 1]:.2f} m."
    )
    return fig, {"nees": float(table[frame, 0]), "shape_m": float(table[frame, 1]), "caption": caption}


@explorable(
    slip=Float(0.7, -1.2, 1.2, 0.1, "slip of the robot", "m"),
    slip_std=Float(0.4, 0.05, 0.8, 0.05, "sigma along the corridor", "m"),
    end=Toggle(True, "the last two posts are in view"),
    ranges={"nn_right": (0, 8), "jcbb_right": (0, 8)},
)
def two_ways(corridor, sensor, slip, slip_std, end):
    """A symmetric corridor, corridor(slip, slip_std, end): nearest neighbour above, joint compatibility below."""
    moment = corridor(slip, slip_std, end)
    fig, axes = plt.subplots(2, 1, figsize=(12, 6.6), layout="constrained", sharex=True)
    facts, words = {}, []
    seen, posts = sensor.retro(moment.ys)[0], moment.x[3:].reshape(-1, 2)  # from the estimated pose, the origin
    for ax, association, name, key in (
        (axes[0], NearestNeighbour(), "nearest neighbour", "nn_right"),
        (axes[1], Jcbb(), "joint compatibility (JCBB)", "jcbb_right"),
    ):
        pairs = pairs_by(association, moment, sensor)
        right = sum(moment.ids[i] == j for i, j in pairs.items())
        ax.plot(*posts.T, **points(ESTIMATE, markersize=9), label="posts in the map")
        ax.plot(
            *seen.T,
            **points(MEASUREMENT, markersize=15, markeredgewidth=2.5),
            label="measured, from the estimated pose",
        )
        for i, j in pairs.items():
            good = moment.ids[i] == j
            color, dash = (GREEN, "-") if good else (VERMILLION, "--")
            ax.plot(*np.transpose([seen[i], posts[j]]), color=color, linestyle=dash, linewidth=3.5, zorder=2)
        ax.plot([], [], color=GREEN, linewidth=3.5, label="right pair")
        ax.plot([], [], color=VERMILLION, linestyle="--", linewidth=3.5, label="wrong pair")
        plot_ellipse(ax, np.zeros(2), moment.P[:2, :2], 3, color=BLUE, linewidth=1.3, label="pose, 3σ ellipse (98.9 %)")
        robot(ax, moment.pose, TRUTH, 0.4)
        robot(ax, np.zeros(3), ESTIMATE, 0.4)
        ax.set(
            xlim=(-2.6, 8),
            ylim=(-2, 2),
            ylabel="y (m)",
            aspect="equal",
            title=f"{name}: {right} of {len(pairs)} pairs are right",
        )
        facts[key] = right
        words.append(f"{name} makes {len(pairs)} pairs, {right} of them right")
    axes[1].set_xlabel("x (m)")
    axes[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1), fontsize=11)
    return fig, {**facts, "caption": f"The robot is {slip:.1f} m ahead of its estimate: {'; '.join(words)}."}


def _room_axes(ax, title):
    map_axes(ax, 9.5, title)
    ax.set(xticks=np.arange(-8, 9, 4), yticks=np.arange(-8, 9, 4))
