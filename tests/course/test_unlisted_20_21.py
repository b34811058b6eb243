"""Answers to the exercises of notebooks 20 and 21 that are in no list of the package."""

import numpy as np
import scipy.linalg
from scipy.optimize import least_squares

from ekfslam_tutorial.course.exercises.nb20_guard import guard
from ekfslam_tutorial.course.exercises.nb20_repair import turn_go_turn
from ekfslam_tutorial.course.exercises.nb21_gauss_newton import gauss_newton_step
from ekfslam_tutorial.course.exercises.nb21_iterated import iterated_correct
from ekfslam_tutorial.course.exercises.nb21_marginalise import marginalise
from ekfslam_tutorial.geometry import numerical_jacobian, wrap

from .probes import Probes, judged_rightly

probes = Probes()
wrong, right = probes.wrong, probes.right


@probes.each
def test_the_check_is_right_about_it(id, says, answer):
    judged_rightly(id, says, answer)


# --- 20.2 the guard ---


@wrong("20.2", "matrix of the shape of P|shape|array")
def only_an_alarm(predict, x, P, u, U):
    return bool(np.abs(guard(predict, x, P, u, U)).max() > 1e-6)


@wrong("20.2", "F_x P F_x'|zero|wrong")
def always_silent(predict, x, P, u, U):
    return np.zeros((len(x), len(x)))


@wrong("20.2", "P_rm|P2|F_x P F_x'|before")
def jacobian_by_the_robot_alone(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)
    F = np.eye(len(x))
    f = lambda pose: predict(np.concatenate([pose, x[3:]]), P, u, U)[0][:3]
    F[:3, :3] = numerical_jacobian(f, x[:3])
    G = np.zeros((len(x), len(u)))
    G[:3] = numerical_jacobian(lambda u: predict(x, P, u, U)[0][:3], u)
    D = np.zeros_like(P2)
    D[:3] = (P2 - (F @ P @ F.T + G @ U @ G.T))[:3]
    return D


@wrong("20.2", "shape|LinAlg|ValueError|broadcast|fit|@")
def shapes_for_three_controls_only(predict, x, P, u, U):
    G = np.zeros((len(x), 3))
    G[:3, :3] = np.eye(3)
    return guard(predict, x, P, u, U) + 0 * G @ U @ G.T


@wrong("20.2", "zero|F_x P F_x'|difference")
def relative_to_the_right_value(predict, x, P, u, U):
    P2 = predict(x, P, u, U)[1]
    return guard(predict, x, P, u, U) / np.abs(P2).max()


@wrong("20.2", "seam|wrap")
def seam_cut_out_of_the_wrong_entry(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def f(x, u):
        d = predict(x, P, u, U)[0] - x2
        d[1] = wrap(d[1])
        return d

    F, G = numerical_jacobian(lambda a: f(a, u), x), numerical_jacobian(lambda b: f(x, b), u)
    return P2 - F @ P @ F.T - G @ U @ G.T


@right("20.2")
def one_sided_differences(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)
    h = 1e-7

    def d(x, u):
        step = predict(x, P, u, U)[0] - x2
        step[2] = (step[2] + np.pi) % (2 * np.pi) - np.pi
        return step / h

    F = np.column_stack([d(x + h * e, u) for e in np.eye(len(x))])
    G = np.column_stack([d(x, u + h * e) for e in np.eye(len(u))])
    return P2 - F @ P @ F.T - G @ U @ G.T


@right("20.2")
def heading_through_a_complex_number(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)
    x2 = x2.copy()

    def f(x, u):
        y = np.array(predict(x, P, u, U)[0])
        y[2] = np.angle(np.exp(1j * (y[2] - x2[2])))
        return y

    return P2 - sum(
        J @ C @ J.T
        for J, C in (
            (numerical_jacobian(lambda a: f(a, u), x), P),
            (numerical_jacobian(lambda b: f(x, b), u), U),
        )
    )


# --- 20.3 the repair ---


@wrong("20.3", "heading|theta")
def heading_in_degrees(x, P, u, U):
    new, P = turn_go_turn(x, P, u, U)
    return np.concatenate([new[:2], np.degrees(new[2:3]), new[3:]]), P


@wrong("20.3", "X_x|heading|finite")
def exact_only_without_turns(x, P, u, U):
    new, _ = turn_go_turn(x, P, u, U)
    return new, turn_go_turn(x, P, np.array([0, u[1], 0]), U)[1]


@wrong("20.3", "X_u|noise|order")
def noise_columns_in_another_order(x, P, u, U):
    new, P0 = turn_go_turn(x, P, u, 0 * U)
    order = [1, 0, 2]
    return new, P0 + turn_go_turn(x, 0 * P, u, U[np.ix_(order, order)])[1]


@wrong("20.3", r"Wrong at \[3, 3\]")
def landmarks_drift_along(x, P, u, U):
    new, P = turn_go_turn(x, P, u, U)
    P = P + 1e-3 * np.diag([0, 0, 0, *(len(x) - 3) * [1]])
    return new, P


@wrong("20.3", "changes its input")
def in_place(x, P, u, U):
    new, P_new = turn_go_turn(x, P, u, U)
    P[:] = P_new
    return new, P


@right("20.3")
def as_odometry_in_the_frame_of_the_robot(x, P, u, U):
    r1, t, r2 = u
    J = np.array([[-t * np.sin(r1), np.cos(r1), 0], [t * np.cos(r1), np.sin(r1), 0], [1, 0, 1]])  # of [dx, dy, dtheta]
    c, s = np.cos(x[2]), np.sin(x[2])
    d, turn = np.array([t * np.cos(r1), t * np.sin(r1)]), np.array([[c, -s], [s, c]])
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[:2, 2], G[:2, :2], G[2, 2] = turn @ [-d[1], d[0]], turn, 1
    new = x + np.concatenate([turn @ d, [r1 + r2], np.zeros(len(x) - 3)])
    return new, F @ P @ F.T + G @ J @ U @ J.T @ G.T


# --- 21.1 iterated correction ---


@wrong("21.1", "one iteration.*ordinary EKF")
def damped(x, P, y, R, observe, iterations):
    at, K, H = np.array(x, float), np.zeros((len(x), 2)), np.zeros((2, len(x)))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = at + 0.7 * (x + K @ (z - H @ (x - at)) - at)
    return at, P - K @ H @ P


@wrong("21.1", "P|covariance|last")
def covariance_divided_by_the_iterations(x, P, y, R, observe, iterations):
    at, S = iterated_correct(x, P, y, R, observe, iterations)
    return at, S / iterations


@wrong("21.1", "R|Z|EKF|x \\+ K z")
def noise_as_sigma(x, P, y, R, observe, iterations):
    return iterated_correct(x, P, y, np.diag(np.sqrt(np.diag(R))), observe, iterations)


@right("21.1")
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


@wrong("21.2", "R\\^-1|weigh|inverse|noise")
def weights_squared(H, z, R):
    W = np.linalg.inv(R)
    return gauss_newton_step(H, z, R @ R)[0], H.T @ W @ H


@wrong("21.2", "dx|H'|least squares|R\\^-1")
def pseudo_inverse_of_whitened_by_the_wrong_side(H, z, R):
    L = np.linalg.cholesky(R)
    return np.linalg.pinv(L @ H) @ (L @ z), gauss_newton_step(H, z, R)[1]


@wrong("21.2", "LinAlg|not square|fit|A =|must be square|shape")
def as_if_square(H, z, R):
    return np.linalg.solve(H, z), H.T @ np.linalg.inv(R) @ H


@right("21.2")
def by_a_library(H, z, R):
    L = np.linalg.cholesky(R)
    fit = least_squares(
        lambda d: scipy.linalg.solve_triangular(L, H @ d - z, lower=True), np.zeros(H.shape[1]), xtol=1e-14
    )
    return fit.x, H.T @ np.linalg.solve(R, H)


@right("21.2")
def by_cholesky(H, z, R):
    W = np.linalg.inv(R)
    c = scipy.linalg.cho_factor(H.T @ W @ H)
    return scipy.linalg.cho_solve(c, H.T @ (W @ z)), (H.T @ W) @ H


# --- 21.3 marginalise ---


@wrong("21.3", "inv|A_kg|information|known")
def half_of_the_schur_complement(A, b, keep):
    B, c = marginalise(A, b, keep)
    return (A[np.ix_(keep, keep)] + B) / 2, c


@wrong("21.3", "order|keep|keep = ")
def the_first_ones_stay(A, b, keep):
    return marginalise(A, b, list(range(len(keep))))


@wrong("21.3", "shape")
def zeros_in_place_of_the_others(A, b, keep):
    B, c = np.zeros_like(A), np.zeros_like(b)
    B[np.ix_(keep, keep)], c[keep] = marginalise(A, b, keep)
    return B, c


@right("21.3")
def by_a_permutation_and_cholesky(A, b, keep):
    gone = [i for i in range(len(A)) if i not in keep]
    order = gone + list(keep)
    L = np.linalg.cholesky(A[np.ix_(order, order)])
    g = len(gone)
    y = scipy.linalg.solve_triangular(L, b[order], lower=True)
    return L[g:, g:] @ L[g:, g:].T, L[g:, g:] @ y[g:]
