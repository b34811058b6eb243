"""Answers to the exercises of notebooks 00 and 01 that are in no list of the package."""

import math

import numpy as np
import scipy.linalg

from ekfslam_tutorial.course.exercises.nb00_wrap import wrap
from ekfslam_tutorial.course.exercises.nb01_correct import correct
from ekfslam_tutorial.course.exercises.nb01_innovation import innovation
from ekfslam_tutorial.course.exercises.nb01_move import move
from ekfslam_tutorial.models.motion import Unicycle

from .probes import Probes, judged_rightly

probes = Probes()
wrong, right = probes.wrong, probes.right


@probes.each
def test_the_check_is_right_about_it(id, says, answer):
    judged_rightly(id, says, answer)


# --- 00.1 wrap ---


@wrong("00.1", "between pi and 2 pi|between -pi and pi|2 pi")
def modulo_pi(angle):
    return angle % np.pi


@wrong("00.1", "2 pi")
def whole_turns_by_int(angle):
    return angle - 2 * np.pi * int(angle / (2 * np.pi))


@wrong("00.1", "rounded")
def pi_is_3_14(angle):
    return (angle + 3.14) % 6.28 - 3.14


@wrong("00.1", "rounded")
def rounded(angle):
    return np.round(wrap(angle), 2)


@wrong("00.1", "half turns|arctan2|direction")
def arcsine(angle):
    return np.arcsin(np.sin(angle))


@wrong("00.1", "sign|left")
def arccosine(angle):
    return np.arccos(np.cos(angle))


@wrong("00.1", "numpy .* take arrays")
def math_functions(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


@wrong("00.1", "array|number")
def always_an_array(angle):
    return np.atleast_1d(wrap(angle))


@wrong("00.1", "changes its input|number")
def in_place(angle):
    angle[angle > np.pi] -= 2 * np.pi
    angle[angle < -np.pi] += 2 * np.pi
    return angle


@wrong("00.1", "array")
def if_on_the_remainder(angle):
    a = angle % (2 * np.pi)
    if a > np.pi:
        a = a - 2 * np.pi
    return a


@wrong("00.1", "return")
def prints_it(angle):
    print(wrap(angle))


@wrong("00.1", "many|several|loop|all turns")
def two_turns_at_most(angle):
    for _ in range(2):
        angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
        angle = np.where(angle <= -np.pi, angle + 2 * np.pi, angle)
    return angle


@right("00.1")
def remainder_for_each(angle):
    return np.vectorize(lambda a: math.remainder(a, math.tau))(angle)


@right("00.1")
def turns_by_ceil(angle):
    return angle - 2 * np.pi * np.ceil((angle - np.pi) / (2 * np.pi))


@right("00.1")
def masks_until_done(angle):
    a = np.array(angle, dtype=float)
    while np.any(a > np.pi):
        a = np.where(a > np.pi, a - 2 * np.pi, a)
    while np.any(a < -np.pi):
        a = np.where(a < -np.pi, a + 2 * np.pi, a)
    return a


@right("00.1")
def by_cases(angle):
    a = np.fmod(angle, 2 * np.pi)
    return a + np.where(a > np.pi, -2 * np.pi, np.where(a < -np.pi, 2 * np.pi, 0))


# --- 01.2 move ---


@wrong("01.2", "middle of the turn")
def heading_in_the_middle_of_the_turn(x, u, dt):
    half = np.array([x[0], x[1], x[2] + u[1] * dt / 2])
    x2, F_x, F_u = move(half, u, dt)
    return np.array([x2[0], x2[1], x[2] + u[1] * dt]), F_x, F_u


@wrong("01.2", "straight ahead|drives v dt|w = 0|ZeroDivision|division")
def exact_arc(x, u, dt):
    r, a = u[0] / u[1], x[2] + u[1] * dt
    x2 = np.array([x[0] + r * (np.sin(a) - np.sin(x[2])), x[1] - r * (np.cos(a) - np.cos(x[2])), a])
    return x2, move(x, u, dt)[1], move(x, u, dt)[2]


@wrong("01.2", "exact arc.*straight ahead first")
def model_of_the_package(x, u, dt):
    return Unicycle().move(x, u, dt)


@wrong("01.2", "exact arc.*straight ahead first")
def arc_by_the_chord(x, u, dt):
    half = u[1] * dt / 2
    chord = u[0] * dt * np.sinc(half / np.pi)
    x2 = np.array([x[0] + chord * np.cos(x[2] + half), x[1] + chord * np.sin(x[2] + half), x[2] + u[1] * dt])
    return x2, *move(x, u, dt)[1:]


@wrong("01.2", "to the left")
def turned_the_other_way(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return np.array([x2[0], x2[1], x[2] - u[1] * dt]), F_x, F_u


@wrong("01.2", "three results|return x2, F_x, F_u|3 results")
def two_results(x, u, dt):
    return move(x, u, dt)[:2]


@wrong("01.2", "F_x")
def jacobians_swapped(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_u, F_x


@wrong("01.2", r"F_u\[2, 1\]|by w")
def turn_not_in_F_u(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    F_u[2, 1] = 0
    return x2, F_x, F_u


@wrong("01.2", r"F_x\[0, 2\]|F_x\[1, 2\]|theta")
def speed_instead_of_distance_in_one_row(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    F_x[1, 2] = u[0] * np.cos(x[2])
    return x2, F_x, F_u


@wrong("01.2", r"dx|shape \(3, 2\)|F_u")
def control_in_F_u_multiplied_out(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_x, F_u @ u


@wrong("01.2", "changes its input")
def moves_the_old_pose(x, u, dt):
    F_x, F_u = move(x, u, dt)[1:]
    x += move(x, u, dt)[0] - x
    return x, F_x, F_u


@wrong("01.2", "decimals|int")
def array_of_integers(x, u, dt):
    x2 = np.array([0, 0, 0])
    x2[:] = move(x, u, dt)[0]
    return x2, *move(x, u, dt)[1:]


@wrong("01.2", "(?s)F_x.*shape|shape")
def F_x_without_the_heading_row(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return x2, F_x[:2], F_u


@right("01.2")
def by_rotation_matrix(x, u, dt):
    c, s = np.cos(x[2]), np.sin(x[2])
    T = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    step = np.array([u[0] * dt, 0, u[1] * dt])
    dT = np.array([[-s, -c, 0], [c, -s, 0], [0, 0, 0]])
    F_x = np.eye(3)
    F_x[:, 2] += dT @ step
    return x + T @ step, F_x, T[:, [0, 2]] * dt


@right("01.2")
def complex_step(x, u, dt):
    f = lambda x, u: np.array([x[0] + u[0] * dt * np.cos(x[2]), x[1] + u[0] * dt * np.sin(x[2]), x[2] + u[1] * dt])
    F_x = np.column_stack([f(x + 1e-20j * e, u).imag / 1e-20 for e in np.eye(3)])
    F_u = np.column_stack([f(x, u + 1e-20j * e).imag / 1e-20 for e in np.eye(2)])
    return f(x, u), F_x, F_u


@right("01.2")
def matrices_of_numpy(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return (x2[0], x2[1], x2[2]), np.matrix(F_x), np.matrix(F_u)


# --- 01.3 innovation ---


@wrong("01.3", "bearing|wrap")
def wrapped_before_only(y, e):
    return np.subtract([y[..., 0], wrap(y[..., 1])], [e[..., 0], wrap(e[..., 1])]).T


@wrong("01.3", r"\.\.\., 1|row|shape")
def flat(y, e):
    return np.array([y[..., 0] - e[..., 0], wrap(y[..., 1] - e[..., 1])])


@wrong("01.3", r"at \[0\] only")
def range_relative(y, e):
    z = innovation(y, e)
    z[..., 0] /= e[..., 0]
    return z


@wrong("01.3", "changes its input")
def works_in_place(y, e):
    y -= e
    y[..., 1] = wrap(y[..., 1])
    return y


@wrong("01.3", r"at \[1\] only")
def sine_of_the_difference(y, e):
    z = np.subtract(y, e)
    z[..., 1] = np.sin(z[..., 1])
    return z


@wrong("01.3", r"\.\.\., 1|many|row")
def first_axis(y, e):
    return np.array([y[0] - e[0], wrap(y[1] - e[1])])


@wrong("01.3", "wrap|turn")
def wrapped_if_too_large_once(y, e):
    z = np.array(np.subtract(y, e))
    b = z[..., 1]
    z[..., 1] = np.where(b > np.pi, b - 2 * np.pi, b)
    return z


@wrong("01.3", "order|range first|\\[range, bearing\\]|sign|y - e")
def bearing_first(y, e):
    return innovation(y, e)[..., ::-1]


@right("01.3")
def two_columns_stacked(y, e):
    d = np.atleast_2d(y) - np.atleast_2d(e)
    d = np.column_stack([d[:, 0], np.angle(np.exp(1j * d[:, 1]))])
    return d.reshape(np.shape(y))


@right("01.3")
def turns_by_floor(y, e):
    z = np.asarray(y) - np.asarray(e)
    return z - 2 * np.pi * np.floor((z + np.pi) / (2 * np.pi)) * np.array([0, 1])


@right("01.3")
def row_by_row(y, e):
    one = lambda a, b: [a[0] - b[0], math.atan2(math.sin(a[1] - b[1]), math.cos(a[1] - b[1]))]
    return one(y, e) if np.ndim(y) == 1 else [one(a, b) for a, b in zip(y, e, strict=True)]


# --- 01.4 correct ---


@wrong("01.4", "z|innovation")
def correction_of_the_measurement_twice(x, P, z, H, R):
    new, C = correct(x, P, z, H, R)
    return new + (new - x), C


@wrong("01.4", "R|noise")
def R_added_to_P(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P + K @ R @ K.T


@wrong("01.4", "innovation|y - e|H x")
def innovation_computed_again(x, P, z, H, R):
    new, C = correct(x, P, z - H @ x, H, R)
    return new, C


@wrong("01.4", "shape|dimension|core|fit|sizes")
def gain_transposed(x, P, z, H, R):
    K = np.linalg.inv(H @ P @ H.T + R) @ H @ P
    return x + K @ z, P - K @ H @ P


@wrong("01.4", "inv|entry|solve")
def solve_on_the_wrong_side(x, P, z, H, R):
    Z = H @ P @ H.T + R
    K = (P @ H.T) / np.diag(Z)
    return x + K @ z, P - K @ Z @ K.T


@wrong("01.4", "symmetric|P|order")
def P_times_K_H_transposed(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - (K @ H @ P @ H.T @ K.T)


@wrong("01.4", "return|results")
def returns_the_gain(x, P, z, H, R):
    return P @ H.T @ np.linalg.inv(H @ P @ H.T + R)


@wrong("01.4", "changes its input")
def updates_in_place(x, P, z, H, R):
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    x += K @ z
    P -= K @ H @ P
    return x, P


@wrong("01.4", "@|product|shape|fit")
def stars_for_products(x, P, z, H, R):
    Z = H * P * H.T + R
    K = P * H.T * np.linalg.inv(Z)
    return x + K * z, P - K * H * P


@wrong("01.4", "depend|measured")
def P_scaled_by_the_surprise(x, P, z, H, R):
    new, C = correct(x, P, z, H, R)
    d2 = z @ np.linalg.solve(H @ P @ H.T + R, z)
    return new, C * max(1.0, d2 / 100)


@right("01.4")
def square_root_by_cholesky(x, P, z, H, R):
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = scipy.linalg.solve_triangular(L, H @ P, lower=True).T
    return x + W @ scipy.linalg.solve_triangular(L, z, lower=True), P - W @ W.T


@right("01.4")
def least_squares_of_prior_and_measurement(x, P, z, H, R):
    A = np.vstack([np.linalg.inv(np.linalg.cholesky(P)), np.linalg.inv(np.linalg.cholesky(R)) @ H])
    b = np.concatenate([np.zeros(len(x)), np.linalg.inv(np.linalg.cholesky(R)) @ z])
    return x + np.linalg.lstsq(A, b, rcond=None)[0], np.linalg.inv(A.T @ A)


@right("01.4")
def with_columns_inside(x, P, z, H, R):
    x, z = np.reshape(x, (-1, 1)), np.reshape(z, (-1, 1))
    K = P.dot(H.T).dot(np.linalg.inv(H.dot(P).dot(H.T) + R))
    return (x + K.dot(z)).flatten(), (np.identity(x.shape[0]) - K.dot(H)).dot(P)
