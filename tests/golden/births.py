"""Classes for tests only, with the derivatives of the recorded program where these are not the exact ones.

The recorded program normalises the direction v of a new anchored or homogeneous point with the derivative I / |v|; the
exact one is the projector (I - u u') / |v|. It takes I / |q| for the derivative of normalising a quaternion, too. So
its covariance keeps a part along q, and what its Jacobians say of a longer q counts. Of a Plücker line they say
something of their own: the moment of the frame is R't x R'v there, of the fourth degree in q. With unit quaternions all
is the same.

These classes change one Jacobian each and nothing else. They are used like any class of the package, which knows
nothing of them.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import AhmLin, AhmPnt, AplLin, HmgLin, HmgPnt, PlkLin
from ekfslam_tutorial.models.motion import Odometry3


def approximate_unit(v):
    """u = v / |v| with the derivative I / |v|."""
    n = np.sqrt((v * v).sum(-1))[..., None]
    return v / n, np.eye(v.shape[-1]) / n[..., None]


@dataclass(frozen=True)
class RecordedAhmPnt(AhmPnt):
    """Anchored homogeneous point, born as in the recorded program."""

    def from_ray(self, v, n):
        l, L_v, L_n = super().from_ray(v, n)
        L_v = L_v.copy()
        L_v[..., self.dim : -1, :] = approximate_unit(v)[1]
        return l, L_v, L_n


@dataclass(frozen=True)
class RecordedHmgPnt(HmgPnt):
    """Homogeneous point, born as in the recorded program."""

    def from_ray(self, v, n):
        l, L_v, L_n = super().from_ray(v, n)
        L_v = L_v.copy()
        L_v[..., :-1, :] = approximate_unit(v)[1]
        return l, L_v, L_n


@dataclass(frozen=True)
class RecordedAhmLin(AhmLin):
    """Anchored homogeneous line, born as in the recorded program but for its block that is a row too high."""

    kind: ClassVar = RecordedAhmPnt()


@dataclass(frozen=True)
class RecordedHmgLin(HmgLin):
    """Homogeneous line, born as in the recorded program."""

    kind: ClassVar = RecordedHmgPnt()


@dataclass(frozen=True)
class FreePlkLin(PlkLin):
    """Plücker line that is left as a correction leaves it: n' v is not brought back to zero."""

    def normalized(self, l):
        return l, np.eye(6)


@dataclass(frozen=True)
class FreeAplLin(AplLin):
    """The same with an anchor; its abscissas count from the point nearest to the origin, as in the recorded program."""

    def support(self, l):
        L = np.concatenate([self.normal(l)[0], l[..., 6:]], -1)
        L_l = np.concatenate([self.normal(l)[1], np.broadcast_to(np.eye(3, 9, 6), (*l.shape[:-1], 3, 9))], -2)
        p0, d, P0_L, D_L = PlkLin().support(L)
        return p0, d, P0_L @ L_l, D_L @ L_l

    def normalized(self, l):
        return l, np.eye(9)


@dataclass(frozen=True)
class RecordedPlkLin(FreePlkLin):
    """The same with the derivative along q of the recorded change of frame."""

    def to_frame(self, F, l):
        lf, LF_f, LF_l = super().to_frame(F, l)
        moment, LF_f = F.to_frame(np.cross(F.t, l[..., 3:]), 0.0)[0], LF_f.copy()
        LF_f[..., :3, 3:] -= 2 * moment[..., None] * F.q
        return lf, LF_f, LF_l


class RecordedFrame3(Frame3):
    """Frame whose quaternion is normalised with the derivative I / |q|."""

    def normalized(self):
        N, N_f = super().normalized()
        N_f = N_f.copy()
        N_f[3:, 3:] = np.eye(4) / np.linalg.norm(self.q)
        return N, N_f


@dataclass(frozen=True)
class RecordedOdometry3(Odometry3):
    """Odometry of a robot with such a frame."""

    frame: ClassVar = RecordedFrame3
