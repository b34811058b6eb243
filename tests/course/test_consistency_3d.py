"""The stored Monte Carlo of notebook 17: small, complete, and what the cells of the notebook compute today."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course.draws.nb17 import EVERY, FRAMES, KINDS, ODOMETRY, RUNS, stored, stored_path
from tools.make_consistency_3d import notebook, series


@pytest.fixture(scope="module")
def cells():
    return notebook()


def test_the_file_is_small_and_complete():
    assert stored_path().stat().st_size < 100_000
    for kind in KINDS:
        for odometry in ODOMETRY:
            s = stored(kind, odometry)
            assert s.nees.shape == s.off.shape == s.states.shape == (RUNS, FRAMES // EVERY)
            assert np.isfinite(s.nees).all() and (s.nees > 0).all() and s.k[-1] == FRAMES


@pytest.mark.parametrize(
    ("kind", "odometry", "seeds"),
    [("idp", "good", (1, 25)), ("idp_euc", "poor", (7,)), ("hmg", "good", (3,)), ("euc_camera", "poor", (2,)),
     ("euc_depth", "good", (4,)), ("ahm", "poor", (5,))],
)  # fmt: skip
def test_runs_made_anew_are_those_of_the_file(cells, kind, odometry, seeds):
    # 40 frames: what rounding differs between computers has grown to far less than a thousandth by then; the errors
    # are stored in half precision, 11 bits
    new, old = series(cells, kind, odometry, seeds, last=40), stored(kind, odometry)
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


def test_a_prior_that_is_too_sure_does_more_harm_than_a_bad_guess(cells):
    """The debrief of section 4, to two digits."""
    low, high = anees_band(6, 4)

    def mean_nees(kind, mean, std):
        data = cells["user_data"](kind, "good", last=40, non_obs_mean=mean, non_obs_std=std)
        return np.mean([cells["one_run"](data, seed)[1, -1] for seed in (1, 2, 3, 4)])

    sure, guess, vague = (mean_nees("idp", *prior) for prior in ((0.2, 0.02), (0.5, 0.1), (0.02, 0.3)))
    assert round(sure) == 39 and sure > high
    assert (round(guess, 1), round(vague, 1)) == (4.8, 5.7) and low < guess < vague < high
    assert round(mean_nees("euc_depth", 0.2, 0.02)) == 62 and 3100 < mean_nees("euc_depth", 0.5, 0.1) < 3200


def test_a_small_error_is_not_an_honest_one():
    """The answers of section 2: correlation of log error and log NEES, and hmgPnt against idpPnt."""
    of = {o: stored("idp", o) for o in ODOMETRY}
    together = {o: np.corrcoef(np.log(s.off[:, -1]), np.log(s.nees[:, -1]))[0, 1] for o, s in of.items()}
    assert {o: round(c, 1) for o, c in together.items()} == {"good": 0.4, "poor": 0.9}
    hmg, idp = stored("hmg", "poor"), of["poor"]
    assert round(hmg.rms[-1] / idp.rms[-1], 1) == 1.4 and round(hmg.anees[-1] / idp.anees[-1]) == 27
