"""Range, bearing and elevation in space: a lidar that turns, a sonar, a total station."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import wrap
from .parameters import check_angle, check_positive


@dataclass(frozen=True)
class RangeBearingElevation:
    """Distance r (m), bearing beta and elevation eps (rad) of a point; axes x ahead, y left, z up.

    y = [|p|, atan2(y, x), atan2(z, hypot(x, y))]: spherical coordinates. The bearing has no meaning straight above.
    T. D. Barfoot, "State Estimation for Robotics", 2017, section 6.4.3.

    Parameters
    ----------
    range_std, bearing_std, elevation_std : float
        Standard deviations of the measurement noise, m and rad.
    max_range : float
        No point further away than this is seen, m.
    fov : float
        Width of the field of view to the left and right, centred on the x axis, rad.
    fov_up : float
        Height of the field of view, centred on the horizon, rad.

    See Also
    --------
    RangeBearing : In the plane.
    PointXYZ : The same three numbers in Cartesian coordinates.
    """

    range_std: float = 0.05
    bearing_std: float = 0.01
    elevation_std: float = 0.01
    max_range: float = np.inf
    fov: float = 2 * np.pi
    fov_up: float = np.pi

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("m", "rad", "rad")
    angles: ClassVar = ("bearing_std", "elevation_std", "fov", "fov_up")

    def __post_init__(self):
        stds = "range_std", "bearing_std", "elevation_std"
        check_positive(self, *stds, "max_range", "fov", "fov_up", infinite=("max_range",))
        for name, limit in (("bearing_std", np.pi), ("elevation_std", np.pi), ("fov", 2 * np.pi), ("fov_up", np.pi)):
            check_angle(self, name, limit)

    @cached_property
    def R(self):
        """Measurement noise covariance, diag(range_std^2, bearing_std^2, elevation_std^2)."""
        return np.diag([self.range_std**2, self.bearing_std**2, self.elevation_std**2])

    def project(self, p):
        """Point in the sensor frame to [range, bearing, elevation]. Returns y, Y_p.

        See Also
        --------
        retro : The inverse.
        """
        p = np.asanyarray(p)
        x, y, z = p[..., 0], p[..., 1], p[..., 2]
        h = np.hypot(x, y)
        r = np.hypot(h, z)
        e = np.stack([r, np.arctan2(y, x), np.arctan2(z, h)], -1)
        E_p = np.zeros_like(e, shape=(*e.shape, 3))
        with np.errstate(divide="ignore", invalid="ignore"):
            c, s, C, S = x / h, y / h, h / r, z / r
            E_p[..., 0, 0], E_p[..., 0, 1], E_p[..., 0, 2] = C * c, C * s, S
            E_p[..., 1, 0], E_p[..., 1, 1] = -s / h, c / h
            E_p[..., 2, 0], E_p[..., 2, 1], E_p[..., 2, 2] = -S * c / r, -S * s / r, C / r
        return e, E_p

    def retro(self, y):
        """[range, bearing, elevation] to a point: r [cos eps cos beta, cos eps sin beta, sin eps]. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        y = np.asanyarray(y)
        r, c, s, C, S = y[..., 0], np.cos(y[..., 1]), np.sin(y[..., 1]), np.cos(y[..., 2]), np.sin(y[..., 2])
        ray = np.stack([C * c, C * s, S], -1)
        RAY_b, RAY_e = np.stack([-C * s, C * c, 0 * c], -1), np.stack([-S * c, -S * s, C], -1)
        r = r[..., None]
        return r * ray, np.stack([ray, r * RAY_b, r * RAY_e], -1)

    def residual(self, y, e):
        """Innovation y - e with the angles wrapped into (-pi, pi]."""
        z = np.subtract(y, e, dtype=float)
        z[..., 1:] = wrap(z[..., 1:])
        return z

    def visible(self, y, p):
        """Return True for each point in range and in the field of view."""
        near = (y[..., 0] > 0) & (y[..., 0] <= self.max_range)
        return near & (np.abs(wrap(y[..., 1])) <= self.fov / 2) & (np.abs(y[..., 2]) <= self.fov_up / 2)
