"""Odometry in the plane: the control is the step itself, seen from the robot."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2
from .unicycle import arc


@dataclass(frozen=True)
class Odometry2:
    """Robot state [x, y, theta]; control u = [dx, dy, dtheta], a step in the robot frame (m, m, rad).

    The new pose is the composition of the old one with the step: the 2D twin of `Odometry3`.
    R. Smith, M. Self, P. Cheeseman, "Estimating uncertain spatial relationships in robotics", 1990, compounding.

    See Also
    --------
    Odometry3 : The same in space.
    Unicycle : Driven by speed and turn rate.
    """

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"dx": 2, "da_deg": 1}
    state_fields: ClassVar = {}

    def move(self, x, u, dt):
        """One step.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 3)
        dt : float
            Not used: a step has no duration.

        Returns
        -------
        x2 : ndarray, shape (..., 3)
            The heading is not wrapped; `Frame2.normalized` does that.
        X_x, X_u : ndarray, shape (..., 3, 3)
        """
        F, X_x, X_u = Frame2(x).compose(Frame2(u))
        return F.x, X_x, X_u

    def part(self, u, U, f):
        """Split a step in time: the share f of it, or with f > 1 the same motion going on.

        Forward speed, sideways speed and turn rate are held, so the robot drives an arc, and two parts that follow each
        other make the whole. With the arc of angle a as a complex number, z(a) = (sin a + i (1 - cos a)) / a, the step
        is dx + i dy = w z(da), and its part f w z(f da).

        Parameters
        ----------
        u : ndarray, shape (3,)
            A step; less than a full turn.
        U : ndarray, shape (3, 3)
        f : float
            Its share of the time.

        Returns
        -------
        u, U : ndarray
            The part, and its covariance f U: those of the parts add up to U, but for what the turn of the first does
            to the second.
        """
        z = lambda a: complex(*arc(np.array([1.0, a]), 1.0)[0][:2])
        d = f * complex(u[0], u[1]) * z(f * u[2]) / z(u[2])
        return np.array([d.real, d.imag, f * u[2]]), f * U
