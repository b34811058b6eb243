"""A car seen from the middle of its rear axle: speed and steering angle are the control."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2
from .unicycle import Unicycle


@dataclass(frozen=True)
class Ackermann:
    """Robot state [x, y, theta] of the middle of the rear axle; control u = [v, steer], m/s and rad.

    The turn rate is w = v tan(steer) / wheelbase, then the arc of a unicycle: the "bicycle" of R. Rajamani, "Vehicle
    Dynamics and Control", 2nd edition 2012, section 2.2, without slip.

    Parameters
    ----------
    wheelbase : float
        Front axle to rear axle, m.

    See Also
    --------
    Vehicle : With slip, a frame anywhere on the car, and the speed of one wheel.
    DifferentialDrive : Two driven wheels.
    """

    wheelbase: float = 2.7

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"v": 1, "steer_deg": 1}
    state_fields: ClassVar = {}

    def __post_init__(self):
        if not 0 < self.wheelbase < np.inf:
            raise ValueError(f"Ackermann: wheelbase must be a positive number of metres, got {self.wheelbase!r}")

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 2)
            The wheels cannot stand across: the steering must stay below 90 degrees.
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 3)
        X_x : ndarray, shape (..., 3, 3)
        X_u : ndarray, shape (..., 3, 2)
        """
        u = np.asanyarray(u)
        v, tan = u[..., 0], np.tan(u[..., 1])
        W_u = np.zeros_like(u, shape=(*u.shape, 2))
        W_u[..., 0, 0] = 1.0
        W_u[..., 1, 0], W_u[..., 1, 1] = tan / self.wheelbase, v * (1 + tan**2) / self.wheelbase
        x2, X_x, X_w = Unicycle().move(x, np.stack([v, v * tan / self.wheelbase], -1), dt)
        return x2, X_x, X_w @ W_u
