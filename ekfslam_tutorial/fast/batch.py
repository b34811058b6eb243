"""Many runs of one filter at once: the equations of `filter`, with one more axis, the run.

One run of a small map spends its time on calls, not on numbers. Here each call does all runs. The run is the *last*
axis of what is stored, so every operation on the states of a map is one on long contiguous rows, a number for each run.
"""

import numpy as np

RUNS_AT_A_TIME = 1024
"""Of the covariance so many runs are corrected together: a row of it and what is taken off it stay in the cache."""


class Batch:
    """Mean and covariance of R runs, all with the same ranges.

    Parameters
    ----------
    x : array_like, shape (R, n)
    P : array_like, shape (R, n, n)

    Attributes
    ----------
    x : ndarray, shape (R, n)
        Means. A view: write into it.
    P : ndarray, shape (R, n, n)
        Covariances. A view, too.
    """

    def __init__(self, x, P):
        x, P = np.asarray(x, float), np.asarray(P, float)
        if x.ndim != 2 or P.shape != (*x.shape, x.shape[1]):
            raise ValueError(f"a batch needs x of shape (R, n) and P of shape (R, n, n), got {x.shape} and {P.shape}")
        self._x, self._P = np.array(x.T, order="C"), np.array(P.transpose(1, 2, 0), order="C")

    @property
    def x(self):
        """Means of all runs, shape (R, n). A view."""
        return self._x.T

    @property
    def P(self):
        """Covariances of all runs, shape (R, n, n). A view."""
        return self._P.transpose(2, 0, 1)

    def predict(self, r, x, X_x, X_u, U):
        """Motion of the state in range r of all runs; see `filter.predict`.

            P_rr = X_x P_rr X_x' + X_u U X_u',    P_rm = X_x P_rm

        Parameters
        ----------
        r : slice
        x : ndarray, shape (R, k)
            States after the motion.
        X_x, X_u : ndarray, shape (k, k) and (k, nu), or (R, k, k) and (R, k, nu)
            The same for all runs, or one for each.
        U : ndarray, shape (nu, nu), or (R, nu, nu)
        """
        X_x, Q = _runs_last(X_x), _runs_last(X_u @ U @ np.swapaxes(X_u, -1, -2))
        P_rm = _times(X_x, self._P[r])
        P_rr = _times(X_x, _at(P_rm, r)) + _broadcast(Q)

        self._x[r] = np.transpose(x)
        self._P[r] = P_rm
        self._P[:, r] = P_rm.swapaxes(0, 1)
        self._P[r, r] = _symmetric(P_rr)

    def correct(self, blocks, z, R):
        """Correction of all runs, each by one observation of its own; see `filter.correct`.

            Z = H P H' + R = L L',   W = P H' L^-T,   x = x + W L^-1 z,   P = P - W W'

        Parameters
        ----------
        blocks : sequence of (range, ndarray)
            Derivatives of the expectation, shape (m, k) for all runs or (R, m, k). A range is a slice; or an array of
            int, shape (R, k), where each run has a state of its own; or None for a known state.
        z : ndarray, shape (R, m)
            Innovations. A run without an observation has zeros here and in its blocks: nothing of it changes.
        R : ndarray, shape (m, m), or (R, m, m)

        Raises
        ------
        ValueError
            If an innovation is not finite, or its covariance not positive definite. Nothing has been changed then.
        """
        PHt, Z = self.innovation(blocks, R)
        self.update(PHt, Z, z)

    def innovation(self, blocks, R):
        """P H' and Z = H P H' + R, as `update` takes them.

        Parameters
        ----------
        blocks, R
            As in `correct`.

        Returns
        -------
        PHt : ndarray, shape (m, n, R)
        Z : ndarray, shape (m, m, R)
        """
        blocks = [(_index(r), _runs_last(J)) for r, J in blocks if r is not None]
        PHt = _sum(_times(J, self._rows(r)) for r, J in blocks)
        return PHt, _sum(_times(J, _at(PHt, r)) for r, J in blocks) + _broadcast(_runs_last(R))

    def update(self, PHt, Z, z):
        """Correction by what `innovation` has returned.

        Parameters
        ----------
        PHt, Z : ndarray
        z : ndarray, shape (R, m)
            Innovations.
        """
        z, wanted = np.ascontiguousarray(np.transpose(z)), (len(Z), self._x.shape[1])
        if z.shape != wanted:
            raise ValueError(f"the innovations must have shape {wanted[::-1]}, got {z.shape[::-1]}")
        L = _cholesky(Z)
        for bad, what in (
            (~np.isfinite(z).all(0), " must be finite"),
            (~(L[-1, -1] > 0), "'s covariance must be positive definite"),
        ):
            if bad.any():
                raise ValueError(f"the innovation{what}, but that of run {int(bad.argmax())} is not")
        W, w = _forward(L, PHt), _forward(L, z)
        for a in range(len(w)):
            self._x += w[a] * W[a]
        for start in range(0, z.shape[1], RUNS_AT_A_TIME):
            some = slice(start, start + RUNS_AT_A_TIME)
            _subtract(self._P[..., some], np.ascontiguousarray(W[..., some]))

    def carry(self, r, B, B2):
        """Carry the covariances of all runs along, from the estimate before a correction to that after it: `ekf.carry`.

            P = T P T',    T = I + (B2 - B) E,    E B_r = I

        Parameters
        ----------
        r : slice
        B, B2 : ndarray, shape (R, n, k)
        """
        Q, U = np.linalg.qr(B[:, r])
        D, E = B2 - B, np.linalg.solve(U, np.swapaxes(Q, -1, -2))
        some = D.any((0, 1))  # to shift the world is most often the same at every estimate
        if not some.any():
            return
        D, E = np.ascontiguousarray(np.moveaxis(D[..., some], 0, -1)), _runs_last(E[:, some])
        S = _times(E, self._P[r])  # V = S + S E' D' / 2, and P + D V + V' D'
        half = 0.5 * _times(E, _at(S, r))
        V = S + _times(half.swapaxes(0, 1), D.swapaxes(0, 1))
        for i in np.flatnonzero(D.any((1, 2))):  # landmarks that no run has seen stay where they are
            P_i = _times(D[i][None], V)[0]
            self._P[i] += P_i
            self._P[:, i] += P_i

    def augment(self, r, runs, l, blocks, Q):
        """A new state l = g(x, noise) in some of the runs, in a range that is all zero there; see `filter.augment`.

            P_lm = L_x P,    P_ll = L_x P L_x' + Q

        Parameters
        ----------
        r : slice
            Range of the new state, of length k.
        runs : ndarray of int, shape (S,)
            Which runs get it.
        l : ndarray, shape (S, k)
            Means.
        blocks : sequence of (slice or None, ndarray of shape (k, j) or (S, k, j))
        Q : ndarray, shape (k, k) or (S, k, k)
        """
        blocks = [(r_x, _runs_last(J)) for r_x, J in blocks if r_x is not None]
        P_lm = _sum(_times(J, self._P[r_x, :, runs]) for r_x, J in blocks)
        P_ll = _sum(_times(J, _at(P_lm, r_x)) for r_x, J in blocks) + _broadcast(_runs_last(Q))

        self._x[r, runs] = np.transpose(l)
        self._P[r, :, runs] = P_lm
        self._P[:, r, runs] = P_lm.swapaxes(0, 1)
        self._P[r, r, runs] = _symmetric(P_ll)

    def _rows(self, r):
        """P[r, :] of all runs, shape (k, n, R)."""
        if isinstance(r, slice):
            return self._P[r]
        k, n, R = len(r), *self._x.shape
        return self._P[r[:, None, :], np.arange(n)[None, :, None], np.arange(R)].reshape(k, n, R)


def _subtract(P, W):
    """P = P - W W' in place; row i of the lower triangle is column i of the upper one."""
    D = np.empty_like(W)
    for i in range(len(P)):
        Di = np.multiply(W[:, i, None], W[:, : i + 1], out=D[:, : i + 1])
        for a in range(1, len(Di)):
            Di[0] += Di[a]
        P[i, : i + 1] -= Di[0]
        P[:i, i] = P[i, :i]


def _symmetric(P):
    return 0.5 * (P + P.swapaxes(0, 1))


def _times(J, rows):
    """J times rows of a matrix, in all runs: (m, k) or (m, k, R) times (k, n, R)."""
    if J.ndim == 2:
        return (J @ rows.reshape(len(rows), -1)).reshape(len(J), *rows.shape[1:])
    return _sum(J[:, i, None] * rows[i] for i in range(len(rows)))


def _sum(terms):
    terms = iter(terms)
    total = next(terms)
    for term in terms:
        total += term
    return total


def _runs_last(J):
    """(R, m, k) to (m, k, R); a matrix for all runs stays as it is."""
    return J if J.ndim == 2 else np.ascontiguousarray(np.moveaxis(J, 0, -1))


def _broadcast(A):
    """A matrix for all runs, (m, m), as (m, m, 1)."""
    return A[..., None] if A.ndim == 2 else A


def _index(r):
    """An array of indices (R, k) as (k, R)."""
    return r if isinstance(r, slice) else np.ascontiguousarray(np.transpose(r))


def _at(PHt, r):
    """(H P)' at the range r, from H P of shape (m, n, R): shape (k, m, R)."""
    if isinstance(r, slice):
        return PHt[:, r].swapaxes(0, 1)
    return np.take_along_axis(PHt, r[None], 1).swapaxes(0, 1)


@np.errstate(invalid="ignore", divide="ignore")
def _cholesky(Z):
    """L of Z = L L', shape (m, m, R); NaN where Z is not positive definite."""
    L = np.zeros_like(Z)
    for a in range(len(Z)):
        for b in range(a):
            L[a, b] = (Z[a, b] - (L[a, :b] * L[b, :b]).sum(0)) / L[b, b]
        L[a, a] = np.sqrt(Z[a, a] - (L[a, :a] ** 2).sum(0))
    return L


def _forward(L, B):
    """L^-1 B in all runs: (m, m, R) and (m, ..., R)."""
    X = np.empty_like(B)
    for a in range(len(B)):
        X[a] = B[a]
        for b in range(a):
            X[a] -= L[a, b] * X[b]
        X[a] /= L[a, a]
    return X
