"""Exercise 21.2: one step of Gauss-Newton, the normal equations."""

import numpy as np

from ..table import table
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
    dx = np.linalg.solve(A, W.T @ z)
    return dx, A


def case(rng, n=4, m=9, R=None, scale=1.0):
    """Measurements with different units, and correlated noise, or with the given R(rng, m)."""
    H = rng.normal(size=(m, n)) * rng.uniform(0.3, 3, (m, 1))
    return H, rng.normal(size=m), scale * (R(rng, m) if R else random_covariance(rng, m, 0.3))


def perfect(H, z, R):
    """Measurements that agree with one another."""
    return H, H @ z[: H.shape[1]], R


ONES, DIAGONAL = (lambda rng, m: np.eye(m)), (lambda rng, m: np.diag(rng.uniform(0.1, 3, m)))

exercise = table(
    "21.2 A step of Gauss-Newton",
    gauss_newton_step,
    hints=(
        "Find the dx for which z - H dx is smallest, each number in units of its sigma.",
        "The cost is (z - H dx)' R^-1 (z - H dx). Its derivative by dx is zero where H' R^-1 H dx = H' R^-1 z.",
        "A = H' R^-1 H, b = H' R^-1 z, dx = np.linalg.solve(A, b). Return dx and A.",
    ),
    returns="dx, A",
    cases={
        "any": lambda rng: [case(rng, *size) for size in ((4, 9), (1, 3), (2, 2), (2, 3), (1, 1))],
        "R = I": lambda rng: [case(rng, *size, ONES) for size in ((3, 8), (2, 5))],
        "diagonal": lambda rng: [case(rng, *size, DIAGONAL) for size in ((3, 8), (2, 5))],
        "perfect": lambda rng: [perfect(*case(rng, 5, 7))],
        "scaled": lambda rng: [case(rng, 3, 6, scale=scale) for scale in (1e-6, 1e4)],
    },
    checks="""
    equal noise | dx | R = I    | With R = I this is ordinary least squares: H' H dx = H' z.
    weights     | dx | diagonal | A measurement counts by the inverse of its variance, on both sides: H' R^-1 H dx = H' R^-1 z.
    correlated noise | dx | any | R is not diagonal here. The equation is the same, H' R^-1 H dx = H' R^-1 z, with the inverse of the whole matrix R.
    information | A  | any      | A = H' R^-1 H; its inverse is the covariance of the unknowns.
    a fit that is perfect | dx | perfect | Where z = H d exactly, the step must be d, whatever the noise.
    small noise | dx | scaled   | Noise of a millimetre or of 100 m: only the ratios count for dx.
    its information | A | scaled | A = H' R^-1 H; its inverse is the covariance of the unknowns.
    """,
    wrong="""
    noise forgotten | np.linalg.solve(R, H) -> H | All measurements count the same in your answer. Weigh them: H' R^-1 H dx = H' R^-1 z.
    noise forgotten in dx | np.linalg.solve(A, W.T @ z) -> np.linalg.solve(H.T @ H, H.T @ z) | dx is that of least squares without weights: both sides of what you solve need R^-1, H' R^-1 H dx = H' R^-1 z.
    R instead of its inverse | np.linalg.solve(R, H) -> R @ H | A large variance must make a measurement count *less*: R^-1, not R.
    only the diagonal of R | np.linalg.solve(R, H) -> np.linalg.solve(np.diag(np.diag(R)), H) | R^-1 as a matrix: covariances count, too.
    weights on one side | W.T @ z -> H.T @ z | The right side needs R^-1, too: H' R^-1 H dx = H' R^-1 z.
    sigma for variance | np.linalg.solve(R, H) -> np.linalg.solve(np.diag(np.sqrt(np.diag(R))), H) | R holds variances: weigh with R^-1, not with its root.
    opposite direction | return dx, A -> return -dx, A | z is measured minus expected: add dx, do not subtract it. The sign is plus.
    a step downhill | np.linalg.solve(A, W.T @ z) -> W.T @ z | H' R^-1 z is the direction of steepest descent. Solve with A = H' R^-1 H.
    half a step | return dx, A -> return dx / 2, A | The whole step: dx solves A dx = H' R^-1 z.
    covariance returned | return dx, A -> return dx, np.linalg.inv(A) | A is the information matrix. Its inverse is the covariance.
    information of the measurements | return dx, A -> return dx, np.diag(np.diag(A)) | A belongs to the unknowns, n x n: H' R^-1 H.
    information without noise | return dx, A -> return dx, H.T @ H | A = H' R^-1 H: R^-1 is missing.
    information with R | return dx, A -> return dx, H.T @ R @ H | A = H' R^-1 H: a large variance tells less, so R^-1, not R.
    mean of the information | return dx, A -> return dx, A / len(z) | Information adds up: A is a sum over the measurements, no mean. Do not divide it by their number.
    twice the information | return dx, A -> return dx, 2 * A | A = H' R^-1 H, without a factor 2.
    damped, or a prior | A = H.T @ W -> A = H.T @ W + np.eye(H.shape[1]) | Nothing else is known of the unknowns: A = H' R^-1 H, no identity and no damping is added.
    root of the weights on the right | W.T @ z -> H.T @ np.linalg.solve(np.linalg.cholesky(R), z) | On the right, too, stands R^-1 itself: H' R^-1 z, not the root of it.
    the other Cholesky factor | np.linalg.solve(R, H) -> np.linalg.solve(np.linalg.cholesky(R).T @ np.linalg.cholesky(R), H) | With R = L L' the whitened numbers are L^-1 times them, and not the inverse of L' times them.
    scaled by the residuals | return dx, A -> v = z - H @ dx; return dx, A * max(len(z) - len(dx), 1) / max(v @ np.linalg.solve(R, v), 1e-300) | R is known here: A = H' R^-1 H as it is. A factor from the residuals is for noise that nobody knows.
    """,
)
