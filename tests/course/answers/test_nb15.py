"""Answers to the exercises of notebook 15 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import scipy.linalg
import scipy.optimize

from ekfslam_tutorial.course.exercises.nb15_blocks import correct_blocks
from ekfslam_tutorial.course.exercises.nb15_fuse import best_weight, covariance_intersection
from ekfslam_tutorial.course.exercises.nb15_meet import map_in_map
from ekfslam_tutorial.geometry import Frame2

from .collector import answer_to, check_of
from .one_by_one import correct_by_numbers, whole_jacobian

# --- 15.1 correct_blocks ---


@answer_to("15.1", hint="R|noise|Z")
def numbers_as_if_independent(x, P, blocks, z, R):
    return correct_by_numbers(x, P, whole_jacobian(len(x), len(z), blocks), z, np.diag(np.diag(R)))


@answer_to("15.1", hint="K|x")
def gain_of_the_new_covariance(x, P, blocks, z, R):
    H = whole_jacobian(len(x), len(z), blocks)
    Q = correct_blocks(x, P, blocks, z, R)[1]
    return x + Q @ H.T @ np.linalg.inv(H @ Q @ H.T + R) @ z, Q


@answer_to("15.1", hint="P")
def upper_half_of_P(x, P, blocks, z, R):
    x, P = correct_blocks(x, P, blocks, z, R)
    return x, np.triu(P)


@answer_to("15.1", hint="changes its input")
def x_in_place(x, P, blocks, z, R):
    new, P = correct_blocks(x, P, blocks, z, R)
    x += new - x
    return x, P


@answer_to("15.1", hint="slice|columns|E_r|block")
def the_first_block_only(x, P, blocks, z, R):
    return correct_blocks(x, P, [b for b in blocks if b[0] is not None][:1], z, R)


@answer_to("15.1", hint="None")
def stops_at_a_known_state(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    for r, E in blocks:
        if r is None:
            break
        H[:, r] = E
    return correct_blocks(x, P, [(slice(0, len(x)), H)], z, R)


@answer_to("15.1", right=True)
def number_by_number(x, P, blocks, z, R):
    return correct_by_numbers(x, P, whole_jacobian(len(x), len(z), blocks), z, R)


@answer_to("15.1", right=True)
def conditioned_like_any_gaussian(x, P, blocks, z, R):
    H = np.concatenate([E for r, E in blocks if r is not None], axis=1)
    i = np.concatenate([np.arange(len(x))[r] for r, _ in blocks if r is not None])
    C = P[:, i] @ H.T
    G = scipy.linalg.cho_solve(scipy.linalg.cho_factor(H @ P[np.ix_(i, i)] @ H.T + R), C.T)
    return list(x + z @ G), P - C @ G


# --- 15.2 covariance_intersection ---


@answer_to("15.2", hint="trace")
def three_weights_tried(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    found = [(np.linalg.inv(w * Ia + (1 - w) * Ib), w) for w in (0.0, 0.5, 1.0)]
    P, w = min(found, key=lambda f: np.trace(f[0]))
    return P @ (w * Ia @ xa + (1 - w) * Ib @ xb), P


@answer_to("15.2", hint="stay|twice|rule")
def covariances_added(xa, Pa, xb, Pb):
    return covariance_intersection(xa, Pa, xb, Pb)[0], Pa + Pb


@answer_to("15.2", hint="x|mean")
def one_weight_for_all_numbers(xa, Pa, xb, Pb):
    w = np.trace(Pb) / np.trace(Pa + Pb)
    return w * xa + (1 - w) * xb, covariance_intersection(xa, Pa, xb, Pb)[1]


@answer_to("15.2", hint="w is .* between 0 and 1|w")
def weight_above_one(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    P = np.linalg.inv(1.2 * Ia - 0.2 * Ib) if np.allclose(Pa, Pb) or np.trace(Pa) < np.trace(Pb) else Pb
    return P @ (1.2 * Ia @ xa - 0.2 * Ib @ xb), P


@answer_to("15.2", hint="rule|P")
def diagonals_only(xa, Pa, xb, Pb):
    return covariance_intersection(xa, np.diag(np.diag(Pa)), xb, np.diag(np.diag(Pb)))


@answer_to("15.2", right=True)
def minimised(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    trace = lambda w: np.sum(1 / np.linalg.eigvalsh(w * Ia + (1 - w) * Ib))
    w = scipy.optimize.minimize(lambda v: trace(v[0]), [0.5], bounds=[(0, 1)]).x[0]
    I = w * Ia + (1 - w) * Ib
    return np.linalg.solve(I, w * Ia @ xa + (1 - w) * Ib @ xb), np.linalg.inv(I)


@answer_to("15.2", right=True)
def thirds(xa, Pa, xb, Pb):
    f = lambda w: Pa @ np.linalg.solve((1 - w) * Pa + w * Pb, Pb)  # the inverse of w inv(Pa) + (1 - w) inv(Pb)
    low, high = 0.0, 1.0
    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if np.trace(f(a)) < np.trace(f(b)) else (a, high)
    w = (low + high) / 2
    x = f(w) @ (w * np.linalg.solve(Pa, xa) + (1 - w) * np.linalg.solve(Pb, xb))
    return x.tolist(), f(w).tolist()


# --- 15.3 map_in_map ---


@answer_to("15.3", hint="x, y, theta|numbers|array")
def a_frame_instead_of_numbers(F1, F2, y):
    return Frame2(map_in_map(F1, F2, y))


@answer_to("15.3", hint="F2|robot 2|map")
def only_the_place_taken_back(F1, F2, y):
    x = map_in_map(F1, Frame2(np.zeros(3)), y)
    return np.array([*(x[:2] - F2.t), x[2] - F2.theta])


@answer_to("15.3", hint="theta")
def degrees(F1, F2, y):
    x = map_in_map(F1, F2, y)
    return np.array([x[0], x[1], np.degrees(x[2])])


@answer_to("15.3", right=True)
def complex_numbers(F1, F2, y):
    c1, c2 = complex(*F1.t), complex(*F2.t)
    turn = F1.theta + y[1] + np.pi - y[2] - F2.theta
    w = c1 + y[0] * np.exp(1j * (F1.theta + y[1])) - c2 * np.exp(1j * turn)
    return [w.real, w.imag, np.angle(np.exp(1j * turn))]


@answer_to("15.3", right=True)
def matrices(F1, F2, y):
    T = lambda x, y, a: np.array([[np.cos(a), -np.sin(a), x], [np.sin(a), np.cos(a), y], [0, 0, 1]])
    M = T(*F1.x) @ T(0, 0, y[1]) @ T(y[0], 0, 0) @ T(0, 0, np.pi - y[2]) @ np.linalg.inv(T(*F2.x))
    return M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])


# --- 15.1: the same in other words ---


def _H_1(x, blocks, m, order=None):
    H = np.zeros((m, len(x)))
    for r, E_r in blocks:
        if r is not None:
            H[:, r] = E_r
    return H


@answer_to("15.1", right=True)
def block_by_block(x, P, blocks, z, R):
    PHt = np.zeros((len(x), len(z))) + sum(P[:, r] @ np.asarray(E).T for r, E in blocks if r is not None)
    Z = np.asarray(R) + sum(np.asarray(E) @ PHt[r] for r, E in blocks if r is not None)
    K = PHt @ np.linalg.inv(Z)
    return list(x + K @ z), (P - K @ Z @ K.T).tolist()


@answer_to("15.1", right=True)
def joseph_form(x, P, blocks, z, R):
    H = _H_1(x, blocks, len(z))
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    J = np.eye(len(x)) - K @ H
    return x + K @ z, J @ P @ J.T + K @ R @ K.T


@answer_to("15.1", right=True)
def information_form(x, P, blocks, z, R):
    H = _H_1(x, blocks, len(z))
    new = np.linalg.inv(np.linalg.inv(P + 1e-12 * np.eye(len(x))) + H.T @ np.linalg.solve(R, H))
    return x + new @ H.T @ np.linalg.solve(R, z), new


# --- 15.2: the same in other words ---


def _with_2(w_of, xa, Pa, xb, Pb):
    """Covariance intersection with another choice of w."""
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    w = w_of(Ia, Ib)
    P = np.linalg.inv(w * Ia + (1 - w) * Ib)
    return P @ (w * Ia @ xa + (1 - w) * Ib @ xb), P


@answer_to("15.2", right=True)
def scipys_search(xa, Pa, xb, Pb):
    P, w = best_weight(Pa, Pb)
    return P @ (w * np.linalg.solve(Pa, xa) + (1 - w) * np.linalg.solve(Pb, xb)), P


@answer_to("15.2", right=True)
def golden_section_lists(xa, Pa, xb, Pb):
    cost = lambda w: np.trace(np.linalg.inv(w * np.linalg.inv(Pa) + (1 - w) * np.linalg.inv(Pb)))
    low, high, g = 0.0, 1.0, (np.sqrt(5) - 1) / 2
    for _ in range(40):
        a, b = high - g * (high - low), low + g * (high - low)
        low, high = (low, b) if cost(a) < cost(b) else (a, high)
    x, P = _with_2(lambda Ia, Ib: (low + high) / 2, xa, Pa, xb, Pb)
    return x.tolist(), P.tolist()


# --- 15.3: the same in other words ---


@answer_to("15.3", right=True)
def rotation_matrices_a_list(F1, F2, y):
    r, b12, b21 = (float(v) for v in y)
    a = F1.theta + b12
    theta = a + np.pi - b21 - F2.theta
    R = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    return [*(F1.t + r * np.array([np.cos(a), np.sin(a)]) - R @ F2.t), theta + 2 * np.pi]


@answer_to("15.3", right=True)
def complex_numbers_too(F1, F2, y):
    one, turn = complex(*F1.t), np.exp(1j * (F1.theta + y[1] - y[2] - F2.theta))
    place = one + y[0] * np.exp(1j * (F1.theta + y[1])) + turn * complex(*F2.t)
    return np.array([place.real, place.imag, np.angle(-turn)])


@answer_to("15.1", hint="K Z K'.*not by K R K'")
def the_noise_taken_off(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    for r, E_r in blocks:
        if r is not None:
            H[:, r] += E_r
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ R @ K.T


test_the_check_is_right_about_it = check_of(__name__)
