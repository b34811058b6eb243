"""Exercise 08.3: the covariance after a correction, for any gain."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def joseph(P, K, H, R):
    """Covariance after the correction x + K (y - H x), for any gain K.

    P, shape (n, n): covariance of x; H, shape (m, n): Jacobian of the measurement; R, shape (m, m): its noise.
    K, shape (n, m): the gain that was used, the best one or not.
    Return the new P, shape (n, n): symmetric, and never with a negative eigenvalue.
    """
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T + K @ R @ K.T


form = Exercise(
    "08.3",
    "Joseph form",
    joseph,
    hints=(
        "Write the error after the correction. Let dx be the error before, v the noise: y = H x + v.",
        "The new error is (I - K H) dx - K v. dx and v are independent: their covariances add up.",
        "P_new = (I - K H) P (I - K H)' + K R K'. I has the size of P.",
    ),
)


def best_gain(P, H, R):
    """Gain of the Kalman filter."""
    return np.linalg.solve(H @ P @ H.T + R, H @ P).T


def case(rng, n, m):
    """Return P, H, R at random."""
    return random_covariance(rng, n), rng.normal(size=(m, n)), random_covariance(rng, m, 0.3)


def _P(result, n):
    return expect.array(result, (n, n), "P")


@form.link("shape", "P keeps its shape (n, n), whatever the number m of measurements.")
def _(f, rng):
    for n, m in ((5, 2), (1, 1), (3, 3), (2, 4)):
        P, H, R = case(rng, n, m)
        _P(f(P, best_gain(P, H, R), H, R), n)


@form.link("gain zero", "With K = 0 the measurement is ignored: P must stay as it is.")
def _(f, rng):
    for n, m in ((5, 2), (3, 1)):
        P, H, R = case(rng, n, m)
        expect.close(_P(f(P, np.zeros((n, m)), H, R), n), P, "P for K = 0")


@form.link("best gain", "With the gain of the Kalman filter it must be what (I - K H) P gives.")
def _(f, rng):
    for n, m in ((5, 2), (3, 3), (2, 4), (7, 1)):
        P, H, R = case(rng, n, m)
        K = best_gain(P, H, R)
        expect.close(_P(f(P, K, H, R), n), P - K @ H @ P, "P for the best gain", 1e-5)


@form.link("any gain", "The gain may be another one: both terms are needed, (I - K H) P (I - K H)' and K R K'.")
def _(f, rng):
    for n, m in ((5, 2), (3, 3), (2, 4), (4, 1)):
        P, H, R = case(rng, n, m)
        K = rng.normal(size=(n, m)) * 0.4
        KHP = K @ H @ P
        want = P - KHP - KHP.T + K @ (H @ P @ H.T + R) @ K.T
        got = _P(f(P, K, H, R), n)
        expect.close(got, want, "P for a gain at random", 1e-5)
        expect.symmetric(got, "P", 1e-7)


@form.link("one number", "n = m = 1, P = 4, H = 1, R = 1, K = 0.5: the new error is 0.5 dx - 0.5 v.")
def _(f, rng):
    a = lambda v: np.array([[v]])
    for P, K, H, R in ((4.0, 0.5, 1.0, 1.0), (2.0, 0.3, 2.0, 5.0)):
        want = (1 - K * H) ** 2 * P + K**2 * R
        expect.close(_P(f(a(P), a(K), a(H), a(R)), 1), a(want), f"P for P = {P:g}, K = {K:g}, H = {H:g}, R = {R:g}")


@form.link("a cloud of errors", "Draw dx and v, compute the new errors: they must scatter as P says.")
def _(f, rng):
    P, H, R = case(rng, 3, 2)
    K = 0.5 * best_gain(P, H, R)
    dx = rng.standard_normal((4000, 3)) @ np.linalg.cholesky(P).T
    v = rng.standard_normal((4000, 2)) @ np.linalg.cholesky(R).T
    new = dx - (dx @ H.T + v) @ K.T
    ratio = np.linalg.eigvals(np.linalg.solve(_P(f(P, K, H, R), 3), np.cov(new.T))).real
    # 4000 draws: a variance is right within 3.3 sqrt(2 / 4000) = 7.4 % (99.9 %), an eigenvalue within 12 %
    expect.true(np.all(np.abs(ratio - 1) < 0.12), f"the cloud is {ratio.max():.2f} times as large as your P (variance)")


@form.link("single precision", "In float32 P must stay positive semi-definite, however good the measurement.")
def _(f, rng):
    for _ in range(5):
        P, H, R = case(rng, 5, 2)
        P, H, R = (a.astype(np.float32) for a in (1e3 * P, H, 1e-6 * R))
        K = best_gain(P, H, R)
        new = _P(f(P, K, H, R), 5)
        low = float(np.linalg.eigvalsh((new + new.T) / 2)[0])
        # rounding of the two products: a few times 6e-8 of the entries of the result itself
        floor = -1e-5 * np.abs(new).max()
        expect.true(low >= floor, f"P has the eigenvalue {low:.2g} in float32, its largest entry is {new.max():.2g}")


def _wrong(name, hint, answer):
    form.wrong(name, hint)(answer)


def _A(P, K, H):
    return np.eye(len(P)) - K @ H


# fmt: off
_wrong("the short form", "(I - K H) P is right for the best gain only. For any gain: (I - K H) P (I - K H)' + K R K'.",
       lambda P, K, H, R: _A(P, K, H) @ P)
_wrong("the short form, made symmetric", "Making (I - K H) P symmetric hides the trouble: for another gain the numbers "
       "are still wrong. Add up the covariances of (I - K H) dx and K v.",
       lambda P, K, H, R: (B := _A(P, K, H) @ P) / 2 + B.T / 2)
_wrong("P - K Z K'", "P - K Z K' is right for the best gain only. Start from the new error, (I - K H) dx - K v.",
       lambda P, K, H, R: P - K @ (H @ P @ H.T + R) @ K.T)
_wrong("noise forgotten", "The noise of the measurement enters the new error, too: add K R K'.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T)
_wrong("noise subtracted", "Covariances of independent errors add up: plus K R K'.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T - K @ R @ K.T)
_wrong("R without the gain", "v reaches the state through the gain: K R K', not R.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T + (R if R.shape == P.shape else R.mean() * np.eye(len(P))))
_wrong("K K'", "The noise has the covariance R: K R K', not K K'.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T + K @ K.T)
_wrong("transpose on the wrong side", "cov(A dx) = A P A': the transpose stands on the right.",
       lambda P, K, H, R: (A := _A(P, K, H)).T @ P @ A + K @ R @ K.T)
_wrong("plus K H", "A correction takes error away: I - K H.",
       lambda P, K, H, R: (A := 2 * np.eye(len(P)) - _A(P, K, H)) @ P @ A.T + K @ R @ K.T)
_wrong("(I - K H) on one side only", "A covariance is multiplied from both sides: (I - K H) P (I - K H)'.",
       lambda P, K, H, R: _A(P, K, H) @ P + K @ R @ K.T)
_wrong("R squared", "R holds variances already: do not square it.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T + K @ R @ R @ K.T)
_wrong("R taken as diagonal", "The noises of one measurement may be correlated: use the whole R.",
       lambda P, K, H, R: (A := _A(P, K, H)) @ P @ A.T + K @ np.diag(np.diag(R)) @ K.T)
_wrong("another gain", "Use the gain K that you are given: it is the one the mean was corrected with.",
       lambda P, K, H, R: P - best_gain(P, H, R) @ H @ P)
# fmt: on


@form.variant("made symmetric at the end, as lists")
def _(P, K, H, R):
    A = np.identity(P.shape[0]) - np.dot(K, H)
    B = np.linalg.multi_dot([A, P, A.T]) + np.linalg.multi_dot([K, R, K.T])
    return ((B + B.T) / 2).tolist()


@form.variant("one product: [A, -K] times the joint covariance")
def _(P, K, H, R):
    n, m = K.shape
    B = np.hstack([np.eye(n) - K @ H, -K])
    S = np.block([[P, np.zeros((n, m))], [np.zeros((m, n)), R]])
    return B @ S @ B.T


@form.variant("square roots of P and R")
def _(P, K, H, R):
    A = (np.eye(len(P)) - K @ H) @ np.linalg.cholesky(P)
    B = K @ np.linalg.cholesky(R)
    return A @ A.T + B @ B.T
