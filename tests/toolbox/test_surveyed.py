"""Landmarks that somebody has measured before the run: in the map from the start, as uncertain as that was."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.analysis.batch_slam import why_not_batched
from ekfslam_tutorial.analysis.factors import graph_of
from ekfslam_tutorial.analysis.graph_files import g2o_text
from ekfslam_tutorial.analysis.smoother import smooth
from ekfslam_tutorial.ekf import chi_square
from ekfslam_tutorial.geometry import wrap
from ekfslam_tutorial.models.landmarks import AhmPnt, Beacon, EucPnt
from ekfslam_tutorial.models.sensors import PinHole, Range, RangeBearing
from ekfslam_tutorial.toolbox import (
    Landmark,
    Options,
    Robot,
    Sensor,
    Surveyed,
    UserData,
    create_slam_structures,
    universal_slam,
)

SCENARIO = """
seed = 4

[time]
last = 120

[world]
type = "points"
points = [[0.0, 10.0], [12.0, -4.0], [-10.0, -6.0]]

[[robot]]
motion = "odometry2"
position = [0, 0]
orientation_deg = 0
dx = [0.2, 0]
da_deg = 1.5
dx_std = 0.02
da_std_deg = 0.3

[[sensor]]
type = "range"
range_std = 0.1

[landmark]
type = "beacon"
bias_std = 0.2

[[landmark.surveyed]]
id = 1
position = [0.3, 9.8]
position_std = [0.5, 0.4]

[[landmark.surveyed]]
id = 2
position = [11.7, -4.4]
covariance = [[0.5, 0.2], [0.2, 0.3]]

[[landmark.surveyed]]
id = 3
position = [-10.2, -5.5]
position_std = 0.5
"""


def scenario(**overrides):
    return UserData.from_text(SCENARIO, {key.replace("__", "."): value for key, value in overrides.items()})


def test_they_are_in_the_map_before_the_first_frame():
    map, _, _, lmks, _ = create_slam_structures(scenario())
    assert list(lmks) == [1, 2, 3] and [lmk.slot for lmk in lmks.values()] == [0, 1, 2]
    assert np.array_equal(lmks[1].state(map), [0.3, 9.8, 0, 0])
    assert np.allclose(map.block(lmks[1].r), np.diag([0.25, 0.16, 0.04, 0]))
    assert np.allclose(map.block(lmks[2].r)[:2, :2], [[0.5, 0.2], [0.2, 0.3]])
    assert not map.P[lmks[1].r, lmks[2].r].any()
    assert {(lmk.n_search, lmk.n_match, lmk.n_inlier) for lmk in lmks.values()} == {(0, 0, 0)}


@pytest.mark.parametrize("joint", [False, True])
def test_both_engines_take_them(joint):
    plain, fast = ([now for now in universal_slam(scenario(options__joint=joint), engine=e)] for e in ("plain", "fast"))
    plain, fast = plain[-1], fast[-1]
    assert {e.kind for e in plain.events} == {"search", "innovation", "correction"}
    assert np.allclose(plain.map.x, fast.map.x, rtol=0, atol=1e-9)
    assert np.allclose(plain.map.P, fast.map.P, rtol=0, atol=1e-9)
    assert all(np.trace(lmk.point(fast.map)[1]) < 0.12 for lmk in fast.lmks.values()), "0.41 to 0.8 at first"


def test_ranges_to_surveyed_beacons_make_an_honest_map():
    """Mean NEES of beacons and robot in 12 runs whose surveys are drawn: 12 x 9 numbers, 99.9 % band of their mean."""
    points, std, sums, rng = np.array([[0.0, 10.0], [12.0, -4.0], [-10.0, -6.0]]), 0.5, [], np.random.default_rng(1)
    for seed in range(12):
        places = points + std * rng.standard_normal(points.shape)
        surveyed = [Surveyed(id=i, position=p, position_std=std) for i, p in enumerate(places, 1)]
        data = scenario(time__last=60)
        *_, now = universal_slam(replace(data, seed=seed, landmark=Landmark(surveyed=surveyed)))
        e = now.map.x - np.concatenate([now.truth[1], points.ravel()])
        e[2] = wrap(e[2])
        sums.append(e @ np.linalg.solve(now.map.P, e))
    assert chi_square.quantile(0.0005, 108) / 12 < np.mean(sums) < chi_square.quantile(0.9995, 108) / 12


def test_a_camera_keeps_its_rays_and_a_surveyed_place_is_a_point():
    kind, l, P = Surveyed(id=5, position=[1, 2, 3], position_std=0.1).start(AhmPnt(), 3)
    assert kind == EucPnt(3) and np.array_equal(l, [1, 2, 3]) and np.allclose(P, 0.01 * np.eye(3))
    kind, l, P = Surveyed(id=5, position=[1, 2], position_std=0.1).start(Beacon(2, bias_std=2.0, scale_std=0.5), 2)
    assert np.array_equal(l, [1, 2, 0, 0]) and np.allclose(P, np.diag([0.01, 0.01, 4.0, 0.25]))


def test_the_smoother_takes_the_places_as_they_were_said():
    """With no measurement of it, a beacon stays where it was said to be; with some, its prior counts once."""
    data = scenario(time__last=30)
    away = replace(data, landmark=replace(data.landmark, surveyed=[*data.landmark.surveyed, far()]))
    filtered = [s for s in universal_slam(away)][-1]
    found = smooth(graph_of(away))
    for id in 1, 2, 3, 9:
        x, lmk = found.graph.values["landmark", id], filtered.lmks[id]
        e, P = x - lmk.state(filtered.map), filtered.map.block(lmk.r)
        assert abs(e[3]) < 1e-12, "scale_std is 0"
        assert e[:3] @ np.linalg.solve(P[:3, :3], e[:3]) < 1, "the filter has linearised elsewhere, but not far away"
    assert np.allclose(found.P["landmark", 9], np.diag([0.25, 0.25, 0.04, 0]), atol=1e-9)
    assert np.allclose(found.graph.values["landmark", 9], [40, 40, 0, 0], atol=1e-9)
    with pytest.raises(ValueError, match="landmark 1 is surveyed: there is no edge for that"):
        g2o_text(graph_of(data))


def far():
    return Surveyed(id=9, position=[40, 40], position_std=0.5)


def test_what_was_known_of_a_deleted_landmark_goes_with_it():
    """Its ranges are those of another place: the gate refuses them, and it is deleted."""
    wrong = Surveyed(id=3, position=[-20.0, 6.0], position_std=0.1)
    data = scenario(time__last=30, options__md2_threshold=9.0, options__min_inlier_ratio=0.5, options__min_search=5)
    data = replace(data, landmark=replace(data.landmark, surveyed=[*data.landmark.surveyed[:2], wrong]))
    *_, now = universal_slam(data)
    assert list(now.lmks) == [1, 2]
    assert ("landmark", 3) not in smooth(graph_of(data)).graph.values


def user_data(model=None, surveyed=(), **more):
    space = isinstance(more.get("sensor"), PinHole)
    sensor = Sensor(model=more.pop("sensor", Range()))
    robot = Robot(position=[0, 0, 0] if space else [0, 0], control={}, control_std={})
    return UserData(robots=[robot], sensors=[sensor], landmark=Landmark(model=model, surveyed=list(surveyed)), **more)


@pytest.mark.parametrize(
    "entry, message",
    [
        (
            {"position": [1, 2]},
            "the surveyed landmark 1: its position_std or its covariance must be given",
        ),
        (
            {"position": [1, 2, 3], "position_std": 1.0},
            r"surveyed landmark 1: position must be 2 numbers, got \[1, 2",
        ),
        (
            {"position": [1, 2], "position_std": -1.0},
            "surveyed landmark 1: position_std is a standard deviation",
        ),
        ({"position": [1, 2], "covariance": [[1, 2], [2, 1]]}, "landmark 1: covariance must be positive semi-definite"),
        ({"id": -1, "position": [1, 2], "position_std": 1.0}, "the id of a surveyed landmark must be a whole number"),
    ],
)
def test_what_is_no_place_is_refused(entry, message):
    with pytest.raises(ValueError, match=message):
        user_data(surveyed=[Surveyed(**{"id": 1} | entry)])


def test_what_does_not_go_together_is_refused():
    one = Surveyed(id=1, position=[1, 2], position_std=1.0)
    with pytest.raises(ValueError, match="two surveyed landmarks have the id 1"):
        Landmark(surveyed=[one, one])
    with pytest.raises(ValueError, match="surveyed landmarks are in the map: with in_map = false all are known"):
        Landmark(surveyed=[one], in_map=False)
    with pytest.raises(ValueError, match="capacity 4 is less than the 5 states of robots, sensors and surveyed landm"):
        user_data(surveyed=[one], options=Options(capacity=4))
    with pytest.raises(TypeError, match=r"each of surveyed must be a toolbox.Surveyed, got \{'id': 1\}"):
        Landmark(surveyed=[{"id": 1}])
    with pytest.raises(ValueError, match=r"surveyed 1: unknown key 'place'; possible: id, position, position_std, cov"):
        scenario(landmark__surveyed=[{"place": [0, 0]}])
    with pytest.raises(ValueError, match=r"must be tables, each written \[\[landmark.surveyed\]\], got 3"):
        scenario(landmark__surveyed=3)
    assert why_not_batched(user_data(surveyed=[one], sensor=RangeBearing(0.1, 0.1)))
