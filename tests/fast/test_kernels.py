"""The loops on the map's storage against the functions of `fast/filter.py`.

A tolerance of 1e-11 of the largest number: sums of a few hundred products, in another order.
"""

import copy
import os
import subprocess
import sys
import textwrap

import numba
import numpy as np
import pytest

from ekfslam_tutorial.fast import (
    FastMap,
    augment,
    correct,
    covariance,
    cross,
    fast_map,
    innovation,
    predict,
    transform,
    update,
)
from ekfslam_tutorial.fast.compiled import filter, kernels, step
from ekfslam_tutorial.fast.compiled.tile import subtract_rows
from ekfslam_tutorial.fast.storage import LINE, WIDTH, aligned, roomy, square, whole
from ekfslam_tutorial.models.motion import Odometry2

N_R, M = 3, 2
KNOWN = [(), ("r",), ("s",), ("r", "s")]


def close(a, b):
    return np.allclose(a, b, rtol=0, atol=1e-11 * np.abs(b).max(initial=1.0))


@pytest.fixture(params=["both", "lower", "large"])
def scene(request, rng, monkeypatch):
    """A map of a robot, a sensor and landmarks, with gaps where some have been removed; r, s, and those that are left.

    Of the covariance both triangles are there, or the upper one is NaN, as if nobody had ever written to it.
    """
    n = 130 if request.param == "large" else 8  # 400 states and more, where a map keeps one triangle by itself
    map = FastMap(compiled=True)
    r, first, s = (
        map.add(rng.normal(size=N_R), np.eye(N_R)),
        map.add(np.ones(2), np.eye(2)),
        map.add(np.ones(3), np.eye(3)),
    )
    lmks = [map.add(rng.normal(size=3), np.eye(3)) for _ in range(n)]
    A = rng.normal(size=map.P.shape) / np.sqrt(map.n)
    map.P[:] = A @ A.T + 0.1 * np.eye(map.n)
    for gone in (first, lmks[2], lmks[n // 2]):
        map.remove(gone)
    del lmks[n // 2], lmks[2]
    if request.param != "both":
        monkeypatch.setattr(fast_map, "ONE_TRIANGLE", 0)
        monkeypatch.setattr(fast_map, "ONE_TRIANGLE_COMPILED", 0, raising=False)
        map._Pn[np.triu_indices(map.n, 1)] = np.nan
        map._lower = True
    return map, r, s, lmks


def plain(map):
    """A copy for the functions that are the measure."""
    other = copy.deepcopy(map)
    assert other._lower == map._lower
    other.compiled = False
    return other


def same(map, other):
    """Return True if two maps hold the same, and both triangles of P, when asked for, are equal to the last bit."""
    return np.array_equal(map.P, map.P.T) and close(map.P, other.P) and close(map.x, other.x)


def test_rows(scene):
    map, r, _, lmks = scene
    x, P, n, lower = map.storage
    out = np.empty((3, n))
    for at in (lmks[0], lmks[-1]):
        kernels.rows_of(P, n, lower, at.start, 3, out)
        assert np.array_equal(out, plain(map).rows(at)) and np.array_equal(out, map.rows(at))
    some = np.array([[lmks[4].start, r.start, n - 1], [0, 1, lmks[0].start]])
    assert np.array_equal(map.rows(some), plain(map).rows(some))
    for wrong in (n, -n - 1):
        with pytest.raises(IndexError):
            map.rows(np.array([[0, wrong]]))


def test_both_triangles(scene):
    map, *_ = scene
    other = plain(map)
    assert np.array_equal(map.P, other.P) and not map._lower


def test_rows_that_are_set(scene, rng):
    map, r, _, lmks = scene
    other, at = plain(map), np.sort([r.start, r.start + 2, lmks[3].start, map.n - 1])
    rows = rng.normal(size=(4, map.n))
    rows[:, at] += rows[:, at].T
    map.overwrite(at, rows)
    other.overwrite(at, rows)
    assert np.array_equal(map.P, other.P) and np.array_equal(map.P[at], rows)


@pytest.mark.parametrize("k", [0, 1, 20, filter.MANY_ROWS + 1])
def test_a_product_that_is_subtracted(scene, k, rng):
    map, *_ = scene
    other, Wt = plain(map), 0.01 * rng.normal(size=(k, map.n))
    map.subtract(Wt)
    other.subtract(Wt)
    assert same(map, other)


def test_a_prediction(scene, rng):
    map, r, s, _ = scene
    for at in (r, s):
        X_x, X_u, B = rng.normal(size=(3, 3)), rng.normal(size=(3, 2)), rng.normal(size=(2, 2))
        X_x[1, 2] = X_x[0, 0] = 0.0
        Q, other = np.empty((3, 3)), plain(map)
        kernels.sandwich(X_u, B @ B.T, Q)
        x, P, n, lower = map.storage
        kernels.propagate(P, n, lower, at.start, X_x, Q)
        predict(other, at, other.x[at].copy(), X_x, X_u, B @ B.T)
        assert close(Q, X_u @ B @ B.T @ X_u.T) and map._lower == other._lower
        assert same(plain(map), plain(other))


def test_a_state_that_is_replaced_by_a_function_of_itself(scene, rng):
    map, *_, lmks = scene
    other, J = plain(map), rng.normal(size=(3, 3))
    x, P, n, lower = map.storage
    kernels.propagate(P, n, lower, lmks[3].start, J, np.zeros((3, 3)))
    transform(other, lmks[3], other.state(lmks[3]), J)
    assert same(map, other)


@pytest.mark.parametrize("known", KNOWN, ids=lambda known: " and ".join(known) + " known")
def test_a_new_state(scene, known, rng):
    map, r, s, _ = scene
    r, s = None if "r" in known else r, None if "s" in known else s
    other, L_r, L_s, B = plain(map), rng.normal(size=(4, 3)), rng.normal(size=(4, 3)), rng.normal(size=(4, 4))
    x, P, n, lower = map.storage
    L = np.concatenate([L_r, L_s], -1)
    P_lm, P_ll = np.full((4, n), np.nan), B @ B.T
    assert kernels.join(P, n, lower, filter.start_of(r), filter.start_of(s), 3, 3, L, P_lm, P_ll)
    assert np.array_equal(P_ll, P_ll.T)
    got = map.insert(np.ones(4), P_ll, P_lm)
    assert got == augment(other, np.ones(4), ((r, L_r), (s, L_s)), B @ B.T)
    assert same(map, other)


def stack(lmks, n_l, some, rng):
    """Landmarks in a stack: where they are, and Jacobians with a few zeros in them."""
    rows = np.array([np.arange(lmk.start, lmk.stop) for lmk in lmks])[:, :n_l]
    J = rng.normal(size=(len(lmks), M, 6 + n_l))
    J[:, 0, 1] = J[0, 1, -1] = 0.0
    return rows, J, list(some)


def blocks_of(r, s, rows, J, found):
    J = J[found]
    return (r, J[..., :3]), (s, J[..., 3:6]), (None if rows is None else rows[found], J[..., 6:])


@pytest.mark.parametrize(
    "known", [*KNOWN, ("l",), ("l", "s"), ("l", "r", "s")], ids=lambda known: " and ".join(known) + " known"
)
def test_expectations(scene, known, rng):
    map, r, s, lmks = scene
    r, s = None if "r" in known else r, None if "s" in known else s
    rows, J, _ = stack(lmks[:5], 3, (), rng)
    rows = None if "l" in known else rows
    x, P, n, lower = map.storage
    cols, at = kernels.columns_of(filter.start_of(r), filter.start_of(s), 3, 3, 3, rows is None)
    E = np.full((5, M, M), np.nan)
    for k in range(5):
        kernels.covariance_of(P, lower, J, cols, at, filter.NO_INDICES if rows is None else rows, k, 6, E[k])
        blocks = [(a, b[0]) for a, b in blocks_of(r, s, None, J, [k])[:2]]
        blocks.append((None if rows is None else lmks[k], J[k, :, 6:]))
        assert close(E[k], covariance(cross(map, blocks), blocks)) and np.array_equal(E[k], E[k].T)


@pytest.mark.parametrize("each", [False, True], ids=["R for all", "R for each"])
@pytest.mark.parametrize("some", [[0], [3, 1, 4], list(range(6))], ids=str)
@pytest.mark.parametrize(
    "known", [*KNOWN, ("l",), ("l", "s"), ("l", "r", "s")], ids=lambda known: " and ".join(known) + " known"
)
def test_corrections(scene, known, some, each, rng):
    map, r, s, lmks = scene
    r, s = None if "r" in known else r, None if "s" in known else s
    rows, J, found = stack(lmks[:6], 3, some, rng)
    rows = None if "l" in known else rows
    B = rng.normal(size=(len(found), M, M)) if each else rng.normal(size=(M, M))
    R, z = B @ np.swapaxes(B, -1, -2) + 0.1 * np.eye(M), 0.1 * rng.normal(size=(len(found), M))
    other, blocks = plain(map), blocks_of(r, s, rows, J, found)
    assert filter.correct_some(map, (r, s, rows), 3, 3, J, found, z, R)
    PHt = cross(other, blocks)
    correct(other, PHt, innovation(z, covariance(PHt, blocks), R))
    assert map._lower == other._lower and same(map, other)
    free = ~map.used
    assert not map.x[free].any() and not map.P[free].any()


@pytest.mark.parametrize("lower", [False, True], ids=["both triangles", "one triangle"])
@pytest.mark.parametrize("m", [1, 2, 7, 20])
@pytest.mark.parametrize("n", [1, 7, 8, 9, 31, 64, 103])
def test_tiles(n, m, lower, rng):
    """P - W W' of the first n rows and columns; the storage around them stays as it is."""
    P, size = square(roomy(n)), -(-n // LINE) * LINE
    P[:] = rng.normal(size=P.shape)
    before, Wt = P.copy(), np.zeros((m, size))
    Wt[:, :n] = rng.normal(size=(m, n))
    kernels.downdate(P, Wt, n, lower)
    expected = before[:n, :n] - Wt[:, :n].T @ Wt[:, :n]
    assert close(np.tril(P[:n, :n]), np.tril(expected)) and (lower or close(P[:n, :n], expected))
    before[:n, :n] = P[:n, :n] = 0
    assert np.array_equal(P, before)


@pytest.mark.parametrize("size", [1, 3, 21])
@pytest.mark.parametrize("k", [1, 7, 8, 30])
@pytest.mark.parametrize("n", [1, 8, 31, 103])
def test_product_in_tiles(n, k, size, rng):
    """X P of the first rows and columns of P: those behind them hold anything."""
    X, P = rng.normal(size=(k, size)), rng.normal(size=(size + 4, whole(n)))
    Xt, out = np.zeros((size, 8 * -(-k // 8))), np.empty((k + 8, whole(n)))
    Xt[:, :k] = X.T
    kernels.product(Xt, P[:size], n, out)
    assert close(out[:k, :n], X @ P[:size, :n])


def test_tiles_of_a_processor_with_fewer_registers(tmp_path):
    """The same products, by the other width of a tile, in a process that is told so."""
    program = """
        import llvmlite.binding
        import numpy as np
        features = llvmlite.binding.get_host_cpu_features() | {"avx512f": False}
        llvmlite.binding.get_host_cpu_features = lambda: llvmlite.binding.FeatureMap(features)
        from ekfslam_tutorial.fast.compiled import kernels
        assert kernels.COLUMNS == 4
        rng = np.random.default_rng(0)
        P, Wt = np.zeros((40, 40), order="F"), rng.normal(size=(5, 32))
        for lower in True, False:
            P[:] = 0
            kernels.downdate(P, Wt, 32, lower)
            keep = np.tril if lower else np.asarray
            assert np.abs(keep(P[:32, :32] + Wt.T @ Wt)).max() < 1e-13 and not P[32:].any() and not P[:, 32:].any()
        X, out = rng.normal(size=(8, 5)), np.empty((8, 32))
        kernels.product(np.ascontiguousarray(X.T), Wt, 30, out)
        assert np.abs(out[:, :30] - X @ Wt[:, :30]).max() < 1e-13
    """
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True, env=environment)


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("n", [0, 1, 5, 40])
def test_rows_in_registers(n, order, rng):
    """A row minus a combination of n others, also of the same matrix; all around it stays as it is."""
    A, H = rng.normal(size=(41, 3 * WIDTH)), np.array(rng.normal(size=(41, 50)), order=order)
    expected, turn = A.copy(), slice(WIDTH, 2 * WIDTH)
    expected[40, turn] = 0.7 * (A[40, turn] - H[40, :n] @ A[:n, turn])
    row_minus(A, 40, WIDTH, H, A, n, 0.7)
    assert close(A[40, turn], expected[40, turn])
    A[40, turn] = expected[40, turn]
    assert np.array_equal(A, expected)


@numba.njit
def row_minus(out, i, j, H, rows, n, factor):
    subtract_rows(out, i, j, H, rows, n, factor)


@pytest.mark.parametrize("m", [1, 2, 20, 31, 32, 33, 150])
@pytest.mark.parametrize("first", [0, WIDTH, 3 * WIDTH])
def test_elimination(m, first, rng):
    """L^-1 A, for as many rows as there are, before and after the rows are longer than one turn."""
    A, B = np.zeros((m, first + whole(m + 1))), rng.normal(size=(m, m))
    Z, A[:, :first] = B @ B.T + np.eye(m), rng.normal(size=(m, first))
    A[:, first : first + m], A[:, first + m] = Z, rng.normal(size=m)
    expected = np.linalg.solve(np.linalg.cholesky(Z), A)
    assert kernels.eliminate(A, first) and close(A, expected)
    A[:, first : first + m] = Z - 2 * np.linalg.eigvalsh(Z)[0] * np.eye(m)
    assert not kernels.eliminate(A, first)


@pytest.mark.parametrize("n", [1, 8, 31, 32, 33, 203])
def test_rows_of_zeros_begin_with_a_line(n):
    """Of all rows that are whole lines, whoever asks, numpy or the loops."""
    for function in aligned, kernels.aligned:
        A = function(5, whole(n) + LINE)
        assert A.flags.c_contiguous and not A.any() and A.ctypes.data % (8 * LINE) == A.strides[0] % (8 * LINE) == 0
    assert whole(n) == kernels.whole(n) == WIDTH * np.ceil(n / WIDTH)


def test_many_rows_are_left_to_blas(rng):
    map = FastMap(compiled=True)
    r = map.add(rng.normal(size=3), np.eye(3))
    rows = np.array([np.arange(a.start, a.stop) for a in (map.add(np.ones(2), np.eye(2)) for _ in range(4))])
    z, J = np.zeros((filter.MANY_ROWS + 1, 1)), rng.normal(size=(4, 2, 8))
    assert not filter.correct_some(map, (r, None, rows), 3, 3, J, [0, 1, 2, 3], z, np.eye(2))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_innovation_that_is_not_finite_changes_nothing(scene, bad, rng):
    map, r, s, lmks = scene
    rows, J, found = stack(lmks[:6], 3, [1, 2], rng)
    x, before = map.x.copy(), plain(map).P
    z = np.array([[0.1, 0.2], [bad, 0.0]])
    assert not filter.correct_some(map, (r, s, rows), 3, 3, J, found, z, np.eye(M))  # numpy says what is wrong
    assert np.array_equal(map.x, x) and np.array_equal(map.P, before)


def test_a_state_of_the_wrong_length_is_not_moved_with_its_neighbour():
    map = FastMap(compiled=True)
    short = map.add(np.zeros(2), np.eye(2))
    map.add(np.ones(3), np.eye(3))
    assert not step.move(map, short, Odometry2(), np.ones(3), np.eye(3), 0.1)
    assert np.array_equal(map.x, [0, 0, 1, 1, 1]) and np.array_equal(map.P, np.eye(5))


# --- by blocks, as users of the filter give them ---------------------------------------------------------------------


def test_predict_is_compiled(scene, rng):
    map, r, *_ = scene
    other, X_x, X_u, B, x = plain(map), *(rng.normal(size=s) for s in ((3, 3), (3, 2), (2, 2), 3))
    other.compiled = False
    X_x.flags.writeable = False
    for each in map, other:
        predict(each, r, x, X_x, np.asfortranarray(X_u), B @ B.T)
    assert same(map, other)


@pytest.mark.parametrize("how", ["one", "one, robot known", "stack", "stack, sensor too", "stack, landmarks known"])
def test_update_is_compiled(scene, how, rng, monkeypatch):
    map, r, s, lmks = scene
    rows, J, _ = stack(lmks[:6], 3, (), rng)
    z, R = 0.1 * rng.normal(size=(6, M)), np.eye(M)
    blocks = {
        "one": ((r, J[0, :, :3]), (lmks[0], J[0, :, 6:])),
        "one, robot known": ((None, J[0, :, :3]), (lmks[0], J[0, :, 6:])),
        "stack": ((r, J[..., :3]), (rows, J[..., 6:])),
        "stack, sensor too": ((r, J[..., :3]), (s, J[..., 3:6]), (rows, J[..., 6:])),
        "stack, landmarks known": ((r, J[..., :3]), (None, J[..., 6:])),
    }[how]
    other, z = plain(map), z[0] if how.startswith("one") else z
    update(other, blocks, z, R)
    assert filter.update(map, blocks, z, R)
    assert map._lower == other._lower and same(map, other)


@pytest.mark.parametrize("wrong", ["J", "rows", "R", "z", "range", "X_x", "x"])
def test_what_does_not_fit_is_refused_as_ever_and_changes_nothing(scene, wrong, rng):
    """Loops do not look where they write: whatever does not fit is left to numpy, which does."""
    map, r, _, lmks = scene
    rows, J, _ = stack(lmks[:6], 3, (), rng)
    z, R, J_r, J_l = np.ones((6, M)), np.eye(M), J[..., :3], J[..., 6:]
    x, before = map.x.copy(), plain(map).P
    X_x = np.eye(4) if wrong == "X_x" else np.eye(3)
    if wrong in ("X_x", "x"):
        with pytest.raises(ValueError):
            predict(map, r, np.zeros(4 if wrong == "x" else 3), X_x, np.eye(3), np.eye(3))
    else:
        J_l = J_l[..., :2] if wrong == "J" else J_l
        rows = rows + map.n if wrong == "rows" else rows
        R = np.eye(3) if wrong == "R" else R
        z = np.ones((6, 3)) if wrong == "z" else z
        r = slice(r.start, r.stop + 2) if wrong == "range" else r
        with pytest.raises((ValueError, IndexError)):
            update(map, ((r, J_r), (rows, J_l)), z, R)
    assert np.array_equal(map.x, x) and np.array_equal(map.P, before)
