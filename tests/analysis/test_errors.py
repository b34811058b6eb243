"""Errors of whole runs: what `History` collects and sums up."""

import json

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import SimLmk, worlds
from ekfslam_tutorial.toolbox import (
    Landmark,
    Options,
    Recorder,
    Recording,
    Robot,
    Sensor,
    Time,
    UserData,
    World,
    universal_slam,
)


def scenario(n_robots=1, robot_in_map=True, lmks_in_map=True, frames=60, **robot):
    """Robots on circles among a ring of landmarks."""
    control = {"control": {"dx": [0.15, 0], "da_deg": 4.0}, "control_std": {"dx": 0.01, "da_deg": 0.5}}
    robots = [
        Robot(id=i + 1, motion=Odometry2(), in_map=robot_in_map, **{"position": [i, 0], **control, **robot})
        for i in range(n_robots)
    ]
    model = RangeBearing(range_std=0.05, bearing_std=0.02)
    return UserData(
        robots=robots,
        sensors=[Sensor(id=r.id, robot=r.id, model=model) for r in robots],
        landmark=Landmark(model=EucPnt(2), in_map=lmks_in_map),
        world=World(build=lambda rng: worlds.ring(n=8, radius=4.0), type="ring"),
        time=Time(last=frames),
        options=Options(),
    )


def run(userdata, recording=None, seed=5, gauge="auto"):
    history = History(gauge)
    for _ in history.watch(universal_slam(userdata, recording, seed=seed)):
        pass
    return history


def record(userdata, seed=5):
    recorder = Recorder()
    for s in universal_slam(userdata, seed=seed):
        recorder.add(s)
    return recorder.recording("run")


def moved(recording, F):
    """The same run in a world that is moved by F: controls and measurements stay, truth and landmarks move."""
    truth = {i: F.compose(Frame2(x))[0].x for i, x in recording.truth.items()}
    lmk = SimLmk(recording.landmarks.ids, F.from_frame(recording.landmarks.points)[0])
    return Recording("moved", recording.t, recording.robots, recording.raw, truth, lmk)


def test_slam_from_a_known_start():
    history = run(scenario())
    f = history.summary()
    assert f["gauge"] == "fixed" and f["alignment"] == "none"
    assert f["frames"] == 60 and f["n_landmarks"] == 8
    track, s = history.track(1), history.last
    assert f["ate_rmse_m"] == pytest.approx(np.sqrt(((track.x - track.truth)[:, :2] ** 2).sum(1).mean()))
    heading = (track.x - track.truth)[:, 2]
    heading = (heading + np.pi) % (2 * np.pi) - np.pi
    assert f["heading_rmse_deg"] == pytest.approx(np.rad2deg(np.sqrt((heading**2).mean())))
    places = dict(zip(s.sim_lmk.ids.tolist(), s.sim_lmk.points, strict=True))
    errors = [lmk.point(s.map)[0] - places[i] for i, lmk in s.lmks.items()]
    assert f["landmark_rmse_m"] == pytest.approx(np.sqrt((np.array(errors) ** 2).sum(1).mean()))
    assert f["landmark_median_m"] == pytest.approx(np.median(np.linalg.norm(errors, axis=1)))
    assert f["landmark_rmse_aligned_m"] <= f["landmark_rmse_m"]
    assert f["nees_dof"] == 3 and f["nis_dof"] == 2
    assert 0 < f["ate_rmse_m"] < f["dead_reckoning_ate_m"]


def test_nis_is_the_mean_of_all_corrections():
    history, md2 = History(), []
    for s in history.watch(universal_slam(scenario(), seed=5)):
        md2 += [o.md2 for o in s.obs.values() if o.updated]
    assert len(md2) == 59 * 8
    assert history.summary()["nis_mean"] == pytest.approx(np.mean(md2))


def test_nees_and_nis_of_an_honest_filter():
    """25 runs; the errors of one run hang together, so the last pose of each counts. 99.9 % bands."""
    from ekfslam_tutorial.analysis import anees_band, nees

    last = []
    for seed in range(25):
        track = run(scenario(frames=30), seed=seed).track(1)
        last.append(nees(Frame2(track.x[-1]), track.P[-1], Frame2(track.truth[-1])))
    low, high = anees_band(3, 25, 0.999)
    assert low < np.mean(last) < high


@pytest.mark.parametrize("F", [Frame2([0, 0, 0]), Frame2([3.0, -2.0, 2.5]), Frame2([-50.0, 80.0, -3.0])])
def test_with_a_free_gauge_the_frame_of_the_truth_does_not_matter(F):
    """A robot that starts at the origin of its own map; the world is moved: all figures stay."""
    userdata = scenario(position=[0, 0])
    recording = record(userdata)
    plain, other = (run(userdata, r, gauge="free").summary() for r in (recording, moved(recording, F)))
    assert plain["alignment"] == other["alignment"] == "landmarks"
    for key in ("ate_rmse_m", "heading_rmse_deg", "landmark_rmse_m", "dead_reckoning_ate_m", "nees_mean"):
        assert other[key] == pytest.approx(plain[key], rel=1e-6), key


def test_the_gauge_is_found_out():
    userdata = scenario(position=[0, 0])
    recording = record(userdata)
    assert run(userdata, recording).gauge == "fixed"
    assert run(userdata, moved(recording, Frame2([0.5, 0, 0]))).gauge == "free"
    assert run(userdata, moved(recording, Frame2([0, 0, 0.1]))).gauge == "free"
    no_start = moved(recording, Frame2([0, 0, 0]))
    no_start.truth[1][0] = np.nan
    assert run(userdata, no_start).gauge == "free"
    assert run(scenario(position=[9, 9], lmks_in_map=False), recording).gauge == "fixed", "known landmarks fix it"
    assert run(scenario(robot_in_map=False), recording).gauge == "fixed", "known robots fix it"


def test_an_uncertain_start_is_in_the_frame_of_the_truth():
    """The simulator draws the true start with the given spread; that is no other frame."""
    for seed in range(10):
        history = run(scenario(position_std=0.3, orientation_std_deg=5.0, frames=2), seed=seed)
        assert history.gauge == "fixed"


def test_mapping_has_the_nees_of_the_landmarks():
    f = run(scenario(robot_in_map=False)).summary()
    assert f["nees_dof"] == 2 and f["ate_rmse_m"] == 0.0
    assert 0.2 < f["nees_mean"] < 6.0  # 8 landmarks: the 99.98 % band of their mean, 2


def test_localisation():
    history = run(scenario(lmks_in_map=False))
    f = history.summary()
    assert f["gauge"] == "fixed" and f["nees_dof"] == 3
    assert f["landmark_rmse_m"] == 0.0
    assert f["ate_rmse_m"] < 0.1


def test_dead_reckoning_is_the_controls_alone():
    userdata = scenario()
    recording = record(userdata)
    track = run(userdata, recording).track(1)
    pose = Frame2(track.x[0])
    for k in range(1, len(recording)):
        pose = pose.compose(Frame2(recording.robots[1].u[k]))[0]
    np.testing.assert_allclose(Frame2(track.dead[-1]).minus(pose)[0], 0, atol=1e-9)


def test_frames_without_truth_do_not_count():
    userdata = scenario()
    recording = record(userdata)
    recording.truth[1][5:50] = np.nan
    history = run(userdata, recording)
    f, track = history.summary(), history.track(1)
    assert track.known.sum() == 15 and f["frames"] == 60
    e = track.x[track.known, :2] - track.truth[track.known, :2]
    assert f["ate_rmse_m"] == pytest.approx(np.sqrt((e**2).sum(1).mean()))


def test_without_any_truth_the_figures_are_none_and_json_takes_them():
    userdata = scenario()
    recording = record(userdata)
    blind = Recording("blind", recording.t, recording.robots, recording.raw)
    f = run(userdata, blind).summary()
    for key in ("ate_rmse_m", "heading_rmse_deg", "landmark_rmse_m", "dead_reckoning_ate_m", "nees_mean"):
        assert f[key] is None
    assert f["nis_mean"] > 0 and f["alignment"] == "none"
    assert json.loads(json.dumps(f, allow_nan=False)) == f


def test_few_landmarks_leave_the_trajectories_to_align_by():
    userdata = scenario(position=[0, 0])
    recording = moved(record(userdata), Frame2([3.0, 1.0, 1.0]))
    recording.landmarks = SimLmk(recording.landmarks.ids[:1], recording.landmarks.points[:1])
    f = run(userdata, recording).summary()
    assert f["alignment"] == "trajectories"
    assert f["ate_rmse_m"] < 0.15


def test_landmarks_nobody_surveyed_are_counted_but_not_judged():
    userdata = scenario()
    recording = record(userdata)
    recording.landmarks = SimLmk(recording.landmarks.ids[:5], recording.landmarks.points[:5])
    history = run(userdata, recording)
    assert history.summary()["n_landmarks"] == 8
    assert history.landmarks()[0].tolist() == recording.landmarks.ids.tolist()


def test_several_robots():
    history = run(scenario(n_robots=2))
    f = history.summary()
    assert list(f["robots"]) == ["1", "2"]
    ate = [f["robots"][i]["ate_rmse_m"] for i in "12"]
    assert f["ate_rmse_m"] == pytest.approx(np.sqrt(np.mean(np.square(ate)))), "pooled: as many frames each"
    for key in ("ate_rmse_m", "heading_rmse_deg", "landmark_rmse_m", "dead_reckoning_ate_m", "nees_mean", "nis_mean"):
        assert f["robots"]["2"][key] is not None
    assert f["robots"]["1"]["n_landmarks"] == 8


def test_a_truth_that_is_an_estimate_counts_with_its_covariance():
    """True poses that somebody else has estimated, 0.2 m and 0.1 rad off: the NEES of a pose is 3 if that is told."""
    recorder, rng = Recorder(), np.random.default_rng(11)
    for s in universal_slam(scenario(), seed=5):
        recorder.add(s)
    log = recorder.recording("estimated truth")
    log.truth[1] = log.truth[1] + rng.normal(size=log.truth[1].shape) * [0.2, 0.2, 0.1]
    blind, told = History("fixed"), History("fixed", truth_std=(0.2, 0.1))
    for s in universal_slam(scenario(), log):
        blind.add(s)
        told.add(s)
    (e, P), (e_told, P_told) = blind.errors(1), told.errors(1)
    np.testing.assert_array_equal(e, e_told)
    np.testing.assert_allclose(P_told - P, np.broadcast_to(np.diag([0.04, 0.04, 0.01]), P.shape), atol=1e-15)
    n = len(e)
    assert abs(told.summary()["nees_mean"] - 3) < 4 * np.sqrt(6 / n)  # 4 sigma of the mean of n of 3 degrees
    assert blind.summary()["nees_mean"] > 20


def test_the_honesty_meter_of_a_run():
    meter = run(scenario()).honesty()
    assert meter.verdicts()["symmetric"] == meter.verdicts()["psd"] == "yes"
    assert meter.verdicts()["nis"] == "as it should be"
    assert meter.rmse == pytest.approx(run(scenario()).summary()["ate_rmse_m"])


def test_what_makes_no_sense():
    with pytest.raises(ValueError, match="unknown gauge 'loose'; known: auto, free, fixed"):
        History("loose")
    with pytest.raises(ValueError, match="no frames yet"):
        History().summary()
