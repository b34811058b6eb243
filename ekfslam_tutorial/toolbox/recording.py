"""Recordings: controls and measurements of a run, real or simulated, which `universal_slam` plays back.

A recording is stored as one npz file (small, exact, fast) or as a folder of CSV files (to read, to make by hand, to
load anywhere); see `recording_csv`. Both keep every bit of every number.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..simulation import SimLmk, SimObs
from .archives import DAMAGE, brief, read_npz
from .checks import covariances, numbers

FORMAT = "ekfslam recording 1"
YEARS = 1e8
"""Seconds, 3 years: a log that begins later has the time of day in it."""


@dataclass(frozen=True)
class ControlLog:
    """Controls of one robot: row k takes it from frame k-1 to frame k.

    Parameters
    ----------
    u : ndarray, shape (F, nu)
        In the units of its motion model, SI and radians.
    U : ndarray, shape (F, nu, nu), optional
        Covariance of each. Without it the scenario's control noise holds.
    """

    u: np.ndarray
    U: np.ndarray | None = None

    def __post_init__(self):
        object.__setattr__(self, "u", numbers("controls u", self.u, 2))
        if self.U is not None:
            object.__setattr__(self, "U", _one_each("control covariances U", self.U, self.u))

    def __len__(self):
        return len(self.u)


@dataclass(frozen=True)
class RawLog(Sequence):
    """Measurements of one sensor over all frames: a sequence of F `SimObs`, kept as flat arrays.

    Parameters
    ----------
    sen : int
        Sensor id.
    offsets : ndarray of int, shape (F + 1,)
        Frame k owns rows offsets[k] to offsets[k + 1] of the arrays below.
    ids : ndarray of int, shape (M,)
        Landmark ids, -1 where not known.
    y : ndarray, shape (M, m)
    R : ndarray, shape (M, m, m), optional
        Noise covariance of each measurement, where it is not the sensor's.
    """

    sen: int
    offsets: np.ndarray
    ids: np.ndarray
    y: np.ndarray
    R: np.ndarray | None = None

    def __post_init__(self):
        offsets, ids = np.asarray(self.offsets), np.asarray(self.ids)
        for name, a in (("offsets", offsets), ("ids", ids)):
            if a.ndim != 1 or not np.issubdtype(a.dtype, np.integer):
                raise ValueError(f"sensor {self.sen}: {name} must be whole numbers in one row, got {_kind(a)}")
        y = numbers(f"sensor {self.sen}: measurements y", self.y, 2)
        if len(ids) != len(y):
            raise ValueError(f"sensor {self.sen}: {len(ids)} landmark ids for {len(y)} measurements")
        if len(offsets) < 1 or offsets[0] != 0 or offsets[-1] != len(y) or (np.diff(offsets) < 0).any():
            raise ValueError(f"sensor {self.sen}: offsets must rise from 0 to the {len(y)} measurements there are")
        for name, value in (("offsets", offsets), ("ids", ids), ("y", y)):
            object.__setattr__(self, name, value)
        if self.R is not None:
            object.__setattr__(self, "R", _one_each(f"sensor {self.sen}: covariances R", self.R, y))

    @classmethod
    def of(cls, sen, observations):
        """Pack a list of F `SimObs`; all of them, or none, have an R."""
        filled = [o for o in observations if len(o.ids)]
        offsets = np.cumsum([0, *(len(o.ids) for o in observations)])
        if not filled:
            m = max((np.shape(o.y)[-1] for o in observations if np.ndim(o.y) == 2), default=0)
            return cls(sen, offsets, np.zeros(0, int), np.zeros((0, m)))
        with_R = [o.R is not None for o in filled]
        if any(with_R) and not all(with_R):
            raise ValueError(f"sensor {sen}: some frames have a covariance R and some do not; give all or none")
        y = np.concatenate([o.y for o in filled])
        R = np.concatenate([o.R for o in filled]) if all(with_R) else None
        return cls(sen, offsets, np.concatenate([np.asarray(o.ids, int) for o in filled]), y, R)

    def __len__(self):
        return len(self.offsets) - 1

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        if not -len(self) <= k < len(self):
            raise IndexError(f"frame {k} of {len(self)}")
        k = k % len(self)
        rows = slice(self.offsets[k], self.offsets[k + 1])
        return SimObs(self.sen, self.ids[rows], self.y[rows], None if self.R is None else self.R[rows])


@dataclass
class Recording:
    """What robots did and saw, frame by frame, and the truth as far as it is known.

    Parameters
    ----------
    name : str
    t : ndarray, shape (F,)
        Seconds since the start, never falling. The step of frame k lasts t[k] - t[k-1], with t[-1] = 0.
    robots : dict of int to ControlLog
        By robot id; a bare array of controls will do.
    raw : dict of int to RawLog
        By sensor id; a list of F `SimObs` will do.
    truth : dict of int to ndarray, shape (F, 3) or (F, 7)
        True pose of each robot, NaN in the rows where it is not known.
    landmarks : SimLmk, optional
        True landmarks: ids (N,) and points (N, 2) or (N, 3).
    notes : list of str
        What a reader should know: origin, corrections made, rows dropped.
    met : dict of int to RawLog
        By sensor id: measurements of other robots. Their ids are those of robots; they never mean landmarks.
    by_event : bool
        True: there is a frame whenever some sensor measured, and one without measurements in it did not look then.
        False: every sensor looks in every frame.
    fixes : dict of int to ndarray, shape (g, 3) or (g, 4)
        By robot id: time, s, and position as a satellite receiver gives it, to compare with. The estimator does not see
        them, and they are no truth.
    """

    name: str
    t: np.ndarray
    robots: dict
    raw: dict
    truth: dict = field(default_factory=dict)
    landmarks: SimLmk | None = None
    notes: list = field(default_factory=list)
    met: dict = field(default_factory=dict)
    by_event: bool = False
    fixes: dict = field(default_factory=dict)

    def __post_init__(self):
        self.t = numbers("times t", self.t, 1)
        late = np.flatnonzero(np.diff(self.t, prepend=0.0) < 0)
        if len(late):
            raise ValueError(f"times t must start at 0 or later and not fall, but frame {late[0]} does")
        if len(self.t) and self.t[0] > YEARS:
            raise ValueError(
                f"times t are seconds since the start, but begin at {self.t[0]:.1f}: subtract the first one"
            )
        self.robots = {i: c if isinstance(c, ControlLog) else ControlLog(c) for i, c in self.robots.items()}
        self.raw, self.met = (
            {i: o if isinstance(o, RawLog) else RawLog.of(i, o) for i, o in logs.items()}
            for logs in (self.raw, self.met)
        )
        self.truth = {i: _truth(i, x) for i, x in self.truth.items()}
        for kind, logs in (
            ("controls of robot", self.robots),
            ("measurements of sensor", self.raw),
            ("sightings of robots by sensor", self.met),
        ):
            self._check_frames(kind, logs)
        self._check_frames("truth of robot", self.truth)
        self.fixes = {i: _fixes(i, table) for i, table in self.fixes.items()}
        if self.landmarks is not None:
            self.landmarks = checked_landmarks(*_pair(self.landmarks))
        self.notes = [str(note) for note in self.notes]

    def _check_frames(self, kind, logs):
        for i, log in logs.items():
            if len(log) != len(self):
                raise ValueError(f"{kind} {i}: {len(log)} frames, but the recording has {len(self)} times t")

    def __len__(self):
        return len(self.t)

    def save(self, path):
        """Write an npz file if the name ends in .npz, otherwise a folder of CSV files. Returns the path."""
        path = Path(path)
        if path.suffix == ".npz":
            np.savez_compressed(path, allow_pickle=False, **_to_arrays(self))
        else:
            from .recording_csv import save_csv

            save_csv(self, path)
        return path

    @classmethod
    def load(cls, path):
        """Read what `save` wrote. Nothing in a file is ever executed.

        Raises
        ------
        FileNotFoundError
        ValueError
            One sentence with the file, and the line of a CSV file, that is wrong.
        """
        path = Path(path)
        if not path.exists():
            raise FileNotFoundError(f"no recording at {path}: give an .npz file or a folder of CSV files")
        if path.is_dir():
            from .recording_csv import load_csv

            return load_csv(path)
        if path.suffix == ".csv":
            raise ValueError(f"{path} is one file of a recording: give the folder that it is in")
        try:
            return _from_arrays(read_npz(path))
        except KeyError as error:
            raise ValueError(f"{path} is not a whole recording: it has no array {brief(error)}") from error
        except DAMAGE as error:
            raise ValueError(f"{path} is not a whole recording: {brief(error)}") from error


class Recorder:
    """Collects the frames of a run into a `Recording`.

    Examples
    --------
    >>> recorder = Recorder()
    >>> for snapshot in universal_slam(userdata):
    ...     recorder.add(snapshot)
    >>> recorder.recording("my run").save("my_run.npz").name
    'my_run.npz'
    """

    def __init__(self):
        self._t, self._controls, self._raw, self._met, self._truth, self._landmarks = [], {}, {}, {}, {}, None

    def add(self, snapshot):
        """Keep one frame: copies of the controls, the raw data and the true poses."""
        self._t.append(snapshot.t)
        self._landmarks = snapshot.sim_lmk
        for rob in snapshot.robs:
            self._controls.setdefault(rob.id, []).append((np.array(rob.u), np.array(rob.U)))
        for sen, obs in snapshot.raw.items():
            self._raw.setdefault(sen, []).append(obs)
        for sen, obs in snapshot.met.items():
            self._met.setdefault(sen, []).append(obs)
        for rob, x in snapshot.truth.items():
            self._truth.setdefault(rob, []).append(np.array(x))

    def recording(self, name, notes=()):
        """The recording of all frames so far."""
        robots = {}
        for i, controls in self._controls.items():
            u, U = zip(*controls, strict=True)
            robots[i] = ControlLog(np.array(u), np.array(U))
        truth = {i: np.array(x) for i, x in self._truth.items()}
        return Recording(name, np.array(self._t), robots, self._raw, truth, self._landmarks, list(notes), self._met)


def _to_arrays(rec):
    arrays = {"format": FORMAT, "name": rec.name, "notes": np.array(rec.notes, dtype=str), "t": rec.t}
    arrays |= {
        "by_event": rec.by_event,
        "robots": np.array(list(rec.robots), int),
        "sensors": np.array(list(rec.raw), int),
    }
    for i, log in rec.robots.items():
        arrays |= {f"robot{i}_u": log.u} | ({} if log.U is None else {f"robot{i}_U": log.U})
    for i, log in rec.raw.items():
        arrays |= _raw_arrays(f"sensor{i}", log)
    for i, log in rec.met.items():
        arrays |= _raw_arrays(f"sensor{i}_met", log)
    arrays |= {f"robot{i}_truth": x for i, x in rec.truth.items()}
    arrays |= {f"robot{i}_fixes": table for i, table in rec.fixes.items()}
    if rec.landmarks is not None:
        arrays |= {"landmark_ids": rec.landmarks.ids, "landmark_points": rec.landmarks.points}
    return arrays | {"arrays": np.array(sorted(arrays))}  # a damaged name is noticed, too


def _raw_arrays(name, log):
    arrays = {f"{name}_offsets": log.offsets, f"{name}_ids": log.ids, f"{name}_y": log.y}
    return arrays | ({} if log.R is None else {f"{name}_R": log.R})


def _raw_log(a, i, name):
    return RawLog(i, a[f"{name}_offsets"], a[f"{name}_ids"], a[f"{name}_y"], a.get(f"{name}_R"))


def _from_arrays(a):
    if str(a["format"]) != FORMAT:
        raise ValueError(f"its format is {str(a['format'])[:40]!r}, known is {FORMAT!r}")
    for name in a["arrays"].tolist() if "arrays" in a else ():
        a[name]  # a KeyError says which one is missing
    robots, sensors = (a[key].tolist() for key in ("robots", "sensors"))
    met = [int(key[6:].removesuffix("_met_ids")) for key in a if re.fullmatch(r"sensor\d+_met_ids", key)]
    return Recording(
        name=str(a["name"]),
        t=a["t"],
        robots={i: ControlLog(a[f"robot{i}_u"], a.get(f"robot{i}_U")) for i in robots},
        raw={i: _raw_log(a, i, f"sensor{i}") for i in sensors},
        truth={i: a[f"robot{i}_truth"] for i in robots if f"robot{i}_truth" in a},
        landmarks=SimLmk(a["landmark_ids"], a["landmark_points"]) if "landmark_ids" in a else None,
        notes=a["notes"].tolist(),
        met={i: _raw_log(a, i, f"sensor{i}_met") for i in met},
        by_event=bool(a.get("by_event", False)),
        fixes={i: a[f"robot{i}_fixes"] for i in robots if f"robot{i}_fixes" in a},
    )


def _kind(a):
    return f"shape {a.shape} of {a.dtype}"


def _one_each(what, a, rows):
    """One covariance for each row of an array (M, m)."""
    a = covariances(what, a, rows.shape[1])
    if len(a) != len(rows):
        raise ValueError(f"{what}: {len(a)} matrices for {len(rows)} rows")
    return a


def _truth(robot, x):
    x = np.asarray(x, float)
    if x.ndim != 2 or x.shape[1] not in (3, 7):
        raise ValueError(f"truth of robot {robot} must have 3 columns (x, y, theta) or 7 (t, q), got shape {x.shape}")
    if np.isinf(x).any():
        raise ValueError(f"truth of robot {robot} must be finite, or NaN where it is not known")
    return x


def _fixes(robot, table):
    table = numbers(f"fixes of robot {robot}", table, 2)
    if table.shape[1] not in (3, 4):
        raise ValueError(f"fixes of robot {robot} must have a time and 2 or 3 coordinates, got shape {table.shape}")
    return table


def _pair(landmarks):
    return (landmarks.ids, landmarks.points) if isinstance(landmarks, SimLmk) else landmarks


def checked_landmarks(ids, points):
    """True landmarks: points in 2D or 3D, each with a whole number of its own, 0 or more.

    Raises
    ------
    ValueError
    """
    points = numbers("landmark points", points, 2)
    ids = np.asarray(ids)
    if ids.shape != points.shape[:1] or not np.issubdtype(ids.dtype, np.integer) or points.shape[1] not in (2, 3):
        raise ValueError(f"landmarks need N whole ids and N points in 2D or 3D, got {_kind(ids)} and {points.shape}")
    unique, counts = np.unique(ids, return_counts=True)
    if len(unique) != len(ids):
        raise ValueError(f"landmark ids must differ from each other, but {unique[counts > 1][0]} stands twice")
    if len(ids) and unique[0] < 0:
        raise ValueError(f"landmark ids must be 0 or more, got {unique[0]}")
    return SimLmk(ids, points)
