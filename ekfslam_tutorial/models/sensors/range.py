"""A distance only: radio beacons, acoustic transponders."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .parameters import check_dim, check_positive


@dataclass(frozen=True)
class Range:
    """Distance of a point, m: y = |p| + bias.

    One range tells no direction, so there is no `retro`: the sensor corrects with landmarks that are in the map
    already. Another sensor may have started them; or they were born as a ring of hypotheses (`toolbox.rings`), which
    asks for `distance`. J. Djugash et al., "Range-only SLAM for robots operating cooperatively with sensor networks",
    ICRA 2006.

    Parameters
    ----------
    range_std : float
        Standard deviation of the measurement noise, m.
    bias : float
        What the sensor always tells too much, m.
    max_range : float
        No point further away than this is seen, m.
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    RangeBearing, RangeBearingElevation : With the direction.
    """

    range_std: float = 0.1
    bias: float = 0.0
    max_range: float = np.inf
    dim: int = 2

    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("m",)

    def __post_init__(self):
        check_positive(self, "range_std", "max_range", infinite=("max_range",))
        if not np.isfinite(self.bias):
            raise ValueError(f"Range: bias must be a finite number of metres, got {self.bias!r}")
        check_dim(self)

    @cached_property
    def R(self):
        """Measurement noise covariance, range_std^2."""
        return np.array([[self.range_std**2]])

    def project(self, p):
        """Point in the sensor frame to its distance. Returns y, Y_p; not finite at the sensor itself."""
        p = np.asanyarray(p)
        r = np.sqrt((p * p).sum(-1))[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            return r + self.bias, (p / r)[..., None, :]

    def distance(self, y):
        """Distance of a point from its measurement: all that one range says. Returns r, shape (...).

        See Also
        --------
        project : The inverse, up to the direction.
        """
        return y[..., 0] - self.bias

    def residual(self, y, e):
        """Innovation y - e, m."""
        return np.subtract(y, e)

    def visible(self, y, p):
        """Return True for each point in range."""
        r = np.sqrt((p * p).sum(-1))
        return (r > 0) & (r <= self.max_range)
