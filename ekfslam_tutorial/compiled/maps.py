"""Compiled pieces of the maps: what `ekf/stochastic_map.py` and `ekf/compressed.py` ask of their storage."""

import numpy as np

from ..ekf.stochastic_map import LINE
from ..ekf.triangle import BLOCK
from .filter import MANY_ROWS
from .kernels import compiled, downdate, rows_of

# --- a map -----------------------------------------------------------------------------------------------------------


def rows(map, indices):
    """`Map.rows` of any states: shape (k, n). None if some are not in the map."""
    (_, P, n, lower), indices = map.storage, np.array(indices, np.int64)
    out = np.empty((len(indices), n))
    return out if _rows(P, n, lower, indices, out) else None


@compiled
def _rows(P, n, lower, indices, out):
    for i in range(len(indices)):
        if not 0 <= indices[i] < n:
            return False
        rows_of(P, n, lower, indices[i], 1, out[i:])
    return True


def mirror(map):
    """`triangle.mirror`: the lower triangle is copied to the upper one, by blocks that stay in the cache."""
    _, P, n, _ = map.storage
    _mirror(P, n)


@compiled
def _mirror(P, n):
    for first in range(0, n, BLOCK):
        for below in range(first, n, BLOCK):
            for j in range(first, min(first + BLOCK, n)):
                for i in range(max(below, j), min(below + BLOCK, n)):
                    P[j, i] = P[i, j]


def overwrite(map, indices, P_im):
    """`Map.overwrite`: rows P_im, shape (k, n), given by their k indices, and the columns."""
    _, P, _, lower = map.storage
    _overwrite(P, lower, np.array(indices, np.int64), np.ascontiguousarray(P_im, float))


@compiled
def _overwrite(P, lower, indices, P_im):
    n = P_im.shape[1]
    for a in range(len(indices)):
        i = indices[a]
        begin = i if lower else 0
        P[begin:n, i] = P_im[a, begin:]
        for j in range(i if lower else n):
            P[i, j] = P_im[a, j]


def subtract(map, Wt):
    """`Map.subtract` of W', shape (m, n). Whether it could be done."""
    if len(Wt) > MANY_ROWS:
        return False
    m, n = Wt.shape
    W, lower = np.zeros((m, -(-n // LINE) * LINE)), map.keep_one_triangle()
    W[:, :n] = Wt
    downdate(map.storage[1], W, lower)
    return True


# --- a compressed map ------------------------------------------------------------------------------------------------


def here(at, used_at, now, rows, some):
    """Where the states of these rows are at hand, (K, k); some of them are used now. None if some are far.

    Parameters
    ----------
    at, used_at : ndarray of int
        Of each state of the map: where it is at hand, -1 if it is far; when it was used last.
    now : int
    rows : ndarray of int, shape (K, k)
    some : list of int
    """
    out = np.empty_like(rows)
    return out if _here(at, used_at, now, rows, np.array(some, np.int64), out) else None


@compiled
def _here(at, used_at, now, rows, some, out):
    K, k = rows.shape
    for i in some:
        for c in range(k):
            if at[rows[i, c]] < 0:
                return False
            used_at[rows[i, c]] = now
    for i in range(K):
        for c in range(k):
            out[i, c] = at[rows[i, c]]
    return True


@compiled
def settle(x, x_near, L, P, v, hand, at):
    """The means x of all states follow those at hand: b = b_0 + G v, `VirtualStates.times`.

    Parameters
    ----------
    x, x_near : ndarray
        Means of all states, and of those at hand.
    L, P : ndarray
        `VirtualStates.factors`.
    v, hand : ndarray of int
        Where the virtual states are at hand; which states are.
    at : ndarray of int
        Where these are.
    """
    size, n, moved, w = len(v), len(x), np.empty(len(hand)), x_near[v]
    for i in range(len(hand)):
        moved[i] = x[hand[i]] + x_near[at[hand[i]]]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            w[i] -= L[j, i] * w[j]
        w[i] /= L[i, i]
    for i in range(size):
        row = P[i, :n]
        for j in range(n):
            x[j] += w[i] * row[j]
    for i in range(len(hand)):
        x[hand[i]] = moved[i]
