"""Where robots start relative to each other, found from landmarks that their own maps have in common."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, v2q
from ekfslam_tutorial.toolbox import Recorder, Recording, UserData, universal_slam
from ekfslam_tutorial.toolbox.rendezvous import START_STD, chain, find_starts

ROUND = {"motion": "odometry2", "dx": [0.25, 0.0], "da_deg": 7.2, "dx_std": [0.01, 0.004], "da_std_deg": 0.2}
SENSOR = {"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 0.5, "max_range": 6.0}
TRUE = {1: [0.0, -2.0, 0.0], 2: [1.5, 2.0, 150.0], 3: [-2.0, 0.5, -80.0]}


def scenario(starts, **more):
    """Three robots on their rounds; `starts` are what the user says, None for nothing."""
    place = lambda x: {} if x is None else {"position": x[:2], "orientation_deg": x[2]}
    return UserData.from_dict(
        {
            "seed": 4,
            "robot": [{"id": i} | ROUND | place(x) for i, x in starts.items()],
            "sensor": [{"id": 10 * i, "robot": i} | SENSOR for i in starts],
            "time": {"last": 100},
        }
        | more
    )


@pytest.fixture(scope="module")
def recording():
    recorder = Recorder()
    for s in universal_slam(scenario(TRUE, world={"type": "ring", "n": 12, "radius": 4.0})):
        recorder.add(s)
    return recorder.recording("three on a round")


def seen_from(start, origin):
    frames = [Frame2(np.array([*x[:2], np.radians(x[2])])) for x in (origin, start)]
    return frames[0].inverse()[0].compose(frames[1])[0]


def test_starts_relative_to_the_first(recording):
    """Errors far below START_STD: the alignment of maps of about 12 landmarks, each known to a few centimetres."""
    data, note = find_starts(scenario({1: [0, 0, 0], 2: None, 3: None}), recording)
    assert data.robots[0].position == [0, 0] and data.robots[0].position_std == 0
    for robot in data.robots[1:]:
        true = seen_from(TRUE[robot.id], TRUE[1])
        np.testing.assert_allclose(robot.position, true.t, atol=0.15)
        found = Frame2(np.array([0, 0, np.radians(robot.orientation_deg)]))
        assert abs(found.minus(Frame2(np.array([0, 0, true.x[2]])))[0][2]) < np.radians(4)
        assert (robot.position_std, robot.orientation_std_deg) == START_STD
    assert "robots [2, 3] relative to robot 1" in note
    *_, s = universal_slam(data, recording)
    for rob in s.robs:
        got = rob.frame(s.map)
        frame = Frame2(np.array([*TRUE[1][:2], 0.0]))
        assert np.linalg.norm(frame.compose(got)[0].t - s.truth[rob.id][:2]) < 0.25


def test_the_truth_is_not_looked_at(recording):
    blind = Recording("blind", recording.t, recording.robots, recording.raw)
    asked = scenario({1: [0, 0, 0], 2: None, 3: None})
    for a, b in zip(find_starts(asked, recording)[0].robots, find_starts(asked, blind)[0].robots, strict=True):
        assert a.position == b.position and a.orientation_deg == b.orientation_deg


def test_starts_on_a_known_map(recording):
    data, note = find_starts(scenario({1: None, 2: None, 3: None}, landmark={"in_map": False}), recording)
    for robot in data.robots:
        np.testing.assert_allclose(robot.position, TRUE[robot.id][:2], atol=0.15)
    assert "on the known map" in note
    no_map = Recording("no map", recording.t, recording.robots, recording.raw)
    with pytest.raises(ValueError, match="'no map' has no landmarks"):
        find_starts(scenario({1: None, 2: None, 3: None}, landmark={"in_map": False}), no_map)


def test_a_robot_that_sees_other_landmarks_cannot_be_placed(recording):
    log = recording.raw[30]
    apart = type(log)(30, log.offsets, log.ids + 100, log.y, log.R)
    other = Recording("apart", recording.t, recording.robots, recording.raw | {30: apart})
    with pytest.raises(
        ValueError,
        match="the map of robot 3 has 0 landmarks in common with those of the others after .*, and 4 are needed",
    ):
        find_starts(scenario({1: [0, 0, 0], 2: None, 3: None}), other)


def test_a_robot_whose_map_lies_otherwise_is_not_told_that_it_sees_too_little(recording):
    """The bearings of the third robot count to the right: its map is a mirror image."""
    log = recording.raw[30]
    mirrored = type(log)(30, log.offsets, log.ids, log.y * [1, -1], log.R)
    other = Recording("mirrored", recording.t, recording.robots, recording.raw | {30: mirrored})
    with pytest.raises(
        ValueError, match=r"robot 3 has \d+ landmarks in common .*no placing of it fits them: are mount"
    ):
        find_starts(scenario({1: [0, 0, 0], 2: None, 3: None}), other)


@pytest.mark.parametrize("frame", [Frame2(np.array([1.0, 2.0, 0.5])), Frame3(np.array([1, 2, 3, *v2q(np.ones(3))[0]]))])
def test_chains_of_maps(frame):
    """Map c shares nothing with map a, but enough with b. One landmark of b is a wrong one and is left out."""
    rng = np.random.default_rng(3)
    world = dict(enumerate(rng.uniform(-5, 5, (12, frame.dim))))
    second = frame.compose(frame)[0]
    a = {i: world[i] for i in range(6)}
    b = {i: frame.to_frame(world[i])[0] for i in range(1, 11)}
    c = {i: second.to_frame(world[i])[0] for i in range(6, 12)}
    b[2] = b[2] + 3.0
    frames = chain({"a": a, "c": c, "b": b})
    assert set(frames) == {"b", "c"}
    np.testing.assert_allclose(frames["b"].R, frame.R, atol=1e-9)
    np.testing.assert_allclose(frames["b"].t, frame.t, atol=1e-9)
    np.testing.assert_allclose(frames["c"].t, second.t, atol=1e-9)
    assert set(chain({"a": a, "c": c})) == set()
    assert set(chain({"a": {}, "b": b})) == set()


def test_points_in_one_place_link_nothing():
    same = {i: np.ones(2) for i in range(6)}
    assert chain({"a": same, "b": same}) == {}
