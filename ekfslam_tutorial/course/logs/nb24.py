"""The films of notebook 24: images of a rendered desk, taken by a small camera in a hand; nobody needs OpenCV for them.

The desk is that of the twin of MonoSLAM's sequence. Here the camera also turns to the side, so that landmarks leave the
image, and somebody may push a book across the desk: its corners look like any other corner, and they move.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

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


@dataclass
class Film(Pictures):
    """Images with all that is true of them: `room`, its `boards` that stand still, and the `poses` of the camera."""

    room: Any = None
    boards: tuple = ()
    poses: Any = ()
    card: Any = None

    def scene(self, k):
        """Let the room look as in image k: with the book where it is then, if there is one."""
        moved = PUSHED * max(k / FPS - WAITS, 0.0) * np.eye(3)[0]
        book = () if self.card is None else (replace(self.card, corner=self.card.corner - moved),)
        self.room.boards = (*self.boards, *book)

    def truths(self, k, pixels):
        """What image k shows at some pixels: points (n, 3) in the frame of the first camera, and which stay there."""
        self.scene(k)
        p, which = self.room.points(self.poses[k], np.atleast_2d(pixels))
        return self.poses[0].to_frame(p)[0], which < len(self.boards)


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
    Film
    """
    rng = np.random.default_rng(seed)
    boards, corners = monoslam_desk.office(rng)
    x, y, _ = np.eye(3)
    card = board(rng, [0.12, -0.2, 0.55], x, y, 0.16, 0.22)
    poses = [Frame3(p) for p in path(n, np.random.default_rng([seed, 1]))]
    log = Film(f"film {seed}", (), room=Room(boards, CAMERA), boards=boards, poses=poses, card=card if book else None)
    images = []
    for k, pose in enumerate(poses):
        log.scene(k)
        images.append(log.room.image(pose, GREY_STD, rng))
    log.frames, first = Images(images, FPS), poses[0].inverse()[0]
    log.__post_init__()  # once more, with the images
    log.truth = {1: np.array([Frame3(first.compose(pose)[0].x).normalized()[0].x for pose in poses])}
    log.corners = first.from_frame(corners)[0]
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
