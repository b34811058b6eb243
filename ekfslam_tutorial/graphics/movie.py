"""Movies: frames of a figure written to GIF, WebP or MP4. The file appears when it is complete, or not at all."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

from ..toolbox.files.writing import written
from .style import GREY, OKABE_ITO

Array = np.ndarray

FORMATS = (".gif", ".webp", ".mp4")
LONGEST = {".gif": 65_535, ".webp": 16_777_215}
"""Milliseconds that these formats can show a frame."""


def grab(fig) -> Array:
    """Draw a figure and return it as an image.

    Parameters
    ----------
    fig : matplotlib Figure

    Returns
    -------
    (h, w, 3) array of uint8
        In the figure's own size and dots per inch.
    """
    fig.canvas.draw()
    return np.asarray(fig.canvas.buffer_rgba())[..., :3].copy()


def side_by_side(images: Iterable[Array]) -> Array:
    """Join images in a row, on white.

    Parameters
    ----------
    images : iterable of (h, w, 3) arrays of uint8
        Of any height.

    Returns
    -------
    (h, w, 3) array of uint8
        As high as the highest, as wide as all.
    """
    images = list(images)
    h = max(len(image) for image in images)
    return np.concatenate([np.pad(i, ((0, h - len(i)), (0, 0), (0, 0)), constant_values=255) for i in images], axis=1)


def check_movie_path(path: str | Path) -> Path:
    """Return the path if a movie can be written there, else raise: to be asked before a long run, not after.

    Parameters
    ----------
    path : path
        Where the movie is to be.

    Returns
    -------
    Path
        The same path.

    Raises
    ------
    ValueError
        If the ending is not ``.gif``, ``.webp`` or ``.mp4``.
    RuntimeError
        If an MP4 is wanted and the program ffmpeg is not there.
    NotADirectoryError
        If the folder does not exist.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"a movie file ends in {', '.join(FORMATS)}; got {path.name!r}")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise RuntimeError("MP4 needs the program ffmpeg, which is not on this machine; write a .gif or .webp instead")
    if not path.parent.is_dir():
        raise NotADirectoryError(f"the folder of {path} does not exist")
    return path


class Movie:
    """A movie that takes one frame after the other.

    Parameters
    ----------
    path : path
        Where to write; the ending says how: ``.gif``, ``.webp`` or ``.mp4`` (needs ffmpeg).
    fps : float
        Frames per second.

    Examples
    --------
    >>> with Movie("run.gif") as movie:
    ...     for snapshot in universal_slam(userdata):
    ...         fig.update(snapshot)
    ...         movie.add(grab(fig.fig))
    """

    def __init__(self, path: str | Path, fps: float = 10):
        self.path, self.fps = check_movie_path(path), float(fps)
        if not self.fps > 0:
            raise ValueError(f"a movie needs more than 0 frames per second, got {fps}")
        longest = LONGEST.get(self.path.suffix.lower(), np.inf) / 1000
        if 1 / self.fps > longest:
            raise ValueError(
                f"{self.path.name} can show a frame for {longest:.0f} s at most, got {fps} frames per second"
            )
        self._folder = tempfile.TemporaryDirectory(prefix="ekfslam-movie-")
        self._frames: list[Path] = []
        self._shape: tuple[int, ...] | None = None

    def add(self, image: Array) -> None:
        """Append a frame (h, w, 3) of bytes, as `grab` returns it; all frames have one size."""
        image = np.asarray(image)
        if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
            raise ValueError(f"a frame is an (h, w, 3) array of uint8, got {image.shape} {image.dtype}")
        if self._shape not in (None, image.shape):
            raise ValueError(f"all frames of a movie have one size: the first is {self._shape}, this one {image.shape}")
        self._shape = image.shape
        frame = Path(self._folder.name) / f"{len(self._frames):06d}.png"
        Image.fromarray(image).save(frame, compress_level=1)
        self._frames.append(frame)

    def close(self) -> None:
        """Write the file. Without a frame there is nothing to write, and no file."""
        try:
            if self._frames:
                whole = Path(self._folder.name) / f"movie{self.path.suffix.lower()}"
                (self._encode_mp4 if whole.suffix == ".mp4" else self._encode_pillow)(whole)
                with written(self.path) as file:
                    file.write(whole.read_bytes())
        finally:
            self._folder.cleanup()

    def _encode_pillow(self, whole: Path) -> None:
        first, *rest = (Image.open(frame) for frame in self._frames)
        options = {"save_all": True, "append_images": rest, "duration": round(1000 / self.fps), "loop": 0}
        if whole.suffix == ".gif":
            # One palette for all frames: it is smaller, and colours do not flicker.
            palette = _palette(first)
            first, *rest = (i.quantize(palette=palette, dither=Image.Dither.NONE) for i in (first, *rest))
            options |= {"append_images": rest, "optimize": False}
        else:
            options |= {"quality": 80, "method": 3}
        first.save(whole, **options)

    def _encode_mp4(self, whole: Path) -> None:
        command = ["ffmpeg", "-loglevel", "error", "-y", "-framerate", str(self.fps)]
        command += ["-i", str(Path(self._folder.name) / "%06d.png"), "-pix_fmt", "yuv420p"]
        command += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", str(whole)]  # the codec wants even sizes
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"ffmpeg could not write {self.path.name}: {done.stderr.strip() or 'no reason given'}")

    def __enter__(self) -> Movie:
        return self

    def __exit__(self, kind, *_) -> None:
        if kind is None or kind is KeyboardInterrupt:  # a run that is stopped keeps the film so far
            self.close()
        else:
            self._folder.cleanup()


def _palette(image: Image.Image) -> Image.Image:
    """Return 256 colours for a film: those of the package's styles, fading to white, and the image's own.

    The image's own alone would not do: a colour that marks a few points only is lost among many greys.
    """
    base = np.array([to_rgb(colour) for colour in (*OKABE_ITO, GREY)])
    fade = np.linspace(0, 1, 13)[:, None, None]
    style = np.unique(np.rint(255 * (base * (1 - fade) + fade)).astype(int).reshape(-1, 3), axis=0)
    own = np.array(image.convert("RGB").quantize(256 - len(style)).getpalette()).reshape(-1, 3)[: 256 - len(style)]
    apart = np.abs(own[:, None] - style).max(axis=-1).min(axis=-1) > 8  # Pillow looks colours up in steps of 4
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([style, own[apart]]).ravel().tolist())
    return palette


def write_movie(path: str | Path, images: Iterable[Array], fps: float = 10) -> Path:
    """Write images as a movie.

    Parameters
    ----------
    path : path
        Where to write; the ending says how, see `Movie`.
    images : iterable of (h, w, 3) arrays of uint8
        The frames, all of one size.
    fps : float
        Frames per second.

    Returns
    -------
    Path
        The file that was written.
    """
    with Movie(path, fps) as movie:
        for image in images:
            movie.add(image)
    return movie.path
