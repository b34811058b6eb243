"""Drawings of notebook 20: the bug museum and its instruments."""

from __future__ import annotations

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np

from ...analysis.consistency import anees_band
from ...graphics import ESTIMATE, TRUTH, line, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREEN, GREY, LIGHT_GREY, ORANGE, PURPLE, VERMILLION
from .. import museum
from ..controls import Choice, Int
from ..exercises.nb20_quiz import LETTERS, PANELS
from ..museum_runs import RUNS, TESTS, bench, caught, mutant_case, readings, world
from ..widgets import explorable

HIDDEN = ("late", "twice", "not_wrapped", "right", "over_q", "mapping", "identity", "pose_only", "transposed",
          "not_squared", "no_heading", "swapped", "elementwise")  # fmt: skip
"""The order of the showcases whose label is covered."""


# ---- texts ---------------------------------------------------------------------------------------------------------


def catalogue():
    """The exhibits, their threads and years, as text."""
    rows = [f"{'exhibit':<28} {'year':<5} reported in"]
    for e in museum.EXHIBITS:
        rows.append(f"{e.name:<28} {e.year or '':<5} {e.thread or 'lectures and homework'}")
    return "\n".join(rows)


def readings_table():
    """What the instruments read for the eight panels, as text."""
    rows = [
        "          the whole filter, 20 runs           sensor covered      first sight, pose",
        "panel   RMSE [m]    NIS     NEES   P < 0     position  heading    known  uncertain",
    ]
    for letter, key in [*PANELS.items(), ("no bug", "right")]:
        r, b = readings(key), bench(key)
        rows.append(
            f"{letter:^7} {_short(r.rmse, 5):>7} {_short(r.mean_nis, 100):>7} {_short(r.mean_nees, 500):>8}"
            f" {r.broken:>5}     {_short(b.position):>9} {_short(b.heading):>8} {_short(b.first):>8}"
            f" {_short(b.first_lost):>10}"
        )
    honest = f"{'honest':^7} {'':>7} {'2':>7} {'3':>8} {'0':>5}     {'2':>9} {'1':>8} {'2':>8} {'2':>10}"
    return "\n".join([*rows, honest])


def answers_table():
    """Letters and names of the answers of exercise 20.1, as text."""
    return "\n".join(f"{letter}  {museum.BY_KEY[key].name}" for key, letter in LETTERS.items())


def _short(value, most=1000):
    """Three digits at most; what is beyond all bounds has none."""
    if not value <= most:
        return f"> {most}"
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2g}"


# ---- figures of the notebook ---------------------------------------------------------------------------------------


def panels_figure(panels=None):
    """NEES and NIS of the eight filters over time. Returns (fig, caption)."""
    panels = PANELS if panels is None else panels
    fig, axes = plt.subplots(2, 4, figsize=(12.6, 6.4), sharex=True, sharey=True, layout="constrained")
    for ax, (letter, key) in zip(axes.flat, panels.items(), strict=False):
        _over_time(ax, readings(key))
        ax.set_title(f"panel {letter}")
    axes[0, 0].set_ylabel("relative to honest")
    axes[1, 0].set_ylabel("relative to honest")
    for ax in axes[1]:
        ax.set_xlabel("time (s)")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    high = [letter for letter, key in panels.items() if readings(key).mean_nees > 10 * 3]
    return fig, (
        f"Mean of {RUNS} runs, two rounds. NEES more than ten times too high: {', '.join(high)}. NIS: "
        + ", ".join(f"{letter} {_short(readings(key).mean_nis, 100)}" for letter, key in panels.items())
        + " (honest: 2)."
    )


def _over_time(ax, r):
    """NEES and NIS over time, relative to their honest means."""
    t, every = np.arange(len(r.nees)) * world().dt, slice(None, None, 4)
    low, high = (np.array(anees_band(3, RUNS, 0.99)) / 3).tolist()
    ax.axhspan(low, high, color=GREEN, alpha=0.35, linewidth=0, label=f"99 % of honest means of {RUNS} runs (NEES)")
    ax.plot(t[every], np.clip(_mean(r.nees) / 3, 0.03, 3000)[every], color=BLUE, label="NEES / 3")
    nis = np.clip(_mean(r.nis) / 2, 0.03, 3000)
    style = dict(color=PURPLE, marker=".", linestyle="none", markersize=4)
    ax.plot(r.nis_frame[every] * world().dt, nis[every], **style, label="NIS / 2")
    ax.set(yscale="log", ylim=(0.02, 4000))
    ax.set_yticks([0.1, 1, 10, 100, 1000], ["0.1", "1", "10", "100", "1000"])
    ax.minorticks_off()


def _mean(a):
    """Mean over the runs of what is finite; NaN where nothing is."""
    finite = np.isfinite(a)
    return np.where(finite, a, 0).sum(-1) / np.where(finite.any(-1), finite.sum(-1), np.nan)


def planted_figure(planted):
    """NEES and NIS over time of filters of the notebook. Returns (fig, caption).

    Parameters
    ----------
    planted : dict of str to tuple
        By name: RMSE (m), NEES (frames, runs), NIS (sightings, runs) and the frames of the sightings.
    """
    fig, axes = plt.subplots(1, len(planted), figsize=(12.6, 4.2), sharey=True, layout="constrained")
    says = []
    for ax, (name, (_, nees, nis, frames)) in zip(axes, planted.items(), strict=True):
        _over_time(ax, SimpleNamespace(nees=nees, nis=nis, nis_frame=frames))
        ax.set(title=name, xlabel="time (s)", ylim=(0.1, 100))
        says.append(f"{name} {_short(float(nees.mean()), 500)} and {_short(float(nis.mean()), 100)}")
    axes[0].set_ylabel("relative to honest")
    fig.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return fig, f"Mean NEES (honest: 3) and mean NIS (honest: 2) of {nees.shape[1]} runs: {'; '.join(says)}."


def guard_figure(guard):
    """The difference that a guard returns, for six wrong predictions. Returns (fig, caption)."""
    names = {e.filter.predict.__name__: e.name for e in museum.EXHIBITS}
    fig, axes = plt.subplots(2, 3, figsize=(11.6, 7.4), layout="constrained")
    says, image = [], None
    for ax, (name, title) in zip(axes.flat, ((n, t) for n, t in names.items() if n != "predict"), strict=False):
        x, P, u, U = mutant_case()
        D = guard(getattr(museum, name), x, P, u, U)
        image = ax.imshow(D, cmap="PuOr_r", vmin=-6, vmax=6)
        wrong = np.abs(D) > 1e-5
        for i, j in np.argwhere(wrong):
            dark = np.abs(D[i, j]) > 3
            ax.text(j, i, f"{D[i, j]:+.1f}", ha="center", va="center", fontsize=11, color="white" if dark else BLACK)
        ax.axhline(2.5, color=BLACK, linewidth=1)
        ax.axvline(2.5, color=BLACK, linewidth=1)
        ax.set_xticks([1, 4.5], ["robot", "map"])
        ax.set_yticks([1, 4.5], ["robot", "map"], rotation=90, va="center")
        ax.tick_params(length=0)
        ax.grid(False)
        ax.set_title(title)
        says.append(f"{title}: {int(wrong.sum())}")
    assert image is not None
    fig.colorbar(image, ax=axes, label="P minus what it should be (m², rad m, rad²)", shrink=0.8, pad=0.02)
    return fig, "Wrong entries of P, of 49, after one prediction with two landmarks. " + "; ".join(says) + "."


def tests_figure():
    """Which test would have caught which exhibit. Returns (fig, caption)."""
    keys, tests = [e.key for e in museum.EXHIBITS], list(TESTS)
    M = np.array([[caught(key)[test] for test in tests] for key in keys])
    alarms = sum(caught("right").values())
    fig, ax = plt.subplots(figsize=(11.8, 6.6), layout="constrained")
    for i in range(0, len(keys), 2):
        ax.axhspan(i - 0.5, i + 0.5, color=LIGHT_GREY, alpha=0.4, linewidth=0)
    for hit, marker, color, size in ((True, "X", VERMILLION, 13), (False, ".", GREY, 5)):
        i, j = np.nonzero(M == hit)
        ax.plot(j, i, linestyle="none", marker=marker, color=color, markersize=size, markeredgewidth=0)
    ax.set(xlim=(-0.6, len(tests) - 0.4), ylim=(len(keys) - 0.4, -0.6))
    ax.set_yticks(range(len(keys)), [museum.BY_KEY[key].name for key in keys])
    ax.set_xticks(range(len(tests)), [f"{t}\n{n} of {len(keys)}" for t, n in zip(tests, M.sum(0), strict=True)])
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    plt.setp(ax.get_xticklabels(), rotation=35, ha="left")
    ax.plot([], [], "X", color=VERMILLION, markersize=12, markeredgewidth=0, label="caught: the test fails")
    ax.plot([], [], ".", color=GREY, label="the test passes: not seen")
    ax.legend(loc="upper center", bbox_to_anchor=(0.4, -0.01), ncols=2, frameon=False)
    ax.grid(False)
    ax.spines[:].set_visible(False)
    units = {"sensor covered", "first sight", "guard", "H", "seam"}
    only = [
        museum.BY_KEY[k].name
        for k, row in zip(keys, M, strict=True)
        if {t for t, h in zip(tests, row, strict=True) if h} <= units
    ]
    return fig, (
        f"Caught, of {len(keys)}: "
        + ", ".join(f"{t} {n}" for t, n in zip(tests, M.sum(0), strict=True))
        + f". Seen by a test of one part only: {', '.join(only)}. False alarms on the filter without a bug: {alarms}."
    )


# ---- the zoo -------------------------------------------------------------------------------------------------------


@explorable(
    exhibit=Choice("mapping", {e.name: e.key for e in museum.BY_KEY.values()}, label="exhibit"),
    case=Int(0, 0, len(HIDDEN), label="showcase without a name (0: none)"),
    ranges={"nis": (0, 1e7), "nees": (0, 1e8), "rmse_m": (0, 1e4)},
)
def zoo(exhibit, case):
    """One exhibit: its map, its errors over time, and what each instrument reads. A showcase hides which one it is."""
    for other in museum.BY_KEY:  # all of them at once, so that no later redraw has to wait
        readings(other)
        bench(other)
    key = HIDDEN[case - 1] if case else exhibit
    name = f"showcase {case}" if case else museum.BY_KEY[key].name
    r, b = readings(key), bench(key)
    fig = plt.figure(figsize=(12.2, 5.6))
    ax = fig.add_axes((0.055, 0.2, 0.35, 0.7))
    s = world()
    ax.plot(*s.points.T, **points(TRUTH), label="true landmarks")
    ax.plot(*r.truth[:, :2].T, **line(TRUTH, linewidth=1.2), label="true path")
    ax.plot(*np.clip(r.path[:, :2].T, -30, 30), **line(ESTIMATE, linewidth=1.2), label="path of the filter")
    l, B = r.x[3:].reshape(-1, 2), np.array([r.P[i : i + 2, i : i + 2] for i in range(3, len(r.x), 2)])
    drawn = np.isfinite(B).all((1, 2)) & (np.abs(l).max(1) < 30)
    drawn[drawn] = np.linalg.eigvalsh(B[drawn])[:, 0] > 0
    if drawn.any():
        plot_ellipse(ax, l[drawn], B[drawn], 3, color=BLUE, linewidth=1.2, zorder=4, label=sigma_label(3))
    ax.plot(*np.clip(l, -30, 30).T, **points(ESTIMATE, markersize=4))
    ax.set(xlim=(-10.5, 10.5), ylim=(-10.5, 10.5), xticks=range(-10, 11, 5), yticks=range(-10, 11, 5))
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", title="run 1 of 20")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, fontsize=11, frameon=False)
    _dials(fig.add_axes((0.47, 0.13, 0.5, 0.76)), r, b)
    fig.suptitle(name if case else f"{name}: {museum.BY_KEY[key].label}", y=0.985)
    caption = (
        f"{name[0].upper()}{name[1:]}: RMSE {_short(r.rmse, 5)} m; NIS {_short(r.mean_nis, 100)} (honest: 2); NEES "
        f"{_short(r.mean_nees, 500)} (3); P < 0 in {r.broken} of {RUNS} runs. Sensor covered: position "
        f"{_short(b.position)} (2), heading {_short(b.heading)} (1). First sight: pose known {_short(b.first)} (2), "
        f"uncertain {_short(b.first_lost)} (2)."
    )
    return fig, {"nis": r.mean_nis, "nees": r.mean_nees, "rmse_m": r.rmse, "caption": caption}


def _dials(ax, r, b):
    """The readings relative to their honest values on a logarithmic scale."""
    rows = (
        ("NEES of the pose", min(r.mean_nees, 1e4), 3, anees_band(3, RUNS, 0.999)),
        ("NIS", r.mean_nis, 2, r.meter.nis_band),
        ("sensor covered: NEES of position", b.position, 2, anees_band(2, 400, 0.999)),
        ("sensor covered: NEES of heading", b.heading, 1, anees_band(1, 400, 0.999)),
        ("first sight, pose known: NEES of landmark", b.first, 2, anees_band(2, 400, 0.999)),
        ("first sight, pose uncertain: NEES of landmark", b.first_lost, 2, anees_band(2, 400, 0.999)),
    )
    low, high = 0.008, 1200.0
    for y, (name, value, honest, band) in zip(range(len(rows), 0, -1), rows, strict=True):
        ax.plot([low, high], [y, y], color=LIGHT_GREY, linewidth=11, solid_capstyle="round", zorder=1)
        green = min(band[0] / honest, 0.93), max(band[1] / honest, 1.07)  # at least as wide as can be seen
        ax.plot(green, [y, y], color=GREEN, linewidth=11, solid_capstyle="butt", zorder=2)
        at = np.clip(np.nan_to_num(value / honest, nan=high), low, high)
        ax.plot(at, y, "D", color=BLACK, markersize=11, markerfacecolor=ORANGE, zorder=3)
        ax.text(low, y + 0.28, f"{name}: {_short(value)} (honest: {honest})", fontsize=13)
    ax.text(low, 0.3, f"RMSE {_short(r.rmse, 5)} m      P < 0 in {r.broken} of {RUNS} runs", fontsize=13)
    ax.set(xscale="log", xlim=(0.005, 2000), ylim=(0.0, 6.7), xlabel="reading / honest reading; green: 99.9 % band")
    ax.set_xticks([0.01, 0.1, 1, 10, 100, 1000], ["0.01", "0.1", "1", "10", "100", "1000"])
    ax.minorticks_off()
    ax.grid(False)
    ax.yaxis.set_visible(False)
    ax.spines["left"].set_visible(False)
