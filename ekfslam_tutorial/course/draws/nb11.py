"""Drawings of notebook 11: motion in space and its noise."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import md2
from ...geometry import Frame3
from ...graphics import ESTIMATE, MEASUREMENT, PREDICTED, covariance_panel, line, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from .nb11_runs import (
    START,
    STEP,
    STEPS,
    beliefs,
    euler_sigmas,
    flights,
    small,
    spread,
    std_of,
    twist_path,
)
from .space import Space

__all__ = ["START", "STEP", "euler_sigmas", "small", "std_of"]

ROBOT, WORLD = "the robot", "the world"
INSIDE = 97.1  # % of the probability in a 3-sigma ellipsoid


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def flight_figure(path, P=None):
    """A path in space, its frames, and the 3-sigma ellipsoids if there are covariances. Returns (fig, caption)."""
    path = np.asarray(path, float)
    fig, ax = plt.subplots(figsize=(10.5, 5.4), layout="constrained")
    t = path[:, :3]
    space = Space(ax, ((-7.5, 8.5), (-1.6, 8.4)), azim=-62, elev=28)
    space.ground(8)
    space.line(t, **line(ESTIMATE), label="path of the drone")
    for x in path[:: max(1, len(path) // 8)]:
        space.gizmo(Frame3(x), 0.5, linewidth=1.8)
    space.line(t * [1, 1, 0], color=GREY, linewidth=1, label="its shadow on the ground")
    length = np.linalg.norm(np.diff(t, axis=0), axis=1).sum()
    caption = f"{len(path) - 1} steps, {length:.1f} m; heights {t[:, 2].min():.1f} m to {t[:, 2].max():.1f} m."
    if P is not None:
        every = slice(5, None, 5)
        space.ellipsoid(t[every], np.asarray(P)[every, :3, :3], 3, **line(ESTIMATE, linewidth=1),
                        label=sigma_label(3, 3))  # fmt: skip
        S = np.sqrt(np.linalg.eigvalsh(np.asarray(P)[-1][:3, :3]))
        caption += f" At the end 1 sigma is {S[0]:.2f}, {S[1]:.2f} and {S[2]:.2f} m along the axes of the ellipsoid."
    ax.legend(loc="upper left", frameon=False)
    return fig, caption


def rank_figure(covariances):
    """Covariances of a body with constant velocity after some steps. `covariances`: {title: P}. Returns (fig, cap)."""
    sizes = {"t": 3, "q": 4, "v": 3, "w": 3}
    fig, axes = plt.subplots(1, len(covariances), figsize=(12, 4.8), layout="constrained")
    words = []
    for ax, (title, P) in zip(axes, covariances.items(), strict=True):
        covariance_panel(P, sizes, ax=ax, title=title)
        words.append(f"{title}: rank {rank(P)}")
    return fig, f"Correlations of the 13 states. {'; '.join(words)}, never 13."


def rank(P) -> int:
    """Rank of a covariance whose states have different units: of its correlations."""
    s = np.sqrt(np.maximum(np.diag(P), 1e-300))
    return int(np.linalg.matrix_rank(P / np.outer(s, s), tol=1e-9))


# ---- widgets --------------------------------------------------------------------------------------------------------


@explorable(
    v=Float(1.0, 0.0, 2.0, 0.1, "speed ahead", "m/s"),
    roll=Float(20.0, -90.0, 90.0, 10.0, "roll rate", "deg/s"),
    pitch=Float(0.0, -90.0, 90.0, 10.0, "pitch rate", "deg/s"),
    yaw=Float(60.0, -90.0, 90.0, 10.0, "yaw rate", "deg/s"),
    ranges={"radius": (0, 12), "advance": (0, 13)},
)
def twist(v, roll, pitch, yaw):
    """Constant speed and turn rates in the robot's own axes: six seconds of it."""
    w = np.radians([roll, pitch, yaw])
    frames = twist_path(v, w)
    t = np.array([F.t for F in frames])
    fig, ax = plt.subplots(figsize=(10.5, 5.6), layout="constrained")
    middle = (t.min(0) + t.max(0)) / 2
    half = max(1.6, 0.75 * np.ptp(t, axis=0).max())
    space = Space(ax, ((-1.75 * half, 1.75 * half), (-half, half)), azim=-60, elev=27)
    u, s = space.xy(middle)
    ax.set(xlim=(u - 1.75 * half, u + 1.75 * half), ylim=(s - half, s + half))
    space.ground(12, height=min(0.0, t[:, 2].min()))
    space.line(t, **line(ESTIMATE, linewidth=2.5), label="path")
    for F in frames[::10]:
        space.gizmo(F, 0.22 * half, linewidth=1.8)
    space.name(frames[0], "start", 13)
    rate = float(np.linalg.norm(w))
    if rate < 1e-9:
        radius, advance = 0.0, 6 * v
        words = f"No turn: a straight line of {advance:.1f} m."
    else:
        along = v * w[0] / rate  # the part of the speed along the axis of the turn
        radius, advance = float(np.sqrt(max(v**2 - along**2, 0)) / rate), abs(float(along * 6))
        words = (
            f"A screw line of radius {radius:.2f} m that advances {advance:.1f} m along its axis in 6 s, "
            f"{np.degrees(rate) * 6 / 360:.1f} turns."
        )
        axis = w / rate
        centre = np.cross(w, [v, 0, 0]) / rate**2
        reach = np.linspace(-half, max(half, along * 6 + half / 2), 2)
        space.line(centre + reach[:, None] * axis, color=BLACK, linestyle="-.", linewidth=1.2, label="axis of the turn")
    ax.legend(loc="upper left", frameon=False)
    caption = f"Speed {v:.1f} m/s, rates ({roll:.0f}, {pitch:.0f}, {yaw:.0f}) deg/s. {words}"
    return fig, {"radius": radius, "advance": advance, "caption": caption}


@explorable(
    step=Int(15, 1, STEPS, label="step", play=200),
    axes=Choice(WORLD, [ROBOT, WORLD], "the filter adds noise in the axes of"),
    turning=Toggle(False, "the turn is noisy, too"),
    ranges={"inside": (0, 100)},
)
def tube(fly, believe, step, axes, turning):
    """The tube of uncertainty round a flight, believe(...), and robots that really fly with noise in their own axes."""
    means, covs = beliefs(believe, turning, "robot" if axes == ROBOT else "world")
    real = flights(fly, turning)[step][:, :3]
    S = covs[step][:3, :3] + 1e-12 * np.eye(3)
    inside = float(100 * np.mean(md2(real - means[step][:3], S) < 9))
    fig, ax = plt.subplots(figsize=(10.5, 5.6), layout="constrained")
    space = Space(ax, ((-7.5, 8.5), (-1.8, 8.6)), azim=-62, elev=30)
    space.ground(9)
    space.line(means[:, :3], color=GREY, linewidth=1, linestyle="--")
    space.line(means[: step + 1, :3], **line(ESTIMATE, linewidth=2.2), label="mean")
    space.line(real, color=MEASUREMENT["color"], marker="+", markersize=5, linestyle="none",
               label=f"{len(real)} robots, noise in their axes")  # fmt: skip
    past = [k for k in range(5, step, 5)]
    if past:
        space.ellipsoid(means[past, :3], covs[past][:, :3, :3], 3, **line(PREDICTED, linewidth=0.8))
    space.ellipsoid(means[step][:3], S, 3, **line(ESTIMATE, linewidth=2), label=f"{sigma_label(3, 3)} of the filter")
    space.gizmo(Frame3(means[step]), 0.9, linewidth=2)
    ax.legend(loc="upper left", frameon=False)
    honest = abs(inside - INSIDE) < 3
    ax.set_title(f"{inside:.0f} % inside, honest is {INSIDE:.0f} %", loc="right", color=BLACK if honest else VERMILLION)
    caption = (
        f"Step {step}, noise of the filter in the axes of {axes}, turn {'noisy' if turning else 'exact'}: "
        f"{inside:.0f} % of the robots are inside the 3-sigma ellipsoid; honest is {INSIDE:.0f} %."
    )
    return fig, {"inside": inside, "caption": caption}


@explorable(
    pitch=Float(60.0, -90.0, 90.0, 2.0, "pitch", "deg"),
    roll=Float(0.0, -180.0, 180.0, 10.0, "roll", "deg"),
    sigma=Float(2.0, 0.5, 5.0, 0.5, "attitude, 1 sigma", "deg"),
    ranges={"worst": (0, 1e18)},
)
def gimbal(pitch, roll, sigma):
    """Three Euler angles turn about three axes. At a pitch of 90 degrees only two of them are left."""
    near = np.clip(pitch, -89.9, 89.9)  # at 90 degrees itself the derivative is infinite
    e = np.radians([roll, near, 0.0])
    yaw_axis, pitch_axis = np.array([0, 0, 1.0]), np.array([0, 1.0, 0])
    roll_axis = np.array([np.cos(e[1]), 0, -np.sin(e[1])])
    fig = plt.figure(figsize=(11.5, 5.0))
    space = Space(fig.add_axes((0.0, 0.0, 0.46, 0.94)), ((-1.75, 1.75), (-1.6, 1.6)), azim=-50, elev=22)
    looks = ((roll_axis, VERMILLION, "-", "roll"), (pitch_axis, GREEN, "--", "pitch"), (yaw_axis, BLUE, "-.", "yaw"))
    for axis, color, dash, name in looks:
        a = np.linspace(0, 2 * np.pi, 61)
        one = np.cross(axis, [0.3, 0.5, 0.8])
        one /= np.linalg.norm(one)
        ring = np.cos(a)[:, None] * one + np.sin(a)[:, None] * np.cross(axis, one)
        size = {"roll": 0.75, "pitch": 1.0, "yaw": 1.25}[name]
        space.line(size * ring, color=color, linestyle=dash, linewidth=1.8)
        space.line([-1.4 * axis, 1.4 * axis], color=color, linestyle=dash, linewidth=3, label=f"axis of {name}")
        space.text(1.4 * axis, name, color=color)
    space.ax.legend(loc="upper left", frameon=False)
    between = float(np.degrees(np.arccos(np.clip(abs(roll_axis @ yaw_axis), 0, 1))))

    ax = fig.add_axes((0.55, 0.14, 0.43, 0.8))
    p = np.concatenate([[-89.9, -89.5], np.arange(-89, 90, 3.0)[1:], [89.5, 89.9]])
    curves = np.array([euler_sigmas(roll, v, sigma) for v in p])
    for column, (_, color, dash, name) in zip(curves.T, looks, strict=True):
        ax.semilogy(p, column, color=color, linestyle=dash, label=f"sigma of {name}")
    here = euler_sigmas(roll, near, sigma)
    ax.semilogy(np.full(3, near), here, **points(ESTIMATE, markersize=9))
    ax.axhline(sigma, color=BLACK, linewidth=1, linestyle=":", label="sigma of the rotation vector")
    ax.set(xlabel="pitch (deg)", ylabel="1 sigma (deg)", xlim=(-92, 92), ylim=(0.3, 3000), xticks=range(-90, 91, 30))
    ax.minorticks_off()
    ax.legend(loc="upper center", ncols=2, fontsize=11)
    worst = float(here.max())
    caption = (
        f"Roll {roll:.0f}, pitch {pitch:.0f} deg: the axes of roll and yaw are {between:.0f} deg apart. An "
        f"attitude known to {sigma:g} deg about each axis has a sigma of {here[0]:.2g} deg in roll, "
        f"{here[1]:.2g} in pitch and {here[2]:.2g} in yaw."
    )
    return fig, {"worst": worst, "caption": caption}


RATES = np.array([1, 2, 5, 10, 20, 50, 100, 200])
LAWS = {"1": ("the same in each step", VERMILLION, "--", "s"), "dt": ("times dt", BLUE, "-", "o"),
        "dt^2": ("times dt squared", ORANGE, ":", "D")}  # fmt: skip


@explorable(
    rate=Choice(10, {f"{r} Hz": int(r) for r in RATES[:-1]}, "rate of the filter"),
    law=Choice("1", {name: law for law, (name, *_) in LAWS.items()}, "variance of an impulse"),
    ranges={"ratio": (0.005, 15)},
)
def rates(rate, law):
    """The same ten seconds in more or fewer steps: how uncertain are velocity and position?"""
    fig, axes = plt.subplots(1, 2, figsize=(11.5, 4.8), layout="constrained")
    for i, (ax, what) in enumerate(zip(axes, ("velocity, 1 sigma (m/s)", "position, 1 sigma (m)"), strict=True)):
        for key, (name, color, dash, marker) in LAWS.items():
            values = [spread(int(r), key)[i] for r in RATES[:7]]
            ax.loglog(RATES[:7], values, color=color, linestyle=dash, marker=marker, markersize=5,
                      linewidth=3 if key == law else 1.3, label=name)  # fmt: skip
        ax.plot(rate, spread(rate, law)[i], marker="o", markersize=17, fillstyle="none", color=BLACK, markeredgewidth=2)
        ax.set(xlabel="steps per second", ylabel=f"{what} after 10 s", xticks=RATES[:7])
        ax.set_xticklabels([str(r) for r in RATES[:7]])
        ax.minorticks_off()
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False)
    v, s = spread(rate, law)
    ratio = v / spread(1, law)[0]
    caption = (
        f"Variance of an impulse {LAWS[law][0]}, {rate} Hz: after 10 s 1 sigma is {v:.2g} m/s and {s:.2g} m; "
        f"{ratio:.2g} times the velocity sigma of a filter of 1 Hz."
    )
    return fig, {"ratio": ratio, "caption": caption}
