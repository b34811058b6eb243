"""Where controls and measurements come from, frame by frame: a simulator, or the recording of a run.

Both give the estimator the same, a `Frame`. It does not know which of them it came from.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..simulation import Looks, Streams, draw, sim_motion, sim_observation
from .adjusted import adjusted
from .structures import create_sim_structures

MANY = 256
"""Covariances of controls of different lengths that are kept."""
TURN = 2 * np.pi * (1 + 1e-12)
"""No angle is beyond it, but for rounding."""


@dataclass
class Frame:
    """Data of one frame: what there is to estimate from.

    Parameters
    ----------
    t, dt : float
        Seconds since the start, and since the frame before.
    controls : dict of int to (ndarray, ndarray, float)
        Control u, its covariance U, and for how many seconds it acts, by robot id. A robot without does not move. Of
        several controls one after the other each has a row: u (k, nu), U (k, nu, nu), seconds (k,).
    raw : dict of int to SimObs
        Measurements, by sensor id.
    truth : dict of int to ndarray
        True pose of each robot, NaN where not known; not for the estimator, except for robots with known pose.
    met : dict of int to SimObs
        Measurements of other robots, by sensor id; none in a simulation.
    idle : set of int
        Sensors that did not look; that is not the same as to look and see nothing.
    """

    t: float
    dt: float
    controls: dict
    raw: dict
    truth: dict
    met: dict = field(default_factory=dict)
    idle: set = field(default_factory=set)


class Told:
    """Noise of a simulation as the filter is told it, where that is not what the simulator draws with.

    Parameters
    ----------
    data : UserData

    Raises
    ------
    ValueError
        For what only a recording can have.
    """

    def __init__(self, data):
        self._factors = {robot.id: robot.noise_factor for robot in data.robots}
        self._R = {s.id: s.noise_factor * np.asarray(s.model.R) for s in data.sensors if s.noise_factor != 1}
        for robot in data.robots:
            if robot.clock_offset:
                raise ValueError(f"robot {robot.id}: clock_offset is for recordings; this is a simulation")
        for sensor in data.sensors:
            if np.any(sensor.biases()):
                raise ValueError(f"sensor {sensor.id}: bias is for recordings; this is a simulation")
            if sensor.lasting:
                raise ValueError(f"sensor {sensor.id}: lasting is for recordings; this is a simulation")

    def U(self, robot, U):
        """Covariance of the control of a robot."""
        return U if self._factors[robot] == 1 else self._factors[robot] * U

    def raw(self, obs):
        """The measurements of a sensor, with their covariances if they are not the sensor's."""
        R = self._R.get(obs.sen)
        return obs if R is None else replace(obs, R=np.tile(R, (len(obs.ids), 1, 1)))


class Simulation:
    """Simulated robots and sensors.

    Parameters
    ----------
    data : UserData
    seed : int
    """

    def __init__(self, data, seed):
        self.sim_robs, self.sim_sens, self.sim_lmk, self._rngs = create_sim_structures(data, Streams(seed))
        self._sen, streams, lmk = {sen.id: sen for sen in self.sim_sens}, Streams(seed), self.sim_lmk
        self._looks = {
            s.id: Looks(lmk.ids, s.descriptor_size, s.descriptor_std, streams.looks(), streams.looks(s.id))
            for s in data.sensors
            if s.descriptor_size
        }
        self._controls = {robot.id: (robot.controls(), robot.U(data.time.dt)) for robot in data.robots}
        self._told = Told(data)
        self._dt = data.time.dt
        self.starts = {}

    def n_frames(self, tim):
        """Number of frames that there are to be."""
        return tim.last - tim.first + 1

    def frame(self, i):
        """Move all robots, let all sensors measure. Frames must be asked for in order, from 0."""
        now = Frame((i + 1) * self._dt, (i + 1) * self._dt - i * self._dt, {}, {}, {})
        for rob in self.sim_robs:
            u, U = self._controls[rob.id]
            rob.u = u[i % len(u)]
            sim_motion(rob, now.dt)
            for id in rob.sensors:
                rngs = self._rngs["sensing", id], self._rngs["clutter", id]
                now.raw[id] = self._told.raw(sim_observation(rob, self._sen[id], self.sim_lmk, *rngs))
                if id in self._looks:
                    now.raw[id] = replace(now.raw[id], d=self._looks[id].of(now.raw[id].ids))
            told = rob.u + draw(self._rngs["motion", rob.id], U), self._told.U(rob.id, U)
            now.controls[rob.id] = *told, now.dt
            now.truth[rob.id] = rob.frame.x
        return now


class Replay:
    """A recording, played again.

    Parameters
    ----------
    data : UserData
    recording : Recording

    Raises
    ------
    ValueError
        If the recording lacks a robot, a sensor, a true pose or ids that are needed, or has other numbers than a model.
    """

    sim_robs, sim_sens = (), ()

    def __init__(self, data, recording):
        recording = adjusted(data, recording)
        self._rec, self._data = recording, data
        self.sim_lmk = recording.landmarks
        if not len(recording):
            raise ValueError(f"the recording {recording.name!r} has no frames")
        self._check_landmarks()
        self._robots, self._U = {robot.id: robot for robot in data.robots}, {}
        _check_has("robot", [r.id for r in data.robots], recording.robots, recording.name)
        _check_has("sensor", [s.id for s in data.sensors], recording.raw, recording.name)
        for robot in data.robots:
            self._check_robot(robot)
        for sensor in data.sensors:
            self._check_sensor(sensor)
        left_open = [r.id for r in data.robots if r.position is None]
        begun = [i for i in left_open if i in recording.truth]
        self.starts: dict = {i: recording.truth[i][0] for i in begun if np.isfinite(recording.truth[i][0]).all()}
        self.starts |= {i: recording.starts[i] for i in left_open if i in recording.starts}
        self._dt = np.diff(recording.t, prepend=0.0)

    def _check_landmarks(self):
        dim = self._data.frame.dim
        if self.sim_lmk is not None and self.sim_lmk.points.shape[1] != dim:
            columns = self.sim_lmk.points.shape[1]
            raise ValueError(
                f"the landmarks of the recording {self._rec.name!r} have {columns} coordinates, needed are {dim}"
            )

    def _check_robot(self, robot):
        rec, truth = self._rec, self._rec.truth.get(robot.id)
        nu = sum(robot.motion.control_fields.values())
        if rec.robots[robot.id].u.shape[1] != nu:
            raise ValueError(
                f"robot {robot.id} ({type(robot.motion).__name__}) takes {nu} controls, but the recording {rec.name!r} "
                f"has {rec.robots[robot.id].u.shape[1]}"
            )
        if truth is not None and truth.shape[1] != robot.frame.size:
            raise ValueError(f"robot {robot.id}: its truth has {truth.shape[1]} columns, needed are {robot.frame.size}")
        start = rec.starts.get(robot.id)
        if start is not None and len(start[0]) != robot.motion.size:
            what = f"{len(start[0])} numbers, needed are {robot.motion.size} ({type(robot.motion).__name__})"
            raise ValueError(f"robot {robot.id}: its start in the recording {rec.name!r} has {what}")
        if not robot.in_map and (truth is None or not np.isfinite(truth).all()):
            raise ValueError(
                f"robot {robot.id} is not in the map (in_map = false), so its pose must be known in every frame, "
                f"but the recording {rec.name!r} does not have it"
            )

    def _check_sensor(self, sensor):
        """Its rows have as many numbers as it measures, angles in radians, and ids if they are needed."""
        name, model, log = self._rec.name, sensor.model, self._rec.raw[sensor.id]
        what, m = f"sensor {sensor.id} ({type(model).__name__})", len(model.R)
        for y in (logs[sensor.id].y for logs in (self._rec.raw, self._rec.met) if sensor.id in logs):
            if len(y) and y.shape[1] != m:
                raise ValueError(f"{what} measures {m} numbers, but the recording {name!r} has {y.shape[1]}")
        for j in (j for j, unit in enumerate(getattr(model, "units", ())) if unit == "rad" and len(log.y)):
            far = np.flatnonzero(np.abs(log.y[:, j]) > TURN)
            if len(far):
                frame = np.searchsorted(log.offsets, far[0], "right") - 1
                value = f"y{j + 1} = {log.y[far[0], j]:.1f} in frame {frame}"
                raise ValueError(f"{what}: {value} is beyond 2 pi; recordings have radians, are these degrees?")
        named = not hasattr(model, "without_lmks")
        if named and len(log.ids) and log.ids.max() < 0 and getattr(self._data.options.association, "by_id", False):
            why = "and the association known_ids needs them; choose nearest_neighbour or jcbb"
            raise ValueError(f"{what}: all ids in the recording {name!r} are -1, {why}")

    def n_frames(self, tim):
        """All frames of the recording, or as many as the user wants."""
        wanted = np.inf if self._data.time.last is None else tim.last - tim.first + 1
        return int(min(len(self._rec), wanted))

    def frame(self, i):
        """Frame i of the recording."""
        rec = self._rec
        controls = {robot.id: self._control(robot.id, i) for robot in self._data.robots}
        raw = {s.id: rec.raw[s.id][i] for s in self._data.sensors}
        truth = {r.id: rec.truth[r.id][i] for r in self._data.robots if r.id in rec.truth}
        met = {s.id: rec.met[s.id][i] for s in self._data.sensors if s.id in rec.met}
        idle = {id for id, obs in raw.items() if rec.by_event and not len(obs)}
        return Frame(float(rec.t[i]), float(self._dt[i]), controls, raw, truth, met, idle)

    def _control(self, robot, i):
        """Control, covariance and duration. A robot that starts at the truth of the first frame is there already."""
        log = self._rec.robots[robot]
        rows = log.rows(i)
        dt = float(self._dt[i]) if log.dt is None else log.dt[rows]
        U = self._noise(robot, dt) if log.U is None else log.U[rows]
        u, U = (0 * log.u[rows], 0 * U) if i == 0 and robot in self.starts else (log.u[rows], U)
        return u, U, dt

    def _noise(self, robot, dt):
        """Covariance of a control of a robot, or of several, where the recording has none."""
        known = self._U.setdefault(robot, {})  # most steps are of the same length
        for h in np.ravel(dt).tolist():
            if h not in known:
                if len(known) >= MANY:
                    known.clear()
                known[h] = self._robots[robot].U(h)
        if np.ndim(dt) == 0:
            return known[dt]
        return np.array([known[h] for h in dt.tolist()]).reshape(len(dt), *[self._rec.robots[robot].u.shape[1]] * 2)


def _check_has(kind, ids, there, name):
    missing = [i for i in ids if i not in there]
    if missing:
        known = ", ".join(map(str, there)) or "none"
        raise ValueError(f"{kind} {missing[0]} is not in the recording {name!r}; {kind}s there: {known}")
