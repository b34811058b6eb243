"""What a covariance is: symmetric, positive semi-definite, finite."""

import numpy as np

TINY = 1e-8  # of the largest number: asymmetry, and eigenvalues below zero, that rounding explains


def check_covariance(P, n, name="P"):
    """Refuse what is not a covariance of n numbers.

    Parameters
    ----------
    P : array_like, shape (n, n)
    n : int
    name : str
        What it is called in the sentence.

    Raises
    ------
    ValueError
        Saying what was got.

    See Also
    --------
    is_covariance : The same as a question.
    """
    P = np.asarray(P, float)
    if P.shape != (n, n):
        raise ValueError(f"{name} must have shape {(n, n)}, got {P.shape}")
    if not np.isfinite(P).all():
        raise ValueError(f"{name} must be finite, got {P.tolist()}")
    tiny = TINY * np.abs(P).max(initial=0.0)
    if np.abs(P - P.T).max(initial=0.0) > tiny:
        raise ValueError(f"{name} must be symmetric, got {P.tolist()}")
    smallest = np.linalg.eigvalsh(P).min(initial=0.0)
    if smallest < -tiny:
        raise ValueError(f"{name} must be positive semi-definite, its smallest eigenvalue is {smallest:.3g}")


def is_covariance(P):
    """Return True if P, a square matrix, is what `check_covariance` accepts."""
    try:
        check_covariance(P, len(P))
    except ValueError:
        return False
    return True
