"""The IMU against integrated differential equations, a fall, and the numbers of a data sheet."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ekfslam_tutorial.geometry import q2R, q_prod, v2q
from ekfslam_tutorial.models import turning
from ekfslam_tutorial.models.motion import Imu

GRAVITY = np.array([0.0, 0.0, -9.81])


def at_rest():
    x = np.zeros(16)
    x[3] = 1.0
    return x


def control(w=(0, 0, 0), a=(0, 0, 9.81)):
    return np.concatenate([w, a, np.zeros(6)])


def test_at_rest_the_accelerometer_measures_what_holds_it_up():
    x2, *_ = Imu().move(at_rest(), control(), 0.01)
    assert np.allclose(x2, at_rest(), atol=1e-15)


def test_a_free_fall_measures_nothing():
    x = at_rest()
    for _ in range(100):
        x, *_ = Imu().move(x, control(a=(0, 0, 0)), 0.01)
    assert np.allclose(x[:3], GRAVITY / 2, atol=1e-12) and np.allclose(x[7:10], GRAVITY, atol=1e-12)


def flown(w, a, seconds):
    """The state by the differential equations t' = v, q' = q w / 2, v' = R(q) a + gravity, integrated finely."""

    def rates(_, x):
        q = x[3:7]
        q_t = 0.5 * q_prod(q, np.array([0.0, *w]))[0]
        return [*x[7:10], *q_t, *(q2R(q)[0] @ a + GRAVITY)]

    return solve_ivp(rates, (0, seconds), at_rest()[:10], rtol=1e-11, atol=1e-12).y[:, -1]


@pytest.mark.parametrize("w, a", [((0.5, -0.3, 1.0), (0.4, 0.2, 9.5)), ((0.0, 2.0, 0.0), (3.0, 0.0, 1.0))])
def test_it_solves_the_equations_of_motion_to_second_order(w, a):
    """Half the step, a quarter of the error: the rotation is taken in the middle."""
    want = flown(np.array(w), np.array(a), 1.0)
    errors = []
    for steps in (100, 200):
        x = at_rest()
        for _ in range(steps):
            x, *_ = Imu().move(x, control(w, a), 1.0 / steps)
        errors.append(np.abs(x[:10] - want).max())
    assert errors[0] < 1e-3 and 3.8 < errors[0] / errors[1] < 4.2


def test_a_known_bias_changes_nothing():
    w, a, b_w, b_a = (np.array(v) for v in ([0.1, 0.2, -0.3], [0.5, 0.1, 9.7], [0.01, -0.02, 0.03], [0.1, 0.2, -0.1]))
    biased = at_rest()
    biased[10:] = [*b_w, *b_a]
    x2, *_ = Imu().move(at_rest(), control(w, a), 0.02)
    y2, *_ = Imu().move(biased, control(w + b_w, a + b_a), 0.02)
    assert np.allclose(y2[:10], x2[:10], atol=1e-15) and np.allclose(y2[10:], biased[10:])


def test_the_noise_of_a_data_sheet_does_not_depend_on_the_rate():
    """The variance of the velocity after 1 s: acc_noise^2; of a bias: its walk^2; at 100 and at 400 Hz."""
    imu = Imu(gyro_noise=1e-9, gyro_walk=1e-9)
    for rate in (100, 400):
        x, P = at_rest(), np.zeros((16, 16))
        for _ in range(rate):
            x, X_x, X_u = imu.move(x, control(), 1 / rate)
            P = X_x @ P @ X_x.T + X_u @ imu.noise(1 / rate) @ X_u.T
        assert np.allclose(np.diag(P)[13:], imu.acc_walk**2)
        # white noise of the accelerometer, and the walk of its bias integrated: acc_walk^2 t^3 / 3
        assert np.allclose(np.diag(P)[7:10], imu.acc_noise**2 + imu.acc_walk**2 / 3, rtol=0.02)


def test_a_turn_is_the_gyrometers():
    x2, *_ = Imu().move(at_rest(), control(w=(0, 0, 1.0)), 0.5)
    assert np.allclose(x2[3:7], v2q(np.array([0, 0, 0.5]))[0])


def test_it_says_of_its_states_what_its_motion_shows(rng):
    """A model that does not say how its states turn is asked by moving a turned state."""

    class Silent:
        frame, size, control_fields, state_fields = Imu.frame, Imu.size, Imu.control_fields, Imu.state_fields
        move = staticmethod(Imu().move)

    x = np.concatenate([[1.0, 2, 3, 1, 0, 0, 0], rng.normal(size=9)])
    assert np.allclose(Imu().turning(x), turning(Silent(), x))


@pytest.mark.parametrize(
    "wrong, sentence",
    [
        (dict(acc_noise=-1), "acc_noise must be zero or a positive number, got -1"),
        (dict(gravity=(0, 0)), r"gravity must be 3 finite numbers, got \(0, 0\)"),
    ],
)
def test_what_makes_no_imu_is_refused(wrong, sentence):
    with pytest.raises(ValueError, match=sentence):
        Imu(**wrong)
