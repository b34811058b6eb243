"""Odometry in space (the manual's `odo3`): the control is the step itself, seen from the robot."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame3, v2q


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
