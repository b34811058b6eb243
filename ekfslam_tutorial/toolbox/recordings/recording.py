"""Recordings: controls and measurements of a run, real or simulated, which `universal_slam` plays back.

A recording is stored as one npz file (`npz_file.py`) or as a folder of CSV files, to read, to make by hand, to load
anywhere (`csv_folder.py`). Both keep every bit of every number, and give back the arguments of `Recording`.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...ekf import check_covariance, real
from ...simulation import SimLmk
from ..files.archives import DAMAGE, brief
from ..user_input import errors_at, finite_array
from .csv_folder import load_csv, save_csv
from .logs import ControlLog, RawLog, checked_landmarks
from .npz_file import load_npz, save_npz

YEARS = 1e8
"""Seconds, 3 years: a log that begins later has the time of day in it."""


@dataclass
class Recording:
    """Controls and measurements of robots, frame by frame, and the truth as far as it is known.

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
    starts : dict of int to (ndarray of shape (n,), ndarray of shape (n, n))
        By robot id: its whole state in the first frame and the covariance of that, as the log itself tells it: an IMU
        at rest knows what is down. For robots whose position the scenario leaves open.
    names : dict of int to str
        What a log calls landmarks whose ids it tells in words, by id.
    t0 : float
        Time of the log, s, from which `t` counts; 0 if nobody has said it.
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
    starts: dict = field(default_factory=dict)
    names: dict = field(default_factory=dict)
    t0: float = 0.0

    def __post_init__(self):
        self.t = finite_array("times t", self.t, 1)
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
        self.starts = {i: _start(i, *start) for i, start in self.starts.items()}
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
        (save_npz if path.suffix == ".npz" else save_csv)(self, path)
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
            values = load_csv(path)
            with errors_at(path):
                return cls(**values)
        if path.suffix == ".csv":
            raise ValueError(f"{path} is one file of a recording: give the folder that it is in")
        try:
            return cls(**load_npz(path))
        except KeyError as error:
            raise ValueError(f"{path} is not a whole recording: it has no array {brief(error)}") from error
        except DAMAGE as error:
            raise ValueError(f"{path} is not a whole recording: {brief(error)}") from error


def _truth(robot, x):
    x = real(f"truth of robot {robot}", x)
    if x.ndim != 2 or x.shape[1] not in (3, 7):
        raise ValueError(f"truth of robot {robot} must have 3 columns (x, y, theta) or 7 (t, q), got shape {x.shape}")
    if np.isinf(x).any():
        raise ValueError(f"truth of robot {robot} must be finite, or NaN where it is not known")
    return x


def _fixes(robot, table):
    table = finite_array(f"fixes of robot {robot}", table, 2)
    if table.shape[1] not in (3, 4):
        raise ValueError(f"fixes of robot {robot} must have a time and 2 or 3 coordinates, got shape {table.shape}")
    return table


def _start(robot, x, P):
    x = finite_array(f"start of robot {robot}", x, 1)
    check_covariance(P, len(x), f"the covariance of the start of robot {robot}")
    return x, np.array(P, float)


def _pair(landmarks):
    return (landmarks.ids, landmarks.points) if isinstance(landmarks, SimLmk) else landmarks
