"""Drawings of notebook 01: a robot that drives among known landmarks. The drive and its noise stand in the notebook."""

from __future__ import annotations

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import md2
from ...geometry import Frame2, wrap
from ...graphics import (
    DEAD_RECKONING,
    ESTIMATE,
    MEASUREMENT,
    PREDICTED,
    REJECTED,
    TRUTH,
    UPDATED,
    line,
    plot_ellipse,
    points,
    sigma_label,
)
from ...graphics.style import BLACK, GREY
from ...models import observe
from ...models.landmarks import EucPnt
from ...models.sensors import RangeBearing
from ..controls import Choice, Float, Int, Toggle
from ..exercises.nb01_correct import correct
from ..exercises.nb01_innovation import innovation
from ..exercises.nb01_move import move
from ..widgets import explorable
from .parts import robot

AT_ROBOT = Frame2(np.zeros(3))  # the sensor sits in the middle of the robot


@dataclass(frozen=True)
class Log:
    """What a robot did and saw: the truth, the controls it was given, and its measurements.

    Attributes
    ----------
    landmarks : ndarray, shape (N, 2)
    truth : ndarray, shape (T + 1, 3)
        True poses; the first one is known to the filter, with covariance `start_P`.
    start_P : ndarray, shape (3, 3)
    dt : float
    u, U : ndarray, shape (T, 2) and (2, 2)
        Controls [v, w], and the covariance of their errors.
    seen, y : list of ndarray
        For each step the indices of the landmarks in view, (m,), and the measurements, (m, 2).
    sensor : RangeBearing
    """

    landmarks: np.ndarray
    truth: np.ndarray
    start_P: np.ndarray
    dt: float
    u: np.ndarray
    U: np.ndarray
    seen: list
    y: list
    sensor: RangeBearing


def expected(sensor, x, p):
    """What the sensor should measure of a landmark at p, from the pose x: e, H."""
    e, H, *_ = observe(Frame2(x), AT_ROBOT, sensor, EucPnt(2), p)
    return e, H


def localise(log):
    """EKF localisation as the reader will write it: poses (T + 1, 3) and covariances (T + 1, 3, 3)."""
    x, P = log.truth[0], log.start_P
    xs, Ps = [x], [P]
    for u, seen, ys in zip(log.u, log.seen, log.y, strict=True):
        x, F_x, F_u = move(x, u, log.dt)
        P = F_x @ P @ F_x.T + F_u @ log.U @ F_u.T
        for i, y in zip(seen, ys, strict=True):
            e, H = expected(log.sensor, x, log.landmarks[i])
            x, P = correct(x, P, innovation(y, e), H, log.sensor.R)
        xs.append(x)
        Ps.append(P)
    return np.array(xs), np.array(Ps)


def dead_reckoning(log):
    """Poses from the controls alone."""
    xs = [log.truth[0]]
    for u in log.u:
        xs.append(move(xs[-1], u, log.dt)[0])
    return np.array(xs)


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def path_figure(log, xs, Ps):
    """The run: truth, odometry alone, EKF localisation. Returns (fig, caption)."""
    return _run(log, np.asarray(xs, float), np.asarray(Ps, float), len(xs) - 1)


def lost_figure(log, good, bad):
    """The path with and without wrap. Returns (fig, caption)."""
    good, bad = np.asarray(good, float), np.asarray(bad, float)
    fig = plt.figure(figsize=(10.5, 5.4))
    ax = fig.add_axes((0.07, 0.12, 0.52, 0.86))
    _room(ax, log.landmarks)
    ax.plot(*log.truth[:, :2].T, **line(TRUTH), label="true path")
    ax.plot(*good[:, :2].T, **line(ESTIMATE), label="EKF, innovation wrapped")
    ax.plot(*bad[:, :2].T, color=REJECTED["color"], marker="x", markersize=5, label="EKF, not wrapped")
    _legend(ax)
    off = lambda xs: np.hypot(*(xs - log.truth)[:, :2].T)
    first = int(np.argmax(off(bad) > 1.0))
    when = f"the first time more than 1 m at step {first}" if off(bad).max() > 1 else "never more than 1 m"
    return fig, (
        f"Largest error of the position: {off(good).max():.2f} m with the wrap; without it "
        f"{off(bad).max():.1f} m, {when}."
    )


def _run(log, xs, Ps, k):
    real, dead = log.truth, dead_reckoning(log)
    fig = plt.figure(figsize=(11.5, 5.6))
    ax = fig.add_axes((0.06, 0.24, 0.46, 0.75))
    _room(ax, log.landmarks)
    ax.plot(*real[: k + 1, :2].T, **line(TRUTH), label="true path")
    ax.plot(*dead[: k + 1, :2].T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*xs[: k + 1, :2].T, **line(ESTIMATE), label="EKF")
    if k:
        for i, y in zip(log.seen[k - 1], log.y[k - 1], strict=True):
            end = Frame2(xs[k]).from_frame(log.sensor.retro(y)[0])[0]
            ax.plot(*zip(xs[k, :2], end, strict=True), **line(MEASUREMENT), linewidth=1.2)
            ax.plot(*end, **points(MEASUREMENT), label="measurements" if i == log.seen[k - 1][0] else None)
    plot_ellipse(ax, xs[k, :2], Ps[k, :2, :2], k=3, **line(ESTIMATE, linewidth=1.6), label=sigma_label(3))
    robot(ax, real[k], TRUTH, 0.5)
    robot(ax, xs[k], ESTIMATE, 0.5)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False, fontsize=11, columnspacing=1.2)

    e = xs - real
    e[:, 2] = wrap(e[:, 2])
    s = np.sqrt(np.maximum(np.diagonal(Ps, axis1=1, axis2=2), 0))
    t = log.dt * np.arange(len(xs))
    for row, (j, unit, scale) in enumerate(((0, "x (m)", 1.0), (1, "y (m)", 1.0), (2, "heading (deg)", 180 / np.pi))):
        a = fig.add_axes((0.62, 0.67 - 0.285 * row, 0.36, 0.24))
        a.fill_between(t, -3 * scale * s[:, j], 3 * scale * s[:, j], color=GREY, alpha=0.3, linewidth=0, label="±3σ")
        a.plot(t, scale * e[:, j], **line(ESTIMATE), linewidth=1.3, label="error of the EKF")
        a.axvline(log.dt * k, color=BLACK, linewidth=1)
        a.set_ylabel(unit)
        a.tick_params(labelbottom=row == 2, labelsize=10)
        a.locator_params(nbins=4)
        if row == 0:
            a.legend(loc="lower center", bbox_to_anchor=(0.5, 0.93), ncols=2, frameon=False, fontsize=11)
    a.set_xlabel("time (s)")
    off = lambda x: float(np.hypot(*(x - real)[k, :2]))
    outside = 100 * float(np.mean(np.abs(e[1:]) > 3 * s[1:]))
    return fig, (
        f"After {log.dt * k:.0f} s the odometry alone is {off(dead):.2f} m off, the EKF {off(xs):.2f} m. "
        f"In the whole run {outside:.0f} % of the errors are outside their 3-sigma band."
    )


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    k=Int(66, 1, 80, label="time step k", play=500),
    range_std=Float(0.15, 0.05, 1.0, 0.05, "R: std of the range", "m"),
    bearing_std_deg=Float(3.0, 1.0, 20.0, 1.0, "R: std of the bearing", "deg"),
    v_std=Float(0.3, 0.05, 0.5, 0.05, "U: std of the speed", "m/s"),
    w_std_deg=Float(10.0, 1.0, 20.0, 1.0, "U: std of the turn rate", "deg/s"),
    fov_deg=Float(60.0, 20.0, 360.0, 20.0, "field of view", "deg"),
    ranges={"sigma_m": (0.01, 10), "in_view": (0, 9)},
)
def live(drive, k, range_std, bearing_std_deg, v_std, w_std_deg, fov_deg):
    """A robot in a room with nine known landmarks. `drive` of the notebook makes its log."""
    log = drive(range_std, bearing_std_deg, v_std, w_std_deg, fov_deg)
    xs, Ps = localise(log)
    fig, caption = _run(log, xs, Ps, k)
    sigma = float(np.sqrt(np.trace(Ps[k, :2, :2]) / 2))
    facts = f" Landmarks in view: {len(log.seen[k - 1])}. Std of the position: {sigma:.2f} m."
    return fig, {"sigma_m": sigma, "in_view": len(log.seen[k - 1]), "caption": caption + facts}


@explorable(
    heading_std_deg=Float(20.0, 1.0, 60.0, 1.0, "std of the heading", "deg"),
    distance=Float(4.0, 0.0, 10.0, 0.5, "distance in one step", "m"),
    ranges={"inside_percent": (0, 100), "bias_m": (0, 10)},
)
def linearised(heading_std_deg, distance):
    """One long step from an uncertain heading: samples through f, and the ellipse of F_x P F_x'."""
    std = np.array([0.15, 0.15, np.radians(heading_std_deg)])
    start = np.random.default_rng(3).standard_normal((1500, 3)) * std
    x, y, theta = start.T
    end = np.stack([x + distance * np.cos(theta), y + distance * np.sin(theta)], -1)
    x2, F_x, _ = move(np.zeros(3), np.array([distance, 0.0]), 1.0)
    P = F_x @ np.diag(std**2) @ F_x.T

    fig = plt.figure(figsize=(10, 5.2))
    ax = fig.add_axes((0.08, 0.12, 0.52, 0.86))
    ax.plot(*end.T, ".", color=MEASUREMENT["color"], markersize=2.5, label=f"{len(end)} samples through f")
    plot_ellipse(ax, x2[:2], P[:2, :2], k=3, **line(PREDICTED), label=sigma_label(3) + " of F_x P F_x'")
    ax.plot(*x2[:2], **points(PREDICTED, markersize=9), label="f(mean)")
    ax.plot(*end.mean(0), **points(UPDATED, markersize=8), label="mean of the samples")
    robot(ax, np.zeros(3), size=0.5)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    _legend(ax)
    inside = 100 * float(np.mean(md2(end - x2[:2], P[:2, :2]) < 9))
    bias = float(np.hypot(*(end.mean(0) - x2[:2])))
    return fig, {
        "inside_percent": inside,
        "bias_m": bias,
        "caption": f"{inside:.1f} % of the samples lie inside the 3-sigma ellipse; a true Gaussian has 98.9 %. "
        f"The mean of the samples is {bias:.2f} m away from f(mean).",
    }


@explorable(
    bearing_deg=Float(179.0, 150.0, 210.0, 1.0, "true bearing of the landmark", "deg"),
    wrapped=Toggle(False, label="wrap the innovation"),
    ranges={"moved_m": (0, 30), "z_deg": (-360, 360)},
)
def seam(bearing_deg, wrapped):
    """A landmark behind the robot: the measured bearing is 2 degrees more than the expected one."""
    sensor = RangeBearing(0.1, np.radians(3.0))
    x, P = np.zeros(3), np.diag([0.2**2, 0.2**2, np.radians(6.0) ** 2])
    a = np.radians(bearing_deg)
    p = 3 * np.array([np.cos(a), np.sin(a)])
    e, H = expected(sensor, x, p)
    y = np.array([3.0, wrap(a + np.radians(2.0))])
    z = innovation(y, e) if wrapped else y - e
    x2, _ = correct(x, P, z, H, sensor.R)

    fig = plt.figure(figsize=(10, 4.6))
    ax = fig.add_axes((0.08, 0.14, 0.56, 0.84))
    robot(ax, x, TRUTH, 0.6)
    robot(ax, x2, UPDATED if wrapped else REJECTED, 0.6, facecolor=UPDATED["color"] if wrapped else REJECTED["color"])
    ax.plot(*p, **points(TRUTH, markersize=14), label="landmark (known)")
    ax.plot(*zip(x[:2], p, strict=True), **line(MEASUREMENT), label="true line of sight")
    ax.plot([], [], color=BLACK, marker=">", linestyle="none", fillstyle="none", markersize=11, label="robot before")
    colour = UPDATED["color"] if wrapped else REJECTED["color"]
    ax.plot([], [], color=colour, marker=">", linestyle="none", markersize=11, label="robot after")
    ax.set(xlim=(-6, 6), ylim=(-6, 4), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    _legend(ax)
    moved, turned = float(np.hypot(*x2[:2])), float(np.degrees(x2[2]))
    return fig, {
        "moved_m": moved,
        "z_deg": float(np.degrees(z[1])),
        "caption": f"Measured {np.degrees(y[1]):.0f} deg, expected {np.degrees(e[1]):.0f} deg: innovation "
        f"{np.degrees(z[1]):.0f} deg. The correction moves the robot by {moved:.2f} m and turns it by "
        f"{turned:.0f} deg.",
    }


@explorable(
    y=Float(2.0, -4.0, 4.0, 0.2, "measured: y", "m"),
    prior_std=Float(1.0, 0.2, 2.0, 0.1, "prior: root of P", "m"),
    noise_std=Float(0.5, 0.2, 2.0, 0.1, "sensor: root of R", "m"),
    ranges={"K": (0, 1), "mean_m": (-4, 4), "sigma_m": (0.1, 2)},
)
def product(multiplied, y, prior_std, noise_std):
    """Prior times likelihood for one number, and the variance of any other mixture of the two.

    `multiplied(x, P, y, R)` of the notebook returns a grid and the three densities on it.
    """
    P, R = prior_std**2, noise_std**2
    grid, *bells = multiplied(0.0, P, y, R)
    step = grid[1] - grid[0]
    mean = float((grid * bells[2]).sum() * step)
    sigma = float(np.sqrt(((grid - mean) ** 2 * bells[2]).sum() * step))
    K = P / (P + R)

    fig = plt.figure(figsize=(12, 5.2))
    ax, right = fig.add_axes((0.06, 0.13, 0.52, 0.65)), fig.add_axes((0.66, 0.13, 0.33, 0.65))
    names = "prior: where the robot should be", "likelihood: what the sensor says", "their product"
    for bell, style, name in zip(bells, (PREDICTED, MEASUREMENT, UPDATED), names, strict=True):
        ax.plot(grid, bell, **line(style, linewidth=2.4), label=name)
    ax.set(xlabel="x (m)", ylabel="density (1/m)", xlim=(-6, 6), ylim=(0, None))
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), frameon=False)

    w = np.linspace(0, 1, 101)
    right.plot(w, (1 - w) ** 2 * P + w**2 * R, color=GREY, linewidth=2.4)
    right.plot(0, P, **points(PREDICTED, markersize=9), label="w = 0: prior only")
    right.plot(1, R, **points(MEASUREMENT, markersize=13, markeredgewidth=2.5), label="w = 1: sensor only")
    right.plot(K, (1 - K) * P, **points(UPDATED, markersize=9), label=f"w = K = {K:.2f}")
    right.set(xlabel="weight w of the measurement (-)", ylabel="variance of the mixture (m²)", ylim=(0, None))
    right.legend(loc="lower left", bbox_to_anchor=(0, 1), frameon=False)
    caption = (
        f"Prior 0 m ± {prior_std:.1f} m, measured {y:.1f} m ± {noise_std:.1f} m (1 sigma). The product has its mean at "
        f"{mean:.2f} m and sigma {sigma:.2f} m. The gain P / (P + R) is {K:.2f}: K y = {K * y:.2f} m."
    )
    return fig, {"K": K, "mean_m": mean, "sigma_m": sigma, "caption": caption.replace("-0.00", "0.00")}


WHITE, PER_STEP, STATE = "white", "per step", "state"


@explorable(
    rule=Choice(
        PER_STEP,
        {
            "U = S / dt, in the control": WHITE,
            "the same U for every dt": PER_STEP,
            "constant, added to the pose": STATE,
        },
        label="noise",
    ),
    n=Int(160, 10, 160, 10, label="steps in 10 s"),
    ranges={"ratio": (0.05, 6)},
)
def noise(after_arc, rule, n):
    """The covariance after 10 s should not depend on how finely the time is cut.

    `after_arc(rule, n)` of the notebook gives mean and covariance after n steps.
    """
    fig = plt.figure(figsize=(10, 4.8))
    ax = fig.add_axes((0.08, 0.13, 0.5, 0.85))
    areas = []
    for steps, style in ((20, PREDICTED), (n, ESTIMATE)):
        x, P = after_arc(rule, steps)
        plot_ellipse(ax, x[:2], P[:2, :2], k=3, **line(style), label=f"{steps} steps: {sigma_label(3)}")
        ax.plot(*x[:2], **points(style))
        areas.append(np.sqrt(np.linalg.det(P[:2, :2])))
    t = np.linspace(0, 10, 60)
    path = 2.5 * np.stack([np.sin(0.2 * t), 1 - np.cos(0.2 * t)], -1)
    ax.plot(*path.T, color=GREY, linestyle="-.", label="path")
    robot(ax, np.zeros(3), size=0.3)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    _legend(ax)
    ratio = float(np.sqrt(areas[1] / areas[0]))
    return fig, {
        "ratio": ratio,
        "caption": f"With {n} steps instead of 20 the ellipse is {ratio:.2f} times as wide (root of the areas).",
    }


# ---- parts ----------------------------------------------------------------------------------------------------------


def _room(ax, landmarks):
    ax.plot(*landmarks.T, **points(TRUTH, markersize=12), label="landmarks (known)")
    ax.set(xlim=(-7.5, 7.5), ylim=(-8.5, 6.2), xticks=range(-6, 7, 3), yticks=range(-6, 7, 3))  # few ticks: quick
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1), borderaxespad=0, frameon=False, fontsize=12)
