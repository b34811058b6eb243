"""The estimators of notebook 21 against other ways to the same numbers."""

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course import museum
from ekfslam_tutorial.course.cells import experiment_of
from ekfslam_tutorial.course.draws.nb21_cost import numbers_kept, pattern
from ekfslam_tutorial.course.estimators import Log, ekf, first_estimates, invariant, iterated, lmk
from ekfslam_tutorial.course.exercises.nb05_frame import slam_frame
from ekfslam_tutorial.course.exercises.nb21_iterated import iterated_correct
from ekfslam_tutorial.course.exercises.nb21_marginalise import marginalise
from ekfslam_tutorial.course.smoothers import METHODS, Window, batch
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, wrap
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.models.sensors.range_bearing import polar
from ekfslam_tutorial.simulation import SimObs, draw
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move

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


def test_a_window_as_long_as_the_log_is_the_batch():
    whole = Window(LOG, LOG.frames, 3)
    end = whole.run()
    for _ in range(8):
        whole.step()
    for a, b in zip(whole.estimate().x, batch(LOG).x, strict=True):
        assert difference(a, b) < 1e-6
    np.testing.assert_allclose(end.path[:, -1], end.x[:, :3], atol=1e-12)


def everything(log):
    """A smoother with all poses in its state, at the solution of the batch."""
    w, best = Window(log, log.frames), batch(log)
    for k in range(log.frames):
        w.grow(k)
    w.poses, w.l = best.path, best.x[:, 3:].reshape(log.runs, -1, 2)
    return w


def test_the_batch_is_the_minimum_of_the_cost():
    w = everything(LOG)
    A, g = w.normal_equations(range(LOG.frames))
    assert np.abs(g).max() < 1e-3 * np.abs(A).max() * 1e-3
    assert np.abs(w.step()).max() < 1e-6


def test_marginalising_loses_nothing_where_nothing_is_linearised_again():
    """Without iterations after it, a step of a short window gives what the long one gives."""
    long, short = Window(LOG, 9), Window(LOG, 9)
    for k in range(6):
        long.grow(k)
        short.grow(k)
    for _ in range(2):
        short.marginalise()
    a, b = long.step(), short.step()
    np.testing.assert_allclose(a[:, 6:], b, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("loops", [0.5, 1.0])
def test_the_pattern_is_where_the_matrix_is_not_zero(loops):
    log = make_logs(1, loops)
    A = everything(log).normal_equations(range(log.frames))[0][0]
    assert not np.any((np.abs(A) > 1e-9) & ~(pattern(log).toarray() != 0))


def test_numbers_kept():
    kept = numbers_kept(make_logs(n=20, radius=12.0))
    assert kept["filter: P"] == 43**2 and kept["one triangle of P"] == 43 * 44 // 2
    assert kept["smoother: A"] <= kept["smoother: factor of A"]


def test_all_poses_but_the_last_marginalised_leave_the_filters_information():
    log = make_logs(1, 1.0)
    A = everything(log).normal_equations(range(log.frames))[0][0]
    B = marginalise(A, np.zeros(len(A)), list(range(3 * log.frames - 3, len(A))))[0]
    np.testing.assert_allclose(np.linalg.inv(B), batch(log).P[0], rtol=1e-5, atol=1e-9)


def test_what_notebook_21_says_of_the_methods():
    """Means of 40 runs: the batch is in its 99.9 % band, the filters are above it, the invariant one comes close."""
    logs = make_logs(40)
    nees = {name: method(logs).nees(logs).mean() for name, method in {"EKF": ekf, **METHODS}.items()}
    low, high = anees_band(3 + 2 * len(logs.points), 40, 0.999)
    assert (round(low, 1), round(high, 1), round(nees["batch"], 1), round(nees["invariant EKF"], 1)) == (
        19.6,
        26.7,
        25.6,
        27.6,
    )
    assert low < nees.pop("batch") < high < min(nees.values()) == nees["invariant EKF"]
