"""Exercise 08.3: the covariance after a correction, for any gain."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def joseph(P, K, H, R):
    """Covariance after the correction x + K (y - H x), for any gain K.

    P, shape (n, n): covariance of x; H, shape (m, n): Jacobian of the measurement; R, shape (m, m): its noise.
    K, shape (n, m): the gain that was used, the best one or not.
    Return the new P, shape (n, n): symmetric, and never with a negative eigenvalue.
    """
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T + K @ R @ K.T


def best_gain(P, H, R):
    """Gain of the Kalman filter."""
    return np.linalg.solve(H @ P @ H.T + R, H @ P).T


def some(rng, n, m, share=None):
    """Return the arguments with a share of the best gain; None: with a gain at random."""
    P, H, R = random_covariance(rng, n), rng.normal(size=(m, n)), random_covariance(rng, m, 0.3)
    return P, rng.normal(size=(n, m)) * 0.4 if share is None else share * best_gain(P, H, R), H, R


def numbers(*found):
    """Return matrices of one number."""
    return [tuple(np.array([[value]]) for value in values) for values in found]


form = table(
    "08.3 Joseph form",
    joseph,
    hints=(
        "Write the error after the correction. Let dx be the error before, v the noise: y = H x + v.",
        "The new error is (I - K H) dx - K v. dx and v are independent: their covariances add up.",
        "P_new = (I - K H) P (I - K H)' + K R K'. I has the size of P.",
    ),
    returns="P",
    cases={
        "any": lambda rng: [some(rng, n, m) for n, m in ((5, 2), (3, 3), (2, 4), (4, 1), (1, 1))],
        "zero": lambda rng: [some(rng, n, m, 0.0) for n, m in ((5, 2), (3, 1))],
        "best": lambda rng: [some(rng, n, m, 1.0) for n, m in ((5, 2), (3, 3), (2, 4), (7, 1))],
        "one number": lambda rng: numbers((4.0, 0.5, 1.0, 1.0), (2.0, 0.3, 2.0, 5.0)),
    },
    checks="""
    shape      | P[:0] | any        | P keeps its shape (n, n), whatever the number m of measurements.
    gain zero  | P     | zero       | With K = 0 the measurement is ignored: P must stay as it is.
    best gain  | P     | best       | K is the gain of the Kalman filter here. The new P is the sum of (I - K H) P (I - K H)' and K R K', with the whole R; the sum of both is (I - K H) P at this gain.
    any gain   | P     | any        | The gain may be any one: the new P is the sum of two terms, (I - K H) P (I - K H)' and K R K'.
    one number | P     | one number | n = m = 1, P = 4, H = 1, R = 1, K = 0.5: the new error is 0.5 dx - 0.5 v.
    """,
    wrong="""
    the short form | A @ P @ A.T + K @ R @ K.T -> A @ P | (I - K H) P is right for the best gain only. For any gain: (I - K H) P (I - K H)' + K R K'.
    the short form, made symmetric | A @ P @ A.T + K @ R @ K.T -> (A @ P + (A @ P).T) / 2 | Making (I - K H) P symmetric hides the trouble: for another gain the numbers are still wrong. Add up the covariances of (I - K H) dx and K v.
    P - K Z K' | A @ P @ A.T + K @ R @ K.T -> P - K @ (H @ P @ H.T + R) @ K.T | P - K Z K' is right for the best gain only. Start from the new error, (I - K H) dx - K v.
    noise forgotten | A.T + K @ R @ K.T -> A.T | The noise of the measurement enters the new error, too: add K R K'.
    noise subtracted | A.T + K -> A.T - K | Covariances of independent errors add up: plus K R K'.
    noise only | A @ P @ A.T + K -> K | The old error does not vanish: (I - K H) P (I - K H)' is the first of two terms.
    R without the gain | K @ R @ K.T -> (R if R.shape == P.shape else R.mean() * np.eye(len(P))) | v reaches the state through the gain: K R K', not R.
    K K' | K @ R @ K.T -> K @ K.T | The noise has the covariance R: K R K', not K K'.
    transpose on the wrong side | A @ P @ A.T -> A.T @ P @ A | cov(A dx) = A P A': the transpose stands on the right.
    transpose forgotten | A @ P @ A.T -> A @ P @ A | cov(A dx) = A P A': the second A is transposed.
    transpose forgotten, made symmetric | A @ P @ A.T -> (A @ P @ A + (A @ P @ A).T) / 2 | cov(A dx) = A P A': the second A is transposed. Making the result symmetric does not mend it.
    plus K H | - K @ H -> + K @ H | A correction takes error away: I - K H.
    identity forgotten | np.eye(len(P)) - K @ H -> -K @ H | The error before does not vanish: I - K H, with the identity.
    (I - K H) on one side only | A @ P @ A.T -> A @ P | A covariance is multiplied from both sides: (I - K H) P (I - K H)'.
    R squared | K @ R @ K.T -> K @ R @ R @ K.T | R holds variances already: do not square it.
    square root of R | K @ R @ K.T -> K @ np.sqrt(np.abs(R)) @ K.T | R holds variances, and K R K' needs variances: no square root.
    R taken as diagonal | K @ R @ K.T -> K @ np.diag(np.diag(R)) @ K.T | The noises of one measurement may be correlated: use the whole R.
    another gain | A = np.eye -> K = best_gain(P, H, R); A = np.eye | Use the gain K that you are given: it is the one the mean was corrected with.
    Z for R | K @ R @ K.T -> K @ (H @ P @ H.T + R) @ K.T | In the new error only the noise v goes through the gain: K R K'. Z = H P H' + R has the old error in it, too, which (I - K H) has counted already.
    P for I | np.eye(len(P)) - K @ H -> P - K @ H | The new error is (I - K H) dx - K v: the identity stands there, not P.
    diagonal counted twice: A matrix made symmetric from its upper triangle has its diagonal once: the variances of yours are doubled. (P + P') / 2 does it.
        return A @ P @ A.T + K @ R @ K.T -> S = A @ P @ A.T + K @ R @ K.T; return np.triu(S) + np.triu(S).T
    inverse of R | K @ R @ K.T -> K @ np.linalg.inv(R) @ K.T | The noise v has the covariance R: K R K', not its inverse.
    absolute values | return A @ P @ A.T + K @ R @ K.T -> return np.abs(A @ P @ A.T + K @ R @ K.T) | A covariance may have negative entries off its diagonal. What may not be negative are its eigenvalues.
    last term forgotten, multiplied out | A @ P @ A.T + K @ R @ K.T -> P - K @ H @ P - P @ H.T @ K.T + K @ R @ K.T | Multiplied out, (I - K H) P (I - K H)' has four terms: + K H P H' K' is missing.
    """,
)


@form.link("a cloud of errors", "Draw dx and v, compute the new errors: they must scatter as P says.")
def _(f, rng):
    P, K, H, R = some(rng, 3, 2, 0.5)
    dx = rng.standard_normal((4000, 3)) @ np.linalg.cholesky(P).T
    v = rng.standard_normal((4000, 2)) @ np.linalg.cholesky(R).T
    new = dx - (dx @ H.T + v) @ K.T
    ratio = np.linalg.eigvals(np.linalg.solve(expect.array(f(P, K, H, R), (3, 3), "P"), np.cov(new.T))).real
    # 4000 draws: a variance is right within 3.3 sqrt(2 / 4000) = 7.4 % (99.9 %), an eigenvalue within 12 %
    expect.true(np.all(np.abs(ratio - 1) < 0.12), f"the cloud is {ratio.max():.2f} times as large as your P (variance)")


@form.link("single precision", "In float32 P must stay positive semi-definite, however good the measurement.")
def _(f, rng):
    for _ in range(5):
        P, _, H, R = some(rng, 5, 2)
        P, H, R = (a.astype(np.float32) for a in (1e3 * P, H, 1e-6 * R))
        new = expect.array(f(P, best_gain(P, H, R), H, R), (5, 5), "P")
        low = float(np.linalg.eigvalsh((new + new.T) / 2)[0])
        # rounding of the two products: a few times 6e-8 of the entries of the result itself
        floor = -1e-5 * np.abs(new).max()
        expect.true(low >= floor, f"P has the eigenvalue {low:.2g} in float32, its largest entry is {new.max():.2g}")
