"""Answers to the exercises of notebook 16 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.stats import norm

from ekfslam_tutorial.course.exercises.nb16_birth import hypothesis
from ekfslam_tutorial.course.exercises.nb16_omni import omni_project
from ekfslam_tutorial.course.exercises.nb16_visible import beacon_visible

from .collector import answer_to, check_of

# --- 16.1 the direct model of a range ---


@answer_to("16.1", hint="sign|away")
def absolute_components(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    return r, np.abs(p / r)[..., None, :]


@answer_to("16.1", hint="shape")
def no_axis_for_the_measurement(p):
    r = np.linalg.norm(p, axis=-1)
    return r, p / r[..., None]


@answer_to("16.1", hint="shape|transpose")
def column_jacobian(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    return r, (p / r)[..., None]


@answer_to("16.1", hint="many points|p\\[")
def norm_of_all(p):
    r = np.linalg.norm(p)
    return np.full((*p.shape[:-1], 1), r), (p / r)[..., None, :]


@answer_to("16.1", hint="many points|p\\[|shape")
def for_lists_only(p):
    p = np.atleast_2d(p)
    r = np.hypot(p[:, 0], p[:, 1])
    return r[:, None], (p / r[:, None])[:, None, :]


@answer_to("16.1", right=True)
def by_einsum(p):
    r = np.sqrt(np.einsum("...i,...i->...", p, p))
    return np.expand_dims(r, -1), np.einsum("...i,...->...i", p, 1 / r).reshape(*p.shape[:-1], 1, 2)


# --- 16.2 what the sensor can see ---


@answer_to("16.2", hint="2.9|range|m,")
def a_little_too_far(y, p, max_range, fov):
    return beacon_visible(y, p, max_range + 0.2, fov)


@answer_to("16.2", hint="shape")
def keeps_the_axis(y, p, max_range, fov):
    return (y <= max_range) & (np.abs(np.arctan2(p[..., 1:], p[..., :1])) <= fov / 2)


@answer_to("16.2", hint="shape|truth value|decide")
def with_if(y, p, max_range, fov):
    if y[..., 0] <= max_range and abs(np.arctan2(p[..., 1], p[..., 0])) <= fov / 2:
        return True
    return False


@answer_to("16.2", right=True)
def with_where(y, p, max_range, fov):
    bearing = np.angle(p[..., 0] + 1j * p[..., 1])
    return np.where(np.squeeze(y, -1) > max_range, 0, np.where(2 * abs(bearing) > fov, 0, 1))


# --- 16.3 a range and a prior ---


@answer_to("16.3", hint="heading|theta|third column")
def heading_column_without_range(x, P, r, var, beta, N):
    p, P_pp, _ = hypothesis(x, P, r, var, beta, N)
    a = x[2] + beta
    J = np.array([[1, 0, -np.sin(a)], [0, 1, np.cos(a)]])
    own = P_pp - hypothesis(x, P, r, 0, beta, 0)[1]
    return p, J @ P @ J.T + own, J @ P


@answer_to("16.3", hint="degrees|direction|robot")
def degrees(x, P, r, var, beta, N):
    return hypothesis(np.array([x[0], x[1], np.degrees(x[2])]), P, r, var, np.degrees(beta), N)


@answer_to("16.3", hint="covariance|P_pp|terms")
def only_the_diagonal(x, P, r, var, beta, N):
    p, P_pp, P_px = hypothesis(x, P, r, var, beta, N)
    return p, np.diag(np.diag(P_pp)), P_px


@answer_to("16.3", right=True)
def by_samples_of_the_unscented_kind(x, P, r, var, beta, N):
    def g(u):
        return u[:2] + u[3] * np.array([np.cos(u[2] + u[4]), np.sin(u[2] + u[4])])

    u, h = np.array([*x, r, beta]), 1e-6
    J = np.array([(g(u + h * d) - g(u - h * d)) / (2 * h) for d in np.eye(5)]).T
    S = np.zeros((5, 5))
    S[:3, :3], S[3, 3], S[4, 4] = P, var, N
    return g(u), J @ S @ J.T, J @ S[:, :3]


# --- 16.4 weights ---


@answer_to("16.4", hint="zero|NaN|logarithm")
def densities(w, z, Z):
    new = w * norm.pdf(z, scale=np.sqrt(Z))
    return new / np.sum(new)


@answer_to("16.4", hint="sum|weights|likel")
def inverse_distance(w, z, Z):
    new = w / (1 + z**2 / Z)
    return new / np.sum(new)


@answer_to("16.4", right=True)
def as_log_sum_exp(w, z, Z):
    log = np.log(w) + norm.logpdf(np.array(z), 0, np.sqrt(Z))
    return np.exp(log - np.logaddexp.reduce(log))


# --- 16.5 a camera all round ---


@answer_to("16.5", hint="elevation")
def height(p):
    y, Y_p = omni_project(p)
    return np.stack([y[..., 0], p[..., 2]], -1), Y_p


@answer_to("16.5", hint="shape|transpose")
def transposed(p):
    y, Y_p = omni_project(p)
    return y, np.swapaxes(Y_p, -1, -2)


@answer_to("16.5", right=True)
def by_cross_products(p):
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(up, p)  # horizontal, across the line of sight
    s, r = np.linalg.norm(side, axis=-1), np.linalg.norm(p, axis=-1)
    above = np.cross(p, side) / (r * s)[..., None]  # the direction in which the elevation grows
    J = np.stack([side / s[..., None] ** 2, above / r[..., None]], axis=-2)
    return np.stack([np.arctan2(-side[..., 0], side[..., 1]) + 2 * np.pi, np.arcsin(p[..., 2] / r)], -1), J


# --- 16.3: the same in other words ---


@answer_to("16.3", right=True)
def one_big_jacobian(x, P, r, var, beta, N):
    a = x[2] + beta
    m, n = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    J = np.column_stack([np.eye(2), r * n, m, r * n])
    C = np.zeros((5, 5))
    C[:3, :3], C[3, 3], C[4, 4] = P, var, N
    return (x[:2] + r * m).tolist(), J @ C @ J.T, (J @ C)[:, :3]


@answer_to("16.3", right=True)
def by_rotation_matrices(x, P, r, var, beta, N):
    def R(a):
        return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

    p = R(x[2]) @ R(beta) @ [r, 0.0]
    J = np.array([[1, 0, -p[1]], [0, 1, p[0]]])
    return x[:2] + p, R(x[2] + beta) @ np.diag([var, r * r * N]) @ R(x[2] + beta).T + J @ P @ J.T, J @ P


# --- 16.5: the same in other words ---


@answer_to("16.5", right=True)
def with_arcsin_and_complex_numbers(p):
    p = np.asarray(p, float)
    s, r = np.linalg.norm(p[..., :2], axis=-1), np.linalg.norm(p, axis=-1)
    J = np.zeros((*p.shape[:-1], 2, 3))
    J[..., 0, 0], J[..., 0, 1] = -p[..., 1] / s**2, p[..., 0] / s**2
    J[..., 1, :] = (np.array([0, 0, 1]) - p * (p[..., 2] / r**2)[..., None]) / s[..., None]
    a = np.angle(p[..., 0] + 1j * p[..., 1])
    return np.stack([np.where(a < 0, a + 2 * np.pi, a), np.arcsin(p[..., 2] / r)], -1), J


@answer_to("16.5", right=True)
def through_the_unit_vector(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    m = p / r
    M_p = (np.eye(3) - m[..., :, None] * m[..., None, :]) / r[..., None]
    y, Y_m = omni_project(m)
    return y, Y_m @ M_p


# --- 16.1: the same in other words ---


@answer_to("16.1", right=True)
def with_hypot_and_stack(p):
    x, y = np.asarray(p)[..., 0], np.asarray(p)[..., 1]
    r = np.hypot(x, y)
    return r[..., None], np.stack([x / r, y / r], axis=-1)[..., None, :]


@answer_to("16.1", right=True)
def by_cosine_and_sine(p):
    a = np.arctan2(p[..., 1], p[..., 0])
    J = np.stack([np.cos(a), np.sin(a)], -1)
    return (p * J).sum(-1, keepdims=True), np.expand_dims(J, -2)


# --- 16.2: the same in other words ---


@answer_to("16.2", right=True)
def by_the_cosine(y, p, max_range, fov):
    p = np.asarray(p)
    wide = fov >= 2 * np.pi - 1e-9
    return np.logical_and(y[..., 0] <= max_range, wide | (p[..., 0] >= np.cos(fov / 2) * np.linalg.norm(p, axis=-1)))


@answer_to("16.2", right=True)
def one_by_one(y, p, max_range, fov):
    flat = [
        r <= max_range and -fov / 2 <= np.arctan2(b, a) <= fov / 2
        for r, (a, b) in zip(np.ravel(y), np.reshape(p, (-1, 2)), strict=True)
    ]
    return np.array(flat).reshape(np.shape(p)[:-1])


# --- 16.4: the same in other words ---


@answer_to("16.4", right=True)
def with_scipy(w, z, Z):
    from scipy.special import softmax
    from scipy.stats import norm

    return softmax(np.log(w) + norm.logpdf(z, scale=np.sqrt(Z)))


@answer_to("16.4", right=True)
def one_by_one_too(w, z, Z):
    logs = [np.log(a) - b * b / (2 * c) - np.log(2 * np.pi * c) / 2 for a, b, c in zip(w, z, Z, strict=True)]
    return [float(1 / np.sum(np.exp(np.clip(np.array(logs) - one, -700, 700)))) for one in logs]


test_the_check_is_right_about_it = check_of(__name__)
