"""The contract test of NewMotion: run it with `python -m pytest` after every change."""

from new_motion import NewMotion

from ekfslam_tutorial.models import check_motion
from ekfslam_tutorial.toolbox import UserData, universal_slam


def test_it_keeps_the_contract_of_a_motion_model():
    check_motion(NewMotion())


def test_a_robot_moves_by_it():
    scenario = {
        "world": {"type": "ring", "n": 10},
        "robot": [
            {"motion": "new_motion", "position": [0, -3], "d": 0.05, "da_deg": 1, "d_std": 0.005, "da_std_deg": 0.1}
        ],
        "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0}],
    }
    *_, snapshot = universal_slam(UserData.from_dict(scenario, models=[NewMotion]))
    error, _ = snapshot.robs[0].frame(snapshot.map).minus(snapshot.sim_robs[0].frame)
    assert abs(error[:2]).max() < 0.3
