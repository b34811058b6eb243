"""The estimators of notebook 21 against other ways to the same numbers."""

import json
import re

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course import build, museum
from ekfslam_tutorial.course.cells import experiment_of
from ekfslam_tutorial.course.draws.nb21_cost import numbers_kept, pattern
from ekfslam_tutorial.course.estimators import FILTERS, Log, ekf, first_estimates, invariant, iterated, lmk
from ekfslam_tutorial.course.exercises.nb05_frame import slam_frame
from ekfslam_tutorial.course.exercises.nb21_gauss_newton import gauss_newton_step
from ekfslam_tutorial.course.exercises.nb21_iterated import iterated_correct
from ekfslam_tutorial.course.exercises.nb21_marginalise import marginalise
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, wrap
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.models.sensors.range_bearing import polar
from ekfslam_tutorial.simulation import SimObs, draw
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move

from .running import needed

make_logs = experiment_of("21", np=np, Frame2=Frame2, polar=polar, draw=draw, Log=Log)["make_logs"]
LOG = make_logs(2, 0.6)
FEW = make_logs(2, 1.2, n=6, reach=2.6)  # at most one landmark in view: the order of corrections plays no part


def difference(a, b):
    """Of two states; the heading wrapped."""
    d = np.array(a) - b
    d[2] = wrap(d[2])
    return np.abs(d).max()


def test_the_ekf_is_that_of_notebook_05():
    one, x, P, ids = LOG.one(1), LOG.first, np.zeros((3, 3)), []
    for k in range(LOG.frames):
        x, P, ids = slam_frame(x, P, ids, one.u[k], LOG.U, one.seen[k], one.y[k], LOG.S)
    assert ids == list(range(len(ids)))
    assert difference(x, ekf(LOG).x[1]) < 1e-9
    np.testing.assert_allclose(P, ekf(LOG).P[1], atol=1e-10)


@pytest.mark.parametrize(
    ("method", "options"),
    [(first_estimates, {"first_estimates": True}), (invariant, {"error": "invariant"}), (ekf, {"error": "additive"})],
)
def test_filters_are_those_of_the_toolbox(method, options):
    sensor, opt, map = RangeBearing(*np.sqrt(np.diag(FEW.S))), Options(**options), Map()
    rob = Rob(1, Odometry2(), r=map.add(FEW.first, np.zeros((3, 3))), U=FEW.U, sensors=[1])
    sen, lmks, obs, one = Sen(1, 1, sensor, Frame2, x=np.zeros(3)), {}, {}, FEW.one(0)
    for k in range(FEW.frames):
        rob.u = one.u[k]
        move(map, rob, 1.0)
        raw = SimObs(1, one.seen[k], one.y[k])
        _, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        init_new_lmks(map, rob, sen, lmks, raw, new, opt)
    ours = method(FEW)
    assert difference(map.x, ours.x[0]) < 1e-8
    np.testing.assert_allclose(map.P, ours.P[0], rtol=1e-7, atol=1e-10)
    assert method is ekf or np.abs(ours.P[0] - ekf(FEW).P[0]).max() > 1e-3  # it is another filter


def test_one_iteration_with_one_landmark_in_view_is_the_ekf():
    np.testing.assert_allclose(iterated(FEW, 1).x, ekf(FEW).x, atol=1e-9)


def test_the_iterated_filter_corrects_as_the_exercise_does():
    x, P, n = FEW.first, np.zeros((3, 3)), 0
    for k in range(FEW.frames):
        x, P = museum.predict(x, P, FEW.u[0, k], FEW.U)
        for i, y in zip(FEW.seen[k], FEW.y[k][0], strict=True):
            if i < n:
                x, P = iterated_correct(x, P, y, FEW.S, lambda x, i=i: museum.observe(x, lmk(i)), 4)
            else:
                x, P = museum.augment(x, P, y, FEW.S)
                n += 1
    assert difference(x, iterated(FEW).x[0]) < 1e-9


# --- the smoother, against the reader's own Gauss-Newton ---


@pytest.fixture(scope="module")
def notebook():
    """Cells of the notebook: its code, and what the named ones define."""
    (path,) = build.notebooks_folder().glob("21_*.ipynb")
    cells = json.loads(path.read_text("utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    starts = "def odometry", "def all_measurements", "def stack", "def as_graph"
    space = {"__name__": "__main__"}
    for cell in needed(code, [k for k, cell in enumerate(code) if build.source(cell).startswith(starts)]):
        exec(build.source(cell), space)
    return cells, space


def all_at_once(space, log, steps=20):
    """Poses and landmarks where all measurements fit best, and the information matrix A there."""
    start = ekf(log)
    x = np.concatenate([start.path[0].ravel(), start.x[0, 3:]])
    for _ in range(steps):
        dx, A = gauss_newton_step(*space["stack"](space["all_measurements"](x, log.one(0)), len(x)))
        x = x + dx
    assert np.abs(dx).max() < 1e-9
    return x, A


@pytest.mark.parametrize("loops", [0.6, 1.3])
def test_the_smoother_finds_what_gauss_newton_finds(notebook, loops):
    """Of the toolbox, with multipliers and sparse; and in the notebook, dense. Also what a filter would keep of it."""
    log = make_logs(2, loops)
    x, P, path = notebook[1]["smoothed"](log.one(0))
    best, A = all_at_once(notebook[1], log)
    n = 3 * log.frames
    np.testing.assert_allclose(wrap(path.ravel() - best[:n]), 0, atol=1e-8)  # turns of the heading do not count
    assert difference(x, best[n - 3 :]) < 1e-8
    B = marginalise(A, np.zeros(len(A)), list(range(n - 3, len(A))))[0]
    np.testing.assert_allclose(np.linalg.inv(B), P, rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("loops", [0.5, 1.0])
def test_the_pattern_is_where_the_matrix_is_not_zero(notebook, loops):
    log = make_logs(1, loops)
    A = all_at_once(notebook[1], log)[1]
    assert not np.any((np.abs(A) > 1e-9) & ~(pattern(log).toarray() != 0))


def test_numbers_kept():
    kept = numbers_kept(make_logs(n=20, radius=12.0))
    assert kept["filter: P"] == 43**2 and kept["one triangle of P"] == 43 * 44 // 2
    assert kept["smoother: A"] <= kept["smoother: factor of A"]


def test_what_notebook_21_says_of_the_methods(notebook):
    """Means of 40 runs, as its table has them: the batch is in its 99.9 % band, the filters are above it."""
    cells = notebook[0]
    (table,) = ["".join(c["outputs"][0]["text"]) for c in cells if "print(nb21.methods_table" in build.source(c)]
    (answer,) = [build.source(c) for c in cells if "the mean NEES of the batch" in build.source(c)]
    rows = dict(re.findall(r"^(.*?)  +((?:> )?[\d.]+(?: to [\d.]+)?) ", table, re.MULTILINE))
    low, high = anees_band(3 + 2 * 10, 40, 0.999)
    assert rows.pop("honest (99.9 %)") == f"{low:.1f} to {high:.1f}" and f"{low:.1f} to {high:.1f}" in answer
    nees = {name: float(mean.removeprefix("> ")) for name, mean in rows.items()}
    assert list(nees) == ["EKF", *FILTERS, "batch"]
    assert f"the batch is {nees['batch']}," in answer and f"comes close, {nees['invariant EKF']}." in answer
    assert low < nees.pop("batch") < high < min(nees.values()) == nees["invariant EKF"]
