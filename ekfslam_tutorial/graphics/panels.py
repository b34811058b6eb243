"""Panels: one question, one axes. Errors against their sigmas, consistency, the covariance matrix, strips of frames.

Every panel takes plain arrays and draws into the axes it is given, or into a new figure; it returns the axes, whose
``figure`` can be shown or saved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..ekf import chi_square
from .ellipses import sigma_label
from .style import BLACK, BLUE, ESTIMATE, GREY, ORANGE, REJECTED, SKY_BLUE, VERMILLION, line

Array = np.ndarray
GAP = 10
"""A step of time of more than so many usual ones is a gap."""


def _axes(ax: Axes | None, figsize=(8.0, 4.0)) -> Axes:
    return plt.subplots(figsize=figsize, layout="constrained")[1] if ax is None else ax


def _span(t):
    """Limits of the axis of time; matplotlib's own where there is only one instant."""
    return (t[0], t[-1]) if len(t) and t[-1] > t[0] else None


def _legend_above(ax: Axes) -> None:
    """Put the legend over the axes, where it hides no data."""
    place = {"loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0}
    ax.legend(**place, ncols=3, frameon=False, fontsize=11, columnspacing=1.2)


def _rug(ax: Axes, t: Array, label: str, at: float) -> None:
    """Mark instants by small strokes at the lower (0) or upper (1) edge, where they hide no curve."""
    edge = ax.get_xaxis_transform()
    style = {"color": REJECTED["color"], "marker": "|", "linestyle": "none", "markersize": 11, "markeredgewidth": 1.2}
    (strokes,) = ax.plot(t, np.full(len(t), at), **style, transform=edge, label=label, clip_on=False, zorder=3)
    strokes.set_in_layout(False)


def _lonely(value: Array) -> Array:
    """Say which values have no neighbour, so that a line would not show them."""
    known = np.isfinite(value)
    return known & ~np.append(False, known[:-1]) & ~np.append(known[1:], False)


def _height(error: Array, band: Array) -> tuple[float, float]:
    """Return how high an error panel has to be, and how high the band is.

    All of it is shown, unless the filter was lost for a few moments only: these would press the rest into a line.
    """
    error, band = error[np.isfinite(error)], band[np.isfinite(band)]
    if not len(error) or not len(band):
        return 1.0, 1.0
    whole = max(error.max(), band.max())
    usual = max(np.quantile(band, 0.95), np.quantile(error, 0.99))
    return 1.1 * whole if whole < 3 * usual else 1.5 * usual, band.max()


def error_panel(
    t: Array,
    error: Array,
    sigma: Array,
    k: float = 3,
    name: str = "error",
    unit: str = "m",
    ax: Axes | None = None,
    legend: bool = True,
) -> Axes:
    """Draw an error over time inside its band of +- k sigma; strokes at the lower edge say when it is outside.

    Nothing is drawn across a gap in time (`gaps_opened`).

    Parameters
    ----------
    t, error, sigma : (F,)
        Time in seconds; estimate minus truth; the standard deviation that the filter states. NaN leaves a gap.
    k : float
        Half width of the band in sigmas.
    name, unit : str
        Label of the vertical axis.
    ax : matplotlib Axes, optional
        Where to draw; by default a new figure.
    legend : bool
        Write the legend above; without it the share outside stands in the panel.
    """
    ax = _axes(ax)
    t, error, sigma = gaps_opened(*(np.asarray(a, dtype=float) for a in (t, error, sigma)))
    band = k * sigma
    out = np.abs(error) > band
    known = np.isfinite(error) & np.isfinite(sigma)
    ax.fill_between(
        t, -band, band, color=BLUE, alpha=0.15, linewidth=0, label=f"±{sigma_label(k, 1)}".replace(" interval", "")
    )
    ax.plot(t, band, color=BLUE, linewidth=0.8)
    ax.plot(t, -band, color=BLUE, linewidth=0.8)
    ax.axhline(0, color=GREY, linewidth=0.8)
    ax.plot(t, error, **line(ESTIMATE, linewidth=1.5), label="estimate - truth")
    lonely = _lonely(error)
    if lonely.any():
        ax.errorbar(t[lonely], error[lonely], band[lonely], fmt=".", color=BLUE, elinewidth=3, alpha=0.6)
    words = f"outside: {100 * out.sum() / max(known.sum(), 1):.1f} %"
    if out.any():
        _rug(ax, t[out], words, 0)
    height, whole = _height(np.abs(error), band)
    if height < whole:
        words += f", band up to ±{whole:.2g} {unit}"
    ax.set(xlabel="t (s)", ylabel=f"{name} ({unit})", xlim=_span(t), ylim=(-height, height))
    if legend:
        _legend_above(ax)
    else:
        ax.text(1, 1.01, words, transform=ax.transAxes, ha="right", va="bottom", fontsize="small")
    return ax


def error_panels(
    t: Array, errors: Array, sigmas: Array, k: float = 3, names: Sequence[str] = (), units: Sequence[str] = ()
) -> Array:
    """Draw one error panel under the other.

    Parameters
    ----------
    t : (F,)
        Time, seconds.
    errors, sigmas : (F, d)
        As for `error_panel`, one column for each panel.
    k : float
        Half width of the bands in sigmas.
    names, units : sequences of d strings
        Labels of the vertical axes.

    Returns
    -------
    (d,) array of axes
        From top to bottom.
    """
    errors, sigmas = np.asarray(errors, dtype=float), np.asarray(sigmas, dtype=float)
    d = errors.shape[1]
    names, units = list(names) or [f"error {i}" for i in range(d)], list(units) or ["m"] * d
    _, axes = plt.subplots(d, 1, figsize=(8, 2.4 * d + 0.6), sharex=True, squeeze=False, layout="constrained")
    for i, ax in enumerate(axes[:, 0]):
        error_panel(t, errors[:, i], sigmas[:, i], k, names[i], units[i], ax=ax)
        ax.label_outer()
    return axes[:, 0]


def consistency_panel(
    t: Array,
    value: Array,
    dof: float | Array,
    runs: int | Array = 1,
    probability: float = 0.95,
    name: str = "NEES",
    ax: Axes | None = None,
) -> Axes:
    """Draw NEES or NIS over time with the chi-square band that an honest filter stays in.

    The mean of `runs` independent values with `dof` degrees of freedom, times runs, is chi-square distributed with
    runs * dof degrees of freedom (Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and
    navigation", 2001, section 5.4). Above the band the filter is over-confident, below it is over-cautious.

    Parameters
    ----------
    t, value : (F,)
        Time, and the value averaged over the runs. NaN where there is none.
    dof : float or (F,)
        Degrees of freedom of one value; it may change from frame to frame.
    runs : int
        Number of Monte-Carlo runs that were averaged.
    probability : float
        Probability inside the band.
    name : str
        What is shown.
    ax : matplotlib Axes, optional
        Where to draw; by default a new figure.
    """
    ax = _axes(ax)
    t, value = np.asarray(t, dtype=float), np.asarray(value, dtype=float)
    dof = np.broadcast_to(np.asarray(dof, dtype=float), value.shape)
    tail = (1 - probability) / 2
    t, value, dof, n = gaps_opened(t, value, dof, np.broadcast_to(np.asarray(runs, dtype=float), value.shape))
    low, high = (chi_square.quantile(p, np.maximum(dof, 1e-9) * n) / n for p in (tail, 1 - tail))
    known = np.isfinite(value)
    within = 100 * ((value >= low) & (value <= high))[known].mean() if known.any() else np.nan
    mean = value[known].mean() if known.any() else np.nan

    ax.fill_between(t, low, high, color=BLUE, alpha=0.15, linewidth=0, label=f"{100 * probability:g} % band")
    ax.plot(t, dof, color=BLACK, linestyle="--", linewidth=1.2, label="expected value")
    width = 1.4 if len(value) < 400 else 0.9
    ax.plot(t, value, color=BLUE, linewidth=width, label=f"{name}: {within:.0f} % in the band")
    lonely = _lonely(value)
    ax.plot(t[lonely], value[lonely], color=BLUE, marker=".", linestyle="none")
    above = value > high
    _rug(ax, t[above], "over-confident", 1)
    ax.axhline(mean, color=ORANGE, linestyle=":", linewidth=1.8, label=f"mean {mean:.3g}")
    top = np.nanmax(np.concatenate([high, value[known]])) if known.any() else np.nanmax(high)
    if top > 20 * np.nanmax(high):
        ax.set_yscale("log")
    else:
        ax.set_ylim(0, 1.1 * top)
    runs_text = f", mean of {runs} runs" if np.ndim(runs) == 0 and runs > 1 else ""
    ax.set(xlabel="t (s)", ylabel=f"{name}{runs_text} (-)", xlim=_span(t))
    _legend_above(ax)
    return ax


def gaps_opened(t: Array, *values: Array) -> list[Array]:
    """Return times and values with a NaN in each gap of time, so that no line is drawn across it.

    Parameters
    ----------
    t : (F,)
        Rising. A gap is a step of more than `GAP` times the median step.
    *values : (F,)
    """
    step = np.diff(t)
    usual = np.median(step[step > 0]) if (step > 0).any() else 0.0
    after = np.flatnonzero(step > GAP * usual) + 1
    middle = np.insert(np.asarray(t, dtype=float), after, (t[after - 1] + t[after]) / 2)
    return [middle, *(np.insert(np.asarray(v, dtype=float), after, np.nan) for v in values)]


def cost_panel(t: Array, seconds: Array, sizes: Array, ax: Axes | None = None) -> Axes:
    """Draw what each frame of a run has cost, and how large the map was.

    Parameters
    ----------
    t : (F,)
        Time of the frames, seconds.
    seconds : (F,)
        What the computer needed for each.
    sizes : (F,)
        Number of landmarks in the map after it.
    ax : matplotlib Axes, optional
        Where to draw; by default a new figure.
    """
    ax = _axes(ax)
    t, ms = np.asarray(t, dtype=float), 1000 * np.asarray(seconds, dtype=float)
    width = max(1, len(ms) // 100)
    blocks = [slice(i, i + width) for i in range(0, len(ms), width)]
    middle, median = (np.array([np.median(a[b]) for b in blocks]) for a in (t, ms))
    top = 1.3 * np.quantile(ms, 0.99) if len(ms) else 1.0
    ax.plot(t, np.minimum(ms, top), color=SKY_BLUE, marker=".", markersize=2, linestyle="none", label="each frame")
    ax.plot(middle, median, **line(ESTIMATE), label="median")
    ax.set(xlabel="t (s)", ylabel="time of a frame (ms)", xlim=_span(t), ylim=(0, top))
    right = ax.twinx()
    right.plot(t, sizes, color=VERMILLION, linestyle="--", linewidth=1.5, label="landmarks")
    right.set(ylabel="landmarks (-)", ylim=(0, 1.15 * max(np.max(sizes, initial=0), 1)))
    right.grid(False)
    right.spines.right.set_visible(True)
    handles, names = (a + b for a, b in zip(*(x.get_legend_handles_labels() for x in (ax, right)), strict=True))
    names[0] += f" ({ms.sum() / 1000:.3g} s in all)"
    ax.legend(handles, names, loc="lower left", bbox_to_anchor=(0, 1), borderaxespad=0, ncols=3, frameon=False)
    return ax


def covariance_panel(
    P: Array, blocks: Mapping[str, Any], correlation: bool = True, ax: Axes | None = None, title: str = ""
) -> Axes:
    """Draw a covariance matrix as a picture, divided into blocks with names.

    Parameters
    ----------
    P : (n, n)
        Covariance.
    blocks : mapping of str to slice or int
        Name of each block in the order of the states, with its range or its length: ``{"rob": slice(0, 3), "L1": 2}``.
        States between the blocks that are in no block are left out.
    correlation : bool
        Show correlation coefficients, which compare metres with radians, instead of covariances.
    ax : matplotlib Axes, optional
        Where to draw; by default a new figure.
    title : str
        Written above.
    """
    P = np.asarray(P, dtype=float)
    index, edges = _block_index(blocks)
    A = P[np.ix_(index, index)]
    if correlation:
        s = np.sqrt(np.maximum(np.diag(A), 0))
        A = np.divide(A, np.outer(s, s), out=np.zeros_like(A), where=np.outer(s, s) > 0)
    limit = 1.0 if correlation else max(np.abs(A).max(initial=0), np.finfo(float).tiny)
    ax = _axes(ax, (6.4, 5.4))
    image = ax.imshow(A, cmap="PuOr_r", vmin=-limit, vmax=limit, interpolation="nearest")
    for e in edges[1:-1] - 0.5:
        ax.axhline(e, color=BLACK, linewidth=0.7)
        ax.axvline(e, color=BLACK, linewidth=0.7)
    middle = (edges[:-1] + edges[1:] - 1) / 2
    every = max(1, int(np.ceil(len(middle) / 16)))  # more names than that would run into each other
    names = [name if i % every == 0 else "" for i, name in enumerate(blocks)]
    ax.set_xticks(middle, names, rotation=90 if len(middle) > 8 else 0)
    ax.set_yticks(middle, names)
    ax.tick_params(length=0)
    ax.grid(False)
    ax.spines[:].set_visible(True)
    label = "correlation (-)" if correlation else "covariance (products of the states' units)"
    ax.figure.colorbar(image, ax=ax, label=label, fraction=0.046, pad=0.03)
    ax.set_title(title)
    return ax


def _block_index(blocks: Mapping[str, Any]) -> tuple[Array, Array]:
    """Return the state numbers of all blocks, and where each begins and the last ends."""
    index, at = [], 0
    for r in blocks.values():
        r = slice(at, at + r) if isinstance(r, (int, np.integer)) else r
        index.append(np.arange(r.start, r.stop))
        at = r.stop
    edges = np.cumsum([0] + [len(i) for i in index])
    return np.concatenate(index) if index else np.zeros(0, dtype=int), edges


def film_strip(
    images: Sequence[Array],
    captions: Sequence[str] = (),
    columns: int | None = None,
    width: float = 12,
    legend: Mapping[str, Any] | None = None,
):
    """Put frames side by side: a film that can be printed.

    Parameters
    ----------
    images : sequence of (h, w, 3) arrays
        Pictures of equal size, for example by `grab`.
    captions : sequence of str
        A line above each.
    columns : int, optional
        Frames in a row; by default all.
    width : float
        Width of the figure, inches.
    legend : mapping of str to artist, optional
        One legend for the strip, for example ``MapFig.legend``.

    Returns
    -------
    matplotlib Figure
        The strip.
    """
    if len(images) == 0:
        raise ValueError("a film strip needs at least one image, got none")
    columns = columns or len(images)
    rows = -(-len(images) // columns)
    h, w = np.shape(images[0])[:2]
    cell = width / columns
    fig, axes = plt.subplots(
        rows,
        columns,
        figsize=(width, rows * (cell * h / w + 0.35) + 0.6 * bool(legend)),
        squeeze=False,
        layout="constrained",
    )
    for i, ax in enumerate(axes.flat):
        ax.axis("off")
        if i < len(images):
            ax.imshow(images[i], aspect="equal")
            ax.set_title(captions[i] if i < len(captions) else "", fontsize=13)
    if legend:
        fig.legend(legend.values(), legend.keys(), loc="outside lower center", ncols=4, frameon=False)
    return fig
