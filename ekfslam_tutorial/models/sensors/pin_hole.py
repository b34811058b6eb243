"""Pin-hole camera with radial distortion, and the manual's functions that it is made of.

Axes of the camera: x right, y down, z forward (RDF). Direct chain (manual, section 5.1):
point -> project -> distort -> pixellise; the inverse chain: depixellise -> undistort -> retro.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from .imager import Imager
from .lens import distort, exact_undistort, undistort
from .parameters import finite_numbers

# --- the manual's functions: plain arrays, every Jacobian ------------------------------------------------------------


def project(p):
    """Perspective projection up = [x/z, y/z]. Returns up, UP_p (..., 2, 3). Not finite at z = 0.

    See Also
    --------
    retro : The inverse.
    """
    p = np.asanyarray(p)
    with np.errstate(divide="ignore", invalid="ignore"):
        w = 1 / p[..., 2:]
        up, zero = p[..., :2] * w, np.zeros_like(w)
        UP_x, UP_y = np.concatenate([w, zero], -1), np.concatenate([zero, w], -1)
        return up, np.stack([UP_x, UP_y, -w * up], -1)


def retro(up, s):
    """Back-projection p = s [up; 1], s the depth along z (..., 1). Returns p, P_up (..., 3, 2), P_s (..., 3, 1).

    See Also
    --------
    project : The inverse.
    """
    ray = np.concatenate([up, np.ones((*up.shape[:-1], 1))], -1)
    P_up = np.eye(3, 2)
    return s * ray, np.expand_dims(s, -1) * P_up, ray[..., None]


def pixellise(ud, k):
    """Metric image point to pixel [u0 + au x, v0 + av y]. Returns u, U_ud (2, 2), U_k (..., 2, 4).

    See Also
    --------
    depixellise : The inverse.
    """
    centre, focal = np.array(k[:2], float), np.array(k[2:], float)
    u = centre + focal * ud
    U_k = np.zeros_like(u, shape=(*u.shape, 4))
    U_k[..., 0, 0], U_k[..., 1, 1] = 1.0, 1.0
    U_k[..., 0, 2], U_k[..., 1, 3] = ud[..., 0], ud[..., 1]
    return u, np.diag(focal), U_k


def depixellise(u, k):
    """Pixel to metric image point [(u - u0)/au, (v - v0)/av]. Returns ud, UD_u (2, 2), UD_k (..., 2, 4).

    See Also
    --------
    pixellise : The inverse.
    """
    centre, focal = np.array(k[:2], float), np.array(k[2:], float)
    ud, UD_u = (u - centre) / focal, np.diag(1 / focal)
    UD_k = np.concatenate([np.broadcast_to(-UD_u, (*ud.shape, 2)), -ud[..., None] * UD_u], -1)
    return ud, UD_u, UD_k


def pin_hole(p, k, d):
    """Pin-hole camera: point in the camera frame to pixel. Manual, section 5.1.

    Parameters
    ----------
    p : ndarray, shape (..., 3)
        Metres, axes RDF.
    k : array_like, shape (4,)
        [u0, v0, au, av], pixels.
    d : array_like
        Distortion vector [d2, d4, d6, ...]; may be empty.

    Returns
    -------
    u : ndarray, shape (..., 2)
    U_p, U_k, U_d : ndarray, shape (..., 2, 3), (..., 2, 4), (..., 2, len(d))

    See Also
    --------
    inv_pin_hole : The inverse.
    project, distort, pixellise : Its links.
    """
    up, UP_p = project(p)
    ud, UD_up, UD_d = distort(up, d)
    u, U_ud, U_k = pixellise(ud, k)
    return u, U_ud @ UD_up @ UP_p, U_k, U_ud @ UD_d


def inv_pin_hole(u, s, k, c):
    """Inverse pin-hole camera: pixel and depth s to a point in the camera frame. Manual, section 5.2.

    Returns
    -------
    p : ndarray, shape (..., 3)
    P_u, P_s, P_k, P_c : ndarray, shape (..., 3, 2), (..., 3, 1), (..., 3, 4), (..., 3, len(c))

    See Also
    --------
    pin_hole : The inverse.
    depixellise, undistort, retro : Its links.
    """
    ud, UD_u, UD_k = depixellise(u, k)
    up, UP_ud, UP_c = undistort(ud, c)
    p, P_up, P_s = retro(up, s)
    P_ud = P_up @ UP_ud
    return p, P_ud @ UD_u, P_s, P_ud @ UD_k, P_up @ UP_c


# --- the sensor model ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PinHole(Imager):
    """Pin-hole camera: measures the pixel [u, v] of a point; a bearing, no distance.

    Parameters
    ----------
    k : sequence of 4 floats
        Intrinsic parameters [u0, v0, au, av], pixels.
    d : sequence of floats
        Radial distortion [d2, d4, d6, ...]; empty for an ideal lens.
    c : sequence of floats, optional
        Correction vector of the manual, an approximate inverse of the distortion (`inv_distortion` fits one).
        Without it the inverse is exact.
    image_size : sequence of 2 floats
        Width and height, pixels.
    pixel_std : float
        Standard deviation of the measurement noise, pixels.
    margin : float
        Width of the frame inside the image that does not count as visible, pixels: half a patch, say. Negative, where
        the distortion has been taken off the pixels: so far outside of the image they still count.

    Raises
    ------
    ValueError
        For singular intrinsic parameters, an image without pixels, or vectors of the wrong length.

    See Also
    --------
    PinHoleDepth : With the depth.
    StereoPinHole : With a second camera.
    DavisonCam : With one coefficient of distortion.
    OmniCam : With a mirror or a fish-eye lens.
    """

    k: tuple = (320.0, 240.0, 320.0, 320.0)
    d: tuple = ()
    c: tuple | None = field(default=None, kw_only=True)
    image_size: tuple = field(default=(640.0, 480.0), kw_only=True)
    pixel_std: float = field(default=1.0, kw_only=True)
    margin: float = field(default=0.0, kw_only=True)

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = True
    units: ClassVar = ("px", "px")
    parameters: ClassVar = ("k", "d")
    tied: ClassVar = ("f",)

    def __post_init__(self):
        self.check_image()
        self.check_intrinsics()
        finite_numbers(self, "d")
        if self.c is not None:
            finite_numbers(self, "c")

    def tie(self, name):
        """The focal length f moves au and av together: in a camera with square pixels they are one number.

        Returns
        -------
        of : str
            Which parameter it moves.
        K_f : ndarray, shape (4,)
        f : float
            Its value, au; pixels.
        """
        return "k", np.array([0.0, 0.0, 1.0, self.k[3] / self.k[2]]), self.k[2]

    def project(self, p):
        """Point or ray in the camera frame to pixel. Returns y, Y_p.

        See Also
        --------
        retro : The inverse, but for the length.
        """
        y, Y_p, _, _ = pin_hole(p, self.k, self.d)
        return y, Y_p

    def retro(self, y):
        """Pixel to the ray [x/z, y/z, 1]. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        ud, UD_y, _ = depixellise(y, self.k)
        up, UP_ud, *_ = exact_undistort(ud, np.asarray(self.d)) if self.c is None else undistort(ud, self.c)
        v, V_up, _ = retro(up, np.ones((*up.shape[:-1], 1)))
        return v, V_up @ UP_ud @ UD_y

    def project_parameters(self, p):
        """Derivatives of `project` by the camera's parameters. Returns y, Y_k (..., 2, 4), Y_d (..., 2, len(d)).

        See Also
        --------
        retro_parameters : The way back.
        """
        y, _, Y_k, Y_d = pin_hole(p, self.k, self.d)
        return y, Y_k, Y_d

    def retro_parameters(self, y):
        """Derivatives of `retro` by the camera's parameters. Returns v, V_k (..., 3, 4), V_c (..., 3, len(c)).

        Without a correction vector the last one is by the distortion d, whose exact inverse is used then.

        See Also
        --------
        project_parameters : The way forth.
        """
        ud, _, UD_k = depixellise(y, self.k)
        if self.c is None:
            up, UP_ud = exact_undistort(ud, np.asarray(self.d))
            UP_c = -UP_ud @ distort(up, self.d)[2]  # distort(up, d) = ud, differentiated by d
        else:
            up, UP_ud, UP_c = undistort(ud, self.c)
        v, V_up, _ = retro(up, np.ones((*up.shape[:-1], 1)))
        return v, V_up @ UP_ud @ UD_k, V_up @ UP_c

    @cached_property
    def fold(self):
        """Image radius x^2 + y^2 = r^2 at which a barrel distortion folds back; infinite if it never does."""
        k = np.arange(len(self.d), -1, -1)
        roots = np.roots((2 * k + 1) * np.concatenate([self.d[::-1], [1.0]]))
        r2 = roots[(np.abs(roots.imag) < 1e-12) & (roots.real > 0)].real
        return np.sqrt(r2.min()) if r2.size else np.inf

    def visible(self, y, p):
        """Return True for each point in front of the camera, in the image, and on this side of the fold of the lens."""
        r = np.linalg.norm(p[..., :2], axis=-1)
        return self.inside(y) & (p[..., 2] > 0) & (r < self.fold * p[..., 2])
