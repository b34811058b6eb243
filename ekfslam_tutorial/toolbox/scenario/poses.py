"""Poses as users give them: position and angles."""

import numpy as np

from ...geometry import e2q


def n_angles(frame):
    """Number of angles of a Frame2 (heading) or a Frame3 (roll, pitch, yaw)."""
    return frame.dof - frame.dim


def pose(frame, e):
    """Frame vector of a position and angles.

    Parameters
    ----------
    frame : type
        Frame2 or Frame3.
    e : ndarray, shape (frame.dof,)
        [x, y, heading] or [x, y, z, roll, pitch, yaw], metres and radians; R = Rz(yaw) Ry(pitch) Rx(roll).

    Returns
    -------
    x : ndarray, shape (frame.size,)
    X_e : ndarray, shape (frame.size, frame.dof)
    """
    if frame.size == frame.dof:
        return e, np.eye(frame.dof)
    q, Q_e = e2q(e[frame.dim :])
    X_e = np.zeros((frame.size, frame.dof))
    X_e[: frame.dim, : frame.dim] = np.eye(frame.dim)
    X_e[frame.dim :, frame.dim :] = Q_e
    return np.concatenate([e[: frame.dim], q]), X_e
