"""Drawings of notebook 08: what cannot be known, and how an EKF comes to believe that it knows it."""

import matplotlib.pyplot as plt
import numpy as np

from ...graphics import DEAD_RECKONING, ESTIMATE, REJECTED, TRUTH, UPDATED, line, points
from ...graphics.style import BLACK, BLUE, GREY, ORANGE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from . import parts

LANDMARK = (8.0, 0.2)  # true range (m) and bearing (rad) of the landmark of the robot that stands still


def sigma_figure(curves):
    """Heading sigma over the number of sightings, `curves`: name -> sigmas in degrees. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(8.6, 4.4), layout="constrained")
    says = []
    for (name, sigma), style in zip(curves.items(), (REJECTED, UPDATED), strict=False):
        ax.plot(sigma, **line(style, linestyle="-", linewidth=2.5), label=f"{name}: what it claims")
        says.append(f"{name}: {sigma[0]:.0f} degrees before, {sigma[-1]:.1f} after {len(sigma) - 1} sightings")
    start = next(iter(curves.values()))[0]
    ax.axhline(start, **line(TRUTH, linewidth=1.5), label="truth: nothing was learned")
    ax.set(xlabel="sightings of one new landmark, robot at rest", ylabel="heading, 1 sigma (deg)", ylim=(0, None))
    ax.legend(loc="center right")
    return fig, ". ".join(says) + "."


@explorable(
    prior=Float(30.0, 1.0, 40.0, 1.0, "heading sigma before", "deg"),
    n=Int(100, 1, 100, label="sightings", play=100),
    seed=Int(3, 0, 9, label="seed of the noise"),
    ranges={"sigma_deg": (0, 41), "nees": (0, 1e5)},
)
def stand_still(standing, prior, n, seed):
    """The robot that stands still, by a function of the notebook: standing(prior, seed) -> errors, sigmas (deg)."""
    error, sigma = standing(prior, seed)
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.9), width_ratios=(1, 1.25))
    fig.subplots_adjust(left=0.07, right=0.98, bottom=0.25, top=0.97, wspace=0.2)
    theta, s, reach = error[n], sigma[n], 7.0
    fan = np.radians(np.linspace(theta - 3 * s, theta + 3 * s, 60))
    ax.fill([0, *(reach * np.cos(fan)), 0], [0, *(reach * np.sin(fan)), 0], color=BLUE, alpha=0.2, label="±3 sigma")
    ax.plot([0, reach * np.cos(fan.mean())], [0, reach * np.sin(fan.mean())], **line(ESTIMATE), label="heading")
    ax.plot([0, reach], [0, 0], **line(TRUTH), label="true heading")
    r, bearing = LANDMARK
    ax.plot(r * np.cos(bearing), r * np.sin(bearing), **points(TRUTH), label="true landmark")
    parts.robot(ax, np.zeros(3), TRUTH, 1.2)
    parts.robot(ax, np.array([0, 0, np.radians(theta)]), ESTIMATE, 1.2)
    ax.set(xlim=(-4, 9.5), ylim=(-7, 7), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, fontsize=11, frameon=False)
    k = np.arange(n + 1)
    right.fill_between(k, -3 * sigma[: n + 1], 3 * sigma[: n + 1], color=BLUE, alpha=0.2, label="±3 sigma")
    right.plot(k, error[: n + 1], color=VERMILLION, label="error")
    right.axhline(0, color=BLACK, linewidth=0.8)
    right.set(xlabel="sightings", ylabel="heading error (deg)", xlim=(0, 100), ylim=(-3.2 * prior, 3.2 * prior))
    right.legend(loc="upper right")
    nees = float((theta / s) ** 2)
    caption = (
        f"{n} sightings: heading sigma {prior:.0f} degrees before, {s:.1f} after; the error is {theta:.1f} degrees, "
        f"NEES {nees:.1f} (honest: about 1)."
    )
    return fig, {"sigma_deg": float(s), "nees": nees, "caption": caption}


@explorable(
    dx=Float(3.0, -6.0, 6.0, 0.5, "shift in x", "m"),
    dy=Float(1.0, -6.0, 6.0, 0.5, "shift in y", "m"),
    turn=Float(40.0, -180.0, 180.0, 5.0, "turn", "deg"),
    robot=Toggle(True, label="move the robot, too"),
    ranges={"change_m": (0, 30)},
)
def rotate_world(move_solution, dx, dy, turn, robot):
    """Move the whole solution, or the map alone, by a function of the notebook: do the residuals notice?"""
    poses, landmarks, before = move_solution(0.0, 0.0, 0.0, True)
    moved, moved_l, after = move_solution(dx, dy, turn, robot)
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.9))
    fig.subplots_adjust(left=0.07, right=0.98, bottom=0.2, top=0.9, wspace=0.2)
    ax.plot(*poses[:, :2].T, **line(DEAD_RECKONING), label="path before")
    ax.plot(*landmarks.T, **points(ESTIMATE, color=GREY, fillstyle="none", markersize=8), label="map before")
    ax.plot(*moved[:, :2].T, **line(ESTIMATE), label="path after")
    for pose in poses:
        parts.robot(ax, pose, DEAD_RECKONING, 1.0)
    for pose in moved:
        parts.robot(ax, pose, ESTIMATE, 1.0)
    ax.plot(*moved_l.T, **points(ESTIMATE, markersize=8), label="map after")
    ax.set(xlim=(-15, 15), ylim=(-14, 14), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=4, fontsize=11, frameon=False, columnspacing=1)
    right.plot(before[..., 0].ravel(), "s", color=GREY, fillstyle="none", markersize=9, label="before")
    right.plot(after[..., 0].ravel(), "+", color=ORANGE, markersize=9, markeredgewidth=2, label="after")
    right.set(xlabel="measurement number", ylabel="residual of the range (m)")
    right.legend(loc="lower right", bbox_to_anchor=(1, 0.98), ncols=2, frameon=False)
    change = float(np.abs(after - before)[..., 0].max())
    same = np.abs(after - before).max() < 1e-9
    word = "no residual changes (less than 1e-9)" if same else f"residuals change by up to {change:.1f} m in range"
    what = "robot and map" if robot else "the map alone"
    caption = f"Moved by ({dx:.1f}, {dy:.1f}) m and {turn:.0f} degrees, {what}: {word}."
    return fig, {"change_m": change, "caption": caption}


@explorable(
    form=Choice("short form", {"(I - K H) P": "short form", "Joseph form": "Joseph form"}, label="P after"),
    gain=Float(1.01, 0.9, 1.1, 0.01, "gain / best gain"),
    noise=Choice(0.01, {"10 cm": 0.1, "1 cm": 0.01, "1 mm": 0.001}, label="noise sigma"),
    double=Toggle(False, label="double precision (float64)"),
    ranges={"negative": (0, 15), "failures": (0, 20)},
)
def eigenvalues(smallest, forms, form, gain, noise, double):
    """Smallest eigenvalue of P after each update, by a function of the notebook: smallest(form, noise, gain, ...)."""
    number = np.float64 if double else np.float32
    sequences = [smallest(forms[form], noise, round(gain, 3), number, seed) for seed in range(20)]
    low, count = sequences[0], sum(bool((s < 0).any()) for s in sequences)
    fig = plt.figure(figsize=(10.5, 4.4))
    ax = fig.add_axes((0.1, 0.13, 0.6, 0.78))
    k, bad = np.arange(1, len(low) + 1), low < 0
    ax.plot(k, low, color=GREY, linewidth=1)
    ax.plot(k[~bad], low[~bad], **points(ESTIMATE, markersize=8), label="not negative")
    ax.plot(k[bad], low[bad], **points(REJECTED, markersize=11), label="negative: no covariance")
    ax.axhline(0, color=BLACK, linewidth=1)
    ax.set(xlabel="update", ylabel="smallest / largest eigenvalue of P", ylim=(-1.5, 1.5))
    ax.set_yscale("symlog", linthresh=1e-9)
    ax.set_yticks([-1, -1e-3, -1e-6, 0, 1e-6, 1e-3, 1])
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    ax.set_title(f"{form}, float{64 if double else 32}, gain {gain:.2f} times the best")
    caption = (
        f"{form.capitalize()}, float{64 if double else 32}, gain {gain:.2f} times the best one, prior 10 m, noise "
        f"{noise:g} m: P has a negative eigenvalue after {int(bad.sum())} of {len(low)} updates. It happens in {count} "
        "of 20 sequences."
    )
    return fig, {"negative": int(bad.sum()), "failures": count, "caption": caption}
