"""Omnidirectional camera: a mirror or a fish-eye lens, with polynomials instead of a lens model.

Scaramuzza, Martinelli, Siegwart, "A flexible technique for accurate omnidirectional camera calibration", ICVS 2006.
Axes as for the pin-hole camera: x right, y down, z along the optical axis.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ...geometry import unit
from .imager import Imager
from .parameters import check_angle, check_positive, finite_numbers


def polynomial(a, x):
    """Value and derivatives of a_0 + a_1 x + a_2 x^2 + ... Returns f, f_x, F_a (..., len(a)).

    See Also
    --------
    radial : That of a pin-hole lens, in even powers.
    """
    n = np.arange(len(a))
    powers = np.asarray(x)[..., None] ** n
    slopes = n[1:] * powers[..., :-1]
    return powers @ a, slopes @ np.asarray(a, float)[1:], powers


def omni_project(p, d):
    """Direction to metric image point: radius f(theta) with the forward polynomial d, theta the elevation of p.

    theta = atan2(z, r), r = hypot(x, y): pi/2 on the optical axis. Returns u, U_p (..., 2, 3), U_d (..., 2, len(d)).
    On the axis itself u = 0, and the derivatives are not finite.

    See Also
    --------
    omni_retro : The inverse, with the backward polynomial.
    """
    xy, z = p[..., :2], p[..., 2:]
    r = np.linalg.norm(xy, axis=-1, keepdims=True)
    rho, rho_theta, RHO_d = polynomial(d, np.arctan2(z, r)[..., 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        axis = xy / r
        THETA_p = np.concatenate([-z * axis, r], -1) / (r * r + z * z)
        AXIS_p = np.concatenate([unit(xy)[1], np.zeros((*xy.shape, 1))], -1)
        U_p = axis[..., :, None] * (rho_theta[..., None] * THETA_p)[..., None, :] + rho[..., None, None] * AXIS_p
        u = np.where(r > 0, axis * rho[..., None], 0.0)
        return u, U_p, axis[..., :, None] * RHO_d[..., None, :]


def omni_ray(u, c):
    """Metric image point to the ray [u; g(|u|)] with the backward polynomial c. Of any length.

    Returns v (..., 3), V_u (..., 3, 2), V_c (..., 3, len(c)).

    See Also
    --------
    omni_retro : The same, of length one.
    """
    r = np.linalg.norm(u, axis=-1)
    z, z_r, Z_c = polynomial(c, r)
    axis = u / np.where(r > 0, r, 1.0)[..., None]
    V_u = np.concatenate([np.broadcast_to(np.eye(2), (*u.shape, 2)), (z_r[..., None] * axis)[..., None, :]], -2)
    V_c = np.concatenate([np.zeros((*u.shape, len(c))), Z_c[..., None, :]], -2)
    return np.concatenate([u, z[..., None]], -1), V_u, V_c


def omni_retro(u, c):
    """Metric image point to unit ray: `omni_ray`, normalised. Returns p, P_u, P_c.

    See Also
    --------
    omni_project : The inverse, with the forward polynomial.
    omni_ray : The same, of any length.
    """
    v, V_u, V_c = omni_ray(u, c)
    p, P_v = unit(v)
    return p, P_v @ V_u, P_v @ V_c


def omni_pixellise(u, k):
    """Metric image point to pixel [x + e y + xc, d x + c y + yc], k = [xc, yc, c, d, e]. Returns y, Y_u, Y_k.

    See Also
    --------
    omni_depixellise : The inverse.
    """
    xc, yc, c, d, e = k
    A = np.array([[1.0, e], [d, c]])
    x, y, zero, one = u[..., 0], u[..., 1], np.zeros_like(u[..., 0]), np.ones_like(u[..., 0])
    Y_k = np.stack([np.stack([one, zero, zero, zero, y], -1), np.stack([zero, one, y, x, zero], -1)], -2)
    return u @ A.T + [xc, yc], A, Y_k


def omni_depixellise(y, k):
    """Pixel to metric image point, the inverse of `omni_pixellise`. Returns u, U_y, U_k.

    See Also
    --------
    omni_pixellise : The inverse.
    """
    xc, yc, c, d, e = k
    U_y = np.linalg.inv(np.array([[1.0, e], [d, c]]))
    u = (y - np.array([xc, yc])) @ U_y.T
    return u, U_y, -U_y @ omni_pixellise(u, k)[2]


def omni_cam(p, k, d):
    """Omnidirectional camera: point in the camera frame to pixel. Returns y, Y_p, Y_k, Y_d.

    See Also
    --------
    inv_omni_cam : The inverse.
    """
    u, U_p, U_d = omni_project(p, d)
    y, Y_u, Y_k = omni_pixellise(u, k)
    return y, Y_u @ U_p, Y_k, Y_u @ U_d


def inv_omni_cam(y, k, c):
    """Inverse omnidirectional camera: pixel to unit ray. Returns p, P_y, P_k, P_c.

    See Also
    --------
    omni_cam : The inverse.
    """
    u, U_y, U_k = omni_depixellise(y, k)
    p, P_u, P_c = omni_retro(u, c)
    return p, P_u @ U_y, P_u @ U_k, P_c


@dataclass(frozen=True)
class OmniCam(Imager):
    """Omnidirectional camera: measures the pixel [u, v] of a point; a bearing, no distance.

    Parameters
    ----------
    k : sequence of 5 floats
        Affine pixel map [xc, yc, c, d, e]: centre in pixels, and the matrix [[1, e], [d, c]].
    d : sequence of floats
        Forward polynomial, lowest power first: image radius (pixels) from the elevation over the mirror plane (rad).
    c : sequence of floats, optional
        Backward polynomial, lowest power first: z from the image radius. Calibration tools give both, and each is a
        fit. Without it the inverse of the forward polynomial is found numerically, exact.
    image_size : sequence of 2 floats
        Width and height, pixels.
    pixel_std : float
        Standard deviation of the measurement noise, pixels.
    fov : float
        Opening angle round the optical axis within which points are seen, rad; pi is a half space.
    margin : float
        Width of the frame inside the image that does not count as visible, pixels: half a patch, say.

    See Also
    --------
    PinHole : With a lens that keeps straight lines straight.
    """

    k: tuple
    d: tuple
    c: tuple | None = field(default=None, kw_only=True)
    image_size: tuple = field(default=(1280.0, 960.0), kw_only=True)
    pixel_std: float = field(default=1.0, kw_only=True)
    margin: float = field(default=0.0, kw_only=True)
    fov: float = field(default=np.pi, kw_only=True)

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = True
    units: ClassVar = ("px", "px")
    parameters: ClassVar = ("k", "d")
    angles: ClassVar = ("fov",)

    def __post_init__(self):
        self.check_image()
        check_positive(self, "fov")
        check_angle(self, "fov", 2 * np.pi)
        k = finite_numbers(self, "k", 5)
        if k[2] == k[3] * k[4]:
            raise ValueError(f"OmniCam: k = [xc, yc, c, d, e] is singular, c - d e must not be zero, got {self.k!r}")
        if not finite_numbers(self, "d").size:
            raise ValueError("OmniCam: d must hold at least one coefficient of the forward polynomial, got none")
        if self.c is not None:
            finite_numbers(self, "c")

    def project(self, p):
        """Point or ray in the camera frame to pixel. Returns y, Y_p.

        See Also
        --------
        retro : The inverse, but for the length.
        """
        y, Y_p, _, _ = omni_cam(p, self.k, self.d)
        return y, Y_p

    def retro(self, y):
        """Pixel to a ray of any length; a landmark's birth normalises it. Returns v, V_y.

        See Also
        --------
        project : The inverse.
        """
        u, U_y, _ = omni_depixellise(y, self.k)
        v, V_u, _ = self._exact_retro(u) if self.c is None else omni_ray(u, self.c)
        return v, V_u @ U_y

    def project_parameters(self, p):
        """Derivatives of `project` by the camera's parameters. Returns y, Y_k (..., 2, 5), Y_d (..., 2, len(d)).

        See Also
        --------
        retro_parameters : The way back.
        """
        y, _, Y_k, Y_d = omni_cam(p, self.k, self.d)
        return y, Y_k, Y_d

    def retro_parameters(self, y):
        """Derivatives of `retro` by the camera's parameters. Returns v, V_k (..., 3, 5), V_c (..., 3, len(c)).

        Without a backward polynomial the last one is by the forward polynomial d, whose exact inverse is used then.

        See Also
        --------
        project_parameters : The way forth.
        """
        u, _, U_k = omni_depixellise(y, self.k)
        v, V_u, V_c = self._exact_retro(u) if self.c is None else omni_ray(u, self.c)
        return v, V_u @ U_k, V_c

    def _exact_retro(self, u, iterations=50):
        """Unit ray whose forward projection is u: Newton's method on the elevation, from the middle of the view."""
        r = np.linalg.norm(u, axis=-1)
        theta = np.full_like(r, np.pi / 2 - self.fov / 4)
        with np.errstate(all="ignore"):
            for _ in range(iterations):
                rho, slope, _ = polynomial(self.d, theta)
                last, theta = theta, np.clip(theta - (rho - r) / slope, np.pi / 2 - self.fov, np.pi / 2)
                if np.array_equal(theta, last, equal_nan=True):
                    break
            rho, slope, RHO_d = polynomial(self.d, theta)
            theta = np.where(np.abs(rho - r) <= 1e-9 * (1 + r), theta, np.nan)
            axis, AXIS_u = unit(u)
            c, s = np.cos(theta)[..., None], np.sin(theta)[..., None]
            THETA_u = axis / slope[..., None]
            V_theta = np.concatenate([-s * axis, c], -1)
            V_u = np.concatenate([c[..., None] * AXIS_u, np.zeros((*c.shape, 2))], -2)
            THETA_d = -RHO_d / slope[..., None]
        v = np.concatenate([c * axis, s], -1)
        return v, V_u + V_theta[..., :, None] * THETA_u[..., None, :], V_theta[..., :, None] * THETA_d[..., None, :]

    def visible(self, y, p):
        """Return True for each point in the field of view and in the image."""
        angle = np.arctan2(np.linalg.norm(p[..., :2], axis=-1), p[..., 2])
        return self.inside(y) & (angle < self.fov / 2)
