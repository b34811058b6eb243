"""A large covariance of which only the lower triangle is kept up to date: half the work, half the memory traffic.

The matrix is column-major, so that what stands below the diagonal in one column stands together in memory.
"""

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
