"""What a scenario says of a log: noise times a factor, a bias taken off, controls moved in time."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry2, Odometry3, Unicycle, Vehicle
from ekfslam_tutorial.toolbox import RawLog, Recorder, Recording, Robot, Sensor, UserData, universal_slam
from ekfslam_tutorial.toolbox.adjusted import (
    adjusted,
    is_adjusted,
    moved_in_time,
    places,
    sightings_from_one_place,
)
from ekfslam_tutorial.toolbox.scenario.reading import parse_toml
from ekfslam_tutorial.toolbox.scenario.writing import to_toml

TEXT = """
[[robot]]
motion = "odometry2"
dx = [0.1, 0]
da_deg = 1.0
dx_std = 0.01
da_std_deg = 0.2
[[sensor]]
type = "range_bearing"
range_std = 0.1
bearing_std_deg = 1.0
"""


def scenario(**overrides):

    return UserData.from_text(TEXT, {key.replace("__", "."): value for key, value in overrides.items()})


def a_log(with_noise=False):
    rng = np.random.default_rng(1)
    y = rng.uniform(1, 2, (6, 2))
    raw = RawLog(1, np.array([0, 2, 2, 6]), np.array([1, 2, 1, 2, 3, 4]), y, np.tile(np.diag([4.0, 1.0]), (6, 1, 1)))
    raw = raw if with_noise else replace(raw, R=None)
    return Recording("a log", np.array([0.0, 1.0, 3.0]), {1: rng.uniform(size=(3, 3))}, {1: raw})


def test_without_a_word_nothing_changes():
    log = a_log()
    assert adjusted(scenario(), log) is log and not is_adjusted(scenario())


@pytest.mark.parametrize("own", [False, True])
def test_the_factor_is_that_of_the_noise_that_counts(own):
    data, log = scenario(sensor__noise_factor=2.5, robot__noise_factor=3.0), a_log(own)
    assert is_adjusted(data)
    new = adjusted(data, log)
    R = np.diag([4.0, 1.0]) if own else data.sensors[0].model.R
    np.testing.assert_allclose(new.raw[1].R, np.tile(2.5 * R, (6, 1, 1)))
    np.testing.assert_allclose(new.robots[1].U, np.tile(3 * data.robots[0].U(), (3, 1, 1)))
    assert log.robots[1].U is None and (new.raw[1].y == log.raw[1].y).all()


def test_a_bias_is_taken_off():
    log = a_log()
    new = adjusted(scenario(sensor__bias=[0.5, -0.1]), log)
    np.testing.assert_allclose(new.raw[1].y, log.raw[1].y - [0.5, -0.1])
    assert new.raw[1].R is None


def test_controls_that_are_moved_in_time():
    t, speeds = np.array([0.0, 1.0, 2.0, 4.0]), np.array([[0.0], [1.0], [3.0], [2.0]])
    u, U = moved_in_time(t, speeds, speeds[:, :, None], 0.5, Unicycle())
    np.testing.assert_allclose(u.ravel(), [0, 1.0, 2.0, 2.25])  # half of each speed and of the one before; a quarter
    np.testing.assert_allclose(U.ravel(), u.ravel())
    u, U = moved_in_time(t, speeds, None, 0.5, Odometry2())  # the last step of 2 lasts 2 s
    np.testing.assert_allclose(u.ravel(), [0, 1.0, 2.0, 1.5 + 1.5])
    assert U is None
    np.testing.assert_allclose(moved_in_time(t, speeds, None, 0.0, Unicycle())[0], speeds)
    same = np.full((4, 1), 2.0)
    np.testing.assert_allclose(moved_in_time(t, same, None, -0.7, Unicycle())[0], same)  # of those nobody can tell
    assert moved_in_time(np.zeros(4), speeds, None, 0.5, Unicycle())[0] is speeds


def test_a_robot_that_stands_still_is_in_one_place():
    """Whatever its controls are: a step, speeds, a wheel that is turned while the car stands."""
    u = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 9e-4], [0.0, 1.1e-3], [0.0, 0.0], [-1e-3, 0.0], [0.5, 0.5]])
    assert places(u, Unicycle()).tolist() == [1, 1, 1, 2, 2, 2, 3]
    steps = np.zeros((4, 3))
    steps[1, 1], steps[3, 2] = -0.01, 0.01
    assert places(steps, Odometry2()).tolist() == [0, 1, 1, 2]
    assert places(np.hstack([steps, np.zeros((4, 3))]), Odometry3()).tolist() == [0, 1, 1, 2]
    truck = np.array([[1.0, 0.1, 0.0], [0.0, 0.5, 0.1], [0.0, -0.5, 0.0], [1.0, 0.0, 0.0]])
    assert places(truck, Vehicle()).tolist() == [1, 1, 1, 2]
    with pytest.raises(ValueError, match="lasting: the controls of ConstantVelocity do not tell when the robot stands"):
        places(np.zeros((2, 6)), ConstantVelocity())


def test_sightings_of_one_landmark_from_one_place_belong_together():
    """Those of unknown landmarks to nothing."""
    log = RawLog(1, np.array([0, 2, 4, 8]), np.array([1, 2, 1, -1, 1, 1, -1, 2]), np.zeros((8, 2)))
    group, size = sightings_from_one_place(log, np.array([0, 0, 5]))
    assert size[group].tolist() == [2, 1, 2, 1, 2, 2, 1, 1]
    assert group[0] == group[2] != group[4] == group[5]


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_sightings_with_a_part_in_common_are_worth_less(share):
    """A robot whose pose is known looks eight times at one point: the variance of the mean is R (1 + 7 share) / 8."""
    text = """
[[robot]]
motion = "odometry2"
in_map = false
[[sensor]]
type = "point_xy"
std = 0.5
"""
    data = UserData.from_text(text, {"sensor.lasting": share, "sensor.noise_factor": 2.0})
    y = np.random.default_rng(1).normal(size=(8, 2))
    assert is_adjusted(data)
    for n in (4, 8):
        still = {1: np.zeros((n, 3))}
        raw = RawLog(1, np.arange(n + 1), [7] * n, y[:n])
        each = Recording("a halt", np.arange(1.0 * n), still, {1: raw}, truth=still)
        *_, s = universal_slam(data, each)
        p, P = s.lmks[7].point(s.map)
        np.testing.assert_allclose(P, 2 * 0.25 * (1 + (n - 1) * share) / n * np.eye(2), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(p, y[:n].mean(0), atol=1e-12)


def test_controls_that_cannot_be_moved_are_refused():
    with pytest.raises(ValueError, match="clock_offset: the controls of ConstantVelocity cannot be moved"):
        moved_in_time(np.arange(3.0), np.zeros((3, 6)), None, 0.1, ConstantVelocity())


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("sensor.noise_factor", 0, "noise_factor must be a positive number, got 0"),
        ("robot.noise_factor", -1.0, "noise_factor must be a positive number"),
        ("sensor.bias", [1.0], "bias must be 2 numbers"),
        ("robot.clock_offset", "late", "clock_offset must be a number"),
        ("sensor.lasting", -1e-9, "lasting is a share, from 0 to 1, got"),
        ("sensor.lasting", 1.1, "lasting is a share, from 0 to 1, got 1.1"),
        ("sensor.lasting", [0.5], "lasting must be a number, got"),
    ],
)
def test_values_that_make_no_sense(key, value, says):
    with pytest.raises(ValueError, match=says):
        UserData.from_text(TEXT, {key: value})


def simulated(**overrides):
    path = "data/scenarios/range_bearing_2d.toml"
    return UserData.from_toml(path, {"time.last": 12} | {k.replace("__", "."): v for k, v in overrides.items()})


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch, request):
    monkeypatch.chdir(request.config.rootpath)


def test_a_common_factor_leaves_the_estimate_and_scales_the_covariance():
    """R and U times c: the same gains, P times c. The filter of a simulation is told so, the world is not."""
    one, four = (
        simulated(options__md2_threshold=1e9),
        simulated(options__md2_threshold=1e9, sensor__noise_factor=4.0, robot__noise_factor=4.0),
    )
    *_, a = universal_slam(one)
    *_, b = universal_slam(four)
    used = a.map.used
    np.testing.assert_allclose(b.map.x[used], a.map.x[used], atol=1e-9)
    np.testing.assert_allclose(b.map.P[used][:, used], 4 * a.map.P[used][:, used], rtol=1e-6, atol=1e-12)
    assert (a.truth[1] == b.truth[1]).all()


@pytest.mark.parametrize("change", [{"robot__clock_offset": 0.1}, {"sensor__bias": [0.1, 0]}, {"sensor__lasting": 0.5}])
def test_a_simulation_has_no_clock_and_no_bias(change):
    with pytest.raises(ValueError, match="is for recordings; this is a simulation"):
        universal_slam(simulated(**change))


def test_a_bias_that_is_told_is_as_good_as_none():
    recorder = Recorder()
    for s in universal_slam(simulated()):
        recorder.add(s)
    log = recorder.recording("a walk")
    off = replace(log, raw={1: replace(log.raw[1], y=log.raw[1].y + [0.3, 0.05])})
    *_, a = universal_slam(simulated(), log)
    *_, b = universal_slam(simulated(sensor__bias=[0.3, 0.05]), off)
    np.testing.assert_allclose(b.map.x[b.map.used], a.map.x[a.map.used], atol=1e-9)


def test_a_scenario_is_written_as_it_is_read():
    table = {
        "name": 'a "name"\nof two lines', "seed": 3, "time": {"last": 9, "dt": 0.5},
        "robot": [{"id": 1, "position": [0, 1.5]}, {"id": 2, "in_map": False}],
        "options": {"association": {"type": "jcbb", "confidence": 0.99}, "md2_threshold": float("inf")},
        "figure": {"limits": [[-1, 1], [0.0, 2e-7]]},
    }  # fmt: skip
    assert parse_toml(to_toml(table)) == table


@pytest.mark.parametrize("name", ["cloister_idp", "two_robots_four_cameras", "victoria_park", "lecture_mapping"])
def test_the_scenarios_of_the_package_survive_writing(name):
    with open(f"data/scenarios/{name}.toml", encoding="utf-8") as file:
        table = parse_toml(file.read())
    assert parse_toml(to_toml(table)) == table


def test_defaults_are_one_and_nothing():
    robot, sensor = Robot(), Sensor(model=simulated().sensors[0].model)
    assert (robot.noise_factor, robot.clock_offset, sensor.noise_factor) == (1.0, 0.0, 1.0)
    assert sensor.biases().tolist() == [0, 0]
