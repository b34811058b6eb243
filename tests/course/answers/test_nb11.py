"""Answers to the exercises of notebook 11 that are in no list of the package."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb11_const_vel import const_vel
from ekfslam_tutorial.course.exercises.nb11_odo3 import odo3, positive, tangent
from ekfslam_tutorial.geometry import Frame3, numerical_jacobian, v2q
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3

from .collector import answer_to, check_of

# --- 11.3: the same in other words ---


def _numerical_3(f):
    """The answer with the value f and its exact derivatives."""

    def answer(x, u, dt):
        x, u = np.asarray(x, float), np.asarray(u, float)
        by_x, by_u = numerical_jacobian(lambda x: f(x, u, dt), x), numerical_jacobian(lambda u: f(x, u, dt), u)
        return f(x, u, dt), by_x, by_u

    return answer


def _value_3(x, u, dt):
    return ConstantVelocity().move(x, u, dt)[0]


@answer_to("11.3", right=True)
def the_packages_model(x, u, dt):
    return ConstantVelocity().move(x, u, dt)


@answer_to("11.3", right=True)
def finite_differences_as_lists(x, u, dt):
    return tuple(a.tolist() for a in _numerical_3(_value_3)(x, u, dt))


@answer_to("11.3", right=True)
def in_blocks_along_the_sphere(x, u, dt):
    x2, X_x, _ = const_vel(x, u, dt)
    return x2, X_x @ tangent(x), np.vstack([np.zeros((7, 6)), np.eye(6)])


@answer_to("11.3", right=True)
def the_quaternion_with_a_not_below_0(x, u, dt):
    return positive(*const_vel(x, u, dt))


# --- 11.4: the same in other words ---


@answer_to("11.4", right=True)
def a_square_root_as_lists(sigma_v, sigma_w, dt):
    S = np.sqrt(dt) * np.diag(np.repeat([sigma_v, sigma_w], 3))
    return (S @ S.T).tolist()


@answer_to("11.4", right=True)
def entry_by_entry(sigma_v, sigma_w, dt):
    U = np.zeros((6, 6))
    for i in range(6):
        U[i, i] = (sigma_v if i < 3 else sigma_w) ** 2 / (1 / dt)
    return U


# --- 11.1: the same in other words ---


def _numerical_1(f):
    """The answer with the value f and its exact derivatives."""

    def answer(x, u):
        return f(x, u), numerical_jacobian(lambda x: f(x, u), x), numerical_jacobian(lambda u: f(x, u), u)

    return answer


@answer_to("11.1", right=True)
def composition_of_frames(x, u):
    q, Q_v = v2q(u[3:])
    F, X_x, X_s = Frame3(x).compose(Frame3(np.concatenate([u[:3], q])))
    return F.x, X_x, np.hstack([X_s[:, :3], X_s[:, 3:] @ Q_v])


@answer_to("11.1", right=True)
def finite_differences_as_lists_too(x, u):
    x2, X_x, X_u = _numerical_1(lambda x, u: Odometry3().move(x, u, 1.0)[0])(x, u)
    return x2.tolist(), X_x.tolist(), X_u.tolist()


@answer_to("11.1", right=True)
def derivative_along_the_sphere(x, u):
    x2, X_x, X_u = odo3(x, u)
    return x2, X_x @ tangent(x), X_u


@answer_to("11.1", right=True)
def the_quaternion_with_a_not_below_0_too(x, u):
    return positive(*odo3(x, u))


# --- 11.2: the same in other words ---


@answer_to("11.2", right=True)
def one_big_jacobian(x, P, u, U):
    x2, X_x, X_u = odo3(x, u)
    J = np.hstack([X_x, X_u])
    S = np.zeros((13, 13))
    S[:7, :7], S[7:, 7:] = P, U
    return x2, (J @ S @ J.T).tolist()


@answer_to("11.2", right=True)
def the_packages_model_made_symmetric(x, P, u, U):
    x2, X_x, X_u = Odometry3().move(x, u, 1.0)
    P = X_x @ P @ X_x.T + X_u @ U @ X_u.T
    return x2, (P + P.T) / 2


@answer_to("11.2", right=True)
def the_quaternion_with_a_not_below_0_too_too(x, P, u, U):
    x2, X_x, X_u = positive(*odo3(x, u))
    return x2, X_x @ P @ X_x.T + X_u @ U @ X_u.T


test_the_check_is_right_about_it = check_of(__name__)
