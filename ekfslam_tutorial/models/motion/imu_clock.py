"""An inertial measurement unit whose clock is not that of the camera: the offset is a part of the state."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .imu import Imu


@dataclass(frozen=True)
class ImuClock(Imu):
    """Robot state [t; q; v; b_w; b_a; s]: that of `Imu`, and by how many seconds s the clock of the IMU is ahead.

    What the IMU measures at the time t of the camera, it has stamped with t + s. So to the control belong the rates r
    at which its w and a change, and the control of `Imu` is [w; a] + s r, exact to first order in s. Take the rates
    of the motion, not of the noise: of a curve through many measurements. M. Li, A. I. Mourikis, "Online
    temporal calibration for camera-IMU systems", Int. J. Robotics Research 33(7):947-964, 2014, has the same state in
    another form.

    See Also
    --------
    Imu : With one clock.
    """

    size: ClassVar[int] = 17
    control_fields: ClassVar = {**Imu.control_fields, "w_rate_deg": 3, "a_rate": 3}
    state_fields: ClassVar = {**Imu.state_fields, "clock": 1}

    def noise(self, dt):
        """Covariance U of the control over `dt` seconds, shape (18, 18); the rates have none of their own."""
        U = np.zeros((18, 18))
        U[:12, :12] = super().noise(dt)
        return U

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 17)
        u : ndarray, shape (..., 18)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 17)
        X_x : ndarray, shape (..., 17, 17)
        X_u : ndarray, shape (..., 17, 18)
        """
        x, u = np.asanyarray(x), np.asanyarray(u)
        s, rates = x[..., 16:], u[..., 12:]
        measured = np.concatenate([u[..., :6] + s * rates, u[..., 6:12]], -1)
        y, Y_x, Y_u = super().move(x[..., :16], measured, dt)
        x2 = np.concatenate([y, s], -1)
        X_x = np.zeros_like(x2, shape=(*x2.shape, 17))
        X_x[..., :16, :16] = Y_x
        X_x[..., :16, 16] = (Y_u[..., :6] @ rates[..., None])[..., 0]
        X_x[..., 16, 16] = 1.0
        X_u = np.zeros_like(x2, shape=(*x2.shape, 18))
        X_u[..., :16, :12] = Y_u
        X_u[..., :16, 12:] = s[..., None] * Y_u[..., :6]
        return x2, X_x, X_u

    def turning(self, x):
        """Derivative of v, the biases and the clock by a turn of the world: see `Imu.turning`. Shape (..., 10, 3)."""
        turned = super().turning(x)
        return np.concatenate([turned, np.zeros_like(turned[..., :1, :])], -2)

    def velocity(self, x, u):
        """Velocity in the robot's own frame: see `Imu.velocity`; w is that of the camera's time. Returns V, V_x."""
        V, V_x = super().velocity(x, u[:6] + x[16] * u[12:])
        V_x[3:, 16] = u[12:15]
        return V, V_x

    def part(self, u, U, f):
        """Split a control in time: see `Imu.part`; the rates stay."""
        D = np.concatenate([np.repeat([f**-0.5, f**0.5], 6), np.ones(6)])
        return np.concatenate([np.repeat([1.0, f], 6), np.ones(6)]) * u, D[:, None] * U * D
