"""An inertial measurement unit: gyrometer and accelerometer drive the state, and their biases are a part of it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame3, hat, q2R, q_prod, v2q


@dataclass(frozen=True)
class Imu:
    """Robot state [t; q; v; b_w; b_a]; control u = [w; a; db_w; db_a]: what the IMU measures, and steps of its biases.

    With w' = w - b_w and a' = a - b_a held over dt, and the rotation taken in the middle of the step:

        g' = R(q * v2q(w' dt / 2)) a' + gravity,      the acceleration in the world,
        t2 = t + v dt + g' dt^2 / 2,   q2 = q * v2q(w' dt),   v2 = v + g' dt,   b2 = b + db.

    J. Solà, "Quaternion kinematics for the error-state Kalman filter", arXiv:1711.02508, sections 5.1 and 5.4.

    Parameters
    ----------
    gyro_noise, acc_noise : float
        Noise densities of a data sheet, rad/s per sqrt(Hz) and m/s^2 per sqrt(Hz).
    gyro_walk, acc_walk : float
        Random walks of the biases, rad/s^2 per sqrt(Hz) and m/s^3 per sqrt(Hz).
    gravity : sequence of 3 floats
        In the world, m/s^2.

    See Also
    --------
    ConstantVelocity : Without any measurement of the motion.
    """

    gyro_noise: float = 1.7e-4
    acc_noise: float = 2e-3
    gyro_walk: float = 2e-5
    acc_walk: float = 3e-3
    gravity: tuple = (0.0, 0.0, -9.81)

    frame: ClassVar = Frame3
    size: ClassVar[int] = 16
    control_fields: ClassVar = {"w_deg": 3, "a": 3, "db_w_deg": 3, "db_a": 3}
    state_fields: ClassVar = {"vel": 3, "gyro_bias_deg": 3, "acc_bias": 3}

    def __post_init__(self):
        for name in ("gyro_noise", "acc_noise", "gyro_walk", "acc_walk"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"Imu: {name} must be zero or a positive number, got {getattr(self, name)!r}")
        if np.shape(self.gravity) != (3,) or not np.isfinite(self.gravity).all():
            raise ValueError(f"Imu: gravity must be 3 finite numbers, got {self.gravity!r}")

    def noise(self, dt):
        """Covariance U of the control over `dt` seconds, shape (12, 12), from the numbers of the data sheet."""
        white, walk = np.array([self.gyro_noise, self.acc_noise]), np.array([self.gyro_walk, self.acc_walk])
        return np.diag(np.repeat(np.concatenate([white**2 / dt, walk**2 * dt]), 3))

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 16)
        u : ndarray, shape (..., 12)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 16)
        X_x : ndarray, shape (..., 16, 16)
        X_u : ndarray, shape (..., 16, 12)
        """
        x, u = np.asanyarray(x), np.asanyarray(u)
        t, q, v, b = x[..., :3], x[..., 3:7], x[..., 7:10], x[..., 10:]
        w, a = u[..., :3] - b[..., :3], u[..., 3:6] - b[..., 3:]
        q2, Q_q, Q_w = _turned(q, w, dt)
        middle, M_q, M_w = _turned(q, w, dt / 2)
        R, R_m = q2R(middle)
        G_m = np.einsum("...ijk,...j->...ik", R_m, a)
        g, G_q, G_w = (R @ a[..., None])[..., 0] + np.array(self.gravity), G_m @ M_q, G_m @ M_w

        x2 = np.concatenate([t + v * dt + g * (dt**2 / 2), q2, v + g * dt, b + u[..., 6:]], -1)
        X_x = np.zeros_like(x2, shape=(*x2.shape, 16))
        X_x[...] = np.eye(16)
        X_x[..., :3, 7:10] = dt * np.eye(3)
        X_x[..., 3:7, 3:7] = Q_q
        X_u = np.zeros_like(x2, shape=(*x2.shape, 12))
        X_u[..., 3:7, :3] = Q_w
        X_u[..., 10:, 6:] = np.eye(6)
        for rows, weight in ((slice(0, 3), dt**2 / 2), (slice(7, 10), dt)):
            X_x[..., rows, 3:7] = weight * G_q
            X_u[..., rows, :3], X_u[..., rows, 3:6] = weight * G_w, weight * R
        X_x[..., :10, 10:] = -X_u[..., :10, :6]  # a bias is subtracted from what is measured
        return x2, X_x, X_u

    def turning(self, x):
        """Derivative of v and the biases by a small turn of the world about its axes: v turns, too, they do not.

        Returns
        -------
        ndarray, shape (..., 9, 3)
            -[v]x above zeros, per radian.
        """
        v = hat(x[..., 7:10])
        return np.concatenate([-v, np.zeros_like(v), np.zeros_like(v)], -2)

    def velocity(self, x, u):
        """Velocity [R(q)' v; w - b_w] in the robot's own frame; without the noise of w. Returns V, V_x (6, size)."""
        v, V_f, V_v = Frame3(x[:7]).to_frame(x[7:10], 0.0)
        V_x = np.zeros((6, len(x)))
        V_x[:3, :7], V_x[:3, 7:10], V_x[3:, 10:13] = V_f, V_v, -np.eye(3)
        return np.concatenate([v, u[:3] - x[10:13]]), V_x

    def part(self, u, U, f):
        """Split a control in time: the share f of it, or with f > 1 the same going on.

        What the IMU measures stays, with white noise: its covariance is divided by f. Steps of the biases are a random
        walk: they and their covariance are multiplied by f.
        """
        d = np.repeat([1.0, f], 6)
        D = np.repeat([f**-0.5, f**0.5], 6)
        return d * u, D[:, None] * U * D


def _turned(q, w, dt):
    """The orientation after a turn with w for `dt` seconds. Returns q2, Q_q, Q_w."""
    dq, DQ_v = v2q(w * dt)
    q2, Q_q, Q_dq = q_prod(q, dq)
    return q2, Q_q, Q_dq @ DQ_v * dt
