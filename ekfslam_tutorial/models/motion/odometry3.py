"""Odometry in space (the manual's `odo3`): the control is the step itself, seen from the robot."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame3, hat, v2q

SMALL = 1e-3  # radians: below it the series is better, its next term is under 1e-10


@dataclass(frozen=True)
class Odometry3:
    """Robot state [t; q]; control u = [dx; dv], a step and a rotation vector in the robot frame (m, rad).

    t2 = t + R(q) dx and q2 = q * v2q(dv): the composition of the frame with the step.

    See Also
    --------
    Odometry2 : The same in the plane.
    ConstantVelocity : Without odometry.
    """

    frame: ClassVar = Frame3
    size: ClassVar[int] = 7
    control_fields: ClassVar = {"dx": 3, "da_deg": 3}
    state_fields: ClassVar = {}

    def move(self, x, u, dt):
        """One step.

        Parameters
        ----------
        x : ndarray, shape (..., 7)
        u : ndarray, shape (..., 6)
        dt : float
            Not used: a step has no duration.

        Returns
        -------
        x2 : ndarray, shape (..., 7)
        X_x : ndarray, shape (..., 7, 7)
        X_u : ndarray, shape (..., 7, 6)
        """
        u = np.asanyarray(u)
        q, Q_v = v2q(u[..., 3:])
        F, X_x, X_s = Frame3(x).compose(Frame3(np.concatenate([u[..., :3], q], -1)))
        X_u = np.concatenate([X_s[..., :3], X_s[..., 3:] @ Q_v], -1)
        return F.x, X_x, X_u

    def part(self, u, U, f):
        """Split a step in time: the share f of it, or with f > 1 the same motion going on.

        Velocities are held, seen from the robot, so it drives a screw, and two parts that follow each other make the
        whole: with dx = V(dv) w, the part is f V(f dv) w and f dv.

        Parameters
        ----------
        u : ndarray, shape (6,)
            A step; less than a full turn.
        U : ndarray, shape (6, 6)
        f : float
            Its share of the time.

        Returns
        -------
        u, U : ndarray
            The part, and its covariance f U: those of the parts add up to U, but for what the turn of the first does
            to the second.
        """
        w = np.linalg.solve(screw(u[3:]), u[:3])
        return np.concatenate([f * screw(f * u[3:]) @ w, f * u[3:]]), f * U


def screw(v):
    """V(v) = int_0^1 R(s v) ds = I + (1 - cos a) / a^2 [v]x + (a - sin a) / a^3 [v]x^2, with the angle a = |v|."""
    a, H = np.linalg.norm(v), hat(v)
    if a < SMALL:
        return np.eye(3) + H / 2 + H @ H / 6
    return np.eye(3) + (1 - np.cos(a)) / a**2 * H + (a - np.sin(a)) / a**3 * H @ H
