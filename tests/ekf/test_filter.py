"""The filter operations, each against the matrix formula it stands for."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import (
    Innovation,
    Map,
    MapFull,
    augment,
    correct,
    covariance,
    cross,
    innovation,
    predict,
    transform,
    update,
)

from .textbook import Textbook

SIZES = (7, 6, 3, 4, 2)


def spread(n, rng):
    A = rng.normal(size=(n, n))
    return A @ A.T + 0.1 * np.eye(n)


@pytest.fixture
def scene(rng):
    """A correlated map of five states, of which the third has been removed again, and the ranges of the others."""
    map = Map()
    ranges = [map.add(rng.normal(size=k), np.eye(k)) for k in SIZES]
    map.P[:] = spread(map.n, rng)
    map.remove(ranges.pop(2))
    return map, ranges


def selection(map, r):
    """The matrix that takes a range out of the state."""
    return np.eye(map.n)[r]


def unchanged(before, after, *ranges):
    """Whether two covariances agree, bit by bit, outside the rows and columns of some ranges."""
    keep = np.ones(len(before), bool)
    for r in ranges:
        keep[r] = False
    return np.array_equal(before[np.ix_(keep, keep)], after[np.ix_(keep, keep)])


@pytest.mark.parametrize("known", [(), (0,), (1,), (0, 1)])
def test_cross_and_covariance_are_block_products(scene, known, rng):
    map, ranges = scene
    blocks = [(None if i in known else ranges[i], rng.normal(size=(2, SIZES[i]))) for i in (0, 1)]
    H = sum((J @ selection(map, r) for r, J in blocks if r is not None), start=np.zeros((2, map.n)))
    PHt = cross(map, blocks)
    assert PHt.shape == (map.n, 2) and np.allclose(PHt, map.P @ H.T)
    assert np.allclose(covariance(PHt, blocks), H @ map.P @ H.T)


@pytest.mark.parametrize("known", [(), (0,), (1,)])
def test_a_correction_is_that_of_the_textbook(scene, known, rng):
    map, ranges = scene
    blocks = [(None if i in known else ranges[i], rng.normal(size=(2, SIZES[i]))) for i in (0, 1)]
    H = sum((J @ selection(map, r) for r, J in blocks if r is not None), start=np.zeros((2, map.n)))
    z, R = rng.normal(size=2), np.array([[0.5, 0.2], [0.2, 0.4]])
    dense = Textbook(map.x.copy(), map.P.copy())
    dense.correct(z, H, R)
    PHt = cross(map, blocks)
    inn = innovation(z, covariance(PHt, blocks), R)
    correct(map, PHt, inn)
    assert np.allclose(map.x, dense.x, atol=1e-12) and np.allclose(map.P, dense.P, atol=1e-11)
    assert np.array_equal(map.P, map.P.T)
    assert inn.md2 == pytest.approx(z @ np.linalg.solve(inn.Z, z))


def test_a_correction_of_what_is_known_changes_nothing(scene, rng):
    map, _ = scene
    x, P = map.x.copy(), map.P.copy()
    blocks = [(None, rng.normal(size=(2, 7)))]
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(np.ones(2), covariance(PHt, blocks), np.eye(2)))
    assert np.array_equal(map.x, x) and np.array_equal(map.P, P)


@pytest.mark.parametrize(
    "z, Z, said",
    [
        ([0.0, 0.0], np.diag([1.0, -1.0]), "innovation covariance must be positive definite, got .*-1.0"),
        ([0.0, 0.0], np.diag([1.0, np.nan]), "innovation covariance must be positive definite, got .*nan"),
        ([0.0, np.nan], np.eye(2), "innovation must be finite, got .*nan"),
    ],
)
def test_a_bad_innovation_is_named_and_nothing_is_changed(scene, z, Z, said):
    map, _ = scene
    x, P = map.x.copy(), map.P.copy()
    with pytest.raises(ValueError, match=said):
        correct(map, np.ones((map.n, 2)), Innovation(np.array(z), Z))
    assert np.array_equal(map.x, x) and np.array_equal(map.P, P)


def test_a_prediction_is_that_of_the_textbook_and_touches_its_blocks_only(scene, rng):
    map, ranges = scene
    r, x = ranges[0], rng.normal(size=7)
    X_x, X_u, U = rng.normal(size=(7, 7)), rng.normal(size=(7, 3)), spread(3, rng)
    before_x, before = map.x.copy(), map.P.copy()
    predict(map, r, x, X_x, X_u, U)

    S = selection(map, r)
    F = np.eye(map.n) + S.T @ (X_x - np.eye(7)) @ S
    assert np.allclose(map.P, F @ before @ F.T + S.T @ X_u @ U @ X_u.T @ S)
    assert np.array_equal(map.x[r], x) and np.array_equal(np.delete(map.x, range(7)), np.delete(before_x, range(7)))
    assert unchanged(before, map.P, r) and np.array_equal(map.P, map.P.T)


@pytest.mark.parametrize("r", [slice(40, 43), slice(3, 6), slice(-3, 0), slice(3, 3)], ids=str)
def test_a_range_outside_the_map_does_not_move(r):
    map = Map()
    for k in 3, 2:
        map.add(np.ones(k), np.eye(k))
    with pytest.raises(ValueError, match=f"range {r.start}:{r.stop} is not in this map of 5 states"):
        predict(map, r, np.zeros(3), np.eye(3), np.eye(3), np.eye(3))
    assert np.array_equal(map.x, np.ones(5)) and np.array_equal(map.P, np.eye(5))


def some(a, i, number):
    a = np.array(a)
    a.flat[i] = number
    return a


@pytest.mark.parametrize(
    "name, value, said",
    [
        ("x", np.ones(1), r"shapes \(3,\), \(3, 3\), \(3, nu\), \(nu, nu\), got \(1,\), \(3, 3\), \(3, 2\), \(2, 2\)"),
        ("X_x", np.eye(4, 3), "must have shapes"),
        ("X_u", np.ones((1, 2)), "must have shapes"),
        ("X_u", np.ones((3, 3)), "must have shapes"),
        ("U", np.ones(2), "must have shapes"),
        ("U", np.ones((2, 3)), "must have shapes"),
        *(("x", some(np.ones(3), 1, bad), "must stay finite") for bad in (np.nan, np.inf)),
        *(("X_x", some(np.eye(3), i, np.nan), "must stay finite") for i in (0, 5, 7)),
        *(("X_u", some(np.ones((3, 2)), i, np.inf), "must stay finite") for i in (0, 5)),
        *(("U", some(np.eye(2), i, bad), "must stay finite") for i in (0, 1, 3) for bad in (np.nan, -np.inf)),
    ],
)
def test_a_motion_that_does_not_fit_or_is_not_finite_is_refused(name, value, said):
    map = Map()
    r = map.add(np.ones(3), np.eye(3))
    map.add(np.ones(2), np.eye(2))
    motion = dict(x=np.zeros(3), X_x=np.eye(3), X_u=np.ones((3, 2)), U=np.eye(2)) | {name: value}
    with pytest.raises(ValueError, match=said), np.errstate(invalid="ignore"):
        predict(map, r, **motion)
    assert np.array_equal(map.x, np.ones(5)) and np.array_equal(map.P, np.eye(5))


@pytest.mark.parametrize(
    "z, R, said",
    [
        ([0.1, 0.2], 0.1, r"R must have shape \(2, 2\), got \(\)"),
        ([0.1, 0.2], [0.1, 0.1], r"R must have shape \(2, 2\), got \(2,\)"),
        ([0.1, 0.2], [np.eye(2)], r"R must have shape \(2, 2\), got \(1, 2, 2\)"),
    ],
)
def test_noise_of_another_shape_is_refused(z, R, said):
    z = np.array(z)
    map = Map()
    r = map.add(np.ones(3), np.eye(3))
    with pytest.raises(ValueError, match=said):
        innovation(z, np.eye(z.size), R)
    with pytest.raises(ValueError, match=said):
        update(map, ((r, np.ones((*z.shape, 3))),), z, R)
    assert np.array_equal(map.x, np.ones(3)) and np.array_equal(map.P, np.eye(3))


def test_vectors_and_noise_may_be_lists():
    maps = Map(), Map()
    for map, form in zip(maps, (np.array, list), strict=True):
        r = map.add(np.ones(3), np.eye(3))
        new = augment(map, form([1.0, 2.0]), ((r, np.eye(2, 3)),), form([[1.0, 0.0], [0.0, 1.0]]))
        update(map, ((r, np.eye(2, 3)), (new, np.eye(2))), form([0.1, 0.2]), form([[1.0, 0.0], [0.0, 1.0]]))
    assert np.array_equal(maps[0].x, maps[1].x) and np.array_equal(maps[0].P, maps[1].P)


@pytest.mark.parametrize("Q, J", [(0.1, np.eye(2, 3)), (np.ones(2), np.eye(2, 3)), (np.eye(2), np.ones((1, 3)))])
def test_a_new_state_of_shapes_that_do_not_fit_is_refused(Q, J):
    map = Map()
    r = map.add(np.ones(3), np.eye(3))
    with pytest.raises(ValueError, match=r"a new state of shape \(2,\) needs L_x P L_x' and Q of \(2, 2\), got"):
        augment(map, np.zeros(2), ((r, J),), Q)
    assert map.n == 3


def test_a_new_state_of_a_known_robot_is_the_lectures(scene, rng):
    """P = [[P, 0], [0, Lz Q Lz']]: nothing is in common with the map."""
    map, _ = scene
    P, l, Lz, Q = map.P.copy(), rng.normal(size=2), rng.normal(size=(2, 2)), spread(2, rng)
    n = map.n
    map.remove(slice(n - 2, n))  # the gap inside is of 3 states: a state of 4 goes to the end
    Lz, Q, l = rng.normal(size=(4, 2)), spread(2, rng), rng.normal(size=4)
    P = map.P.copy()
    r = augment(map, l, [(None, rng.normal(size=(4, 7)))], Lz @ Q @ Lz.T)
    block = np.block([[P[: r.start, : r.start], np.zeros((r.start, 4))], [np.zeros((4, r.start)), Lz @ Q @ Lz.T]])
    assert np.allclose(map.P[: r.stop, : r.stop], block) and np.array_equal(map.x[r], l)


def test_a_new_state_of_an_estimated_robot_is_the_block_formula(scene, rng):
    """P = [[P, P Lx'], [Lx P, Lx P Lx' + Lz Q Lz']], with robot and sensor in the map."""
    map, ranges = scene
    L = [rng.normal(size=(5, SIZES[i])) for i in (0, 1)]
    Q, l = spread(5, rng), rng.normal(size=5)
    P, n = map.P.copy(), map.n
    Lx = L[0] @ selection(map, ranges[0]) + L[1] @ selection(map, ranges[1])
    r = augment(map, l, [(ranges[0], L[0]), (ranges[1], L[1])], Q)
    assert r == slice(n, n + 5)
    assert np.allclose(map.P, np.block([[P, P @ Lx.T], [Lx @ P, Lx @ P @ Lx.T + Q]]))
    assert np.array_equal(map.P[:n, :n], P) and np.array_equal(map.P, map.P.T)


def test_a_new_state_may_fill_a_gap(scene, rng):
    map, ranges = scene
    L = rng.normal(size=(3, 7))
    P, n = map.P.copy(), map.n
    r = augment(map, np.zeros(3), [(ranges[0], L)], np.eye(3))
    assert r == slice(13, 16) and map.n == n
    want = P.copy()
    want[r] = L @ P[ranges[0]]
    want[:, r] = want[r].T
    want[r, r] = L @ P[ranges[0], ranges[0]] @ L.T + np.eye(3)
    assert np.allclose(map.P, want)


def test_a_full_map_takes_nothing_and_loses_nothing(rng):
    map = Map(capacity=8)
    r = map.add(rng.normal(size=7), spread(7, rng))
    before = map.x.copy(), map.P.copy(), map.used.copy()
    with pytest.raises(MapFull, match="7 of 8 states are in use, a new state needs 2 more"):
        augment(map, np.zeros(2), [(r, np.ones((2, 7)))], np.eye(2))
    after = map.x, map.P, map.used
    assert map.n == 7 and all(np.array_equal(a, b) for a, b in zip(after, before, strict=True))


def test_a_transformation_is_the_block_formula(scene, rng):
    """Six numbers become three, as when an inverse-depth point becomes Euclidean; the other three are free."""
    map, ranges = scene
    r, J, x = ranges[1], rng.normal(size=(3, 6)), rng.normal(size=3)
    before = map.P.copy()
    head = transform(map, r, x, J)
    T = np.eye(map.n)
    T[r] = 0
    T[head, r] = J
    assert head == slice(7, 10) and np.allclose(map.P, T @ before @ T.T) and np.array_equal(map.x[head], x)
    assert not map.used[10:13].any() and not map.P[10:13].any() and not map.x[10:13].any()
    assert unchanged(before, map.P, r)


def test_a_transformation_of_the_same_size_keeps_the_range(scene, rng):
    map, ranges = scene
    assert transform(map, ranges[0], np.zeros(7), np.eye(7)) == ranges[0]


def test_free_states_take_part_in_nothing(scene, rng):
    """A removed state is a zero row and column before and after every operation on the others."""
    map, ranges = scene
    free = slice(13, 16)
    predict(map, ranges[0], np.ones(7), rng.normal(size=(7, 7)), np.eye(7), np.eye(7))
    blocks = [(ranges[0], rng.normal(size=(2, 7))), (ranges[1], rng.normal(size=(2, 6)))]
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(np.ones(2), covariance(PHt, blocks), np.eye(2)))
    transform(map, ranges[0], np.ones(7), rng.normal(size=(7, 7)))
    assert not map.P[free].any() and not map.P[:, free].any() and not map.x[free].any()


# --- reduction: a linear model ---------------------------------------------------------------------------------------


def test_a_linear_model_gives_the_kalman_filter_and_that_gives_least_squares(rng):
    """A point with constant velocity, its position measured. The filter's last estimate is the batch solution of all
    measurements and all motions together, with the inverse of the normal matrix as covariance."""
    F, Q, H, R = np.array([[1, 0.1], [0, 1]]), np.diag([1e-4, 1e-3]), np.array([[1.0, 0.0]]), np.array([[0.04]])
    P0, n = np.diag([1.0, 2.0]), 15
    ys = rng.normal(size=(n, 1))

    map = Map()
    r = map.add([0.5, -0.2], P0)
    kalman = Textbook([0.5, -0.2], P0)
    rows, right, weight = [np.eye(2, 2 * n + 2)], [np.array([0.5, -0.2])], [np.linalg.inv(P0)]
    for k, y in enumerate(ys):
        predict(map, r, F @ map.x[r], F, np.eye(2), Q)
        PHt = cross(map, [(r, H)])
        correct(map, PHt, innovation(y - H @ map.x[r], covariance(PHt, [(r, H)]), R))

        kalman.predict(F @ kalman.x, F, Q)
        kalman.correct(y - H @ kalman.x, H, R)

        now, then = slice(2 * k + 2, 2 * k + 4), slice(2 * k, 2 * k + 2)
        A, B = np.zeros((2, 2 * n + 2)), np.zeros((1, 2 * n + 2))
        A[:, now], A[:, then], B[:, now] = np.eye(2), -F, H
        rows += [A, B]
        right += [np.zeros(2), y]
        weight += [np.linalg.inv(Q), np.linalg.inv(R)]
    normal = sum(A.T @ W @ A for A, W in zip(rows, weight, strict=True))
    batch = np.linalg.solve(normal, sum(A.T @ W @ b for A, W, b in zip(rows, weight, right, strict=True)))

    assert np.allclose(map.x, kalman.x, atol=1e-13) and np.allclose(map.P, kalman.P, atol=1e-13)
    assert np.allclose(map.x, batch[-2:], atol=1e-10)
    assert np.allclose(map.P, np.linalg.inv(normal)[-2:, -2:], atol=1e-10)


def test_many_corrections_keep_a_covariance(rng):
    """Symmetric to the last bit and without a negative eigenvalue, after a thousand exact measurements of one thing."""
    map = Map()
    map.add(np.zeros(12), 100 * spread(12, rng))
    for _ in range(1000):
        H = rng.normal(size=(2, 12))
        blocks = [(slice(0, 12), H)]
        PHt = cross(map, blocks)
        correct(map, PHt, innovation(0.01 * rng.normal(size=2), covariance(PHt, blocks), 1e-4 * np.eye(2)))
    assert np.array_equal(map.P, map.P.T) and np.linalg.eigvalsh(map.P)[0] > 0
