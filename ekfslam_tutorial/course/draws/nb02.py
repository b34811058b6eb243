"""Drawings of notebook 02: the lecture's log, mapped with known poses. What is drawn is computed in the notebook."""

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import md2
from ...datasets import lecture
from ...geometry import Frame2
from ...graphics import (
    DEAD_RECKONING,
    ESTIMATE,
    MEASUREMENT,
    TRUTH,
    UPDATED,
    covariance_panel,
    line,
    plot_ellipse,
    points,
    sigma_label,
)
from ...graphics.style import GREY
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from .parts import robot


def truth():
    """True landmarks by id."""
    return dict(zip(*lecture.true_landmarks(), strict=True))


# ---- figures of the notebook ------------------------------------------------------------------------------


def localisation_figure(poses):
    """The three pictures of the recap in one: truth, odometry alone, EKF localisation. Returns (fig, caption)."""
    real = np.array([lecture.get_pose(k) for k in range(1, lecture.n_steps() + 1)])
    odometry = [Frame2(real[0])]
    for k in range(2, lecture.n_steps() + 1):
        odometry.append(odometry[-1].compose(Frame2(lecture.odometry(k)))[0])
    dead = np.array([F.t for F in odometry])
    poses = np.asarray(poses)

    fig, ax = _map_axes()
    ax.plot(*lecture.true_landmarks()[1].T, **points(TRUTH), label="landmarks (known here)")
    ax.plot(*dead.T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*poses[:, :2].T, **points(ESTIMATE), label="EKF localisation")
    ax.plot(*real[:, :2].T, **line(TRUTH), label="true path")
    _legend(ax)
    off = lambda p: np.hypot(*(p[:, :2] - real[:, :2]).T)
    return fig, (
        f"Localisation with a known map. After 50 steps the odometry alone is {off(dead)[-1]:.2f} m off; "
        f"the EKF is never more than {off(poses).max():.2f} m off."
    )


def cloud_figure(stars, whose, k=50):
    """The unfiltered star cloud of the slide. Returns (fig, caption).

    Parameters
    ----------
    stars : array_like, shape (m, 2)
        A place for each measurement of the steps 1 to k.
    whose : sequence of int
        The landmark of each.
    """
    stars = np.asarray(stars, float)
    fig, ax = _map_axes()
    _cloud(ax, stars)
    ax.plot(*lecture.true_landmarks()[1].T, **points(TRUTH), label="true landmarks")
    _path(ax, k)
    _legend(ax)
    errors = np.hypot(*(stars - [truth()[int(i)] for i in whose]).T)
    return fig, (
        f"No filtering: {len(stars)} measurements give {len(stars)} places for {len(set(map(int, whose)))} landmarks. "
        f"The worst is {errors.max():.2f} m off, the median one {np.median(errors):.2f} m."
    )


def first_frame(x, P, ids, x_r):
    """The slide's first frame: all landmarks were seen once, from one pose. Map and covariance; returns (fig, caption).

    Parameters
    ----------
    x, P : array_like, shape (2n,) and (2n, 2n)
    ids : sequence of int
        Landmark ids in the order of x.
    x_r : array_like, shape (3,)
        The pose they were seen from.
    """
    x, P, x_r = (np.asarray(a, float) for a in (x, P, x_r))
    l, B = x.reshape(-1, 2), _blocks(P)
    fig, (ax, right) = plt.subplots(1, 2, figsize=(12, 5.6), layout="constrained", width_ratios=(1.1, 1))
    for p in l:
        ax.plot(*zip(x_r[:2], p, strict=True), **line(MEASUREMENT, linewidth=0.8, alpha=0.7))
    _landmarks(ax, l, B)
    robot(ax, x_r, TRUTH, 0.7)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, columnspacing=1.0)
    covariance_panel(P, {str(i): 2 for i in ids}, ax=right, title="correlations in P, by landmark")
    far = np.hypot(*(l - x_r[:2]).T)
    width = 3 * np.sqrt(np.linalg.eigvalsh(B))
    near, most = int(np.argmin(far)), int(np.argmax(far))
    errors, inside = _errors(l, B, ids)
    return fig, (
        f"All {len(l)} landmarks, seen once from one pose. Across the line of sight the 3-sigma ellipse is "
        f"{width[near].min():.2f} m wide (to each side) at {far[near]:.1f} m and {width[most].max():.2f} m at "
        f"{far[most]:.1f} m. {inside} of {len(l)} true ones lie inside. Between two landmarks P is "
        f"{_say(_off_diagonal(P, [2] * len(l)))}."
    )


def map_figure(x, P, ids, k=50):
    """The lecture's last figure: 3-sigma ellipses, true landmarks, estimates. Returns (fig, caption).

    Parameters
    ----------
    x, P : array_like, shape (2n,) and (2n, 2n)
    ids : sequence of int
        Landmark ids in the order of x.
    k : int
        The time step, for the path of the robot.
    """
    l, B = np.asarray(x, float).reshape(-1, 2), _blocks(np.asarray(P, float))
    fig, ax = _map_axes()
    _landmarks(ax, l, B)
    _path(ax, k)
    _legend(ax)
    return fig, _verdict(l, B, ids)


# ---- widgets ----------------------------------------------------------------------------------------------


@explorable(
    k=Int(12, 1, 50, label="time step k", play=400, tip="Arrow keys move step by step"),
    show_cloud=Toggle(True, label="star cloud (no filter)"),
    show_map=Toggle(True, label="EKF map, 3-sigma ellipses"),
    ranges={"landmarks": (5, 16), "inside": (0, 16), "radius_m": (0.05, 1.5)},
)
def scrubber(steps, k, show_cloud, show_map):
    """The 50 steps one by one: what was measured, and what the filter makes of it. `steps`: x, P, ids of each."""
    x, P, ids = steps[k - 1]
    l, B = np.reshape(x, (-1, 2)), _blocks(np.asarray(P, float))
    pose = lecture.get_pose(k)
    fig, ax = _map_axes()
    if show_cloud:
        _cloud(ax, np.array([lecture.initL(y, lecture.get_pose(j)) for j in range(1, k + 1) for y in lecture.sense(j)]))
    if show_map:
        _landmarks(ax, l, B)
    else:
        ax.plot(*lecture.true_landmarks()[1].T, **points(TRUTH), label="true landmarks")
    for y in lecture.sense(k):
        ax.plot(*zip(pose[:2], lecture.initL(y, pose), strict=True), **line(MEASUREMENT, linewidth=1))
    _path(ax, k)
    _legend(ax)
    errors, inside = _errors(l, B, ids)
    radius = _radius(B).mean()
    caption = (
        f"Step {k}: {len(lecture.sense(k))} landmarks in view, {len(ids)} in the map. {inside} of {len(ids)} true ones "
        f"lie inside their 3-sigma ellipse; mean ellipse radius {radius:.2f} m, worst error {errors.max():.2f} m."
    )
    return fig, {"landmarks": len(ids), "inside": inside, "radius_m": radius, "caption": caption}


KNOWN, UNCERTAIN = "known", "uncertain"


@explorable(
    k=Int(15, 1, 50, label="time step k", play=500),
    pose=Choice(
        KNOWN,
        {"known exactly (this lecture)": KNOWN, "uncertain (next lecture: SLAM)": UNCERTAIN},
        label="pose of the robot",
    ),
    ranges={"off_diagonal": (0, 0.3)},
)
def heat_map(known, uncertain, k, pose):
    """The covariance of the map, step by step. `known`, `uncertain`: P and landmark ids of each step of both runs."""
    P, ids = (known if pose == KNOWN else uncertain)[k - 1]
    sizes = {"robot": 3} if pose == UNCERTAIN else {}
    sizes |= {str(i): 2 for i in ids}
    fig, ax = plt.subplots(figsize=(7.2, 5.8), layout="constrained")
    covariance_panel(P, sizes, ax=ax, title=f"step {k}, pose {pose}")
    ax.set(xlabel="landmark id", ylabel="landmark id")
    off = _off_diagonal(P, list(sizes.values()))
    return fig, {
        "off_diagonal": off,
        "caption": f"Step {k}, pose {pose}. P is {len(P)} x {len(P)} for {len(ids)} landmarks. Outside the diagonal "
        f"blocks it is {_say(off)}; median std {np.sqrt(np.median(np.diag(P))):.2f} m.",
    }


@explorable(
    range_m=Float(4.0, 0.5, 20.0, 0.5, "range", "m"),
    range_std=Float(0.2, 0.02, 1.0, 0.02, "std of the range", "m"),
    bearing_std=Float(4.0, 0.5, 40.0, 0.5, "std of the bearing", "deg"),
    ranges={"inside_percent": (0, 100), "bias_m": (0, 20)},
)
def banana(born, range_m, range_std, bearing_std):
    """Where a landmark may be, given one measurement.

    `born(y, R)` of the notebook returns l, its covariance, and samples of the noise through q.
    """
    std = np.array([range_std, np.radians(bearing_std)])
    l, P, cloud = born(np.array([range_m, 0.6]), np.diag(std**2))
    fig, ax = plt.subplots(figsize=(8.4, 4.6), layout="constrained")
    ax.plot(*cloud.T, ".", color=GREY, markersize=2.5, label=f"{len(cloud)} samples of q(y)")
    plot_ellipse(ax, l, P, k=3, **line(ESTIMATE), label=sigma_label(3) + " of L_y R L_y'")
    ax.plot(*l, **points(ESTIMATE, markersize=8), label="l = q(y)")
    ax.plot(*cloud.mean(0), **points(UPDATED, markersize=7), label="mean of the samples")
    robot(ax, np.zeros(3), TRUTH, 0.3)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    inside = 100 * float(np.mean(md2(cloud - l, P) < 9))
    bias = float(np.hypot(*(cloud.mean(0) - l)))
    caption = (
        f"{inside:.1f} % of the samples lie inside the 3-sigma ellipse; a true Gaussian has 98.9 %. "
        f"The mean of the samples is {bias:.2f} m away from l."
    )
    return fig, {"inside_percent": inside, "bias_m": bias, "caption": caption}


# ---- parts ------------------------------------------------------------------------------------------------


def _map_axes():
    fig = plt.figure(figsize=(9.2, 6.2))
    ax = fig.add_axes((0.08, 0.1, 0.6, 0.87))  # the legend has its place on the right
    ax.set(xlim=(-7.5, 7.5), ylim=(-6.6, 7.4), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return fig, ax


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0, frameon=False)


def _path(ax, k):
    path = np.array([lecture.get_pose(j) for j in range(1, k + 1)])
    ax.plot(*path[:, :2].T, **line(TRUTH, linewidth=1.2), label="path of the robot (known)")
    robot(ax, path[-1], TRUTH, 0.5)


def _cloud(ax, stars):
    ax.plot(*stars.T, **points(MEASUREMENT, markersize=6, markeredgewidth=1), label="one per measurement")


def _landmarks(ax, l, B):
    plot_ellipse(ax, l, B, k=3, **line(ESTIMATE, linewidth=1.3), label=sigma_label(3))
    ax.plot(*l.T, **points(ESTIMATE, markersize=4), label="estimates")
    ax.plot(*lecture.true_landmarks()[1].T, **points(TRUTH, markersize=9, markeredgewidth=1.0), label="true landmarks")


def _blocks(P):
    """The 2 x 2 blocks on the diagonal."""
    return np.array([P[i : i + 2, i : i + 2] for i in range(0, len(P), 2)])


def _errors(l, B, ids):
    """Distance of each estimate from the truth, and how many truths lie inside their ellipse."""
    e = l - np.array([truth()[int(i)] for i in ids])
    return np.hypot(*e.T), int(np.sum(md2(e, B) < 9))


def _radius(B):
    """Radius of the circle that has the area of the 3-sigma ellipse."""
    return 3 * np.sqrt(np.sqrt(np.linalg.det(B)))


def _verdict(l, B, ids):
    errors, inside = _errors(l, B, ids)
    return (
        f"{len(ids)} landmarks mapped; {inside} true ones lie inside their 3-sigma ellipse. "
        f"Mean ellipse radius {_radius(B).mean():.2f} m, worst error {errors.max():.2f} m."
    )


def _off_diagonal(P, sizes):
    """Largest entry outside the diagonal blocks."""
    edges = np.cumsum([0, *sizes])
    rest = np.array(P, float)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        rest[a:b, a:b] = 0
    return float(np.abs(rest).max(initial=0))


def _say(off):
    return "exactly zero" if off == 0 else f"up to {off:.2g}"
