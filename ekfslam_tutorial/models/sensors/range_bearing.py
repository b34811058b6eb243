"""Range and bearing in the plane: the sensor of the lecture."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import wrap
from .parameters import check_angle, check_positive


def polar(p):
    """Point in the plane to range and bearing: [hypot(x, y), atan2(y, x)].

    Returns
    -------
    y : ndarray, shape (..., 2)
        Metres and radians.
    Y_p : ndarray, shape (..., 2, 2)
        Not finite at the sensor itself, where the bearing has no meaning.

    See Also
    --------
    RangeBearing.retro : The inverse.
    """
    p = np.asanyarray(p)
    x, y = p[..., 0], p[..., 1]
    r = np.hypot(x, y)
    e = np.stack([r, np.arctan2(y, x)], -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        c, s = x / r, y / r
        return e, np.stack([np.stack([c, s], -1), np.stack([-s / r, c / r], -1)], -2)


@dataclass(frozen=True)
class RangeBearing:
    """Distance r (m) and direction beta (rad, counter-clockwise from the sensor's x axis) of a point.

    y = [|p|, atan2(p_y, p_x)]. S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", 2005, section 6.6.

    Parameters
    ----------
    range_std, bearing_std : float
        Standard deviations of the measurement noise, m and rad.
    max_range : float
        No point further away than this is seen, m.
    fov : float
        Width of the field of view, centred on the x axis, rad.

    See Also
    --------
    BearingOnly2 : Without the range.
    PinHoleDepth : In space.
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
        check_positive(self, "range_std", "bearing_std", "max_range", "fov", infinite=("max_range",))
        check_angle(self, "bearing_std", np.pi)
        check_angle(self, "fov", 2 * np.pi)

    @cached_property
    def R(self):
        """Measurement noise covariance, diag(range_std^2, bearing_std^2)."""
        return np.diag([self.range_std**2, self.bearing_std**2])

    def project(self, p):
        """Point in the sensor frame to [range, bearing]. Returns y, Y_p.

        See Also
        --------
        retro : The inverse.
        """
        return polar(p)

    def retro(self, y):
        """[range, bearing] to a point in the sensor frame: r [cos beta, sin beta]. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        r, b = np.moveaxis(y, -1, 0)
        c, s = np.cos(b), np.sin(b)
        v = np.stack([r * c, r * s], -1)
        V_y = np.zeros_like(v, shape=(*v.shape, 2))
        V_y[..., 0, 0], V_y[..., 0, 1] = c, -r * s
        V_y[..., 1, 0], V_y[..., 1, 1] = s, r * c
        return v, V_y

    def residual(self, y, e):
        """Innovation y - e with the bearing wrapped into (-pi, pi]."""
        z = np.subtract(y, e, dtype=float)
        z[..., 1] = wrap(z[..., 1])
        return z

    def visible(self, y, p):
        """Return True for each point in range and in the field of view."""
        in_range = (y[..., 0] > 0) & (y[..., 0] <= self.max_range)
        return in_range if self.fov >= 2 * np.pi else in_range & (np.abs(wrap(y[..., 1])) <= self.fov / 2)
