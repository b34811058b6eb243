"""A heading in the world: a magnetic compass, two antennas, the sun."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import Frame3, wrap
from .own_state import OwnState
from .parameters import check_angle, check_dim, check_positive


@dataclass(frozen=True)
class Compass(OwnState):
    """Heading of the sensor's x axis in the world, rad: y = atan2(R_yx, R_xx) + declination.

    It is counter-clockwise from the world's x axis. In space it is the yaw angle: J. Diebel, "Representing attitude",
    2006, eq. 68 and 286.

    Parameters
    ----------
    heading_std : float
        Standard deviation of the noise, rad.
    declination : float
        What it always tells too much, rad: between magnetic and true north. It may be a state.
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    Gps : The position.
    """

    heading_std: float = 0.02
    declination: float = 0.0
    dim: int = 2

    units: ClassVar = ("rad",)
    angles: ClassVar = ("heading_std", "declination")
    parameters: ClassVar = ("declination",)

    def __post_init__(self):
        check_positive(self, "heading_std")
        check_angle(self, "heading_std", np.pi)
        check_angle(self, "declination", 2 * np.pi)
        check_dim(self)

    @cached_property
    def R(self):
        """Measurement noise covariance, heading_std^2."""
        return np.array([[self.heading_std**2]])

    def project(self, v):
        """Frame F.x of the sensor in the world to its heading. Returns y, Y_v."""
        Y_v = np.zeros_like(v, shape=(*v.shape[:-1], 1, v.shape[-1]))
        if self.dim == 2:
            Y_v[..., 0, 2] = 1.0
            return v[..., 2:3] + self.declination, Y_v
        F = Frame3(v[..., :7])
        x, y, X_o, YY_o = F.R[..., 0, 0], F.R[..., 1, 0], F.R_o[..., 0, 0, :], F.R_o[..., 1, 0, :]
        r2 = (x * x + y * y)[..., None]
        Y_v[..., 0, 3:7] = (x[..., None] * YY_o - y[..., None] * X_o) / r2
        return np.arctan2(y, x)[..., None] + self.declination, Y_v

    def project_parameters(self, v):
        """Derivative of `project` by the declination. Returns y, Y_d."""
        return self.project(v)[0], np.ones((*v.shape[:-1], 1, 1))

    def residual(self, y, e):
        """Innovation y - e, wrapped into (-pi, pi]."""
        return wrap(np.subtract(y, e, dtype=float))
