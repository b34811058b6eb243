"""Covariances as curves: the k-sigma ellipse in the plane, three great circles of the ellipsoid in space."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

Array = np.ndarray


def half_axes(cov: Array) -> Array:
    """Return the half-axes of the 1-sigma ellipse or ellipsoid, as columns.

    The columns are ``A = V sqrt(D)`` of ``cov = V D V'``, so ``A A' = cov`` and the ellipse is ``A u`` for
    all unit vectors ``u``.

    Parameters
    ----------
    cov : (..., d, d)
        Covariance. It may be singular or zero: that axis has length 0. Eigenvalues that rounding has made
        negative count as 0. Where an entry is not finite, the result is NaN, which matplotlib does not draw.

    Returns
    -------
    (..., d, d)
        Half-axes, shortest first, in the units of the square root of `cov`.
    """
    cov = np.asarray(cov, dtype=float)
    finite = np.isfinite(cov).all(axis=(-2, -1), keepdims=True)
    D, V = np.linalg.eigh(np.where(finite, (cov + np.swapaxes(cov, -1, -2)) / 2, 0.0))
    A = V * np.sqrt(np.maximum(D, 0.0))[..., None, :]
    return np.where(finite, A, np.nan)


def ellipse_points(mean: Array, cov: Array, k: float = 3, n: int = 60) -> Array:
    """Return closed k-sigma ellipses: the points p with (p - mean)' inv(cov) (p - mean) = k^2.

    Parameters
    ----------
    mean : (..., 2)
        Centres. Leading axes broadcast against those of `cov`.
    cov : (..., 2, 2)
        Covariances; singular and zero ones give a segment and a point.
    k : float
        Number of sigmas. The ellipse holds 39.3, 86.5, 98.9 % of the probability for k = 1, 2, 3.
    n : int
        Number of points; the last one repeats the first.

    Returns
    -------
    (..., n, 2)
        Points, in the units of `mean`.
    """
    mean, A = np.asarray(mean, dtype=float), half_axes(cov)
    if mean.shape[-1:] != (2,) or A.shape[-2:] != (2, 2):
        raise ValueError(f"an ellipse needs mean (..., 2) and cov (..., 2, 2), got {mean.shape} and {A.shape}")
    a = np.linspace(0, 2 * np.pi, n)
    circle = np.stack([np.cos(a), np.sin(a)], axis=-1)  # (n, 2)
    return mean[..., None, :] + k * circle @ np.swapaxes(A, -1, -2)


def ellipsoid_wires(mean: Array, cov: Array, k: float = 3, n: int = 33) -> Array:
    """Return three closed curves for each k-sigma ellipsoid: the great circles through its principal axes.

    Parameters
    ----------
    mean : (..., 3)
        Centres. Leading axes broadcast against those of `cov`.
    cov : (..., 3, 3)
        Covariances, singular ones too.
    k : float
        Number of sigmas. The ellipsoid holds 19.9, 73.9, 97.1 % of the probability for k = 1, 2, 3.
    n : int
        Points of each curve; the last one repeats the first.

    Returns
    -------
    (..., 3, n, 3)
        Curve, point, coordinate.
    """
    mean, A = np.asarray(mean, dtype=float), half_axes(cov)
    if mean.shape[-1:] != (3,) or A.shape[-2:] != (3, 3):
        raise ValueError(f"an ellipsoid needs mean (..., 3) and cov (..., 3, 3), got {mean.shape} and {A.shape}")
    a = np.linspace(0, 2 * np.pi, n)
    c, s, o = np.cos(a), np.sin(a), np.zeros(n)
    circles = np.stack([np.stack([c, s, o], -1), np.stack([o, c, s], -1), np.stack([s, o, c], -1)])  # (3, n, 3)
    return mean[..., None, None, :] + k * circles @ np.swapaxes(A, -1, -2)[..., None, :, :]


def nan_separated(curves: Array) -> Array:
    """Join curves to one with a row of NaN after each: one artist draws them all.

    Parameters
    ----------
    curves : (..., n, d)
        Curves of n points.

    Returns
    -------
    (m, d)
        m is n + 1 times the number of curves.
    """
    curves = np.asarray(curves, dtype=float)
    d = curves.shape[-1]
    curves = curves.reshape(-1, curves.shape[-2], d)
    gap = np.full((len(curves), 1, d), np.nan)
    return np.concatenate([curves, gap], axis=1).reshape(-1, d)


def sigma_label(k: float, dim: int = 2) -> str:
    """Return the legend text of a k-sigma ellipse or ellipsoid, with the probability inside it.

    Parameters
    ----------
    k : float
        Number of sigmas.
    dim : int
        1, 2 or 3: interval, ellipse, ellipsoid. The probability is chi-square(dim) at k^2.
    """
    normal = math.erf(k / math.sqrt(2))
    name, inside = {
        1: ("interval", normal),
        2: ("ellipse", 1 - math.exp(-k * k / 2)),
        3: ("ellipsoid", normal - k * math.exp(-k * k / 2) * math.sqrt(2 / math.pi)),
    }[dim]
    return f"{k:g}σ {name} ({100 * inside:.1f} %)"


def plot_ellipse(ax: Axes, mean: Array, cov: Array, k: float = 3, n: int = 60, **style: Any) -> Line2D:
    """Draw one or many k-sigma ellipses as one line and return it.

    Parameters
    ----------
    ax : matplotlib Axes
    mean, cov : (..., 2), (..., 2, 2)
        As for `ellipse_points`.
    k : float
        Number of sigmas; say it in the legend with ``label=sigma_label(k)``.
    n : int
        Number of points of each ellipse.
    **style
        Anything ``ax.plot`` takes, or a style of the package (``**ESTIMATE``); markers are left out.
        A new covariance goes into the same line by ``line.set_data(*nan_separated(ellipse_points(...)).T)``.
    """
    style = {key: value for key, value in style.items() if key not in ("marker", "fillstyle")}
    return ax.plot(*nan_separated(ellipse_points(mean, cov, k, n)).T, **style)[0]
