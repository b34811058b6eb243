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
from ..exercises.nb18_correct import correct_both
from ..exercises.nb18_meet import meet
from ..project import SYMPTOMS, Project, Symptom, scores
from ..trial import run_trial

SECONDS = 120.0  # of the twin
ERROR = 0.06  # m, at most in the last third: right runs have 0.03 to 0.04, those with landmarks alone 0.12
ODOMETRY = OdometryNoise(along=0.03, across=0.02, turn=0.06, drift=0.034)

SCENARIO = """
name = "five robots"
time = {last = 900}
landmark = {type = "euc_pnt"}
robot = [
  {id=1, motion="odometry2", position=[0, 0], orientation_deg=0},
  {id=2, motion="odometry2", position=[-2.6, 1.1], orientation_deg=170, position_std=0.5, orientation_std_deg=20},
  {id=3, motion="odometry2", position=[-1.1, 1.1], orientation_deg=-10, position_std=0.5, orientation_std_deg=20},
  {id=4, motion="odometry2", position=[1.2, -1.7], orientation_deg=175, position_std=0.5, orientation_std_deg=20},
  {id=5, motion="odometry2", position=[2.2, -0.3], orientation_deg=-55, position_std=0.5, orientation_std_deg=20},
]
sensor = [
  {id=1, robot=1, type="range_bearing", range_std=0.15, bearing_std_deg=1.0},
  {id=2, robot=2, type="range_bearing", range_std=0.15, bearing_std_deg=1.0},
  {id=3, robot=3, type="range_bearing", range_std=0.15, bearing_std_deg=1.0},
  {id=4, robot=4, type="range_bearing", range_std=0.15, bearing_std_deg=1.0},
  {id=5, robot=5, type="range_bearing", range_std=0.15, bearing_std_deg=1.0},
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
    assert rec.landmarks is not None
    return replace(
        rec,
        raw=plain(rec.raw),
        met=plain(rec.met),
        truth={id: mine(poses) for id, poses in rec.truth.items()},
        landmarks=SimLmk(rec.landmarks.ids, start.to_frame(rec.landmarks.points)[0]),
    )


def unmet():
    """The same recording without sightings of robots."""
    rec = twin()
    nobody = lambda log: replace(log, offsets=0 * log.offsets, ids=log.ids[:0], y=log.y[:0])
    return replace(rec, met={id: nobody(log) for id, log in rec.met.items()})


def loop(world):
    """Five robots in one filter: yield the map after each frame.

    world.x, shape (15,), and world.P, shape (15, 15), are the poses of the robots before the first frame.
    `for rob in world.robs`: rob.id, its range rob.r in x, and rob.motion.move(x, u, dt), which returns the pose after a
    step, X_x, X_u. `for sen in world.sens`: sen.id, sen.robot, the id of the robot that carries it, and sen.model.R,
    shape (2, 2). `for now in world` goes through the frames: now.u[rob.id] and now.U[rob.id] are the control and its
    covariance, now.dt the time; now.seen[sen.id] is a list of pairs (landmark id, [range, bearing]), now.met[sen.id]
    the same with ids of robots. Use a gate of 13.8 on the squared Mahalanobis distance.
    Yield x, P, lmks after each frame: the whole map, the robots first, and a dictionary landmark id: slice.
    """
    x, P, lmks = world.x, world.P, {}
    at = {rob.id: rob.r for rob in world.robs}

    def correct(x, P, a, b, y, R):
        """Correct with what the robot at a saw of b: a robot, or a landmark, which is a robot without a heading."""
        e, E_a, E_b = meet(x[a], np.append(x[b], 0.0)[:3])
        E_b = E_b[:, : b.stop - b.start]
        z = y - e
        z[1] = wrap(z[1])
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


LITTLE = Symptom(
    "the error",
    lambda s, p: s.error > ERROR,
    "the robots are off by {s.error:.3f} m in the last third; with all that is seen it is about half of that",
    "Honest, but it learns little: are all known landmarks of a frame used, by all five sensors? Are all sightings of robots? Is the noise of the sensors much too large?",
)
UNUSED = "The sightings of robots are not used: is there a loop over now.met[sen.id], for every sensor, inside that over the frames? Does it hand the corrected x and P on?"
INCEST = "So the sightings of robots make it too sure. Do both blocks go into H, E_a of the robot that looks and E_b of the one that is seen? now.met[sen.id] is what the robot sen.robot sees. What two robots know in common is in P[a, b]: an estimate of the other one, taken as news, counts it twice."


class FiveRobots(Project):
    """A project in which runs are compared with what the same loop makes of a log without sightings of robots."""

    def judge(self, run):
        """Judge a run; one that is not right, or not better than without sightings of robots, is told so."""
        verdict = super().judge(run)
        if verdict.status == "not attempted" or verdict.link in ("is a run", "scenario", "loop", "the map"):
            return verdict
        alone = run_trial(run.data, run.loop, run.data.seed, self.limit, unmet())
        if alone.failed is not None:
            return verdict
        s, without = scores([run.trial]), scores([alone])
        if np.isclose(s.error, without.error, rtol=1e-9):
            message = "without the sightings of robots your loop gives the same result"
            return replace(verdict, status="failed", link="robots see robots", message=message, hint=UNUSED)
        if s.nees > self.band[1] >= without.nees:
            message = (
                f"the mean NEES is {s.nees:.1f} (band {self.band[0]:g} to {self.band[1]:g}); without the sightings of "
                f"robots it is {without.nees:.1f}"
            )
            return replace(verdict, status="failed", link="robots see robots", message=message, hint=INCEST)
        return verdict

    @property
    def links(self):
        """What is tested, in order."""
        return (*super().links, "robots see robots")


project = FiveRobots(
    "18.project",
    "Five robots that see each other",
    loop,
    scenario=SCENARIO,
    start=START,
    hints=(
        "In each frame: move all five robots first; then for each sensor landmarks that are known, landmarks that are new, and robots. Your `meet` serves for both: a landmark is a robot without a heading, meet(x[a], [lx, ly, 0]), and of E_b only the first two columns count.",
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
    symptoms=(*SYMPTOMS, LITTLE),
    recording=lambda data: twin(),
)
