"""From the files of a set to a recording."""

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ekfslam_tutorial.datasets import mrclam
from ekfslam_tutorial.datasets.calibration import OdometryCalibration
from ekfslam_tutorial.datasets.mrclam_log import RobotLog, SetLog, Sightings, read_set
from ekfslam_tutorial.datasets.sources import Source

AS_COMMANDED = OdometryCalibration(1.0, 1.0, 1.0, 0.0)


@pytest.fixture
def recording(handmade):
    return mrclam.load(1, (1,), handmade, AS_COMMANDED)


def test_a_frame_for_each_stamp_with_all_that_was_seen_then(recording):
    assert recording.t[0] == 0.0
    np.testing.assert_allclose(recording.t, [*np.arange(0, 4.01, 0.2), 5.0], atol=1e-6)
    counts = np.diff(recording.raw[1].offsets).tolist()
    assert counts == [3, 2] * 10 + [3, 1]
    np.testing.assert_array_equal(recording.raw[1][0].ids, [6, 11, 17])


def test_steps_follow_the_commands(recording):
    """0.1 m/s for the first second; then, from 2 s to 3.9 s, 0.5 rad/s, the gap of the odometry included."""
    u = recording.robots[1].u
    np.testing.assert_allclose(u[1:6, 0], 0.02, atol=1e-7)
    np.testing.assert_allclose(u[6:, 0], 0, atol=1e-9)
    np.testing.assert_allclose(u[11:20, 2], 0.1, atol=1e-6)
    assert u[:, 2].sum() == pytest.approx(1.0, abs=1e-6)


def test_calibration_scales_and_delays(handmade):
    late = mrclam.load(1, (1,), handmade, OdometryCalibration(0.5, 1.0, 1.0, 0.2))
    u = late.robots[1].u
    assert u[:, 2].sum() == pytest.approx(1.0, abs=1e-6), "these turns are on the spot"
    np.testing.assert_allclose(u[1:7, 0], [0.0, 0.02, 0.02, 0.02, 0.02, 0.02], atol=1e-7)
    spin = mrclam.load(1, (1,), handmade, OdometryCalibration(1.0, 1.0, 0.5, 0.0))
    assert spin.robots[1].u[:, 2].sum() == pytest.approx(0.5, abs=1e-6)


def test_the_log_calibrates_itself_unless_told(handmade):
    own = mrclam.load(1, (1,), handmade)
    assert any("pairs of sightings" in note for note in own.notes)


def test_noise_grows_with_range(recording):
    raw = recording.raw[1]
    noise = mrclam.SIGHTING_NOISE
    np.testing.assert_allclose(raw.R[:, 0, 0], noise.range_std**2 + (noise.range_growth * raw.y[:, 0]) ** 2)
    np.testing.assert_allclose(raw.R[:, 1, 1], noise.bearing_std**2)
    assert not raw.R[:, 0, 1].any()


def test_truth_and_landmarks(recording):
    """What a robot at the true pose would see is what was seen, to the millimetres of the file."""
    truth, points = recording.truth[1], dict(zip(recording.landmarks.ids, recording.landmarks.points, strict=True))
    assert np.isnan(truth[-1]).all()
    for pose, seen in zip(truth[:-1], recording.raw[1], strict=False):
        d = np.array([points[i] for i in seen.ids]) - pose[:2]
        b = (np.arctan2(d[:, 1], d[:, 0]) - pose[2] + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(seen.y, np.column_stack([np.hypot(*d.T), b]), atol=1e-3)


def test_several_robots_share_the_frames(handmade):
    both = mrclam.load(1, (1, 2), handmade, AS_COMMANDED)
    alone = mrclam.load(1, (2,), handmade, AS_COMMANDED)
    assert list(both.robots) == list(both.raw) == [1, 2]
    assert both.raw[2].ids.tolist() == alone.raw[2].ids.tolist()
    assert both.robots[2].u[:, 0].sum() == pytest.approx(0.1 * both.t[-1], abs=1e-6)
    for k in np.flatnonzero(np.diff(alone.raw[2].offsets)):
        at = np.flatnonzero(abs(both.t - alone.t[k]) < 1e-6)
        np.testing.assert_array_equal(both.raw[2][at[0]].y, alone.raw[2][k].y)


def test_sparse_truth_has_a_frame_of_its_own(handmade):
    alone = mrclam.load(1, (2,), handmade, AS_COMMANDED)
    known = np.isfinite(alone.truth[2][:, 0])
    np.testing.assert_allclose(alone.t[known], [1.0, 2.2], atol=1e-6)
    assert len(alone.raw[2][int(np.flatnonzero(known)[1])].ids) == 0


def test_zip_and_folder_are_the_same(handmade, tmp_path):
    zipped = shutil.make_archive(str(tmp_path / "out" / "MRCLAM_Dataset1"), "zip", handmade.parent, handmade.name)
    a, b = (mrclam.load(1, (1,), path) for path in (handmade, zipped))
    np.testing.assert_array_equal(a.raw[1].y, b.raw[1].y)
    np.testing.assert_array_equal(a.robots[1].u, b.robots[1].u)
    assert a.notes == b.notes


@pytest.mark.parametrize("name", ["MRCLAM_Dataset4", "mrclam4", "MRCLAM-Dataset-4", "mrclam_set_4"])
@pytest.mark.parametrize("deep", ["", "deep"])
def test_sets_are_found_below_the_data_folder(handmade, tmp_path, monkeypatch, name, deep):
    data = tmp_path / "data"
    shutil.copytree(handmade, data / deep / name)
    monkeypatch.setenv("EKFSLAM_DATA", str(data))
    assert mrclam.find_set(4).path == data / deep / name
    assert mrclam.find_set(4, data).path == data / deep / name
    assert mrclam.find_set(1) is None
    assert mrclam.load(4, (1,)).name == name


def test_a_set_that_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=r"MRCLAM set 3 is not found in .*; wanted is MRCLAM_Dataset3\.zip"):
        mrclam.load(3)
    monkeypatch.delenv("EKFSLAM_DATA")
    with pytest.raises(FileNotFoundError, match="MRCLAM set 3 is not found in EKFSLAM_DATA, which is not set"):
        mrclam.load(3)


def test_odometry_that_ends_early(handmade):
    """Half of the odometry is gone: no commands, no frames, and a note."""
    path = handmade / "Robot2_Odometry.dat"
    path.write_text("\n".join(path.read_text().splitlines()[:8]) + "\n")
    short = mrclam.load(1, (2,), handmade, AS_COMMANDED)
    assert short.t[-1] <= 0.3 + mrclam.HOLD
    assert any("odometry ends" in note and "frames left out" in note for note in short.notes)


def test_odometry_that_ends_before_anything_is_seen(handmade):
    path = handmade / "Robot2_Odometry.dat"
    path.write_text(path.read_text().replace("12500000", "12400000"))
    with pytest.raises(ValueError, match=r"the odometry of robots \[2\] ends before they see anything"):
        mrclam.load(1, (2,), handmade)


def test_a_robot_that_sees_nothing_usable(handmade):
    path = handmade / "Robot2_Measurement.dat"
    path.write_text("# nothing but a misread barcode\n1250000001.000 99 1.000 0.000\n")
    with pytest.raises(ValueError, match=r"robots \[2\] have not seen anything"):
        mrclam.load(1, (2,), handmade)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 80))
def test_no_sighting_is_lost_or_moved_to_another_frame(seed, n):
    rng = np.random.default_rng(seed)
    t = 1.25e9 + np.sort(rng.integers(0, 60, n)) * 0.25
    met = 1.25e9 + np.sort(rng.integers(0, 60, 5)) * 0.25
    seen = Sightings(t, rng.integers(6, 21, n), rng.uniform(0.5, 3, (n, 2)))
    others = Sightings(met, np.full(5, 2), rng.uniform(0.5, 3, (5, 2)))
    odometry = np.column_stack([1.25e9 + np.arange(0, 16, 0.1), rng.uniform(0, 0.1, 160), rng.uniform(-1, 1, 160)])
    log = SetLog("random", {1: RobotLog(1, odometry, seen, others, np.zeros((0, 4)), False)}, np.arange(2), np.eye(2))
    rec = mrclam.recording(log)
    assert sum(len(obs.ids) for obs in rec.raw[1]) == n
    start = min(t[0], met[0])
    for k, obs in enumerate(rec.raw[1]):
        here = abs(t - start - rec.t[k]) < 1e-6
        np.testing.assert_array_equal(obs.ids, seen.ids[here])
        np.testing.assert_array_equal(obs.y, seen.y[here])


def test_reading_does_not_depend_on_which_robots_are_asked_for(handmade):
    source = Source(handmade)
    a, b = read_set(source, (1,)).robots[1], read_set(source, (2, 1)).robots[1]
    np.testing.assert_array_equal(a.odometry, b.odometry)
    np.testing.assert_array_equal(a.landmarks.y, b.landmarks.y)
