"""What landmarks with an inverse distance share."""

import numpy as np


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

    See Also
    --------
    ahead : Puts a negative inverse distance right.
    """
    return np.where(rho < 0, -1.0, 1.0)


def scalar(n, v):
    """A prior n of one number, repeated for each of the vectors v: shape (..., 1)."""
    return np.broadcast_to(n, (*v.shape[:-1], 1))


def homogeneous(m, rho, M_f, M_m, M_rho):
    """State [m; rho] and its Jacobians by the frame and by the state, from those of m; rho stays what it was.

    See Also
    --------
    anchored : The same with an anchor.
    """
    d = m.shape[-1]
    l = np.concatenate([m, scalar(rho, m)], -1)
    L_f = np.zeros_like(l, shape=(*l.shape, M_f.shape[-1]))
    L_f[..., :d, :] = M_f
    L_l = np.zeros_like(l, shape=(*l.shape, d + 1))
    L_l[..., :d, :d], L_l[..., :d, d:], L_l[..., d, d] = M_m, M_rho, 1
    return l, L_f, L_l


def anchored(t, m, rho, T_f, T_t, M_f, M_m):
    """State [t; m; rho] of anchor, direction and inverse distance, with its Jacobians by the frame and the state.

    See Also
    --------
    homogeneous : The same without an anchor.
    anchored_point : The point of such a state.
    anchored_ray : Its ray.
    """
    l = np.concatenate([t, m, rho], -1)
    anchor, direction = slice(0, t.shape[-1]), slice(t.shape[-1], -1)
    L_f = np.zeros_like(l, shape=(*l.shape, T_f.shape[-1]))
    L_f[..., anchor, :], L_f[..., direction, :] = T_f, M_f
    L_l = np.zeros_like(l, shape=(*l.shape, l.shape[-1]))
    L_l[..., anchor, anchor], L_l[..., direction, direction], L_l[..., -1, -1] = T_t, M_m, 1
    return l, L_f, L_l


def anchored_point(t, m, rho, M_u):
    """Point p = t + m / rho of a landmark whose direction has the Jacobian M_u. Returns p, P_l.

    See Also
    --------
    anchored_ray : Finite at rho = 0, too.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        p = t + m / rho
        return p, _columns(p, np.eye(p.shape[-1]), M_u / rho[..., None], (-m / rho**2)[..., None])


def anchored_ray(t, m, rho, M_u):
    """Ray v = t rho + m, turned round where rho < 0, so that p = v / |rho|. Returns v, V_l.

    See Also
    --------
    anchored_point : The point itself.
    weight : The weight |rho| of the ray.
    """
    s = along(rho)
    v = s * (t * rho + m)
    return v, s[..., None] * _columns(v, rho[..., None] * np.eye(v.shape[-1]), M_u, t[..., None])


def _columns(p, P_t, P_u, P_rho):
    """The Jacobian of p by a state [t; m; rho]: its blocks side by side, each for all points or the same for all."""
    return np.concatenate([np.broadcast_to(P, (*p.shape, P.shape[-1])) for P in (P_t, P_u, P_rho)], -1)


def weight(rho, size):
    """Weight w = |rho| of a ray v: p = v / w. Returns w, W_l for a state of this size that ends in rho.

    See Also
    --------
    anchored_ray : The ray.
    """
    s = along(rho)
    w = s * rho
    W_l = np.zeros_like(w, shape=(*w.shape, size))
    W_l[..., -1] = s
    return w, W_l


def ahead(l, min_rho):
    """The landmark itself, or with the inverse distance min_rho where a correction has turned it negative.

    See Also
    --------
    along : The sign of what is behind.
    """
    if l[-1] >= 0:
        return l
    return np.concatenate([l[:-1], [min_rho]])


def linearity(t, m, rho, var_rho, camera):
    """Linearity index of an anchored point: small where a Euclidean Gaussian would do as well.

        L = 4 sigma_d / d |cos a|,    sigma_d = sigma_rho / rho^2

    d is the distance from the camera to the point, a the angle between the direction m of its birth and the direction
    from which it is seen now. Civera, Davison, Montiel, "Inverse depth to depth conversion for monocular SLAM",
    ICRA 2007, eq. 10 and 17.

    See Also
    --------
    anchored_point : The Euclidean point.
    """
    d = t + m / rho - camera
    d1 = np.sqrt(d @ d)
    return 4 * np.sqrt(var_rho) / rho**2 / d1 * abs(m @ d) / (np.sqrt(m @ m) * d1)
