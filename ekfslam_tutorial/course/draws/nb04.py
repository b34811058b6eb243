"""Drawings of notebook 04: from mapping to SLAM. The experiments stand in the notebook."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from ...analysis.consistency import anees_band, md2
from ...datasets import lecture
from ...ekf import Map, correct, covariance, cross, innovation
from ...geometry import Frame2
from ...graphics import (
    DEAD_RECKONING,
    ESTIMATE,
    MEASUREMENT,
    PREDICTED,
    TRUTH,
    UPDATED,
    covariance_panel,
    half_axes,
    line,
    plot_ellipse,
    sigma_label,
)
from ...graphics.style import BLACK, BLUE, GREEN, GREY, VERMILLION
from ...models.landmarks import EucPnt
from ...models.observation import observe
from .. import fleet
from ..controls import Choice, Int, Toggle
from ..widgets import explorable
from .parts import landmarks, map_axes, nees_gauge, robot, true_landmarks

SLAM, ZERO, MAPPING = "SLAM formula", "zero cross-covariance", "mapping formula"
EVERY = 20  # frames from one picture of the split screen to the next


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def odometry_map(map, lmks, path):
    """The lecture's log mapped with odometry poses as if they were exact. Returns (fig, caption)."""
    true = dict(zip(*lecture.true_landmarks(), strict=True))
    ranges = [lmk.r for lmk in lmks.values()]
    real = np.array([lecture.get_pose(k) for k in range(1, lecture.n_steps() + 1)])
    fig = plt.figure(figsize=(11, 6.4))
    ax = fig.add_axes((0.07, 0.1, 0.57, 0.88))
    true_landmarks(ax, list(true.values()))
    ax.plot(*real[:, :2].T, **line(TRUTH), label="true path")
    ax.plot(*path[:, :2].T, **line(DEAD_RECKONING), label="odometry, taken as exact")
    stars = np.array([true[id] for id in lmks])  # the labels stand on the other side
    landmarks(ax, map.x, map.P, ranges, labels=[str(i) for i in lmks], away_from=stars)
    for id, r in zip(lmks, ranges, strict=True):
        ax.plot(*np.transpose([map.x[r], true[id]]), color=VERMILLION, linewidth=1, zorder=3)
    ax.plot([], [], color=VERMILLION, linewidth=1, label="error")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)

    e = np.array([map.x[r] - true[id] for id, r in zip(lmks, ranges, strict=True)])
    inside = int(np.sum(md2(e, np.array([map.P[r, r] for r in ranges])) < 9))
    return fig, (
        f"{inside} of {len(lmks)} true landmarks lie inside their 3-sigma ellipse; an honest map has nearly all. "
        f"The worst error is {np.hypot(*e.T).max():.1f} m. At the end the odometry is "
        f"{np.hypot(*(path[-1] - real[-1])[:2]):.1f} m off."
    )


def birth(robots, cloud, x_r, P_rr, l, ellipses):
    """Where a new landmark may be when the pose is uncertain. Returns (fig, caption).

    Parameters
    ----------
    robots, cloud : ndarray, shape (N, 3) and (N, 2)
        Sampled poses, and the landmark that follows from each.
    x_r, P_rr, l : ndarray
        Mean and covariance of the pose, mean of the landmark.
    ellipses : dict of str to ndarray
        Covariances of the landmark by name: one or two.
    """
    fig, (ax, side) = plt.subplots(1, 2, figsize=(12, 5.4), layout="constrained", width_ratios=[1.25, 1])
    ax.plot(*robots[:, :2].T, ".", color=GREY, markersize=2, label="possible poses")
    ax.plot(*cloud.T, ".", color=MEASUREMENT["color"], markersize=2, label="landmark, one per pose")
    plot_ellipse(ax, x_r[:2], P_rr[:2, :2], color=GREY, linewidth=1.5)
    robot(ax, x_r, size=0.35)
    for (name, S), style in zip(ellipses.items(), (PREDICTED, ESTIMATE), strict=False):
        plot_ellipse(ax, l, S, 3, color=style["color"], linestyle=style["linestyle"], linewidth=2.5, label=name)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title=f"the landmark: samples and {sigma_label(3)}")
    ax.legend(loc="lower right", markerscale=4)

    turn = np.degrees(robots[:, 2] - x_r[2])
    ray = (l - x_r[:2]) / np.hypot(*(l - x_r[:2]))
    sideways = (cloud - l) @ np.array([-ray[1], ray[0]])
    c = np.corrcoef(turn, sideways)[0, 1]
    side.plot(turn, sideways, ".", color=MEASUREMENT["color"], markersize=2.5)
    side.axhline(0, color=BLACK, linewidth=0.8)
    side.axvline(0, color=BLACK, linewidth=0.8)
    side.set(xlabel="error of the heading (deg)", ylabel="error of the landmark, sideways (m)")
    side.set_title(f"they err together: correlation {c:.2f}")
    words = [f"{100 * np.mean(md2(cloud - l, S) < 9):.0f} % ({name})" for name, S in ellipses.items()]
    return fig, (
        f"{len(cloud)} samples. Inside the 3-sigma ellipse lie {' and '.join(words)}; an honest ellipse holds 99 %. "
        f"Heading error and sideways landmark error have the correlation {c:.2f}."
    )


def two_covariances(before, after, sizes, titles=("before", "after")):
    """Two covariances as correlations, blocks that differ framed in the second. Returns (fig, caption)."""
    edges = np.cumsum([0, *sizes.values()])
    fig, axes = plt.subplots(1, 2, figsize=(12, 5.2), layout="constrained")
    for ax, P, title in zip(axes, (before, after), titles, strict=True):
        covariance_panel(P, sizes, ax=ax, title=title)
    changed = frame_changed(axes[1], before, after, edges)
    n = len(sizes) ** 2
    return fig, f"{len(changed)} of {n} blocks have changed (framed): {', '.join(changed) or 'none'}."


def frame_changed(ax, before, after, edges, names=None, tolerance=1e-12):
    """Frame the blocks of a covariance panel that have changed; return their names, upper triangle only."""
    names = names or ["r", *map(str, range(1, len(edges) - 1))]
    changed, frames = [], []
    for i, (a, b) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        for j, (c, d) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            if np.abs(after[a:b, c:d] - before[a:b, c:d]).max() > tolerance:
                frames.append(Rectangle((c - 0.5, a - 0.5), d - c, b - a))
                changed.append(f"P_{names[i]}{names[j]}")
    ax.add_collection(PatchCollection(frames, facecolor="none", edgecolor=GREEN, linewidth=3.5, zorder=5))
    return changed


def nees_figure(results):
    """NEES over time of each formula, with the band of honest filters. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(11, 5.2), layout="constrained")
    low, high = anees_band(3, next(iter(results.values())).nees.shape[1])
    styles = [(BLUE, "-"), (VERMILLION, "--"), (BLACK, ":")]
    for (name, r), (color, dash) in zip(results.items(), styles, strict=False):
        mean = np.convolve(np.nanmean(r.nees, 1), np.ones(20) / 20, "valid")
        ax.plot(r.t[19:], mean, color=color, linestyle=dash, linewidth=2.4, label=name)
    ax.axhspan(
        low, high, color=GREEN, alpha=0.35, linewidth=0, label=f"95 % band of honest filters, {low:.1f} to {high:.1f}"
    )
    end = next(iter(results.values())).t[-1]
    lap = end / 2
    ax.axvline(lap, color=GREY, linestyle="-.", linewidth=1.2)
    ax.text(lap, 0.6, " first loop closed", color=GREY, fontsize=12)
    ax.set(yscale="log", xlabel="t (s)", ylabel="NEES of the pose, 3 states (-)", xlim=(0, end))
    ax.set_ylim(0.5, None)
    ax.set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    words = [f"{np.nanmean(r.nees):.2g} ({name})" for name, r in results.items()]
    return fig, f"Mean NEES over time and runs, ideal 3: {', '.join(words)}."


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    frame=Int(540, EVERY, 1240, EVERY, "frame", play=250),
    wrong=Choice(MAPPING, [MAPPING, ZERO], "left side"),
    ranges={"nees_wrong": (0, 1000), "nees_slam": (1, 8)},
)
def split_screen(results, world, frame, wrong):
    """The same run twice: a wrong formula for new landmarks on the left, the SLAM formula on the right.

    `results` are those of the fleets by the name of the formula, with the states of one run; `world` their scenario.
    """
    fig = plt.figure(figsize=(12, 7.3))
    facts, words = {}, []
    for side, (formula, key) in enumerate(((wrong, "wrong"), (SLAM, "slam"))):
        r = results[formula]
        x, P = r.states[frame]
        left = 0.065 + 0.5 * side
        ax = fig.add_axes((left, 0.27, 0.42, 0.68))
        seen = {i: s for i, s in r.ranges.items() if s.stop <= len(x)}
        inside = sum(bool(md2(x[s] - world.points[i], P[s, s]) < 9) for i, s in seen.items())
        map_axes(ax, 15, f"{formula}: {inside} of {len(seen)} stars in their ellipse")
        if side:
            ax.set_ylabel("")
        true_landmarks(ax, world.points)
        ax.plot(*r.truth[:frame, :2].T, **line(TRUTH, linewidth=1.2), label="true path")
        landmarks(ax, x, P, list(seen.values()))
        robot(ax, r.truth[frame - 1], TRUTH, 0.8)
        robot(ax, x[:3], ESTIMATE, 0.8)
        plot_ellipse(ax, x[:2], P[:2, :2], 3, color=BLUE, linewidth=1.3)
        value = float(np.mean(r.nees[frame - 1]))
        nees_gauge(fig.add_axes((left, 0.1, 0.42, 0.05)), value, 3, r.nees.shape[1])
        facts[f"nees_{key}"] = value
        off = float(np.hypot(*(x[:2] - r.truth[frame - 1, :2])))
        words.append(f"NEES {value:.2g}, the robot {off:.2f} m off, {inside} of {len(seen)} stars in their ellipse")
    fig.axes[0].legend(loc="upper left", fontsize=11, ncols=2)
    facts["caption"] = (
        f"Frame {frame}, t = {frame * world.dt:.0f} s. {wrong.capitalize()}: {words[0]}. SLAM formula: {words[1]}. "
        "An honest filter has a NEES of about 3."
    )
    return fig, facts


MOMENTS = {"half way round (30 s)": 300, "just before the loop closes (54 s)": 540, "after the loop (70 s)": 700}


@explorable(
    landmark=Int(2, 1, 16, label="landmark that is seen", play=900, tip="by its number in the map"),
    moment=Choice(540, MOMENTS, "moment"),
    correlated=Toggle(True, "keep the covariances between robot and landmarks"),
    ranges={"shrunk": (0, 20), "most": (0, 100)},
)
def web(r, world, landmark, moment, correlated):
    """One landmark is measured: which ellipses shrink? Those that are correlated with what is measured.

    `r` is the result of a fleet with the states of one run, `world` its scenario.
    """
    x, P = r.states[moment]
    ranges = [s for s in r.ranges.values() if s.stop <= len(x)]
    landmark = min(landmark, len(ranges))
    P = P if correlated else without_cross(P, [slice(0, 3), *ranges])
    seen = ranges[landmark - 1]
    after, shared = see(x, P, seen, ranges, world.sensor)
    loss = np.array([1 - np.sqrt(np.trace(after[s, s]) / np.trace(P[s, s])) for s in ranges])
    shrunk = loss > 0.1

    fig = plt.figure(figsize=(11, 6.8))
    ax = fig.add_axes((0.06, 0.09, 0.57, 0.89))
    map_axes(ax, 15)
    for s, c in zip(ranges, shared, strict=True):
        if s != seen and c > 0.05:
            ax.plot(*np.transpose([x[seen], x[s]]), color=MEASUREMENT["color"], linewidth=6 * c, alpha=0.6, zorder=1)
    ax.plot(*np.transpose([x[:2], x[seen]]), **line(MEASUREMENT, linewidth=2.5), label="the measurement")
    ax.plot([], [], color=MEASUREMENT["color"], linewidth=4, alpha=0.6, label="correlation with it (wide: near 1)")
    landmarks(ax, x, P, ranges, style=PREDICTED, name="", labels=[str(i + 1) for i in range(len(ranges))])
    ax.plot([], [], **line(PREDICTED), label=f"before: {sigma_label(3)}")
    for group, name, style in (
        (shrunk, "after: more than 10 % smaller", UPDATED),
        (~shrunk, "after: nearly the same", ESTIMATE),
    ):
        chosen = [s for s, yes in zip(ranges, group, strict=True) if yes]
        landmarks(ax, x, after, chosen, style=style, name="", linewidth=2.4)
        if chosen:
            ax.plot([], [], **line(style, linewidth=2.4), label=name)
    ax.plot(*x[seen], marker="o", markersize=16, fillstyle="none", color=BLACK, markeredgewidth=2, linestyle="none",
            label=f"seen: landmark {landmark}")  # fmt: skip
    plot_ellipse(ax, x[:2], P[:2, :2], 3, **line(PREDICTED, linewidth=1.3))
    robot(ax, x[:3], ESTIMATE, 0.8)
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    others = np.delete(loss, landmark - 1)
    best = int(np.argmax(np.where(np.arange(len(loss)) == landmark - 1, -1, loss))) + 1
    most = 100 * float(others.max(initial=0))
    caption = (
        f"The robot sees landmark {landmark} only. {shrunk.sum()} of {len(ranges)} ellipses shrink by more than 10 %. "
    )
    if most > 0.5:
        caption += f"Of those not in view, landmark {best} gains most: its sigma falls by {most:.0f} %."
    else:
        caption += "Those not in view do not change at all."
    return fig, {"shrunk": int(shrunk.sum()), "most": most, "caption": caption}


def without_cross(P, ranges):
    """The covariance with zeros between different states."""
    D = np.zeros_like(P)
    for s in ranges:
        D[s, s] = P[s, s]
    return D


def see(x, P, seen, ranges, sensor):
    """Measure the landmark in range `seen`, as well as the sensor does.

    Returns
    -------
    ndarray, shape (n, n)
        The covariance afterwards.
    list of float
        Largest correlation, 0 to 1, of each of the landmarks in `ranges` with the measurement.
    """
    map = Map()
    map.add(x, P)
    e, E_r, _, E_l = observe(Frame2(x[:3]), fleet.AT_ROBOT, sensor, EucPnt(2), x[seen])
    blocks = (slice(0, 3), E_r), (seen, E_l)
    PHt = cross(map, blocks)
    inn = innovation(0 * e, covariance(PHt, blocks), sensor.R)
    shared = [float(np.linalg.norm(np.linalg.pinv(half_axes(P[s, s])) @ PHt[s] @ inn.iL.T, 2)) for s in ranges]
    correct(map, PHt, inn)
    return map.P.copy(), shared
