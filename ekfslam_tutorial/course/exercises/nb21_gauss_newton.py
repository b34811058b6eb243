"""Exercise 21.2: one step of Gauss-Newton, the normal equations."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def gauss_newton_step(H, z, R):
    """Correction of all unknowns by all measurements at once, and how much is known after it.

    H, shape (m, n), m >= n: Jacobian of all m measured numbers by all n unknowns. z, shape (m,): measured minus
    expected. R, shape (m, m): covariance of the measurements.
    Return dx, shape (n,): what to add to the unknowns; and the information matrix A, shape (n, n), the inverse of
    their covariance.
    """
    W = np.linalg.solve(R, H)  # R^-1 H
    A = H.T @ W
    return np.linalg.solve(A, W.T @ z), A


exercise = Exercise(
    "21.2",
    "A step of Gauss-Newton",
    gauss_newton_step,
    hints=(
        "Find the dx for which z - H dx is smallest, each number in units of its sigma.",
        "The cost is (z - H dx)' R^-1 (z - H dx). Its derivative by dx is zero where H' R^-1 H dx = H' R^-1 z.",
        "A = H' R^-1 H, b = H' R^-1 z, dx = np.linalg.solve(A, b). Return dx and A.",
    ),
)


def case(rng, n=4, m=9):
    """Measurements with different units, and noise that hangs together."""
    H = rng.normal(size=(m, n)) * rng.uniform(0.3, 3, (m, 1))
    return H, rng.normal(size=m), random_covariance(rng, m, 0.3)


def two(result, n):
    """Return the results dx and A as arrays."""
    dx, A = expect.results(result, "dx", "A")
    return expect.array(dx, n, "dx"), expect.array(A, (n, n), "A")


@exercise.link("two results", "The function must end with `return dx, A`.")
def _(f, rng):
    for n, m in ((4, 9), (1, 1), (2, 2)):
        two(f(*case(rng, n, m)), n)


@exercise.link("equal noise", "With R = I this is ordinary least squares: H' H dx = H' z.", 0)
def _(f, rng):
    for n, m in ((3, 8), (2, 5)):
        H, z, _ = case(rng, n, m)
        dx = two(f(H, z, np.eye(m)), n)[0]
        expect.close(dx, np.linalg.lstsq(H, z, rcond=None)[0], "dx for R = I")


@exercise.link("weights", "A measurement counts by the inverse of its variance: R^-1, not R.", 0)
def _(f, rng):
    for n, m in ((3, 8), (2, 5)):
        H, z, _ = case(rng, n, m)
        R = np.diag(rng.uniform(0.1, 3, m))
        expect.close(two(f(H, z, R), n)[0], gauss_newton_step(H, z, R)[0], "dx for a diagonal R")


@exercise.link("noise that hangs together", "R need not be diagonal: use its inverse as a matrix.", 0)
def _(f, rng):
    for n, m in ((4, 9), (1, 3)):
        c = case(rng, n, m)
        expect.close(two(f(*c), n)[0], gauss_newton_step(*c)[0], "dx")


@exercise.link("information", "A = H' R^-1 H; its inverse is the covariance of the unknowns.", 1)
def _(f, rng):
    for n, m in ((4, 9), (2, 3), (1, 4)):
        c = case(rng, n, m)
        A = two(f(*c), n)[1]
        expect.close(A, gauss_newton_step(*c)[1], "A")
        expect.symmetric(A, "A", 1e-6)


@exercise.link("a fit that is perfect", "Where z = H d exactly, the step must be d, whatever the noise.", 0)
def _(f, rng):
    H, _, R = case(rng, 5, 7)
    d = rng.normal(size=5)
    expect.close(two(f(H, H @ d, R), 5)[0], d, "dx")


@exercise.link("small noise", "Noise of a millimetre or of 100 m: only the ratios count for dx.", 0)
def _(f, rng):
    H, z, R = case(rng, 3, 6)
    for scale in (1e-6, 1e4):
        got = two(f(H, z, scale * R), 3)
        expect.close(got[0], gauss_newton_step(H, z, R)[0], f"dx with R of the size {scale:g}", 1e-4)
        expect.close(got[1] * scale, gauss_newton_step(H, z, R)[1], "A times that size", 1e-4)


# ---- wrong and right answers ---------------------------------------------------------------------------------------


def _wrong(name, hint, dx, A=None):
    def answer(H, z, R):
        right = gauss_newton_step(H, z, R)
        return dx(H, np.asarray(z), np.asarray(R), *right), right[1] if A is None else A(H, R, right[1])

    exercise.wrong(name, hint)(answer)


inv = np.linalg.inv
plain = lambda H, z, R, dx, A: inv(H.T @ H) @ H.T @ z
right = lambda H, z, R, dx, A: dx
# fmt: off
_wrong("noise forgotten", "All measurements count the same in your answer. Weigh them: H' R^-1 H dx = H' R^-1 z.",
       plain, lambda H, R, A: H.T @ H)
_wrong("noise forgotten in dx", "The right side needs R^-1, too: both sides of the normal equations are weighted.",
       plain)
_wrong("R instead of its inverse", "A large variance must make a measurement count *less*: R^-1, not R.",
       lambda H, z, R, dx, A: inv(H.T @ R @ H) @ H.T @ R @ z, lambda H, R, A: H.T @ R @ H)
_wrong("only the diagonal of R", "R^-1 as a matrix: covariances count, too.",
       lambda H, z, R, dx, A: gauss_newton_step(H, z, np.diag(np.diag(R)))[0],
       lambda H, R, A: gauss_newton_step(H, np.zeros(len(H)), np.diag(np.diag(R)))[1])
_wrong("weights on one side", "Weigh both sides: H' R^-1 H dx = H' R^-1 z.",
       lambda H, z, R, dx, A: inv(A) @ H.T @ z)
_wrong("sigma for variance", "R holds variances: weigh with R^-1, not with its root.",
       lambda H, z, R, dx, A: gauss_newton_step(H, z, np.diag(np.sqrt(np.diag(R))))[0],
       lambda H, R, A: gauss_newton_step(H, np.zeros(len(H)), np.diag(np.sqrt(np.diag(R))))[1])
_wrong("opposite direction", "z is measured minus expected: add dx, do not subtract it. The sign is plus.",
       lambda H, z, R, dx, A: -dx)
_wrong("a step downhill", "H' R^-1 z is the direction of steepest descent. Solve with A = H' R^-1 H.",
       lambda H, z, R, dx, A: A @ dx)
_wrong("half a step", "The whole step: dx solves A dx = H' R^-1 z.", lambda H, z, R, dx, A: dx / 2)
_wrong("covariance returned", "A is the information matrix. Its inverse is the covariance.", right,
       lambda H, R, A: inv(A))
_wrong("information of the measurements", "A belongs to the unknowns, n x n: H' R^-1 H.", right,
       lambda H, R, A: np.diag(np.diag(A)))
_wrong("information without noise", "A = H' R^-1 H: R^-1 is missing.", right, lambda H, R, A: H.T @ H)
_wrong("twice the information", "A = H' R^-1 H, without a factor 2.", right, lambda H, R, A: 2 * A)
# fmt: on


@exercise.variant("whitened, by least squares")
def _(H, z, R):
    L = np.linalg.cholesky(R)
    J, r = np.linalg.solve(L, H), np.linalg.solve(L, z)
    return np.linalg.lstsq(J, r, rcond=None)[0], J.T @ J


@exercise.variant("inverses, lists")
def _(H, z, R):
    A = H.T @ np.linalg.inv(R) @ H
    return (np.linalg.inv(A) @ H.T @ np.linalg.inv(R) @ z).tolist(), A.tolist()


@exercise.variant("by QR")
def _(H, z, R):
    W = np.linalg.inv(np.linalg.cholesky(R))
    Q, U = np.linalg.qr(W @ H)
    return np.linalg.solve(U, Q.T @ (W @ z)), U.T @ U
