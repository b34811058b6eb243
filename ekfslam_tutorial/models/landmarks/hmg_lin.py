"""Homogeneous line: a line through two homogeneous points."""

from dataclasses import dataclass
from typing import ClassVar

from .hmg_pnt import HmgPnt
from .lines import TwoPoints


@dataclass(frozen=True)
class HmgLin(TwoPoints):
    """A line l = [m1; rho1; m2; rho2] through the points m / rho.

    Born from the two ends of a segment, with a prior inverse distance (1/m) for each.
    Solà et al., "Impact of landmark parametrization on monocular EKF-SLAM with points and lines", IJCV 97 (2012).

    See Also
    --------
    HmgPnt : The points.
    AhmLin : With an anchor.
    """

    kind: ClassVar = HmgPnt()
    anchor: ClassVar[int] = 0
    priors: ClassVar = (1.0, 1.0)
