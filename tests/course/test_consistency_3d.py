"""The stored Monte Carlo of notebook 17: small, complete, and what the program computes today."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course.draws.nb17_runs import EVERY, FRAMES, KINDS, ODOMETRY, RUNS, live, stored, stored_path


def test_the_file_is_small_and_complete():
    assert stored_path().stat().st_size < 100_000
    for kind in KINDS:
        for odometry in ODOMETRY:
            s = stored(kind, odometry)
            assert s.nees.shape == s.off.shape == s.states.shape == (RUNS, FRAMES // EVERY)
            assert np.isfinite(s.nees).all() and (s.nees > 0).all() and s.k[-1] == FRAMES


@pytest.mark.parametrize(
    ("kind", "odometry", "seeds"),
    [("idp", "good", (1, 25)), ("idp_euc", "poor", (7,)), ("hmg", "good", (3,)), ("euc_camera", "poor", (2,))],
)
def test_runs_made_anew_are_those_of_the_file(kind, odometry, seeds):
    # 40 frames: what rounding differs between computers has grown to far less than a thousandth by then; the errors
    # are stored in half precision, 11 bits
    new, old = live(kind, odometry, seeds, frames=40), stored(kind, odometry)
    rows, k = np.array(seeds) - 1, len(new.k)
    assert np.array_equal(new.k, old.k[:k]) and np.array_equal(new.states, old.states[rows, :k])
    assert np.allclose(new.nees, old.nees[rows, :k], rtol=1e-3)
    assert np.allclose(new.off, old.off[rows, :k], rtol=1e-3, atol=1e-6)


def test_what_the_notebook_says_of_it():
    # "honest": the mean NEES of the last frame, of 25 independent runs, in the 99.9 % band
    low, high = anees_band(6, RUNS, 0.999)
    inside = {
        (kind, odometry) for kind in KINDS for odometry in ODOMETRY if low < stored(kind, odometry).anees[-1] < high
    }
    assert inside == {
        ("ahm", "good"),
        ("idp", "good"),
        ("idp_euc", "good"),
        ("euc_camera", "good"),
        ("euc_camera", "poor"),
    }
