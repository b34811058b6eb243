"""The manual's structures: Rob, Sen, Lmk, Tim (figures 4 to 9); Obs is in `sightings.py`.

Each record knows its range `r` in the map. A range of `None` means that the state is *known*: the object holds it
itself, in `x`, and the filter leaves it alone.
"""

import html
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..ekf.html import table_html


def _frame(map, obj, kind):
    """The frame that the state of a robot or a sensor begins with: the same object as long as it stays the same."""
    last, x = obj.last, _state(map, obj)
    if len(x) != kind.size:
        x = x[: kind.size]
    if last is None or last.x.tobytes() != x.tobytes():
        obj.last = last = kind(x)
    return last


def _state(map, obj):
    """A copy: what was read from the map stays what it was when the map goes on."""
    if obj.r is None and obj.x is None:
        raise ValueError(f"{type(obj).__name__} {obj.id} has no state yet: put it into the map, or give it a known x")
    return np.array(obj.x) if obj.r is None else map.state(obj.r)


def _where(obj):
    """Where the state of an object is, in words."""
    if obj.r is None:
        return "not in the map" if obj.x is None else "known"
    return f"in the map at {obj.r.start}:{obj.r.stop}"


def _title(obj):
    """Id, and name where there is one."""
    return f"{obj.id} {obj.name!r}" if obj.name else str(obj.id)


class _Shown:
    """What a notebook shows for an object: its line, and below it its attributes."""

    __slots__ = ()

    def _repr_html_(self):
        rows = [(f.name, short(getattr(self, f.name))) for f in fields(self) if f.repr]  # pyright: ignore
        return f"<b>{html.escape(repr(self))}</b>{table_html(('attribute', 'value'), rows)}"


def short(value):
    """A value in few words."""
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
        Control of this frame and its covariance.
    sensors : list of int
        Ids of the sensors it carries.
    n_refused : int
        How many of its innovations in a row have failed the gate.
    checked_U : bytes or None
        The control covariance that was last found to be one: it is not tested again while its numbers stay the same.
    first : ndarray or None
        The pose as predicted, before any correction of this frame; None without first-estimates Jacobians.
    last, normal : Frame2, Frame3 or None
        The frame that was last asked for, and the one that was last normalised: not computed again while it is so.
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
    last: Any = field(default=None, repr=False)
    normal: Any = field(default=None, repr=False)

    def __repr__(self):
        return f"Rob({_title(self)}, {type(self.motion).__name__}, {_where(self)}, sensors {self.sensors})"

    def state(self, map):
        """State vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame2 or Frame3 of the robot in the world."""
        return _frame(map, self, self.motion.frame)


@dataclass
class Sen(_Shown):
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
    last, normal : Frame2, Frame3 or None
        The frame that was last asked for, and the one that was last normalised: not computed again while it is so.
    groups : Groups or None
        Of which types the landmarks are that it was last asked about, and where in the map.
    gapless : tuple (Lmk, int) or None
        The landmark that it started last and `Lmk.births` then, if the slots 0, 1, 2, ... had no gap.
    """

    id: int
    robot: int
    model: Any
    frame_type: Any
    name: str = ""
    x: Any = None
    r: slice | None = None
    lmk_type: Any = None
    last: Any = field(default=None, repr=False)
    normal: Any = field(default=None, repr=False)
    groups: Any = field(default=None, repr=False)
    gapless: Any = field(default=None, repr=False)

    def __repr__(self):
        return f"Sen({_title(self)}, {type(self.model).__name__} on robot {self.robot}, frame {_where(self)})"

    def state(self, map):
        """Frame vector: the map's estimate, or the known one."""
        return _state(map, self)

    def frame(self, map):
        """Frame of the sensor on its robot."""
        return _frame(map, self, self.frame_type)


@dataclass(eq=False, slots=True)
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
    n_search, n_match, n_inlier : int
        How often it was looked for, found, and used.
    first : ndarray or None
        The state at birth, for first-estimates Jacobians; None without them.
    changes : int
        Of all landmarks: how often a type or a range has been changed. What was noted of them is true until then.
    births : int
        Of all landmarks: how many have been given a slot.
    """

    changes: ClassVar[int] = 0
    births: ClassVar[int] = 0

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
        if self.r is None:
            return p, np.zeros((len(p), len(p)))
        return p, P_l @ map.block(self.r) @ P_l.T


def _counted(name):
    """A field of `Lmk` of which `changes` counts when it is changed."""
    slot = vars(Lmk)[name]

    def write(lmk, value):
        if hasattr(lmk, "first"):  # not at birth
            Lmk.changes += 1
        slot.__set__(lmk, value)

    return property(slot.__get__, write)


Lmk.type, Lmk.r = _counted("type"), _counted("r")  # pyright: ignore[reportAttributeAccessIssue]


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
