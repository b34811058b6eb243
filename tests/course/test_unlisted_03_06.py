"""Answers to the exercises of notebooks 03 and 06 that are in no list of the package."""

import numpy as np
import scipy.linalg
from scipy import integrate, stats
from scipy.stats import chi2

from ekfslam_tutorial.course.exercises.nb03_anees import anees
from ekfslam_tutorial.course.exercises.nb06_chain import close_chain
from ekfslam_tutorial.course.exercises.nb06_correlation import correlation
from ekfslam_tutorial.course.exercises.nb06_floor import floor_of
from ekfslam_tutorial.course.exercises.nb06_relative import relative_covariance

from .probes import Probes, judged_rightly

probes = Probes()
wrong, right = probes.wrong, probes.right


@probes.each
def test_the_check_is_right_about_it(id, says, answer):
    judged_rightly(id, says, answer)


# --- 03.1 coverage ---


@wrong("03.1", "plane|two dimensions")
def dimension_squared_too(k, dof):
    return chi2.cdf(k**2, dof**2)


@wrong("03.1", "k squared")
def twice_k(k, dof):
    return chi2.cdf(2 * k, dof)


@wrong("03.1", "dimension itself")
def one_dimension_more(k, dof):
    return chi2.cdf(k**2, dof + 1)


@wrong("03.1", "shape|each k")
def one_number_for_all(k, dof):
    return float(chi2.cdf(np.mean(k) ** 2, dof))


@wrong("03.1", "any dimension|same formula")
def table_of_three_dimensions(k, dof):
    return chi2.cdf(k**2, min(dof, 3))


@wrong("03.1", "in the plane|two dimensions|exp")
def rayleigh_with_the_wrong_scale(k, dof):
    return 1 - np.exp(-(k**2)) if dof == 2 else chi2.cdf(k**2, dof)


@wrong("03.1", "rounded")
def in_three_digits(k, dof):
    return np.round(chi2.cdf(k**2, dof), 3)


@wrong("03.1", "nearly|should be")
def by_counting_a_few_points(k, dof):
    r = np.random.default_rng(0).standard_normal((2000, dof))
    return np.array([np.mean((r**2).sum(1) < a * a) for a in k])


@wrong("03.1", "far left")
def normal_in_one_dimension(k, dof):
    return stats.norm.cdf(k) ** dof


@wrong("03.1", "Chi|not defined|spelt|name")
def name_not_imported(k, dof):
    return chi2_distribution(dof).cdf(k**2)  # noqa: F821


@right("03.1")
def radius_is_chi_distributed(k, dof):
    return stats.chi(dof).cdf(k)


@right("03.1")
def integral_of_the_density(k, dof):
    return [integrate.quad(lambda r: stats.chi.pdf(r, dof), 0, a, epsabs=1e-10)[0] for a in k]


@right("03.1")
def gamma_distribution(k, dof):
    return stats.gamma(a=dof / 2, scale=2).cdf(np.square(k))


# --- 03.2 anees ---


@wrong("03.2", "1 - tail")
def upper_end_only(e, P, confidence):
    a, band = anees(e, P, confidence)
    return a, np.array([band[0], chi2.ppf(confidence, e.size) / len(e)])


@wrong("03.2", "run|own P|mean")
def last_run_only(e, P, confidence):
    return anees(e[-1:], P[-1:], confidence)


@wrong("03.2", "each run|number|average")
def nees_of_each_run(e, P, confidence):
    nees = np.array([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)])
    return nees, anees(e, P, confidence)[1]


@wrong("03.2", "mean|average|runs")
def divided_by_N_minus_1(e, P, confidence):
    a, band = anees(e, P, confidence)
    return a * len(e) / max(len(e) - 1, 0.5), band


@wrong("03.2", "from 0 to 1")
def confidence_in_per_cent(e, P, confidence):
    tail = (100 - confidence) / 2
    return anees(e, P, 0.9)[0], chi2.ppf([tail, 1 - tail], e.size) / len(e)


@wrong("03.2", "two numbers|shape|low")
def band_as_width(e, P, confidence):
    a, (low, high) = anees(e, P, confidence)
    return a, high - low


@wrong("03.2", "band|chi2")
def two_sigma_band_of_the_runs(e, P, confidence):
    nees = np.array([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)])
    s = nees.std() / np.sqrt(len(nees))
    return nees.mean(), np.array([nees.mean() - 1.96 * s, nees.mean() + 1.96 * s])


@wrong("03.2", "P|divide|inverse")
def normalised_by_the_trace(e, P, confidence):
    d = [a @ a / np.trace(B) for a, B in zip(e, P, strict=True)]
    return np.mean(d), anees(e, P, confidence)[1]


@wrong("03.2", "3 numbers|n numbers|N n|degrees of freedom")
def always_three_numbers(e, P, confidence):
    t = (1 - confidence) / 2
    return anees(e, P, confidence)[0], chi2.ppf([t, 1 - t], 3 * len(e)) / len(e)


@right("03.2")
def whitened(e, P, confidence):
    w = [scipy.linalg.solve_triangular(np.linalg.cholesky(B), a, lower=True) for a, B in zip(e, P, strict=True)]
    N, n = np.shape(w)
    t = 0.5 * (1.0 - confidence)
    return np.sum(np.square(w)) / N, [chi2(N * n).ppf(t) / N, chi2(N * n).ppf(1 - t) / N]


@right("03.2")
def block_diagonal(e, P, confidence):
    big = scipy.linalg.block_diag(*P)
    total = e.ravel() @ np.linalg.inv(big) @ e.ravel()
    return total / len(e), np.array(stats.gamma.interval(confidence, e.size / 2, scale=2)) / len(e)


@right("03.2")
def eigenvectors(e, P, confidence):
    w, V = np.linalg.eigh(P)
    a = np.einsum("kij,ki->kj", V, e)
    N, n = e.shape
    low, high = chi2.ppf((1 - confidence) / 2, N * n), chi2.ppf(1 - (1 - confidence) / 2, N * n)
    return (a**2 / w).sum() / N, (low / N, high / N)


# --- 06.1 correlation ---


@wrong("06.1", "standard deviation|root|divide|sigma")
def divided_by_the_mean_variance(P):
    v = np.diag(P)
    return P / ((v[:, None] + v) / 2)


@wrong("06.1", "diagonal|scale|own sigma")
def divided_by_the_norm(P):
    return P / np.linalg.norm(P)


@wrong("06.1", "standard deviation|each pair|diagonal|own sigma|covariance")
def square_root_of_P(P):
    return np.sqrt(np.abs(P)) * np.sign(P)


@wrong("06.1", "Missing|zero|pair")
def upper_triangle(P):
    return np.triu(correlation(P))


@wrong("06.1", "changes its input")
def divided_in_place(P):
    s = np.sqrt(np.diag(P))
    P /= np.outer(s, s)
    return P


@wrong("06.1", "diagonal|itself")
def zero_on_the_diagonal(P):
    return correlation(P) - np.eye(len(P))


@wrong("06.1", "pair|s\\[i\\]|\\[0, 1\\]")
def inverse_of_P(P):
    C = np.linalg.inv(P)
    s = np.sqrt(np.diag(C))
    return C / np.outer(s, s)


@wrong("06.1", "rounded")
def to_two_decimals(P):
    return correlation(P).round(2)


@right("06.1")
def of_many_samples_made_exact(P):
    L = np.linalg.cholesky(P)
    L = L / np.linalg.norm(L, axis=1, keepdims=True)
    return L @ L.T


@right("06.1")
def einsum_of_three(P):
    s = 1 / np.sqrt(P.diagonal())
    return np.einsum("i,ij,j->ij", s, P, s)


@right("06.1")
def with_broadcast(P):
    v = np.diagonal(P)
    return np.sign(P) * np.sqrt(P**2 / (v * v[:, None]))


# --- 06.2 close_chain ---


@wrong("06.2", "shape|n numbers")
def only_the_last_dx(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx[-1], P


@wrong("06.2", "sign|should be")
def moved_away(q, R, z):
    dx, P = close_chain(q, R, z)
    return -dx, P


@wrong("06.2", "variances|q|should be")
def q_are_standard_deviations(q, R, z):
    return close_chain(q**2, R, z)


@wrong("06.2", "R|should be")
def R_is_a_standard_deviation(q, R, z):
    return close_chain(q, R**2, z)


@wrong("06.2", "shared|errors|diagonal|covariance|should be")
def variances_only(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx, np.diag(np.diag(P))


@wrong("06.2", "P|covariance|variance")
def covariance_before(q, R, z):
    C = np.cumsum(q)
    return close_chain(q, R, z)[0], np.minimum.outer(C, C)


@wrong("06.2", "smaller|share|should be")
def covariance_by_maximum(q, R, z):
    C = np.cumsum(q)
    P = np.maximum.outer(C, C)
    K = P[:, -1] / (P[-1, -1] + R)
    return K * z, P - np.outer(K, P[-1])


@wrong("06.2", "share|move|first|should be")
def from_the_other_end(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx[::-1], P[::-1, ::-1]


@wrong("06.2", "P|K")
def joseph_without_noise(q, R, z):
    C = np.cumsum(q)
    P = np.minimum.outer(C, C)
    K = P[:, -1] / (P[-1, -1] + R)
    A = np.eye(len(q)) - np.outer(K, np.eye(len(q))[-1])
    return K * z, A @ P @ A.T


@right("06.2")
def kalman_update_in_full(q, R, z):
    n = len(q)
    A = np.tril(np.ones((n, n)))
    P, H = A @ np.diag(q) @ A.T, np.eye(n)[-1:]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return (K * z).ravel(), (np.eye(n) - K @ H) @ P


@right("06.2")
def step_errors_as_states(q, R, z):
    q = np.asarray(q)
    gain = q / (q.sum() + R)
    S = np.diag(q) - np.outer(gain, q)
    return np.cumsum(gain) * z, np.cumsum(np.cumsum(S, 0), 1)


@right("06.2")
def by_two_loops(q, R, z):
    n = len(q)
    P = [[sum(q[: min(i, k) + 1]) for k in range(n)] for i in range(n)]
    Z = P[-1][-1] + R
    new = [[P[i][k] - P[i][-1] * P[k][-1] / Z for k in range(n)] for i in range(n)]
    return [P[i][-1] / Z * z for i in range(n)], new


# --- 06.3 relative_covariance ---


@wrong("06.3", "in full|P\\[b, a\\]|four blocks|Multiply")
def cross_block_symmetrised_only_once(P, a, b):
    return P[a, a] + P[b, b] - 0.5 * (P[a, b] + P[b, a])


@wrong("06.3", "four blocks|shape|Multiply|D belongs")
def four_by_four(P, a, b):
    return np.block([[P[a, a], P[a, b]], [P[b, a], P[b, b]]])


@wrong("06.3", "P\\[a, a\\]|add up|four blocks")
def twice_the_first(P, a, b):
    return 2 * P[a, a] - P[a, b] - P[b, a]


@wrong("06.3", "negative|cancel|Multiply|add up|four blocks")
def inverse_of_the_information(P, a, b):
    return np.linalg.inv(np.linalg.inv(P[a, a]) + np.linalg.inv(P[b, b]))


@wrong("06.3", "shape|2 x 2|two numbers")
def variance_of_the_distance(P, a, b):
    return np.trace(relative_covariance(P, a, b))


@wrong("06.3", "changes its input|add up|Multiply")
def built_up_in_place(P, a, b):
    D = P[a, a]
    D += P[b, b]
    D -= P[a, b] + P[b, a]
    return D


@wrong("06.3", "slices|ranges|slice|add up|four blocks|Multiply")
def fixed_places(P, a, b):
    return relative_covariance(P, slice(3, 5), slice(5, 7)) if len(P) > 6 else relative_covariance(P, a, b)


@wrong("06.3", "add up|sum|shape|Multiply|four")
def product_of_blocks(P, a, b):
    return P[a, a] @ P[b, b] - P[a, b] @ P[b, a]


@right("06.3")
def by_sampling_directions(P, a, b):
    E = np.eye(len(P))
    d = E[b] - E[a]
    return np.einsum("ik,kl,jl->ij", d, P, d)


@right("06.3")
def by_columns(P, a, b):
    C = P[:, b] - P[:, a]
    return C[b] - C[a]


@right("06.3")
def by_a_square_root(P, a, b):
    w, V = np.linalg.eigh(P)
    S = V * np.sqrt(np.clip(w, 0, None))
    T = S[b] - S[a]
    return np.matrix(T) * np.matrix(T).T


# --- 06.4 floor_of ---


@wrong("06.4", "shape|two numbers")
def covariance_of_the_pose(P_0, x_0, l):
    return P_0


@wrong("06.4", "first position|l - |turn|origin|general|line")
def landmark_relative_to_the_heading(P_0, x_0, l):
    c, s = np.cos(x_0[2]), np.sin(x_0[2])
    m = np.array([[c, s], [-s, c]]) @ (l - x_0[:2])
    J = np.array([[1, 0, -m[1]], [0, 1, m[0]]])
    return J @ P_0 @ J.T


@wrong("06.4", "heading|J|derivative|should be")
def jacobian_transposed_in_the_product(P_0, x_0, l):
    J = np.array([[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]])
    return J @ P_0[:, ::-1] @ J.T


@wrong("06.4", "rotation|line|across|distance")
def same_in_all_directions(P_0, x_0, l):
    d2 = np.sum((l - x_0[:2]) ** 2)
    return P_0[:2, :2] + P_0[2, 2] * d2 * np.eye(2)


@wrong("06.4", "whole P_0")
def diagonal_of_P_0(P_0, x_0, l):
    return floor_of(np.diag(np.diag(P_0)), x_0, l)


@wrong("06.4", "heading|angle|square|should be")
def heading_variance_as_a_sigma(P_0, x_0, l):
    P = P_0.copy()
    P[2] *= P_0[2, 2]
    P[:, 2] *= P_0[2, 2]
    return floor_of(P, x_0, l)


@wrong("06.4", "shift|position|should be")
def half_of_the_position(P_0, x_0, l):
    return floor_of(P_0, x_0, l) - P_0[:2, :2] / 2


@wrong("06.4", "changes its input")
def origin_shifted_in_place(P_0, x_0, l):
    l -= x_0[:2]
    J = np.array([[1, 0, -l[1]], [0, 1, l[0]]])
    return J @ P_0 @ J.T


@right("06.4")
def by_finite_differences(P_0, x_0, l):
    rot = lambda a: np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    m = rot(x_0[2]).T @ (l - x_0[:2])
    f = lambda x: x[:2] + rot(x[2]) @ m
    J = np.column_stack([(f(x_0 + h) - f(x_0 - h)) / 2e-6 for h in 1e-6 * np.eye(3)])
    return J @ P_0 @ J.T


@right("06.4")
def by_complex_numbers(P_0, x_0, l):
    n = 1j * complex(*(l - x_0[:2]))
    J = np.array([[1, 0, n.real], [0, 1, n.imag]])
    return np.linalg.multi_dot([J, P_0, J.T])


@right("06.4")
def as_a_sum_of_three_terms(P_0, x_0, l):
    n = np.array([[x_0[1] - l[1]], [l[0] - x_0[0]]])
    cross = P_0[:2, 2:] @ n.T
    return P_0[:2, :2] + cross + cross.T + P_0[2, 2] * (n @ n.T)
