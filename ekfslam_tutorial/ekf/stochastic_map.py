"""The stochastic map: one mean, one covariance, and who owns which part of them."""

from itertools import pairwise

import numpy as np

from .blas import Downdate
from .extra import check_compiled, compiled
from .html import map_html
from .triangle import below, mirror, whole_range, whole_rows

GROWTH = 2**0.5  # of the number of states: the storage of P doubles, so a map of n states is copied O(log n) times
TINY = 1e-8  # of the largest number of a covariance: asymmetry, and eigenvalues below zero, that rounding explains
LINE = 8  # numbers in a line of the cache
WIDTH = 4 * LINE  # numbers of a row that compiled code takes at a time
ONE_TRIANGLE = 400  # states: from here on half the work is worth more than a covariance that is complete at once
ONE_TRIANGLE_COMPILED = 40  # the same where rows of half a matrix are read by compiled code


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
    compiled : bool
        Let the steps of `slam` on this map be compiled: the same results to rounding, in a fraction of the time where
        the map is small. Needs numba (the extra `compiled`); the first run on a machine takes some seconds to compile.

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
    n_used : int
        Number of states in use.
    """

    def __init__(self, capacity=None, *, compiled=False):
        if capacity is not None and (not isinstance(capacity, (int, np.integer)) or capacity < 1):
            raise ValueError(f"the capacity of a map must be a positive number of states, got {capacity!r}")
        if compiled:
            check_compiled(ImportError)
        self.capacity, self.compiled = capacity, compiled
        self.n = self.n_used = 0
        self._lower = False  # only the lower triangle of P is up to date
        self._starts = set()  # where the states in use begin
        size = roomy(1)  # not zero: that array would be row-major as well, and compiled code asks for one order
        self._store(np.zeros(size), square(size), np.zeros(size, bool))

    def __repr__(self):
        room = "" if self.capacity is None else f" of {self.capacity}"
        return f"Map({self.n_used}{room} states in use)"

    def _repr_html_(self):
        return map_html(self)

    def _store(self, x, P, used):
        """Take this storage: vectors of the capacity, and a column-major matrix."""
        self._x, self._P, self._used = x, P, used
        self._downdate = Downdate(P)
        self._look()

    def _look(self):
        """Views of the part of the storage that is in use: made once, not at every access."""
        n = self.n
        self._xn, self._Pn = self._x[:n], self._P[:n, :n]

    def __getstate__(self):
        """For copies: addresses and views stay here."""
        return {k: v for k, v in vars(self).items() if k not in ("_xn", "_Pn", "_downdate")}

    def __setstate__(self, state):
        self.__dict__.update(state)
        P = square(len(self._x))
        P[:] = self._P
        self._store(self._x, P, self._used)

    @property
    def x(self):
        """Mean of all states, shape (n,). A view: writing into it changes the map."""
        return self._xn

    @property
    def P(self):
        """Covariance of all states, shape (n, n). A view, too, good until the next operation on the map."""
        if self._lower:
            if self.compiled:
                compiled().mirror(self)
            else:
                mirror(self._Pn)
            self._lower = False
        return self._Pn

    @property
    def used(self):
        """Which states are in use, shape (n,), bool."""
        return self._used[: self.n]

    @property
    def ranges(self):
        """Ranges of the states in use, in the order of the map: a list of slices."""
        starts = sorted(self._starts)
        return [slice(a, a + int(self._used[a:b].sum())) for a, b in pairwise([*starts, self.n])]

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

        P_xm = np.zeros((len(x), self.n)) if P_xm is None else np.asarray(P_xm, float)
        return self.insert(x, symmetric(P_xx), P_xm)

    @property
    def storage(self):
        """For compiled code: storage of x and P, how much of it counts, and whether of P only the lower triangle."""
        return self._x, self._P, self.n, self._lower

    def at_hand(self, r, s=None, rows=None, some=None):
        """Where these states stand in `storage`: at their ranges; of the rows, (K, k), at least some."""
        return r, s, rows

    # --- what the operations of the filter are made of ---------------------------------------------------------------

    def state(self, r):
        """Mean of the state in range r: a copy, shape (k,); of K states given by their rows (K, k), shape (K, k)."""
        return self._xn[r].copy() if isinstance(r, slice) else self._xn.take(r)

    def block(self, r):
        """Covariance of the state in range r: a copy, shape (k, k); of K states by their rows (K, k), (K, k, k)."""
        if not isinstance(r, slice):
            i, j = r[:, :, None], r[:, None, :]
            return self._Pn[np.maximum(i, j), np.minimum(i, j)] if self._lower else self._Pn[i, j]
        B = self._Pn[r, r].copy()
        if self._lower:
            i, j = below(len(B))
            B[j, i] = B[i, j]
        return B

    def variances(self, r):
        """Variances of the states in range r, or of K states given by their rows (K, k): a copy of that shape."""
        return self._Pn.diagonal()[r].copy()

    def between(self, i, j):
        """Covariance between some states and others, given by their indices: a copy, shape (len(i), len(j))."""
        return compiled().between(self, i, j) if self.compiled else self.P[np.ix_(i, j)]

    def rows(self, r):
        """Covariance of the state in range r with the whole map, P[r, :]. Not to be written to.

        Parameters
        ----------
        r : slice or ndarray of int, shape (K, k)
            A range, or the states of K ranges.

        Returns
        -------
        ndarray, shape (k, n) or (K, k, n)
        """
        if not self._lower:
            return self._Pn.T[r]
        if self.compiled:
            i = range(r.start, r.stop) if isinstance(r, slice) else r.ravel()
            if (rows := compiled().rows(self, i)) is not None:
                return rows if isinstance(r, slice) else rows.reshape(*r.shape, self.n)
        if isinstance(r, slice):
            return whole_range(self._Pn, r)
        return whole_rows(self._Pn, r.ravel().tolist()).reshape(*r.shape, self.n)

    def here(self, r):
        """Where the state in range r stands in what `rows` returns: at r."""
        return r

    def fetch(self, blocks):
        """Each block's Jacobian, with the covariance of its state with the whole map: those of known states drop out.

        Returns
        -------
        list of (ndarray of shape (m, k), ndarray of shape (k, n))
        """
        return [(J, self.rows(r)) for r, J in blocks if r is not None] or [nothing(blocks, self.n)]

    def columns(self, HP, blocks):
        """P H' from H P."""
        return HP.T

    def put(self, r, x, P_xm, P_xx):
        """Replace the state in range r.

        Parameters
        ----------
        r : slice
        x : ndarray, shape (k,)
        P_xm : ndarray, shape (k, n)
            Its covariance with the whole map; the part at r itself is not used.
        P_xx : ndarray, shape (k, k)
        """
        self._xn[r] = x
        self._Pn.T[r] = P_xm
        if self._lower:  # nobody reads what is right of the diagonal
            self._Pn[r, : r.stop] = P_xm[:, : r.stop]
        else:
            self._Pn[r] = P_xm
        self._Pn[r, r] = symmetric(P_xx)

    def overwrite(self, indices, P_im):
        """Set rows of the covariance, given by their sorted indices, and with them the columns."""
        if self.compiled:
            compiled().overwrite(self, indices, P_im)
        else:
            self._Pn.T[indices] = P_im
            self._Pn[indices] = P_im

    def move(self, r, x):
        """Set the mean of the state in range r, and leave its covariance as it is."""
        self._xn[r] = x

    def shift(self, dx):
        """x = x + dx."""
        self._xn += dx

    def subtract(self, Wt):
        """P = P - W W', given W' of shape (m, n); if it has fewer columns, of the first states only."""
        if not self.compiled or not compiled().subtract(self, Wt):
            self._downdate(Wt, self.keep_one_triangle())

    def keep_one_triangle(self):
        """If the map is large, change only the lower triangle from now on, until `P` is asked for. Whether it is so."""
        n = self.n
        self._lower = self._lower or n >= ONE_TRIANGLE or (self.compiled and n >= ONE_TRIANGLE_COMPILED)
        return self._lower

    def relieve(self):
        """After a correction: nothing is left to do."""

    def insert(self, x, P_xx, P_xm):
        """A new state, as `add` puts it in, unchecked; P_xx is symmetric. Returns its range."""
        n, r = self.n, self.occupy(self.free(len(x)), x)
        self._Pn[r, :n] = P_xm
        self._Pn.T[r, :n] = P_xm
        self._Pn[r, r] = P_xx
        return r

    def free(self, k):
        """Where a new state of k entries can be put: the first gap that is long enough, or the end of the map.

        Raises
        ------
        MapFull
            If it does not fit.
        """
        if self.capacity is not None and self.n_used + k > self.capacity:
            raise MapFull(
                f"the map is full: {self.n_used} of {self.capacity} states are in use, a new state needs {k} more"
            )
        start = self.n if self.n_used == self.n else self._first_gap(k)
        if start + k > len(self._x):
            self._grow(start + k)
        return slice(start, start + k)

    def occupy(self, r, x):
        """A new state in a range that is `free`; its covariance is there, or will be written. Returns its range."""
        if r.stop > self.n:
            self.n = r.stop
            self._look()
        self._x[r], self._used[r] = x, True
        self._starts.add(r.start)
        self.n_used += r.stop - r.start
        return r

    def remove(self, r):
        """Take the state of range r out of the map: its part of x and P becomes zero.

        Raises
        ------
        ValueError
            If r is not the range of a state.
        """
        self.check_range(r)
        self.vacate(r)

    def check_range(self, r):
        """Refuse what is not the range of a state."""
        if not isinstance(r, slice) or None in (r.start, r.stop) or r.step is not None:
            raise ValueError(f"remove takes the range that add has returned, got {r!r}")
        if not (0 <= r.start < r.stop <= self.n and self.used[r].all()):
            raise ValueError(f"range {r.start}:{r.stop} is not in use in this map of {self.n} states")
        ends = r.stop in self._starts or not self.used[r.stop : r.stop + 1].any()
        if not ends or self._starts.intersection(range(r.start, r.stop)) != {r.start}:
            near = ", ".join(f"{s.start}:{s.stop}" for s in self.ranges if s.start < r.stop and r.start < s.stop)
            raise ValueError(f"range {r.start}:{r.stop} is not that of a state; there is {near}")

    def vacate(self, r):
        """Free the entries of range r, a state or a part of one, unchecked: their part of x and P becomes zero."""
        self._x[r], self._P[r, :], self._P[:, r], self._used[r] = 0, 0, 0, False
        self._starts -= set(range(r.start, r.stop))
        self.n_used -= r.stop - r.start

    def clear(self):
        """Take all states out of the map; its storage stays."""
        n, self.n, self.n_used, self._lower = self.n, 0, 0, False
        self._x[:n], self._P[:n, :n], self._used[:n] = 0, 0, False
        self._starts.clear()
        self._look()

    def _first_gap(self, k):
        """Where k free entries stand together for the first time; one past the last entry in use, if nowhere."""
        taken = np.flatnonzero(np.concatenate([[True], self.used, [True]])) - 1
        fits = np.flatnonzero(np.diff(taken) - 1 >= k)
        return int(taken[fits[0]]) + 1 if fits.size else int(taken[-2]) + 1

    def _grow(self, n):
        """Larger storage, for n entries and more."""
        size, m = roomy(int(GROWTH * n)), self.n
        x, P, used = np.zeros(size), square(size), np.zeros(size, bool)
        x[:m], P[:m, :m], used[:m] = self._xn, self._Pn, self.used
        self._store(x, P, used)


def roomy(n):
    """A size of storage that holds n states, by which columns of P do not evict each other from the cache.

    They do if they are a power of two apart, or nearly so: a correction at n = 1003 takes 206 us in a storage of 1024,
    and 97 in one of 1048. So a column has 3 lines of the cache more than a multiple of 8 lines.
    """
    lines = -(-n // LINE)
    return LINE * (lines + (3 - lines) % 8)


def whole(n):
    """A number of columns for n numbers, by which a row of a matrix is whole pieces of WIDTH."""
    return -(-n // WIDTH) * WIDTH


def zeros(m, n):
    """Zeros of shape (m, n); the first row begins with a line of the cache, and so do all if n is a number of lines.

    Numbers that stand across two lines take two reads: with W' so, P -= W W' of 203 states takes 20 us, not 16. Let it
    be an odd number of lines, then rows do not evict each other: see `roomy`.
    """
    numbers = np.zeros(m * n + LINE)
    begin = -(numbers.ctypes.data // numbers.itemsize) % LINE
    return numbers[begin : begin + m * n].reshape(m, n)


def square(n):
    """Zeros of shape (n, n), column-major, as `zeros`."""
    return zeros(n, n).T


def nothing(blocks, n):
    """Jacobian and rows that stand for blocks of known states only: their product is zero."""
    return np.zeros((blocks[0][1][..., 0].size, 0)), np.zeros((0, n))


def symmetric(P):
    """A covariance without the rounding errors that make A P A' differ from its transpose."""
    S = P + P.T
    S *= 0.5
    return S


def are_covariances(P):
    """Whether all matrices of a stack, shape (K, n, n), are what `check_covariance` accepts."""
    tiny = TINY * np.abs(P).max((-1, -2), initial=0.0)
    if not np.isfinite(P).all() or (np.abs(P - np.swapaxes(P, -1, -2)).max((-1, -2), initial=0.0) > tiny).any():
        return False
    return bool((np.linalg.eigvalsh(P)[..., 0] >= -tiny).all())


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
    if np.abs(P - P.T).max(initial=0.0) > TINY * scale:
        raise ValueError(f"{name} must be symmetric, got {P.tolist()}")
    if n and np.linalg.eigvalsh(P)[0] < -TINY * scale:
        raise ValueError(
            f"{name} must be positive semi-definite, its smallest eigenvalue is {np.linalg.eigvalsh(P)[0]:.3g}"
        )
