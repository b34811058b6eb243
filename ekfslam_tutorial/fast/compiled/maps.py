"""Compiled pieces of the maps: what `fast_map.py` and `compressed_map.py` ask of their storage."""

from math import sqrt

import numpy as np

from ..smallness import EXPLAINED, FLOOR, STILL, TINY, TRIALS
from ..storage import LINE, WIDTH
from ..triangle import BLOCK
from . import kernels
from .filter import MANY_ROWS, integers, machine_code
from .kernels import aligned, compiled, copy, downdate, near, product, put, rows_of, whole
from .tile import COLUMNS, subtract_rows

# --- a map -----------------------------------------------------------------------------------------------------------


def rows(map, indices):
    """`FastMap.rows` of any states: shape (k, n). None if some are not in the map."""
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


def between(map, i, j):
    """`FastMap.between`: shape (len(i), len(j))."""
    _, P, _, lower = map.storage
    out = np.empty((len(i), len(j)))
    _between(P, lower, i, j, out)
    return out


@compiled
def _between(P, lower, rows, cols, out):
    for a in range(len(rows)):
        for b in range(len(cols)):
            i, j = rows[a], cols[b]
            out[a, b] = P[j, i] if lower and i < j else P[i, j]


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
    """`FastMap.overwrite`: rows P_im, shape (k, n), given by their k indices, and the columns."""
    _, P, _, lower = map.storage
    _overwrite(P, lower, np.array(indices, np.int64), np.asarray(P_im, float), P_im.shape[1])


@compiled
def _overwrite(P, lower, indices, P_im, n):
    k = len(P_im)
    for a in range(k):
        i = indices[a]
        for j in range(i if lower else 0, n):
            P[j, i] = P_im[a, j]
    for j in range(n):  # side by side in memory are the columns
        for a in range(k):
            i = indices[a]
            if j < i or not lower:
                P[i, j] = P_im[a, j]


def copy_lower(map, out):
    """Copy the lower triangle of the covariance; nothing else of `out` is written."""
    _, P, n, _ = map.storage
    _copy_lower(P, n, out)


@compiled
def _copy_lower(P, n, out):
    for j in range(n):
        copy(P[j:n, j], out[j:n, j])


def subtract(map, Wt):
    """`FastMap.subtract` of W', shape (m, n). Returns True if done."""
    if len(Wt) > MANY_ROWS:
        return False
    m, n = Wt.shape
    W, lower = aligned(m, whole(n) + LINE), map.keep_one_triangle()
    W[:, :n] = Wt
    downdate(map.storage[1], W, n, lower)
    return True


# --- a compressed map ------------------------------------------------------------------------------------------------

SPOTS = "b1(i8[::1], i8[::1], i8, i8[:, ::1], i8[::1], i8[:, ::1])"
FOLLOW = "void(f8[::1], f8[::1], i8[::1])"
SETTLED = (
    "void(f8[::1, :], i8, b1, f8[::1, :], b1, f8[:, ::1], f8[:, ::1], i8[::1], i8[::1], i8[::1], f8[::1], f8[:, ::1])"
)
SETTLE = "void(f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], i8[::1], i8[::1])"


def spots(spot_of, last_use, now, indices, some):
    """`kernels.near` of states (K, k): where they stand in the small map. None if one of those used is far."""
    indices, out, run = integers(indices), np.empty(indices.shape, np.int64), machine_code(near, SPOTS)
    return out if run(spot_of, last_use, now, indices, integers(some), out) else None


def follow(x, moved, state_at):
    """`kernels.follow`: the means of the active states."""
    machine_code(kernels.follow, FOLLOW)(x, moved, state_at)


def settle(x, moved, virtual, v, state_at):
    """The means x of the far states follow the virtual ones, b = b_0 + G v, `VirtualStates.times`; these are zero then.

    Parameters
    ----------
    x, moved, of
        As in `kernels.follow`, and its `state_at`.
    virtual : VirtualStates
    v : ndarray of int, shape (size,)
        Where the virtual states stand in the small map.
    """
    Lt, P = virtual.factors
    machine_code(_settle, SETTLE)(x, moved, Lt, P, v, state_at)


@compiled
def _settle(x, moved, Lt, P, v, state_at):
    size, n, w = len(v), len(x), moved[v]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            w[i] -= Lt[i, j] * w[j]
        w[i] /= Lt[i, i]
    minus_dx, w = np.zeros((1, whole(n))), w.reshape(1, size)
    for j in range(0, n, WIDTH):
        subtract_rows(minus_dx, 0, j, w, P, size, 1.0)
    for k in range(len(moved)):
        if state_at[k] >= 0:
            minus_dx[0, state_at[k]] = 0.0
    for j in range(n):
        x[j] -= minus_dx[0, j]
    moved[:] = 0.0


def settled(whole, small, virtual, active, spot_of, v, std):
    """`CompressedMap._settle` of the covariance, and of the standard deviations `std`: rows of the active states.

    Parameters
    ----------
    whole, small : FastMap
    virtual : VirtualStates
    active : ndarray of int, shape (k,)
        The states that are active.
    spot_of, std : ndarray
        Where each state stands in the small map, -1 if it is far; what its standard deviation is, at most.
    v : ndarray of int, shape (size,)
        Where the virtual states stand in the small map.

    Returns
    -------
    ndarray, shape (k, n)
        A part of the virtual states' scratch. None if they are too many: BLAS is faster then.
    """
    if len(v) > MANY_ROWS:
        return None
    lower, (_, P_small, _, small_lower) = whole.keep_one_triangle(), small.storage
    _, P, n, _ = whole.storage
    out, k = virtual.scratch(len(active) + len(v) + COLUMNS), len(active)
    run = machine_code(_settled, SETTLED)
    run(P, n, lower, P_small, small_lower, *virtual.factors, active, spot_of, v, std, out)
    return out[:k, :n]


@compiled
def _settled(P, n, lower, P_small, small_lower, Lt, P_0, active, spot_of, v, std, out):
    """With `both`, rows of P_aa' and of C: both L^-1 P_0[A, :] are the rows of the active states, and W'."""
    k, size, far, spot = len(active), len(v), n, spot_of[active]
    while far > 0 and spot_of[far - 1] >= 0:
        far -= 1
    P_vv, Ct, order = np.empty((size, size)), np.empty((size, size)), np.empty(size, np.int64)
    _between(P_small, small_lower, v, v, P_vv)
    rank = _cholesky(-P_vv, Ct, order)
    both = np.zeros((size, -(-(k + rank) // COLUMNS) * COLUMNS))  # its transpose
    for c in range(size):
        for a in range(k):
            i, j = max(spot[a], v[c]), min(spot[a], v[c])
            both[c, a] = P_small[i, j] if small_lower else P_small[spot[a], v[c]]
        for q in range(rank):
            both[c, k + q] = Ct[q, c]
    for c in range(size - 1, -1, -1):
        solved = both[c] / Lt[c, c]
        copy(solved, both[c])
        for e in range(c):
            row, factor = both[e], Lt[e, c]
            for a in range(len(solved)):
                row[a] -= factor * solved[a]
    product(both, P_0[:size], n, out)
    for a in range(k):
        for b in range(a + 1):
            i, j = max(spot[a], spot[b]), min(spot[a], spot[b])
            out[a, active[b]] = out[b, active[a]] = P_small[i, j]
        std[active[a]] = sqrt(max(out[a, active[a]], 0.0))
    downdate(P, out[k : k + rank], far, lower)  # the others get their rows
    _overwrite(P, lower, active, out[:k], n)


def explained(virtual, i, P_ii):
    """`VirtualStates._explained` of states i (k,), P_ii (k, k): G_i, shape (k, size + k)."""
    Lt, P = virtual.factors
    Gt = np.zeros((virtual.size + len(i), len(i)))
    _explained(Lt, P, i, P_ii, Gt)
    return Gt.T


@compiled
def _explained(Lt, P, i, P_ii, Gt):
    size, k, largest = len(Lt), len(i), 0.0
    for c in range(size):
        for a in range(k):
            Gt[c, a] = P[c, i[a]]
    for c in range(size):
        for a in range(k):
            Gt[c, a] /= Lt[c, c]
        for d in range(c + 1, size):
            for a in range(k):
                Gt[d, a] -= Lt[c, d] * Gt[c, a]
    for a in range(k):
        largest = max(largest, P_ii[a, a])
    D = np.empty(k)
    for a in range(k):
        D[a] = FLOOR * max(P_ii[a, a], STILL * (largest if largest > 0 else 1.0))
    for _ in range(TRIALS):
        if _triangle(P_ii, D, size, Gt):
            break
        D *= 100


@compiled
def _triangle(P, D, size, Ct):
    """Complete C' (size + k, k), of which the first rows are given: C C' = P + D. Returns True if D is large enough."""
    k = len(P)
    for j in range(k):
        row = Ct[size + j]
        for a in range(j, k):
            row[a] = P[j, a]
        row[j] += D[j]
        for c in range(size + j):
            h = Ct[c, j]
            for a in range(j, k):
                row[a] -= h * Ct[c, a]
        if not row[j] > 0:
            return False
        pivot = sqrt(row[j])
        for a in range(j, k):
            row[a] /= pivot
    return True


@compiled
def _cholesky(P, Ct, order):
    """`virtual.cholesky` of P (k, k). Returns the rank: so many rows of C' are written.

    `order` (k,) gets the states, of which most is left first.
    """
    k = len(P)
    s, left = np.empty(k), np.empty(k)
    for a in range(k):
        s[a] = sqrt(max(P[a, a], TINY))
        left[a] = P[a, a] / s[a] ** 2
    for rank in range(k):  # the largest first
        p, row = np.argmax(left), Ct[rank]
        if not left[p] > EXPLAINED:
            return rank
        pivot = s[p] * sqrt(left[p])
        for a in range(k):
            row[a] = P[p, a]
        for c in range(rank):
            h = Ct[c, p]
            for a in range(k):
                row[a] -= h * Ct[c, a]
        for a in range(k):
            row[a] /= pivot
        for before in order[:rank]:
            row[before] = 0.0
        for a in range(k):
            left[a] -= (row[a] / s[a]) ** 2
        order[rank], row[p], left[p] = p, pivot, -np.inf
    return k


def joined(small, v, G_i, P_ii):
    """`CompressedMap._joined` of G_i (k, size + k) and P_ii (k, k). Returns the range in the small map."""
    m = len(G_i) + G_i.shape[1] - len(v)
    spot = small.free(m)
    _, P, n, lower = small.storage
    _join(P, n, lower, v, G_i, P_ii, spot.start)
    return small.occupy(spot, 0.0)


@compiled
def _join(P, n, lower, v, G, P_ii, start):
    k, size = len(G), len(v)
    m = k + G.shape[1] - size
    row, P_xm, P_xx = np.empty((1, n)), np.zeros((m, n)), np.zeros((m, m))
    for c in range(size):
        rows_of(P, n, lower, v[c], 1, row)
        for a in range(k):
            for j in range(n):
                P_xm[a, j] += G[a, c] * row[0, j]
    for a in range(k):
        for b in range(k):
            P_xx[a, b] = P_ii[a, b]
            for c in range(size):
                P_xx[a, b] += P_xm[a, v[c]] * G[b, c]
        for c in range(k, m):
            P_xx[a, c] = P_xx[c, a] = G[a, size + c - k]
    for a in range(k):
        for c in range(size):
            P_xm[a, v[c]] += G[a, c]
    put(P, n, lower, start, P_xm, P_xx)
