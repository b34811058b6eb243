"""Answers to the exercises of notebook 20 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb20_guard import guard
from ekfslam_tutorial.course.exercises.nb20_repair import turn_go_turn
from ekfslam_tutorial.geometry import numerical_jacobian, wrap

from .collector import answer_to, check_of

# --- 20.2 the guard ---


@answer_to("20.2", hint="matrix of the shape of P|shape|array")
def only_an_alarm(predict, x, P, u, U):
    return bool(np.abs(guard(predict, x, P, u, U)).max() > 1e-6)


@answer_to("20.2", hint="F_x P F_x'|zero|wrong")
def always_silent(predict, x, P, u, U):
    return np.zeros((len(x), len(x)))


@answer_to("20.2", hint="P_rm|P2|F_x P F_x'|before")
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


@answer_to("20.2", hint="shape|LinAlg|ValueError|broadcast|fit|@")
def shapes_for_three_controls_only(predict, x, P, u, U):
    G = np.zeros((len(x), 3))
    G[:3, :3] = np.eye(3)
    return guard(predict, x, P, u, U) + 0 * G @ U @ G.T


@answer_to("20.2", hint="zero|F_x P F_x'|difference")
def relative_to_the_right_value(predict, x, P, u, U):
    P2 = predict(x, P, u, U)[1]
    return guard(predict, x, P, u, U) / np.abs(P2).max()


@answer_to("20.2", hint="seam|wrap")
def seam_cut_out_of_the_wrong_entry(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def f(x, u):
        d = predict(x, P, u, U)[0] - x2
        d[1] = wrap(d[1])
        return d

    F, G = numerical_jacobian(lambda a: f(a, u), x), numerical_jacobian(lambda b: f(x, b), u)
    return P2 - F @ P @ F.T - G @ U @ G.T


@answer_to("20.2", right=True)
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


@answer_to("20.2", right=True)
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


@answer_to("20.3", hint="heading|theta")
def heading_in_degrees(x, P, u, U):
    new, P = turn_go_turn(x, P, u, U)
    return np.concatenate([new[:2], np.degrees(new[2:3]), new[3:]]), P


@answer_to("20.3", hint="X_x|heading|finite")
def exact_only_without_turns(x, P, u, U):
    new, _ = turn_go_turn(x, P, u, U)
    return new, turn_go_turn(x, P, np.array([0, u[1], 0]), U)[1]


@answer_to("20.3", hint="X_u|noise|order")
def noise_columns_in_another_order(x, P, u, U):
    new, P0 = turn_go_turn(x, P, u, 0 * U)
    order = [1, 0, 2]
    return new, P0 + turn_go_turn(x, 0 * P, u, U[np.ix_(order, order)])[1]


@answer_to("20.3", hint=r"Wrong at \[3, 3\]")
def landmarks_drift_along(x, P, u, U):
    new, P = turn_go_turn(x, P, u, U)
    P = P + 1e-3 * np.diag([0, 0, 0, *(len(x) - 3) * [1]])
    return new, P


@answer_to("20.3", hint="changes its input")
def in_place(x, P, u, U):
    new, P_new = turn_go_turn(x, P, u, U)
    P[:] = P_new
    return new, P


@answer_to("20.3", right=True)
def as_odometry_in_the_frame_of_the_robot(x, P, u, U):
    r1, t, r2 = u
    J = np.array([[-t * np.sin(r1), np.cos(r1), 0], [t * np.cos(r1), np.sin(r1), 0], [1, 0, 1]])  # of [dx, dy, dtheta]
    c, s = np.cos(x[2]), np.sin(x[2])
    d, turn = np.array([t * np.cos(r1), t * np.sin(r1)]), np.array([[c, -s], [s, c]])
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[:2, 2], G[:2, :2], G[2, 2] = turn @ [-d[1], d[0]], turn, 1
    new = x + np.concatenate([turn @ d, [r1 + r2], np.zeros(len(x) - 3)])
    return new, F @ P @ F.T + G @ J @ U @ J.T @ G.T


# --- 20.2: the same in other words ---


@answer_to("20.2", right=True)
def one_jacobian_of_everything(predict, x, P, u, U):
    n, (x2, P2) = len(x), predict(x, P, u, U)

    def moved(a):
        d = predict(a[:n], P, a[n:], U)[0] - x2
        d[2] = np.arctan2(np.sin(d[2]), np.cos(d[2]))
        return d

    J = numerical_jacobian(moved, np.concatenate([x, u]))
    S = np.zeros((n + len(u), n + len(u)))
    S[:n, :n], S[n:, n:] = P, U
    return (P2 - J @ S @ J.T).tolist()


@answer_to("20.2", right=True)
def differences_by_hand(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def column(dx, du):
        d = predict(x + dx, P, u + du, U)[0] - predict(x - dx, P, u - du, U)[0]
        d[2] = (d[2] + np.pi) % (2 * np.pi) - np.pi
        return d / 2e-5

    F_x = np.array([column(h, 0 * u) for h in 1e-5 * np.eye(len(x))]).T
    F_u = np.array([column(0 * x, h) for h in 1e-5 * np.eye(len(u))]).T
    return np.subtract(P2, F_x @ P @ F_x.T) - F_u @ U @ F_u.T


@answer_to("20.2", right=True)
def sine_and_cosine_of_the_heading_turned_back(predict, x, P, u, U):
    x2, P2 = predict(x, P, u, U)

    def mean(x, u):
        new = np.array(predict(x, P, u, U)[0])
        new[2] += 2 * np.pi * np.round((x2[2] - new[2]) / (2 * np.pi))
        return new

    F_x = numerical_jacobian(lambda x: mean(x, u), x)
    F_u = numerical_jacobian(lambda u: mean(x, u), u)
    return P2 - F_x @ P @ F_x.T - F_u @ U @ F_u.T


# --- 20.3: the same in other words ---


@answer_to("20.3", right=True)
def whole_matrices(x, P, u, U):
    n, (r1, t, r2) = len(x), u
    a = x[2] + r1
    F, G = np.eye(n), np.zeros((n, 3))
    F[0, 2], F[1, 2] = -t * np.sin(a), t * np.cos(a)
    G[:3] = [[-t * np.sin(a), np.cos(a), 0], [t * np.cos(a), np.sin(a), 0], [1, 0, 1]]
    return x + G[:, 1] * t + [0, 0, r1 + r2, *(n - 3) * [0]], F @ P @ F.T + G @ U @ G.T


@answer_to("20.3", right=True)
def from_its_own_mean_by_finite_differences_lists_whole_turns_added(x, P, u, U):
    def mean(x, u):
        new = np.array(x, float)
        new[:3] += [u[1] * np.cos(x[2] + u[0]), u[1] * np.sin(x[2] + u[0]), u[0] + u[2] + 4 * np.pi]
        return new

    from ekfslam_tutorial.geometry import numerical_jacobian

    F, G = numerical_jacobian(lambda a: mean(a, u), x), numerical_jacobian(lambda b: mean(x, b), u)
    return mean(x, u).tolist(), (F @ P @ F.T + G @ U @ G.T).tolist()


@answer_to("20.3", right=True)
def three_motions_of_the_package_one_after_the_other(x, P, u, U):
    from ekfslam_tutorial.models.motion import Odometry2

    x, P, A = np.array(x, float), np.array(P, float), np.zeros((3, 3))
    for step, row in (([0, 0, u[0]], 0), ([u[1], 0, 0], 1), ([0, 0, u[2]], 2)):
        x[:3], X_x, X_u = Odometry2().move(x[:3], np.array(step), 1.0)
        P[:3] = X_x @ P[:3]
        P[:, :3] = P[:, :3] @ X_x.T
        A = X_x @ A
        A[:, row] += X_u[:, 0 if row == 1 else 2]
    P[:3, :3] += A @ U @ A.T
    return x, P


test_the_check_is_right_about_it = check_of(__name__)
