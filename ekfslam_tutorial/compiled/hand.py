"""Compiled pieces of a compressed map: what `ekf/compressed.py` calls between its far states and those at hand."""

import numpy as np

from .kernels import compiled


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
