"""The main loop: what is not in the map is known, streams do not disturb each other, a full map is no end."""

import numpy as np
import pytest

from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import project_lmks
from ekfslam_tutorial.toolbox import Recorder, Robot, Sensor, UserData, universal_slam
from tests.toolbox.scenarios import FLAT, SPACE


def run(table, overrides=None, seed=None, recording=None):
    """All that a run leaves behind: numbers of every frame, and the last snapshot."""
    frames, last = [], None
    for last in universal_slam(UserData.from_dict(table, overrides), recording, seed):
        frames.append((last.map.x.copy(), last.map.P.copy(), tuple(last.events)))
    return frames, last


def same(a, b):
    return all(
        np.array_equal(x, u) and np.array_equal(P, V) and e == f for (x, P, e), (u, V, f) in zip(a, b, strict=True)
    )


@pytest.mark.parametrize("table", [FLAT, SPACE], ids=["flat", "space"])
def test_the_same_seed_gives_the_same_bytes(table):
    first, again, other = run(table)[0], run(table)[0], run(table, seed=99)[0]
    assert same(first, again) and not same(first, other)


def test_the_whole_run_is_known_beforehand_and_numbered():
    data = UserData.from_dict(FLAT, {"time.first": 5, "time.last": 9})
    snapshots = universal_slam(data)
    assert len(snapshots) == 5
    seen = [(s.k, s.t, s.dt) for s in snapshots]
    assert seen == [(5, 0.5, 0.5), (6, 1.0, 0.5), (7, 1.5, 0.5), (8, 2.0, 0.5), (9, 2.5, 0.5)]


def test_slam_finds_the_landmarks_within_its_own_uncertainty():
    _, s = run(FLAT)
    assert len(s.lmks) == 12
    for lmk in s.lmks.values():
        p, P = lmk.point(s.map)
        e = p - s.sim_lmk.points[lmk.id - 1]
        assert e @ np.linalg.solve(P, e) < 18.4  # chi-square with 2 dof: one in 10,000


def test_mapping_with_known_pose_keeps_the_landmarks_apart():
    _, s = run(FLAT, {"robot.in_map": False})
    assert s.robs[0].r is None and np.array_equal(s.robs[0].x, s.truth[1])
    assert s.map.n == 24
    apart = np.kron(np.eye(12), np.ones((2, 2)))
    assert np.abs(s.map.P * (1 - apart)).max() == 0 and np.linalg.eigvalsh(s.map.P)[0] > 0


def test_localisation_keeps_the_known_map_and_finds_the_robot():
    lost = {"landmark": {"in_map": False}, "robot.position_std": 0.5, "robot.orientation_std_deg": 5.0}
    _, s = run(FLAT, lost)
    assert s.map.n == 3 and len(s.lmks) == 12 and all(lmk.r is None for lmk in s.lmks.values())
    assert not any(e.kind == "initialisation" for e in s.events)
    e, _ = s.robs[0].frame(s.map).minus(s.sim_robs[0].frame)
    assert np.linalg.norm(e[:2]) < 0.2 < np.linalg.norm(s.sim_robs[0].x[:2])


class SeesAll(RangeBearing):
    def visible(self, y, p):
        return True


class SeesEach(RangeBearing):
    def visible(self, y, p):
        return np.full(y.shape[:-1], True)


@pytest.mark.parametrize("engine", ["plain", "fast"])
def test_a_sensor_may_say_once_for_all_that_it_sees_all(engine):
    def run(model):
        data = UserData.from_dict(FLAT, {"time.last": 10, "options.engine": engine})
        data.sensors[0].model = model
        *_, now = universal_slam(data)
        return now

    once, each = run(SeesAll(0.1, 0.02)), run(SeesEach(0.1, 0.02))
    assert len(once.lmks) == 12 and all(o.visible for o in once.obs.values())
    assert np.allclose(once.map.x, each.map.x, rtol=0, atol=1e-9)
    assert np.allclose(once.map.P, each.map.P, rtol=0, atol=1e-9)


def test_an_uncertain_start_is_really_unknown():
    starts = []
    for seed in range(6):
        s = next(universal_slam(UserData.from_dict(FLAT, {"robot.position_std": 0.5}), seed=seed))
        starts.append(s.sim_robs[0].x[:2] - [0.5, -4])
    assert len({round(float(x), 6) for x, _ in starts}) == 6 and 0.1 < np.std(starts) < 1.5


def test_self_calibration_finds_the_mounting():
    mounted = {"sensor.orientation_std_deg": 5.0, "sensor.frame_in_map": True, "time.last": 100}
    first = next(universal_slam(UserData.from_dict(FLAT, mounted)))
    sigma0 = np.sqrt(first.map.P[first.sens[0].r, first.sens[0].r][2, 2])
    _, s = run(FLAT, mounted)
    sen, true = s.sens[0], s.sim_sens[0].frame
    assert abs(true.theta) > 0.01  # the truth was drawn
    error, sigma = abs(sen.frame(s.map).theta - true.theta), np.sqrt(s.map.P[sen.r, sen.r][2, 2])
    assert error < 4 * sigma and sigma < 0.2 * sigma0


def test_an_uncalibrated_sensor_not_in_the_map_is_taken_as_it_was_said_to_be():
    _, s = run(FLAT, {"sensor.orientation_std_deg": 5.0})
    assert s.sens[0].r is None and s.sens[0].x[2] == 0 and s.sim_sens[0].frame.theta != 0


def test_another_sensor_changes_neither_the_motion_nor_the_first_sensors_noise():
    second = FLAT["sensor"][0] | {"id": 2, "max_range": 3.0, "clutter": 1.0, "p_detect": 0.5}
    both = FLAT | {"sensor": [second, FLAT["sensor"][0] | {"id": 1}]}
    runs = [universal_slam(UserData.from_dict(table)) for table in (FLAT, both, FLAT | {"sensor": []})]
    for alone, two, none in zip(*runs, strict=True):
        assert np.array_equal(alone.robs[0].u, two.robs[0].u) and np.array_equal(alone.robs[0].u, none.robs[0].u)
        assert np.array_equal(alone.truth[1], two.truth[1]) and np.array_equal(alone.truth[1], none.truth[1])
        assert np.array_equal(alone.raw[1].y, two.raw[1].y) and np.array_equal(alone.raw[1].ids, two.raw[1].ids)


def test_a_second_robot_does_not_change_the_first_ones_world():
    two = FLAT | {"robot": [FLAT["robot"][0], FLAT["robot"][0] | {"position": [0, 4], "orientation_deg": 180}]}
    for a, b in zip(universal_slam(UserData.from_dict(FLAT)), universal_slam(UserData.from_dict(two)), strict=True):
        assert np.array_equal(a.robs[0].u, b.robs[0].u) and np.array_equal(a.raw[1].y, b.raw[1].y)


def test_two_robots_share_one_map():
    two = FLAT | {
        "robot": [FLAT["robot"][0], FLAT["robot"][0] | {"position": [0, 4], "orientation_deg": 180}],
        "sensor": [FLAT["sensor"][0] | {"robot": i} for i in (1, 2)],
    }
    _, s = run(two)
    one, other = (rob.r for rob in s.robs)
    assert len(s.lmks) == 12 and np.abs(s.map.P[one, other]).max() > 1e-6


def test_a_full_map_goes_on_and_says_what_it_refused():
    full = {"options.capacity": 3 + 2 * 5}
    frames, s = run(FLAT, full)
    assert len(frames) == 50 and len(s.lmks) == 5 and s.map.n == 13
    assert len(s.refused) == 7 and not s.refused & set(s.lmks)
    assert {e.kind for f in frames for e in f[2]} >= {"refused", "correction"}
    _, few = run(FLAT, {"options.max_lmks": 4})
    assert len(few.lmks) == 4 and len(few.refused) == 8


def test_false_measurements_start_no_landmark_where_ids_are_known():
    _, s = run(FLAT, {"sensor.clutter": 3.0, "sensor.p_detect": 0.8})
    assert set(s.lmks) == set(range(1, 13))


def test_unknown_association_maps_the_ring_without_ids():
    _, s = run(FLAT, {"options.association": "nearest_neighbour", "sensor.max_range": 20.0})
    p = np.array([lmk.point(s.map)[0] for lmk in s.lmks.values()])
    gap = np.linalg.norm(p[:, None] - s.sim_lmk.points, axis=-1)
    assert len(p) == 12 and sorted(gap.argmin(1).tolist()) == list(range(12)) and gap.min(1).max() < 0.5


def test_a_camera_helps_with_landmarks_that_a_laser_started():
    eye = {"id": 2, "type": "bearing_only2", "bearing_std_deg": 0.5}
    frames, s = run(FLAT | {"sensor": [FLAT["sensor"][0] | {"id": 1}, eye]})
    events = [e for f in frames for e in f[2]]
    assert any(e.kind == "correction" and e.sen == 2 for e in events)
    assert not any(e.kind == "initialisation" and e.sen == 2 for e in events)


def test_sensors_may_start_landmarks_of_their_own_type():
    depth = SPACE["sensor"][0] | {"type": "pin_hole_depth", "landmark": "euc_pnt"}
    frames, s = run(SPACE | {"sensor": [depth, SPACE["sensor"][0]]}, {"options.n_inits": [5, 1]})
    first = {e.lmk: e.sen for f in frames for e in f[2] if e.kind == "initialisation"}
    expected = {1: "EucPnt", 2: "IdpPnt"}  # by the sensor that started it
    assert {id: type(lmk.type).__name__ for id, lmk in s.lmks.items()} == {
        id: expected[sen] for id, sen in first.items()
    }
    assert set(first.values()) == {1, 2}


def test_a_depth_camera_starts_landmarks_with_a_margin_in_pixels():
    depth = SPACE["sensor"][0] | {"type": "pin_hole_depth", "landmark": "euc_pnt"}
    _, s = run(SPACE | {"sensor": [depth]}, {"options.init_margin": 25.6})
    assert len(s.lmks) > 10


def test_snapshots_show_what_the_figures_need():
    _, s = run(SPACE)
    assert s.obs and all(key == (o.sen, o.lmk) for key, o in s.obs.items())
    assert set(s.truth) == {1} and s.truth[1].shape == (7,) and s.sim_lmk.points.shape == (72, 3)
    (again,) = project_lmks(s.map, s.robs[0], s.sens[0], [next(iter(s.lmks.values()))])
    assert np.isfinite(again.e).all()


def test_without_a_world_there_is_no_simulation():
    with pytest.raises(ValueError, match=r"a simulation needs a world: write \[world\]"):
        universal_slam(UserData(robots=[Robot()], sensors=[]))


def test_nan_from_a_broken_sensor_is_named():
    class Broken:
        """Range and bearing, one of them sometimes not a number."""

        bearing_only, dim, R = False, 2, np.eye(2)

        def project(self, p):
            y = np.stack([np.hypot(*p.T), np.full(len(p), np.nan)], -1)
            return y, np.zeros((len(p), 2, 2))

        def residual(self, y, e):
            return y - e

        def visible(self, y, p):
            return np.ones(len(p), bool)

    data = UserData.from_dict(FLAT)
    data.sensors = [Sensor(model=Broken())]
    with pytest.raises(ValueError, match="sensor 1: measurement 0 of landmark 1 must be finite"):
        next(universal_slam(data))


# --- recordings instead of the simulator -----------------------------------------------------------------------------


@pytest.mark.parametrize("table", [FLAT, SPACE], ids=["flat", "space"])
def test_a_recorded_run_plays_back_to_the_same_bytes(table):
    recorder = Recorder()
    frames = []
    for s in universal_slam(UserData.from_dict(table)):
        recorder.add(s)
        frames.append((s.map.x.copy(), s.map.P.copy(), tuple(s.events)))
    recording = recorder.recording("again")
    replayed, last = run({k: v for k, v in table.items() if k not in ("world", "time")}, recording=recording)
    assert same(frames, replayed)
    assert (
        not last.sim_robs and np.array_equal(last.truth[1], s.truth[1]) and len(last.sim_lmk.ids) == len(s.sim_lmk.ids)
    )


def record(table=FLAT, overrides=None):
    recorder = Recorder()
    for s in universal_slam(UserData.from_dict(table, overrides)):
        recorder.add(s)
    return recorder.recording("log")


def test_a_recording_may_be_cut_short():
    frames, s = run(FLAT, {"time.last": 7}, recording=record())
    assert len(frames) == 7 and s.k == 7


def test_recorded_truth_is_the_known_pose_and_the_start():
    log = record()
    table = FLAT | {"robot": [{k: v for k, v in FLAT["robot"][0].items() if k != "position"}]}
    _, s = run(table, {"robot.in_map": False}, recording=log)
    assert np.array_equal(s.robs[0].x, log.truth[1][-1])
    first = next(universal_slam(UserData.from_dict(table), log))
    assert np.allclose(first.map.x[:3], log.truth[1][0], atol=1e-12)  # no step before the first frame


def test_recorded_covariances_come_before_the_scenarios():
    log = record()
    (s,) = [s for s in universal_slam(UserData.from_dict(FLAT, {"robot.v_std": 9.0, "time.last": 1}), log)]
    assert s.robs[0].U[0, 0] == pytest.approx(0.05**2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot.id": 4, "sensor.robot": 4}, "robot 4 is not in the recording 'log'; robots there: 1"),
        ({"sensor.id": 6}, "sensor 6 is not in the recording 'log'; sensors there: 1"),
    ],
)
def test_what_a_recording_lacks_is_named(change, message):
    with pytest.raises(ValueError, match=message):
        universal_slam(UserData.from_dict(FLAT, change), record())


def test_a_recording_must_fit_the_motion_model_and_the_known_pose():
    log = record()
    with pytest.raises(ValueError, match=r"robot 1 \(Odometry2\) takes 3 controls, but the recording 'log' has 2"):
        universal_slam(UserData.from_dict(FLAT | {"robot": [{"motion": "odometry2"}]}), log)
    log.truth[1][5] = np.nan
    with pytest.raises(ValueError, match=r"robot 1 is not in the map \(in_map = false\), so its pose must be known"):
        universal_slam(UserData.from_dict(FLAT, {"robot.in_map": False}), log)
    log.landmarks = None
    with pytest.raises(ValueError, match=r"the landmarks are known \(in_map = false\), so a world or a recording"):
        universal_slam(UserData.from_dict(FLAT, {"landmark": {"in_map": False}}), log)
