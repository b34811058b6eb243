"""Two driven wheels on one axle: the speeds of the wheels are the control."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2
from .unicycle import Unicycle


@dataclass(frozen=True)
class DifferentialDrive:
    """Robot state [x, y, theta] of the middle of the axle; control u = [left, right], speeds of the wheels (m/s).

    v = (left + right) / 2 and w = (right - left) / base, then the arc of a unicycle. R. Siegwart, I. R. Nourbakhsh,
    D. Scaramuzza, "Introduction to Autonomous Mobile Robots", 2nd edition 2011, section 3.2.

    Parameters
    ----------
    base : float
        Distance of the wheels, m.

    See Also
    --------
    Unicycle : Driven by speed and turn rate.
    Ackermann : Steered by its front wheels.
    """

    base: float = 0.4

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"left": 1, "right": 1}
    state_fields: ClassVar = {}

    def __post_init__(self):
        if not 0 < self.base < np.inf:
            raise ValueError(f"DifferentialDrive: base must be a positive number of metres, got {self.base!r}")

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 2)
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 3)
        X_x : ndarray, shape (..., 3, 3)
        X_u : ndarray, shape (..., 3, 2)
        """
        W_u = np.array([[0.5, 0.5], [-1 / self.base, 1 / self.base]])  # [v, w] = W_u u
        x2, X_x, X_w = Unicycle().move(x, (W_u @ np.asanyarray(u)[..., None])[..., 0], dt)
        return x2, X_x, X_w @ W_u
