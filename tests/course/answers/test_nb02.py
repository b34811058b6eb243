"""Answers to the exercises of notebook 02 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb02_grow import add_landmark
from ekfslam_tutorial.course.exercises.nb02_h import h
from ekfslam_tutorial.course.exercises.nb02_q import q
from ekfslam_tutorial.course.exercises.nb02_step import map_step
from ekfslam_tutorial.geometry import wrap

from .collector import answer_to, check_of

# --- 02.2 ---


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


# --- 02.3 ---


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


# --- 02.4 ---


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


# --- 02.5 ---


def mk(body):
    def f(x, P, ids, seen, ys, x_r, R):
        ids = list(ids)
        for id, y in zip(seen, ys, strict=True):
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
    for id, y in zip(seen, ys, strict=True):
        if id not in ids:
            x, P = add_landmark(x, P, y, x_r, R)
            ids.append(id)
        else:
            x, P = upd(x, P, ids.index(id), y, x_r, R)
    return x, P, ids


@answer_to("02.5")
def inplace_x(x, P, ids, seen, ys, x_r, R):
    ids = list(ids)
    for id, y in zip(seen, ys, strict=True):
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
    for id, y in zip(seen, ys, strict=True):
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


test_the_check_is_right_about_it = check_of(__name__)
