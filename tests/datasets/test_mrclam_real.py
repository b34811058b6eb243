"""The real MRCLAM logs: what the loader counts, and how well EKF-SLAM does on them. Needs EKFSLAM_DATA."""

from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.datasets import mrclam, prepare
from ekfslam_tutorial.datasets.mrclam_log import read_set
from ekfslam_tutorial.toolbox import UserData, universal_slam
from tests.pace import Watch, within

SCENARIO = Path(__file__).parents[2] / "data" / "scenarios" / "mrclam_single.toml"


def here(set):
    """Where a set is; without it there is no test."""
    source = mrclam.find_set(set)
    if source is None:
        pytest.skip(f"MRCLAM set {set} is not below EKFSLAM_DATA")
    return source


class Places(History):
    """A history that leaves out the errors of the robots in the gauge of the map: a quarter of a run's time.

    `test_set_9_robot_3` has them, as every run of a user; here only places and angles are asked for.
    """

    def _gauge_of(self, s):
        return None


def run_of(userdata, history=Places, every=1):
    """Summary of a whole run; `every`: of one frame in so many and the last: enough but for dead reckoning."""
    history = history()
    for k, now in enumerate(universal_slam(*prepare(userdata))):
        if k % every == 0:
            history.add(now)
    if history.last is not now:
        history.add(now)
    return history.summary()


@pytest.fixture(scope="module")
def figures(data_dir):
    """(set, robot) -> summary of a run of the scenario file; each is run once."""
    done = {}

    def run(set, robot, history=Places):
        here(set)
        if (set, robot) not in done:
            with Watch() as it:
                summary = run_of(UserData.from_toml(SCENARIO, {"data.set": set, "data.robots": [robot]}), history)
            done[set, robot] = summary | {"cpu_s": it.seconds}
        return done[set, robot]

    return run


def test_set_9_robot_3(figures):
    """The figures asked of the scenario as it is. Measured: 0.058 m, 2.0 deg, 0.047 m."""
    f = figures(9, 3, History)
    assert f["ate_rmse_m"] <= 0.08
    assert f["heading_rmse_deg"] <= 2.5
    assert f["landmark_rmse_m"] <= 0.06
    assert f["n_landmarks"] == 15
    assert f["gauge"] == "free" and f["alignment"] == "landmarks"
    assert f["cpu_s"] < 15  # measured: 5 s


@pytest.mark.parametrize("robot", [1, 2, 4, 5])
def test_set_9_other_robots_do_not_diverge(figures, robot):
    """Robot 4 gets stuck at a barrier while it is told to turn: it is lost, and found again."""
    f = figures(9, robot)
    assert f["ate_rmse_m"] < 0.2
    assert f["landmark_rmse_m"] < 0.08
    assert f["ate_rmse_m"] < f["dead_reckoning_ate_m"] / 4
    if robot == 4:
        assert f["n_recoveries"] >= 1


@pytest.mark.parametrize("robot", [1, 2, 3, 4, 5])
def test_set_7_robots_do_not_diverge(figures, robot):
    f = figures(7, robot)
    assert f["ate_rmse_m"] < 0.35
    assert f["landmark_rmse_m"] < 0.13
    assert f["ate_rmse_m"] < f["dead_reckoning_ate_m"] / 2


def test_set_7_on_average(figures):
    """Measured: 0.216 m; 0.262 m is what a careful filter with one turn scale for all reaches."""
    assert np.mean([figures(7, robot)["ate_rmse_m"] for robot in range(1, 6)]) <= 0.25


@pytest.mark.parametrize(("set", "sightings", "spurious"), [(7, 20282, 9), (9, 43157, 2)])
def test_every_row_is_accounted_for(data_dir, set, sightings, spurious):
    log = read_set(here(set), (1, 2, 3, 4, 5))
    assert sum(len(r.landmarks) + len(r.robots) for r in log.robots.values()) == sightings - spurious
    assert sum("spurious" in note for note in log.notes) == 2
    assert not any("interchanged" in note for note in log.notes)


def test_five_robots_load_fast(data_dir):
    """600,000 rows in less than 2 s of one core, the self-calibration of five logs included (measured: 1.2 s)."""
    here(7)
    recording = within(2.0, lambda: mrclam.load(7, (1, 2, 3, 4, 5)))
    assert len(recording) == 11498


def test_turns_of_set_9_are_too_large_and_those_of_set_7_nearly_right(data_dir):
    """A documented property of set 9, commanded turns of about 1.5 times the real ones: the log finds it by itself, for
    turns under way. On the spot robots 2 and 5 turn as they are told."""
    for set, scale, tolerance in ((9, 0.62, 0.06), (7, 0.93, 0.07)):
        for log in read_set(here(set), (2, 5)).robots.values():
            s = log.landmarks
            fit = mrclam.self_calibration(log.odometry, s.t, s.ids, s.y, mrclam.FAMILY)
            assert fit.left == pytest.approx(scale, abs=tolerance)
            assert fit.right == pytest.approx(scale, abs=tolerance)
            if set == 9:
                assert fit.spin == pytest.approx(1.0, abs=0.05)


def test_five_robots_of_set_7_in_one_map(data_dir):
    """About 10 s, because it is the whole log of five robots. Measured: 0.111 m, landmarks 0.035 m."""
    here(7)
    f = run_of(UserData.from_toml(SCENARIO.with_name("mrclam_joint.toml")), every=10)
    assert f["ate_aligned_m"] <= 0.13 and f["landmark_rmse_aligned_m"] <= 0.06
    assert all(robot["ate_aligned_m"] <= 0.2 for robot in f["robots"].values()), "nobody is locked out"


def test_robot_3_of_set_9_on_the_known_map(data_dir):
    """Better than with a map of its own (0.058 m). Measured: 0.043 m."""
    here(9)
    f = run_of(UserData.from_toml(SCENARIO.with_name("mrclam_localisation.toml")), every=10)
    assert f["gauge"] == "fixed" and f["ate_rmse_m"] <= 0.06


@pytest.mark.parametrize(("set", "begin", "end", "ate_m"), [(7, 0.1, 0.3, 0.2), (9, 0.15, 0.25, None)])
def test_a_piece_of_the_log(data_dir, tmp_path, monkeypatch, set, begin, end, ate_m):
    """Another start, another order of landmarks, less to calibrate with. Measured: landmarks 0.069 and 0.047 m, poses
    of set 7 0.147 m; those of this piece of set 9 have no ground truth. Ten longer pieces: docs/data_tuning.md."""
    cut(here(set), tmp_path / f"MRCLAM_Dataset{set}", begin, end)
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path))
    f = run_of(UserData.from_toml(SCENARIO.with_name("mrclam_joint.toml"), {"data.set": set}), every=10)
    assert f["landmark_rmse_aligned_m"] <= 0.08 and f["n_landmarks"] == 15
    assert ate_m is None or f["ate_aligned_m"] <= ate_m


def cut(source, folder, begin, end):
    """Write the part of a set between two shares of its time."""
    rows = {n: [r for r in source.read(n).decode().splitlines() if r.strip()] for n in source.names() if ".dat" in n}
    times = {name: [None if r.startswith("#") else float(r.split()[0]) for r in rows[name]] for name in rows}
    odometry = [t for name in rows if "Odometry" in name for t in times[name] if t is not None]
    first, last = (min(odometry) + share * np.ptp(odometry) for share in (begin, end))
    folder.mkdir()
    for name in rows:
        timed = name.startswith("Robot")
        kept = [r for r, t in zip(rows[name], times[name], strict=True) if not timed or t is None or first <= t <= last]
        (folder / Path(name).name).write_text("\n".join(kept) + "\n")
