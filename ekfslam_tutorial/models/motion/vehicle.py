"""A car, steered by its front wheels and measured at a rear wheel: the truck of Victoria Park."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import Frame2
from .unicycle import arc


@dataclass(frozen=True)
class Vehicle:
    """Robot state [x, y, theta] of a point on the car; control u = [v, steer, slip]: speed of a wheel, m/s, and angles.

    The middle of the rear axle drives a circular arc. Its speed differs from that of the measured wheel, which is
    `track` metres to the left of it and drives a smaller or larger circle:

        v_c = v / (1 - tan(steer) track / wheelbase),   w = v_c tan(steer) / wheelbase.

    The state is the pose of a point m = [ahead, left] of the axle, where the laser is. Its step in its own frame is
    R(slip) [dx, dy] + (R(w dt) - I) m, w dt, with the step [dx, dy, w dt] of the axle. J. E. Guivant, E. M. Nebot, IEEE
    Trans. Robotics and Automation 17(3):242-257, 2001, section II; their equations of motion are this arc for small dt.

    Their car never slips sideways, and no noise in v and steer can say that it does. `slip` is the angle between where
    the axle points and where it goes. Nobody commands or measures it: it is zero, with a standard deviation.

    Parameters
    ----------
    wheelbase : float
        Front axle to rear axle, m (L).
    ahead, left : float
        The place of the state's frame from the middle of the rear axle, m (a, b).
    track : float
        How far left of the middle the wheel is whose speed is measured, m (H).

    See Also
    --------
    Unicycle : Driven by speed and turn rate.
    """

    wheelbase: float = 2.83
    ahead: float = 3.78
    left: float = 0.5
    track: float = 0.76

    frame: ClassVar = Frame2
    size: ClassVar[int] = 3
    control_fields: ClassVar = {"v": 1, "steer_deg": 1, "slip_deg": 1}
    state_fields: ClassVar = {}

    def __post_init__(self):
        if not 0 < self.wheelbase < np.inf:
            raise ValueError(f"Vehicle: wheelbase must be a positive number of metres, got {self.wheelbase!r}")
        if not np.isfinite([self.ahead, self.left, self.track]).all():
            raise ValueError(
                f"Vehicle: ahead, left and track must be finite, got {self.ahead!r}, {self.left!r}, {self.track!r}"
            )

    def move(self, x, u, dt):
        """One step of `dt` seconds.

        Parameters
        ----------
        x : ndarray, shape (..., 3)
        u : ndarray, shape (..., 3)
            The wheels cannot stand across: the steering must stay below 90 degrees, and below the angle
            arctan(wheelbase / track) at which the measured wheel stands still.
        dt : float

        Returns
        -------
        x2 : ndarray, shape (..., 3)
        X_x : ndarray, shape (..., 3, 3)
        X_u : ndarray, shape (..., 3, 3)
        """
        u = np.asanyarray(u)
        axle, A_u = self.axle(u[..., :2])
        step, S_a = arc(axle, dt)
        here, H_s, H_slip = self._at_mount(step, u[..., 2])
        F, X_x, X_h = Frame2(x).compose(Frame2(here))
        return F.x, X_x, np.concatenate([X_h @ (H_s @ (S_a @ A_u)), X_h @ H_slip], -1)

    def axle(self, u):
        """Speed and turn rate of the middle of the rear axle.

        Parameters
        ----------
        u : ndarray, shape (..., 2)
            [v, steer], m/s and rad.

        Returns
        -------
        a : ndarray, shape (..., 2)
            [v_c, w], m/s and rad/s.
        A_u : ndarray, shape (..., 2, 2)

        See Also
        --------
        arc : The step that follows.
        """
        u = np.asanyarray(u)
        v, tan = u[..., 0], np.tan(u[..., 1])
        T_s = 1 + tan**2
        k = 1 / (1 - tan * self.track / self.wheelbase)
        K_s = k**2 * T_s * self.track / self.wheelbase
        a = np.stack([k * v, k * v * tan / self.wheelbase], -1)
        A_u = np.zeros_like(a, shape=(*a.shape, 2))
        A_u[..., 0, 0], A_u[..., 0, 1] = k, K_s * v
        A_u[..., 1, 0], A_u[..., 1, 1] = k * tan / self.wheelbase, (K_s * tan + k * T_s) * v / self.wheelbase
        return a, A_u

    def _at_mount(self, step, slip):
        """The step of the axle as that of the mounted frame, in its own axes: R(slip) [dx, dy] + (R(dtheta) - I) m.

        Returns
        -------
        here : ndarray, shape (..., 3)
        H_s : ndarray, shape (..., 3, 3)
        H_slip : ndarray, shape (..., 3, 1)
        """
        dx, dy, turn = step[..., 0], step[..., 1], step[..., 2]
        c, s, C, S = np.cos(slip), np.sin(slip), np.cos(turn), np.sin(turn)
        x, y = C * self.ahead - S * self.left, S * self.ahead + C * self.left  # the mount after the turn

        here = np.stack([c * dx - s * dy + x - self.ahead, s * dx + c * dy + y - self.left, turn], -1)
        H_s = np.zeros_like(here, shape=(*here.shape, 3))
        H_s[..., 0, 0], H_s[..., 0, 1], H_s[..., 0, 2] = c, -s, -y
        H_s[..., 1, 0], H_s[..., 1, 1], H_s[..., 1, 2] = s, c, x
        H_s[..., 2, 2] = 1.0
        H_slip = np.stack([-s * dx - c * dy, c * dx - s * dy, np.zeros_like(x)], -1)
        return here, H_s, H_slip[..., None]
