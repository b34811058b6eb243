"""How far states depend on the active ones, for the compressed filter: the matrix G of b = b_0 + G v.

Each state that becomes active has a virtual one. With A for those states, and P_0 for the covariance as it was last
settled, all that is asked of G and of L, the covariance of A with v at the beginning, is

    P_0[b, A] = G_b L'.

So any L with an inverse will do. The Cholesky factor of P_0[A, A] makes v white, and no number in G is larger than a
standard deviation; but a state that is a function of others has no inverse. So L is the factor of P_0[A, A] with the
variances a little larger: `FLOOR`. (To leave out the virtual state of what is a function of others is no way out: what
rounding has left of its variance is then noise that no other state knows of, and grows each time all is settled.)
G itself is worked out where it is needed only; kept are the rows P_0[A, :] and the small L.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg.blas import dtrsm  # pyright: ignore[reportAttributeAccessIssue]
from scipy.linalg.lapack import dpotrf, dpstrf, dtrtrs  # pyright: ignore[reportAttributeAccessIssue]

from .extra import compiled
from .smallness import EXPLAINED, FLOOR, STILL, TINY, TRIALS
from .storage import LINE, aligned, by_lines, whole


class VirtualStates:
    """Virtual states: as many as there are active states that were far.

    Parameters
    ----------
    n : int
        Extent of the map.
    compiled : bool
        As in `Map`.

    Attributes
    ----------
    size : int
        How many virtual states there are.
    """

    def __init__(self, n, compiled=False):
        self.compiled = compiled
        self._P = self._scratch = aligned(0, 0)  # nothing was ever written right of the extent of P
        self.clear()
        self.extend(n)

    def clear(self):
        """None of them; the arrays stay."""
        self.size, self._L = 0, np.zeros((0, 0), order="F")

    def extend(self, n):
        """Let there be room for a map of this extent."""
        rows, old = self._P.shape
        P = aligned(rows, whole(n))
        P[: self.size, :old] = self._P[: self.size]
        self._P = P

    def add(self, i, P_i, P_ii):
        """States become active, each with a virtual one.

        Parameters
        ----------
        i : ndarray of int, shape (k,)
        P_i, P_ii : ndarray, shape (k, n) and (k, k)
            P_0[i, :] and P_0[i, i].

        Returns
        -------
        ndarray, shape (k, size)
            G_i, the columns of the new virtual states included: the new rows of L.
        """
        old = self.size
        G_i = compiled().explained(self, i, P_ii) if self.compiled else self._explained(i, P_ii)
        self.size = size = old + len(i)
        L = np.zeros((size, size), order="F")
        L[:old, :old], L[old:] = self._L, G_i
        self._L = L
        if size > len(self._P):
            P = aligned(2 * size, self._P.shape[1])
            P[:old] = self._P[:old]
            self._P = P
        self._P[old:size, : P_i.shape[1]] = P_i
        return G_i

    def _explained(self, i, P_ii):
        """G_i, as `add` returns it."""
        G_i = self.of(i)
        return np.concatenate([G_i, triangle(P_ii - G_i.dot(G_i.T), P_ii.diagonal())], axis=1)

    def of(self, i):
        """G of some states, given by their indices (k,): shape (k, size)."""
        return dtrtrs(self._L, self._P[: self.size, i], lower=1)[0].T if self.size else np.zeros((len(i), 0))

    def through(self, B, n):
        """B G' of the whole map of extent n, for B of shape (k, size): shape (k, n)."""
        if not self.size:
            return np.zeros((len(B), n))
        return dtrsm(1.0, self._L, B, side=1, lower=1) @ self._P[: self.size, :n]

    def scratch(self, k):
        """Room for k rows as long as those of P_0[A, :] and a line: whatever was in it last."""
        n = self._P.shape[1] + LINE
        if self._scratch.shape[1] != n or len(self._scratch) < k:
            self._scratch = by_lines(np.empty(2 * k * n + LINE), 2 * k, n)
        return self._scratch

    @property
    def factors(self):
        """L', row-major, and P_0[A, :] whose first rows count: G' = L^-1 P_0[A, :]."""
        return self._L.T, self._P

    def times(self, v, n):
        """G v of the whole map, shape (n,)."""
        return dtrtrs(self._L, v, lower=1, trans=1)[0] @ self._P[: self.size, :n] if self.size else np.zeros(n)

    def forget(self, r):
        """The states of range r do not depend on anything any more."""
        self._P[:, r] = 0.0


def triangle(P, variances):
    """The lower triangle C with C C' = P + D, where D is positive, and as small as `FLOOR` allows.

    Parameters
    ----------
    P : ndarray, shape (k, k)
        What is left of a covariance, given other states.
    variances : ndarray, shape (k,)
        Those of the same states before.

    Returns
    -------
    ndarray, shape (k, k)
    """
    D = FLOOR * np.maximum(variances, STILL * (variances.max(initial=0.0) or 1.0))
    for _ in range(TRIALS):
        C, bad = dpotrf(P + np.diag(D), lower=1)
        if not bad:
            break
        D = 100 * D
    return C


def cholesky(P):
    """C with C C' = P, for a covariance that may be singular: as many columns as there is information.

    Parameters
    ----------
    P : ndarray, shape (k, k)

    Returns
    -------
    C : ndarray, shape (k, rank)
    first : ndarray of int, shape (rank,)
        The rows in which C is lower triangular.
    """
    s = np.sqrt(np.maximum(P.diagonal(), TINY))[:, None]
    L, order, rank, _ = dpstrf(P / (s * s.T), tol=EXPLAINED, lower=1)
    order -= 1
    C = np.empty((len(P), rank))
    C[order] = L[:, :rank] * _lower(len(P), rank)
    return s * C, order[:rank]


_lower = lru_cache(maxsize=256)(np.tri)
