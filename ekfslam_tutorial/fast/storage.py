"""Arrays as the wing keeps them: rows that begin with a line of the cache, and do not evict each other from it."""

import numpy as np

LINE = 8  # numbers in a line of the cache
WIDTH = 4 * LINE  # numbers of a row that compiled code takes at a time


def roomy(n):
    """Return a size of storage that holds n states, by which columns of P do not evict each other from the cache.

    They do if they are a power of two apart, or nearly so. So a column has 3 lines more than a multiple of 8 lines.
    """
    lines = -(-n // LINE)
    return LINE * (lines + (3 - lines) % 8)


def whole(n):
    """Return a number of columns for n numbers, by which a row of a matrix is whole pieces of WIDTH."""
    return -(-n // WIDTH) * WIDTH


def aligned(m, n):
    """Return zeros of shape (m, n); the first row begins with a line of the cache, and so do all if n is whole lines.

    Let it be an odd number of lines, then rows do not evict each other: see `roomy`.
    """
    return by_lines(np.zeros(m * n + LINE), m, n)


def by_lines(numbers, m, n):
    """Return an array of shape (m, n) among m n + LINE numbers or more, which begins with a line of the cache."""
    first = -(numbers.ctypes.data // numbers.itemsize) % LINE
    return numbers[first : first + m * n].reshape(m, n)


def square(n, zeros=True):
    """Return zeros of shape (n, n), or anything, column-major, as `aligned`."""
    return by_lines((np.zeros if zeros else np.empty)(n * n + LINE), n, n).T


def symmetric(P):
    """Return a covariance without the rounding errors that make A P A' differ from its transpose."""
    S = P + P.T
    S *= 0.5
    return S


def nothing(blocks, n):
    """Return Jacobian and rows that stand for blocks of known states only: their product is zero."""
    return np.zeros((blocks[0][1][..., 0].size, 0)), np.zeros((0, n))
