"""Drawings of notebook 02: the lecture's log, mapped with known poses."""

from dataclasses import dataclass
from functools import cache

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...analysis.consistency import md2
from ...datasets import lecture
from ...ekf import Map
from ...geometry import Frame2
from ...graphics import DEAD_RECKONING, ESTIMATE, MEASUREMENT, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, VERMILLION, Style
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable

# The lecture's colours: true landmarks red, estimates black. They differ in shape and fill, too.
TRUE_STAR: Style = dict(
    linestyle="none", marker="*", markersize=12, color=VERMILLION, fillstyle="none", markeredgewidth=1.5
)
MAP_STAR: Style = dict(linestyle="none", marker=(6, 2, 0), markersize=7.5, color=BLACK, markeredgewidth=1.2)
KNOWN, UNCERTAIN = "known", "uncertain"


@dataclass(frozen=True)
class Step:
    """The filter after one time step: map, covariance, pose, and the range of each landmark by its id."""

    x: np.ndarray
    P: np.ndarray
    pose: np.ndarray
    ranges: dict


@cache
def run(pose=KNOWN):
    """The package's filter on the lecture's log: mapping (pose known) or SLAM (pose uncertain).

    Returns
    -------
    list of Step
        One for each of the 50 time steps.
    """
    log, opt = lecture.load_data(), Options(lmk_type=EucPnt(2))
    map, lmks, steps = Map(), {}, []
    rob = Rob(1, Odometry2(), U=np.diag(lecture.ODOMETRY_STD**2))
    sen = Sen(1, rob.id, lecture.SENSOR, Frame2, x=np.zeros(3))
    place(map, rob, lecture.get_pose(1), None if pose == KNOWN else np.zeros((3, 3)))
    for k in range(1, lecture.n_steps() + 1):
        if pose == KNOWN:
            rob.x = lecture.get_pose(k)
        elif k > 1:
            rob.u = lecture.odometry(k)
            move(map, rob, 1.0)
        raw = log.raw[lecture.SENSOR_ID][k - 1]
        _, new = correct_known_lmks(map, rob, sen, lmks, {}, raw, opt)
        init_new_lmks(map, rob, sen, lmks, raw, new, opt)
        ranges = {id: lmk.r for id, lmk in lmks.items()}
        steps.append(Step(map.x.copy(), map.P.copy(), rob.state(map).copy(), ranges))
    return steps


def cloud(k):
    """The slide's star cloud: every measurement of the steps 1 to k put into the map, no filter. (points, ids)"""
    ks = range(1, k + 1)
    l = [lecture.initL(z, lecture.get_pose(j)) for j in ks for z in lecture.sense(j)]
    return np.array(l), np.concatenate([lecture.seen(j) for j in ks])


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
    ax.plot(*lecture.true_landmarks()[1].T, **TRUE_STAR, label="landmarks (known here)")
    ax.plot(*real[:, :2].T, color=BLACK, linestyle="--", label="true path")
    ax.plot(*dead.T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*poses[:, :2].T, **points(ESTIMATE), label="EKF localisation")
    _legend(ax)
    off = lambda p: np.hypot(*(p[:, :2] - real[:, :2]).T)
    return fig, (
        f"Localisation with a known map. After 50 steps the odometry alone is {off(dead)[-1]:.2f} m off; "
        f"the EKF is never more than {off(poses).max():.2f} m off."
    )


def cloud_figure(k=50):
    """The unfiltered star cloud of the slide. Returns (fig, caption)."""
    fig, ax = _map_axes()
    l, ids = _cloud(ax, k)
    ax.plot(*lecture.true_landmarks()[1].T, **TRUE_STAR, label="true landmarks")
    _robot(ax, k)
    _legend(ax)
    errors = np.hypot(*(l - [truth()[i] for i in ids]).T)
    return fig, (
        f"No filtering: {len(l)} measurements give {len(l)} stars for {len(set(ids))} landmarks. "
        f"The worst star is {errors.max():.2f} m off, the median star {np.median(errors):.2f} m."
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
    x, P, ids = np.asarray(x, float), np.asarray(P, float), [int(i) for i in ids]
    l = x.reshape(-1, 2)
    B = np.array([P[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(len(ids))])
    fig, ax = _map_axes()
    _landmarks(ax, l, B)
    _robot(ax, k)
    _legend(ax)
    return fig, _verdict(l, B, ids)


def heat_figure(x, P, ids):
    """The covariance as a picture, one 2 x 2 block per pair of landmarks. Returns (fig, caption)."""
    P = np.asarray(P, float)
    fig, ax = _square()
    _heat(ax, P, [str(i) for i in ids])
    return fig, _heat_caption(P, len(ids))


# ---- widgets ----------------------------------------------------------------------------------------------


@explorable(
    k=Int(12, 1, 50, label="time step k", play=400, tip="Arrow keys move step by step"),
    show_cloud=Toggle(True, label="star cloud (no filter)"),
    show_map=Toggle(True, label="EKF map, 3-sigma ellipses"),
    ranges={"landmarks": (5, 16), "inside": (0, 16), "radius_m": (0.05, 1.5)},
)
def scrubber(k, show_cloud, show_map):
    """The 50 steps one by one: what was measured, and what the filter makes of it."""
    now, pose = run()[k - 1], lecture.get_pose(k)
    l, B, ids = _estimates(now)
    fig, ax = _map_axes()
    if show_cloud:
        _cloud(ax, k)
    if show_map:
        _landmarks(ax, l, B)
    else:
        ax.plot(*lecture.true_landmarks()[1].T, **TRUE_STAR, label="true landmarks")
    for z in lecture.sense(k):
        ax.plot(*zip(pose[:2], lecture.initL(z, pose), strict=True), **line(MEASUREMENT), linewidth=1)
    _robot(ax, k)
    _legend(ax)
    errors, inside = _errors(l, B, ids)
    radius = _radius(B).mean()
    caption = (
        f"Step {k}: {len(lecture.sense(k))} landmarks in view, {len(ids)} in the map. {inside} of {len(ids)} true ones "
        f"lie inside their 3-sigma ellipse; mean ellipse radius {radius:.2f} m, worst error {errors.max():.2f} m."
    )
    return fig, {"landmarks": len(ids), "inside": inside, "radius_m": radius, "caption": caption}


@explorable(
    k=Int(15, 1, 50, label="time step k", play=500),
    pose=Choice(
        KNOWN,
        {"known exactly (this lecture)": KNOWN, "uncertain (next lecture: SLAM)": UNCERTAIN},
        label="pose of the robot",
    ),
    ranges={"off_diagonal": (0, 0.3)},
)
def heat_map(k, pose):
    """The covariance of the map, growing and shrinking, with known poses and without."""
    now = run(pose)[k - 1]
    names = [str(i) for i in now.ranges]
    sizes = [2] * len(names)
    if pose == UNCERTAIN:
        names, sizes = ["robot", *names], [3, *sizes]
    fig, ax = _square()
    _heat(ax, now.P, names, sizes)
    ax.set_title(f"step {k}")
    return fig, {
        "off_diagonal": _off_diagonal(now.P, sizes),
        "caption": f"Step {k}, pose {pose}. " + _heat_caption(now.P, len(now.ranges), sizes),
    }


@explorable(
    range_m=Float(4.0, 0.5, 20.0, 0.5, "range", "m"),
    range_std=Float(0.2, 0.02, 1.0, 0.02, "std of the range", "m"),
    bearing_std=Float(4.0, 0.5, 40.0, 0.5, "std of the bearing", "deg"),
    ranges={"inside_percent": (0, 100), "bias_m": (0, 20)},
)
def banana(range_m, range_std, bearing_std):
    """Where a landmark may be, given one measurement: samples through q, and the ellipse L_y R L_y'."""
    std = np.array([range_std, np.radians(bearing_std)])
    noise = np.random.default_rng(2).standard_normal((1500, 2)) * std
    r, b = (np.array([range_m, 0.6]) + noise).T
    cloud = np.stack([r * np.cos(b), r * np.sin(b)], -1)
    c, s = np.cos(0.6), np.sin(0.6)
    l, L_y = range_m * np.array([c, s]), np.array([[c, -range_m * s], [s, range_m * c]])
    P = L_y @ np.diag(std**2) @ L_y.T

    fig, ax = plt.subplots(figsize=(6.6, 5.0), layout="constrained")
    ax.plot(*cloud.T, ".", color=MEASUREMENT["color"], markersize=2.5, label="1500 samples of q(y)")
    plot_ellipse(ax, l, P, k=3, color=BLACK, label=sigma_label(3))
    ax.plot(*l, **MAP_STAR, label="l = q(y)")
    ax.plot(*cloud.mean(0), "s", color=VERMILLION, fillstyle="none", markersize=9, label="mean of the samples")
    ax.plot(0, 0, "k>", markersize=10, label="robot")
    ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.set_adjustable("datalim")
    ax.legend(loc="upper left", fontsize=10)
    inside = 100 * float(np.mean(md2(cloud - l, P) < 9))
    bias = float(np.hypot(*(cloud.mean(0) - l)))
    caption = (
        f"{inside:.1f} % of the samples lie inside the 3-sigma ellipse; a true Gaussian has 98.9 %. "
        f"The mean of the samples is {bias:.2f} m away from l."
    )
    return fig, {"inside_percent": inside, "bias_m": bias, "caption": caption}


# ---- parts ------------------------------------------------------------------------------------------------


def _map_axes() -> tuple[Figure, Axes]:
    fig = plt.figure(figsize=(9.2, 6.2))
    ax = fig.add_axes((0.08, 0.1, 0.6, 0.87))  # the legend has its place on the right
    ax.set(xlim=(-7.5, 7.5), ylim=(-6.6, 7.4), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.grid(True, linewidth=0.5, alpha=0.5)
    return fig, ax


def _square():
    fig = plt.figure(figsize=(7.0, 5.6))
    return fig, fig.add_axes((0.1, 0.13, 0.72, 0.8))


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0, fontsize=12, frameon=False)


def _robot(ax, k):
    path = np.array([lecture.get_pose(j) for j in range(1, k + 1)])
    ax.plot(*path[:, :2].T, color=BLACK, linestyle="--", linewidth=1, label="path of the robot")
    body = np.array([[0.5, 0], [-0.35, 0.28], [-0.35, -0.28], [0.5, 0]])
    ax.fill(*Frame2(path[-1]).from_frame(body)[0].T, facecolor="white", edgecolor=BLACK, zorder=3)


def _cloud(ax, k):
    l, ids = cloud(k)
    ax.plot(*l.T, **points(MEASUREMENT, markersize=6, markeredgewidth=1), label="one per measurement")
    return l, ids


def _landmarks(ax, l, B):
    plot_ellipse(ax, l, B, k=3, color=BLACK, linewidth=1.2, label=sigma_label(3))
    ax.plot(*lecture.true_landmarks()[1].T, **TRUE_STAR, label="true landmarks")
    ax.plot(*l.T, **MAP_STAR, label="estimates")


def _estimates(step):
    """Means, 2 x 2 covariances and ids of the landmarks of a `Step`."""
    l = np.array([step.x[r] for r in step.ranges.values()])
    B = np.array([step.P[r, r] for r in step.ranges.values()])
    return l, B, list(step.ranges)


def _errors(l, B, ids):
    """Distance of each estimate from the truth, and how many truths lie inside their ellipse."""
    e = l - np.array([truth()[i] for i in ids])
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


def _heat(ax, P, names, sizes=None):
    """Correlation is hard to see beside large variances: the colour is the signed square root, in metres or rad."""
    edges = np.cumsum([0, *(sizes or [2] * len(names))])
    S = np.sign(P) * np.sqrt(np.abs(P))
    top = max(np.abs(S).max(initial=0), 1e-3)
    image = ax.imshow(S, cmap="PuOr", vmin=-top, vmax=top, interpolation="none")
    for edge in edges[1:-1] - 0.5:
        ax.axhline(edge, color="0.75", linewidth=0.5)
        ax.axvline(edge, color="0.75", linewidth=0.5)
    middles = (edges[1:] + edges[:-1] - 1) / 2
    ax.set_xticks(middles, names, fontsize=10, rotation=90 if len(names) > 8 else 0)
    ax.set_yticks(middles, names, fontsize=10)
    ax.set(xlabel="landmark id", ylabel="landmark id")
    ax.grid(False)
    bar = ax.figure.add_axes((0.82, 0.18, 0.025, 0.7))
    ax.figure.colorbar(
        image, cax=bar, label="sign(P) sqrt|P|  [m; robot: m, rad]" if names[0] == "robot" else "sign(P) sqrt|P|  [m]"
    )


def _off_diagonal(P, sizes):
    """Largest entry outside the diagonal blocks."""
    edges = np.cumsum([0, *sizes])
    rest = P.copy()
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        rest[a:b, a:b] = 0
    return float(np.abs(rest).max(initial=0))


def _heat_caption(P, n, sizes=None):
    off = _off_diagonal(P, sizes or [2] * n)
    say = "exactly zero" if off == 0 else f"up to {off:.2g}"
    std = np.sqrt(np.median(np.diag(P)))
    return (
        f"P is {len(P)} x {len(P)} for {n} landmarks. Outside the diagonal blocks it is {say}; median std {std:.2f} m."
    )
