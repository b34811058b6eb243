"""Many runs at once give what each gives alone: the plain filter is the oracle."""

import numpy as np
import pytest

from ekfslam_tutorial.ekf import carry
from ekfslam_tutorial.fast import Batch, FastMap, augment, correct, covariance, cross, innovation, predict

RUNS, ROB = 7, slice(0, 3)
EXACT = {"rtol": 0, "atol": 1e-12}  # sums in another order: rounding of numbers of size 1, over 30 operations


def covariances(rng, *shape):
    A = rng.normal(size=(*shape, shape[-1])) / np.sqrt(shape[-1])
    return A @ np.swapaxes(A, -1, -2) + 0.1 * np.eye(shape[-1])


def both(rng, n=9):
    """A batch, and the same as maps of their own."""
    x, P = rng.normal(size=(RUNS, n)), covariances(rng, RUNS, n)
    maps = []
    for x_i, P_i in zip(x, P, strict=True):
        maps.append(FastMap())
        maps[-1].add(x_i, P_i)
    return Batch(x, P), maps


def assert_same(batch, maps):
    for x, P, map in zip(batch.x, batch.P, maps, strict=True):
        np.testing.assert_allclose(x, map.x, **EXACT)
        np.testing.assert_allclose(P, map.P, **EXACT)
    np.testing.assert_array_equal(batch.P, np.swapaxes(batch.P, -1, -2))


def each(a, i, ndim):
    """What run i gets of an array that may be for all runs."""
    return a[i] if a.ndim > ndim else a


@pytest.mark.parametrize("own", [(), (RUNS,)], ids=["for all runs", "each its own"])
@pytest.mark.parametrize("m", [1, 2, 3])
def test_predict_and_correct_are_those_of_the_filter(rng, own, m):
    batch, maps = both(rng)
    for _ in range(30):
        x, U = rng.normal(size=(RUNS, 3)), covariances(rng, *own, 2)
        X_x, X_u = rng.normal(size=(*own, 3, 3)) / 2, rng.normal(size=(*own, 3, 2))
        E_r, E_l, R = rng.normal(size=(*own, m, 3)), rng.normal(size=(*own, m, 2)), covariances(rng, *own, m)
        z, l = rng.normal(size=(RUNS, m)), slice(5, 7)
        batch.predict(ROB, x, X_x, X_u, U)
        batch.correct(((ROB, E_r), (None, E_r), (l, E_l)), z, R)
        for i, map in enumerate(maps):
            predict(map, ROB, x[i], each(X_x, i, 2), each(X_u, i, 2), each(U, i, 2))
            blocks = (ROB, each(E_r, i, 2)), (l, each(E_l, i, 2))
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(z[i], covariance(PHt, blocks), each(R, i, 2)))
        assert_same(batch, maps)


@pytest.mark.parametrize("k", [1, 3])
def test_the_covariance_is_carried_along_as_in_the_filter(rng, k):
    """Some states stay where they are, in all runs or in some; and so do all states in some of the directions."""
    batch, maps = both(rng)
    before, after = rng.normal(size=(2, RUNS, 9, k))
    after[:, 4:6], after[:3, 8] = before[:, 4:6], before[:3, 8]
    if k > 1:
        after[..., 1] = before[..., 1]
    batch.carry(slice(1, 5), before, after)
    batch.carry(slice(1, 5), before, before)  # nothing has moved
    for map, B, B2 in zip(maps, before, after, strict=True):
        carry(map, slice(1, 5), B, B2)
    assert_same(batch, maps)


def test_each_run_may_see_another_landmark_or_none(rng):
    batch, maps = both(rng)
    which, sees = rng.integers(0, 3, RUNS), np.arange(RUNS) != 2
    rows = (3 + 2 * which)[:, None] + np.arange(2)
    E_r, E_l = rng.normal(size=(RUNS, 2, 3)) * sees[:, None, None], rng.normal(size=(RUNS, 2, 2)) * sees[:, None, None]
    z, R = rng.normal(size=(RUNS, 2)) * sees[:, None], covariances(rng, 2)
    batch.correct(((ROB, E_r), (rows, E_l)), z, R)
    for i in np.flatnonzero(sees):
        blocks = (ROB, E_r[i]), (slice(rows[i, 0], rows[i, 0] + 2), E_l[i])
        PHt = cross(maps[i], blocks)
        correct(maps[i], PHt, innovation(z[i], covariance(PHt, blocks), R))
    assert_same(batch, maps)
    assert np.array_equal(batch.x[2], maps[2].x) and np.array_equal(batch.P[2], maps[2].P)  # to the last bit


def test_some_runs_get_a_new_state(rng):
    x, P = np.zeros((RUNS, 5)), np.zeros((RUNS, 5, 5))
    x[:, :3], P[:, :3, :3] = rng.normal(size=(RUNS, 3)), covariances(rng, RUNS, 3)
    batch, runs = Batch(x, P), np.array([0, 3, 4])
    l, L_r, Q = rng.normal(size=(3, 2)), rng.normal(size=(3, 2, 3)), covariances(rng, 3, 2)
    batch.augment(slice(3, 5), runs, l, ((ROB, L_r), (None, L_r)), Q)
    for k, i in enumerate(runs):
        map = FastMap()
        map.add(x[i, :3], P[i, :3, :3])
        augment(map, l[k], ((ROB, L_r[k]),), Q[k])
        np.testing.assert_allclose(batch.x[i], map.x, **EXACT)
        np.testing.assert_allclose(batch.P[i], map.P, **EXACT)
    others = np.setdiff1d(np.arange(RUNS), runs)
    assert np.array_equal(batch.x[others], x[others]) and np.array_equal(batch.P[others], P[others])


def test_a_large_batch_is_corrected_in_parts(rng, monkeypatch):
    monkeypatch.setattr("ekfslam_tutorial.fast.batch.RUNS_AT_A_TIME", 3)
    (batch, _), z, H = both(rng), rng.normal(size=(RUNS, 2)), rng.normal(size=(2, 3))
    whole = Batch(batch.x, batch.P)
    batch.correct(((ROB, H),), z, np.eye(2))
    monkeypatch.undo()
    whole.correct(((ROB, H),), z, np.eye(2))
    assert np.array_equal(batch.P, whole.P) and np.array_equal(batch.x, whole.x)


def test_what_is_no_batch_or_no_innovation_is_refused(rng):
    with pytest.raises(ValueError, match=r"x of shape \(R, n\) and P of shape \(R, n, n\), got \(3, 4\) and \(3, 4\)"):
        Batch(np.zeros((3, 4)), np.zeros((3, 4)))
    batch, _ = both(rng)
    before, H = (batch.x.copy(), batch.P.copy()), np.ones((2, 3))
    z = np.zeros((RUNS, 2))
    with pytest.raises(ValueError, match=r"innovations must have shape \(7, 2\), got \(6, 2\)"):
        batch.correct(((ROB, H),), z[1:], np.eye(2))
    z[4, 1] = np.nan
    with pytest.raises(ValueError, match="the innovation must be finite, but that of run 4 is not"):
        batch.correct(((ROB, H),), z, np.eye(2))
    R = np.tile(np.eye(2), (RUNS, 1, 1))
    R[5] = -100 * np.eye(2)
    with pytest.raises(ValueError, match="covariance must be positive definite, but that of run 5 is not"):
        batch.correct(((ROB, H),), np.zeros((RUNS, 2)), R)
    assert np.array_equal(batch.x, before[0]) and np.array_equal(batch.P, before[1])
