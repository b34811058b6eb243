"""Trajectories in the TUM format, which `evo` and others read: one file for each robot, and one for its truth."""

import numpy as np

from ..geometry import e2q
from .files import written


def write_tum(out, history):
    """Write trajectory-N.tum, and truth-N.tum where the truth is known; return their names.

    A row is `t x y z qx qy qz qw`: seconds, metres, unit quaternion with the scalar last. Poses are in the frame of the
    map, so compare them with alignment: `evo_ape tum truth-1.tum trajectory-1.tum --align`.
    """
    names = []
    for id in history.robots:
        track = history.track(id)
        names.append(_write(out / f"trajectory-{id}.tum", tum_rows(track.t, track.x)))
        if track.known.any():
            names.append(_write(out / f"truth-{id}.tum", tum_rows(track.t[track.known], track.truth[track.known])))
    return names


def tum_rows(t, x):
    """Rows (F, 8) of poses x (F, 3), [x y theta], or (F, 7), [t; q] with the scalar first."""
    if x.shape[1] == 7:
        return np.column_stack([t, x[:, :3], x[:, 4:], x[:, 3]])
    q = e2q(x[:, 2:] * [0.0, 0.0, 1.0])[0]
    return np.column_stack([t, x[:, :2], np.zeros(len(t)), q[:, 1:], q[:, 0]])


def _write(path, rows):
    with written(path, text=True) as file:
        np.savetxt(file, rows, fmt="%.9f")
    return path.name
