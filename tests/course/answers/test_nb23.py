"""Answers to the exercises of notebook 23 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb11_odo3 import positive
from ekfslam_tutorial.course.exercises.nb23_drift import drift
from ekfslam_tutorial.course.exercises.nb23_frame import move_frame
from ekfslam_tutorial.course.exercises.nb23_nees import flight_nees
from ekfslam_tutorial.course.exercises.nb23_step import imu_step
from ekfslam_tutorial.geometry import Frame3, e2q, numerical_jacobian, q2R, q_prod, unit, v2q
from ekfslam_tutorial.models.motion import Imu
from ekfslam_tutorial.models.motion.at_rest import at_rest

from .collector import answer_to, check_of

G = np.array([0, 0, -9.81])

# --- 23.1 a step ---


@answer_to("23.1", right=True)
def the_packages_model_as_lists(x, u, dt):
    x2, X_x, _ = Imu().move(x, np.concatenate([u, np.zeros(6)]), dt)
    return x2.tolist(), X_x[:, 10:].tolist()


@answer_to("23.1", right=True)
def finite_differences(x, u, dt):
    value = lambda b: imu_step(np.concatenate([x[:10], b]), u, dt)[0]
    return value(x[10:]), numerical_jacobian(value, x[10:])


@answer_to("23.1", right=True)
def the_quaternion_with_a_not_below_0(x, u, dt):
    return positive(*imu_step(x, u, dt))


@answer_to("23.1", right=True)
def velocity_first_then_its_mean(x, u, dt):
    w, a = u[:3] - x[10:13], u[3:] - x[13:]
    v2 = x[7:10] + dt * (q2R(q_prod(x[3:7], v2q(w * dt / 2)[0])[0])[0] @ a + G)
    q2 = q_prod(x[3:7], v2q(w * dt)[0])[0]
    return np.r_[x[:3] + dt * (x[7:10] + v2) / 2, q2, v2, x[10:]], imu_step(x, u, dt)[1]


@answer_to("23.1", hint="subtract|minus|bias")
def only_half_of_the_bias(x, u, dt):
    y = x.copy()
    y[10:] /= 2
    x2, X_b = imu_step(y, u, dt)
    x2[10:] = x[10:]
    return x2, X_b


@answer_to("23.1", hint="gravity|9.81|rest")
def gravity_of_the_moon(x, u, dt):
    x2, X_b = imu_step(x, u, dt)
    x2[7:10] += np.array([0, 0, 8.19]) * dt
    x2[:3] += np.array([0, 0, 8.19]) * dt**2 / 2
    return x2, X_b


@answer_to("23.1", hint="length|unit|q|turn|angle")
def eulers_turn(x, u, dt):
    x2, X_b = imu_step(x, u, dt)
    x2[3:7] = x[3:7] + 0.5 * dt * q_prod(x[3:7], np.r_[0, u[:3] - x[10:13]])[0]
    return x2, X_b


@answer_to("23.1", hint="order|shape")
def results_exchanged(x, u, dt):
    x2, X_b = imu_step(x, u, dt)
    return X_b, x2


@answer_to("23.1", hint="sign|opposite|subtracted")
def derivative_by_what_is_measured(x, u, dt):
    x2, _, X_u = Imu().move(x, np.concatenate([u, np.zeros(6)]), dt)
    return x2, X_u[:, :6]


# --- 23.2 a data sheet ---


@answer_to("23.2", right=True)
def block_by_block_as_lists(arw, density, gyro_walk, acc_walk, dt):
    s = [np.deg2rad(arw) / np.sqrt(3600 * dt), density * 9.80665e-6 / dt**0.5, gyro_walk * dt**0.5, acc_walk * dt**0.5]
    S = np.kron(np.diag(s), np.eye(3))
    return (S @ S.T).tolist()


@answer_to("23.2", right=True)
def by_the_packages_model(arw, density, gyro_walk, acc_walk, dt):
    return Imu(np.pi / 180 * arw / 60, density * 9.80665e-6, gyro_walk, acc_walk).noise(dt)


@answer_to("23.2", hint="dt|variance|mean")
def everything_times_dt(arw, density, gyro_walk, acc_walk, dt):
    n = [np.radians(arw) / 60, density * 9.80665e-6, gyro_walk, acc_walk]
    return np.diag(np.repeat(np.array(n) ** 2 * dt, 3))


@answer_to("23.2", hint="shape")
def four_variances(arw, density, gyro_walk, acc_walk, dt):
    n = [np.radians(arw) / 60 / dt**0.5, density * 9.80665e-6 / dt**0.5, gyro_walk * dt**0.5, acc_walk * dt**0.5]
    return np.diag(np.array(n) ** 2)


@answer_to("23.2", hint="60|hour")
def walk_in_an_hour_as_a_rate(arw, density, gyro_walk, acc_walk, dt):
    n = np.array([np.radians(arw) / 3600, density * 9.80665e-6])
    return np.diag(np.repeat([*n**2 / dt, gyro_walk**2 * dt, acc_walk**2 * dt], 3))


# --- 23.3 drift ---


@answer_to("23.3", right=True)
def by_one_rule_for_all(t, b_w, b_a, n_w, n_a):
    factorial = [1, 1, 2, 6]
    bias = lambda c, k: c * t**k / factorial[k]
    noise = lambda n, k: n * t ** (k - 0.5) / (factorial[k - 1] * (2 * k - 1) ** 0.5)
    return [9.81 * bias(b_w, 3), bias(b_a, 2), 9.81 * noise(n_w, 3), noise(n_a, 2)]


@answer_to("23.3", right=True)
def by_variances(t, b_w, b_a, n_w, n_a):
    g = 9.81
    return np.array(
        [g * b_w * t**3 / 6, b_a * t**2 / 2, (g**2 * n_w**2 * t**5 / 20) ** 0.5, (n_a**2 * t**3 / 3) ** 0.5]
    )


@answer_to("23.3", hint="three integrals|gravity|9.81")
def gyrometer_as_an_acceleration(t, b_w, b_a, n_w, n_a):
    off = drift(t, b_w, b_a, n_w, n_a)
    return np.array([9.81 * b_w * t**2 / 2, *off[1:]])


@answer_to("23.3", hint="shape|four")
def the_sum(t, b_w, b_a, n_w, n_a):
    return drift(t, b_w, b_a, n_w, n_a).sum()


@answer_to("23.3", hint="order|arguments|place")
def the_gyrometers_first(t, b_w, b_a, n_w, n_a):
    return drift(t, b_w, b_a, n_w, n_a)[[0, 2, 1, 3]]


# --- 23.4 rest ---


@answer_to("23.4", right=True)
def by_euler_angles(w, a, acc_bias_std):
    x, y, z = a.mean(axis=0)
    q = e2q(np.array([np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z)), 0.7]))[0]  # yaw: as one likes
    return q.tolist(), w.mean(axis=0).tolist(), acc_bias_std / 9.81


@answer_to("23.4", right=True)
def by_the_angle_and_an_axis(w, a, acc_bias_std):
    up = unit(a.sum(0))[0]
    axis = np.cross(up, [0, 0, 1.0])
    s = np.linalg.norm(axis)
    q = v2q(axis / s * np.arctan2(s, up[2]))[0] if s > 1e-12 else np.eye(4)[int(up[2] < 0)]
    return -q, w.sum(0) / len(w), np.arctan(acc_bias_std / 9.81) if acc_bias_std < 1e-3 else acc_bias_std / 9.81


@answer_to("23.4", right=True)
def by_the_package(w, a, acc_bias_std):
    x, _ = at_rest(w.mean(0), a.mean(0))
    return x[3:7], x[10:13], acc_bias_std / 9.81


@answer_to("23.4", hint="conjugate|brings|world|up")
def from_the_world_into_the_imu(w, a, acc_bias_std):
    q, *rest = by_the_package(w, a, acc_bias_std)
    return q * [1, -1, -1, -1], *rest


@answer_to("23.4", hint="up|not gravity|z")
def gravity_is_measured(w, a, acc_bias_std):
    return by_euler_angles(w, -a, acc_bias_std)


@answer_to("23.4", hint="same in all|no mean")
def tilt_of_a_mean(w, a, acc_bias_std):
    return *by_the_package(w, a, acc_bias_std)[:2], acc_bias_std / 9.81 / len(a) ** 0.5


@answer_to("23.4", hint="level|angle|mean of a|roll|small|z")
def small_angles(w, a, acc_bias_std):
    x, y, _ = a.mean(0)
    return v2q(np.array([y, -x, 0]) / 9.81)[0], w.mean(0), acc_bias_std / 9.81


# --- 23.5 many controls ---


@answer_to("23.5", right=True)
def step_by_step(x, P, move, us, U, dt):
    for u in us:
        r, R_r, R_u = move(x[:16], u, dt)
        F = np.eye(len(x))
        F[:16, :16] = R_r
        G_u = np.zeros((len(x), 12))
        G_u[:16] = R_u
        x, P = np.r_[r, x[16:]], F @ P @ F.T + G_u @ U @ G_u.T
    return x.tolist(), P.tolist()


@answer_to("23.5", right=True)
def one_big_jacobian_of_all_noises(x, P, move, us, U, dt):
    r, n = x[:16], len(us)
    X, W = np.eye(16), np.zeros((16, 12 * n))
    for k, u in enumerate(us):
        r, R_r, R_u = move(r, u, dt)
        X, W = R_r @ X, R_r @ W
        W[:, 12 * k : 12 * k + 12] = R_u
    F = np.eye(len(x))
    F[:16, :16] = X
    P = F @ P @ F.T
    P[:16, :16] += W @ np.kron(np.eye(n), U) @ W.T
    return np.concatenate([r, x[16:]]), (P + P.T) / 2


@answer_to("23.5", hint="moved on|moves that noise|steps after|noise")
def noises_simply_added(x, P, move, us, U, dt):
    y, C = move_frame(x, P, move, us, 0 * U, dt)
    for u in us:
        r, _, R_u = move(x[:16], u, dt)
        x = np.r_[r, x[16:]]
        C[:16, :16] += R_u @ U @ R_u.T
    return y, C


@answer_to("23.5", hint="in order|where the last|state")
def all_steps_from_the_start(x, P, move, us, U, dt):
    y = x.copy()
    y[:16] += sum(move(x[:16], u, dt)[0] - x[:16] for u in us)
    return y, move_frame(x, P, move, us, U, dt)[1]


@answer_to("23.5", hint="input|copy")
def written_into_P(x, P, move, us, U, dt):
    y, C = move_frame(x, P, move, us, U, dt)
    P[:] = C
    return y, P


@answer_to("23.5", hint="shape|whole|return")
def the_imu_only(x, P, move, us, U, dt):
    y, C = move_frame(x, P, move, us, U, dt)
    return y[:16], C[:16, :16]


# --- 23.6 NEES ---


@answer_to("23.6", right=True)
def frame_by_frame(p, v, P, p_true, v_true, yaw):
    Rt = Frame3(np.r_[0, 0, 0, v2q(np.array([0, 0, yaw]))[0]]).R.T
    rows = []
    for k in range(1, len(p)):
        e = np.r_[p[k] - p[0] - (p_true[k] - p_true[0]) @ Rt, v[k] - v_true[k] @ Rt]
        rows.append(float(e @ np.linalg.inv(P[k]) @ e))
    return rows


@answer_to("23.6", right=True)
def the_estimate_turned_into_the_true_world(p, v, P, p_true, v_true, yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    J = np.kron(np.eye(2), R)
    e = np.hstack([(p - p[0]) @ R.T - (p_true - p_true[0]), v @ R.T - v_true])[1:]
    C = J @ P[1:] @ J.T
    return np.einsum("ki,kij,kj->k", e, np.linalg.inv(C), e)


@answer_to("23.6", hint="turned|yaw|truth")
def turned_twice(p, v, P, p_true, v_true, yaw):
    return flight_nees(p, v, P, p_true, v_true, 2 * yaw)


@answer_to("23.6", hint="shape|first|each frame")
def with_the_first_frame(p, v, P, p_true, v_true, yaw):
    return np.r_[0.0, flight_nees(p, v, P, p_true, v_true, yaw)]


@answer_to("23.6", hint="begin|start|same point|P is relative")
def shifted_by_the_ends(p, v, P, p_true, v_true, yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    e = np.hstack([(p - p[-1]) - (p_true - p_true[-1]) @ R.T, v - v_true @ R.T])[1:]
    return np.einsum("ki,kij,kj->k", e, np.linalg.inv(P[1:]), e)


@answer_to("23.6", hint="small|P\\^-1|inverse")
def covariance_for_its_inverse(p, v, P, p_true, v_true, yaw):
    return flight_nees(p, v, np.concatenate([P[:1], np.linalg.inv(P[1:])]), p_true, v_true, yaw)


@answer_to("23.3", hint="b_w tilts")
def no_gravity_for_the_bias(t, b_w, b_a, n_w, n_a):
    return drift(t, b_w / 9.81, b_a, n_w, n_a)


@answer_to("23.3", hint="three integrals, k = 3")
def noise_of_the_gyro_as_that_of_the_other(t, b_w, b_a, n_w, n_a):
    off = drift(t, b_w, b_a, n_w, n_a)
    off[2] = 9.81 * n_w * t**1.5 / np.sqrt(3)
    return off


test_the_check_is_right_about_it = check_of(__name__)
