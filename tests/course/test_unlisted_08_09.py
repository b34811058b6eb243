"""Answers to the exercises of notebooks 08 and 09 that are in no list of the package."""

import numpy as np
import scipy.linalg

from ekfslam_tutorial.course.exercises.nb08_fej import correct_fej, observe
from ekfslam_tutorial.course.exercises.nb08_nullspace import observability
from ekfslam_tutorial.course.exercises.nb09_ate import ate
from ekfslam_tutorial.course.exercises.nb09_barcodes import landmarks_seen
from ekfslam_tutorial.course.exercises.nb09_clock import clock_offset
from ekfslam_tutorial.course.exercises.nb09_times import by_time
from ekfslam_tutorial.geometry import wrap

from .probes import Probes, judged_rightly

probes = Probes()
wrong, right = probes.wrong, probes.right


@probes.each
def test_the_check_is_right_about_it(id, says, answer):
    judged_rightly(id, says, answer)


# --- 08.1 observability ---


@wrong("08.1", "H_0 sees the first state")
def last_state_instead_of_the_first(H, F):
    O, Phi = [H[-1]], np.eye(H[0].shape[1])
    for A, B in zip(H[-2::-1], F[::-1], strict=True):
        Phi = Phi @ np.linalg.inv(B)
        O.insert(0, A @ Phi)
    return np.vstack(O), observability(H, F)[1]


@wrong("08.1", "times|whole O|rank|invisible")
def rank_of_the_last_block(H, F):
    O, _ = observability(H, F)
    return O, O.shape[1] - np.linalg.matrix_rank(H[-1])


@wrong("08.1", "whole number|invisible|must be")
def the_null_space_itself(H, F):
    O, _ = observability(H, F)
    return O, scipy.linalg.null_space(O)


@wrong("08.1", "rows")
def gramian(H, F):
    O, d = observability(H, F)
    return O.T @ O, d


@wrong("08.1", "invisible")
def one_too_many(H, F):
    O, d = observability(H, F)
    return O, d + 1


@wrong("08.1", "columns|rows|shape")
def side_by_side(H, F):
    O, d = observability(H, F)
    return O.T, d


@right("08.1")
def eigenvalues_of_the_gramian(H, F):
    O, _ = observability(H, F)
    w = np.linalg.eigvalsh(O.T @ O)
    return O, int(np.sum(w <= 1e-11 * w[-1]))


@right("08.1")
def pivoted_qr(H, F):
    Phi, O = np.eye(len(H[0][0])), list(H[0])
    for k, A in enumerate(H[1:]):
        Phi = F[k] @ Phi
        O.extend(A @ Phi)
    r = np.abs(np.diag(scipy.linalg.qr(np.array(O), mode="r", pivoting=True)[0]))
    return O, float(len(O[0]) - np.sum(r > 1e-9 * r[0]))


@right("08.1")
def product_for_each_time(H, F):
    n = H[0].shape[1]
    O = np.concatenate([H[k] @ np.linalg.multi_dot([np.eye(n), *F[:k][::-1], np.eye(n)]) for k in range(len(H))])
    return O, n - np.linalg.matrix_rank(O)


# --- 08.2 correct_fej ---


@wrong("08.2", "mean|x after|e is taken|x_first")
def linear_expectation(x, P, y, i, x_first, R):
    e, H = observe(x_first, i)
    z = y - (e + H @ (x - x_first))
    z[1] = wrap(z[1])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P


@wrong("08.2", "x_first|H")
def mean_of_both_jacobians(x, P, y, i, x_first, R):
    e, H = observe(x, i)
    H = (H + observe(x_first, i)[1]) / 2
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ z, P - K @ H @ P


@wrong("08.2", "return|results")
def returns_the_innovation_too(x, P, y, i, x_first, R):
    return *correct_fej(x, P, y, i, x_first, R), y - observe(x, i)[0]


@wrong("08.2", "changes its input")
def corrects_x_in_place(x, P, y, i, x_first, R):
    new, Q = correct_fej(x, P, y, i, x_first, R)
    x[:] = new
    return x, Q


@wrong("08.2", "wrapped|seam|range|should be")
def both_numbers_wrapped(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return x + K @ (wrap(y - e) * [0.5, 1]), P - K @ H @ P


@wrong("08.2", "P")
def K_R_K_subtracted(x, P, y, i, x_first, R):
    H = observe(x_first, i)[1]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return correct_fej(x, P, y, i, x_first, R)[0], P - K @ R @ K.T


@right("08.2")
def one_number_after_the_other(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    L = np.linalg.inv(np.linalg.cholesky(R))
    z, dx, Q = L @ [y[0] - e[0], wrap(y[1] - e[1])], np.zeros(len(x)), np.array(P)
    for h, v in zip(L @ H, z, strict=True):
        k = Q @ h / (h @ Q @ h + 1)
        dx, Q = dx + k * (v - h @ dx), Q - np.outer(k, h @ Q)
    return x + dx, (Q + Q.T) / 2


@right("08.2")
def cholesky_of_Z(x, P, y, i, x_first, R):
    e, H = observe(x, i)[0], observe(x_first, i)[1]
    z = np.array([y[0] - e[0], np.angle(np.exp(1j * (y[1] - e[1])))])
    W = np.linalg.solve(np.linalg.cholesky(H @ P @ H.T + R), np.column_stack([H @ P, z]))
    return tuple(x + W[:, :-1].T @ W[:, -1]), P - W[:, :-1].T @ W[:, :-1]


@right("08.2")
def by_lists(x, P, y, i, x_first, R):
    new, Q = correct_fej(x, P, y, i, x_first, R)
    return [new.tolist(), Q.tolist()]


# --- 08.3 joseph ---


@wrong("08.3", "gain|terms")
def K_Z_K_subtracted(P, K, H, R):
    return P - K @ (H @ P @ H.T + R) @ K.T


@wrong("08.3", "gain|terms|K = 0")
def symmetrised_short_form(P, K, H, R):
    Q = P - K @ H @ P
    return (Q + Q.T) / 2


@wrong("08.3", "gain|sign|should be")
def noise_subtracted(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T - K @ R @ K.T


@wrong("08.3", "gain|should be|raised")
def transposed_first(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A.T @ P @ A + K @ R @ K.T


@wrong("08.3", "raised|shape|fit")
def noise_without_the_gain(P, K, H, R):
    A = np.eye(len(P)) - K @ H
    return A @ P @ A.T + R


@wrong("08.3", "gain|should be")
def gain_computed_again(P, K, H, R):
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    return P - K @ H @ P


@right("08.3")
def multiplied_out_as_one_factor(P, K, H, R):
    S = np.hstack([(np.eye(len(P)) - K @ H) @ np.linalg.cholesky(P), K @ np.linalg.cholesky(R)])
    return S @ S.T


@right("08.3")
def block_matrices(P, K, H, R):
    G = np.block([np.identity(P.shape[0]) - K @ H, -K])
    return G @ scipy.linalg.block_diag(P, R) @ G.T


@right("08.3")
def einsum(P, K, H, R):
    A = np.eye(*P.shape) - np.einsum("ij,jk->ik", K, H)
    return np.einsum("ij,jk,lk->il", A, P, A) + np.einsum("ij,jk,lk->il", K, R, K)


# --- 09.1 by_time ---


@wrong("09.1", "rows")
def stamps_only(rows):
    _, late, gap = by_time(rows)
    return np.sort(rows[:, 0]), late, gap


@wrong("09.1", "late|step|[Cc]ount")
def later_than_the_latest_so_far(rows):
    out, _, gap = by_time(rows)
    return out, int(np.sum(rows[:, 0] < np.maximum.accumulate(rows[:, 0]))), gap


@wrong("09.1", "late")
def indices_of_the_late_rows(rows):
    out, _, gap = by_time(rows)
    return out, np.flatnonzero(np.diff(rows[:, 0]) < 0), gap


@wrong("09.1", "gap|longest|step")
def place_of_the_gap(rows):
    out, late, _ = by_time(rows)
    return out, late, int(np.argmax(np.diff(out[:, 0])))


@wrong("09.1", "rows")
def equal_stamps_dropped(rows):
    _, late, gap = by_time(rows)
    keep = np.unique(rows[:, 0], return_index=True)[1]
    return rows[keep], late, gap


@wrong("09.1", "changes its input")
def sorted_in_place(rows):
    out, late, gap = by_time(rows)
    rows[:] = out
    return rows, late, gap


@right("09.1")
def insertion_sort(rows):
    out, late = [], 0
    for k, row in enumerate(rows):
        late += k > 0 and row[0] < rows[k - 1][0]
        i = len(out)
        while i and out[i - 1][0] > row[0]:
            i -= 1
        out.insert(i, row)
    return np.array(out), late, max(np.diff([r[0] for r in out]))


@right("09.1")
def python_sorted_indices(rows):
    order = sorted(range(len(rows)), key=lambda i: rows[i, 0])
    t = rows[order, 0]
    return rows[order], float((rows[:-1, 0] > rows[1:, 0]).sum()), (t[1:] - t[:-1]).max()


@right("09.1")
def structured_with_mergesort(rows):
    out = rows[rows[:, 0].argsort(kind="mergesort")]
    return (
        out.tolist(),
        len([1 for a, b in zip(rows[:, 0], rows[1:, 0], strict=False) if b < a]),
        np.ptp(np.lib.stride_tricks.sliding_window_view(out[:, 0], 2), axis=1).max(),
    )


# --- 09.2 landmarks_seen ---


@wrong("09.2", "stay|times|order|should")
def each_landmark_once(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    keep = np.sort(np.unique(ids, return_index=True)[1])
    return t[keep], ids[keep], y[keep]


@wrong("09.2", "order|times|should")
def ordered_by_subject(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    order = np.argsort(ids, kind="stable")
    return t[order], ids[order], y[order]


@wrong("09.2", "measurements|Columns")
def barcode_among_the_measurements(rows, table, robots):
    t, ids, _ = landmarks_seen(rows, table, robots)
    keep = np.isin(rows[:, 0], t)
    return t, ids, rows[keep, 1:3]


@wrong("09.2", "KeyError.*never fails")
def plain_dictionary(rows, table, robots):
    subject_of = {b: s for s, b in table}
    ids = np.array([subject_of[b] for b in rows[:, 1]])
    keep = ~np.isin(ids, robots)
    return rows[keep, 0], ids[keep], rows[keep, 2:]


@wrong("09.2", "times|one axis|axes|shape")
def one_table(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    return np.column_stack([t, ids]), ids, y


@wrong("09.2", "3 results|three|return")
def one_array(rows, table, robots):
    return np.column_stack(landmarks_seen(rows, table, robots))


@right("09.2")
def searchsorted(rows, table, robots):
    table = table[np.argsort(table[:, 1])]
    at = np.minimum(np.searchsorted(table[:, 1], rows[:, 1]), len(table) - 1)
    ids = table[at, 0]
    ok = (table[at, 1] == rows[:, 1]) & np.array([i not in robots for i in ids], dtype=bool)
    return rows[ok, 0], ids[ok], rows[ok][:, 2:4]


@right("09.2")
def dictionary_of_landmarks_only(rows, table, robots):
    subject = {int(b): int(s) for s, b in table if s not in set(robots)}
    kept = [(r[0], subject[int(r[1])], r[2:]) for r in rows if int(r[1]) in subject]
    return [k[0] for k in kept], [k[1] for k in kept], [k[2] for k in kept]


@right("09.2")
def two_steps(rows, table, robots):
    rows = rows[np.isin(rows[:, 1], table[:, 1])]
    ids = np.array([table[table[:, 1] == c][0][0] for c in rows[:, 1]], dtype=int)
    mask = np.ones(len(rows), dtype=bool)
    for r in robots:
        mask &= ids != r
    return rows[mask][:, 0], ids[mask], rows[mask][:, -2:]


# --- 09.3 clock_offset ---


@wrong("09.3", "Z|nis")
def mean_Z_of_the_run(offsets, z, Z):
    nis = np.array([np.mean([v @ np.linalg.solve(B.mean(0), v) for v in a]) for a, B in zip(z, Z, strict=True)])
    return offsets[np.argmin(nis)], nis


@wrong("09.3", "2 results|return offset, nis|two")
def offset_only(offsets, z, Z):
    return clock_offset(offsets, z, Z)[0]


@wrong("09.3", "nis|mean|run")
def nis_of_each_measurement(offsets, z, Z):
    nis = np.einsum("kmi,kmij,kmj->km", z, np.linalg.inv(Z), z)
    return offsets[np.argmin(nis.mean(1))], nis


@wrong("09.3", "nis|Z")
def log_likelihood(offsets, z, Z):
    nis = clock_offset(offsets, z, Z)[1] + np.log(np.linalg.det(Z)).mean(1)
    return offsets[np.argmin(nis)], nis


@wrong("09.3", "inv|nis|Z")
def first_component_only(offsets, z, Z):
    nis = np.mean(z[..., 0] ** 2 / Z[..., 0, 0], axis=1)
    return offsets[np.argmin(nis)], nis


@wrong("09.3", "nis|mean|m")
def divided_by_one_less(offsets, z, Z):
    best, nis = clock_offset(offsets, z, Z)
    m = z.shape[1]
    return best, nis * m / max(m - 1, 0.5)


@right("09.3")
def sorted_pairs(offsets, z, Z):
    nis = [np.mean([v @ np.linalg.inv(S) @ v for v, S in zip(a, B, strict=True)]) for a, B in zip(z, Z, strict=True)]
    return sorted(zip(nis, offsets, strict=True))[0][1], nis


@right("09.3")
def all_in_one_long_list(offsets, z, Z):
    K, m, p = z.shape
    w = np.linalg.solve(np.linalg.cholesky(Z.reshape(-1, p, p)), z.reshape(-1, p, 1))
    nis = np.sum(w**2, axis=(1, 2)).reshape(K, m).mean(1)
    return offsets.tolist()[int(nis.argmin())], nis


@right("09.3")
def eigenvectors(offsets, z, Z):
    w, V = np.linalg.eigh(Z)
    a = np.einsum("kmji,kmj->kmi", V, z)
    nis = (a * a / w).sum(2).mean(1)
    return np.asarray(offsets)[nis == nis.min()][0], tuple(nis)


# --- 09.4 ate ---


@wrong("09.4", "scale|align|angle|should be")
def with_a_scale(path, truth):
    aligned, _ = ate(path, truth)
    c = truth.mean(0)
    a, b = aligned - c, truth - c
    aligned = c + a * np.sum(a * b) / np.sum(a * a)
    return aligned, np.sqrt(np.mean(np.sum((aligned - truth) ** 2, 1)))


@wrong("09.4", "angle|turn|align")
def direction_of_the_whole_way(path, truth):
    u, v = path[-1] - path[0], truth[-1] - truth[0]
    t = np.arctan2(v[1], v[0]) - np.arctan2(u[1], u[0])
    R = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    aligned = (path - path.mean(0)) @ R.T + truth.mean(0)
    return aligned, np.sqrt(np.mean(np.sum((aligned - truth) ** 2, 1)))


@wrong("09.4", "frame of the truth|align|should be")
def truth_laid_on_the_path(path, truth):
    aligned, error = ate(truth, path)
    return aligned, error


@wrong("09.4", "root|mean|distance|each point")
def root_of_each_coordinate(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.sqrt(np.mean((aligned - truth) ** 2))


@wrong("09.4", "distance|mean|should be|Square")
def mean_distance(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.mean(np.linalg.norm(aligned - truth, axis=1))


@wrong("09.4", "worst point")
def largest_distance(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.max(np.linalg.norm(aligned - truth, axis=1))


@right("09.4")
def complex_numbers(path, truth):
    a, b = path @ [1, 1j], truth @ [1, 1j]
    c = np.vdot(a - a.mean(), b - b.mean())
    w = (a - a.mean()) * c / abs(c) + b.mean()
    return np.column_stack([w.real, w.imag]), np.sqrt(np.mean(np.abs(w - b) ** 2))


@right("09.4")
def svd_with_the_sign(path, truth):
    a, b = path - path.mean(0), truth - truth.mean(0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    D = np.diag([1, np.sign(np.linalg.det(Vt.T @ U.T))])
    aligned = (Vt.T @ D @ U.T @ a.T).T + truth.mean(0)
    return aligned.tolist(), np.linalg.norm(aligned - truth) / len(path) ** 0.5


@right("09.4")
def the_package(path, truth):
    from ekfslam_tutorial.geometry import align

    aligned = align(path, truth).from_frame(path)[0]
    return aligned, np.sqrt(((aligned - truth) ** 2).sum(1).mean())
