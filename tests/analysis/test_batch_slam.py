"""Runs of a scenario all at once: each is the run that `universal_slam` makes with the same seed."""

from copy import deepcopy

import numpy as np
import pytest

from ekfslam_tutorial.analysis import batch_slam
from ekfslam_tutorial.toolbox import UserData, World, universal_slam

BASE = {
    "time": {"dt": 0.5, "last": 70},
    "world": {"type": "lecture"},
    "robot": {"motion": "unicycle", "position": [0, -4], "v": 1.0, "w_deg": 14.4, "v_std": 0.1, "w_std_deg": 2.0},
    "sensor": {"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 5.0, "fov_deg": 270.0},
    "landmark": {},
    "options": {"md2_threshold": 25.0},
}
SEEDS = [3, 1, 4, 15]


def scenario(**changes):
    """The base scenario with other values of some keys of its sections; another motion model drops the robot's."""
    table = deepcopy(BASE)
    if "motion" in changes.get("robot", {}):
        table["robot"] = {"position": [0, -4]}
    for section, values in changes.items():
        table[section].update(values)
    return UserData.from_dict(table | {"robot": [table["robot"]], "sensor": [table["sensor"]]})


ODOMETRY = {"motion": "odometry2", "dx": [[0.5, 0], [0.5, 0.1]], "da_deg": [7.2, 7.2], "dx_std": 0.05, "da_std_deg": 1}
VEHICLE = {"motion": "vehicle", "v": 1.0, "steer_deg": 33.0, "v_std": 0.1, "steer_std_deg": 1.0}
CHANGES = {
    "as it is": {},  # 70 frames: noise is drawn twice
    "odometry, a list of controls": {"robot": ODOMETRY},
    "a car": {"robot": VEHICLE},
    "uncertain start and mounting": {
        "robot": {"position_std": 0.1, "orientation_deg": 170.0, "orientation_std_deg": 10.0},
        "sensor": {"position": [0.2, -0.1], "orientation_deg": 20.0, "position_std": 0.05},
    },
    "a sensor that misses, a narrow gate": {"sensor": {"p_detect": 0.6}, "options": {"md2_threshold": 4.0}},
    "two corrections, not projected again": {"options": {"n_updates": 2, "reproject": False}},
    "the additive error": {"options": {"error": "additive"}, "robot": {"w_std_deg": 6.0}},
    "the invariant error": {"options": {"error": "invariant"}, "robot": {"w_std_deg": 6.0}},
    "first-estimates Jacobians": {"options": {"first_estimates": True}, "robot": {"w_std_deg": 6.0}},
    "a world of chance, another first frame": {"world": {"type": "random2", "n": 12}, "time": {"first": 5, "last": 30}},
}


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_each_run_is_the_run_of_its_seed(changes):
    """To 1e-10: sums come in another order, and 70 frames of corrections multiply what rounding that makes."""
    data = scenario(**changes)
    alone, n_corrected = [universal_slam(data, seed=seed) for seed in SEEDS], 0
    together = batch_slam(data, SEEDS)
    assert len(together) == len(alone[0])
    for now, *each in zip(together, *alone, strict=True):
        for r, one in enumerate(each):
            assert now.k == one.k and set(one.lmks) == set(now.ids[now.seen[r]].tolist())
            places = [slice(3 + 2 * i, 5 + 2 * i) for i in np.flatnonzero(now.seen[r])]
            here = np.r_[(slice(0, 3), *places)]
            there = np.r_[(slice(0, 3), *(one.lmks[id].r for id in now.ids[now.seen[r]].tolist()))]
            np.testing.assert_allclose(now.truth[r], one.truth[1], rtol=0, atol=1e-12)
            np.testing.assert_allclose(now.x[r, here], one.map.x[there], rtol=0, atol=1e-10)
            np.testing.assert_allclose(
                now.P[r][np.ix_(here, here)], one.map.P[np.ix_(there, there)], rtol=0, atol=1e-10
            )
            np.testing.assert_allclose(now.points[r], one.sim_lmk.points)
            n_corrected += sum(e.kind == "correction" for e in one.events)
    assert n_corrected > 100


def test_a_run_does_not_depend_on_its_neighbours():
    """To the last bit: that makes Monte-Carlo figures the same however the runs are shared out."""
    data = scenario()
    *_, some = batch_slam(data, SEEDS)
    for r, seed in enumerate(SEEDS):
        *_, one = batch_slam(data, [seed])
        assert np.array_equal(one.x[0], some.x[r]) and np.array_equal(one.P[0], some.P[r])
    *_, many = batch_slam(data, [*range(60), *SEEDS])
    assert np.array_equal(many.x[60:], some.x) and np.array_equal(many.P[60:], some.P)


REFUSED = {
    "one robot with one sensor is needed, got 1 and 0": {"sensor": []},
    "one robot with one sensor is needed, got 2 and 1": {"robot": 2 * [BASE["robot"]]},
    "the sensor BearingOnly2 is no RangeBearing": {
        "sensor": [{"type": "bearing_only2", "bearing_std_deg": 1.0}],
        "landmark": {"type": "ahm_pnt"},
    },
    "the motion model Odometry3": {
        "robot": [{"motion": "odometry3"}],
        "sensor": [{"type": "pin_hole"}],
        "world": {"type": "cloister"},
        "landmark": {"type": "idp_pnt"},
    },
    "landmarks of type AhmPnt are no EucPnt": {"landmark": {"type": "ahm_pnt"}},
    "sensor.clutter = 0.5; it would have to be 0.0": {"sensor": [BASE["sensor"] | {"clutter": 0.5}]},
    "sensor.frame_in_map = True": {"sensor": [BASE["sensor"] | {"frame_in_map": True}]},
    "sensor.bias = .0.1, 0": {"sensor": [BASE["sensor"] | {"bias": [0.1, 0]}]},
    "sensor.lasting = 0.5; it would have to be 0.0": {"sensor": [BASE["sensor"] | {"lasting": 0.5}]},
    "robot.clock_offset = 0.1; it would have to be 0.0": {"robot": [BASE["robot"] | {"clock_offset": 0.1}]},
    "robot.in_map = False": {"robot": [BASE["robot"] | {"in_map": False}]},
    "landmark.in_map = False": {"landmark": {"in_map": False}},
    "options.joint = True; it would have to be False": {"options": {"joint": True}},
    "the association Jcbb is not KnownIds": {"options": {"association": "jcbb"}},
    "the scenario plays the data set 'mrclam'": {"data": {"name": "mrclam"}},
}


@pytest.mark.parametrize("reason", REFUSED)
def test_what_cannot_be_batched_is_named(reason):
    table = BASE | {"robot": [BASE["robot"]], "sensor": [BASE["sensor"]]} | REFUSED[reason]
    table["robot"] = [entry | {"id": i} for i, entry in enumerate(table["robot"], 1)]
    with pytest.raises(ValueError, match=f"^these runs cannot be batched: .*{reason}"):
        batch_slam(UserData.from_dict(table), SEEDS)


def test_no_seeds_and_worlds_that_differ_are_refused():
    data = scenario()
    with pytest.raises(ValueError, match="a batch needs at least one seed"):
        batch_slam(data, [])
    data.world = World(build=lambda rng: (np.arange(n := rng.integers(3, 9)), rng.uniform(-5, 5, (n, 2))))
    with pytest.raises(ValueError, match="every landmark needs an id of its own, the same in all runs"):
        next(batch_slam(data, range(9)))
