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


test_the_check_is_right_about_it = check_of(__name__)
