"""What counts as a number, and what as a covariance: symmetric, positive semi-definite, finite."""

import numpy as np

TINY = 1e-8  # of the largest number: asymmetry, and eigenvalues below zero, that rounding explains


def real(name, a):
    """Return an array of floats, or refuse what numpy would silently read as something else.

    Parameters
    ----------
    name : str
        What it is called in the sentence.
    a : array_like
        Of real numbers. Of complex ones numpy would drop a part, of masked ones the mask, and an array of objects may
        hold anything.

    Raises
    ------
    ValueError
        Saying what was got.
    """
    if np.ma.is_masked(a):
        raise ValueError(f"{name} must not have masked entries: leave out what is not known")
    try:
        array = np.asarray(a)
    except ValueError as error:
        raise ValueError(f"{name} must be real numbers, got rows of different lengths") from error
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name} must be real numbers, got {'None' if a is None else array.dtype}")
    return array.astype(float, copy=False)


def real_blocks(blocks):
    """Return blocks, pairs of a range and a Jacobian, with Jacobians of floats; others are refused as by `real`."""
    return [(r, real("a Jacobian", J)) for r, J in blocks]


def faults(P):
    """Return what keeps finite square matrices from being covariances.

    Parameters
    ----------
    P : ndarray, shape (..., n, n)

    Returns
    -------
    skew, negative : ndarray of bool, shape (...)
        Where a matrix is not symmetric; where it has an eigenvalue below zero. Rounding is no fault.
    """
    tiny = TINY * np.abs(P).max((-2, -1), initial=0.0)
    skew = np.abs(P - np.swapaxes(P, -2, -1)).max((-2, -1), initial=0.0) > tiny
    return skew, np.linalg.eigvalsh(P).min(-1, initial=0.0) < -tiny


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
    faults : The same for many matrices at once.
    """
    P = real(name, P)
    if P.shape != (n, n):
        raise ValueError(f"{name} must have shape {(n, n)}, got {P.shape}")
    if not np.isfinite(P).all():
        raise ValueError(f"{name} must be finite, got {P.tolist()}")
    skew, negative = faults(P)
    if skew:
        raise ValueError(f"{name} must be symmetric, got {P.tolist()}")
    if negative:
        smallest = np.linalg.eigvalsh(P).min()
        raise ValueError(f"{name} must be positive semi-definite, its smallest eigenvalue is {smallest:.3g}")
