"""Inverse-depth line: a line through two inverse-depth points with one anchor."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from .idp_pnt import IdpPnt
from .lines import TwoPoints


@dataclass(frozen=True)
class IdpLin(TwoPoints):
    """A line l = [x0; pitch1; yaw1; rho1; pitch2; yaw2; rho2] through the points x0 + m(pitch, yaw) / rho.

    Born from the two ends of a segment, with a prior inverse distance (1/m) for each.
    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97 (2012).

    See Also
    --------
    IdpPnt : The points.
    AhmLin : With vectors instead of the angles.
    """

    kind: ClassVar = IdpPnt()
    anchor: ClassVar[int] = 3
    priors: ClassVar = (1.0, 1.0)

    def ahead(self, l, min_rho):
        """The line with inverse distances that are not negative: if one is, both become `min_rho`."""
        return ahead(l, min_rho, [5, 8])


def ahead(l, min_rho, of):
    """The line itself, or with the inverse distances `of` set to min_rho where a correction has turned one negative."""
    if (l[of] >= 0).all():
        return l
    l = np.array(l)
    l[of] = min_rho
    return l
