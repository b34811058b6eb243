"""Anchored Plücker line: a Plücker line whose origin is where it was first seen from."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .lines import vector_product
from .plk_lin import PlkLin, perpendicular

LINE = PlkLin()
LAST = np.eye(6, 9, 3)
"""Selection of [n; v] from the state."""


@dataclass(frozen=True)
class AplLin:
    """A line l = [x0; n; v]: its points p have (p - x0) x v = n, with the anchor x0 (m).

    n and v are what they are in a Plücker line, seen from the anchor. So a change of frame turns them and no more; what
    is uncertain of a line that was seen from one place stays a matter of that place. So a wide prior does not make the
    filter too sure of itself, as it does with a Plücker line, which has forgotten where it was seen from.
    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97 (2012).

    See Also
    --------
    PlkLin : Without an anchor.
    """

    dim: ClassVar[int] = 3
    size: ClassVar[int] = 9
    priors: ClassVar = (1.0, 0.0)

    def to_frame(self, F, l):
        """Anchor as a point, n and v as directions. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        return self._change(F.to_frame, l)

    def from_frame(self, F, l):
        """Anchor as a point, n and v as directions. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        return self._change(F.from_frame, l)

    @staticmethod
    def _change(transform, l):
        parts = [transform(l[..., i : i + 3], w) for i, w in ((0, 1.0), (3, 0.0), (6, 0.0))]
        x, X_f, X_x = zip(*parts, strict=True)
        L_l = np.zeros_like(l, shape=(*l.shape, 9))
        for i, J in enumerate(X_x):
            L_l[..., 3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = J
        return np.concatenate(x, -1), np.concatenate(np.broadcast_arrays(*X_f), -2), L_l

    def normal(self, l):
        """n + x0 x v: the normal seen from the origin. Returns n, N_l.

        See Also
        --------
        from_rays : The inverse.
        """
        c, C_x, C_v = vector_product(l[..., :3], l[..., 6:])
        return l[..., 3:6] + c, np.concatenate([C_x, np.broadcast_to(np.eye(3), C_x.shape), C_v], -1)

    def support(self, l):
        """The point nearest to the anchor, and the direction v / |v|. Returns p0, d, P0_l, D_l."""
        p0, d, P0_l, D_l = LINE.support(l[..., 3:])
        return l[..., :3] + p0, d, P0_l @ LAST + np.eye(3, 9), D_l @ LAST

    def from_rays(self, v, n):
        """Line seen along two rays v = [v1; v2]; the prior n = [b1, b2] is its direction. Returns l, L_v, L_n.

        See Also
        --------
        normal : The inverse.
        """
        l, L_v, L_n = LINE.from_rays(v, n)
        zero = np.zeros_like(l, shape=(*l.shape[:-1], 3))
        return np.concatenate([zero, l], -1), LAST.T @ L_v, LAST.T @ L_n

    def normalized(self, l):
        """The line with n' v = 0, which a correction does not keep. Returns l, L_l.

        It is v that gives way. Seen from the anchor, n has been measured, and v was a prior. P holds the condition
        for the v that it was corrected from, which may have been another direction altogether: so what it says of v
        across the plane is out of date, and follows anew from n.
        """
        d, D_v, D_n = perpendicular(l[..., 6:], l[..., 3:6])
        L_l = np.zeros_like(l, shape=(*l.shape, 9))
        L_l[..., :6, :6], L_l[..., 6:, 3:6], L_l[..., 6:, 6:] = np.eye(6), D_n, D_v
        return np.concatenate([l[..., :6], d], -1), L_l
