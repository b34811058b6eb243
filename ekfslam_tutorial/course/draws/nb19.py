"""Drawings of notebook 19: a truck in Victoria Park, trees that nobody tells apart, GPS beside the path."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ...graphics import DEAD_RECKONING, ESTIMATE, MEASUREMENT, REJECTED, UPDATED, line, plot_ellipse, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY_BLUE, VERMILLION
from ..controls import Int, Toggle
from ..logs.nb19 import recording
from ..widgets import explorable
from .parts import robot
from .parts import say as say

GATE, NEW = 9.21, 24.9  # squared distances: 99 % and 99.9996 % of chi-square with 2 degrees of freedom
SHARE = 0.95
PICTURES = 50  # of the park
POINTS = 600  # of a path that is drawn


class Kept:
    """What the figures want of a run: `add` takes each frame.

    Attributes
    ----------
    used, born : int
        Detections that corrected; trees ever started.
    seen : int
        Detections there were.
    views : list
        Now and then: time, pose, trees.
    """

    def __init__(self, frames):
        self.rows, self.views, self.used, self.seen, self.born = [], [], 0, 0, 0
        self.last: Any = None
        self.every = max(frames // PICTURES, 1)

    def add(self, now):
        """Keep a frame."""
        r = now.robs[0].r
        P, kinds = now.map.block(r), [e.kind for e in now.events]
        self.rows.append([now.t, *now.map.state(r)[:2], np.sqrt(P[0, 0] + P[1, 1]), len(now.lmks)])
        self.used, self.born = self.used + kinds.count("correction"), self.born + kinds.count("initialisation")
        self.seen += len(now.raw[1].ids)
        self.last = now
        if now.k % self.every == 0:
            self.views.append((now.t, now.map.state(r)[:3].copy(), self.trees))

    @property
    def trees(self):
        """Where the trees are that are in the map at the end, m."""
        return np.array([lmk.point(self.last.map)[0] for lmk in self.last.lmks.values()]).reshape(-1, 2)

    @property
    def finds(self):
        """How often each of them was found."""
        return np.array([lmk.n_match for lmk in self.last.lmks.values()])

    t = property(lambda self: np.array(self.rows)[:, 0], doc="Times of the frames, s.")
    path = property(lambda self: np.array(self.rows)[:, 1:3], doc="Where the laser was, m.")
    std = property(lambda self: np.array(self.rows)[:, 3], doc="Standard deviation of the position, m.")
    n_trees = property(lambda self: np.array(self.rows)[:, 4].astype(int), doc="Trees in the map.")


def from_gps(which, d):
    """Distances of a run to the GPS fixes in its time, and their root mean square without the worst 5 %, m."""
    fixes = recording(which).fixes[1]
    fixes = fixes[(fixes[:, 0] >= d.t[0]) & (fixes[:, 0] <= d.t[-1])]
    at = np.column_stack([np.interp(fixes[:, 0], d.t, d.path[:, i]) for i in (0, 1)])
    far = np.hypot(*(at - fixes[:, 1:]).T)
    best = np.sort(far)[: int(SHARE * len(far))]
    return far, float(np.sqrt(np.mean(best**2)))


# ---- the log --------------------------------------------------------------------------------------------------------


def scan_figure(which, k):
    """Scan k as the truck sees it, and how many detections all scans have. Returns (fig, caption)."""
    rec = recording(which)
    raw = rec.raw[1]
    fig, (ax, bars) = plt.subplots(1, 2, figsize=(12, 5.6), width_ratios=[1.35, 1], layout="constrained")
    r, b = raw[k].y.T
    angle = np.radians(np.linspace(-90, 90, 90))
    for reach in (10, 20, 30, 40):
        ax.plot(-reach * np.sin(angle), reach * np.cos(angle), color=GREY, linewidth=0.6)
    ax.plot(-r * np.sin(b), r * np.cos(b), **points(MEASUREMENT, markersize=12), label="detection")
    robot(ax, [0, 0, np.pi / 2], size=2.5)
    ax.set(xlabel="to the right (m)", ylabel="ahead (m)", aspect="equal", title=f"{which}: scan at {rec.t[k]:.0f} s")
    ax.legend(loc="upper right")
    n = np.diff(raw.offsets)
    bars.hist(n, np.arange(n.max() + 2) - 0.5, color=SKY_BLUE, edgecolor="w")
    bars.set(xlabel="detections in a scan (-)", ylabel="scans (-)", xticks=range(0, n.max() + 1, 5))
    return fig, (
        f"{which.capitalize()}: {len(rec)} scans in {rec.t[-1]:.0f} s with {len(raw.ids)} detections, {n.mean():.1f} "
        f"in a scan, none of them with a name. GPS: {len(rec.fixes[1])} fixes, the longest gap "
        f"{np.diff(rec.fixes[1][:, 0]).max():.0f} s."
    )


def dead_reckoning_figure(which, paths):
    """Paths by the controls alone, {name: path}, the model first, and GPS. Returns (fig, caption)."""
    rec = recording(which)
    fig, ax = plt.subplots(figsize=(10, 6.6), layout="constrained")
    ax.plot(*rec.fixes[1][::3, 1:].T, **points(MEASUREMENT, markersize=4), label="GPS")
    looks = (("-", BLUE), ("--", VERMILLION), (":", GREEN))
    words = []
    for (name, path), (dash, color) in zip(paths.items(), looks, strict=False):
        ax.plot(*path[:: max(len(path) // POINTS, 1)].T, linestyle=dash, color=color, linewidth=1.6, label=name)
        at = [np.column_stack([np.interp(rec.fixes[1][:, 0], rec.t, path[:, i]) for i in (0, 1)])]
        far = np.hypot(*(at[0] - rec.fixes[1][:, 1:]).T)
        words.append(f"{name} {np.median(far):.0f} m")
    ax.set(xlabel="x, east (m)", ylabel="y, north (m)", aspect="equal", title=which)
    ax.set_adjustable("datalim")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    (first, model), *others = paths.items()
    apart = [f"{name} {np.linalg.norm(path - model, axis=1).max():.0f} m" for name, path in others]
    return fig, (
        f"{which.capitalize()}, by the controls alone: median distance to GPS {', '.join(words)}. "
        f"Largest distance to {first}: {', '.join(apart)}."
    )


# ---- association ----------------------------------------------------------------------------------------------------


def gates_figure(which, s, j):
    """One scan in the measurement space: expected trees with their gates, and what becomes of the detections.

    Parameters
    ----------
    which : str
    s : dict
        y (k, 2): detections. e (n, 2), Z (n, 2, 2): expectations and covariances of the innovations. t: s; trees: how
        many there are in the map.
    j : (k,)
        The tree of each detection; -1: a new one; -2: not used.
    """
    fig, ax = plt.subplots(figsize=(11, 6.2), layout="constrained")
    turn = np.array([[0, np.degrees(1)], [1, 0]])  # bearing in degrees across, range up
    e = s["e"] @ turn.T
    for k, (looks, name) in {
        np.sqrt(GATE): (line(ESTIMATE), "expected tree, gate 99 %"),
        np.sqrt(NEW): (line(DEAD_RECKONING), "gate of new trees, 99.9996 %"),
    }.items():
        plot_ellipse(ax, e, turn @ s["Z"] @ turn.T, k, **{**looks, "linewidth": 1.4}, label=name)
    y = s["y"] @ turn.T
    for kind, looks, name in (
        (j >= 0, {**UPDATED, "fillstyle": "none", "markersize": 9}, "used"),
        (j == -1, {**MEASUREMENT, "markersize": 13}, "starts a tree"),
        (j == -2, {**REJECTED, "markersize": 10}, "not used"),
    ):
        ax.plot(*y[kind].T, **{**points(looks), "markeredgewidth": 2}, label=f"{name}: {kind.sum()}", zorder=6)
    ax.invert_xaxis()
    ax.set(xlabel="bearing (deg), left is left", ylabel="range (m)", title=f"{which}, scan at {s['t']:.0f} s")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return fig, (
        f"{which.capitalize()}, scan at {s['t']:.0f} s: {s['trees']} trees in the map, {len(e)} of them should "
        f"be in view; of {len(y)} detections {(j >= 0).sum()} are used, {(j == -1).sum()} start a tree, "
        f"{(j == -2).sum()} are not used."
    )


def rates_figure(which, every, errors):
    """The distance to GPS over the time between two scans, {rule: errors}. Returns (fig, caption)."""
    dt = float(np.median(np.diff(recording(which).t)))
    fig, ax = plt.subplots(figsize=(9.6, 5.4), layout="constrained")
    for (name, e), (color, mark, dash) in zip(errors.items(), ((ORANGE, "s", "--"), (BLUE, "o", "-")), strict=True):
        ax.plot(np.array(every) * dt, e, color=color, marker=mark, linestyle=dash, markersize=9, label=name)
    ax.set(yscale="log", xlabel="time from scan to scan (s)", ylabel="distance to GPS (m)", title=which)
    ax.set_yticks([1, 3, 10, 30], ["1", "3", "10", "30"])
    ax.minorticks_off()
    ax.legend()
    words = [f"{name} {', '.join(f'{e:.1f}' for e in row)} m" for name, row in errors.items()]
    return fig, (
        f"{which.capitalize()}, one scan each {', '.join(f'{k * dt:.1f}' for k in every)} s: distance to GPS (root "
        f"mean square without the worst 5 %) with {' and with '.join(words)}."
    )


def path_figure(which, d, name):
    """Path, trees, GPS of a run. Returns (fig, caption)."""
    _, error = from_gps(which, d)
    fig, ax = plt.subplots(figsize=(9.6, 6.4), layout="constrained")
    fixes = recording(which).fixes[1]
    ax.plot(*fixes[fixes[:, 0] <= d.t[-1], 1:].T, **points(MEASUREMENT, markersize=4), label="GPS")
    ax.plot(*d.path[:: max(len(d.path) // POINTS, 1)].T, **line(ESTIMATE), label="EKF-SLAM")
    ax.plot(*d.trees.T, **points(ESTIMATE, markersize=4), label="trees")
    ax.set(xlabel="x, east (m)", ylabel="y, north (m)", aspect="equal", title=f"{which}, {name}")
    ax.set_adjustable("datalim")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return fig, (
        f"{which.capitalize()}, {name}: {len(d.trees)} trees in the map, {100 * d.used / d.seen:.0f} % of the "
        f"detections used, distance to GPS {error:.1f} m."
    )


# ---- upkeep ---------------------------------------------------------------------------------------------------------


def upkeep_figure(which, kept, cleaned):
    """How many trees the map has over time, without and with deletion. Returns (fig, caption)."""
    fig, (ax, bars) = plt.subplots(1, 2, figsize=(12.5, 5.2), layout="constrained")
    ax.plot(kept.t, kept.n_trees, color=VERMILLION, linestyle="--", linewidth=2, label="nobody is deleted")
    ax.plot(cleaned.t, cleaned.n_trees, color=BLUE, linewidth=2, label="deleted if found in less than 20 %")
    ax.set(xlabel="time (s)", ylabel="trees in the map (-)", ylim=(0, None), title=which)
    ax.legend(loc="upper left")
    edges = [0.5, 1.5, 4.5, 9.5, 19.5, 49.5, 1e9]
    for d, shift, color, hatch in ((kept, -0.2, VERMILLION, "//"), (cleaned, 0.2, BLUE, "")):
        count = np.histogram(d.finds, edges)[0]
        bars.bar(np.arange(len(count)) + shift, count, 0.4, color=color, hatch=hatch, edgecolor="w")
    bars.set_xticks(range(6), ["1", "2-4", "5-9", "10-19", "20-49", "50 +"])
    bars.set(xlabel="detections of a tree (-)", ylabel="trees at the end (-)")
    errors = [from_gps(which, d)[1] for d in (kept, cleaned)]
    return fig, (
        f"{which.capitalize()}, {kept.t[-1]:.0f} s: without deletion {kept.n_trees[-1]} trees, "
        f"{np.sum(kept.finds < 5)} of them detected less than 5 times; with deletion {cleaned.n_trees[-1]} trees. "
        f"Distance to GPS {errors[0]:.2f} m and {errors[1]:.2f} m."
    )


# ---- the whole park -------------------------------------------------------------------------------------------------


def park_figure(which, d, far, error):
    """Path, trees and GPS of the whole log, and how far the two are from each other. Returns (fig, caption)."""
    fixes = recording(which).fixes[1]
    fig, (ax, low) = plt.subplots(1, 2, figsize=(12.4, 5.8), width_ratios=[1, 1.1], layout="constrained")
    ax.plot(*fixes[:, 1:].T, **points(MEASUREMENT, markersize=4), label="GPS")
    ax.plot(*d.path[:: max(len(d.path) // POINTS, 1)].T, **line(ESTIMATE), linewidth=1.4, label="EKF-SLAM")
    ax.plot(*d.trees.T, **points(ESTIMATE, markersize=4), label="trees of the map")
    low_x, high_x = np.percentile(d.path, [0, 100], axis=0) + [[-45], [45]]
    ax.set(xlim=(low_x[0], high_x[0]), ylim=(low_x[1], high_x[1]))
    ax.set(xlabel="x, east (m)", ylabel="y, north (m)", aspect="equal", title=f"{which}: {d.t[-1]:.0f} s")
    ax.legend(loc="lower right", fontsize=11)
    inside = fixes[(fixes[:, 0] >= d.t[0]) & (fixes[:, 0] <= d.t[-1]), 0]
    low.plot(inside, far, **points(MEASUREMENT, markersize=4), label="distance to GPS")
    low.plot(d.t, 3 * d.std, color=BLACK, linestyle="--", label="3σ of the filter")
    low.set(yscale="log", ylim=(0.05, 200), xlabel="time (s)", ylabel="distance (m)")
    low.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)
    way = np.linalg.norm(np.diff(d.path, axis=0), axis=1).sum()
    return fig, (
        f"{which.capitalize()}: {way / 1000:.1f} km, {d.seen} detections, {100 * d.used / d.seen:.0f} % of them used, "
        f"{d.born} trees started, {d.n_trees[-1]} in the map at the end. Distance to GPS: median "
        f"{np.median(far):.2f} m, root mean square without the worst 5 % {error:.2f} m, largest {np.max(far):.0f} m."
    )


@explorable(
    percent=Int(50, 2, 100, 2, label="time", play=200, tip="Per cent of the log; arrow keys move it"),
    gps=Toggle(True, label="GPS"),
    ranges={"trees": (1, 600)},
)
def overlay(which, d, percent, gps):
    """The park from the first scan to the last: path and trees, with GPS over them."""
    t, pose, trees = d.views[max(len(d.views) * percent // 100 - 1, 0)]
    k = int(np.searchsorted(d.t, t, side="right"))
    fig, ax = plt.subplots(figsize=(9.6, 6.6))
    fixes = recording(which).fixes[1]
    if gps:
        ax.plot(*fixes[fixes[:, 0] <= t, 1:].T, **points(MEASUREMENT, markersize=4), label="GPS")
    ax.plot(*d.path[:k].T, **line(ESTIMATE), linewidth=1.3, label="EKF-SLAM")
    ax.plot(*trees.T, **points(ESTIMATE, markersize=4), label="trees")
    robot(ax, pose, size=8, edgecolor=BLACK)
    edge = np.percentile(d.path, [0, 100], axis=0) + [[-45], [45]]
    ax.set(xlim=edge[:, 0], ylim=edge[:, 1], aspect="equal", xlabel="x, east (m)", ylabel="y, north (m)")
    ax.set_title(f"{which}, {t:.0f} s")
    ax.legend(loc="upper left", fontsize=12)
    return fig, {"trees": len(trees), "caption": f"{which.capitalize()} after {t:.0f} s: {len(trees)} trees."}


def wrong_mount_figure(which, right, wrong, ahead):
    """The same minutes with the laser in its place and elsewhere. Returns (fig, caption)."""
    fig, axes = plt.subplots(1, 2, figsize=(12.5, 5.6), layout="constrained", sharex=True, sharey=True)
    fixes, words = recording(which).fixes[1], []
    for ax, d, name in (
        (axes[0], right, "laser in its place"),
        (axes[1], wrong, f"laser {ahead:g} m ahead of the axle"),
    ):
        error = from_gps(which, d)[1]
        ax.plot(*fixes[fixes[:, 0] <= d.t[-1], 1:].T, **points(MEASUREMENT, markersize=4), label="GPS")
        ax.plot(*d.path[:: max(len(d.path) // POINTS, 1)].T, **line(ESTIMATE), label="EKF-SLAM")
        ax.plot(*d.trees.T, **points(ESTIMATE, markersize=4), label="trees")
        ax.set(xlabel="x, east (m)", aspect="equal", title=f"{name}: {error:.1f} m")
        words.append(f"{name}: {d.n_trees[-1]} trees, distance to GPS {error:.1f} m")
    axes[0].set_ylabel("y, north (m)")
    axes[0].legend(loc="upper left", fontsize=11)
    return fig, f"{which.capitalize()}, {right.t[-1]:.0f} s. {'; '.join(words)}."
