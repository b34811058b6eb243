"""`update` is `cross` to `correct` in one call."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import Map, correct, covariance, cross, innovation, update

M = 2
ROBOT, SENSOR, LMK = slice(0, 3), slice(3, 6), slice(6, 9)
KNOWN = pytest.mark.parametrize(
    "known", ["", "r", "s", "l", "rs", "rl", "sl", "rsl"], ids=lambda k: k or "nothing known"
)


def correlated_map(rng):
    map = Map()
    for r in ROBOT, SENSOR, LMK:
        map.add(rng.normal(size=r.stop - r.start), np.eye(r.stop - r.start))
    A = rng.normal(size=(9, 9))
    map.P[:] = A @ A.T / 9 + 0.1 * np.eye(9)
    return map


def blocks_of(rng, known):
    ranges = [None if name in known else r for name, r in zip("rsl", (ROBOT, SENSOR, LMK), strict=True)]
    return tuple((r, rng.normal(size=(M, 3))) for r in ranges)


def noise(rng):
    B = rng.normal(size=(M, M))
    return B @ B.T + 0.1 * np.eye(M)


@KNOWN
def test_it_is_the_four_calls_and_the_matrix_formula(known, rng):
    """K = P H' Z^-1, x + K z, P - K H P, with H written out: 1e-12 for sums of some tens of products."""
    maps = [correlated_map(np.random.default_rng(5)) for _ in range(2)]
    x, P = maps[0].x.copy(), maps[0].P.copy()
    blocks, z, R = blocks_of(rng, known), rng.normal(size=M), noise(rng)
    update(maps[0], blocks, z, R)
    PHt = cross(maps[1], blocks)
    correct(maps[1], PHt, innovation(z, covariance(PHt, blocks), R))
    assert np.array_equal(maps[0].x, maps[1].x) and np.array_equal(maps[0].P, maps[1].P)

    H = np.zeros((M, 9))
    for r, J in blocks:
        if r is not None:
            H[:, r] = J
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    assert np.allclose(maps[0].x, x + K @ z, rtol=0, atol=1e-12)
    assert np.allclose(maps[0].P, P - K @ H @ P, rtol=0, atol=1e-12)
    assert np.array_equal(x, maps[0].x) == (known == "rsl")


@pytest.mark.parametrize("known", ["", "r", "rsl"], ids=lambda k: k or "nothing known")
@pytest.mark.parametrize(
    ("number", "factor", "said"),
    [
        (np.nan, 1.0, "the innovation must be finite, got"),
        (-np.inf, 1.0, "the innovation must be finite, got"),
        (0.1, np.nan, "the innovation covariance must be positive definite, got"),
        (0.1, -1e3, "the innovation covariance must be positive definite, got"),
    ],
)
def test_nothing_is_changed_by_what_is_refused(known, number, factor, said, rng):
    map = correlated_map(rng)
    x, P = map.x.copy(), map.P.copy()
    with pytest.raises(ValueError, match=said):
        update(map, blocks_of(rng, known), np.array([0.2, number]), factor * noise(rng))
    assert np.array_equal(map.x, x) and np.array_equal(map.P, P)
