"""A large covariance of which only the lower triangle is kept up to date: half the work, half the memory traffic.

The matrix is column-major, so that what stands below the diagonal in one column stands together in memory.
"""

from functools import cache

import numpy as np

BLOCK = 64  # columns mirrored at a time: what is read and what is written both stay in the cache


def mirror(P):
    """Copy the lower triangle of P to the upper one, in place."""
    n = len(P)
    for j in range(0, n, BLOCK):
        k = min(j + BLOCK, n)
        D = P[j:k, j:k]
        D[:] = np.tril(D) + np.tril(D, -1).T
        P[j:k, k:] = P[k:, j:k].T


def whole_rows(P, indices):
    """Some rows of the symmetric matrix of which P holds the lower triangle, shape (len(indices), n)."""
    rows = np.empty((len(indices), len(P)))
    for i, row in zip(indices, rows, strict=True):
        row[:i] = P[i, :i]
        row[i:] = P[i:, i]
    return rows


def whole_range(P, r):
    """The same for rows that stand together, those of the slice r, shape (k, n)."""
    rows = np.empty((r.stop - r.start, len(P)))
    rows[:, : r.start] = P[r, : r.start]
    rows[:, r.start :] = P[r.start :, r].T
    i, j = below(len(rows))
    here = rows[:, r]  # what is right of its diagonal counts
    here[i, j] = here[j, i]
    return rows


below = cache(lambda n: np.tril_indices(n, -1))
