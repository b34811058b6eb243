"""Made-up recordings in the recorded format: what the replay must be able to read, without the recorded numbers.

The truth and the measurements come from this package's simulator, the "recorded" results from its own filter. They say
nothing about the filter being right; they say that a recording of this kind can be read, replayed and scored.
"""

import json

import numpy as np

from ekfslam_tutorial.geometry import Frame3, e2q
from ekfslam_tutorial.models.sensors.lens import inv_distortion
from ekfslam_tutorial.simulation import SimLmk, SimRob, SimSen, draw, sim_motion, sim_observation, worlds
from ekfslam_tutorial.slam import correct_known_lmks, init_new_lmks, move

from .replay import KINDS, row
from .scenario import MOTIONS, Scenario, camera, numbered, several

RDF = [-90.0, 0.0, -90.0]  # degrees: turns a robot's axes into those of a camera
OMNI = {
    "intrinsic": [668.0, 438.0, 1.0, 0.0, 0.0],
    "distortion": [644.7, -341.0, -29.01, -57.7, 18.49, 5.415, 50.65, -56.14, 15.91, 0.0, 0.0],
    "invDistortion": [447.3, 0.0, -0.001068, 1.184e-06, -1.856e-09],
    "imageSize": [1280.0, 800.0],
}


def robot(**changes):
    """A robot as the recorded program's user writes it."""
    values = dict(motion="odometry", position=[0.0, -5.0, 0.0], orientationDegrees=[0.0, 0.0, 0.0])
    values |= dict(positionStd=[0.0] * 3, orientationStd=[0.0] * 3, dx=[0.08, 0.0, 0.0], daDegrees=[0.0, 0.0, 0.9])
    return dict(id=1.0, name="Dala") | values | dict(dxStd=[0.005] * 3, daStd=[0.05] * 3) | changes


def moving(**changes):
    """A robot with constant velocity."""
    values = dict(motion="constVel", position=[1.0, 0.0, 0.0], orientationDegrees=[0.0, 0.0, 45.0])
    values |= dict(velocity=[1.0, 0.0, 0.0], angularVelDegrees=[0.0, 0.0, 10.0], velStd=[0.0] * 3, angVelStd=[0.0] * 3)
    return robot(**values | dict(dv=[0.0] * 3, dwDegrees=[0.0] * 3, dvStd=[0.0] * 3, dwStd=[0.0, 0.0, 1.0]) | changes)


def sensor(type="pinHole", **changes):
    """A sensor as the recorded program's user writes it."""
    values = dict(id=1.0, name="Micropix", type=type, robot=1.0, position=[0.0, 0.0, 0.6], orientationDegrees=RDF)
    values |= dict(positionStd=[0.0] * 3, orientationStd=[0.0] * 3, imageSize=[640.0, 480.0], pixErrorStd=1.0)
    values |= dict(intrinsic=[320.0, 240.0, 320.0, 320.0], distortion=[], frameInMap=0, depthErrorStd=0.1)
    return values | (OMNI if type == "omniCam" else {}) | changes


def options(type="idpPnt", n_updates=10.0, md2=9.0, n_inits=(10.0, 1.0)):
    """Options as the recorded program's user writes them."""
    correct = dict(reprojectLmks=1, reparametrize=1, nUpdates=n_updates, MD2th=md2, linTestIdp=0.1)
    init = dict(nbrInits=list(n_inits), initType=type, idpPnt=dict(nonObsMean=0.01, nonObsStd=0.5))
    size = 3.0 if type == "eucPnt" else 7.0
    return dict(map=dict(numLmks=73.0, lmkSize=size), correct=correct, init=init)


WITH_LENS = dict(distortion=[-0.3, 0.1])
TWO = [robot(), robot(id=2.0, position=[0.0, 5.0, 0.0], orientationDegrees=[0.0, 0.0, 180.0], positionStd=[0.02] * 3)]
FOUR = [
    sensor(),
    sensor(id=2.0, frameInMap=1, orientationStd=[1.5] * 3, position=[0.0, -0.25, 0.6]),
    sensor(id=3.0, robot=2.0),
    sensor(id=4.0, robot=2.0, **WITH_LENS),
]
KNOWN_KINDS = {
    "pnt_ahm": (robot(), sensor(), options("ahmPnt"), "ekf"),
    "pnt_hmg": (robot(), sensor(), options("hmgPnt"), "ekf"),
    "pnt_idp_distort": (robot(), sensor(**WITH_LENS), options(), "ekf"),
    "pnt_idp_frameinmap": (
        robot(positionStd=[0.01] * 3, orientationStd=[0.5] * 3),
        sensor(frameInMap=1, positionStd=[0.02] * 3, orientationStd=[1.0] * 3),
        options(),
        "ekf",
    ),
    "constvel_default": (moving(), sensor(), options(), "ekf"),
    "omni_ahm": (robot(), sensor("omniCam"), options("ahmPnt"), "ekf"),
    "pnt_idp_outliers": (robot(), sensor(), options(n_updates=20.0, md2=1.0, n_inits=(10.0, 2.0)), "ekf"),
    "phd_euc_distort": (
        robot(),
        sensor("pinHoleDepth", pixErrorStd=0.7, depthErrorStd=0.2, **WITH_LENS),
        options("eucPnt"),
        "graph",
    ),
    "multi_2rob_4sen": (TWO, FOUR, options(), "ekf"),
    "one_robot_two_sensors": (robot(), FOUR[:2], options(), "ekf"),
    "two_robots_one_sensor_each": (TWO, [FOUR[0], sensor(id=2.0, robot=2.0)], options(), "ekf"),
}


def pose(user):
    """Pose [t; q] and its covariance, from degrees."""
    e, std = np.radians(user["orientationDegrees"]), np.radians(user["orientationStd"])
    q, Q_e = e2q(e)
    P = np.zeros((7, 7))
    P[:3, :3], P[3:, 3:] = np.diag(np.square(user["positionStd"])), Q_e * std**2 @ Q_e.T
    return np.concatenate([user["position"], q]), P


def state(user):
    """State of a robot and its covariance."""
    x, P = pose(user)
    if user["motion"] == "odometry":
        return x, P
    x = np.concatenate([x, user["velocity"], np.radians(user["angularVelDegrees"])])
    Q = np.zeros((13, 13))
    Q[:7, :7] = P
    Q[7:, 7:] = np.diag(np.square(np.concatenate([user["velStd"], np.radians(user["angVelStd"])])))
    return x, Q


def control(user):
    """Control and its standard deviations."""
    step, impulse = ("dx", "daDegrees", "dxStd", "daStd"), ("dv", "dwDegrees", "dvStd", "dwStd")
    names = step if user["motion"] == "odometry" else impulse
    a, b, a_std, b_std = (np.asarray(user[name]) for name in names)
    return np.concatenate([a, np.radians(b)]), np.concatenate([a_std, np.radians(b_std)])


def parameters(user):
    """What the recorded program derives from a sensor's parameters."""
    d, k = user["distortion"], user["intrinsic"]
    par = dict(imSize=user["imageSize"], k=k, d=d)
    if user["type"] == "omniCam":
        return par | dict(pixErr=user["pixErrorStd"], c=user["invDistortion"])
    par["c"] = inv_distortion(np.array(d), len(d) + 1, k).tolist()
    if user["type"] == "pinHoleDepth":
        std = [user["pixErrorStd"], user["pixErrorStd"], user["depthErrorStd"]]
        return par | dict(cov=dict(shape=[3, 3], data=np.diag(np.square(std)).tolist()))
    return par | dict(pixErr=user["pixErrorStd"])


def one_or_all(items):
    """A list of one is stored as the item itself."""
    return items[0] if len(items) == 1 else items


def describe(name, robots, sensors, opt, branch, frames):
    """The parameters, as NAME.json holds them."""
    carried = [one_or_all([s["id"] for s in several(sensors) if s["robot"] == k]) for k, _ in numbered(robots)]
    stds = [control(r)[1] for r in several(robots)]
    return {
        "name": name,
        "branch": branch,
        "Time": {"dt": 0.1, "firstFrame": 1.0, "lastFrame": float(frames)},
        "Opt": opt,
        "Robot": robots,
        "Sensor": sensors,
        "senPar": one_or_all([parameters(s) for s in several(sensors)]),
        "senFrame": one_or_all([pose(s)[0].tolist() for s in several(sensors)]),
        "robSensors": one_or_all(carried),
        "robCon": one_or_all([{"U": {"shape": [6, 6], "data": np.diag(s**2).tolist()}} for s in stds]),
    }


def initial(data):
    """Initial map: robots first, then sensors that are in it."""
    states = [(f"rob{i}", *state(r)) for i, r in numbered(data["Robot"])]
    for i, s in numbered(data["Sensor"]):
        states.append((f"sen{i}", *(pose(s) if s["frameInMap"] else (np.zeros(0), np.zeros((0, 0))))))
    n = sum(len(x) for _, x, _ in states) + int(data["Opt"]["map"]["numLmks"] * data["Opt"]["map"]["lmkSize"])
    arrays, at = {"map_x0": np.zeros(n), "map_P0": np.zeros((n, n))}, 0
    for name, x, P in states:
        r = slice(at, at + len(x))
        arrays["map_x0"][r], arrays["map_P0"][r, r], at = x, P, r.stop
        arrays[f"range_{name}"] = np.arange(r.start, r.stop) + 1
    return arrays


def simulate(data, frames, rng):
    """Noisy controls and measurements, in the arrays' layout."""
    world = SimLmk(*worlds.cloister())
    robots = [SimRob(i, "", MOTIONS[r["motion"]], state(r)[0], control(r)[0]) for i, r in numbered(data["Robot"])]
    pars = several(data["senPar"])
    sensors = [
        SimSen(i, "", int(s["robot"]), Frame3(pose(s)[0]), camera(s, pars[i - 1])) for i, s in numbered(data["Sensor"])
    ]
    stds = {r.id: control(user)[1] for r, user in zip(robots, several(data["Robot"]), strict=True)}
    u, raw = {r.id: [] for r in robots}, {s.id: [] for s in sensors}
    for _ in range(frames):
        for r in robots:
            sim_motion(r, 0.1)
            u[r.id].append(r.u + draw(rng, np.diag(stds[r.id] ** 2)))
            for s in (s for s in sensors if s.robot == r.id):
                raw[s.id].append(sim_observation(r, s, world, rng))
    arrays = {f"u_rob{i}": np.array(rows) for i, rows in u.items()}
    for i, observations in raw.items():
        arrays[f"pts_sen{i}_off"] = np.cumsum([0, *(len(o) for o in observations)])
        arrays[f"pts_sen{i}_id"] = np.concatenate([o.ids for o in observations])
        arrays[f"pts_sen{i}_y"] = np.concatenate([o.y for o in observations])
    return arrays


def results(scenario, frames, rng):
    """Fill in the arrays of the recorded results from this package's own run."""
    arrays = scenario.arrays
    map, robots, sensors, opt = scenario.start()
    n = len(arrays["map_x0"])
    lmks, obs, events = {}, {}, []
    for i, rob in robots.items():
        arrays[f"est_x_rob{i}"] = np.zeros((frames, rob.motion.size))
    for frame in range(frames):
        for i, rob in robots.items():
            rob.u = scenario.control(frame, i)
            move(map, rob, 0.1)
            for s in rob.sensors:
                raw = scenario.raw(frame, s)
                if raw.started is not None:  # chance decides, as in the recorded program
                    raw.started = rng.permutation([id for id in raw.ids if id not in lmks])[:1].tolist()
                happened, new = correct_known_lmks(map, rob, sensors[s], lmks, obs, raw, opt)
                happened += init_new_lmks(map, rob, sensors[s], lmks, raw, new, opt, opt.n_inits[frame > 0])
                events += [row(event, frame + 1) for event in happened if event.kind in KINDS]
        for i, rob in robots.items():
            arrays[f"est_x_rob{i}"][frame] = rob.state(map)
    events = np.array(events).reshape(-1, 6)
    arrays["ev_int"] = np.zeros((len(events), 11), int)
    arrays["ev_int"][:, [0, 1, 2, 3, 5]] = events[:, :5]
    x, P = np.zeros(n), np.zeros((n, n))
    x[: map.n], P[: map.n, : map.n] = map.x[:n], map.P[:n, :n]
    arrays["map_x"] = np.tile(x, (frames, 1))
    arrays |= {"P_frame": np.array([frames]), f"P_{frames:04d}": P}
    arrays["lmk_table"], arrays["lmk_range"] = np.zeros((frames, 73, 7), int), np.zeros((frames, 73, 11), int)
    words = {"EucPnt": 0, "IdpPnt": 1, "AhmPnt": 2, "HmgPnt": 3}
    for lmk in lmks.values():
        arrays["lmk_table"][-1, lmk.slot, :3] = 1, lmk.id, words[type(lmk.type).__name__] + 1
        arrays["lmk_range"][-1, lmk.slot, : lmk.type.size] = np.arange(lmk.r.start, lmk.r.stop) + 1


def make(folder, name, frames=20, seed=1):
    """Write NAME.json and NAME.npz of one of the known kinds into a folder."""
    robots, sensors, opt, branch = KNOWN_KINDS[name]
    rng = np.random.default_rng(seed)
    data = describe(name, robots, sensors, opt, branch, frames)
    arrays = initial(data) | {"frame": np.arange(1, frames + 1)} | simulate(data, frames, rng)
    arrays |= {"map_x": np.zeros((frames, len(arrays["map_x0"]))), "ev_int": np.zeros((0, 11), int)}
    scenario = Scenario(name, data, arrays)
    results(scenario, frames, rng)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps(data), encoding="utf-8")
    np.savez_compressed(folder / f"{name}.npz", **scenario.arrays)
    return scenario
