"""What a compressed map asks compiled code for, against the same in numpy."""

import numpy as np

from ekfslam_tutorial.compiled import here, settle
from ekfslam_tutorial.ekf.virtual import VirtualStates


def test_where_they_are_at_hand():
    at, used_at = np.array([4, -1, 2, 3, -1, 0]), np.zeros(6, int)
    rows = np.array([[0, 2], [3, 1], [5, 0]])
    assert np.array_equal(here(at, used_at, 7, rows, [0, 2]), [[4, 2], [3, -1], [0, 4]])
    assert used_at.tolist() == [7, 0, 7, 0, 0, 7]  # only those that are used
    assert here(at, used_at, 8, rows, [0, 1]) is None  # one of these is far
    assert here(at, used_at, 8, rows[:, :0], []).shape == (3, 0)


def test_means_follow_those_at_hand(rng):
    n, hand, v = 30, np.array([7, 2, 11, 3]), np.array([5, 1, 6, 8])
    A = rng.normal(size=(n, n))
    P = A @ A.T
    virtual = VirtualStates(n)
    virtual.take(hand, P[hand], P[np.ix_(hand, hand)])
    at = np.full(n, -1)
    at[hand] = [0, 2, 3, 4]
    x, x_near = rng.normal(size=n), rng.normal(size=9)
    dx = virtual.times(x_near[v], n)
    dx[hand] = x_near[at[hand]]
    expected = x + dx
    settle(x, x_near, *virtual.factors, v, hand, at)
    assert np.abs(x - expected).max() < 1e-13 * np.abs(expected).max()  # four products and a solution, in another order


def test_nothing_is_at_hand(rng):
    x = rng.normal(size=5)
    before = x.copy()
    nothing = np.zeros(0, int)
    settle(x, np.zeros(3), *VirtualStates(5).factors, nothing, nothing, np.full(5, -1))
    assert np.array_equal(x, before)
