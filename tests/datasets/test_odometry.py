"""From commanded speeds to steps with covariances."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ekfslam_tutorial.datasets.odometry import OdometryNoise, dead_reckon, steps
from ekfslam_tutorial.models.motion import Odometry2, Unicycle

NOISE = OdometryNoise(along=0.06, across=0.04, turn=0.15, drift=0.03)


def log(rng, n=200, dt=0.02):
    """Commands that change now and then, standing included."""
    t = 1.25e9 + np.cumsum(rng.uniform(0.5 * dt, 1.5 * dt, n))
    change = np.repeat(rng.normal(size=(n // 20, 2)) * [0.2, 0.6], 20, axis=0)
    change[40:60] = 0
    return t, change[:, 0], change[:, 1]


@st.composite
def logs_and_times(draw, n_min):
    """A log, and instants before, in and after it."""
    n = draw(st.integers(n_min, 60))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    t, v, w = log(rng)
    return t, v, w, np.unique(rng.uniform(t[0] - 1, t[-1] + 1, n))


def test_straight_and_turn():
    pose = dead_reckon(
        np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.5, 0.0, 0.5, 9.0]), np.array([0.0, np.pi / 2, 0.0, 9.0])
    )
    np.testing.assert_allclose(pose, [[0, 0, 0], [0.5, 0, 0], [0.5, 0, np.pi / 2], [0.5, 0.5, np.pi / 2]], atol=1e-15)


def test_dead_reckoning_is_the_unicycle_to_third_order(rng):
    """Pieces go straight in their middle direction: a chord instead of an arc, shorter by (turn^2 / 24)."""
    t, v, w = log(rng)
    x = np.zeros(3)
    for k in range(len(t) - 1):
        x = Unicycle().move(x, np.array([v[k], w[k]]), t[k + 1] - t[k])[0]
    way, turn = abs(v[:-1]) @ np.diff(t), abs(w * 0.03).max()
    np.testing.assert_allclose(dead_reckon(t, v, w)[-1], x, atol=1.1 * way * turn**2 / 24 + 1e-12)


@settings(max_examples=40, deadline=None)
@given(logs_and_times(1))
def test_steps_put_together_are_dead_reckoning(case):
    """Whatever the frames: composing all steps leads to where the dead-reckoned path is."""
    t, v, w, times = case
    u, U = steps(t, v, w, times, NOISE)
    assert u.shape == (len(times), 3) and not u[0].any() and not U[0].any()

    knots = np.union1d(t, times)
    command = np.searchsorted(t, knots, "right") - 1
    path = dead_reckon(knots, *(np.where(command < 0, 0, a[command]) for a in (v, w)))
    x = path[np.searchsorted(knots, times[0])]
    for step, time in zip(u, times, strict=True):
        x = Odometry2().move(x, step, 0)[0]
        np.testing.assert_allclose(x, path[np.searchsorted(knots, time)], atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(logs_and_times(2))
def test_covariances_are_covariances(case):
    t, v, w, times = case
    _, U = steps(t, v, w, times, NOISE)
    np.testing.assert_allclose(U, np.swapaxes(U, 1, 2), atol=1e-18)
    assert (np.linalg.eigvalsh(U) >= -1e-15).all()


def test_covariance_is_that_of_many_small_predictions(rng):
    """The oracle: the EKF prediction, piece by piece. It puts a turn's noise at the start of a piece, `steps` at its
    middle: the difference falls with the length of the pieces, here 2 ms at 0.2 m/s."""
    t, v, w = log(rng, n=2000, dt=0.002)
    u, U = steps(t, v, w, t[[0, -1]], NOISE)
    x, P = np.zeros(3), np.zeros((3, 3))
    for k in range(len(t) - 1):
        dt = t[k + 1] - t[k]
        way, turn = abs(v[k]) * dt, abs(w[k]) * dt
        q = [
            NOISE.along**2 * way,
            NOISE.across**2 * way,
            NOISE.turn**2 * turn + NOISE.drift**2 * dt * bool(way or turn),
        ]
        x, X_x, X_u = Odometry2().move(x, np.array([v[k] * dt, 0, w[k] * dt]), 0)
        P = X_x @ P @ X_x.T + X_u @ np.diag(q) @ X_u.T
    np.testing.assert_allclose(u[1], x, atol=1e-3)
    np.testing.assert_allclose(U[1], P, rtol=2e-3, atol=2e-3 * abs(P).max())


def test_covariance_does_not_depend_on_how_often_a_command_is_repeated():
    """The same motion, logged at 10 Hz and at 100 Hz: random walks add up to the same variance."""
    coarse, fine = (np.arange(0, 4 + dt / 2, dt) for dt in (0.1, 0.01))
    U = [steps(t, 0 * t + 0.2, 0 * t + 0.3, np.array([0.0, 4.0]), NOISE)[1][1] for t in (coarse, fine)]
    # the arc is cut into chords of 0.03 rad: relative differences of that squared
    np.testing.assert_allclose(U[0], U[1], rtol=1e-3, atol=1e-3 * abs(U[1]).max())


def test_standing_still_adds_nothing():
    t = np.arange(5.0)
    u, U = steps(t, 0 * t, 0 * t, np.array([0.5, 1.5, 3.0]), NOISE)
    assert not u.any() and not U.any()


def test_a_gap_holds_the_command():
    t = np.array([0.0, 0.1, 1.5, 1.6])
    u, _ = steps(t, np.array([0.1, 0.1, 0, 0]), np.zeros(4), np.array([0.0, 1.0, 2.0]), NOISE)
    np.testing.assert_allclose(u[:, 0], [0, 0.1, 0.05], atol=1e-12)


def test_one_frame():
    u, U = steps(np.array([0.0, 1.0]), np.ones(2), np.ones(2), np.array([0.5]), NOISE)
    assert u.shape == (1, 3) and U.shape == (1, 3, 3) and not u.any() and not U.any()


def test_noise_is_read_in_the_direction_of_travel():
    """Straight on for 4 m: along x 0.06^2 * 4; across, 0.04^2 * 4 and the swing of the drift, 0.03^2 s^3 v^2 / 3."""
    t = np.arange(0, 20.001, 0.01)
    _, U = steps(t, 0 * t + 0.2, 0 * t, np.array([0.0, 20.0]), NOISE)
    assert U[1, 0, 0] == pytest.approx(0.06**2 * 4, rel=1e-6)
    assert U[1, 1, 1] == pytest.approx(0.04**2 * 4 + 0.03**2 * 0.2**2 * 20**3 / 3, rel=1e-4)
    assert U[1, 2, 2] == pytest.approx(0.03**2 * 20, rel=1e-6)
    assert U[1, 1, 2] == pytest.approx(0.03**2 * 0.2 * 20**2 / 2, rel=1e-4)
