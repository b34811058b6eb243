"""Range rate without a range: how fast the distance of a point grows."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .parameters import check_dim, check_positive


def range_rate(v, d):
    """Growth of the distance of a point that stands still, m/s: y = -(p / |p|) v_s, of v = [p; v_s; w_s].

    Returns
    -------
    y : ndarray, shape (..., 1)
    Y_v : ndarray, shape (..., 1, len(v))
        Not finite at the sensor itself.

    See Also
    --------
    Moving.velocity : Where v_s comes from.
    """
    v = np.asanyarray(v)
    p, s = v[..., :d], v[..., d : 2 * d]
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.sqrt((p * p).sum(-1))[..., None]
        m = p / r
        y = -(m * s).sum(-1)[..., None]
        Y_v = np.zeros_like(v, shape=(*v.shape[:-1], 1, v.shape[-1]))
        Y_v[..., 0, :d], Y_v[..., 0, d : 2 * d] = -(s + y * m) / r, -m
        return y, Y_v


@dataclass(frozen=True)
class RangeRate:
    """Range rate of a point that stands still, m/s: y = -(p / |p|) v_s, v_s the velocity of the sensor.

    It starts no landmark: another sensor does, or the landmarks are known. The robot needs a velocity among its states.

    Parameters
    ----------
    rate_std : float
        Standard deviation of the noise, m/s.
    max_range : float
        No point further away than this is seen, m.
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    Doppler : With range and bearing.
    """

    rate_std: float = 0.1
    max_range: float = np.inf
    dim: int = 2

    bearing_only: ClassVar[bool] = False
    asks_robot: ClassVar = "moving"
    units: ClassVar = ("m/s",)

    def __post_init__(self):
        check_positive(self, "rate_std", "max_range", infinite=("max_range",))
        check_dim(self)

    @cached_property
    def R(self):
        """Measurement noise covariance, rate_std^2."""
        return np.array([[self.rate_std**2]])

    def project(self, v):
        """Point in the sensor frame, and the sensor's velocity, [p; v_s; w_s]. Returns y, Y_v."""
        return range_rate(v, self.dim)

    def residual(self, y, e):
        """Innovation y - e, m/s."""
        return np.subtract(y, e)

    def visible(self, y, v):
        """Return True for each point in range."""
        r = np.sqrt((v[..., : self.dim] ** 2).sum(-1))
        return (r > 0) & (r <= self.max_range)
