"""Answers to the exercises of notebook 21 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import scipy.linalg
from scipy.optimize import least_squares

from ekfslam_tutorial.course.exercises.nb21_gauss_newton import gauss_newton_step
from ekfslam_tutorial.course.exercises.nb21_iterated import iterated_correct
from ekfslam_tutorial.course.exercises.nb21_marginalise import marginalise
from ekfslam_tutorial.geometry import wrap

from .collector import answer_to, check_of

# --- 21.1 iterated correction ---


@answer_to("21.1", hint="one iteration.*ordinary EKF")
def damped(x, P, y, R, observe, iterations):
    at, K, H = np.array(x, float), np.zeros((len(x), 2)), np.zeros((2, len(x)))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = at + 0.7 * (x + K @ (z - H @ (x - at)) - at)
    return at, P - K @ H @ P


@answer_to("21.1", hint="P|covariance|last")
def covariance_divided_by_the_iterations(x, P, y, R, observe, iterations):
    at, S = iterated_correct(x, P, y, R, observe, iterations)
    return at, S / iterations


@answer_to("21.1", hint="R|Z|EKF|x \\+ K z")
def noise_as_sigma(x, P, y, R, observe, iterations):
    return iterated_correct(x, P, y, np.diag(np.sqrt(np.diag(R))), observe, iterations)


@answer_to("21.1", right=True)
def with_solve_and_symmetric(x, P, y, R, observe, iterations):
    at, S = x.copy(), P
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], (y[1] - e[1] + np.pi) % (2 * np.pi) - np.pi])
        Z = H @ P @ H.T + R
        at = x + P @ H.T @ np.linalg.solve(Z, z + H @ (at - x))
        S = P - P @ H.T @ np.linalg.solve(Z, H @ P)
    return at, (S + S.T) / 2


# --- 21.2 Gauss-Newton ---


@answer_to("21.2", hint="R\\^-1|weigh|inverse|noise")
def weights_squared(H, z, R):
    W = np.linalg.inv(R)
    return gauss_newton_step(H, z, R @ R)[0], H.T @ W @ H


@answer_to("21.2", hint="dx|H'|least squares|R\\^-1")
def pseudo_inverse_of_whitened_by_the_wrong_side(H, z, R):
    L = np.linalg.cholesky(R)
    return np.linalg.pinv(L @ H) @ (L @ z), gauss_newton_step(H, z, R)[1]


@answer_to("21.2", hint="LinAlg|not square|fit|A =|must be square|shape")
def as_if_square(H, z, R):
    return np.linalg.solve(H, z), H.T @ np.linalg.inv(R) @ H


@answer_to("21.2", right=True)
def by_a_library(H, z, R):
    L = np.linalg.cholesky(R)
    fit = least_squares(
        lambda d: scipy.linalg.solve_triangular(L, H @ d - z, lower=True), np.zeros(H.shape[1]), xtol=1e-14
    )
    return fit.x, H.T @ np.linalg.solve(R, H)


@answer_to("21.2", right=True)
def by_cholesky(H, z, R):
    W = np.linalg.inv(R)
    c = scipy.linalg.cho_factor(H.T @ W @ H)
    return scipy.linalg.cho_solve(c, H.T @ (W @ z)), (H.T @ W) @ H


# --- 21.3 marginalise ---


@answer_to("21.3", hint="inv|A_kg|information|known")
def half_of_the_schur_complement(A, b, keep):
    B, c = marginalise(A, b, keep)
    return (A[np.ix_(keep, keep)] + B) / 2, c


@answer_to("21.3", hint="order|keep|keep = ")
def the_first_ones_stay(A, b, keep):
    return marginalise(A, b, list(range(len(keep))))


@answer_to("21.3", hint="shape")
def zeros_in_place_of_the_others(A, b, keep):
    B, c = np.zeros_like(A), np.zeros_like(b)
    B[np.ix_(keep, keep)], c[keep] = marginalise(A, b, keep)
    return B, c


@answer_to("21.3", right=True)
def by_a_permutation_and_cholesky(A, b, keep):
    gone = [i for i in range(len(A)) if i not in keep]
    order = gone + list(keep)
    L = np.linalg.cholesky(A[np.ix_(order, order)])
    g = len(gone)
    y = scipy.linalg.solve_triangular(L, b[order], lower=True)
    return L[g:, g:] @ L[g:, g:].T, L[g:, g:] @ y[g:]


test_the_check_is_right_about_it = check_of(__name__)
