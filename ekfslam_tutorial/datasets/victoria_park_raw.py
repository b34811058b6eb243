"""Victoria Park from the publisher's own files: odometry, GPS, and raw scans, in which our detector looks for trees."""

from dataclasses import replace

import numpy as np

from .matlab import read_mat
from .sources import find_file, get_file
from .trees import TreeDetector
from .victoria_park import CALIBRATION, FILE, ParkLog, read_log

SCANS, ODOMETRY, GPS = "aa3_lsr2.mat", "aa3_dr.mat", "aa3_gpsx.mat"
ANGLES = np.radians(np.arange(361) / 2 - 90)
"""Of the beams, counter-clockwise from straight ahead: the first one looks to the right."""

MASK = 2**13 - 1
"""The range is in the lower 13 bits, cm; those above tell how bright the echo was."""

OWN_CALIBRATION = replace(CALIBRATION, per_diameter=0.0)
"""That of the published detections without their error in range: our detector means the middle of a trunk."""


def read_scans(path=None):
    """Read the raw scans.

    Parameters
    ----------
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.

    Returns
    -------
    t : ndarray, shape (K,)
        s.
    ranges : ndarray, shape (K, 361)
        m; 80 and more where no echo came back.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    arrays = _arrays(SCANS, path, ("LASER", "TLsr"))
    laser, t = np.asarray(arrays["LASER"]), np.ravel(arrays["TLsr"])
    if laser.ndim != 2 or laser.shape != (len(t), len(ANGLES)) or not np.issubdtype(laser.dtype, np.integer):
        wanted = f"(scans, {len(ANGLES)}) of whole numbers, a time for each"
        raise ValueError(f"{SCANS}: LASER must be {wanted}; got {laser.shape} of {laser.dtype} and {len(t)} times")
    return t / 1e3, (laser.astype(int) & MASK) / 100.0


def read_raw_log(path=None, detector=TreeDetector()):  # noqa: B008 - a frozen value
    """The log with the trees that our detector finds; odometry and GPS come from whichever file is here.

    Parameters
    ----------
    path : str or Path, optional
        A folder with the files; without it, below the folders of `EKFSLAM_DATA`.
    detector : TreeDetector

    Returns
    -------
    ParkLog

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    t, ranges = read_scans(path)
    offsets, trees = detector(ranges, ANGLES)
    if find_file(ODOMETRY, path) is None and find_file(FILE, path) is not None:
        log = read_log(path)
        return replace(log, scan_t=t, offsets=offsets, detections=trees)
    odometry = _arrays(ODOMETRY, path, ("time", "speed", "steering"))
    gps = _arrays(GPS, path, ("timeGps", "Lo_m", "La_m"))
    columns = lambda a, names: np.column_stack([np.ravel(a[name]).astype(float) for name in names])
    return ParkLog(
        columns(odometry, ("time", "speed", "steering")) / [1e3, 1, 1],
        columns(gps, ("timeGps", "Lo_m", "La_m")) / [1e3, 1, 1],
        t,
        offsets,
        trees,
    )


def _arrays(name, path, wanted):
    file = get_file("Victoria Park", name, path)
    arrays = read_mat(file, wanted)
    missing = [key for key in wanted if key not in arrays]
    if missing:
        raise ValueError(f"{file} is not a file of Victoria Park: it has no array {', '.join(missing)}")
    return arrays
