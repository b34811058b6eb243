"""Errors against GPS: interpolation in time, the best 95 %, and an alignment that jumps do not pull away."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis.fixes import fix_alignment, fix_errors, fix_figures
from ekfslam_tutorial.analysis.tracks import Track
from ekfslam_tutorial.geometry import Frame2

T = np.arange(0.0, 101.0)
PATH = np.column_stack([2 * T, 20 * np.sin(T / 15)])


def track(x=PATH, id=1):
    n = len(x)
    return Track(id, Frame2, T, np.column_stack([x, np.zeros(n)]), np.zeros((n, 3, 3)), np.full((n, 3), np.nan), x)


def fixes_at(t, error=0.0):
    return np.column_stack([t, *(np.interp(t, T, p) for p in PATH.T)]) + [0.0, error, 0.0]


def test_fixes_are_compared_at_their_own_times():
    t = np.linspace(0.25, 99.75, 200)
    np.testing.assert_allclose(fix_errors(T, PATH, fixes_at(t, 1.5)), 1.5)
    outside = fixes_at(np.array([-5.0, 3.0, 120.0]))
    assert len(fix_errors(T, PATH, outside)) == 1


def test_figures_of_100_fixes_of_which_4_are_jumps():
    fixes = fixes_at(np.linspace(0.5, 99.5, 100), 1.0)
    fixes[[10, 30, 50, 70], 1] += 49.0
    f = fix_figures([track()], {1: fixes})
    assert f["gps_n"] == 100
    assert f["gps_rmse_best95_m"] == pytest.approx(1.0) and f["gps_median_m"] == pytest.approx(1.0)
    assert f["gps_rmse_m"] == pytest.approx(np.sqrt((96 + 4 * 50.0**2) / 100))
    assert f["gps_rmse_best95_aligned_m"] == pytest.approx(0.0, abs=1e-6), "a shift by 1 m is the start's"


def test_the_alignment_finds_the_motion_in_spite_of_jumps(rng):
    F = Frame2(np.array([3.0, -2.0, 0.1]))
    fixes = fixes_at(np.linspace(0, 100, 400))
    fixes[:, 1:] = F.from_frame(fixes[:, 1:])[0] + 0.1 * rng.normal(size=(400, 2))
    fixes[::40, 1:] += rng.uniform(20, 100, (10, 2))
    error = np.abs(fix_alignment(T, PATH, fixes).x - F.x)
    assert (error < [0.05, 0.05, 1e-3]).all()  # 5 sigma and more


def test_robots_without_fixes_do_not_count_and_few_fixes_say_so():
    f = fix_figures([track(), track(id=2)], {2: fixes_at(np.array([5.0]), 2.0)})
    assert f["gps_n"] == 1 and f["gps_rmse_m"] == pytest.approx(2.0) and f["gps_rmse_best95_aligned_m"] is None
    assert fix_figures([track()], {})["gps_median_m"] is None
