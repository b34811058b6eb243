"""The log of notebook 19: the truck of Victoria Park where its file is, and its twin everywhere."""

from dataclasses import replace
from functools import cache

import numpy as np

from ...datasets import victoria_park, victoria_park_raw, victoria_park_twin
from ...datasets.sources import find_file

__all__ = ["REAL", "SHORT", "TWIN", "here", "recording"]

TWIN, REAL = "simulated twin", "real log"
SHORT = {REAL: 1200, TWIN: 600}  # scans of the experiments: four minutes, and two
NOISE = victoria_park.ParkNoise(speed=0.2, speed_growth=0.03, steer=np.radians(1.5), slip=np.radians(6.0))


def here():
    """Which log the notebook uses: REAL if a file of Victoria Park is found, else TWIN."""
    found = [find_file(name) for name in (victoria_park.FILE, victoria_park_raw.SCANS)]
    return REAL if any(path is not None for path in found) else TWIN


@cache
def _log(which):
    """The log, and the calibration that belongs to its detections."""
    if which == TWIN:
        return victoria_park_twin.simulate()[0], victoria_park.CALIBRATION
    if find_file(victoria_park.FILE) is not None:
        return victoria_park.read_log(), victoria_park.CALIBRATION
    return victoria_park_raw.read_raw_log(), victoria_park_raw.OWN_CALIBRATION


@cache
def recording(which=TWIN, every=1, noise=NOISE):
    """The log as a recording: a frame for each scan, detections without ids, GPS beside it.

    Parameters
    ----------
    which : str
    every : int
        Only one scan in so many is kept; the odometry goes on.
    noise : ParkNoise
        What the filter is told of the controls.
    """
    log, calibration = _log(which)
    kept = np.arange(0, len(log.scan_t), every)
    n = np.diff(log.offsets)
    scans = np.repeat(np.arange(len(n)), n)
    thinned = replace(
        log,
        scan_t=log.scan_t[kept],
        offsets=np.concatenate([[0], np.cumsum(n[kept])]),
        detections=log.detections[scans % every == 0],
    )
    return victoria_park.recording(thinned, calibration, noise)
