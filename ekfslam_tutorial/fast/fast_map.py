"""A stochastic map whose covariance is half kept, half at need: the public interface is that of `ekf.Map`.

What a map of the wing has beyond that interface, its second section, is what `filter.py` and the steps are made of.
"""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from .blas import Downdate
from .core import MapFull, check_covariance, map_html, real
from .extra import check_compiled, compiled
from .lazy import lazy
from .notes import Notes
from .storage import nothing, roomy, square, symmetric
from .triangle import below, mirror, whole_range, whole_rows

GROWTH = 2  # of the number of states, when the storage is full: so a map of n states is copied O(log n) times
SPARING, LARGE = 2**0.5, 1400  # the same, and from which number on: the storage of P doubles there
NOTHING, NO_NUMBERS = np.zeros(0), np.zeros(0, np.int64)
NO_LEDGER = np.zeros(0, bool), NO_NUMBERS, NOTHING, NO_NUMBERS, NO_NUMBERS, NOTHING, NO_NUMBERS
ONE_TRIANGLE = 400  # states: from here on half the work is worth more than a covariance that is complete at once
ONE_TRIANGLE_COMPILED = 40  # the same where rows of half a matrix are read by compiled code
FEW = 4  # times as many states as are carried: then rows and columns of these are less work than the whole map


class FastMap:
    """Mean x and covariance P of everything that is estimated, as `ekf.Map` has them: `x` and `P` may be written to.

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

    all_active: ClassVar[bool] = True  # `CompressedMap` keeps the covariance of some states only up to date

    def __init__(self, capacity=None, *, compiled=False):
        if capacity is not None and (not isinstance(capacity, (int, np.integer)) or capacity < 1):
            raise ValueError(f"the capacity of a map must be a positive number of states, got {capacity!r}")
        if compiled:
            check_compiled(ImportError)
        self.capacity, self.compiled = capacity, compiled
        self.n = self.n_used = 0
        self.robs = []  # as in `ekf.Map`
        self._lower = False  # only the lower triangle of P is up to date
        self._starts = set()  # where the states in use begin
        size = roomy(1)  # not zero: that array would be row-major as well, and compiled code asks for one order
        self._store(np.zeros(size), square(size), np.zeros(size, bool))
        self.notes = Notes()

    def __repr__(self):
        room = "" if self.capacity is None else f" of {self.capacity}"
        return f"FastMap({self.n_used}{room} states in use)"

    def _repr_html_(self):
        return map_html(self)

    def _store(self, x, P, used):
        """Take this storage: vectors of the capacity, and a column-major matrix."""
        self._x, self._P, self._used = x, P, used
        self._downdate = Downdate(P)
        self._look()

    def _look(self):
        """Views of the part of the storage that is in use: made once, not at every access; that of P at the first."""
        self._xn = self._x[: self.n]
        self.__dict__.pop("_Pn", None)

    _Pn = lazy(lambda self: self._P[: self.n, : self.n])

    def __getstate__(self):
        """Return what copies keep: of the storage, what counts. Addresses, views and notes stay here."""
        kept = {k: v for k, v in vars(self).items() if k not in ("_xn", "_Pn", "_downdate", "notes")}
        n, P = self.n, self._Pn
        if self.compiled and self._lower:
            P = np.zeros((n, n), order="F")
            compiled().copy_lower(self, P)
        return kept | {"_x": self._xn, "_P": P, "_used": self.used, "_size": len(self._x)}

    def __setstate__(self, state):
        state = dict(state)
        size = state.pop("_size", len(state["_x"]))  # rows as far apart as they were: the same numbers to the last bit
        self.__dict__.update(state)
        x, used = np.zeros(size), np.zeros(size, bool)
        P, n = square(size, zeros=not (self.compiled and self._lower)), len(self._x)
        x[:n], P[:n, :n], used[:n] = self._x, self._P, self._used
        self._store(x, P, used)
        self.notes = Notes()

    @property
    def x(self):
        """Mean of all states, shape (n,). A view: writing into it changes the map."""
        return self._xn

    @x.setter
    def x(self, x):
        """Write all of it: `map.x += dx` does that."""
        self.x[:] = x

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

    @P.setter
    def P(self, P):
        """Write all of it."""
        self.P[:] = P

    @property
    def used(self):
        """Mask of the states that are in use, shape (n,), bool."""
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
        x, P_xx = real("the mean of a new state", x), real("P_xx", P_xx)
        if x.ndim != 1:
            raise ValueError(f"the mean of a new state must be a vector, got shape {x.shape}")
        check_covariance(P_xx, len(x), "P_xx")
        if not np.isfinite(x).all():
            raise ValueError(f"the mean of a new state must be finite, got {x}")
        if P_xm is not None and (real("P_xm", P_xm).shape != (len(x), self.n) or not np.isfinite(P_xm).all()):
            raise ValueError(f"P_xm must be finite and have shape {(len(x), self.n)}, got shape {np.shape(P_xm)}")

        P_xm = np.zeros((len(x), self.n)) if P_xm is None else real("P_xm", P_xm)
        self.notes.changes += 1
        return self.insert(x, symmetric(P_xx), P_xm)

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
        self.replace(head, x, P_rm, P_rr)
        if tail.start < tail.stop:
            self.notes.changes += 1
            self.vacate(tail)
        return head

    def remove(self, r):
        """Take the state of range r out of the map: its part of x and P becomes zero.

        Raises
        ------
        ValueError
            If r is not the range of a state.
        """
        self.check_range(r)
        self.notes.changes += 1
        self.vacate(r)

    def state(self, r):
        """Mean of the state in range r: a copy, shape (k,); of K states given by indices (K, k), shape (K, k)."""
        return self._xn[r].copy() if isinstance(r, slice) else self._xn.take(r)

    def entry(self, i):
        """Mean of the entry at index i, which is not counted from the end: a float."""
        return self._xn.item(i)

    def block(self, r):
        """Covariance of the state in range r: a copy, shape (k, k); of K states by indices (K, k), (K, k, k)."""
        if not isinstance(r, slice):
            i, j = r[:, :, None], r[:, None, :]
            return self._Pn[np.maximum(i, j), np.minimum(i, j)] if self._lower else self._Pn[i, j]
        B = self._Pn[r, r].copy()
        if self._lower:
            i, j = below(len(B))
            B[j, i] = B[i, j]
        return B

    # --- for the operations of the filter: a whole map, or what of it is active, as `CompressedMap` has it -----

    @property
    def storage(self):
        """Storage for compiled code: of x and P, how much of it counts, and if of P only the lower triangle does."""
        return self._x, self._P, self.n, self._lower

    @property
    def means(self):
        """Means of all states, of which those of what is in use in `storage` are up to date: a view."""
        return self._xn

    @property
    def bookkeeping(self):
        """For compiled code: arrays by which landmarks are found in `storage`, which is not asked for here."""
        return NO_NUMBERS, NO_NUMBERS, 0, NOTHING, NO_NUMBERS

    def spots(self, r, s=None, indices=None, some=None):
        """Return where these states stand in `storage`; of those given by indices (K, k), at least some."""
        return r, s, indices

    def spot(self, r):
        """Return where the state in range r stands in what `rows` has: at r."""
        return r

    def fetch(self, blocks):
        """Return each Jacobian, with the covariance of its state with the whole map: known states drop out.

        Returns
        -------
        list of (ndarray of shape (m, k), ndarray of shape (k, n))
        """
        return [(J, self.rows(r)) for r, J in blocks if r is not None] or [nothing(blocks, self.n)]

    def columns(self, HP, blocks):
        """Return P H' from H P."""
        return HP.T

    def replace(self, r, x, P_rm, P_rr):
        """Replace the state in range r by one of the same length. P_rm is its covariance with what `rows` has."""
        self._xn[r] = x
        self._Pn.T[r] = P_rm
        if self._lower:  # nobody reads what is right of the diagonal
            self._Pn[r, : r.stop] = P_rm[:, : r.stop]
        else:
            self._Pn[r] = P_rm
        self._Pn[r, r] = symmetric(P_rr)

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

    def variances(self, r):
        """Variances of the states in range r, or of K states given by indices (K, k): a copy of that shape."""
        return self._Pn.diagonal()[r].copy()

    def between(self, i, j):
        """Covariance between some states and others, given by their indices: a copy, shape (len(i), len(j))."""
        return compiled().between(self, i, j) if self.compiled else self.P[np.ix_(i, j)]

    def rows(self, r):
        """Covariance of the state in range r with the whole map, P[r, :]. Not to be written to.

        Parameters
        ----------
        r : slice or ndarray of int, shape (K, k)
            A range, or the indices of K states.

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

    def overwrite(self, indices, P_im):
        """Set rows of the covariance, given by their sorted indices, and with them the columns."""
        if self.compiled:
            compiled().overwrite(self, indices, P_im)
        else:
            self._Pn.T[indices] = P_im
            self._Pn[indices] = P_im

    def set_mean(self, r, x):
        """Set the mean of the state in range r, and leave its covariance as it is."""
        self._xn[r] = x

    def shift(self, dx):
        """x = x + dx."""
        self._xn += dx

    def subtract(self, Wt):
        """P = P - W W', given W' of shape (m, n); if it has fewer columns, of the first states only."""
        if not self.compiled or not compiled().subtract(self, Wt):
            self._downdate(Wt, self.keep_one_triangle())

    def roughly(self, settled=False):
        """Return the means of all states, exact here in any case: see `CompressedMap.roughly`."""
        return self._xn, self._xn, NOTHING

    def referred(self):
        """Return the estimate that P refers to, for the invariant error: a copy of the present one."""
        return self._xn.copy()

    def carry(self, at, D, r, E):
        """P = T P T', T = I + D E, as `ekf.carry`: D has rows for the states at these indices, E is of range r."""
        if self.compiled:
            compiled().carry(self, at, D, r, E)
            return
        S = E.dot(self.rows(r))
        if FEW * len(at) < self.n:  # there are rings, or gaps that they have left
            A = D.dot(S)
            A[:, at] += 0.5 * D.dot(S[:, r].dot(E.T)).dot(D.T)
            self._Pn[at] += A
            self._Pn.T[at] += A
            return
        whole = np.zeros((self.n, len(E)))
        whole[at] = D
        P = whole.dot(S + 0.5 * S[:, r].dot(E.T).dot(whole.T))
        self._Pn += P + P.T

    def keep_one_triangle(self):
        """Change only the lower triangle, if the map is large, until `P` is asked for. Returns True if so."""
        n = self.n
        self._lower = self._lower or n >= ONE_TRIANGLE or (self.compiled and n >= ONE_TRIANGLE_COMPILED)
        return self._lower

    def relieve(self, followed=False):
        """Do nothing: after a correction nothing is left to do."""

    def insert(self, x, P_xx, P_xm):
        """A new state, as `add` puts it in, unchecked; P_xx is symmetric. Returns its range."""
        n, r = self.n, self.occupy(self.free(len(x)), x)
        self._Pn[r, :n] = P_xm
        self._Pn.T[r, :n] = P_xm
        self._Pn[r, r] = P_xx
        return r

    def free(self, k):
        """Return where a new state of k entries can be put: the first gap that is long enough, or the end of the map.

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
            self.reserve(int((GROWTH if start < LARGE else SPARING) * (start + k)))
        return slice(start, start + k)

    def occupy(self, r, x):
        """A new state in a range that is `free`; its covariance is there, or will be written. Returns its range."""
        self._x[r], self._used[r] = x, True
        return self.take(r)

    @property
    def entries(self):
        """Storage of the means, and which of them are in use."""
        return self._x, self._used

    def ledger(self, r):
        """Return for compiled code where it has to note a new state in range r, which is `free`: see `kernels.own`."""
        return r.start, 0, *self.entries, *NO_LEDGER

    def take(self, r):
        """A new state in a range that is `free`, and noted in the `ledger`. Returns its range."""
        if r.stop > self.n:
            self.n = r.stop
            self._look()
        self._starts.add(r.start)
        self.n_used += r.stop - r.start
        return r

    def vacate(self, r):
        """Free the entries of range r, a state or a part of one, unchecked: their part of x and P becomes zero."""
        self._x[r], self._P[r, :], self._P[:, r], self._used[r] = 0, 0, 0, False
        self._starts -= set(range(r.start, r.stop))
        self.n_used -= r.stop - r.start

    def clear(self):
        """Take all states out of the map; its storage stays, and what is in it of P: new states write all of theirs."""
        n, self.n, self.n_used, self._lower = self.n, 0, 0, False
        self._x[:n], self._used[:n] = 0, False
        self._starts.clear()
        self._look()

    def _first_gap(self, k):
        """Return where k free entries stand together for the first time; one past the last entry in use, if nowhere."""
        taken = np.flatnonzero(np.concatenate([[True], self.used, [True]])) - 1
        fits = np.flatnonzero(np.diff(taken) - 1 >= k)
        return int(taken[fits[0]]) + 1 if fits.size else int(taken[-2]) + 1

    def reserve(self, n):
        """Let there be storage for n entries, and more."""
        size, m = roomy(n), self.n
        x, used = np.zeros(size), np.zeros(size, bool)
        x[:m], used[:m] = self._xn, self.used
        half = self.compiled and self._lower
        P = square(size, zeros=not half)  # new states write all of theirs
        if half:
            compiled().copy_lower(self, P)
        else:
            P[:m, :m] = self._Pn
        self._store(x, P, used)
