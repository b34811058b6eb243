"""Exercise 18.4: two maps of the same landmarks become one, with all that their covariances say."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def fuse(l1, P1, l2, P2):
    """Put two independent maps of the same landmarks together, as well as possible.

    l1 and l2, shape (n,): the landmarks of two maps, [x, y] one after the other, in one frame, in the same order.
    P1 and P2, shape (n, n): their covariances, with all that they say about pairs of landmarks.
    The second map is a measurement of the first: l2 = l1 + error, with the covariance P2.
    Return the fused map, shape (n,), and its covariance, shape (n, n).
    """
    K = np.linalg.solve(P1 + P2, P1).T
    return l1 + K @ (l2 - l1), P1 - K @ P1


fusion = Exercise(
    "18.4",
    "Two maps become one",
    fuse,
    hints=(
        "A Kalman correction: the state is l1 with P1, the measurement is l2 with R = P2, and H is the identity.",
        "The innovation is l2 - l1, its covariance Z = P1 + P2, the gain K = P1 Z^-1. Or add informations: "
        "P^-1 = P1^-1 + P2^-1.",
        "l = l1 + K (l2 - l1) and P = P1 - K P1, with the whole matrices: not 2 x 2 blocks, not diagonals.",
    ),
)


def covariance(rng, n, size=1.0):
    """Return a covariance (n, n) of landmarks that hang together."""
    A = rng.normal(size=(n, n)) * rng.uniform(0.3, 1.0, n)[:, None]
    B = rng.normal(size=(n, 3))  # as if the whole map could shift and turn
    return size * (0.2 * A @ A.T / n + B @ B.T + 0.02 * np.eye(n))


def case(rng, n, size=1.0):
    """Return two maps."""
    l = 5 * rng.normal(size=n)
    return l + rng.normal(size=n), covariance(rng, n), l + rng.normal(size=n), covariance(rng, n, size)


CASES = ((2, 1.0), (6, 1.0), (10, 0.2), (8, 4.0))


def _two(result, n):
    l, P = expect.results(result, "l", "P")
    return expect.array(l, n, "l"), expect.array(P, (n, n), "P")


@fusion.link("two results", "The function must end with `return l, P`.")
def _(f, rng):
    for n, size in CASES:
        _two(f(*case(rng, n, size)), n)


@fusion.link("by hand", "Variances 1 and 4: the first map has the weight 4/5, the second 1/5.", part=0)
def _(f, rng):
    l1, l2 = np.array([1.0, 2.0]), np.array([2.0, 0.0])
    l, _ = _two(f(l1, np.eye(2), l2, 4 * np.eye(2)), 2)
    expect.close(l, [1.2, 1.6], "l", at="P1 = I, P2 = 4 I, l1 = [1, 2] and l2 = [2, 0]")


@fusion.link("mean", "The whole matrices: a landmark is also told by what is known of its neighbours.", part=0)
def _(f, rng):
    for n, size in CASES:
        args = case(rng, n, size)
        expect.close(_two(f(*args), n)[0], fuse(*args)[0], "l", 1e-5, at=f"{n // 2} landmarks")


@fusion.link("covariance", "P1 - K P1, which is (P1^-1 + P2^-1)^-1.", part=1)
def _(f, rng):
    for n, size in CASES:
        args = case(rng, n, size)
        P = _two(f(*args), n)[1]
        expect.close(P, fuse(*args)[1], "P", 1e-5, at=f"{n // 2} landmarks")
        expect.symmetric(P, "P", 1e-6)
        expect.psd(P, "P", 1e-6)


@fusion.link("order of the maps", "Neither map is better by its place: fuse(1, 2) is fuse(2, 1).")
def _(f, rng):
    l1, P1, l2, P2 = case(rng, 6, 3.0)
    one, two = _two(f(l1, P1, l2, P2), 6), _two(f(l2, P2, l1, P1), 6)
    expect.close(two[0], one[0], "l with the maps exchanged", 1e-5)
    expect.close(two[1], one[1], "P with the maps exchanged", 1e-5)


@fusion.link("an unsure neighbour", "Map 2 knows its first landmark only. In map 1 the second hangs on the first, so "
             "it must move along.", part=0)  # fmt: skip
def _(f, rng):
    P1 = np.kron(np.array([[1.0, 0.9], [0.9, 1.0]]), np.eye(2))
    P2 = np.diag([1e-4, 1e-4, 1e4, 1e4])
    l1, l2 = np.zeros(4), np.array([1.0, -1.0, 50.0, 70.0])
    l, _ = _two(f(l1, P1, l2, P2), 4)
    expect.close(l, fuse(l1, P1, l2, P2)[0], "l", 1e-4, at="a second landmark that map 2 hardly knows")


def _wrong(name, hint, l=None, P=None, P1_P2=None):
    """A misconception: other covariances that go in, or another l or P that comes out."""

    @fusion.wrong(name, hint)
    def _(l1, P1, l2, P2):
        A, B = P1_P2(P1, P2) if P1_P2 else (P1, P2)
        l_, P_ = fuse(l1, A, l2, B)
        return l(l1, P1, l2, P2) if l else l_, P(P1, P2) if P else P_


def _blocks(P):
    n = len(P) // 2
    return P * np.kron(np.eye(n), np.ones((2, 2)))


def _scalar(P):
    return np.eye(len(P)) * np.trace(P) / len(P)


# fmt: off
_wrong("plain mean", "A map that is ten times as good gets the same weight. Weigh by the covariances.",
       l=lambda l1, P1, l2, P2: (l1 + l2) / 2, P=lambda P1, P2: (P1 + P2) / 4)
_wrong("plain mean, fused covariance", "The mean is not weighted: l = l1 + K (l2 - l1) with K = P1 (P1 + P2)^-1.",
       l=lambda l1, P1, l2, P2: (l1 + l2) / 2)
_wrong("landmark by landmark", "You use the 2 x 2 blocks only. The landmarks of one map hang together: its common "
       "shift and turn is in the blocks beside the diagonal.", P1_P2=lambda P1, P2: (_blocks(P1), _blocks(P2)))
_wrong("number by number", "You use the variances only. What the covariances say about pairs is what makes a map of "
       "single points.", P1_P2=lambda P1, P2: (np.diag(np.diag(P1)), np.diag(np.diag(P2))))
_wrong("one weight for each map", "One number cannot say which part of a map is good: use the whole matrices.",
       P1_P2=lambda P1, P2: (_scalar(P1), _scalar(P2)))
_wrong("the better map only", "The other map is worse, but not worthless: it is information.",
       l=lambda l1, P1, l2, P2: (l1 if np.trace(P1) <= np.trace(P2) else l2).copy(),
       P=lambda P1, P2: (P1 if np.trace(P1) <= np.trace(P2) else P2).copy())
_wrong("weights exchanged", "The map with the larger covariance must get the smaller weight.",
       l=lambda l1, P1, l2, P2: fuse(l2, P1, l1, P2)[0])
_wrong("innovation with the wrong sign", "The innovation is l2 - l1: what map 2 says beyond map 1.",
       l=lambda l1, P1, l2, P2: l1 - (fuse(l1, P1, l2, P2)[0] - l1))
_wrong("gain transposed", "K = P1 (P1 + P2)^-1, in this order: yours is its transpose.",
       l=lambda l1, P1, l2, P2: l1 + np.linalg.solve(P1 + P2, P1) @ (l2 - l1))
_wrong("covariances added", "Two maps know more than one: the fused covariance is smaller than both.",
       P=lambda P1, P2: P1 + P2)
_wrong("mean of the covariances", "Two maps know more than one: the fused covariance is smaller than both.",
       P=lambda P1, P2: (P1 + P2) / 2)
_wrong("half the covariance", "That holds for two maps of the same covariance only.", P=lambda P1, P2: P1 / 2)
_wrong("covariance of the plain mean", "(P1 + P2) / 4 belongs to the plain mean, not to the weighted one.",
       P=lambda P1, P2: (P1 + P2) / 4)
_wrong("informations not turned back", "P1^-1 + P2^-1 is the information: invert the sum.",
       P=lambda P1, P2: np.linalg.inv(P1) + np.linalg.inv(P2))
_wrong("P1 as it was", "Map 2 has brought information: P = P1 - K P1.", P=lambda P1, P2: P1.copy())
_wrong("told twice", "Map 2 counts once. Fused again with what is already in it, it makes the covariance too small.",
       P1_P2=lambda P1, P2: (P1, P2 / 2))
# fmt: on


@fusion.variant("informations")
def _(l1, P1, l2, P2):
    A1, A2 = np.linalg.inv(P1), np.linalg.inv(P2)
    P = np.linalg.inv(A1 + A2)
    return P @ (A1 @ l1 + A2 @ l2), P


@fusion.variant("Joseph's form, lists")
def _(l1, P1, l2, P2):
    K = P1 @ np.linalg.inv(P1 + P2)
    L = np.eye(len(l1)) - K
    return (l1 + K @ (l2 - l1)).tolist(), (L @ P1 @ L.T + K @ P2 @ K.T).tolist()


@fusion.variant("least squares over both maps")
def _(l1, P1, l2, P2):
    n = len(l1)
    W = [np.linalg.inv(np.linalg.cholesky(P)) for P in (P1, P2)]
    A, y = np.vstack(W), np.concatenate([W[0] @ l1, W[1] @ l2])
    l = np.linalg.lstsq(A, y, rcond=None)[0]
    return l, np.linalg.inv(A.T @ A) if n else P1
