"""Answers to the exercises of notebook 09 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb09_ate import ate
from ekfslam_tutorial.course.exercises.nb09_barcodes import landmarks_seen
from ekfslam_tutorial.course.exercises.nb09_clock import clock_offset
from ekfslam_tutorial.course.exercises.nb09_times import by_time

from .collector import answer_to, check_of

# --- 09.1 by_time ---


@answer_to("09.1", hint="rows")
def stamps_only(rows):
    _, late, gap = by_time(rows)
    return np.sort(rows[:, 0]), late, gap


@answer_to("09.1", hint="late|step|[Cc]ount")
def later_than_the_latest_so_far(rows):
    out, _, gap = by_time(rows)
    return out, int(np.sum(rows[:, 0] < np.maximum.accumulate(rows[:, 0]))), gap


@answer_to("09.1", hint="late")
def indices_of_the_late_rows(rows):
    out, _, gap = by_time(rows)
    return out, np.flatnonzero(np.diff(rows[:, 0]) < 0), gap


@answer_to("09.1", hint="gap|longest|step")
def place_of_the_gap(rows):
    out, late, _ = by_time(rows)
    return out, late, int(np.argmax(np.diff(out[:, 0])))


@answer_to("09.1", hint="rows")
def equal_stamps_dropped(rows):
    _, late, gap = by_time(rows)
    keep = np.unique(rows[:, 0], return_index=True)[1]
    return rows[keep], late, gap


@answer_to("09.1", hint="changes its input")
def sorted_in_place(rows):
    out, late, gap = by_time(rows)
    rows[:] = out
    return rows, late, gap


@answer_to("09.1", right=True)
def insertion_sort(rows):
    out, late = [], 0
    for k, row in enumerate(rows):
        late += k > 0 and row[0] < rows[k - 1][0]
        i = len(out)
        while i and out[i - 1][0] > row[0]:
            i -= 1
        out.insert(i, row)
    return np.array(out), late, max(np.diff([r[0] for r in out]))


@answer_to("09.1", right=True)
def python_sorted_indices(rows):
    order = sorted(range(len(rows)), key=lambda i: rows[i, 0])
    t = rows[order, 0]
    return rows[order], float((rows[:-1, 0] > rows[1:, 0]).sum()), (t[1:] - t[:-1]).max()


@answer_to("09.1", right=True)
def structured_with_mergesort(rows):
    out = rows[rows[:, 0].argsort(kind="mergesort")]
    return (
        out.tolist(),
        len([1 for a, b in zip(rows[:, 0], rows[1:, 0], strict=False) if b < a]),
        np.ptp(np.lib.stride_tricks.sliding_window_view(out[:, 0], 2), axis=1).max(),
    )


# --- 09.2 landmarks_seen ---


@answer_to("09.2", hint="stay|times|order|should")
def each_landmark_once(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    keep = np.sort(np.unique(ids, return_index=True)[1])
    return t[keep], ids[keep], y[keep]


@answer_to("09.2", hint="order|times|should")
def ordered_by_subject(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    order = np.argsort(ids, kind="stable")
    return t[order], ids[order], y[order]


@answer_to("09.2", hint="measurements|Columns")
def barcode_among_the_measurements(rows, table, robots):
    t, ids, _ = landmarks_seen(rows, table, robots)
    keep = np.isin(rows[:, 0], t)
    return t, ids, rows[keep, 1:3]


@answer_to("09.2", hint="KeyError.*never fails")
def plain_dictionary(rows, table, robots):
    subject_of = {b: s for s, b in table}
    ids = np.array([subject_of[b] for b in rows[:, 1]])
    keep = ~np.isin(ids, robots)
    return rows[keep, 0], ids[keep], rows[keep, 2:]


@answer_to("09.2", hint="times|one axis|axes|shape")
def one_table(rows, table, robots):
    t, ids, y = landmarks_seen(rows, table, robots)
    return np.column_stack([t, ids]), ids, y


@answer_to("09.2", hint="3 results|three|return")
def one_array(rows, table, robots):
    return np.column_stack(landmarks_seen(rows, table, robots))


@answer_to("09.2", right=True)
def searchsorted(rows, table, robots):
    table = table[np.argsort(table[:, 1])]
    at = np.minimum(np.searchsorted(table[:, 1], rows[:, 1]), len(table) - 1)
    ids = table[at, 0]
    ok = (table[at, 1] == rows[:, 1]) & np.array([i not in robots for i in ids], dtype=bool)
    return rows[ok, 0], ids[ok], rows[ok][:, 2:4]


@answer_to("09.2", right=True)
def dictionary_of_landmarks_only(rows, table, robots):
    subject = {int(b): int(s) for s, b in table if s not in set(robots)}
    kept = [(r[0], subject[int(r[1])], r[2:]) for r in rows if int(r[1]) in subject]
    return [k[0] for k in kept], [k[1] for k in kept], [k[2] for k in kept]


@answer_to("09.2", right=True)
def two_steps(rows, table, robots):
    rows = rows[np.isin(rows[:, 1], table[:, 1])]
    ids = np.array([table[table[:, 1] == c][0][0] for c in rows[:, 1]], dtype=int)
    mask = np.ones(len(rows), dtype=bool)
    for r in robots:
        mask &= ids != r
    return rows[mask][:, 0], ids[mask], rows[mask][:, -2:]


# --- 09.3 clock_offset ---


@answer_to("09.3", hint="Z|nis")
def mean_Z_of_the_run(offsets, z, Z):
    nis = np.array([np.mean([v @ np.linalg.solve(B.mean(0), v) for v in a]) for a, B in zip(z, Z, strict=True)])
    return offsets[np.argmin(nis)], nis


@answer_to("09.3", hint="2 results|return offset, nis|two")
def offset_only(offsets, z, Z):
    return clock_offset(offsets, z, Z)[0]


@answer_to("09.3", hint="nis|mean|run")
def nis_of_each_measurement(offsets, z, Z):
    nis = np.einsum("kmi,kmij,kmj->km", z, np.linalg.inv(Z), z)
    return offsets[np.argmin(nis.mean(1))], nis


@answer_to("09.3", hint="nis|Z")
def log_likelihood(offsets, z, Z):
    nis = clock_offset(offsets, z, Z)[1] + np.log(np.linalg.det(Z)).mean(1)
    return offsets[np.argmin(nis)], nis


@answer_to("09.3", hint="inv|nis|Z")
def first_component_only(offsets, z, Z):
    nis = np.mean(z[..., 0] ** 2 / Z[..., 0, 0], axis=1)
    return offsets[np.argmin(nis)], nis


@answer_to("09.3", hint="nis|mean|m")
def divided_by_one_less(offsets, z, Z):
    best, nis = clock_offset(offsets, z, Z)
    m = z.shape[1]
    return best, nis * m / max(m - 1, 0.5)


@answer_to("09.3", right=True)
def sorted_pairs(offsets, z, Z):
    nis = [np.mean([v @ np.linalg.inv(S) @ v for v, S in zip(a, B, strict=True)]) for a, B in zip(z, Z, strict=True)]
    return sorted(zip(nis, offsets, strict=True))[0][1], nis


@answer_to("09.3", right=True)
def all_in_one_long_list(offsets, z, Z):
    K, m, p = z.shape
    w = np.linalg.solve(np.linalg.cholesky(Z.reshape(-1, p, p)), z.reshape(-1, p, 1))
    nis = np.sum(w**2, axis=(1, 2)).reshape(K, m).mean(1)
    return offsets.tolist()[int(nis.argmin())], nis


@answer_to("09.3", right=True)
def eigenvectors(offsets, z, Z):
    w, V = np.linalg.eigh(Z)
    a = np.einsum("kmji,kmj->kmi", V, z)
    nis = (a * a / w).sum(2).mean(1)
    return np.asarray(offsets)[nis == nis.min()][0], tuple(nis)


# --- 09.4 ate ---


@answer_to("09.4", hint="scale|align|angle|should be")
def with_a_scale(path, truth):
    aligned, _ = ate(path, truth)
    c = truth.mean(0)
    a, b = aligned - c, truth - c
    aligned = c + a * np.sum(a * b) / np.sum(a * a)
    return aligned, np.sqrt(np.mean(np.sum((aligned - truth) ** 2, 1)))


@answer_to("09.4", hint="angle|turn|align")
def direction_of_the_whole_way(path, truth):
    u, v = path[-1] - path[0], truth[-1] - truth[0]
    t = np.arctan2(v[1], v[0]) - np.arctan2(u[1], u[0])
    R = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    aligned = (path - path.mean(0)) @ R.T + truth.mean(0)
    return aligned, np.sqrt(np.mean(np.sum((aligned - truth) ** 2, 1)))


@answer_to("09.4", hint="frame of the truth|align|should be")
def truth_laid_on_the_path(path, truth):
    aligned, error = ate(truth, path)
    return aligned, error


@answer_to("09.4", hint="root|mean|distance|each point")
def root_of_each_coordinate(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.sqrt(np.mean((aligned - truth) ** 2))


@answer_to("09.4", hint="distance|mean|should be|Square")
def mean_distance(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.mean(np.linalg.norm(aligned - truth, axis=1))


@answer_to("09.4", hint="worst point")
def largest_distance(path, truth):
    aligned, _ = ate(path, truth)
    return aligned, np.max(np.linalg.norm(aligned - truth, axis=1))


@answer_to("09.4", right=True)
def complex_numbers(path, truth):
    a, b = path @ [1, 1j], truth @ [1, 1j]
    c = np.vdot(a - a.mean(), b - b.mean())
    w = (a - a.mean()) * c / abs(c) + b.mean()
    return np.column_stack([w.real, w.imag]), np.sqrt(np.mean(np.abs(w - b) ** 2))


@answer_to("09.4", right=True)
def svd_with_the_sign(path, truth):
    a, b = path - path.mean(0), truth - truth.mean(0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    D = np.diag([1, np.sign(np.linalg.det(Vt.T @ U.T))])
    aligned = (Vt.T @ D @ U.T @ a.T).T + truth.mean(0)
    return aligned.tolist(), np.linalg.norm(aligned - truth) / len(path) ** 0.5


@answer_to("09.4", right=True)
def the_package(path, truth):
    from ekfslam_tutorial.geometry import align

    aligned = align(path, truth).from_frame(path)[0]
    return aligned, np.sqrt(((aligned - truth) ** 2).sum(1).mean())


# --- 09.4: the same in other words ---


def _best_4(path, truth, mirror=False):
    U, s, Vt = np.linalg.svd((truth - truth.mean(0)).T @ (path - path.mean(0)))
    D = np.diag([1.0, 1.0 if mirror else np.linalg.det(U @ Vt)])
    return U @ D @ Vt, np.sum(s * np.diag(D)) / np.sum((path - path.mean(0)) ** 2)


def _turned_4(path, truth, R):
    return (path - path.mean(0)) @ R.T + truth.mean(0)


@answer_to("09.4", right=True)
def svd_with_the_sign_of_the_determinant_as_lists(path, truth):
    aligned = _turned_4(path, truth, _best_4(path, truth)[0])
    return aligned.tolist(), float(np.linalg.norm(aligned - truth) / np.sqrt(len(path)))


@answer_to("09.4", right=True)
def complex_numbers_too(path, truth):
    p, t = (a[:, 0] + 1j * a[:, 1] for a in (path, truth))
    u = np.sum(np.conj(p - p.mean()) * (t - t.mean()))
    q = u / abs(u) * (p - p.mean()) + t.mean()
    return np.column_stack([q.real, q.imag]), np.sqrt(np.mean(abs(q - t) ** 2))


@answer_to("09.4", right=True)
def the_package_too(path, truth):
    from ekfslam_tutorial.analysis import align

    aligned = align(path, truth).from_frame(path)[0]
    return aligned, np.sqrt(((aligned - truth) ** 2).sum(1).mean())


# --- 09.2: the same in other words ---


@answer_to("09.2", right=True)
def a_loop_lists(rows, table, robots):
    t, ids, y = [], [], []
    for time, code, r, b in rows:
        for subject, barcode in table:
            if barcode == code and subject not in list(robots):
                t.append(time)
                ids.append(int(subject))
                y.append([r, b])
    return t, ids, y


@answer_to("09.2", right=True)
def comparison_of_all_with_all(rows, table, robots):
    landmarks = table[~np.isin(table[:, 0], robots)]
    row, entry = np.nonzero(rows[:, 1][:, None] == landmarks[:, 1])
    return rows[row, 0], landmarks[entry, 0], rows[row][:, [2, 3]]


# --- 09.3: the same in other words ---


@answer_to("09.3", right=True)
def loops_and_solve_lists(offsets, z, Z):
    nis = [
        sum(a @ np.linalg.solve(B, a) for a, B in zip(zk, Zk, strict=True)) / len(zk)
        for zk, Zk in zip(z, Z, strict=True)
    ]
    return min(zip(nis, offsets, strict=True))[1], nis


@answer_to("09.3", right=True)
def inverse_and_matrix_products(offsets, z, Z):
    nis = (z[:, :, None, :] @ np.linalg.inv(Z) @ z[:, :, :, None])[:, :, 0, 0].mean(axis=1)
    return [float(offsets[list(nis).index(nis.min())]), nis]


@answer_to("09.3", right=True)
def cholesky(offsets, z, Z):
    white = np.linalg.solve(np.linalg.cholesky(Z), z[..., None])[..., 0]
    nis = np.sum(white**2, axis=(1, 2)) / z.shape[1]
    return offsets[nis.argmin()], nis


# --- 09.1: the same in other words ---


@answer_to("09.1", right=True)
def sorted_with_a_key_loops_lists(rows):
    t = [row[0] for row in rows]
    out = sorted((list(row) for row in rows), key=lambda row: row[0])
    gap = max(b[0] - a[0] for a, b in zip(out, out[1:], strict=False))
    return [out, sum(b < a for a, b in zip(t, t[1:], strict=False)), gap]


@answer_to("09.1", right=True)
def lexsort_with_the_row_number(rows):
    order = np.lexsort((np.arange(len(rows)), rows[:, 0]))
    steps = np.ediff1d(rows[order, 0])
    return rows[order], np.count_nonzero(rows[1:, 0] < rows[:-1, 0]), steps.max()


@answer_to("09.2", hint=r"subjects, entry \[0\], is 1\d\d for .*, it should be \d+ ")
def subjects_counted_from_a_hundred(rows, table, robots):
    times, subjects, measurements = landmarks_seen(rows, table, robots)
    return times, 100 + subjects, measurements


test_the_check_is_right_about_it = check_of(__name__)
