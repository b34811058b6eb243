"""Drawings of notebook 09: a real log, what is wrong with it, and what EKF-SLAM makes of it."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ...analysis import align
from ...geometry import Frame2
from ...graphics import DEAD_RECKONING, ESTIMATE, REJECTED, TRUTH, UPDATED, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREY, ORANGE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from . import nb09_runs as runs
from .nb09_runs import files
from .parts import robot, true_landmarks

ROBOTS = (1, 2, 3, 4, 5)


def troubles_figure(which):
    """What the files hold: sightings by subject, and the time from one command to the next. Returns (fig, caption)."""
    f = files(which)
    start, subject_of = f.start, {int(b): int(s) for s, b in f.barcodes}
    t = f.sightings[:, 0] - start
    ids = np.array([subject_of.get(int(b), -1) for b in f.sightings[:, 1]])
    fig, (top, low) = plt.subplots(2, 1, figsize=(10, 6.6), height_ratios=[2, 1], sharex=True, layout="constrained")
    met, lost = np.isin(ids, ROBOTS), ids < 0
    top.plot(t[~met & ~lost], ids[~met & ~lost], "|", color=BLUE, markersize=7, label="landmark")
    top.plot(t[met], ids[met], "x", color=ORANGE, markersize=5, label="other robot")
    top.plot(t[lost], np.zeros(lost.sum()), **points(REJECTED, marker="v"), label="barcode in no list")
    top.set(
        ylabel="subject seen", yticks=[0, 5, 10, 15, 20], ylim=(-1.5, 21), title=f"{which} {f.name}, robot {f.robot}"
    )
    top.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    rows = f.odometry[np.argsort(f.odometry[:, 0], kind="stable")]
    dt = np.diff(rows[:, 0])
    low.plot(rows[1:, 0] - start, dt, ".", color=BLACK, markersize=3)
    low.axhline(0.5, color=VERMILLION, linestyle="--", linewidth=1.2, label="0.5 s: a gap")
    low.set(
        yscale="log", xlabel="time (s)", ylabel="step of the\nodometry (s)", ylim=(1e-3, 5), xlim=(-5, runs.SECONDS)
    )
    low.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    late = sum(int((np.diff(a[:, 0]) < 0).sum()) for a in (f.odometry, f.sightings))
    return fig, (
        f"{which.capitalize()} {f.name}, robot {f.robot}, {runs.SECONDS:.0f} s: {len(t)} sightings, {met.sum()} of "
        f"them of other robots and {lost.sum()} with a barcode in no list; rows out of order: {late}; step of the "
        f"odometry: typical {np.median(dt):.3f} s, longest {dt.max():.2f} s."
    )


def calibration_figure(which, scales, delays, errors):
    """How well scale and delay of the turns explain the bearings: errors (deg), scales by delays. (fig, caption)."""
    fig, ax = plt.subplots(figsize=(8, 4.8), layout="constrained")
    half = np.diff(delays)[0] / 2, np.diff(scales)[0] / 2
    extent = (delays[0] - half[0], delays[-1] + half[0], scales[0] - half[1], scales[-1] + half[1])
    image = ax.imshow(errors, origin="lower", extent=extent, aspect="auto", cmap="viridis_r")
    fig.colorbar(image, ax=ax, label="median error of the bearing (deg)")
    i, j = np.unravel_index(np.argmin(errors), np.shape(errors))
    ax.plot(delays[j], scales[i], "o", color="white", markeredgecolor=BLACK, markersize=11, label="smallest")
    ax.set(xlabel="delay of the commands (s)", ylabel="real / commanded turn", title=which)
    ax.grid(False)
    ax.legend(loc="upper right")
    return fig, (
        f"{which.capitalize()}: the bearings are explained best, {np.min(errors):.2f} degrees off in the median, by "
        f"turns of {scales[i]:.2f} times the command, {delays[j]:.2f} s late."
    )


class Drawn:
    """A run of the notebook, ready to be drawn: in the frame of its start, and the frame that lays it on the truth."""

    def __init__(self, which, run, dead):
        log = files(which)
        self.which, self.t, self.dead = which, np.array([s[0] for s in run]), dead
        self.states = run
        self.path = np.array([x[:3] for _, x, _, _ in run])
        self.truth = log.truth(self.t)
        _, x, _, ids = run[-1]
        l, real = x[3:].reshape(-1, 2), log.surveyed(ids)
        known = np.isfinite(real[:, 0])
        self.survey, self.F = log.log.points, align(l[known], real[known])
        self.map_error = _rms(self.F.from_frame(l[known])[0] - real[known])
        seen = np.isfinite(self.truth[:, 0])
        self.error = _rms(self.F.from_frame(self.path[seen, :2])[0] - self.truth[seen, :2])
        moved = align(dead[seen, :2], self.truth[seen, :2])
        self.dead_error = _rms(moved.from_frame(dead[seen, :2])[0] - self.truth[seen, :2])


def map_figure(which, run, dead):
    """Path and map after alignment, with dead reckoning. Returns (fig, caption).

    Parameters
    ----------
    which : str
        TWIN or REAL.
    run : list of tuple
        For each picture of the camera: time, x, P, and the landmarks in the order of the state.
    dead : ndarray, shape (n, 3)
        The poses by the commands alone, at the same times, from the same start.
    """
    d = Drawn(which, run, dead)
    fig, ax = _axes()
    _draw(ax, d, len(run) - 1, True, True)
    _legend(ax)
    ax.set_title(which)
    return fig, (
        f"{which.capitalize()} {files(which).name}, {len(run)} pictures, {len(run[-1][3])} landmarks. Laid on the "
        f"surveyed landmarks: path {d.error:.2f} m off, landmarks {d.map_error:.2f} m (root mean square). The commands "
        f"alone, laid on the true path as well as can be: {d.dead_error:.2f} m."
    )


@explorable(
    percent=Int(40, 1, 100, label="time", play=150, tip="Per cent of the log; arrow keys move it"),
    aligned=Toggle(True, label="aligned with the truth"),
    show_dead=Toggle(True, label="dead reckoning"),
    ranges={"landmarks": (1, 20)},
)
def scrubber(which, run, dead, percent, aligned, show_dead):
    """The log from beginning to end: path, map, and where the odometry alone would be."""
    d = Drawn(which, run, dead)
    k = max((len(run) - 1) * percent // 100, 1)
    fig, ax = _axes()
    n = _draw(ax, d, k, aligned, show_dead)
    _legend(ax)
    how = "aligned" if aligned else "in the frame of its start"
    ax.set_title(f"{which}, {d.t[k] - d.t[0]:.0f} s")
    return fig, {
        "landmarks": n,
        "caption": f"{which.capitalize()} after {d.t[k] - d.t[0]:.0f} s: {n} landmarks in the map, {how}.",
    }


def clock_figure(which, offsets, curves):
    """Mean NIS over the clock offset, `curves`: name -> mean NIS. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(8.6, 4.8), layout="constrained")
    looks: tuple[dict[str, Any], ...] = (
        dict(color=VERMILLION, marker="s"),
        dict(color=BLUE, marker="o"),
        dict(color=GREY, marker="v", linestyle="-."),
    )
    says = []
    for (name, nis), look in zip(curves.items(), looks, strict=False):
        best = int(np.argmin(nis))
        ax.plot(offsets, nis, markersize=8, **look, label=name)
        ax.plot(offsets[best], nis[best], "o", markersize=17, markerfacecolor="none", markeredgecolor=BLACK)
        says.append(f"{name}: smallest, {nis[best]:.2f}, at {offsets[best]:.1f} s; at most {np.max(nis):.1f}")
    ax.axhline(2, color=BLACK, linestyle=":", linewidth=1.2, label="honest: 2")
    ax.plot([], [], "o", markersize=13, markerfacecolor="none", markeredgecolor=BLACK, label="smallest")
    ax.set(xlabel="clock offset taken from the stamps (s)", ylabel="mean NIS", yscale="log", title=which)
    ticks = [t for t in (0.2, 0.5, 1, 1.5, 2, 3, 5, 10, 20, 50) if ax.get_ylim()[0] <= t <= ax.get_ylim()[1]]
    ax.set_yticks(ticks, [f"{t:g}" for t in ticks])
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    return fig, f"{which.capitalize()}, mean NIS. {'. '.join(says)}."


@explorable(
    offset=Float(0.0, -0.1, 0.6, 0.1, "clock offset", "s", "Subtracted from the stamps of the sightings"),
    factor=Choice(1.0, {"a quarter": 0.25, "as told": 1.0, "four times": 4.0}, label="variances R"),
    run=True,
    ranges={"nis": (0.05, 60)},
)
def clock_and_noise(innovations, offset, factor):
    """Two knobs, one number: the NIS has a minimum over the offset, but falls for ever with R.

    `innovations(offset, factor)` is a function of the notebook: z (m, 2) and Z (m, 2, 2).
    """
    z, Z = innovations(offset, factor)
    t, nis = np.arange(len(z)), float(np.mean(np.einsum("ki,ki->k", z, np.linalg.solve(Z, z[..., None])[..., 0])))
    fig, axes = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained")
    for ax, i, name, unit in zip(axes, (0, 1), ("range", "bearing"), ("m", "deg"), strict=True):
        scale = 1.0 if i == 0 else 180 / np.pi
        # one tick for each sighting, no line: neighbours are sightings of different landmarks
        sigma = 3 * np.sqrt(Z[:, i, i]) * scale
        ax.plot(t, sigma, "_", color=GREY, markersize=4, label="±3σ (99.7 %)")
        ax.plot(t, -sigma, "_", color=GREY, markersize=4)
        ax.plot(t, z[:, i] * scale, ".", color=BLUE, markersize=4, label="innovation")
        top = (2.0, 20.0)[i]
        ax.set(xlabel="sighting", ylabel=f"{name} ({unit})", ylim=(-top, top))
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, markerscale=2, frameon=False)
    fig.suptitle(f"mean NIS {nis:.2f}   (honest: 2)")
    caption = f"{runs.TWIN.capitalize()}, offset {offset:.1f} s, variances times {factor:g}: mean NIS {nis:.2f}."
    return fig, {"nis": nis, "caption": caption}


def noise_figure(which, factors, nis, nees):
    """Mean NIS and NEES over the factor of R. Returns (fig, caption)."""
    nis, nees = np.asarray(nis), np.asarray(nees)
    fig, ax = plt.subplots(figsize=(8.4, 4.8), layout="constrained")
    ax.plot(factors, nis / 2, **{**ESTIMATE, "markersize": 10}, label="mean NIS / 2")
    ax.plot(factors, nees / 3, **{**REJECTED, "linestyle": "--", "markersize": 10}, label="mean NEES / 3")
    ax.axhline(1.0, color=BLACK, linewidth=1, linestyle=":", label="honest: 1")
    ax.set(xscale="log", yscale="log", xlabel="variances R, relative to the tuned ones", ylabel="relative to the ideal")
    ax.set_xticks(factors, [f"{k:g}" for k in factors])
    ax.set_yticks([0.1, 0.3, 1, 3, 10], ["0.1", "0.3", "1", "3", "10"])
    ax.minorticks_off()
    ax.set_title(which)
    ax.legend(loc="best")
    nearest = int(np.argmin(abs(np.log(nis / 2))))
    return fig, (
        f"{which.capitalize()} {files(which).name}: with R times {factors[nearest]:g} the mean NIS is "
        f"{nis[nearest]:.1f}, near 2, and the mean NEES is {nees[nearest]:.1f}, honest is 3. With the tuned R they are "
        f"{nis[-1]:.2f} and {nees[-1]:.1f}."
    )


def alignment_figure(path, truth, aligned, error):
    """A path in its own frame, the truth, and the path after alignment. Returns (fig, caption)."""
    fig, ax = _axes()
    ax.plot(*path.T, **line(ESTIMATE, linestyle=":"), label="estimate, own frame")
    ax.plot(*aligned.T, **line(UPDATED), label="estimate, aligned")
    ax.plot(*truth.T, **line(TRUTH, linewidth=1.2), label="truth")
    for start, style, name in ((path[0], ESTIMATE, None), (aligned[0], UPDATED, None), (truth[0], TRUTH, "true start")):
        ax.plot(*start, **points(style, markersize=10), label=name)
    _legend(ax)
    before = np.sqrt(((path - truth) ** 2).sum(1).mean())
    return fig, f"Before alignment the path is {before:.1f} m off, after it {error:.2f} m (ATE, {len(path)} instants)."


# ---- parts --------------------------------------------------------------------------------------------------


def _rms(e):
    """Root of the mean squared length of errors (n, 2)."""
    return float(np.sqrt((e**2).sum(1).mean()))


def _axes():
    fig = plt.figure(figsize=(9.6, 6.6))
    ax = fig.add_axes((0.08, 0.1, 0.6, 0.83))
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    return fig, ax


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0, fontsize=12, frameon=False)


def _draw(ax, d, k, aligned, dead):
    """Picture k of a run, laid on the truth or in the frame of its start. Returns the number of landmarks."""
    F = d.F if aligned else Frame2(np.zeros(3))
    moved = lambda p: F.from_frame(p[: k + 1, :2])[0].T
    if aligned:
        true_landmarks(ax, d.survey)
        ax.plot(*d.truth[: k + 1, :2].T, **line(TRUTH, linewidth=1.2), label="true path")
    if dead:
        ax.plot(*moved(d.dead), **line(DEAD_RECKONING, linewidth=1.2), label="dead reckoning")
    ax.plot(*moved(d.path), **line(ESTIMATE, linewidth=1.4), label="your filter")
    _, x, P, ids = d.states[k]
    l, B = x[3:].reshape(-1, 2), np.array([P[i : i + 2, i : i + 2] for i in range(3, len(x), 2)])
    plot_ellipse(ax, F.from_frame(l)[0], F.R @ B @ F.R.T, k=3, color=BLUE, linewidth=1.3, label=sigma_label(3))
    ax.plot(*F.from_frame(l)[0].T, **points(ESTIMATE), label="landmarks")
    robot(ax, F.compose(Frame2(d.path[k]))[0].x)
    return len(ids)
