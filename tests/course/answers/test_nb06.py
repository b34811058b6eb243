"""Answers to the exercises of notebook 06 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np

from ekfslam_tutorial.course.exercises.nb06_chain import close_chain
from ekfslam_tutorial.course.exercises.nb06_correlation import correlation
from ekfslam_tutorial.course.exercises.nb06_floor import floor_of
from ekfslam_tutorial.course.exercises.nb06_relative import relative_covariance

from .collector import answer_to, check_of

# --- 06.1 correlation ---


@answer_to("06.1", hint="standard deviation|root|divide|sigma")
def divided_by_the_mean_variance(P):
    v = np.diag(P)
    return P / ((v[:, None] + v) / 2)


@answer_to("06.1", hint="diagonal|scale|own sigma")
def divided_by_the_norm(P):
    return P / np.linalg.norm(P)


@answer_to("06.1", hint="standard deviation|each pair|diagonal|own sigma|covariance")
def square_root_of_P(P):
    return np.sqrt(np.abs(P)) * np.sign(P)


@answer_to("06.1", hint="Missing|zero|pair")
def upper_triangle(P):
    return np.triu(correlation(P))


@answer_to("06.1", hint="changes its input")
def divided_in_place(P):
    s = np.sqrt(np.diag(P))
    P /= np.outer(s, s)
    return P


@answer_to("06.1", hint="diagonal|itself")
def zero_on_the_diagonal(P):
    return correlation(P) - np.eye(len(P))


@answer_to("06.1", hint="pair|s\\[i\\]|\\[0, 1\\]")
def inverse_of_P(P):
    C = np.linalg.inv(P)
    s = np.sqrt(np.diag(C))
    return C / np.outer(s, s)


@answer_to("06.1", hint="rounded")
def to_two_decimals(P):
    return correlation(P).round(2)


@answer_to("06.1", right=True)
def of_many_samples_made_exact(P):
    L = np.linalg.cholesky(P)
    L = L / np.linalg.norm(L, axis=1, keepdims=True)
    return L @ L.T


@answer_to("06.1", right=True)
def einsum_of_three(P):
    s = 1 / np.sqrt(P.diagonal())
    return np.einsum("i,ij,j->ij", s, P, s)


@answer_to("06.1", right=True)
def with_broadcast(P):
    v = np.diagonal(P)
    return np.sign(P) * np.sqrt(P**2 / (v * v[:, None]))


# --- 06.2 close_chain ---


@answer_to("06.2", hint="shape|n numbers")
def only_the_last_dx(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx[-1], P


@answer_to("06.2", hint="sign|should be")
def moved_away(q, R, z):
    dx, P = close_chain(q, R, z)
    return -dx, P


@answer_to("06.2", hint="variances|q|should be")
def q_are_standard_deviations(q, R, z):
    return close_chain(q**2, R, z)


@answer_to("06.2", hint="R|should be")
def R_is_a_standard_deviation(q, R, z):
    return close_chain(q, R**2, z)


@answer_to("06.2", hint="shared|errors|diagonal|covariance|should be")
def variances_only(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx, np.diag(np.diag(P))


@answer_to("06.2", hint="P|covariance|variance")
def covariance_before(q, R, z):
    C = np.cumsum(q)
    return close_chain(q, R, z)[0], np.minimum.outer(C, C)


@answer_to("06.2", hint="smaller|share|should be")
def covariance_by_maximum(q, R, z):
    C = np.cumsum(q)
    P = np.maximum.outer(C, C)
    K = P[:, -1] / (P[-1, -1] + R)
    return K * z, P - np.outer(K, P[-1])


@answer_to("06.2", hint="share|move|first|should be")
def from_the_other_end(q, R, z):
    dx, P = close_chain(q, R, z)
    return dx[::-1], P[::-1, ::-1]


@answer_to("06.2", hint="P|K")
def joseph_without_noise(q, R, z):
    C = np.cumsum(q)
    P = np.minimum.outer(C, C)
    K = P[:, -1] / (P[-1, -1] + R)
    A = np.eye(len(q)) - np.outer(K, np.eye(len(q))[-1])
    return K * z, A @ P @ A.T


@answer_to("06.2", right=True)
def kalman_update_in_full(q, R, z):
    n = len(q)
    A = np.tril(np.ones((n, n)))
    P, H = A @ np.diag(q) @ A.T, np.eye(n)[-1:]
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    return (K * z).ravel(), (np.eye(n) - K @ H) @ P


@answer_to("06.2", right=True)
def step_errors_as_states(q, R, z):
    q = np.asarray(q)
    gain = q / (q.sum() + R)
    S = np.diag(q) - np.outer(gain, q)
    return np.cumsum(gain) * z, np.cumsum(np.cumsum(S, 0), 1)


@answer_to("06.2", right=True)
def by_two_loops(q, R, z):
    n = len(q)
    P = [[sum(q[: min(i, k) + 1]) for k in range(n)] for i in range(n)]
    Z = P[-1][-1] + R
    new = [[P[i][k] - P[i][-1] * P[k][-1] / Z for k in range(n)] for i in range(n)]
    return [P[i][-1] / Z * z for i in range(n)], new


# --- 06.3 relative_covariance ---


@answer_to("06.3", hint="in full|P\\[b, a\\]|four blocks|Multiply")
def cross_block_symmetrised_only_once(P, a, b):
    return P[a, a] + P[b, b] - 0.5 * (P[a, b] + P[b, a])


@answer_to("06.3", hint="four blocks|shape|Multiply|D belongs")
def four_by_four(P, a, b):
    return np.block([[P[a, a], P[a, b]], [P[b, a], P[b, b]]])


@answer_to("06.3", hint="P\\[a, a\\]|add up|four blocks")
def twice_the_first(P, a, b):
    return 2 * P[a, a] - P[a, b] - P[b, a]


@answer_to("06.3", hint="negative|cancel|Multiply|add up|four blocks")
def inverse_of_the_information(P, a, b):
    return np.linalg.inv(np.linalg.inv(P[a, a]) + np.linalg.inv(P[b, b]))


@answer_to("06.3", hint="shape|2 x 2|two numbers")
def variance_of_the_distance(P, a, b):
    return np.trace(relative_covariance(P, a, b))


@answer_to("06.3", hint="changes its input|add up|Multiply")
def built_up_in_place(P, a, b):
    D = P[a, a]
    D += P[b, b]
    D -= P[a, b] + P[b, a]
    return D


@answer_to("06.3", hint="slices|ranges|slice|add up|four blocks|Multiply")
def fixed_places(P, a, b):
    return relative_covariance(P, slice(3, 5), slice(5, 7)) if len(P) > 6 else relative_covariance(P, a, b)


@answer_to("06.3", hint="add up|sum|shape|Multiply|four")
def product_of_blocks(P, a, b):
    return P[a, a] @ P[b, b] - P[a, b] @ P[b, a]


@answer_to("06.3", right=True)
def by_sampling_directions(P, a, b):
    E = np.eye(len(P))
    d = E[b] - E[a]
    return np.einsum("ik,kl,jl->ij", d, P, d)


@answer_to("06.3", right=True)
def by_columns(P, a, b):
    C = P[:, b] - P[:, a]
    return C[b] - C[a]


@answer_to("06.3", right=True)
def by_a_square_root(P, a, b):
    w, V = np.linalg.eigh(P)
    S = V * np.sqrt(np.clip(w, 0, None))
    T = S[b] - S[a]
    return np.matrix(T) * np.matrix(T).T


# --- 06.4 floor_of ---


@answer_to("06.4", hint="shape|two numbers")
def covariance_of_the_pose(P_0, x_0, l):
    return P_0


@answer_to("06.4", hint="first position|l - |turn|origin|general|line")
def landmark_relative_to_the_heading(P_0, x_0, l):
    c, s = np.cos(x_0[2]), np.sin(x_0[2])
    m = np.array([[c, s], [-s, c]]) @ (l - x_0[:2])
    J = np.array([[1, 0, -m[1]], [0, 1, m[0]]])
    return J @ P_0 @ J.T


@answer_to("06.4", hint="heading|J|derivative|should be")
def jacobian_transposed_in_the_product(P_0, x_0, l):
    J = np.array([[1, 0, -(l[1] - x_0[1])], [0, 1, l[0] - x_0[0]]])
    return J @ P_0[:, ::-1] @ J.T


@answer_to("06.4", hint="rotation|line|across|distance")
def same_in_all_directions(P_0, x_0, l):
    d2 = np.sum((l - x_0[:2]) ** 2)
    return P_0[:2, :2] + P_0[2, 2] * d2 * np.eye(2)


@answer_to("06.4", hint="whole P_0")
def diagonal_of_P_0(P_0, x_0, l):
    return floor_of(np.diag(np.diag(P_0)), x_0, l)


@answer_to("06.4", hint="heading|angle|square|should be")
def heading_variance_as_a_sigma(P_0, x_0, l):
    P = P_0.copy()
    P[2] *= P_0[2, 2]
    P[:, 2] *= P_0[2, 2]
    return floor_of(P, x_0, l)


@answer_to("06.4", hint="shift|position|should be")
def half_of_the_position(P_0, x_0, l):
    return floor_of(P_0, x_0, l) - P_0[:2, :2] / 2


@answer_to("06.4", hint="changes its input")
def origin_shifted_in_place(P_0, x_0, l):
    l -= x_0[:2]
    J = np.array([[1, 0, -l[1]], [0, 1, l[0]]])
    return J @ P_0 @ J.T


@answer_to("06.4", right=True)
def by_finite_differences(P_0, x_0, l):
    rot = lambda a: np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    m = rot(x_0[2]).T @ (l - x_0[:2])
    f = lambda x: x[:2] + rot(x[2]) @ m
    J = np.column_stack([(f(x_0 + h) - f(x_0 - h)) / 2e-6 for h in 1e-6 * np.eye(3)])
    return J @ P_0 @ J.T


@answer_to("06.4", right=True)
def by_complex_numbers(P_0, x_0, l):
    n = 1j * complex(*(l - x_0[:2]))
    J = np.array([[1, 0, n.real], [0, 1, n.imag]])
    return np.linalg.multi_dot([J, P_0, J.T])


@answer_to("06.4", right=True)
def as_a_sum_of_three_terms(P_0, x_0, l):
    n = np.array([[x_0[1] - l[1]], [l[0] - x_0[0]]])
    cross = P_0[:2, 2:] @ n.T
    return P_0[:2, :2] + cross + cross.T + P_0[2, 2] * (n @ n.T)


# --- right answers in other words ---


@answer_to("06.2", right=True)
def a_triangular_matrix_Joseph_form(q, R, z):
    n = len(q)
    L = np.tril(np.ones((n, n)))
    P, H = L @ np.diag(q) @ L.T, np.zeros((1, n))
    H[0, -1] = 1
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(n) - K @ H
    return (K * z).ravel(), A @ P @ A.T + K @ K.T * R


@answer_to("06.2", right=True)
def loops_and_lists(q, R, z):
    n = len(q)
    P = [[float(sum(q[: min(i, j) + 1])) for j in range(n)] for i in range(n)]
    K = [P[i][n - 1] / (P[n - 1][n - 1] + R) for i in range(n)]
    return [k * z for k in K], [[P[i][j] - K[i] * P[n - 1][j] for j in range(n)] for i in range(n)]


@answer_to("06.2", right=True)
def correct_the_steps_then_add_them_up(q, R, z):
    K = np.array(q) / (np.sum(q) + R)
    S = np.diag(q) - np.outer(K, q)
    return np.cumsum(K * z), np.cumsum(np.cumsum(S, 0), 1)


@answer_to("06.1", right=True)
def scaled_from_both_sides(P):
    D = np.diag(1 / np.sqrt(np.diag(P)))
    return D @ P @ D


@answer_to("06.1", right=True)
def two_loops_lists(P):
    n = len(P)
    return [[P[i][j] / (P[i][i] * P[j][j]) ** 0.5 for j in range(n)] for i in range(n)]


@answer_to("06.1", right=True)
def rows_then_columns(P):
    s = np.diag(P) ** 0.5
    return P / s / s[:, None]


@answer_to("06.4", right=True)
def with_the_frame_s_own_derivatives(P_0, x_0, l):
    m = np.array([[np.cos(x_0[2]), np.sin(x_0[2])], [-np.sin(x_0[2]), np.cos(x_0[2])]]) @ (l - x_0[:2])
    dR = np.array([[-np.sin(x_0[2]), -np.cos(x_0[2])], [np.cos(x_0[2]), -np.sin(x_0[2])]])
    J = np.column_stack([np.eye(2), dR @ m])
    return J @ P_0 @ J.T


@answer_to("06.4", right=True)
def written_out_lists(P_0, x_0, l):
    u, v = -(l[1] - x_0[1]), l[0] - x_0[0]
    a = P_0[0][0] + 2 * u * P_0[0][2] + u * u * P_0[2][2]
    b = P_0[0][1] + u * P_0[1][2] + v * P_0[0][2] + u * v * P_0[2][2]
    c = P_0[1][1] + 2 * v * P_0[1][2] + v * v * P_0[2][2]
    return [[a, b], [b, c]]


@answer_to("06.3", right=True)
def with_the_Jacobian_of_the_difference(P, a, b):
    J = np.zeros((2, len(P)))
    J[:, a], J[:, b] = -np.eye(2), np.eye(2)
    return J @ P @ J.T


@answer_to("06.3", right=True)
def the_other_way_round_lists(P, a, b):
    J = np.hstack([np.eye(2), -np.eye(2)])
    return (J @ np.block([[P[a, a], P[a, b]], [P[b, a], P[b, b]]]) @ J.T).tolist()


@answer_to("06.3", right=True)
def one_cross_block_and_its_transpose(P, a, b):
    return P[a, a] + P[b, b] - (P[a, b] + P[a, b].T)


test_the_check_is_right_about_it = check_of(__name__)
