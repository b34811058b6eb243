"""Drawings of notebook 09: a real log, what is wrong with it, and what EKF-SLAM makes of it."""

from functools import cache

import matplotlib.pyplot as plt
import numpy as np

from ...geometry import Frame2
from ...graphics import DEAD_RECKONING, ESTIMATE, REJECTED, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREY, ORANGE, VERMILLION, Style
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from . import nb09_runs as runs
from .nb09_runs import TWIN, files, here, slam
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


@cache
def _in_truth(which, shift=0.0):
    """The run of a log, and the frame that lays its map on the surveyed landmarks."""
    run = slam(which, shift=shift)
    F, _ = run.history.alignment()
    return run, run.history.track(files(which).robot), F


def map_figure(which, shift=0.0):
    """Path and map after alignment, with dead reckoning. Returns (fig, caption)."""
    run, track, F = _in_truth(which, shift)
    fig, ax = _axes()
    _draw(ax, which, run, track, F, len(track.t) - 1, True)
    _legend(ax)
    s = run.summary
    return fig, (
        f"{which.capitalize()} {files(which).name}, {len(track.t)} frames: ATE {s['ate_aligned_m']:.2f} m, landmarks "
        f"{s['landmark_rmse_aligned_m']:.2f} m, dead reckoning {s['dead_reckoning_ate_m']:.2f} m, all after alignment. "
        f"Mean NIS {s['nis_mean']:.2f} (white noise: 2), mean NEES {s['nees_mean']:.1f} (3)."
    )


@explorable(
    percent=Int(40, 1, 100, label="time", play=150, tip="Per cent of the log; arrow keys move it"),
    aligned=Toggle(True, label="aligned with the truth"),
    dead=Toggle(True, label="dead reckoning"),
    ranges={"landmarks": (1, 20)},
)
def scrubber(percent, aligned, dead):
    """The log from beginning to end: path, map, and where the odometry alone would be."""
    which = here()
    run, track, F = _in_truth(which)
    k = max((len(track.t) - 1) * percent // 100, 1)
    fig, ax = _axes()
    n = _draw(ax, which, run, track, F if aligned else Frame2(np.zeros(3)), k, dead)
    _legend(ax)
    how = "aligned" if aligned else "in the frame of its start"
    ax.set_title(f"{which}, {track.t[k]:.0f} s")
    return fig, {
        "landmarks": n,
        "caption": f"{which.capitalize()} after {track.t[k]:.0f} s: {n} landmarks in the map, {how}.",
    }


def clock_figure(offsets, nis, best):
    """Mean NIS over the clock offset. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(8, 4.6), layout="constrained")
    _curve(ax, offsets, nis)
    ax.plot(best, np.min(nis), **points(TRUTH, markersize=16), label="smallest")
    ax.legend()
    return fig, (
        f"Mean NIS of the {TWIN} over the clock offset: smallest, {np.min(nis):.2f}, at {best:.1f} s; "
        f"without correction {nis[np.argmin(np.abs(offsets))]:.2f}."
    )


@explorable(
    offset=Float(0.0, -0.1, 0.6, 0.1, "clock offset", "s", "Subtracted from the stamps of the sightings"),
    factor=Choice(1.0, {"a quarter": 0.25, "as tuned": 1.0, "four times": 4.0}, label="variances R"),
    run=True,
    ranges={"nis": (0.05, 10)},
)
def clock_and_noise(offset, factor):
    """Two knobs, one number: the NIS has a minimum over the offset, but falls for ever with R."""
    run = slam(TWIN, runs.CLOCK_SECONDS, float(np.round(runs.CLOCK_ERROR - offset, 3)), factor)
    t = np.arange(len(run.nis))
    fig, axes = plt.subplots(1, 2, figsize=(10.5, 4.6), layout="constrained")
    for ax, i, name, unit in zip(axes, (0, 1), ("range", "bearing"), ("m", "deg"), strict=True):
        scale = 1.0 if i == 0 else 180 / np.pi
        # one tick for each sighting, no line: neighbours are sightings of different landmarks
        sigma = 3 * np.sqrt(run.Z[:, i, i]) * scale
        ax.plot(t, sigma, "_", color=GREY, markersize=4, label="±3σ (99.7 %)")
        ax.plot(t, -sigma, "_", color=GREY, markersize=4)
        ax.plot(t, run.z[:, i] * scale, ".", color=BLUE, markersize=4, label="innovation")
        top = (2.0, 20.0)[i]
        ax.set(xlabel="sighting", ylabel=f"{name} ({unit})", ylim=(-top, top))
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, markerscale=2, frameon=False)
    nis = float(run.nis.mean())
    fig.suptitle(f"mean NIS {nis:.2f}   (white noise, right R: 2)")
    caption = f"{TWIN.capitalize()}, offset {offset:.1f} s, variances times {factor:g}: mean NIS {nis:.2f}."
    return fig, {"nis": nis, "caption": caption}


def noise_figure(which, factors=(0.05, 0.1, 0.25, 1.0), seconds=120.0):
    """NIS and NEES over the factor of R. Returns (fig, caption)."""
    s = [slam(which, seconds, 0.0, k).summary for k in factors]
    nis, nees, error = (np.array([a[n] for a in s]) for n in ("nis_mean", "nees_mean", "ate_aligned_m"))
    fig, ax = plt.subplots(figsize=(8.4, 4.8), layout="constrained")
    ax.plot(factors, nis / 2, **_both(ESTIMATE), label="mean NIS / 2")
    ax.plot(factors, nees / 3, **{**_both(TRUTH), "color": VERMILLION}, label="mean NEES / 3")
    ax.axhline(1.0, color=BLACK, linewidth=1, linestyle=":", label="honest: 1")
    ax.set(xscale="log", yscale="log", xlabel="variances R, relative to the tuned ones", ylabel="relative to the ideal")
    ax.set_xticks(factors, [f"{k:g}" for k in factors])
    ax.set_yticks([0.1, 0.3, 1, 3], ["0.1", "0.3", "1", "3"])
    ax.minorticks_off()
    ax.set_title(f"{which}, {seconds:.0f} s")
    ax.legend(loc="best")
    nearest = int(np.argmin(abs(np.log(nis / 2))))
    return fig, (
        f"{which.capitalize()} {files(which).name}: with R times {factors[nearest]:g} the mean NIS is "
        f"{nis[nearest]:.1f}, near 2, and the mean NEES is {nees[nearest]:.1f}, honest is 3. With the tuned R they are "
        f"{nis[-1]:.2f} and {nees[-1]:.1f}; ATE {error[nearest]:.2f} m and {error[-1]:.2f} m."
    )


def alignment_figure(path, truth, aligned, error):
    """A path in its own frame, the truth, and the path after alignment. Returns (fig, caption)."""
    fig, ax = _axes()
    ax.plot(*path.T, **line(DEAD_RECKONING), label="estimate, own frame")
    ax.plot(*np.asarray(aligned).T, **line(ESTIMATE), label="estimate, aligned")
    ax.plot(*truth.T, color=BLACK, linestyle="--", linewidth=1.2, label="truth")
    ax.plot(*path[0], "o", color=GREY, markersize=9, label="starts")
    ax.plot(*truth[0], "o", color=BLACK, fillstyle="none", markersize=9)
    _legend(ax)
    before = np.sqrt(((path - truth) ** 2).sum(1).mean())
    return fig, f"Before alignment the path is {before:.1f} m off, after it {error:.2f} m (ATE, {len(path)} instants)."


# ---- parts --------------------------------------------------------------------------------------------------


def _both(style) -> Style:
    return {**style, "markersize": 10}


def _curve(ax, offsets, nis):
    ax.plot(offsets, nis, **_both({**ESTIMATE, "marker": "s"}), label="mean NIS")
    ax.set(xlabel="clock offset taken from the stamps (s)", ylabel="mean NIS", ylim=(0, 1.1 * np.max(nis)))


def _axes():
    fig = plt.figure(figsize=(9.6, 6.6))
    ax = fig.add_axes((0.08, 0.1, 0.6, 0.83))
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_adjustable("datalim")
    return fig, ax


def _legend(ax):
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0, fontsize=12, frameon=False)


def _draw(ax, which, run, track, F, k, dead):
    """Frame k of a run, seen from the parent of F. Returns the number of landmarks in the map."""
    moved = track.moved(F)
    if np.any(F.x):
        true_landmarks(ax, runs.survey(which).points)
        ax.plot(*track.truth[: k + 1, :2].T, color=BLACK, linestyle="--", linewidth=1.2, label="true path")
    if dead:
        ax.plot(*moved.dead[: k + 1, :2].T, **line(DEAD_RECKONING), linewidth=1.2, label="dead reckoning")
    ax.plot(*moved.x[: k + 1, :2].T, **line(ESTIMATE), linewidth=1.4, label="EKF-SLAM")
    l, B = (np.array(a) for a in zip(*run.maps[k].values(), strict=True))
    l = F.from_frame(l)[0]
    plot_ellipse(ax, l, F.R @ B @ F.R.T, k=3, color=BLUE, linewidth=1.3, label=sigma_label(3))
    ax.plot(*l.T, **points(ESTIMATE), label="landmarks")
    robot(ax, moved.x[k])
    return len(l)


def rigidly_moved(path, angle, shift):
    """The same path, turned about the origin by `angle` and moved by `shift`."""
    return Frame2(np.array([*shift, angle])).from_frame(np.asarray(path))[0]
