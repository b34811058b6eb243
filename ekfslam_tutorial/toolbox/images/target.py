"""A black rectangle of known size before the camera: it tells how long a metre is.

One camera sees directions only; how large the world is it cannot know. The four corners of a rectangle, whose size was
measured with a ruler, enter the map where they are seen first, with all that this does not tell left open.
"""

from typing import NamedTuple

import numpy as np

from ...geometry import hat
from .extra import opencv

PIXEL, SHAPE = 0.3, 0.0005
"""Standard deviations: of a corner that was found, pixels; and of its place in the rectangle, m."""
LEVELS = 40, 50, 60, 70, 80, 95, 110
"""Grey values that part black from white: one of them will do."""
SMALLEST, LARGEST = 400, 0.2
"""Area of the rectangle in the image: pixels, and share of the image."""
BORDER = 6
"""All of it is so far inside the image, pixels."""
EDGE = 40
"""It is so much darker than what is around it, grey values."""
STEPS = 20


class Given(NamedTuple):
    """Points that are given with an image.

    Parameters
    ----------
    pixels : ndarray, shape (n, 2)
    points : ndarray, shape (n, 3)
        In the frame of the camera, m.
    P : ndarray, shape (3 n, 3 n)
        Their joint covariance.
    """

    pixels: np.ndarray
    points: np.ndarray
    P: np.ndarray


class Target:
    """A black rectangle.

    Parameters
    ----------
    width, height : float
        Metres.
    """

    def __init__(self, width, height):
        if not (width > 0 and height > 0):
            raise ValueError(f"target must be width and height in metres, got {[width, height]}")
        x, y = width / 2, height / 2
        self.corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])

    def find(self, image, sensor):
        """Find it in an image, and where it is. Returns Given, or None."""
        for pixels in rectangles(image, sensor, np.ptp(self.corners, axis=0)):
            given = self.place(pixels, sensor)
            if given is not None:
                return given
        return None

    def place(self, pixels, sensor):
        """Corners in the frame of the camera, from their pixels.

        A small rectangle tells its distance well and badly how it is turned: turned towards the camera on one side or
        on the other it looks nearly the same. Both are solutions; the corners get the mean and the covariance of both,
        each by its likelihood.

        Parameters
        ----------
        pixels : ndarray, shape (4, 2)
        sensor : SensorModel

        Returns
        -------
        Given or None
            None if no rectangle of this size is seen so.
        """
        cv2, rays = opencv(), sensor.retro(pixels)[0]
        solved = cv2.solvePnPGeneric(self.corners, rays[:, None, :2].copy(), np.eye(3), None, flags=cv2.SOLVEPNP_IPPE)
        guesses = [(cv2.Rodrigues(r)[0], t.ravel()) for r, t in zip(*solved[1:3], strict=True)]
        found = [f for f in (self._adjusted(pixels, sensor, R, t) for R, t in guesses) if f is not None]
        if not found:
            return None
        cost, p, P = (np.array(a) for a in zip(*found, strict=True))
        w = np.exp(-(cost - cost.min()) / 2)
        w /= w.sum()
        mean = np.einsum("i,ij->j", w, p)
        d = p - mean
        P = np.einsum("i,ijk->jk", w, P) + np.einsum("i,ij,ik->jk", w, d, d)
        return Given(pixels, mean.reshape(-1, 3), (P + P.T) / 2 + SHAPE**2 * np.eye(len(P)))

    def _adjusted(self, pixels, sensor, R, t):
        """Adjust one solution to the pixels (Gauss, Newton): what is left of them in sigmas squared, corners and P."""
        for _ in range(STEPS):
            p = self.corners @ R.T + t
            if not (p[:, 2] > 0).all():
                return None
            e, E_p = sensor.project(p)
            G = np.concatenate([np.broadcast_to(np.eye(3), (4, 3, 3)), -hat(p - t)], -1)
            J, z = (E_p @ G).reshape(-1, 6) / PIXEL, (pixels - e).ravel() / PIXEL
            P = np.linalg.pinv(J.T @ J, hermitian=True)
            step = P @ J.T @ z
            t = t + step[:3]
            R = opencv().Rodrigues(step[3:])[0] @ R
        P = G.reshape(-1, 6) @ P @ G.reshape(-1, 6).T  # pyright: ignore -- there are STEPS
        return float(z @ z), (self.corners @ R.T + t).ravel(), P  # pyright: ignore


def rectangles(image, sensor, size):
    """Black rectangles in an image, the most contrast first: their corners, from the upper left one clockwise, (4, 2).

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width)
    sensor : SensorModel
        Its lens is taken off: straight edges are straight then.
    size : ndarray, shape (2,) or longer
        Width and height.
    """
    cv2, found, (rows, columns) = opencv(), [], image.shape
    focal = float(sensor.k[2])
    for level in LEVELS:
        outlines, _ = cv2.findContours((image < level).astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            if not SMALLEST < cv2.contourArea(outline) < LARGEST * image.size:
                continue
            (left, top), (right, bottom) = outline[:, 0].min(0), outline[:, 0].max(0)
            if left < BORDER or top < BORDER or right >= columns - BORDER or bottom >= rows - BORDER:
                continue
            ideal = (focal * sensor.retro(outline[:, 0].astype(float))[0][:, None, :2]).astype(np.float32)
            four = cv2.approxPolyDP(ideal, 0.04 * cv2.arcLength(ideal, True), True)
            if len(four) != 4 or not cv2.isContourConvex(four):
                continue
            q = in_order(four[:, 0].astype(float))
            sides = np.linalg.norm(np.roll(q, -1, 0) - q, axis=1)
            ratio = (sides[0] + sides[2]) / (sides[1] + sides[3]) * size[1] / size[0]
            contrast = _contrast(image, outline)
            if 0.65 < ratio < 1.5 and contrast > EDGE:
                rays = np.column_stack([q / focal, np.ones(4)])
                pixels = sensor.project(rays)[0]
                if ((pixels >= BORDER) & (pixels < np.array([columns, rows]) - BORDER)).all():
                    found.append((contrast, pixels))
    found.sort(key=lambda pair: -pair[0])
    return [_to_a_part(image, q) for _, q in found]


def in_order(q):
    """Corners (4, 2) clockwise from the upper left one, as an image shows them."""
    d = q - q.mean(0)
    return q[np.argsort(np.arctan2(d[:, 1], d[:, 0]))]


def _contrast(image, outline):
    """Contrast of the inside with what is around, darker is more, less how uneven it is."""
    cv2 = opencv()
    inside = np.zeros_like(image)
    cv2.drawContours(inside, [outline], -1, 255, -1)
    ring = cv2.dilate(inside, np.ones((9, 9))) - cv2.dilate(inside, np.ones((5, 5)))
    core = cv2.erode(inside, np.ones((5, 5)))
    if not core.any() or not ring.any():
        return 0.0
    return float(image[ring > 0].mean() - image[core > 0].mean() - image[core > 0].std())


def _to_a_part(image, q):
    """Corners to a part of a pixel."""
    cv2 = opencv()
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 0.01)
    return cv2.cornerSubPix(image, q.astype(np.float32)[:, None].copy(), (3, 3), (-1, -1), stop)[:, 0].astype(float)
