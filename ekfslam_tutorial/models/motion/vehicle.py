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
        u = np.asarray(u, float)
        axle, A_u = self.axle(u[..., :2])
        step, S_a = arc(axle, dt)
        slid, D_s, D_slip = _slid(step, u[..., 2])
        here, H_d = self._at_mount(slid)
        F, X_x, X_h = Frame2(x).compose(Frame2(here))
        X_d = X_h @ H_d
        return F.x, X_x, np.concatenate([X_d @ D_s @ S_a @ A_u, X_d @ D_slip], -1)

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
        """
        u = np.asarray(u, float)
        v, tan = u[..., 0], np.tan(u[..., 1])
        T_s = 1 + tan**2
        k = 1 / (1 - tan * self.track / self.wheelbase)
        K_s = k**2 * T_s * self.track / self.wheelbase
        v_c = k * v
        a = np.stack([v_c, v_c * tan / self.wheelbase], -1)
        A_v = np.stack([k, k * tan / self.wheelbase], -1)
        A_s = np.stack([K_s * v, (K_s * tan + k * T_s) * v / self.wheelbase], -1)
        return a, np.stack([A_v, A_s], -1)

    def _at_mount(self, step):
        """The step of the axle as that of the mounted frame, in its own axes, and the derivative by the step."""
        m = np.array([self.ahead, self.left])
        R = Frame2(step).R
        J = np.zeros((*step.shape[:-1], 3, 3))
        J[...] = np.eye(3)
        turned = (R @ m[:, None])[..., 0]
        J[..., 0, 2], J[..., 1, 2] = -turned[..., 1], turned[..., 0]
        return np.concatenate([step[..., :2] + turned - m, step[..., 2:]], -1), J


def _slid(step, slip):
    """A step (..., 3) that goes in a direction turned by the angle `slip`; the derivatives by both."""
    D_s = np.zeros((*step.shape[:-1], 3, 3))
    c, s = np.cos(slip), np.sin(slip)
    D_s[..., 0, 0], D_s[..., 0, 1] = c, -s
    D_s[..., 1, 0], D_s[..., 1, 1] = s, c
    D_s[..., 2, 2] = 1.0
    slid = (D_s @ step[..., None])[..., 0]
    D_slip = np.stack([-slid[..., 1], slid[..., 0], np.zeros_like(slip)], -1)
    return slid, D_s, D_slip[..., None]
