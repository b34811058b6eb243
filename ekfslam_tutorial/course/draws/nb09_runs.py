"""Logs for notebook 09: a real MRCLAM log where there is one, and the simulated twin everywhere."""

import tempfile
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ...datasets import mrclam, mrclam_twin
from ...datasets.mrclam_log import MEASUREMENT, ODOMETRY, SetLog, Sightings, read_set, truth_at
from ...datasets.tables import read_table

TWIN, REAL = "simulated twin", "real log"
SETS = (7, 9, 1, 2, 3, 4, 5, 6, 8)  # dense ground truth of a tuned set first
REAL_ROBOT, TWIN_ROBOT = 2, 3
SECONDS = 300.0  # of a log; a whole real one takes a quarter of a minute


def here():
    """Which log the notebook uses: REAL if a set of MRCLAM is found, else TWIN."""
    return REAL if _real_source() is not None else TWIN


def _real_source():
    return next((s for s in map(mrclam.find_set, SETS) if s is not None), None)


@dataclass(frozen=True)
class Files:
    """One robot's files as they are, and the same as the loader of the package reads them."""

    name: str
    robot: int
    barcodes: np.ndarray  # [subject, barcode]
    sightings: np.ndarray  # [t, barcode, range, bearing], in the order of the file
    odometry: np.ndarray  # [t, v, w], in the order of the file
    log: SetLog

    @property
    def start(self):
        """Time of the first sighting, s."""
        return self.sightings[:, 0].min()

    def truth(self, times):
        """True poses at some times, shape (n, 3); NaN where they are not known."""
        return truth_at(self.log.robots[self.robot], np.asarray(times))

    def surveyed(self, ids):
        """Surveyed places of some landmarks, shape (n, 2); NaN where there is none."""
        places = dict(zip(self.log.ids.tolist(), self.log.points, strict=True))
        return np.array([places.get(int(i), (np.nan, np.nan)) for i in ids])


@cache
def files(which=TWIN):
    """The first `SECONDS` of a log."""
    if which == REAL:
        source = _real_source()
        if source is None:
            raise FileNotFoundError("no set of MRCLAM is found; set EKFSLAM_DATA to the folder with your data sets")
        return _files(source, REAL_ROBOT)
    with tempfile.TemporaryDirectory() as folder:
        path = mrclam_twin.write(Path(folder) / "MRCLAM_Twin", 1, SECONDS, robots=(TWIN_ROBOT,))
        return _files(mrclam.find_set(1, path), TWIN_ROBOT)


def _files(source, robot):
    sightings = read_table(source, f"Robot{robot}_Measurement.dat", MEASUREMENT)
    odometry = read_table(source, f"Robot{robot}_Odometry.dat", ODOMETRY)
    barcodes = read_table(source, "Barcodes.dat", ("subject", "barcode")).astype(int)
    end = sightings[:, 0].min() + SECONDS
    log = _until(read_set(source, (robot,)), robot, end)
    cut = lambda rows: rows[rows[:, 0] < end]
    return Files(source.path.stem, robot, barcodes, cut(sightings), cut(odometry), log)


def _until(log, robot, end):
    """The log of one robot up to a time."""
    one = log.robots[robot]
    cut = lambda s: Sightings(s.t, s.ids, s.y).where(s.t < end)
    odometry = one.odometry[one.odometry[:, 0] < end + 2 * mrclam.HOLD]
    one = replace(one, odometry=odometry, landmarks=cut(one.landmarks), robots=cut(one.robots))
    return replace(log, robots={robot: one}, notes=list(log.notes))
