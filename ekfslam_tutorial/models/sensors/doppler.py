"""Range, bearing and range rate in the plane: Doppler radar and sonar."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .parameters import check_positive
from .range_bearing import RangeBearing
from .range_rate import range_rate


@dataclass(frozen=True)
class Doppler(RangeBearing):
    """Distance, direction and range rate of a point in the plane: y = [r, beta, -(p / r) v_s], v_s its own velocity.

    A static world shows how fast the sensor moves: D. Kellner et al., "Instantaneous ego-motion estimation using
    Doppler radar", ITSC 2013, eq. 1. The robot needs a velocity among its states.

    Parameters
    ----------
    range_std, bearing_std, max_range, fov
        As in `RangeBearing`.
    rate_std : float
        Standard deviation of the range rate, m/s.

    See Also
    --------
    RangeRate : The last number alone.
    ConstantTurn : A robot for it.
    """

    rate_std: float = 0.1

    asks_robot: ClassVar = "moving"
    units: ClassVar = ("m", "rad", "m/s")

    def __post_init__(self):
        super().__post_init__()
        check_positive(self, "rate_std")

    @cached_property
    def R(self):
        """Measurement noise covariance, diag(range_std^2, bearing_std^2, rate_std^2)."""
        return np.diag([self.range_std, self.bearing_std, self.rate_std]) ** 2

    def project(self, v):
        """Point in the sensor frame, and the sensor's velocity, [p; v_s; w_s]. Returns y, Y_v."""
        (e, E_p), (rate, Y_v) = super().project(v[..., :2]), range_rate(v, 2)
        E_v = np.concatenate([E_p, np.zeros_like(E_p, shape=(*E_p.shape[:-1], v.shape[-1] - 2))], -1)
        return np.concatenate([e, rate], -1), np.concatenate([E_v, Y_v], -2)

    def retro(self, y):
        """[range, bearing, rate] to a point in the sensor frame, of which the rate says nothing. Returns p, P_y."""
        p, P_y = super().retro(y[..., :2])
        return p, np.concatenate([P_y, np.zeros_like(P_y[..., :1])], -1)
