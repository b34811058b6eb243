"""Anchored homogeneous line: a line through two anchored homogeneous points with one anchor."""

from dataclasses import dataclass
from typing import ClassVar

from .ahm_pnt import AhmPnt
from .idp_lin import ahead
from .lines import TwoPoints


@dataclass(frozen=True)
class AhmLin(TwoPoints):
    """A line l = [x0; m1; rho1; m2; rho2] through the points x0 + m / rho.

    Born from the two ends of a segment, with a prior inverse distance (1/m) for each.
    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97 (2012).

    See Also
    --------
    AhmPnt : The points.
    HmgLin : Without an anchor.
    """

    kind: ClassVar = AhmPnt()
    anchor: ClassVar[int] = 3
    priors: ClassVar = (1.0, 1.0)

    def ahead(self, l, min_rho):
        """The line with inverse distances that are not negative: if one is, both become `min_rho`."""
        return ahead(l, min_rho, [6, 10])
