"""Many runs at once are the package's filter, run many times; and they show what the lesson says."""

import dataclasses

import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course import fleet
from ekfslam_tutorial.course.draws.nb04 import MAPPING, SLAM, ZERO
from ekfslam_tutorial.course.exercises.nb04_blocks import new_blocks
from ekfslam_tutorial.course.exercises.nb04_moved import moved
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.simulation import SimObs, draw
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place


def zero_cross(P, L_r, L_y, R):
    P_lx, P_ll = new_blocks(P, L_r, L_y, R)
    return 0 * P_lx, P_ll


def mapping_blocks(P, L_r, L_y, R):
    return np.zeros((2, len(P))), L_y @ R @ L_y.T


FORMULAS = {SLAM: new_blocks, ZERO: zero_cross, MAPPING: mapping_blocks}
RIGHT = {"moved": moved, "new_blocks": new_blocks}
SHORT = fleet.round_trip(loops=0.25)


def run_of_the_package(s, runs, which, seed):
    """One of the runs of the fleet again, by the steps of `slam`, from the same random numbers."""
    rng, truth = np.random.default_rng(seed), s.start
    map, lmks, opt = Map(), {}, Options(lmk_type=EucPnt(2), error="additive")
    rob, sen = Rob(1, Odometry2()), Sen(1, 1, s.sensor, Frame2, x=np.zeros(3))
    place(map, rob, s.start, np.zeros((3, 3)))
    for _ in range(s.frames):
        truth = Odometry2().move(truth, s.step, s.dt)[0]
        rob.u, rob.U = s.step + draw(rng, s.U, (runs,))[which], s.U
        move(map, rob, s.dt)
        y = s.sensor.project(Frame2(truth).to_frame(s.points)[0])[0]
        seen = np.flatnonzero(y[:, 0] <= s.sensor.max_range)
        raw = SimObs(1, seen, (y + draw(rng, s.sensor.R, (runs, len(y)))[which])[seen])
        known = SimObs(1, *(a[[i in lmks for i in seen]] for a in (raw.ids, raw.y)))
        sen.model = dataclasses.replace(s.sensor, max_range=np.inf)  # the fleet uses what is truly in sight
        opt = dataclasses.replace(opt, n_updates=None)
        for k in range(len(known)):  # in the order of the fleet, one by one
            correct_known_lmks(map, rob, sen, lmks, {}, SimObs(1, known.ids[k : k + 1], known.y[k : k + 1]), opt)
        new = [i for i, id in enumerate(raw.ids) if int(id) not in lmks]
        init_new_lmks(map, rob, sen, lmks, raw, new, opt)
    return map, lmks


def test_a_run_of_the_fleet_is_a_run_of_the_package():
    s, runs = dataclasses.replace(SHORT, frames=80), 3
    result = fleet.run(s, RIGHT, runs, seed=5, keep=[80])
    map, lmks = run_of_the_package(s, runs, 0, seed=5)
    x, P = result.states[80]
    assert list(result.ranges) == list(lmks) and len(lmks) >= 4
    # The package wraps the heading, the fleet does not; all else is the same algebra in another order.
    np.testing.assert_allclose(np.delete(x, 2), np.delete(map.x, 2), atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * x[2]), np.exp(1j * map.x[2]), atol=1e-9)
    np.testing.assert_allclose(P, map.P, atol=1e-10)


def test_noise_does_not_depend_on_the_formulas():
    a, b = (
        fleet.run(dataclasses.replace(SHORT, frames=20), {**RIGHT, "new_blocks": FORMULAS[f]}, 2)
        for f in FORMULAS
        if f != ZERO
    )
    # Until the second sight of a landmark no wrong formula has had an effect on the pose.
    np.testing.assert_array_equal(a.position_error[0], b.position_error[0])
    assert a.position_error[0].all()


@pytest.fixture(scope="module")
def results():
    s = fleet.round_trip(loops=1)
    return {name: fleet.run(s, {"moved": moved, "new_blocks": f}, runs=20) for name, f in FORMULAS.items()}


def test_the_slam_formula_is_honest_and_the_others_are_not(results):
    """The averages over 20 runs at one time are in the 99.9 % band; the band is for one time, so most times must be."""
    low, high = anees_band(3, 20, 0.999)
    mean = {name: r.nees.mean(1) for name, r in results.items()}
    assert np.mean((mean[SLAM] > low) & (mean[SLAM] < high)) > 0.95
    for wrong in (ZERO, MAPPING):
        assert mean[wrong][300:].mean() > 3 * high
        assert results[wrong].summary()["nis"] == pytest.approx(2, rel=0.05)  # and the NIS does not see it
    assert results[SLAM].broken == 0


def test_a_fleet_can_be_told_a_wrong_sensor_and_keep_any_run():
    s = dataclasses.replace(SHORT, frames=40)
    told = dataclasses.replace(s.sensor, range_std=10 * s.sensor.range_std, bearing_std=10 * s.sensor.bearing_std)
    right, wrong = (fleet.run(s, RIGHT, 4, keep=[40], told=t, kept_run=2) for t in (None, told))
    assert 1 < right.nis.mean() < 3 and wrong.nis.mean() < 0.1
    assert len(right.nis_t) == len(right.nis) and right.nis_t[-1] == pytest.approx(40 * s.dt)
    error = np.hypot(*(right.states[40][0][:2] - right.truth[-1, :2]))
    assert error == pytest.approx(right.position_error[-1, 2]) and error != right.position_error[-1, 0]


def test_p_rm_not_propagated_breaks_the_covariance():
    def forgets(P, X_x, X_u, U):
        new = P.copy()
        new[:3, :3] = X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T
        return new

    result = fleet.run(fleet.round_trip(loops=1), {**RIGHT, "moved": forgets}, runs=3)
    assert result.broken > 0
