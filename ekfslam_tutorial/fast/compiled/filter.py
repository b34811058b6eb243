"""Compiled pieces of the filter: what `fast/filter.py` calls for a map with `compiled`, blocks given."""

from functools import cache

import numpy as np

from . import kernels

MANY_ROWS = 200  # of W' from which on BLAS is faster than the loops
NO_INDICES = np.zeros((0, 0), np.int64)  # of landmarks that are known
RANGE = slice, type(None)


PREDICT = "b1(f8[::1, :], i8, b1, i8, f8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1])"
CARRY = "void(f8[::1, :], i8, b1, i8[::1], f8[:, ::1], i8, f8[:, ::1])"
WITHIN = "b1(i8[:, ::1], i8)"
UPDATE = (
    "b1(f8[::1], f8[::1, :], i8, b1, i8, i8, i8[:, ::1], i8, i8, "
    "f8[:, :, ::1], f8[:, :, ::1], i8[::1], f8[:, ::1], f8[:, :, ::1])"
)


@cache
def machine_code(kernel, types):
    """A kernel as `program.entry` gives programs."""
    return kernel.compile(types)


def floats(a):
    """An array as machine code takes it, whatever its type and order. It is not written to."""
    return np.asarray(a, float, order="C")


def integers(a):
    """The same for whole numbers."""
    return np.asarray(a, np.int64, order="C")


def noises(R):
    """A covariance for all, or one for each: a stack."""
    R = floats(R)
    return R[None] if R.ndim == 2 else R


def start_of(r):
    """Return where a range begins; -1 for that of a known state."""
    return -1 if r is None else r.start


def predict(map, r, x, X_x, X_u, U):
    """`filter.predict`. Returns True if it could be done."""
    if not 0 <= r.start < r.stop <= map.n:
        return False
    k, nu, (spot, *_) = r.stop - r.start, len(U), map.spots(r)
    x, X_x, X_u, U = floats(x), floats(X_x), floats(X_u), floats(U)
    if not isinstance(spot, slice) or (X_x.shape, X_u.shape, U.shape, x.shape) != ((k, k), (k, nu), (nu, nu), (k,)):
        return False
    _, P, n, lower = map.storage
    if not machine_code(kernels.predict, PREDICT)(P, n, lower, spot.start, x, X_x, X_u, U):
        return False
    map.set_mean(r, x)
    return True


def carry(map, at, D, r, E):
    """`FastMap.carry`."""
    _, P, n, lower = map.storage
    machine_code(kernels.carry, CARRY)(P, n, lower, integers(at), floats(D), r.start, floats(E))


def update(map, blocks, z, R):
    """`filter.update`, by one or two ranges, and after them at most one array of indices. Returns True if done."""
    z, ranges, Js, sizes, indices = floats(z), [], [], [], None
    if z.ndim == 1:
        z, R = z[None], floats(R)[None]
    for r, J in blocks:
        if r is None:
            continue
        if indices is not None:
            return False
        if isinstance(r, slice):
            if not 0 <= r.start < r.stop <= map.n:
                return False
            ranges.append(r)
            sizes.append(r.stop - r.start)
        else:
            indices = integers(r)
            if indices.ndim != 2 or len(indices) != len(z) or not machine_code(kernels.within, WITHIN)(indices, map.n):
                return False
            sizes.append(indices.shape[1])
        Js.append(J if J.ndim == 3 else J[None])
        if Js[-1].shape != (*z.shape, sizes[-1]):
            return False
    if not 1 <= len(ranges) <= 2:
        return False
    (r, s), (n_r, n_s) = (*ranges, None)[:2], (*sizes[: len(ranges)], 0)[:2]
    found = every(len(z))
    return correct_some(map, map.spots(r, s, indices, found), n_r, n_s, np.concatenate(Js, -1), found, z, R)


@cache
def every(K):
    """The indices of all K."""
    return np.arange(K)


def correct_some(map, spots, n_r, n_s, J, found, z, R):
    """`filter.update` by those found of a stack. Returns True if done; if not, nothing has been changed.

    Parameters
    ----------
    map : Map
    spots : tuple (slice or None, slice or None, ndarray of int of shape (K, k) or None)
        From `map.spots`: where the states are that the columns of J belong to, two that are the same for all, and
        those that each has of its own.
    n_r, n_s : int
        Numbers of the first two.
    J : ndarray, shape (K, m, ·)
    found : list or ndarray of int, shape (k,)
        Which of the K.
    z : ndarray, shape (k, m)
    R : ndarray, shape (m, m), or (k, m, m)
    """
    m, (r, s, indices), J, z, R = z.shape[1], spots, floats(J), floats(z), noises(R)
    if z.size > MANY_ROWS or R.shape not in ((1, m, m), (len(z), m, m)):
        return False
    if not isinstance(r, RANGE) or not isinstance(s, RANGE):
        return False
    found, indices = integers(found), NO_INDICES if indices is None else integers(indices)
    lower = map.keep_one_triangle()
    x, P, n, _ = map.storage
    run, E = machine_code(kernels.update, UPDATE), np.empty((len(J), m, m))
    if not run(x, P, n, lower, start_of(r), start_of(s), indices, n_r, n_s, J, E, found, z, R):
        return False
    map.relieve()
    return True
