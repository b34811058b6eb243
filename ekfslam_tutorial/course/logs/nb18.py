"""The log of notebook 18: a MRCLAM set with five robots where there is one, and its twin everywhere."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from ...datasets import mrclam, mrclam_twin
from ...datasets.mrclam_log import ROBOTS, read_set
from ...datasets.odometry import OdometryNoise

__all__ = ["REAL", "ROBOTS", "SECONDS", "TWIN", "frames", "here", "recording", "survey"]

TWIN, REAL = "simulated twin", "real log"
SETS = (7, 1, 2, 3, 4, 5, 6, 8, 9)  # one with dense ground truth first
SECONDS = {REAL: 240.0, TWIN: 120.0}  # of a log; the whole of set 7 in one filter takes a quarter of a minute
TWIN_NOISE = OdometryNoise(along=0.03, across=0.02, turn=0.06, drift=0.034), mrclam.SightingNoise(0.1, 0.03, 0.013)
"""About what the twin was made with. Its errors are white, so its filter may be told the truth about them."""


def _real_set():
    return next((n for n in SETS if mrclam.find_set(n) is not None), None)


def here():
    """Which log the notebook uses: REAL if a set of MRCLAM is found, else TWIN."""
    return REAL if _real_set() is not None else TWIN


@cache
def recording(which=TWIN):
    """The log of the five robots as a recording; the real one is whole, runs stop after `SECONDS`."""
    if which == REAL:
        n = _real_set()
        if n is None:
            raise FileNotFoundError("no set of MRCLAM is found; set EKFSLAM_DATA to the folder with your data sets")
        return mrclam.load(n, ROBOTS)
    with tempfile.TemporaryDirectory() as folder:
        path = mrclam_twin.write(Path(folder) / "MRCLAM_Twin", 1, SECONDS[TWIN], sparse=())
        log = read_set(mrclam.find_set(1, path), ROBOTS)
    return mrclam.recording(log, None, *TWIN_NOISE)


def frames(which=TWIN, seconds=None):
    """How many frames the first seconds of the log have."""
    return int(np.searchsorted(recording(which).t, seconds or SECONDS[which]))


def survey(which=TWIN):
    """True places of the landmarks, by id."""
    true = recording(which).landmarks
    assert true is not None  # every set of MRCLAM has its survey
    return dict(zip(true.ids.tolist(), true.points, strict=True))
