"""Drawings of notebook 23: how an IMU drifts, a flight with its tubes, what becomes known when, honesty."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ...analysis import anees_band
from ...graphics import ESTIMATE, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, DEAD_RECKONING, GREEN, GREY, ORANGE, PURPLE, VERMILLION
from ..controls import Float
from ..widgets import explorable

CAUSES = {
    "bias of the gyrometer": (VERMILLION, "-", "o"),
    "bias of the accelerometer": (BLUE, "--", "s"),
    "noise of the gyrometer": (ORANGE, "-.", "^"),
    "noise of the accelerometer": (GREEN, ":", "D"),
}
AXES = "xyz"


# ---- an IMU alone ---------------------------------------------------------------------------------------------------


def drift_figure(t, off, slopes):
    """Position error over time for each cause, log-log, with the slopes that were fitted. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(9.5, 5.6), layout="constrained")
    for (name, e), slope in zip(off.items(), slopes, strict=True):
        color, dash, mark = CAUSES[name]
        look: dict[str, Any] = dict(color=color, linestyle=dash, marker=mark, markevery=0.12, markersize=7)
        ax.plot(t, e, **look, linewidth=2.4, label=f"{name}: slope {slope:.2f}")
    _time_axes(ax, t[0], t[-1])
    ax.set(ylabel="position error (m)", ylim=(1e-4, 2e3))
    ax.legend(loc="upper left")
    ends = "; ".join(
        f"{name} {_length(e[-1])}, slope {s:.2f}" for (name, e), s in zip(off.items(), slopes, strict=True)
    )
    return fig, f"Off after {t[-1]:.0f} s, and the slope on log-log axes: {ends}. Noise: the RMS of many runs."


@explorable(
    gyro_bias=Float(0.1, 0.0, 0.5, 0.01, "bias of the gyrometer", "deg/s"),
    acc_bias=Float(0.02, 0.0, 0.2, 0.005, "bias of the accelerometer", "m/s²"),
    gyro_noise=Float(0.3, 0.0, 3.0, 0.05, "noise of the gyrometer", "deg/√h"),
    acc_noise=Float(0.002, 0.0, 0.05, 0.001, "noise of the accelerometer", "m/s²/√Hz"),
    ranges={"off_10": (0, 100), "off_60": (0, 5000)},
)
def drifting(imu_step, drift, gyro_bias, acc_bias, gyro_noise, acc_noise):
    """Position error of an IMU that lies still and is not corrected, and the laws of its four causes."""
    numbers = np.radians(gyro_bias), acc_bias, np.radians(gyro_noise) / 60, acc_noise
    t, off = _lying(imu_step, *numbers)
    laws = np.array([np.asarray(drift(s, *numbers)) for s in t])
    fig, ax = plt.subplots(figsize=(9, 5), layout="constrained")
    for (name, (color, dash, _)), law in zip(CAUSES.items(), laws.T, strict=True):
        if law[-1] > 0:
            ax.plot(t, law, color=color, linestyle=dash, linewidth=2.2, label=f"law: {name}")
    ax.plot(t, np.maximum(off, 1e-9), color=BLACK, linewidth=3, alpha=0.6, label="one IMU, step by step")
    _time_axes(ax, t[0], t[-1])
    ax.set(ylabel="position error (m)", ylim=(1e-4, 3e3))
    ax.legend(loc="upper left")
    at = [int(np.argmin(np.abs(t - s))) for s in (10, 60)]
    worst = list(CAUSES)[int(np.argmax(laws[at[1]]))] if laws.any() else "nothing"
    return fig, {
        "off_10": off[at[0]],
        "off_60": off[at[1]],
        "caption": f"Off after 10 s by {_length(off[at[0]])}, after 60 s by {_length(off[at[1]])}; "
        f"most of it from the {worst}.",
    }


def _lying(imu_step, b_w, b_a, n_w, n_a, dt=0.25, seconds=60):
    """Run an IMU that lies still and does not know its biases. Returns times, and position errors along x."""
    rng, n = np.random.default_rng(23), round(seconds / dt)
    x = np.zeros(16)
    x[3] = 1.0
    u = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 9.81], (n, 1))
    u[:, 1] += b_w + n_w / np.sqrt(dt) * rng.standard_normal(n)
    u[:, 3] += b_a + n_a / np.sqrt(dt) * rng.standard_normal(n)
    off = []
    for each in u:
        x = np.array(imu_step(x, each, dt)[0])
        off.append(abs(x[0]))
    return dt * np.arange(1, n + 1), np.array(off)


def _time_axes(ax, low, high):
    ticks = [s for s in (0.1, 0.3, 1, 3, 10, 30, 60, 100) if low * 0.99 <= s <= high * 1.01]
    ax.set(xscale="log", yscale="log", xlabel="time without correction (s)", xlim=(low, high))
    ax.set_xticks(ticks, [f"{s:g}" for s in ticks])
    ax.minorticks_off()


def _length(m):
    """A length as one says it."""
    return f"{m:.0f} m" if m >= 10 else f"{m:.1f} m" if m >= 1 else f"{100 * m:.2g} cm"


# ---- a flight -------------------------------------------------------------------------------------------------------


def flight_figure(flight, alone):
    """The path from above beside the truth, and the errors within the 3-sigma tubes. Returns (fig, caption)."""
    fig, axes = plt.subplot_mosaic([["map", "x"], ["map", "y"], ["map", "z"]], figsize=(13, 6.6), layout="constrained")
    ax, t, p, true = axes["map"], flight.t, flight.x[:, :3], flight.true[:, :3]
    ax.plot(*true.T[:2], **line(TRUTH), label="true path")
    ax.plot(*p.T[:2], **line(ESTIMATE), label="estimated path, IMU and camera")
    lost = alone.x[:, :3]
    ax.plot(*lost.T[:2], **line(DEAD_RECKONING, linewidth=2.2), label="the IMU alone")
    every = slice(20, None, 20)
    plot_ellipse(ax, p[every, :2], flight.P[every, :2, :2], 3, **line(ESTIMATE, linewidth=1), label=sigma_label(3))
    ax.plot(*true[every, :2].T, **points(TRUTH, markersize=8), label="truth, each second")
    ax.plot(*p[0, :2], marker="P", color=GREY, markersize=11, linestyle="none", label="start")
    around = np.concatenate([true, p])[:, :2]
    low, high = around.min(0) - 0.9, around.max(0) + 0.9
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper left", fontsize=10)
    e, s = p - true, np.sqrt(np.einsum("kii->ki", flight.P[:, :3, :3]))
    for i, name in enumerate(AXES):
        _tube(axes[name], t, 100 * e[:, i], 300 * s[:, i], f"error in {name} (cm)")
    axes["x"].legend(loc="upper left", ncols=2, fontsize=10)
    axes["z"].set_xlabel("time (s)")
    inside = 100 * np.mean(np.abs(e[1:]) <= 3 * s[1:])
    rms, off = np.sqrt(np.mean(np.sum(e**2, 1))), np.linalg.norm(lost[-1] - alone.true[-1, :3])
    return fig, (
        f"{flight.name}, {t[-1]:.0f} s, {np.linalg.norm(np.diff(true, axis=0), axis=1).sum():.0f} m: with the camera "
        f"off by {100 * rms:.1f} cm rms, {inside:.0f} % of the errors inside their 3-sigma tube; the IMU alone is off "
        f"by {off:.1f} m at the end."
    )


def _tube(ax, t, e, three, label):
    ax.fill_between(t, -three, three, color=BLUE, alpha=0.22, linewidth=0, label="± 3 sigma")
    ax.plot(t, e, color=BLACK, linewidth=1.6, label="error: estimate minus truth")
    ax.set(ylabel=label, xlim=(t[0], t[-1]))


def biases_figure(flight, true, walks):
    """Errors of the biases with their 3-sigma bands; the true ones walk, too. Returns (fig, caption)."""
    fig, axes = plt.subplots(2, 3, figsize=(13, 5.6), sharex=True, sharey="row", layout="constrained")
    scale = np.repeat([np.degrees(1), 1.0], 3)
    t, e = flight.t, scale * (flight.x[:, 10:16] - true)
    three = 3 * scale * np.sqrt(np.einsum("kii->ki", flight.P[:, 10:16, 10:16]))
    for i, ax in enumerate(axes.ravel()):
        ax.fill_between(t, -three[:, i], three[:, i], color=BLUE, alpha=0.22, linewidth=0, label="± 3 sigma")
        ax.plot(t, e[:, i], color=BLACK, linewidth=1.8, label="error: estimate minus the true bias of the start")
        walked = 3 * walks[i // 3] * np.sqrt(t) * scale[i]
        ax.plot(t, walked, color=GREY, linestyle=":", linewidth=1.8, label="how far it may have walked (3 sigma)")
        ax.plot(t, -walked, color=GREY, linestyle=":", linewidth=1.8)
        ax.set(xlim=(t[0], t[-1]), title=f"along {AXES[i % 3]} of the IMU" if i < 3 else "")
    axes[0, 0].set(ylabel="gyrometer (deg/s)")
    axes[1, 0].set(ylabel="accelerometer (m/s²)")
    for ax in axes[1]:
        ax.set(xlabel="time (s)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=3)
    off, sigma = np.abs(e[-1]), three[-1] / 3
    return fig, (
        f"After {t[-1]:.0f} s the gyrometer's biases are off by {off[:3].max():.2g} deg/s at most (1 sigma up to "
        f"{sigma[:3].max():.2g}), the accelerometer's by {off[3:].max():.2g} m/s² (1 sigma up to "
        f"{sigma[3:].max():.2g}, and the true ones have walked by about {walks[1] * np.sqrt(t[-1]):.2g})."
    )


# ---- what becomes known when ----------------------------------------------------------------------------------------

FLIGHTS = {
    "it stands": (GREY, ":", "v"),  # wider: elsewhere another line lies on it
    "it moves, without a turn": (ORANGE, "--", "s"),
    "it turns, in place": (PURPLE, "-.", "^"),
    "it moves and turns": (BLUE, "-", "o"),
}
STATES = {
    "position (cm)": 100.0,
    "yaw (deg)": np.degrees(1),
    "tilt (deg)": np.degrees(1),
    "bias of the gyrometer (deg/s)": np.degrees(1),
    "bias of the accelerometer, up (m/s²)": 1.0,
    "bias of the accelerometer, level (m/s²)": 1.0,
}


def known_figure(t, sigmas):
    """Sigma over time of six things, for several flights, {flight: {state: (F,)}}. Returns (fig, caption)."""
    fig, axes = plt.subplots(2, 3, figsize=(13, 6.6), sharex=True, layout="constrained")
    for ax, (state, scale) in zip(axes.ravel(), STATES.items(), strict=True):
        name, _, unit = state.rpartition(" ")
        for flight, of in sigmas.items():
            color, dash, mark = FLIGHTS[flight]
            look = dict(
                color=color,
                linestyle=dash,
                marker=mark,
                markevery=0.15,
                markersize=6,
                linewidth=5 if dash == ":" else 2.2,
            )
            ax.plot(t[1:], scale * of[name][1:], **look, label=flight)
        ax.set(yscale="log", xlim=(0, t[-1]), title=name, ylabel=f"1 sigma {unit}")
        low, high = ax.get_ylim()
        ticks = [k * 10.0**e for e in range(-4, 3) for k in (1, 3) if low / 1.3 <= k * 10.0**e <= high * 1.3]
        ax.set_yticks(ticks, [f"{v:g}" for v in ticks])
        ax.minorticks_off()
    for ax in axes[1]:
        ax.set_xlabel("time (s)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=4)
    level, tilt = "bias of the accelerometer, level", "tilt"
    ends = "; ".join(
        f"{flight} {of[level][-1]:.3f} m/s² and {np.degrees(of[tilt][-1]):.2f} deg" for flight, of in sigmas.items()
    )
    return fig, f"1 sigma of the accelerometer's level bias and of the tilt after {t[-1]:.0f} s: {ends}."


# ---- honesty --------------------------------------------------------------------------------------------------------


def nees_figure(t, nees, dof):
    """Mean NEES over time of some flights, {name: (runs, F)}, and its band. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10.5, 5), layout="constrained")
    runs = len(next(iter(nees.values())))
    low, high = anees_band(dof, runs)
    ax.axhspan(low, high, color=GREEN, alpha=0.25, linewidth=0, label=f"honest, 95 %: {low:.1f} to {high:.1f}")
    looks = dict(zip(nees, ((BLUE, "-", "o"), (ORANGE, "--", "s"), (VERMILLION, "-.", "x")), strict=False))
    words = []
    for name, rows in nees.items():
        color, dash, mark = looks[name]
        mean = np.mean(rows, 0)
        ax.plot(t, mean, color=color, linestyle=dash, marker=mark, markevery=0.1, linewidth=2.2, label=name)
        words.append(f"{name} {rows.mean() / dof:.1f}")
    ax.set(yscale="log", xlabel="time (s)", ylabel=f"NEES, {dof} dof (-), mean of {runs} flights", xlim=(t[0], t[-1]))
    ticks = [1, 3, 6, 10, 30, 100]
    ax.set_yticks(ticks, [str(k) for k in ticks])
    ax.minorticks_off()
    ax.legend(loc="upper right")
    return fig, f"Mean NEES per degree of freedom, honest 1: {'; '.join(words)}."
