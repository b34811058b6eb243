"""The stochastic map: one mean, one covariance, and which part of them belongs to a state."""

import numpy as np

from .covariances import check_covariance, real
from .html import map_html


class MapFull(RuntimeError):
    """A state does not fit into what is left of the map's capacity."""


class Map:
    """Mean x and covariance P of everything that is estimated: robots, landmarks, sensors.

    A state in the map is a *range*, a contiguous slice. States come with `add` and go with `remove`; what has been
    removed is a zero row and column, harmless in every formula, until a new state takes its place.

    Parameters
    ----------
    capacity : int, optional
        Most numbers that may be in use at a time. Without it the map grows as needed.

    Attributes
    ----------
    x : ndarray, shape (n,)
        Mean.
    P : ndarray, shape (n, n)
        Covariance.
    ranges : list of slice
        The states in use, in the order of the map.
    robs : list
        Who has been put into it as a robot, by `slam.place`. The map itself does nothing with it.
    """

    def __init__(self, capacity=None):
        if capacity is not None and (not isinstance(capacity, (int, np.integer)) or capacity < 1):
            raise ValueError(f"the capacity of a map must be a positive number of states, got {capacity!r}")
        self.capacity, self.x, self.P, self.ranges, self.robs = capacity, np.zeros(0), np.zeros((0, 0)), [], []

    def __repr__(self):
        room = "" if self.capacity is None else f" of {self.capacity}"
        return f"Map({self.n_used}{room} states in use)"

    def _repr_html_(self):
        return map_html(self)

    @property
    def n(self):
        """Extent: one past the last used entry there ever was."""
        return len(self.x)

    @property
    def n_used(self):
        """Count of the numbers that are in use."""
        return sum(r.stop - r.start for r in self.ranges)

    @property
    def used(self):
        """Mask of the numbers that are in use, shape (n,), bool."""
        used = np.zeros(self.n, bool)
        for r in self.ranges:
            used[r] = True
        return used

    def state(self, r):
        """Mean of the state in range r: a copy, shape (k,)."""
        return self.x[r].copy()

    def block(self, r):
        """Covariance of the state in range r: a copy, shape (k, k)."""
        return self.P[r, r].copy()

    def add(self, x, P_xx, P_xm=None):
        """Put a state into the map.

        Parameters
        ----------
        x : array_like, shape (k,)
            Mean.
        P_xx : array_like, shape (k, k)
            Covariance.
        P_xm : array_like, shape (k, n), optional
            Cross-covariance with the map as it is; independent of it if not given.

        Returns
        -------
        slice
            The range of the new state: the first gap that is long enough, or the end of the map.

        Raises
        ------
        MapFull
            If the state does not fit. Nothing has been changed then.
        ValueError
            For shapes that do not fit each other, numbers that are not finite, or a P_xx that is no covariance.
        """
        x, P_xx = real("the mean of a new state", x), real("P_xx", P_xx)
        if x.ndim != 1:
            raise ValueError(f"the mean of a new state must be a vector, got shape {x.shape}")
        check_covariance(P_xx, len(x), "P_xx")
        if not np.isfinite(x).all():
            raise ValueError(f"the mean of a new state must be finite, got {x}")
        P_xm = np.zeros((len(x), self.n)) if P_xm is None else real("P_xm", P_xm)
        if P_xm.shape != (len(x), self.n) or not np.isfinite(P_xm).all():
            raise ValueError(f"P_xm must be finite and have shape {(len(x), self.n)}, got shape {P_xm.shape}")

        m, r = self.n, self._room(len(x))
        self.x[r] = x
        self.P[r, :m], self.P[:m, r] = P_xm, P_xm.T
        self.P[r, r] = symmetric(P_xx)
        return r

    def put(self, r, x, P_rm, P_rr):
        """Replace the state in range r, or a part of it; if by fewer numbers, the rest of r is free again.

        Parameters
        ----------
        r : slice
        x : ndarray, shape (k,)
        P_rm : ndarray, shape (k, n)
            Covariance of the new state with the whole map; the part at r itself is not used.
        P_rr : ndarray, shape (k, k)

        Returns
        -------
        slice
            The range of the new state: the head of r.
        """
        head, tail = slice(r.start, r.start + len(x)), slice(r.start + len(x), r.stop)
        if tail.start < tail.stop and r not in self.ranges:
            raise ValueError(f"only a whole state can become shorter, and range {r.start}:{r.stop} is none")
        self.x[head], self.P[head], self.P[:, head] = x, P_rm, P_rm.T
        self.P[head, head] = symmetric(P_rr)
        if tail.start < tail.stop:
            self.ranges[self.ranges.index(r)] = head
            self._clear(tail)
        return head

    def remove(self, r):
        """Take the state of range r out of the map: its part of x and P becomes zero.

        Raises
        ------
        ValueError
            If r is not the range of a state.
        """
        if not isinstance(r, slice) or None in (r.start, r.stop) or r.step is not None:
            raise ValueError(f"remove takes the range that add has returned, got {r!r}")
        if r not in self.ranges:
            if not (0 <= r.start < r.stop <= self.n and self.used[r].all()):
                raise ValueError(f"range {r.start}:{r.stop} is not in use in this map of {self.n} states")
            near = ", ".join(f"{s.start}:{s.stop}" for s in self.ranges if s.start < r.stop and r.start < s.stop)
            raise ValueError(f"range {r.start}:{r.stop} is not that of a state; there is {near}")
        self.ranges.remove(r)
        self._clear(r)

    def _clear(self, r):
        self.x[r], self.P[r], self.P[:, r] = 0, 0, 0

    def _room(self, k):
        """Range for a new state of k numbers: the first gap that is long enough, or the end of the map."""
        if self.capacity is not None and self.n_used + k > self.capacity:
            raise MapFull(
                f"the map is full: {self.n_used} of {self.capacity} states are in use, a new state needs {k} more"
            )
        start = 0
        for r in self.ranges:
            if r.start - start >= k:
                break
            start = r.stop
        r, more = slice(start, start + k), max(0, start + k - self.n)
        self.x, self.P = np.pad(self.x, (0, more)), np.pad(self.P, (0, more))
        self.ranges = sorted([*self.ranges, r], key=lambda r: r.start)
        return r


def symmetric(P):
    """Return a covariance without the rounding errors that make A P A' differ from its transpose."""
    return (P + P.T) / 2
