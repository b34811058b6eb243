"""A recording as the scenario wants it: noise times a factor, a bias taken off, controls moved in time, halts."""

from dataclasses import replace

import numpy as np

from ..geometry import ORIGIN
from ..models.motion import Odometry2, Odometry3, Unicycle, Vehicle
from .recordings import ControlLog

STEPS, RATES = (Odometry2, Odometry3), (Unicycle, Vehicle)
"""Motion models whose controls are steps between two frames, and those whose controls are speeds."""
STILL = 1e-3
"""A robot stands still that moves by less, m and rad, in a frame or in a second."""


def adjusted(data, recording):
    """The recording with what the scenario says of its robots and sensors.

    Parameters
    ----------
    data : UserData
        `noise_factor` and `clock_offset` of each robot, `noise_factor`, `bias` and `lasting` of each sensor.
    recording : Recording

    Returns
    -------
    Recording
        The same one, if there is nothing to do.

    Raises
    ------
    ValueError
        For a clock offset and a motion model whose controls cannot be moved in time; for `lasting` and one whose
        controls do not tell whether the robot stands.
    """
    robots, raw, met = dict(recording.robots), dict(recording.raw), dict(recording.met)
    for robot in data.robots:
        if robot.id in robots:
            robots[robot.id] = _controls(recording.t, robots[robot.id], robot)
    for sensor in data.sensors:
        for logs in (raw, met):
            if sensor.id in logs:
                logs[sensor.id] = _measurements(logs[sensor.id], sensor)
        if sensor.lasting and sensor.id in raw:
            motion = next(robot.motion for robot in data.robots if robot.id == sensor.robot)
            raw[sensor.id] = _counted_once(raw[sensor.id], sensor, places(robots[sensor.robot].u, motion))
    new, old = (robots, raw, met), (recording.robots, recording.raw, recording.met)
    same = all(a[i] is b[i] for a, b in zip(new, old, strict=True) for i in a)
    return recording if same else replace(recording, robots=robots, raw=raw, met=met)


def is_adjusted(data):
    """True if the scenario changes what a recording holds, or what the filter is told of a simulation."""
    robots = any(robot.noise_factor != 1 or robot.clock_offset for robot in data.robots)
    return robots or any(s.noise_factor != 1 or np.any(s.bias) or s.lasting for s in data.sensors)


def _controls(t, log, robot):
    if robot.clock_offset:
        log = ControlLog(*moved_in_time(t, log.u, log.U, robot.clock_offset, robot.motion))
    if robot.noise_factor == 1:
        return log
    return replace(log, U=robot.noise_factor * (_noises(t, log, robot) if log.U is None else log.U))


def _noises(t, log, robot):
    """The covariance of each control, by what the scenario says."""
    lengths = np.diff(t, prepend=0.0) if log.dt is None else log.dt
    return np.array([robot.U(h) for h in lengths.tolist()])


def _measurements(log, sensor):
    m = len(sensor.model.R)
    if log.y.shape[1] != m or (sensor.noise_factor == 1 and not np.any(sensor.bias)):
        return log  # one with other numbers than the model's is refused elsewhere
    R = log.R
    if sensor.noise_factor != 1:
        R = sensor.noise_factor * (np.tile(sensor.model.R, (len(log.y), 1, 1)) if R is None else R)
    return replace(log, y=log.y - sensor.biases(), R=R)


def places(u, motion):
    """Number of the place that a robot is at in each frame; it stays the same while the robot stands still.

    Parameters
    ----------
    u : ndarray, shape (F, n)
        Controls.
    motion : MotionModel

    Returns
    -------
    ndarray of int, shape (F,)

    Raises
    ------
    ValueError
        For a motion model with velocities: its controls do not tell.
    """
    if motion.size != motion.frame.size:
        raise ValueError(f"lasting: the controls of {type(motion).__name__} do not tell when the robot stands still")
    start = ORIGIN[motion.frame.dim].x
    moved = np.abs(motion.move(np.tile(start, (len(u), 1)), u, 1.0)[0] - start).max(-1, initial=0.0) > STILL
    return np.cumsum(moved)


def sightings_from_one_place(log, place):
    """Groups of sightings of one landmark from one place: group of each, shape (M,), and size of each group.

    A sighting of an unknown landmark is a group of its own.

    Parameters
    ----------
    log : RawLog
    place : ndarray of int, shape (F,)
        As from `places`.
    """
    frame = np.repeat(np.arange(len(log)), np.diff(log.offsets))
    alone = np.where(log.ids < 0, 1 + np.arange(len(log.ids)), 0)
    keys = np.stack([place[frame], log.ids, alone], -1)
    _, group, size = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    return group.ravel(), size


def _counted_once(log, sensor, place):
    """n sightings whose errors have a part in common: their mean varies as that of n with R times 1 + (n - 1) share."""
    group, size = sightings_from_one_place(log, place)
    R = np.tile(sensor.model.R, (len(log.y), 1, 1)) if log.R is None else log.R
    factor = 1 + (size[group] - 1) * sensor.lasting
    return replace(log, R=factor[:, None, None] * R)


def moved_in_time(t, u, U, offset, motion):
    """Controls that take effect later than they are stamped.

    What the robot did between two frames is what was commanded between these times minus the offset. Controls are taken
    as constant from frame to frame; pieces of steps are added up as if their turns were small.

    Parameters
    ----------
    t : ndarray, shape (F,)
        Times of the frames, s.
    u, U : ndarray, shape (F, n) and (F, n, n), or None
    offset : float
        s; before the log begins, and after it has ended, the robot goes on as at its end.
    motion : MotionModel

    Returns
    -------
    u, U : ndarray, shape (F, n) and (F, n, n), or None

    Raises
    ------
    ValueError
        For a motion model whose controls are neither steps nor speeds.
    """
    if not isinstance(motion, STEPS + RATES):
        raise ValueError(
            f"clock_offset: the controls of {type(motion).__name__} cannot be moved in time; those of "
            f"{', '.join(cls.__name__ for cls in STEPS + RATES)} can"
        )
    dt = np.diff(t)
    if not (dt > 0).any():
        return u, U
    steps = isinstance(motion, STEPS)
    first, last = np.flatnonzero(dt > 0)[[0, -1]]
    long = 1.0 + abs(offset)  # s; before the log and after it, the speed is that of its end

    def moved(a):
        """The sums of a control, taken at other instants."""
        flat = a[1:].reshape(len(dt), -1)
        speed = flat / np.where(dt > 0, dt, 1.0)[:, None] if steps else flat
        knots = np.concatenate([[t[0] - long], t, [t[-1] + long]])
        ways = np.vstack([0 * speed[:1], long * speed[first], speed * dt[:, None], long * speed[last]])
        total = np.cumsum(ways, axis=0)
        at = np.column_stack([np.interp(t - offset, knots, column) for column in total.T])
        new = np.diff(at, axis=0)
        new = new if steps else new / np.where(dt > 0, dt, 1.0)[:, None]
        return np.concatenate([a[:1], new.reshape(a[1:].shape)])

    return moved(u), None if U is None else moved(U)
