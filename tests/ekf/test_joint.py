"""Several observations in one correction, and long histories, against full matrices."""

import copy
import pickle

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, augment, correct, covariance, cross, innovation, predict, transform, update

from .textbook import Textbook

M = 2  # numbers in an observation


def spread(n, rng):
    A = rng.normal(size=(n, n))
    return A @ A.T / n + 0.1 * np.eye(n)


def big(map, blocks):
    """H, written out."""
    H = np.zeros((len(blocks[0][1]), map.n))
    for r, J in blocks:
        if r is not None:
            H[:, r] += J
    return H


@pytest.mark.parametrize("known", [(), ("robot",), ("sensor",), ("robot", "sensor")])
def test_one_correction_by_several_is_the_textbooks_with_stacked_rows(known, rng):
    """P H' side by side; H P H' from the rows that `covariance` gives of it, each observation's below the other."""
    map = Map()
    ranges = [map.add(rng.normal(size=k), np.eye(k)) for k in (7, 7, *[3] * 10)]
    map.P[:] = spread(map.n, rng)
    robot, sensor = (None if name in known else r for name, r in zip(("robot", "sensor"), ranges, strict=False))
    observations = [
        ((robot, rng.normal(size=(M, 7))), (sensor, rng.normal(size=(M, 7))), (lmk, rng.normal(size=(M, 3))))
        for lmk in ranges[5:9]
    ]
    z, R = rng.normal(size=4 * M), spread(4 * M, rng)
    H = np.vstack([big(map, blocks) for blocks in observations])
    dense = Textbook(map.x, map.P)
    dense.correct(z, H, R)

    PHt = np.hstack([cross(map, blocks) for blocks in observations])
    E = np.vstack([covariance(PHt, blocks) for blocks in observations])
    assert np.allclose(E, H @ map.P @ H.T, atol=1e-12)
    correct(map, PHt, innovation(z, E, R))
    assert np.allclose(map.x, dense.x, atol=1e-11) and np.allclose(map.P, dense.P, atol=1e-11)
    assert np.array_equal(map.P, map.P.T)


def test_a_long_history_beside_full_matrices(rng):
    """Predictions, corrections and births in a mixed order; then a state becomes shorter, and one goes."""
    map = Map()
    robot = map.add(np.zeros(3), 0.1 * np.eye(3))
    lmks = [map.add(rng.normal(size=2), np.eye(2)) for _ in range(12)]
    dense = Textbook(map.x, map.P)
    for k in range(60):
        X_x, X_u, U, x = (
            np.eye(3) + 0.1 * rng.normal(size=(3, 3)),
            rng.normal(size=(3, 2)),
            0.01 * np.eye(2),
            np.ones(3),
        )
        predict(map, robot, x, X_x, X_u, U)
        F, Q, big_x = np.eye(map.n), np.zeros((map.n, map.n)), dense.x.copy()
        F[robot, robot], Q[robot, robot], big_x[robot] = X_x, X_u @ U @ X_u.T, x
        dense.predict(big_x, F, Q)

        z, blocks = rng.normal(size=2), ((robot, rng.normal(size=(2, 3))), (lmks[k % 12], rng.normal(size=(2, 2))))
        H = big(map, blocks)
        update(map, blocks, z, np.eye(2))
        dense.correct(z, H, np.eye(2))
        if k % 10 == 9:
            l, L = rng.normal(size=2), rng.normal(size=(2, 3))
            lmks.append(augment(map, l, [(robot, L)], 0.1 * np.eye(2)))
            dense.augment(l, L @ np.eye(len(dense.x))[robot], 0.1 * np.eye(2))
    assert np.allclose(map.x, dense.x, atol=1e-10) and np.allclose(map.P, dense.P, atol=1e-10)

    T = np.eye(map.n)
    T[9:11, 9:11] = [[1.0, 2.0], [0.0, 0.0]]  # one number instead of the two of a state
    assert transform(map, lmks[3], T[9, 9:11] @ map.x[9:11][:, None], T[9:10, 9:11]) == slice(9, 10)
    map.remove(lmks[6])
    T[lmks[6], lmks[6]] = 0
    dense.predict(T @ dense.x, T, np.zeros_like(T))
    assert map.n == len(dense.x) == 39 and np.allclose(map.x, dense.x, atol=1e-10)
    assert np.allclose(map.P, dense.P, atol=1e-10) and np.array_equal(map.P, map.P.T)


def test_a_gap_in_the_middle_is_filled(rng):
    """Its rows and its columns are new on both sides."""
    map = Map()
    ranges = [map.add(rng.normal(size=3), np.eye(3)) for _ in range(5)]
    map.P[:] = spread(15, rng)
    map.remove(ranges[2])
    P, L = map.P.copy(), rng.normal(size=(3, 3))
    assert augment(map, np.zeros(3), [(ranges[3], L)], np.eye(3)) == ranges[2]
    P[ranges[2]] = L @ P[ranges[3]]
    P[:, ranges[2]] = P[ranges[2]].T
    P[ranges[2], ranges[2]] = L @ P[ranges[3], ranges[3]] @ L.T + np.eye(3)
    assert np.allclose(map.P, P, atol=1e-12)


def test_a_copy_of_a_map_is_a_map_of_its_own(rng):
    map = Map()
    r = map.add(np.zeros(3), spread(3, rng))
    for other in (copy.deepcopy(map), pickle.loads(pickle.dumps(map))):
        P = other.P.copy()
        update(other, [(r, np.eye(3))], np.ones(3), np.eye(3))
        assert np.array_equal(map.P, P) and np.array_equal(map.x, np.zeros(3))
        assert np.allclose(other.P, P - P @ np.linalg.solve(P + np.eye(3), P))
        assert other.add([1.0], [[1.0]]) == slice(3, 4)
