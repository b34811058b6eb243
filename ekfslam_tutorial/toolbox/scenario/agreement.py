"""Agreement of the parts of the user's data: ids, dimensions, sensors and landmark types."""

import numpy as np

from ...models.observation import birth
from ...slam.first_estimates import check_first_estimates
from ..rings import rings_by

FARTHEST = 5e5
"""A start may be so many times less certain than what a sensor measures at one metre. Distances in the map are small
differences of large numbers then: P has 16 digits, and those of the squares, 5e5^2 = 2.5e11, are gone. What is left
holds distances to a hundredth of a sigma; with 10 times as much they are one sigma off."""


def check_agreement(data):
    """Refuse robots, sensors and landmarks that do not fit together.

    Parameters
    ----------
    data : UserData

    Raises
    ------
    ValueError, TypeError
        One sentence that names both sides.
    """
    if not data.robots:
        raise ValueError("there is no robot; write at least one [[robot]]")
    for kind, entries in (("robot", data.robots), ("sensor", data.sensors)):
        ids = [entry.id for entry in entries]
        twice = [i for i in ids if ids.count(i) > 1]
        if twice:
            raise ValueError(f"two {kind}s have the id {twice[0]}; every {kind} needs its own")
    robots = {robot.id: robot for robot in data.robots}
    for sensor in data.sensors:
        if sensor.robot not in robots:
            known = ", ".join(map(str, robots))
            raise ValueError(f"sensor {sensor.id} is on robot {sensor.robot}, which does not exist; robots: {known}")
        if hasattr(sensor.model, "innovation") and not getattr(data.options.association, "by_id", False):
            kind = type(data.options.association).__name__
            raise ValueError(f"sensor {sensor.id}: lines are told apart by their ids only, known_ids, got {kind}")
    _check_dimensions(data)
    _check_capacity(data)
    for sensor in data.sensors:
        _check_asks(data, robots[sensor.robot], sensor)
    if data.options.first_estimates:
        check_first_estimates(data.frame, [started_by(data, sensor) for sensor in data.sensors])
    for sensor in data.sensors:
        sensor.start(data.frame)
    if data.landmark.in_map:
        _check_births(data)
        _check_digits(data)
    _check_view(data.figure, data.frame.dim, bool(data.sensors))


def _check_asks(data, robot, sensor):
    """Refuse a sensor that asks for more than its robot has, or than a part of the filter can give."""
    kind, asks = type(sensor.model).__name__, "asks_robot" in dir(sensor.model) or "delay" in sensor.params_in_map
    if asks and not hasattr(robot.motion, "velocity"):
        what = "the delay of its stamps" if "delay" in sensor.params_in_map else f"what a {kind} measures"
        raise ValueError(
            f"sensor {sensor.id}: {what} depends on a velocity, and {type(robot.motion).__name__} of robot {robot.id} "
            "has none among its states; take constant_turn in the plane, constant_velocity or imu in space"
        )
    if asks and not robot.in_map:
        raise ValueError(
            f"sensor {sensor.id}: {kind} asks for the velocity of robot {robot.id}, which must be in the map"
        )
    if data.options.first_estimates and (asks or sensor.params_in_map):
        raise ValueError(f"sensor {sensor.id}: first_estimates know neither velocities nor parameters of sensors")
    if sensor.params_in_map and data.landmark.hypotheses and rings_by(sensor.model):
        raise ValueError(f"sensor {sensor.id}: params_in_map and hypotheses of a range do not go together")


def _check_digits(data):
    """Refuse a start so uncertain that a covariance has no digits left for what the sensors say of the map."""
    for robot in (robot for robot in data.robots if robot.in_map):
        x, P = robot.start()
        std, dim = np.sqrt(np.max(np.diag(P)[: data.frame.dim])), data.frame.dim
        for sensor in data.sensors:
            least = std / FARTHEST
            if sensor.robot == robot.id and (noise := noise_at_one_metre(sensor.model, dim)) < least:
                raise ValueError(
                    f"robot {robot.id}: position_std = {std:g} m beside {noise:.2g} m of noise of sensor {sensor.id} "
                    f"leaves no digits for the map; take at most {FARTHEST * noise:.2g} m, or 0: the start is the "
                    "origin of the map then"
                )


def noise_at_one_metre(sensor, dim):
    """Noise of the place of a point, as a sensor measures it one metre away, in its best direction, m.

    Parameters
    ----------
    sensor : SensorModel
    dim : int

    Returns
    -------
    float
        Infinity if it does not say.
    """
    most = 0.0
    with np.errstate(all="ignore"):
        for p in (*np.eye(dim), *-np.eye(dim)):
            try:
                Y_p = np.broadcast_to(sensor.project(p)[1], (len(sensor.R), dim))
                information = Y_p.T @ np.linalg.solve(sensor.R, Y_p)
            except Exception:  # a model of the user's: what is wrong with it shows where it is used
                continue
            if np.isfinite(information).all():
                most = max(most, np.linalg.eigvalsh(information)[-1])
    return 1 / np.sqrt(most) if most else np.inf


def started_by(data, sensor):
    """The type of the landmarks that a sensor is to start."""
    return sensor.landmark or data.landmark.model


def can_start(sensor, lmk):
    """Return True if a sensor model can give birth to a landmark of a type: from a ray, from a point, or from two rays.

    A sensor without `retro` starts none: what it measures, a range for example, fixes neither.
    """
    return hasattr(sensor, "retro") and hasattr(lmk, birth(sensor))


def _rings(data, sensor):
    """Return True if a sensor's landmarks are born as rings of hypotheses; refuse what that cannot be done with."""
    if not (data.landmark.hypotheses and rings_by(sensor.model)):
        return False
    kind = type(data.options.association).__name__
    if not getattr(data.options.association, "by_id", False):
        raise ValueError(
            f"sensor {sensor.id}: a range has no direction to match it by, so hypotheses need "
            f"association = 'known_ids', got {kind}"
        )
    if not hasattr(started_by(data, sensor), "from_point"):
        raise TypeError(
            f"sensor {sensor.id}: {type(started_by(data, sensor)).__name__} landmarks cannot be born from "
            "a range; take euc_pnt, or beacon"
        )
    return True


def _check_births(data):
    """Refuse sensors if none can start landmarks, or if one cannot start the type of its own that it was given."""
    lookers = [s for s in data.sensors if not hasattr(s.model, "without_lmks")]
    able = [can_start(s.model, started_by(data, s)) or _rings(data, s) for s in lookers]
    unable = [s for s, ok in zip(lookers, able, strict=True) if not ok]
    nothing = not any(able) and not data.landmark.surveyed
    bad = [s for s in unable if s.landmark is not None] or (unable if nothing else [])  # no lookers: none
    if bad:
        sensor, kind = type(bad[0].model).__name__, type(started_by(data, bad[0])).__name__
        why = "one ray does not fix them; take a landmark type with a prior, for example idp_pnt or ahm_pnt"
        if not hasattr(bad[0].model, "retro"):
            why = "it has no method retro; let another sensor start them, or say that they are known, in_map = false"
        if rings_by(bad[0].model):
            why = "a range tells no direction; take hypotheses = 64 of them all round, or let another sensor start them"
        raise TypeError(f"sensor {bad[0].id}: {kind} landmarks cannot be started by a {sensor}, {why}")


def _check_dimensions(data):
    """Refuse a scenario that is partly in the plane and partly in space."""
    of = {f"robot {r.id} ({type(r.motion).__name__})": r.frame.dim for r in data.robots}
    of |= {f"sensor {s.id} ({type(s.model).__name__})": getattr(s.model, "dim", data.frame.dim) for s in data.sensors}
    types = [data.landmark.model, *(s.landmark for s in data.sensors if s.landmark is not None)]
    of |= {f"landmark type {type(t).__name__}": getattr(t, "dim", data.frame.dim) for t in types}
    first, dim = next(iter(of.items()))
    for name, d in of.items():
        if d != dim:
            raise ValueError(f"{first} is {dim}D and {name} is {d}D; a scenario is in 2D or in 3D, not in both")


def _check_capacity(data):
    """Refuse a map too small for the robots and sensors that are estimated; landmarks that do not fit are left out."""
    capacity = data.options.capacity
    needed = sum(robot.motion.size for robot in data.robots if robot.in_map)
    needed += sum(data.frame.size + len(sensor.params()[0]) for sensor in data.sensors if sensor.in_map)
    surveyed = [entry.start(data.landmark.model, data.frame.dim)[1] for entry in data.landmark.surveyed]
    needed += sum(map(len, surveyed))
    if capacity is not None and capacity < needed:
        what = "robots, sensors and surveyed landmarks" if surveyed else "robots and sensors"
        raise ValueError(f"options: capacity {capacity} is less than the {needed} states of {what}")


def _check_view(figure, dim, has_sensor):
    """Refuse a view that the map figure does not have, and a camera that turns where it cannot."""
    views = (("top",) if dim == 2 else ("perspective", "top", "side")) + (("self",) if has_sensor else ())
    if figure.view and figure.view not in views:
        raise ValueError(f"figure: a {dim}D scenario has the views {', '.join(views)}, got {figure.view!r}")
    if figure.orbit_deg and (dim == 2 or figure.view == "self"):
        raise ValueError(
            f"figure: orbit_deg needs a 3D view from outside, got the {dim}D view {figure.view or 'top'!r}"
        )
