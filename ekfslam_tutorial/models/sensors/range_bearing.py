"""Range and bearing in the plane: the sensor of the lecture."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import wrap
from ...geometry.arrays import blank, cos_sin, floats, matrix, numbers, vector
from .checks import angle, positive


def polar(p):
    """Point in the plane to range and bearing: [hypot(x, y), atan2(y, x)].

    Returns
    -------
    y : ndarray, shape (..., 2)
        Metres and radians.
    Y_p : ndarray, shape (..., 2, 2)
        Not finite at the sensor itself, where the bearing has no meaning.
    """
    x, y = p[..., 0], p[..., 1]
    r = np.hypot(x, y)
    with np.errstate(divide="ignore", invalid="ignore"):
        c, s = x / r, y / r
        e, E_p = blank(p, *r.shape, 2), blank(p, *r.shape, 2, 2)
        e[..., 0], e[..., 1] = r, np.arctan2(y, x)
        E_p[..., 0, 0], E_p[..., 0, 1] = c, s
        E_p[..., 1, 0], E_p[..., 1, 1] = -s / r, c / r
    return e, E_p


@dataclass(frozen=True)
class RangeBearing:
    """Distance r (m) and direction beta (rad, counter-clockwise from the sensor's x axis) of a point.

    Parameters
    ----------
    range_std, bearing_std : float
        Standard deviations of the measurement noise, m and rad.
    max_range : float
        No point further away than this is seen, m.
    fov : float
        Width of the field of view, centred on the x axis, rad.
    """

    range_std: float
    bearing_std: float
    max_range: float = np.inf
    fov: float = 2 * np.pi

    dim: ClassVar[int] = 2
    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("m", "rad")
    angles: ClassVar = ("bearing_std", "fov")  # parameters in radians; users may write them in degrees, as NAME_deg

    def __post_init__(self):
        positive(self, "range_std", "bearing_std", "max_range", "fov", infinite=("max_range",))
        angle(self, "bearing_std", np.pi)
        angle(self, "fov", 2 * np.pi)

    @cached_property
    def R(self):
        """Measurement noise covariance, diag(range_std^2, bearing_std^2)."""
        return np.diag([self.range_std**2, self.bearing_std**2])

    def project(self, p):
        """Point in the sensor frame to [range, bearing]. Returns y, Y_p."""
        return polar(floats(p))

    def retro(self, y):
        """[range, bearing] to a point in the sensor frame: r [cos beta, sin beta]. Returns v, V_y."""
        y = floats(y)
        (r, b), lead = numbers(y), y.shape[:-1]
        c, s = cos_sin(b)
        return vector(lead, r * c, r * s), matrix(lead, [c, -r * s], [s, r * c])

    def residual(self, y, e):
        """Innovation y - e with the bearing wrapped into (-pi, pi]."""
        z = np.subtract(y, e, dtype=float)
        z[..., 1] = wrap(z[..., 1])
        return z

    def visible(self, y, p):
        """Whether points are in range and in the field of view."""
        r = y[..., 0]
        in_range = (r > 0) & (r <= self.max_range)
        return in_range if self.fov >= 2 * np.pi else in_range & (np.abs(wrap(y[..., 1])) <= self.fov / 2)
