"""What landmarks with an inverse distance share."""

import numpy as np

from ...geometry import identity
from ...geometry.arrays import blank, zeros


def check_dim(lmk):
    """Refuse a landmark that is neither in the plane nor in space.

    Raises
    ------
    ValueError
    """
    if lmk.dim not in (2, 3):
        raise ValueError(f"{type(lmk).__name__}: dim must be 2 or 3, got {lmk.dim!r}")


def along(rho):
    """+1 in front of the anchor, -1 behind: the sign that keeps a ray a point up to a *positive* scale.

    An inverse distance that a correction has turned negative puts the point behind; zero is infinity, ahead.
    """
    return 1.0 - 2.0 * (rho < 0)


def scalar(n, v):
    """A prior n of one number, repeated for each of the vectors v: shape (..., 1)."""
    return np.broadcast_to(n, (*v.shape[:-1], 1))


def homogeneous(m, rho, M_f, M_m, M_rho):
    """State [m; rho] and its Jacobians by the frame and by the state, from those of m; rho stays what it was."""
    lead, d = M_f.shape[:-2], m.shape[-1]
    l = np.concatenate([m, np.broadcast_to(rho, (*m.shape[:-1], 1))], -1)
    L_f, L_l = zeros(l, *lead, d + 1, M_f.shape[-1]), zeros(l, *lead, d + 1, d + 1)
    L_f[..., :d, :] = M_f
    L_l[..., :d, :d], L_l[..., :d, d:], L_l[..., d, d] = M_m, M_rho, 1
    return l, L_f, L_l


def anchored(t, m, rho, T_f, T_t, M_f, M_m):
    """State [t; m; rho] of anchor, direction and inverse distance, with its Jacobians by the frame and the state."""
    lead, d, k = T_f.shape[:-2], t.shape[-1], m.shape[-1]
    l = np.concatenate([t, m, rho], -1)
    L_f, L_l = zeros(l, *lead, d + k + 1, T_f.shape[-1]), zeros(l, *lead, d + k + 1, d + k + 1)
    L_f[..., :d, :], L_f[..., d : d + k, :] = T_f, M_f
    L_l[..., :d, :d], L_l[..., d : d + k, d : d + k], L_l[..., -1, -1] = T_t, M_m, 1
    return l, L_f, L_l


def anchored_point(t, m, rho, M_u):
    """Point p = t + m / rho of a landmark whose direction has the Jacobian M_u. Returns p, P_l."""
    d, k = M_u.shape[-2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        p = t + m / rho
        P_l = blank(t, *t.shape[:-1], d, d + k + 1)
        P_l[..., :d] = identity(d)
        P_l[..., d:-1] = M_u / rho[..., None]
        P_l[..., -1] = -m / rho**2
    return p, P_l


def anchored_ray(t, m, rho, M_u):
    """Ray v = t rho + m, turned round where rho < 0, so that p = v / |rho|. Returns v, V_l."""
    d, k = M_u.shape[-2:]
    V_l = blank(t, *t.shape[:-1], d, d + k + 1)
    V_l[..., :d] = rho[..., None] * identity(d)
    V_l[..., d:-1] = M_u
    V_l[..., -1] = t
    s = along(rho)
    return s * (t * rho + m), s[..., None] * V_l


def weight(rho, size):
    """Weight w = |rho| of a ray v: p = v / w. Returns w, W_l for a state of this size that ends in rho."""
    s = along(rho)
    W_l = zeros(rho, *rho.shape, size)
    W_l[..., -1] = s
    return s * rho, W_l


def ahead(l, min_rho):
    """The landmark itself, or with the inverse distance min_rho where a correction has turned it negative."""
    if l[-1] >= 0:
        return l
    return np.concatenate([l[:-1], [min_rho]])


def linearity(t, m, rho, var_rho, camera):
    """Linearity index of an anchored point: small where a Euclidean Gaussian would do as well.

        L = 4 sigma_d / d |cos a|,    sigma_d = sigma_rho / rho^2

    d is the distance from the camera to the point, a the angle between the direction m of its birth and the direction
    from which it is seen now. Civera, Davison, Montiel, "Inverse depth to depth conversion for monocular SLAM",
    ICRA 2007, eq. 10 and 17.
    """
    d = t + m / rho - camera
    d1 = np.sqrt(d @ d)
    return 4 * np.sqrt(var_rho) / rho**2 / d1 * abs(m @ d) / (np.sqrt(m @ m) * d1)
