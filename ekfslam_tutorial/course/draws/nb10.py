"""Drawings of notebook 10: frames, quaternions, the chain rule."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from ...analysis import anees_band, chi2_band
from ...geometry import Frame3, e2q, q2R, unit, v2q
from ...graphics import ESTIMATE, MEASUREMENT, REJECTED, TRUTH, line, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable
from .nb10_runs import (
    BOTH,
    DIRECTIONS,
    GYRO,
    NEVER,
    RATE,
    RUNS,
    SIGHT,
    STEPS,
    VALUE,
    judged,
    slerp,
)
from .space import Space

__all__ = ["BOTH", "DIRECTIONS", "GYRO", "NEVER", "RATE", "SIGHT", "VALUE", "judged"]

WORLD = Frame3(np.eye(7)[3])
POINT = np.array([3.2, 2.6, 1.9])


def frame(x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0) -> Frame3:
    """A frame from a position in metres and Euler angles in degrees."""
    return Frame3(np.concatenate([[x, y, z], e2q(np.radians([roll, pitch, yaw]))[0]]))


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def tree_figure(Rf, Sf, p):
    """World, robot, camera and a point: who is given in whom. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10, 5.6), layout="constrained")
    space = Space(ax, ((-1.6, 5.6), (-1.1, 2.9)), azim=-68, elev=22)
    space.ground(6)
    Cf = Rf.compose(Sf)[0]
    space.gizmo(WORLD, 0.9, "world")
    space.gizmo(Rf, 0.7, "robot")
    space.gizmo(Cf, 0.7)
    space.text(Cf.t, "camera", fontsize=14, xytext=(-28, 26))
    space.line([WORLD.t, Rf.t], color=BLUE, linestyle="--", label="Rf: robot in the world")
    space.line([Rf.t, Cf.t], color=PURPLE, linestyle=":", linewidth=3, label="Sf: camera in the robot")
    space.line([Cf.t, p], **line(MEASUREMENT, linewidth=2.2), label="ps: point in the camera")
    space.line(p, **points(TRUTH, markersize=16), label="p: point in the world")
    ax.legend(loc="upper left", frameon=False)
    pr = Rf.to_frame(p)[0]
    ps = Sf.to_frame(pr)[0]
    words = (f"({', '.join(f'{v + 0.0:.1f}' for v in np.round(x, 6))})" for x in (p, pr, ps))
    return fig, "One point, three times three numbers: {} in the world, {} in the robot, {} in the camera, m.".format(
        *words
    )


def nees_figure(tangent, seven, flipped):
    """NEES of many poses: six numbers; seven numbers; seven numbers, q with the other sign. Returns (fig, caption)."""
    fig, ax = plt.subplots(figsize=(10, 4.6), layout="constrained")
    bins = np.geomspace(0.3, 1e8, 60).tolist()
    looks = ((tangent, BLUE, "six numbers, tangent space"), (seven, ORANGE, "seven numbers, same sign of q"),
             (flipped, VERMILLION, "seven numbers, other sign of q"))  # fmt: skip
    for (values, color, name), fill, dash in zip(looks, (0.55, 0.0, 0.0), ("-", "--", "-."), strict=True):
        ax.hist(values, bins, histtype="stepfilled", facecolor=(color, fill), edgecolor=color, linewidth=2.2,
                linestyle=dash, label=name)  # fmt: skip
    low, high = chi2_band(6, 0.99)
    ax.axvspan(low, high, color=GREEN, alpha=0.25, linewidth=0, label=f"99 % of honest errors, {low:.1f} to {high:.0f}")
    ax.set(xscale="log", xlabel="squared error, weighted with the inverse of P (NEES)", ylabel="poses")
    ax.set_ylim(0, 1.3 * np.histogram(tangent, bins)[0].max())  # the other sign, one narrow peak, goes on above
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, frameon=False)
    return fig, (
        f"{len(tangent)} poses drawn from their own covariance. Median NEES with six numbers {np.median(tangent):.1f}, "
        f"inside the 99 % band {100 * np.mean((tangent > low) & (tangent < high)):.0f} %. With seven numbers and a P "
        f"made invertible: {np.median(seven):.0f}; with the other sign of q: {np.median(flipped):.1e}."
    )


# ---- widgets --------------------------------------------------------------------------------------------------------

FORMULAS = {
    "R' (p - t)": lambda F, p: F.R.T @ (p - F.t),
    "R p + t": lambda F, p: F.R @ p + F.t,
    "R (p - t)": lambda F, p: F.R @ (p - F.t),
    "R' p - t": lambda F, p: F.R.T @ p - F.t,
}


@explorable(
    formula=Choice("R (p - t)", list(FORMULAS), "pf ="),
    x=Float(1.5, -1.0, 3.0, 0.25, "frame, x", "m"),
    yaw=Float(-20.0, -180.0, 180.0, 10.0, "yaw", "deg"),
    pitch=Float(-20.0, -80.0, 80.0, 10.0, "pitch", "deg"),
    ranges={"off": (0, 20)},
)
def gizmos(formula, x, yaw, pitch):
    """Four formulas for the point seen from the frame: draw their numbers along the axes of the frame."""
    F = frame(x, 0.0, 0.8, 0.0, pitch, yaw)
    pf = FORMULAS[formula](F, POINT)
    back = F.from_frame(pf)[0]
    off = float(np.linalg.norm(back - POINT))
    right = off < 1e-9
    fig, ax = plt.subplots(figsize=(10.5, 5.8), layout="constrained")
    space = Space(ax, ((-4.6, 5.6), (-2.4, 3.4)), azim=-65, elev=24)
    space.ground(5)
    space.gizmo(WORLD, 1.2, "world")
    space.gizmo(F, 1.2, "F")
    steps = np.array(F.t) + np.vstack([np.zeros(3), np.cumsum(F.R * pf, axis=1).T])
    look = ESTIMATE if right else REJECTED
    space.line(steps, **line(MEASUREMENT, linewidth=2.4), label="pf, laid along the axes of F")
    space.line(POINT, **points(TRUTH, markersize=18), label="the point p")
    space.line(back, **points(look, markersize=9), label="where pf says it is")
    ax.legend(loc="upper left", frameon=False)
    lamp = "right: it lands on the point" if right else f"wrong: it lands {off:.1f} m away"
    ax.set_title(f"pf = {formula}     {lamp}", loc="left", color=BLACK if right else VERMILLION)
    n = ", ".join(f"{v + 0.0:.1f}" for v in pf)
    caption = f"F at x = {x:g} m, yaw {yaw:.0f} and pitch {pitch:.0f} deg. pf = {formula} = ({n}) m is {lamp}."
    return fig, {"off": off, "caption": caption}


@explorable(
    yaw=Float(90.0, -180.0, 180.0, 10.0, "turn (yaw) of A", "deg"),
    ahead=Float(2.0, 0.0, 3.0, 0.25, "step ahead of B", "m"),
    roll=Float(60.0, -180.0, 180.0, 10.0, "roll of B", "deg"),
    ranges={"apart": (0, 7), "angle": (0, 180.001)},
)
def two_orders(yaw, ahead, roll):
    """A, then B in A; and B, then A in B."""
    A, B = frame(0.5, 0, 0.6, yaw=yaw), frame(ahead, 0, 0, roll=roll)
    results = {"A B": A.compose(B)[0], "B A": B.compose(A)[0]}
    fig, axes = plt.subplots(1, 2, figsize=(11.5, 5.0), layout="constrained")
    for ax, (name, F) in zip(axes, results.items(), strict=True):
        first = A if name == "A B" else B
        space = Space(
            ax, ((-3.4, 3.8), (-2.2, 3.0)), azim=-60, elev=28, title=f"{name}: {name[2]} is given in {name[0]}"
        )
        space.ground(4)
        space.gizmo(WORLD, 0.8, "world", color=GREY)
        space.gizmo(first, 1.0, linestyle="--", linewidth=1.8)
        space.name(first, name[0], avoid=(WORLD.t, F.t))
        space.gizmo(F, 1.3, linewidth=3.4)
        space.name(F, name, 16, avoid=(first.t,), weight="bold")
        space.line([WORLD.t, first.t, F.t], color=BLACK, linestyle=":")
    e, _ = results["A B"].minus(results["B A"])
    apart, angle = float(np.linalg.norm(e[:3])), float(np.degrees(np.linalg.norm(e[3:])))
    caption = (
        f"A turns by {yaw:.0f} deg, B steps {ahead:g} m ahead and rolls by {roll:.0f} deg. A B and B A are "
        f"{apart:.1f} m and {angle:.0f} deg apart."
    )
    return fig, {"apart": apart, "angle": angle, "caption": caption}


@explorable(
    s=Float(0.5, 0.0, 1.0, 0.05, "part of the way", tip="0: first orientation, 1: second"),
    angle=Float(140.0, 10.0, 350.0, 10.0, "angle between", "deg"),
    flip=Toggle(False, "take -q instead of q for the second"),
    ranges={"norm": (0, 1.001), "turned": (0, 360)},
)
def ball(s, angle, flip):
    """Between two orientations: slerp, and the straight line through the inside of the ball."""
    u = unit(np.array([0.3, -0.2, 1.0]))[0]
    q0 = np.array([1.0, 0, 0, 0])
    q1 = v2q(np.radians(angle) * u)[0] * (-1 if flip else 1)
    nose = np.array([1.0, 0, 0])
    way = np.array([q2R(slerp(q0, q1, t))[0] @ nose for t in np.linspace(0, 1, 61)])
    q, straight = slerp(q0, q1, s), (1 - s) * q0 + s * q1
    norm = float(np.linalg.norm(straight))
    fig = plt.figure(figsize=(11, 5.2))
    space = Space(fig.add_axes((0.0, 0.02, 0.5, 0.9)), ((-1.6, 1.6), (-1.4, 1.5)), azim=-35, elev=32)
    a = np.linspace(0, 2 * np.pi, 61)
    circles = [np.stack([np.cos(a), np.sin(a), 0 * a], -1), np.stack([np.cos(a), 0 * a, np.sin(a)], -1)]
    space.curves([*circles, np.stack([0 * a, np.cos(a), np.sin(a)], -1)], color=GREY, linewidth=0.8)
    space.line(way, color=BLUE, linewidth=3, label="path of the nose (slerp)")
    for q_end, name in ((q0, "first"), (q1, "second")):
        tip = q2R(q_end)[0] @ nose
        space.line(tip, marker="s", color=BLACK, markersize=9, linestyle="none")
        space.text(tip, name, xytext=(10, 4) if name == "second" else (10, -16))
    space.gizmo(Frame3(np.r_[0, 0, 0, q]), 0.7)
    space.line(q2R(q)[0] @ nose, **points(ESTIMATE, markersize=12), label="nose now")
    space.ax.legend(loc="lower left", frameon=False)

    ax = fig.add_axes((0.6, 0.14, 0.38, 0.76))
    t = np.linspace(0, 1, 101)
    norms = np.linalg.norm((1 - t)[:, None] * q0 + t[:, None] * q1, axis=1)
    ax.plot(t, np.ones_like(t), color=BLUE, label="slerp: norm 1")
    ax.plot(t, norms, color=VERMILLION, linestyle="--", label="(1 - s) q0 + s q1")
    ax.plot(s, norm, **points(REJECTED, markersize=12))
    ax.set(xlabel="part s of the way", ylabel="norm of the quaternion", ylim=(0, 1.1), xlim=(0, 1))
    ax.legend(loc="lower left")
    turned = 2 * np.degrees(np.arctan2(np.linalg.norm(slerp(q0, q1, 1.0)[1:]), slerp(q0, q1, 1.0)[0]))
    same = "-q" if flip else "q"
    caption = (
        f"The second orientation, written as {same}, is {angle:.0f} deg away. Slerp turns by {turned:.0f} deg to "
        f"reach it. At s = {s:g} the straight mean of the quaternions has the norm {norm:.2f}."
    )
    return fig, {"norm": norm, "turned": float(turned), "caption": caption}


@explorable(
    mode=Choice(NEVER, [NEVER, VALUE, BOTH], "normalise"),
    prior=Float(30.0, 5.0, 60.0, 5.0, "first sigma of the attitude", "deg"),
    seed=Int(0, 0, 9, label="run"),
    run=True,
    ranges={"norm": (0.3, 3), "along": (0, 2)},
)
def norm_drift(attitude, mode, prior, seed):
    """An attitude filter of the notebook, attitude(mode, prior, seed): what becomes of the norm, and of P along q?"""
    all_runs = judged(attitude, mode, prior)
    one = all_runs[seed]
    k = np.arange(1, STEPS + 1)
    fig, axes = plt.subplots(1, 3, figsize=(12.5, 4.3), layout="constrained")
    axes[0].plot(k, all_runs[:10, :, 0].T, color=GREY, linewidth=0.8)
    axes[0].plot(k, one[:, 0], color=BLUE, linewidth=2.6, label=f"run {seed}")
    axes[0].axhline(1, color=BLACK, linestyle="--", linewidth=1, label="must be 1")
    axes[0].set(ylabel="norm of q", ylim=(0.9, 1.25) if all_runs[:10, :, 0].max() < 1.25 else None)
    axes[0].legend(loc="upper right")
    along = np.maximum(one[:, 1], 1e-9)
    axes[1].semilogy(k, along, color=ORANGE, linewidth=2.6)
    axes[1].set(ylabel="sigma that P has along q", ylim=(3e-10, 1))
    mean = all_runs[:, :, 2].mean(0)
    low, high = anees_band(3, RUNS)
    axes[2].axhspan(low, high, color=GREEN, alpha=0.35, linewidth=0, label="95 % band, honest")
    axes[2].semilogy(k, mean, color=VERMILLION, linewidth=2.2, label=f"mean of {RUNS} runs")
    axes[2].set(ylabel="NEES of the attitude, 3 dof", ylim=(1, 300))
    axes[2].legend(loc="upper right")
    for ax in axes:
        ax.set_xlabel("step")
    norm, along = float(one[-1, 0]), float(one[-1, 1])
    fig.suptitle(f"normalise: {mode}", x=0.01, ha="left")
    caption = (
        f"Normalise {mode}, first sigma {prior:.0f} deg. Run {seed} ends with the norm {norm:.3f} and a sigma of "
        f"{f'{along:.1g}' if along > 1e-6 else '0'} along q. Mean NEES of {RUNS} runs: {mean[:20].mean():.1f} in the "
        f"first 20 steps, {mean[20:].mean():.1f} in the others; honest is 3."
    )
    return fig, {"norm": norm, "along": along, "caption": caption}


# ---- the chain, as blocks ------------------------------------------------------------------------------------------

CHAIN = (("p", 3, "to_frame", "r"), ("pr", 3, "to_frame", "s"), ("ps", 3, "project", ""), ("up", 2, "distort", "d"),
         ("ud", 2, "pixellise", "k"), ("u", 2, "", ""))  # fmt: skip
NAMES = [name for name, *_ in CHAIN]
SIZES = {name: size for name, size, *_ in CHAIN} | {"r": 7, "s": 7, "d": 2, "k": 4}
PARAMETERS = {"r": 0, "s": 1, "d": 3, "k": 4}  # the block that each parameter enters


def factors(out: str, by: str) -> list[str]:
    """Names of the Jacobians whose product is the derivative of `out` by `by`; none if it does not depend on it."""
    first = PARAMETERS[by] if by in PARAMETERS else NAMES.index(by)
    last = NAMES.index(out)
    names = [f"{b.upper()}_{a}" for a, b in zip(NAMES[:last], NAMES[1 : last + 1], strict=True)][first:]
    if by in PARAMETERS and names:
        names[0] = f"{names[0].split('_')[0]}_{by}"
    return names[::-1]


@explorable(
    out=Choice("u", NAMES[1:], "derivative of"),
    by=Choice(
        "r", {"Rf.x (r)": "r", "Sf.x (s)": "s", "d": "d", "k": "k", "p": "p", "pr": "pr", "ps": "ps"}, "derivative by"
    ),
    ranges={"factors": (0, 5)},
)
def blocks(out, by):
    """The observation chain of a camera: which blocks lie on the way, which Jacobians are multiplied?"""
    chain = factors(out, by) if by != out else []
    fig, ax = plt.subplots(figsize=(12.5, 4.0), layout="constrained")
    ax.set(xlim=(-0.7, 11.4), ylim=(-1.9, 1.9))
    ax.set_axis_off()
    on = {name.split("_")[0].lower() for name in chain}
    for i, (name, size, block, parameter) in enumerate(CHAIN):
        x, used = 2.15 * i, i + 1 < len(CHAIN) and NAMES[i + 1] in on
        marked = name in (out, by)
        ax.text(x, 0, f"{name}\n({size})", ha="center", va="center", fontsize=15, weight="bold" if marked else "normal",
                color=VERMILLION if name == out else (BLUE if name == by else BLACK))  # fmt: skip
        if not block:
            continue
        box = FancyBboxPatch((x + 0.53, -0.38), 1.1, 0.76, boxstyle="round,pad=0.04")
        box.set(facecolor="#DDEEFB" if used else "white", edgecolor=BLUE if used else GREY, lw=2.4 if used else 1)
        ax.add_patch(box)
        ax.text(x + 1.08, 0, block, ha="center", va="center", fontsize=12.5)
        for a, b in ((x + 0.25, x + 0.47), (x + 1.7, x + 1.92)):
            ax.add_patch(FancyArrowPatch((a, 0), (b, 0), arrowstyle="-|>", mutation_scale=11, color=BLACK, shrinkA=0,
                                         shrinkB=0))  # fmt: skip
        if parameter:
            hit = parameter == by
            label = {"r": "Rf.x", "s": "Sf.x"}.get(parameter, parameter)
            ax.text(x + 1.08, 1.25, f"{label} ({SIZES[parameter]})", ha="center", fontsize=14,
                    color=BLUE if hit else BLACK, weight="bold" if hit else "normal")  # fmt: skip
            ax.add_patch(FancyArrowPatch((x + 1.08, 1.15), (x + 1.08, 0.5), arrowstyle="-|>", mutation_scale=11,
                                         color=BLUE if hit else GREY, shrinkA=0, shrinkB=0))  # fmt: skip
    rows, cols = SIZES[out], SIZES[by]
    whole = f"{out.upper()}_{by}"
    shape = lambda n: f"({SIZES[n.split('_')[0].lower()]}, {SIZES[n.split('_')[1]]})"
    if chain:
        says = f"{whole} = {' '.join(chain)}"
        sizes = f"({rows}, {cols}) = {' '.join(shape(n) for n in chain)}"
    else:
        says = f"{whole} = {'I' if out == by else '0'}"
        sizes = "a thing by itself" if out == by else f"{by} comes in behind {out}: it has no influence"
    ax.text(5.4, -1.05, says, ha="center", fontsize=19)
    ax.text(5.4, -1.65, sizes, ha="center", fontsize=14, color="#555555")
    return fig, {"factors": len(chain), "caption": f"{says}; shapes: {sizes}." if chain else f"{says}: {sizes}."}
