"""How far states depend on those at hand, for the compressed filter: the matrix G of b = b_0 + G v.

Of the covariance P_0 as it was last put back, G holds the Cholesky factor, column after column, in the order in which
states came to hand: P_0[b, A] = G_b L' with L = G_A. So v is white at the beginning, no number in G is larger than a
standard deviation, and a state that is a function of others needs no virtual state of its own. G itself is worked out
where it is needed only; kept are the rows P_0[A, :] and the small L.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg.blas import dtrsm  # pyright: ignore[reportAttributeAccessIssue]
from scipy.linalg.lapack import dpstrf, dtrtrs  # pyright: ignore[reportAttributeAccessIssue]

from .extra import compiled

EXPLAINED = 4e-15
"""A state of which no more than this share of its variance is left, given the others, is a function of them."""

TINY = 1e-200


class VirtualStates:
    """As many as there are independent states at hand that came from far.

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
        self._P = np.zeros((0, n))  # nothing was ever written right of the extent
        self.clear()

    def clear(self):
        """None of them; the arrays stay."""
        self.size, self._L = 0, np.zeros((0, 0), order="F")

    def reach(self, n):
        """Let there be room for a map of this extent."""
        rows, old = self._P.shape
        P = np.zeros((rows, n))
        P[:, :old] = self._P
        self._P = P

    def take(self, i, P_i, P_ii):
        """States come to hand: more virtual ones for what these do not yet explain.

        Parameters
        ----------
        i : ndarray of int, shape (k,)
        P_i, P_ii : ndarray, shape (k, n) and (k, k)
            P_0[i, :] and P_0[i, i].

        Returns
        -------
        ndarray, shape (k, size)
            G_i, the columns of the new virtual states included.
        """
        old = self.size
        G_i, first = compiled().explained(self, i, P_ii) if self.compiled else self._explained(i, P_ii)
        self.size = size = old + len(first)
        L = np.zeros((size, size), order="F")
        L[:old, :old], L[old:] = self._L, G_i[first]
        self._L = L
        if size > len(self._P):
            P = np.zeros((2 * size, self._P.shape[1]))
            P[:old] = self._P[:old]
            self._P = P
        self._P[old:size, : P_i.shape[1]] = P_i[first]
        return G_i

    def _explained(self, i, P_ii):
        """G_i, as `take` returns it, and those of the states that get a virtual one each."""
        G_i = self.of(i)
        C, first = cholesky(P_ii - G_i.dot(G_i.T), P_ii.diagonal())
        return np.concatenate([G_i, C], axis=1), first

    def of(self, i):
        """G of some states, given by their indices (k,): shape (k, size)."""
        return dtrtrs(self._L, self._P[: self.size, i], lower=1)[0].T if self.size else np.zeros((len(i), 0))

    def all(self, n):
        """G' of the whole map of extent n, shape (size, n)."""
        if not self.size:
            return np.zeros((0, n))
        return dtrsm(1.0, self._L, self._P[: self.size, :n].T, side=1, lower=1, trans_a=1).T

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


def cholesky(P, scale=None):
    """C with C C' = P, for a covariance that may be singular: as many columns as there is information.

    Parameters
    ----------
    P : ndarray, shape (k, k)
    scale : ndarray, shape (k,), optional
        Variances beside which those that are left over in the end count as zero; the diagonal of P if not given.

    Returns
    -------
    C : ndarray, shape (k, rank)
    first : ndarray of int, shape (rank,)
        The rows in which C is lower triangular.
    """
    s = np.sqrt(np.maximum(P.diagonal() if scale is None else scale, TINY))[:, None]
    L, order, rank, _ = dpstrf(P / (s * s.T), tol=EXPLAINED, lower=1)
    order -= 1
    C = np.empty((len(P), rank))
    C[order] = L[:, :rank] * _lower(len(P), rank)
    return s * C, order[:rank]


_lower = lru_cache(maxsize=256)(np.tri)
