"""Answers to the exercises of notebook 04 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb04_blocks import new_blocks
from ekfslam_tutorial.course.exercises.nb04_effect import effect_on
from ekfslam_tutorial.course.exercises.nb04_inverse import inverse_observation
from ekfslam_tutorial.course.exercises.nb04_moved import moved

from .collector import answer_to, check_of

# --- 04.1 ---


@answer_to("04.1")
def right_only_for_theta_0(x_r, y):
    return inverse_observation(np.array([x_r[0], x_r[1], 0.0]), y)


@answer_to("04.1")
def right_only_at_the_origin(x_r, y):
    l, L_r, L_y = inverse_observation(np.array([0, 0, x_r[2]]), y)
    return l, L_r, L_y


@answer_to("04.1")
def arguments_swapped(x_r, y):
    return inverse_observation(np.array([*y, 0.0]), x_r[:2])


@answer_to("04.1")
def jacobians_swapped(x_r, y):
    l, L_r, L_y = inverse_observation(x_r, y)
    return l, L_y, L_r


@answer_to("04.1")
def bearing_wrapped_into_a_quarter(x_r, y):
    return inverse_observation(x_r, [y[0], y[1] % (np.pi / 2)])


@answer_to("04.1")
def L_r_with_a_third_row(x_r, y):
    l, L_r, L_y = inverse_observation(x_r, y)
    return l, np.vstack([L_r, [0, 0, 1]]), L_y


@answer_to("04.1")
def integers(x_r, y):
    l, L_r, L_y = inverse_observation(x_r, y)
    return l, L_r.astype(int), L_y


@answer_to("04.1", right=True)
def direction_by_rotation_of_a_unit_vector(x_r, y):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    u = np.matmul([[c, -s], [s, c]], [np.cos(y[1]), np.sin(y[1])])
    n = np.array([-u[1], u[0]])
    return x_r[:2] + y[0] * u, np.c_[np.eye(2), y[0] * n], np.c_[u, y[0] * n]


@answer_to("04.1", right=True)
def homogeneous_transforms(x_r, y):
    T = lambda a, t: np.array([[np.cos(a), -np.sin(a), t[0]], [np.sin(a), np.cos(a), t[1]], [0, 0, 1]])
    l = (T(x_r[2], x_r[:2]) @ T(y[1], (0, 0)) @ [y[0], 0, 1])[:2]
    dx, dy = l - x_r[:2]
    return tuple(l), [[1, 0, -dy], [0, 1, dx]], [[dx / y[0], -dy], [dy / y[0], dx]]


# --- 04.2 ---


@answer_to("04.2")
def cross_covariance_by_position_only(P, L_r, L_y, R):
    P_lx, P_ll = new_blocks(P, L_r, L_y, R)
    return L_r[:, :2] @ P[:2], P_ll


@answer_to("04.2")
def cross_terms_added_twice(P, L_r, L_y, R):
    P_lx, P_ll = new_blocks(P, L_r, L_y, R)
    return P_lx, P_ll + L_r @ P[:3, :3] @ L_r.T


@answer_to("04.2")
def only_the_diagonal_of_P_ll(P, L_r, L_y, R):
    P_lx, P_ll = new_blocks(P, L_r, L_y, R)
    return P_lx, np.diag(np.diag(P_ll))


@answer_to("04.2")
def pose_of_the_last_three(P, L_r, L_y, R):
    return new_blocks(P[::-1, ::-1], L_r, L_y, R)


@answer_to("04.2")
def five_states_always(P, L_r, L_y, R):
    out = np.zeros((2, 5))
    out[:, :3] = L_r @ P[:3, :3]
    return out, new_blocks(P, L_r, L_y, R)[1]


@answer_to("04.2")
def standard_deviations(P, L_r, L_y, R):
    P_lx, P_ll = new_blocks(P, L_r, L_y, R)
    return P_lx, np.sqrt(np.abs(P_ll))


@answer_to("04.2", right=True)
def stacked_jacobian_of_the_landmark_alone(P, L_r, L_y, R):
    n = len(P)
    G = np.zeros((2, n))
    G[:, :3] = L_r
    return np.dot(G, P), np.dot(G, P).dot(G.T) + np.dot(L_y, np.dot(R, np.transpose(L_y)))


@answer_to("04.2", right=True)
def symmetrised(P, L_r, L_y, R):
    P_ll = L_r @ P[0:3, 0:3] @ L_r.T + L_y @ R @ L_y.T
    return (P[:, :3] @ L_r.T).T, 0.5 * (P_ll + P_ll.T)


# --- 04.3 ---


@answer_to("04.3")
def noise_in_the_corner_only(P, X_x, X_u, U):
    new = moved(P, X_x, X_u, 0 * U)
    new[0, 0] += (X_u @ U @ X_u.T)[0, 0]
    return new


@answer_to("04.3")
def cross_covariance_halved(P, X_x, X_u, U):
    new = moved(P, X_x, X_u, U)
    new[:3, 3:] /= 2
    new[3:, :3] /= 2
    return new


@answer_to("04.3")
def works_in_place(P, X_x, X_u, U):
    P[:] = moved(P, X_x, X_u, U)
    return P


@answer_to("04.3")
def seven_states_always(P, X_x, X_u, U):
    F = np.eye(7)
    F[:3, :3] = X_x
    return F @ P @ F.T


@answer_to("04.3")
def only_the_upper_triangle(P, X_x, X_u, U):
    return np.triu(moved(P, X_x, X_u, U))


@answer_to("04.3")
def cross_covariance_grows_with_noise(P, X_x, X_u, U):
    new = moved(P, X_x, X_u, U)
    new[:3, 3:] += (X_u @ U @ X_u.T)[:, :1]
    new[3:, :3] = new[:3, 3:].T
    return new


@answer_to("04.3", right=True)
def noise_by_its_root(P, X_x, X_u, U):
    new = np.array(P, copy=True)
    new[:3, :] = np.einsum("ij,jk->ik", X_x, new[:3, :])
    new[:, :3] = np.einsum("ij,kj->ik", new[:, :3], X_x)
    w, V = np.linalg.eigh(U)
    W = X_u @ V @ np.diag(np.sqrt(np.clip(w, 0, None)))
    new[:3, :3] = new[:3, :3] + W @ W.T
    return new


# --- 04.4 ---


@answer_to("04.4")
def gain_of_the_seen_landmark(P, H, R, b):
    return effect_on(P, H, R, slice(3, 5))


@answer_to("04.4")
def always_the_last_landmark(P, H, R, b):
    return effect_on(P, H, R, slice(len(P) - 4, len(P) - 2))


@answer_to("04.4")
def gain_without_the_robot(P, H, R, b):
    H = H.copy()
    H[:, :3] = 0
    return effect_on(P, H, R, b)


@answer_to("04.4")
def symmetric_R_only(P, H, R, b):
    return effect_on(P, H, np.diag(np.diag(R)), b)


@answer_to("04.4")
def half_the_loss(P, H, R, b):
    K, Q = effect_on(P, H, R, b)
    return K, (Q + P[b, b]) / 2


@answer_to("04.4", right=True)
def one_number_after_the_other(P, H, R, b):
    """Decorrelate the measurement, then use its numbers one by one."""
    L = np.linalg.inv(np.linalg.cholesky(R))
    G, Q = L @ H, P.copy()
    for h in G:
        Q = Q - np.outer(Q @ h, Q @ h) / (h @ Q @ h + 1)
    return (Q @ H.T @ np.linalg.inv(R))[b], Q[b, b]


# --- right answers in other words ---


@answer_to("04.2", right=True)
def one_Jacobian_of_everything_np_block(P, L_r, L_y, R):
    n = len(P)
    J = np.block([[np.eye(n), np.zeros((n, 2))], [L_r, np.zeros((2, n - 3)), L_y]])
    S = J @ np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), R]]) @ J.T
    return S[n:, :n], S[n:, n:]


@answer_to("04.2", right=True)
def start_with_a_huge_covariance_then_correct_with_the_measurement(P, L_r, L_y, R):
    n, W = len(P), np.linalg.inv(L_y)
    S = np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), 1e6 * np.eye(2)]])
    H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W])
    S = S - S @ H.T @ np.linalg.inv(H @ S @ H.T + R) @ H @ S
    return S[n:, :n], S[n:, n:]


@answer_to("04.2", right=True)
def sums_over_entries_lists(P, L_r, L_y, R):
    n = len(P)
    P_lx = [[sum(L_r[i][k] * P[k][j] for k in range(3)) for j in range(n)] for i in range(2)]
    P_ll = [[sum(P_lx[i][k] * L_r[j][k] for k in range(3)) for j in range(2)] for i in range(2)]
    noise = np.einsum("ik,kl,jl->ij", L_y, R, L_y)
    return P_lx, [[P_ll[i][j] + noise[i][j] for j in range(2)] for i in range(2)]


@answer_to("04.2", right=True)
def square_roots_of_the_covariances(P, L_r, L_y, R):
    w, V = np.linalg.eigh(P)
    A = V * np.sqrt(np.clip(w, 0, None))
    B = L_r @ A[:3]
    r, Q = np.linalg.eigh(R)
    C = L_y @ (Q * np.sqrt(np.clip(r, 0, None)))
    return B @ A.T, B @ B.T + C @ C.T


@answer_to("04.4", right=True)
def correct_the_whole_state_in_the_Joseph_form_then_cut_out_B(P, H, R, b):
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    A = np.eye(len(P)) - K @ H
    return K[b], (A @ P @ A.T + K @ R @ K.T)[b, b]


@answer_to("04.4", right=True)
def by_adding_information(P, H, R, b):
    W = np.linalg.inv(R)
    new = np.linalg.inv(np.linalg.inv(P) + H.T @ W @ H)
    return (new @ H.T @ W)[b], new[b, b]


@answer_to("04.4", right=True)
def the_conditional_Gaussian_of_B_given_the_measurement_lists(P, H, R, b):
    n = len(P)
    J = np.vstack([np.eye(n)[b], H])
    S = J @ P @ J.T
    S[2:, 2:] += R
    K = S[:2, 2:] @ np.linalg.inv(S[2:, 2:])
    return K.tolist(), (S[:2, :2] - K @ S[2:, :2]).tolist()


@answer_to("04.1", right=True)
def by_the_chain_rule_with_a_rotation_matrix(x_r, y):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    R = np.array([[c, -s], [s, c]])
    in_robot = y[0] * np.array([np.cos(y[1]), np.sin(y[1])])
    swing = np.array([[0, -1], [1, 0]])
    L_y = R @ np.column_stack([in_robot / y[0], swing @ in_robot])
    return np.asarray(x_r)[:2] + R @ in_robot, np.hstack([np.eye(2), (R @ swing @ in_robot)[:, None]]), L_y


@answer_to("04.1", right=True)
def complex_numbers_lists(x_r, y):
    beam = y[0] * np.exp(1j * (x_r[2] + y[1] - 4 * np.pi))
    unit, swing = beam / y[0], 1j * beam
    l = complex(x_r[0], x_r[1]) + beam
    L_y = [[unit.real, swing.real], [unit.imag, swing.imag]]
    return [l.real, l.imag], [[1, 0, swing.real], [0, 1, swing.imag]], L_y


def place(x_r, y):
    a = x_r[2] + y[1]
    return np.array([x_r[0] + y[0] * np.cos(a), x_r[1] + y[0] * np.sin(a)])


@answer_to("04.1", right=True)
def finite_differences(x_r, y):
    h = 1e-6
    L_r = [(place(x_r + d, y) - place(x_r - d, y)) / (2 * h) for d in h * np.eye(3)]
    L_y = [(place(x_r, y + d) - place(x_r, y - d)) / (2 * h) for d in h * np.eye(2)]
    return place(x_r, y), np.transpose(L_r), np.transpose(L_y)


@answer_to("04.3", right=True)
def one_big_Jacobian(P, X_x, X_u, U):
    F, G = np.eye(len(P)), np.zeros((len(P), np.shape(U)[0]))
    F[:3, :3], G[:3] = X_x, X_u
    return F @ P @ F.T + G @ U @ G.T


@answer_to("04.3", right=True)
def block_by_block_np_block(P, X_x, X_u, U):
    P_rm = X_x @ P[:3, 3:]
    return np.block([[X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T, P_rm], [P_rm.T, P[3:, 3:]]])


@answer_to("04.3", right=True)
def by_a_square_root_of_P_lists(P, X_x, X_u, U):
    w, V = np.linalg.eigh(P)
    S = V * np.sqrt(np.clip(w, 0, None))
    S[:3] = np.dot(X_x, S[:3])
    new = S @ S.T
    new[:3, :3] += np.linalg.multi_dot([X_u, U, np.transpose(X_u)])
    return new.tolist()


test_the_check_is_right_about_it = check_of(__name__)
