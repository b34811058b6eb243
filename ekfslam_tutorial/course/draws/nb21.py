"""Drawings of notebook 21: what a filter gains if it may change its mind, and what that costs."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb
from scipy.stats import chi2

from ...analysis.consistency import anees_band, chi2_band
from ...graphics import (
    DEAD_RECKONING,
    ESTIMATE,
    PREDICTED,
    REJECTED,
    TRUTH,
    UPDATED,
    line,
    plot_ellipse,
    points,
    sigma_label,
)
from ...graphics.style import BLACK, BLUE, GREEN, GREY, LIGHT_GREY, ORANGE, SKY_BLUE, VERMILLION
from .. import museum
from ..controls import Choice, Int
from ..estimators import FILTERS
from ..widgets import explorable
from .nb21_cost import numbers_kept, price
from .parts import robot

__all__ = ["numbers_kept", "price"]

CARRIED = {"color": SKY_BLUE, "marker": "v", "linestyle": "-", "fillstyle": "full"}
LOOKS = dict(zip(("EKF", *FILTERS, "batch"), (REJECTED, PREDICTED, UPDATED, CARRIED, ESTIMATE), strict=True))
LAGS = {"1: a filter": 1, "2": 2, "5": 5, "10": 10, "20": 20, "all: batch": 94}


# ---- one correction ------------------------------------------------------------------------------------------------

POSE = np.zeros(3)
LANDMARK, LANDMARK_STD = np.array([3.0, 2.0]), 1.5
SIGHT = np.array([4.4, -0.15])  # range and bearing measured
NOISE = np.diag([0.15, np.radians(3.0)]) ** 2


def one_landmark():
    """A robot that knows its pose, a landmark that it hardly knows, and a measurement far from what is expected."""
    P = np.diag([1e-9, 1e-9, 1e-9, LANDMARK_STD**2, LANDMARK_STD**2])
    return (
        np.concatenate([POSE, LANDMARK]),
        P,
        SIGHT,
        NOISE,
        lambda x: museum.observe(np.asarray(x, float), slice(3, 5)),
    )


def correction_figure(results):
    """Prior, exact posterior, and corrections by number of iterations: {1: (x, P), ...}. Returns (fig, caption)."""
    gx, gy = np.meshgrid(np.linspace(0.5, 7, 260), np.linspace(-2.6, 4.5, 260))
    y = np.stack([np.hypot(gx, gy), np.arctan2(gy, gx)], -1) - SIGHT
    prior = ((gx - LANDMARK[0]) ** 2 + (gy - LANDMARK[1]) ** 2) / LANDMARK_STD**2
    cost = (y**2 / np.diag(NOISE)).sum(-1) + prior
    best = np.unravel_index(np.argmin(cost), cost.shape)
    fig, ax = plt.subplots(figsize=(10.6, 5.6), layout="constrained")
    ax.contourf(gx, gy, cost - cost.min(), levels=[0, 9], colors=[LIGHT_GREY])
    ax.fill([], [], color=LIGHT_GREY, label="exact: inside 3σ")
    plot_ellipse(ax, LANDMARK, LANDMARK_STD**2 * np.eye(2), 1, color=GREY, linestyle=":", label="prior, 1σ")
    ax.plot(*LANDMARK, **points(DEAD_RECKONING, markersize=9), label="prior")
    off, styles = [], (REJECTED, UPDATED)
    for (count, (x, P)), style in zip(results.items(), styles, strict=False):
        l, B = np.asarray(x, float)[3:], np.asarray(P, float)[3:, 3:]
        name = "EKF" if count == 1 else f"{count} iterations"
        plot_ellipse(ax, l, B, 3, **line(style, linewidth=1.6))
        ax.plot(*l, **points(style, markersize=10), label=f"{name}, {sigma_label(3)}")
        off.append(f"{name} {np.hypot(l[0] - gx[best], l[1] - gy[best]):.2f} m")
    robot(ax, np.zeros(3), TRUTH, size=0.2)  # its pose is known
    ax.annotate("robot", (0, 0), (-6, -22), textcoords="offset points", fontsize=12)
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal", xlim=(-0.4, 7), ylim=(-2.6, 4.5))
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    return fig, f"Distance from the best fit to prior and measurement: {', '.join(off)}."


# ---- five estimators -----------------------------------------------------------------------------------------------


def map_figure(log, solutions):
    """One run: truth, the EKF, and another solution. Returns (fig, caption).

    Parameters
    ----------
    log : Log
        Of the run alone.
    solutions : dict of str to (poses, landmarks)
        Path (K, 3) and map (N, 2), flat or not, of "EKF" and "batch".
    """
    fig = plt.figure(figsize=(10.6, 5.8))
    ax = fig.add_axes((0.07, 0.11, 0.55, 0.86))
    rms = lambda d: float(np.sqrt((d**2).sum(1).mean()))
    of_path, of_map = [], []
    for name, (poses, l) in solutions.items():
        poses, l = np.asarray(poses, float), np.asarray(l, float).reshape(-1, 2)
        _scene(ax, log if not of_map else None, poses, l, LOOKS[name], name)
        of_path.append(f"{name} {rms(poses[:, :2] - log.truth[:, :2]):.2f} m")
        of_map.append(f"{name} {rms(l - log.points):.2f} m")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), frameon=False)
    return fig, f"RMSE of the path: {', '.join(of_path)}. Of the map: {', '.join(of_map)}."


def _scene(ax, log, path, l, style, name):
    if log is not None:
        ax.plot(*log.points.T, **points(TRUTH), label="true landmarks")
        ax.plot(*log.truth[:, :2].T, **line(TRUTH, linewidth=1.3), label="true path")
        ax.set(xlim=(-10, 10), ylim=(-10, 10), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.plot(*path[:, :2].T, **line(style), label=f"{name}, path")
    ax.plot(*l.T, **points(style), label=f"{name}, landmarks")


def methods_figure(log, results):
    """NEES of pose and map, run by run, of estimates by the name of their method. Returns (fig, caption)."""
    dof = 3 + 2 * len(log.points)
    low, high = chi2_band(dof, 0.99)
    fig, ax = plt.subplots(figsize=(11, 4.8), layout="constrained")
    ax.axvspan(low, high, color=GREEN, alpha=0.3, linewidth=0, label="99 % of the runs of an honest filter")
    ax.axvline(dof, color=BLACK, linestyle="--", linewidth=1.2, label=f"number of states, {dof}")
    words = []
    for row, (name, e) in enumerate(results.items()):
        v = e.nees(log)
        ax.plot(np.clip(v, 8, 400), np.full(len(v), -row), **points(LOOKS[name], markersize=7))
        words.append(f"{name} {np.sum((v >= low) & (v <= high))}")
    ax.set(xscale="log", xlim=(7.5, 430), ylim=(-4.6, 0.6), xlabel=f"NEES of pose and map, {dof} states (400: or more)")
    ax.set_yticks([-row for row in range(len(results))], list(results))
    ax.set_xticks([10, 20, 50, 100, 200, 400], ["10", "20", "50", "100", "200", "400"])
    ax.minorticks_off()
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False)
    return fig, f"Runs of {log.runs} inside the band {low:.0f} to {high:.0f}: {', '.join(words)}."


def methods_table(log, results):
    """The same estimates as numbers, as text."""
    dof = 3 + 2 * len(log.points)
    rows = ["                 NEES of pose   NEES of    sigma of    RMSE of", ""]
    rows[1] = "method                and map  heading  heading [deg]  map [m]"
    for name, e in results.items():
        sigma = np.degrees(np.sqrt(np.median(e.P[:, 2, 2])))
        rows.append(
            f"{name:<16} {_of(e.nees(log).mean()):>13} {e.nees_heading(log).mean():>8.1f} {sigma:>14.1f} "
            f"{np.median(e.map_rmse(log)):>8.2f}"
        )
    (a, b), (c, d) = anees_band(dof, log.runs, 0.999), anees_band(1, log.runs, 0.999)
    rows.append(f"{'honest (99.9 %)':<16} {f'{a:.1f} to {b:.1f}':>13} {f'{c:.1f}-{d:.1f}':>8}")
    return "\n".join([*rows, f"NEES: mean of the {log.runs} runs. Sigma and RMSE: their median."])


def _of(value):
    """Two digits; above 40 a single run decides, and the digits mean little."""
    return "> 40" if value > 40 else f"{value:.1f}"


# ---- sparsity ------------------------------------------------------------------------------------------------------


def sparsity_figure(A, poses):
    """Information of all poses and landmarks; of last pose and map; and its inverse. Returns (fig, caption)."""
    K = poses
    P = np.linalg.inv(A)[3 * K - 3 :, 3 * K - 3 :]
    B = np.linalg.inv(P)  # what is left when all other poses are marginalised: section 5
    fig, axes = plt.subplots(1, 3, figsize=(12.4, 4.9), layout="constrained")
    titles = (f"A: {K} poses, {(len(A) - 3 * K) // 2} landmarks", "A: last pose, landmarks", "P: last pose, landmarks")
    words = []
    for ax, M, title in zip(axes, (A, B, P), titles, strict=True):
        full, d = _filled(M), np.sqrt(np.abs(np.diag(M)))
        strength = np.where(full, 0.25 + 0.75 * np.sqrt(np.abs(M) / np.outer(d, d)), 0)
        ax.imshow(strength, cmap="Blues", vmin=0, vmax=1, interpolation="nearest")
        ax.set_title(f"{title}\n{100 * full.mean():.0f} % not zero")
        ax.set_xlabel(f"{len(M)} x {len(M)}")
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
        words.append(f"{len(M)} x {len(M)}, {100 * full.mean():.0f} %")
    return fig, (
        f"Entries that are not zero. Information matrix A of everything: {words[0]}. After all poses but the last were "
        f"marginalised: {words[1]}. Covariance of the filter: {words[2]}. Dark: strongly linked."
    )


def _filled(M):
    """Which entries are not zero, relative to the diagonal."""
    d = np.sqrt(np.abs(np.diag(M)))
    return np.abs(M) > 1e-9 * np.outer(d, d)


@explorable(
    gone=Int(12, 0, 46, label="poses marginalised", play=250),
    first=Choice("oldest", {"the oldest first": "oldest", "every second one": "second"}, label="which ones"),
    ranges={"filled": (0, 100), "links": (0, 45)},
)
def fill_in(A, lmks, marginalise, gone, first):
    """Marginalise poses one after another, the landmarks stay: which entries of A are filled."""
    n = len(lmks)
    K = (len(A) - 2 * n) // 3
    order = list(range(K - 1)) if first == "oldest" else [*range(0, K - 1, 2), *range(1, K - 1, 2)]
    out = {j for k in order[:gone] for j in range(3 * k, 3 * k + 3)}
    keep = [j for j in range(len(A)) if j not in out]
    B = marginalise(A, np.zeros(len(A)), keep)[0] if gone else A
    old, new = _filled(A)[np.ix_(keep, keep)], _filled(B)
    fig = plt.figure(figsize=(10.6, 5.6))
    ax = fig.add_axes((0.02, 0.06, 0.5, 0.86))
    shown = np.zeros((len(A), len(A)))
    shown[np.ix_(keep, keep)] = np.where(old, 1, np.where(new, 2, 0))
    picture = np.ones((*shown.shape, 3))
    for value, colour in ((1, BLUE), (2, ORANGE)):
        picture[shown == value] = to_rgb(colour)
    away = np.array(sorted(out), int)
    picture[away], picture[:, away] = 0.87, 0.87
    ax.imshow(picture, interpolation="nearest")
    ax.axhline(3 * K - 0.5, color=BLACK, linewidth=1)
    ax.axvline(3 * K - 0.5, color=BLACK, linewidth=1)
    ax.set(xticks=[1.5 * K, (3 * K + len(A)) / 2], yticks=[1.5 * K, (3 * K + len(A)) / 2])
    ax.set_xticklabels(["poses", "landmarks"])
    ax.set_yticklabels(["poses", "landmarks"], rotation=90, va="center")
    ax.tick_params(length=0)
    ax.grid(False)
    for colour, name in ((BLUE, "was there"), (ORANGE, "filled in"), ("0.87", "marginalised")):
        ax.plot([], [], "s", color=colour, markersize=12, label=name)
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1), frameon=False)
    L = new[-2 * n :, -2 * n :].reshape(n, 2, n, 2).any((1, 3))
    links = int((L.sum() - n) // 2)
    web = fig.add_axes((0.66, 0.06, 0.32, 0.6))
    for i, j in np.argwhere(np.triu(L, 1)):
        web.plot(*lmks[[i, j]].T, color=ORANGE, linewidth=1.2)
    web.plot(*lmks.T, **points(ESTIMATE, markersize=9))
    web.set(aspect="equal", title=f"landmarks linked: {links} of {n * (n - 1) // 2} pairs", xticks=[], yticks=[])
    web.grid(False)
    web.spines[:].set_visible(False)
    filled = 100 * float(new.mean())
    caption = (
        f"{gone} of {K} poses marginalised, {'the oldest first' if first == 'oldest' else 'every second one first'}: "
        f"{len(keep)} unknowns are left, {filled:.0f} % of their information matrix is not zero, {links} of "
        f"{n * (n - 1) // 2} pairs of landmarks are linked directly."
    )
    return fig, {"filled": filled, "links": links, "caption": caption}


# ---- lag -----------------------------------------------------------------------------------------------------------


@explorable(
    lag=Choice(5, LAGS, label="lag: poses in the state"),
    shown=Int(1, 1, 5, label="run shown"),
    run=True,
    ranges={"nees": (5, 1e4), "path_m": (0.01, 20)},
)
def smoother(log, ekf, smoothed, lag, shown):
    """A smoother that keeps the last poses, against the EKF and the batch: smoothed(lag) and the EKF are estimates."""
    e = smoothed(lag)
    dof = 3 + 2 * len(log.points)
    fig = plt.figure(figsize=(11.6, 5.4))
    ax = fig.add_axes((0.06, 0.12, 0.42, 0.84))
    _scene(ax, log, e.path[shown - 1], e.x[shown - 1, 3:].reshape(-1, 2), ESTIMATE, f"lag {lag}")
    ax.legend(loc="center", bbox_to_anchor=(0.56, 0.48), fontsize=11, frameon=False, handlelength=1.3)
    rows = {"EKF": ekf, f"lag {lag}": e, "batch": smoothed(log.frames)}
    bands = [fig.add_axes((0.6, y, 0.37, 0.3)) for y in (0.62, 0.14)]
    nees = [float(np.median(r.nees(log))) for r in rows.values()]
    path = [float(np.median(r.path_rmse(log))) for r in rows.values()]
    for a, values, title in zip(
        bands, (nees, path), ("NEES of pose and map, median", "RMSE of the path (m), median"), strict=True
    ):
        a.barh([2, 1, 0], values, color=[VERMILLION, BLUE, GREEN], height=0.6)
        for y, v in zip((2, 1, 0), values, strict=True):
            a.text(v, y, f" {v:.3g}", va="center", fontsize=13)
        a.set_yticks([2, 1, 0], list(rows))
        a.set(title=title, xlim=(0, 1.2 * max(values)))
        a.grid(False)
    middle = float(chi2.median(dof))
    bands[0].axvline(middle, color=BLACK, linestyle="--", linewidth=1.2)
    bands[0].set_xlabel(f"dashed: honest median, {middle:.1f}", fontsize=11)
    states = 3 * min(lag, log.frames) + 2 * len(log.points)
    caption = (
        f"Lag {lag}: up to {states} unknowns in each step. Medians of {log.runs} runs: NEES {nees[1]:.1f} (EKF "
        f"{nees[0]:.1f}, batch {nees[2]:.1f}, honest {middle:.1f}), RMSE of the path {path[1]:.2f} m (EKF "
        f"{path[0]:.2f} m, batch {path[2]:.2f} m)."
    )
    return fig, {"nees": nees[1], "path_m": path[1], "caption": caption}


# ---- cost ----------------------------------------------------------------------------------------------------------


def cost_figure(logs):
    """Numbers kept for logs past more and more landmarks. Returns (fig, caption)."""
    N, kept = [len(log.points) for log in logs], [numbers_kept(log) for log in logs]
    fig, ax = plt.subplots(figsize=(9.6, 5.0), layout="constrained")
    looks = (REJECTED, DEAD_RECKONING, PREDICTED, ESTIMATE)
    for name, style in zip(kept[0], looks, strict=True):
        ax.plot(N, [k[name] for k in kept], **{**style, "markersize": 8}, label=name)
    ax.set(xscale="log", yscale="log", xlabel="landmarks", ylabel="numbers kept")
    ax.set_xticks(N, [str(n) for n in N])
    ax.minorticks_off()
    ax.legend(loc="upper left")
    last, growth = kept[-1], {name: kept[-1][name] / kept[0][name] for name in kept[0]}
    factor = "smoother: factor of A"
    return fig, (
        f"From {N[0]} to {N[-1]} landmarks, two rounds: P grows {growth['filter: P']:.0f} times, the factor of A about "
        f"{round(growth[factor], -1):.0f} times. With {N[-1]} landmarks P has {last['filter: P'] / 1000:.0f} thousand "
        f"numbers, the factor of A about {round(last[factor] / 1000, -1):.0f} thousand."
    )
