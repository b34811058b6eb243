"""What the tests of images share. They need OpenCV, the extra `images`; without it only its absence can be tested."""

from importlib.util import find_spec

import numpy as np
import pytest

from ekfslam_tutorial.datasets import monoslam_desk
from ekfslam_tutorial.models.sensors import DavisonCam
from ekfslam_tutorial.simulation.textured import Room

NO_OPENCV = find_spec("cv2") is None
needs_opencv = pytest.mark.skipif(NO_OPENCV, reason="OpenCV, the extra images, is not installed")
CAMERA = DavisonCam(margin=8.0)


@pytest.fixture(scope="session")
def room():
    """Room of the twin, and the true corners of its rectangle."""
    boards, corners = monoslam_desk.office(np.random.default_rng(1))
    return Room(boards, CAMERA), corners


@pytest.fixture(scope="session")
def short_twin():
    """Forty images of the twin."""
    return monoslam_desk.twin(n=40)
