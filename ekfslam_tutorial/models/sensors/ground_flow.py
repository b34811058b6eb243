"""Speed over the ground, of its picture: optical flow."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .own_state import OwnState, speeds
from .parameters import check_positive


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
        return speeds(v, 2, 1 / self.height)

    def project_parameters(self, v):
        """Derivative of `project` by the height. Returns y, Y_height."""
        y = self.project(v)[0]
        return y, -y[..., None] / self.height
