"""Exercise 06.2: a loop in one dimension, and what its closure does to all landmarks."""

import numpy as np

from .. import expect
from ..table import table


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


def some(rng, n):
    """Return the variances of n steps, and a closure."""
    return rng.uniform(0.01, 0.1, n), float(rng.uniform(0.005, 0.05)), float(rng.uniform(0.2, 1.0))


def exact(rng):
    """Return a closure without noise."""
    q, _, z = some(rng, 6)
    return q, 0.0, z


def slipped(rng):
    """Return a long chain with a negative gap, in which the wheels slipped once."""
    q, R, z = some(rng, 30)
    q[12] = 1.0
    return q, R, -z


chain = table(
    "06.2 Closing a chain",
    close_chain,
    hints=(
        "First the covariance before the closure. Landmarks i and k have the errors of some steps in common: which?",
        "cov(i, k) is the sum of q over the steps that both share: up to the smaller of i and k. The measurement sees the last landmark only, so H = [0 ... 0 1] and P H' is the last column of P.",
        "C = np.cumsum(q), P = np.minimum.outer(C, C), K = P[:, -1] / (P[-1, -1] + R); then K z and P - K H P.",
    ),
    returns="dx, P",
    symbols="P_nn = the variance of the last landmark before the closure",
    cases={
        "any": lambda rng: [some(rng, n) for n in (4, 7, 1)],
        "sizes": lambda rng: [some(rng, n) for n in (5, 9, 2, 1)],
        "exact": lambda rng: [exact(rng)],
        "slipped": lambda rng: [slipped(rng)],
    },
    checks="""
    shapes                          | dx[:0], P[:0] | any | dx has n numbers, P is n x n.
    the last landmark               | dx[-1] | sizes   | The last landmark is measured. It moves by P_nn/(P_nn + R) times z, and its variance P_nn is the sum of all q.
    all landmarks move              | dx     | sizes   | What corrects the last landmark corrects all that share errors with it. K has an entry for each landmark: which steps do landmark i and the last one share?
    an exact closure                | dx, P[-1] | exact | With R = 0 the last landmark is known exactly, and the gap is closed entirely: P - K Z K' has zeros in its row. Before it, P_ik is the sum of the errors that both share.
    the covariance afterwards       | P      | sizes   | P - K H P, in every entry. Before the closure, the covariance P_ik of landmarks i and k is the sum of the q of the steps that both share.
    negative gap, long chain        | dx, P  | slipped | 30 steps, z is negative, and one step has the variance 1 m^2. The formulas are those of a short chain: dx = K z is negative here, and P does not depend on z.
    """,
    wrong="""
    landmarks without a common error | np.minimum.outer(C, C) -> np.diag(C) | A diagonal covariance says: no common errors. But landmarks 3 and 5 share the errors of the steps 1, 2 and 3.
    each landmark has its own step only | np.minimum.outer(C, C) -> np.diag(q) | The errors add up along the way: landmark k has those of all steps 1 to k.
    steps not added up | C = np.cumsum(q) -> C = q | The errors add up along the way: landmark k has the variance of all steps 1 to k, C = np.cumsum(q).
    only the last landmark moves | K = P[:, -1] / -> K = np.eye(len(P))[-1] * P[-1, -1] / | Only the seen landmark was corrected. The others share its errors: the gain K has an entry for each of them.
    all move alike | K = P[:, -1] / -> K = np.ones(len(P)) * P[-1, -1] / | Landmark 1 has the error of one step, the last one those of all steps: they cannot all move by the same amount.
    last step alone in Z | K = P[:, -1] / (P[-1, -1] + R) -> K = P[:, -1] / (q[-1] + R) | Z = P_nn + R, and the last landmark has the errors of all steps: its variance P_nn is the sum of all q, not the last one. Here P_nn = the variance of the last landmark before the closure.
    equal shares | K = P[:, -1] / -> K = np.arange(1, len(P) + 1) / len(P) * P[-1, -1] / | The gap is not spread evenly over the steps: where the odometry was bad, more of it belongs. Use q.
    R forgotten | (P[-1, -1] + R) -> P[-1, -1] | The closure has noise, too: divide by P_nn + R.
    P_nn forgotten | (P[-1, -1] + R) -> R | The gain divides by the whole uncertainty of the innovation, P_nn + R, not by R alone.
    R squared | (P[-1, -1] + R) -> (P[-1, -1] + R**2) | R is a variance already: do not square it.
    R as a standard deviation | (P[-1, -1] + R) -> (P[-1, -1] + np.sqrt(R)) | R is a variance already: take no root.
    the larger of the two | np.minimum.outer -> np.maximum.outer | Landmarks i and k share the steps up to the *smaller* of the two.
    one step less | C = np.cumsum(q) -> C = np.cumsum(q) - q | Landmark k is put down *after* step k: it has the errors of the steps 1 to k, step k included.
    the first landmark measured: Back at the start, the *last* landmark is measured: H = [0 ... 0 1], and P H' is the last column of P.
        K = P[:, -1] / (P[-1, -1] + R) -> K = P[:, 0] / (P[0, 0] + R)
        np.outer(K, P[-1]) -> np.outer(K, P[0])
    standard deviations added | np.cumsum(q) -> np.cumsum(np.sqrt(q)) ** 2 | Independent errors: their variances add up, not their standard deviations.
    q squared | np.cumsum(q) -> np.cumsum(q**2) | q holds variances already: do not square them.
    sign of dx | return K * z -> return -K * z | z is measurement minus expectation: the landmarks move by + K z.
    gain returned | return K * z -> return K | K is the share of the gap: dx = K z.
    P - K H, the last P forgotten | P - np.outer(K, P[-1]) -> np.eye(len(P)) - np.outer(K, np.eye(len(P))[-1]) | (I - K H) must still be multiplied by P: P - K H P.
    P as before | P - np.outer(K, P[-1]) -> P | x was corrected, P was not: P - K H P.
    P grows | P - np.outer -> P + np.outer | A measurement takes uncertainty away: P *minus* K H P.
    K K' without Z | np.outer(K, P[-1]) -> np.outer(K, K) | The loss is K Z K' with Z = P_nn + R; yours is K K'.
    K R K' | np.outer(K, P[-1]) -> np.outer(K, K) * R | The loss is K Z K' with Z = P_nn + R; yours has R alone.
    only the variance of the last | np.outer(K, P[-1]) -> np.diag(np.eye(len(P))[-1]) * K[-1] * P[-1, -1] | All entries of P change, not only the last one: P - K H P.
    only the diagonal of P | P - np.outer(K, P[-1]) -> np.diag(np.diag(P - np.outer(K, P[-1]))) | P has the covariances between the landmarks, too: they do not vanish.
    errors of the steps behind | np.minimum.outer(C, C) -> np.minimum.outer(np.cumsum(q[::-1])[::-1], np.cumsum(q[::-1])[::-1]) | Landmark k has the errors of the steps 1 to k, which lie before it, and not those of the steps behind it.
    product of K and P as a number | np.outer(K, P[-1]) -> K @ P[-1] | K is a vector: `K @ K`, `K @ K.T` and `K @ P[-1]` are one number, taken off all of P. What is taken off is a matrix, the outer product K H P = K Z K' = np.outer(K, P[-1]).
    Joseph without the noise | P - np.outer(K, P[-1]) -> (A := np.eye(len(P)) - np.outer(K, np.eye(len(P))[-1])) @ P @ A.T | P - K H P is (I - K H) P, with (I - K H) once. With it on both sides, as in Joseph's form, a second term belongs there: + K R K'.
    P_nn twice in Z | (P[-1, -1] + R) -> (2 * P[-1, -1] + R) | The error of the way counts once: Z = P_nn + R.
    what is left of z | return K * z -> return z - K * z | dx = K z is by how much each landmark moves, not what is left of z.
    """,
    forms="""
    P - K Z K' | np.outer(K, P[-1]) -> np.outer(K, K) * (P[-1, -1] + R) | P - K Z K'
    """,
)

VARIANCES = "P - K H P: what is the variance of each landmark now?"


def variances(f, args):
    """Return a student's variances after a closure."""
    n = len(args[0])
    return np.diag(expect.array(expect.results(f(*args), "dx", "P")[1], (n, n), "P"))


@chain.link("the variances afterwards", VARIANCES, 1, "the covariance afterwards")
def _(f, rng):
    for args in (some(rng, 5), some(rng, 8)):
        expect.close(variances(f, args), np.diag(close_chain(*args)[1]), "the diagonal of P")


BETTER = "After the closure the variance of each landmark is smaller than before, of the unseen ones, too."


@chain.link("an unseen landmark becomes better", BETTER, None, "negative gap, long chain")
def _(f, rng):
    args = some(rng, 10)
    fall = 1 - variances(f, args) / np.cumsum(args[0])
    expect.true(fall.min() > 0, f"landmark {int(fall.argmin()) + 1} has not become better")
