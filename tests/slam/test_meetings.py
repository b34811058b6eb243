"""Robots that see each other: Jacobians by both, the correction, the gate, and what a meeting is good for."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band, nees
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q, numerical_jacobian
from ekfslam_tutorial.models import observe
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2, Odometry3
from ekfslam_tutorial.models.sensors import PinHoleDepth, RangeBearing
from ekfslam_tutorial.simulation import draw
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_met_robots, move, place, project_robots

from .scenes import FORWARD, raw

RNG = np.random.default_rng


def pose3(t, angles):
    return np.concatenate([t, e2q(np.asarray(angles, float))[0]])


def pair(d=2, P=None, sensor_P=None):
    """Two robots that look about, the first with a sensor that is mounted off its middle."""
    map = Map()
    frame, motion = (Frame2, Odometry2()) if d == 2 else (Frame3, Odometry3())
    poses = [[0.2, -0.3, 0.4], [3.0, 1.0, -1.2]]
    poses = poses if d == 2 else [pose3([0, 0, 0.2], [0.02, -0.05, 0.3]), pose3([4, 1, 0.5], [0.3, 0.1, -1])]
    robs = [Rob(i, motion, U=1e-4 * np.eye(frame.dof)) for i in (1, 2)]
    for rob, x in zip(robs, poses, strict=True):
        place(map, rob, np.array(x, float), None if P is None else P)
    model = RangeBearing(0.05, 0.01) if d == 2 else PinHoleDepth(depth_std=0.05)
    sen = Sen(7, 1, model, frame)
    place(map, sen, np.array([0.1, 0.05, 0.2]) if d == 2 else FORWARD, sensor_P)
    return map, robs, sen


@pytest.mark.parametrize("d", [2, 3])
def test_jacobians_by_both_robots_and_the_sensor(d):
    size = 3 if d == 2 else 7
    map, (rob, other), sen = pair(d, 1e-3 * np.eye(size), 1e-4 * np.eye(size))

    def expectation(x):
        frame = sen.frame_type
        return observe(frame(x[rob.r]), frame(x[sen.r]), sen.model, EucPnt(d), frame(x[other.r]).t)[0]

    (o,) = project_robots(map, rob, sen, [other])
    H = np.zeros((len(o.e), map.n))
    for r, J in o.blocks:
        H[:, r] = J
    np.testing.assert_allclose(H, numerical_jacobian(expectation, map.x.copy()), rtol=1e-5, atol=1e-6 * abs(H).max())
    np.testing.assert_allclose(o.E, H @ map.P @ H.T, rtol=1e-9, atol=1e-12)
    assert o.lmk == 2 and H[:, other.r][:, :d].any(axis=0).all() and not H[:, other.r][:, d:].any()


def test_the_correction_is_the_textbooks():
    """x + K z and (I - K H) P with the dense H: both robots move, and become correlated."""
    map, (rob, other), sen = pair(P=np.diag([0.02, 0.03, 0.005]))
    x, P = map.x.copy(), map.P.copy()
    (o,) = project_robots(map, rob, sen, [other])
    H = np.hstack([o.E_r, o.E_l, np.zeros((2, 1))])
    y = o.e + [0.05, -0.01]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + sen.model.R)
    (event,) = correct_met_robots(map, rob, sen, [rob, other], raw([2], [y]), Options(error="additive"))
    assert (event.kind, event.rob, event.sen, event.lmk, event.flag) == ("meeting", 1, 7, 2, True)
    np.testing.assert_allclose(map.x, x + K @ [0.05, -0.01], atol=1e-12)
    np.testing.assert_allclose(map.P, P - K @ H @ P, atol=1e-12)
    assert abs(map.P[rob.r, other.r]).max() > 1e-4


@pytest.mark.parametrize("known", [0, 1])
def test_a_robot_whose_pose_is_known_is_a_beacon(known):
    map, robs, sen = pair(P=np.diag([0.02, 0.03, 0.005]))
    fixed = robs[known]
    x, r = map.x[fixed.r].copy(), fixed.r
    fixed.x, fixed.r = x, None
    map.remove(r)
    (o,) = project_robots(map, robs[0], sen, [robs[1]])
    before = np.trace(map.P)
    correct_met_robots(map, robs[0], sen, robs, raw([2], [o.e]), Options())
    assert np.trace(map.P) < before and np.array_equal(fixed.x, x)


def test_gate_strangers_and_own_covariance():
    map, robs, sen = pair(P=1e-4 * np.eye(3))
    (o,) = project_robots(map, robs[0], sen, robs[1:])
    x = map.x.copy()
    far = o.e + [5.0, 0.0]
    events = correct_met_robots(map, robs[0], sen, robs, raw([9, 2, 1], [far, far, far]), Options(md2_threshold=13.8))
    assert [(e.lmk, e.flag) for e in events] == [(2, False)], "robot 9 is not here, and robot 1 does not see itself"
    assert np.array_equal(map.x, x)
    R = np.array([100 * np.eye(2)])
    events = correct_met_robots(map, robs[0], sen, robs, raw([2], [far], R), Options(md2_threshold=13.8))
    assert events[0].flag and not np.array_equal(map.x, x)


def walk(seed, meet, steps=40):
    """Two robots walk blindly side by side; robot 1 measures robot 2 where `meet`; errors of both, and the NEES."""
    rng = RNG(seed)
    P0, U = np.diag([0.01, 0.01, 0.001]), np.diag([0.02, 0.01, 0.01]) ** 2
    map, motion, model = Map(), Odometry2(), RangeBearing(0.05, 0.01)
    robs, sen = [Rob(i, motion, U=U) for i in (1, 2)], Sen(1, 1, model, Frame2)
    truth = [Frame2(np.array([0.0, 0.0, 0.0])), Frame2(np.array([1.5, 1.0, 0.0]))]
    place(map, sen, np.zeros(3))
    for rob, F, P in zip(robs, truth, (P0 * 1e-2, P0), strict=True):  # the first one knows better where it is
        place(map, rob, F.x + draw(rng, P), P)
    for _ in range(steps):
        for k, rob in enumerate(robs):
            step = np.array([0.1, 0.0, 0.03])
            truth[k] = truth[k].compose(Frame2(step))[0]
            rob.u = step + draw(rng, U)
            move(map, rob, 0.1)
        y = model.project(truth[0].to_frame(truth[1].t)[0])[0] + draw(rng, model.R)
        if meet:
            correct_met_robots(map, robs[0], sen, robs, raw([2], [y]), Options())
    e = [rob.frame(map).minus(F)[0] for rob, F in zip(robs, truth, strict=True)]
    n = [nees(rob.frame(map), map.P[rob.r, rob.r], F) for rob, F in zip(robs, truth, strict=True)]
    return np.array(e), np.array(n)


def test_meetings_make_the_robots_better_and_stay_honest():
    """30 walks. NEES of one pose per walk and robot in the 99.9 % band; the variance of the worse robot falls."""
    met, blind = (([walk(seed, meet) for seed in range(30)]) for meet in (True, False))
    low, high = anees_band(3, 30, 0.999)
    for robot in (0, 1):
        assert low < np.mean([n[robot] for _, n in met]) < high
    rms = [np.sqrt(np.mean([(e[1, :2] ** 2).sum() for e, _ in walks])) for walks in (met, blind)]
    assert rms[0] < 0.8 * rms[1]
