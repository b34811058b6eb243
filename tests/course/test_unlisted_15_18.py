"""Answers to the exercises of notebooks 15 and 18 that are in no list of the package."""

import numpy as np
import scipy.linalg
import scipy.optimize
from scipy.spatial.transform import Rotation

from ekfslam_tutorial.course.exercises.nb15_blocks import correct_blocks
from ekfslam_tutorial.course.exercises.nb15_fuse import covariance_intersection
from ekfslam_tutorial.course.exercises.nb15_meet import map_in_map
from ekfslam_tutorial.course.exercises.nb18_correct import correct_both
from ekfslam_tutorial.course.exercises.nb18_fuse import fuse
from ekfslam_tutorial.course.exercises.nb18_gauge import align_all
from ekfslam_tutorial.course.exercises.nb18_meet import meet
from ekfslam_tutorial.geometry import Frame2

from .probes import Probes, judged_rightly

probes = Probes()
wrong, right = probes.wrong, probes.right


@probes.each
def test_the_check_is_right_about_it(id, says, answer):
    judged_rightly(id, says, answer)


def _H(n, m, blocks):
    H = np.zeros((m, n))
    for r, E in blocks:
        if r is not None:
            H[:, r] = E
    return H


def _by_numbers(x, P, H, z, R):
    """The correction, one number after the other: the noise is made independent first."""
    W = np.linalg.inv(np.linalg.cholesky(R))
    dx = np.zeros(len(x))
    for h, v in zip(W @ H, W @ z, strict=True):
        k = P @ h / (h @ P @ h + 1)
        dx, P = dx + k * (v - h @ dx), P - np.outer(k, h @ P)
    return x + dx, (P + P.T) / 2


# --- 15.1 correct_blocks ---


@wrong("15.1", "R|noise|Z")
def numbers_as_if_independent(x, P, blocks, z, R):
    return _by_numbers(x, P, _H(len(x), len(z), blocks), z, np.diag(np.diag(R)))


@wrong("15.1", "K|x")
def gain_of_the_new_covariance(x, P, blocks, z, R):
    H = _H(len(x), len(z), blocks)
    Q = correct_blocks(x, P, blocks, z, R)[1]
    return x + Q @ H.T @ np.linalg.inv(H @ Q @ H.T + R) @ z, Q


@wrong("15.1", "P")
def upper_half_of_P(x, P, blocks, z, R):
    x, P = correct_blocks(x, P, blocks, z, R)
    return x, np.triu(P)


@wrong("15.1", "changes its input")
def x_in_place(x, P, blocks, z, R):
    new, P = correct_blocks(x, P, blocks, z, R)
    x += new - x
    return x, P


@wrong("15.1", "slice|columns|E_r|block")
def the_first_block_only(x, P, blocks, z, R):
    return correct_blocks(x, P, [b for b in blocks if b[0] is not None][:1], z, R)


@wrong("15.1", "None")
def stops_at_a_known_state(x, P, blocks, z, R):
    H = np.zeros((len(z), len(x)))
    for r, E in blocks:
        if r is None:
            break
        H[:, r] = E
    return correct_blocks(x, P, [(slice(0, len(x)), H)], z, R)


@right("15.1")
def number_by_number(x, P, blocks, z, R):
    return _by_numbers(x, P, _H(len(x), len(z), blocks), z, R)


@right("15.1")
def conditioned_like_any_gaussian(x, P, blocks, z, R):
    H = np.concatenate([E for r, E in blocks if r is not None], axis=1)
    i = np.concatenate([np.arange(len(x))[r] for r, _ in blocks if r is not None])
    C = P[:, i] @ H.T
    G = scipy.linalg.cho_solve(scipy.linalg.cho_factor(H @ P[np.ix_(i, i)] @ H.T + R), C.T)
    return list(x + z @ G), P - C @ G


# --- 15.2 covariance_intersection ---


@wrong("15.2", "trace")
def three_weights_tried(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    found = [(np.linalg.inv(w * Ia + (1 - w) * Ib), w) for w in (0.0, 0.5, 1.0)]
    P, w = min(found, key=lambda f: np.trace(f[0]))
    return P @ (w * Ia @ xa + (1 - w) * Ib @ xb), P


@wrong("15.2", "stay|twice|rule")
def covariances_added(xa, Pa, xb, Pb):
    return covariance_intersection(xa, Pa, xb, Pb)[0], Pa + Pb


@wrong("15.2", "x|mean")
def one_weight_for_all_numbers(xa, Pa, xb, Pb):
    w = np.trace(Pb) / np.trace(Pa + Pb)
    return w * xa + (1 - w) * xb, covariance_intersection(xa, Pa, xb, Pb)[1]


@wrong("15.2", "w is .* between 0 and 1|w")
def weight_above_one(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    P = np.linalg.inv(1.2 * Ia - 0.2 * Ib) if np.allclose(Pa, Pb) or np.trace(Pa) < np.trace(Pb) else Pb
    return P @ (1.2 * Ia @ xa - 0.2 * Ib @ xb), P


@wrong("15.2", "rule|P")
def diagonals_only(xa, Pa, xb, Pb):
    return covariance_intersection(xa, np.diag(np.diag(Pa)), xb, np.diag(np.diag(Pb)))


@right("15.2")
def minimised(xa, Pa, xb, Pb):
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    trace = lambda w: np.sum(1 / np.linalg.eigvalsh(w * Ia + (1 - w) * Ib))
    w = scipy.optimize.minimize(lambda v: trace(v[0]), [0.5], bounds=[(0, 1)]).x[0]
    I = w * Ia + (1 - w) * Ib
    return np.linalg.solve(I, w * Ia @ xa + (1 - w) * Ib @ xb), np.linalg.inv(I)


@right("15.2")
def thirds(xa, Pa, xb, Pb):
    f = lambda w: Pa @ np.linalg.solve((1 - w) * Pa + w * Pb, Pb)  # the inverse of w inv(Pa) + (1 - w) inv(Pb)
    low, high = 0.0, 1.0
    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if np.trace(f(a)) < np.trace(f(b)) else (a, high)
    w = (low + high) / 2
    x = f(w) @ (w * np.linalg.solve(Pa, xa) + (1 - w) * np.linalg.solve(Pb, xb))
    return x.tolist(), f(w).tolist()


# --- 15.3 map_in_map ---


@wrong("15.3", "x, y, theta|numbers|array")
def a_frame_instead_of_numbers(F1, F2, y):
    return Frame2(map_in_map(F1, F2, y))


@wrong("15.3", "F2|robot 2|map")
def only_the_place_taken_back(F1, F2, y):
    x = map_in_map(F1, Frame2(np.zeros(3)), y)
    return np.array([*(x[:2] - F2.t), x[2] - F2.theta])


@wrong("15.3", "theta")
def degrees(F1, F2, y):
    x = map_in_map(F1, F2, y)
    return np.array([x[0], x[1], np.degrees(x[2])])


@right("15.3")
def complex_numbers(F1, F2, y):
    c1, c2 = complex(*F1.t), complex(*F2.t)
    turn = F1.theta + y[1] + np.pi - y[2] - F2.theta
    w = c1 + y[0] * np.exp(1j * (F1.theta + y[1])) - c2 * np.exp(1j * turn)
    return [w.real, w.imag, np.angle(np.exp(1j * turn))]


@right("15.3")
def matrices(F1, F2, y):
    T = lambda x, y, a: np.array([[np.cos(a), -np.sin(a), x], [np.sin(a), np.cos(a), y], [0, 0, 1]])
    M = T(*F1.x) @ T(0, 0, y[1]) @ T(y[0], 0, 0) @ T(0, 0, np.pi - y[2]) @ np.linalg.inv(T(*F2.x))
    return M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])


# --- 18.1 meet ---


@wrong("18.1", "range")
def city_blocks(a, b):
    e, E_a, E_b = meet(a, b)
    return np.array([np.abs(b[:2] - a[:2]).sum(), e[1]]), E_a, E_b


@wrong("18.1", "bearing")
def arcsine(a, b):
    e, E_a, E_b = meet(a, b)
    return np.array([e[0], np.arcsin((b[1] - a[1]) / e[0]) - a[2]]), E_a, E_b


@wrong("18.1", "E_a")
def cosine_of_the_bearing(a, b):
    (r, beta), _, E_b = meet(a, b)
    c, s = np.cos(beta), np.sin(beta)
    return np.array([r, beta]), np.array([[-c, -s, 0], [s / r, -c / r, -1]]), E_b


@wrong("18.1", "E_b")
def the_same_jacobian_for_both(a, b):
    e, E_a, _ = meet(a, b)
    return e, E_a, -E_a


@right("18.1")
def sines_and_cosines_of_the_direction(a, b):
    d = complex(*(b - a)[:2])
    r, c, s = abs(d), d.real / abs(d), d.imag / abs(d)
    E_a = [[-c, -s, 0], [s / r, -c / r, -1]]
    return [r, np.angle(d) - a[2]], E_a, [[c, s, 0], [-s / r, c / r, 0]]


# --- 18.2 correct_both ---


@wrong("18.2", "cross|P_ab|Z|[Hh]ang together|product")
def two_filters(x, P, a, b, z, E_a, E_b, R):
    H, Q = _H(len(x), len(z), [(a, E_a), (b, E_b)]), np.zeros_like(P)
    for r in (a, b):
        Q[r, r] = P[r, r]
    K = Q @ H.T @ np.linalg.inv(H @ Q @ H.T + R)
    return x + K @ z, P - K @ H @ P


@wrong("18.2", "K Z K|P")
def K_R_K_subtracted(x, P, a, b, z, E_a, E_b, R):
    H = _H(len(x), len(z), [(a, E_a), (b, E_b)])
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    return x + K @ z, P - K @ R @ K.T


@wrong("18.2", "x|K z")
def difference_returned(x, P, a, b, z, E_a, E_b, R):
    new, Q = correct_both(x, P, a, b, z, E_a, E_b, R)
    return new - x, Q


@right("18.2")
def one_number_after_the_other(x, P, a, b, z, E_a, E_b, R):
    return _by_numbers(x, P, _H(len(x), len(z), [(a, E_a), (b, E_b)]), z, R)


# --- 18.3 align_all ---


@wrong("18.3", "no error|rigid motion|F")
def first_points_laid_on_each_other(paths, truths):
    F, _ = align_all(paths, truths)
    c, s = np.cos(F[2]), np.sin(F[2])
    F[:2] = truths[0][0] - np.array([[c, -s], [s, c]]) @ paths[0][0]
    return F, align_all(paths, truths)[1]


@wrong("18.3", "ate|instants|mean")
def one_less(paths, truths):
    F, ates = align_all(paths, truths)
    n = np.array([len(p) for p in paths])
    return F, ates * np.sqrt(n / (n - 1))


@right("18.3")
def rotation_from_scipy(paths, truths):
    flat = lambda p: np.pad(np.vstack(p) - np.vstack(p).mean(0), ((0, 0), (0, 1)))
    theta = Rotation.align_vectors(flat(truths), flat(paths))[0].as_rotvec()[2]
    w = np.exp(1j * theta)
    p, q = (np.vstack(all) @ [1, 1j] for all in (paths, truths))
    t = q.mean() - w * p.mean()
    off = [abs(w * (k @ [1, 1j]) + t - s @ [1, 1j]) for k, s in zip(paths, truths, strict=True)]
    return (t.real, t.imag, theta), [np.linalg.norm(d) / len(d) ** 0.5 for d in off]


# --- 18.4 fuse ---


@wrong("18.4", "l|P1|[Ww]eight")
def half_of_the_information(l1, P1, l2, P2):
    return covariance_intersection(l1, P1, l2, P2)


@wrong("18.4", "P|covariance")
def smaller_entry_of_both(l1, P1, l2, P2):
    return fuse(l1, P1, l2, P2)[0], np.minimum(P1, P2)


@wrong("18.4", "K|gain|[Ww]eight|l")
def gain_without_P1_in_Z(l1, P1, l2, P2):
    return l1 + P1 @ np.linalg.inv(P2) @ (l2 - l1), fuse(l1, P1, l2, P2)[1]


@right("18.4")
def least_squares(l1, P1, l2, P2):
    W = [np.linalg.inv(np.linalg.cholesky(P)) for P in (P1, P2)]
    A, b = np.vstack(W), np.concatenate([W[0] @ l1, W[1] @ l2])
    return np.linalg.lstsq(A, b, rcond=None)[0], np.linalg.inv(A.T @ A)


@right("18.4")
def parallel_sum(l1, P1, l2, P2):
    G = np.linalg.inv(P1 + P2)
    return P2 @ G @ l1 + P1 @ G @ l2, P1 @ G @ P2
