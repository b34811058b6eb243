"""Speeds over the ground: of a wheel, and of the picture of the ground."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .own_state import OwnState
from .parameters import check_positive


def _speeds(v, n, factor):
    """The first n numbers of the velocity behind a frame in the plane, v = [F.x; v_s; w_s], times a factor."""
    Y_v = np.zeros((n, v.shape[-1]))
    Y_v[:, 3 : 3 + n] = factor * np.eye(n)
    return factor * v[..., 3 : 3 + n], Y_v


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
        return _speeds(v, 1, self.scale)

    def project_parameters(self, v):
        """Derivative of `project` by the scale. Returns y, Y_scale."""
        return self.project(v)[0], v[..., 3:4, None]


@dataclass(frozen=True)
class GroundFlow(OwnState):
    """Optical flow of a camera that looks down on the ground, rad/s: y = [v_x, v_y] / height.

    In the middle of its image, with the sign of the camera's motion. D. Honegger et al., "An open source and open
    hardware embedded metric optical flow CMOS camera", ICRA 2013, eq. 4. The robot needs a velocity among its states.

    Parameters
    ----------
    flow_std : float
        Standard deviation of each number, rad/s.
    height : float
        Of the camera above the ground, m. It may be a state.

    See Also
    --------
    WheelSpeed : One component.
    ConstantTurn : A robot for it.
    """

    flow_std: float = 0.05
    height: float = 1.0

    dim: ClassVar[int] = 2
    asks_robot: ClassVar = "moving"
    units: ClassVar = ("rad/s", "rad/s")
    parameters: ClassVar = ("height",)

    def __post_init__(self):
        check_positive(self, "flow_std", "height")

    @cached_property
    def R(self):
        """Measurement noise covariance, flow_std^2 I."""
        return self.flow_std**2 * np.eye(2)

    def project(self, v):
        """Frame and velocity [F.x; v_s; w_s] of the camera to the flow. Returns y, Y_v."""
        return _speeds(v, 2, 1 / self.height)

    def project_parameters(self, v):
        """Derivative of `project` by the height. Returns y, Y_height."""
        y = self.project(v)[0]
        return y, -y[..., None] / self.height
