"""Drawings of notebook 01: a robot that drives among known landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

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

STEPS, DT = 80, 0.5  # 40 s
SEED = 3  # of motion and sensor
START = np.array([0.0, -3.8, 0.0])
START_P = np.diag([0.01, 0.01, 0.01]) ** 2  # nearly known: 1 cm, 0.6 deg
LANDMARKS = np.array(
    [[-5.0, -5.0], [0.0, -5.5], [5.0, -5.0], [5.5, 0.0], [5.0, 5.0], [0.5, 5.5], [-5.0, 5.0], [-5.5, 0.0], [0.5, 0.5]]
)
AT_ROBOT = Frame2(np.zeros(3))  # the sensor sits in the middle of the robot


@dataclass(frozen=True)
class Log:
    """What a robot did and saw: the truth, the controls it was given, and its measurements.

    Attributes
    ----------
    truth : ndarray, shape (STEPS + 1, 3)
        True poses; the first one is known to the filter.
    u, U : ndarray, shape (STEPS, 2) and (2, 2)
        Controls [v, w], and the covariance of their errors.
    seen, y : list of ndarray
        For each step the indices of the landmarks in view, (m,), and the measurements, (m, 2).
    sensor : RangeBearing
    """

    truth: np.ndarray
    u: np.ndarray
    U: np.ndarray
    seen: list
    y: list
    sensor: RangeBearing


@lru_cache(64)
def drive(range_std=0.15, bearing_std_deg=3.0, v_std=0.15, w_std_deg=6.0, fov_deg=360.0):
    """Drive once round the room. The random numbers are the same for all settings, so that settings compare fairly."""
    motion_rng, sensor_rng = (np.random.default_rng(s) for s in np.random.SeedSequence(SEED).spawn(2))
    u = np.tile([0.6, np.pi / 20], (STEPS, 1))
    u[:, 1] *= 1 - 0.6 * np.cos(8 * np.pi * np.arange(STEPS) / STEPS)
    std = np.array([v_std, np.radians(w_std_deg)])
    noise = motion_rng.standard_normal((STEPS, 2)) * std
    sensor = RangeBearing(range_std, np.radians(bearing_std_deg), max_range=6.0, fov=np.radians(fov_deg))
    errors = sensor_rng.standard_normal((STEPS, len(LANDMARKS), 2)) * [range_std, np.radians(bearing_std_deg)]

    truth, seen, ys = [START], [], []
    for k in range(STEPS):
        truth.append(move(truth[-1], u[k] + noise[k], DT)[0])
        p = Frame2(truth[-1]).to_frame(LANDMARKS)[0]
        e = sensor.project(p)[0]
        i = np.flatnonzero(sensor.visible(e, p))
        seen.append(i)
        ys.append(e[i] + errors[k, i])
    return Log(np.array(truth), u, np.diag(std**2), seen, ys, sensor)


def expected(sensor, x, p):
    """What the sensor should measure of a landmark at p, from the pose x: e, H."""
    e, H, *_ = observe(Frame2(x), AT_ROBOT, sensor, EucPnt(2), p)
    return e, H


@lru_cache(64)
def localise(*settings):
    """EKF localisation on `drive(*settings)`: poses (STEPS + 1, 3) and covariances (STEPS + 1, 3, 3)."""
    log = drive(*settings)
    x, P = START, START_P
    xs, Ps = [x], [P]
    for k in range(STEPS):
        x, F_x, F_u = move(x, log.u[k], DT)
        P = F_x @ P @ F_x.T + F_u @ log.U @ F_u.T
        for i, y in zip(log.seen[k], log.y[k], strict=True):
            e, H = expected(log.sensor, x, LANDMARKS[i])
            x, P = correct(x, P, innovation(y, e), H, log.sensor.R)
        xs.append(x)
        Ps.append(P)
    return np.array(xs), np.array(Ps)


def dead_reckoning(log):
    """Poses from the controls alone."""
    xs = [START]
    for u in log.u:
        xs.append(move(xs[-1], u, DT)[0])
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
    _room(ax)
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
    _room(ax)
    ax.plot(*real[: k + 1, :2].T, **line(TRUTH), label="true path")
    ax.plot(*dead[: k + 1, :2].T, **line(DEAD_RECKONING), label="odometry alone")
    ax.plot(*xs[: k + 1, :2].T, **line(ESTIMATE), label="EKF")
    if k:
        for i, y in zip(log.seen[k - 1], log.y[k - 1], strict=True):
            end = Frame2(xs[k]).from_frame(log.sensor.retro(y)[0])[0]
            ax.plot(*zip(xs[k, :2], end, strict=True), **line(MEASUREMENT), linewidth=1.2)
            ax.plot(*end, **points(MEASUREMENT), label="measurements" if i == log.seen[k - 1][0] else None)
    plot_ellipse(ax, xs[k, :2], Ps[k, :2, :2], k=3, color=BLACK, linewidth=1.6, label=sigma_label(3))
    robot(ax, real[k], TRUTH, 0.5)
    robot(ax, xs[k], ESTIMATE, 0.5)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False, fontsize=11, columnspacing=1.2)

    e = xs - real
    e[:, 2] = wrap(e[:, 2])
    s = np.sqrt(np.maximum(np.diagonal(Ps, axis1=1, axis2=2), 0))
    t = DT * np.arange(len(xs))
    for row, (j, unit, scale) in enumerate(((0, "x (m)", 1.0), (1, "y (m)", 1.0), (2, "heading (deg)", 180 / np.pi))):
        a = fig.add_axes((0.62, 0.67 - 0.285 * row, 0.36, 0.24))
        a.fill_between(t, -3 * scale * s[:, j], 3 * scale * s[:, j], color=GREY, alpha=0.3, linewidth=0, label="±3σ")
        a.plot(t, scale * e[:, j], **line(ESTIMATE), linewidth=1.3, label="error of the EKF")
        a.axvline(DT * k, color=BLACK, linewidth=1)
        a.set_ylabel(unit)
        a.tick_params(labelbottom=row == 2, labelsize=10)
        a.locator_params(nbins=4)
        if row == 0:
            a.legend(loc="lower center", bbox_to_anchor=(0.5, 0.93), ncols=2, frameon=False, fontsize=11)
    a.set_xlabel("time (s)")
    off = lambda x: float(np.hypot(*(x - real)[k, :2]))
    outside = 100 * float(np.mean(np.abs(e[1:]) > 3 * s[1:]))
    return fig, (
        f"After {DT * k:.0f} s the odometry alone is {off(dead):.2f} m off, the EKF {off(xs):.2f} m. "
        f"In the whole run {outside:.0f} % of the errors are outside their 3-sigma band."
    )


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    k=Int(66, 1, STEPS, label="time step k", play=500),
    range_std=Float(0.15, 0.05, 1.0, 0.05, "R: std of the range", "m"),
    bearing_std_deg=Float(3.0, 1.0, 20.0, 1.0, "R: std of the bearing", "deg"),
    v_std=Float(0.3, 0.05, 0.5, 0.05, "U: std of the speed", "m/s"),
    w_std_deg=Float(10.0, 1.0, 20.0, 1.0, "U: std of the turn rate", "deg/s"),
    fov_deg=Float(60.0, 20.0, 360.0, 20.0, "field of view", "deg"),
    ranges={"sigma_m": (0.01, 10), "in_view": (0, 9)},
)
def live(k, range_std, bearing_std_deg, v_std, w_std_deg, fov_deg):
    """A robot in a room with nine known landmarks."""
    settings = (range_std, bearing_std_deg, v_std, w_std_deg, fov_deg)
    log, (xs, Ps) = drive(*settings), localise(*settings)
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
    plot_ellipse(ax, x2[:2], P[:2, :2], k=3, color=BLACK, label=sigma_label(3) + " of F_x P F_x'")
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


WHITE, PER_STEP, STATE = "white", "per step", "state"


def after_arc(rule, n):
    """Mean and covariance after 10 s on an arc, in n steps, with one of three rules for the noise."""
    dt, x, P = 10 / n, np.zeros(3), np.zeros((3, 3))
    u, at_1s = np.array([0.5, 0.2]), np.diag([0.1**2, np.radians(4.0) ** 2])
    for _ in range(n):
        x, F_x, F_u = move(x, u, dt)
        if rule == STATE:
            Q = np.diag([0.1**2, 0.1**2, np.radians(4.0) ** 2])
        else:
            Q = F_u @ (at_1s / dt if rule == WHITE else at_1s) @ F_u.T
        P = F_x @ P @ F_x.T + Q
    return x, P


@explorable(
    rule=Choice(
        WHITE,
        {
            "U = S / dt, in the control": WHITE,
            "the same U for every dt": PER_STEP,
            "constant, added to the pose": STATE,
        },
        label="noise",
    ),
    n=Int(40, 10, 160, 10, label="steps in 10 s"),
    ranges={"ratio": (0.05, 6)},
)
def noise(rule, n):
    """The covariance after 10 s should not depend on how finely the time is cut."""
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


def _room(ax):
    ax.plot(*LANDMARKS.T, **points(TRUTH, markersize=12), label="landmarks (known)")
    ax.set(xlim=(-7.5, 7.5), ylim=(-8.5, 6.2), xticks=range(-6, 7, 3), yticks=range(-6, 7, 3))  # few ticks: quick
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1), borderaxespad=0, frameon=False, fontsize=12)
