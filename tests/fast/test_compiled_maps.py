"""What a compressed map asks compiled code for, against the same in numpy."""

import numpy as np
import pytest

from ekfslam_tutorial.fast import (
    CompressedMap,
    FastMap,
    augment,
    correct,
    covariance,
    cross,
    fast_map,
    innovation,
    update,
)
from ekfslam_tutorial.fast import virtual as by_numpy
from ekfslam_tutorial.fast.compiled import expected, expected_in_view, explained, follow, settle, spots
from ekfslam_tutorial.fast.compiled import maps as pieces
from ekfslam_tutorial.fast.expectation import may_be_seen
from ekfslam_tutorial.fast.storage import square
from ekfslam_tutorial.fast.virtual import VirtualStates
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.sensors import RangeBearing

CLOSE = 1e-12  # of the largest number: a dozen operations on each, in another order


def close(a, b):
    return a.shape == b.shape and np.abs(a - b).max(initial=0.0) <= CLOSE * np.abs(b).max(initial=1.0)


def positive(rng, n, rank=None):
    A = rng.normal(size=(n, rank or n))
    return A @ A.T


def cholesky(P):
    """The kernel as `virtual.cholesky` has it."""
    Ct, order = np.empty(P.shape), np.empty(len(P), np.int64)
    rank = pieces._cholesky(P, Ct, order)
    return Ct[:rank].T, order[:rank]


def test_where_the_active_ones_stand():
    at, used_at = np.array([4, -1, 2, 3, -1, 0]), np.zeros(6, int)
    rows = np.array([[0, 2], [3, 1], [5, 0]])
    assert np.array_equal(spots(at, used_at, 7, rows, [0, 2]), [[4, 2], [3, -1], [0, 4]])
    assert used_at.tolist() == [7, 0, 7, 0, 0, 7]  # only those that are used
    assert spots(at, used_at, 8, rows, [0, 1]) is None  # one of these is far
    assert spots(at, used_at, 8, rows[:, :0], []).shape == (3, 0)


def test_means_follow_the_active_ones(rng):
    n, active, v = 30, np.array([7, 2, 11, 3]), np.array([5, 1, 6, 8])
    A = rng.normal(size=(n, n))
    P = A @ A.T
    virtual = VirtualStates(n)
    virtual.add(active, P[active], P[np.ix_(active, active)])
    of = np.full(12, -1)  # longer than it need be, as it is when the near map has been larger
    of[[0, 2, 3, 4]] = active
    x, x_near = rng.normal(size=n), rng.normal(size=9)
    expected, left = x.copy(), x_near.copy()
    expected[active] += x_near[[0, 2, 3, 4]]
    left[[0, 2, 3, 4]] = 0.0
    follow(x, x_near, of)
    assert np.array_equal(x, expected) and np.array_equal(x_near, left)

    dx = virtual.times(x_near[v], n)
    dx[active] = 0.0
    expected = x + dx
    settle(x, x_near, virtual, v, of)
    assert np.array_equal(x[active], expected[active]) and not x_near.any()
    assert np.abs(x - expected).max() < 1e-13 * np.abs(expected).max()  # four products and a solution, in another order


def test_nothing_is_active(rng):
    x = rng.normal(size=5)
    before = x.copy()
    nothing = np.zeros(0, int)
    settle(x, np.zeros(3), VirtualStates(5), nothing, np.full(3, -1))
    assert np.array_equal(x, before)


@pytest.mark.parametrize("lower", [False, True])
def test_between_some_states_and_others(rng, lower):
    map = FastMap(compiled=True)
    P = positive(rng, 90)
    map.add(rng.normal(size=90), P)
    if lower:  # what is right of the diagonal is not true then
        map.subtract(np.zeros((1, 90)))
        assert map.storage[3]
        map.storage[1][0, 1:90] = np.nan
    i, j = np.array([5, 0, 88, 5]), np.array([3, 89, 0])
    assert np.array_equal(map.between(i, j), P[np.ix_(i, j)])
    assert map.between(i[:0], j).shape == (0, 3)


@pytest.mark.parametrize("active", [[], [7, 2], [11, 3, 4, 29, 0]])
@pytest.mark.parametrize("some", [[8], [9, 10], [13, 21, 6, 22, 28]])
def test_what_the_active_ones_explain(rng, active, some):
    n, active, some = 30, np.array(active, int), np.array(some)
    for P in (
        positive(rng, n),
        positive(rng, n, 8),
        np.outer(s := 10.0 ** rng.uniform(-4, 2, n), s) * positive(rng, n),
    ):
        virtual = VirtualStates(n)
        if len(active):
            virtual.add(active, P[active], P[np.ix_(active, active)])
        expected = virtual._explained(some, P[np.ix_(some, some)])
        G = explained(virtual, some, np.ascontiguousarray(P[np.ix_(some, some)]))
        assert G.shape == expected.shape == (len(some), len(active) + len(some))
        scale = np.sqrt(P.diagonal()[some])[:, None]  # where nothing is left, a root shows half of the digits
        assert np.abs((G - expected) / scale).max() < 1e-8


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("rank", [10, 3, 1, 0])
def test_covariances_with_all_others_are_those_of_P(rng, rank, compiled):
    """P_0[A, :] = L G', whether P has an inverse or not; no number in G is much larger than a standard deviation."""
    P = positive(rng, 10, rank) if rank else np.zeros((10, 10))
    virtual = VirtualStates(10, compiled)
    for some in np.array([1, 5, 6]), np.array([0, 9]), np.array([3]):
        virtual.add(some, P[some], np.ascontiguousarray(P[np.ix_(some, some)]))
    active, (Lt, _), Gt = [1, 5, 6, 0, 9, 3], virtual.factors, virtual.through(np.eye(6), 10)
    assert np.abs(Lt.T @ Gt - P[active]).max() <= 1e-14 * np.abs(P).max()
    assert (np.abs(Gt) <= 1.01 * np.sqrt(P.diagonal())).all() and (Lt.diagonal() > 0).all()


@pytest.mark.parametrize(
    "factor", [by_numpy.triangle, lambda P, v: explained(VirtualStates(len(P)), np.arange(len(P)), P)]
)
def test_a_difference_that_is_no_covariance_has_a_triangle(factor):
    """As rounding leaves it below zero by more than the first D makes good."""
    P = np.array([[1.0, 1.0], [1.0, 1.0 - 1e-6]])
    C = factor(P, P.diagonal())
    assert np.abs(C @ C.T - P).max() < 1e-3 and C[1, 1] > 0 and C[0, 1] == 0


@pytest.mark.parametrize("n, rank", [(1, 1), (3, 3), (5, 2), (4, 0), (60, 60), (60, 23)])
def test_factors_of_a_covariance(rng, n, rank):
    for scale in np.ones(n), 10.0 ** rng.uniform(-4, 2, n):
        P = np.outer(scale, scale) * positive(rng, n, rank) if rank else np.zeros((n, n))
        (C, order), (expected, first) = cholesky(P), by_numpy.cholesky(P)
        assert C.shape == expected.shape == (n, rank) and np.array_equal(order, first)
        assert close(C / scale[:, None], expected / scale[:, None])
        assert not np.triu(C[order], 1).any()


def test_what_is_no_covariance_has_the_factors_of_its_positive_part():
    """A rounding error below zero, as it is left of a difference, is nothing."""
    C, order = cholesky(np.diag([4.0, -1e-17, 1.0]))
    assert np.array_equal(C, [[2.0, 0.0], [0.0, 0.0], [0.0, 1.0]]) and order.tolist() == [0, 2]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("n_first", [0, 1, 40, 97, 100])
def test_the_first_states_only(rng, n_first, compiled):
    """W' with fewer columns than there are states."""
    map, P = FastMap(compiled=compiled), positive(rng, 100)
    map.add(np.zeros(100), P)
    Wt = rng.normal(size=(3, n_first))
    map.subtract(Wt)
    P[:n_first, :n_first] -= Wt.T @ Wt
    assert close(map.P, P)


@pytest.mark.parametrize("active", [30, 200])
@pytest.mark.parametrize("lower", [False, True])
def test_states_become_active(rng, monkeypatch, active, lower):
    """The same map twice: at one of them numpy does it."""
    if not lower:
        monkeypatch.setattr(fast_map, "ONE_TRIANGLE_COMPILED", 1000)
    maps = [CompressedMap(active=active, compiled=True) for _ in range(2)]
    P, x = positive(rng, 150), rng.normal(size=150)
    for map in maps:
        for i in range(0, 150, 2):
            map.add(x[i : i + 2], P[i : i + 2, i : i + 2], P[i : i + 2, :i])
        map._small.compiled = map._virtual.compiled = map.compiled = map is maps[0]
    triangles = set()
    for _ in range(25):
        triangles.add(maps[0].storage[3])
        rows = 2 * rng.choice(75, 4, replace=False)[:, None] + [0, 1]
        J, z = rng.normal(size=(8, 2)), rng.normal(size=8)
        for map in maps:
            places = map.spots(None, None, rows, list(range(4)))[2]
            H = np.zeros((8, map._small.n))
            for k in range(4):
                H[2 * k : 2 * k + 2, places[k]] = J[2 * k : 2 * k + 2]
            Pn = map._small.P
            Z = H @ Pn @ H.T + np.eye(8)
            map.shift(Pn @ H.T @ np.linalg.solve(Z, z))
            map.subtract(np.linalg.solve(np.linalg.cholesky(Z), H @ Pn))
        here = [map._spot_of[map._active_states] for map in maps]
        a, b = (map._small.between(at, at) for map, at in zip(maps, here, strict=True))
        assert np.array_equal(*here) and close(a, b)
    assert (True in triangles) == lower
    assert close(maps[0].x, maps[1].x) and close(maps[0].P, maps[1].P)


@pytest.mark.parametrize("active", [12, 60])
def test_storage_that_grows_need_not_be_zero(rng, monkeypatch, active):
    """Whatever is in the memory that a larger map gets: here it is NaN, which would spread."""
    grown = []

    def poisoned(n, zeros=True):
        P = square(n)
        if not zeros:
            P[:] = np.nan
            grown.append(n)
        return P

    monkeypatch.setattr(fast_map, "square", poisoned)
    pair = CompressedMap(active=active, compiled=True), FastMap()
    robot, lmks = slice(0, 3), []
    for map in pair:
        map.add(np.zeros(3), 0.1 * np.eye(3))
    for k in range(160):
        L, l = rng.normal(size=(2, 3)), rng.normal(size=2)
        r, _ = (augment(map, l, [(robot, L)], 0.1 * np.eye(2)) for map in pair)
        lmks.append(r)
        some = [lmks[i] for i in rng.choice(len(lmks), min(len(lmks), 4), replace=False)] if k % 3 == 0 else lmks[-4:]
        J_r, J_l, z = (
            rng.normal(size=(len(some), 2, 3)),
            rng.normal(size=(len(some), 2, 2)),
            rng.normal(size=(len(some), 2)),
        )
        blocks = (robot, J_r), (np.array([range(r.start, r.stop) for r in some]), J_l)
        for map in pair:
            update(map, blocks, z, np.eye(2))
        if k % 10 == 9:
            gone = lmks.pop(rng.integers(len(lmks)))
            for map in pair:
                map.remove(gone)
        if k % 7 == 0:
            assert close(pair[0].block(lmks[0]), pair[1].block(lmks[0]))
    assert len(grown) >= 2
    assert close(np.array(pair[0].x), pair[1].x) and close(pair[0].P, pair[1].P)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_file_holds_the_states_and_nothing_of_the_spare_storage(rng, compiled):
    """Nor what stands above the diagonal where only half counts. Files that held all of the storage can be read."""
    map, P = FastMap(compiled=compiled), positive(rng, 90)
    for i in range(0, 90, 3):
        map.add(rng.normal(size=3), P[i : i + 3, i : i + 3], P[i : i + 3, :i])
    map.subtract(np.zeros((1, 90)))
    half, size = map.storage[3], len(map.storage[0])
    assert half == compiled and size > 90
    if half:
        map.storage[1][:90, :90][np.triu_indices(90, 1)] = np.nan
    map.storage[1][90:], map.storage[1][:, 90:] = np.nan, np.nan
    state = map.__getstate__()
    arrays = [a for a in state.values() if isinstance(a, np.ndarray)]
    assert sorted(a.shape for a in arrays) == [(90,), (90,), (90, 90)] and not any(np.isnan(a).any() for a in arrays)
    before = state | {"_x": map.storage[0], "_P": map.storage[1], "_used": np.arange(size) < 90}
    del before["_size"]
    for kept in state, before:
        other = FastMap()
        other.__setstate__(kept)
        assert len(other.storage[0]) == size and other.compiled == compiled
        assert np.array_equal(other.x, map.x) and np.array_equal(other.P, P) and np.array_equal(other.used, map.used)


def test_what_may_be_seen_is_told_from_means_that_are_behind(rng):
    """Landmarks on a line, a range of three of them: the means are settled only where somebody is at its edge."""
    map, beside = CompressedMap(active=20, compiled=True), FastMap()
    sensor, kind, S = RangeBearing(1.0, 1.0, max_range=3.2), EucPnt(2), Frame2(np.zeros(3))
    for m in (map, beside):
        for k in range(40):
            augment(m, [float(k), 0.0], [(None, np.eye(2))], 0.1 * np.eye(2))
    indices, kept, settled = np.arange(80).reshape(40, 2), 0, 0
    for k in range(120):
        some = [(k // 3 + i) % 40 for i in range(3)]
        blocks = [(indices[some], rng.normal(size=(3, 2, 2)) * 0.3)]
        z = 0.05 * rng.normal(size=(3, 2))
        for m in (map, beside):
            PHt = cross(m, blocks)
            correct(m, PHt, innovation(z, covariance(PHt, blocks), np.eye(2)))
        R = Frame2(np.array([some[0] + 1.0, 0.1, 0.3]))
        behind = map._far_behind
        got, at, *found, E = expected_in_view(map, R, S, sensor, kind, indices, None, None)
        kept, settled = kept + (behind and map._far_behind), settled + (behind and not map._far_behind)
        assert np.array_equal(got, np.flatnonzero(may_be_seen(R, S, sensor, kind, beside.x[indices])))
        assert len(got) and E is None and np.array_equal(at, indices[got])
        each = expected(map, R, S, sensor, kind, beside.x[at], None, None, at, False)
        assert all(close(np.asarray(a, float), np.asarray(b, float)) for a, b in zip(found, each[:4], strict=True))
    assert kept > 20 and settled > 5
