"""Project 18: five robots that see each other, in one filter of one's own."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from ...datasets import mrclam, mrclam_twin
from ...datasets.mrclam_log import ROBOTS, read_set
from ...datasets.odometry import OdometryNoise
from ...geometry import Frame2, wrap
from ...simulation import SimLmk
from .. import asks
from ..project import SYMPTOMS, Project, Symptom
from .nb18_correct import correct_both
from .nb18_meet import meet

SECONDS = 120.0  # of the twin
MET_ERROR = 0.07  # m, at most with the sightings of robots: measured, see tests/course/test_projects_space.py
ODOMETRY = OdometryNoise(along=0.03, across=0.02, turn=0.06, drift=0.034)

SCENARIO = """
name = "five robots"
time = {last = 900}
landmark = {type = "euc_pnt"}
robot = [
    {id = 1, motion = "odometry2", position = [0, 0], orientation_deg = 0},
    {id = 2, motion = "odometry2", position = [-2.6, 1.1], orientation_deg = 170, position_std = 0.5, orientation_std_deg = 20},
    {id = 3, motion = "odometry2", position = [-1.1, 1.1], orientation_deg = -10, position_std = 0.5, orientation_std_deg = 20},
    {id = 4, motion = "odometry2", position = [1.2, -1.7], orientation_deg = 175, position_std = 0.5, orientation_std_deg = 20},
    {id = 5, motion = "odometry2", position = [2.2, -0.3], orientation_deg = -55, position_std = 0.5, orientation_std_deg = 20},
]
sensor = [
    {id = 1, robot = 1, type = "range_bearing", range_std = 0.15, bearing_std_deg = 1.0},
    {id = 2, robot = 2, type = "range_bearing", range_std = 0.15, bearing_std_deg = 1.0},
    {id = 3, robot = 3, type = "range_bearing", range_std = 0.15, bearing_std_deg = 1.0},
    {id = 4, robot = 4, type = "range_bearing", range_std = 0.15, bearing_std_deg = 1.0},
    {id = 5, robot = 5, type = "range_bearing", range_std = 0.15, bearing_std_deg = 1.0},
]
"""

START = SCENARIO[: SCENARIO.index("sensor = [")] + (
    "# Here: five sensors, one on each robot, with its id. A range is good to about 0.15 m, a bearing to about 1 degree.\n"
)


@cache
def twin():
    """The recording of the simulated twin in the frame of robot 1 at its start. The noise of the sensors is left out.

    So the filter takes that of the scenario.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = mrclam_twin.write(Path(folder) / "MRCLAM_Twin", 1, SECONDS, sparse=())
        log = read_set(mrclam.find_set(1, path), ROBOTS)
    rec = mrclam.recording(log, None, ODOMETRY)
    start = Frame2(rec.truth[1][0])
    mine = lambda poses: np.column_stack([start.to_frame(poses[:, :2])[0], wrap(poses[:, 2] - start.theta)])
    plain = lambda logs: {id: replace(log, R=None) for id, log in logs.items()}
    return replace(
        rec,
        raw=plain(rec.raw),
        met=plain(rec.met),
        truth={id: mine(poses) for id, poses in rec.truth.items()},
        landmarks=SimLmk(rec.landmarks.ids, start.to_frame(rec.landmarks.points)[0]),
    )


def loop(world):
    """Five robots in one filter: yield the map after each frame.

    world.x, shape (15,), and world.P, shape (15, 15), are the poses of the robots before the first frame.
    `for rob in world.robs`: rob.id, its range rob.r in x, and rob.motion.move(x, u, dt), which returns the pose after a
    step, X_x, X_u. `for sen in world.sens`: sen.id, sen.robot, the id of the robot that carries it, and sen.model.R,
    shape (2, 2). `for now in world` goes through the frames: now.u[rob.id] and now.U[rob.id] are the control and its
    covariance, now.dt the time; now.seen[sen.id] is a list of pairs (landmark id, [range, bearing]), now.met[sen.id]
    the same with ids of robots. Some sightings are wrong: the gate is 13.8.
    Yield x, P, lmks after each frame: the whole map, the robots first, and a dictionary landmark id: slice.
    """
    x, P, lmks = world.x, world.P, {}
    at = {rob.id: rob.r for rob in world.robs}

    def correct(x, P, a, b, y, R):  # b: a robot, or a landmark, which is a robot without a heading
        e, E_a, E_b = meet(x[a], np.append(x[b], 0.0)[:3])
        E_b = E_b[:, : b.stop - b.start]
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        Z = R + np.hstack([E_a, E_b]) @ P[np.ix_(np.r_[a, b], np.r_[a, b])] @ np.hstack([E_a, E_b]).T
        return (x, P) if z @ np.linalg.solve(Z, z) > 13.8 else correct_both(x, P, a, b, z, E_a, E_b, R)

    for now in world:
        for rob in world.robs:
            r = rob.r
            x[r], X_x, X_u = rob.motion.move(x[r], now.u[rob.id], now.dt)
            P[r] = X_x @ P[r]
            P[:, r] = P[:, r] @ X_x.T
            P[r, r] += X_u @ now.U[rob.id] @ X_u.T
        for sen in world.sens:
            a, R = at[sen.robot], sen.model.R
            for id, y in now.seen[sen.id]:
                if id in lmks:
                    x, P = correct(x, P, a, lmks[id], y, R)
                else:  # l = t + range [cos, sin](heading + bearing)
                    u = np.array([np.cos(x[a][2] + y[1]), np.sin(x[a][2] + y[1])])
                    v = np.array([-u[1], u[0]])
                    L_r, L_y = np.column_stack([np.eye(2), y[0] * v]), np.column_stack([u, y[0] * v])
                    P_lx = L_r @ P[a]
                    lmks[id] = slice(len(x), len(x) + 2)
                    x = np.append(x, x[a][:2] + y[0] * u)
                    P = np.block([[P, P_lx.T], [P_lx, P_lx[:, a] @ L_r.T + L_y @ R @ L_y.T]])
            for id, y in now.met[sen.id]:
                x, P = correct(x, P, a, at[id], y, R)
        yield x, P, lmks


def _range_noise(data):
    for s in data.sensors:
        r, b = np.sqrt(np.diag(s.model.R)) * [1, 180 / np.pi]
        if not (0.05 <= r <= 0.5 and 0.3 <= b <= 5):
            return f"sensor {s.id} has {r:.2g} m and {b:.2g} degrees: 0.05 to 0.5 m and 0.3 to 5 degrees make sense"
    return None


def _own_sensor(data):
    wrong = [s.id for s in data.sensors if s.id != s.robot]
    return f"sensor {wrong[0]} is on robot {data.sensors[0].robot}: each has the id of its robot" if wrong else None


project = Project(
    "18.project",
    "Five robots that see each other",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "In each frame: move all five robots first; then for each sensor landmarks that are known, landmarks that are "
        "new, and robots. Your `meet` serves for both: a landmark is a robot without a heading, meet(x[a], [lx, ly, 0]), "
        "and of E_b only the first two columns count.",
        "Known landmark: e, E_a, E_b = meet(x[a], np.append(x[l], 0.0)); z = y - e with the bearing wrapped; "
        "x, P = correct_both(x, P, a, l, z, E_a, E_b[:, :2], R), if z' Z^-1 z < 13.8. A robot: meet(x[a], x[b]) and the "
        "same. New landmark: l = t + range [cos, sin](heading + bearing), P_lx = L_r P[a], "
        "P_ll = P_lx[:, a] L_r' + L_y R L_y'.",
    ),
    asks=(
        asks.robots(*["odometry2"] * 5),
        asks.sensors(*["range_bearing"] * 5),
        asks.landmarks("euc_pnt"),
        asks.frames(600, 1900),
        asks.estimated(),
        _own_sensor,
        _range_noise,
    ),
    band=(0.8, 6.0),
    before=(
        Symptom(
            "robots see robots",
            lambda s, p: s.nees <= p.band[1] and MET_ERROR < s.error < 0.3 * s.dead_error,
            "the robots are off by {s.error:.3f} m in the last third: as much as with landmarks alone",
            "The sightings of robots are not used, or not by both: is there a loop over now.met[sen.id]? Do both blocks, "
            "E_a and E_b, go into the correction?",
        ),
    ),
    symptoms=SYMPTOMS,
    recording=lambda data: twin(),
)
