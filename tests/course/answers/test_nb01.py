"""Answers to the exercises of notebook 01 that are in no list of the package: wrong ones, and odd right ones."""

import math

import numpy as np
import scipy.linalg

from ekfslam_tutorial.course.exercises.nb00_wrap import wrap
from ekfslam_tutorial.course.exercises.nb01_correct import correct
from ekfslam_tutorial.course.exercises.nb01_innovation import innovation
from ekfslam_tutorial.course.exercises.nb01_move import move
from ekfslam_tutorial.geometry import numerical_jacobian
from ekfslam_tutorial.models.motion import Unicycle

from .collector import answer_to, check_of

# --- 01.2 move ---


@answer_to("01.2", hint=r"`x\[2\] \+ u\[1\] \* dt / 2` stood where `x\[2\]` belongs")
def heading_in_the_middle_of_the_turn(x, u, dt):
    half = np.array([x[0], x[1], x[2] + u[1] * dt / 2])
    x2, F_x, F_u = move(half, u, dt)
    return np.array([x2[0], x2[1], x[2] + u[1] * dt]), F_x, F_u


@answer_to("01.2", hint="straight ahead|drives v dt|w = 0|ZeroDivision|division")
def exact_arc(x, u, dt):
    r, a = u[0] / u[1], x[2] + u[1] * dt
    x2 = np.array([x[0] + r * (np.sin(a) - np.sin(x[2])), x[1] - r * (np.cos(a) - np.cos(x[2])), a])
    return x2, move(x, u, dt)[1], move(x, u, dt)[2]


@answer_to("01.2", hint="exact arc.*straight ahead first")
def model_of_the_package(x, u, dt):
    return Unicycle().move(x, u, dt)


@answer_to("01.2", hint="exact arc.*straight ahead first")
def arc_by_the_chord(x, u, dt):
    half = u[1] * dt / 2
    chord = u[0] * dt * np.sinc(half / np.pi)
    x2 = np.array([x[0] + chord * np.cos(x[2] + half), x[1] + chord * np.sin(x[2] + half), x[2] + u[1] * dt])
    return x2, *move(x, u, dt)[1:]


@answer_to("01.2", hint="to the left")
def turned_the_other_way(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return np.array([x2[0], x2[1], x[2] - u[1] * dt]), F_x, F_u


@answer_to("01.2", hint="three results|return x2, F_x, F_u|3 results")
def two_results(x, u, dt):
    return move(x, u, dt)[:2]


@answer_to("01.2", hint="F_x")
def jacobians_swapped(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_u, F_x


@answer_to("01.2", hint=r"F_u\[2, 1\]|by w")
def turn_not_in_F_u(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    F_u[2, 1] = 0
    return x2, F_x, F_u


@answer_to("01.2", hint=r"F_x\[0, 2\]|F_x\[1, 2\]|theta")
def speed_instead_of_distance_in_one_row(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    F_x[1, 2] = u[0] * np.cos(x[2])
    return x2, F_x, F_u


@answer_to("01.2", hint=r"dx|shape \(3, 2\)|F_u")
def control_in_F_u_multiplied_out(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_x, F_u @ u


@answer_to("01.2", hint="changes its input")
def moves_the_old_pose(x, u, dt):
    F_x, F_u = move(x, u, dt)[1:]
    x += move(x, u, dt)[0] - x
    return x, F_x, F_u


@answer_to("01.2", hint="decimals|int")
def array_of_integers(x, u, dt):
    x2 = np.array([0, 0, 0])
    x2[:] = move(x, u, dt)[0]
    return x2, *move(x, u, dt)[1:]


@answer_to("01.2", hint="(?s)F_x.*shape|shape")
def F_x_without_the_heading_row(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_x[:2], F_u


@answer_to("01.2", right=True)
def by_rotation_matrix(x, u, dt):
    c, s = np.cos(x[2]), np.sin(x[2])
    T = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    step = np.array([u[0] * dt, 0, u[1] * dt])
    dT = np.array([[-s, -c, 0], [c, -s, 0], [0, 0, 0]])
    F_x = np.eye(3)
    F_x[:, 2] += dT @ step
    return x + T @ step, F_x, T[:, [0, 2]] * dt


@answer_to("01.2", right=True)
def complex_step(x, u, dt):
    f = lambda x, u: np.array([x[0] + u[0] * dt * np.cos(x[2]), x[1] + u[0] * dt * np.sin(x[2]), x[2] + u[1] * dt])
    F_x = np.column_stack([f(x + 1e-20j * e, u).imag / 1e-20 for e in np.eye(3)])
    F_u = np.column_stack([f(x, u + 1e-20j * e).imag / 1e-20 for e in np.eye(2)])
    return f(x, u), F_x, F_u


@answer_to("01.2", right=True)
def matrices_of_numpy(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return (x2[0], x2[1], x2[2]), np.matrix(F_x), np.matrix(F_u)


# --- 01.3 innovation ---


@answer_to("01.3", hint="bearing|wrap")
def wrapped_before_only(y, e):
    return np.subtract([y[..., 0], wrap(y[..., 1])], [e[..., 0], wrap(e[..., 1])]).T


@answer_to("01.3", hint=r"\.\.\., 1|row|shape")
def flat(y, e):
    return np.array([y[..., 0] - e[..., 0], wrap(y[..., 1] - e[..., 1])])


@answer_to("01.3", hint=r"at \[0\] only")
def range_relative(y, e):
    z = innovation(y, e)
    z[..., 0] /= e[..., 0]
    return z


@answer_to("01.3", hint="changes its input")
def works_in_place(y, e):
    y -= e
    y[..., 1] = wrap(y[..., 1])
    return y


@answer_to("01.3", hint=r"at \[1\] only")
def sine_of_the_difference(y, e):
    z = np.subtract(y, e)
    z[..., 1] = np.sin(z[..., 1])
    return z


@answer_to("01.3", hint=r"\.\.\., 1|many|row")
def first_axis(y, e):
    return np.array([y[0] - e[0], wrap(y[1] - e[1])])


@answer_to("01.3", hint="wrap|turn")
def wrapped_if_too_large_once(y, e):
    z = np.array(np.subtract(y, e))
    b = z[..., 1]
    z[..., 1] = np.where(b > np.pi, b - 2 * np.pi, b)
    return z


@answer_to("01.3", hint="order|range first|\\[range, bearing\\]|sign|y - e")
def bearing_first(y, e):
    return innovation(y, e)[..., ::-1]


@answer_to("01.3", right=True)
def two_columns_stacked(y, e):
    d = np.atleast_2d(y) - np.atleast_2d(e)
    d = np.column_stack([d[:, 0], np.angle(np.exp(1j * d[:, 1]))])
    return d.reshape(np.shape(y))


@answer_to("01.3", right=True)
def turns_by_floor(y, e):
    z = np.asarray(y) - np.asarray(e)
    return z - 2 * np.pi * np.floor((z + np.pi) / (2 * np.pi)) * np.array([0, 1])


@answer_to("01.3", right=True)
def row_by_row(y, e):
    one = lambda a, b: [a[0] - b[0], math.atan2(math.sin(a[1] - b[1]), math.cos(a[1] - b[1]))]
    return one(y, e) if np.ndim(y) == 1 else [one(a, b) for a, b in zip(y, e, strict=True)]


# --- 01.4 correct ---


@answer_to("01.4", hint="z|innovation")
def correction_of_the_measurement_twice(x, P, z, H, R):
    new, C = correct(x, P, z, H, R)
    return new + (new - x), C


@answer_to("01.4", hint="R|noise")
def R_added_to_P(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P + K @ R @ K.T


@answer_to("01.4", hint="innovation|y - e|H x")
def innovation_computed_again(x, P, z, H, R):
    new, C = correct(x, P, z - H @ x, H, R)
    return new, C


@answer_to("01.4", hint="shape|dimension|core|fit|sizes")
def gain_transposed(x, P, z, H, R):
    K = np.linalg.inv(H @ P @ H.T + R) @ H @ P
    return x + K @ z, P - K @ H @ P


@answer_to("01.4", hint="inv|entry|solve")
def solve_on_the_wrong_side(x, P, z, H, R):
    Z = H @ P @ H.T + R
    K = (P @ H.T) / np.diag(Z)
    return x + K @ z, P - K @ Z @ K.T


@answer_to("01.4", hint="symmetric|P|order")
def P_times_K_H_transposed(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - (K @ H @ P @ H.T @ K.T)


@answer_to("01.4", hint="return|results")
def returns_the_gain(x, P, z, H, R):
    return P @ H.T @ np.linalg.inv(H @ P @ H.T + R)


@answer_to("01.4", hint="changes its input")
def updates_in_place(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x += K @ z
    P -= K @ H @ P
    return x, P


@answer_to("01.4", hint="@|product|shape|fit")
def stars_for_products(x, P, z, H, R):
    Z = H * P * H.T + R
    K = P * H.T * np.linalg.inv(Z)
    return x + K * z, P - K * H * P


@answer_to("01.4", hint="depend|measured")
def P_scaled_by_the_surprise(x, P, z, H, R):
    new, C = correct(x, P, z, H, R)
    d2 = z @ np.linalg.solve(H @ P @ H.T + R, z)
    return new, C * max(1.0, d2 / 100)


@answer_to("01.4", right=True)
def square_root_by_cholesky(x, P, z, H, R):
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = scipy.linalg.solve_triangular(L, H @ P, lower=True).T
    return x + W @ scipy.linalg.solve_triangular(L, z, lower=True), P - W @ W.T


@answer_to("01.4", right=True)
def least_squares_of_prior_and_measurement(x, P, z, H, R):
    A = np.vstack([np.linalg.inv(np.linalg.cholesky(P)), np.linalg.inv(np.linalg.cholesky(R)) @ H])
    b = np.concatenate([np.zeros(len(x)), np.linalg.inv(np.linalg.cholesky(R)) @ z])
    return x + np.linalg.lstsq(A, b, rcond=None)[0], np.linalg.inv(A.T @ A)


@answer_to("01.4", right=True)
def with_columns_inside(x, P, z, H, R):
    x, z = np.reshape(x, (-1, 1)), np.reshape(z, (-1, 1))
    K = P.dot(H.T).dot(np.linalg.inv(H.dot(P).dot(H.T) + R))
    return (x + K.dot(z)).flatten(), (np.identity(x.shape[0]) - K.dot(H)).dot(P)


# --- right answers in other words ---


@answer_to("01.4", right=True)
def I_K_H_P_with_solve_as_lists(x, P, z, H, R):
    PHt = P @ H.T
    K = np.linalg.solve(H @ PHt + R, PHt.T).T
    return list(x + K @ z), ((np.eye(len(x)) - K @ H) @ P).tolist()


@answer_to("01.4", right=True)
def joseph_s_form(x, P, z, H, R):
    K = P @ H.T @ np.linalg.pinv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    return x + K.dot(z), A @ P @ A.T + K @ R @ K.T


@answer_to("01.4", right=True)
def by_adding_information(x, P, z, H, R):
    W = np.linalg.solve(R, H)
    C = np.linalg.inv(np.linalg.inv(P) + H.T @ W)
    return x + C @ W.T @ z, C


@answer_to("01.3", right=True)
def arctan2_of_sine_and_cosine(y, e):
    d = np.asarray(y) - np.asarray(e)
    return np.stack([d[..., 0], np.arctan2(np.sin(d[..., 1]), np.cos(d[..., 1]))], -1)


@answer_to("01.3", right=True)
def bearings_wrapped_before_too_lists(y, e):
    y, e = np.array(y, float), np.array(e, float)
    b = (wrap(y[..., 1]) - wrap(e[..., 1]) + np.pi) % (2 * np.pi) - np.pi
    return np.stack([y[..., 0] - e[..., 0], b], -1).tolist()


@answer_to("01.3", right=True)
def nearest_whole_turn_removed(y, e):
    z = np.asarray(y, float) - e
    return z - 2 * np.pi * np.round(z / (2 * np.pi)) * [0, 1]


@answer_to("01.2", right=True)
def lists_heading_with_a_turn_more(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return [x2[0], x2[1], x2[2] + 2 * np.pi], F_x.tolist(), F_u.tolist()


@answer_to("01.2", right=True)
def heading_wrapped_Jacobians_filled_entry_by_entry(x, u, dt):
    v, w = u
    F_x, F_u = np.eye(3), np.zeros((3, 2))
    F_x[0, 2], F_x[1, 2] = -v * dt * np.sin(x[2]), v * dt * np.cos(x[2])
    F_u[0, 0], F_u[1, 0], F_u[2, 1] = dt * np.cos(x[2]), dt * np.sin(x[2]), dt
    x2 = x + F_u @ u
    return np.array([x2[0], x2[1], np.arctan2(np.sin(x2[2]), np.cos(x2[2]))]), F_x, F_u


@answer_to("01.2", right=True)
def finite_differences(x, u, dt):
    after = lambda x, u: x + np.array([u[0] * dt * np.cos(x[2]), u[0] * dt * np.sin(x[2]), u[1] * dt])
    return after(x, u), numerical_jacobian(lambda a: after(a, u), x), numerical_jacobian(lambda a: after(x, a), u)


test_the_check_is_right_about_it = check_of(__name__)
