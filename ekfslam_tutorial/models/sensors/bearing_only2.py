"""Bearing without range in the plane: a camera that looks at a flat world."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import wrap
from .parameters import check_angle, check_positive
from .range_bearing import polar


@dataclass(frozen=True)
class BearingOnly2:
    """Direction beta of a point (rad, counter-clockwise from the sensor's x axis).

    y = atan2(p_y, p_x): the second number of `RangeBearing`. T. Bailey, "Constrained initialisation for bearing-only
    SLAM", ICRA 2003, has what follows from the missing range.

    Parameters
    ----------
    bearing_std : float
        Standard deviation of the measurement noise, rad.
    max_range : float
        No point further away than this is seen, m. Rays have no length: it counts for Euclidean points only.
    fov : float
        Width of the field of view, centred on the x axis, rad.

    See Also
    --------
    RangeBearing : With the range.
    PinHole : In space.
    """

    bearing_std: float
    max_range: float = np.inf
    fov: float = 2 * np.pi

    dim: ClassVar[int] = 2
    bearing_only: ClassVar[bool] = True
    units: ClassVar = ("rad",)
    angles: ClassVar = ("bearing_std", "fov")  # parameters in radians; users may write them in degrees, as NAME_deg

    def __post_init__(self):
        check_positive(self, "bearing_std", "max_range", "fov", infinite=("max_range",))
        check_angle(self, "bearing_std", np.pi)
        check_angle(self, "fov", 2 * np.pi)

    @cached_property
    def R(self):
        """Measurement noise covariance, [[bearing_std^2]]."""
        return np.array([[self.bearing_std**2]])

    def project(self, p):
        """Point or ray in the sensor frame to [bearing]. Returns y, Y_p.

        See Also
        --------
        retro : The inverse, but for the length.
        """
        y, Y_p = polar(p)
        return y[..., 1:], Y_p[..., 1:, :]

    def retro(self, y):
        """[bearing] to the unit ray [cos beta, sin beta]. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        c, s = np.cos(y), np.sin(y)
        return np.concatenate([c, s], -1), np.concatenate([-s, c], -1)[..., None]

    def residual(self, y, e):
        """Innovation y - e, wrapped into (-pi, pi]."""
        return wrap(np.subtract(y, e))

    def visible(self, y, p):
        """Return True for each point in range and in the field of view."""
        return (np.abs(wrap(y[..., 0])) <= self.fov / 2) & (np.hypot(p[..., 0], p[..., 1]) <= self.max_range)
