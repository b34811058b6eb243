"""An IMU that lies still: what its start says of tilt and bias, by a second author who works with what is down."""

from itertools import product

import numpy as np
import pytest

from ekfslam_tutorial.geometry import numerical_jacobian, q2R, q_prod
from ekfslam_tutorial.models.motion.at_rest import at_rest

G = np.array([0.0, 0.0, -9.81])
LYING = {
    "level": [0.0, 0.0, 9.7],
    "tilted": [1.0, -2.0, 9.0],
    "on its side": [9.9, 0.0, 0.0],
    "upside down": [0.0, 0.0, -9.8],
    "almost upside down": [0.3, 0.2, -9.8],
    "upside down within 1 mrad": [0.005, 0.005, -9.8],
}
STDS = {"gyro_std": 0.002, "acc_std": 0.03, "vel_std": 0.05, "acc_bias_std": 0.2}


@pytest.mark.parametrize("gravity", [G, np.array([0.0, 9.0, 0.0]), np.array([3.0, -7.0, 2.0])], ids=str)
@pytest.mark.parametrize("a", LYING.values(), ids=list(LYING))
def test_what_is_measured_at_rest_is_gravity_and_bias(a, gravity):
    """The rotation brings what is measured upwards, without a turn about it; the rest of its length is bias."""
    w, a = np.array([0.01, -0.02, 0.03]), np.array(a)
    x, _ = at_rest(w, a, gravity)
    s = a / np.linalg.norm(a) * np.linalg.norm(gravity)
    R = q2R(x[3:7])[0]
    assert np.allclose(R @ s, -gravity, atol=1e-9) and np.isclose(np.linalg.norm(x[3:7]), 1)
    assert np.array_equal(x[:3], np.zeros(3)) and np.array_equal(x[7:10], np.zeros(3))
    assert np.allclose(x[10:13], w) and np.allclose(x[13:], a - s)
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    assert abs(axis @ gravity) < 1e-5  # level; 1e-3 rad from upside down by half a turn more


def test_half_a_turn_whatever_is_down():
    """Along each axis and each diagonal, just upside down: some axis across it is always found."""
    for down in product((-1.0, 0.0, 1.0), repeat=3):
        if any(down):
            g = 9.81 * np.array(down) / np.linalg.norm(down)
            x, P = at_rest(np.zeros(3), 1.02 * g, g)
            assert np.allclose(q2R(x[3:7])[0] @ g, -g, atol=1e-12) and np.isfinite(P).all()


@pytest.mark.parametrize("gravity", [G, np.array([3.0, -7.0, 2.0])], ids=str)
@pytest.mark.parametrize("a", LYING.values(), ids=list(LYING))
def test_tilt_and_bias_are_known_as_well_as_they_can_be(a, gravity):
    """Of [R' gravity; v; b_w; b_a], with a = -R' gravity + b_a + n of which the length of R' gravity is known.

    So only what is across can be wrong of R' gravity, by the bias and by n. What else there is of P is nothing: place,
    yaw, and the length of q.
    """
    a = np.array(a)
    x, P = at_rest(np.array([0.1, 0.2, 0.3]), a, gravity, **STDS)
    up = a / np.linalg.norm(a)
    across, along, I, O = np.eye(3) - np.outer(up, up), np.outer(up, up), np.eye(3), np.zeros((3, 3))
    J = np.block(
        [[across, across, O, O], [O, O, I, O], [O, O, O, I], [across, -along, O, O]]
    )  # by b_a, n, v, noise of w
    stds = np.repeat([STDS[name] for name in ("acc_bias_std", "acc_std", "vel_std", "gyro_std")], 3)
    H = np.zeros((12, 16))
    H[:3, 3:7] = numerical_jacobian(lambda q: q2R(q)[0].T @ gravity, x[3:7])
    H[3:, 7:] = np.eye(9)
    assert np.allclose(H @ P @ H.T, J @ np.diag(stds**2) @ J.T, rtol=1e-6, atol=1e-10)
    yaw = q_prod(x[3:7], np.concatenate([[0.0], up]))[0]
    for nothing in (x[3:7], yaw):
        assert np.allclose(P[:, 3:7] @ nothing, 0, atol=1e-12)
    assert not P[:3].any() and np.allclose(P, P.T, atol=1e-15)


def test_the_stds_that_nobody_gives():
    said = dict(gravity=G, gyro_std=1e-3, acc_std=0.05, vel_std=0.02, acc_bias_std=0.1)
    for given, silent in zip(
        at_rest(np.ones(3), LYING["tilted"], **said), at_rest(np.ones(3), LYING["tilted"]), strict=True
    ):
        assert np.array_equal(given, silent)


@pytest.mark.parametrize("a", [np.zeros(3), np.full(3, np.nan)])
def test_an_accelerometer_that_measures_nothing(a):
    with pytest.raises(ValueError, match="an accelerometer at rest measures gravity, got"):
        at_rest(np.zeros(3), a)
