"""Small constant arrays."""

from functools import cache

import numpy as np


@cache
def identity(n):
    """Identity matrix of size n: one and the same for everybody, so it cannot be written to."""
    I = np.eye(n)
    I.flags.writeable = False
    return I
