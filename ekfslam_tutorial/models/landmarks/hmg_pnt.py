"""Homogeneous point: straight lines and planes stay what they are, and infinity is a number."""

from dataclasses import dataclass

import numpy as np

from ...geometry import unit
from .projective import along, check_dim, homogeneous, scalar, weight


@dataclass(frozen=True)
class HmgPnt:
    """A point l = [m; rho] at p = m / rho; m is a direction from the world's origin.

    Born from a ray, m is a unit vector of the sensor frame and rho the inverse distance (1/m).
    A correction may turn rho negative: the point is then taken to lie behind, and not mended (as in the manual).
    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM", IJCV 97 (2012), section 3.2.

    Parameters
    ----------
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    AhmPnt : With an anchor.
    EucPnt : Without the inverse distance.
    """

    dim: int = 3

    def __post_init__(self):
        check_dim(self)

    @property
    def size(self):
        """Length of the state."""
        return self.dim + 1

    def to_frame(self, F, l):
        """m_F = R' (m - rho t), rho_F = rho. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        m, rho = l[..., :-1], l[..., -1:]
        mf, M_f, M_m = F.to_frame(m, rho)
        M_rho = -F.Rt @ F.t[..., None]
        return homogeneous(mf, rho, M_f, M_m, M_rho)

    def from_frame(self, F, l):
        """m = R m_F + rho_F t, rho = rho_F. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        mf, rho = l[..., :-1], l[..., -1:]
        m, M_f, M_mf = F.from_frame(mf, rho)
        return homogeneous(m, rho, M_f, M_mf, F.t[..., None])

    def point(self, l):
        """p = m / rho. Returns p, P_l. Not finite at rho = 0: the point is at infinity.

        See Also
        --------
        from_point : The inverse.
        ray : Also at infinity.
        """
        m, rho = l[..., :-1], l[..., -1:]
        with np.errstate(divide="ignore", invalid="ignore"):
            p = m / rho
            I = np.broadcast_to(np.eye(self.dim), (*m.shape, self.dim))
            return p, np.concatenate([I, -p[..., None]], -1) / rho[..., None]

    def ray(self, l):
        """v = m, turned round where rho < 0, so that p = v / |rho|. Returns v, V_l.

        See Also
        --------
        from_ray : The inverse.
        homogeneous : With its weight.
        """
        m, rho = l[..., :-1], l[..., -1:]
        s = along(rho)
        V_m = s[..., None] * np.eye(self.dim)
        return s * m, np.concatenate([V_m, np.zeros((*m.shape, 1))], -1)

    def homogeneous(self, l):
        """The ray and its weight |rho|: p = v / |rho|. Returns v, w, V_l, W_l.

        See Also
        --------
        ray : Without its weight.
        """
        v, V_l = self.ray(l)
        w, W_l = weight(l[..., -1:], self.size)
        return v, w, V_l, W_l

    def from_ray(self, v, n):
        """l = [v / |v|; n], n the prior inverse distance. Returns l, L_v, L_n.

        See Also
        --------
        ray : The inverse.
        """
        m, M_v = unit(v)
        L_v = np.concatenate([M_v, np.zeros((*m.shape[:-1], 1, self.dim))], -2)
        return np.concatenate([m, scalar(n, m)], -1), L_v, np.eye(self.size)[:, -1:]

    def from_point(self, p):
        """l = [p / |p|; 1 / |p|]. Returns l, L_p, L_n (no columns).

        See Also
        --------
        point : The inverse.
        """
        m, M_p = unit(p)
        rho = 1 / np.linalg.norm(p, axis=-1, keepdims=True)
        RHO_p = -(rho**2)[..., None] * m[..., None, :]
        return np.concatenate([m, rho], -1), np.concatenate([M_p, RHO_p], -2), np.zeros((self.size, 0))
