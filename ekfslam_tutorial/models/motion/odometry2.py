"""Odometry in the plane: the control is the step itself, seen from the robot."""

from dataclasses import dataclass
from typing import ClassVar

from ...geometry import Frame2


@dataclass(frozen=True)
class Odometry2:
    """Robot state [x, y, theta]; control u = [dx, dy, dtheta], a step in the robot frame (m, m, rad).

    The new pose is the composition of the old one with the step: the 2D twin of `Odometry3`.

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
