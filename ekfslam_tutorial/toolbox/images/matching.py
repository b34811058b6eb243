"""Where a patch fits best in an image: normalised cross-correlation inside an ellipse, to a part of a pixel."""

import numpy as np

from .extra import opencv


def find_patch(image, patch, e, Z, sigma=3.0, most=25):
    """Look for a patch where it is expected.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width)
    patch : ndarray of uint8, shape (s, s)
        s odd.
    e, Z : ndarray, shape (2,) and (2, 2)
        Expected pixel and the covariance of the innovation.
    sigma : float
        Size of the ellipse.
    most : int
        It is looked for so many pixels to each side at most.

    Returns
    -------
    y : ndarray, shape (2,), or None
        Where it fits best, by the parabola through the neighbours; None if the ellipse is outside the image.
    score : float
        The normalised cross-correlation there, -1 to 1: of the patch less its mean and the image less its mean.
    """
    h, (rows, columns) = len(patch) // 2, image.shape
    (a, b), (_, d) = Z.tolist()
    u, v = e.tolist()
    reach_u, reach_v = (int(min(np.ceil(sigma * np.sqrt(s)), most)) + 1 for s in (a, d))
    left, right = max(round(u) - reach_u, h), min(round(u) + reach_u, columns - 1 - h)
    top, bottom = max(round(v) - reach_v, h), min(round(v) + reach_v, rows - 1 - h)
    if right < left or bottom < top:
        return None, -1.0
    cv2 = opencv()
    window = image[top - h : bottom + h + 1, left - h : right + h + 1]
    score = cv2.matchTemplate(window, patch, cv2.TM_CCOEFF_NORMED)
    det, wide = a * d - b * b, score.shape[1]
    outside = (sigma**2 + 1) * det  # one more: the neighbours of the edge

    def md2_det(row, column):
        """The squared Mahalanobis distance of places in the window, times the determinant."""
        du, dv = left + column - u, top + row - v
        return d * du * du - dv * (2 * b * du) + a * dv * dv

    row, column = divmod(int(score.argmax()), wide)
    if md2_det(row, column) > outside:  # the best of all is rarely outside the ellipse; only then all are asked
        score[md2_det(*np.ogrid[: score.shape[0], :wide]) > outside] = -1.0
        row, column = divmod(int(score.argmax()), wide)

    def at(row, column):
        """The score at a place, -1 outside the ellipse."""
        return -1.0 if md2_det(row, column) > outside else float(score[row, column])

    best, y = float(score[row, column]), np.array([left + column, top + row], float)
    if 0 < column < wide - 1:
        y[0] += summit(at(row, column - 1), best, at(row, column + 1))
    if 0 < row < score.shape[0] - 1:
        y[1] += summit(at(row - 1, column), best, at(row + 1, column))
    return y, best


def summit(before, at, after):
    """Summit of the parabola through three values, from the middle one, -0.5 to 0.5."""
    bend = before - 2 * at + after
    return min(max(0.5 * (before - after) / bend, -0.5), 0.5) if bend < 0 else 0.0


def corners(image, taken, n, apart, quality, border):
    """Corners where the image has none yet: J. Shi, C. Tomasi, "Good features to track", CVPR 1994.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width)
    taken : ndarray, shape (k, 2)
        Pixels of the landmarks that are expected in it.
    n : int
        Most of them.
    apart : float
        So far from each other, and from all that are taken, pixels.
    quality : float
        Share of the best corner's smaller eigenvalue that each must have.
    border : int
        Nothing nearer to the edge than this, pixels.

    Returns
    -------
    ndarray, shape (m, 2)
        The best first.
    """
    cv2 = opencv()
    free = np.zeros_like(image)
    free[border:-border, border:-border] = 255
    for u, v in np.rint(taken).astype(int).tolist():
        cv2.circle(free, (u, v), int(apart), 0, -1)
    found = cv2.goodFeaturesToTrack(image, n, quality, apart, mask=free, blockSize=7)
    return np.zeros((0, 2)) if found is None else found[:, 0].astype(float)
