"""A detector that gives metres: the place of a point, seen from the sensor."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .parameters import check_positive


@dataclass(frozen=True)
class PointXY:
    """Place y = [x, y] of a point in the sensor's frame, m: y = p. What an object detector or a scan matcher tells.

    The source is the sensor frame itself: nothing is between the point and the numbers.

    Parameters
    ----------
    std : float
        Standard deviation of the noise of each coordinate, m.
    max_range : float
        No point further away than this is seen, m.

    See Also
    --------
    PointXYZ : In space.
    RangeBearing : The same two numbers in polar coordinates.
    """

    std: float = 0.1
    max_range: float = np.inf

    dim: ClassVar[int] = 2
    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("m", "m")

    def __post_init__(self):
        check_positive(self, "std", "max_range", infinite=("max_range",))

    @cached_property
    def R(self):
        """Measurement noise covariance, std^2 I."""
        return self.std**2 * np.eye(self.dim)

    def project(self, p):
        """Point in the sensor frame to the measurement: the same numbers. Returns y, Y_p.

        See Also
        --------
        retro : The inverse.
        """
        return p, np.broadcast_to(np.eye(self.dim), (*np.shape(p), self.dim))

    def retro(self, y):
        """Measurement to point: the same numbers. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        return self.project(y)

    def residual(self, y, e):
        """Innovation y - e, m."""
        return np.subtract(y, e)

    def visible(self, y, p):
        """Return True for each point in range."""
        return np.sqrt((y * y).sum(-1)) <= self.max_range


@dataclass(frozen=True)
class PointXYZ(PointXY):
    """Place y = [x, y, z] of a point in the sensor's frame, m: y = p.

    Parameters
    ----------
    std, max_range
        As in `PointXY`.

    See Also
    --------
    PointXY : In the plane.
    RangeBearingElevation : The same three numbers in polar coordinates.
    """

    dim: ClassVar[int] = 3
    units: ClassVar = ("m", "m", "m")
