"""Euclidean point: the landmark of the lecture."""

from dataclasses import dataclass

import numpy as np

from .projective import check_dim


@dataclass(frozen=True)
class EucPnt:
    """A point l = p, in metres; 2 or 3 numbers.

    Parameters
    ----------
    dim : int
        2 in the plane, 3 in space.

    See Also
    --------
    HmgPnt, AhmPnt, IdpPnt : What a single ray can start.

    Notes
    -----
    A bearing-only sensor can observe such a point but not start one: a ray does not fix it, and no Gaussian over
    its depth is honest. That is why there is no `from_ray`.
    """

    dim: int = 3

    def __post_init__(self):
        check_dim(self)

    @property
    def size(self):
        """Length of the state."""
        return self.dim

    def to_frame(self, F, l):
        """The point in frame F. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        return F.to_frame(l)

    def from_frame(self, F, l):
        """The point of frame F in its parent. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        return F.from_frame(l)

    def point(self, l):
        """Euclidean point. Returns p, P_l.

        See Also
        --------
        from_point : The inverse.
        """
        return l, np.eye(self.dim)

    def ray(self, l):
        """The point itself: every point is on its own ray. Returns v, V_l.

        See Also
        --------
        point : The same numbers.
        """
        return l, np.eye(self.dim)

    def from_point(self, p):
        """Landmark at a point. Returns l, L_p, L_n (no columns: nothing is left to guess).

        See Also
        --------
        point : The inverse.
        """
        return p, np.eye(self.dim), np.zeros((self.dim, 0))
