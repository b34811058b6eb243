"""Compiled pieces of the maps: what `fast_map.py` and `compressed_map.py` ask of their storage."""

from math import sqrt

import numpy as np

from ..smallness import EXPLAINED, FLOOR, STILL, TINY, TRIALS
from ..storage import LINE, WIDTH
from ..triangle import BLOCK
from .filter import MANY_ROWS, integers, machine_code
from .kernels import aligned, compiled, downdate, put, rows_of, whole
from .tile import COLUMNS, product_tile, subtract_rows

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
    _overwrite(P, lower, np.array(indices, np.int64), np.asarray(P_im, float))


@compiled
def _overwrite(P, lower, indices, P_im):
    k, n = P_im.shape
    for a in range(k):
        i = indices[a]
        for j in range(i if lower else 0, n):
            P[j, i] = P_im[a, j]
    for j in range(n):  # side by side in memory are the columns
        for a in range(k):
            i = indices[a]
            if j < i or not lower:
                P[i, j] = P_im[a, j]


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
SETTLE = "void(f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], i8[::1], i8[::1])"


def spots(spot_of, last_use, now, indices, some):
    """Return where these states, (K, k), stand in the small map; some are used now. None if one of those is far.

    Parameters
    ----------
    spot_of, last_use : ndarray of int
        Of each state of the map: where it stands in the small map, -1 if it is far; when it was used last.
    now : int
    indices : ndarray of int, shape (K, k)
    some : list of int, or ndarray
    """
    indices, out, run = integers(indices), np.empty(indices.shape, np.int64), machine_code(_spots, SPOTS)
    return out if run(spot_of, last_use, now, indices, integers(some), out) else None


@compiled
def _spots(spot_of, last_use, now, indices, some, out):
    K, k = indices.shape
    for i in some:
        for c in range(k):
            if spot_of[indices[i, c]] < 0:
                return False
            last_use[indices[i, c]] = now
    for i in range(K):
        for c in range(k):
            out[i, c] = spot_of[indices[i, c]]
    return True


def follow(x, moved, state_at):
    """`CompressedMap._follow`: what `moved` (n_small,) says goes to the means x (n,) of the active states.

    `state_at` says which state of the map stands where in the small one, -1 for the virtual ones.
    """
    machine_code(_follow, FOLLOW)(x, moved, state_at)


@compiled
def _follow(x, moved, state_at):
    for k in range(len(moved)):
        if state_at[k] >= 0:
            x[state_at[k]] += moved[k]
            moved[k] = 0.0


def settle(x, moved, virtual, v, state_at):
    """The means x of the far states follow the virtual ones, b = b_0 + G v, `VirtualStates.times`; these are zero then.

    Parameters
    ----------
    x, moved, of
        As in `follow`.
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


def product(X, P, n):
    """X (k, size) times the first n columns of P, whose first `size` rows count and are whole lines: shape (k, n)."""
    k, size = X.shape
    Xt, out = np.zeros((size, -(-k // COLUMNS) * COLUMNS)), np.empty((k + COLUMNS, -(-n // LINE) * LINE))
    Xt[:, :k] = X.T
    _product(P[:size], Xt, out.T, n)
    return out[:k, :n]


@compiled
def _product(P, Xt, out, n):
    for i in range(0, n, LINE):
        for j in range(0, Xt.shape[1], COLUMNS):
            product_tile(out, i, j, P, Xt)


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


def cholesky(P):
    """`virtual.cholesky` of P (k, k): C (k, rank), and the rows in which it is lower triangular."""
    Ct, order = np.empty(P.shape), np.empty(len(P), np.int64)
    rank = _cholesky(P, Ct, order)
    return Ct[:rank].T, order[:rank]


@compiled
def _cholesky(P, Ct, order):
    """The rows of C' (k, k) until C C' = P; `order` (k,) gets the states, of which most is left first. The rank."""
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
