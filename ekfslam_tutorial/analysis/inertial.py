"""Errors of a run with an IMU: gravity is known, so the gauge has four degrees, the place of the start and the yaw."""

import numpy as np

from ..geometry import Frame3, v2q, wrap

SETTLED = 1.0
"""Seconds after the first known pose from which on consistency is looked at: before, truth and estimate differ by less
than the truth is known."""


def upright(points, targets):
    """Least-squares motion between pairs of points that keeps the vertical: a shift, and a turn about z.

    Parameters
    ----------
    points, targets : ndarray, shape (n, 3)
        Metres.

    Returns
    -------
    Frame3
        The frame F of the points, seen from the targets, as `geometry.align` gives it.

    Raises
    ------
    ValueError
        If the points do not fix a turn about the vertical.
    """
    if len(points) < 3:
        raise ValueError(f"{len(points)} points do not fix a turn about the vertical")
    a, b = points - points.mean(0), targets - targets.mean(0)
    (x, y), (X, Y) = a[:, :2].T, b[:, :2].T
    s, c = x @ Y - y @ X, x @ X + y @ Y
    if np.hypot(s, c) <= 1e-12 * max(x @ x + y @ y, 1e-12):
        raise ValueError(f"{len(points)} points do not fix a turn about the vertical")
    F = Frame3(np.concatenate([np.zeros(3), v2q(np.array([0.0, 0.0, np.arctan2(s, c)]))[0]]))
    return Frame3(np.concatenate([targets.mean(0) - F.R @ points.mean(0), F.q]))


def rotation_rmse(x, truth):
    """RMSE of orientations after one constant rotation of the body has been taken away, rad.

    How a truth is mounted on its robot is often known less well than its path: EuRoC's V1_01 is 6 deg off.

    Parameters
    ----------
    x, truth : ndarray, shape (n, 3) or (n, 7)
        Poses in one frame.
    """
    if not len(x):
        return np.nan
    if x.shape[1] == 3:
        e = wrap(x[:, 2] - truth[:, 2])
        e = wrap(e - np.arctan2(np.sin(e).sum(), np.cos(e).sum()))
        return float(np.sqrt((e**2).mean()))
    from scipy.spatial.transform import Rotation  # here: it takes a while to load

    R, Rt = (Rotation.from_quat(a[:, [4, 5, 6, 3]]) for a in (x, truth))
    body = Rt.inv() * R
    return float(np.sqrt(((body * body.mean().inv()).magnitude() ** 2).mean()))


def motion_errors(t, p, v, P, truth):
    """Errors of position and velocity relative to the first known position, yaw laid on the truth.

    Parameters
    ----------
    t : ndarray, shape (n,)
        s.
    p, v : ndarray, shape (n, 3)
        Estimates.
    P : ndarray, shape (n, 6, 6)
        Their covariance, relative to where the filter has started.
    truth : ndarray, shape (n, 3)
        True positions, NaN where not known; velocities are their differences.

    Returns
    -------
    e : ndarray, shape (K, 6)
        In the axes of the estimate, where the true position is known; NaN until `SETTLED` seconds after the first.
    P : ndarray, shape (K, 6, 6)
    """
    k = np.flatnonzero(np.isfinite(truth).all(1))
    t, p, v, P, g = t[k], p[k], v[k], P[k], truth[k]
    try:
        g = upright(g, p).from_frame(g)[0]
    except ValueError:
        return np.full((len(k), 6), np.nan), P
    e = np.concatenate([(p - p[0]) - (g - g[0]), v - np.gradient(g, t, axis=0)], 1)
    settled = (t >= t[0] + SETTLED) & (np.arange(len(t)) < len(t) - 1)  # at the end there is half a difference only
    e[~settled] = np.nan
    return e, P
