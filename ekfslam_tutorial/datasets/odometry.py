"""Commanded speeds become steps between frames, with their covariance.

A log of speeds is dense (10 to 100 Hz); frames are where measurements are. All commands between two frames are put
together into one step of `models.Odometry2`, and the noise of every piece is carried to the end of its step.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class OdometryNoise:
    """Noise of an odometry, how commanded and real motion part: random walks, so the variances grow with the way.

    Parameters
    ----------
    along, across : float
        Position, in and across the direction of travel: metres per square root of a metre travelled.
    turn : float
        Heading: radians per square root of a radian turned.
    drift : float
        Heading: radians per square root of a second under way.
    """

    along: float
    across: float
    turn: float
    drift: float


def dead_reckon(t, v, w):
    """Poses of a robot that does as it is told, from the origin; a command holds until the next one comes.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times of the commands, s, rising.
    v, w : ndarray, shape (n,)
        Forward speed, m/s, and turn rate, rad/s.

    Returns
    -------
    ndarray, shape (n, 3)
        [x, y, theta] at `t`; m, m, rad, the heading is not wrapped. Each piece goes straight in its middle direction,
        which is exact to the third order in its turn.
    """
    dt = np.diff(t)
    theta = np.concatenate([[0.0], np.cumsum(w[:-1] * dt)])
    middle = (theta[1:] + theta[:-1]) / 2
    way = v[:-1] * dt
    x, y = (np.concatenate([[0.0], np.cumsum(way * f(middle))]) for f in (np.cos, np.sin))
    return np.stack([x, y, theta], axis=1)


def steps(t, v, w, times, noise):
    """All steps of a log between its frames, as controls of `models.Odometry2`.

    Parameters
    ----------
    t, v, w : ndarray, shape (n,)
        Commands as in `dead_reckon`. Before the first command the robot stands still, the last one holds.
    times : ndarray, shape (F,)
        Times of the frames, s, strictly rising.
    noise : OdometryNoise

    Returns
    -------
    u : ndarray, shape (F, 3)
        [dx, dy, dtheta] seen from the frame before (m, m, rad). The first one is zero.
    U : ndarray, shape (F, 3, 3)
        Their covariances: for every piece, its noise along and across its direction, and its turn noise, which swings
        the end of the step about the place of the piece: U = sum J diag(q) J'.
    """
    knots = np.union1d(t[(t > times[0]) & (t < times[-1])], times)
    command = np.searchsorted(t, knots, "right") - 1
    v, w = (np.where(command < 0, 0.0, a[command]) for a in (v, w))
    pose = dead_reckon(knots, v, w)
    frames = np.searchsorted(knots, times)
    u, U = np.zeros((len(times), 3)), np.zeros((len(times), 3, 3))
    if len(times) == 1:
        return u, U

    # every piece in the axes of the frame where its step starts, seen from where its step ends
    leads_to = np.searchsorted(times, knots[:-1], "right")
    start, end = pose[frames[leads_to - 1]], pose[frames[leads_to]]
    place = (pose[1:] + pose[:-1]) / 2
    lever = _turned(end[:, :2] - place[:, :2], -start[:, 2])
    c, s = np.cos(place[:, 2] - start[:, 2]), np.sin(place[:, 2] - start[:, 2])
    zero, one = np.zeros_like(c), np.ones_like(c)
    # fmt: off
    J = np.stack([
        np.stack([   c,   -s, -lever[:, 1]], 1),
        np.stack([   s,    c,  lever[:, 0]], 1),
        np.stack([zero, zero,          one], 1),
    ], axis=1)
    # fmt: on
    dt = np.diff(knots)
    way, turn = abs(v[:-1]) * dt, abs(w[:-1]) * dt
    under_way = np.where((v[:-1] != 0) | (w[:-1] != 0), dt, 0.0)
    q = np.stack(
        [noise.along**2 * way, noise.across**2 * way, noise.turn**2 * turn + noise.drift**2 * under_way], axis=1
    )
    U[1:] = np.add.reduceat((J * q[:, None, :]) @ np.swapaxes(J, 1, 2), frames[:-1])

    d = np.diff(pose[frames], axis=0)
    u[1:, :2], u[1:, 2] = _turned(d[:, :2], -pose[frames[:-1], 2]), d[:, 2]
    return u, U


def _turned(p, angle):
    """Points (n, 2) turned by angles (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]], axis=1)
