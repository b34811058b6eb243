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
def by_cholesky(H, z, R):
    W = np.linalg.inv(R)
    c = scipy.linalg.cho_factor(H.T @ W @ H)
    return scipy.linalg.cho_solve(c, H.T @ (W @ z)), (H.T @ W) @ H


@answer_to("21.2", right=True)
def by_a_library(H, z, R):
    L = np.linalg.cholesky(R)
    fit = least_squares(
        lambda d: scipy.linalg.solve_triangular(L, H @ d - z, lower=True), np.zeros(H.shape[1]), xtol=1e-14
    )
    return fit.x, H.T @ np.linalg.solve(R, H)


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


# --- 21.2: the same in other words ---


@answer_to("21.2", right=True)
def whitened_by_least_squares(H, z, R):
    L = np.linalg.cholesky(R)
    J, r = np.linalg.solve(L, H), np.linalg.solve(L, z)
    return np.linalg.lstsq(J, r, rcond=None)[0], J.T @ J


@answer_to("21.2", right=True)
def inverses_lists(H, z, R):
    A = H.T @ np.linalg.inv(R) @ H
    return (np.linalg.inv(A) @ H.T @ np.linalg.inv(R) @ z).tolist(), A.tolist()


@answer_to("21.2", right=True)
def by_qr(H, z, R):
    W = np.linalg.inv(np.linalg.cholesky(R))
    Q, U = np.linalg.qr(W @ H)
    return np.linalg.solve(U, Q.T @ (W @ z)), U.T @ U


# --- 21.1: the same in other words ---


@answer_to("21.1", right=True)
def information_form_gauss_newton_on_prior_and_measurement_lists(x, P, y, R, observe, iterations):
    at, W, V = np.array(x, float), np.linalg.inv(P), np.linalg.inv(R)
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], np.arctan2(np.sin(y[1] - e[1]), np.cos(y[1] - e[1]))])
        S = np.linalg.inv(W + H.T @ V @ H)
        at = at + S @ (H.T @ V @ z + W @ (x - at))
    return at.tolist(), S.tolist()


@answer_to("21.1", right=True)
def joseph_form_whole_turns_added(x, P, y, R, observe, iterations):
    at, K, H = np.array(x, float), np.zeros((len(x), 2)), np.zeros((2, len(x)))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.asarray(y) - e - H @ (x - at)
        z[1] += 2 * np.pi * np.round((wrap(y[1] - e[1]) - (y[1] - e[1])) / (2 * np.pi))
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = x + K @ z
    A = np.eye(len(x)) - K @ H
    return at + [0, 0, 2 * np.pi, *(len(x) - 3) * [0]], A @ P @ A.T + K @ R @ K.T


@answer_to("21.1", right=True)
def least_squares_of_all_residuals_together(x, P, y, R, observe, iterations):
    at, L, M = np.array(x, float), np.linalg.inv(np.linalg.cholesky(P)), np.linalg.inv(np.linalg.cholesky(R))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        J, r = np.vstack([L, M @ H]), np.concatenate([L @ (x - at), M @ z])
        at = at + np.linalg.lstsq(J, r, rcond=None)[0]
    return at, np.linalg.inv(J.T @ J)


# --- 21.3: the same in other words ---


@answer_to("21.3", right=True)
def by_way_of_the_covariance(A, b, keep):
    P = np.linalg.inv(A)
    B = np.linalg.inv(P[np.ix_(keep, keep)])
    return B, B @ (P @ b)[keep]


@answer_to("21.3", right=True)
def gauss_elimination_one_unknown_after_the_other_lists(A, b, keep):
    A, b = np.array(A, float), np.array(b, float)
    for i in range(len(A)):
        if i not in keep:
            others = [j for j in range(len(A)) if j != i]
            f = A[:, i] / A[i, i]
            for j in others:
                b[j] -= f[j] * b[i]
            A[others] -= np.outer(f[others], A[i])
            A[:, i] = 0
    return A[np.ix_(keep, keep)].tolist(), b[keep].tolist()


@answer_to("21.3", right=True)
def with_masks(A, b, keep):
    out = np.ones(len(A), bool)
    out[keep] = False
    G = np.linalg.inv(A[out][:, out]) if out.any() else np.zeros((0, 0))
    B = A[keep][:, out]
    return A[keep][:, keep] - B @ G @ B.T, np.asarray(b)[keep] - B @ G @ np.asarray(b)[out]


@answer_to("21.1", hint="keep the prior P in the loop")
def corrected_in_the_loop_and_once_more(x, P, y, R, observe, iterations):
    at = x.copy()
    for _ in range(iterations):
        e, H = observe(at)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = x + K @ (np.array([y[0] - e[0], wrap(y[1] - e[1])]) - H @ (x - at))
        P = P - K @ H @ P
    return at, P - K @ H @ P


test_the_check_is_right_about_it = check_of(__name__)
