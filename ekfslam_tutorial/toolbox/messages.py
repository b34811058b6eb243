"""Messages of robots: stamped controls and measurements in any order; and what the robots did between any two times."""

from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..ekf import Map
from ..simulation import SimObs
from ..slam import Rob, move, place
from ..slam.steps import check_control, check_raw
from .recordings import ControlLog, RawLog, Recording
from .sources import TURN
from .user_input import finite_array, short_text


@dataclass(frozen=True, eq=False)
class Control:
    """Control of a robot until a time, from its control before.

    Parameters
    ----------
    t : float
        When it ended, s.
    u : array_like, shape (nu,)
        In the units of its motion model, SI and radians.
    robot : int
        Id.
    U : array_like, shape (nu, nu), optional
        Its covariance over the whole time. Without it the scenario's control noise holds.
    """

    t: float
    u: Any
    robot: int = 1
    U: Any = None


@dataclass(frozen=True, eq=False)
class Measurement:
    """Measurements of a sensor at a time; without rows: it looked, and saw nothing.

    Parameters
    ----------
    t : float
        s.
    ids : array_like of int, shape (k,)
        Landmark ids, -1 where not known.
    y : array_like, shape (k, m)
        SI units and radians.
    sensor : int
        Id.
    R : array_like, shape (k, m, m), optional
        Noise covariance of each, where it is not the sensor's.
    of_robots : bool
        The ids are those of other robots.
    d : array_like, shape (k, n), optional
        What each looks like, by n numbers: its descriptor, for the association `descriptors`.
    """

    t: float
    ids: Any
    y: Any
    sensor: int = 1
    R: Any = None
    of_robots: bool = False
    d: Any = None


class Reader:
    """Reads messages: one sentence for what is wrong with one, the scenario's noise, bias and clock for a good one.

    Parameters
    ----------
    data : UserData

    Raises
    ------
    ValueError
        For a robot whose pose is known, or that moves by steps that nobody can split.
    """

    def __init__(self, data):
        self.data = data
        self._robots = {robot.id: robot for robot in data.robots}
        self._sensors = {sensor.id: sensor for sensor in data.sensors}
        self._length = None  # of descriptors
        for robot in data.robots:
            if not robot.in_map:
                raise ValueError(
                    f"robot {robot.id} is not in the map (in_map = false): its poses are known, so a stream "
                    "of messages has nothing to estimate them from; play a recording of them"
                )
            if not hasattr(robot.motion, "part"):
                _check_velocity(robot)

    def read(self, message):
        """Return the message as the filter takes it.

        Raises
        ------
        ValueError, TypeError
            One sentence.
        """
        if isinstance(message, Control):
            return self._control(message)
        if isinstance(message, Measurement):
            return self._measurement(message)
        raise TypeError(f"a message is a Control or a Measurement, got {short_text(message)}")

    def _control(self, c):
        robot = _known("robot", c.robot, self._robots)
        t = _time(f"the control of robot {c.robot}", c.t)
        u = finite_array(f"robot {robot.id}: the control", c.u)
        U = robot.U() if c.U is None else finite_array(f"robot {robot.id}: the covariance of the control", c.U)
        check_control(Rob(robot.id, robot.motion, u=u, U=U, r=slice(0, 0)), 0.0)
        return Control(t + robot.clock_offset, u, robot.id, U if robot.noise_factor == 1 else robot.noise_factor * U)

    def _measurement(self, m):
        sensor = _known("sensor", m.sensor, self._sensors)
        model, what = sensor.model, f"sensor {sensor.id} ({type(sensor.model).__name__})"
        t = _time(f"the measurement of sensor {m.sensor}", m.t)
        ids, y = np.asarray(m.ids), np.asarray(m.y)
        if not ids.size and not y.size:
            ids, y = np.zeros(0, int), np.zeros((0, len(model.R)))
        raw = SimObs(sensor.id, ids, y, m.R)
        check_raw(raw, sensor)
        for j in (j for j, unit in enumerate(getattr(model, "units", ())) if unit == "rad"):
            if (np.abs(y[:, j]) > TURN).any():
                raise ValueError(f"{what}: y{j + 1} = {np.abs(y[:, j]).max():.1f} is beyond 2 pi; are these degrees?")
        named = not (m.of_robots or hasattr(sensor.model, "without_lmks"))
        if named and len(ids) and ids.max() < 0 and getattr(self.data.options.association, "by_id", False):
            why = "and the association known_ids needs them; choose nearest_neighbour or jcbb"
            raise ValueError(f"{what}: all ids are -1, {why}")
        R = None if m.R is None else np.array(m.R, float)
        if sensor.noise_factor != 1:
            R = sensor.noise_factor * (np.tile(model.R, (len(ids), 1, 1)) if R is None else R)
        d = None if m.d is None else self._descriptors(f"{what}: descriptors d", m.d, len(ids))
        return Measurement(t, ids, y.astype(float) - sensor.biases(), sensor.id, R, bool(m.of_robots), d)

    def _descriptors(self, what, d, n):
        """A row of finite numbers for each of n measurements, as long as all that came before: they are compared."""
        d = finite_array(what, d, 2)
        if len(d) != n:
            raise ValueError(f"{what}: {len(d)} rows for {n} measurements")
        self._length = self._length or d.shape[1]
        if d.shape[1] != self._length:
            raise ValueError(f"{what} must have {self._length} numbers, as those before, got {d.shape[1]}")
        return d


def _known(kind, id, there):
    if isinstance(id, (int, np.integer)) and id in there:
        return there[id]
    raise ValueError(f"there is no {kind} {short_text(id)}; {kind}s there: {', '.join(map(str, there)) or 'none'}")


def _time(what, t):
    if isinstance(t, (int, float, np.number)) and not isinstance(t, bool) and np.isfinite(t):
        return float(t)
    raise ValueError(f"{what} needs a time, a finite number of seconds, got {short_text(t)}")


def _check_velocity(robot):
    """Refuse a model of a user's own whose controls are steps, if it does not say how to split one."""
    motion, (x, _) = robot.motion, robot.start()
    u = np.full(sum(motion.control_fields.values()), 0.1)
    whole, half = motion.move(x, u, 0.1)[0], motion.move(x, u, 0.05)[0]
    twice = motion.move(half, u, 0.05)[0]
    if np.linalg.norm(twice - whole) > 0.25 * np.linalg.norm(whole - x):
        raise ValueError(
            f"robot {robot.id}: the controls of {type(motion).__name__} are no velocities: two of half the time "
            "lead elsewhere than one; so that they can be split at a measurement, give it a method part(u, U, f)"
        )


# --- what the robots did between two times ---------------------------------------------------------------------------


class Step(NamedTuple):
    """A control u of covariance U that acts for dt seconds."""

    u: np.ndarray
    U: np.ndarray
    dt: float


@dataclass
class Driven:
    """A control in its place: it acts after `begin`, and after `after`, where a frame was settled without it."""

    begin: float
    after: float
    control: Control


class Timeline:
    """Controls of all robots in their order, and the part of one that acts between two times.

    A control acts from the robot's control before until its own time. A part of it is what the motion model says
    (`part`); for velocities: the same velocity for a shorter time, with a covariance that grows as the time shrinks, so
    that the parts together are as uncertain as the whole. After the last control the robot goes on as in it; before
    any, it is taken to stand still, with the noise that the scenario has for a step of `time.dt`.

    Parameters
    ----------
    data : UserData
    t0 : float
        When the robots start, s.
    """

    def __init__(self, data, t0):
        self._robots, self._dt, self.t0 = {robot.id: robot for robot in data.robots}, data.time.dt, t0
        self.driven = {robot.id: [] for robot in data.robots}

    def find(self, robot, t):
        """Return the control of this robot that ends at t, or None."""
        i = self._index(robot, t)
        there = self.driven[robot][i : i + 1]
        return there[0].control if there and there[0].control.t == t else None

    def add(self, control, after=-np.inf):
        """Put a control in its place; return from when on the motion of its robot is another one than before."""
        mine, i = self.driven[control.robot], self._index(control.robot, control.t)
        begin = mine[i - 1].control.t if i else self.t0
        mine.insert(i, Driven(begin, after, control))
        if i + 1 < len(mine):
            mine[i + 1].begin = control.t
        return max(begin, after)

    def forget(self, t):
        """Forget controls that have ended by t, but for the last of each robot."""
        for robot, mine in self.driven.items():
            del mine[: max(0, self._index(robot, np.nextafter(t, np.inf)) - 1)]

    def step(self, robot, a, b):
        """Control of a robot from a to b; none of its controls ends in between.

        Returns
        -------
        Step
        """
        mine, i, motion = self.driven[robot], self._index(robot, b), self._robots[robot].motion
        nothing = np.zeros(sum(motion.control_fields.values()))
        if a == b and self.find(robot, b) is None:
            return Step(nothing, np.diag(nothing), 0.0)
        if i < len(mine) and b > mine[i].after:
            return self._part(robot, mine[i], a, b)
        if i:
            return self._part(robot, mine[i - 1], a, b)
        return _part(motion, nothing, self._robots[robot].U(), b - a, self._dt)

    def _part(self, robot, driven, a, b):
        c, T = driven.control, driven.control.t - driven.begin
        if a == driven.begin and b == c.t:
            return Step(c.u, c.U, T)
        return _part(self._robots[robot].motion, c.u, c.U, b - a, T or self._dt)

    def _index(self, robot, t):
        return bisect_left(self.driven[robot], t, key=lambda d: d.control.t)


def _part(motion, u, U, dt, T):
    """The part of a control of T seconds that acts for dt; a velocity that the model says nothing about stays."""
    u, U = motion.part(u, U, dt / T) if hasattr(motion, "part") else (u, U * T / dt)
    return Step(u, U, dt)


def integrate(motion, x, P, steps):
    """Move a state and its covariance by controls, one after the other: dead reckoning.

    Parameters
    ----------
    motion : MotionModel
    x : array_like, shape (n,)
        State of the robot, its pose first.
    P : array_like, shape (n, n)
    steps : iterable of (ndarray, ndarray, float)
        Control u, its covariance U, and for how many seconds it acts.

    Returns
    -------
    x : ndarray, shape (n,)
    P : ndarray, shape (n, n)

    Raises
    ------
    ValueError

    See Also
    --------
    recording_of : A whole log of controls and measurements at times of their own.
    """
    map, rob = Map(), Rob(0, motion)
    place(map, rob, x, P)
    for rob.u, rob.U, dt in steps:
        move(map, rob, dt)
    return map.state(rob.r), map.block(rob.r)


# --- a whole log -----------------------------------------------------------------------------------------------------


def merged(measurements):
    """All that one sensor measured at one time, in an order that does not depend on which message came first."""
    if len(measurements) == 1:
        (m,) = measurements
        return SimObs(m.sensor, m.ids, m.y, m.R, m.d)
    measurements = sorted(measurements, key=content)
    ids, y = (np.concatenate([getattr(m, name) for m in measurements]) for name in ("ids", "y"))
    R, d = (_all_or_none(measurements, *what) for what in (("R", "a covariance R"), ("d", "descriptors d")))
    return SimObs(measurements[0].sensor, ids, y, R, d)


def _all_or_none(measurements, name, what):
    """Join what measurements of one sensor and one time may have or not, one after the other; None if none has it."""
    values, m = [getattr(m, name) for m in measurements], measurements[0]
    there = [value is not None for value in values]
    if any(there) and not all(there):
        raise ValueError(f"sensor {m.sensor} at {m.t:g} s: some messages have {what} and some do not")
    return np.concatenate(values) if all(there) else None


def content(m):
    """Content of a message, to be compared: two with the same content are one that was sent twice."""
    if isinstance(m, Control):
        return m.t, m.robot, m.u.tobytes(), m.U.tobytes()
    rest = (b"" if a is None else a.tobytes() for a in (m.R, m.d))
    return m.t, m.sensor, m.of_robots, m.ids.tolist(), m.y.tobytes(), *rest


def recording_of(messages, data, name, t0=0.0):
    """Make a recording of stamped controls and measurements, each at its own rate: one's own log.

    There is a frame at each time of a message, and a control that lasts longer is split there: see `Timeline`.

    Parameters
    ----------
    messages : iterable of Control and Measurement
        In any order. Messages that are the same twice are taken once.
    data : UserData
        The scenario to play it with.
    name : str
    t0 : float
        When the robots start, s; the recording counts from there.

    Returns
    -------
    Recording

    Raises
    ------
    ValueError, TypeError
        One sentence for a message that is wrong or comes before t0.

    See Also
    --------
    OnlineSlam : Takes the same messages as they come.
    """
    neutral, line, looks, times = plain(data), Timeline(data, t0), {}, []
    reader = Reader(neutral)
    for m in map(reader.read, messages):
        if m.t < t0:
            raise ValueError(f"a message at {m.t:g} s is before the start at {t0:g} s")
        if isinstance(m, Control):
            there = line.find(m.robot, m.t)
            if there is not None and content(there) != content(m):
                raise ValueError(f"robot {m.robot} has two controls that end at {m.t:g} s")
            if there is None:
                line.add(m)
        else:
            mine = looks.setdefault((m.of_robots, m.sensor, m.t), [])
            mine += [] if any(content(m) == content(other) for other in mine) else [m]
        times.append(m.t)
    times = np.unique(times)
    before = np.concatenate([[t0], times[:-1]])
    between = list(zip(before.tolist(), times.tolist(), strict=True))
    steps = {id: [line.step(id, a, b) for a, b in between] for id in line.driven}
    robots = {i: ControlLog(np.array([s.u for s in mine]), np.array([s.U for s in mine])) for i, mine in steps.items()}
    nothing = {s.id: SimObs(s.id, np.zeros(0, int), np.zeros((0, len(s.model.R)))) for s in data.sensors}

    def log(sensor, of_robots):
        """All that a sensor has seen, a row for each frame."""
        rows = [looks.get((of_robots, sensor.id, t)) for t in times.tolist()]
        rows = [nothing[sensor.id] if row is None else merged(row) for row in rows]
        if any(o.R is not None for o in rows):
            rows = [replace(o, R=np.tile(sensor.model.R, (len(o), 1, 1))) if o.R is None else o for o in rows]
        return RawLog.of(sensor.id, rows)

    raw = {s.id: log(s, False) for s in data.sensors}
    met = {s.id: log(s, True) for s in data.sensors if any(key[:2] == (True, s.id) for key in looks)}
    return Recording(name, times - t0, robots, raw, met=met, by_event=True)


def plain(data):
    """The scenario without what it says of noise factors, biases and clocks."""
    robots = [replace(robot, noise_factor=1.0, clock_offset=0.0) for robot in data.robots]
    sensors = [replace(sensor, noise_factor=1.0, bias=None) for sensor in data.sensors]
    return replace(data, robots=robots, sensors=sensors)
