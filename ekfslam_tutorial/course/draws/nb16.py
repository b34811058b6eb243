"""Drawings of notebook 16: the entry points of a sensor, a beacon in the loop, hypotheses on a ring."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

from ...graphics import ESTIMATE, TRUTH, line, plot_ellipse, points
from ...graphics.style import BLACK, BLUE, GREEN, GREY, LIGHT_GREY, VERMILLION
from ..controls import Choice, Int, Toggle
from ..widgets import explorable
from .nb16_runs import (
    METHODS,
    NEAR,
    RANGES,
    STD,
    Runs,
    correct_ring,
    entry_points,
    passes,
    places,
    start_ring,
    verdict,
)

__all__ = ["NEAR", "RANGES", "STD", "Runs", "entry_points", "passes", "verdict"]

COLUMNS = ("read user data", "simulate", "correct known", "start new")
MEANING = {
    "R": "R\nnoise",
    "project": "project\ny = h(p)",
    "residual": "residual\ny - e",
    "visible": "visible\nwhat it sees",
    "retro": "retro\nback to a point",
}


# ---- entry points ---------------------------------------------------------------------------------------------------


def entry_figure(filled):
    """Which method was called in which part of the loop, and where the run stopped. Returns (fig, caption)."""
    calls, stop = entry_points(filled)
    fig, ax = plt.subplots(figsize=(11, 5.4), layout="constrained")
    for i, method in enumerate(METHODS):
        done = method in filled
        ax.text(-1.3, i, ("\u2713 " if done else "\u2026 ") + MEANING[method], fontsize=14, va="center", ma="left",
                color=BLACK if done else GREY)  # fmt: skip
        for j, column in enumerate(COLUMNS):
            n = calls[method, column]
            face, text, color = ("white", "", GREY) if not n else (GREEN, f"{n}", BLACK)
            if stop == (method, column):
                face, text, color = VERMILLION, "\u2717 stops here", "white"
            ax.add_patch(Rectangle((j - 0.46, i - 0.4), 0.92, 0.8, facecolor=face, edgecolor=GREY, alpha=0.85))
            ax.text(j, i, text, fontsize=14, ha="center", va="center", color=color, weight="bold")
    ax.set(xlim=(-1.35, 3.5), ylim=(4.5, -0.5), yticks=[])
    ax.set_xticks(range(4), COLUMNS)
    ax.xaxis.tick_top()
    ax.tick_params(length=0, labelsize=14)
    ax.grid(False)
    for side in ax.spines.values():
        side.set_visible(False)
    n, written = len(filled), f"Written: {', '.join(filled) or 'nothing'}."
    if stop is None:
        return fig, f"{written} The run of 3 frames ends. Each number counts the calls in that part of the loop."
    return fig, f"{written} The run stops in `{stop[0]}`, in the part '{stop[1]}'. ({n} of {len(METHODS)} methods.)"


@explorable(
    R=Toggle(False, label="R is written"),
    project=Toggle(False, label="project is written"),
    residual=Toggle(False, label="residual is written"),
    visible=Toggle(False, label="visible is written"),
    retro=Toggle(False, label="retro is written"),
    ranges={"written": (0, 5), "runs": (0, 1)},
)
def checklist(R, project, residual, visible, retro):
    """A sensor with some of its methods: where does the run stop?"""
    ticks = dict(R=R, project=project, residual=residual, visible=visible, retro=retro)
    filled = tuple(name for name in METHODS if ticks[name])
    fig, caption = entry_figure(filled)
    return fig, {"written": len(filled), "runs": float("The run of" in caption), "caption": caption}


# ---- runs -----------------------------------------------------------------------------------------------------------


def honesty_figure(runs):
    """Position errors and NEES of several sets of runs: {name: Runs}. Returns (fig, caption)."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(11.5, 4.4), layout="constrained", sharey=True)
    rows = np.arange(len(runs))[::-1]
    for y, r in zip(rows, runs.values(), strict=True):
        spread = y + np.linspace(-0.22, 0.22, len(r.off))
        left.plot(r.off, spread, ".", color=GREY, markersize=7)
        left.plot(r.rms, y, marker="D", color=BLUE, markersize=11, linestyle="none")
        right.plot(r.nees, spread, ".", color=GREY, markersize=7)
        inside = r.band[0] <= r.anees <= r.band[1]
        right.plot(r.anees, y, marker="D" if inside else "X", color=BLUE if inside else VERMILLION, markersize=12)
        right.plot(r.band, [y - 0.36] * 2, color=GREEN, linewidth=7, solid_capstyle="butt")
    first = next(iter(runs.values()))
    left.set(xlabel="position error at the end (m)", xlim=(0, None), ylim=(-0.6, len(runs) - 0.4))
    left.set_yticks(rows, list(runs))
    right.set(xlabel=f"NEES at the end, {first.dof} dof (-)", xscale="log")
    ticks = [t for t in (0.1, 0.3, 1, 3, 10, 30, 100) if right.get_xlim()[0] < t < right.get_xlim()[1]]
    right.set_xticks(ticks, [f"{t:g}" for t in ticks])
    right.minorticks_off()
    low, high = first.band
    right.plot([], [], color=GREEN, linewidth=7, label=f"99.9 % band of the mean: {low:.1f} to {high:.1f}")
    right.plot([], [], "D", color=BLUE, label="mean (left: RMS)")
    right.plot([], [], ".", color=GREY, label="one run")
    fig.legend(handles=right.get_legend_handles_labels()[0], loc="outside lower center", ncols=3)
    return fig, " ".join(f"{name.replace(chr(10), ' ')}: {r}." for name, r in runs.items())


# ---- hypotheses -----------------------------------------------------------------------------------------------------


@explorable(
    k=Int(RANGES, 1, RANGES, label="ranges so far", play=250),
    way=Choice("straight", ["straight", "curve"], label="way of the robot"),
    H=Choice(24, {"1": 1, "4": 4, "8": 8, "24": 24}, label="hypotheses"),
    number=Int(3, 0, 9, label="beacon number"),
    ranges={"off": (0, 30), "weight": (0, 1.000001), "alive": (1, 24)},
)
def ring(k, way, H, number):
    """Hypotheses for the place of a beacon, from ranges alone; and the exact answer as a shade."""
    x, truth, y = passes(10, way)
    truth, y = truth[number], y[number]
    w, m, P = start_ring(x[0], y[0], H)
    for i in range(1, k):
        w, m, P = correct_ring(w, m, P, x[i], y[i])
    fig, ax = plt.subplots(figsize=(10.5, 6.4), layout="constrained")
    u = np.linspace(-7.5, 7.5, 181)
    gx, gy = np.meshgrid(u, u)
    log = np.sum([-((y[i] - np.hypot(gx - x[i, 0], gy - x[i, 1])) ** 2) / (2 * STD**2) for i in range(k)], axis=0)
    soft = np.exp(np.clip((log - log.max()) / 4, -30, 0))  # doubled width, so that it can be seen beside the ellipses
    ax.contourf(gx, gy, soft, levels=[0.1, 0.4, 0.8, 1.01], cmap="Greys", alpha=0.5)
    ax.fill([], [], color=GREY, alpha=0.6, label="exact answer (shade)")
    for wi, mi, Pi in zip(w, m, P, strict=True):
        share = float(wi / w.max())
        plot_ellipse(ax, mi, Pi, 3, **line(ESTIMATE, linewidth=0.7 + 2.2 * share, alpha=0.25 + 0.75 * share))
    ax.plot([], [], **line(ESTIMATE, linewidth=2.5), label="hypothesis, 3σ (98.9 %);\nthicker: more weight")
    ax.plot(*x[:, :2].T, color=LIGHT_GREY, linewidth=3)
    ax.plot(*x[:k, :2].T, color=BLACK, linewidth=2.5, marker="o", markersize=3.5, label="robot, known poses")
    ax.plot(*truth, **points(TRUTH, markersize=15), label="beacon, true")
    ax.set(xlim=(-7.5, 7.5), ylim=(-7.5, 7.5), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=12)
    heavy = sorted(((*p - x[0, :2], weight) for p, weight in places(w, m) if weight > 0.1), key=_angle)
    for i, (dx, dy, weight) in enumerate(heavy):  # neighbours on the ring: one number outside, the next one inside
        away = (1 if i % 2 == 0 else -1) * 32 * np.array([dx, dy]) / np.hypot(dx, dy)
        place = x[0, 0] + dx, x[0, 1] + dy
        ax.annotate(f"{100 * weight:.0f} %", place, away, textcoords="offset points", fontsize=14, color=BLUE,
                    ha="center", va="center")  # fmt: skip
    off, weight = verdict(w, m, truth)
    decided = "that would decide" if weight > 0.99 else "not decided"
    caption = (
        f"{k} ranges, {way}: {len(w)} of {H} hypotheses alive. The best is {off:.2g} m off; within 0.5 m of it lies "
        f"{100 * weight:.0f} % of the weight: {decided}."
    )
    return fig, {"off": off, "weight": weight, "alive": len(w), "caption": caption}


def _angle(item) -> float:
    """The direction of [dx, dy, ...]."""
    return float(np.arctan2(item[1], item[0]))


def table_figure(rows):
    """How often the ranges alone find the beacon: rows of (way, H, share right, share decided, wrong but decided)."""
    fig, axes = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True, layout="constrained")
    for ax, way in zip(axes, ("straight", "curve"), strict=True):
        mine = [row for row in rows if row[0] == way]
        at = np.arange(len(mine))
        good = np.array([100 * row[2] for row in mine])
        bad = np.array([100 * row[3] for row in mine])
        ax.bar(at, good, color=BLUE, label="decided, and right")
        ax.bar(at, bad, bottom=good, color=VERMILLION, hatch="xx", edgecolor="white", label="decided, and wrong")
        ax.bar(at, 100 - good - bad, bottom=good + bad, color=LIGHT_GREY, hatch="..", edgecolor="white",
               label="not decided")  # fmt: skip
        ax.set_xticks(at, [str(row[1]) for row in mine])
        ax.set(title=way, xlabel="hypotheses at the start", ylim=(0, 100))
        ax.grid(False)
    axes[0].set_ylabel("share of the runs (%)")
    handles, names = axes[0].get_legend_handles_labels()
    fig.legend(handles, names, loc="outside lower center", ncols=3)
    text = "; ".join(f"{w}, {H}: {100 * g:.0f} % right, {100 * b:.0f} % wrong" for w, H, g, b in rows)
    return fig, f"Decided: 99 % of the weight within 0.5 m of the best. {text}."
