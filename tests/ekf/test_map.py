"""The stochastic map: who owns which part, under any sequence of additions and removals."""

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, invariant, multiple, rule

from ekfslam_tutorial.ekf import Map, MapFull, transform

CAPACITY = 40


class MapMachine(RuleBasedStateMachine):
    """A map of limited capacity next to a dictionary that says what must be in it."""

    ranges = Bundle("ranges")

    def __init__(self):
        super().__init__()
        self.map, self.kept, self.rng = Map(CAPACITY), {}, np.random.default_rng(0)

    @rule(target=ranges, k=st.integers(1, 9), correlated=st.booleans())
    def add(self, k, correlated):
        A = self.rng.normal(size=(k, k + self.map.n))
        x, P_xm = self.rng.normal(size=k), None
        P_xx = A @ A.T
        if correlated and self.map.n:
            P_xm = A[:, k:] * 0.01 @ self.map.P
            P_xx = P_xx + P_xm @ np.linalg.pinv(self.map.P) @ P_xm.T  # rounding errors make it unsymmetric
        before = self.map.x.copy(), self.map.P.copy(), self.map.used.copy()
        n_used = self.map.n_used
        try:
            r = self.map.add(x, P_xx, P_xm)
        except MapFull:
            assert n_used + k > CAPACITY
            after = self.map.x, self.map.P, self.map.used
            assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
            return multiple()
        assert n_used + k <= CAPACITY and r.stop - r.start == k and not before[2][r].any()
        assert np.allclose(self.map.P[r, r], P_xx, rtol=1e-12)
        self.kept[r.start] = (r, x)
        return r

    @rule(r=consumes(ranges))
    def remove(self, r):
        self.map.remove(r)
        del self.kept[r.start]
        with pytest.raises(ValueError, match="is not in use"):
            self.map.remove(r)

    @rule(target=ranges, r=consumes(ranges), data=st.data())
    def shrink(self, r, data):
        """A state becomes a shorter one, as in a reparametrisation."""
        k = data.draw(st.integers(1, r.stop - r.start))
        x = self.rng.normal(size=k)
        head = transform(self.map, r, x, self.rng.normal(size=(k, r.stop - r.start)))
        assert head == slice(r.start, r.start + k)
        self.kept[r.start] = (head, x)
        return head

    @invariant()
    def ranges_and_states_belong_together(self):
        owner = np.zeros(self.map.n, int)
        for r, x in self.kept.values():
            owner[r] += 1
            assert np.array_equal(self.map.x[r], x)
        assert owner.max(initial=0) <= 1 and np.array_equal(owner == 1, self.map.used)
        assert self.map.n_used == owner.sum() <= CAPACITY

    @invariant()
    def free_states_are_zero(self):
        free = ~self.map.used
        assert not self.map.x[free].any() and not self.map.P[free].any() and not self.map.P[:, free].any()

    @invariant()
    def the_covariance_is_one(self):
        P = self.map.P
        assert np.array_equal(P, P.T)
        assert not P.size or np.linalg.eigvalsh(P)[0] >= -1e-9 * np.abs(P).max()


TestMapMachine = MapMachine.TestCase
TestMapMachine.settings = settings(max_examples=100, stateful_step_count=25, deadline=None)


def test_without_a_capacity_the_map_grows():
    map = Map()
    for k in range(200):
        assert map.add(np.full(3, k), np.eye(3)) == slice(3 * k, 3 * k + 3)
    assert (
        map.n == map.n_used == 600 and np.array_equal(map.x[::3], np.arange(200)) and np.array_equal(map.P, np.eye(600))
    )


def test_the_views_can_be_written_to():
    map = Map()
    r = map.add(np.zeros(2), np.eye(2))
    map.x[r] = [1.0, 2.0]
    map.P[r, r] *= 4
    assert np.array_equal(map.x, [1, 2]) and np.array_equal(map.P, 4 * np.eye(2))


def test_the_first_gap_that_is_long_enough_is_taken():
    map = Map()
    ranges = [map.add(np.zeros(k), np.eye(k)) for k in (2, 3, 2, 5, 2)]
    map.remove(ranges[1])
    map.remove(ranges[3])
    assert map.add(np.zeros(4), np.eye(4)) == slice(7, 11)
    assert map.add(np.zeros(3), np.eye(3)) == slice(2, 5)
    assert map.add(np.zeros(3), np.eye(3)) == slice(14, 17)


def test_what_it_says_of_itself():
    map = Map(10)
    map.add(np.zeros(3), np.eye(3))
    assert repr(map) == "Map(3 of 10 states in use)" and repr(Map()) == "Map(0 states in use)"


ASYMMETRIC, INDEFINITE = np.array([[1.0, 0.2], [0.1, 1.0]]), np.array([[1.0, 2.0], [2.0, 1.0]])


@pytest.mark.parametrize(
    "x, P_xx, P_xm, said",
    [
        ([0.0, 0.0], np.eye(3), None, r"P_xx must .*shape \(2, 2\), got .*\(3, 3\)"),
        ([0.0, 0.0], np.ones((2, 3)), None, r"P_xx must .*shape \(2, 2\), got .*\(2, 3\)"),
        ([0.0, np.nan], np.eye(2), None, "the mean of a new state must be finite, got"),
        ([0.0, 0.0], np.diag([1.0, np.inf]), None, "P_xx must be finite, got"),
        ([0.0, 0.0], ASYMMETRIC, None, "P_xx must be symmetric, got"),
        ([0.0, 0.0], INDEFINITE, None, "P_xx must be positive semi-definite, its smallest eigenvalue is -1"),
        ([0.0, 0.0], np.eye(2), np.full((2, 3), np.nan), "P_xm must be finite"),
        ([0.0, 0.0], np.eye(2), np.zeros((3, 2)), r"P_xm must .*shape \(2, 3\), got .*\(3, 2\)"),
    ],
)
def test_bad_input_is_named_and_nothing_is_changed(x, P_xx, P_xm, said):
    map = Map()
    map.add(np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match=said):
        map.add(x, P_xx, P_xm)
    assert map.n == 3 and np.array_equal(map.P, np.eye(3))


def test_singular_covariances_are_welcome():
    map = Map()
    v = np.array([1.0, 2.0, 3.0])
    map.add(v, np.outer(v, v))
    map.add(v, np.zeros((3, 3)))
    assert map.n == 6


@pytest.mark.parametrize("capacity", [0, -3])
def test_a_map_without_room_is_refused(capacity):
    with pytest.raises(ValueError, match=f"capacity of a map must be a positive number of states, got {capacity}"):
        Map(capacity)


@pytest.mark.parametrize("r", [slice(0, 2), slice(2, 5), slice(3, 3), slice(-1, 2)])
def test_only_what_is_there_can_be_removed(r):
    map = Map()
    for k in 2, 1:
        map.add(np.zeros(k), np.eye(k))
    map.remove(slice(0, 2))
    with pytest.raises(ValueError, match=f"range {r.start}:{r.stop} is not in use"):
        map.remove(r)


@pytest.mark.parametrize(
    "r, said",
    [
        (slice(0, 2), "range 0:2 is not that of a state; there is 0:3"),
        (slice(1, 3), "range 1:3 is not that of a state; there is 0:3"),
        (slice(0, 5), "range 0:5 is not that of a state; there is 0:3, 3:5"),
        (slice(0, 3, 2), r"remove takes the range that add has returned, got slice\(0, 3, 2\)"),
    ],
)
def test_only_a_whole_state_can_be_removed(r, said):
    map = Map()
    ranges = [map.add(np.ones(k), np.eye(k)) for k in (3, 2)]
    with pytest.raises(ValueError, match=said):
        map.remove(r)
    assert map.ranges == ranges and map.n_used == 5 and np.array_equal(map.x, np.ones(5))
    assert np.array_equal(map.P, np.eye(5))


def test_only_a_whole_state_can_become_shorter():
    """A part may be replaced by as many numbers: a frame in front of velocities. By fewer there would be a hole."""
    map = Map()
    map.add([1.0, 2.0, 3.0], np.diag([1.0, 2.0, 3.0]))
    map.add([4.0, 5.0], np.eye(2))
    x, P = map.x.copy(), map.P.copy()
    for r in (slice(0, 2), slice(1, 3), slice(2, 5)):
        with pytest.raises(
            ValueError, match=f"only a whole state can become shorter, and range {r.start}:{r.stop} is none"
        ):
            map.put(r, [9.0], np.zeros((1, 5)), np.eye(1))
        assert np.array_equal(map.x, x) and np.array_equal(map.P, P) and map.n_used == 5
    assert map.put(slice(1, 3), [7.0, 8.0], 0.1 * np.ones((2, 5)), np.eye(2)) == slice(1, 3)
    assert map.x.tolist() == [1.0, 7.0, 8.0, 4.0, 5.0] and map.ranges == [slice(0, 3), slice(3, 5)]
    assert map.put(slice(0, 3), [6.0], np.full((1, 5), 0.2), np.eye(1)) == slice(0, 1)
    assert map.x.tolist() == [6.0, 0.0, 0.0, 4.0, 5.0] and map.ranges == [slice(0, 1), slice(3, 5)]
    assert map.P[0].tolist() == map.P[:, 0].tolist() == [1.0, 0.0, 0.0, 0.2, 0.2] and not map.P[1:3].any()
