"""The whole run in one picture: paths, map, truth where it is known, and a caption that is computed from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from .artists import HALO, Labels, dim_of, draw_legend, new_line, put_path
from .bodies import ground_grid, nice_step
from .clip import box, clip_curves, inside
from .ellipses import ellipse_points, ellipsoid_wires, half_axes, nan_separated, sigma_label
from .style import BLACK, DEAD_RECKONING, ESTIMATE, LIGHT_GREY, MEASUREMENT, ROBOTS, TRUTH, line, points
from .views import View, fit_limits

Array = np.ndarray
MANY = 100
"""More landmarks than this are small points, which do not hide each other."""
NAMED = {2: MANY, 3: 40}
"""More landmarks than this have no labels, which would hide the map: in space they lie behind each other, too."""
VAGUE = 0.08
"""An ellipsoid longer than this part of the world is one line: many of them would hide everything."""
LONG = 1500
"""A path of more points than this crosses itself often: a thin line."""


def map_picture(
    path: Array | Mapping[str, Array],
    mean: Array,
    cov: Array,
    ids=None,
    true_path: Array | Mapping[str, Array] | None = None,
    true_points: Array | None = None,
    true_ids=None,
    dead_reckoning: Array | Mapping[str, Array] | None = None,
    fixes: Array | Mapping[str, Array] | None = None,
    k: float = 3,
    title: str = "",
    ax: Any = None,
    figsize=(9, 8),
    colors: Sequence[str] = (),
    lines: tuple | None = None,
    true_edges: Array | None = None,
):
    """Draw trajectories and map over the truth.

    Parameters
    ----------
    path : (F, d) array, or one for each robot by name
        Estimated positions, d = 2 or 3, metres. NaN leaves a gap.
    mean, cov : (n, d), (n, d, d)
        Estimated landmarks.
    ids : sequence of n, optional
        Their ids: labels, and the partners in `true_ids`.
    true_path, dead_reckoning : like `path`, optional
    fixes : (g, d) array, or one for each robot by name, optional
        Positions by a satellite receiver: points, no line. The picture need not have room for all of them.
    true_points, true_ids : (N, d), (N,), optional
        True landmarks and their ids.
    k : float
        Ellipses are drawn at k sigma.
    title : str
        Written above.
    ax : matplotlib axes, optional
        2D or 3D, like the data; by default a new figure.
    figsize : (width, height)
        Of the new figure, inches.
    colors : sequence of colours, optional
        Of the estimated paths; by default those of the robots, in their order.
    lines : (ids, (m, 2, 3), (m, 2, 3, 3)), optional
        Estimated lines, in space: ids, both ends, and their covariances.
    true_edges : (M, 2, 3), optional
        True edges.

    Returns
    -------
    ax
        The axes; ``ax.figure`` is the figure.
    caption : str
        What the picture shows, with numbers: for the log, for ``alt`` texts and for tests. The radius of an
        ellipse is its longest half-axis; landmark errors are those of the landmarks with a true one of the same id.
    """
    paths, truths, dead = (_by_name(p) for p in (path, true_path, dead_reckoning))
    d = next(iter(paths.values())).shape[1]
    mean, cov = np.asarray(mean, dtype=float).reshape(-1, d), np.asarray(cov, dtype=float).reshape(-1, d, d)
    true_points = np.zeros((0, d)) if true_points is None else np.asarray(true_points, dtype=float)
    ids = list(range(1, len(mean) + 1)) if ids is None else list(ids)
    line_ids, ends, ends_cov = lines or ([], np.zeros((0, 2, d)), np.zeros((0, 2, d, d)))
    edges = np.zeros((0, 2, d)) if true_edges is None else np.asarray(true_edges, dtype=float)
    view = None
    if ax is None:
        view = View(plt.figure(figsize=figsize), d)
        view.choose("perspective" if d == 3 else "top")
        ax = view.axes

    axis = k * half_axes(cov)[..., -1]  # the longest half-axis of each ellipse
    spread = np.linalg.norm(axis, axis=-1)
    world = np.concatenate([*paths.values(), *truths.values(), true_points, edges.reshape(-1, d)])
    size = np.ptp(fit_limits(world), axis=1).max()
    vague = (spread > VAGUE * size) & (d == 3)
    near = spread < 0.5 * size
    half = k * np.sqrt(np.diagonal(cov, axis1=1, axis2=2).clip(0))[near] * ~vague[near, None]  # of an ellipse's box
    limits = fit_limits(np.concatenate([world, mean[near] - half, mean[near] + half]))
    if view is None:
        _frame(ax, limits)
    else:
        view.show(limits, {})

    for i, p in enumerate(_by_name(fixes).values()):
        seen = p[inside(p, box(limits))]
        ax.plot(
            *seen.T,
            **points(MEASUREMENT, markersize=3.5, markeredgewidth=0.7),
            zorder=2.5,  # below the paths, which they would bury
            label="GPS" if not i else None,
        )
    _plot_paths(ax, dead, DEAD_RECKONING, "dead reckoning", zorder=2)
    _plot_paths(ax, paths, ESTIMATE, "estimated path", zorder=4, colors=colors or ROBOTS)
    _plot_paths(ax, truths, TRUTH, "true path", zorder=5)
    curves = (ellipse_points if d == 2 else ellipsoid_wires)(mean, cov, k)
    rows = clip_curves(curves[~vague], box(limits))
    ax.plot(*rows.T, **line(ESTIMATE, linewidth=1.1), zorder=3, label=sigma_label(k, d))
    if vague.any():
        rays = clip_curves(np.stack([mean - axis, mean + axis], axis=1)[vague], box(limits))
        ax.plot(*rays.T, **line(ESTIMATE, linewidth=0.7, alpha=0.35), zorder=1, label="its longest axis, where long")
    if line_ids or len(edges):
        _plot_lines(ax, ends, ends_cov, edges, k, limits)
    small = {"markersize": 2.5} if len(mean) > MANY else {}
    if len(mean) or not line_ids:
        ax.plot(*mean.T, **points(ESTIMATE, **small), zorder=6, label="estimated landmark")
    if len(true_points):
        ax.plot(*true_points.T, **points(TRUTH, markeredgewidth=1.1), zorder=5, label="true landmark")
    places = [*zip(ids, mean, strict=True), *zip(line_ids, ends.mean(1), strict=True)]
    shown = {id: p for id, p in places if inside(p, box(limits))}
    shown = shown if len(places) <= NAMED[d] else {}
    stars = true_points[inside(true_points, box(limits))]
    letters: dict[str, Any] = dict(size=12 if len(ids) <= 40 else 10, color=BLACK, zorder=7, **HALO)
    Labels(ax, apart=True, marks=stars, **letters).put(shown)
    handles, names = ax.get_legend_handles_labels()
    if view is None:
        ax.set_title(title)
        ax.legend(handles, names, loc="best")
    else:
        ax.figure.text(0.5, 0.975, title, ha="center", va="top", fontsize=14)
        ground = ground_grid(limits, nice_step(np.ptp(limits[:2], axis=1).max()), np.clip(0.0, *limits[-1]))
        ax.plot(*nan_separated(ground).T, color=LIGHT_GREY, linewidth=0.8, zorder=0)
        draw_legend(ax.figure, dict(zip(names, handles, strict=True)))
    return ax, _caption(paths, truths, mean, spread, ids, true_points, true_ids, k, len(line_ids))


def _by_name(path) -> dict[str, Array]:
    if path is None:
        return {}
    path = path if isinstance(path, Mapping) else {"": path}
    return {name: np.asarray(p, dtype=float) for name, p in path.items()}


def _plot_paths(ax, paths, style, label, zorder, colors=()) -> None:
    """Draw paths; where there are several estimated ones, each has the colour of its robot and its name."""
    ends, several = {}, len(paths) > 1 and style is ESTIMATE
    for i, (name, p) in enumerate(paths.items()):
        look = {"linewidth": 1.8 if len(p) < LONG else 1.1, "label": name if several else label if i == 0 else None}
        if len(paths) > 1 and style is TRUTH:  # it may lie on the others
            look |= {"linewidth": 0.7, "alpha": 0.7}
        if colors:
            look["color"] = colors[i % len(colors)]
        put_path(new_line(ax, **line(style, **look), zorder=zorder), p)
        known = np.flatnonzero(np.isfinite(p).all(axis=1))
        if len(known):
            ends[name] = p[known[-1]]
    if several:
        for i, (name, p) in enumerate(ends.items()):
            Labels(ax, size=12, shift=(16.0, 13.0), color=colors[i % len(colors)], zorder=8, **HALO).put({name: p})


def _frame(ax, limits) -> None:
    ax.set(xlim=limits[0], ylim=limits[1], xlabel="x (m)", ylabel="y (m)")
    if dim_of(ax) == 3:
        ax.set(zlim=limits[2], zlabel="z (m)")
        ax.set_box_aspect(np.ptp(limits, axis=1))
    else:
        ax.set_aspect("equal")


def _plot_lines(ax, ends, cov, edges, k, limits) -> None:
    """Draw lines between their ends with the ellipsoids of these, over the true edges."""
    ax.plot(*clip_curves(ends, box(limits)).T, **line(ESTIMATE, linewidth=2.4), zorder=5, label="estimated line")
    if len(edges):
        ax.plot(*nan_separated(edges).T, **line(TRUTH, linewidth=1.0), zorder=6, label="true edge")
    sure = np.linalg.norm(half_axes(cov)[..., -1], axis=-1) * k < VAGUE * np.ptp(limits, axis=1).max()
    wires = ellipsoid_wires(ends[sure], cov[sure], k)
    ax.plot(*clip_curves(wires, box(limits)).T, **line(ESTIMATE, linewidth=1.1), zorder=3)


def _caption(paths, truths, mean, spread, ids, true_points, true_ids, k, n_lines=0) -> str:
    """One or two sentences with the numbers that the picture shows."""
    words = [f"{len(mean) + n_lines} landmarks mapped" + f", {n_lines} of them lines" * (n_lines > 0)]
    if len(mean):
        words.append(f"median {k:g}σ radius {np.median(spread):.2g} m")
    if len(true_points) and true_ids is not None:
        true = dict(zip(np.asarray(true_ids).tolist(), true_points, strict=True))
        errors = [np.linalg.norm(p - true[id]) for id, p in zip(ids, mean, strict=True) if id in true]
        if errors:
            words.append(f"largest landmark error {max(errors):.2g} m")
    for name, truth in truths.items():
        error = np.linalg.norm(paths[name] - truth, axis=1) if name in paths else np.array([np.nan])
        if np.isfinite(error).any():
            who = f" of {name}" if name else ""
            words.append(f"position RMSE{who} {np.sqrt(np.nanmean(error**2)):.2g} m")
    return ", ".join(words) + "."
