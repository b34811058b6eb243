"""The rigid motion that brings one set of points onto another.

A SLAM map is right only up to the frame in which the robot started: moved and turned as a whole it explains every
measurement as well (the gauge). Where that frame is not known, a map is compared with the truth after alignment.
"""

import numpy as np

from .frames import Frame2, Frame3
from .quaternions import R2q


def align(points, targets, weights=None):
    """Least-squares rigid motion between pairs of points: min over F of sum w_i |targets_i - F.from_frame(points_i)|^2.

    Rotation and translation, no scale: U diag(1, .., det) V' of the singular values of the cross-covariance.
    K. S. Arun, T. S. Huang, S. D. Blostein, IEEE Trans. PAMI 9(5):698-700, 1987; the sign of the determinant as in
    S. Umeyama, IEEE Trans. PAMI 13(4):376-380, 1991, eqs. 40-42.

    Parameters
    ----------
    points, targets : ndarray, shape (n, d)
        d = 2 or 3. Landmarks of a map and their surveyed places, or positions on two trajectories; metres.
    weights : array_like, shape (n,), optional
        What each pair counts; all the same if not given. One over its variance is best.

    Returns
    -------
    Frame2 or Frame3
        The frame F of the points, seen from the targets: `F.from_frame(p)` aligns a point, `F.compose(pose)` a pose.

    Raises
    ------
    ValueError
        When the shapes differ, a number is not finite, a weight is negative, or the points do not fix a rotation: in
        the plane two different points are needed, in space three that are not on a line.

    See Also
    --------
    Frame2.minus, Frame3.minus : The difference of two poses.
    """
    a, b = np.asarray(points, float), np.asarray(targets, float)
    if a.ndim != 2 or a.shape != b.shape or a.shape[1] not in (2, 3):
        raise ValueError(f"alignment needs two arrays of the same shape (n, 2) or (n, 3), got {a.shape} and {b.shape}")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise ValueError("alignment needs finite points; leave out those that are not known")
    w = np.ones(len(a)) if weights is None else np.asarray(weights, float)
    if w.shape != (len(a),) or not (np.isfinite(w).all() and (w >= 0).all()):
        raise ValueError(f"alignment of {len(a)} points needs as many weights, finite and not negative")
    d = a.shape[1]
    w = w / w.sum() if w.any() else w
    mean_a, mean_b = w @ a, w @ b
    U, s, Vt = np.linalg.svd((w[:, None] * (b - mean_b)).T @ (a - mean_a))
    rounding = 1e-24 * np.abs(a).max(initial=0) * np.abs(b).max(initial=0)  # of points in one place
    if len(a) < d or s[d - 2] <= max(1e-12 * s[0], rounding):
        raise ValueError(f"{len(a)} points do not fix a rotation in {d}D: they are too few, or on top of each other")
    sign = np.ones(d)
    sign[-1] = np.sign(np.linalg.det(U @ Vt))
    R = (U * sign) @ Vt
    t = mean_b - R @ mean_a
    if d == 2:
        return Frame2(np.array([*t, np.arctan2(R[1, 0], R[0, 0])]))
    return Frame3(np.concatenate([t, R2q(R)[0]]))
