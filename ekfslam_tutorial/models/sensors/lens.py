"""Radial distortion of a lens, and its inverses. Points are on the normalised image plane: [x/z, y/z]."""

import numpy as np


def radial(u, d):
    """Radial polynomial map u (1 + d1 r^2 + d2 r^4 + ...), r = |u|.

    Returns
    -------
    ud : ndarray, shape (..., 2)
    UD_u : ndarray, shape (..., 2, 2)
    UD_d : ndarray, shape (..., 2, len(d))

    See Also
    --------
    distort, undistort : Its two uses.
    """
    if not len(d):
        return u, np.eye(2), np.empty((*u.shape, 0))
    d = np.asarray(d, float)
    k = np.arange(1, len(d) + 1)
    r2 = (u * u).sum(-1)[..., None]
    powers = r2**k
    f = 1 + (powers @ d)[..., None]
    f_r2 = ((r2 ** (k - 1)) @ (k * d))[..., None]
    UD_u = f[..., None] * np.eye(2) + 2 * f_r2[..., None] * u[..., :, None] * u[..., None, :]
    return f * u, UD_u, u[..., :, None] * powers[..., None, :]


def distort(up, d):
    """Lens distortion of normalised image points with the vector d = [d2 d4 d6 ...]. Returns ud, UD_up, UD_d.

    See Also
    --------
    undistort : The inverse, approximate.
    exact_undistort : The inverse.
    """
    return radial(up, d)


def undistort(ud, c):
    """The manual's inverse of `distort`: the same polynomial with a correction vector c. Returns up, UP_ud, UP_c.

    Approximate; see `inv_distortion` for c and `exact_undistort` for the exact inverse.

    See Also
    --------
    distort : The inverse.
    """
    return radial(ud, c)


def exact_undistort(ud, d, iterations=25):
    """Exact inverse of `distort` by Newton's method on the radius. Returns up, UP_ud.

    NaN where the distortion has no inverse (beyond the fold of a strong barrel distortion).

    See Also
    --------
    distort : The inverse.
    """
    if not len(d):
        return ud, np.eye(2)
    rd = np.linalg.norm(ud, axis=-1)
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
        UP_ud = np.linalg.inv(np.where(solvable[..., None, None], UD_up, np.eye(2)))
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

    See Also
    --------
    undistort : Its use.
    """
    d = np.asarray(d, float)
    if d.size == 0:
        return d
    u0, v0, au, av = k
    r = np.linspace(0, 1.1 * np.hypot(u0 / au, v0 / av), 101)
    rd = r * (1 + r[:, None] ** (2 * np.arange(1, len(d) + 1)) @ d)
    powers = rd[:, None] ** (2 * np.arange(1, n + 1) + 1)
    return np.linalg.pinv(powers) @ (r - rd)
