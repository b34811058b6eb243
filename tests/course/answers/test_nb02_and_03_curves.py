"""Answers to 02.6, the ellipse, and 03.5, the error band, that are in no list of the package."""

import numpy as np
from scipy.linalg import sqrtm

from ekfslam_tutorial.course.exercises.nb02_ellipse import ellipse
from ekfslam_tutorial.course.exercises.nb03_band import error_band
from ekfslam_tutorial.geometry import wrap

from .collector import answer_to, check_of

# --- 02.6 the ellipse ---


@answer_to("02.6", right=True)
def by_cholesky_from_another_start(mean, P, k):
    a = np.linspace(1, 1 + 2 * np.pi, 61)
    return mean + k * np.column_stack([np.cos(a), np.sin(a)]) @ np.linalg.cholesky(P).T


@answer_to("02.6", right=True)
def half_axes_and_an_angle_clockwise_as_a_list(mean, P, k):
    (d, D), V = np.linalg.eigh(P)
    t, made = np.arctan2(V[1, 1], V[0, 1]), []
    for a in np.linspace(0, -2 * np.pi, 73):
        u, v = k * D**0.5 * np.cos(a), k * d**0.5 * np.sin(a)
        made.append([mean[0] + u * np.cos(t) - v * np.sin(t), mean[1] + u * np.sin(t) + v * np.cos(t)])
    return made


@answer_to("02.6", right=True)
def by_singular_values(mean, P, k):
    U, S, _ = np.linalg.svd(P)
    a = np.linspace(-np.pi, np.pi, 200)
    return k * (U * np.sqrt(S) @ [np.sin(a), np.cos(a)]).T + np.asarray(mean)


@answer_to("02.6", right=True)
def symmetric_root(mean, P, k):
    a = np.linspace(0, 2 * np.pi, 80)
    return np.c_[np.cos(a), np.sin(a)] @ sqrtm(P) * k + mean


@answer_to("02.6", right=True)
def polar_form(mean, P, k):
    u = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 400)])
    r = k / np.sqrt(np.einsum("ni,ij,nj->n", u, np.linalg.inv(P), u))
    return mean + r[:, None] * u


@answer_to("02.6", hint="transpose")
def a_row_for_x_and_one_for_y(mean, P, k):
    return ellipse(mean, P, k).T


@answer_to("02.6", hint=r"variances\*|root of its variance")
def covariance_times_circle(mean, P, k):
    a = np.linspace(0, 2 * np.pi, 50)
    return mean + k * np.c_[np.cos(a), np.sin(a)] @ P


@answer_to("02.6", hint="columns")
def rows_of_the_unsorted(mean, P, k):
    D, V = np.linalg.eig(P)
    a = np.linspace(0, 2 * np.pi, 60)
    return np.array([mean + k * V.T @ (np.sqrt(D) * [np.cos(t), np.sin(t)]) for t in a])


@answer_to("02.6", hint="radians")
def a_step_for_each_degree(mean, P, k):
    a = np.arange(0, 361)
    return mean + k * (np.linalg.cholesky(P) @ [np.cos(a), np.sin(a)]).T


@answer_to("02.6", hint="add it to every point")
def around_the_origin(mean, P, k):
    return ellipse(np.zeros(2), P, k)


@answer_to("02.6", hint="root of its variance.*columns|columns.*root of its variance|variances|all should be")
def root_forgotten_and_axes_swapped(mean, P, k):
    a = np.linspace(0, 2 * np.pi, 90)
    D, V = np.linalg.eigh(P)
    return mean + (k * V @ np.diag(D[::-1]) @ [np.cos(a), np.sin(a)]).T


@answer_to("02.6", hint="goes round|0 to 2 pi")
def three_quarters(mean, P, k):
    return ellipse(mean, P, k)[:75]


@answer_to("02.6", hint="corners|100 points")
def the_four_ends_of_the_axes(mean, P, k):
    D, V = np.linalg.eigh(P)
    A = k * V * np.sqrt(D)
    return mean + np.array([A[:, 0], A[:, 1], -A[:, 0], -A[:, 1]])


@answer_to("02.6", hint="5.99|95")
def size_of_95_per_cent(mean, P, k):
    return ellipse(mean, P, np.sqrt(5.991464547107979))


# --- 03.5 the error band ---


@answer_to("03.5", right=True)
def one_time_after_the_other_as_lists(x, truth, P, k):
    e = [
        [a[0] - b[0], a[1] - b[1], np.arctan2(np.sin(a[2] - b[2]), np.cos(a[2] - b[2]))]
        for a, b in zip(x, truth, strict=True)
    ]
    return e, [[k * C[j][j] ** 0.5 for j in range(3)] for C in P]


@answer_to("03.5", right=True)
def by_einsum(x, truth, P, k):
    (dx, dy, turn), variance = (x - truth).T, np.einsum("tii->ti", P)
    return np.stack([dx, dy, (turn + np.pi) % (2 * np.pi) - np.pi], 1), (k * k * variance) ** 0.5


@answer_to("03.5", right=True)
def in_a_loop(x, truth, P, k):
    e, w = np.zeros(np.shape(x)), []
    for t, (a, b) in enumerate(zip(x, truth, strict=True)):
        e[t, :2], e[t, 2] = a[:2] - b[:2], np.angle(np.exp(1j * (a[2] - b[2])))
        w.append(k * np.diag(sqrtm(np.diag(np.diag(P[t])))).real)
    return e, w


@answer_to("03.5", hint="179|wrap")
def only_added_or_taken_away_once(x, truth, P, k):
    return x - truth, error_band(x, truth, P, k)[1]


@answer_to("03.5", hint="root")
def variances(x, truth, P, k):
    return wrap_third(x - truth), k * np.array([np.diag(C) for C in P])


@answer_to("03.5", hint="k squared")
def squared_size(x, truth, P, k):
    return wrap_third(x - truth), k**2 * np.array([np.diag(C) for C in P]) ** 0.5


@answer_to("03.5", hint="half of its width")
def width_of_the_band(x, truth, P, k):
    return wrap_third(x - truth), 2 * k * np.array([np.diag(C) for C in P]) ** 0.5


@answer_to("03.5", hint="shape")
def one_number_for_each_time(x, truth, P, k):
    return np.linalg.norm(x - truth, axis=1), k * np.sqrt(np.trace(P, axis1=1, axis2=2))


@answer_to("03.5", hint="estimate minus the truth|sign")
def sign_turned(x, truth, P, k):
    return wrap_third(truth - x), error_band(x, truth, P, k)[1]


def wrap_third(e):
    return np.column_stack([e[:, :2], wrap(e[:, 2])])


test_the_check_is_right_about_it = check_of(__name__)
