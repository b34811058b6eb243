"""Answers to the exercises of notebook 05 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb04_inverse import inverse_observation
from ekfslam_tutorial.course.exercises.nb04_moved import moved
from ekfslam_tutorial.course.exercises.nb05_augment import augment
from ekfslam_tutorial.course.exercises.nb05_correct import correct
from ekfslam_tutorial.course.exercises.nb05_frame import slam_frame
from ekfslam_tutorial.course.exercises.nb05_observe import observe
from ekfslam_tutorial.course.exercises.nb05_predict import predict
from ekfslam_tutorial.geometry import wrap
from ekfslam_tutorial.models.motion import Odometry2

from .collector import answer_to, check_of

# --- 05.1 ---


@answer_to("05.1")
def heading_wrapped_into_a_half_turn(x, P, u, U):
    x, P = predict(x, P, u, U)
    x[2] = x[2] % np.pi
    return x, P


@answer_to("05.1")
def half_the_turn_first(x, P, u, U):
    new, Q = predict(x, P, u, U)
    a = x[2] + u[2] / 2
    new[:2] = x[:2] + [np.cos(a) * u[0] - np.sin(a) * u[1], np.sin(a) * u[0] + np.cos(a) * u[1]]
    return new, Q


@answer_to("05.1")
def in_place(x, P, u, U):
    x[:3] = predict(x, P, u, U)[0][:3]
    return x, predict(x, P, u, U)[1]


@answer_to("05.1")
def noise_as_if_theta_were_0(x, P, u, U):
    new, Q = predict(x, P, u, 0 * U)
    Q[:3, :3] += U
    return new, Q


@answer_to("05.1")
def U_of_position_only(x, P, u, U):
    U = U.copy()
    U[2], U[:, 2] = 0, 0
    return predict(x, P, u, U)


@answer_to("05.1", right=True)
def with_rotation_matrix_and_float32_like_lists(x, P, u, U):
    a = float(x[2])
    R = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    step = R @ u[:2]
    X_x, X_u = np.eye(3), np.eye(3)
    X_x[:2, 2], X_u[:2, :2] = [-step[1], step[0]], R
    new = np.concatenate([x[:2] + step, [np.angle(np.exp(1j * (a + u[2])))], x[3:]])
    Q = np.array(P)
    Q[:3, :3] = X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T
    Q[:3, 3:] = X_x @ P[:3, 3:]
    Q[3:, :3] = Q[:3, 3:].T
    return new.tolist(), [list(row) for row in Q]


# --- 05.2 ---


@answer_to("05.2")
def heading_column_scaled_by_range(x, l):
    e, H = observe(x, l)
    H[1, 2] = -e[0]
    return e, H


@answer_to("05.2")
def absolute_bearing(x, l):
    e, H = observe(x, l)
    return np.abs(e), H


@answer_to("05.2")
def robot_columns_at_the_end(x, l):
    e, H = observe(x, l)
    return e, np.hstack([H[:, 3:], H[:, :3]])


@answer_to("05.2")
def nine_columns_always(x, l):
    e, H = observe(x, l)
    return e, H[:, :9] if H.shape[1] > 9 else H


@answer_to("05.2", right=True)
def by_the_gradient_of_the_complex_logarithm(x, l):
    d = complex(*(np.asarray(x)[l] - x[:2])) * np.exp(-1j * x[2])
    w = np.exp(-1j * x[2]) / d  # d(log r + i beta)
    H = np.zeros((2, len(x)))
    H[:, l] = [[w.real * abs(d), -w.imag * abs(d)], [w.imag, w.real]]
    H[:, :2] -= H[:, l]
    H[1, 2] -= 1
    return np.array([np.exp(np.log(abs(d))), np.log(d).imag + 6 * np.pi]), H


# --- 05.3 ---


@answer_to("05.3")
def wraps_the_state(x, P, y, R, e, H):
    x, P = correct(x, P, y, R, e, H)
    return wrap(x), P


@answer_to("05.3")
def gate_at_three_sigma(x, P, y, R, e, H):
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    if z @ np.linalg.solve(H @ P @ H.T + R, z) > 0.5:
        return x.copy(), P.copy()
    return correct(x, P, y, R, e, H)


@answer_to("05.3")
def range_only(x, P, y, R, e, H):
    K = P @ H[:1].T / (H[:1] @ P @ H[:1].T + R[:1, :1])
    return x + K[:, 0] * (y[0] - e[0]), P - K @ H[:1] @ P


@answer_to("05.3")
def adds_a_little_noise(x, P, y, R, e, H):
    x, P = correct(x, P, y, R, e, H)
    return x, P + 1e-3 * np.eye(len(x))


@answer_to("05.3", right=True)
def in_two_halves(x, P, y, R, e, H):
    """Decorrelated: first one number of the measurement, then the other, both linearised at e."""
    L = np.linalg.inv(np.linalg.cholesky(R))
    z, G = L @ [y[0] - e[0], wrap(y[1] - e[1])], L @ H
    dx, Q = np.zeros(len(x)), np.array(P)
    for h, v in zip(G, z, strict=True):
        K = Q @ h / (h @ Q @ h + 1)
        dx, Q = dx + K * (v - h @ dx), Q - np.outer(K, h @ Q)
    return x + dx, (Q + Q.T) / 2


# --- 05.4 ---


@answer_to("05.4")
def heading_wrapped_by_degrees(x, P, y, R):
    new, Q = augment(x, P, [y[0], np.degrees(y[1])], R)
    return new, Q


@answer_to("05.4")
def cross_covariance_with_the_first_landmark_lost(x, P, y, R):
    new, Q = augment(x, P, y, R)
    if len(x) > 3:
        Q[-2:, 3:5] = 0
        Q[3:5, -2:] = 0
    return new, Q


@answer_to("05.4")
def a_bit_larger_for_safety(x, P, y, R):
    new, Q = augment(x, P, y, R)
    Q[-2:, -2:] *= 1.2
    return new, Q


@answer_to("05.4")
def forgets_to_return_x(x, P, y, R):
    return augment(x, P, y, R)[1]


@answer_to("05.4", right=True)
def by_sampling_points_of_the_linear_map(x, P, y, R):
    """A square root of the augmented covariance, built column by column."""
    l, L_r, L_y = inverse_observation(x[:3], y)
    w, V = np.linalg.eigh(P)
    A = V * np.sqrt(np.clip(w, 0, None))
    C = np.linalg.cholesky(R)
    S = np.block([[A, np.zeros((len(x), 2))], [L_r @ A[:3], L_y @ C]])
    return np.hstack((x, l)), np.matmul(S, S.T)


# --- 05.5 ---


@answer_to("05.5")
def appends_to_the_callers_ids(x, P, ids, u, U, seen, ys, R):
    x, P, new = slam_frame(x, P, list(ids), u, U, seen, ys, R)
    ids.extend(new[len(ids) :])
    return x, P, ids


@answer_to("05.5")
def ids_sorted(x, P, ids, u, U, seen, ys, R):
    x, P, ids = slam_frame(x, P, ids, u, U, seen, ys, R)
    return x, P, sorted(ids)


@answer_to("05.5")
def corrects_twice(x, P, ids, u, U, seen, ys, R):
    known = [i for i, id in enumerate(seen) if id in ids]
    return slam_frame(x, P, ids, u, U, [seen[i] for i in known] + list(seen), np.vstack([ys[known], ys]), R)


@answer_to("05.5")
def forgets_covariances_of_the_robot(x, P, ids, u, U, seen, ys, R):
    x, P, ids = slam_frame(x, P, ids, u, U, seen, ys, R)
    P = P.copy()
    P[:3, 3:], P[3:, :3] = 0, 0
    return x, P, ids


@answer_to("05.5")
def moves_only_when_something_is_seen(x, P, ids, u, U, seen, ys, R):
    return slam_frame(x, P, ids, u, U, seen, ys, R) if len(seen) else (x.copy(), P.copy(), list(ids))


@answer_to("05.5", right=True)
def known_ones_by_uncertainty_ids_as_a_tuple(x, P, ids, u, U, seen, ys, R):
    """The toolbox's order: the most uncertain expectation first."""
    x, P = predict(x, P, u, U)
    place = {id: slice(3 + 2 * k, 5 + 2 * k) for k, id in enumerate(ids)}
    todo = [(id, y) for id, y in zip(seen, ys, strict=True) if id in place]
    while todo:
        E = [np.linalg.det((H := observe(x, place[id])[1]) @ P @ H.T) for id, _ in todo]
        id, y = todo.pop(int(np.argmax(E)))
        e, H = observe(x, place[id])
        x, P = correct(x, P, y, R, e, H)
    out = tuple(ids)
    for id, y in zip(seen, ys, strict=True):
        if id not in place:
            x, P = augment(x, P, y, R)
            out += (id,)
    return x, P, out


# --- right answers in other words ---


@answer_to("05.4", right=True)
def one_Jacobian_of_everything(x, P, y, R):
    n = len(x)
    l, L_r, L_y = inverse_observation(x[:3], y)
    J = np.zeros((n + 2, n + 2))
    J[:n, :n], J[n:, :3], J[n:, n:] = np.eye(n), L_r, L_y
    A = np.zeros((n + 2, n + 2))
    A[:n, :n], A[n:, n:] = P, R
    return [*x, *l], J @ A @ J.T


@answer_to("05.4", right=True)
def start_with_a_huge_covariance_then_correct_with_the_measurement(x, P, y, R):
    n = len(x)
    l, L_r, L_y = inverse_observation(x[:3], y)
    W = np.linalg.inv(L_y)
    S = np.zeros((n + 2, n + 2))
    S[:n, :n], S[n:, n:] = P, 1e6 * np.eye(2)
    H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W])
    return np.append(x, l), S - S @ H.T @ np.linalg.solve(H @ S @ H.T + R, H @ S)


@answer_to("05.4", right=True)
def into_a_matrix_of_zeros_lists(x, P, y, R):
    n = len(x)
    a = x[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    L_r, L_y = np.array([[1, 0, -y[0] * s], [0, 1, y[0] * c]]), np.array([[c, -y[0] * s], [s, y[0] * c]])
    S = np.zeros((n + 2, n + 2))
    S[:n, :n] = P
    S[:n, n:] = P[:, :3] @ L_r.T
    S[n:, :n] = S[:n, n:].T
    S[n:, n:] = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T
    return [*x, x[0] + y[0] * c, x[1] + y[0] * s], S.tolist()


@answer_to("05.3", right=True)
def joseph_s_form(x, P, y, R, e, H):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    d = y[1] - e[1]
    return x + K @ [y[0] - e[0], np.arctan2(np.sin(d), np.cos(d))], A @ P @ A.T + K @ R @ K.T


@answer_to("05.3", right=True)
def by_adding_information_lists_heading_with_a_turn_more(x, P, y, R, e, H):
    W = np.linalg.solve(R, H)
    P = np.linalg.inv(np.linalg.inv(P) + H.T @ W)
    x = x + P @ W.T @ np.array([y[0] - e[0], wrap(y[1] - e[1])])
    return [*x[:2], x[2] + 2 * np.pi, *x[3:]], P.tolist()


@answer_to("05.3", right=True)
def I_K_H_P_the_angle_wrapped_by_hand(x, P, y, R, e, H):
    z = np.array(y, float) - e
    while z[1] > np.pi:
        z[1] -= 2 * np.pi
    while z[1] <= -np.pi:
        z[1] += 2 * np.pi
    K = P @ H.T @ np.linalg.pinv(H @ P @ H.T + R)
    return x + K.dot(z), (np.identity(len(x)) - K.dot(H)).dot(P)


@answer_to("05.3", right=True)
def square_root_of_Z(x, P, y, R, e, H):
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = np.linalg.solve(L, H @ P).T
    z = np.array([y[0] - e[0], (y[1] - e[1] + np.pi) % (2 * np.pi) - np.pi])
    return x + W @ np.linalg.solve(L, z), P - W @ W.T


def place(ids, id):
    k = 3 + 2 * list(ids).index(id)
    return slice(k, k + 2)


def use(x, P, ids, known, id, y, R):
    """Correct with a known landmark, or start a new one."""
    if known:
        return *correct(x, P, y, R, *observe(x, place(ids, id))), ids
    return *augment(x, P, y, R), [*ids, id]


@answer_to("05.5", right=True)
def one_loop_new_landmarks_as_they_come(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    for id, y in zip(seen, ys, strict=True):
        x, P, ids = use(x, P, ids, id in ids, id, y, R)
    return x, P, list(ids)


@answer_to("05.5", right=True)
def new_landmarks_first(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    old, ids = set(ids), list(ids)
    for id, y in sorted(zip(seen, ys, strict=True), key=lambda pair: pair[0] in old):
        x, P, ids = use(x, P, ids, id in old, id, y, R)
    return x, P, ids


@answer_to("05.5", right=True)
def all_known_landmarks_in_one_correction_lists_and_an_array_of_ids(x, P, ids, u, U, seen, ys, R):
    x, P = predict(x, P, u, U)
    known = [i for i, id in enumerate(seen) if id in ids]
    if known:
        rows = [observe(x, place(ids, seen[i])) for i in known]
        H = np.vstack([H for _, H in rows])
        z = np.concatenate([[ys[i][0] - e[0], wrap(ys[i][1] - e[1])] for i, (e, _) in zip(known, rows, strict=True)])
        K = np.linalg.solve(H @ P @ H.T + np.kron(np.eye(len(known)), R), H @ P).T
        x, P = x + K @ z, P - K @ H @ P
        P = (P + P.T) / 2
    for i, id in enumerate(seen):
        if i not in known:
            x, P = augment(x, P, ys[i], R)
            ids = [*ids, id]
    return x.tolist(), P.tolist(), np.array(ids)


@answer_to("05.5", right=True)
def in_the_opposite_order_heading_not_wrapped(x, P, ids, u, U, seen, ys, R):
    x, P, ids = slam_frame(x, P, ids, u, U, seen[::-1], ys[::-1], R)
    x[2] += 2 * np.pi
    return x, P, ids


@answer_to("05.2", right=True)
def by_the_chain_rule_through_the_robot_frame(x, l):
    c, s = np.cos(x[2]), np.sin(x[2])
    T = np.array([[c, s], [-s, c]])
    p = T @ (x[l] - x[:2])
    r = np.hypot(*p)
    E_p = np.array([p / r, [-p[1] / r**2, p[0] / r**2]])
    H = np.zeros((2, len(x)))
    H[:, l] += E_p @ T
    H[:, :3] += E_p @ np.column_stack([-T, [p[1], -p[0]]])
    return (r, np.arctan2(p[1], p[0])), H


@answer_to("05.2", right=True)
def complex_numbers_whole_turns_added_lists(x, l):
    i, d = l.start, complex(*(x[l] - x[:2]))
    H = [[0.0] * len(x), [0.0] * len(x)]
    H[0][0], H[0][1], H[0][i], H[0][i + 1] = -d.real / abs(d), -d.imag / abs(d), d.real / abs(d), d.imag / abs(d)
    g = 1 / d
    H[1][0], H[1][1], H[1][2], H[1][i], H[1][i + 1] = -g.imag, -g.real, -1.0, g.imag, g.real
    return [abs(d), np.angle(d) - float(x[2]) - 2 * np.pi], H


@answer_to("05.2", right=True)
def finite_differences(x, l):
    def value(x):
        dx, dy = x[l] - x[:2]
        return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - x[2]])

    J = [(value(x + d) - value(x - d)) / 2e-6 for d in 1e-6 * np.eye(len(x))]
    return value(x), np.transpose(J)


@answer_to("05.1", right=True)
def one_big_Jacobian_heading_wrapped(x, P, u, U):
    c, s = np.cos(x[2]), np.sin(x[2])
    X_x = np.array([[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]], [0, 0, 1]])
    X_u = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    new = np.concatenate([x[:3] + X_u @ u, x[3:]])
    new[2] = np.arctan2(np.sin(new[2]), np.cos(new[2]))
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[:3, :3], G[:3] = X_x, X_u
    return new, F @ P @ F.T + G @ U @ G.T


@answer_to("05.1", right=True)
def the_model_of_the_toolbox_whole_turns_added_lists(x, P, u, U):
    x_r, X_x, X_u = Odometry2().move(x[:3], u, 1.0)
    return [*x_r[:2], x_r[2] + 4 * np.pi, *x[3:]], moved(P, X_x, X_u, U).tolist()


@answer_to("05.1", right=True)
def finite_differences_block_by_block(x, P, u, U):
    step = lambda v: (
        v[:3] + np.array([[np.cos(v[2]), -np.sin(v[2]), 0], [np.sin(v[2]), np.cos(v[2]), 0], [0, 0, 1]]) @ v[3:]
    )
    v = np.concatenate([x[:3], u])
    J = np.stack([(step(v + d) - step(v - d)) / 2e-6 for d in 1e-6 * np.eye(6)], 1)
    C = J[:, :3] @ P[:3, 3:]
    return np.concatenate([step(v), x[3:]]), np.block(
        [[J[:, :3] @ P[:3, :3] @ J[:, :3].T + J[:, 3:] @ U @ J[:, 3:].T, C], [C.T, P[3:, 3:]]]
    )


test_the_check_is_right_about_it = check_of(__name__)
