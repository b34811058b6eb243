"""The filter's equations in loops, on the storage of a map: what `fast/filter.py` says, one number at a time.

Inner loops begin at 0, or are slices: only then does the compiler let several numbers be computed at once.

P is the map's storage, column-major, of which the first n rows and columns count. Where `lower` is set only the lower
triangle of it is true. A range that is not in the map begins at -1; its Jacobian drops out.

Shapes: rows of P (k, n); a Jacobian J of K landmarks (K, m, n_r + n_s + n_l), for robot, sensor and landmark, of which
those `found` count, M = m len(found) numbers in all; [H P, Z, z] (M, ·), Z from column `first` on; z and R as measured.

The file is compiled; read `fast/filter.py`. The tests hold the two against each other.
"""

from math import isfinite, pi, sqrt

import numpy as np

from .. import storage
from ..storage import LINE, WIDTH
from . import cache
from .tile import COLUMNS, TALL, product_tile, subtract_rows, subtract_tall_tile, subtract_tile

CACHED = 2048  # numbers that stay in the fastest cache, and leave room for others
HOW = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True}  # a b + c may be rounded once


compiled = cache.compiled(**HOW)
whole, by_lines = compiled(storage.whole), compiled(storage.by_lines)


@compiled
def aligned(m, n):
    """Zeros, as `storage.aligned`."""
    return by_lines(np.zeros(m * n + LINE), m, n)


@compiled
def copy(numbers, out):
    """out[:] = numbers. (As an assignment it takes longer, and may copy: the two might overlap.)"""
    for j in range(len(numbers)):
        out[j] = numbers[j]


@compiled
def rows_of(P, n, lower, start, k, out):
    """Rows of P, `FastMap.rows`: k of them from start on; the upper triangle is taken from the lower one."""
    for a in range(k):
        i = start + a
        begin = i if lower else 0
        for j in range(begin):
            out[a, j] = P[i, j]
        copy(P[begin:n, i], out[a, begin:n])


@compiled
def put(P, n, lower, start, P_rm, P_rr):
    """Rows and columns of P, `FastMap.replace`."""
    k = len(P_rr)
    for a in range(k):
        i, begin = start + a, start if lower else 0
        copy(P_rm[a, begin:n], P[begin:n, i])
        for j in range(start if lower else n):
            P[i, j] = P_rm[a, j]
    for a in range(k):
        for b in range(k):
            P[start + a, start + b] = 0.5 * (P_rr[a, b] + P_rr[b, a])


@compiled
def propagate(P, n, lower, start, J, Q):
    """P_rm = J P_rm, P_rr = J P_rr J' + Q for the range that begins at start: `predict`, and `transform`."""
    k = len(J)
    rows, P_rm, P_rr = np.empty((k, n)), np.zeros((k, n)), Q.copy()
    rows_of(P, n, lower, start, k, rows)
    for a in range(k):
        for b in range(k):
            if J[a, b] != 0:
                for j in range(n):
                    P_rm[a, j] += J[a, b] * rows[b, j]
    for a in range(k):
        for b in range(k):
            for c in range(k):
                P_rr[a, b] += P_rm[a, start + c] * J[b, c]
    put(P, n, lower, start, P_rm, P_rr)


@compiled
def heading(angle):
    """An angle in its normal form, `frames.normalize`: whole turns are added where it is outside of them."""
    return angle if -pi < angle < pi else pi - (pi - angle) % (2 * pi)


@compiled
def sandwich(A, Q, out):
    """out = A Q A'."""
    m, k = A.shape
    for i in range(m):
        for j in range(m):
            out[i, j] = 0.0
        for a in range(k):
            AQ = 0.0
            for b in range(k):
                AQ += A[i, b] * Q[b, a]
            for j in range(m):
                out[i, j] += AQ * A[j, a]


@compiled
def predict(P, n, lower, start, x, X_x, X_u, U):
    """`predict`, of the covariance, if all it takes is finite, x included. Returns True if it is so."""
    total = np.sum(x) + np.sum(X_x) + np.sum(X_u) + np.sum(U)
    for i in range(start, start + len(x)):
        for j in range(start, i + 1):
            total += P[i, j]
    if not isfinite(total):
        return False
    Q = np.empty((len(x), len(x)))
    sandwich(X_u, U, Q)
    propagate(P, n, lower, start, X_x, Q)
    return True


@compiled
def carry(P, n, lower, at, D, start, E):
    """P = T P T', T = I + D E, `FastMap.carry`: D (·, k) for the states at these indices, E (k, ·) for a range.

    With S = E P and V = S + S E' D' / 2 it is P + D V + V' D'.
    """
    k, m = E.shape
    rows, V, Dt, half = np.empty((m, n)), np.zeros((k, n)), np.zeros((k, n)), np.zeros((k, k))
    rows_of(P, n, lower, start, m, rows)
    for i in range(len(at)):
        for a in range(k):
            Dt[a, at[i]] = D[i, a]
    for a in range(k):
        for b in range(m):
            for j in range(n):
                V[a, j] += E[a, b] * rows[b, j]
    for a in range(k):
        for c in range(k):
            for b in range(m):
                half[a, c] += 0.5 * V[a, start + b] * E[c, b]
    for a in range(k):
        for c in range(k):
            for j in range(n):
                V[a, j] += half[a, c] * Dt[c, j]
    for j in range(n):
        for a in range(k):
            d, v, column, Da, Va = Dt[a, j], V[a, j], P[j:n, j], Dt[a, j:], V[a, j:]
            for i in range(n - j):
                column[i] += Da[i] * v + Va[i] * d
        if not lower:
            for i in range(j + 1, n):
                P[j, i] = P[i, j]


@compiled
def within(indices, n):
    """Return True if all these indices are of a map of n states."""
    for i in range(indices.shape[0]):
        for c in range(indices.shape[1]):
            if not 0 <= indices[i, c] < n:
                return False
    return True


@compiled
def near(spot_of, last_use, now, indices, some, out):
    """Where states (K, k) stand in the small map of a compressed one; some are used now. False if one of those is far.

    Parameters
    ----------
    spot_of, last_use : ndarray of int
        Of each state of the map: where it stands in the small map, -1 if it is far; when it was used last.
    now : int
    indices : ndarray of int, shape (K, k)
        The states.
    some : ndarray of int
        Which of the K are used.
    out : ndarray of int, shape (K, k)
    """
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


@compiled
def follow(x, moved, state_at):
    """`CompressedMap._follow`: what `moved` (n_small,) says goes to the means x (n,) of the active states.

    `state_at` says which state of the map stands where in the small one, -1 for the virtual ones.
    """
    for k in range(len(moved)):
        if state_at[k] >= 0:
            x[state_at[k]] += moved[k]
            moved[k] = 0.0


@compiled
def own(l, spot, state, now, x, used, spot_used, start_of, refers, spot_of, last_use, std, state_at):
    """Note a new state with the mean l, at `state` in the map; in a compressed one at `spot` in the small one, too.

    What it is noted in is the `ledger` of the map, of which a `FastMap` has x and used only; the others are empty then.

    Parameters
    ----------
    l : ndarray, shape (k,)
    spot, state : int
        Where it begins.
    now : int
        When it is used.
    x, used, start_of, refers, spot_of, last_use, std : ndarray
        Of each state of the map, as `FastMap` and `CompressedMap` have them.
    spot_used, state_at : ndarray
        Of each state of the small map.
    """
    for c in range(len(l)):
        x[state + c], used[state + c] = l[c], True
        if len(spot_of) > 0:
            spot_used[spot + c], state_at[spot + c], spot_of[state + c] = True, state + c, spot + c
            start_of[state + c], refers[state + c] = state, l[c]
            last_use[state + c], std[state + c] = now, 0.0


@compiled
def columns_of(r, s, n_r, n_s, n_l, known):
    """Find the columns of a Jacobian [E_r E_s E_l] of states in the map, and those of robot and sensor among them."""
    cols, at, q = np.empty(n_r + n_s + n_l, np.int64), np.empty(n_r + n_s + n_l, np.int64), 0
    for c in range(n_r + n_s + n_l):
        if c < n_r:
            state = r + c if r >= 0 else -1
        elif c < n_r + n_s:
            state = s + c - n_r if s >= 0 else -1
        else:
            state = -1 if known else 0
        if state >= 0:
            cols[q], at[q] = c, state
            q += 1
    return cols[:q], at[:q]


@compiled
def covariance_of(P, lower, J, cols, at, indices, k, n_before, E):
    """E = H P H' of landmark k alone, `covariance`: the blocks of P are read where they stand."""
    m, q = len(E), len(cols)
    for c in range(q):
        if cols[c] >= n_before:
            at[c] = indices[k, cols[c] - n_before]
    for a in range(m):
        for b in range(a + 1):
            E[a, b] = 0.0
    for c in range(q):
        for a in range(m):
            HP = 0.0
            for d in range(q):
                i, j = at[d], at[c]
                HP += J[k, a, cols[d]] * (P[j, i] if lower and i < j else P[i, j])
            for b in range(a + 1):
                E[a, b] += HP * J[k, b, cols[c]]
    for a in range(m):
        for b in range(a):
            E[b, a] = E[a, b]


@compiled
def covariances(P, lower, r, s, indices, n_r, n_s, J, found, E):
    """`covariance_of` of each of those found."""
    n_l = J.shape[2] - n_r - n_s
    cols, at = columns_of(r, s, n_r, n_s, n_l, indices.shape[1] == 0)
    for k in found:
        covariance_of(P, lower, J, cols, at, indices, k, n_r + n_s, E[k])


@compiled
def products(P, n, lower, r, s, indices, n_r, n_s, J, found, A, first):
    """Add H P to A, and from column `first` on H P H', of the stack of those found: `cross` and `covariance`."""
    K, m, n_before = len(found), J.shape[1], n_r + n_s
    cols, at = columns_of(r, s, n_r, n_s, indices.shape[1], indices.shape[1] == 0)
    q, Z = len(cols), A[:, first:]
    minus_H, P_at, HP_at = np.empty((K * m, q)), np.zeros((q, first)), np.zeros((q, Z.shape[1]))
    for c in range(q):
        if cols[c] < n_before:
            rows_of(P, n, lower, at[c], 1, P_at[c:])
    for i in range(K):
        k = found[i]
        for c in range(q):
            if cols[c] >= n_before:
                rows_of(P, n, lower, indices[k, cols[c] - n_before], 1, P_at[c:])
            for a in range(m):
                minus_H[i * m + a, c] = -J[k, a, cols[c]]
        for a in range(m):
            for j in range(0, first, WIDTH):
                subtract_rows(A, i * m + a, j, minus_H, P_at, q, 1.0)
    for i in range(K):
        k = found[i]
        for c in range(q):
            if cols[c] >= n_before:
                at[c] = indices[k, cols[c] - n_before]
            if cols[c] >= n_before or i == 0:
                for p in range(K * m):
                    HP_at[c, p] = A[p, at[c]]
        for a in range(m):
            for p in range(0, K * m, WIDTH):
                subtract_rows(Z, i * m + a, p, minus_H, HP_at, q, 1.0)


@compiled
def eliminate(A, first):
    """Make L^-1 A of A, in place, where Z = L L' stands from column `first` on. Returns True if Z is positive definite.

    A has M rows and, from column `first` on, whole(M + 1) columns or more. What is left of Z comes last, as much at a
    time as stays in the fastest cache.
    """
    M, Lt = len(A), A[:, first:]
    end, piece, factors = first + whole(M + 1), max(WIDTH, whole(CACHED // (M + 1))), np.empty(M)
    begin = max(0, min(first, end - piece))
    for i in range(M):
        pivot = Lt[i, i]
        for c in range(i):
            pivot -= Lt[c, i] ** 2
        if not (pivot > 0 and isfinite(pivot)):
            return False
        factors[i] = 1 / sqrt(pivot)
        for j in range(begin, end, WIDTH):
            subtract_rows(A, i, j, Lt.T, A, i, factors[i])
    for left in range(0, begin, piece):
        for i in range(M):
            for j in range(left, min(left + piece, begin), WIDTH):
                subtract_rows(A, i, j, Lt.T, A, i, factors[i])
    return True


@compiled
def downdate(P, Wt, n, lower):
    """P -= W W' in tiles, of n states; W' has columns up to a multiple of LINE, those that are too many are zero."""
    for j in range(0, n, COLUMNS):
        first = j - j % LINE if lower else 0
        rest = n - (n - first) % (TALL * LINE)
        for i in range(first, rest, TALL * LINE):
            subtract_tall_tile(P, i, j, Wt)
        for i in range(rest, n, LINE):
            subtract_tile(P, i, j, Wt)


@compiled
def product(Xt, P, n, out):
    """Make X P of the first n columns of P in tiles, row by row in `out`.

    Parameters
    ----------
    Xt : ndarray, shape (size, k)
        X', k a multiple of COLUMNS.
    P : ndarray, shape (size, ·)
        Rows of whole lines, n numbers and more.
    n : int
    out : ndarray
        k rows or more, of whole lines, too.
    """
    for i in range(0, n, LINE):
        for j in range(0, Xt.shape[1], COLUMNS):
            product_tile(out.T, i, j, P, Xt)


@compiled
def update(x, P, n, lower, r, s, indices, n_r, n_s, J, E, found, z, R):
    """`correct` by the stack of those found; E (K, m, m) gets their H P H', `covariance`.

    Returns
    -------
    bool
        False if the covariance of the innovation is not positive definite, or z not finite: nothing has been changed.
    """
    K, m = z.shape
    M, first = K * m, whole(n)
    A = aligned(M + 1, first + whole(M + 1) + LINE)  # [H P, Z, z] becomes [W', L', w], and below W' comes -dx
    products(P, n, lower, r, s, indices, n_r, n_s, J, found, A, first)
    Z = A[:, first:]
    for i in range(K):
        for a in range(m):
            for b in range(m):
                E[found[i], a, b] = Z[i * m + a, i * m + b]
                Z[i * m + a, i * m + b] += R[i if len(R) > 1 else 0, a, b]
            Z[i * m + a, M] = z[i, a]
    if not isfinite(np.sum(z)) or not eliminate(A[:M], first):
        return False
    for j in range(0, first, WIDTH):
        subtract_rows(A, M, j, Z.T, A, M, 1.0)
    for j in range(n):
        x[j] -= A[M, j]
    downdate(P, A[:M], n, lower)
    return True


@compiled
def passes(z, E, R, threshold):
    """Return 1 if z' (E + R)^-1 z is below the gate, 0 if not, -1 where `eliminate` says False."""
    m, total = len(z), 0.0
    A = aligned(m, whole(m + 1))  # [Z, z] becomes [L', w]
    A[:, :m], A[:, m] = E + R, z
    if not isfinite(np.sum(z)) or not eliminate(A, 0):
        return -1
    for a in range(m):
        total += A[a, m] ** 2
    return 1 if total < threshold else 0


@compiled
def gated(x, P, n, lower, r, s, indices, n_f, J, E, found, z, R, threshold):
    """`update` by those found that pass the gate, each on its own.

    Returns
    -------
    int
        How many have passed; `found` begins with them. -1 where `update` says False.
    """
    K, q, every = len(found), 0, len(R) > 1
    w, Q = z.copy(), R.copy()
    for i in range(K):
        passed = passes(z[i], E[found[i]], R[i if every else 0], threshold) if isfinite(threshold) else 1
        if passed < 0:
            return -1
        if passed:
            found[q], w[q] = found[i], z[i]
            if every:
                Q[q] = R[i]
            q += 1
    done = q == 0 or update(x, P, n, lower, r, s, indices, n_f, n_f, J, E, found[:q], w[:q], Q[:q] if every else Q)
    return q if done else -1


@compiled
def join(P, n, lower, r, s, n_r, n_s, L, P_lm, P_ll):
    """P_lm = L_x P and P_ll = L_x P L_x' + Q of a new state, `augment`: P_ll is Q before. Returns True if finite."""
    k = len(L)
    shared = np.empty((max(n_r, n_s), n))
    P_lm[:] = 0.0
    for start, first, size in ((r, 0, n_r), (s, n_r, n_s)):
        if start < 0:
            continue
        rows_of(P, n, lower, start, size, shared)
        for a in range(k):
            for c in range(size):
                for j in range(n):
                    P_lm[a, j] += L[a, first + c] * shared[c, j]
    for start, first, size in ((r, 0, n_r), (s, n_r, n_s)):
        if start < 0:
            continue
        for a in range(k):
            for b in range(k):
                for c in range(size):
                    P_ll[a, b] += P_lm[a, start + c] * L[b, first + c]
    for a in range(k):
        for b in range(a):
            P_ll[a, b] = P_ll[b, a] = 0.5 * (P_ll[a, b] + P_ll[b, a])
    return isfinite(np.sum(P_ll))
