"""Answers to the exercises of notebook 02 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.linalg import block_diag

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


# --- right answers in other words ---


@answer_to("02.3", right=True)
def with_complex_numbers_as_lists(y, x_r):
    u = np.exp(1j * (x_r[2] + y[1] + 2 * np.pi))
    l = complex(x_r[0], x_r[1]) + y[0] * u
    return [l.real, l.imag], [[u.real, (1j * y[0] * u).real], [u.imag, (1j * y[0] * u).imag]]


@answer_to("02.3", right=True)
def rotation_matrix_times_point(y, x_r):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    R = np.array([[c, -s], [s, c]])
    u, v = np.array([np.cos(y[1]), np.sin(y[1])]), np.array([-np.sin(y[1]), np.cos(y[1])])
    return x_r[:2] + R @ (y[0] * u), R @ np.column_stack([u, y[0] * v])


@answer_to("02.3", right=True)
def L_y_as_the_inverse_of_H(y, x_r):
    l = q(np.asarray(y), np.asarray(x_r))[0]
    return tuple(l), np.linalg.inv(h(l, 0, x_r)[1])


@answer_to("02.4", right=True)
def np_block_as_lists(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    n = len(x)
    return [*x, *l], np.block([[P, np.zeros((n, 2))], [np.zeros((2, n)), L_y @ R @ L_y.T]]).tolist()


@answer_to("02.4", right=True)
def scipy_block_diag(x, P, y, x_r, R):
    l, L_y = q(y, x_r)
    return np.append(x, l), block_diag(P, L_y @ R @ L_y.T)[-len(x) - 2 :, -len(x) - 2 :]


@answer_to("02.4", right=True)
def large_first_guess_then_one_update_with_the_same_measurement(x, P, y, x_r, R):
    l, _ = q(y, x_r)
    H = h(l, 0, x_r)[1]
    prior = 1e6 * np.eye(2)
    K = prior @ H.T @ np.linalg.inv(H @ prior @ H.T + R)
    A = np.eye(2) - K @ H
    return np.append(x, l), block_diag(P, A @ prior @ A.T + K @ R @ K.T)[-len(x) - 2 :, -len(x) - 2 :]


@answer_to("02.4", right=True)
def information_of_the_measurement_inverted(x, P, y, x_r, R):
    l, _ = q(y, x_r)
    H = h(l, 0, x_r)[1]
    return np.append(x, l), block_diag(P, np.linalg.inv(H.T @ np.linalg.solve(R, H)))[-len(x) - 2 :, -len(x) - 2 :]


@answer_to("02.2", right=True)
def with_complex_numbers(x, i, x_r):
    d = complex(*x[2 * i : 2 * i + 2]) - complex(x_r[0], x_r[1])
    e = [abs(d), np.angle(d * np.exp(-1j * x_r[2]))]
    g = 1j / d  # d(angle) = Im(dd / d)
    H = np.zeros((2, len(x)))
    H[0, 2 * i], H[0, 2 * i + 1] = d.real / abs(d), d.imag / abs(d)
    H[1, 2 * i], H[1, 2 * i + 1] = (1 / d).imag, g.imag
    return e, H


@answer_to("02.2", right=True)
def lists_bearing_not_wrapped(x, i, x_r):
    dx, dy = float(x[2 * i] - x_r[0]), float(x[2 * i + 1] - x_r[1])
    r = (dx * dx + dy * dy) ** 0.5
    H = [[0.0] * len(x), [0.0] * len(x)]
    H[0][2 * i], H[0][2 * i + 1] = dx / r, dy / r
    H[1][2 * i], H[1][2 * i + 1] = -dy / r**2, dx / r**2
    return [r, float(np.arctan2(dy, dx)) - float(x_r[2]) + 2 * np.pi], H


@answer_to("02.2", right=True)
def in_the_robot_frame_by_the_chain_rule(x, i, x_r):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    T = np.array([[c, s], [-s, c]])
    px, py = T @ (np.asarray(x).reshape(-1, 2)[i] - x_r[:2])
    r = np.hypot(px, py)
    B = np.array([[px / r, py / r], [-py / r**2, px / r**2]]) @ T
    return (r, np.arctan2(py, px)), np.hstack([np.zeros((2, 2 * i)), B, np.zeros((2, len(x) - 2 * i - 2))])


@answer_to("02.2", right=True)
def derivative_by_finite_differences(x, i, x_r):
    def value(x):
        dx, dy = x[2 * i] - x_r[0], x[2 * i + 1] - x_r[1]
        return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - x_r[2]])

    d = 1e-6 * np.eye(len(x))
    return value(x), np.stack([(value(x + dj) - value(x - dj)) / 2e-6 for dj in d], axis=1)


@answer_to("02.5", right=True)
def joseph_form_as_lists(x, P, ids, seen, ys, x_r, R):
    def joseph(x, P, i, y, x_r, R):
        H = h(x, i, x_r)[1]
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        A = np.eye(len(P)) - K @ H
        return upd(x, P, i, y, x_r, R)[0], A @ P @ A.T + K @ R @ K.T

    x, P, ids = mk(joseph)(np.array(x), np.array(P), ids, seen, ys, x_r, R)
    return x.tolist(), P.tolist(), tuple(ids)


@answer_to("02.5", right=True)
def a_filter_of_two_states_for_each_landmark(x, P, ids, seen, ys, x_r, R):
    x, P, ids = x.copy(), P.copy(), ids.copy()
    for id, y in zip(seen, ys, strict=True):
        if id in ids:
            i = ids.index(id)
            s = slice(2 * i, 2 * i + 2)
            x[s], P[s, s] = upd(x[s], P[s, s], 0, y, x_r, R)
        else:
            x, P = add_landmark(x, P, y, x_r, R)
            ids += [id]
    return x, P, ids


@answer_to("02.5", right=True)
def known_landmarks_in_one_stacked_update_then_the_new_ones(x, P, ids, seen, ys, x_r, R):
    old = [(ids.index(id), y) for id, y in zip(seen, ys, strict=True) if id in ids]
    if old:
        es, Hs = zip(*(h(x, i, x_r) for i, _ in old), strict=True)
        z = np.concatenate([[y[0] - e[0], wrap(y[1] - e[1])] for (_, y), e in zip(old, es, strict=True)])
        H = np.vstack(Hs)
        K = np.linalg.solve(H @ P @ H.T + np.kron(np.eye(len(old)), R), H @ P).T
        x, P = x + K @ z, (np.eye(len(x)) - K @ H) @ P
    new = [(id, y) for id, y in zip(seen, ys, strict=True) if id not in ids]
    for _, y in new:
        x, P = add_landmark(x, P, y, x_r, R)
    return x, P, ids + [id for id, _ in new]


@answer_to("02.5", right=True)
def information_form(x, P, ids, seen, ys, x_r, R):
    def update(x, P, i, y, x_r, R):
        x, P, s = x.copy(), P.copy(), slice(2 * i, 2 * i + 2)
        e, H = h(x[s], 0, x_r)
        P[s, s] = np.linalg.inv(np.linalg.inv(P[s, s]) + H.T @ np.linalg.solve(R, H))
        x[s] += P[s, s] @ H.T @ np.linalg.solve(R, [y[0] - e[0], wrap(y[1] - e[1])])
        return x, P

    return mk(update)(x, P, ids, seen, ys, x_r, R)


@answer_to("02.2", hint="Counting starts at 0")
def counted_from_one(x, i, x_r):
    l_x, l_y = x[2 * i - 2 : 2 * i]
    return np.array([np.hypot(l_x - x_r[0], l_y - x_r[1]), 0.0]), np.zeros((2, len(x)))


test_the_check_is_right_about_it = check_of(__name__)
