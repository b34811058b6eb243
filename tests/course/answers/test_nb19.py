"""Answers to the exercises of notebook 19 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import pytest

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.exercises.nb19_gps import gps_error
from ekfslam_tutorial.course.exercises.nb19_scan import sort_scan

from .collector import answer_to, check_of

# --- 19.2 labels are no quantities ---


@pytest.mark.parametrize("misconception", registry.get("19.2").misconceptions, ids=lambda m: m.name)
def test_a_label_is_not_half_or_twice_another(misconception):
    message = registry.get("19.2").judge(misconception.answer).message
    assert "Yours" not in message and "rong sign" not in message, message


@answer_to("19.2", right=True)
def numbers_with_a_point(D, gate, new_gate):
    return sort_scan(D, gate, new_gate).astype(float)


# --- 19.3 who stays in the map ---


@answer_to("19.3", hint="This scan counts, too")
def asks_in_a_loop_and_counts_after(searched, found, visible, matched, min_search, min_ratio):
    gone, s, m = [], searched.copy(), found.copy()
    for i in np.flatnonzero(visible):
        if s[i] >= min_search and m[i] / max(s[i], 1) < min_ratio:
            gone.append(int(i))
        s[i] += 1
        m[i] += matched[i]
    return s, m, gone


@answer_to("19.3", hint="At least.* min_search: >=")
def too_patient_by_one(searched, found, visible, matched, min_search, min_ratio):
    s, m = searched + visible, found + matched
    return s, m, [i for i in range(len(s)) if visible[i] and s[i] > min_search and m[i] < min_ratio * s[i]]


# --- 19.4 a path compared with GPS ---


@answer_to("19.4", hint="order of fixes")
def sorted_in_place(t, path, fixes, share):
    d = gps_error(t, path, fixes, share)[0]
    d.sort()
    return d, np.sqrt(np.mean(d[: int(share * len(d))] ** 2))


# --- 19.1: the same in other words ---


@answer_to("19.1", right=True)
def equation_by_equation_lists(x, u, dt, car):
    from math import cos, sin, tan

    (v, al), (L, H, a, b) = u, car
    c, s, t = cos(x[2]), sin(x[2]), tan(al)
    vc = v / (1 - t * H / L)
    y = [
        x[0] + dt * vc * (c - t / L * (a * s + b * c)),
        x[1] + dt * vc * (s + t / L * (a * c - b * s)),
        x[2] + dt * vc / L * t,
    ]
    A = [
        [1, 0, -dt * vc * (s + t / L * (a * c - b * s))],
        [0, 1, dt * vc * (c - t / L * (a * s + b * c))],
        [0, 0, 1],
    ]
    T, V = 1 / cos(al) ** 2, vc / (1 - t * H / L) / cos(al) ** 2 * H / L
    B = [
        [
            dt / (1 - t * H / L) * (c - t / L * (a * s + b * c)),
            dt * (V * (c - t / L * (a * s + b * c)) - vc * T / L * (a * s + b * c)),
        ],
        [
            dt / (1 - t * H / L) * (s + t / L * (a * c - b * s)),
            dt * (V * (s + t / L * (a * c - b * s)) + vc * T / L * (a * c - b * s)),
        ],
        [dt / (1 - t * H / L) * t / L, dt * (V * t + vc * T) / L],
    ]
    return y, A, B


@answer_to("19.1", right=True)
def by_the_chain_rule_through_v_c_w(x, u, dt, car):
    (v, alpha), (L, H, a, b) = u, car
    t = np.tan(alpha)
    k, T = L / (L - H * t), 1 + t * t
    C_u = np.array([[k, v * k * k * T * H / L], [k * t / L, v * T / L * (k * k * t * H / L + k)]])
    turn = np.array([[np.cos(x[2]), -np.sin(x[2]), 0], [np.sin(x[2]), np.cos(x[2]), 0], [0, 0, 1]])
    V_c = turn @ np.array([[1.0, -b], [0.0, a], [0.0, 1.0]])
    step = dt * V_c @ np.array([k * v, k * v * t / L])
    X_x = np.eye(3) + np.outer([-step[1], step[0], 0], [0, 0, 1])
    return x + step, X_x, dt * V_c @ C_u


@answer_to("19.1", right=True)
def complex_numbers_numerical_jacobians(x, u, dt, car):
    from ekfslam_tutorial.geometry import numerical_jacobian

    def f(p, q):
        L, H, a, b = car
        t = np.tan(q[1])
        vc = q[0] / (1 - H * t / L)
        w = vc * t / L
        d = (vc + 1j * w * complex(a, b)) * np.exp(1j * p[2]) * dt
        return np.array([p[0] + d.real, p[1] + d.imag, p[2] + w * dt])

    x, u = np.asarray(x, float), np.asarray(u, float)
    return f(x, u), numerical_jacobian(lambda p: f(p, u), x), numerical_jacobian(lambda q: f(x, q), u)


# --- 19.4: the same in other words ---


@answer_to("19.4", right=True)
def a_loop_over_the_fixes_lists(t, path, fixes, share):
    d = []
    for time, x, y in fixes:
        if t[0] <= time <= t[-1]:
            i = min(max(int(np.searchsorted(t, time)), 1), len(t) - 1)
            w = (time - t[i - 1]) / (t[i] - t[i - 1])
            p = (1 - w) * path[i - 1] + w * path[i]
            d.append(float(np.hypot(p[0] - x, p[1] - y)))
    best = sorted(d)[: int(share * len(d))]
    return d, (sum(v * v for v in best) / len(best)) ** 0.5


@answer_to("19.4", right=True)
def complex_numbers_partition(t, path, fixes, share):
    f = fixes[np.logical_and(fixes[:, 0] >= t[0], fixes[:, 0] <= t[-1])]
    p = np.interp(f[:, 0], t, path[:, 0]) + 1j * np.interp(f[:, 0], t, path[:, 1])
    d = abs(p - f[:, 1] - 1j * f[:, 2])
    n = int(share * len(d))
    return d, np.linalg.norm(np.partition(d, n - 1)[:n]) / np.sqrt(n)


# --- 19.3: the same in other words ---


@answer_to("19.3", right=True)
def a_loop_lists(searched, found, visible, matched, min_search, min_ratio):
    s, m, gone = [], [], []
    for i in range(len(searched)):
        s.append(int(searched[i]) + int(visible[i]))
        m.append(int(found[i]) + int(matched[i]))
        if visible[i] and s[i] >= min_search and m[i] < min_ratio * s[i]:
            gone.append(i)
    return s, m, gone


@answer_to("19.3", right=True)
def indices_as_an_array(searched, found, visible, matched, min_search, min_ratio):
    s, m = np.where(visible, searched + 1, searched), np.where(matched, found + 1, found)
    return s, m, np.nonzero(visible & ~(s < min_search) & ~(m >= min_ratio * s))[0]


# --- 19.2: the same in other words ---


@answer_to("19.2", right=True)
def a_loop_a_list(D, gate, new_gate):
    out = []
    for i, row in enumerate(D):
        if not len(row) or min(row) > new_gate:
            out.append(-1)
            continue
        t = min(range(len(row)), key=lambda c: row[c])
        rival = min(range(len(D)), key=lambda r: D[r][t])
        out.append(t if rival == i and row[t] <= gate else -2)
    return out


@answer_to("19.2", right=True)
def as_a_mask_numbers_with_a_point(D, gate, new_gate):
    k, n = D.shape
    if not D.size:
        return -np.ones(k)
    ok = (D == D.min(axis=1, keepdims=True)) & (D == D.min(axis=0, keepdims=True)) & (D <= gate)
    return np.where(ok.any(1), ok.argmax(1), np.where((D > new_gate).all(1), -1.0, -2.0))


@answer_to("19.3", hint="this scan included")
def count_of_before(searched, found, visible, matched, min_search, min_ratio):
    s, f = searched + visible, found + matched
    return s, f, [i for i in range(len(s)) if visible[i] and searched[i] >= min_search and f[i] < min_ratio * s[i]]


test_the_check_is_right_about_it = check_of(__name__)
