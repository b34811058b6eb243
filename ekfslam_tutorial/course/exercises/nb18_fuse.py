"""Exercise 18.4: two maps of the same landmarks become one, with all that their covariances say."""

import numpy as np

from ..table import table


def fuse(l1, P1, l2, P2):
    """Put two independent maps of the same landmarks together, as well as possible.

    l1 and l2, shape (n,): the landmarks of two maps, [x, y] one after the other, in one frame, in the same order.
    P1 and P2, shape (n, n): their covariances, with all that they say about pairs of landmarks.
    The second map is a measurement of the first: l2 = l1 + error, with the covariance P2.
    Return the fused map, shape (n,), and its covariance, shape (n, n).
    """
    K = np.linalg.solve(P1 + P2, P1).T
    l = l1 + K @ (l2 - l1)
    P = P1 - K @ P1
    return l, P


def covariance(rng, n, size=1.0):
    """Return a covariance (n, n) of landmarks that are correlated."""
    A = rng.normal(size=(n, n)) * rng.uniform(0.3, 1.0, n)[:, None]
    B = rng.normal(size=(n, 3))  # as if the whole map could shift and turn
    return size * (0.2 * A @ A.T / n + B @ B.T + 0.02 * np.eye(n))


def case(rng, n, size=1.0):
    """Return two maps."""
    l = 5 * rng.normal(size=n)
    return l + rng.normal(size=n), covariance(rng, n), l + rng.normal(size=n), covariance(rng, n, size)


def both_orders(l1, P1, l2, P2):
    """The same two maps in both orders."""
    return [(l1, P1, l2, P2), (l2, P2, l1, P1)]


def unsure(rng):
    """Map 2 hardly knows its second landmark, which in map 1 hangs on the first."""
    P1 = np.kron(np.array([[1.0, 0.9], [0.9, 1.0]]), np.eye(2))
    return [(np.zeros(4), P1, np.array([1.0, -1.0, 50.0, 70.0]), np.diag([1e-4, 1e-4, 1e4, 1e4]))]


fusion = table(
    "18.4 Two maps become one",
    fuse,
    hints=(
        "A Kalman correction: the state is l1 with P1, the measurement is l2 with R = P2, and H is the identity.",
        "The innovation is l2 - l1, its covariance Z = P1 + P2, the gain K = P1 Z^-1. Or add the information: P^-1 = P1^-1 + P2^-1.",
        "l = l1 + K (l2 - l1) and P = P1 - K P1, with the whole matrices: not 2 x 2 blocks, not diagonals.",
    ),
    returns="l, P",
    cases={
        "any": lambda rng: [case(rng, *c) for c in ((2, 1.0), (6, 1.0), (10, 0.2), (8, 4.0))],
        "by hand": lambda rng: [(np.array([1.0, 2.0]), np.eye(2), np.array([2.0, 0.0]), 4 * np.eye(2))],
        "order": lambda rng: both_orders(*case(rng, 6, 3.0)),
        "unsure": unsure,
    },
    checks="""
    by hand            | l | by hand | Variances 1 and 4: the first map has the weight 4/5, the second 1/5, as l = P (P1^-1 l1 + P2^-1 l2) with P = (P1^-1 + P2^-1)^-1.
    mean               | l | any     | l = P (P1^-1 l1 + P2^-1 l2) with P = (P1^-1 + P2^-1)^-1, all n x n. The covariances are full here: a landmark is also told by what is known of its neighbours.
    covariance         | P | any     | P1 - K P1, which is (P1^-1 + P2^-1)^-1.
    order of the maps  | l, P | order   | Neither map is better by its place: fuse(1, 2) is fuse(2, 1).
    an unsure neighbour | l | unsure | Map 2 knows its first landmark only. In map 1 the second hangs on the first, so it must move along.
    """,
    wrong="""
    plain mean | l = l1 + K @ (l2 - l1) -> l = (l1 + l2) / 2 | A map that is ten times as good gets the same weight. Weigh by the covariances.
        P = P1 - K @ P1 -> P = (P1 + P2) / 4
    plain mean, fused covariance | l = l1 + K @ (l2 - l1) -> l = (l1 + l2) / 2 | The mean is not weighted: l = l1 + K (l2 - l1) with K = P1 (P1 + P2)^-1.
    landmark by landmark | K = np -> P1, P2 = _blocks(P1), _blocks(P2); K = np | You use the 2 x 2 blocks only. The landmarks of one map are correlated: its common shift and turn is in the blocks off the diagonal.
    blocks of the sum | np.linalg.solve(P1 + P2, P1) -> np.linalg.solve(_blocks(P1 + P2), P1) | You invert the 2 x 2 blocks of P1 + P2 only. The landmarks are correlated: the whole matrix counts.
    number by number | K = np -> P1, P2 = np.diag(np.diag(P1)), np.diag(np.diag(P2)); K = np | Your gain knows the variances only. What the covariances say about pairs is what makes a map of single points.
    one weight for each map | K = np -> P1, P2 = (np.eye(len(P)) * np.trace(P) / len(P) for P in (P1, P2)); K = np | One number cannot say which part of a map is good: use the whole matrices.
    the better map only | return l, P -> return (l1, P1) if np.trace(P1) <= np.trace(P2) else (l2, P2) | The other map is worse, but not worthless: it is information.
    weights exchanged | l1 + K @ (l2 - l1) -> l2 + K @ (l1 - l2) | The map with the larger covariance must get the smaller weight.
    weighted with the covariances | l = l1 + K @ (l2 - l1) -> l = np.linalg.solve(P1 + P2, P1 @ l1 + P2 @ l2) | You weigh each map with its covariance, so that the worse one counts more. The weight is the inverse, the information.
    innovation with the wrong sign | l1 + K @ (l2 - l1) -> l1 + K @ (l1 - l2) | The innovation is l2 - l1: what map 2 says beyond map 1.
    gain transposed | l1 + K @ (l2 - l1) -> l1 + K.T @ (l2 - l1) | K = P1 (P1 + P2)^-1, in this order: yours is its transpose.
    covariances added | P1 - K @ P1 -> P1 + P2 | Two maps know more than one: the fused covariance is smaller than both.
    covariances added, for the mean, too: What adds up is the information, P1^-1 + P2^-1; its inverse is the fused covariance, smaller than both.
        l1 + K @ (l2 - l1) -> (P1 + P2) @ (np.linalg.inv(P1) @ l1 + np.linalg.inv(P2) @ l2)
        P1 - K @ P1 -> P1 + P2
    mean of the covariances | P1 - K @ P1 -> (P1 + P2) / 2 | Two maps know more than one: the fused covariance is smaller than both.
    half the covariance | P1 - K @ P1 -> P1 / 2 | That holds for two maps of the same covariance only.
    covariance of the plain mean | P1 - K @ P1 -> (P1 + P2) / 4 | (P1 + P2) / 4 belongs to the plain mean, not to the weighted one.
    information not turned back | P1 - K @ P1 -> np.linalg.inv(P1) + np.linalg.inv(P2) | P1^-1 + P2^-1 is the information: invert the sum.
    P1 as it was | P1 - K @ P1 -> P1 | Map 2 has brought information: P = P1 - K P1.
    P2 for P1 | P1 - K @ P1 -> P1 - K @ P2 | The covariance of map 1 falls by K P1, not by K P2.
    told twice | K = np -> P2 = P2 / 2; K = np | Map 2 counts once. Fused again with what is already in it, it makes the covariance too small.
    half of each | K = np -> P1, P2 = 2 * P1, 2 * P2; K = np | Your P is too large. The two maps are independent and each counts in full: the informations add, P = (P1^-1 + P2^-1)^-1, which is smaller than P1 and than P2.
    P grows | P1 - K @ P1 -> P1 + K @ P1 | Map 2 has brought information: P = P1 - K P1, with a minus.
    Joseph without the noise | P1 - K @ P1 -> (np.eye(len(P1)) - K) @ P1 @ (np.eye(len(P1)) - K).T | The fused P is (I - K) P1, with (I - K) once. With it on both sides, as in Joseph's form, a second term belongs there: + K P2 K'.
    blocks of the second map only | K = np -> P2 = _blocks(P2); K = np | The landmarks of the second map are correlated, too: the whole P2, and not one landmark after the other.
    P2 for P1 in front | P = P1 - K @ P1 -> P = P2 - K @ P2 | K is the gain of the first map: P = (I - K) P1.
    """,
    forms="""
    information | l = l1 + K @ (l2 - l1) -> P = np.linalg.inv(np.linalg.inv(P1) + np.linalg.inv(P2)) | P = inv(inv(P1) + inv(P2))
        P = P1 - K @ P1 -> l = P @ (np.linalg.inv(P1) @ l1 + np.linalg.inv(P2) @ l2)
    weights of both | l = l1 + K @ (l2 - l1) -> l = P2 @ np.linalg.inv(P1 + P2) @ l1 + K @ l2 | of two weights
        P = P1 - K @ P1 -> P = P2 @ np.linalg.inv(P1 + P2) @ P1
    """,
)


def _blocks(P):
    return P * np.kron(np.eye(len(P) // 2), np.ones((2, 2)))
