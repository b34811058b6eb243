"""Replay of a recorded run through this package's own steps, and the references it is compared with."""

from dataclasses import dataclass

import numpy as np

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks.lines import offsets

from .scenario import FAR, LANDMARKS, LINES, TYPES

ENGINES = {"plain": slam, "fast": fast}
KINDS = {"search": 0, "innovation": 1, "correction": 2, "initialisation": 3, "deletion": 4}


@dataclass
class Run:
    """What came out of a run.

    Parameters
    ----------
    events : ndarray of int, shape (M, 6)
        [event, frame, robot, sensor, landmark id, flag], in order; the flag of an innovation tells whether it passed
        the gate, other flags are 0.
    poses : ndarray, shape (F, robots, 7)
        At the end of each frame, with unit quaternions.
    points : dict of int to ndarray, shape (3,), or None
        Landmarks at the end, as Euclidean points, by id; None where a reference does not hold them. Of a line, the four
        numbers of `offsets` from the true one.
    covariances : dict of int to ndarray, shape (3, 3), or None
    """

    events: np.ndarray
    poses: np.ndarray
    points: dict | None
    covariances: dict | None


def replay(scenario, births=False, engine="plain"):
    """Run the filter on the recorded controls and measurements; all decisions are its own.

    Parameters
    ----------
    scenario : Scenario
    births : bool
        See `Scenario.start`.
    engine : str
        Whose steps: "plain" or "fast".

    Returns
    -------
    Run
    """
    steps = ENGINES[engine]
    map, robots, sensors, opt = scenario.start(births, steps.new_map)
    lmks, obs, events, poses = {}, {}, [], []
    for frame in range(scenario.n_frames):
        n_max = opt.n_inits[frame > 0]
        for i, rob in robots.items():
            rob.u = scenario.control(frame, i)
            steps.move(map, rob, scenario.data["Time"]["dt"])
            for s in rob.sensors:
                raw = scenario.raw(frame, s)
                happened, new = steps.correct_known_lmks(map, rob, sensors[s], lmks, obs, raw, opt)
                happened += steps.init_new_lmks(map, rob, sensors[s], lmks, raw, new, opt, n_max)
                if scenario.type in ("plkLin", "aplLin"):
                    for lmk in lmks.values():
                        lmk.par = np.array([-FAR, FAR])
                events += [row(event, frame + 1) for event in happened if event.kind in KINDS]
        poses.append([rob.state(map)[:7].copy() for rob in robots.values()])
    found = {id: place(scenario, id, lmk.type, lmk.state(map), map.block(lmk.r)) for id, lmk in lmks.items()}
    points, covariances = ({id: f[k] for id, f in found.items()} for k in (0, 1))
    return Run(np.array(events).reshape(-1, 6), unit_poses(poses), points, covariances)


def place(scenario, id, kind, l, P):
    """Where a landmark is, and the covariance of that: a point; or how far a line is from the true one, 4 numbers."""
    p, P_l = offsets(kind, l, *scenario.segment(id)) if scenario.type in LINES else kind.point(l)
    return p, P_l @ P @ np.transpose(P_l)


def row(event, frame):
    """An event as numbers."""
    flag = event.flag if event.kind == "innovation" else 0
    return [KINDS[event.kind], frame, event.rob, event.sen, event.lmk, int(flag)]


def unit_poses(poses):
    """Poses with unit quaternions."""
    return Frame3(np.array(poses, float)).normalized()[0].x


def recorded(scenario):
    """The recorded program's own run."""
    arrays, ev = scenario.arrays, scenario.arrays["ev_int"]
    events = np.column_stack([ev[:, [0, 1, 2, 3, 5]], accepted(ev)])
    poses = np.stack([arrays[f"est_x_rob{i}"][:, :7] for i in range(1, scenario.n_robots + 1)], 1)
    return Run(events, unit_poses(poses), *recorded_landmarks(scenario))


def recorded_landmarks(scenario):
    """Points and covariances at the end; None for both in an extract of the first frames."""
    arrays = scenario.arrays
    if "P_frame" not in arrays:
        return None, None
    x, P = arrays["map_x"][-1], arrays[f"P_{int(arrays['P_frame'][0]):04d}"]
    points, covariances = {}, {}
    for (used, id, code, *_), positions in zip(arrays["lmk_table"][-1], arrays["lmk_range"][-1], strict=True):
        if used:
            r = positions[positions > 0] - 1
            kind = LANDMARKS[TYPES[code - 1]]
            points[int(id)], covariances[int(id)] = place(scenario, int(id), kind, x[r], P[np.ix_(r, r)])
    return points, covariances


def accepted(ev):
    """Flags: an innovation was accepted when a correction of the same landmark follows."""
    follows = np.zeros(len(ev), bool)
    follows[:-1] = (ev[1:, 0] == 2) & (ev[1:, 1:6] == ev[:-1, 1:6]).all(-1)
    return ((ev[:, 0] == 1) & follows).astype(int)


def exact(path):
    """The run of an independent implementation of the exact formulas, from exact/NAME.npz."""
    with np.load(path) as a:
        events = a["ev"].copy()
        events[events[:, 0] != 1, 5] = 0
        if "ids" not in a.files:
            return Run(events, unit_poses(a["poses"]), None, None)
        ids = a["ids"].astype(int).tolist()
        points, covariances = (dict(zip(ids, a[name], strict=True)) for name in ("pts", "covs"))
        return Run(events, unit_poses(a["poses"]), points, covariances)
