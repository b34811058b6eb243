"""Landmark classes for tests only: points whose birth has the recorded program's approximate derivative.

The recorded program normalises the direction v of a new anchored or homogeneous point with the derivative I / |v|; the
exact one is the projector (I - u u') / |v|. These classes change that one Jacobian and nothing else. They are used like
any class of the package, which knows nothing of them.
"""

from dataclasses import dataclass

import numpy as np

from ekfslam_tutorial.models.landmarks import AhmPnt, HmgPnt


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
