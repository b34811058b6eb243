"""Constant velocity in space (the manual's `constVel`): the control is a random impulse of the velocities."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame3, hat, q_prod, v2q


@dataclass(frozen=True)
class ConstantVelocity:
    """Robot state [t; q; v; w]; control u = [dv; dw], impulses of linear (m/s) and angular velocity (rad/s).

    t2 = t + v dt,  q2 = q * v2q(w dt),  v2 = v + dv,  w2 = w + dw:
    v in the world, w in the robot frame, as in the manual. A robot without odometry: a hand-held camera.

    See Also
    --------
    Odometry3 : With odometry.
    """

    frame: ClassVar = Frame3
    size: ClassVar[int] = 13
    control_fields: ClassVar = {"dv": 3, "dw_deg": 3}
    state_fields: ClassVar = {"vel": 3, "ang_vel_deg": 3}

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 13)
        u : ndarray, shape (..., 6)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 13)
        X_x : ndarray, shape (..., 13, 13)
        X_u : ndarray, shape (..., 13, 6)
        """
        x, u = np.asanyarray(x), np.asanyarray(u)
        t, q, v, w = x[..., :3], x[..., 3:7], x[..., 7:10], x[..., 10:]
        dq, DQ_dv = v2q(w * dt)
        q2, Q_q, Q_dq = q_prod(q, dq)

        x2 = np.concatenate([t + v * dt, q2, v + u[..., :3], w + u[..., 3:]], -1)
        X_x = np.zeros_like(x2, shape=(*x2.shape, 13))
        X_x[...] = np.eye(13)
        X_x[..., :3, 7:10] = dt * np.eye(3)
        X_x[..., 3:7, 3:7] = Q_q
        X_x[..., 3:7, 10:] = Q_dq @ DQ_dv * dt
        X_u = np.zeros_like(x2, shape=(*x2.shape, 6))
        X_u[..., 7:, :] = np.eye(6)
        return x2, X_x, X_u

    def turning(self, x):
        """Derivative of v and w by a small turn of the whole world about its axes: v turns, too, w does not.

        Returns
        -------
        ndarray, shape (..., 6, 3)
            -[v]x above zeros, per radian.
        """
        v = hat(x[..., 7:10])
        return np.concatenate([-v, np.zeros_like(v)], -2)

    def velocity(self, x, u):
        """Velocity [R(q)' v; w] in the robot's own frame, m/s and rad/s. Returns V, V_x (6, 13)."""
        v, V_f, V_v = Frame3(x[:7]).to_frame(x[7:10], 0.0)
        V_x = np.zeros((6, 13))
        V_x[:3, :7], V_x[:3, 7:10], V_x[3:, 10:] = V_f, V_v, np.eye(3)
        return np.concatenate([v, x[10:]]), V_x

    def part(self, u, U, f):
        """Split an impulse in time: the share f of it, with the covariance f U, as of a random walk."""
        return f * np.asarray(u), f * np.asarray(U)
