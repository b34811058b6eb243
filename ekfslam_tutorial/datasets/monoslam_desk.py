"""MonoSLAM's desk: one hand-held camera in an office, 30 images a second, and no other sensor.

The test sequence of A. J. Davison, I. D. Reid, N. D. Molton, O. Stasse, "MonoSLAM: Real-time single camera SLAM", IEEE
T-PAMI 29(6), 2007: grey images of 320 x 240 pixels, `frames/0000.png` and so on. A black rectangle on the wall, 183 x
129 mm, tells how long a metre is.
"""

from pathlib import Path

import numpy as np

from ..geometry import Frame3, R2q, e2q
from ..models.sensors import DavisonCam
from ..simulation.textured import Room, board, with_black_rectangle
from ..toolbox.images import Pictures
from ..toolbox.images.frames import IMAGES, Images, frames_of
from ..toolbox.images.target import Target
from .sources import data_folders

NAME, FPS = "monoslam_desk", 30.0
TWIN = 150
"""Images of the twin: five seconds."""
TARGET = 0.1832, 0.1292
"""Width and height of the black rectangle, m: what fits best; the publisher's four points are no rectangle."""
CENTRE = -0.0436, 0.0228, 0.0
"""Its middle in the frame of the truth, m: the mean of the four points."""
TRUTH = "batch_truth*.npz"
TRUTH_STD = 0.005, np.deg2rad(0.3)
"""How good a batch adjustment of the same images is: m, and rad about each axis."""


def find_frames(path=None):
    """The folder of the images: `path` itself, or `frames` in it, or below those of `EKFSLAM_DATA`; None if nowhere."""
    folders = [Path(path)] if path is not None else [f / NAME for f in data_folders()] + list(data_folders())
    for folder in folders:
        for place in (folder / "frames", folder):
            if place.is_dir() and image_files(place):
                if path is not None or NAME in (place.name, place.parent.name):
                    return place
    return None


def image_files(folder):
    """The image files of a folder, in the order of their names."""
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in IMAGES)


def load(path=None, first=0, last=None, step=1, target=TARGET, forget=None):
    """The sequence, or a part of it.

    Parameters
    ----------
    path : str or Path, optional
        The folder of the images, or the one that has it; without it, below the folders of `EKFSLAM_DATA`.
    first, last, step : int
        Numbers of the first and the last image; each step-th.
    target : sequence of 2 float
        Width and height of the black rectangle, m; empty: it is not looked for, and the scale stays a guess.
    forget : int, optional
        The corners of the rectangle are deleted from the map after so many frames.

    Returns
    -------
    Pictures
        The world is the first camera: x right, y down, z forward.

    Raises
    ------
    FileNotFoundError, ValueError
    """
    folder = find_frames(path)
    if folder is None:
        raise FileNotFoundError(f"{NAME}: no images (.png, .pgm) in {path or 'the folders of EKFSLAM_DATA'}")
    frames = frames_of(folder, None, first, last, step, FPS)
    known = sorted([*folder.glob(TRUTH), *folder.parent.glob(TRUTH)])
    poses, origin = _truth(known[0], frames.numbers) if known else (None, None)
    truth = {} if poses is None else {1: poses}
    log = Pictures(f"{NAME}, images {frames.numbers[0]} to {frames.numbers[-1]}", frames, truth=truth, forget=forget)
    log.target, log.truth_std = _target(target), TRUTH_STD if known else (0.0, 0.0)
    if origin is not None:
        log.corners = origin.from_frame(Target(*TARGET).corners + CENTRE)[0]
    return log


def own(path=None, camera=None, first=0, last=None, step=1, target=(), forget=None):
    """Images of a video file, or live of a camera of this computer.

    Parameters
    ----------
    path : str or Path, optional
        The video.
    camera : int, optional
        The number of the camera, from 0.
    first, last, step, target, forget
        As in `load`; no target, if not given: the scale is a guess then.

    Returns
    -------
    Pictures
    """
    frames = frames_of(path, camera, first, last, step)
    name = f"camera {camera}" if camera is not None else Path(path or "").name
    log = Pictures(name, frames, _target(target), forget)
    if log.target is None:
        log.notes = ["no target of known size: how long a metre is, is a guess"]
    return log


def _target(size):
    if not len(size):
        return None
    if len(size) != 2:
        raise ValueError(f"target must be width and height in metres, got {list(size)}")
    return Target(*size)


def _truth(file, numbers):
    """Poses (F, 7) of the camera in the first one's frame, NaN where not known; and the frame that brings them there.

    Where the first pose is not known they stay in their own frame; None then.
    """
    with np.load(file) as a:
        missing = [name for name in ("frame", "R", "t") if name not in a]
        if missing:
            raise ValueError(f"{file}: it has no array {missing[0]}")
        known, R, t = a["frame"].tolist(), a["R"], a["t"]
    poses = np.full((len(numbers), 7), np.nan)
    at = {n: k for k, n in enumerate(known)}
    x = {n: Frame3(np.concatenate([t[at[n]], R2q(R[at[n]])[0]])) for n in numbers if n in at}
    origin = x[numbers[0]].inverse()[0] if numbers[0] in x else None
    for i, n in enumerate(numbers):
        if n in x:
            poses[i] = (x[n] if origin is None else origin.compose(x[n])[0]).normalized()[0].x
    return poses, origin


def twin(seed=1, n=TWIN, step=1, forget=None, noise=2.0, sensor=None):
    """Rendered images of a small room with the same rectangle, for those who do not have the sequence.

    Parameters
    ----------
    seed : int
        Of everything random.
    n : int
        Number of images.
    step, forget
        As in `load`.
    noise : float
        Standard deviation of grey values.
    sensor : SensorModel, optional
        The camera; that of the sequence if not given.

    Returns
    -------
    Pictures
    """
    sensor, rng = sensor or DavisonCam(), np.random.default_rng(seed)
    boards, corners = office(rng)
    poses = [Frame3(x) for x in path_of_a_hand(n * step)[::step]]
    room, first = Room(boards, sensor), poses[0].inverse()[0]
    images = [room.image(pose, noise, rng) for pose in poses]
    truth = np.array([first.compose(pose)[0].normalized()[0].x for pose in poses])
    log = Pictures(f"twin of {NAME}", Images(images, FPS / step), Target(*TARGET), forget, {1: truth})
    log.corners = first.from_frame(corners)[0]
    log.notes = [f"simulated twin of {NAME}, seed {seed}: rendered images, no real camera was here"]
    return log


def office(rng):
    """The boards of the twin's room: a wall with the rectangle, a desk, a shelf and a side wall; and the corners."""
    x, y, z = np.eye(3)
    slant = np.array([0.6, 0.0, 0.8])
    wall = board(rng, [-1.2, -0.9, 1.1], x, y, 2.6, 1.6)
    near = board(rng, [-0.28, -0.25, 0.62], x, y, 0.5, 0.42)
    near, corners = with_black_rectangle(near, 45, 40, *TARGET)
    desk = board(rng, [-1.2, 0.42, 0.2], x, z, 2.6, 1.0)
    side = board(rng, [-1.0, -0.8, 0.5], slant, y, 0.9, 1.3)
    box = board(rng, [0.45, -0.3, 0.8], x, y, 0.4, 0.5)
    return (wall, near, desk, side, box), corners


def path_of_a_hand(n):
    """Poses of a camera in a hand, shape (n, 7): slow circles, looking about; at rest in the beginning."""
    t = np.arange(n) / FPS
    ease = 1 - np.exp(-((t / 0.8) ** 2))
    p = np.stack([0.16 * np.sin(1.3 * t), 0.09 * np.sin(1.9 * t + 0.5), 0.12 * np.sin(0.9 * t)], -1) * ease[:, None]
    a = np.stack([0.08 * np.sin(1.1 * t), -0.16 * np.sin(1.3 * t + 0.3), 0.07 * np.sin(1.7 * t)], -1) * ease[:, None]
    return np.concatenate([p, np.array([e2q(e)[0] for e in a])], -1)
