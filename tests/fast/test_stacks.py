"""Stacks of observations, corrected jointly, and covariances of which one triangle is kept, against full matrices."""

import numpy as np
import pytest

from ekfslam_tutorial.fast import FastMap, augment, correct, covariance, cross, fast_map, innovation, predict
from tests.ekf.textbook import Textbook

pytestmark = pytest.mark.usefixtures("triangles")

K, M = 4, 2  # observations in a stack, numbers in each


def spread(n, rng):
    A = rng.normal(size=(n, n))
    return A @ A.T / n + 0.1 * np.eye(n)


@pytest.fixture
def scene(rng):
    """A map of a robot (7), a sensor (7) and ten landmarks (3), and their ranges."""
    map = FastMap()
    robot, sensor = map.add(rng.normal(size=7), np.eye(7)), map.add(rng.normal(size=7), np.eye(7))
    lmks = [map.add(rng.normal(size=3), np.eye(3)) for _ in range(10)]
    map.P[:] = spread(map.n, rng)
    return map, robot, sensor, lmks


def stack(robot, sensor, lmks, rng):
    """Blocks of a stack of observations of the landmarks, and the big H that they stand for."""
    E_r, E_s, E_l = (rng.normal(size=(K, M, k)) for k in (7, 7, 3))
    rows = np.array([range(r.start, r.stop) for r in lmks])
    H = np.zeros((K, M, 44))
    for i in range(K):
        for r, J in ((robot, E_r), (sensor, E_s)):
            if r is not None:
                H[i][:, r] = J[i]
        H[i][:, rows[i]] = E_l[i]
    return ((robot, E_r), (sensor, E_s), (rows, E_l)), H.reshape(K * M, 44)


@pytest.mark.parametrize("known", [(), ("robot",), ("sensor",), ("robot", "sensor")])
@pytest.mark.parametrize("own_noise", [False, True])
def test_a_joint_correction_is_the_textbooks_with_stacked_rows(scene, known, own_noise, rng):
    map, robot, sensor, lmks = scene
    robot, sensor = None if "robot" in known else robot, None if "sensor" in known else sensor
    blocks, H = stack(robot, sensor, lmks[3 : 3 + K], rng)
    z, R = rng.normal(size=(K, M)), np.array([spread(M, rng) for _ in range(K)])
    R = R if own_noise else R[0]
    big_R = np.zeros((K * M, K * M))
    for i in range(K):
        big_R[i * M : (i + 1) * M, i * M : (i + 1) * M] = R[i] if own_noise else R
    dense = Textbook(map.x.copy(), map.P.copy())
    dense.correct(z.ravel(), H, big_R)

    PHt = cross(map, blocks)
    assert PHt.shape == (map.n, K * M) and np.allclose(PHt, map.P @ H.T, atol=1e-12)
    E = covariance(PHt, blocks)
    assert np.allclose(E, H @ map.P @ H.T, atol=1e-12)
    correct(map, PHt, innovation(z, E, R))
    assert np.allclose(map.x, dense.x, atol=1e-11) and np.allclose(map.P, dense.P, atol=1e-11)
    assert np.array_equal(map.P, map.P.T)


def test_the_parts_of_an_innovation_are_left_alone(rng):
    z, E, R = rng.normal(size=(2, 2)), np.eye(4), np.eye(2)
    assert np.array_equal(innovation(z, E, R).Z, 2 * np.eye(4)) and np.array_equal(E, np.eye(4))


def test_a_stack_of_one_is_a_single_observation(scene, rng):
    map, robot, _, lmks = scene
    E_r, E_l, z = rng.normal(size=(1, M, 7)), rng.normal(size=(1, M, 3)), rng.normal(size=(1, M))
    single, r = (robot, E_r[0]), lmks[2]
    stacked = (robot, E_r), (np.array([range(r.start, r.stop)]), E_l)
    PHt, one = cross(map, stacked), cross(map, (single, (r, E_l[0])))
    assert np.allclose(PHt, one, atol=1e-14)
    a, b = (
        innovation(z, covariance(PHt, stacked), np.eye(M)),
        innovation(z[0], covariance(one, (single, (r, E_l[0]))), np.eye(M)),
    )
    assert np.allclose(a.Z, b.Z) and np.isclose(a.md2, b.md2)


def test_a_long_run_beside_full_matrices(rng):
    """Predictions, single and joint corrections, births, removals, reparametrisations, in a mixed order; nobody asks
    for the covariance in between, except through ranges."""
    map = FastMap()
    robot = map.add(np.zeros(3), 0.1 * np.eye(3))
    lmks = [map.add(rng.normal(size=2), np.eye(2)) for _ in range(12)]
    dense = Textbook(map.x.copy(), map.P.copy())
    for k in range(60):
        X_x, X_u, U, x = (
            np.eye(3) + 0.1 * rng.normal(size=(3, 3)),
            rng.normal(size=(3, 2)),
            0.01 * np.eye(2),
            rng.normal(size=3),
        )
        predict(map, robot, x, X_x, X_u, U)
        n = map.n
        F, Q, big_x = np.eye(n), np.zeros((n, n)), dense.x.copy()
        F[robot, robot], Q[robot, robot], big_x[robot] = X_x, X_u @ U @ X_u.T, x
        dense.predict(big_x, F, Q)

        some = [lmks[i] for i in rng.choice(len(lmks), 3, replace=False)]
        E_r, E_l, z = rng.normal(size=(3, 2, 3)), rng.normal(size=(3, 2, 2)), rng.normal(size=(3, 2))
        H = np.zeros((3, 2, n))
        for i, r in enumerate(some):
            H[i][:, robot], H[i][:, r] = E_r[i], E_l[i]
        if k % 3 == 0:
            blocks = (robot, E_r[0]), (some[0], E_l[0])
            z, H = z[0], H[:1]
        else:
            blocks = (robot, E_r), (np.array([range(r.start, r.stop) for r in some]), E_l)
        PHt = cross(map, blocks)
        correct(map, PHt, innovation(z, covariance(PHt, blocks), np.eye(2)))
        dense.correct(z.ravel(), H.reshape(-1, n), np.eye(z.size))
        assert np.allclose(map.block(some[0]), dense.P[some[0], some[0]], atol=1e-10)
        assert np.allclose(map.rows(some[1]), dense.P[some[1]], atol=1e-10)
        assert np.allclose(map.state(some[1]), dense.x[some[1]], atol=1e-10)

        if k % 10 == 9:
            L, G = rng.normal(size=(2, 3)), np.zeros((2, n))
            G[:, robot] = L
            l = rng.normal(size=2)
            lmks.append(augment(map, l, [(robot, L)], 0.1 * np.eye(2)))
            dense.augment(l, G, 0.1 * np.eye(2))
    assert map.n == 39 and np.allclose(map.x, dense.x, atol=1e-10)
    assert np.allclose(map.P, dense.P, atol=1e-10) and np.array_equal(map.P, map.P.T)


def test_a_gap_is_filled_while_one_triangle_is_kept(rng):
    """A state in the middle has rows on both sides of the diagonal: both must be new."""
    map = FastMap()
    ranges = [map.add(rng.normal(size=3), np.eye(3)) for _ in range(5)]
    map.P[:] = spread(15, rng)
    blocks = [(ranges[0], rng.normal(size=(2, 3))), (ranges[4], rng.normal(size=(2, 3)))]
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(np.ones(2), covariance(PHt, blocks), np.eye(2)))
    map.remove(ranges[2])
    P = map.P.copy()
    correct(map, PHt := cross(map, blocks), innovation(np.zeros(2), covariance(PHt, blocks), 1e12 * np.eye(2)))
    L = rng.normal(size=(3, 3))
    assert augment(map, np.zeros(3), [(ranges[3], L)], np.eye(3)) == ranges[2]
    P[ranges[2]] = L @ P[ranges[3]]
    P[:, ranges[2]] = P[ranges[2]].T
    P[ranges[2], ranges[2]] = L @ P[ranges[3], ranges[3]] @ L.T + np.eye(3)
    assert np.allclose(map.P, P, atol=1e-9)


def test_large_maps_keep_one_triangle_and_small_ones_both(monkeypatch, rng):
    monkeypatch.undo()
    for n, one in ((fast_map.ONE_TRIANGLE - 2, False), (fast_map.ONE_TRIANGLE + 2, True)):
        map = FastMap()
        r = map.add(np.zeros(n), np.eye(n))
        J = rng.normal(size=(2, n))
        PHt = cross(map, [(r, J)])
        correct(map, PHt, innovation(np.ones(2), covariance(PHt, [(r, J)]), np.eye(2)))
        assert map._lower is one
        want = np.eye(n) - J.T @ np.linalg.solve(J @ J.T + np.eye(2), J)
        assert np.allclose(map.P, want, atol=1e-12) and map._lower is False


def test_a_copy_of_a_map_is_a_map_of_its_own(rng):
    import copy
    import pickle

    map = FastMap()
    r = map.add(np.zeros(3), spread(3, rng))
    for other in (copy.deepcopy(map), pickle.loads(pickle.dumps(map))):
        P, J = other.P.copy(), np.eye(3)
        PHt = cross(other, [(r, J)])
        correct(other, PHt, innovation(np.ones(3), covariance(PHt, [(r, J)]), np.eye(3)))
        assert np.array_equal(map.P, P) and np.array_equal(map.x, np.zeros(3))
        assert np.allclose(other.P, P - P @ np.linalg.solve(P + np.eye(3), P)) and other.add([1.0], [[1.0]]) == slice(
            3, 4
        )
