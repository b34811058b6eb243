"""The contract test of NewSensor: run it with `python -m pytest` after every change."""

from new_sensor import NewSensor

from ekfslam_tutorial.models import check_pair, check_sensor
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.toolbox import UserData, universal_slam


def test_it_keeps_the_contract_of_a_sensor():
    check_sensor(NewSensor())


def test_it_goes_with_euclidean_points():
    check_pair(NewSensor(), EucPnt(NewSensor.dim))


def test_a_robot_finds_its_way_with_it():
    scenario = {
        "world": {"type": "ring", "n": 10},
        "robot": [{"motion": "unicycle", "position": [0, -3], "v": 0.5, "w_deg": 10, "v_std": 0.05, "w_std_deg": 1}],
        "sensor": [{"type": "new_sensor"}],
    }
    *_, snapshot = universal_slam(UserData.from_dict(scenario, models=[NewSensor]))
    error, _ = snapshot.robs[0].frame(snapshot.map).minus(snapshot.sim_robs[0].frame)
    assert len(snapshot.lmks) == 10 and abs(error[:2]).max() < 0.3
