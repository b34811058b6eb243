"""Where images come from: a folder of files, a video file, a webcam, or arrays. Each is a sequence of grey images."""

import re
import time
from pathlib import Path

import numpy as np

from .extra import opencv

IMAGES = ".png", ".pgm", ".jpg", ".jpeg"
LATEST = 900
"""Frames of a webcam, where nobody says how many: half a minute."""


class Folder:
    """The image files of a folder, in the order of their names.

    Parameters
    ----------
    path : path
    first, last : int, optional
        Numbers of the first and the last image. If all names are numbers, such as 0012.png, these count; else it is the
        place in the folder, from 0.
    step : int
        Every so many numbers only.
    fps : float
        Images a second.

    Attributes
    ----------
    t : ndarray, shape (F,)
        Seconds since the first one.
    numbers : list of int

    Raises
    ------
    FileNotFoundError, ValueError
    """

    def __init__(self, path, first=0, last=None, step=1, fps=30.0):
        files = sorted(p for p in Path(path).glob("*") if p.suffix.lower() in IMAGES)
        if not files:
            raise FileNotFoundError(f"no images ({', '.join(IMAGES)}) in the folder {path}")
        named = all(p.stem.isdecimal() for p in files)
        by_number = {int(p.stem) if named else i: p for i, p in enumerate(files)}
        there = min(by_number), max(by_number)
        self.numbers = part(sorted(by_number), first, last, step, path, there)
        self._files = [by_number[n] for n in self.numbers]
        self.t = (np.array(self.numbers, float) - self.numbers[0]) / fps
        self.period = step / fps

    def __len__(self):
        return len(self._files)

    def __getitem__(self, i):
        cv2, file = opencv(), self._files[i]
        image = cv2.imdecode(np.frombuffer(file.read_bytes(), np.uint8), cv2.IMREAD_GRAYSCALE)
        if image is None:
            raise ValueError(f"{file} is damaged, or no image")
        return image


def part(numbers, first, last, step, where, there):
    """The numbers from first to last, each step-th."""
    stop = there[1] if last is None else last
    wanted = [n for n in numbers if first <= n <= stop and (n - first) % step == 0]
    if step < 1 or not wanted or first < there[0] or stop > there[1]:
        asked = f"{first} to {'the end' if last is None else last}" + f", each {step}th" * (step != 1)
        raise ValueError(f"{where}: it has the images {there[0]} to {there[1]}, asked for are {asked}")
    return wanted


class Video:
    """A video file, read from its beginning to its end.

    Parameters
    ----------
    path : path
    first, last, step
        As of `Folder`; frames are counted from 0.
    fps : float, optional
        Images a second; without it as the file says.

    Raises
    ------
    FileNotFoundError, ValueError
    """

    def __init__(self, path, first=0, last=None, step=1, fps=None):
        cv2 = opencv()
        if not Path(path).is_file():
            raise FileNotFoundError(f"no video file {path}")
        self._film, self._path, self._next = cv2.VideoCapture(str(path)), path, 0
        n = int(self._film.get(cv2.CAP_PROP_FRAME_COUNT))
        if not self._film.isOpened() or n < 1:
            raise ValueError(f"{path} is no video that OpenCV can read")
        fps = fps or self._film.get(cv2.CAP_PROP_FPS) or 30.0
        self.numbers = part(range(n), first, last, step, path, (0, n - 1))
        self.t = (np.array(self.numbers, float) - self.numbers[0]) / fps
        self.period = step / fps

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, i):
        wanted = self.numbers[i]
        if wanted < self._next:
            self._film.set(opencv().CAP_PROP_POS_FRAMES, wanted)
            self._next = wanted
        while self._next <= wanted:
            there, image = self._film.read()
            self._next += 1
            if not there:
                raise ValueError(f"{self._path}: image {wanted} cannot be read")
        return grey(image)


def _opened(cv2, number):
    """The camera, open or not; what its drivers have to say is not printed."""
    words = cv2.utils.logging
    level = words.getLogLevel()
    words.setLogLevel(words.LOG_LEVEL_SILENT)
    try:
        return cv2.VideoCapture(number)
    finally:
        words.setLogLevel(level)


class Webcam:
    """A camera of this computer: each image is the newest one, and its time is that of the clock.

    Parameters
    ----------
    number : int
        Of the camera, from 0.
    last : int, optional
        Number of the last frame, from 0; half a minute if not given. Ctrl-C stops before.
    size : sequence of 2 int
        Width and height that it is asked for; what comes is scaled to them.
    fps : float
        Images a second that it is asked for.

    Raises
    ------
    ValueError
        If there is no such camera.
    """

    def __init__(self, number, last=None, size=(320, 240), fps=30.0):
        cv2 = opencv()
        self._film, self._size, self._begun = _opened(cv2, int(number)), tuple(map(int, size)), None
        if not self._film.isOpened():
            raise ValueError(
                f"there is no camera {number} here, or another program has it; a video file does as well: --camera FILE"
            )
        wanted = {cv2.CAP_PROP_FRAME_WIDTH: self._size[0], cv2.CAP_PROP_FRAME_HEIGHT: self._size[1]}
        for key, value in (wanted | {cv2.CAP_PROP_FPS: fps, cv2.CAP_PROP_BUFFERSIZE: 1}).items():
            self._film.set(key, value)
        n = LATEST if last is None else last + 1
        self.numbers, self.t, self.period = list(range(n)), np.arange(n) / fps, 1 / fps

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, i):
        there, image = self._film.read()
        if not there:
            raise ValueError("the camera gives no images any more")
        now = time.monotonic()
        self._begun = now if self._begun is None else self._begun
        self.t[i] = now - self._begun  # what was written there before was only what is usual
        return opencv().resize(grey(image), self._size)


class Images:
    """Images that are in the memory, one after the other, as of a rendered world.

    Parameters
    ----------
    images : sequence of ndarray of uint8, shape (height, width)
    fps : float
    """

    def __init__(self, images, fps=30.0):
        self._images, self.numbers = images, list(range(len(images)))
        self.t, self.period = np.arange(len(images)) / fps, 1 / fps

    def __len__(self):
        return len(self._images)

    def __getitem__(self, i):
        return self._images[i]


def grey(image):
    """An image of OpenCV, in colours or not, as a grey one."""
    return image if image.ndim == 2 else opencv().cvtColor(image, opencv().COLOR_BGR2GRAY)


def frames_of(path=None, camera=None, first=0, last=None, step=1, fps=None, size=(320, 240)):
    """Images of a camera by its number, of a folder, or of a video file.

    Raises
    ------
    FileNotFoundError, ValueError
    """
    if camera is not None:
        return Webcam(camera, last, size, fps or 30.0)
    if path is None:
        raise ValueError("where the images are is not said: path = a folder or a video file, or camera = 0")
    if Path(path).is_dir():
        return Folder(path, first, last, step, fps or 30.0)
    if re.search("[*?]", str(path)):
        raise ValueError(f"path is the folder of the images, not a pattern, got {path}")
    return Video(path, first, last, step, fps)
