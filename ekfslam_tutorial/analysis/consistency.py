"""Does a filter know how wrong it is? NEES, NIS, and the chi-square bands they should stay in.

The terms are those of Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and
Navigation", Wiley 2001, section 5.4.
"""

from dataclasses import dataclass

import numpy as np

from ..ekf import chi_square

SINGULAR = 1e-12
"""A correlation matrix with an eigenvalue below this counts as singular."""


def md2(e, P):
    """Squared Mahalanobis distance e' P^-1 e.

    Parameters
    ----------
    e : array_like, shape (..., n)
    P : array_like, shape (..., n, n)
        Covariance of e. Leading axes broadcast.

    Returns
    -------
    ndarray, shape (...)
        NaN where P is not positive definite or not finite: there is no such distance then.
    """
    e, P = np.asarray(e, float), np.asarray(P, float)
    lead, n = np.broadcast_shapes(e.shape[:-1], P.shape[:-2]), e.shape[-1]
    if P.shape[-2:] != (n, n):
        raise ValueError(f"an error of {n} numbers needs a covariance of shape {(n, n)}, got {P.shape[-2:]}")
    e, P = np.broadcast_to(e, (*lead, n)), np.broadcast_to(P, (*lead, n, n))
    with np.errstate(invalid="ignore", divide="ignore"):
        std = np.sqrt(np.diagonal(P, axis1=-2, axis2=-1))  # the units differ (m, rad): judge the correlations
        w, C = e / std, P / (std[..., :, None] * std[..., None, :])
    usable = np.asarray(np.isfinite(w).all(-1) & np.isfinite(C).all((-1, -2)))
    C = np.where(usable[..., None, None], C, np.eye(n))
    usable &= np.linalg.eigvalsh(C)[..., 0] > SINGULAR
    C = np.where(usable[..., None, None], C, np.eye(n))
    return np.where(usable, (w * np.linalg.solve(C, w[..., None])[..., 0]).sum(-1), np.nan)


def nees(estimate, P, truth):
    """Normalised estimation error squared of poses, in the tangent space: 3 degrees of freedom in 2D, 6 in 3D.

    A 7 x 7 covariance of [t; q] is singular along q, so the error is taken as e = estimate.minus(truth), with the
    covariance E P E'.

    Parameters
    ----------
    estimate, truth : Frame2 or Frame3
        One pose or many, `x` of shape (..., 3) or (..., 7).
    P : ndarray, shape (..., 3, 3) or (..., 7, 7)
        Covariance of the state vector of `estimate`.

    Returns
    -------
    ndarray, shape (...)
        Its mean over honest runs is `estimate.dof`. NaN where the covariance is singular or the truth unknown.
    """
    e, E_f = estimate.minus(truth)
    return md2(e, E_f @ P @ np.swapaxes(E_f, -1, -2))


def nis(z, Z):
    """Normalised innovation squared, z' Z^-1 z; its mean over an honest run is the size of z.

    Needs no truth. It can look perfect while the map is wrong: only NEES shows a missing cross-covariance.

    Parameters
    ----------
    z : array_like, shape (..., m)
    Z : array_like, shape (..., m, m)
    """
    return md2(z, Z)


def chi2_band(dof, confidence=0.95):
    """Lower and upper bound that a chi-square number of `dof` degrees of freedom stays in with this probability.

    Returns
    -------
    low, high : float
        The same probability is left out below and above.
    """
    if not 0 < confidence < 1:
        raise ValueError(f"confidence is a probability between 0 and 1, got {confidence}")
    low, high = chi_square.quantile(np.array([1 - confidence, 1 + confidence]) / 2, dof)
    return float(low), float(high)


def anees_band(dof, runs, confidence=0.95):
    """Band for the average NEES (or NIS) of several independent runs.

    The sum of N such numbers is chi-square with N dof degrees of freedom; the band is that of the sum, over N.

    Parameters
    ----------
    dof : float
        Of one number: 3 for a pose in the plane, 6 in space, the size of z for NIS.
    runs : int
        How many independent numbers are averaged. Frames of one run are not independent.
    confidence : float

    Returns
    -------
    low, high : float

    Examples
    --------
    >>> [round(b, 2) for b in anees_band(3, 20)]
    [2.02, 4.16]
    """
    low, high = chi2_band(runs * dof, confidence)
    return low / runs, high / runs


def coverage(k, dof):
    """Probability that the k-sigma ellipse of a Gaussian in `dof` dimensions contains the truth.

    Examples
    --------
    >>> [round(float(coverage(3, n)), 3) for n in (1, 2, 3)]
    [0.997, 0.989, 0.971]
    """
    return chi_square.cdf(np.square(k), dof)


def k_sigma(probability, dof):
    """The k for which the k-sigma ellipse contains the truth with this probability: the inverse of `coverage`."""
    return np.sqrt(chi_square.quantile(probability, dof))


@dataclass(frozen=True)
class Honesty:
    """The honesty meter: five numbers that together tell whether to believe a filter.

    Parameters
    ----------
    rmse : float
        Of the position, m.
    nees, nis : float
        Means over all numbers there are; NaN if there are none.
    nees_band, nis_band : (float, float)
        Where they should be.
    asymmetry : float
        Largest |P - P'|, relative to the largest entry of P.
    smallest : float
        Smallest eigenvalue of P, relative to the largest; below zero P is no covariance.
    """

    rmse: float
    nees: float
    nees_band: tuple
    nis: float
    nis_band: tuple
    asymmetry: float
    smallest: float

    def verdicts(self):
        """Say what each number says, in words."""
        return {
            "nees": _judge(self.nees, self.nees_band),
            "nis": _judge(self.nis, self.nis_band),
            "symmetric": "yes" if self.asymmetry <= ROUNDING else "no",
            "psd": "yes" if self.smallest >= -ROUNDING else "no",
        }

    @property
    def honest(self):
        """True if nothing speaks against the filter; what is not known does not."""
        return not {"over-confident", "too cautious", "no"} & set(self.verdicts().values())

    def __repr__(self):
        says = self.verdicts()
        rows = [("NEES", self.nees, self.nees_band, says["nees"]), ("NIS", self.nis, self.nis_band, says["nis"])]
        return "\n".join(
            [
                f"RMSE    {self.rmse:.3f} m",
                *(f"{name:<8}{mean:.2f}, wanted {b[0]:.2f} to {b[1]:.2f}: {word}" for name, mean, b, word in rows),
                f"P = P'  {says['symmetric']} (largest difference {self.asymmetry:.0e} of the largest entry)",
                f"P >= 0  {says['psd']} (smallest eigenvalue {self.smallest:.0e} of the largest)",
            ]
        )


ROUNDING = 1e-9
"""Relative asymmetry, or negative eigenvalue, that rounding alone may cause."""


def honesty(e, P, nis=(), nis_dof=2.0, dim=2, map_P=None, runs=None, confidence=0.999):
    """Read the honesty meter.

    Parameters
    ----------
    e : ndarray, shape (N, n)
        Errors, estimate minus truth, of N runs or frames: of points or poses, positions first.
    P : ndarray, shape (N, n, n)
        Their covariances, as the filter has them.
    nis : array_like, shape (K,)
        Squared Mahalanobis distances of innovations.
    nis_dof : float
        Size of an innovation; the mean size, if they differ.
    dim : int
        How many of the n numbers are the position.
    map_P : ndarray, shape (m, m), optional
        Covariance of the whole map, to be checked for symmetry and sign; all of `P` if not given.
    runs : int, optional
        How many of the N errors are independent of each other; all N if not given. The frames of one run are not.
    confidence : float
        Of the bands.

    Returns
    -------
    Honesty
    """
    e, P, nis = np.asarray(e, float), np.asarray(P, float), np.asarray(nis, float)
    if e.ndim != 2 or P.shape != (*e.shape, e.shape[1]):
        raise ValueError(f"errors of shape (N, n) need covariances of shape (N, n, n), got {e.shape} and {P.shape}")
    n = e.shape[1]
    squared = md2(e, P)
    covs = P if map_P is None else np.asarray(map_P, float)[None]
    scale = np.abs(covs).max((-1, -2), initial=0.0).clip(1e-300)
    eigenvalues = np.linalg.eigvalsh((covs + np.swapaxes(covs, -1, -2)) / 2)
    return Honesty(
        rmse=float(np.sqrt(np.nanmean((e[:, :dim] ** 2).sum(-1)))),
        nees=_mean(squared),
        nees_band=anees_band(n, runs or max(np.isfinite(squared).sum(), 1), confidence),
        nis=_mean(nis),
        nis_band=anees_band(nis_dof, max(np.isfinite(nis).sum(), 1), confidence),
        asymmetry=float((np.abs(covs - np.swapaxes(covs, -1, -2)).max((-1, -2)) / scale).max()),
        smallest=float((eigenvalues[..., 0] / np.abs(eigenvalues).max(-1).clip(1e-300)).min()),
    )


def _mean(a):
    a = a[np.isfinite(a)]
    return float(a.mean()) if a.size else float("nan")


def _judge(mean, band):
    if not np.isfinite(mean):
        return "not known"
    return "over-confident" if mean > band[1] else "too cautious" if mean < band[0] else "as it should be"
