"""NewSensor: a sensor of your own. It works as it is (range and bearing in the plane); make it yours.

What a sensor must have, and the equation of each part:

    project   y = h(p)      measurement of a point p in the sensor's frame, and its Jacobian Y_p = dy/dp
    retro     v = h^-1(y)   the point, or the ray, that is measured as y, and its Jacobian V_y = dv/dy
    residual  z = y - e     the innovation; wrap angles here
    visible                 what the sensor can see
    R                       covariance of the measurement noise
    bearing_only            True if a measurement leaves the distance open: then `retro` gives a ray of any length

Points come as rows (..., d), so one call serves many landmarks: index with [..., 0], never with [0]. Write plain numpy,
with `np.where` for a decision by a value: the fast engine compiles what it can, numpy does the rest.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ekfslam_tutorial.geometry import wrap


@dataclass(frozen=True)
class NewSensor:
    """Say here what the sensor measures, with units.

    Parameters
    ----------
    range_std : float
        Standard deviation of the range, m. Parameters are what a user can set: one line each.
    bearing_std : float
        Standard deviation of the bearing, rad.
    max_range : float
        It sees so far, m.
    """

    range_std: float = 0.1
    bearing_std: float = 0.02
    max_range: float = 10.0

    dim: ClassVar[int] = 2  # of its world: 2 or 3
    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("m", "rad")  # of the measurement, for figures
    angles: ClassVar = ("bearing_std",)  # parameters in radians: a scenario may give them in degrees, NAME_deg

    @cached_property
    def R(self):
        """Covariance of the measurement noise, shape (m, m)."""
        return np.diag([self.range_std**2, self.bearing_std**2])

    def project(self, p):
        """Measurement of points: y = [hypot(x, y), atan2(y, x)].

        Parameters
        ----------
        p : ndarray, shape (..., 2)
            Points in the sensor's frame, m.

        Returns
        -------
        y : ndarray, shape (..., m)
        Y_p : ndarray, shape (..., m, 2)
        """
        x, y = p[..., 0], p[..., 1]
        r = np.hypot(x, y)
        Y_p = np.stack([np.stack([x / r, y / r], -1), np.stack([-y / r**2, x / r**2], -1)], -2)
        return np.stack([r, np.arctan2(y, x)], -1), Y_p

    def retro(self, y):
        """Point that is measured as y: v = r [cos b, sin b].

        Returns
        -------
        v : ndarray, shape (..., 2)
        V_y : ndarray, shape (..., 2, m)
        """
        r, c, s = y[..., 0], np.cos(y[..., 1]), np.sin(y[..., 1])
        V_y = np.stack([np.stack([c, -r * s], -1), np.stack([s, r * c], -1)], -2)
        return np.stack([r * c, r * s], -1), V_y

    def residual(self, y, e):
        """Innovation y - e, with its angle in (-pi, pi]."""
        z = np.subtract(y, e)
        z[..., 1] = wrap(z[..., 1])
        return z

    def visible(self, y, p):
        """Return True for each point p, measured as y, that can be seen."""
        return (y[..., 0] <= self.max_range) & (y[..., 0] > 0)
