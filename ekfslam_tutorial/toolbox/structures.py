"""From the user's data to the structures of a run (manual, section 4.1: createSLAMstructures, createSimStructures)."""

import numpy as np

from ..models import state_class
from ..models.landmarks import EucPnt
from ..simulation import SimRob, SimSen
from ..slam import Lmk, Rob, Sen, Tim, place
from . import engines
from .recordings.logs import checked_landmarks
from .user_input import errors_at

SIMULATED_FRAMES = 100  # where the user does not say how many


def create_slam_structures(data, landmarks=None, poses=None):
    """Make map, robots, sensors, landmarks and time, as they are before the first frame.

    Parameters
    ----------
    data : UserData
    landmarks : SimLmk, optional
        The landmarks of the world; needed where they are known (localisation).
    poses : dict of int to ndarray, or to (ndarray, ndarray), optional
        Where robots start whose position the user has left open, as frame vectors; or their whole states with the
        covariance.

    Returns
    -------
    map : Map
    robs : list of Rob
    sens : list of Sen
    lmks : dict of int to Lmk
    tim : Tim
    """
    map = engines.engine(data.options).new_map(data.options.capacity)
    robs = [_create_rob(map, robot, data, (poses or {}).get(robot.id)) for robot in data.robots]
    sens = [_create_sen(map, sensor, data.frame) for sensor in data.sensors]
    first, last = data.time.first, data.time.last
    tim = Tim(first, first + SIMULATED_FRAMES - 1 if last is None else last, data.time.dt)
    return map, robs, sens, _known_lmks(data, landmarks) | _surveyed_lmks(map, data), tim


def _create_rob(map, robot, data, pose):
    rob = Rob(robot.id, robot.motion, robot.name, robot.type, U=robot.U(), sensors=_sensors_of(robot, data))
    x, P = robot.start()
    if robot.position is None and isinstance(pose, tuple):
        x, P = pose
    elif robot.position is None and pose is not None:
        x[: len(pose)] = pose
    place(map, rob, x, P if robot.in_map else None)
    return rob


def _create_sen(map, sensor, frame):
    model = sensor.seen_as
    sen = Sen(sensor.id, sensor.robot, model, state_class(frame, model), sensor.name, lmk_type=sensor.landmark)
    sen.tilt, sen.walk = np.deg2rad(sensor.orientation_walk_deg), sensor.params()[2]
    x, P = sensor.start(frame)
    place(map, sen, x, P if sensor.in_map else None)
    return sen


def _sensors_of(robot, data):
    return [sensor.id for sensor in data.sensors if sensor.robot == robot.id]


def _known_lmks(data, landmarks):
    """Make all landmarks, as known points, where the user says that they are not to be estimated."""
    if data.landmark.in_map:
        return {}
    if landmarks is None:
        raise ValueError("the landmarks are known (in_map = false), so a world or a recording must say where they are")
    type = EucPnt(data.frame.dim)
    pairs = zip(landmarks.ids.tolist(), landmarks.points, strict=True)
    return {id: Lmk(id, type, x=np.array(p), slot=slot) for slot, (id, p) in enumerate(pairs)}


def _surveyed_lmks(map, data):
    """Put those landmarks into the map whose places have been measured before; nobody has looked for them yet."""
    lmks = {}
    for slot, entry in enumerate(data.landmark.surveyed):
        kind, l, P = entry.start(data.landmark.model, data.frame.dim)
        counts = dict.fromkeys(("n_search", "n_match", "n_inlier"), 0)
        lmks[entry.id] = Lmk(entry.id, kind, r=map.add(l, P), slot=slot, **counts)
    return lmks


def create_sim_structures(data, streams):
    """Make true robots, sensors and landmarks, as they are before the first frame.

    Where the user says how well a start or a mounting is known, the truth is a draw around it.

    Parameters
    ----------
    data : UserData
    streams : Streams

    Returns
    -------
    sim_robs : list of SimRob
    sim_sens : list of SimSen
    sim_lmk : SimLmk
    rngs : dict
        The generators to go on with: ("motion", robot id), ("sensing", sensor id) and ("clutter", sensor id).
    """
    rngs = {("motion", r.id): streams.motion(r.id) for r in data.robots}
    rngs |= {("sensing", s.id): streams.sensing(s.id) for s in data.sensors}
    rngs |= {("clutter", s.id): streams.clutter(s.id) for s in data.sensors}

    sim_robs = []
    for r in data.robots:
        x, _ = r.start(rngs["motion", r.id].standard_normal(r.dof))
        sim_robs.append(SimRob(r.id, r.name, r.motion, x, r.controls()[0], _sensors_of(r, data), r.type))
    sim_sens = []
    for s in data.sensors:
        x, _ = s.start(data.frame, rngs["sensing", s.id].standard_normal(data.frame.dof + len(s.params()[0])))
        F = state_class(data.frame, s.seen_as)(x)
        sim_sens.append(SimSen(s.id, s.name, s.robot, F, s.seen_as, s.p_detect, s.clutter))
    return sim_robs, sim_sens, _create_sim_lmk(data, streams.world), rngs


def _create_sim_lmk(data, rng):
    if data.world is None:
        raise ValueError("a simulation needs a world: write [world] with type = ..., or give a recording")
    name = data.world.type
    with errors_at(f"the world {name!r}"):
        landmarks = checked_landmarks(*data.world.build(rng))
        if not len(landmarks.ids) + len(landmarks.segment_ids):
            raise ValueError("there is no landmark in it")
    dim = landmarks.points.shape[1]
    if dim != data.frame.dim:
        robot = data.robots[0]
        raise ValueError(
            f"the world {name!r} is {dim}D and robot {robot.id} is {robot.frame.dim}D; "
            "a scenario is in 2D or in 3D, not in both"
        )
    return landmarks
