"""Answers to the exercises 02.4 and 02.5 that are in no list of the package: wrong ones, and odd right ones."""

# ruff: noqa: B905

import numpy as np
import pytest

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.exercises.nb02_grow import add_landmark
from ekfslam_tutorial.course.exercises.nb02_h import h
from ekfslam_tutorial.course.exercises.nb02_q import q
from ekfslam_tutorial.course.exercises.nb02_step import map_step
from ekfslam_tutorial.geometry import wrap

ANSWERS = []


def answer_to(id, right=False):
    """Collect an answer: its exercise, and whether it is right."""

    def collect(function):
        ANSWERS.append(pytest.param(id, right, function, id=f"{id}: {function.__name__}"))
        return function

    return collect


@answer_to("02.4")
def LRL_transposed_both(x, P, y, x_r, R):
    l, L = q(y, x_r)
    return np.concatenate([x, l]), np.block([[P, np.zeros((len(x), 2))], [np.zeros((2, len(x))), L.T @ R @ L]])


@answer_to("02.4")
def upper_only(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    P2[-1, -2] = 0
    return x2, P2


@answer_to("02.4")
def P_scaled(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    P2[: len(x), : len(x)] *= 1.0001
    return x2, P2


@answer_to("02.4")
def std_on_diag(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    B = P2[-2:, -2:]
    P2[-2:, -2:] = np.sign(B) * np.sqrt(np.abs(B))
    return x2, P2


@answer_to("02.4")
def lin_at_theta0(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    L = q(y, np.zeros(3))[1]
    P2[-2:, -2:] = L @ R @ L.T
    return x2, P2


@answer_to("02.4")
def add_R_cart(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    P2[-2:, -2:] += R
    return x2, P2


@answer_to("02.4")
def duplicates_last(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    if len(x):
        P2[-2:, -2:] = P[-2:, -2:]
    return x2, P2


@answer_to("02.4")
def inplace_P(x, P, y, x_r, R):
    P *= 1
    P += 0.0
    P[...] = P + 0.1 if P.size else P
    return add_landmark(x, P - 0.1, y, x_r, R)


@answer_to("02.4")
def returns_P_first(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    return P2, x2


@answer_to("02.4", True)
def jitter(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    return x2, P2 + 1e-12 * np.eye(len(P2))


@answer_to("02.4", True)
def symm(x, P, y, x_r, R):
    x2, P2 = add_landmark(x, P, y, x_r, R)
    return x2.tolist(), (P2 + P2.T) / 2


@answer_to("02.4", True)
def G_form(x, P, y, x_r, R):
    n = len(x)
    l, L = q(y, x_r)
    A = np.zeros((n + 2, n + 2))
    A[:n, :n] = np.eye(n)
    A[n:, n:] = L
    S = np.zeros((n + 2, n + 2))
    S[:n, :n] = P
    S[n:, n:] = R
    return np.r_[x, l], A @ S @ A.T


def mk(body):
    def f(x, P, ids, seen, ys, x_r, R):
        ids = list(ids)
        for id, y in zip(seen, ys):
            if id not in ids:
                x, P = add_landmark(x, P, y, x_r, R)
                ids.append(id)
            else:
                x, P = body(x, P, ids.index(id), y, x_r, R)
        return x, P, ids

    return f


def upd(x, P, i, y, x_r, R, H=None, K=None):
    e, H0 = h(x, i, x_r)
    H = H0 if H is None else H
    z = y - e
    z[1] = wrap(z[1])
    Z = H @ P @ H.T + R
    K = P @ H.T @ np.linalg.inv(Z)
    return x + K @ z, P - K @ Z @ K.T


@answer_to("02.5")
def K_over(x, P, ids, seen, ys, x_r, R):
    return mk(lambda x, P, i, y, x_r, R: (upd(x, P, i, y, x_r, R)[0], upd(x, P, i, y, x_r, R)[1] * 0.999))(
        x, P, ids, seen, ys, x_r, R
    )


@answer_to("02.5")
def update_twice(x, P, ids, seen, ys, x_r, R):
    return mk(lambda x, P, i, y, x_r, R: upd(*upd(x, P, i, y, x_r, R), i, y, x_r, R))(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def wrap_expect_only(x, P, ids, seen, ys, x_r, R):
    def b(x, P, i, y, x_r, R):
        e, H = h(x, i, x_r)
        e[1] = wrap(e[1])
        z = y - e
        Z = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(Z)
        return x + K @ z, P - K @ Z @ K.T

    return mk(b)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def mod2pi(x, P, ids, seen, ys, x_r, R):
    def b(x, P, i, y, x_r, R):
        e, H = h(x, i, x_r)
        z = y - e
        z[1] = z[1] % (2 * np.pi)
        Z = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(Z)
        return x + K @ z, P - K @ Z @ K.T

    return mk(b)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def half_gain(x, P, ids, seen, ys, x_r, R):
    def b(x, P, i, y, x_r, R):
        x2, P2 = upd(x, P, i, y, x_r, R)
        return x + (x2 - x) / 2, P2

    return mk(b)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def sorts(x, P, ids, seen, ys, x_r, R):
    o = np.argsort(seen)
    return map_step(x, P, ids, [seen[k] for k in o], ys[o] if len(o) else ys, x_r, R)


@answer_to("02.5")
def drops_unseen(x, P, ids, seen, ys, x_r, R):
    x, P, ids = map_step(x, P, ids, seen, ys, x_r, R)
    k = [j for j, i in enumerate(ids) if i in seen] or list(range(len(ids)))
    idx = [t for j in k for t in (2 * j, 2 * j + 1)]
    return x[idx], P[np.ix_(idx, idx)], [ids[j] for j in k]


@answer_to("02.5")
def max5(x, P, ids, seen, ys, x_r, R):
    return map_step(x, P, ids, seen[:3], ys[:3], x_r, R)


@answer_to("02.5")
def appends_in_place(x, P, ids, seen, ys, x_r, R):
    for id, y in zip(seen, ys):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
        else:
            x, P = upd(x, P, ids.index(id), y, x_r, R)
    return x, P, ids


@answer_to("02.5")
def inplace_x(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for id, y in zip(seen, ys):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
        else:
            x2, P = upd(x, P, ids.index(id), y, x_r, R)
            x += x2 - x
    return x, P, ids


@answer_to("02.5")
def joseph_wrong(x, P, ids, seen, ys, x_r, R):
    def b(x, P, i, y, x_r, R):
        e, H = h(x, i, x_r)
        z = y - e
        z[1] = wrap(z[1])
        Z = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(Z)
        A = np.eye(len(x)) - K @ H
        return x + K @ z, A @ P @ A.T

    return mk(b)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def H_theta(x, P, ids, seen, ys, x_r, R):
    def b(x, P, i, y, x_r, R):
        e, H = h(x, i, np.array([0, 0, 0.0]))
        return upd(x, P, i, y, x_r, R, H=H)

    return mk(b)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.5")
def stops_after_first_new(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for id, y in zip(seen, ys):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
            break
        else:
            x, P = upd(x, P, ids.index(id), y, x_r, R)
    return x, P, ids


@answer_to("02.5", True)
def own_everything(x, P, ids, seen, ys, x_r, R):
    x = np.array(x, float)
    P = np.array(P, float)
    ids = list(map(int, ids))
    for k in range(len(seen)):
        r, b = ys[k]
        if seen[k] in ids:
            i = 2 * ids.index(seen[k])
            dx, dy = x[i] - x_r[0], x[i + 1] - x_r[1]
            d = np.hypot(dx, dy)
            H = np.array([[dx / d, dy / d], [-dy / d**2, dx / d**2]])
            z = np.array([r - d, b - (np.arctan2(dy, dx) - x_r[2])])
            z[1] = np.arctan2(np.sin(z[1]), np.cos(z[1]))
            B = P[i : i + 2, i : i + 2]
            K = np.linalg.solve((H @ B @ H.T + R).T, (B @ H.T).T).T
            x[i : i + 2] += K @ z
            P[i : i + 2, i : i + 2] = B - K @ H @ B
        else:
            a = b + x_r[2]
            x = np.r_[x, x_r[0] + r * np.cos(a), x_r[1] + r * np.sin(a)]
            L = np.array([[np.cos(a), -r * np.sin(a)], [np.sin(a), r * np.cos(a)]])
            P = np.pad(P, ((0, 2), (0, 2)))
            P[-2:, -2:] = L @ R @ L.T
            ids.append(seen[k])
    return x, P, np.array(ids)


@pytest.mark.parametrize("id, right, answer", ANSWERS)
def test_an_answer_that_nobody_listed(id, right, answer):
    verdict = registry.get(id).judge(answer)
    assert verdict.passed is right, f"{verdict.link}: {verdict.message}"
    assert right or (verdict.message and verdict.hint)
