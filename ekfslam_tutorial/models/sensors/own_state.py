"""What sensors share that see no landmark, but the robot that carries them."""

from typing import ClassVar

import numpy as np


class OwnState:
    """A sensor that gets its own frame in the world, F.x, instead of a point; there is always something to measure.

    See Also
    --------
    Gps, Compass, WheelSpeed, GroundFlow : Those of the package.
    ItsRobot : What stands in the place of a landmark.
    """

    without_lmks: ClassVar[bool] = True
    bearing_only: ClassVar[bool] = False

    def residual(self, y, e):
        """Innovation y - e."""
        return np.subtract(y, e, dtype=float)

    def visible(self, y, v):
        """Return True, for all."""
        return np.full(np.shape(y)[:-1], True)


def speeds(v, n, factor):
    """The first n numbers of the velocity behind a frame in the plane, v = [F.x; v_s; w_s], times a factor."""
    Y_v = np.zeros((n, v.shape[-1]))
    Y_v[:, 3 : 3 + n] = factor * np.eye(n)
    return factor * v[..., 3 : 3 + n], Y_v
