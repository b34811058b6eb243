"""Answers to the exercises 02.2 and 02.3 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import pytest

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.exercises.nb02_h import h
from ekfslam_tutorial.course.exercises.nb02_q import q
from ekfslam_tutorial.geometry import wrap

ANSWERS = []


def answer_to(id, right=False):
    """Collect an answer: its exercise, and whether it is right."""

    def collect(function):
        ANSWERS.append(pytest.param(id, right, function, id=f"{id}: {function.__name__}"))
        return function

    return collect


@answer_to("02.2")
def abs_bearing(x, i, x_r):
    e, H = h(x, i, x_r)
    return np.abs(e), H


@answer_to("02.2")
def wrap_02pi_negative_only(x, i, x_r):
    e, H = h(x, i, x_r)
    e[1] = np.clip(e[1], -3, 3)
    return e, H


@answer_to("02.2")
def r_manhattan(x, i, x_r):
    e, H = h(x, i, x_r)
    d = x[2 * i : 2 * i + 2] - x_r[:2]
    e[0] = np.abs(d).sum()
    return e, H


@answer_to("02.2")
def H_robot_3cols(x, i, x_r):
    e, H = h(x, i, x_r)
    return e, np.hstack([np.zeros((2, 3)), H])


@answer_to("02.2")
def H_rows_swapped(x, i, x_r):
    e, H = h(x, i, x_r)
    return e, H[::-1]


@answer_to("02.2")
def bearing_only_theta_mod(x, i, x_r):
    e, H = h(x, i, x_r)
    return np.array([e[0], np.arctan2(*(x[2 * i : 2 * i + 2] - x_r[:2])[::-1]) - x_r[2] % np.pi]), H


@answer_to("02.2")
def H_both_signs(x, i, x_r):
    e, H = h(x, i, x_r)
    H2 = H.copy()
    H2[1] *= -1
    H2[0] *= -1
    return e, H2


@answer_to("02.2")
def H_at_i_plus_1(x, i, x_r):
    e, H = h(x, i, x_r)
    return e, np.roll(H, 1, axis=1)


@answer_to("02.2")
def H_dr_over_dtheta(x, i, x_r):
    e, H = h(x, i, x_r)
    H = H.copy()
    H[1] = H[1] * e[0]
    return e, H


@answer_to("02.2")
def swapped_return(x, i, x_r):
    e, H = h(x, i, x_r)
    return H, e


@answer_to("02.2")
def only_e(x, i, x_r):
    return h(x, i, x_r)[0]


@answer_to("02.2")
def float16(x, i, x_r):
    e, H = h(x, i, x_r)
    return e.astype(np.float16), H.astype(np.float16)


@answer_to("02.2", True)
def float32(x, i, x_r):
    e, H = h(x, i, x_r)
    return e.astype(np.float32), H.astype(np.float32)


@answer_to("02.2", True)
def matrix(x, i, x_r):
    e, H = h(x, i, x_r)
    return e, np.matrix(H)


@answer_to("02.2", True)
def forward_diff(x, i, x_r):
    x = np.asarray(x)
    v = lambda x: h(x, i, x_r)[0]
    e = v(x)
    return e, np.array([(wrapd(v(x + d) - e)) / 1e-7 for d in np.eye(len(x)) * 1e-7]).T


def wrapd(a):
    a[1] = wrap(a[1])
    return a


@answer_to("02.2", True)
def kwargs(x, i, x_r, **kw):
    return h(x, i, x_r)


@answer_to("02.2", True)
def other_names(mu, idx, pose, verbose=False):
    return h(mu, idx, pose)


@answer_to("02.2", True)
def reshaped(x, i, x_r):
    L = np.reshape(x, (-1, 2))
    d = L[i] - x_r[:2]
    n = np.linalg.norm(d)
    H = np.zeros((2, L.shape[0], 2))
    H[0, i] = d / n
    H[1, i] = np.array([-d[1], d[0]]) / n**2
    return [n, (np.arctan2(d[1], d[0]) - x_r[2]) % (2 * np.pi)], H.reshape(2, -1)


@answer_to("02.3")
def l_wrapped(y, x_r):
    l, L = q(y, x_r)
    return wrap(l), L


@answer_to("02.3")
def jac_sign2(y, x_r):
    l, L = q(y, x_r)
    L = L.copy()
    L[:, 1] *= -1
    return l, L


@answer_to("02.3")
def jac_no_theta0(y, x_r):
    return q(y, x_r)[0], q(y, np.array([0, 0, 0.0]))[1]


@answer_to("02.3")
def jac_sinonly(y, x_r):
    l, L = q(y, x_r)
    return l, np.array(
        [[np.cos(y[1] + x_r[2]), -np.sin(y[1] + x_r[2]) * y[0]], [np.cos(y[1] + x_r[2]), np.sin(y[1] + x_r[2]) * y[0]]]
    )


@answer_to("02.3")
def in_robot_frame(y, x_r):
    return np.array([y[0] * np.cos(y[1]), y[0] * np.sin(y[1])]), np.array(
        [[np.cos(y[1]), -y[0] * np.sin(y[1])], [np.sin(y[1]), y[0] * np.cos(y[1])]]
    )


@answer_to("02.3")
def order_yx(y, x_r):
    l, L = q(y, x_r)
    return l[::-1], L[::-1]


@answer_to("02.3")
def theta_twice(y, x_r):
    return q(y, np.array([x_r[0], x_r[1], 2 * x_r[2]]))


@answer_to("02.3")
def args_swapped(x_r, y):
    return q(y, x_r)


@answer_to("02.3", True)
def asin_form(y, x_r):
    r, b = y
    x, yy, t = x_r
    return (x + r * np.sin(t + b + np.pi / 2), yy - r * np.cos(t + b + np.pi / 2)), [
        [np.cos(t + b), -r * np.sin(t + b)],
        [np.sin(t + b), r * np.cos(t + b)],
    ]


@pytest.mark.parametrize("id, right, answer", ANSWERS)
def test_an_answer_that_nobody_listed(id, right, answer):
    verdict = registry.get(id).judge(answer)
    assert verdict.passed is right, f"{verdict.link}: {verdict.message}"
    assert right or (verdict.message and verdict.hint)
