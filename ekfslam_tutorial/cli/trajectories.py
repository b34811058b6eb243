"""Trajectories in the formats of TUM, KITTI and EuRoC, which `evo` and others read, with covariances beside them.

A pose in the plane is one in space without height. `NAME-cov.txt` has a row for each pose: the upper triangle of the
covariance of [x y theta], or of [x y z rx ry rz] (position along the axes of the map, rotation about those of the
robot), as `ekfslam audit` reads it.
"""

import numpy as np

from ..geometry import Frame2, Frame3, e2q
from .files import written

EUROC = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []"


def in_space(x):
    """Poses (F, 3) or (F, 7) as [t; q], the scalar first, shape (F, 7)."""
    if x.shape[1] == 7:
        return x
    return np.column_stack([x[:, :2], np.zeros(len(x)), e2q(x[:, 2:] * [0.0, 0.0, 1.0])[0]])


def tum_rows(t, x):
    """Rows `t x y z qx qy qz qw` of poses."""
    x = in_space(x)
    return np.column_stack([t, x[:, :3], x[:, 4:], x[:, 3]])


def kitti_rows(x):
    """Rows of [R t], 12 numbers by rows; KITTI has no stamps."""
    F = Frame3(in_space(x))
    return np.concatenate([F.R, F.t[..., None]], -1).reshape(-1, 12)


def cov_rows(frame, x, P):
    """Upper triangles of the covariances of poses, in their tangent space."""
    F = frame(x)
    _, E_x = F.minus(F)
    P = E_x @ P @ np.swapaxes(E_x, -1, -2)
    i, j = np.triu_indices(P.shape[-1])
    return P[:, i, j]


def write_text(path, rows, fmt="%.9f", header=""):
    """Write numbers in columns; return the file's name."""
    with written(path, text=True) as file:
        np.savetxt(file, rows, fmt=fmt, header=header, comments="")
    return path.name


def write_tum(out, history):
    """Write trajectory-N.tum, and truth-N.tum where the truth is known; return their names.

    A row is `t x y z qx qy qz qw`: seconds, metres, unit quaternion with the scalar last. Poses are in the frame of the
    map, so compare them with alignment: `evo_ape tum truth-1.tum trajectory-1.tum --align`.
    """
    names = []
    for what, _, t, x in _paths(history):
        names.append(write_text(out / f"{what}.tum", tum_rows(t, x)))
    return names


def write_kitti(out, history):
    """Write trajectory-N.kitti with the times in trajectory-N-times.txt, and the truth."""
    names = []
    for what, _, t, x in _paths(history):
        names.append(write_text(out / f"{what}.kitti", kitti_rows(x), "%.12g"))
        names.append(write_text(out / f"{what}-times.txt", t))
    return names


def write_euroc(out, history):
    """Write trajectory-N.csv and truth-N.csv: nanoseconds, position, quaternion with the scalar first."""
    names = []
    for what, _, t, x in _paths(history):
        with written(out / f"{what}.csv", text=True) as file:
            file.write(EUROC + "\n")
            for ns, pose in zip(np.round(1e9 * t).astype(np.int64), in_space(x), strict=True):
                file.write(",".join([str(ns), *(f"{v:.12g}" for v in pose)]) + "\n")
        names.append(f"{what}.csv")
    return names


def write_covariances(out, history):
    """Write trajectory-N-cov.txt; return their names."""
    tracks = [history.track(id) for id in history.robots]
    rows = {track.id: cov_rows(track.frame, track.x, track.P) for track in tracks}
    return [write_text(out / f"trajectory-{id}-cov.txt", a, "%.12g") for id, a in rows.items()]


def _paths(history):
    """Name, robot, times and poses of each path: the estimated one, and the true one where it is known."""
    for id in history.robots:
        track = history.track(id)
        yield f"trajectory-{id}", id, track.t, track.x
        if track.known.any():
            yield f"truth-{id}", id, track.t[track.known], track.truth[track.known]


def frames_of(track):
    """A track's poses and covariances in space: (F, 7), and (F, 6, 6) with rotations about the axes of the map."""
    F, n = track.frame(track.x), len(track.x)
    _, E_x = F.minus(F)
    P = E_x @ track.P @ np.swapaxes(E_x, -1, -2)
    if track.frame is Frame2:
        full, at = np.zeros((n, 6, 6)), np.array([0, 1, 5])
        full[:, at[:, None], at] = P
        return in_space(track.x), full
    turn = np.tile(np.eye(6), (n, 1, 1))
    turn[:, 3:, 3:] = F.R
    return track.x, turn @ P @ np.swapaxes(turn, -1, -2)
