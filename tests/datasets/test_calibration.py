"""Odometry that calibrates itself, on simulated robots whose true scales and delay are known."""

import numpy as np
import pytest

from ekfslam_tutorial.datasets.calibration import APART, OdometryCalibration, _pairs, self_calibration
from ekfslam_tutorial.datasets.odometry import dead_reckon

TYPICAL = OdometryCalibration(0.94, 0.94, 0.94, 0.2)


def simulated(rng, true, duration=300.0, tick=0.05, outliers=0.0):
    """A robot among 12 landmarks: odometry (n, 3), and sightings t, ids, y at 4 Hz in a field of view of 1.2 rad."""
    t = np.arange(0, duration, tick)
    kind = np.repeat(rng.choice(4, len(t) // 40 + 1, p=[0.4, 0.2, 0.2, 0.2]), 40)[: len(t)]
    v = np.array([0.15, 0.12, 0.12, 0.0])[kind]
    w = np.array([0.0, 0.5, -0.5, 0.6])[kind]
    odometry = np.column_stack([t, v, w])
    late = np.searchsorted(t, t - true.delay, "right") - 1
    real = dead_reckon(t, v, np.where(late < 0, 0, true.turn_rate(v, w)[late]))
    points = rng.uniform(-6, 6, (12, 2))
    rows = []
    for k in range(0, len(t), 5):
        d = points - real[k, :2]
        r, b = np.hypot(*d.T), np.arctan2(d[:, 1], d[:, 0]) - real[k, 2]
        b = (b + np.pi) % (2 * np.pi) - np.pi
        for i in np.flatnonzero(abs(b) < 0.6):
            wrong = rng.uniform(-0.5, 0.5) if rng.random() < outliers else 0
            rows.append([t[k], i, r[i] * (1 + 0.03 * rng.normal()), b[i] + 0.012 * rng.normal() + wrong])
    rows = np.array(rows)
    return odometry, rows[:, 0], rows[:, 1].astype(int), rows[:, 2:]


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    "true", [OdometryCalibration(0.9, 0.95, 0.85, 0.25), OdometryCalibration(0.64, 0.58, 1.0, 0.1), TYPICAL]
)
def test_scales_and_delay_are_found(true, seed):
    """Within 0.03 and 0.04 s: about three times the spread over seeds; the prior is off by up to 0.36."""
    fit = self_calibration(*simulated(np.random.default_rng(seed), true), TYPICAL)
    for name in ("left", "right", "spin"):
        assert getattr(fit, name) == pytest.approx(getattr(true, name), abs=0.03)
    assert fit.delay == pytest.approx(true.delay, abs=0.04)
    assert "pairs of sightings" in fit.source


def test_outliers_lose_their_weight():
    true = OdometryCalibration(0.8, 0.8, 0.8, 0.2)
    fit = self_calibration(*simulated(np.random.default_rng(1), true, outliers=0.05), TYPICAL)
    assert fit.left == pytest.approx(0.8, abs=0.04)
    assert fit.spin == pytest.approx(0.8, abs=0.04)


def test_what_the_log_does_not_tell_stays_typical(rng):
    """A robot that never turns says nothing about turns, and one that sees nothing says nothing at all."""
    t = np.arange(0, 20, 0.05)
    odometry = np.column_stack([t, 0 * t + 0.1, 0 * t])
    straight = self_calibration(odometry, t, np.ones(len(t), int), np.column_stack([5 - 0.1 * t, 0 * t]), TYPICAL)
    nothing = self_calibration(odometry, np.zeros(0), np.zeros(0, int), np.zeros((0, 2)), TYPICAL)
    for fit in (straight, nothing):
        got = [fit.left, fit.right, fit.spin, fit.delay]
        np.testing.assert_allclose(got, [0.94, 0.94, 0.94, 0.2], atol=1e-6)


def test_pairs_are_of_one_landmark_and_apart(rng):
    t = np.sort(rng.uniform(0, 60, 400))
    ids = rng.integers(0, 5, 400)
    first, second = _pairs(t, ids)
    assert len(first) > 200
    np.testing.assert_array_equal(ids[first], ids[second])
    gap = t[second] - t[first]
    assert gap.min() >= APART[0] and gap.max() <= APART[1]
    assert len(set(first.tolist())) == len(first), "each sighting begins one pair at most"


@pytest.mark.parametrize("values", [(0, 1, 1, 0), (1, -1, 1, 0), (1, 1, 11, 0), (1, 1, 1, 20), (1, np.nan, 1, 0)])
def test_calibrations_that_make_no_sense(values):
    with pytest.raises(ValueError, match="makes no sense"):
        OdometryCalibration(*values)
