"""Numbers of a state log: millimetres and tenths of a milliradian as integers, covariances as triangular factors.

A covariance P is written as ``[e, L11, L21, L22, ...]``: the lower triangle of ``L`` with ``L L' = P``, row by row, in
units of ``10**e`` metres. Three digits of the largest entry are kept, whatever its size is, so that an ellipse of
1 cm is drawn as well as one of 10 m; and what is read back is a covariance, whatever rounding did.
"""

from __future__ import annotations

import math

import numpy as np

from ..ellipses import half_axes

Array = np.ndarray

METRE, RADIAN = 0.001, 0.0001
"""What the integer 1 stands for: in a position, m; in a heading (rad) or an entry of a quaternion."""

FAR = 1e6
"""Nothing further away, and no standard deviation greater than that, can be shown, m."""


def lower_factor(P: Array) -> Array:
    """Return lower triangular L with ``L L' = P`` and no negative diagonal entry.

    Parameters
    ----------
    P : (..., d, d)
        Covariances. Singular ones too, unlike a Cholesky factorisation; NaN gives NaN.

    Returns
    -------
    (..., d, d)
        From ``P = A A'`` (`half_axes`) and ``A' = Q R``: ``P = R' R``.
    """
    A = half_axes(P)
    bad = ~np.isfinite(A).all(axis=(-2, -1), keepdims=True)
    R = np.linalg.qr(np.where(bad, 0.0, np.swapaxes(A, -1, -2)))[1]
    signs = np.where(np.diagonal(R, axis1=-2, axis2=-1) < 0, -1.0, 1.0)
    return np.where(bad, np.nan, np.swapaxes(R * signs[..., None], -1, -2))


def pack_factor(L: Array) -> list[int]:
    """Return ``[e, L11, L21, L22, ...]``, or nothing at all if the factor cannot be shown."""
    low = L[np.tril_indices(len(L))]
    if not (np.isfinite(low).all() and np.abs(low).max() < FAR):
        return []
    largest = np.abs(low).max()
    e = math.frexp(largest)[1] - 7 if largest > 1e-9 else 0
    return [e, *np.rint(low / 2.0**e).astype(int).tolist()]


def unpack_factor(record: list[int], d: int) -> Array:
    """Return L (d, d) from what `pack_factor` wrote; NaN where nothing was written."""
    L = np.full((d, d), np.nan) if not record else np.zeros((d, d))
    if record:
        L[np.tril_indices(d)] = np.array(record[1:], dtype=float) * 2.0 ** record[0]
    return L


def units_of(n: int, d: int) -> Array:
    """Return the units of the first n numbers of a pose: d metres, then radians or a quaternion."""
    return np.where(np.arange(n) < d, METRE, RADIAN)


def pack(x: Array, d: int) -> list[int]:
    """Return a point or a pose as integers, or nothing at all if it has no place."""
    x = np.asarray(x, dtype=float)
    if not (np.isfinite(x).all() and np.abs(x).max() < FAR):
        return []
    return np.rint(x / units_of(len(x), d)).astype(int).tolist()


def unpack(record: list[int], n: int, d: int) -> Array:
    """Return the n numbers that `pack` wrote; NaN where nothing was written."""
    return np.array(record, dtype=float) * units_of(n, d) if record else np.full(n, np.nan)


def short(value: float) -> float | int | None:
    """Return a number with three digits for JSON; None where it is not finite."""
    value = float(value)
    if not math.isfinite(value):
        return None
    value = float(f"{value:.2g}")
    return int(value) if value == int(value) and abs(value) < 1e15 else value


def hundredths(value: float) -> int | None:
    """Return a number as an integer in hundredths; None where it is not finite, or too large to mean anything."""
    value = float(value)
    return round(100 * value) if abs(value) < FAR else None
