"""The contract test of NewLandmark: run it with `python -m pytest` after every change."""

from new_landmark import NewLandmark

from ekfslam_tutorial.models import check_landmark, check_pair
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.toolbox import UserData, universal_slam


def test_it_keeps_the_contract_of_a_landmark_type():
    check_landmark(NewLandmark())


def test_it_goes_with_range_and_bearing():
    check_pair(RangeBearing(0.1, 0.02), NewLandmark(2))


def test_a_robot_maps_with_it():
    scenario = {
        "world": {"type": "ring", "n": 10},
        "robot": [{"motion": "unicycle", "position": [0, -3], "v": 0.5, "w_deg": 10, "v_std": 0.05, "w_std_deg": 1}],
        "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0}],
        "landmark": {"type": "new_landmark"},
    }
    *_, snapshot = universal_slam(UserData.from_dict(scenario, models=[NewLandmark]))
    for landmark in snapshot.lmks.values():
        point, _ = landmark.point(snapshot.map)
        assert abs(point - snapshot.sim_lmk.points[landmark.id - 1]).max() < 0.3
