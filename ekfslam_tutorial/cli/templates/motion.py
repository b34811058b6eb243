"""NewMotion: a motion model of your own. It works as it is (drive, then turn, in the plane); make it yours.

What a motion model must have:

    move            x2 = f(x, u, dt): the state after one step of dt seconds, and its Jacobians X_x and X_u
    frame           Frame2 or Frame3: the first numbers of the state are the robot's frame
    size            length of the state
    control_fields  the parts of the control u and how many numbers each has; `_deg` marks an angle
    state_fields    what the state has beyond the frame: velocities, for example

Write plain numpy, with `np.where` for a decision by a value: the fast engine compiles what it can, numpy does the rest.
A user gives each control field and its standard deviation in the scenario: here `d`, `d_std`, `da_deg`, `da_std_deg`.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ekfslam_tutorial.geometry import Frame2


@dataclass(frozen=True)
class NewMotion:
    """Robot state [x, y, theta]; control u = [d, da]: drive d metres ahead, then turn by da radians.

    x2 = x + d cos(theta),  y2 = y + d sin(theta),  theta2 = theta + da
    """

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"d": 1, "da_deg": 1}
    state_fields: ClassVar = {}

    def move(self, x, u, dt):
        """One step.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 2)
        dt : float
            Duration, s. Not used here: d is a distance, not a speed.

        Returns
        -------
        x2 : ndarray, shape (..., 3)
        X_x : ndarray, shape (..., 3, 3)
        X_u : ndarray, shape (..., 3, 2)
        """
        c, s, d = np.cos(x[..., 2]), np.sin(x[..., 2]), u[..., 0]
        x2 = x + np.stack([d * c, d * s, u[..., 1]], -1)

        X_x = np.zeros_like(x2, shape=(*x2.shape, 3))  # filled below: an array like x2, a matrix for each state
        X_x[...] = np.eye(3)
        X_x[..., 0, 2], X_x[..., 1, 2] = -d * s, d * c
        X_u = np.zeros_like(x2, shape=(*x2.shape, 2))
        X_u[..., 0, 0], X_u[..., 1, 0], X_u[..., 2, 1] = c, s, 1
        return x2, X_x, X_u
