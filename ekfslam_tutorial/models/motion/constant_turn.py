"""Constant speed and turn rate in the plane: a robot without odometry, whose speeds are states."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2
from .unicycle import arc


@dataclass(frozen=True)
class ConstantTurn:
    """Robot state [x, y, theta, v, w]; control u = [dv, dw], impulses of speed (m/s) and turn rate (rad/s).

    The arc of a unicycle with the speeds that it has, then v2 = v + dv, w2 = w + dw. "Constant turn rate and velocity":
    R. Schubert, E. Richter, G. Wanielik, "Comparison and evaluation of advanced motion models for vehicle tracking",
    FUSION 2008, eq. 7. For sensors that measure speeds, such as `Doppler` and `WheelSpeed`.

    See Also
    --------
    Unicycle : Speeds as controls.
    ConstantVelocity : In space.
    """

    frame: ClassVar = Frame2
    size: ClassVar[int] = 5
    control_fields: ClassVar = {"dv": 1, "dw_deg": 1}
    state_fields: ClassVar = {"speed": 1, "turn_rate_deg": 1}

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 5)
        u : ndarray, shape (..., 2)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 5)
        X_x : ndarray, shape (..., 5, 5)
        X_u : ndarray, shape (..., 5, 2)

        See Also
        --------
        arc : The step of the pose.
        """
        x, u = np.asanyarray(x), np.asanyarray(u)
        step, S_v = arc(x[..., 3:], dt)
        F, F_f, F_s = Frame2(x[..., :3]).compose(Frame2(step))
        x2 = np.concatenate([F.x, x[..., 3:] + u], -1)
        X_x = np.zeros_like(x2, shape=(*x2.shape, 5))
        X_x[..., :3, :3], X_x[..., :3, 3:], X_x[..., 3:, 3:] = F_f, F_s @ S_v, np.eye(2)
        X_u = np.zeros_like(x2, shape=(*x2.shape, 2))
        X_u[..., 3:, :] = np.eye(2)
        return x2, X_x, X_u

    def turning(self, x):
        """Derivative of v and w by a turn of the world: none, they are the robot's own. Zeros, shape (..., 2, 1).

        See Also
        --------
        gauge : What it is for.
        """
        return np.zeros((*np.shape(x)[:-1], 2, 1))

    def velocity(self, x, u):
        """Velocity [v, 0, w] in the robot's own frame, m/s and rad/s. Returns V, V_x (3, 5).

        See Also
        --------
        Moving : The robot, for a sensor that asks for it.
        """
        V_x = np.zeros((3, 5))
        V_x[0, 3] = V_x[2, 4] = 1.0
        return V_x @ x, V_x

    def part(self, u, U, f):
        """Split an impulse in time: the share f of it, with the covariance f U, as of a random walk."""
        return f * np.asarray(u), f * np.asarray(U)
