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


@answer_to("18.3", right=True)
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


test_the_check_is_right_about_it = check_of(__name__)
