"""The optional extra `images`: OpenCV, imported when an image is looked at."""

from functools import cache
from importlib.util import find_spec
from typing import Any

MISSING = "images need OpenCV: pip install 'ekfslam_tutorial[images]'"


@cache
def opencv() -> Any:
    """Return the module cv2, with one thread of its own: the images are small.

    Raises
    ------
    ValueError
        If it is not installed, with what to do.
    """
    if find_spec("cv2") is None:
        raise ValueError(MISSING)
    import cv2  # pyright: ignore[reportMissingImports] -- an extra

    cv2.setNumThreads(1)
    return cv2
