"""A correction by one number after the other: what the answers to notebooks 15 and 18 share."""

import numpy as np


def whole_jacobian(n, m, blocks):
    """Return the Jacobian by all `n` states, from its blocks."""
    H = np.zeros((m, n))
    for r, E in blocks:
        if r is not None:
            H[:, r] = E
    return H


def correct_by_numbers(x, P, H, z, R):
    """Return the corrected state and covariance: the noise is made independent first."""
    W = np.linalg.inv(np.linalg.cholesky(R))
    dx = np.zeros(len(x))
    for h, v in zip(W @ H, W @ z, strict=True):
        k = P @ h / (h @ P @ h + 1)
        dx, P = dx + k * (v - h @ dx), P - np.outer(k, h @ P)
    return x + dx, (P + P.T) / 2
