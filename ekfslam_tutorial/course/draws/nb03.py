"""Drawings of notebook 03: the instruments that tell whether a filter is honest. The filters stand in the notebook."""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import chi2

from ...analysis.consistency import Honesty, anees_band, chi2_band, coverage, honesty, md2
from ...datasets import lecture
from ...geometry import wrap
from ...graphics import ESTIMATE, TRUTH, plot_ellipse, points, sigma_label
from ...graphics.style import BLACK, BLUE, GREEN, GREY, LIGHT_GREY, ORANGE, PURPLE, SKY_BLUE, VERMILLION
from ..controls import Choice, Float, Int, Toggle
from ..widgets import explorable

# The four mappers of exercise 03.3, and the five filters of exercise 03.4, behind their letters.
MAPPERS = {
    "A": dict(times=2),
    "B": dict(),
    "C": dict(odometry=True),
    "D": dict(range_factor=2.0, bearing_factor=2.0),
}
PANELS = {
    "P": "no cross-covariance",
    "Q": "bearing not wrapped",
    "R": "std taken for variance",
    "S": "P_rm not moved",
    "T": "correct",
}


@dataclass(frozen=True)
class Mapped:
    """Maps of N landmarks from R runs.

    Attributes
    ----------
    l, P : ndarray, shape (R, N, 2) and (R, N, 2, 2)
        Estimates and their covariances, in metres; with known poses the landmarks are independent.
    e : ndarray, shape (R, 2N)
        Error of the whole map.
    cov : ndarray, shape (R, 2N, 2N)
    nis, likelihood : ndarray
        Of all innovations; mean log-likelihood.
    """

    l: np.ndarray
    P: np.ndarray
    e: np.ndarray
    cov: np.ndarray
    nis: np.ndarray
    likelihood: float


def mapped(lmks, surprises, points):
    """Gather the maps of some runs.

    Parameters
    ----------
    lmks : list of (ndarray, ndarray)
        Of each landmark the estimates (R, 2) and their covariances (R, 2, 2).
    surprises : list of (ndarray, ndarray)
        Innovations (R, 2) and their covariances (R, 2, 2).
    points : ndarray, shape (N, 2)
        The truth.
    """
    l, P = np.stack([l for l, _ in lmks], 1), np.stack([P for _, P in lmks], 1)
    runs, n, _ = l.shape
    cov = np.zeros((runs, 2 * n, 2 * n))
    for j in range(n):
        cov[:, 2 * j : 2 * j + 2, 2 * j : 2 * j + 2] = P[:, j]
    nis = np.array([md2(z, Z) for z, Z in surprises])
    score = [-0.5 * (d2 + np.log(np.linalg.det(2 * np.pi * Z))) for d2, (_, Z) in zip(nis, surprises, strict=True)]
    return Mapped(l, P, (l - points).reshape(runs, -1), cov, nis, float(np.mean(score)))


# ---- 1 coverage ----------------------------------------------------------------------------------------------------


@explorable(
    k=Float(1.0, 0.2, 4.0, 0.1, "size k of the ellipse", "sigma"),
    dof=Int(3, 1, 8, label="dimension (right picture)"),
    ranges={"plane_percent": (0, 100), "percent": (0, 100)},
)
def dial(k, dof):
    """Random points and the k-sigma ellipse; squared distances in any dimension."""
    rng = np.random.default_rng(1)
    p = rng.standard_normal((1000, 2)) @ np.array([[1.0, 0.0], [0.6, 0.6]]).T
    d2 = (rng.standard_normal((4000, dof)) ** 2).sum(1)
    P = np.array([[1.0, 0.6], [0.6, 0.72]])
    inside = md2(p, P) < k * k
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.8))
    fig.subplots_adjust(left=0.07, right=0.98, bottom=0.13, top=0.92, wspace=0.2)  # quicker than a layout engine
    ax.plot(
        *p[inside].T,
        color=BLUE,
        linestyle="none",
        marker="o",
        markersize=2,
        markeredgewidth=0,
        label=f"inside: {100 * inside.mean():.1f} %",
    )
    ax.plot(*p[~inside].T, "x", color=VERMILLION, markersize=5, label=f"outside: {100 * (~inside).mean():.1f} %")
    plot_ellipse(ax, np.zeros(2), P, k=k, color=BLACK, label=f"{k:.1f} sigma ellipse")
    ax.set(xlim=(-5, 5), ylim=(-4.2, 4.2), xlabel="error in x (m)", ylabel="error in y (m)", aspect="equal")
    ax.set_title("1000 errors in the plane")
    ax.legend(loc="upper left", fontsize=11)
    top = max(chi2.ppf(0.9995, dof), 1.1 * k * k)
    grid = np.linspace(1e-3, top, 300)
    right.hist(
        d2,
        bins=60,
        range=(0, top),
        density=True,
        histtype="stepfilled",
        color=LIGHT_GREY,
        label="4000 squared distances",
    )
    pdf = chi2.pdf(grid, dof)
    right.plot(grid, pdf, color=BLUE, label=f"chi-square, {dof} degrees of freedom")
    right.fill_between(grid, pdf, where=grid > k * k, color=VERMILLION, alpha=0.5, hatch="//", label="outside")
    right.axvline(k * k, color=BLACK, linestyle="--", label=f"k² = {k * k:.2f}")
    right.set(xlabel=r"squared distance $e^\top P^{-1} e$", ylabel="density", ylim=(0, min(1.3 * pdf[5:].max(), 1.2)))
    right.set_title(f"{dof} dimension{'s' * (dof > 1)}: {100 * coverage(k, dof):.1f} % inside")
    right.legend(fontsize=11, loc="upper right")
    plane, any_dim = 100 * float(coverage(k, 2)), 100 * float(coverage(k, dof))
    caption = (
        f"{k:.1f} sigma: an interval holds {100 * coverage(k, 1):.1f} %, an ellipse {plane:.1f} %, "
        f"{dof} dimension{'s' * (dof > 1)} {any_dim:.1f} %."
    )
    return fig, {"plane_percent": plane, "percent": any_dim, "caption": caption}


# ---- 2 NEES --------------------------------------------------------------------------------------------------------


def nees_figure(nees, average, band):
    """NEES of each of N runs beside their average, each with its 95 % band. Returns (fig, caption)."""
    nees, band, n = np.asarray(nees, float), [float(b) for b in band], len(nees)
    one = chi2_band(3)
    fig, ax = plt.subplots(figsize=(9.0, 4.6), layout="constrained")
    ax.axhspan(*one, color=SKY_BLUE, alpha=0.25, label=f"95 % band of one run: {one[0]:.2f} to {one[1]:.2f}")
    label = f"95 % band of the average: {band[0]:.2f} to {band[1]:.2f}"
    ax.fill_between([n + 0.7, n + 3.3], band[0], band[1], color=GREEN, alpha=0.4, hatch="//", label=label)
    ax.plot(np.arange(1, n + 1), nees, "o", color=BLUE, label="NEES of one run")
    ax.plot(n + 2, average, "D", color=BLACK, markersize=9, label=f"average: {average:.2f}")
    ax.set(xlabel="run", ylabel="NEES of the last pose", xlim=(0, n + 4), ylim=(0, max(12, 1.1 * nees.max())))
    ax.set_xticks([1, *range(5, n + 1, 5), n + 2], ["1", *map(str, range(5, n + 1, 5)), "all"])
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    out = int(np.sum((nees < one[0]) | (nees > one[1])))
    word = "inside" if band[0] < average < band[1] else "outside"
    return fig, (
        f"{n} runs: {out} outside the band of one run. The average, {average:.2f}, is {word} its own band, "
        f"{band[0]:.2f} to {band[1]:.2f}."
    )


@explorable(
    told=Float(1.0, 0.2, 4.0, 0.1, "noise told / true noise (variances)"),
    runs=Choice(20, [1, 5, 20, 50], label="runs"),
    ranges={"anees": (0.2, 40)},
)
def over_time(localise, told, runs):
    """Average NEES of localisation over time, with its band. `localise(runs, told)` of the notebook does it."""
    x, P = localise(50, round(told, 2))
    e = x - np.array([lecture.get_pose(k) for k in range(1, len(x) + 1)])[:, None]
    e[..., 2] = wrap(e[..., 2])
    nees = md2(e, P)[:, :runs]
    low, high = anees_band(3, runs)
    mean, k = nees.mean(1), np.arange(1, len(nees) + 1)
    fig = plt.figure(figsize=(9.0, 4.4))
    ax = fig.add_axes((0.09, 0.13, 0.57, 0.83))
    ax.axhspan(low, high, color=GREEN, alpha=0.3, label=f"95 % band, {low:.2f} to {high:.2f}")
    ax.plot(k, nees[:, : min(runs, 12)], color=GREY, linewidth=0.5, alpha=0.6)
    ax.plot([], [], color=GREY, linewidth=0.5, label="single runs")
    ax.plot(k, mean, color=BLUE, marker="o", markersize=3.5, label=f"average of {runs} run{'s' * (runs > 1)}")
    ax.set(xlabel="time step", ylabel="NEES of the pose", xlim=(0, 51), yscale="log", ylim=(0.1, 100))
    ax.minorticks_off()
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    inside = 100 * float(np.mean((mean > low) & (mean < high)))
    caption = (
        f"Told {told:.1f} times the true variances. {runs} run{'s' * (runs > 1)}: average NEES {mean.mean():.2f} "
        f"(honest: 3), inside its 95 % band in {inside:.0f} % of the steps."
    )
    return fig, {"anees": float(mean.mean()), "caption": caption}


# ---- 3 the meter ---------------------------------------------------------------------------------------------------


def read_meter(mapped: Mapped) -> Honesty:
    """The honesty meter of some runs of a mapper: NEES of the whole map, NIS of all innovations."""
    return honesty(mapped.e, mapped.cov, mapped.nis.ravel(), nis_dof=2)


@explorable(
    range_factor=Float(1.0, 0.3, 3.0, 0.1, "range noise told / true (std)"),
    bearing_factor=Float(1.0, 0.3, 3.0, 0.1, "bearing noise told / true (std)"),
    twice=Toggle(True, label="use each measurement twice"),
    odometry=Toggle(False, label="take the odometry for the true pose"),
    run=True,
    ranges={"nis": (0.05, 200), "nees": (1, 1e5), "rmse_m": (0.02, 2)},
)
def meter(mapping, range_factor, bearing_factor, twice, odometry):
    """A mapper with known poses, `mapping` of the notebook, and its five instruments."""
    mapped = mapping(round(range_factor, 2), round(bearing_factor, 2), 1 + twice, odometry)
    h = read_meter(mapped)
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.6, 5.2), layout="constrained", width_ratios=(1, 1.05))
    _map(ax, mapped)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, fontsize=10, frameon=False, columnspacing=1)
    _gauges(right, h)
    says = h.verdicts()
    caption = (
        f"RMSE {h.rmse:.3f} m. NIS {_short(h.nis)} (honest: 2): {says['nis']}. NEES {_short(h.nees)} (honest: 32): "
        f"{says['nees']}. P symmetric: {says['symmetric']}; P without negative eigenvalue: {says['psd']}."
    )
    return fig, {"nis": h.nis, "nees": h.nees, "rmse_m": h.rmse, "caption": caption}


def tune_figure(factors, nis, nees, likelihood):
    """What the instruments say for each factor on the noise that the filter is told. Returns (fig, caption)."""
    factors, nis, nees, score = (np.asarray(a, float) for a in (factors, nis, nees, likelihood))
    fig, (ax, right) = plt.subplots(1, 2, figsize=(11.0, 4.4), layout="constrained")
    ax.plot(factors, nis / 2, "o-", color=BLUE, label="NIS / 2")
    ax.plot(factors, nees / 32, "s--", color=VERMILLION, label="NEES / 32")
    ax.axhline(1, color=BLACK, linewidth=1, linestyle=":", label="honest")
    ax.set(xlabel="noise told / true noise (std)", ylabel="relative to honest", xscale="log", yscale="log")
    ax.set_title("consistency")
    ax.legend()
    best = int(np.argmax(score))
    right.plot(factors, score, "o-", color=GREEN)
    right.plot(factors[best], score[best], "D", color=BLACK, markersize=9, label=f"best: {factors[best]:.2f}")
    right.set(xlabel="noise told / true noise (std)", ylabel="mean log-likelihood of an innovation", xscale="log")
    right.set_title("score")
    right.legend()
    for a in (ax, right):
        a.set_xticks([0.5, 1, 2], ["0.5", "1", "2"])
        a.minorticks_off()
    ax.set_yticks([0.2, 0.5, 1, 2, 5], ["0.2", "0.5", "1", "2", "5"])
    near = int(np.argmin(np.abs(np.log(nis / 2))))
    return fig, (
        f"The NIS is nearest to 2 at a factor of {factors[near]:.2f}, the NEES there is {nees[near]:.0f} (honest: 32); "
        f"the likelihood of the innovations is largest at {factors[best]:.2f}."
    )


# ---- 4 four mappers ------------------------------------------------------------------------------------------------


def mappers_figure(mapping):
    """The maps of the four mappers, each a setting of `mapping`. Returns (fig, caption)."""
    fig, axes = plt.subplots(2, 2, figsize=(9.6, 8.6), sharex=True, sharey=True, layout="constrained")
    worst = []
    for ax, (letter, wrong) in zip(axes.flat, MAPPERS.items(), strict=True):
        mapped = mapping(**wrong)
        _map(ax, mapped)
        ax.set_title(f"mapper {letter}")
        ax.label_outer()
        worst.append(f"{letter} {np.hypot(*mapped.e[0].reshape(-1, 2).T).max():.2f} m")
    fig.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return fig, "One run of each mapper. Worst landmark error: " + ", ".join(worst) + "."


def mappers_table(mapping):
    """The instruments of the four mappers, as text."""
    meters = {letter: read_meter(mapping(**wrong)) for letter, wrong in MAPPERS.items()}
    first = next(iter(meters.values()))
    rows = ["mapper   RMSE (m)    NIS   NEES   P = P'   P >= 0"]
    for letter, h in meters.items():
        says = h.verdicts()
        numbers = f"{h.rmse:8.2f} {h.nis:6.1f} {_short(h.nees, 0):>6}"
        rows.append(f"{letter:^6}   {numbers}   {says['symmetric']:>6}   {says['psd']:>6}")
    low, high = first.nees_band
    return "\n".join([*rows, f"honest            {2:6.1f} {low:3.0f}-{high:.0f}      yes      yes"])


# ---- 5 which bug ---------------------------------------------------------------------------------------------------


def panels_figure(results):
    """RMSE, NIS and NEES of five SLAM filters over time. Returns (fig, caption).

    Parameters
    ----------
    results : dict of str to fleet.Result
        By the name of the bug; the letters hide which is which.
    """
    fig, axes = plt.subplots(3, 5, figsize=(12.6, 6.6), sharex=True, sharey="row", layout="constrained")
    for column, (letter, bug) in zip(axes.T, PANELS.items(), strict=True):
        r = results[bug]
        every = slice(None, None, 12)
        bands = None, *(anees_band(dof, r.nees.shape[1], 0.99) for dof in (2, 3))
        rms = np.sqrt(np.mean(r.position_error**2, 1))
        column[0].plot(r.t[every], np.clip(rms[every], 0.005, 30), color=BLUE)
        column[1].plot(r.nis_t[every], np.clip(_mean(r.nis)[every], 0.02, 3e3), ".", color=PURPLE, markersize=4)
        column[2].plot(r.t[every], np.clip(_mean(r.nees)[every], 0.1, 3e4), color=VERMILLION)
        for ax, band in zip(column[1:], bands[1:], strict=True):
            ax.axhspan(*band, color=GREEN, alpha=0.35)
        column[0].set_title(letter)
        column[2].set_xlabel("time (s)")
        if r.broken:
            column[2].text(0.96, 0.06, "P < 0", transform=column[2].transAxes, ha="right", fontsize=13, weight="bold")
    for ax, name in zip(axes[:, 0], ("RMSE (m)", "NIS (honest: 2)", "NEES (honest: 3)"), strict=True):
        ax.set(yscale="log", ylabel=name)
    axes[0, 0].set_ylim(0.01, 40)
    axes[1, 0].set_ylim(0.02, 4e3)
    axes[2, 0].set_ylim(0.1, 4e4)
    return fig, (
        "Five SLAM filters, 10 runs each, two rounds. Band: where the mean of 10 honest runs stays with 99 % "
        "probability. " + "; ".join(f"{k}: NIS {_short(_middle(results[b].nis))}" for k, b in PANELS.items()) + "."
    )


def panels_table(results):
    """The same as numbers: medians over the runs, as text."""
    rows = ["panel   RMSE (m)     NIS    NEES   runs with P < 0"]
    for letter, bug in PANELS.items():
        r = results[bug]
        rmse = float(np.median(np.sqrt(np.mean(r.position_error**2, 0))))
        rows.append(
            f"{letter:^5}   {_short(rmse, 1, 10):>8} {_short(_middle(r.nis), 1):>7} {_short(_middle(r.nees), 1):>7}   "
            f"{r.broken:>3} of {r.nees.shape[1]}"
        )
    return "\n".join([*rows, "ideal                 2.0     3.0     0"])


# ---- parts ---------------------------------------------------------------------------------------------------------


def _mean(a):
    """Mean over the runs; numbers that do not exist are left out."""
    return np.array([row[np.isfinite(row)].mean() if np.isfinite(row).any() else np.nan for row in a])


def _middle(a):
    """Median over the runs of the mean over time; numbers that do not exist are left out."""
    means = [run[np.isfinite(run)].mean() for run in np.asarray(a).T if np.isfinite(run).any()]
    return float(np.median(means))


def _short(value, digits=2, most=100):
    """A number, or that it is beyond all bounds: a run that diverges has no digits worth printing."""
    if value > most:
        return f"> {most}" if value < 20 * most else f"> {20 * most}"
    return f"{value:.{digits}f}"


def _map(ax, mapped):
    """First run of a mapper."""
    plot_ellipse(ax, mapped.l[0], mapped.P[0], k=3, color=BLUE, linewidth=1.2, label=sigma_label(3))
    ax.plot(*lecture.true_landmarks()[1].T, **points(TRUTH, markersize=9, markeredgewidth=1.0), label="true landmarks")
    ax.plot(*mapped.l[0].T, **points(ESTIMATE, markersize=4), label="estimates")
    ax.set(xlim=(-8, 8), ylim=(-7.2, 7.8), xlabel="x (m)", ylabel="y (m)", aspect="equal")


def _gauges(ax, h):
    """NIS and NEES on a logarithmic scale, 1 is honest; the other three as words."""
    says = h.verdicts()
    for y, key, value, wanted, honest in ((3, "nis", h.nis, h.nis_band, 2), (2, "nees", h.nees, h.nees_band, 32)):
        value, band = value / honest, np.array(wanted) / honest
        ax.plot([0.05, 20], [y, y], color=LIGHT_GREY, linewidth=12, solid_capstyle="round", zorder=1)
        ax.plot(band, [y, y], color=GREEN, linewidth=12, solid_capstyle="butt", zorder=2)
        ax.plot(np.clip(value, 0.05, 20), y, "D", color=BLACK, markersize=12, markerfacecolor=ORANGE, zorder=3)
        ax.text(0.05, y + 0.3, f"{key.upper()} / {honest} = {_short(value)}: {says[key]}", fontsize=14)
    words = f"RMSE {h.rmse:.3f} m", f"P = P':  {says['symmetric']}", f"P >= 0:  {says['psd']}"
    for y, word in zip((1.1, 0.6, 0.1), words, strict=True):
        ax.text(0.05, y, word, fontsize=14)
    ax.set(xscale="log", xlim=(0.035, 28), ylim=(-0.2, 4), xlabel="relative to an honest filter; bar: 99.9 % band")
    ax.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ax.set_title("honesty meter, 20 runs")
    ax.grid(False)
    ax.yaxis.set_visible(False)
    ax.spines["left"].set_visible(False)
