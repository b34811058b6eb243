"""Drawings of notebook 15: a shared landmark, a rumour, a meeting, the mounting of a camera, a second camera."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import anees_band
from ...geometry import wrap
from ...graphics import ESTIMATE, MEASUREMENT, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREEN, GREY, LIGHT_GREY, ORANGE, PURPLE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from .nb15_eyes import DEPTHS, MOUNT, RHO_STD, depth_sigmas, mounting
from .nb15_runs import (
    METHODS,
    POINTS,
    ROBOTS,
    STARTS,
    STEPS,
    add_information,
    joined,
    meeting,
    own_map,
    rumour,
    same_landmarks,
    shared,
)
from .parts import nees_gauge, robot, true_landmarks

__all__ = ["METHODS", "MOUNT", "add_information", "depth_sigmas", "joined", "meeting", "mounting", "own_map", "rumour",
           "same_landmarks", "shared"]  # fmt: skip

LOOKS: tuple[dict[str, Any], ...] = (
    dict(color=BLUE, linestyle="-"),
    dict(color=ORANGE, linestyle="--"),
)  # of robot 1 and robot 2


def _ellipse(ax, x, P, k, look, label=None):
    plot_ellipse(ax, x[:2], P[:2, :2], 3, **look, linewidth=2, label=label)
    robot(ax, x[:3], size=0.55, facecolor=look["color"])
    ax.annotate(f"robot {k}", x[:2], (-12, -24), textcoords="offset points", fontsize=13, weight="bold", zorder=9)


# ---- one map, one landmark ------------------------------------------------------------------------------------------


@explorable(
    step=Int(2, 0, 3, label="step", play=1200),
    same=Toggle(True, label="robot 2 sees the same landmark"),
    std=Float(1.0, 0.2, 1.5, 0.1, "position of a robot, 1 sigma", "m"),
    ranges={"correlation": (0, 1.0001), "second": (0, 3)},
)
def one_landmark(step, same, std):
    """Two robots that have never met, a landmark, and a GPS for robot 1 only."""
    x, P = shared(step, same, std)
    fig, (ax, im) = plt.subplots(1, 2, figsize=(12.4, 4.9), width_ratios=(1.75, 1))
    fig.subplots_adjust(left=0.06, right=0.985, bottom=0.12, top=0.92, wspace=0.1)  # quicker than a layout engine
    seen = POINTS[:1] if same else POINTS
    ax.plot(*seen.T, **points(TRUTH, markersize=14), label="landmark, truth")
    for k, r in enumerate((slice(0, 3), slice(3, 6))):
        robot(ax, ROBOTS[k], TRUTH, size=0.55)
        _ellipse(ax, x[r], P[r, r], k + 1, LOOKS[k], f"robot {k + 1}, {sigma_label(3)}")
    for i in range(6, len(x), 2):
        plot_ellipse(ax, x[i : i + 2], P[i : i + 2, i : i + 2], 3, color=PURPLE, linestyle=":", linewidth=2.4,
                     label="landmark, 3σ" if i == 6 else None)  # fmt: skip
        ax.plot(*x[i : i + 2], **points(ESTIMATE, color=PURPLE, markersize=6))
    if step == 3:
        ax.plot(*ROBOTS[0, :2], **points(MEASUREMENT, markersize=18), label="GPS of robot 1")
    ax.set(xlim=(-8.6, 9.4), ylim=(-5, 6.6), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_title(f"Step {step}: {STEPS[step]}", loc="left")
    ax.legend(loc="upper left", ncols=2, fontsize=11)
    C = P / np.sqrt(np.outer(np.diag(P), np.diag(P)))
    im.imshow(C, cmap="PuOr_r", vmin=-1, vmax=1)
    edges = [0, 3, 6, *range(8, len(x) + 1, 2)]
    for e in edges[1:-1]:
        im.axhline(e - 0.5, color=BLACK, linewidth=1)
        im.axvline(e - 0.5, color=BLACK, linewidth=1)
    names = ["robot 1", "robot 2", *(f"lmk {i + 1}" for i in range(len(edges) - 3))]
    middle = [(a + b - 1) / 2 for a, b in zip(edges[:-1], edges[1:], strict=True)]
    im.set_xticks(middle, names, fontsize=12)
    im.set_yticks(middle, names, fontsize=12, rotation=90, va="center")
    im.tick_params(length=0)
    im.grid(False)
    im.set_title("correlations", loc="left")
    c = float(np.abs(C[:2, 3:5]).max())
    sigma = [float(np.sqrt(np.trace(P[r, r]))) for r in (slice(0, 2), slice(3, 5))]
    caption = (
        f"{STEPS[step][0].upper()}{STEPS[step][1:]}. Position sigma of robot 1 {sigma[0]:.2f} m, of robot 2 "
        f"{sigma[1]:.2f} m (both coordinates); largest correlation between the two robots {c:.2f}."
    )
    return fig, {"correlation": c, "second": sigma[1], "caption": caption}


# ---- a rumour -------------------------------------------------------------------------------------------------------


@explorable(
    method=Choice(METHODS[3], list(METHODS), label="what the two trackers do"),
    every=Int(1, 1, 10, label="frames between two exchanges"),
    walk=Float(0.05, 0.02, 1.0, 0.01, "step of the thing, 1 sigma", "m"),
    ranges={"nees": (0, 1e3), "claimed": (0, 10)},
)
def rumours(method, every, walk):
    """Two sensors watch one thing: what is claimed, what is true, and the dial of honesty."""
    r = rumour(method, every, walk)
    k = np.arange(1, len(r.P) + 1)
    rmse = np.sqrt((r.error**2).sum(-1).mean(1))
    claimed = np.sqrt(np.trace(r.P, axis1=1, axis2=2))
    best = rumour(METHODS[0], 1, walk)
    fig, (ax, dial) = plt.subplots(2, 1, figsize=(10.8, 6), height_ratios=(4.6, 1))
    fig.subplots_adjust(left=0.08, right=0.98, bottom=0.11, top=0.94, hspace=0.5)  # quicker than a layout engine
    ax.plot(k, rmse, color=BLACK, linewidth=2.6, linestyle="--", label="true error: RMS of 200 runs")
    ax.plot(k, claimed, color=BLUE, linewidth=2.8, label="claimed: 1σ of the filter")
    ax.plot(k, np.sqrt(np.trace(best.P, axis1=1, axis2=2)), color=GREEN, linewidth=2, linestyle=":",
            label="one joint filter, 1σ: the best possible")  # fmt: skip
    ax.set(xlabel="frame", ylabel="position error (m)", xlim=(1, len(k)))
    ax.set_ylim(0, 1.45 * max(rmse.max(), claimed.max()))
    ax.set_title(method, loc="left")
    ax.legend(loc="upper right")
    nees = float(r.nees[-1].mean())
    nees_gauge(dial, nees, 2, r.nees.shape[1], 0.8, 100)
    low, high = anees_band(2, r.nees.shape[1])
    words = "honest" if low <= nees <= high else "too sure of itself" if nees > high else "too cautious"
    asks = f", exchange every {every} frames" if method in METHODS[3:] and every > 1 else ""
    caption = (
        f"{method.capitalize()}{asks}, after {len(k)} frames: claimed {claimed[-1]:.3f} m, true error {rmse[-1]:.3f} m "
        f"(RMS of {r.nees.shape[1]} runs). Mean NEES {nees:.3g}, honest is {low:.2f} to {high:.2f}: {words}."
    )
    return fig, {"nees": nees, "claimed": float(claimed[-1]), "caption": caption}


# ---- a meeting ------------------------------------------------------------------------------------------------------

STAGES = {"before: map 2 laid on map 1": 0, "they have met": 1, "and common landmarks made one": 2}


@explorable(
    stage=Choice(1, STAGES, label="what is known"),
    bearing_std=Float(1.0, 0.2, 10.0, 0.2, "bearing of the other robot, 1 sigma", "deg"),
    seed=Int(0, 0, 9, label="noise number"),
    ranges={"error": (0, 30), "nees": (0, 1e8)},
)
def meet(stage, bearing_std, seed):
    """Two robots, each with a map of its own, meet in the middle."""
    x, P, n1, ids, truth, common = joined(seed, bearing_std, stage)
    fig = plt.figure(figsize=(11, 5.6))
    ax = fig.add_axes((0.07, 0.11, 0.62, 0.86))
    turn = np.array(
        [[0, -1], [1, 0]]
    )  # the picture shows the world, in which robot 1 starts to the left and looks down
    show = lambda p: np.asarray(p) @ turn + STARTS[0, :2]
    look = lambda C: turn.T @ C @ turn
    p = truth[np.r_[3:n1, n1 + 3 : len(x)]].reshape(-1, 2)
    true_landmarks(ax, show(p))
    for k, (at, end) in enumerate(((0, n1), (n1, len(x)))):
        for i in range(at + 3, end, 2):
            plot_ellipse(ax, show(x[i : i + 2]), look(P[i : i + 2, i : i + 2]), 3, **LOOKS[k], linewidth=1.8,
                         label=f"map {k + 1}, {sigma_label(3)}" if i == at + 3 else None)  # fmt: skip
        ax.plot(*show(x[at + 3 : end].reshape(-1, 2)).T, marker="os"[k], color=LOOKS[k]["color"], markersize=5,
                linestyle="none")  # fmt: skip
        q = x[at : at + 3] + [0, 0, -np.pi / 2]
        robot(ax, [*show(q[:2]), q[2]], size=0.5, facecolor=LOOKS[k]["color"])
        beside = ((10, 6), (-26, 18))[k]
        ax.annotate(f"robot {k + 1}", tuple(show(q[:2])), beside, textcoords="offset points", fontsize=13,
                    weight="bold")  # fmt: skip
        robot(ax, [*show(truth[at : at + 2]), truth[at + 2] - np.pi / 2], TRUTH, size=0.5)
    if stage:
        ends = show(np.array([x[:2], x[n1 : n1 + 2]]))
        ax.plot(*ends.T, **line(MEASUREMENT, linewidth=2.2), zorder=3, label="they see each other")
    ax.set(xlim=(-8.6, 6.6), ylim=(-5.4, 5.4), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)
    second = np.arange(n1, len(x))
    e = x[second] - truth[second]
    e[2] = wrap(e[2])
    error = float(np.sqrt(np.mean(e[3:] ** 2) * 2))
    nees = float(e @ np.linalg.solve(P[np.ix_(second, second)], e)) / len(e)
    sigma = float(np.sqrt(np.trace(P[n1 + 3 :, n1 + 3 :]) / (len(e) - 3) * 2))
    count = f"; {common} landmarks are in both" if stage == 2 else ""
    caption = (
        f"{next(name for name, s in STAGES.items() if s == stage).capitalize()}: the landmarks of map 2 are off by "
        f"{error:.2f} m (RMS), their sigma is {sigma:.2f} m{count}. NEES per number {nees:.2g}; honest is about 1."
    )
    return fig, {"error": error, "nees": nees, "caption": caption}


# ---- the mounting of a camera ---------------------------------------------------------------------------------------


@explorable(
    turn=Float(0.0, 0.0, 3.0, 0.3, "turn of the robot in a frame", "deg"),
    std=Float(2.0, 0.5, 4.0, 0.5, "mounting is off by, 1 sigma", "deg"),
    calibrate=Toggle(True, label="the mounting is in the map"),
    seed=Int(1, 1, 9, label="noise number"),
    run=True,
    ranges={"nees": (0, 1e6), "robot": (0, 5)},
)
def calibration(turn, std, calibrate, seed):
    """The mounting of a camera as a part of the map: its errors, and what happens without."""
    m = mounting(turn, std, seed, calibrate=calibrate)
    k = np.arange(1, len(m.error) + 1)
    fig, axes = plt.subplots(1, 3, figsize=(12.6, 4.4), sharey=True, layout="constrained")
    for i, (ax, name) in enumerate(zip(axes, ("roll: about the way ahead", "pitch", "yaw"), strict=True)):
        ax.fill_between(k, -2 * m.std[:, i], 2 * m.std[:, i], color=BLUE, alpha=0.22, linewidth=0, label="2σ")
        ax.plot(k, m.error[:, i], color=BLACK, linestyle="--", linewidth=2.4, label="error")
        ax.axhline(0, color=GREY, linewidth=1)
        ax.set_title(name, loc="left")
        ax.set(xlabel="frame", xlim=(1, len(k)), ylim=(-3.2 * std, 3.2 * std))
    axes[0].set_ylabel("mounting, about the robot's axes (deg)")
    axes[0].legend(loc="upper right", ncols=2)
    end, sigma, nees, off = m.error[-1], m.std[-1], float(m.nees[-1]), float(m.robot[-1])
    words = " / ".join(f"{e + 0.0:.2f}" for e in np.round(end, 2))
    claim = " / ".join(f"{s:.2f}" for s in sigma) if calibrate else "0: taken as exact"
    caption = (
        f"After {len(k)} frames: errors of roll, pitch, yaw {words} deg, 1 sigma {claim} deg. The robot is off by "
        f"{off:.2f} m, its NEES is {nees:.3g} (mean of honest filters: 6)."
    )
    return fig, {"nees": nees, "robot": off, "caption": caption}


# ---- a second camera ------------------------------------------------------------------------------------------------


@explorable(
    baseline=Float(0.25, 0.05, 1.0, 0.05, "second camera to the right", "m"),
    frames=Int(1, 1, 20, label="frames", play=300),
    step=Float(0.0, 0.0, 0.2, 0.02, "drive ahead in each frame", "m"),
    noise=Choice(1.0, {"0.2 px": 0.2, "1 px": 1.0, "3 px": 3.0}, label="noise of a pixel, sigma"),
    ranges={"near": (0, 2), "far": (0, 8)},
)
def two_cameras(baseline, frames, step, noise):
    """How well the depth of points is known: by one camera, and by two."""
    one, two = depth_sigmas(0.0, frames, step, noise), depth_sigmas(baseline, frames, step, noise)
    prior = RHO_STD * np.linalg.norm(np.column_stack([DEPTHS, DEPTHS / 4]), axis=1)
    fig, ax = plt.subplots(figsize=(10.5, 5.2), layout="constrained")
    ax.loglog(DEPTHS, 100 * prior, color=LIGHT_GREY, linewidth=8, label="prior")
    ax.loglog(DEPTHS, 100 * one, color=VERMILLION, linestyle="--", marker="s", markersize=8, linewidth=2.4,
              label="one camera")  # fmt: skip
    ax.loglog(DEPTHS, 100 * two, color=BLUE, marker="o", markersize=8, linewidth=2.6, label="two cameras")
    ax.axhspan(0.01, 10, color=GREEN, alpha=0.13, linewidth=0)
    ax.text(2.05, 0.12, "green: depth known to 10 % (1σ)", fontsize=12, color=BLACK)
    ax.set(xlim=(1.9, 50), ylim=(0.1, 900), xlabel="depth of the point (m)", ylabel="1σ of the inverse depth (%)")
    ax.set_xticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.minorticks_off()
    ax.legend(loc="lower right")
    depth = lambda s: np.exp(np.interp(np.log(0.1), np.log(s), np.log(DEPTHS)))  # where the curve leaves the green
    reach = lambda s: f"up to {depth(s):.1f} m" if np.any(s <= 0.1) else "nowhere"
    caption = (
        f"{frames} frame{'s' * (frames != 1)}, {(frames - 1) * step:.1f} m driven, cameras {baseline:.2f} m apart. "
        f"Depth known to 10 %: with one camera {reach(one)}, with two {reach(two)}. At 2 m: {100 * one[0]:.2g} % and "
        f"{100 * two[0]:.2g} %; at 48 m: {100 * one[-1]:.3g} % and {100 * two[-1]:.2g} %."
    )
    return fig, {"near": float(two[0]), "far": float(two[-1]), "caption": caption}
