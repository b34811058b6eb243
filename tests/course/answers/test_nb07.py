"""Answers to the exercises of notebook 07 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import scipy.linalg
import scipy.optimize
from scipy.stats import chi2

from ekfslam_tutorial.course.exercises.nb07_choose import choose
from ekfslam_tutorial.course.exercises.nb07_joint import jointly_compatible
from ekfslam_tutorial.course.exercises.nb07_mutual import mutual_nearest
from ekfslam_tutorial.course.exercises.nb07_new import new_ones
from ekfslam_tutorial.geometry import wrap

from .collector import answer_to, check_of

# --- 07.1 choose ---


@answer_to("07.1", hint="plausible|ambiguous|guess")
def clearly_nearer_one_wins(zs, Zs, confidence):
    i, d2 = choose(zs, Zs, confidence)
    inside = np.flatnonzero(d2 <= chi2.ppf(confidence, np.shape(zs)[1]))
    if len(inside) > 1 and np.sort(d2)[1] > 3 * np.sort(d2)[0]:
        return int(np.argmin(d2)), d2
    return i, d2


@answer_to("07.1", hint="index|None, not|must be")
def true_or_false(zs, Zs, confidence):
    i, d2 = choose(zs, Zs, confidence)
    return i is not None, d2


@answer_to("07.1", hint="index|counted from 0")
def a_mask(zs, Zs, confidence):
    d2 = choose(zs, Zs, confidence)[1]
    return d2 <= chi2.ppf(confidence, np.shape(zs)[1]), d2


@answer_to("07.1", hint="d2 = z|whole")
def likelihood_instead_of_distance(zs, Zs, confidence):
    i, d2 = choose(zs, Zs, confidence)
    return i, d2 + np.log(np.linalg.det(2 * np.pi * Zs))


@answer_to("07.1", hint="whole|inv")
def determinant_for_the_inverse(zs, Zs, confidence):
    d2 = np.array([z @ z / np.linalg.det(Z) for z, Z in zip(zs, Zs, strict=True)])
    return choose(zs, Zs, confidence)[0], d2


@answer_to("07.1", hint="2 results|return i, d2")
def index_only(zs, Zs, confidence):
    return choose(zs, Zs, confidence)[0]


@answer_to("07.1", hint="None")
def empty_list_for_none(zs, Zs, confidence):
    i, d2 = choose(zs, Zs, confidence)
    return ([] if i is None else i), d2


@answer_to("07.1", hint="m degrees of freedom")
def sigma_rule_of_one_dimension(zs, Zs, confidence):
    d2 = choose(zs, Zs, confidence)[1]
    inside = np.flatnonzero(np.sqrt(d2) < 2.576)
    return (int(inside[0]) if len(inside) == 1 else None), d2


@answer_to("07.1", hint="m degrees of freedom")
def density_for_the_quantile(zs, Zs, confidence):
    d2 = choose(zs, Zs, confidence)[1]
    inside = np.flatnonzero(chi2.pdf(d2, zs.shape[1]) > 1 - confidence)
    return (int(inside[0]) if len(inside) == 1 else None), d2


@answer_to("07.1", right=True)
def survival_function(zs, Zs, confidence):
    L = np.linalg.cholesky(Zs)
    w = [scipy.linalg.solve_triangular(a, z, lower=True) for a, z in zip(L, zs, strict=True)]
    d2 = np.square(w).sum(axis=1)
    (i,) = np.nonzero(chi2.sf(d2, np.shape(zs)[1]) > 1 - confidence)
    return (i.item() if i.size == 1 else None), d2


@answer_to("07.1", right=True)
def sorted_distances(zs, Zs, confidence):
    d2 = [np.dot(z, np.dot(np.linalg.pinv(Z), z)) for z, Z in zip(zs, Zs, strict=True)]
    order, limit = np.argsort(d2), chi2.isf(1 - confidence, len(zs[0]))
    best, second = d2[order[0]], (d2[order[1]] if len(d2) > 1 else np.inf)
    return (order[0] if best < limit < second else None), np.array(d2)


@answer_to("07.1", right=True)
def eigenvectors_of_Z(zs, Zs, confidence):
    w, V = np.linalg.eigh(Zs)
    a = (np.transpose(V, (0, 2, 1)) @ zs[..., None])[..., 0]
    d2 = tuple((a * a / w).sum(-1))
    ok = [i for i, d in enumerate(d2) if d < chi2(zs.shape[-1]).ppf(confidence)]
    if len(ok) != 1:
        return None, d2
    return float(ok[0]), d2


# --- 07.2 mutual_nearest ---


@answer_to("07.2", hint="not None")
def none_for_no_pair(D, limit):
    return [None if j < 0 else int(j) for j in mutual_nearest(D, limit)]


@answer_to("07.2", hint="-1|entry for each")
def only_the_pairs(D, limit):
    return [int(j) for j in mutual_nearest(D, limit) if j >= 0]


@answer_to("07.2", hint="entry for each|shape")
def list_of_pairs(D, limit):
    return [(i, int(j)) for i, j in enumerate(mutual_nearest(D, limit)) if j >= 0]


@answer_to("07.2", hint="counted from 0|must be \\[1, 0, 2\\]")
def counted_from_one(D, limit):
    j = mutual_nearest(D, limit)
    return np.where(j >= 0, j + 1, -1)


@answer_to("07.2", hint="root|squared|limit")
def root_of_the_distances(D, limit):
    return mutual_nearest(np.sqrt(D), limit)


@answer_to("07.2", hint="least|second best|nearer|must be")
def hungarian(D, limit):
    j = np.full(len(D), -1)
    for i, a in zip(*scipy.optimize.linear_sum_assignment(D), strict=True):
        if D[i, a] <= limit:
            j[i] = a
    return j


@answer_to("07.2", hint="empty|nothing|argmin|no landmark")
def argmin_of_nothing(D, limit):
    j = np.argmin(D, axis=1)
    back = np.argmin(D, axis=0)
    return np.where((back[j] == np.arange(len(D))) & (D.min(1) <= limit), j, -1)


@answer_to("07.2", hint="gate|too far|limit")
def gate_by_the_mean(D, limit):
    return mutual_nearest(D, np.mean(D) if np.size(D) else limit)


@answer_to("07.2", hint="changes its input")
def crosses_out_in_place(D, limit):
    j = np.full(len(D), -1)
    while np.size(D) and D.min() <= limit:
        i, a = np.unravel_index(np.argmin(D), D.shape)
        j[i] = a
        D[i], D[:, a] = np.inf, np.inf
    return j


@answer_to("07.2", right=True)
def dictionary_of_the_landmarks(D, limit):
    k, n = D.shape
    wants = {a: min(range(k), key=lambda i: D[i, a]) for a in range(n)} if k else {}
    j = []
    for i in range(k):
        near = min(range(n), key=lambda a: D[i, a], default=-1)
        j.append(near if near >= 0 and wants[near] == i and D[i, near] <= limit else -1)
    return j


@answer_to("07.2", right=True)
def infinity_appended(D, limit):
    k, n = np.shape(D)
    E = np.full((k + 1, n + 1), np.inf)
    E[:k, :n] = D
    E[:k, n] = np.nextafter(limit, np.inf)
    near, back = E[:k].argmin(1), E.argmin(0)
    return np.array([a if a < n and back[a] == i else -1 for i, a in enumerate(near)], dtype=float)


@answer_to("07.2", right=True)
def ranks_of_rows_and_columns(D, limit):
    D = np.asarray(D)
    rows, columns = D.argsort(1).argsort(1), D.argsort(0).argsort(0)
    out = -np.ones(D.shape[0], int)
    for i, a in np.argwhere((rows == 0) & (columns == 0) & (D <= limit)):
        out[i] = a
    return tuple(out.tolist())


# --- 07.3 jointly_compatible ---


@answer_to("07.3", hint="joint distance|stacked|d2")
def sum_of_single_distances(zs, Hs, P, R, confidence):
    d2 = sum(z @ np.linalg.solve(H @ P @ H.T + R, z) for z, H in zip(zs, Hs, strict=True))
    Z = jointly_compatible(zs, Hs, P, R, confidence)[2]
    return d2 <= chi2.ppf(confidence, 2 * len(zs)), d2, Z


@answer_to("07.3", hint="joint d2")
def every_pair_passes_its_own_gate(zs, Hs, P, R, confidence):
    _, d2, Z = jointly_compatible(zs, Hs, P, R, confidence)
    single = [z @ np.linalg.solve(H @ P @ H.T + R, z) for z, H in zip(zs, Hs, strict=True)]
    return max(single) <= chi2.ppf(confidence, 2), d2, Z


@answer_to("07.3", hint="2 ?m|limit|quantile")
def m_degrees_of_freedom(zs, Hs, P, R, confidence):
    _, d2, Z = jointly_compatible(zs, Hs, P, R, confidence)
    return d2 <= chi2.ppf(confidence, len(zs)), d2, Z


@answer_to("07.3", hint="True or False")
def probability_for_ok(zs, Hs, P, R, confidence):
    _, d2, Z = jointly_compatible(zs, Hs, P, R, confidence)
    return chi2.cdf(d2, 2 * len(zs)), d2, Z


@answer_to("07.3", hint="shape|pair")
def list_of_blocks(zs, Hs, P, R, confidence):
    ok, d2, _ = jointly_compatible(zs, Hs, P, R, confidence)
    return ok, d2, [H @ P @ H.T + R for H in Hs]


@answer_to("07.3", hint="\\bR\\b|pair|kron")
def R_divided_by_the_pairs(zs, Hs, P, R, confidence):
    return jointly_compatible(zs, Hs, P, R / len(zs), confidence)


@answer_to("07.3", hint="order|stack|d2|z' inv")
def ranges_first_then_bearings(zs, Hs, P, R, confidence):
    _, _, Z = jointly_compatible(zs, Hs, P, R, confidence)
    z = np.asarray(zs).T.ravel()
    d2 = z @ np.linalg.solve(Z, z)
    return d2 <= chi2.ppf(confidence, len(z)), d2, Z


@answer_to("07.3", hint="P|H P H|diagonal")
def covariance_of_the_landmarks_only(zs, Hs, P, R, confidence):
    Q = P.copy()
    Q[:3, 3:], Q[3:, :3] = 0, 0
    return jointly_compatible(zs, Hs, Q, R, confidence)


@answer_to("07.3", hint="number|shape|d2")
def d2_as_a_matrix(zs, Hs, P, R, confidence):
    ok, d2, Z = jointly_compatible(zs, Hs, P, R, confidence)
    return ok, np.array([[d2]]), Z


@answer_to("07.3", right=True)
def block_by_block(zs, Hs, P, R, confidence):
    m = len(zs)
    Z = np.zeros((2 * m, 2 * m))
    for i in range(m):
        for j in range(m):
            Z[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = Hs[i] @ P @ np.transpose(Hs[j]) + (i == j) * R
    w = np.linalg.solve(np.linalg.cholesky(Z), np.ravel(zs))
    return bool(w @ w < chi2.isf(1 - confidence, 2 * m)), np.sum(w**2), Z


@answer_to("07.3", right=True)
def block_diag_and_inverse(zs, Hs, P, R, confidence):
    H = Hs.reshape(-1, Hs.shape[-1])
    Z = H @ P @ H.T + scipy.linalg.block_diag(*[R] * len(zs))
    z = zs.reshape(-1, 1)
    d2 = (z.T @ np.linalg.inv(Z) @ z).item()
    return chi2.cdf(d2, z.size) <= confidence, d2, Z.tolist()


@answer_to("07.3", right=True)
def one_pair_after_the_other(zs, Hs, P, R, confidence):
    """Condition each pair on those before it: the distances add up."""
    _, _, Z = jointly_compatible(zs, Hs, P, R, confidence)
    x, Q, d2 = np.zeros(len(P)), np.array(P), 0.0
    for z, H in zip(zs, Hs, strict=True):
        S = H @ Q @ H.T + R
        v = z - H @ x
        K = Q @ H.T @ np.linalg.inv(S)
        d2 += v @ np.linalg.solve(S, v)
        x, Q = x + K @ v, Q - K @ S @ K.T
    return np.bool_(d2 <= chi2.ppf(confidence, 2 * len(zs))), d2, Z


# --- 07.4 new_ones ---


@answer_to("07.4", hint="all|every")
def far_from_the_first_landmark(ys, es, Es, R, confidence):
    _, D = new_ones(ys, es, Es, R, confidence)
    return [i for i in range(len(ys)) if not len(es) or D[i, 0] > chi2.ppf(confidence, 2)], D


@answer_to("07.4", hint="every|all|mean")
def far_on_the_average(ys, es, Es, R, confidence):
    _, D = new_ones(ys, es, Es, R, confidence)
    return [i for i in range(len(ys)) if not len(es) or D[i].mean() > chi2.ppf(confidence, 2)], D


@answer_to("07.4", hint="empty map|no landmark|zero-size|every measurement is new")
def minimum_of_nothing(ys, es, Es, R, confidence):
    _, D = new_ones(ys, es, Es, R, confidence)
    return [i for i in range(len(ys)) if D[i].min() > chi2.ppf(confidence, 2)], D


@answer_to("07.4", hint="shape|k x n|table|transpose")
def table_transposed(ys, es, Es, R, confidence):
    new, D = new_ones(ys, es, Es, R, confidence)
    return new, D.T


@answer_to("07.4", hint="inv|Z")
def covariances_multiplied(ys, es, Es, R, confidence):
    D = np.zeros((len(ys), len(es)))
    for i, y in enumerate(ys):
        for j, e in enumerate(es):
            z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
            D[i, j] = z @ np.linalg.inv(Es[j] @ R) @ z
    return [i for i in range(len(ys)) if all(D[i] > chi2.ppf(confidence, 2))], D


@answer_to("07.4", hint="E_j|Z|distances")
def first_covariance_for_all(ys, es, Es, R, confidence):
    return new_ones(ys, es, np.array([Es[0]] * len(Es)) if len(Es) else Es, R, confidence)


@answer_to("07.4", hint="list|indices")
def a_set(ys, es, Es, R, confidence):
    new, D = new_ones(ys, es, Es, R, confidence)
    return {i: ys[i] for i in new}, D


@answer_to("07.4", hint="indices|list")
def measurements_not_indices(ys, es, Es, R, confidence):
    new, D = new_ones(ys, es, Es, R, confidence)
    return ys[new], D


@answer_to("07.4", hint="z = y_i - e_j")
def wrapped_with_abs(ys, es, Es, R, confidence):
    D = np.zeros((len(ys), len(es)))
    for i, y in enumerate(ys):
        for j, e in enumerate(es):
            z = np.array([y[0] - e[0], abs(y[1] - e[1])])
            z[1] = min(z[1], 2 * np.pi - z[1])
            D[i, j] = z @ np.linalg.solve(Es[j] + R, z)
    return [i for i in range(len(ys)) if all(D[i] > chi2.ppf(confidence, 2))], D


@answer_to("07.4", hint="confidence|chi2.ppf")
def fixed_gate(ys, es, Es, R, confidence):
    _, D = new_ones(ys, es, Es, R, confidence)
    return [i for i in range(len(ys)) if all(D[i] > 9.21)], D


@answer_to("07.4", right=True)
def masked_minimum(ys, es, Es, R, confidence):
    D = np.full((len(ys), len(es)), np.nan)
    for j in range(len(es)):
        z = np.array(ys) - es[j]
        z[:, 1] = np.arctan2(np.sin(z[:, 1]), np.cos(z[:, 1]))
        D[:, j] = np.einsum("ki,ij,kj->k", z, np.linalg.inv(Es[j] + R), z)
    old = (D <= chi2.ppf(confidence, 2)).any(axis=1)
    return np.where(~old)[0], D


@answer_to("07.4", right=True)
def while_loop_and_tuples(ys, es, Es, R, confidence):
    new, table, i = (), [], 0
    while i < len(ys):
        row = []
        for e, E in zip(es, Es, strict=True):
            z = np.subtract(ys[i], e)
            z[1] -= 2 * np.pi * round(z[1] / (2 * np.pi))
            row.append(float(np.dot(z, np.linalg.pinv(E + R).dot(z))))
        if not any(d <= chi2(2).ppf(confidence) for d in row):
            new += (i,)
        table.append(row)
        i += 1
    return new, np.array(table).reshape(len(ys), len(es))


@answer_to("07.4", right=True)
def exponential_limit(ys, es, Es, R, confidence):
    _, D = new_ones(ys, es, Es, R, confidence)
    return [i for i, row in enumerate(D) if (row > -2 * np.log(1 - confidence)).all()], D


# --- right answers in other words ---


@answer_to("07.1", right=True)
def with_the_inverse_a_loop_lists(zs, Zs, confidence):
    d2, inside = [], []
    for i, (z, Z) in enumerate(zip(zs, Zs, strict=True)):
        d2.append(float(z @ np.linalg.inv(Z) @ z))
        if d2[-1] < chi2.ppf(confidence, len(z)):
            inside.append(i)
    return (inside[0] if len(inside) == 1 else None), d2


@answer_to("07.1", right=True)
def probabilities_instead_of_limits(zs, Zs, confidence):
    d2 = np.einsum("ni,nij,nj->n", zs, np.linalg.inv(Zs), zs)
    ok = chi2.cdf(d2, np.shape(zs)[-1]) <= confidence
    return (np.argmax(ok) if ok.sum() == 1 else None), d2


@answer_to("07.1", right=True)
def cholesky_factors(zs, Zs, confidence):
    d2 = np.sum(np.linalg.solve(np.linalg.cholesky(Zs), np.asarray(zs)[..., None])[..., 0] ** 2, -1)
    i = [k for k in range(len(d2)) if d2[k] <= chi2.ppf(confidence, zs.shape[1])]
    return (i[0], d2) if len(i) == 1 else (None, d2)


def joint_Z(Hs, P, R):
    m = range(len(Hs))
    return np.block([[Hs[i] @ P @ Hs[j].T + (R if i == j else 0) for j in m] for i in m])


@answer_to("07.3", right=True)
def block_by_block_plain_types(zs, Hs, P, R, confidence):
    Z = joint_Z(Hs, P, R)
    z = np.ravel(zs)
    d2 = float(z @ np.linalg.inv(Z) @ z)
    return bool(chi2.cdf(d2, 2 * len(zs)) <= confidence), d2, Z.tolist()


@answer_to("07.3", right=True)
def pair_by_pair_conditional_distances(zs, Hs, P, R, confidence):
    Z, z, d2 = joint_Z(Hs, P, R), np.ravel(zs), 0.0
    for i in range(0, len(z), 2):
        K = np.linalg.solve(Z[:i, :i], Z[:i, i : i + 2]).T if i else np.zeros((2, 0))
        w = z[i : i + 2] - K @ z[:i]
        d2 += w @ np.linalg.solve(Z[i : i + 2, i : i + 2] - K @ Z[:i, i : i + 2], w)
    return d2 < chi2.ppf(confidence, z.size), d2, Z


@answer_to("07.2", hint="used twice")  # by two measurements that are just as near
def with_masks_list(D, limit):
    D = np.asarray(D)
    if not D.size:
        return [-1] * len(D)
    ok = (D == D.min(1, keepdims=True)) & (D == D.min(0, keepdims=True)) & (D <= limit)
    return np.where(ok.any(1), ok.argmax(1), -1).tolist()


@answer_to("07.2", hint="used twice")  # by two measurements that are just as near
def loops_over_all_pairs(D, limit):
    k, n = len(D), len(D[0]) if len(D) else 0
    j = []
    for i in range(k):
        best = -1
        for a in range(n):
            row = all(D[i][a] <= D[i][b] for b in range(n))
            if row and all(D[i][a] <= D[c][a] for c in range(k)) and D[i][a] <= limit:
                best = a
        j.append(best)
    return j


@answer_to("07.4", right=True)
def all_at_once_with_einsum(ys, es, Es, R, confidence):
    z = np.asarray(ys)[:, None] - np.asarray(es)[None]
    z[..., 1] = (z[..., 1] + np.pi) % (2 * np.pi) - np.pi
    D = np.einsum("kni,nij,knj->kn", z, np.linalg.inv(Es + R), z)
    return np.flatnonzero(D.min(1, initial=np.inf) > chi2.ppf(confidence, 2)), D


@answer_to("07.4", right=True)
def loops_lists_probabilities(ys, es, Es, R, confidence):
    if not len(es):
        return list(range(len(ys))), np.zeros((len(ys), 0))
    D = []
    for y in ys:
        zs = [np.array([y[0] - e[0], wrap(y[1] - e[1])]) for e in es]
        D.append([float(z @ np.linalg.inv(E + R) @ z) for z, E in zip(zs, Es, strict=True)])
    return [i for i, row in enumerate(D) if min(row) > chi2.ppf(confidence, 2)], D


@answer_to("07.2", hint="argmin.*without an axis")
def nearest_of_the_whole_table(D, limit):
    j = np.full(len(D), -1)
    for i in range(len(D)):
        best = int(D.argmin())
        if D[i, best] <= limit:
            j[i] = best
    return j


test_the_check_is_right_about_it = check_of(__name__)
