"""Angles, quaternions, reference frames, alignment and numerical Jacobians.

Lives here: functions of plain arrays that know nothing of robots, sensors or filters.
May not: import anything of this package but `geometry` itself.
"""

from .alignment import align
from .angles import wrap
from .frames import ORIGIN, Frame2, Frame3
from .jacobians import check_jacobians, numerical_jacobian
from .quaternions import (
    R2q,
    au2q,
    au2v,
    e2q,
    e2R,
    hat,
    pi2pc,
    q2au,
    q2e,
    q2Pi,
    q2Q,
    q2qc,
    q2Qn,
    q2R,
    q2R_q,
    q2v,
    q_prod,
    unit,
    v2au,
    v2q,
    w2omega,
)

__all__ = [
    "ORIGIN",
    "Frame2",
    "Frame3",
    "R2q",
    "align",
    "au2q",
    "au2v",
    "check_jacobians",
    "e2R",
    "e2q",
    "hat",
    "numerical_jacobian",
    "pi2pc",
    "q2Pi",
    "q2Q",
    "q2Qn",
    "q2R",
    "q2R_q",
    "q2au",
    "q2e",
    "q2qc",
    "q2v",
    "q_prod",
    "unit",
    "v2au",
    "v2q",
    "w2omega",
    "wrap",
]
