"""What a sensor should see of many landmarks in one frame, and what it has measured: arrays, an `Obs` is one row."""

import numpy as np

from ..geometry.lazy import lazy
from .objects import Obs


class Sightings:
    """Expected observations of K landmarks by one sensor, and what becomes of them.

    Parameters
    ----------
    sen : int
        Id of the sensor.
    lmks : list of Lmk
    e, v : ndarray, shape (K, m) and (K, d)
        Expectations; points in the sensor frame, or rays.
    visible : ndarray of bool, shape (K,)
    ranges : tuple (slice or None, slice or None, ndarray of int of shape (K, k) or None)
        Where the robot's frame, the sensor's frame and each landmark are in the map; None for what is known.
    E_r, E_s, E_l : ndarray, shape (K, m, ·)
        Jacobians of e.

    Attributes
    ----------
    y, R, z, index, measured, matched, updated : sequences of length K
        The columns of `Obs` of these names.
    """

    def __init__(self, sen, lmks, e, v, visible, ranges, E_r, E_s, E_l):
        self.sen, self.lmks, self.e, self.v, self.visible = sen, lmks, e, v, visible
        self.ranges, self.E_r, self.E_s, self.E_l = ranges, E_r, E_s, E_l
        self.H_l = E_l  # that of the blocks, where it is another one
        self.r = [lmk.r for lmk in lmks]
        nothing, no = [None] * len(lmks), [False] * len(lmks)
        self.y, self.R, self.z, self.index = nothing, nothing.copy(), nothing.copy(), nothing.copy()
        self.measured, self.matched, self.updated = no, no.copy(), no.copy()

    def rows(self):
        """All of them as a list of Obs."""
        return [Obs(self, k) for k in range(len(self.lmks))]

    def blocks(self, some=None):
        """The stack of blocks (range, Jacobian) of all of them, or of some, given by their indices."""
        (r, s, rows), J = self.ranges, (self.E_r, self.E_s, self.H_l)
        if some is not None:
            rows, J = None if rows is None else rows.take(some, 0), [each.take(some, 0) for each in J]
        return (r, J[0]), (s, J[1]), (rows, J[2])

    def take(self, some):
        """The same of some of the landmarks, given by their indices."""
        (r, E_r), (s, E_s), (rows, E_l) = self.blocks(some)
        e, v, visible = self.e.take(some, 0), self.v.take(some, 0), self.visible.take(some)
        return Sightings(self.sen, [self.lmks[k] for k in some], e, v, visible, (r, s, rows), E_r, E_s, E_l)

    def keep(self, map):
        """Note the covariance of the states that each expectation depends on: E follows from it when asked for."""
        blocks = [(r, J) for r, J in self.blocks() if r is not None]
        K = len(self.lmks)
        every = [r if isinstance(r, np.ndarray) else np.broadcast_to(np.arange(r.start, r.stop), (K, r.stop - r.start))
                 for r, _ in blocks]  # fmt: skip
        self._H = [J for _, J in blocks]
        self._P = map.block(np.concatenate(every, -1)) if every else None

    @lazy
    def E(self):
        """Covariance of each expectation as it was when `keep` was called, H P H', shape (K, m, m)."""
        if self._P is None:
            return np.zeros((*self.e.shape, self.e.shape[-1]))
        H = np.concatenate(self._H, -1)
        return H @ self._P @ np.swapaxes(H, -1, -2)

    def match(self, pairs, wanted=None):
        """Note the measurement of each landmark, from the pairs (landmark id, index) of an association.

        Parameters
        ----------
        pairs : dict of int to int
        wanted : set of int, optional
            Ids of the landmarks that are looked for; all, if not given.
        """
        self.measured = [wanted is None or lmk.id in wanted for lmk in self.lmks]
        self.index = [pairs.get(lmk.id) if m else None for lmk, m in zip(self.lmks, self.measured, strict=True)]
        self.matched = [i is not None for i in self.index]


def merged(parts):
    """Landmarks of several types in one table: Jacobians of the smaller ones get columns of zeros.

    Parameters
    ----------
    parts : list of Sightings
        At least one, all of the same sensor.
    """
    if len(parts) == 1:
        return parts[0]
    size = max(part.E_l.shape[-1] for part in parts)
    every = lambda name: [getattr(part, name) for part in parts]
    pad = lambda A: np.pad(A, [(0, 0)] * (A.ndim - 1) + [(0, size - A.shape[-1])])
    together = lambda name: np.concatenate(every(name))
    rows = [part.ranges[2] for part in parts]
    known = [each is None for each in rows]
    at = np.concatenate([np.zeros((len(p.e), size), int) if p.ranges[2] is None else pad(p.ranges[2]) for p in parts])
    E_l = [pad(each) for each in every("E_l")]
    lmks, ranges = sum(every("lmks"), []), (*parts[0].ranges[:2], None if all(known) else at)
    e, v, visible, E_r, E_s = (together(name) for name in ("e", "v", "visible", "E_r", "E_s"))
    whole = Sightings(parts[0].sen, lmks, e, v, visible, ranges, E_r, E_s, np.concatenate(E_l))
    whole.H_l = np.concatenate([J * (not k) for J, k in zip(E_l, known, strict=True)])
    return whole
