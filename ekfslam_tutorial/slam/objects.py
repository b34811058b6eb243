"""The manual's structures: Rob, Sen, Lmk, Obs, Tim (figures 4 to 9), and what happens to them: Event.

Each record knows its range `r` in the map. A range of `None` means that the state is *known*: the object holds it
itself, in `x`, and the filter leaves it alone.
"""

import html
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np

from ..ekf import Innovation
from ..ekf.html import table_html
from ..models.landmarks.lines import ends
from ..models.moving import Moving


def _state(map, obj):
    """State of an object: a copy, so what was read from the map stays what it was when the map goes on."""
    if obj.r is None and obj.x is None:
        raise ValueError(f"{type(obj).__name__} {obj.id} has no state yet: put it into the map, or give it a known x")
    return np.array(obj.x, float) if obj.r is None else map.state(obj.r)


def states(map, objs):
    """States of several objects of one type, one in each row."""
    return np.array([obj.x if obj.r is None else map.x[obj.r] for obj in objs], float)


def _where(obj):
    """Place of the state of an object, in words."""
    if obj.r is None:
        return "not in the map" if obj.x is None else "known"
    return f"in the map at {obj.r.start}:{obj.r.stop}"


def _title(obj):
    """Id, and name where there is one."""
    return f"{obj.id} {obj.name!r}" if obj.name else str(obj.id)


class _Shown:
    """View of an object in a notebook: its line, and below it its attributes."""

    def _repr_html_(self):
        rows = [(f.name, short(getattr(self, f.name))) for f in fields(self) if f.repr]  # pyright: ignore
        return f"<b>{html.escape(repr(self))}</b>{table_html(('attribute', 'value'), rows)}"


def short(value):
    """A value in a few words."""
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=3, threshold=40)
    if isinstance(value, slice):
        return f"{value.start}:{value.stop}"
    return value.__name__ if isinstance(value, type) else repr(value)


@dataclass
class Rob(_Shown):
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
        Control of this frame and its covariance; or several, one after the other, a row for each.
    dt : float or ndarray
        How many seconds it acts, or each of several.
    sensors : list of int
        Ids of the sensors it carries.
    n_refused : int
        How many of its innovations in a row have failed the gate.
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
    dt: Any = None
    sensors: list = field(default_factory=list)
    n_refused: int = 0
    first: Any = field(default=None, repr=False)

    def __repr__(self):
        return f"Rob({_title(self)}, {type(self.motion).__name__}, {_where(self)}, sensors {self.sensors})"

    def state(self, map):
        """State vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame2 or Frame3 of the robot in the world."""
        return self.motion.frame(self.state(map)[: self.motion.frame.size])

    def moving(self, map):
        """Frame and velocity, for a sensor that asks for them."""
        return Moving(self.motion, self.state(map), self.u)


@dataclass
class Sen(_Shown):
    """A sensor on a robot.

    Attributes
    ----------
    id, name : int, str
    robot : int
        Id of the robot that carries it.
    model : SensorModel
        Holds the parameters (manual: `par`). `Calibrated`, where some of them are states.
    x : ndarray or None
        Frame on the robot, [x y theta] or [t; q], where it is known; parameters that are states stand behind it.
    r : slice or None
        Range of all of that in the map, for self-calibration (manual: `frameInMap`).
    frame_type : type
        Frame2 or Frame3; `state_class` makes one with parameters of it.
    lmk_type : LmkType or None
        How landmarks that this sensor finds are stored; `Options.lmk_type` if None.
    tilt : float
        Its mounting gives way, with the frame in the map: random walk of each of its angles, rad/sqrt(s).
    walk : float or ndarray
        The same of its parameters that are states: of each its unit per sqrt(s).
    """

    id: int
    robot: int
    model: Any
    frame_type: Any
    name: str = ""
    x: Any = None
    r: slice | None = None
    lmk_type: Any = None
    tilt: float = 0.0
    walk: Any = 0.0

    def __repr__(self):
        return f"Sen({_title(self)}, {type(self.model).__name__} on robot {self.robot}, frame {_where(self)})"

    def state(self, map):
        """Frame vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame of the sensor on its robot."""
        return self.frame_type(self.state(map))


@dataclass(eq=False)
class Lmk(_Shown):
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
    par : ndarray or None
        Parameters that are known of it and are no states (manual: `par`). Of a line: where its ends are, two abscissas.
    n_search, n_match, n_inlier : int
        How often it was looked for, found, and used.
    n_refused : int
        How many of its innovations in a row have failed the gate; counted with `retry_after`.
    n_missed : int
        How often in a row it has not been found; counted with `lost_after` and `wander`.
    first : ndarray or None
        The state at birth, for first-estimates Jacobians; None without them.
    appearance : object
        What it looks like, for an association that asks (manual: `sig`); None where nobody does.
    """

    id: int
    type: Any
    x: Any = None
    r: slice | None = None
    slot: int = 0
    n: np.ndarray | None = None
    N: np.ndarray | None = None
    par: Any = None
    n_search: int = 1
    n_match: int = 1
    n_inlier: int = 1
    n_refused: int = 0
    n_missed: int = 0
    first: Any = field(default=None, repr=False)
    appearance: Any = field(default=None, repr=False)

    def __repr__(self):
        counts = f"searched {self.n_search}, matched {self.n_match}, used {self.n_inlier}"
        return f"Lmk({self.id}, {type(self.type).__name__}, {_where(self)}, {counts})"

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
        return p, self._spread(map, P_l)

    def ends(self, map):
        """Ends of a line, as far as it has been seen, and their covariances.

        Returns
        -------
        p : ndarray, shape (2, 3)
            Metres.
        P : ndarray, shape (2, 3, 3)
        """
        p, P_l = ends(self.type, self.state(map), self.par)
        return p, np.array([self._spread(map, J) for J in P_l])

    def _spread(self, map, P_l):
        """Covariance of what depends on its state by the Jacobian P_l; zero for a known landmark."""
        return np.zeros((len(P_l), len(P_l))) if self.r is None else P_l @ map.block(self.r) @ P_l.T


@dataclass(eq=False)
class Obs(_Shown):
    """The observation of one landmark by one sensor in this frame (manual, fig. 9).

    Attributes
    ----------
    sen, lmk : int, int
        Ids.
    e, E : ndarray, shape (m,) and (m, m)
        Expectation, and its covariance H P H'.
    v : ndarray, shape (d,)
        Point in the sensor frame, or ray towards it.
    blocks : tuple of 3 (slice or None, ndarray of shape (m, ·))
        (rob.r, E_r), (sen.r, E_s), (lmk.r, E_l): the states it depends on, and its Jacobians. Of a robot it is the
        frame, or its whole state if the sensor asks for its velocity.
    visible : bool
        The sensor should see it.
    y, R : ndarray, shape (m,) and (m, m), or None
        Measurement and its covariance, once matched.
    z : ndarray, shape (m,), or None
        Innovation.
    index : int or None
        Which of this frame's raw measurements it is.
    measured, matched, updated : bool
        It was looked for; a measurement was found; that was used for a correction.
    """

    sen: int
    lmk: int
    e: Any
    E: Any
    v: Any
    blocks: Any = field(repr=False)
    visible: bool = True
    y: Any = None
    R: Any = None
    z: Any = None
    index: int | None = None
    measured: bool = False
    matched: bool = False
    updated: bool = False

    E_r = property(lambda self: self.blocks[0][1], doc="Jacobian of the expectation by the robot's frame.")
    E_s = property(lambda self: self.blocks[1][1], doc="Jacobian of the expectation by the sensor's frame.")
    E_l = property(lambda self: self.blocks[2][1], doc="Jacobian of the expectation by the landmark.")

    @property
    def Z(self):
        """Covariance of the innovation, E + R; None without a measurement."""
        return None if self.R is None else self.E + self.R

    @property
    def md2(self):
        """Squared Mahalanobis distance of the innovation; None without a measurement."""
        return None if self.z is None else Innovation(self.z, self.E + self.R).md2

    def __repr__(self):
        fate = "used" if self.updated else "refused" if self.matched else "not seen" if self.visible else "out of view"
        return f"Obs(landmark {self.lmk} by sensor {self.sen}, expected {short(self.e)}, {fate})"

    def _repr_html_(self):
        rows = [(name, short(getattr(self, name))) for name in ("e", "E", "y", "R", "z", "Z", "md2")]
        return f"<b>{html.escape(repr(self))}</b>{table_html(('attribute', 'value'), rows)}"


@dataclass
class Tim:
    """Time: numbers of the first and the last frame, and the sampling period in seconds (manual, fig. 8)."""

    first: int
    last: int
    dt: float


class Event(NamedTuple):
    """One thing that a step did; a list of them is in the order in which it did them.

    kind is search (flag: a measurement was found), innovation (flag: it passed the gate), correction,
    initialisation, refused (the map was full), deletion, recovery (the gate of a lost robot was opened, lmk is -1; or
    that of a landmark) or meeting (another robot was measured, lmk is its id; flag: it passed the gate).
    """

    kind: str
    rob: int
    sen: int
    lmk: int
    flag: bool = True
