"""Unicycle: forward speed and turn rate, the velocity model of wheeled robots."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2

SMALL = 1e-4  # radians: below it sin(a)/a and its like are replaced by series, next term under 1e-17


def arc(u, dt):
    """The step along a circular arc, seen from its start.

    Parameters
    ----------
    u : ndarray, shape (..., 2)
        [v, w]: forward speed (m/s) and turn rate (rad/s), constant over `dt`.
    dt : float
        s.

    Returns
    -------
    step : ndarray, shape (..., 3)
        [dx, dy, dtheta], m and rad.
    S_u : ndarray, shape (..., 3, 2)

    See Also
    --------
    Unicycle.move : The step from any pose.
    """
    u = np.asanyarray(u)
    v, a = u[..., 0], u[..., 1] * dt
    s, c, s_a, c_a = _curve(a)

    step = np.stack([v * dt * s, v * dt * c, a], -1)
    S_u = np.zeros_like(step, shape=(*step.shape, 2))
    S_u[..., 0, 0], S_u[..., 0, 1] = dt * s, dt * v * dt * s_a
    S_u[..., 1, 0], S_u[..., 1, 1] = dt * c, dt * v * dt * c_a
    S_u[..., 2, 1] = dt
    return step, S_u


def _curve(a):
    """sin(a) / a and (1 - cos(a)) / a, and their derivatives, also where a is small."""
    small = np.abs(a) < SMALL
    safe = np.where(small, 1.0, a)
    s = np.where(small, 1 - a**2 / 6, np.sin(safe) / safe)
    c = np.where(small, a / 2 - a**3 / 24, (1 - np.cos(safe)) / safe)
    s_a = np.where(small, -a / 3, (np.cos(safe) - s) / safe)
    c_a = np.where(small, 0.5 - a**2 / 8, (np.sin(safe) - c) / safe)
    return s, c, s_a, c_a


@dataclass(frozen=True)
class Unicycle:
    """Robot state [x, y, theta]; control u = [v, w], forward speed (m/s) and turn rate (rad/s), constant over dt.

    The robot drives the exact circular arc (Thrun, Burgard, Fox, "Probabilistic Robotics", eq. 5.9), written so that
    it is smooth through w = 0: with a = w dt,

        x2 = x + R(theta) v dt [sin(a)/a, (1 - cos a)/a],   theta2 = theta + a.

    See Also
    --------
    Vehicle : Steered by its front wheels.
    Odometry2 : Driven by measured steps.
    """

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"v": 1, "w_deg": 1}
    state_fields: ClassVar = {}

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 2)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 3)
        X_x : ndarray, shape (..., 3, 3)
        X_u : ndarray, shape (..., 3, 2)
        """
        step, S_u = arc(u, dt)
        F, X_x, X_s = Frame2(x).compose(Frame2(step))
        return F.x, X_x, X_s @ S_u
