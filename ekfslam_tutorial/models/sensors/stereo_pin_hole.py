"""Two pin-hole cameras side by side: the disparity gives the depth."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from .imager import Imager
from .parameters import check_positive, finite_numbers
from .pin_hole import depixellise, pixellise, project, retro


@dataclass(frozen=True)
class StereoPinHole(Imager):
    """Rectified stereo camera: pixel of the left image and disparity, y = [u, v, d] with d = u_left - u_right.

    The right camera stands `baseline` metres to the right of the left one, whose frame is the sensor's (x right,
    y down, z forward): u = u0 + au x / z, v = v0 + av y / z, d = au baseline / z. R. Hartley, A. Zisserman, "Multiple
    View Geometry in Computer Vision", 2nd edition 2004, chapter 9.

    The same row is measured in both images. Their mean loses nothing that could tell of the point, so v is this mean:
    with independent noise of `pixel_std` in all four numbers, R = pixel_std^2 [[1, 0, 1], [0, 1/2, 0], [1, 0, 2]].

    Parameters
    ----------
    k : sequence of 4 floats
        Intrinsic parameters [u0, v0, au, av] of both cameras, pixels.
    baseline : float
        Distance of the two cameras, m.
    image_size : sequence of 2 floats
        Width and height, pixels.
    pixel_std : float
        Standard deviation of the noise of one pixel coordinate in one image, pixels.
    min_disparity : float
        Points so far away that the disparity is less are not seen, pixels.
    margin : float
        Width of the frame inside the image that does not count as visible, pixels.

    See Also
    --------
    PinHole : One camera.
    PinHoleDepth : One camera that measures the depth itself.
    """

    k: tuple = (320.0, 240.0, 320.0, 320.0)
    baseline: float = 0.2
    image_size: tuple = (640.0, 480.0)
    pixel_std: float = 1.0
    min_disparity: float = 1.0
    margin: float = 0.0

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = False
    units: ClassVar = ("px", "px", "px")

    def __post_init__(self):
        self.check_image()
        check_positive(self, "baseline", "min_disparity")
        k = finite_numbers(self, "k", 4)
        if not (k[2:] > 0).all():
            raise ValueError(f"StereoPinHole: k = [u0, v0, au, av] needs au and av above zero, got {self.k!r}")

    @cached_property
    def R(self):
        """Measurement noise covariance: the left column is a part of u and of d."""
        return self.pixel_std**2 * np.array([[1.0, 0.0, 1.0], [0.0, 0.5, 0.0], [1.0, 0.0, 2.0]])

    def project(self, p):
        """Point in the left camera's frame to [u, v, d]. Returns y, Y_p.

        See Also
        --------
        retro : The inverse.
        """
        p = np.asanyarray(p)
        up, UP_p = project(p)
        u, U_up, _ = pixellise(up, self.k)
        with np.errstate(divide="ignore", invalid="ignore"):
            d = self.k[2] * self.baseline / p[..., 2:]
            D_p = np.concatenate([0 * d, 0 * d, -d / p[..., 2:]], -1)
        return np.concatenate([u, d], -1), np.concatenate([U_up @ UP_p, D_p[..., None, :]], -2)

    def retro(self, y):
        """[u, v, d] to a point in the left camera's frame: depth au baseline / d times the ray. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        y = np.asanyarray(y)
        d = y[..., 2:]
        up, UP_u, _ = depixellise(y[..., :2], self.k)
        s = self.k[2] * self.baseline / d
        v, V_up, V_s = retro(up, s)
        return v, np.concatenate([V_up @ UP_u, V_s * (-s / d)[..., None]], -1)

    def visible(self, y, p):
        """Return True for each point in front of the cameras and in both images, as far as the disparity can tell."""
        right = np.stack([y[..., 0] - y[..., 2], y[..., 1]], -1)
        return (p[..., 2] > 0) & (y[..., 2] >= self.min_disparity) & self.inside(y) & self.inside(right)
