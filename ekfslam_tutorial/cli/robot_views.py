"""Pictures of each robot of a run: its path and map, its errors within 3 sigma, and whether the filter is honest."""

import matplotlib.pyplot as plt
import numpy as np

from ..analysis.consistency import md2
from ..graphics import consistency_panel, error_panel, map_picture
from ..graphics.panels import GAP
from ..graphics.style import ROBOTS
from .files import save_figure

AXES = {
    2: [("x error", "m"), ("y error", "m"), ("heading error", "deg")],
    3: [*((f"{a} error", "m") for a in "xyz"), *((f"rotation about {a}", "deg") for a in "xyz")],
}
MOTION = [*((f"{a} error", "m") for a in "xyz"), *((f"velocity {a} error", "m/s") for a in "xyz")]
"""Errors of a robot with an IMU."""
MOST_POINTS = 120
"""NIS of a long run is averaged: single values would only zigzag, and a mean of many has a narrower band."""


def write_robot_figures(out, history, tracks, lmks, data, fixes):
    """Write map-N.png, errors-N.png and consistency-N.png for each robot; return their names.

    Parameters
    ----------
    out : Path
    history : History
    tracks : dict of int to Track
        In the frame of the truth, if that is known.
    lmks : dict
        Arguments of `map_picture` for the landmarks: mean, cov, ids, true_points, true_ids.
    data : UserData
    fixes : dict of int to ndarray, shape (g, d)
        Positions by a satellite receiver, where there are any.
    """
    names = []
    for id, track in tracks.items():
        if len(tracks) > 1:
            color = ROBOTS[list(tracks).index(id) % len(ROBOTS)]
            names.append(save_figure(_path(track, lmks, data, fixes.get(id), color), out / f"map-{id}.png"))
        e, P = history.errors(id)
        if track.known.sum() > 1 and P.any():  # a robot whose place is given has no errors
            names.append(
                save_figure(_errors(track, e, P, data.figure.k, history.error_of(id)), out / f"errors-{id}.png")
            )
        nees, nis = md2(e, P), history.nis(id)
        if len(nis) > 1 or np.isfinite(nees).any():
            names.append(
                save_figure(_consistency(track, nees, nis, history.error_of(id)), out / f"consistency-{id}.png")
            )
    return names


def _path(track, lmks, data, fixes, color):
    dim = track.frame.dim
    axes, _ = map_picture(
        track.x[:, :dim],
        **lmks,
        true_path=track.truth[:, :dim] if track.known.any() else None,
        fixes=fixes,
        k=data.figure.k,
        title=f"{data.name}: robot {track.id}",
        colors=[color],
    )
    return axes.figure


def _errors(track, e, P, k, of="pose"):
    """Errors over time where the truth is known, each inside its band: both in one gauge, see `History.errors`."""
    sigma = np.sqrt(np.diagonal(P, axis1=1, axis2=2).clip(0))
    names = AXES[track.frame.dim] if of == "pose" else MOTION
    scale = np.array([180 / np.pi if unit == "deg" else 1.0 for _, unit in names])
    columns = len(names) // 3  # in space rotations stand beside positions
    size = (9 + 5 * (columns - 1), 7.6)
    fig, table = plt.subplots(3, columns, figsize=size, sharex=True, squeeze=False, layout="constrained")
    panels = table.T.ravel()
    for i, ((name, unit), ax) in enumerate(zip(names, panels, strict=True)):
        t, scaled = track.t[track.known], scale[i]
        error_panel(t, scaled * e[:, i], scaled * sigma[:, i], k, name, unit, ax=ax, legend=False)
        if ax not in table[-1]:
            ax.set_xlabel("")
    entries = {}
    for ax in panels:  # what they share is said once
        for handle, words in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(words.split(":")[0], handle)
    fig.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=3, frameon=False)
    fig.suptitle(f"robot {track.id}")
    return fig


def _consistency(track, value, nis, of="pose"):
    """NEES of the pose, where the truth is known, and below it NIS of the innovations used; each with its 95 % band."""
    t = track.t[track.known]
    rows = int(np.isfinite(value).any()) + int(len(nis) > 0)
    fig, panels = plt.subplots(rows, 1, figsize=(9, 0.5 + 3 * rows), sharex=True, squeeze=False, layout="constrained")
    if np.isfinite(value).any():
        consistency_panel(t, value, track.frame.dof, name=f"NEES of the {of}", ax=panels[0, 0])
    if len(nis):
        t, value, dof, n = _averaged(nis)
        name = "NIS" if n.max() == 1 else f"NIS, means of {n.max()}"
        consistency_panel(t, value, dof, runs=n, name=name, ax=panels[-1, 0])
        panels[-1, 0].set_ylabel("NIS (-)")
    if len(track.t) > 1:  # of both panels, and the whole run: neither begins or ends later than the other
        panels[0, 0].set_xlim(track.t[0], track.t[-1])
    fig.suptitle(f"robot {track.id}" if track.known.any() else f"robot {track.id}, whose true pose is not known")
    return fig


def _averaged(nis):
    """NIS (K, 3) of [t, value, dof] as t, value and dof of groups that follow each other, and their sizes.

    No group reaches across a gap in time; the last one before it may be smaller.
    """
    most = -(-len(nis) // MOST_POINTS)
    t = nis[:, 0]
    step = np.diff(t)
    usual = np.median(step[step > 0]) if (step > 0).any() else 0.0
    starts = np.concatenate([[0], np.flatnonzero(step > GAP * max(usual, 1e-12)) + 1, [len(t)]])
    edges = np.concatenate([np.arange(a, b, most) for a, b in zip(starts[:-1], starts[1:], strict=True)])
    n = np.diff(edges, append=len(t))
    t, value, dof = (np.add.reduceat(nis, edges) / n[:, None]).T
    return t, value, dof, n
