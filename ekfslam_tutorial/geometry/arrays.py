"""Small arrays: constants, and closed forms that are written once for one vector and for a stack of vectors."""

import math
from functools import cache

import numpy as np

from .symbols import Symbol, Symbols

FLOAT = np.dtype(float)


def floats(x):
    """An array of floats; of symbols, if it is one (`symbols.py`)."""
    if isinstance(x, Symbol):
        return np.array(x, object).view(Symbols)
    return x if isinstance(x, Symbols) else np.asarray(x, float)


def blank(x, *shape):
    """An array for numbers like those of x, to be filled in."""
    return np.empty(shape) if x.dtype is FLOAT else np.empty(shape, x.dtype).view(type(x))


def zeros(x, *shape):
    """The same, filled with zeros."""
    return np.zeros(shape) if x.dtype is FLOAT else np.zeros(shape, x.dtype).view(type(x))


@cache
def identity(n):
    """Identity matrix of size n: one and the same for everybody, so it cannot be written to."""
    I = np.eye(n)
    I.flags.writeable = False
    return I


def product(A, B):
    """Product of two Jacobians, or stacks of them.

    The identity, which is one and the same object everywhere, costs nothing. Where B is a single matrix, `dot` on all
    rows is `@` in a fraction of the time.
    """
    if A is identity(A.shape[-1]):
        return B
    if B is identity(B.shape[-1]):
        return A
    if B.ndim > 2:
        return A @ B
    return A.dot(B) if A.ndim == 2 else A.reshape(-1, len(B)).dot(B).reshape(*A.shape[:-1], B.shape[1])


def numbers(x):
    """The numbers of a vector, to compute with: floats of a single one, arrays of a stack.

    Closed forms in the plane take a float a tenth of the time that they take an array of one number.
    """
    return x.tolist() if x.ndim == 1 else [x[..., i] for i in range(x.shape[-1])]


def cos_sin(a):
    """Cosine and sine of one of these numbers."""
    if isinstance(a, float) and math.isfinite(a):
        return math.cos(a), math.sin(a)
    return np.cos(a), np.sin(a)


def inverse(z):
    """1 / z of one of these numbers, infinite at zero."""
    if isinstance(z, float):
        return 1 / z if z else math.inf
    return 1 / z


def leading(x, y):
    """Leading shape of what is computed from two vectors, or stacks of them: () for two single vectors."""
    return () if x.ndim == y.ndim == 1 else np.broadcast_shapes(x.shape[:-1], y.shape[:-1])


def vector(lead, *entries):
    """The vector with these numbers; of a stack, shape (*lead, n), they are arrays, or the same for all."""
    try:
        return np.array(entries, float) if not lead else _filled(np.empty((*lead, len(entries))), entries)
    except TypeError:
        if not any(isinstance(entry, (Symbol, Symbols)) for entry in entries):
            raise
        return _filled(np.empty((*lead, len(entries)), object).view(Symbols), entries)


def _filled(out, entries):
    for i, entry in enumerate(entries):
        out[..., i] = entry
    return out


def matrix(lead, *rows):
    """The matrix with these rows of numbers, each a list, or a stack of matrices, shape (*lead, m, n)."""
    if not lead:
        try:
            return np.array(rows, float)
        except TypeError:
            pass  # symbols, or what `vector` will complain about
    return vector(lead, *sum(rows, [])).reshape(*lead, len(rows), -1)
