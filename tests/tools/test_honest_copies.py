"""Copies of a log whose noise is as it is told: of the simulated twin of MRCLAM, 100 s of it."""

from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.datasets import prepare
from ekfslam_tutorial.toolbox import UserData

SCENARIO = Path(__file__).parents[2] / "data" / "scenarios" / "mrclam_twin.toml"


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "tools"))
    import honest_copies

    return honest_copies


def test_copies_have_the_noise_that_is_told_and_the_truth_where_it_was_known(tool):
    data, log = prepare(UserData.from_toml(SCENARIO, {"data.duration": 100, "options.error": "invariant"}))
    _, poses, points = tool.judged(data, log)
    made = list(tool.copies(data, log, poses, points, 5, np.random.default_rng(1)))
    assert np.array_equal(np.isnan(made[0].truth[1]), np.isnan(log.truth[1]))
    (true_u, true_y) = (np.mean([get(copy) for copy in made], 0) for get in (controls, sightings))
    n = len(made)
    # Mean squares of white numbers about the mean of n: chi-square with n - 1 degrees of freedom each, over n - 1.
    for get, mean, C in ((controls, true_u, log.robots[1].U), (sightings, true_y, made[0].raw[1].R)):
        some = np.linalg.eigvalsh(C)[:, 0] > 1e-12
        z = np.array([get(copy) - mean for copy in made])[:, some]
        q = np.einsum("kni,nij,knj->kn", z, np.linalg.inv(C[some]), z)
        dof = z.shape[1] * z.shape[2] * (n - 1)
        assert abs(q.sum() / dof - 1) < 4 * np.sqrt(2 / dof)  # 4 standard deviations of such a mean
    nees = [tool.judged(data, copy)[0] for copy in made]
    assert 0.6 < np.mean(nees) < 1.5  # single ones of 20 copies are between 0.70 and 1.49


def controls(log):
    return log.robots[1].u


def sightings(log):
    return log.raw[1].y


def test_how_many_of_some_happen(tool):
    assert np.allclose(tool.how_many([0.5, 0.5]), [0.25, 0.5, 0.25])
    assert np.allclose(tool.how_many([1.0, 0.2]), [0, 0.8, 0.2])
    assert tool.in_band(np.array([0.5, 0.6, 1.6, 1.7])).tolist() == [False, True, True, False]
