"""Loaders of Victoria Park and Lost in the Woods, on files made here; damaged files are named."""

import numpy as np
import pytest
from scipy.io import savemat

from ekfslam_tutorial.datasets import lost_in_the_woods, victoria_park
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


def test_the_park(tmp_path):
    a = park(tmp_path)
    rec, log = victoria_park.load(tmp_path), victoria_park.read_log(tmp_path)
    assert len(rec) == 40 and (rec.raw[1].ids == -1).all()
    assert len(rec.raw[1].y) == (a["det_range"] < victoria_park.MAX_RANGE).sum()
    np.testing.assert_allclose(rec.raw[1].y[:, 1], victoria_park.MISALIGNED, atol=1e-12)  # straight ahead, but for it
    coarse, car = np.zeros(3), Vehicle()
    for u in rec.robots[1].u[1:]:
        coarse = car.move(coarse, u, 0.2)[0]
    fine, t = np.zeros(3), log.odometry[:, 0]
    for k in range(len(t)):
        dt = min(t[k] + 0.025, log.scan_t[-1]) - t[k]
        fine = car.move(fine, log.odometry[k, 1:], dt)[0] if dt > 0 else fine
    assert coarse[2] == pytest.approx(fine[2], abs=1e-9)  # the turn is the same; the way bends a little in between
    np.testing.assert_allclose(coarse[:2], fine[:2], atol=0.01)


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
