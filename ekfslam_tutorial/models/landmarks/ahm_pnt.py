"""Anchored homogeneous point: a homogeneous point whose origin is where it was first seen from."""

from dataclasses import dataclass

import numpy as np

from ...geometry import unit
from .projective import ahead, anchored, anchored_point, anchored_ray, check_dim, linearity, scalar, weight


@dataclass(frozen=True)
class AhmPnt:
    """A point l = [x0; m; rho] at p = x0 + m / rho: anchor x0 (m), direction m, inverse distance rho (1/m).

    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM", IJCV 97 (2012), section 3.3.
    m is a unit vector at birth only: corrections may change its norm, and the point keeps its meaning.

    Parameters
    ----------
    dim : int
        2 in the plane (5 numbers), 3 in space (7 numbers).

    See Also
    --------
    HmgPnt : Without an anchor.
    IdpPnt : With two angles instead of the direction's vector.
    """

    dim: int = 3

    def __post_init__(self):
        check_dim(self)

    @property
    def size(self):
        """Length of the state."""
        return 2 * self.dim + 1

    def _split(self, l):
        d = self.dim
        return l[..., :d], l[..., d:-1], l[..., -1:]

    def to_frame(self, F, l):
        """Anchor as a point, m as a direction. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        t, m, rho = self._split(l)
        t, T_f, T_t = F.to_frame(t)
        m, M_f, M_m = F.to_frame(m, 0.0)
        return anchored(t, m, rho, T_f, T_t, M_f, M_m)

    def from_frame(self, F, l):
        """Anchor as a point, m as a direction. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        t, m, rho = self._split(l)
        t, T_f, T_t = F.from_frame(t)
        m, M_f, M_m = F.from_frame(m, 0.0)
        return anchored(t, m, rho, T_f, T_t, M_f, M_m)

    def point(self, l):
        """p = x0 + m / rho. Returns p, P_l. Not finite at rho = 0: the point is at infinity.

        See Also
        --------
        from_point : The inverse.
        ray : Also at infinity.
        """
        t, m, rho = self._split(l)
        return anchored_point(t, m, rho, np.eye(self.dim))

    def ray(self, l):
        """v = x0 rho + m, turned round where rho < 0. Returns v, V_l.

        See Also
        --------
        from_ray : The inverse.
        homogeneous : With its weight.
        """
        t, m, rho = self._split(l)
        return anchored_ray(t, m, rho, np.eye(self.dim))

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
        """l = [0; v / |v|; n], n the prior inverse distance. Returns l, L_v, L_n.

        See Also
        --------
        ray : The inverse.
        """
        m, M_v = unit(v)
        l = np.concatenate([np.zeros_like(m), m, scalar(n, m)], -1)
        L_v = np.zeros_like(l, shape=(*l.shape, self.dim))
        L_v[..., self.dim : -1, :] = M_v
        return l, L_v, np.eye(self.size)[:, -1:]

    def from_point(self, p):
        """l = [0; p / |p|; 1 / |p|]. Returns l, L_p, L_n (no columns).

        See Also
        --------
        point : The inverse.
        """
        l, L_v, L_n = self.from_ray(p, 1 / np.linalg.norm(p, axis=-1, keepdims=True))
        RHO_p = -(l[..., -1:] ** 2)[..., None] * l[..., None, self.dim : -1]
        return l, L_v + L_n @ RHO_p, np.zeros((self.size, 0))

    def ahead(self, l, min_rho):
        """The landmark with an inverse distance that is not negative."""
        return ahead(l, min_rho)

    def linearity(self, l, P, camera):
        """Linearity index, seen from a camera at this place; below about 0.1 a Euclidean point will do."""
        return linearity(l[: self.dim], l[self.dim : -1], l[-1], P[-1, -1], camera)
