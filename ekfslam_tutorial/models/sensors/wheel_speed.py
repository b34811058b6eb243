"""Speed over the ground, of a wheel."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .own_state import OwnState, speeds
from .parameters import check_positive


@dataclass(frozen=True)
class WheelSpeed(OwnState):
    """Speed of a wheel in the plane, m/s: y = scale v_x, v_x that of its place along the sensor's x axis.

    A wheel at [0, b/2] of a robot with speed v and turn rate w has v_x = v - w b/2: two of them are odometry whose
    errors the filter knows. R. Siegwart, I. Nourbakhsh, D. Scaramuzza, "Introduction to Autonomous Mobile Robots",
    2nd ed., 2011, eq. 3.12. The robot needs a velocity among its states.

    Parameters
    ----------
    speed_std : float
        Standard deviation of the noise, m/s.
    scale : float
        Told speed over true speed: what a wrong radius of the wheel makes. It may be a state.

    See Also
    --------
    GroundFlow : Both components.
    ConstantTurn : A robot for it.
    """

    speed_std: float = 0.02
    scale: float = 1.0

    dim: ClassVar[int] = 2
    asks_robot: ClassVar = "moving"
    units: ClassVar = ("m/s",)
    parameters: ClassVar = ("scale",)

    def __post_init__(self):
        check_positive(self, "speed_std", "scale")

    @cached_property
    def R(self):
        """Measurement noise covariance, speed_std^2."""
        return np.array([[self.speed_std**2]])

    def project(self, v):
        """Frame and velocity [F.x; v_s; w_s] of the sensor to the speed. Returns y, Y_v."""
        return speeds(v, 1, self.scale)

    def project_parameters(self, v):
        """Derivative of `project` by the scale. Returns y, Y_scale."""
        return self.project(v)[0], v[..., 3:4, None]
