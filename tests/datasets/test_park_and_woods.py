"""Loaders of Victoria Park and Lost in the Woods, on files made here; damaged files are named."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

from ekfslam_tutorial.datasets import lost_in_the_woods, victoria_park
from ekfslam_tutorial.datasets.sources import find_file
from ekfslam_tutorial.datasets.victoria_park import ParkCalibration
from ekfslam_tutorial.geometry import wrap
from ekfslam_tutorial.models.motion import Vehicle


@pytest.fixture
def woods(tmp_path):
    n, rng = 40, np.random.default_rng(1)
    r = rng.uniform(1, 5, (n, 17)) * (rng.random((n, 17)) < 0.5)
    column = lambda: rng.normal(size=(n, 1))
    arrays = {k: column() for k in ("v", "om", "x_true", "y_true", "th_true")}
    arrays |= {"t": 5 + 0.1 * np.arange(n)[:, None], "r": r, "b": rng.normal(size=(n, 17)) * (r > 0)}
    arrays |= {"true_valid": np.arange(n)[:, None] != 7, "l": rng.normal(size=(17, 2)), "d": 0.2}
    arrays |= {"r_var": 0.01, "b_var": 0.02, "v_var": 0.03, "om_var": 0.04}
    savemat(tmp_path / lost_in_the_woods.FILE, arrays)
    return tmp_path, arrays


def test_the_woods(woods):
    folder, a = woods
    rec = lost_in_the_woods.load(folder, max_range=3.0)
    assert len(rec) == 40 and rec.t[0] == 0
    np.testing.assert_array_equal(rec.robots[1].u[5], [a["v"][4, 0], a["om"][4, 0]])
    seen = np.flatnonzero((a["r"][9] > 0) & (a["r"][9] <= 3))
    frame = rec.raw[1][9]
    np.testing.assert_array_equal(frame.ids, seen + 1)
    np.testing.assert_array_equal(frame.y, np.column_stack([a["r"][9, seen], a["b"][9, seen]]))
    np.testing.assert_allclose(rec.raw[1].R[0], np.diag([0.04, 0.08]))
    assert np.isnan(rec.truth[1][7]).all() and np.isfinite(rec.truth[1][8]).all()


@pytest.mark.parametrize("degrees", [-4.6, 0.0, 30.0])
def test_truth_of_the_woods_is_turned_to_where_it_drives(degrees):
    """Halts, curves, gaps and driving backwards do not count. The paths are made of short steps: 1e-3 rad for these."""
    rng, n, angle = np.random.default_rng(2), 3000, np.deg2rad(degrees)
    t, v = 0.1 * np.arange(n), np.repeat(rng.choice([0.0, 0.1, 0.2, -0.15], 60, p=[0.2, 0.3, 0.3, 0.2]), 50)
    way = np.cumsum(np.repeat(rng.normal(0, 0.1, 60), 50) * 0.1)
    xy = np.cumsum(0.1 * v[:, None] * np.column_stack([np.cos(way), np.sin(way)]), 0)
    truth = np.column_stack([xy, (way - angle + np.pi) % (2 * np.pi) - np.pi])
    truth[rng.random(n) < 0.05] = np.nan
    assert abs(lost_in_the_woods.drives_beside(t, truth) - angle) < 1e-3
    assert lost_in_the_woods.drives_beside(t[:50], truth[:50]) == 0, "too short to tell"
    assert lost_in_the_woods.drives_beside(t, np.full_like(truth, np.nan)) == 0


def test_real_truth_of_the_woods_drives_as_its_heading_says(data_dir):
    """Of the file itself the bearings are asked, which the loader does not use: they fit the heading of the file."""
    if find_file(lost_in_the_woods.FILE) is None:
        pytest.skip("Lost in the Woods is not below EKFSLAM_DATA")
    rec = lost_in_the_woods.load()
    assert abs(lost_in_the_woods.drives_beside(rec.t, rec.truth[1])) < 1e-9
    (turned,) = [float(re.search(r"(-?[\d.]+) deg", note)[1]) for note in rec.notes if "heading of the truth" in note]
    assert turned == pytest.approx(-4.6, abs=0.1)
    tubes = dict(zip(rec.landmarks.ids, rec.landmarks.points, strict=True))
    off = []
    for k in range(0, len(rec), 5):
        x, y, heading = rec.truth[1][k]
        laser = heading - np.deg2rad(turned)  # as the file has it
        for tube, (_, bearing) in zip(rec.raw[1][k].ids, rec.raw[1][k].y, strict=True):
            dx, dy = tubes[tube] - [x + 0.219 * np.cos(laser), y + 0.219 * np.sin(laser)]
            off.append(np.rad2deg(wrap(bearing - np.arctan2(dy, dx) + laser)))
    assert abs(np.nanmedian(off)) < 0.5, "the laser looks where the file's heading points, not where the robot drives"


def test_damaged_woods(woods):
    file = woods[0] / lost_in_the_woods.FILE
    file.write_bytes(file.read_bytes()[:300])
    with pytest.raises(ValueError, match=r"dataset2\.mat"):
        lost_in_the_woods.load(file)
    with pytest.raises(FileNotFoundError, match="Lost in the Woods"):
        lost_in_the_woods.load(woods[0] / "nowhere")


def park(folder, **changes):
    a = {"odo_t_ms": 100 + 25 * np.arange(400), "speed": np.full(400, 2.0), "steering": np.linspace(-0.4, 0.4, 400)}
    a |= {"gps_t_ms": np.arange(3), "gps_x": np.zeros(3), "gps_y": np.zeros(3)}
    a |= {"scan_t_ms": 50 + 200 * np.arange(40), "det_per_scan": np.arange(40) % 3}
    m = int(a["det_per_scan"].sum())
    a |= {"det_range": np.linspace(1, 60, m), "det_bearing": np.full(m, np.pi / 2), "det_diameter": np.full(m, 0.4)}
    np.savez(folder / victoria_park.FILE, **(a | changes))
    return a


NOTHING = ParkCalibration(bearing=0.0, per_diameter=0.0, steer_scale=1.0, steer_offset=0.0, delay=0.0)


def test_the_park(tmp_path):
    a = park(tmp_path)
    rec, log = victoria_park.load(tmp_path, NOTHING), victoria_park.read_log(tmp_path)
    assert len(rec) == 40 and (rec.raw[1].ids == -1).all()
    kept = a["det_range"] < victoria_park.MAX_RANGE
    np.testing.assert_allclose(rec.raw[1].y, np.column_stack([a["det_range"], np.zeros(len(kept))])[kept], atol=1e-12)
    coarse, car = np.zeros(3), Vehicle()
    for u in rec.robots[1].u[1:]:
        coarse = car.move(coarse, u, 0.2)[0]
    fine, t = np.zeros(3), log.odometry[:, 0]
    for k in range(len(t)):
        dt = min(t[k] + 0.025, log.scan_t[-1]) - t[k]
        fine = car.move(fine, [*log.odometry[k, 1:], 0.0], dt)[0] if dt > 0 else fine
    assert coarse[2] == pytest.approx(fine[2], abs=1e-9)  # the turn is the same; the way bends a little in between
    np.testing.assert_allclose(coarse[:2], fine[:2], atol=0.01)


def test_what_is_calibrated_in_the_park(tmp_path):
    a = park(tmp_path)
    plain = victoria_park.load(tmp_path, NOTHING)
    turned = victoria_park.load(tmp_path, replace(NOTHING, bearing=0.1, per_diameter=-0.5))
    np.testing.assert_allclose(turned.raw[1].y - plain.raw[1].y, [[-0.2, 0.1]] * len(plain.raw[1].y), atol=1e-12)
    steered = victoria_park.load(tmp_path, replace(NOTHING, steer_scale=2.0, steer_offset=0.1))
    k = 20
    # each command holds until the next one, 25 ms later
    steering = np.interp(50 + 200 * (k - 0.5), a["odo_t_ms"] + 12.5, a["steering"])
    assert plain.robots[1].u[k, 1] == pytest.approx(steering, abs=1e-3)
    assert steered.robots[1].u[k, 1] == pytest.approx(2 * steering + 0.1, abs=2e-3)
    late = victoria_park.load(tmp_path, replace(NOTHING, delay=0.2))
    np.testing.assert_allclose(late.robots[1].u[3:], plain.robots[1].u[2:-1], atol=1e-9)


def test_gps_is_kept_in_the_time_of_the_recording(tmp_path):
    t = np.array([0, 150, 7000, 9000])
    park(tmp_path, gps_t_ms=t, gps_x=0.1 * t, gps_y=-0.1 * t)
    rec = victoria_park.load(tmp_path)
    np.testing.assert_allclose(rec.fixes[1], [[0.1, 15.0, -15.0], [6.95, 700.0, -700.0]])


def test_a_standing_truck_has_no_noise(tmp_path):
    park(tmp_path, speed=np.zeros(400))
    rec = victoria_park.load(tmp_path)
    assert not rec.robots[1].u.any() and not rec.robots[1].U.any()


def test_damaged_park(tmp_path):
    park(tmp_path, det_range=np.ones(3))
    with pytest.raises(ValueError, match="det_per_scan counts"):
        victoria_park.load(tmp_path)
    with pytest.raises(FileNotFoundError, match="Victoria Park"):
        victoria_park.load(tmp_path / "nowhere")


def test_the_twin_of_the_woods_says_so():
    rec = lost_in_the_woods.twin(seed=3, n=200)
    assert "simulated" in rec.notes[0] and len(rec) == 200 and len(rec.raw[1].y) > 50
    again = lost_in_the_woods.twin(seed=3, n=200)
    np.testing.assert_array_equal(rec.raw[1].y, again.raw[1].y)
