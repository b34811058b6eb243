"""The manual's structures: Rob, Sen, Lmk, Obs, Tim (figures 4 to 9).

Each record knows its range `r` in the map. A range of `None` means that the state is *known*: the object holds it
itself, in `x`, and the filter leaves it alone.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np


def _state(map, obj):
    """A copy: what was read from the map stays what it was when the map goes on."""
    if obj.r is None and obj.x is None:
        raise ValueError(f"{type(obj).__name__} {obj.id} has no state yet: put it into the map, or give it a known x")
    return np.array(obj.x) if obj.r is None else map.state(obj.r)


@dataclass
class Rob:
    """A robot.

    Attributes
    ----------
    id, name, type : int, str, str
        The type is a word for the reader; nothing depends on it.
    motion : MotionModel
    x : ndarray or None
        Known state, if the robot is not in the map.
    r : slice or None
        Range of the state in the map: the frame first, then velocities if the motion model has them.
    u, U : ndarray
        Control of this frame and its covariance.
    sensors : list of int
        Ids of the sensors it carries.
    n_refused : int
        How many of its innovations in a row have failed the gate.
    checked_U : ndarray or None
        The control covariance that was last found to be one: it is not tested again while it stays the same.
    first : ndarray or None
        The pose as predicted, before any correction of this frame; None without first-estimates Jacobians.
    """

    id: int
    motion: Any
    name: str = ""
    type: str = ""
    x: Any = None
    r: slice | None = None
    u: Any = None
    U: Any = None
    sensors: list = field(default_factory=list)
    n_refused: int = 0
    checked_U: Any = field(default=None, repr=False)
    first: Any = field(default=None, repr=False)

    def state(self, map):
        """State vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame2 or Frame3 of the robot in the world."""
        return self.motion.frame(self.state(map)[: self.motion.frame.size])


@dataclass
class Sen:
    """A sensor on a robot.

    Attributes
    ----------
    id, name : int, str
    robot : int
        Id of the robot that carries it.
    model : SensorModel
        Holds the parameters (manual: `par`).
    x : ndarray or None
        Frame on the robot, [x y theta] or [t; q], where it is known.
    r : slice or None
        Range of the frame in the map, for self-calibration (manual: `frameInMap`).
    frame_type : type
        Frame2 or Frame3.
    lmk_type : LmkType or None
        How landmarks that this sensor finds are stored; `Options.lmk_type` if None.
    """

    id: int
    robot: int
    model: Any
    frame_type: Any
    name: str = ""
    x: Any = None
    r: slice | None = None
    lmk_type: Any = None
    _known: Any = field(default=None, repr=False)

    def state(self, map):
        """Frame vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame of the sensor on its robot."""
        if self.r is not None:
            return self.frame_type(self.state(map))
        if self._known is None or self._known.x is not self.x:
            self._known = self.frame_type(self.x)  # it never changes: its rotation matrix is computed once
        return self._known


@dataclass
class Lmk:
    """A landmark.

    Attributes
    ----------
    id : int
    type : LmkType
    x : ndarray or None
        Known state, if the landmark is not in the map (localisation).
    r : slice or None
        Range in the map.
    slot : int
        Index in the manual's `Lmk()` array: the first free one at birth.
    n, N : ndarray
        Prior of what its first measurement left open (manual: `nom`), mean and covariance.
    n_search, n_match, n_inlier : int
        How often it was looked for, found, and used.
    first : ndarray or None
        The state at birth, for first-estimates Jacobians; None without them.
    """

    id: int
    type: Any
    x: Any = None
    r: slice | None = None
    slot: int = 0
    n: np.ndarray | None = None
    N: np.ndarray | None = None
    n_search: int = 1
    n_match: int = 1
    n_inlier: int = 1
    first: Any = field(default=None, repr=False)

    def state(self, map):
        """State vector: the map's estimate, or the known one."""
        return _state(map, self)

    def point(self, map):
        """Euclidean point and its covariance.

        Returns
        -------
        p : ndarray, shape (d,)
            Metres.
        P : ndarray, shape (d, d)
            P_l P_ll P_l'; zero for a known landmark.
        """
        p, P_l = self.type.point(self.state(map))
        if self.r is None:
            return p, np.zeros((len(p), len(p)))
        return p, P_l @ map.block(self.r) @ P_l.T


@dataclass(slots=True)
class Obs:
    """The observation of one landmark by one sensor in this frame (manual, fig. 9).

    Attributes
    ----------
    sen, lmk : int
        Ids.
    e, E : ndarray
        Expectation and its covariance.
    blocks : tuple of (slice or None, ndarray)
        (rob.r, E_r), (sen.r, E_s), (lmk.r, E_l): Jacobians of the expectation and the states they belong to.
    v : ndarray
        Point in the sensor frame, or ray towards it.
    visible : bool
        Whether the sensor should see it.
    y, R : ndarray or None
        Measurement and its covariance, once matched.
    index : int or None
        Which of this frame's raw measurements it is.
    z : ndarray or None
        Innovation.
    measured, matched, updated : bool
        A measurement was looked for; found; used for a correction.
    """

    sen: int
    lmk: int
    e: np.ndarray
    E: np.ndarray
    blocks: tuple
    v: np.ndarray
    visible: bool
    y: np.ndarray | None = None
    R: np.ndarray | None = None
    index: int | None = None
    z: np.ndarray | None = None
    measured: bool = False
    matched: bool = False
    updated: bool = False

    @property
    def Z(self):
        """Covariance of the innovation, E + R; None without a measurement."""
        return None if self.R is None else self.E + self.R

    @property
    def md2(self):
        """Squared Mahalanobis distance of the innovation; None without a measurement."""
        return None if self.z is None else float(self.z @ np.linalg.solve(self.E + self.R, self.z))

    @property
    def E_r(self):
        """Jacobian of the expectation by the robot's frame."""
        return self.blocks[0][1]

    @property
    def E_s(self):
        """Jacobian of the expectation by the sensor's frame."""
        return self.blocks[1][1]

    @property
    def E_l(self):
        """Jacobian of the expectation by the landmark."""
        return self.blocks[2][1]


@dataclass
class Tim:
    """Time: numbers of the first and the last frame, and the sampling period in seconds (manual, fig. 8)."""

    first: int
    last: int
    dt: float


class Event(NamedTuple):
    """Something that a step did, in the order in which it did it.

    kind is search (flag: a measurement was found), innovation (flag: it passed the gate), correction,
    initialisation, refused (the map was full), deletion, recovery (the gate of a lost robot was opened; lmk is -1) or
    meeting (another robot was measured, lmk is its id; flag: it passed the gate).
    """

    kind: str
    rob: int
    sen: int
    lmk: int
    flag: bool = True
