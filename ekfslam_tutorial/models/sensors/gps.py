"""A position in the world: GPS, a motion capture system, a total station."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .own_state import OwnState
from .parameters import check_dim, check_positive


@dataclass(frozen=True)
class Gps(OwnState):
    """Position of the antenna in the world, m: y = F.t = t_r + R_r t_s, with the lever arm t_s.

    The lever arm is the sensor's place on the robot. It may be a state, as every mounting: a robot that turns shows it.
    P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems", 2nd ed., 2013,
    section 14.3.2.

    Parameters
    ----------
    std : float
        Standard deviation of each coordinate, m.
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    Compass : The heading.
    """

    std: float = 1.0
    dim: int = 2

    def __post_init__(self):
        check_positive(self, "std")
        check_dim(self)

    @property
    def units(self):
        """Unit of each number."""
        return ("m",) * self.dim

    @cached_property
    def R(self):
        """Measurement noise covariance, std^2 I."""
        return self.std**2 * np.eye(self.dim)

    def project(self, v):
        """Frame F.x of the antenna in the world to its position. Returns y, Y_v."""
        return v[..., : self.dim], np.eye(self.dim, v.shape[-1])
