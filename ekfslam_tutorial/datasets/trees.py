"""Trees in the scans of a laser: clusters of beams that end at a thin thing with nothing near behind it.

The scanner of Victoria Park (SICK LMS 221) has 361 beams, half a degree apart. A trunk is a few beams of nearly the
same range, with the background much further away, or nothing at all, on both sides.
"""

from dataclasses import dataclass

import numpy as np

NOTHING = 80.0
"""Ranges from here on, m, mean that no echo came back."""


@dataclass(frozen=True)
class TreeDetector:
    """Detector of trees: what is taken for one.

    Parameters
    ----------
    nearest, farthest : float
        Ranges of a trunk, m.
    joined : float
        Neighbouring beams end at the same thing if their ranges differ by less than this, m.
    separation : float
        The beams beside a trunk end so much further away at least, m. What stands nearer hides an edge.
    thinnest, thickest : float
        Diameters, m.
    depth : float
        No beam of a trunk ends further behind the nearest one than half its diameter and this, m: a wall does.
    beams : int
        Fewest beams on a trunk.
    spot : float
        So much wider, rad, does a thing look because a beam is not a line.
    """

    nearest: float = 1.5
    farthest: float = 60.0
    joined: float = 0.5
    separation: float = 1.5
    thinnest: float = 0.02
    thickest: float = 1.5
    depth: float = 0.3
    beams: int = 2
    spot: float = 0.0

    def __call__(self, ranges, angles):
        """Find the trees in scans, each scan for itself.

        Parameters
        ----------
        ranges : ndarray, shape (K, n)
            m; from `NOTHING` on, or not finite: no echo.
        angles : ndarray, shape (n,)
            Of the beams, counter-clockwise from straight ahead, evenly spaced and rising, rad.

        Returns
        -------
        offsets : ndarray of int, shape (K + 1,)
            Scan k has the trees offsets[k] to offsets[k + 1].
        trees : ndarray, shape (M, 3)
            Range of the trunk's middle, m, its bearing, rad, its diameter, m. A circle of radius d/2 that is seen at a
            half-width w from a distance r to its bark obeys sin(w) = (d/2) / (r + d/2).
        """
        ranges, angles = np.asarray(ranges, float), np.asarray(angles, float)
        if ranges.ndim != 2 or ranges.shape[1:] != angles.shape or len(angles) < 3:
            raise ValueError(f"scans need shape (K, n) and angles (n,), n >= 3, got {ranges.shape} and {angles.shape}")
        K, n = ranges.shape
        if not K:
            return np.zeros(1, int), np.zeros((0, 3))
        echo = np.isfinite(ranges) & (ranges < NOTHING)
        r = np.where(echo, ranges, np.inf).ravel()

        # things: runs of neighbouring beams with nearly the same range
        with np.errstate(invalid="ignore"):
            apart = ~(np.abs(np.diff(r, prepend=np.inf)) < self.joined)
        apart[::n] = True
        first = np.flatnonzero(apart)
        last = np.append(first[1:], len(r)) - 1
        count = last - first + 1
        column, scan = first % n, first // n
        low, high = np.minimum.reduceat(r, first), np.maximum.reduceat(r, first)

        # a trunk: far enough in front of what is on both sides, neither too thin nor too thick nor too deep
        inside = (column > 0) & (column + count < n) & np.isfinite(low)
        before, after = r[first - 1], r[np.minimum(last + 1, len(r) - 1)]
        free = (before > r[first] + self.separation) & (after > r[last] + self.separation)
        bark = (r[(first + last) // 2] + r[(first + last + 1) // 2]) / 2
        sine = np.sin(np.maximum(count * (angles[1] - angles[0]) - self.spot, 1e-6) / 2).clip(0, 0.9)
        diameter = np.where(inside, 2 * bark * sine / (1 - sine), np.inf)
        is_tree = inside & free & (count >= self.beams) & (low > self.nearest) & (high < self.farthest)
        is_tree &= (diameter > self.thinnest) & (diameter < self.thickest)
        k = np.flatnonzero(is_tree)
        k = k[high[k] - low[k] < diameter[k] / 2 + self.depth]

        bearing = (angles[column[k]] + angles[column[k] + count[k] - 1]) / 2
        trees = np.column_stack([bark[k] + diameter[k] / 2, bearing, diameter[k]])
        return np.searchsorted(scan[k], np.arange(K + 1)), trees


def agreement(ours, theirs, near=1.0):
    """Return how far two lists of trees agree: pairs that are each other's nearest, scan by scan.

    Parameters
    ----------
    ours, theirs : (offsets, trees)
        As `TreeDetector` returns them, of the same scans.
    near : float
        Pairs further apart than this, m, do not count.

    Returns
    -------
    dict
        found: share of theirs that is in ours; confirmed: share of ours that is in theirs; range_m, bearing_deg,
        diameter_m: median of ours minus theirs over the pairs; spread_range_m, spread_bearing_deg: 1.48 times the
        median of their absolute deviations.
    """
    pairs = []
    for k in range(len(ours[0]) - 1):
        a, b = (trees[offsets[k] : offsets[k + 1]] for offsets, trees in (ours, theirs))
        if not len(a) or not len(b):
            continue
        p, q = (t[:, :1] * np.column_stack([np.cos(t[:, 1]), np.sin(t[:, 1])]) for t in (a, b))
        D = np.linalg.norm(p[:, None] - q[None], axis=2)
        i = np.flatnonzero((D.argmin(0)[D.argmin(1)] == np.arange(len(a))) & (D.min(1) < near))
        pairs.append(a[i] - b[D.argmin(1)[i]])
    d = np.concatenate([np.zeros((0, 3)), *pairs])
    middle = np.median(d, axis=0) if len(d) else np.full(3, np.nan)
    spread = 1.48 * np.median(np.abs(d - middle), axis=0) if len(d) else np.full(3, np.nan)
    return {
        "found": len(d) / max(len(theirs[1]), 1),
        "confirmed": len(d) / max(len(ours[1]), 1),
        "range_m": float(middle[0]),
        "bearing_deg": float(np.degrees(middle[1])),
        "diameter_m": float(middle[2]),
        "spread_range_m": float(spread[0]),
        "spread_bearing_deg": float(np.degrees(spread[1])),
    }
