"""The lecture's log: the functions of the slide's listing, and the files they read."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.datasets import lecture
from ekfslam_tutorial.geometry import Frame2, wrap
from ekfslam_tutorial.toolbox import Recording

FOLDER = Path(__file__).resolve().parents[2] / "data" / "lecture"


def test_the_listing_of_the_slide_runs():
    lecture.load_data()
    cloud = [lecture.initL(z, lecture.get_pose(k)) for k in range(1, 51) for z in lecture.sense(k)]
    ids = [i for k in range(1, 51) for i in lecture.seen(k)]
    truth = dict(zip(*lecture.true_landmarks(), strict=True))

    errors = np.array([l - truth[i] for l, i in zip(cloud, ids, strict=True)])
    assert set(ids) == set(truth)
    # The cloud's spread: range 0.3 m, and up to 5 m times 5 deg = 0.44 m; 4 sigma of that is 1.8 m.
    assert np.hypot(*errors.T).max() < 1.8
    assert 0.15 < errors.std() < 0.44


def test_measurements_have_the_stated_noise():
    truth = dict(zip(*lecture.true_landmarks(), strict=True))
    z = []
    for k in range(1, 51):
        pose = Frame2(lecture.get_pose(k))
        for y, i in zip(lecture.sense(k), lecture.seen(k), strict=True):
            e, _ = lecture.SENSOR.project(pose.to_frame(truth[i])[0])
            z.append(lecture.SENSOR.residual(y, e))
    white = np.array(z) / [lecture.SENSOR.range_std, lecture.SENSOR.bearing_std]
    n = len(white)
    # 99.9 % bands of the mean (3.3 / sqrt n) and of the standard deviation (3.3 / sqrt 2n) of n unit normals
    assert np.all(np.abs(white.mean(0)) < 3.3 / np.sqrt(n))
    assert np.all(np.abs(white.std(0) - 1) < 3.3 / np.sqrt(2 * n))


def test_odometry_has_the_stated_noise():
    noise = []
    for k in range(2, 51):
        step, *_ = Frame2(lecture.get_pose(k - 1)).inverse()[0].compose(Frame2(lecture.get_pose(k)))
        noise.append([*(lecture.odometry(k)[:2] - step.t), wrap(lecture.odometry(k)[2] - step.theta)])
    white = np.array(noise) / lecture.ODOMETRY_STD
    assert not lecture.odometry(1).any()
    assert np.all(np.abs(white.std(0) - 1) < 3.3 / np.sqrt(2 * len(white)))


def test_a_result_is_the_callers_own():
    lecture.get_pose(3)[:] = 0
    lecture.sense(3)[:] = 0
    assert lecture.get_pose(3).any() and lecture.sense(3).any()


@pytest.mark.parametrize("k", [0, 51, -1, 2.5])
def test_a_step_that_is_not_there(k):
    with pytest.raises(ValueError, match=r"steps 1 to 50, got"):
        lecture.get_pose(k)


def test_the_committed_log_is_the_one_the_script_makes():
    spec = importlib.util.spec_from_file_location("make_log", FOLDER / "make_log.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    made, kept = script.make(), Recording.load(FOLDER)
    # The files have 6 decimals; another maths library may round the last one the other way.
    np.testing.assert_allclose(kept.truth[1], made.truth[1], atol=2e-6)
    np.testing.assert_allclose(kept.robots[1].u, made.robots[1].u, atol=2e-6)
    np.testing.assert_allclose(kept.raw[1].y, made.raw[1].y, atol=2e-6)
    assert kept.raw[1].ids.tolist() == made.raw[1].ids.tolist()
    assert kept.notes == made.notes and f"seed {script.SEED}" in kept.notes[0]


def test_the_log_is_small_and_described():
    assert sum(p.stat().st_size for p in FOLDER.iterdir()) < 200_000
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    for path in FOLDER.glob("*.csv"):
        assert path.name in text
        assert all(f"`{column}`" in text for column in path.open(encoding="utf-8").readline().strip().split(","))
