"""The part of a straight edge that a camera sees: between planes, and behind a lens that bends it, by a search."""

import numpy as np

SAMPLES, HALVINGS = 65, 40
"""Points of an edge at which a lens is asked whether it sees them, and steps to the place where it ceases to."""


def stretch(camera, walls, a, way):
    """First and last s of the points a + s way that a camera sees, 0 <= s <= 1; the last is less if it sees none.

    Parameters
    ----------
    camera : PinHole
    walls : ndarray, shape (5, 3)
        Of this camera.
    a, way : ndarray, shape (..., 3)
        One end of the edge, and the way to the other, in the camera's frame, m.

    Returns
    -------
    first, last : ndarray, shape (...)

    See Also
    --------
    SegmentCam.segments : Their images.
    """
    with np.errstate(all="ignore"):
        at, slope = a @ walls.T, way @ walls.T  # inside where at + s slope >= 0
        cut = -at / slope
        first = np.where(slope > 0, cut, np.where((slope == 0) & (at < 0), np.inf, 0)).max(-1, initial=0.0)
        last = np.where(slope < 0, cut, 1.0).min(-1, initial=1.0)
        return seen_between(camera, a, way, first, last) if len(camera.d) else (first, last)


def walls(camera):
    """Normals, pointing inwards, of planes through the camera; between them is all that can be in its image.

    Without distortion they are its four sides and the image plane. A bent image is between them, and fills less.

    Returns
    -------
    ndarray, shape (5, 3)

    See Also
    --------
    stretch : The part of an edge between them.
    """
    w, h = np.subtract(camera.image_size, camera.margin)
    m, n = camera.margin, np.linspace(0, 1, 33)[:, None]
    corners = np.array([[m, m], [w, m], [w, h], [m, h], [m, m]])
    border = np.concatenate([p + n * (q - p) for p, q in zip(corners[:-1], corners[1:], strict=True)])
    rays = camera.retro(border)[0][:, :2]
    if not np.isfinite(rays).all():  # the lens folds back before the border is reached
        rays = np.array([[-camera.fold], [camera.fold]]).repeat(2, axis=1)
    (x0, y0), (x1, y1) = rays.min(0), rays.max(0)
    return np.array([[1, 0, -x0], [-1, 0, x1], [0, 1, -y0], [0, -1, y1], [0, 0, 1]], float)


def seen_between(camera, a, way, first, last):
    """The stretch between s = first and last that is in the image: sampled, and its ends then halved down."""
    sees = lambda s: camera.visible(camera.project(p := a + s[..., None] * way)[0], p)
    s = first + np.linspace(0, 1, SAMPLES).reshape(-1, *[1] * first.ndim) * (last - first)
    seen, ends = sees(s), []
    for points, inside in ((s, seen), (s[::-1], seen[::-1])):
        k = inside.argmax(0)[None]
        good, bad = (np.take_along_axis(points, i, 0)[0] for i in (k, np.maximum(k - 1, 0)))
        for _ in range(HALVINGS if (good != bad).any() else 0):
            middle = (good + bad) / 2
            ok = sees(middle)
            good, bad = np.where(ok, middle, good), np.where(ok, bad, middle)
        ends.append(good)
    return ends[0], np.where(seen.any(0), ends[1], -np.inf)
