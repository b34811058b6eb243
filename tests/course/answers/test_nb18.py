"""Answers to the exercises of notebook 18 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.spatial.transform import Rotation

from ekfslam_tutorial.course.exercises.nb15_fuse import covariance_intersection
from ekfslam_tutorial.course.exercises.nb18_correct import correct_both
from ekfslam_tutorial.course.exercises.nb18_fuse import fuse
from ekfslam_tutorial.course.exercises.nb18_gauge import align_all
from ekfslam_tutorial.course.exercises.nb18_meet import meet

from .collector import answer_to, check_of
from .one_by_one import correct_by_numbers, whole_jacobian

# --- 18.1 meet ---


@answer_to("18.1", hint="range")
def city_blocks(a, b):
    e, E_a, E_b = meet(a, b)
    return np.array([np.abs(b[:2] - a[:2]).sum(), e[1]]), E_a, E_b


@answer_to("18.1", hint="bearing")
def arcsine(a, b):
    e, E_a, E_b = meet(a, b)
    return np.array([e[0], np.arcsin((b[1] - a[1]) / e[0]) - a[2]]), E_a, E_b


@answer_to("18.1", hint="E_a")
def cosine_of_the_bearing(a, b):
    (r, beta), _, E_b = meet(a, b)
    c, s = np.cos(beta), np.sin(beta)
    return np.array([r, beta]), np.array([[-c, -s, 0], [s / r, -c / r, -1]]), E_b


@answer_to("18.1", hint="E_b")
def the_same_jacobian_for_both(a, b):
    e, E_a, _ = meet(a, b)
    return e, E_a, -E_a


@answer_to("18.1", right=True)
def sines_and_cosines_of_the_direction(a, b):
    d = complex(*(b - a)[:2])
    r, c, s = abs(d), d.real / abs(d), d.imag / abs(d)
    E_a = [[-c, -s, 0], [s / r, -c / r, -1]]
    return [r, np.angle(d) - a[2]], E_a, [[c, s, 0], [-s / r, c / r, 0]]


# --- 18.2 correct_both ---


@answer_to("18.2", hint="cross|P_ab|Z|[Hh]ang together|product")
def two_filters(x, P, a, b, z, E_a, E_b, R):
    H, Q = whole_jacobian(len(x), len(z), [(a, E_a), (b, E_b)]), np.zeros_like(P)
    for r in (a, b):
        Q[r, r] = P[r, r]
    K = Q @ H.T @ np.linalg.inv(H @ Q @ H.T + R)
    return x + K @ z, P - K @ H @ P


@answer_to("18.2", hint="K Z K|P")
def K_R_K_subtracted(x, P, a, b, z, E_a, E_b, R):
    H = whole_jacobian(len(x), len(z), [(a, E_a), (b, E_b)])
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    return x + K @ z, P - K @ R @ K.T


@answer_to("18.2", hint="x|K z")
def difference_returned(x, P, a, b, z, E_a, E_b, R):
    new, Q = correct_both(x, P, a, b, z, E_a, E_b, R)
    return new - x, Q


@answer_to("18.2", right=True)
def one_number_after_the_other(x, P, a, b, z, E_a, E_b, R):
    return correct_by_numbers(x, P, whole_jacobian(len(x), len(z), [(a, E_a), (b, E_b)]), z, R)


# --- 18.3 align_all ---


@answer_to("18.3", hint="no error|rigid motion|F")
def first_points_laid_on_each_other(paths, truths):
    F, _ = align_all(paths, truths)
    c, s = np.cos(F[2]), np.sin(F[2])
    F[:2] = truths[0][0] - np.array([[c, -s], [s, c]]) @ paths[0][0]
    return F, align_all(paths, truths)[1]


@answer_to("18.3", hint="ate|instants|mean")
def one_less(paths, truths):
    F, ates = align_all(paths, truths)
    n = np.array([len(p) for p in paths])
    return F, ates * np.sqrt(n / (n - 1))


@answer_to("18.3", hint="mirror")  # a rotation in space may turn the plane over
def rotation_from_scipy(paths, truths):
    flat = lambda p: np.pad(np.vstack(p) - np.vstack(p).mean(0), ((0, 0), (0, 1)))
    theta = Rotation.align_vectors(flat(truths), flat(paths))[0].as_rotvec()[2]
    w = np.exp(1j * theta)
    p, q = (np.vstack(all) @ [1, 1j] for all in (paths, truths))
    t = q.mean() - w * p.mean()
    off = [abs(w * (k @ [1, 1j]) + t - s @ [1, 1j]) for k, s in zip(paths, truths, strict=True)]
    return (t.real, t.imag, theta), [np.linalg.norm(d) / len(d) ** 0.5 for d in off]


# --- 18.4 fuse ---


@answer_to("18.4", hint="l|P1|[Ww]eight")
def half_of_the_information(l1, P1, l2, P2):
    return covariance_intersection(l1, P1, l2, P2)


@answer_to("18.4", hint="P|covariance")
def smaller_entry_of_both(l1, P1, l2, P2):
    return fuse(l1, P1, l2, P2)[0], np.minimum(P1, P2)


@answer_to("18.4", hint="K|gain|[Ww]eight|l")
def gain_without_P1_in_Z(l1, P1, l2, P2):
    return l1 + P1 @ np.linalg.inv(P2) @ (l2 - l1), fuse(l1, P1, l2, P2)[1]


@answer_to("18.4", right=True)
def least_squares(l1, P1, l2, P2):
    W = [np.linalg.inv(np.linalg.cholesky(P)) for P in (P1, P2)]
    A, b = np.vstack(W), np.concatenate([W[0] @ l1, W[1] @ l2])
    return np.linalg.lstsq(A, b, rcond=None)[0], np.linalg.inv(A.T @ A)


@answer_to("18.4", right=True)
def parallel_sum(l1, P1, l2, P2):
    G = np.linalg.inv(P1 + P2)
    return P2 @ G @ l1 + P1 @ G @ l2, P1 @ G @ P2


# --- 18.2: the same in other words ---


def _H_2(x, a, b, z, E_a, E_b):
    H = np.zeros((len(z), len(x)))
    H[:, a], H[:, b] = E_a, E_b
    return H


@answer_to("18.2", right=True)
def with_the_inverse_and_josephs_form(x, P, a, b, z, E_a, E_b, R):
    H = _H_2(x, a, b, z, E_a, E_b)
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    L = np.eye(len(x)) - K @ H
    return x + K @ z, L @ P @ L.T + K @ R @ K.T


@answer_to("18.2", right=True)
def block_by_block_lists(x, P, a, b, z, E_a, E_b, R):
    PHt = P[:, a] @ E_a.T + P[:, b] @ E_b.T
    Z = E_a @ PHt[a] + E_b @ PHt[b] + R
    K = PHt @ np.linalg.inv(Z)
    return (x + K @ z).tolist(), (P - K @ PHt.T).tolist()


@answer_to("18.2", right=True)
def cholesky_factor(x, P, a, b, z, E_a, E_b, R):
    H = _H_2(x, a, b, z, E_a, E_b)
    L = np.linalg.cholesky(H @ P @ H.T + R)
    W = np.linalg.solve(L, H @ P)
    return x + W.T @ np.linalg.solve(L, z), P - W.T @ W


# --- 18.4: the same in other words ---


@answer_to("18.4", right=True)
def informations(l1, P1, l2, P2):
    A1, A2 = np.linalg.inv(P1), np.linalg.inv(P2)
    P = np.linalg.inv(A1 + A2)
    return P @ (A1 @ l1 + A2 @ l2), P


@answer_to("18.4", right=True)
def josephs_form_lists(l1, P1, l2, P2):
    K = P1 @ np.linalg.inv(P1 + P2)
    L = np.eye(len(l1)) - K
    return (l1 + K @ (l2 - l1)).tolist(), (L @ P1 @ L.T + K @ P2 @ K.T).tolist()


@answer_to("18.4", right=True)
def least_squares_over_both_maps(l1, P1, l2, P2):
    n = len(l1)
    W = [np.linalg.inv(np.linalg.cholesky(P)) for P in (P1, P2)]
    A, y = np.vstack(W), np.concatenate([W[0] @ l1, W[1] @ l2])
    l = np.linalg.lstsq(A, y, rcond=None)[0]
    return l, np.linalg.inv(A.T @ A) if n else P1


# --- 18.3: the same in other words ---


@answer_to("18.3", right=True)
def svd(paths, truths):
    p, q = np.vstack(paths), np.vstack(truths)
    U, _, Vt = np.linalg.svd((q - q.mean(0)).T @ (p - p.mean(0)))
    R = U @ np.diag([1, np.linalg.det(U @ Vt)]) @ Vt
    t = q.mean(0) - R @ p.mean(0)
    ates = [float(np.linalg.norm(a @ R.T + t - b) / np.sqrt(len(a))) for a, b in zip(paths, truths, strict=True)]
    return [*t.tolist(), float(np.arctan2(R[1, 0], R[0, 0]))], ates


@answer_to("18.3", right=True)
def complex_numbers_a_whole_turn_more(paths, truths):
    p, q = ([a[:, 0] + 1j * a[:, 1] for a in some] for some in (paths, truths))
    all_p, all_q = np.concatenate(p), np.concatenate(q)
    u = np.sum(np.conj(all_p - all_p.mean()) * (all_q - all_q.mean()))
    u = u / abs(u)
    t = all_q.mean() - u * all_p.mean()
    ates = [np.sqrt(np.mean(abs(u * a + t - b) ** 2)) for a, b in zip(p, q, strict=True)]
    return np.array([t.real, t.imag, np.angle(u) + 2 * np.pi]), np.array(ates)


@answer_to("18.3", right=True)
def the_package(paths, truths):
    from ekfslam_tutorial.geometry import align

    F = align(np.concatenate(paths), np.concatenate(truths))
    return F.x, [np.sqrt(((F.from_frame(p)[0] - q) ** 2).sum(1).mean()) for p, q in zip(paths, truths, strict=True)]


# --- 18.1: the same in other words ---


def _turn_1(a):
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


@answer_to("18.1", right=True)
def by_the_chain_rule_in_the_frame_of_a(a, b):
    T = _turn_1(a[2]).T
    p = T @ (b[:2] - a[:2])
    r = np.hypot(*p)
    E_p = np.array([p / r, [-p[1] / r**2, p[0] / r**2]])
    E_a = E_p @ np.column_stack([-T, [p[1], -p[0]]])
    return (r, np.arctan2(p[1], p[0])), E_a, np.hstack([E_p @ T, np.zeros((2, 1))])


@answer_to("18.1", right=True)
def complex_numbers_lists_a_whole_turn_more(a, b):
    d = complex(*(np.asarray(b[:2]) - a[:2]))
    u, g = d / abs(d), 1 / d
    e = [abs(d), np.angle(d) - float(a[2]) + 2 * np.pi]
    E_a = [[-u.real, -u.imag, 0], [-g.imag, -g.real, -1]]
    return e, E_a, [[u.real, u.imag, 0], [g.imag, g.real, 0]]


@answer_to("18.1", right=True)
def the_package_too(a, b):
    from ekfslam_tutorial.geometry import Frame2
    from ekfslam_tutorial.models import observe
    from ekfslam_tutorial.models.landmarks import EucPnt
    from ekfslam_tutorial.models.sensors import RangeBearing

    e, E_r, _, E_l = observe(Frame2(a), Frame2(np.zeros(3)), RangeBearing(0.1, 0.1), EucPnt(2), b[:2])
    return e, E_r, np.pad(E_l, ((0, 0), (0, 1)))


test_the_check_is_right_about_it = check_of(__name__)
