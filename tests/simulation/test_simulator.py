"""The simulator: true motion, noise of the right size, and streams that do not disturb each other."""

import numpy as np
import pytest
from scipy.stats import chi2

from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models.motion import ConstantVelocity, Unicycle
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.simulation import SimLmk, SimRob, SimSen, Streams, draw, sim_motion, sim_observation

SENSOR = RangeBearing(0.1, 0.02, max_range=8.0, fov=3.0)


def rob(x=(0, 0, 0), u=(1.0, 0.5)):
    return SimRob(1, "r", Unicycle(), np.array(x, float), np.array(u), [1])


def sen(**more):
    return SimSen(1, "s", 1, Frame2([0.2, 0, 0]), SENSOR, **more)


def lmk(n=200, seed=0):
    return SimLmk(np.arange(1, n + 1), np.random.default_rng(seed).uniform(-10, 10, (n, 2)))


def test_motion_is_the_models_own_without_noise():
    r = rob()
    for _ in range(40):
        expected = r.motion.move(r.x, r.u, 0.1)[0]
        sim_motion(r, 0.1)
        assert np.allclose(Frame2(r.x).minus(Frame2(expected))[0], 0, atol=1e-12)
    assert -np.pi < r.x[2] <= np.pi


def test_quaternion_stays_a_unit_over_a_long_run():
    x = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0.3, 2.0, 0.7])
    r = SimRob(1, "r", ConstantVelocity(), x, np.zeros(6))
    for _ in range(5000):
        sim_motion(r, 0.1)
    assert abs(np.linalg.norm(r.frame.q) - 1) < 1e-14


def test_measurements_are_those_of_visible_landmarks_with_the_sensors_noise():
    world, rng = lmk(), np.random.default_rng(1)
    r, s = rob((1, 2, 0.3)), sen()
    d2 = []
    for _ in range(60):
        obs = sim_observation(r, s, world, rng)
        p = s.frame.to_frame(r.frame.to_frame(world.points[obs.ids - 1])[0])[0]
        e, _ = SENSOR.project(p)
        z = SENSOR.residual(obs.y, e)
        d2 += (z @ np.linalg.inv(SENSOR.R) * z).sum(-1).tolist()
        assert (obs.y[:, 0] <= 8.0).all() and (np.abs(obs.y[:, 1]) <= 1.5).all()
    low, high = chi2.ppf([0.0005, 0.9995], 2 * len(d2))  # 99.9 % band; the seed is fixed, so it holds or it does not
    assert len(d2) > 500 and low < sum(d2) < high


def test_bearings_are_wrapped_after_the_noise():
    s = SimSen(1, "s", 1, Frame2([0.0, 0, 0]), RangeBearing(0.1, 0.5))
    behind = SimLmk(np.arange(1, 401), np.stack([np.full(400, -5.0), np.linspace(-0.1, 0.1, 400)], -1))
    y = sim_observation(rob(), s, behind, np.random.default_rng(2)).y
    assert (np.abs(y[:, 1]) <= np.pi).all() and (y[:, 1] > 2).any() and (y[:, 1] < -2).any()


def test_a_landmarks_noise_does_not_depend_on_who_else_is_in_view():
    world = lmk(50)
    wide = SimSen(1, "s", 1, Frame2([0.2, 0, 0]), RangeBearing(0.1, 0.02, max_range=100.0))
    narrow = sim_observation(rob(), sen(), world, np.random.default_rng(4))
    all_of_them = sim_observation(rob(), wide, world, np.random.default_rng(4))
    assert 0 < len(narrow) < len(all_of_them) == 50
    assert np.array_equal(narrow.y, all_of_them.y[np.isin(all_of_them.ids, narrow.ids)])


def test_nothing_is_seen_behind_a_camera():
    r = SimRob(1, "r", ConstantVelocity(), np.array([0, 0, 0, 1, 0, 0, 0, *np.zeros(6)]), np.zeros(6))
    camera = SimSen(1, "c", 1, Frame3([0, 0, 0, 1, 0, 0, 0]), PinHole())
    world = SimLmk(np.arange(1, 5), np.array([[0, 0, 5.0], [0, 0, -5.0], [1, 1, 0.0], [0.1, 0, 5]]))
    assert sim_observation(r, camera, world, np.random.default_rng(0)).ids.tolist() == [1, 4]


def test_missed_and_false_measurements_come_at_the_rates_asked_for():
    world, s = lmk(), sen(p_detect=0.7, clutter=2.0)
    full = np.mean([len(sim_observation(rob(), sen(), world, np.random.default_rng(i))) for i in range(20)])
    rng, clutter = np.random.default_rng(5), np.random.default_rng(6)
    seen = [sim_observation(rob(), s, world, rng, clutter) for _ in range(300)]
    false = np.array([(o.ids == -1).sum() for o in seen])
    true = np.array([(o.ids > 0).sum() for o in seen])
    # means of 300 draws, bands of 4 standard errors: Poisson(2), and a thinning with probability 0.7
    assert abs(false.mean() - 2.0) < 4 * np.sqrt(2.0 / 300)
    assert abs(true.mean() - 0.7 * full) < 4 * np.sqrt(0.21 * full / 300) + 0.5


def test_clutter_needs_its_own_generator():
    with pytest.raises(ValueError, match="sensor 1 misses measurements or makes false ones: a clutter_rng is needed"):
        sim_observation(rob(), sen(clutter=1.0), lmk(), np.random.default_rng(5))


def test_clutter_leaves_the_true_measurements_as_they_were():
    a = sim_observation(rob(), sen(), lmk(), np.random.default_rng(5))
    b = sim_observation(rob(), sen(clutter=3.0), lmk(), np.random.default_rng(5), np.random.default_rng(6))
    assert len(b) > len(a) and np.array_equal(b.ids[: len(a)], a.ids) and np.array_equal(b.y[: len(a)], a.y)


def test_draws_have_the_covariance_even_a_singular_one():
    cov = np.array([[2.0, 1.0, 0.0], [1.0, 0.5, 0.0], [0.0, 0.0, 0.0]])  # rank 1 and a zero
    x = draw(np.random.default_rng(0), cov, (40_000,))
    assert x.shape == (40_000, 3) and np.allclose(x[:, 2], 0, atol=1e-7)
    assert np.allclose(np.cov(x.T), cov, atol=0.06)  # 4 standard errors: 4 * sqrt(2) * 2 / sqrt(40000)


def test_streams_are_told_apart_by_id_and_cause():
    one, two = Streams(7), Streams(7)
    two.sensing(5).random(100)  # a further sensor, asked for first
    assert np.array_equal(one.motion(1).random(5), two.motion(1).random(5))
    assert np.array_equal(one.sensing(1).random(5), two.sensing(1).random(5))
    drawn = [s.random() for s in (one.world, one.motion(1), one.motion(2), one.sensing(1), one.clutter(1))]
    assert len(set(drawn)) == 5 and Streams(8).motion(1).random() not in drawn


def test_sim_lmk_knows_the_size_of_the_world():
    world = SimLmk(np.array([1, 2]), np.array([[0.0, 1.0, 2.0], [4.0, 1.0, 6.0]]))
    assert world.lims.tolist() == [[0, 4], [1, 1], [2, 6]]
    assert world.dims.tolist() == [4, 0, 4] and world.center.tolist() == [2, 1, 4]


@pytest.mark.parametrize("k", [0, 1])
def test_sim_obs_says_how_many(k):
    assert len(sim_observation(rob(), sen(), lmk(0 + k), np.random.default_rng(0))) <= k
