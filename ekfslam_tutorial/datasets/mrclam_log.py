"""The text files of one MRCLAM set, read and put right: barcodes, order of rows, known errors. No frames, no filter."""

from dataclasses import dataclass, field

import numpy as np

from ..geometry import Frame2, wrap
from .odometry import dead_reckon
from .tables import read_table

ROBOTS = (1, 2, 3, 4, 5)
UNLISTED = 1000
"""A landmark whose barcode is in no list gets the id UNLISTED + barcode."""

SPURIOUS_MAX = 50
"""Misread barcodes come a few times a set (2 to 16 in the published ones); what comes more often is really there."""

TRUTH_STEP, TRUTH_DIGITS = 0.05, 6
"""Dense truth is kept at about this interval, s, and with so many decimals (m, rad): between two rows that far apart a
robot of these sets is off the straight line by less than a millimetre."""

ODOMETRY = ("t [s]", "v [m/s]", "w [rad/s]")
MEASUREMENT = ("t [s]", "barcode", "range [m]", "bearing [rad]")
GROUNDTRUTH = ("t [s]", "x [m]", "y [m]", "theta [rad]")
BARCODES = ("subject", "barcode")
LANDMARKS = ("subject", "x [m]", "y [m]", "sigma x [m]", "sigma y [m]")


@dataclass(frozen=True)
class Sightings:
    """Measurements by one robot: times (m,), s, rising; ids (m,); y (m, 2) range and bearing (m, rad)."""

    t: np.ndarray
    ids: np.ndarray
    y: np.ndarray

    def __len__(self):
        return len(self.t)

    def where(self, mask):
        """The part of them that `mask` selects."""
        return Sightings(self.t[mask], self.ids[mask], self.y[mask])


@dataclass(frozen=True)
class RobotLog:
    """Log of one robot.

    Parameters
    ----------
    robot : int
        Its number, 1 to 5.
    odometry : ndarray, shape (n, 3)
        Commands [t, v, w] (s, m/s, rad/s); times rise.
    landmarks, robots : Sightings
        Of landmarks (ids 6 to 20, or UNLISTED + barcode) and of other robots (ids 1 to 5).
    truth : ndarray, shape (g, 4)
        [t, x, y, theta] (s, m, m, rad), times strictly rising; no rows when there is no ground truth.
    dense : bool
        True if the truth may be interpolated.
    """

    robot: int
    odometry: np.ndarray
    landmarks: Sightings
    robots: Sightings
    truth: np.ndarray
    dense: bool


AT_ONCE = 0.05
"""So near to a stamp of the truth, s, nobody asks how the robot has moved."""


@dataclass(frozen=True)
class SetLog:
    """One set: the logs of some of its robots, and the surveyed landmarks (ids (N,), points (N, 2) in metres)."""

    name: str
    robots: dict
    ids: np.ndarray
    points: np.ndarray
    notes: list = field(default_factory=list)


def read_set(source, robots):
    """Read the files of a set.

    Parameters
    ----------
    source : datasets.sources.Source
        Folder or zip.
    robots : sequence of int
        Which robots' files to read.

    Returns
    -------
    SetLog
        Its notes say, in words, all that was dropped or put right.

    Raises
    ------
    FileNotFoundError, ValueError
        A file is missing or damaged (see `read_table`), or a robot is not one of 1 to 5.
    """
    check_robots(robots)
    notes = []
    subjects = _read_barcodes(source)
    survey = read_table(source, "Landmark_Groundtruth.dat", LANDMARKS)
    ids = _whole(source, "Landmark_Groundtruth.dat", survey[:, 0])
    without = sorted({*ROBOTS, *ids.tolist()} - set(subjects.values()))
    if without:
        notes.append(f"subjects {without} have no barcode in Barcodes.dat")
    logs = {r: _read_robot(source, r, subjects, notes) for r in robots}
    log = SetLog(source.path.stem, logs, ids, survey[:, 1:3], notes)
    return _check_survey(log)


def check_robots(robots):
    """Refuse what is not a choice of the five robots."""
    robots = list(robots)
    whole = all(isinstance(r, int | np.integer) for r in robots)
    if not robots or not whole or not set(robots) <= set(ROBOTS) or len(set(robots)) < len(robots):
        raise ValueError(f"MRCLAM robots must be some of {list(ROBOTS)}, each once; got {robots}")


def _read_barcodes(source):
    """Barcode -> subject; the numbers differ from set to set."""
    table = _whole(source, "Barcodes.dat", read_table(source, "Barcodes.dat", BARCODES))
    for name, column in zip(BARCODES, table.T, strict=True):
        values, counts = np.unique(column, return_counts=True)
        if (counts > 1).any():
            raise ValueError(f"{source.path}: Barcodes.dat has the {name} {values[counts > 1][0]} twice")
    return {int(b): int(s) for s, b in table}


def _whole(source, name, values):
    """Numbers of subjects and barcodes, which a file may write as 72 or 72.0."""
    wrong = values[(values != np.round(values)) | (abs(values) > 10**6)]
    if len(wrong):
        raise ValueError(f"{source.path}: {name} has the subject or barcode {wrong[0]:g}, which is no such number")
    return values.astype(int)


def _read_robot(source, robot, subjects, notes):
    odometry = _read_odometry(source, robot, notes)
    sightings = _read_sightings(source, robot, subjects, notes)
    truth, dense = _read_truth(source, robot, notes)
    met = np.isin(sightings.ids, ROBOTS)
    notes.append(f"robot {robot}: {(~met).sum()} sightings of landmarks, {met.sum()} of other robots, kept apart")
    return RobotLog(robot, odometry, sightings.where(~met), sightings.where(met), truth, dense)


def _read_odometry(source, robot, notes):
    """Commands in the order of time. A first row that starts the robot for one tick is what was left from before."""
    odometry = read_table(source, f"Robot{robot}_Odometry.dat", ODOMETRY)
    if len(odometry) > 2 and odometry[0, 1:].any() and not odometry[1:3, 1:].any():
        odometry = odometry[1:]
        notes.append(f"robot {robot}: first odometry row dropped, a command left over from before")
    odometry = _sorted(odometry, f"robot {robot}: odometry", notes)
    gaps = np.diff(odometry[:, 0])[odometry[:-1, 1:].any(axis=1)]
    if (gaps > 0.5).any():
        notes.append(
            f"robot {robot}: {(gaps > 0.5).sum()} odometry gaps of up to {gaps.max():.1f} s under way: command held"
        )
    return odometry


def _read_sightings(source, robot, subjects, notes):
    name = f"Robot{robot}_Measurement.dat"
    rows = read_table(source, name, MEASUREMENT)
    rows = _sorted(rows, f"robot {robot}: measurement", notes)
    rows = rows[np.sort(np.unique(rows[:, :2], axis=0, return_index=True)[1])]  # one a stamp and barcode
    barcode = _whole(source, name, rows[:, 1])
    ids = np.array([subjects.get(b, UNLISTED + b) for b in barcode])
    counts = dict(zip(*np.unique(ids[ids > UNLISTED], return_counts=True), strict=True))
    for i, n in counts.items():
        what = f"robot {robot}: barcode {i - UNLISTED} is not in Barcodes.dat, {n} sightings"
        notes.append(f"{what}: " + ("spurious, dropped" if n < SPURIOUS_MAX else f"landmark {i}, never surveyed"))
    spurious = np.isin(ids, [i for i, n in counts.items() if n < SPURIOUS_MAX]) | (rows[:, 2] <= 0) | (ids == robot)
    return Sightings(rows[:, 0], ids, np.stack([rows[:, 2], wrap(rows[:, 3])], 1)).where(~spurious)


def _read_truth(source, robot, notes):
    """Dense truth, or else sparse: several rows at one stamp are one instant, their mean counts."""
    names = source.names()
    dense, sparse = f"Robot{robot}_Groundtruth.dat", f"Robot{robot}_Groundtruth_sparse.csv"
    if dense in names:
        rows = _sorted(read_table(source, dense, GROUNDTRUTH), f"robot {robot}: ground truth", notes)
        return _thinned(rows[np.concatenate([[True], np.diff(rows[:, 0]) > 0])]), True
    if sparse not in names:
        notes.append(f"robot {robot}: no ground truth")
        return np.zeros((0, 4)), False
    rows = read_table(source, sparse, GROUNDTRUTH, separator=",")
    t, instant = np.unique(rows[:, 0], return_inverse=True)
    columns = [rows[:, 1], rows[:, 2], np.cos(rows[:, 3]), np.sin(rows[:, 3])]
    x, y, c, s = (np.bincount(instant, a) / np.bincount(instant) for a in columns)
    notes.append(f"robot {robot}: ground truth at {len(t)} instants only")
    return np.stack([t, x, y, np.arctan2(s, c)], 1), False


def _thinned(rows):
    """The rows that begin an interval of TRUTH_STEP, those beside a gap, and the last one."""
    t = rows[:, 0]
    begins = np.diff(t // TRUTH_STEP, prepend=-np.inf) > 0
    gap = np.diff(t) > TRUTH_STEP
    keep = begins | np.append(gap, True) | np.append(True, gap)
    return np.column_stack([t[keep], rows[keep, 1:].round(TRUTH_DIGITS)])


def _sorted(rows, what, notes):
    """Rows by time; rows of one time keep their order."""
    late = (np.diff(rows[:, 0]) < 0).sum()
    if late:
        notes.append(f"{what}: {late} rows out of order, sorted by time")
    return rows[np.argsort(rows[:, 0], kind="stable")]


def truth_at(log, times, tolerance=0.05, gap=1.0):
    """True poses of a robot at given times.

    Parameters
    ----------
    log : RobotLog
    times : ndarray, shape (F,)
    tolerance : float
        A sparse truth counts for the frame nearest to it if that is at most so far away, s.
    gap : float
        A dense truth is interpolated across at most so many seconds.

    Returns
    -------
    ndarray, shape (F, 3)
        [x, y, theta], theta in (-pi, pi]; NaN where unknown.
    """
    out = np.full((len(times), 3), np.nan)
    if not len(log.truth) or not len(times):
        return out
    t, pose = log.truth[:, 0], log.truth[:, 1:]
    if log.dense:
        pose = np.column_stack([pose[:, :2], np.unwrap(pose[:, 2])])
        after = np.clip(np.searchsorted(t, times), 1, max(len(t) - 1, 1))
        known = (times >= t[0]) & (times <= t[-1]) & (np.diff(t, append=np.inf)[after - 1] <= gap)
        out[known] = np.stack([np.interp(times[known], t, c) for c in pose.T], 1)
    else:
        nearest = abs(times[:, None] - t).argmin(axis=0)
        near = abs(times[nearest] - t) <= tolerance
        out[nearest[near]] = pose[near]
    out[:, 2] = wrap(out[:, 2])
    return out


def _truth_near(log, times, tolerance=1.0):
    """Poses by the nearest stamp of a sparse truth, and the odometry since; NaN where that is further away, s."""
    t = log.truth[:, 0]
    after = np.clip(np.searchsorted(t, times), 1, max(len(t) - 1, 1))
    near = np.minimum(np.where(times - t[after - 1] < t[after % len(t)] - times, after - 1, after), len(t) - 1)
    out, drives = np.full((len(times), 3), np.nan), len(log.odometry) > 1
    known = abs(times - t[near]) <= (tolerance if drives else AT_ONCE)
    out[known] = log.truth[near[known], 1:]
    if drives:
        path = dead_reckon(*log.odometry.T)
        driven = lambda at: Frame2(np.column_stack([np.interp(at, log.odometry[:, 0], c) for c in path.T]))
        step = driven(t[near[known]]).inverse()[0].compose(driven(times[known]))[0]
        out[known] = Frame2(out[known]).compose(step)[0].x
    return out


def _check_survey(log):
    """Interchange surveyed landmarks that the robots saw in each other's places (set 1: subjects 11 and 17).

    The survey is only used to judge a map, never to make one; so this looks at the ground truth.
    """
    seen = _seen_places(log)
    points = log.points.copy()
    at = {int(i): k for k, i in enumerate(log.ids)}
    for i in sorted(seen.keys() & at.keys()):
        for j in sorted(at.keys() - {i}):
            own, other = (np.linalg.norm(seen[i] - log.points[at[k]]) for k in (i, j))
            back = np.linalg.norm(seen[j] - log.points[at[i]]) if j in seen else 0.0
            if own > 1.0 and other < 0.5 and back < 0.5 and np.array_equal(points[at[i]], log.points[at[i]]):
                points[[at[i], at[j]]] = points[[at[j], at[i]]]
                log.notes.append(f"surveyed places of landmarks {i} and {j} are interchanged in the files: put right")
    return SetLog(log.name, log.robots, log.ids, points, log.notes)


def _seen_places(log):
    """Landmark -> where the robots saw it, by their true poses: the median over at least 20 sightings."""
    ids, places = [], []
    for robot in log.robots.values():
        if len(robot.truth):
            x, y, theta = (truth_at if robot.dense else _truth_near)(robot, robot.landmarks.t).T
            r, b = robot.landmarks.y.T
            ids.append(robot.landmarks.ids)
            places.append(np.stack([x + r * np.cos(theta + b), y + r * np.sin(theta + b)], 1))
    if not ids:
        return {}
    ids, places = np.concatenate(ids), np.concatenate(places)
    known = np.isfinite(places[:, 0])
    ids, places = ids[known], places[known]
    return {int(i): np.median(places[ids == i], axis=0) for i in np.unique(ids) if (ids == i).sum() >= 20}
