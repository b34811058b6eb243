"""Cutting curves at the walls of a convex region: the box of a 3D figure, or what a camera sees.

matplotlib draws 3D lines far outside the axes, and mirrored where they pass behind the eye. A landmark seen once from
one place has an ellipsoid of kilometres; what lies in the region must be drawn, and nothing else.
"""

from __future__ import annotations

import numpy as np

from .ellipses import nan_separated

Array = np.ndarray
Region = tuple[Array, Array]  # half-spaces N p <= c: N (h, d), c (h,)


def box(limits: Array) -> Region:
    """Return the region between the lower and the upper limit of each axis, `limits` (d, 2)."""
    limits = np.asarray(limits, dtype=float)
    I = np.eye(len(limits))
    return np.concatenate([-I, I]), np.concatenate([-limits[:, 0], limits[:, 1]])


def pyramid(frame, half: Array, near: float) -> Region:
    """Return what a camera sees: |x| <= half_x z, |y| <= half_y z and z >= near, in the camera's axes.

    Parameters
    ----------
    frame : Frame3
        Camera in the world: x right, y down, z forward.
    half : (2,)
        Half the width and half the height of the view, at distance 1.
    near : float
        Nearest distance that is drawn, metres.
    """
    hx, hy = half
    N = np.array([[1, 0, -hx], [-1, 0, -hx], [0, 1, -hy], [0, -1, -hy], [0, 0, -1]]) @ frame.R.T
    return N, N @ frame.t + [0, 0, 0, 0, -near]


def inside(p: Array, region: Region) -> Array:
    """Return which points p (..., d) lie in the region; a point that is not finite does not."""
    N, c = region
    with np.errstate(invalid="ignore"):  # infinity times 0
        return np.all(p @ N.T <= c, axis=-1)


def clip_curves(curves: Array, region: Region) -> Array:
    """Return the parts of polylines that lie in the region.

    Parameters
    ----------
    curves : (..., n, d)
        Polylines. A point that is not finite interrupts its line.
    region : half-spaces

    Returns
    -------
    (m, d)
        Points in the order of drawing, a row of NaN where the pen is lifted.
    """
    N, c = region
    curves = np.asarray(curves, dtype=float)
    curves = curves.reshape(-1, *curves.shape[-2:])
    with np.errstate(invalid="ignore"):
        outside = curves @ N.T - c  # (curve, point, wall), metres times |N| outside that wall
    whole = np.all(outside <= 0, axis=(1, 2))
    a, b = curves[~whole, :-1], curves[~whole, 1:]
    ga, gb = outside[~whole, :-1], outside[~whole, 1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        s = ga / (ga - gb)  # where on the segment a wall is crossed
        enter = np.where(ga > 0, np.where(gb > 0, np.inf, s), 0.0).max(axis=-1, initial=0.0)
        leave = np.where((gb > 0) & (ga <= 0), s, 1.0).min(axis=-1, initial=1.0)
        keep = (enter < leave) & np.isfinite(ga).all(axis=-1) & np.isfinite(gb).all(axis=-1)
    a, step = a[keep], (b - a)[keep]
    pieces = np.stack([a + enter[keep, None] * step, a + leave[keep, None] * step], axis=-2)
    return np.concatenate([nan_separated(curves[whole]), nan_separated(pieces)])
