"""A stream of messages comes to what the recording of them comes to, in whatever order they arrive."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from ekfslam_tutorial.models.motion import ConstantVelocity, Imu, Odometry2, Odometry3, Unicycle
from ekfslam_tutorial.toolbox import (
    Control,
    Measurement,
    OnlineSlam,
    Recorder,
    Recording,
    Robot,
    Timeline,
    UserData,
    as_stream,
    integrate,
    recording_of,
    universal_slam,
)

from .scenarios import FLAT as FIFTY_FRAMES
from .scenarios import SPACE

FLAT = FIFTY_FRAMES | {"time": {"dt": 0.2, "last": 25}}
FLEET = FLAT | {
    "robot": [
        FLAT["robot"][0],
        FLAT["robot"][0] | {"id": 2, "position": [0.0, 4.0], "orientation_deg": 180.0},
    ],
    "sensor": [FLAT["sensor"][0], FLAT["sensor"][0] | {"id": 2, "robot": 2}],
    "time": {"dt": 0.1, "last": 25},
}
WAYS = {
    "plane": FLAT,
    "fast": FLAT | {"options": {"engine": "fast"}},
    "compressed": FLAT | {"options": {"engine": "fast", "compressed": True}},
    "who is who is not known": FLAT | {"options": {"association": "jcbb", "joint": True}},
    "first estimates": FLAT | {"options": {"first_estimates": True}},
    "space": SPACE,
    "space, fast": SPACE | {"options": SPACE["options"] | {"engine": "fast", "joint": True}},
    "two robots": FLEET,
    "known by their looks": SPACE
    | {
        "sensor": [SPACE["sensor"][0] | {"descriptor_size": 4}],
        "options": SPACE["options"] | {"association": "descriptors"},
        "time": {"last": 8},
    },
}
LATE = 0.5


def recorded(table):
    """A scenario and the recording of its simulation."""
    data, recorder = UserData.from_dict(table), Recorder()
    for now in universal_slam(data):
        recorder.add(now)
    return data, recorder.recording("a run")


def end_of(run):
    *_, now = run
    return now


def shuffled(messages, seed, share=0.2):
    """The messages in the order in which they arrive, when a share of them is late by up to half a second."""
    rng = np.random.default_rng(seed)
    late = np.where(rng.random(len(messages)) < share, rng.uniform(0, LATE, len(messages)), 0.0)
    return [messages[i] for i in np.argsort([m.t for m in messages] + late, kind="stable")]


def assert_same(now, other, atol=1e-9):
    assert list(now.lmks) == list(other.lmks) or set(now.lmks) == set(other.lmks)
    for a, b in zip([*now.robs, *now.lmks.values()], [*other.robs, *(other.lmks[i] for i in now.lmks)], strict=True):
        np.testing.assert_allclose(a.state(now.map), b.state(other.map), atol=atol)
        np.testing.assert_allclose(now.map.block(a.r), other.map.block(b.r), atol=atol)
    assert now.k == other.k


def unsynchronised(n=60, seed=7):
    """A robot whose speeds come at 20 Hz and whose laser looks at 7.3 Hz, at posts that it cannot miss."""
    rng, data = np.random.default_rng(seed), UserData.from_dict(FLAT | {"time": {"dt": 0.1}})
    posts = np.array([[3.0, -3.0], [2.0, -6.0], [-2.0, -2.0]])
    messages = [Control(0.05 * (k + 1), [0.8, 0.02 * np.sin(k)] + rng.normal(0, 0.01, 2)) for k in range(n)]
    for t in np.arange(0.1, 0.05 * n, 1 / 7.3):
        d = posts - [0.8 * t, -4.0]
        y = np.column_stack([np.hypot(*d.T), np.arctan2(d[:, 1], d[:, 0])]) + rng.normal(0, [0.1, 0.02], (3, 2))
        messages.append(Measurement(t, [1, 2, 3], y))
    return data, sorted(messages, key=lambda m: m.t)


# --- the same numbers ---


@pytest.mark.parametrize("way", WAYS)
def test_a_stream_is_the_recording(way):
    data, recording = recorded(WAYS[way])
    slam, messages = as_stream(data, recording)
    for m in messages:
        assert slam.add(m) is None
    assert_same(slam.update(), end_of(universal_slam(data, recording)), 1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_messages_that_are_late_change_nothing(way):
    data, recording = recorded(WAYS[way])
    slam, messages = as_stream(data, recording)
    for k, m in enumerate(shuffled(messages, seed=4)):
        assert slam.add(m) is None
        if k % 3 == 0:
            slam.update()
    assert not slam.dropped
    assert_same(slam.update(), end_of(universal_slam(data, recording)))


@pytest.mark.parametrize("seed", range(3))
def test_rates_of_their_own_in_any_order(seed):
    data, messages = unsynchronised()
    end = end_of(universal_slam(data, recording_of(messages, data, "own rates")))
    x, P = end.robs[0].state(end.map), end.map.block(end.robs[0].r)
    slam = OnlineSlam(data)
    for m in shuffled(messages, seed):
        assert slam.add(m) is None
        slam.update()
    np.testing.assert_allclose(slam.state()[0], x, atol=1e-9)
    np.testing.assert_allclose(slam.state()[1], P, atol=1e-9)
    assert slam.update().k == sum(isinstance(m, Measurement) for m in messages)


def test_robots_with_rates_of_their_own():
    data, rng = UserData.from_dict(FLEET), np.random.default_rng(3)
    messages = [Control(t, [1.0, 0.3], 1) for t in np.arange(0.05, 3, 0.05)]
    messages += [Control(t, [0.8, -0.2], 2) for t in np.arange(0.07, 3, 0.07)]
    messages += [
        Measurement(t, [5], [[2.0 + rng.normal(0, 0.1), 0.1 * s]], s)
        for s in (1, 2)
        for t in np.arange(0.1, 3, 0.11 * s)
    ]
    messages += [Measurement(1.2, [2], [[8.0, 1.5]], 1, of_robots=True)]
    ends = []
    for order in (sorted(messages, key=lambda m: m.t), shuffled(messages, 1), shuffled(messages, 2, share=1.0)):
        slam = OnlineSlam(data)
        for m in order:
            assert slam.add(m) is None
            slam.update()
        ends.append([slam.state(3.5, robot) for robot in (1, 2)])
    for other in ends[1:]:
        for (x, P), (y, Q) in zip(ends[0], other, strict=True):
            np.testing.assert_allclose(x, y, atol=1e-9)
            np.testing.assert_allclose(P, Q, atol=1e-9)


def test_measurements_of_one_time_are_one_look():
    data, messages = unsynchronised()
    rows = []
    for m in messages:
        one_each = isinstance(m, Measurement)
        rows += [replace(m, ids=[i], y=[y]) for i, y in zip(m.ids, m.y, strict=True)] if one_each else [m]
    ends = []
    for order in (messages, rows, shuffled(rows, 5)):
        slam = OnlineSlam(data)
        for m in order:
            slam.add(m)
        ends.append((slam.update().k, *slam.state()))
    for k, x, P in ends[1:]:
        assert k == ends[0][0]
        np.testing.assert_allclose(x, ends[0][1], atol=1e-12)
        np.testing.assert_allclose(P, ends[0][2], atol=1e-12)


def test_with_the_time_of_day_it_is_the_same():
    data, messages = unsynchronised()
    day = 1.7e9
    slam, later = OnlineSlam(data), OnlineSlam(data, t0=day)
    for m in messages:
        slam.add(m)
        later.add(replace(m, t=day + m.t))
    np.testing.assert_allclose(later.state()[0], slam.state()[0], atol=1e-5)  # a double has 2e-7 s there


def test_noise_bias_and_clock_of_the_scenario_hold():
    data, messages = unsynchronised()
    robots = [replace(data.robots[0], noise_factor=4.0, clock_offset=0.02)]
    sensors = [replace(data.sensors[0], noise_factor=2.0, bias=[0.1, 0.01])]
    told = replace(data, robots=robots, sensors=sensors)
    U, R = 4 * data.robots[0].U(), 2 * data.sensors[0].model.R
    slam, other = OnlineSlam(told), OnlineSlam(data)
    for m in messages:
        slam.add(m)
        if isinstance(m, Control):
            other.add(Control(m.t + 0.02, m.u, 1, U))
        else:
            other.add(Measurement(m.t, m.ids, m.y - [0.1, 0.01], 1, np.tile(R, (3, 1, 1))))
    for a, b in zip(slam.state(), other.state(), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


# --- a control that spans a measurement ---


@pytest.mark.parametrize(
    "motion, u",
    [
        (Odometry2(), [0.5, 0.1, 1.2]),
        (Odometry2(), [0.5, 0.1, 0.0]),
        (Odometry3(), [0.5, 0.1, -0.2, 0.3, 0.9, -0.4]),
        (Odometry3(), [0.5, 0.1, -0.2, 0.0, 0.0, 1e-5]),
    ],
)
def test_the_parts_of_a_step_make_the_whole(motion, u):
    u, U = np.array(u), np.diag(np.arange(1.0, len(u) + 1)) * 1e-4
    x = np.array([1.0, 2.0, 0.5]) if motion.size == 3 else np.array([1.0, 2.0, 3.0, 0.8, 0.6, 0.0, 0.0])
    whole = motion.move(x, u, 0.1)[0]
    for f in (0.3, 0.5, 0.9):
        first, U1 = motion.part(u, U, f)
        middle = motion.move(x, first, 0.1)[0]
        # what is left of the motion is seen from where it begins: the same velocities
        rest, U2 = motion.part(u, U, 1 - f)
        np.testing.assert_allclose(motion.move(middle, rest, 0.1)[0], whole, atol=1e-12)
        np.testing.assert_allclose(U1 + U2, U)
    np.testing.assert_allclose(motion.part(u, U, 1.0)[0], u, atol=1e-12)


@pytest.mark.parametrize(
    "motion, same",
    [
        (Unicycle(), [0, 2]),
        (Odometry2(), [0, 2]),
        (Odometry3(), [0, 4, 5, 6]),
        (ConstantVelocity(), range(7, 13)),
        (Imu(), range(10, 16)),
    ],
)
def test_a_control_that_is_split_is_as_uncertain_as_the_whole(motion, same):
    """Along a straight way, or in rest: only what the heading of one part does to the next depends on the split."""
    n = sum(motion.control_fields.values())
    u = np.zeros(n)
    u[0] = 0.4 if not isinstance(motion, (ConstantVelocity, Imu)) else 0.0
    data = UserData(robots=[Robot(motion=motion, control_cov=1e-8 * np.eye(n))])
    line = Timeline(data, 0.0)
    line.add(Control(1.0, u, 1, 1e-8 * np.eye(n)))
    ends = []
    for times in ([0.0, 1.0], [0.0, 0.3, 0.55, 1.0]):
        ends.append(integrate(motion, *data.robots[0].start(), [line.step(1, a, b) for a, b in pairwise(times)]))
    (x, P), (y, Q) = ends
    np.testing.assert_allclose(y[same], x[same], atol=1e-12)
    np.testing.assert_allclose(np.diag(Q)[same], np.diag(P)[same], rtol=1e-6)
    assert (np.diag(P)[same] > 0).all()


def test_a_step_model_that_cannot_be_split_is_refused():
    class Hop:
        frame, size, control_fields, state_fields = Odometry2.frame, 3, {"dx": 2, "da_deg": 1}, {}

        def move(self, x, u, dt):
            return Odometry2().move(x, u, dt)

    with pytest.raises(ValueError, match=r"robot 1: the controls of Hop are no velocities.*part\(u, U, f\)"):
        OnlineSlam(UserData(robots=[Robot(motion=Hop())]))


def test_a_control_counts_from_a_measurement_that_was_settled_without_it():
    data, _ = unsynchronised()
    slam = OnlineSlam(data, horizon=0.5)
    slam.add(Control(1.0, [1.0, 0.0]))
    slam.add(Measurement(2.0, [1], [[3.0, 0.0]]))
    assert slam.add(Control(4.0, [0.0, 0.0])) is None  # from 2 s on; until then it went on as before
    slam.add(Measurement(4.0, [], []))
    np.testing.assert_allclose(slam.state()[0], [2.0, -4.0, 0.0], atol=1e-12)


# --- the state at any time ---


def test_the_state_between_measurements_is_what_the_filter_would_have_there():
    data, messages = unsynchronised()
    slam = OnlineSlam(data)
    for m in messages[:40]:
        slam.add(m)
    now = slam.update()
    before = now.map.x.copy(), now.map.P.copy()
    t = slam.t + 0.123
    x, P = slam.state(t)
    np.testing.assert_array_equal(slam.update().map.x, before[0])
    np.testing.assert_array_equal(slam.update().map.P, before[1])
    slam.add(Measurement(t, [], []))  # it looks and sees nothing: the filter itself goes there
    now = slam.update()
    np.testing.assert_allclose(now.robs[0].state(now.map), x, atol=1e-12)
    np.testing.assert_allclose(now.map.block(now.robs[0].r), P, atol=1e-12)


def test_the_state_of_the_past_is_what_was_known_then():
    data, messages = unsynchronised()
    slam, seen, last = OnlineSlam(data), {}, None
    for m in messages:
        slam.add(m)
        if isinstance(m, Measurement):
            last = m.t
        elif last is not None:  # what the robot did until then is known now
            seen[last], last = slam.state(last), None
    for t, (x, P) in list(seen.items())[-5:]:
        np.testing.assert_allclose(slam.state(t)[0], x, atol=1e-12)
        np.testing.assert_allclose(slam.state(t)[1], P, atol=1e-12)
    with pytest.raises(ValueError, match=r"the state of robot 1 at 0\.2 s is not kept; it is from"):
        slam.state(0.2)
    with pytest.raises(ValueError, match="there is no robot 7; robots there: 1"):
        slam.state(3.0, robot=7)
    with pytest.raises(ValueError, match="a time that is no number of seconds: nan"):
        slam.state(np.nan)


def test_landmarks_are_those_of_the_map():
    data, messages = unsynchronised()
    slam = OnlineSlam(data)
    for m in messages:
        slam.add(m)
    places = slam.landmarks()
    np.testing.assert_allclose(places[1][0], [3.0, -3.0], atol=0.2)
    assert set(places) == {1, 2, 3} and all(P.shape == (2, 2) for _, P in places.values())


def test_a_known_map():
    data, recording = recorded(FLAT)
    data = replace(data, landmark=replace(data.landmark, in_map=False))
    slam, messages = as_stream(data, recording)
    for m in shuffled(messages, 2):
        slam.add(m)
    now, end = slam.update(), end_of(universal_slam(data, recording))
    np.testing.assert_allclose(now.map.x, end.map.x, atol=1e-9)


# --- killed and resumed ---


@pytest.mark.parametrize("way", ["plane", "compressed", "space, fast", "two robots"])
def test_killed_and_resumed_comes_to_the_same(way, tmp_path):
    data, recording = recorded(WAYS[way])
    slam, messages = as_stream(data, recording)
    messages = shuffled(messages, 8)
    for k, m in enumerate(messages):
        slam.add(m)
        if k in (len(messages) // 3, len(messages) // 2):
            slam.save(tmp_path / "stream")
            slam = OnlineSlam.load(tmp_path / "stream", slam.data)
    assert not slam.dropped
    assert_same(slam.update(), end_of(universal_slam(data, recording)))


def test_a_resumed_stream_knows_what_it_has_dropped_and_seen(tmp_path):
    data, messages = unsynchronised()
    slam = OnlineSlam(data)
    for m in messages:
        slam.add(m)
    slam.add(messages[0])
    slam.save(tmp_path / "stream")
    other = OnlineSlam.load(tmp_path / "stream", data)
    assert other.dropped == slam.dropped == {"older than the horizon": 1}
    assert "was sent twice" in other.add(messages[-1])
    for t in (slam.t - 1.0, slam.t - 0.333, slam.t + 1.0):
        for a, b in zip(slam.state(t), other.state(t), strict=True):
            np.testing.assert_array_equal(a, b)


def test_a_file_of_another_scenario_is_refused(tmp_path):
    data, _ = unsynchronised()
    OnlineSlam(data).save(tmp_path / "stream")
    with pytest.raises(ValueError, match="of another scenario, changed is: robots of the scenario"):
        OnlineSlam.load(tmp_path / "stream", UserData.from_dict(FLEET))
    (tmp_path / "text").write_text("no")
    with pytest.raises(ValueError, match="damaged"):
        OnlineSlam.load(tmp_path / "text", data)


# --- what is dropped, what is wrong ---


def test_what_is_dropped_is_said_and_counted():
    data, messages = unsynchronised()
    slam = OnlineSlam(data, horizon=0.5, t0=0.05)
    assert slam.add(Control(0.01, [1, 0])) == "robot 1: a message of 0.01 s, before the start at 0.05 s"
    for m in messages:
        slam.add(m)
    x = slam.state()[0]
    late = "sensor 1: a message of 1.2 s came when the newest was of 3 s; the horizon is 0.5 s"
    assert slam.add(Measurement(1.2, [1], [[1.0, 0.0]])) == late
    assert slam.add(messages[-1]) == "robot 1: the message of 3 s was sent twice"
    assert slam.add(Control(messages[-1].t, [9.0, 9.0])) == "robot 1: it has another control that ends at 3 s"
    np.testing.assert_array_equal(slam.state()[0], x)
    assert slam.dropped == {
        "before the start": 1,
        "older than the horizon": 1,
        "sent twice": 1,
        "second control of a robot for one time": 1,
    }


@pytest.mark.parametrize(
    "message, sentence",
    [
        (Control("now", [1, 0]), "the control of robot 1 needs a time, a finite number of seconds, got 'now'"),
        (Control(np.nan, [1, 0]), "the control of robot 1 needs a time, a finite number of seconds, got nan"),
        (Control(True, [1, 0]), "the control of robot 1 needs a time, a finite number of seconds, got True"),
        (Control(1.0, [1, 0], robot=4), "there is no robot 4; robots there: 1"),
        (Control(1.0, [1, 0, 0]), r"robot 1: the control must be 2 finite numbers \[v, w\], got \[1. 0. 0.\]"),
        (Control(1.0, [1, np.inf]), r"robot 1: the control must be finite, got \[1, inf\]"),
        (Control(1.0, [1, 0], U=-np.eye(2)), "robot 1: the control covariance"),
        (Measurement(1.0, [1], [[1.0, 0.0]], sensor=9), "there is no sensor 9; sensors there: 1"),
        (Measurement(None, [1], [[1.0, 0.0]]), "the measurement of sensor 1 needs a time"),
        (Measurement(1.0, [1], [[1.0, 0.0, 0.0]]), r"sensor 1: measurements must have shape \(1, 2\)"),
        (Measurement(1.0, [1], [1.0, 0.0]), r"sensor 1: measurements must have shape \(1, 2\)"),
        (Measurement(1.0, [1], [[1.0, np.nan]]), "sensor 1: measurement 0 of landmark 1 must be finite"),
        (Measurement(1.0, [1.5], [[1.0, 0.0]]), "sensor 1: ids must be integers"),
        (Measurement(1.0, [1], [[1.0, 90.0]]), "y2 = 90.0 is beyond 2 pi; are these degrees"),
        (Measurement(1.0, [1], [[1.0, 0.0]], d=np.zeros((2, 3))), "descriptors d: 2 rows for 1 measurements"),
        (Measurement(1.0, [1], [[1.0, 0.0]], d=[[np.nan]]), "descriptors d must be finite"),
        (Measurement(1.0, [-1], [[1.0, 0.0]]), "all ids are -1, and the association known_ids needs them"),
        ("left", "a message is a Control or a Measurement, got 'left'"),
    ],
)
def test_a_message_that_is_wrong_gets_one_sentence(message, sentence):
    data, _ = unsynchronised()
    slam = OnlineSlam(data)
    with pytest.raises((ValueError, TypeError), match=sentence) as told:
        slam.add(message)
    assert "\n" not in str(told.value)
    slam.add(Control(1.0, [1.0, 0.0]))  # and it goes on
    np.testing.assert_allclose(slam.state()[0], [1.0, -4.0, 0.0], atol=1e-12)


def test_half_of_the_covariances_is_refused_before_anything_changes():
    data, _ = unsynchronised()
    slam = OnlineSlam(data)
    slam.add(Measurement(1.0, [1], [[1.0, 0.0]]))
    with pytest.raises(ValueError, match="some messages have a covariance R and some do not"):
        slam.add(Measurement(1.0, [2], [[2.0, 0.0]], R=[0.01 * np.eye(2)]))
    assert set(slam.landmarks()) == {1}
    with pytest.raises(ValueError, match="some messages have descriptors d and some do not"):
        slam.add(Measurement(1.0, [2], [[2.0, 0.0]], d=np.zeros((1, 3))))
    with pytest.raises(ValueError, match="descriptors d must have 3 numbers, as those before, got 2"):
        slam.add(Measurement(2.0, [2], [[2.0, 0.0]], d=np.zeros((1, 2))))


def test_known_poses_are_refused():
    data = UserData.from_dict(FLAT)
    data = replace(data, robots=[replace(data.robots[0], in_map=False)])
    with pytest.raises(ValueError, match="robot 1 is not in the map"):
        OnlineSlam(data)
    with pytest.raises(ValueError, match="the horizon must be a number of seconds, got -1"):
        OnlineSlam(UserData.from_dict(FLAT), horizon=-1)


# --- a whole log ---


def test_a_log_becomes_a_recording_whatever_its_order(tmp_path):
    data, messages = unsynchronised()
    recording = recording_of(messages, data, "own rates")
    assert recording.by_event and len(recording) == len({m.t for m in messages})
    other = recording_of([*shuffled(messages, 3), messages[5]], data, "own rates")
    np.testing.assert_array_equal(recording.robots[1].U, other.robots[1].U)
    np.testing.assert_array_equal(recording.raw[1].y, other.raw[1].y)
    back = Recording.load(recording.save(tmp_path / "log"))
    np.testing.assert_array_equal(end_of(universal_slam(data, back)).map.x, end_of(universal_slam(data, other)).map.x)
    with pytest.raises(ValueError, match="a message at 0.05 s is before the start at 0.1 s"):
        recording_of(messages, data, "x", t0=0.1)
    with pytest.raises(ValueError, match="robot 1 has two controls that end at 1 s"):
        recording_of([Control(1.0, [1, 0]), Control(1.0, [2, 0])], data, "x")


def test_integrated_speeds_are_the_way():
    u, U = np.array([1.0, np.pi / 2]), np.zeros((2, 2))
    x, P = integrate(Unicycle(), [0.0, 0.0, 0.0], np.zeros((3, 3)), [(u, U, 0.25)] * 4)
    np.testing.assert_allclose(x, [2 / np.pi, 2 / np.pi, np.pi / 2])
    assert not P.any()
