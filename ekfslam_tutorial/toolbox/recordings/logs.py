"""Logs of one robot and of one sensor, and the landmarks of a recording: flat arrays, checked when they are made."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...simulation import SimLmk, SimObs
from ..user_input import covariance_stack, finite_array

FORMAT = "ekfslam recording 1"


@dataclass(frozen=True)
class ControlLog:
    """Controls of one robot: row k takes it from frame k-1 to frame k; or several rows do, one after the other.

    Parameters
    ----------
    u : ndarray, shape (M, nu)
        In the units of its motion model, SI and radians.
    U : ndarray, shape (M, nu, nu), optional
        Covariance of each. Without it the scenario's control noise holds.
    offsets : ndarray of int, shape (F + 1,), optional
        Many controls a frame, as those of an IMU: rows offsets[k] to offsets[k + 1] take the robot from frame k-1 to
        frame k. Without it each frame has one row, M = F.
    dt : ndarray, shape (M,), optional
        With `offsets`: for how many seconds each row acts.
    """

    u: np.ndarray
    U: np.ndarray | None = None
    offsets: np.ndarray | None = None
    dt: np.ndarray | None = None

    def __post_init__(self):
        object.__setattr__(self, "u", finite_array("controls u", self.u, 2))
        if self.U is not None:
            object.__setattr__(self, "U", _one_each("control covariances U", self.U, self.u))
        if (self.offsets is None) != (self.dt is None):
            raise ValueError("many controls a frame need both, the offsets of their rows and the seconds dt of each")
        if self.offsets is not None:
            object.__setattr__(self, "offsets", _offsets("controls", self.offsets, len(self.u)))
            dt = finite_array("seconds dt of the controls", self.dt, 1)
            object.__setattr__(self, "dt", dt)
            if dt.shape != self.u.shape[:1] or (dt < 0).any():
                raise ValueError(f"seconds dt of the controls must be {len(self.u)} numbers of 0 or more")

    def __len__(self):
        return len(self.u) if self.offsets is None else len(self.offsets) - 1

    def rows(self, k):
        """Row of frame k: its number, or with `offsets` a slice."""
        return k if self.offsets is None else slice(self.offsets[k], self.offsets[k + 1])


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
    d : ndarray, shape (M, n), optional
        Descriptor of each measurement: what it looks like.
    """

    sen: int
    offsets: np.ndarray
    ids: np.ndarray
    y: np.ndarray
    R: np.ndarray | None = None
    d: np.ndarray | None = None

    def __post_init__(self):
        if np.ma.is_masked(self.ids):
            words = "-1 stands for an id that is not known"
            raise ValueError(f"sensor {self.sen}: ids must not have masked entries: {words}")
        ids = _whole(f"sensor {self.sen}: ids", self.ids)
        y = finite_array(f"sensor {self.sen}: measurements y", self.y, 2)
        if len(ids) != len(y):
            raise ValueError(f"sensor {self.sen}: {len(ids)} landmark ids for {len(y)} measurements")
        offsets = _offsets(f"sensor {self.sen}", self.offsets, len(y), "measurements there are")
        for name, value in (("offsets", offsets), ("ids", ids), ("y", y)):
            object.__setattr__(self, name, value)
        if self.R is not None:
            object.__setattr__(self, "R", _one_each(f"sensor {self.sen}: covariances R", self.R, y))
        if self.d is not None:
            d = finite_array(f"sensor {self.sen}: descriptors d", self.d, 2)
            if len(d) != len(y):
                raise ValueError(f"sensor {self.sen}: {len(d)} descriptors for {len(y)} measurements")
            object.__setattr__(self, "d", d)

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
        y = np.ma.concatenate([o.y for o in filled])  # a mask is kept, and told of by who reads it
        R = np.ma.concatenate([o.R for o in filled]) if all(with_R) else None
        with_d = [o.d is not None for o in filled]
        if any(with_d) and not all(with_d):
            raise ValueError(f"sensor {sen}: some frames have descriptors d and some do not; give all or none")
        d = np.concatenate([o.d for o in filled]) if all(with_d) else None
        return cls(sen, offsets, np.ma.concatenate([np.ma.asarray(o.ids) for o in filled]), y, R, d)

    def __len__(self):
        return len(self.offsets) - 1

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[i] for i in range(*k.indices(len(self)))]
        if not -len(self) <= k < len(self):
            raise IndexError(f"frame {k} of {len(self)}")
        k = k % len(self)
        rows = slice(self.offsets[k], self.offsets[k + 1])
        R, d = (None if a is None else a[rows] for a in (self.R, self.d))
        return SimObs(self.sen, self.ids[rows], self.y[rows], R, d)


def checked_landmarks(ids, points, segment_ids=(), segments=()):
    """Check true landmarks: points in 2D or 3D, and edges, each with a whole number of its own, 0 or more.

    Raises
    ------
    ValueError
    """
    points = finite_array("landmark points", points, 2)
    ids = np.asarray(ids)
    if ids.shape != points.shape[:1] or not np.issubdtype(ids.dtype, np.integer) or points.shape[1] not in (2, 3):
        raise ValueError(f"landmarks need N whole ids and N points in 2D or 3D, got {_kind(ids)} and {points.shape}")
    segments = finite_array("landmark segments", np.reshape(segments, (-1, 6)), 2)
    segment_ids = np.asarray(segment_ids, int)
    if segment_ids.shape != segments.shape[:1] or (len(segments) and points.shape[1] != 3):
        raise ValueError(f"segments need M ids and M pairs of points in 3D, got {_kind(segment_ids)}, {segments.shape}")
    all = np.concatenate([ids, segment_ids])
    unique, counts = np.unique(all, return_counts=True)
    if len(unique) != len(all):
        raise ValueError(f"landmark ids must differ from each other, but {unique[counts > 1][0]} stands twice")
    if len(all) and unique[0] < 0:
        raise ValueError(f"landmark ids must be 0 or more, got {unique[0]}")
    return SimLmk(ids, points, segment_ids, segments)


def _whole(what, a):
    """Read whole numbers in one row."""
    a = np.asarray(a)
    if a.ndim != 1 or not np.issubdtype(a.dtype, np.integer):
        raise ValueError(f"{what} must be whole numbers in one row, got {_kind(a)}")
    return a


def _offsets(what, offsets, n, rows="rows there are"):
    """Read where the rows of each frame begin, and after the last one where they end: at n."""
    offsets = _whole(f"{what}: offsets", offsets)
    if len(offsets) < 1 or offsets[0] != 0 or offsets[-1] != n or (np.diff(offsets) < 0).any():
        raise ValueError(f"{what}: offsets must rise from 0 to the {n} {rows}")
    return offsets


def _kind(a):
    return f"shape {a.shape} of {a.dtype}"


def _one_each(what, a, rows):
    """Read one covariance for each row of an array (M, m)."""
    a = covariance_stack(what, a, rows.shape[1])
    if len(a) != len(rows):
        raise ValueError(f"{what}: {len(a)} matrices for {len(rows)} rows")
    return a
