"""The raw measurement of a camera in one frame: an image, and what was measured in it once it was looked for."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass
class App:
    """Patch that was looked for, and what was found: the appearance of a landmark in an image (manual: Obs.app).

    Parameters
    ----------
    pred : ndarray of uint8, shape (s, s)
        The patch as it should look from here.
    sc : float
        How well it fits where it fits best: normalised cross-correlation, -1 to 1.
    image : ndarray of uint8
    y : ndarray, shape (2,), or None
        Where that is, pixels; None if it does not fit well enough anywhere.
    """

    pred: Any
    sc: float
    image: Any = field(repr=False)
    y: Any = None

    @property
    def curr(self):
        """The patch as it looks in the image, where it was found; None if it was not."""
        if self.y is None:
            return None
        h, (u, v) = len(self.pred) // 2, np.rint(self.y).astype(int)
        return self.image[v - h : v + h + 1, u - h : u + h + 1]


@dataclass
class Picture:
    """Raw data of a camera in one frame.

    It begins as an image only. `ActiveSearch` measures in it, and writes what it has found into `ids` and `y`, so that
    it is like any raw measurement from then on.

    Parameters
    ----------
    sen : int
        Sensor id.
    image : ndarray of uint8, shape (height, width)
        Grey.
    ids : ndarray of int, shape (k,)
        Which landmark it is; -1 where it may start one.
    y : ndarray, shape (k, 2)
        Pixels.
    R : None
        The noise is that of the sensor.
    app : dict of int to App
        By landmark id, of all that were looked for.
    scene : tuple or None
        Robot, sensor and landmarks, while somebody looks at it.
    born : dict of int to int
        Landmarks that were started: their ids, and which of the measurements each was.
    target : Target or None
        What is to be found in it, if it has not been found before.
    given : Given or None
        What was found of that.
    forget : bool
        True: the landmarks that were given are to be deleted after this frame.
    """

    sen: int
    image: Any = field(repr=False)
    ids: Any = field(default_factory=lambda: np.zeros(0, int))
    y: Any = field(default_factory=lambda: np.zeros((0, 2)))
    R: None = None
    app: dict = field(default_factory=dict, repr=False)
    scene: Any = field(default=None, repr=False)
    born: dict = field(default_factory=dict)
    target: Any = field(default=None, repr=False)
    given: Any = None
    forget: bool = False

    def __len__(self):
        return len(self.ids)
