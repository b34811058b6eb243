"""The lens of ROS and OpenCV, with tangential distortion, which the sensor models here do not have."""

import numpy as np

from ...models.sensors.lens import exact_undistort

TURNS, NEAR = 50, 1e-12


def tangential(up, p1, p2):
    """Tangential distortion of normalised image points, shape (..., 2).

    Source: D. C. Brown, "Decentering distortion of lenses", Photogrammetric Engineering 32(3), 1966.
    """
    x, y = np.moveaxis(up, -1, 0)
    r2 = x * x + y * y
    return np.stack([2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], -1)


def without_tangential(pixels, k, d):
    """Pixels as a lens with the radial part alone would show them.

    With ud = D(up) + T(up), radial and tangential part, D(up) = ud - T(D^-1(D(up))) is found by iteration: T is small.

    Parameters
    ----------
    pixels : ndarray, shape (n, 2)
    k : sequence of float
        u0, v0, fu, fv, pixels.
    d : sequence of float
        k1, k2, p1, p2, k3: the `D` of a CameraInfo with the model plumb_bob.

    Returns
    -------
    ndarray, shape (n, 2)
        NaN where no point of the world is seen there.
    """
    centre, focal, radial = np.array(k[:2], float), np.array(k[2:], float), [d[0], d[1], d[4]]
    seen = (pixels - centre) / focal
    shown = seen
    for _ in range(TURNS):
        before, shown = shown, seen - tangential(exact_undistort(shown, radial)[0], d[2], d[3])
        if not np.nanmax(np.abs(shown - before), initial=0.0) > NEAR:
            break
    back = shown + tangential(exact_undistort(shown, radial)[0], d[2], d[3])
    return np.where((np.abs(back - seen) < 1e-9).all(-1, keepdims=True), centre + focal * shown, np.nan)
