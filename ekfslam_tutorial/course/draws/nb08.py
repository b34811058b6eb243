"""Drawings of notebook 08: what cannot be known, and how an EKF comes to believe that it knows it."""

import matplotlib.pyplot as plt
import numpy as np

from ...geometry import Frame2, wrap
from ...graphics import ESTIMATE, TRUTH, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION
from ...models.sensors.range_bearing import polar
from ..controls import Choice, Float, Int, Toggle
from ..exercises.nb08_fej import observe
from ..widgets import explorable
from .nb08_runs import (
    EKF,
    FEJ,
    JOSEPH,
    LANDMARK,
    LANDMARKS,
    SHORT,
    TIDY,
    R,
    all_at_once,
    drive,
    failures,
    first_sight,
    measurements,
    repeated,
    standing,
)

__all__ = ["R", "all_at_once", "drive", "failures", "first_sight", "measurements", "observe", "standing"]


def sigma_figure(*curves):
    """Heading sigma over the number of sights. Each curve: (sigmas in degrees, label). Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(8.6, 4.4), layout="constrained")
    says = []
    for (sigma, label), (color, dashes) in zip(curves, ((VERMILLION, "-"), (GREEN, "--"), (BLUE, ":")), strict=False):
        sigma = np.asarray(sigma, float)
        ax.plot(sigma, color=color, linestyle=dashes, linewidth=2.5, label=label)
        says.append(f"{label}: {sigma[0]:.0f} degrees before, {sigma[-1]:.1f} after {len(sigma) - 1} sights")
    ax.axhline(curves[0][0][0], color=BLACK, linewidth=1, linestyle=":", label="the truth: nothing was learned")
    ax.set(xlabel="sights of one new landmark, robot at rest", ylabel="heading, 1 sigma [deg]", ylim=(0, None))
    ax.legend(loc="center right")
    return fig, ". ".join(says) + "."


@explorable(
    prior=Float(30.0, 1.0, 40.0, 1.0, "heading sigma before", "deg"),
    n=Int(100, 1, 100, label="sights", play=100),
    jacobians=Choice(EKF, {"present estimate (EKF)": EKF, "first estimate (FEJ)": FEJ}, label="Jacobians at the"),
    seed=Int(0, 0, 9, label="noise number"),
    ranges={"sigma_deg": (0, 41), "nees": (0, 1e5)},
)
def stand_still(prior, n, jacobians, seed):
    """The robot that stands still: what it believes of its heading."""
    error, sigma, _, _ = standing(prior, jacobians, 100, seed)
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.9), width_ratios=(1, 1.25))
    fig.subplots_adjust(left=0.07, right=0.98, bottom=0.25, top=0.97, wspace=0.2)
    theta, s = np.degrees(error[n]), np.degrees(sigma[n])
    fan = np.radians(np.linspace(theta - 3 * s, theta + 3 * s, 60))
    reach = 7.0
    ax.fill(
        [0, *(reach * np.cos(fan)), 0], [0, *(reach * np.sin(fan)), 0], color=BLUE, alpha=0.2, label="heading, 3 sigma"
    )
    ax.plot([0, reach * np.cos(error[n])], [0, reach * np.sin(error[n])], color=BLUE, label="heading believed")
    ax.plot([0, reach], [0, 0], color=BLACK, linestyle="--", label="true heading")
    ax.plot(
        *(LANDMARK[0] * np.array([np.cos(LANDMARK[1]), np.sin(LANDMARK[1])])), **points(TRUTH), label="true landmark"
    )
    ax.plot(0, 0, "k>", markersize=12)
    ax.set(xlim=(-4, 9.5), ylim=(-7, 7), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, fontsize=11, frameon=False)
    k = np.arange(n + 1)
    right.fill_between(
        k, -3 * np.degrees(sigma[: n + 1]), 3 * np.degrees(sigma[: n + 1]), color=BLUE, alpha=0.2, label="3 sigma"
    )
    right.plot(k, np.degrees(error[: n + 1]), color=VERMILLION, label="true error")
    right.axhline(0, color=BLACK, linewidth=0.8)
    right.set(xlabel="sights", ylabel="heading error [deg]", xlim=(0, 100), ylim=(-3.2 * prior, 3.2 * prior))
    right.legend(loc="upper right")
    nees = float((error[n] / sigma[n]) ** 2)
    caption = (
        f"{jacobians}, {n} sights: heading sigma {prior:.0f} degrees before, {s:.1f} after; the error is {theta:.1f} "
        f"degrees, NEES {nees:.1f} (honest: about 1)."
    )
    return fig, {"sigma_deg": float(s), "nees": nees, "caption": caption}


@explorable(
    dx=Float(3.0, -6.0, 6.0, 0.5, "shift in x", "m"),
    dy=Float(1.0, -6.0, 6.0, 0.5, "shift in y", "m"),
    turn=Float(40.0, -180.0, 180.0, 5.0, "turn", "deg"),
    robot=Toggle(True, label="move the robot, too"),
    ranges={"change_m": (0, 30)},
)
def rotate_world(dx, dy, turn, robot):
    """Move the whole solution, or the map alone: do the residuals notice?"""
    rng = np.random.default_rng(12)
    a = np.linspace(0, 1.5 * np.pi, 8)
    poses = np.column_stack([3 * np.cos(a), 3 * np.sin(a), a + np.pi / 2])
    y = _expected(poses, LANDMARKS) + rng.normal(size=(8, 4, 2)) * np.sqrt(np.diag(R))
    G = Frame2(np.array([dx, dy, np.radians(turn)]))
    moved_l = G.from_frame(LANDMARKS)[0]
    moved = G.compose(Frame2(poses))[0].x if robot else poses
    before, after = _residual(y, _expected(poses, LANDMARKS)), _residual(y, _expected(moved, moved_l))
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.9))
    fig.subplots_adjust(left=0.07, right=0.98, bottom=0.2, top=0.9, wspace=0.2)
    ax.plot(*poses[:, :2].T, color=GREY, linestyle="--", marker="v", fillstyle="none", label="path before")
    ax.plot(*LANDMARKS.T, **points(TRUTH, color=GREY), label="map before")
    ax.plot(*moved[:, :2].T, color=BLUE, marker="v", label="path after")
    ax.plot(*moved_l.T, **points(ESTIMATE, markersize=8), label="map after")
    ax.set(xlim=(-15, 15), ylim=(-14, 14), xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=4, fontsize=11, frameon=False, columnspacing=1)
    right.plot(before[..., 0].ravel(), "s", color=GREY, fillstyle="none", markersize=9, label="before")
    right.plot(after[..., 0].ravel(), "+", color=ORANGE, markersize=9, markeredgewidth=2, label="after")
    right.set(xlabel="measurement number", ylabel="residual of the range [m]")
    right.legend(loc="lower right", bbox_to_anchor=(1, 0.98), ncols=2, frameon=False)
    change = float(np.abs(after - before)[..., 0].max())
    same = np.abs(after - before).max() < 1e-9
    word = "no residual changes (less than 1e-9)" if same else f"residuals change by up to {change:.1f} m in range"
    what = "robot and map" if robot else "the map alone"
    caption = f"Moved by ({dx:.1f}, {dy:.1f}) m and {turn:.0f} degrees, {what}: {word}."
    return fig, {"change_m": change, "caption": caption}


@explorable(
    form=Choice(
        SHORT, {"(I - K H) P": SHORT, "Joseph form": JOSEPH, "Joseph form, made symmetric": TIDY}, label="P after"
    ),
    gain=Float(1.01, 0.9, 1.1, 0.01, "gain / best gain"),
    noise=Choice(0.01, {"10 cm": 0.1, "1 cm": 0.01, "1 mm": 0.001}, label="noise sigma"),
    double=Toggle(False, label="double precision (float64)"),
    ranges={"negative": (0, 15), "failures": (0, 20)},
)
def eigenvalues(form, gain, noise, double):
    """Smallest eigenvalue of P after each update: rounding, and a gain that is not the best one."""
    case = dict(noise=noise, gain=round(gain, 3), double=double)
    low, count = repeated(form, **case), failures(form, 20, **case)
    fig = plt.figure(figsize=(10.5, 4.4))
    ax = fig.add_axes((0.1, 0.13, 0.6, 0.78))
    k, bad = np.arange(1, len(low) + 1), low < 0
    ax.plot(k, low, color=GREY, linewidth=1)
    ax.plot(k[~bad], low[~bad], "o", color=BLUE, markersize=8, label="not negative")
    ax.plot(
        k[bad], low[bad], "x", color=VERMILLION, markersize=11, markeredgewidth=2.5, label="negative: no covariance"
    )
    ax.axhline(0, color=BLACK, linewidth=1)
    ax.set(xlabel="update", ylabel="smallest / largest eigenvalue of P", ylim=(-1.5, 1.5))
    ax.set_yscale("symlog", linthresh=1e-9)
    ax.set_yticks([-1, -1e-3, -1e-6, 0, 1e-6, 1e-3, 1])
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    name = "(I - K H) P" if form == SHORT else form
    ax.set_title(f"{name}, float{64 if double else 32}, gain {gain:.2f} times the best")
    caption = (
        f"{name}, float{64 if double else 32}, gain {gain:.2f} times the best one, prior 10 m, noise {noise:g} m: "
        f"P has a negative eigenvalue after {int(bad.sum())} of {len(low)} updates; so do {count} of 20 sequences."
    )
    return fig, {"negative": int(bad.sum()), "failures": count, "caption": caption}


def _expected(poses, l):
    """Expected measurements of all landmarks from all poses, shape (K, N, 2)."""
    return np.array([polar(Frame2(pose).to_frame(l)[0])[0] for pose in poses])


def _residual(y, e):
    z = y - e
    z[..., 1] = wrap(z[..., 1])
    return z
