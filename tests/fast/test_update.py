"""`update` is `cross` to `correct` in one call: on any map, by one measurement or a stack, compiled or not."""

from importlib.util import find_spec

import numpy as np
import pytest

from ekfslam_tutorial.fast import CompressedMap, FastMap, correct, covariance, cross, innovation, update

pytestmark = pytest.mark.usefixtures("triangles")

M, N_LMKS = 2, 12
ROBOT, SENSOR = slice(0, 5), slice(5, 8)  # of the robot's five numbers three are its frame
HEAD = slice(0, 3)

needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba, the extra `compiled`, is not installed")
COMPILED = pytest.mark.parametrize(
    "compiled", [False, pytest.param(True, marks=needs_numba)], ids=["numpy", "compiled"]
)
KINDS = pytest.mark.parametrize(
    "kind", [FastMap, lambda **how: CompressedMap(active=10, **how)], ids=["Map", "CompressedMap"]
)


def four_calls(map, blocks, z, R):
    """What `update` stands for."""
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(z, covariance(PHt, blocks), R))


def agree(scene, blocks, z, R):
    """Return True if one call on one map gives what four give on the other."""
    update(scene.maps[0], blocks, z, R)
    four_calls(scene.maps[1], blocks, z, R)
    return scene.same()


class Scene:
    """Two maps alike: a robot, a sensor and landmarks, all correlated, one removed. Compressed, few are active."""

    def __init__(self, kind, compiled):
        rng = np.random.default_rng(5)
        self.compiled, self.maps = compiled, (kind(compiled=compiled), kind())
        n = SENSOR.stop + 3 * N_LMKS
        A = rng.normal(size=(n, n)) / np.sqrt(n)
        P, x = A @ A.T + 0.1 * np.eye(n), rng.normal(size=n)
        ranges = [ROBOT, SENSOR, *(slice(a, a + 3) for a in range(SENSOR.stop, n, 3))]
        for map in self.maps:
            for r in ranges:
                assert map.add(x[r], P[r, r], P[r, : r.start]) == r
            map.remove(ranges[6])
            four_calls(map, ((HEAD, np.eye(3)), (ranges[3], np.eye(3))), np.zeros(3), np.eye(3))
        self.lmks = ranges[2:6] + ranges[7:]

    def same(self):
        """Return True if both maps hold the same numbers. Without compiled code both do the very same operations.

        Compiled sums have another order: of a few hundred products 1e-11 of the largest number is left.
        """
        (a, b), tolerance = self.maps, 1e-11 if self.compiled else 0.0
        off = [np.abs(c - d).max() / np.abs(d).max() for c, d in ((a.x, b.x), (a.P, b.P))]
        return max(off) <= tolerance and np.array_equal(a.used, b.used)


def one(scene, rng, known, lmk=0):
    """One landmark, as the blocks of an observation are: (rob.r, E_r), (sen.r, E_s), (lmk.r, E_l)."""
    ranges = [None if name in known else r for name, r in zip("rsl", (HEAD, SENSOR, scene.lmks[lmk]), strict=True)]
    return tuple((r, rng.normal(size=(M, 3))) for r in ranges)


def stack(scene, rng, known, some):
    rows = np.array([range(scene.lmks[i].start, scene.lmks[i].stop) for i in some])
    ranges = [None if name in known else r for name, r in zip("rsl", (HEAD, SENSOR, rows), strict=True)]
    return tuple((r, rng.normal(size=(len(some), M, 3))) for r in ranges)


def noise(rng, *shape):
    B = rng.normal(size=(*shape, M, M))
    return B @ np.swapaxes(B, -1, -2) + 0.1 * np.eye(M)


KNOWN = pytest.mark.parametrize(
    "known", ["", "r", "s", "l", "rs", "rl", "sl", "rsl"], ids=lambda k: k or "nothing known"
)


@COMPILED
@KINDS
@KNOWN
def test_one_measurement(kind, compiled, known, rng):
    scene = Scene(kind, compiled)
    for lmk in 1, 8, 0, 8:  # one that is active, and others that are far
        blocks, z, R = one(scene, rng, known, lmk), rng.normal(size=M), noise(rng)
        x = scene.maps[1].x.copy()
        assert agree(scene, blocks, z, R) and np.array_equal(x, scene.maps[1].x) == (known == "rsl")


@COMPILED
@KINDS
@KNOWN
@pytest.mark.parametrize("each", [False, True], ids=["R for all", "R for each"])
@pytest.mark.parametrize("some", [(4,), (3, 0, 7), range(11)], ids=["1", "3", "all"])
def test_a_stack(kind, compiled, known, each, some, rng):
    """In the order in which they are given. With all landmarks a compressed map has more active than it may keep."""
    scene = Scene(kind, compiled)
    for _ in range(2):
        K = len(some)
        blocks, z, R = stack(scene, rng, known, some), rng.normal(size=(K, M)), noise(rng, *[K] * each)
        assert agree(scene, blocks, z, R)


@COMPILED
@KINDS
def test_more_than_compiled_code_takes(kind, compiled, rng):
    """Three shared states; rows that are not the last; 60 numbers at once: then it is the four calls."""
    scene = Scene(kind, compiled)
    a, b, c = (rng.normal(size=(M, 3)) for _ in range(3))
    many = stack(scene, rng, "", [i % 11 for i in range(30)])
    for blocks, z, R in (
        (((HEAD, a), (scene.lmks[0], b), (scene.lmks[5], c)), rng.normal(size=M), noise(rng)),
        (stack(scene, rng, "", (1, 2))[::-1], rng.normal(size=(2, M)), noise(rng)),
        (many, rng.normal(size=(30, M)), noise(rng, 30)),
    ):
        assert agree(scene, blocks, z, R)


@COMPILED
@KINDS
def test_it_is_the_matrix_formula(kind, compiled, rng):
    """K = P H' Z^-1, x + K z, P - K H P, with H written out: 1e-12 for sums of some tens of products."""
    scene = Scene(kind, compiled)
    map, some = scene.maps[0], (3, 0, 7)
    blocks, z, R = stack(scene, rng, "s", some), rng.normal(size=(3, M)), noise(rng, 3)
    x, P = map.x.copy(), map.P.copy()
    H, noises = np.zeros((3 * M, map.n)), np.zeros((3 * M, 3 * M))
    for k in range(3):
        here = slice(M * k, M * k + M)
        H[here, HEAD], H[here, scene.lmks[some[k]]], noises[here, here] = blocks[0][1][k], blocks[2][1][k], R[k]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + noises)
    update(map, blocks, z, R)
    assert np.allclose(map.x, x + K @ z.ravel(), rtol=0, atol=1e-12)
    assert np.allclose(map.P, P - K @ H @ P, rtol=0, atol=1e-12) and np.array_equal(map.P, map.P.T)


BAD = {
    "z is NaN": (np.nan, 1.0, "the innovation must be finite, got"),
    "z is infinite": (-np.inf, 1.0, "the innovation must be finite, got"),
    "R is NaN": (0.1, np.nan, "the innovation covariance must be positive definite, got"),
    "R is below zero": (0.1, -1e3, "the innovation covariance must be positive definite, got"),
}


@COMPILED
@KINDS
@pytest.mark.parametrize("known", ["", "r", "rsl"], ids=lambda k: k or "nothing known")
@pytest.mark.parametrize("K", [0, 3], ids=["one", "stack"])
@pytest.mark.parametrize("bad", BAD)
def test_errors_are_those_of_correct_and_nothing_has_been_changed(kind, compiled, known, K, bad, rng):
    scene, (number, factor, said) = Scene(kind, compiled), BAD[bad]
    blocks = stack(scene, rng, known, (2, 9, 4)) if K else one(scene, rng, known, 9)
    z = rng.normal(size=(K, M) if K else M)
    R = noise(rng, *[K] * bool(K))
    z[..., -1] = number
    R[-1] = factor * R[-1] if K or np.isnan(factor) else R[-1]
    R = R if K else factor * R
    map, twin = scene.maps
    texts = []
    for do, each in (update, map), (four_calls, twin):
        with pytest.raises(ValueError, match=said) as caught:
            do(each, blocks, z, R)
        texts.append(str(caught.value))
    assert compiled or texts[0] == texts[1]
    # in a compressed map states may have become active, and all is settled to show P: rounding
    tolerance = 0.0 if isinstance(map, FastMap) else 1e-13
    for each, fresh in zip(scene.maps, Scene(kind, compiled).maps, strict=True):
        assert np.abs(each.x - fresh.x).max() <= tolerance and np.abs(each.P - fresh.P).max() <= tolerance
    z, R = rng.normal(size=z.shape), noise(rng)
    for do, each in (update, map), (four_calls, twin):  # and the map is as good as before
        do(each, blocks, z, R)
    assert scene.same()


@pytest.mark.parametrize("n", [9, 60], ids=["most of the map", "a small part of it"])
def test_the_part_that_is_carried_leaves_the_rest_right(n):
    """P = T P T' with T = I + D E: of a map that moves with the world, and of a large one of which little does."""
    rng = np.random.default_rng(n)
    map, A = FastMap(), rng.normal(size=(n, n))
    map.add(rng.normal(size=n), A @ A.T)
    r, at, T = slice(2, 4), np.array([0, 1, 2, 3, 7, 8]), np.eye(n)
    D, E, P = rng.normal(size=(6, 1)), rng.normal(size=(1, 2)), map.P.copy()
    T[np.ix_(at, [2, 3])] += D @ E
    map.carry(at, D, r, E)
    np.testing.assert_allclose(map.P, T @ P @ T.T, atol=1e-12 * np.abs(P).max() * n)
