"""Exercise 06.2: a loop in one dimension, and what its closure does to all landmarks."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def close_chain(q, R, z):
    """Close a loop of n steps, in one dimension.

    Landmark k is put down after step k. Its error is the sum of the errors of the steps 1 to k; these are independent
    and have the variances q, shape (n,), in m^2. Back at the start, the robot measures the position of the last
    landmark, with variance R, in m^2; R may be 0. The innovation is z, in m.
    Return dx, shape (n,): what each landmark is moved by; and P, shape (n, n): their covariance afterwards.
    """
    C = np.cumsum(q)
    P = np.minimum.outer(C, C)
    K = P[:, -1] / (P[-1, -1] + R)
    return K * z, P - np.outer(K, P[-1])


chain = Exercise(
    "06.2",
    "Closing a chain",
    close_chain,
    hints=(
        "First the covariance before the closure. Landmarks i and k have the errors of some steps in common: which?",
        "cov(i, k) is the sum of q over the steps that both share: up to the smaller of i and k. The measurement sees "
        "the last landmark only, so H = [0 ... 0 1] and P H' is the last column of P.",
        "C = np.cumsum(q), P = np.minimum.outer(C, C), K = P[:, -1] / (P[-1, -1] + R); then K z and P - K H P.",
    ),
)


def _case(rng, n):
    return rng.uniform(0.01, 0.1, n), float(rng.uniform(0.005, 0.05)), float(rng.uniform(0.2, 1.0))


def _out(result, n):
    dx, P = expect.results(result, "dx", "P")
    return expect.array(dx, n, "dx"), expect.array(P, (n, n), "P")


def _truth(q, R, z):
    """By adding information: the steps are the states, the closure measures their sum."""
    n = len(q)
    L = np.tril(np.ones((n, n)))
    S = np.linalg.inv(np.diag(1 / q) + np.ones((n, n)) / R)
    return L @ S @ np.ones(n) * z / R, L @ S @ L.T


@chain.link("shapes", "dx has n numbers, P is n x n.")
def _(f, rng):
    for n in (4, 7, 1):
        _out(f(*_case(rng, n)), n)


@chain.link("the last landmark", "The measured landmark moves by q/(q + R) times z, where q is its variance.", part=0)
def _(f, rng):
    for n in (5, 1):
        q, R, z = _case(rng, n)
        expect.close(_out(f(q, R, z), n)[0][-1], q.sum() / (q.sum() + R) * z, "dx[-1]", at=f"{n} steps")


@chain.link("all landmarks move", "What corrects the last landmark corrects all that share errors with it: K has n "
            "entries.", part=0)  # fmt: skip
def _(f, rng):
    for n in (5, 9):
        q, R, z = _case(rng, n)
        expect.close(_out(f(q, R, z), n)[0], _truth(q, R, z)[0], "dx")


@chain.link("an exact closure", "With R = 0 the last landmark is known exactly, and the gap is closed entirely.")
def _(f, rng):
    q, _, z = _case(rng, 6)
    dx, P = _out(f(q, 0.0, z), 6)
    expect.close(dx[-1], z, "dx[-1] for R = 0")
    expect.close(P[-1], np.zeros(6), "the last row of P for R = 0", atol=1e-12)


@chain.link("the variances afterwards", "P - K H P: what is the variance of each landmark now?", part=1)
def _(f, rng):
    for n in (5, 8):
        q, R, z = _case(rng, n)
        expect.close(np.diag(_out(f(q, R, z), n)[1]), np.diag(_truth(q, R, z)[1]), "the diagonal of P")


@chain.link("the covariance afterwards", "P - K H P has all covariances between the landmarks, too.", part=1)
def _(f, rng):
    for n in (5, 8, 2):
        q, R, z = _case(rng, n)
        P = _out(f(q, R, z), n)[1]
        expect.close(P, _truth(q, R, z)[1], "P")
        expect.symmetric(P, "P", 1e-6)
        expect.psd(P, "P")


@chain.link("an unseen landmark becomes better", "The variance of each landmark must fall, not only of the last.")
def _(f, rng):
    q, R, z = _case(rng, 10)
    fall = 1 - np.diag(_out(f(q, R, z), 10)[1]) / np.cumsum(q)
    expect.true(fall.min() > 0, f"landmark {int(fall.argmin()) + 1} has not become better")


@chain.link("negative gap, long chain", "Nothing here depends on the sign of z or on the number of steps.")
def _(f, rng):
    q, R, z = _case(rng, 30)
    q[12] = 1.0  # a slip of the wheels
    dx, P = _out(f(q, R, -z), 30)
    want = _truth(q, R, -z)
    expect.close(dx, want[0], "dx")
    expect.close(P, want[1], "P")


def _wrong(name, hint, before=None, K=None, after=None, dx=None):
    """The solution with one step replaced."""

    @chain.wrong(name, hint)
    def _(q, R, z):
        C = np.cumsum(q)
        P = np.minimum.outer(C, C) if before is None else before(q, C)
        k = P[:, -1] / (P[-1, -1] + R) if K is None else K(P, R)
        new = P - np.outer(k, P[-1]) if after is None else after(P, k, R)
        return k * z if dx is None else dx(k, z), new


# fmt: off
_wrong("landmarks without a common error", "A diagonal covariance says: no common errors. But landmarks 3 and 5 share "
       "the errors of the steps 1, 2 and 3.", before=lambda q, C: np.diag(C))
_wrong("each landmark has its own step only", "The errors add up along the way: landmark k has those of all steps "
       "1 to k.", before=lambda q, C: np.diag(q))
_wrong("only the last landmark moves", "Only the seen landmark was corrected. The others share its errors: the gain K "
       "has an entry for each of them.",
       K=lambda P, R: np.eye(len(P))[-1] * P[-1, -1] / (P[-1, -1] + R))
_wrong("all move alike", "Landmark 1 has the error of one step, the last one those of all steps: they cannot all move "
       "by the same amount.", K=lambda P, R: np.full(len(P), P[-1, -1] / (P[-1, -1] + R)))
_wrong("equal shares", "The gap is not spread evenly over the steps: where the odometry was bad, more of it belongs. "
       "Use q.", K=lambda P, R: np.arange(1, len(P) + 1) / len(P) * P[-1, -1] / (P[-1, -1] + R))
_wrong("R forgotten", "The closure has noise, too: divide by P_nn + R.", K=lambda P, R: P[:, -1] / P[-1, -1])
_wrong("R squared", "R is a variance already: do not square it.", K=lambda P, R: P[:, -1] / (P[-1, -1] + R**2))
_wrong("R as a standard deviation", "R is a variance already: take no root.",
       K=lambda P, R: P[:, -1] / (P[-1, -1] + np.sqrt(R)))
_wrong("the larger of the two", "Landmarks i and k share the steps up to the *smaller* of the two.",
       before=lambda q, C: np.maximum.outer(C, C))
_wrong("standard deviations added", "Independent errors: their variances add up, not their standard deviations.",
       before=lambda q, C: np.minimum.outer(np.cumsum(np.sqrt(q)) ** 2, np.cumsum(np.sqrt(q)) ** 2))
_wrong("q squared", "q holds variances already: do not square them.",
       before=lambda q, C: np.minimum.outer(np.cumsum(q**2), np.cumsum(q**2)))
_wrong("sign of dx", "z is measurement minus expectation: the landmarks move by + K z.", dx=lambda k, z: -k * z)
_wrong("gain returned", "K is the share of the gap: dx = K z.", dx=lambda k, z: k)
_wrong("P as before", "x was corrected, P was not: P - K H P.", after=lambda P, k, R: P)
_wrong("P grows", "A measurement takes uncertainty away: P *minus* K H P.",
       after=lambda P, k, R: P + np.outer(k, P[-1]))
_wrong("K K' without Z", "The loss is K Z K' with Z = P_nn + R; yours is K K'.",
       after=lambda P, k, R: P - np.outer(k, k))
_wrong("only the variance of the last", "All entries of P change, not only the last one: P - K H P.",
       after=lambda P, k, R: P - np.diag(np.eye(len(P))[-1]) * k[-1] * P[-1, -1])
_wrong("only the diagonal of P", "P has the covariances between the landmarks, too: they do not vanish.",
       after=lambda P, k, R: np.diag(np.diag(P - np.outer(k, P[-1]))))
# fmt: on


@chain.variant("a triangular matrix, Joseph form")
def _(q, R, z):
    n = len(q)
    L = np.tril(np.ones((n, n)))
    P, H = L @ np.diag(q) @ L.T, np.zeros((1, n))
    H[0, -1] = 1
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(n) - K @ H
    return (K * z).ravel(), A @ P @ A.T + K @ K.T * R


@chain.variant("loops and lists")
def _(q, R, z):
    n = len(q)
    P = [[float(sum(q[: min(i, j) + 1])) for j in range(n)] for i in range(n)]
    K = [P[i][n - 1] / (P[n - 1][n - 1] + R) for i in range(n)]
    return [k * z for k in K], [[P[i][j] - K[i] * P[n - 1][j] for j in range(n)] for i in range(n)]


@chain.variant("correct the steps, then add them up")
def _(q, R, z):
    K = np.array(q) / (np.sum(q) + R)
    S = np.diag(q) - np.outer(K, q)
    return np.cumsum(K * z), np.cumsum(np.cumsum(S, 0), 1)
