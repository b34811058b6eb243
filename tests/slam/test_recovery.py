"""A robot that is lost: its gate is opened, and only its."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry2, Odometry3, Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import worlds
from ekfslam_tutorial.slam import Event, Options, Rob, place, reopen_gate
from ekfslam_tutorial.toolbox import Options as UserOptions
from ekfslam_tutorial.toolbox import Recorder, Robot, Sensor, Time, UserData, World, universal_slam

REFUSED, ACCEPTED = (Event("innovation", 1, 1, 7, flag) for flag in (False, True))


def start(motion, rng):
    """A robot in a map, correlated with 4 other states."""
    n = motion.size
    map, rob = Map(), Rob(1, motion)
    A = rng.normal(size=(n + 4, n + 4))
    P = A @ A.T
    x = rng.normal(size=n)
    if motion.frame.dim == 3:
        x[3:7] /= np.linalg.norm(x[3:7])
    place(map, rob, x, P[:n, :n])
    map.add(rng.normal(size=4), P[n:, n:], P[n:, :n])
    return map, rob


@pytest.mark.parametrize("motion", [Odometry2(), Unicycle(), Odometry3(), ConstantVelocity()])
def test_the_pose_becomes_more_uncertain_and_nothing_else_changes(motion, rng):
    map, rob = start(motion, rng)
    F, d = motion.frame, motion.frame.dim
    frame = slice(0, F.size)
    rob.n_refused = 2
    x, P = map.x.copy(), map.P.copy()
    opt = Options(reopen_after=3, reopen_std=(0.3, 0.5))
    (event,) = reopen_gate(map, rob, [REFUSED], opt)
    assert event.kind == "recovery" and event.rob == 1 and rob.n_refused == 0
    assert abs(F(map.x[frame]).minus(F(x[frame]))[0]).max() < 1e-12
    np.testing.assert_allclose(map.x[F.size :], x[F.size :], atol=1e-12)

    added = map.P - P
    E_f = F(map.x[frame]).minus(F(x[frame]))[1]
    wanted = np.diag([0.3**2] * d + [0.5**2] * (F.dof - d))
    np.testing.assert_allclose(E_f @ added[frame, frame] @ E_f.T, wanted, atol=1e-9)
    if d == 2:  # in space the quaternion is normalised as well, which takes out what lies along it
        added[frame, frame] = 0
        np.testing.assert_allclose(added, 0, atol=1e-12)
    np.testing.assert_allclose(map.P[F.size :, F.size :], P[F.size :, F.size :], atol=1e-12)
    assert np.linalg.eigvalsh(map.P)[0] > -1e-9


def test_refusals_are_counted_in_a_row(rng):
    map, rob = start(Odometry2(), rng)
    opt = Options(reopen_after=3)
    P = map.P.copy()
    assert reopen_gate(map, rob, [REFUSED, REFUSED], opt) == []
    assert reopen_gate(map, rob, [], opt) == []
    assert reopen_gate(map, rob, [ACCEPTED], opt) == [] and rob.n_refused == 0
    assert reopen_gate(map, rob, [REFUSED, Event("search", 1, 1, 7), REFUSED], opt) == []
    np.testing.assert_array_equal(map.P, P)
    assert len(reopen_gate(map, rob, [REFUSED], opt)) == 1


def test_never_unless_asked_and_never_for_a_known_robot(rng):
    map, rob = start(Odometry2(), rng)
    P = map.P.copy()
    assert reopen_gate(map, rob, [REFUSED] * 50, Options()) == []
    np.testing.assert_array_equal(map.P, P)
    known = Rob(2, Odometry2(), x=np.zeros(3))
    assert reopen_gate(map, known, [REFUSED] * 50, Options(reopen_after=2)) == []


def pushed_robot():
    """A recorded run on a circle among a ring of landmarks, in which the robot is turned by 1 rad and does not know."""
    turns = [5.0] * 40 + [5.0 + np.rad2deg(1.0)] + [5.0] * 60
    userdata = UserData(
        robots=[
            Robot(
                motion=Odometry2(),
                control={"dx": [[0.15, 0]] * len(turns), "da_deg": turns},
                control_std={"dx": 0.005, "da_deg": 0.5},
            )
        ],
        sensors=[Sensor(model=RangeBearing(range_std=0.05, bearing_std=0.02, max_range=6.0))],
        world=World(build=lambda rng: worlds.ring(n=16, radius=4.0), type="ring"),
        time=Time(last=len(turns)),
        options=UserOptions(md2_threshold=13.8),
    )
    recorder = Recorder()
    for snapshot in universal_slam(userdata, seed=3):
        recorder.add(snapshot)
    recording = recorder.recording("pushed")
    recording.robots[1].u[40, 2] -= 1.0
    return userdata, recording


@pytest.mark.parametrize("after", [None, 4])
def test_a_robot_that_was_pushed_is_lost_for_good_without_recovery(after):
    userdata, recording = pushed_robot()
    userdata = replace(userdata, options=replace(userdata.options, reopen_after=after))
    history = History("fixed")
    for _ in history.watch(universal_slam(userdata, recording)):
        pass
    heading = abs(history.track(1).errors()[0][:, 2])
    assert heading[:40].max() < 0.1
    if after is None:
        assert heading[-20:].min() > 0.5 and history.n_recoveries == 0
    else:
        assert heading[-20:].max() < 0.1 and history.n_recoveries >= 1
        assert history.summary()["landmark_rmse_m"] < 0.15
