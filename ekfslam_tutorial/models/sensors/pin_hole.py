"""Pin-hole camera with radial distortion, and the manual's functions that it is made of.

Axes of the camera: x right, y down, z forward (RDF). Direct chain (manual, section 5.1):
point -> project -> distort -> pixellise; the inverse chain: depixellise -> undistort -> retro.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from ...geometry import identity
from ...geometry.arrays import blank, floats, inverse, matrix, numbers
from ...geometry.arrays import vector as stacked
from .checks import positive, vector

# --- the manual's functions: plain arrays, every Jacobian ------------------------------------------------------------


def project(p):
    """Perspective projection up = [x/z, y/z]. Returns up, UP_p (..., 2, 3). Not finite at z = 0."""
    (x, y, z), lead = numbers(p), p.shape[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        w = inverse(z)
        u, v = x * w, y * w
        return stacked(lead, u, v), matrix(lead, [w, 0.0, -u * w], [0.0, w, -v * w])


def retro(up, s):
    """Back-projection p = s [up; 1], s the depth along z (..., 1). Returns p, P_up (..., 3, 2), P_s (..., 3, 1)."""
    ray = np.concatenate([up, np.ones((*up.shape[:-1], 1))], -1)
    P_up = np.concatenate([identity(2), np.zeros((1, 2))])
    return s * ray, np.asarray(s)[..., None] * P_up, ray[..., None]


def radial(u, d):
    """Radial polynomial map u (1 + d1 r^2 + d2 r^4 + ...), r = |u|.

    Returns
    -------
    ud : ndarray, shape (..., 2)
    UD_u : ndarray, shape (..., 2, 2)
    UD_d : ndarray, shape (..., 2, len(d))
    """
    if not len(d):
        return u, identity(2), np.empty((*u.shape, 0))
    d = np.asarray(d, float)
    k = np.arange(1, len(d) + 1)
    r2 = (u * u).sum(-1)[..., None]
    powers = r2**k
    f = 1 + (powers @ d)[..., None]
    f_r2 = ((r2 ** (k - 1)) @ (k * d))[..., None]
    UD_u = f[..., None] * identity(2) + 2 * f_r2[..., None] * u[..., :, None] * u[..., None, :]
    return f * u, UD_u, u[..., :, None] * powers[..., None, :]


def distort(up, d):
    """Lens distortion of normalised image points with the vector d = [d2 d4 d6 ...]. Returns ud, UD_up, UD_d."""
    return radial(up, d)


def undistort(ud, c):
    """The manual's inverse of `distort`: the same polynomial with a correction vector c. Returns up, UP_ud, UP_c.

    Approximate; see `inv_distortion` for c and `exact_undistort` for the exact inverse.
    """
    return radial(ud, c)


def exact_undistort(ud, d, iterations=25):
    """Exact inverse of `distort` by Newton's method on the radius. Returns up, UP_ud.

    NaN where the distortion has no inverse (beyond the fold of a strong barrel distortion).
    """
    if not len(d):
        return ud, identity(2)
    rd = np.sqrt((ud * ud).sum(-1))
    r = rd.copy()
    k = np.arange(1, len(d) + 1)
    with np.errstate(all="ignore"):
        for _ in range(iterations):
            powers = r[..., None] ** (2 * k)
            r = r - (r * (1 + powers @ d) - rd) / (1 + powers @ ((2 * k + 1) * d))
        found = np.abs(r * (1 + r[..., None] ** (2 * k) @ d) - rd) <= 1e-12 * (1 + rd)
        up = np.where(found & (r >= 0), np.where(rd > 0, r / rd, 1.0), np.nan)[..., None] * ud
        UD_up = distort(up, d)[1]
        solvable = np.isfinite(UD_up).all((-1, -2)) & (np.linalg.det(UD_up) != 0)
        UP_ud = np.linalg.inv(np.where(solvable[..., None, None], UD_up, identity(2)))
    return up, np.where(solvable[..., None, None], UP_ud, np.nan)


def inv_distortion(d, n, k):
    """Correction vector c of n numbers for a distortion vector d: a least-squares fit over the image.

    Parameters
    ----------
    d : array_like
        Distortion vector.
    n : int
        Length of the correction vector.
    k : array_like, shape (4,)
        Intrinsic parameters [u0, v0, au, av]; they say how far the image reaches.

    Returns
    -------
    ndarray, shape (n,) or (0,)
        c such that undistort(distort(up, d), c) is near up on 101 radii, up to 1.1 times that of the image corner.
    """
    d = np.asarray(d, float)
    if d.size == 0:
        return d
    u0, v0, au, av = k
    r = np.linspace(0, 1.1 * np.hypot(u0 / au, v0 / av), 101)
    rd = r * (1 + r[:, None] ** (2 * np.arange(1, len(d) + 1)) @ d)
    powers = rd[:, None] ** (2 * np.arange(1, n + 1) + 1)
    return np.linalg.pinv(powers) @ (r - rd)


def pixellise(ud, k):
    """Metric image point to pixel [u0 + au x, v0 + av y]. Returns u, U_ud (2, 2), U_k (..., 2, 4)."""
    (u0, v0, au, av), (x, y), lead = k, numbers(ud), ud.shape[:-1]
    U_k = matrix(lead, [1.0, 0.0, x, 0.0], [0.0, 1.0, 0.0, y])
    return stacked(lead, u0 + au * x, v0 + av * y), np.array([[au, 0.0], [0.0, av]], float), U_k


def depixellise(u, k):
    """Pixel to metric image point [(u - u0)/au, (v - v0)/av]. Returns ud, UD_u (2, 2), UD_k (..., 2, 4)."""
    centre, focal = np.array(k[:2]), np.array(k[2:])
    ud, UD_u = (u - centre) / focal, np.diag(1 / focal)
    UD_k = blank(ud, *ud.shape, 4)
    UD_k[..., :2] = -UD_u
    UD_k[..., 2:] = -ud[..., None] * UD_u
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
    """
    ud, UD_u, UD_k = depixellise(u, k)
    up, UP_ud, UP_c = undistort(ud, c)
    p, P_up, P_s = retro(up, s)
    P_ud = P_up @ UP_ud
    return p, P_ud @ UD_u, P_s, P_ud @ UD_k, P_up @ UP_c


# --- the sensor model ------------------------------------------------------------------------------------------------


class Imager:
    """What cameras with an image of a given size share."""

    image_size: tuple
    pixel_std: float

    def check_image(self):
        """Refuse an image without pixels and noise that is not positive."""
        if not (vector(self, "image_size", 2) > 0).all():
            raise ValueError(f"{type(self).__name__}: image_size must be two positive numbers, got {self.image_size!r}")
        positive(self, "pixel_std")

    def inside(self, u):
        """Whether pixels lie in the image, borders included."""
        u, v = u[..., 0], u[..., 1]
        return (u >= 0) & (v >= 0) & (u <= self.image_size[0]) & (v <= self.image_size[1])

    def residual(self, y, e):
        """Innovation y - e, pixels."""
        return np.subtract(y, e)


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

    Raises
    ------
    ValueError
        For singular intrinsic parameters, an image without pixels, or vectors of the wrong length.
    """

    k: tuple = (320.0, 240.0, 320.0, 320.0)
    d: tuple = ()
    c: tuple | None = field(default=None, kw_only=True)
    image_size: tuple = field(default=(640.0, 480.0), kw_only=True)
    pixel_std: float = field(default=1.0, kw_only=True)

    dim: ClassVar[int] = 3
    bearing_only: ClassVar[bool] = True
    units: ClassVar = ("px", "px")

    def __post_init__(self):
        self.check_image()
        k = vector(self, "k", 4)
        if k[2] == 0 or k[3] == 0:
            raise ValueError(
                f"{type(self).__name__}: k = [u0, v0, au, av] is singular, au and av must not be zero, got {self.k!r}"
            )
        vector(self, "d")
        if self.c is not None:
            vector(self, "c")

    @cached_property
    def R(self):
        """Measurement noise covariance, pixel_std^2 I."""
        return self.pixel_std**2 * identity(2)

    def project(self, p):
        """Point or ray in the camera frame to pixel. Returns y, Y_p."""
        y, Y_p, _, _ = pin_hole(floats(p), self.k, self.d)
        return y, Y_p

    def retro(self, y):
        """Pixel to the ray [x/z, y/z, 1]. Returns v, V_y."""
        ud, UD_y, _ = depixellise(floats(y), self.k)
        up, UP_ud, *_ = exact_undistort(ud, np.asarray(self.d)) if self.c is None else undistort(ud, self.c)
        v, V_up, _ = retro(up, np.ones((*up.shape[:-1], 1)))
        return v, V_up @ UP_ud @ UD_y

    def project_parameters(self, p):
        """Derivatives of `project` by the camera's parameters. Returns y, Y_k (..., 2, 4), Y_d (..., 2, len(d))."""
        y, _, Y_k, Y_d = pin_hole(floats(p), self.k, self.d)
        return y, Y_k, Y_d

    def retro_parameters(self, y):
        """Derivatives of `retro` by the camera's parameters. Returns v, V_k (..., 3, 4), V_c (..., 3, len(c)).

        Without a correction vector the last one is by the distortion d, whose exact inverse is used then.
        """
        ud, _, UD_k = depixellise(floats(y), self.k)
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
        """Whether points lie in front of the camera, in the image, and on this side of the fold of the lens."""
        r = np.sqrt((p[..., :2] ** 2).sum(-1))
        return self.inside(y) & (p[..., 2] > 0) & (r < self.fold * p[..., 2])
