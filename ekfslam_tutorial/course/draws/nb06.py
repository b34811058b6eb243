"""Drawings of notebook 06: loop closure."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from ...graphics import ESTIMATE, MEASUREMENT, TRUTH, line, plot_ellipse
from ...graphics.style import BLACK, BLUE, GREEN, GREY, ORANGE, VERMILLION, Style
from .parts import landmarks, map_axes, robot, true_landmarks

INSIDE: Style = dict(loc="center", bbox_to_anchor=(0.57, 0.47), fontsize=11)  # the round leaves room for a legend


def sigma(P, r):
    """Standard deviation of a point, m: root of the mean variance over its two directions."""
    return float(np.sqrt(np.trace(P[r, r]) / 2))


# ---- figures of the notebook ----------------------------------------------------------------------------------------


def before_after(moments, k, world):
    """The map one frame before frame k, and at frame k. Returns (fig, caption).

    Parameters
    ----------
    moments : list
        The filter after each frame, from 0 to k: `x`, `P`; `ranges`, of the landmarks by id; `truth`, the true pose;
        `seen`, the ids of the landmarks in view.
    k : int
    world : ndarray, shape (N, 2)
        True landmarks.
    """
    fig, axes = plt.subplots(1, 2, figsize=(13, 7.3), layout="constrained", sharey=True)
    for ax, j, title in zip(axes, (k - 1, k), ("one frame before", "the loop is closed"), strict=True):
        _map(ax, moments, j, world, f"frame {j}: {title}")
    axes[0].legend(**INSIDE)
    axes[1].set_ylabel("")
    a, b = moments[k - 1], moments[k]
    out = [i for i in a.ranges if i not in b.seen]
    pull = float(np.hypot(*(b.x[:2] - a.x[:2])))
    gain = [1 - sigma(b.P, b.ranges[i]) / sigma(a.P, a.ranges[i]) for i in out]
    best = out[int(np.argmax(gain))]
    return fig, (
        f"In frame {k} landmark 0 is seen again: the robot is moved by {pull:.1f} m. "
        f"{sum(g > 0.1 for g in gain)} of the {len(out)} landmarks out of view "
        f"become better by more than 10 %; the best gain has landmark {best}: sigma from "
        f"{sigma(a.P, a.ranges[best]):.2f} m to {sigma(b.P, b.ranges[best]):.2f} m."
    )


def correlations(before, after, names=("before", "after the closure")):
    """Correlations of the landmarks' positions, before and after. Returns (fig, caption).

    Parameters
    ----------
    before, after : ndarray, shape (n, n)
        Correlation coefficients, -1 to 1, of n landmarks in the order of their birth.
    names : pair of str
        Titles.
    """
    fig, axes = plt.subplots(1, 2, figsize=(13, 5.8), layout="constrained")
    for ax, C, title in zip(axes, (before, after), names, strict=True):
        ax.imshow(C, cmap="PuOr_r", vmin=-1, vmax=1, interpolation="none")
        ax.set(xlabel="landmark", ylabel="landmark", title=title)
        ax.set_xticks(range(0, len(C), 2))
        ax.set_yticks(range(0, len(C), 2))
        ax.grid(False)
    fig.colorbar(axes[0].images[0], ax=axes, label="correlation of positions (-)", shrink=0.9)
    last, near = len(before) - 1, len(before) // 2
    return fig, (
        f"Correlation between landmark {near} and its successor: {before[near, near + 1]:.2f} before, "
        f"{after[near, near + 1]:.2f} after; between landmarks 0 and {last}, the two ends of the chain: "
        f"{before[0, last]:.2f} before, {after[0, last]:.2f} after; between landmarks 0 and {near}: "
        f"{before[0, near]:.2f} before, {after[0, near]:.2f} after."
    )


def chain(before, after, shift, gap):
    """A straight loop in one dimension: sigmas before and after, and what each landmark moves. Returns (fig, caption).

    Parameters
    ----------
    before, after : ndarray, shape (n,)
        Standard deviations, m.
    shift : ndarray, shape (n,)
        What each landmark is moved by, m.
    gap : float
        The innovation at the closure, m.
    """
    n = np.arange(1, len(before) + 1)
    fig, (ax, side) = plt.subplots(1, 2, figsize=(12, 4.8), layout="constrained")
    ax.plot(n, before, color=GREY, linestyle="--", marker="s", fillstyle="none", label="before the closure")
    ax.plot(n, after, color=BLUE, linestyle="-", marker="o", label="after")
    ax.set(xlabel="landmark, in the order of the drive", ylabel="sigma (m), 1σ", ylim=(0, None), xticks=n[1::2])
    ax.legend()
    side.bar(n, shift, color=ORANGE, edgecolor=BLACK, label="moved by")
    side.axhline(gap, color=VERMILLION, linestyle=":", linewidth=2, label="the gap z")
    side.set(xlabel="landmark, in the order of the drive", ylabel="correction (m)", xticks=n[1::2])
    side.legend(loc="center left")
    worst = int(np.argmax(after)) + 1
    return fig, (
        f"Before, landmark {len(n)} is the worst ({before[-1]:.2f} m). After, it is landmark {worst} "
        f"({after[worst - 1]:.2f} m), half way. The gap of {gap:.2f} m is spread over all {len(n)} landmarks."
    )


def floor_figure(sigmas, floors, heading_std_deg):
    """Sigma of each landmark and the floor below which none should fall. Returns (fig, caption).

    Parameters
    ----------
    sigmas, floors : ndarray, shape (n,)
        Standard deviations, m.
    heading_std_deg : float
        Of the first heading, for the title.
    """
    sigmas, floors = np.asarray(sigmas), np.asarray(floors)
    below = sigmas < 0.99 * floors
    ids = np.arange(len(sigmas))
    fig, ax = plt.subplots(figsize=(11, 4.8), layout="constrained")
    ax.step(
        ids, floors, where="mid", color=BLACK, linestyle="--", linewidth=2, label="the floor: no filter can do better"
    )
    ax.plot(ids[~below], sigmas[~below], "o", color=BLUE, markersize=9, label="EKF-SLAM, on or above the floor")
    if below.any():
        ax.plot(ids[below], sigmas[below], "X", color=VERMILLION, markersize=11, label="EKF-SLAM, below the floor")
    ax.set(xlabel="landmark", ylabel="sigma (m), 1σ", ylim=(0, None), xticks=ids)
    ax.set_title(f"after two rounds; sigma of the first heading {heading_std_deg:g}°")
    ax.legend(loc="lower center", ncols=3)  # below the marks
    low = int(np.argmin(sigmas / floors))
    return fig, (
        f"First heading: {heading_std_deg:g} degrees. {below.sum()} of {len(ids)} landmarks are below their floor. "
        f"The lowest, landmark {low}: {sigmas[low]:.2f} m, floor {floors[low]:.2f} m."
    )


def differences_figure(pairs, floor):
    """Sigmas of differences between landmarks, along and across, over time. Returns (fig, caption).

    Parameters
    ----------
    pairs : dict of str to ndarray, shape (F, 2)
        For each pair of landmarks its name, and in each frame the sigma of the distance and that across it, m.
    floor : float
        Sigma of the first position, m.
    """
    fig, axes = plt.subplots(1, 2, figsize=(13, 5), layout="constrained", sharey=True)
    looks = zip((BLUE, VERMILLION, GREEN), ("-", "--", "-."), strict=True)
    for (name, table), (color, dash) in zip(pairs.items(), looks, strict=False):
        for ax, curve in zip(axes, np.transpose(table), strict=True):
            ax.plot(curve, color=color, linestyle=dash, linewidth=2.4, label=name)
    for ax, title in zip(axes, ("their distance", "across: the direction from one to the other"), strict=True):
        ax.set(xlabel="frame", yscale="log", ylim=(0.01, 1), title=title)
        ax.set_yticks([0.01, 0.03, 0.1, 0.3, 1], ["0.01", "0.03", "0.1", "0.3", "1"])
        ax.axhline(floor, color=BLACK, linestyle=":", linewidth=2, label="floor of the positions")
    axes[0].set_ylabel("sigma of the difference (m), 1σ")
    axes[1].legend(loc="lower left")
    words = [f"{name} {t[-1][0]:.3f} m and {t[-1][1]:.2f} m" for name, t in pairs.items()]
    first = next(iter(pairs.values()))
    return fig, (
        f"At the end, sigma of the distance and across it: {'; '.join(words)}. Half way the first distance had "
        f"{first[len(first) // 2][0]:.3f} m. Positions: {floor:g} m at best."
    )


def closed_with(moment, whole, cut, world):
    """One closure with the covariances and one without them, as maps. Returns (fig, caption).

    Parameters
    ----------
    moment : Moment
        Before the closure.
    whole, cut : (x, P)
        After it, with the cross-covariances and without them.
    world : ndarray, shape (N, 2)
        True landmarks.
    """
    fig, axes = plt.subplots(1, 2, figsize=(13, 7.3), layout="constrained", sharey=True)
    ranges, words = moment.ranges, []
    titles = "with cross-covariances", "without them"
    for ax, (x, P), title in zip(axes, (whole, cut), titles, strict=True):
        map_axes(ax, 16.5, title)
        true_landmarks(ax, world[list(ranges)])
        landmarks(ax, x, P, list(ranges.values()), labels=[str(i) for i in ranges])
        steps = [(moment.x[r], x[r]) for r in (slice(0, 2), *ranges.values())]
        far = [float(np.hypot(*(new - old))) for old, new in steps]
        arrow = dict(arrowstyle="->", color=ORANGE, linewidth=2.5, shrinkA=0, shrinkB=0)
        for (old, new), d in zip(steps, far, strict=True):
            if d > 0.2:
                ax.annotate("", new, old, arrowprops=arrow, zorder=7)
        ax.plot([], [], color=ORANGE, linewidth=2, label="moved by the closure")
        robot(ax, moment.truth, TRUTH, 0.9)
        robot(ax, x[:3], ESTIMATE, 0.9)
        words.append(f"{title} {sum(d > 0.2 for d in far[1:])} landmarks move by more than 0.2 m")
    axes[0].legend(**INSIDE)
    axes[1].set_ylabel("")
    return fig, f"One measurement of landmark 0: {'; '.join(words)}. The robot moves in both cases."


# ---- widget ---------------------------------------------------------------------------------------------------------


def scrubber(moments, frame, start_std, difference, world):
    """A run at one frame: the map, and the sigma of every landmark against time. Returns (fig, facts).

    Parameters
    ----------
    moments : list
        As for `before_after`.
    frame : int
    start_std : float
        Sigma of the first position, m: the floor.
    difference : bool
        Show differences to landmark 0 instead of positions.
    world : ndarray, shape (N, 2)
        True landmarks.
    """
    now, n = moments[frame], len(world)
    fig = plt.figure(figsize=(13, 6.4))
    ax = fig.add_axes((0.055, 0.1, 0.42, 0.85))
    _map(ax, moments, frame, world)
    ax.legend(**INSIDE)
    curve = fig.add_axes((0.565, 0.1, 0.42, 0.85))
    table = _sigmas(moments, n, difference)
    late = n // 2
    curve.plot(table[:, 1:], color=GREY, linewidth=0.8)
    curve.plot(table[: frame + 1, late], color=VERMILLION, linewidth=2.6, linestyle="--", label=f"landmark {late}")
    curve.plot(table[: frame + 1, 1], color=BLUE, linewidth=2.6, label="landmark 1")
    curve.plot([], [], color=GREY, linewidth=0.8, label="all landmarks")
    if not difference:
        curve.axhline(start_std, color=BLACK, linestyle=":", linewidth=2, label=f"floor, {start_std:g} m")
    curve.axvline(frame, color=BLACK, linewidth=1)
    what = "sigma of the difference to landmark 0" if difference else "sigma of the position"
    curve.set(xlabel="frame", ylabel=f"{what} (m), 1σ", xlim=(0, len(moments) - 1), ylim=(0, 1.45))
    curve.legend(loc="upper right", fontsize=11)
    values = table[frame][np.isfinite(table[frame])]
    back = "seen again" if any(0 in m.seen for m in moments[len(moments) // 4 : frame + 1]) else "not yet seen again"
    values = values[1:] if difference and len(values) > 1 else values
    caption = (
        f"Frame {frame}: {len(now.ranges)} landmarks in the map, the first one {back}. {what.capitalize()}: best "
        f"{values.min():.2f} m, worst {values.max():.2f} m"
        + ("." if difference else f"; the floor is {start_std:.2f} m.")
    )
    return fig, {"worst": float(values.max()), "least": float(values.min()), "caption": caption}


def _map(ax, moments, k, world, title=""):
    now = moments[k]
    map_axes(ax, 16.5, title)
    true_landmarks(ax, world)
    ax.plot(*np.array([m.truth[:2] for m in moments[: k + 1]]).T, **line(TRUTH, linewidth=1.2), label="true path")
    landmarks(ax, now.x, now.P, list(now.ranges.values()), labels=[str(i) for i in now.ranges])
    for i in now.seen:
        ax.plot(*np.transpose([now.x[:2], now.x[now.ranges[i]]]), **line(MEASUREMENT, linewidth=2))
    ax.plot([], [], **line(MEASUREMENT, linewidth=2), label="in view")
    plot_ellipse(ax, now.x[:2], now.P[:2, :2], 3, **line(ESTIMATE, linewidth=1.3))
    robot(ax, now.truth, TRUTH, 0.9)
    robot(ax, now.x[:3], ESTIMATE, 0.9)


def _sigmas(moments, n, difference):
    """Sigma of each landmark, or of its difference to landmark 0, in each frame; NaN before it is in the map."""
    table = np.full((len(moments), n), np.nan)
    for row, m in zip(table, moments, strict=True):
        x = np.array([r.start for r in m.ranges.values()], int)
        traces = m.P[x, x] + m.P[x + 1, x + 1]
        if difference and 0 in m.ranges:
            o = m.ranges[0].start
            traces = traces + m.P[o, o] + m.P[o + 1, o + 1] - 2 * (m.P[o, x] + m.P[o + 1, x + 1])
        row[list(m.ranges)] = np.sqrt(np.maximum(traces, 0) / 2)
    return table
