"""Estimated positions beside those of a satellite receiver, which is no truth: it wanders, jumps, and has gaps."""

import numpy as np

from ..geometry import align

BEST = 0.95
"""Share of the fixes that are compared; the worst ones are jumps of the receiver, up to 100 m and more."""


def fix_errors(t, positions, fixes, F=None):
    """Distance of each fix from the estimated path at its time.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times of the estimates, s, rising.
    positions : ndarray, shape (n, d)
        Estimated positions, m: of the point of the robot that the receiver stands for.
    fixes : ndarray, shape (g, 1 + d)
        Time and position. Those before the first and after the last estimate are left out.
    F : Frame2 or Frame3, optional
        Alignment of the path, from `fix_alignment`.

    Returns
    -------
    ndarray, shape (k,)
        m. The path is straight between two estimates.
    """
    p, q = _pairs(t, positions, fixes)
    return np.linalg.norm((p if F is None else F.from_frame(p)[0]) - q, axis=1)


def fix_alignment(t, positions, fixes, best=BEST):
    """The rigid motion of the path that fits the best fixes: least squares over those that were nearest so far.

    Parameters as for `fix_errors`; `best` is the share of the fixes to use.

    Returns
    -------
    Frame2 or Frame3

    Raises
    ------
    ValueError
        If the fixes are too few.
    """
    p, q = _pairs(t, positions, fixes)
    use = np.ones(len(p), bool)
    for _ in range(10):
        F = align(p[use], q[use])
        errors = np.linalg.norm(F.from_frame(p)[0] - q, axis=1)
        use = errors <= np.quantile(errors, best)
    return F


def fix_figures(tracks, fixes):
    """The figures that `result.json` has of runs with GPS.

    Parameters
    ----------
    tracks : iterable of Track
    fixes : dict of int to ndarray, shape (g, 1 + d)
        By robot id.

    Returns
    -------
    dict
        gps_n fixes, gps_rmse_m of all, gps_rmse_best95_m of the nearest 95 %, gps_median_m of all: path and fixes as
        they are, in the frame of the map. gps_rmse_best95_aligned_m: the same after `fix_alignment`; what of the error
        is not due to the start. None where there are too few.
    """
    tracks = [track for track in tracks if track.id in fixes]
    plain, aligned = [np.zeros(0)], [np.zeros(0)]
    for track in tracks:
        args = track.t, track.x[:, : track.frame.dim], fixes[track.id]
        plain.append(fix_errors(*args))
        try:
            aligned.append(fix_errors(*args, fix_alignment(*args)))
        except ValueError:  # too few fixes to align
            continue
    errors, aligned = np.concatenate(plain), np.concatenate(aligned)
    return {
        "gps_n": len(errors),
        "gps_rmse_m": _rms(errors),
        "gps_rmse_best95_m": _rms(_nearest(errors)),
        "gps_median_m": float(np.median(errors)) if len(errors) else None,
        "gps_rmse_best95_aligned_m": _rms(_nearest(aligned)),
    }


def _pairs(t, positions, fixes):
    """Estimated positions at the times of the fixes, and the fixes, as far as there are both."""
    at = (fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])
    return np.column_stack([np.interp(fixes[at, 0], t, p) for p in positions.T]), fixes[at, 1:]


def _nearest(errors):
    return np.sort(errors)[: int(BEST * len(errors))]


def _rms(errors):
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else None
