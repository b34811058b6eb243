"""What a state log says without a player: a film strip, and a caption with numbers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from ..artists import Labels, draw_legend
from ..ellipses import ellipse_points, ellipsoid_wires, nan_separated, sigma_label
from ..picture import map_picture
from ..style import ESTIMATE, line
from ..views import fit_limits
from .frames import LogFrame
from .state_log import StateLog

Array = np.ndarray


def log_strip(log: StateLog, n: int = 3, width: float = 12, at: Sequence[int] = ()):
    """Draw frames of a log side by side, in the same axes, with one legend.

    Parameters
    ----------
    log : StateLog
    n : int
        How many, evenly spaced, the last one included.
    width : float
        Of the strip, inches.
    at : sequence of int, optional
        Numbers of the frames, instead; the log must have them.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    ValueError
        If the log has no frame, or not one of those that are asked for.
    """
    frames, d = _frames(log), log.to_dict(frames=False)["dim"]
    chosen = np.unique(np.linspace(0, len(frames) - 1, n + 1).round().astype(int)[1:])
    if at:
        place = {frame.k: i for i, frame in enumerate(frames)}
        missing = [k for k in at if k not in place]
        if missing:
            raise ValueError(f"the log has no frame {missing[0]}; it has {len(place)} of {min(place)} to {max(place)}")
        chosen = [place[k] for k in at]
    places = [_path(frames, id, d) for id in frames[-1].robots]
    places += [_known_places(frames[i], d) for i in (*chosen, len(frames) - 1)]
    limits = fit_limits(np.concatenate(places), margin=0.16)  # room for the names of those at the edge, too
    cell = width / len(chosen)
    fig = plt.figure(figsize=(width, min(cell, 4.5) + 1.0))
    entries: dict = {}
    for column, i in enumerate(chosen):
        ax: Any = _axes(fig, column * cell, cell, d)
        _draw(ax, frames[: i + 1], d, log.k)
        ax.set(**{f"{axis}lim": limit for axis, limit in zip("xyz", limits, strict=False)})
        if d == 3:  # the same scales in each picture, and room for the numbers of the z axis
            ax.set_box_aspect(np.ptp(limits, axis=1), zoom=0.92)
        ax.set_title(f"frame {frames[i].k}, t = {frames[i].t:.1f} s", fontsize=13)
        handles, names = ax.get_legend_handles_labels()
        entries |= {name: h for h, name in zip(handles, names, strict=True) if _is_drawn(h)}
    draw_legend(fig, entries)
    return fig


def _axes(fig, left, cell, d):
    """Add axes in a cell of the strip, with room for their numbers; inches."""
    w, h = fig.get_size_inches()
    if d == 3:
        rect = (left / w, 0.55 / h, (cell - 0.45) / w, 1 - 1.0 / h)
        ax = fig.add_axes(rect, projection="3d", computed_zorder=False)
        ax.tick_params(labelsize=10, pad=0)
        ax.locator_params(nbins=5)
        ax.locator_params(axis="z", nbins=3)
        ax.zaxis.labelpad = -2
        return ax
    ax = fig.add_axes(((left + 0.9) / w, 1.25 / h, (cell - 1.0) / w, 1 - 1.65 / h))
    ax.locator_params(nbins=6)
    return ax


def _is_drawn(curve) -> bool:
    """Say whether a line has a point that is not NaN."""
    return bool(np.isfinite(curve.get_data_3d() if hasattr(curve, "get_data_3d") else curve.get_data()).any())


def log_caption(log: StateLog) -> str:
    """Return what happens in a log in two sentences, with numbers of two or three digits.

    Parameters
    ----------
    log : StateLog
        Measurements are counted if it has some, and all: not if frames of the run are left out.
    """
    frames = _frames(log)
    last, obs = frames[-1], [o for frame in frames for o in frame.obs]
    used, gone = sum(o.updated for o in obs), sum(len(frame.gone) for frame in frames)
    words = []
    if obs and all(after.k == frame.k + 1 for frame, after in pairwise(frames)):
        words.append(f"{_count(used, 'measurement')} used, {len(obs) - used} rejected")
    if gone:
        words.append(f"{_count(gone, 'landmark')} deleted")
    radii = [log.k * np.linalg.norm(L, ord=2) for _, L in last.lmks.values() if np.isfinite(L).all()]
    ending = [f"{_count(len(last.lmks), 'landmark')} in the map"]
    if radii and np.median(radii) > 0:
        ending.append(f"median {log.k:g}σ radius {np.median(radii):.2g} m")
    for id, (x, L, _) in last.robots.items():
        if id in last.truth and L.any():  # not where the pose is known
            far = np.linalg.norm(x[: len(last.truth[id]) // 2 + 1] - last.truth[id][: len(x) // 2 + 1])
            who = f"robot {id}" if len(last.robots) > 1 else "the robot"
            ending.append(f"{who} {far:.2g} m from its true position")
    events = f": {', '.join(words)}" if words else ""
    return f"{_count(len(frames), 'frame')}, {last.t - frames[0].t:.3g} s{events}. At the end: {', '.join(ending)}."


def _frames(log: StateLog) -> list[LogFrame]:
    frames = log.frames()
    if not frames:
        raise ValueError("there is nothing to show: the state log has no frame")
    return frames


def _count(n: int, word: str) -> str:
    return f"{n} {word}{'s' * (n != 1)}"


def _path(frames, id, d, truth=False) -> Array:
    """Return the positions (F, d) of a robot; NaN where it has none."""
    nowhere = np.full(d, np.nan)
    if truth:
        return np.array([frame.truth.get(id, nowhere)[:d] for frame in frames])
    return np.array([frame.robots[id][0][:d] if id in frame.robots else nowhere for frame in frames])


def _known_places(frame, d) -> Array:
    """Return the true landmarks and the estimates that know where they are (n, d)."""
    near = [p for p, L in frame.lmks.values() if np.isfinite(L).all() and np.linalg.norm(L) < 1]
    return np.array([*near, *frame.world.values()]).reshape(-1, d)


def _draw(ax, frames, d, k) -> None:
    """Draw the last of the frames, and the paths up to it."""
    frame = frames[-1]
    lmks = {id: (p, L) for id, (p, L) in frame.lmks.items() if np.isfinite(p).all() and np.isfinite(L).all()}
    true = np.array([p for p in frame.world.values() if np.isfinite(p).all()]).reshape(-1, d)
    map_picture(
        {f"robot {id}": _path(frames, id, d) for id in frame.robots},
        np.array([p for p, _ in lmks.values()]).reshape(-1, d),
        np.array([L @ L.T for _, L in lmks.values()]).reshape(-1, d, d),
        ids=list(lmks),
        true_path={f"robot {id}": _path(frames, id, d, truth=True) for id in frame.truth} or None,
        true_points=true,
        k=k,
        ax=ax,
    )
    ax.get_legend().remove()
    for x, L, _ in frame.robots.values():
        if L.any():  # not where the pose is known
            curves = (ellipse_points if d == 2 else ellipsoid_wires)(x[:d], L @ L.T, k)
            ax.plot(*nan_separated(curves).T, **line(ESTIMATE, linewidth=1.1), zorder=6, label=sigma_label(k, d))
    if d == 3:  # the picture is small: markers too, and no names
        for curve in ax.lines:
            curve.set_markersize(0.6 * curve.get_markersize())
        for names in [c for c in ax.collections if isinstance(c, Labels)]:
            names.remove()
