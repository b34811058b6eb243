"""Plücker line: the normal of the plane through the origin, and the direction."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...geometry import hat, unit
from .lines import plane_base, vector_product


def perpendicular(a, b):
    """a without its part along b: the nearest to a that a' b = 0 allows. Returns c, C_a, C_b."""
    bb = (b * b).sum(-1)[..., None]
    s = (a * b).sum(-1)[..., None] / bb
    S_a, S_b = (b / bb)[..., None, :], (a / bb - 2 * s * b / bb)[..., None, :]
    C_a = np.eye(3) - b[..., None] @ S_a
    return a - s * b, C_a, -s[..., None] * np.eye(3) - b[..., None] @ S_b


@dataclass(frozen=True)
class PlkLin:
    """A line l = [n; v]: its points p have p x v = n. v is a direction, and n the normal of its plane with the origin.

    Six numbers for four degrees of freedom: the scale means nothing, and n' v = 0. The distance from the origin is
    |n| / |v|. Bartoli and Sturm, "Structure-from-motion using lines", CVIU 100 (2005), have the change of frame and the
    projection; Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97
    (2012), the birth: the prior says where in its plane the line lies.

    See Also
    --------
    AplLin : With an anchor.
    IdpLin, HmgLin, AhmLin : By two points.
    """

    dim: ClassVar[int] = 3
    size: ClassVar[int] = 6
    priors: ClassVar = (1.0, 0.0)

    def to_frame(self, F, l):
        """v_F = R' v, n_F = R' (n - t x v). Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        n, v, t = l[..., :3], l[..., 3:], F.t
        vf, VF_f, VF_v = F.to_frame(v, 0.0)
        nf, NF_f, NF_m = F.to_frame(n - np.cross(t, v), 0.0)
        NF_f = NF_f + NF_m @ hat(v) @ np.eye(3, F.size)
        return _stack(nf, vf, NF_f, VF_f, NF_m, -NF_m @ hat(t), VF_v)

    def from_frame(self, F, l):
        """v = R v_F, n = R n_F + t x v. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        v, V_f, V_vf = F.from_frame(l[..., 3:], 0.0)
        m, M_f, M_nf = F.from_frame(l[..., :3], 0.0)
        c, C_t, C_v = vector_product(F.t, v)
        return _stack(m + c, v, M_f + C_t @ np.eye(3, F.size) + C_v @ V_f, V_f, M_nf, C_v @ V_vf, V_vf)

    def normal(self, l):
        """n itself. Returns n, N_l.

        See Also
        --------
        from_rays : The inverse.
        """
        return l[..., :3], np.eye(3, 6)

    def support(self, l):
        """The point v x n / v' v nearest to the origin, and the direction v / |v|. Returns p0, d, P0_l, D_l."""
        n, v = l[..., :3], l[..., 3:]
        d, D_v = unit(v)
        vv = (v * v).sum(-1)[..., None]
        c, C_v, C_n = vector_product(v, n)
        p0 = c / vv
        P0_v = (C_v - 2 * p0[..., :, None] * v[..., None, :]) / vv[..., None]
        return p0, d, np.concatenate([C_n / vv[..., None], P0_v], -1), D_v @ np.eye(6)[3:]

    def from_rays(self, v, n):
        """Line seen along two rays v = [v1; v2]; the prior n = [b1, b2] is its direction. Returns l, L_v, L_n.

        The unit normal is v1 x v2 / |v1 x v2|. In its plane the direction is b1 e1 + b2 e2, e1 parallel to the image;
        so |b| is the inverse distance of the line.

        See Also
        --------
        normal : The inverse.
        """
        c, C_1, C_2 = vector_product(v[..., :3], v[..., 3:])
        m, M_c = unit(c)
        e1, e2, E1_m, E2_m = plane_base(m)
        b1, b2 = n[..., :1], n[..., 1:]
        W_m = b1[..., None] * E1_m + b2[..., None] * E2_m
        L_m = np.concatenate([np.broadcast_to(np.eye(3), W_m.shape), W_m], -2)
        L_n = np.eye(6)[:, 3:] @ np.stack([e1, e2], -1)
        L_v = L_m @ M_c @ np.concatenate([C_1, C_2], -1)
        return np.concatenate([m, b1 * e1 + b2 * e2], -1), L_v, L_n

    def normalized(self, l):
        """The line with n' v = 0, which a correction does not keep. Returns l, L_l."""
        m, M_n, M_v = perpendicular(l[..., :3], l[..., 3:])
        l2, _, L_l = _stack(m, l[..., 3:], M_n, M_n, M_n, M_v, np.eye(3))
        return l2, L_l


def _stack(n, v, N_f, V_f, N_n, N_v, V_v):
    """[n; v] and its derivatives by a frame and by the line it was; v does not depend on n."""
    l = np.concatenate([n, v], -1)
    L_f = np.concatenate(np.broadcast_arrays(N_f, V_f), -2)
    L_l = np.zeros_like(l, shape=(*l.shape, 6))
    L_l[..., :3, :3], L_l[..., :3, 3:], L_l[..., 3:, 3:] = N_n, N_v, V_v
    return l, L_f, L_l
