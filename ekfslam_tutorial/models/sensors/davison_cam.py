"""A wide-angle camera with the lens of Davison's MonoSLAM: one coefficient, and an inverse in closed form."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .imager import Imager
from .pin_hole import depixellise, pixellise, project, retro


def bend(u, k1):
    """Radial map u / sqrt(1 + 2 k1 |u|^2). Returns ud, UD_u (..., 2, 2); its inverse is that of -k1.

    With k1 > 0 it draws the image together. Not a number where 1 + 2 k1 |u|^2 is not positive. A. J. Davison,
    I. D. Reid, N. D. Molton, O. Stasse, "MonoSLAM: Real-time single camera SLAM", IEEE T-PAMI 29(6), 2007, section 3.

    See Also
    --------
    distort : The polynomial of the manual.
    """
    square = 1 + 2 * k1 * (u * u).sum(-1)[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        f = np.where(square > 0, 1 / np.sqrt(np.where(square > 0, square, 1.0)), np.nan)
    outer = u[..., :, None] * u[..., None, :]
    return f * u, f[..., None] * np.eye(2) - (2 * k1 * f**3)[..., None] * outer


@dataclass(frozen=True)
class DavisonCam(Imager):
    """Camera with a wide angle: measures the pixel [u, v] of a point; a bearing, no distance.

    The ideal pixel, seen from the centre, is drawn together: u_d = u_u / sqrt(1 + 2 k1 |u_u|^2). The inverse has the
    same form with -k1, where a polynomial needs many coefficients or iterations.

    Parameters
    ----------
    k : sequence of 4 floats
        Intrinsic parameters [u0, v0, au, av], pixels.
    k1 : float
        Coefficient of the lens, 1 / pixel^2.
    image_size : sequence of 2 floats
        Width and height, pixels.
    pixel_std : float
        Standard deviation of the measurement noise, pixels.
    margin : float
        Width of the frame inside the image that does not count as visible, pixels: half a patch, say.

    See Also
    --------
    PinHole : With the polynomial lens of the manual.
    bend : The lens itself.
    """

    k: tuple = (162.0, 125.0, 195.0, 195.0)
    k1: float = 9e-6
    image_size: tuple = (320.0, 240.0)
    pixel_std: float = 1.0
    margin: float = 0.0

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = True
    units: ClassVar = ("px", "px")

    def __post_init__(self):
        self.check_image()
        self.check_intrinsics()
        if not np.isfinite(self.k1):
            raise ValueError(f"DavisonCam: k1 must be a finite number, got {self.k1!r}")

    def project(self, p):
        """Point or ray in the camera frame to pixel. Returns y, Y_p.

        See Also
        --------
        retro : The inverse, but for the length.
        """
        up, UP_p = project(p)
        u, U_up, _ = pixellise(up, self.k)
        centre = np.array(self.k[:2], float)
        ud, UD_u = bend(u - centre, self.k1)
        return centre + ud, UD_u @ U_up @ UP_p

    def retro(self, y):
        """Pixel to the ray [x/z, y/z, 1]. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        centre = np.array(self.k[:2], float)
        uu, UU_y = bend(y - centre, -self.k1)
        up, UP_u, _ = depixellise(centre + uu, self.k)
        v, V_up, _ = retro(up, np.ones((*up.shape[:-1], 1)))
        return v, V_up @ UP_u @ UU_y

    def visible(self, y, p):
        """Return True for each point in front of the camera and in the image."""
        return self.inside(y) & (p[..., 2] > 0)
