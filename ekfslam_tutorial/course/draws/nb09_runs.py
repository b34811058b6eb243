"""Logs and runs for notebook 09: a real MRCLAM log where there is one, and the simulated twin everywhere."""

import tempfile
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ...analysis import History
from ...datasets import mrclam, mrclam_twin
from ...datasets.calibration import self_calibration
from ...datasets.mrclam_log import MEASUREMENT, ODOMETRY, SetLog, Sightings, read_set
from ...datasets.tables import read_table
from ...simulation import SimLmk
from ...toolbox import Recording, UserData, universal_slam

TWIN, REAL = "simulated twin", "real log"
SETS = (7, 9, 1, 2, 3, 4, 5, 6, 8)  # dense ground truth of a tuned set first
REAL_ROBOT, TWIN_ROBOT = 2, 3
SECONDS = 300.0  # of a log; a whole real one takes a quarter of a minute
CLOCK_ERROR = 0.2  # s, put into the twin's stamps: the camera's clock is ahead of that of the odometry
OFFSETS = np.round(np.arange(-0.1, 0.61, 0.1), 1)  # s
CLOCK_SECONDS = 60.0


def here():
    """Which log the notebook uses: REAL if a set of MRCLAM is found, else TWIN."""
    return REAL if _real_source() is not None else TWIN


def _real_source():
    return next((s for s in map(mrclam.find_set, SETS) if s is not None), None)


@dataclass(frozen=True)
class Files:
    """One robot's files as they are, and the same as the loader reads them."""

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


def _until(log, robot, end, shift=0.0):
    """The log of one robot up to a time, its sightings shifted in time by `shift`, s."""
    one = log.robots[robot]
    cut = lambda s: Sightings(s.t + shift, s.ids, s.y).where(s.t < end)
    odometry = one.odometry[one.odometry[:, 0] < end + 2 * mrclam.HOLD]
    one = replace(one, odometry=odometry, landmarks=cut(one.landmarks), robots=cut(one.robots))
    return replace(log, robots={robot: one}, notes=list(log.notes))


@cache
def calibration(which=TWIN):
    """How the odometry of a log is scaled and delayed, from the log itself, with clocks that agree."""
    one = files(which).log.robots[files(which).robot]
    s = one.landmarks
    return self_calibration(one.odometry, s.t, s.ids, s.y, mrclam.FAMILY)


def recording(which=TWIN, seconds=SECONDS, shift=0.0, factor=1.0):
    """The log as a recording.

    Parameters
    ----------
    which : str
    seconds : float
        How much of it.
    shift : float
        Added to the stamps of the sightings, s.
    factor : float
        Of the measurement variances that the filter is told.
    """
    f = files(which)
    n = mrclam.SIGHTING_NOISE
    k = np.sqrt(factor)
    noise = mrclam.SightingNoise(n.range_std * k, n.range_growth * k, n.bearing_std * k)
    log = _until(f.log, f.robot, f.start + seconds, shift)
    return mrclam.recording(log, calibration(which), sighting_noise=noise)


def scenario(robot):
    """The scenario of `mrclam_single.toml`, without the deletion of landmarks."""
    options = {"association": "known_ids", "md2_threshold": 13.8, "reopen_after": 4, "reopen_std": [0.3, 0.5]}
    return UserData.from_dict(
        {
            "name": "mrclam",
            "robot": [{"id": robot, "motion": "odometry2", "position": [0, 0], "orientation_deg": 0}],
            "sensor": [
                {"id": robot, "robot": robot, "type": "range_bearing", "range_std": 0.2, "bearing_std_deg": 1.4}
            ],
            "landmark": {"type": "euc_pnt"},
            "options": options,
        }
    )


@dataclass(frozen=True)
class Result:
    """A run of EKF-SLAM over a recording."""

    recording: Recording
    history: History
    maps: list  # of each frame: {landmark: (point, covariance)}
    z: np.ndarray  # (m, 2) innovations, those that failed the gate, too
    Z: np.ndarray  # (m, 2, 2)

    @property
    def summary(self):
        """The figures of merit."""
        return self.history.summary()

    @property
    def nis(self):
        """Squared Mahalanobis distance of each innovation."""
        return np.einsum("ki,ki->k", self.z, np.linalg.solve(self.Z, self.z[..., None])[..., 0])


@cache
def slam(which=TWIN, seconds=SECONDS, shift=0.0, factor=1.0):
    """EKF-SLAM over a log; parameters as in `recording`."""
    played = recording(which, seconds, shift, factor)
    history, maps, z, Z = History("free"), [], [], []
    for s in history.watch(universal_slam(scenario(files(which).robot), played)):
        maps.append({i: tuple(map(np.copy, lmk.point(s.map))) for i, lmk in s.lmks.items()})
        for o in s.obs.values():
            if o.matched and o.z is not None:
                z.append(o.z.copy())
                Z.append(o.Z.copy())
    return Result(played, history, maps, np.array(z), np.array(Z))


def clock_runs(factor=1.0):
    """The twin with a wrong camera clock, corrected by each of `OFFSETS`.

    Returns
    -------
    z : ndarray, shape (K, m, 2)
        Innovations of the same m sightings in each run.
    Z : ndarray, shape (K, m, 2, 2)
    """
    runs = [slam(TWIN, CLOCK_SECONDS, float(np.round(CLOCK_ERROR - c, 3)), factor) for c in OFFSETS]
    return np.array([r.z for r in runs]), np.array([r.Z for r in runs])


def survey(which) -> SimLmk:
    """The surveyed landmarks."""
    log = files(which).log
    return SimLmk(log.ids, log.points)
