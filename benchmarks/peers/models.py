"""Range and bearing of several landmarks at once, in numpy: as a user writes them who stacks all that one step brings.

`at` (m,) says where in the state each landmark begins.
"""

from functools import cache

import numpy as np

from ..world import R, wrap


def expected(x, at):
    """Ranges and bearings in turn, shape (2 m,)."""
    dx, dy = x[at] - x[0], x[at + 1] - x[1]
    e = np.empty(2 * len(at))
    e[0::2] = np.sqrt(dx * dx + dy * dy)
    e[1::2] = wrap(np.arctan2(dy, dx) - x[2])
    return e


def jacobian(x, at):
    """Their dense Jacobian, shape (2 m, n)."""
    dx, dy = x[at] - x[0], x[at + 1] - x[1]
    q = dx * dx + dy * dy
    r = np.sqrt(q)
    H, rows = np.zeros((2 * len(at), len(x))), 2 * np.arange(len(at))
    H[0::2, 0], H[0::2, 1] = -dx / r, -dy / r
    H[1::2, 0], H[1::2, 1], H[1::2, 2] = dy / q, -dx / q, -1.0
    H[rows, at], H[rows, at + 1] = dx / r, dy / r
    H[rows + 1, at], H[rows + 1, at + 1] = -dy / q, dx / q
    return H


def residual(y, e):
    """Innovation with the bearings wrapped."""
    z = y - e
    z[1::2] = wrap(z[1::2])
    return z


@cache
def noise(m):
    """R of m measurements, shape (2 m, 2 m)."""
    return np.kron(np.eye(m), R)
