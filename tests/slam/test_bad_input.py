"""Bad input: one clear sentence, before anything has been changed."""

import numpy as np
import pytest

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.models.landmarks import EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import Gps
from ekfslam_tutorial.slam import Options, Rob, correct_known_lmks, init_new_lmks, move, place

from .scenes import Scene, raw

P3 = np.diag([0.01, 0.01, 0.001])


def snapshot(scene):
    return scene.map.x.copy(), scene.map.P.copy(), dict(scene.lmks)


def assert_unchanged(scene, before):
    x, P, lmks = before
    assert np.array_equal(scene.map.x, x) and np.array_equal(scene.map.P, P) and scene.lmks == lmks


@pytest.mark.parametrize(
    "ids, y, said",
    [
        ([5], [[3.0, np.nan]], r"sensor 1: measurement 0 of landmark 5 must be finite, got \[3.0, nan\]"),
        ([4, 5], [[3.0, 0.1], [np.inf, 0.0]], "sensor 1: measurement 1 of landmark 5 must be finite"),
        ([5], [[3.0, 0.1, 2.0]], r"must have shape \(1, 2\), one row per id, got \(1, 3\)"),
        ([4, 5], [[3.0, 0.1]], r"must have shape \(2, 2\), one row per id, got \(1, 2\)"),
        ([5], [3.0, 0.1], r"must have shape \(1, 2\), one row per id, got \(2,\)"),
    ],
)
def test_bad_measurements(ids, y, said):
    scene = Scene(P=P3)
    scene.add(5, [3.0, 0.3], 0.01 * np.eye(2))
    before = snapshot(scene)
    with pytest.raises(ValueError, match=said):
        correct_known_lmks(*scene.all, scene.obs, raw(ids, y), scene.opt)
    assert_unchanged(scene, before)


def test_bad_measurements_of_robots_and_of_oneself():
    """One that is right comes first: it is not used either."""
    scene = Scene(P=P3)
    other = Rob(2, Odometry2())
    place(scene.map, other, np.array([3.0, 0.3, 0.0]), P3)
    before = snapshot(scene)
    with pytest.raises(ValueError, match="measurement 1 of landmark 2 must be finite"):
        two = raw([2, 2], [[3.0, 0.1], [np.nan, 0.0]])
        slam.correct_met_robots(scene.map, scene.rob, scene.sen, [scene.rob, other], two, scene.opt)
    assert_unchanged(scene, before)
    scene.sen.model = Gps()
    with pytest.raises(ValueError, match="measurement 1 of landmark -1 must be finite"):
        two = raw([-1, -1], [[0.1, 0.0], [np.inf, 0.0]])
        slam.correct_without_lmks(scene.map, scene.rob, scene.sen, scene.obs, two, scene.opt, {})
    assert_unchanged(scene, before)


def test_ids_that_are_no_numbers():
    scene = Scene(P=P3)
    measurements = raw([1], [[3.0, 0.1]])
    measurements.ids = np.array([1.5])
    with pytest.raises(ValueError, match=r"ids must be integers, got \[1.5\] \(float64\)"):
        correct_known_lmks(*scene.all, scene.obs, measurements, scene.opt)


@pytest.mark.parametrize(
    "R, said",
    [
        (np.eye(2), r"must have shape \(1, 2, 2\), got \(2, 2\)"),
        (np.diag([1.0, -1.0])[None], "noise covariance of landmark 5 must be positive semi-definite"),
        (np.array([[[1.0, 0.5], [0.0, 1.0]]]), "noise covariance of landmark 5 must be symmetric"),
    ],
)
def test_bad_noise(R, said):
    scene = Scene(P=P3)
    with pytest.raises(ValueError, match=said):
        correct_known_lmks(*scene.all, scene.obs, raw([5], [[3.0, 0.1]], R), scene.opt)


@pytest.mark.parametrize(
    "u, said",
    [
        ([0.1, 0.0], r"robot 1: the control must be 3 finite numbers \[dx, da\], got"),
        ([0.1, 0.0, np.nan], "robot 1: the control must be 3 finite numbers"),
        (None, "robot 1: the control must be real numbers, got None"),
    ],
)
def test_bad_controls(u, said):
    scene = Scene(P=P3)
    scene.rob.u = u if u is None else np.array(u)
    before = snapshot(scene)
    with pytest.raises(ValueError, match=said):
        move(scene.map, scene.rob, 0.1)
    assert_unchanged(scene, before)


@pytest.mark.parametrize(
    "U, said",
    [
        (np.eye(2), r"control covariance must have shape \(3, 3\), got \(2, 2\)"),
        (np.diag([1.0, 1.0, -1.0]), "control covariance must be positive semi-definite"),
        (np.diag([1.0, 1.0, np.nan]), "control covariance must be finite"),
    ],
)
def test_bad_control_noise(U, said):
    scene = Scene(P=P3)
    scene.rob.u, scene.rob.U = np.zeros(3), U
    with pytest.raises(ValueError, match=f"robot 1: the {said}"):
        move(scene.map, scene.rob, 0.1)


@pytest.mark.parametrize("dt", [-0.1, np.nan, np.inf])
def test_bad_durations(dt):
    scene = Scene(P=P3)
    scene.rob.u = np.zeros(3)
    with pytest.raises(ValueError, match="the duration of a step must be a number of seconds, got"):
        move(scene.map, scene.rob, dt)


@pytest.mark.parametrize("dt", ["0.1", 0.1 + 0j, None, np.array(0.1, object), [0.1]])
def test_durations_that_are_no_numbers(dt):
    """Neither engine counts with them, nor stops with a sentence of numpy."""
    for steps, map in ((slam, slam.new_map()), (fast, fast.new_map())):
        rob = slam.Rob(1, Odometry2(), u=np.zeros(3), U=np.eye(3))
        slam.place(map, rob, np.zeros(3), np.eye(3))
        for good in (0.1, np.float32(0.1), 1, np.array(0.1)):
            steps.move(map, rob, good)
        with pytest.raises(ValueError, match="robot 1: the duration of a step must be (real numbers|a number of sec)"):
            steps.move(map, rob, dt)


@pytest.mark.parametrize("P, said", [(np.eye(2), "must have shape"), (np.diag([1.0, 1.0, -0.1]), "semi-definite")])
def test_bad_starts(P, said):
    scene = Scene()
    with pytest.raises(ValueError, match=said):
        place(scene.map, scene.rob, np.zeros(3), P)


def test_a_pair_that_does_not_fit_is_named():
    """A camera cannot start a Euclidean point: one ray does not fix it."""
    scene = Scene(d=3, P=1e-6 * np.eye(7), lmk_type=EucPnt())
    before = snapshot(scene)
    with pytest.raises(TypeError, match="EucPnt cannot be started by PinHole: one ray does not fix it"):
        init_new_lmks(*scene.all, raw([3], [[300.0, 200.0]]), [0], scene.opt)
    assert_unchanged(scene, before)


@pytest.mark.parametrize(
    "options, said",
    [
        (dict(n=[0.1], N=[[-1.0]]), "prior must be positive semi-definite"),
        (dict(n=[0.1, 0.2]), r"prior must have shape \(2, 2\)"),
        (dict(md2_threshold=0.0), "md2_threshold must be a positive number, got 0.0"),
        (dict(n_updates=-1), "n_updates must be a whole number of 0 or more, or None, got -1"),
        (dict(n_inits=(1, 2, 3)), r"n_inits must be two whole numbers of 0 or more, or None, got \(1, 2, 3\)"),
        (dict(min_match_ratio=10), "min_match_ratio must be between 0 and 1, got 10"),
        (dict(init_margin=np.nan), "init_margin must be a number of 0 or more, got nan"),
    ],
)
def test_bad_options(options, said):
    with pytest.raises(ValueError, match=said):
        Options(**options)


def test_a_prior_of_the_wrong_length_is_noticed():
    scene = Scene(d=3, P=1e-6 * np.eye(7), lmk_type=IdpPnt(), n=[0.1, 0.2], N=np.eye(2))
    before = snapshot(scene)
    with pytest.raises(ValueError):
        init_new_lmks(*scene.all, raw([3], [[300.0, 200.0]]), [0], scene.opt)
    assert_unchanged(scene, before)
