"""What a landmark looks like: a patch of the image that it was first seen in, and the same seen from elsewhere.

An appearance is a dictionary, `Lmk.appearance`, of which the core knows nothing:

    patch   ndarray of uint8, shape (2 BIG + 1, 2 BIG + 1), larger than what is compared: it may be turned
    pixel   ndarray, shape (2,), where its centre was in that image
    pose    ndarray, shape (7,), the frame of the camera in the world then, as it was believed to be
    given   bool, True for a corner of the target: its place was given, not measured
"""

import numpy as np

from ...geometry import Frame3
from .extra import opencv

HALF, BIG = 7, 21
"""Half the size of what is compared, 15 x 15 pixels, and of what is kept."""
STEP = 4.0
"""Pixels to each side, of the differences that make the affine map."""
SIDES = STEP * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
LEAST, MOST, LONGEST = 0.2, 5.0, 2.6
"""A patch is not compared if its area would change by more than this, or a length by more."""
FLAT = 4.0
"""A patch whose grey values vary less (standard deviation) says nothing."""


def look_at(image, pixel, camera, given=False):
    """Make the appearance of a landmark at its birth.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width)
    pixel : ndarray, shape (2,)
    camera : Frame3
        Of the camera in the world.
    given : bool

    Returns
    -------
    dict
    """
    size = (2 * BIG + 1, 2 * BIG + 1)
    patch = opencv().getRectSubPix(image, size, (float(pixel[0]), float(pixel[1])))
    return {"patch": patch, "pixel": np.array(pixel, float), "pose": camera.x.copy(), "given": given}


def affine_maps(sensor, appearances, points, camera):
    """Change of patches on their way to the present image, to first order about their centres.

    Each patch is taken for a piece of a plane through its landmark that faced the camera at birth. That plane gives a
    homography from the first image to the present one; lens included it is followed for a few pixels to each side, and
    their differences are the affine map.

    Parameters
    ----------
    sensor : SensorModel
    appearances : list of dict
    points : ndarray, shape (n, 3)
        Where the landmarks are, in the world.
    camera : Frame3
        Of the camera in the world, now.

    Returns
    -------
    ndarray, shape (n, 2, 2)
        Pixels in the present image per pixel in the first one.
    """
    first = Frame3(np.array([a["pose"] for a in appearances]))
    pixel = np.array([a["pixel"] for a in appearances])
    normal = points - first.t
    ray = np.einsum("nij,snj->sni", first.R, sensor.retro(pixel + SIDES[:, None])[0])
    far = (normal * normal).sum(-1) / (normal * ray).sum(-1)  # along the ray to the plane
    right, left, below, above = sensor.project((first.t + far[..., None] * ray - camera.t) @ camera.R)[0]
    return np.stack([right - left, below - above], -1) / (2 * STEP)


def warped(appearance, A):
    """The patch as it should look now, shape (15, 15); None if that says nothing.

    Parameters
    ----------
    appearance : dict
    A : ndarray, shape (2, 2)
        From `affine_maps`.
    """
    (a, b), (c, d) = A.tolist()
    det, size = a * d - b * c, (a * a + b * b + c * c + d * d) / 2
    if not (LEAST < det < MOST) or size + np.sqrt(max(size * size - det * det, 0.0)) > LONGEST**2:
        return None
    p, q, r, s = d / det, -b / det, -c / det, a / det  # the inverse of A; it takes centre to centre
    M = np.array([[p, q, BIG - HALF * (p + q)], [r, s, BIG - HALF * (r + s)]])
    cv2 = opencv()
    patch = cv2.warpAffine(
        appearance["patch"],
        M,
        (2 * HALF + 1, 2 * HALF + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return patch if cv2.meanStdDev(patch)[1][0, 0] >= FLAT else None
