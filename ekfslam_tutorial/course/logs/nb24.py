"""The films of notebook 24: images of a rendered desk, taken by a small camera in a hand; nobody needs OpenCV for them.

The desk is that of the twin of MonoSLAM's sequence. Here the camera also turns to the side, so that landmarks leave the
image, and somebody may push a book across the desk: its corners look like any other corner, and they move.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from ...datasets import monoslam_desk
from ...geometry import Frame3, e2q
from ...models.sensors import DavisonCam
from ...simulation.textured import Room, board
from ...toolbox.images import Pictures
from ...toolbox.images.frames import Images

CAMERA = DavisonCam(k=(80.0, 60.0, 97.5, 97.5), k1=3.6e-5, image_size=(160.0, 120.0), pixel_std=0.5, margin=6.0)
"""Half as many pixels as MonoSLAM's, with the same lens; half a patch of 11 x 11 pixels is its margin."""
FPS, FRAMES = 15.0, 45
GIVEN_STD = 0.002
"""How well the four corners of the black rectangle are known, m."""
PUSHED, WAITS = 0.15, 0.5
"""The book: m/s to the left, after so many seconds."""
PAN = 0.3
"""rad that the camera has turned to the right at the end."""
GREY_STD = 2.0
TREMBLES = 0.007
"""rad from image to image, about each axis: about a pixel."""


@cache
def film(seed, book=True, n=FRAMES):
    """Images of the desk, with the truth.

    Parameters
    ----------
    seed : int
        Of the textures and the noise of the grey values.
    book : bool
        True: somebody pushes a book across.
    n : int
        Images.

    Returns
    -------
    Pictures
        With one thing more, `truths`, a function of the number of an image and some pixels in it: the points that are
        seen there, in the frame of the first camera, and which of them stay where they are.
    """
    rng = np.random.default_rng(seed)
    boards, corners = monoslam_desk.office(rng)
    x, y, _ = np.eye(3)
    card = board(rng, [0.12, -0.2, 0.55], x, y, 0.16, 0.22)
    poses = [Frame3(p) for p in path(n, np.random.default_rng([seed, 1]))]
    room, first = Room(boards, CAMERA), poses[0].inverse()[0]
    at = lambda k: card.corner - PUSHED * max(k / FPS - WAITS, 0.0) * x
    images = []
    for k, pose in enumerate(poses):
        room.boards = (*boards, replace(card, corner=at(k))) if book else boards
        images.append(room.image(pose, GREY_STD, rng))
    truth = np.array([first.compose(pose)[0].normalized()[0].x for pose in poses])
    log = Pictures(f"film {seed}", Images(images, FPS), truth={1: truth})
    log.corners = first.from_frame(corners)[0]

    def truths(k, pixels):
        """What image k shows at some pixels: points, shape (n, 3), and which are not on the book, shape (n,)."""
        room.boards = (*boards, replace(card, corner=at(k))) if book else boards
        p, which = room.points(poses[k], np.atleast_2d(pixels))
        return first.from_frame(p)[0], which < len(boards)

    log.truths = truths  # pyright: ignore[reportAttributeAccessIssue] -- for the verdict alone
    return log


def path(n, rng):
    """Poses of the camera, shape (n, 7): those of the twin, by a hand that trembles, slowly turned to the right."""
    step = round(monoslam_desk.FPS / FPS)
    poses, turned = monoslam_desk.path_of_a_hand(n * step)[::step], []
    for k, (x, a) in enumerate(zip(poses, rng.normal(0.0, TREMBLES, (n, 3)), strict=True)):
        turn = Frame3(np.concatenate([np.zeros(3), e2q(a * min(k, 1) + [0.0, PAN * k / n, 0.0])[0]]))
        still = Frame3(np.concatenate([np.zeros(3), x[3:]]))
        turned.append(np.concatenate([x[:3], turn.compose(still)[0].x[3:]]))
    return np.array(turned)


def given(log, seed):
    """The corners of the black rectangle as somebody has measured them: places, shape (4, 3), in the first frame, m."""
    return log.corners + np.random.default_rng(seed).normal(0.0, GIVEN_STD, log.corners.shape)
