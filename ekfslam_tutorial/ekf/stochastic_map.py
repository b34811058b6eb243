"""The stochastic map: one mean, one covariance, and who owns which part of them."""

import numpy as np

GROWTH = 1.5  # new storage is larger by this factor, so that a map of n states is copied O(log n) times


class MapFull(RuntimeError):
    """A state does not fit into what is left of the map's capacity."""


class Map:
    """Mean x and covariance P of everything that is estimated: robots, landmarks, sensors.

    A state in the map is a *range*, a contiguous slice. States come with `add` and go with `remove`; what has been
    removed is a zero row and column, harmless in every formula, until a new state takes its place.

    Parameters
    ----------
    capacity : int, optional
        Most states that may be in use at a time. Without it the map grows as needed.

    Attributes
    ----------
    x : ndarray, shape (n,)
        Mean. A view: write into it, `map.x[r] = ...`.
    P : ndarray, shape (n, n)
        Covariance. A view. Always the true, symmetric covariance.
    used : ndarray of bool, shape (n,)
        Which entries belong to a state.
    n : int
        Extent: one past the last used entry there ever was.
    """

    def __init__(self, capacity=None):
        if capacity is not None and (not isinstance(capacity, (int, np.integer)) or capacity < 1):
            raise ValueError(f"the capacity of a map must be a positive number of states, got {capacity!r}")
        self.capacity = capacity
        self.n = 0
        self._x = np.zeros(0)
        self._P = np.zeros((0, 0), order="F")
        self._used = np.zeros(0, bool)

    def __repr__(self):
        room = "" if self.capacity is None else f" of {self.capacity}"
        return f"Map({self.n_used}{room} states in use)"

    @property
    def x(self):
        """Mean of all states, shape (n,). A view: writing into it changes the map."""
        return self._x[: self.n]

    @property
    def P(self):
        """Covariance of all states, shape (n, n). A view, too."""
        return self._P[: self.n, : self.n]

    @property
    def used(self):
        """Which states are in use, shape (n,), bool."""
        return self._used[: self.n]

    @property
    def n_used(self):
        """Number of states in use."""
        return int(np.count_nonzero(self.used))

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
            The range of the new state.

        Raises
        ------
        MapFull
            If the state does not fit. Nothing has been changed then.
        ValueError
            For shapes that do not fit each other, numbers that are not finite, or a P_xx that is no covariance.
        """
        x, P_xx = np.asarray(x, float), np.asarray(P_xx, float)
        if x.ndim != 1:
            raise ValueError(f"the mean of a new state must be a vector, got shape {x.shape}")
        check_covariance(P_xx, len(x), "P_xx")
        if not np.isfinite(x).all():
            raise ValueError(f"the mean of a new state must be finite, got {x}")
        if P_xm is not None and (np.shape(P_xm) != (len(x), self.n) or not np.isfinite(P_xm).all()):
            raise ValueError(f"P_xm must be finite and have shape {(len(x), self.n)}, got shape {np.shape(P_xm)}")

        r = self._make_room(len(x))
        if P_xm is not None:
            n = np.shape(P_xm)[1]
            self._P[r, :n] = P_xm
            self._P[:n, r] = np.transpose(P_xm)
        self._x[r], self._P[r, r], self._used[r] = x, 0.5 * (P_xx + P_xx.T), True
        return r

    def remove(self, r):
        """Take the state of range r out of the map: its part of x and P becomes zero.

        Raises
        ------
        ValueError
            If r is not a range in use.
        """
        if not isinstance(r, slice) or None in (r.start, r.stop):
            raise ValueError(f"remove takes the range that add has returned, got {r!r}")
        if not (0 <= r.start < r.stop <= self.n and self.used[r].all()):
            raise ValueError(f"range {r.start}:{r.stop} is not in use in this map of {self.n} states")
        self._x[r], self._P[r, :], self._P[:, r], self._used[r] = 0, 0, 0, False

    def _make_room(self, k):
        """A free range of k entries: the first gap that is long enough, or the end of the map."""
        if self.capacity is not None and self.n_used + k > self.capacity:
            raise MapFull(
                f"the map is full: {self.n_used} of {self.capacity} states are in use, a new state needs {k} more"
            )
        taken = np.flatnonzero(np.concatenate([[True], self.used, [True]])) - 1
        gaps = np.diff(taken) - 1
        fits = np.flatnonzero(gaps >= k)
        start = int(taken[fits[0]]) + 1 if fits.size else self._end()
        if start + k > self.n:
            self._extend(start + k)
        return slice(start, start + k)

    def _end(self):
        """One past the last entry in use."""
        used = np.flatnonzero(self.used)
        return int(used[-1]) + 1 if used.size else 0

    def _extend(self, n):
        """Let the map reach up to n entries."""
        if n > len(self._x):
            size = int(GROWTH * n) + 8
            x, P, used = np.zeros(size), np.zeros((size, size), order="F"), np.zeros(size, bool)
            x[: self.n], P[: self.n, : self.n], used[: self.n] = self.x, self.P, self.used
            self._x, self._P, self._used = x, P, used
        self.n = n


def check_covariance(P, n, name="P"):
    """Refuse what is not a covariance of n numbers: symmetric, positive semi-definite, finite.

    Raises
    ------
    ValueError
        Saying what was got.
    """
    P = np.asarray(P, float)
    if P.shape != (n, n):
        raise ValueError(f"{name} must have shape {(n, n)}, got {P.shape}")
    if not np.isfinite(P).all():
        raise ValueError(f"{name} must be finite, got {P.tolist()}")
    scale = np.abs(P).max(initial=0.0)
    if np.abs(P - P.T).max(initial=0.0) > 1e-8 * scale:
        raise ValueError(f"{name} must be symmetric, got {P.tolist()}")
    if n and np.linalg.eigvalsh(P)[0] < -1e-8 * scale:
        raise ValueError(
            f"{name} must be positive semi-definite, its smallest eigenvalue is {np.linalg.eigvalsh(P)[0]:.3g}"
        )
