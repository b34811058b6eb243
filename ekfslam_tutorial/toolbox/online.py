"""SLAM on a stream: messages as they arrive, late ones and such out of order too, and the state at any time."""

from bisect import bisect_left, bisect_right
from collections import Counter
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..simulation import SimLmk
from . import engines, identity
from .files import value_file
from .messages import Control, Measurement, Reader, Timeline, content, integrate, merged, plain
from .recordings.logs import checked_landmarks
from .run_state import run_state
from .sources import Frame, Replay
from .structures import create_slam_structures
from .universal_slam import Loop
from .user_input import finite_array

FORMAT = "ekfslam stream 1"
STATES = 8
"""So many states of the run are kept within a horizon: what has to be done again is what came since one of them."""


class OnlineSlam:
    """A filter that takes messages: the loop of `universal_slam`, with frames made of what arrives.

    There is a frame at each time at which something was measured; all robots move there, by the parts of their
    controls that act until then (`Timeline`). What comes out depends on the messages, not on the order in which they
    came: one that is late, but within the horizon, lets the filter go back to a state before it and do again what
    followed. One that is older is dropped, and so is one that was sent twice; `add` says so, and `dropped` counts.

    A measurement may come before the control that covers its time: the robot is then taken to go on as before, until
    that control comes. A control that comes more than the horizon after a measurement counts from that measurement on.

    Parameters
    ----------
    data : UserData
        Robots start where it says; `[world]` and `[time]` are not used, but for `time.dt` (see `Timeline`).
    horizon : float
        How much older than the newest message another may be, s.
    t0 : float
        When the robots start, s; for messages that are stamped with the time of day, that of the first.
    landmarks : SimLmk, optional
        The known map, where the landmarks are known (localisation).
    starts : dict of int to ndarray, optional
        Poses of robots whose position the scenario leaves open.

    Attributes
    ----------
    t : float
        Time of the newest message, s.
    dropped : Counter of str
        How many messages were dropped, by reason.

    Raises
    ------
    ValueError, TypeError
        If the data do not fit together, or a robot's pose is known.

    See Also
    --------
    as_stream : The messages of a recording, and the filter for them.
    recording_of : A recording of such messages, for `universal_slam`.
    integrate : Dead reckoning by controls.
    """

    def __init__(self, data, horizon=1.0, t0=0.0, landmarks=None, starts=None):
        for name, value in (("horizon", horizon), ("t0", t0)):
            if finite_array(f"the {name}", value).ndim or (name == "horizon" and value < 0):
                raise ValueError(f"the {name} must be a number of seconds, got {value}")
        self.data, self.horizon, self.t0, self.t = data, float(horizon), float(t0), float(t0)
        self.dropped = Counter()
        landmarks = None if landmarks is None else checked_landmarks(landmarks.ids, landmarks.points)
        self._world = SimpleNamespace(sim_robs=(), sim_sens=(), sim_lmk=landmarks)
        self._reader, self._line = Reader(data), Timeline(data, self.t0)
        map, robs, sens, lmks, _ = create_slam_structures(data, landmarks, starts)
        self._loop = Loop(data, engines.engine(data.options), map, robs, sens, lmks)
        self._times, self._frames, self._looks = [], [], {}  # of all messages, of measurements; these by their time
        self._ids = [robot.id for robot in data.robots]
        self._at, self._now = dict.fromkeys(self._ids, -np.inf), -np.inf  # how far the robots are, and the messages
        self._snapshot = self._loop.snapshot(data.time.first - 1, Frame(self.t0, 0.0, {}, {}, {}), [], [], self._world)
        self._past = {rob.id: [(self.t0, *self._state(rob))] for rob in self._loop.robs}
        self._kept = [self._keep()]

    # --- in ----------------------------------------------------------------------------------------------------------

    def add(self, message):
        """Take a message. It is worked on when somebody asks.

        Parameters
        ----------
        message : Control or Measurement

        Returns
        -------
        str or None
            Why it was dropped; None if it was taken.

        Raises
        ------
        ValueError, TypeError
            One sentence, for a message that is wrong; nothing has changed then.
        """
        m = self._reader.read(message)
        said = self._unwanted(m)
        if said is None:
            if isinstance(m, Control):
                again = self._line.add(m, self._frame_before(m.t - self.horizon))
                self._go_back(lambda kept: kept["t"] < m.t and kept["at"][m.robot] <= again)
            else:
                looks = self._looks.get(m.t, [])
                merged([other for other in [*looks, m] if other.sensor == m.sensor])  # or it says why not
                self._looks[m.t] = [*looks, m]
                _insert(self._frames, m.t)
                if len(self._ids) == 1 and not looks and m.t == self._now:
                    self._stay()
                self._go_back(lambda kept: kept["t"] < m.t)
            _insert(self._times, m.t)
            self.t = max(self.t, m.t)
        return said

    def _frame_before(self, t):
        """Time of the last frame before t, which is settled by now; minus infinity if there is none."""
        i = bisect_left(self._frames, t)
        if i:
            return self._frames[i - 1]
        first = self._kept[0]  # what is in it is forgotten
        return first["frame"] if first["state"]["frames"] and first["frame"] < t else -np.inf

    def _unwanted(self, m):
        """Why a message is dropped, counted; or None."""
        who = f"robot {m.robot}" if isinstance(m, Control) else f"sensor {m.sensor}"
        if m.t < self.t0:
            self.dropped["before the start"] += 1
            return f"{who}: a message of {m.t:g} s, before the start at {self.t0:g} s"
        if m.t < self.t - self.horizon:
            self.dropped["older than the horizon"] += 1
            return (
                f"{who}: a message of {m.t:g} s came when the newest was of {self.t:g} s; "
                f"the horizon is {self.horizon:g} s"
            )
        if isinstance(m, Control):
            there = self._line.find(m.robot, m.t)
            same = there is not None and content(there) == content(m)
            if there is not None and not same:
                self.dropped["second control of a robot for one time"] += 1
                return f"{who}: it has another control that ends at {m.t:g} s"
        else:
            same = any(content(m) == content(other) for other in self._looks.get(m.t, ()))
        if same:
            self.dropped["sent twice"] += 1
            return f"{who}: the message of {m.t:g} s was sent twice"
        return None

    # --- out ---------------------------------------------------------------------------------------------------------

    def update(self):
        """Work on all messages that have come.

        Returns
        -------
        Snapshot
            After the last frame, as `universal_slam` yields it: the live objects, good until the next update.

        Raises
        ------
        ValueError
            If two messages of a sensor and a time do not fit each other.
        """
        for t in self._times[bisect_right(self._times, self._now) :]:
            self._do(t)
        while len(self._kept) > 1 and self._kept[1]["t"] < self.t - 2 * self.horizon:
            del self._kept[0]
        self._forget(self._kept[0]["t"])
        return self._snapshot

    def state(self, t=None, robot=None):
        """State of a robot at any time from the horizon on, by all that was measured until then.

        The filter stays as it is: from the last estimate before t the state is predicted by the controls, or where they
        end, by the last of them.

        Parameters
        ----------
        t : float, optional
            s; by default the time of the newest message.
        robot : int, optional
            Id; by default the first robot's.

        Returns
        -------
        x : ndarray, shape (n,)
            The pose first, then what else the motion model has.
        P : ndarray, shape (n, n)

        Raises
        ------
        ValueError
            For an unknown robot, or a time before what is kept.
        """
        robot = self._ids[0] if robot is None else robot
        if robot not in self._ids:
            raise ValueError(f"there is no robot {robot}; robots there: {', '.join(map(str, self._ids))}")
        t = self.t if t is None else t
        if not np.isfinite(t):
            raise ValueError(f"the state of robot {robot} is asked for at a time that is no number of seconds: {t}")
        self.update()
        past = self._past[robot]
        i = bisect_right(past, t, key=lambda entry: entry[0]) - 1
        if i < 0:
            raise ValueError(f"the state of robot {robot} at {t:g} s is not kept; it is from {past[0][0]:g} s on")
        at, x, P = past[i]
        if t == at:
            return x.copy(), P.copy()
        rob = next(rob for rob in self._loop.robs if rob.id == robot)
        return integrate(rob.motion, x, P, [self._line.step(robot, at, t)])

    def landmarks(self):
        """All landmarks by all that was measured: id -> point and its covariance, metres."""
        self.update()
        return {id: lmk.point(self._loop.map) for id, lmk in self._loop.lmks.items() if lmk.par is None}

    # --- forwards and back -------------------------------------------------------------------------------------------

    def _do(self, t):
        """All messages of one time: controls that end then, and what the sensors saw."""
        loop, looks = self._loop, self._looks.get(t, [])
        moving = self._ids if looks else [id for id in self._ids if self._line.find(id, t) is not None]
        moving = [id for id in moving if self._at[id] < t]
        controls = {id: self._line.step(id, max(self._at[id], self.t0), t) for id in moving}
        raw, met = (self._seen(looks, of_robots) for of_robots in (False, True))
        idle = {sen.id for sen in loop.sens} - set(raw)
        now = Frame(t, t - self._snapshot.t, controls, raw, {}, met, idle)
        if looks:
            k = self._snapshot.k
            events, corrected = loop.step(now, k - self.data.time.first + 1)
            self._snapshot = loop.snapshot(k + 1, now, events, corrected, self._world)
        for rob in loop.robs:
            if rob.id in controls and not looks:
                loop.move(rob, now)
            if rob.id in controls or looks:
                self._past[rob.id].append((t, *self._state(rob)))
        self._at |= dict.fromkeys(controls, t)
        self._now = t
        if t >= self._kept[-1]["t"] + self.horizon / STATES:
            self._kept.append(self._keep())

    def _seen(self, looks, of_robots):
        """Measurements of one time, by sensor."""
        sensors = {m.sensor for m in looks if m.of_robots == of_robots}
        return {id: merged([m for m in looks if (m.sensor, m.of_robots) == (id, of_robots)]) for id in sensors}

    def _state(self, rob):
        return self._loop.map.state(rob.r), self._loop.map.block(rob.r)

    def _keep(self):
        """The run as it is now, in copies."""
        state = _own(run_state(self._snapshot, self.data))
        return {"t": self._now, "at": dict(self._at), "frame": self._snapshot.t, "state": state}

    def _go_back(self, good):
        """Go back to the last state that is good, if the present one is not."""
        if good({"t": self._now, "at": self._at}):
            return
        while not good(self._kept[-1]):
            del self._kept[-1]
        self._restore(self._kept[-1])

    def _stay(self):
        """A measurement of the time at which the only robot is already, by its control: nothing has to be done again.

        (Of several, the first one looks before the second one moves.)
        """
        if self._kept[-1]["t"] == self._now:
            del self._kept[-1]
        self._now = np.nextafter(self._now, -np.inf)

    def _restore(self, kept):
        loop, state = self._loop, _own(kept["state"])
        loop.restore(state)
        self._now, self._at = kept["t"], dict(kept["at"])
        k = self.data.time.first + state["frames"] - 1
        self._snapshot = loop.snapshot(k, Frame(kept["frame"], 0.0, {}, {}, {}), [], [], self._world)
        for past in self._past.values():
            del past[max(1, bisect_right(past, self._now, key=lambda entry: entry[0])) :]

    def _forget(self, t):
        """Forget the messages until t: they are in the oldest state that is kept."""
        n = bisect_right(self._times, t)
        for old in self._times[:n]:
            self._looks.pop(old, None)
        del self._times[:n], self._frames[: bisect_right(self._frames, t)]
        self._line.forget(t)
        for past in self._past.values():
            del past[: max(0, bisect_right(past, t, key=lambda entry: entry[0]) - 1)]

    # --- on disk -----------------------------------------------------------------------------------------------------

    def save(self, path):
        """Keep all in a file, whole or not at all: the oldest state within the horizon, and the messages after it.

        Parameters
        ----------
        path : path
        """
        self.update()
        messages = [_values(m) for looks in self._looks.values() for m in looks]
        driven = [(d.begin, d.after, _values(d.control)) for mine in self._line.driven.values() for d in mine]
        known = self._world.sim_lmk
        value_file.save(
            path,
            {
                "format": FORMAT,
                "program": identity.program(),
                "inputs": identity.of_scenario(self.data),
                "horizon": self.horizon,
                "t0": self.t0,
                "t": self.t,
                "dropped": dict(self.dropped),
                "landmarks": None if known is None else [known.ids, known.points],
                "kept": self._kept[0],
                "past": {id: list(past[0]) for id, past in self._past.items()},
                "measurements": messages,
                "driven": driven,
            },
        )

    @classmethod
    def load(cls, path, data):
        """Go on from a file that `save` has written, with the same scenario: the numbers are those of a run unbroken.

        Parameters
        ----------
        path : path
        data : UserData

        Returns
        -------
        OnlineSlam

        Raises
        ------
        ValueError
            If the file is damaged, or was made by another scenario or version.
        FileNotFoundError
        """
        file = value_file.load(path)
        if not isinstance(file, dict) or file.get("format") != FORMAT:
            raise ValueError(f"{path} is no file of a stream")
        if file["program"] != identity.program():
            raise ValueError(f"{path} is of another version of the program ({file['program']})")
        if what := identity.changed(file["inputs"], identity.of_scenario(data)):
            raise ValueError(f"{path} is of another scenario, changed is: {what}")
        known = None if file["landmarks"] is None else SimLmk(*file["landmarks"])
        slam = cls(data, file["horizon"], file["t0"], known)
        slam.t, slam.dropped, slam._kept = file["t"], Counter(file["dropped"]), [file["kept"]]
        slam._past = {id: [tuple(first)] for id, first in file["past"].items()}
        slam._restore(file["kept"])
        for begin, after, values in file["driven"]:
            control = Control(**values)
            slam._line.add(control, after)
            slam._line.driven[control.robot][-1].begin = begin
            slam._times.append(control.t)
        for m in (Measurement(**values) for values in file["measurements"]):
            slam._looks.setdefault(m.t, []).append(m)
        slam._frames = sorted(slam._looks)
        slam._times = sorted({t for t in [*slam._times, *slam._frames] if t > file["kept"]["t"]})
        return slam


def _insert(times, t):
    """Put a time into a sorted list, once."""
    i = bisect_left(times, t)
    if times[i : i + 1] != [t]:
        times.insert(i, t)


def _each(ends, u, U):
    """Time, control and covariance of each control of a frame."""
    return zip(ends, u, U, strict=True) if np.ndim(u) == 2 else [(ends[0], u, U)]


def _own(value) -> Any:
    """A copy of nested values, arrays included."""
    if isinstance(value, dict):
        return {key: _own(inner) for key, inner in value.items()}
    if isinstance(value, (list, set)):
        return type(value)(value)
    return value.copy(order="K") if isinstance(value, np.ndarray) else value


def _values(message):
    return {f.name: getattr(message, f.name) for f in fields(message)}


def as_stream(data, recording, horizon=1.0):
    """A recording as a stream: the filter, and the messages that make it compute what `universal_slam` does.

    Parameters
    ----------
    data : UserData
    recording : Recording
    horizon : float
        s.

    Returns
    -------
    slam : OnlineSlam
        Its scenario, `slam.data`, is without noise factors, biases and clock offsets: the messages have them.
    messages : list of Control and Measurement
        In the order of time.

    Raises
    ------
    ValueError, TypeError
        As `universal_slam`.
    """
    source, messages = Replay(data, recording), []
    for i in range(len(recording)):
        now = source.frame(i)
        for id, (u, U, dt) in now.controls.items():
            ends = now.t - np.sum(dt) + np.cumsum(dt) if np.ndim(u) == 2 else [now.t]  # of many the last one ends now
            messages += [Control(min(t, now.t), u, id, U) for t, u, U in _each(ends, u, U)]
        for seen, of_robots in ((now.raw, False), (now.met, True)):
            for id, o in seen.items():
                if id not in now.idle if not of_robots else len(o):
                    messages.append(Measurement(now.t, o.ids, o.y, id, o.R, of_robots, o.d))
    return OnlineSlam(plain(data), horizon, 0.0, source.sim_lmk, source.starts), messages
