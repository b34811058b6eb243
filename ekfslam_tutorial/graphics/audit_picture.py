"""The picture of an audit: NEES over time, coverage, each axis, and the findings beside their bands."""

import matplotlib.pyplot as plt
import numpy as np

from ..ekf import chi_square
from .panels import consistency_panel
from .style import BLUE, ESTIMATE, GREY, LIGHT_GREY, REJECTED, TRUTH, line, points

NAMES = {2: ["x", "y", "heading"], 3: ["x", "y", "z", "rot. x", "rot. y", "rot. z"]}


def audit_picture(found):
    """Draw an audit.

    Parameters
    ----------
    found : analysis.audit.Audit

    Returns
    -------
    matplotlib Figure
        Above the mean NEES of the poses over time with the band of an honest estimator. Below, how many poses are
        inside the regions that should hold a given share; the mean square of each error over its variance; and the
        findings with their 95 % bands.
    """
    fig = plt.figure(figsize=(12.5, 8.6), layout="constrained")
    grid = fig.add_gridspec(2, 3, height_ratios=[1.1, 1.0])
    _over_time(fig.add_subplot(grid[0, :]), found)
    _coverage(fig.add_subplot(grid[1, 0]), found)
    _axes(fig.add_subplot(grid[1, 1]), found)
    _findings(fig.add_subplot(grid[1, 2]), found)
    runs = len(found.runs)
    fig.suptitle(f"{runs} run{'s' * (runs > 1)}: {found.sentence}")
    return fig


def _over_time(ax, found):
    """Mean NEES over the runs, where all have the same number of poses; else of each run by itself."""
    runs = found.runs
    if len({len(run.t) for run in runs}) == 1:
        t, values = runs[0].t - runs[0].t[0], np.array([run.nees for run in runs])
        n = np.isfinite(values).sum(0)
        mean = np.where(n > 0, np.nansum(values, 0) / np.maximum(n, 1), np.nan)
        name = "NEES of the pose" + f", mean of {len(runs)} runs" * (len(runs) > 1)
        consistency_panel(t, mean, runs[0].e.shape[1], np.maximum(n, 1), name=name, ax=ax)
        ax.set_xlabel("t (s)")
        return
    for run in runs:
        ax.plot(run.t - run.t[0], run.nees, color=BLUE, linewidth=0.8, alpha=0.6)
    ax.axhline(runs[0].e.shape[1], **line(TRUTH), label="mean of an honest estimator")
    ax.set(xlabel="t (s)", ylabel="NEES of the pose (-)")
    ax.legend(loc="upper left", bbox_to_anchor=(0, 1.12), frameon=False)


def _coverage(ax, found):
    """Share of the poses inside regions of all sizes, against the share that they should hold."""
    nees = np.concatenate([run.nees for run in found.runs])
    nees = np.sort(nees[np.isfinite(nees)])
    ax.plot([0, 100], [0, 100], **line(TRUTH), label="honest")
    if len(nees):
        held = chi_square.cdf(nees, found.runs[0].e.shape[1])
        ax.plot(100 * held, 100 * np.arange(1, len(nees) + 1) / len(nees), **line(ESTIMATE), label="found")
    ax.set(xlabel="a region should hold (%)", ylabel="it holds (%)", xlim=(0, 100), ylim=(0, 100), aspect="equal")
    ax.legend(loc="upper left")


def _axes(ax, found):
    """Mean square of each error, over what its covariance says."""
    names = NAMES[found.runs[0].dim]
    ax.bar(range(len(names)), np.nan_to_num(found.per_axis), color=BLUE, width=0.6)
    ax.axhline(1, **line(TRUTH))
    ax.set_xticks(range(len(names)), names, rotation=30 if len(names) > 3 else 0)
    ax.set(ylabel="mean square / variance (-)", ylim=(0, 1.15 * max(2.0, np.nanmax([*found.per_axis, 1.0]))))
    ax.grid(axis="x", visible=False)


def _findings(ax, found):
    """Each finding, with the band that an honest estimator has."""
    parts = {n: p for n in ("pose", "position", "rotation", "map", "innovations") if (p := getattr(found, n)).runs}
    for k, part in enumerate(parts.values()):
        label = f"{100 * found.level:.3g} % band of an honest one" if k == 0 else None
        ax.plot([part.low, part.high], [k, k], color=LIGHT_GREY, linewidth=12, solid_capstyle="butt", label=label)
        inside = part.word == "as it should be"
        ax.plot(part.ratio, k, **points(ESTIMATE if inside else REJECTED))
        ax.annotate(f"{part.ratio:.3g}", (part.ratio, k), (0, 9), textcoords="offset points", ha="center", fontsize=11)
    ax.axvline(1, color=GREY, linewidth=1)
    ax.set_yticks(range(len(parts)), parts)
    ax.set(xscale="log", xlabel="mean / dof (-)", ylim=(len(parts) - 0.4, -0.9))
    every = [v for p in parts.values() for v in (p.low, p.high, p.ratio)] or [1.0]
    low, high = min(0.5, 0.8 * min(every)), max(2.0, 1.25 * max(every))
    ax.set_xlim(low, high)
    ticks = [v for v in (0.01, 0.1, 0.2, 0.5, 1, 2, 5, 10, 100, 1000) if low <= v <= high]
    ax.set_xticks(ticks, [f"{v:g}" for v in ticks])
    ax.minorticks_off()
    ax.grid(axis="y", visible=False)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1), fontsize=11, frameon=False)
