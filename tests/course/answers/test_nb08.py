"""Answers to the exercises of notebook 08 that are in no list of the package: wrong ones, and odd right ones."""

from functools import reduce

import numpy as np
import scipy.linalg

from ekfslam_tutorial.course.exercises.nb08_fej import correct_fej, observe
from ekfslam_tutorial.course.exercises.nb08_nullspace import observability
from ekfslam_tutorial.ekf import Map, correct, covariance, cross, innovation
from ekfslam_tutorial.geometry import wrap
from ekfslam_tutorial.models.sensors import RangeBearing

from .collector import answer_to, check_of

# --- 08.1 observability ---


@answer_to("08.1", hint="H_0 sees the first state")
def last_state_instead_of_the_first(H, F):
    O, Phi = [H[-1]], np.eye(H[0].shape[1])
    for A, B in zip(H[-2::-1], F[::-1], strict=True):
        Phi = Phi @ np.linalg.inv(B)
        O.insert(0, A @ Phi)
    return np.vstack(O), observability(H, F)[1]


@answer_to("08.1", hint="times|whole O|rank|invisible")
def rank_of_the_last_block(H, F):
    O, _ = observability(H, F)
    return O, O.shape[1] - np.linalg.matrix_rank(H[-1])


@answer_to("08.1", hint="whole number|invisible|must be")
def the_null_space_itself(H, F):
    O, _ = observability(H, F)
    return O, scipy.linalg.null_space(O)


@answer_to("08.1", hint="rows")
def gramian(H, F):
    O, d = observability(H, F)
    return O.T @ O, d


@answer_to("08.1", hint="invisible")
def one_too_many(H, F):
    O, d = observability(H, F)
    return O, d + 1


@answer_to("08.1", hint="columns|rows|shape")
def side_by_side(H, F):
    O, d = observability(H, F)
    return O.T, d


@answer_to("08.1", right=True)
def eigenvalues_of_the_gramian(H, F):
    O, _ = observability(H, F)
    w = np.linalg.eigvalsh(O.T @ O)
    return O, int(np.sum(w <= 1e-11 * w[-1]))


@answer_to("08.1", right=True)
def pivoted_qr(H, F):
    Phi, O = np.eye(len(H[0][0])), list(H[0])
    for k, A in enumerate(H[1:]):
        Phi = F[k] @ Phi
        O.extend(A @ Phi)
    r = np.abs(np.diag(scipy.linalg.qr(np.array(O), mode="r", pivoting=True)[0]))
    return O, float(len(O[0]) - np.sum(r > 1e-9 * r[0]))


@answer_to("08.1", right=True)
def product_for_each_time(H, F):
    n = H[0].shape[1]
    O = np.concatenate([H[k] @ np.linalg.multi_dot([np.eye(n), *F[:k][::-1], np.eye(n)]) for k in range(len(H))])
    return O, n - np.linalg.matrix_rank(O)


# --- 08.2 correct_fej ---


@answer_to("08.2", hint="mean|x after|e is taken|x_first")
def linear_expectation(x, P, y, i, x_first, R):
    e, H = observe(x_first, i)
    z = y - (e + H @ (x - x_first))
    z[1] = wrap(z[1])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P


@answer_to("08.2", hint="x_first|H")
def mean_of_both_jacobians(x, P, y, i, x_first, R):
    e, H = observe(x, i)
    H = (H + observe(x_first, i)[1]) / 2
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P


@answer_to("08.2", hint="return|results")
def returns_the_innovation_too(x, P, y, i, x_first, R):
    return *correct_fej(x, P, y, i, x_first, R), y - observe(x, i)[0]


@answer_to("08.2", hint="changes its input")
def corrects_x_in_place(x, P, y, i, x_first, R):
    new, Q = correct_fej(x, P, y, i, x_first, R)
    x[:] = new
    return x, Q


@answer_to("08.2", hint="wrapped|seam|range|should be")
def both_numbers_wrapped(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ (wrap(y - e) * [0.5, 1]), P - K @ H @ P


@answer_to("08.2", hint="P")
def K_R_K_subtracted(x, P, y, i, x_first, R):
    H = observe(x_first, i)[1]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return correct_fej(x, P, y, i, x_first, R)[0], P - K @ R @ K.T


@answer_to("08.2", right=True)
def one_number_after_the_other(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    L = np.linalg.inv(np.linalg.cholesky(R))
    z, dx, Q = L @ [y[0] - e[0], wrap(y[1] - e[1])], np.zeros(len(x)), np.array(P)
    for h, v in zip(L @ H, z, strict=True):
        k = Q @ h / (h @ Q @ h + 1)
        dx, Q = dx + k * (v - h @ dx), Q - np.outer(k, h @ Q)
    return x + dx, (Q + Q.T) / 2


@answer_to("08.2", right=True)
def cholesky_of_Z(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    z = np.array([y[0] - e[0], np.angle(np.exp(1j * (y[1] - e[1])))])
    W = np.linalg.solve(np.linalg.cholesky(H @ P @ H.T + R), np.column_stack([H @ P, z]))
    return tuple(x + W[:, :-1].T @ W[:, -1]), P - W[:, :-1].T @ W[:, :-1]


@answer_to("08.2", right=True)
def by_lists(x, P, y, i, x_first, R):
    new, Q = correct_fej(x, P, y, i, x_first, R)
    return [new.tolist(), Q.tolist()]


# --- 08.3 joseph ---


@answer_to("08.3", hint="gain|terms")
def K_Z_K_subtracted(P, K, H, R):
    return P - K @ (H @ P @ H.T + R) @ K.T


@answer_to("08.3", hint="gain|terms|K = 0")
def symmetrised_short_form(P, K, H, R):
    Q = P - K @ H @ P
    return (Q + Q.T) / 2


@answer_to("08.3", hint="gain|sign|should be")
def noise_subtracted(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T - K @ R @ K.T


@answer_to("08.3", hint="gain|should be|raised")
def transposed_first(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A.T @ P @ A + K @ R @ K.T


@answer_to("08.3", hint="raised|shape|fit")
def noise_without_the_gain(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T + R


@answer_to("08.3", hint="gain|should be")
def gain_computed_again(P, K, H, R):
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    return P - K @ H @ P


@answer_to("08.3", right=True)
def multiplied_out_as_one_factor(P, K, H, R):
    S = np.hstack([(np.eye(len(P)) - K @ H) @ np.linalg.cholesky(P), K @ np.linalg.cholesky(R)])
    return S @ S.T


@answer_to("08.3", right=True)
def block_matrices(P, K, H, R):
    G = np.block([np.identity(P.shape[0]) - K @ H, -K])
    return G @ scipy.linalg.block_diag(P, R) @ G.T


@answer_to("08.3", right=True)
def einsum(P, K, H, R):
    A = np.eye(*P.shape) - np.einsum("ij,jk->ik", K, H)
    return np.einsum("ij,jk,lk->il", A, P, A) + np.einsum("ij,jk,lk->il", K, R, K)


# --- right answers in other words ---


@answer_to("08.2", right=True)
def joseph_form_whole_turns_added_lists(x, P, y, i, x_first, R):
    (e, _), (_, H) = observe(x, i), observe(x_first, i)
    z = [y[0] - e[0], np.arctan2(np.sin(y[1] - e[1]), np.cos(y[1] - e[1]))]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    new = x + K @ z
    return [*new[:2], new[2] + 2 * np.pi, *new[3:]], (A @ P @ A.T + K @ R @ K.T).tolist()


@answer_to("08.2", right=True)
def information_form(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    z = np.subtract(y, e)
    z[1] = (z[1] + np.pi) % (2 * np.pi) - np.pi
    A = np.eye(len(x)) + P @ H.T @ np.linalg.solve(R, H)
    P = np.linalg.solve(A, P)
    return x + P @ H.T @ np.linalg.solve(R, z), 0.5 * (P + P.T)


@answer_to("08.2", right=True)
def by_the_blocks_of_the_package(x, P, y, i, x_first, R):
    map = Map()
    map.add(x, P)
    H = [(slice(0, len(x)), observe(x_first, i)[1])]
    PHt = cross(map, H)
    correct(map, PHt, innovation(RangeBearing(1, 1).residual(y, observe(x, i)[0]), covariance(PHt, H), R))
    return map.x, map.P


@answer_to("08.3", right=True)
def made_symmetric_at_the_end_as_lists(P, K, H, R):
    A = np.identity(P.shape[0]) - np.dot(K, H)
    B = np.linalg.multi_dot([A, P, A.T]) + np.linalg.multi_dot([K, R, K.T])
    return ((B + B.T) / 2).tolist()


@answer_to("08.3", right=True)
def one_product_A_K_times_the_joint_covariance(P, K, H, R):
    n, m = K.shape
    B = np.hstack([np.eye(n) - K @ H, -K])
    S = np.block([[P, np.zeros((n, m))], [np.zeros((m, n)), R]])
    return B @ S @ B.T


@answer_to("08.3", right=True)
def square_roots_of_P_and_R(P, K, H, R):
    A = (np.eye(len(P)) - K @ H) @ np.linalg.cholesky(P)
    B = K @ np.linalg.cholesky(R)
    return A @ A.T + B @ B.T


@answer_to("08.1", right=True)
def singular_value_decomposition_as_lists(H, F):
    Phi, O = np.eye(H[0].shape[1]), H[0]
    for k in range(len(F)):
        Phi = F[k] @ Phi
        O = np.concatenate([O, H[k + 1] @ Phi])
    s = np.linalg.svd(O, compute_uv=False)
    return [O.tolist(), O.shape[1] - int(np.sum(s > 1e-9 * s.max()))]


@answer_to("08.1", right=True)
def null_space_of_scipy(H, F):
    O = np.vstack([H_k @ reduce(lambda Phi, F_j: F_j @ Phi, F[:k], np.eye(H_k.shape[1])) for k, H_k in enumerate(H)])
    return O, scipy.linalg.null_space(O, rcond=1e-10).shape[1]


@answer_to("08.1", right=True)
def rank_with_numpy_s_own_tolerance(H, F):
    Phi, O = np.eye(H[0].shape[1]), [H[0]]
    for A, B in zip(H[1:], F, strict=True):
        Phi = B @ Phi
        O += [A @ Phi]
    return np.vstack(O), Phi.shape[0] - np.linalg.matrix_rank(np.vstack(O))


@answer_to("08.1", right=True)
def backwards_Horner_s_rule(H, F):
    O = H[-1]
    for A, B in zip(H[-2::-1], F[::-1], strict=True):
        O = np.vstack([A, O @ B])
    return O, O.shape[1] - np.linalg.matrix_rank(O)


test_the_check_is_right_about_it = check_of(__name__)
