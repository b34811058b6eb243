"""Does a filter know how wrong it is, when nobody knows the truth? Its own corrections tell.

The corrections of an honest filter are uncorrelated in time, and each is as large as K S K' says. So the sum of the
corrections of many seconds is as large as the sum of these covariances. Where errors last, those of a landmark that is
measured 2 % too near for half a minute, corrections go the same way again and again, and their sum is too large. No
truth is needed: only mean and covariance of the pose before and after each correction.

    a = K z = x+ - x-,    A = K S K' = P- - P+
    over blocks b of T seconds    g_b = sum of a,    V_b = sum of A
    S(T) = sum over b of g_b' V_b^-1 g_b / number of degrees of freedom
    c    = largest S(T) over T = 1, 3, 10, 30, 60, 120 s

An honest filter has S(T) near 1 for every T; with R and U times c, a filter that is too sure becomes honest, and its
estimate stays as it is, but for the gate.

Source: the innovations of an optimal filter are white (T. Kailath, "An innovations approach to least-squares
estimation", IEEE Trans. Automatic Control 13(6), 1968; R. K. Mehra, "On the identification of variances and adaptive
Kalman filtering", IEEE Trans. Automatic Control 15(2), 1970), so the corrections are, too. Their sums over blocks
instead of correlations of single innovations see an error that lasts for minutes. docs/tuning.md has what this was
measured to find, and what it is blind to.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ekf import chi_square

LENGTHS = 1, 3, 10, 30, 60, 120
"""Lengths T of the blocks, s: from single corrections to a round trip."""
FEWEST = 15
"""Degrees of freedom that a length must have, five poses in the plane, to be asked at all."""
FLAT = 1e-6
"""Directions in which the blocks' corrections have less of their variance, as correlation, are left out: rounding."""
CHANCE = 1e-4
"""Probability that an honest filter is above `CorrectionRatio.limit`."""
QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
"""A quarter turn: a small turn theta of the world moves a point p by theta QUARTER p."""
SURE = 0.975
"""A ratio is sure if an honest filter has none so large with this probability, whatever the length of the blocks."""
GROSS = 1.5
"""A ratio up to here is nothing to warn of: an honest filter that is not linear has it, too."""


@dataclass(frozen=True)
class CorrectionRatio:
    """Ratio of the sums of the corrections to what was expected of them.

    Parameters
    ----------
    value : float
        The largest S(T): 1 is right, more is over-confident. NaN if the run is too short.
    seconds : int
        Its T.
    limit : float
        What an honest filter stays below, except by a chance of 1 in 10,000.
    by_length : dict of int to (float, int)
        S(T) and its degrees of freedom, by T.
    """

    value: float
    seconds: int
    limit: float
    by_length: dict

    @property
    def too_large(self):
        """True if chance does not explain it: the filter is over-confident."""
        return bool(self.value > max(self.limit, GROSS))

    @property
    def sure(self):
        """True if chance alone would seldom make it so large: the largest of several lengths, which share the chance.

        Of honest filters 1 to 2 % are sure. With the whole chance for each length it would be 4 to 8 %, and of the
        larger of two axes up to 10 %.
        """
        _, dof = self.by_length.get(self.seconds, (0.0, 0))
        return bool(dof and self.value * dof > chi_square.quantile(1 - (1 - SURE) / len(self.by_length), dof))

    @property
    def factor(self):
        """The factor for R and U: `value`, and at least 1, for lasting errors hide noise that is told too large."""
        return max(1.0, self.value) if np.isfinite(self.value) else 1.0


def corrections(frame, x0, P0, x1, P1, turned: Any = False):
    """Corrections of a pose and their covariances, from the pose before and after.

        a = x1 - x0,    A = P0 - P1 = K S K'

    The invariant error turns P1 with the world, about its origin, P1 = T (P0 - K S K') T'. Then it is turned back: the
    turn theta of the world stays, and a position goes with it by (p1 - p0) x theta less.

        A = P0 - T^-1 P1 T^-T

    Parameters
    ----------
    frame : type
        Frame2 or Frame3.
    x0, x1 : ndarray, shape (N, size)
        Before and after.
    P0, P1 : ndarray, shape (N, size, size)
    turned : bool or ndarray of bool, shape (N,)
        P1 has been turned.

    Returns
    -------
    a : ndarray, shape (N, dof)
        [metres; radians], in the tangent space at x0.
    A : ndarray, shape (N, dof, dof)
    """
    F0, F1 = frame(x0), frame(x1)
    a, _ = F1.minus(F0)
    _, E0 = F0.minus(F0)
    _, E1 = F1.minus(F1)
    turned = np.broadcast_to(turned, len(x0))[:, None, None]
    E1 = np.where(turned, turned_back(F0, F1) @ E1, E0)
    return a, E0 @ P0 @ np.swapaxes(E0, -1, -2) - E1 @ P1 @ np.swapaxes(E1, -1, -2)


def along_the_robot(F0, a, A):
    """Return corrections and their covariances with positions along the axes of the robot, not of the map.

    What is wrong with the robot turns with it: a camera that is turned, a range that is too long, a wheel that is too
    large. On a round trip such corrections point in all directions of the map, and sums along its axes do not show it.

    Parameters
    ----------
    F0 : Frame2 or Frame3
        The poses before.
    a, A
        As `corrections` gives them.
    """
    R = np.tile(np.eye(F0.dof), (len(a), 1, 1))
    R[:, : F0.dim, : F0.dim] = np.swapaxes(F0.R, -1, -2)  # angles are the robot's own, in space, too
    return (R @ a[..., None])[..., 0], R @ A @ np.swapaxes(R, -1, -2)


def turned_back(F0, F1):
    """T^-1 in the tangent spaces of the poses after and before a correction, shape (N, dof, dof)."""
    d = F0.dim
    T = np.tile(np.eye(F0.dof), (len(F0.x), 1, 1))
    way = (F1.t - F0.t)[..., None]
    if d == 2:
        T[:, :2, 2:] = -QUARTER @ way
    else:
        T[:, 3:, 3:] = np.swapaxes(F0.R, -1, -2) @ F1.R  # angles are seen from the robot: to the world, and back
        T[:, :3, 3:] = np.cross(way, F1.R, axis=1)  # dp = dp1 + (p1 - p0) x theta
    return T


def block_sums(t, a, A, seconds):
    """Sums of corrections over blocks of so many seconds.

    Parameters
    ----------
    t : ndarray, shape (N,)
        Times, s.
    a, A : ndarray, shape (N, n) and (N, n, n)
        Corrections, or sums of them over shorter blocks that do not reach across the border of a long one.
    seconds : float

    Returns
    -------
    t : ndarray, shape (B,)
        Beginnings of the blocks that have a correction, s.
    g, V : ndarray, shape (B, n) and (B, n, n)
    """
    number, block = np.unique(np.floor_divide(t, seconds), return_inverse=True)
    g, V = np.zeros((len(number), *a.shape[1:])), np.zeros((len(number), *A.shape[1:]))
    np.add.at(g, block, a)
    np.add.at(V, block, A)
    return number * seconds, g, V


def squared_sums(g, V):
    """Sum over blocks of g' V^-1 g, and its degrees of freedom.

    A block of few corrections has none in some directions; there it counts no degree of freedom.

    Parameters
    ----------
    g, V : ndarray, shape (B, n) and (B, n, n)

    Returns
    -------
    total : float
    dof : int
    """
    scale = np.sqrt(np.diagonal(V, axis1=-2, axis2=-1).clip(0))  # the units differ (m, rad): judge the correlations
    scale = np.where(scale > 0, scale, 1.0)
    lam, Q = np.linalg.eigh(V / (scale[:, :, None] * scale[:, None, :]))
    along = np.einsum("bij,bi->bj", Q, g / scale)
    counts = lam > FLAT
    return float((along[counts] ** 2 / lam[counts]).sum()), int(counts.sum())


def correction_ratio(parts):
    """The largest S(T) of the corrections of one robot, or of several together.

    Parameters
    ----------
    parts : list of (t, a, A)
        Of each robot: times (N,), corrections (N, n), covariances (N, n, n); or sums of them over whole seconds.

    Returns
    -------
    CorrectionRatio
    """
    by_length = {}
    for T in LENGTHS:
        sums = [squared_sums(*block_sums(part[0], part[1], part[2], T)[1:]) for part in parts]
        total, dof = (sum(column) for column in zip(*sums, strict=True)) if sums else (0.0, 0)
        if dof >= FEWEST:
            by_length[T] = total / dof, dof
    if not by_length:
        return CorrectionRatio(float("nan"), 0, float("nan"), {})
    seconds = max(by_length, key=lambda T: by_length[T][0])
    value, dof = by_length[seconds]
    limit = float(chi_square.quantile(1 - CHANCE / len(LENGTHS), dof)) / dof
    return CorrectionRatio(value, seconds, limit, by_length)


class SecondSums:
    """Corrections of a robot, summed over whole seconds as they come: little to keep of a long run.

    Parameters
    ----------
    frame : type
        Frame2 or Frame3.
    rows : list of tuple
        What `rows` gave of another one.
    along_robot : bool
        Sum along the axes of the robot, not of the map.
    """

    AT_ONCE = 256

    def __init__(self, frame, rows=(), along_robot=False):
        self._frame, self._rows, self._new, self._along_robot = frame, list(rows), [], along_robot

    def add(self, t, x0, P0, x1, P1, turned=False):
        """Take one correction: time, s; the rest as for `corrections`."""
        self._new.append((t, x0, P0, x1, P1, turned))
        if len(self._new) >= self.AT_ONCE:
            self._sum()

    def _sum(self):
        if self._new:
            t, *poses = (np.array(column) for column in zip(*self._new, strict=True))
            a, A = corrections(self._frame, *poses)
            if self._along_robot:
                a, A = along_the_robot(self._frame(poses[0]), a, A)
            if self._rows:  # its last second may go on
                last = self._rows.pop()
                t, a, A = (np.concatenate([[kept], new]) for kept, new in zip(last, (t, a, A), strict=True))
            self._rows += zip(*block_sums(t, a, A, 1), strict=True)
            self._new = []

    @property
    def rows(self):
        """Sums so far: a list of (second, g, V)."""
        self._sum()
        return self._rows

    @property
    def arrays(self):
        """Sums so far: seconds (N,), g (N, dof), V (N, dof, dof)."""
        n = self._frame.dof
        t, g, V = zip(*self.rows, strict=True) if self.rows else ((), np.zeros((0, n)), np.zeros((0, n, n)))
        return np.array(t, float), np.array(g), np.array(V)
