"""A radio beacon: a point whose ranges are wrong in a way of its own, by a bias and by a scale."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .projective import check_dim


@dataclass(frozen=True)
class Beacon:
    """A point with the faults of its ranges, l = [p, b, s]: a range r is measured as (1 + s) r + b.

    Delays in the electronics of a beacon make all its ranges too long by b (m). A clock that is too fast, or the wave
    on its way along the ground, makes them too long by a share s of the range. Both are states: what the filter cannot
    tell from the place of the beacon stays correlated with it.

    For a range sensor that is the range of another point, the *apparent* one, in the same direction:

        p_a = ((1 + s) + b / |p|) p,    |p_a| = (1 + s) |p| + b

    Sensors measure that one (see `models.observation.to_sensor`); `point` is where the beacon is.

    Parameters
    ----------
    dim : int
        2 in the plane, 3 in space.
    bias_std : float
        How well b is known to be zero before the first range, m; 0 for no bias.
    scale_std : float
        How well s is known to be zero before the first range; 0 for no scale.

    See Also
    --------
    EucPnt : For ranges without faults.

    Notes
    -----
    J. Djugash, S. Singh, "A robust method of localization and mapping using only range", ISER 2008, has the bias of
    each beacon among the states.
    """

    dim: int = 2
    bias_std: float = 1.0
    scale_std: float = 0.0

    prior: ClassVar[int] = 2
    """How many numbers its first range leaves open beside the direction: b and s."""

    def __post_init__(self):
        check_dim(self)
        for name in ("bias_std", "scale_std"):
            value = getattr(self, name)
            if not 0 <= value < np.inf:
                raise ValueError(f"Beacon: {name} must be a number of 0 or more, got {value!r}")

    @property
    def size(self):
        """Length of the state."""
        return self.dim + 2

    @property
    def N(self):
        """Covariance of [b, s] before the first range."""
        return np.diag([self.bias_std, self.scale_std]) ** 2

    def to_frame(self, F, l):
        """The beacon in frame F; bias and scale stay what they are. Returns l_F, LF_f, LF_l.

        See Also
        --------
        from_frame : The inverse.
        """
        return self._moved(F.to_frame, l)

    def from_frame(self, F, l):
        """The beacon of frame F in its parent. Returns l, L_f, L_lf.

        See Also
        --------
        to_frame : The inverse.
        """
        return self._moved(F.from_frame, l)

    def _moved(self, transform, l):
        p, P_f, P_p = transform(l[..., : self.dim])
        D = np.eye(self.dim, self.size)
        O = np.eye(self.size) - D.T @ D  # of bias and scale
        return np.concatenate([p, l[..., self.dim :]], -1), D.T @ P_f, D.T @ P_p @ D + O

    def point(self, l):
        """Place of the beacon. Returns p, P_l.

        See Also
        --------
        apparent : Where a range sensor sees it.
        """
        return l[..., : self.dim], np.eye(self.dim, self.size)

    def ray(self, l):
        """The point itself: every point is on its own ray. Returns v, V_l."""
        return self.point(l)

    def apparent(self, l):
        """Apparent place, where a range sensor at the origin sees it: (1 + s + b / |p|) p. Returns v, V_l.

        See Also
        --------
        from_apparent : The inverse.
        """
        p, b, s = l[..., : self.dim], l[..., self.dim : -1], l[..., -1:]
        r = np.sqrt((p * p).sum(-1))[..., None]
        u = p / r
        a = 1 + s + b / r
        V_p = a[..., None] * np.eye(self.dim) - (b / r)[..., None] * u[..., :, None] * u[..., None, :]
        return a * p, np.concatenate([V_p, u[..., None], p[..., None]], -1)

    def from_apparent(self, v, n):
        """Beacon that a range sensor at the origin sees at v, if n = [b, s]. Returns l, L_v, L_n.

        See Also
        --------
        apparent : The inverse.
        """
        b, s = n[..., :1], n[..., 1:]
        r = np.sqrt((v * v).sum(-1))[..., None]
        u = v / r
        a = (1 - b / r) / (1 + s)
        D, O = np.eye(self.size, self.dim), np.eye(self.size)[:, self.dim :]
        P_v = a[..., None] * np.eye(self.dim) + (b / r / (1 + s))[..., None] * u[..., :, None] * u[..., None, :]
        P_n = np.concatenate([(-u / (1 + s))[..., None], (-a / (1 + s) * v)[..., None]], -1)
        return np.concatenate([a * v, b + 0 * r, s + 0 * r], -1), D @ P_v, D @ P_n + O

    def from_point(self, p):
        """Beacon without faults at a point. Returns l, L_p, L_n (no columns: nothing is left to guess).

        See Also
        --------
        point : The inverse.
        """
        zero = np.zeros_like(p, shape=(*p.shape[:-1], 2))
        return np.concatenate([p, zero], -1), np.eye(self.size, self.dim), np.zeros((self.size, 0))
