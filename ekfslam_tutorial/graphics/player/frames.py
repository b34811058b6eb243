"""From the records of a log back to numbers: what a viewer knows in each frame. It is also what checks a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .coding import unpack, unpack_factor

Array = np.ndarray

KEYS = {
    "k",
    "t",
    "rob",
    "true",
    "sen",
    "lmk",
    "gone",
    "new",
    "lin",
    "edge",
    "used",
    "rejected",
    "missed",
    "world",
    "note",
    "img",
    "whole",
}


@dataclass
class LogObs:
    """One measurement of a landmark.

    Parameters
    ----------
    sen, lmk : int
        Ids.
    updated : bool
        Used for a correction; otherwise rejected by the gate.
    md2 : float
        Squared Mahalanobis distance of the innovation.
    z, std : (m,)
        Innovation and its standard deviations, in the sensor's units.
    point : (d,) or None
        The measured point, where the sensor measures distances.
    """

    sen: int
    lmk: int
    updated: bool
    md2: float
    z: Array
    std: Array
    point: Array | None


@dataclass
class LogFrame:
    """One frame of a log, in metres and radians; NaN stands for what was not finite.

    Parameters
    ----------
    k, t : int, float
        Frame number and time.
    robots : dict of int to (x, L, std)
        Pose; factor of the covariance of the position, ``L L' = P``, zero for a known robot; std of the heading (2D).
    truth : dict of int to ndarray
        True poses.
    sens : dict of int to ndarray
        Poses of the sensors on their robots.
    lmks : dict of int to (mean, L)
    lines : dict of int to (ends, L)
        Both ends (2, 3) of each, and a factor for each of them (2, 3, 3).
    obs : list of LogObs
    missed : list of (int, int)
        Sensor and landmark: looked for, and not found.
    new, gone : list of int
    world, edges : dict of int to ndarray
        True landmarks; both ends of true edges.
    notes : list of (str, int)
    """

    k: int
    t: float
    robots: dict[int, tuple[Array, Array, float]]
    truth: dict[int, Array]
    sens: dict[int, Array]
    lmks: dict[int, tuple[Array, Array]]
    obs: list[LogObs]
    missed: list[tuple[int, int]]
    new: list[int]
    gone: list[int]
    world: dict[int, Array]
    notes: list[tuple[str, int]]
    lines: dict[int, tuple[Array, Array]]
    edges: dict[int, Array]


class Decoder:
    """Reads the records of a log in order.

    Parameters
    ----------
    head : dict
        ``dim``, ``robots`` and ``sensors`` of the log.

    Raises
    ------
    ValueError
        If the head, or later a record, is not as `StateLog` describes it.
    """

    def __init__(self, head: dict[str, Any]):
        if head.get("dim") not in (2, 3):
            raise ValueError(f"the dimension of a state log is 2 or 3, got {head.get('dim')!r}")
        self.d, self.n = head["dim"], {2: 3, 3: 7}[head["dim"]]
        try:
            self.robots = {rob["id"] for rob in head["robots"]}
            self.units = {sen["id"]: len(sen["units"]) for sen in head["sensors"]}
            self.points = {sen["id"]: sen["point"] for sen in head["sensors"]}
        except (TypeError, KeyError) as error:
            raise ValueError(
                f"every robot of a state log has an id, every sensor id, units and point: {error!r}"
            ) from error
        self.read_before = 0
        self.lmks: dict[int, tuple[Array, Array]] = {}
        self.sens: dict[int, Array] = {}
        self.world: dict[int, Array] = {}
        self.lines: dict[int, tuple[Array, Array]] = {}
        self.edges: dict[int, Array] = {}

    def read(self, record: dict[str, Any]) -> LogFrame:
        """Return the next frame."""
        where = f"record {self.read_before} of the state log"
        self.read_before += 1
        if not isinstance(record, dict) or not {"k", "t", "rob"} <= set(record) <= KEYS:
            got = sorted(record) if isinstance(record, dict) else type(record).__name__
            raise ValueError(f"{where} must have k, t, rob and may have {', '.join(sorted(KEYS))}; got {got}")
        try:
            return self._read(record)
        except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
            raise ValueError(f"{where} cannot be read: {error}") from error

    def _read(self, record) -> LogFrame:
        d, n = self.d, self.n
        factor = 1 + d * (d + 1) // 2
        if record.get("whole"):
            self.lmks, self.sens, self.world, self.lines, self.edges = {}, {}, {}, {}, {}
        self.lmks = {id: value for id, value in self.lmks.items() if id not in record.get("gone", ())}
        for id, *x in _rows(record, "lmk", (0, d, d + 1, d + factor), null=d + 1):
            self.lmks[id] = self._lmk(x, *self.lmks.get(id, (np.full(d, np.nan), np.full((d, d), np.nan))))
        self.lines = {id: value for id, value in self.lines.items() if id not in record.get("gone", ())}
        self.lines |= {id: self._line(x) for id, *x in _rows(record, "lin", (2 * (d + factor),))}
        self.edges = self.edges | {
            id: unpack(x, 2 * d, 2 * d).reshape(2, d) for id, *x in _rows(record, "edge", (2 * d,))
        }
        self.sens = self.sens | {id: unpack(x, n, d) for id, *x in _rows(record, "sen", (n,))}
        self.world = self.world | {id: unpack(x, d, d) for id, *x in _rows(record, "world", (0, d))}
        robots = {id: self._robot(x) for id, *x in _rows(record, "rob", (0, n, n + factor + (d == 2)))}
        return LogFrame(
            k=record["k"],
            t=float(record["t"]),
            robots=robots,
            truth={id: unpack(x, n, d) for id, *x in _rows(record, "true", (n,))},
            sens=self.sens,
            lmks=self.lmks,
            obs=[
                self._obs(int(sen), row, kind == "used")
                for kind in ("used", "rejected")
                for sen, rows in record.get(kind, {}).items()
                for row in rows
            ],
            missed=[(int(sen), lmk) for sen, lmks in record.get("missed", {}).items() for lmk in lmks],
            new=list(record.get("new", ())),
            gone=list(record.get("gone", ())),
            world=self.world,
            notes=[(what, lmk) for what, lmk in record.get("note", ())],
            lines=self.lines,
            edges=self.edges,
        )

    def _robot(self, x) -> tuple[Array, Array, float]:
        d, n = self.d, self.n
        if len(x) <= n:  # known, or nowhere
            return unpack(x, n, d), np.zeros((d, d)), 0.0
        size = 1 + d * (d + 1) // 2
        std = float(unpack(x[n + size :], 1, 0)[0]) if d == 2 else np.nan
        return unpack(x[:n], n, d), unpack_factor(x[n : n + size], d), std

    def _lmk(self, x, mean, L) -> tuple[Array, Array]:
        """Return mean and factor: nowhere, moved on, or moved on and given another covariance."""
        d = self.d
        if not x:
            return np.full(d, np.nan), np.full((d, d), np.nan)
        factor = L if len(x) == d else unpack_factor([] if x[d] is None else x[d:], d)
        return np.where(np.isfinite(mean), mean, 0.0) + unpack(x[:d], d, d), factor

    def _line(self, x) -> tuple[Array, Array]:
        """Return both ends and their factors."""
        d = self.d
        cov = np.reshape(x[2 * d :], (2, -1)).tolist()
        return unpack(x[: 2 * d], 2 * d, 2 * d).reshape(2, d), np.array([unpack_factor(c, d) for c in cov])

    def _obs(self, sen, row, updated) -> LogObs:
        m, d = self.units[sen], self.d
        n = 2 + 2 * m
        if len(row) not in (n, n + d * self.points[sen]):
            raise ValueError(f"an observation by sensor {sen} has {n} numbers and perhaps a point, got {row}")
        md2, *numbers = (np.nan if v is None else float(v) for v in row[1:n])
        std = np.array(numbers[m:])
        point = unpack(row[n:], d, d) if len(row) > n else None
        return LogObs(sen, row[0], updated, md2 / 100, np.array(numbers[:m]) / 100 * std, std, point)


def _rows(record, key, lengths, null=None):
    """Return the rows of integers under a key; each has an id and one of the lengths. One of length `null` ends so."""
    rows = record.get(key, ())
    for row in rows:
        numbers = row[:-1] if len(row) - 1 == null and row[-1] is None else row
        if len(row) - 1 not in lengths or not all(type(v) is int for v in numbers):
            words = " or ".join(map(str, sorted(set(lengths))))
            raise ValueError(f"a row of '{key}' is an id and {words} whole numbers, got {row}")
    return rows
