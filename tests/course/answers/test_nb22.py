"""Answers to the exercises of notebook 22 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.linalg import null_space, orth, pinvh

from ekfslam_tutorial.course.exercises.nb22_birth import new_line
from ekfslam_tutorial.course.exercises.nb22_ends import extend
from ekfslam_tutorial.course.exercises.nb22_innovation import line_innovation
from ekfslam_tutorial.course.exercises.nb22_nees import line_nees
from ekfslam_tutorial.course.exercises.nb22_project import image_line
from ekfslam_tutorial.course.exercises.nb22_tidy import tidy_line
from ekfslam_tutorial.geometry import hat, unit
from ekfslam_tutorial.models.landmarks import PlkLin
from ekfslam_tutorial.models.landmarks.lines import abscissas, plane_base

from .collector import answer_to, check_of

# --- 22.1 the image of a line ---


@answer_to("22.1", right=True)
def by_two_points(F, l, k):
    """The image line is the cross product of the pixels of two points; its scale is then set right."""
    n, v = l[:3], l[3:]
    K = np.array([[k[2], 0, k[0]], [0, k[3], k[1]], [0, 0, 1]])
    p0 = np.cross(v, n) / (v @ v)
    images = [K @ F.R.T @ (p - F.t) for p in (p0, p0 + v)]
    J = (k[2] * k[3] * np.linalg.inv(K).T @ F.R.T) @ np.hstack([np.eye(3), -hat(F.t)])
    return np.cross(*images).tolist(), J.tolist()


@answer_to("22.1", right=True)
def by_the_inverse_of_k(F, l, k):
    K = np.diag([k[2], k[3], 1.0])
    K[:2, 2] = k[:2]
    M = k[2] * k[3] * np.linalg.inv(K).T @ F.R.T
    J = np.concatenate([M, M @ np.cross(np.eye(3), F.t).T], axis=1)  # the columns e_i x t are those of -hat(t)
    return J @ l, J


@answer_to("22.1", right=True)
def one_row_at_a_time(F, l, k):
    u0, v0, au, av = k
    r = F.R.T @ (l[:3] + np.cross(l[3:], F.t))
    rows = np.hstack([F.R.T, F.R.T @ np.array([np.cross(e, F.t) for e in np.eye(3)]).T])
    h = [av * r[0], au * r[1], -av * u0 * r[0] - au * v0 * r[1] + au * av * r[2]]
    return np.array(h), np.stack(
        [av * rows[0], au * rows[1], -av * u0 * rows[0] - au * v0 * rows[1] + au * av * rows[2]]
    )


@answer_to("22.1", hint="scale|K_L")
def of_length_one(F, l, k):
    h, H_l = image_line(F, l, k)
    return h / np.hypot(h[0], h[1]), H_l / np.hypot(h[0], h[1])


@answer_to("22.1", hint="shape|order")
def the_derivative_alone(F, l, k):
    h, H_l = image_line(F, l, k)
    return H_l, h


@answer_to("22.1", hint="n - t x v|place|normal|moved")
def place_of_the_camera_turned_twice(F, l, k):
    h, H_l = image_line(F, l, k)
    n = l[:3] - np.cross(F.R.T @ F.t, l[3:])
    return H_l[:, :3] @ n, H_l


@answer_to("22.1", hint="K_L|first row|centre")
def focal_lengths_are_one(F, l, k):
    return image_line(F, l, np.array([k[0], k[1], 1.0, 1.0]))


# --- 22.2 the distance of a segment from a line ---


@answer_to("22.2", right=True)
def in_one_stroke(y, h):
    q = np.column_stack([np.reshape(y, (2, 2)), np.ones(2)])
    L = np.sqrt(h[0] ** 2 + h[1] ** 2)
    z = q @ h / L
    return z, np.kron(np.eye(2), h[:2]) / L, q / L - np.outer(q @ h, [h[0], h[1], 0]) / L**3


@answer_to("22.2", right=True)
def through_the_unit_line(y, h):
    L = np.linalg.norm(h[:2])
    U = np.eye(3) / L - np.outer(h, np.append(h[:2], 0)) / L**3
    u = h / L
    Q = [[y[0], y[1], 1], [y[2], y[3], 1]]
    Z_y = [[u[0], u[1], 0, 0], [0, 0, u[0], u[1]]]
    return (np.array(Q) @ u).tolist(), Z_y, np.array(Q) @ U


@answer_to("22.2", right=True)
def by_differences(y, h):
    z = lambda y, h: (np.reshape(y, (2, 2)) @ h[:2] + h[2]) / np.hypot(*h[:2])
    d, s = 1e-5, 1e-6 * np.hypot(*h[:2])
    Z_y = np.array([(z(y + d * e, h) - z(y - d * e, h)) / (2 * d) for e in np.eye(4)]).T
    by = np.array([1, 1, 100.0])
    Z_h = np.array(
        [(z(y, h + s * w * e) - z(y, h - s * w * e)) / (2 * s * w) for w, e in zip(by, np.eye(3), strict=True)]
    )
    return z(y, h), Z_y, Z_h.T


@answer_to("22.2", hint="second end|end|v2")
def ends_exchanged(y, h):
    z, Z_y, Z_h = line_innovation(np.roll(y, 2), h)
    return z, np.roll(Z_y, 2, axis=1), Z_h


@answer_to("22.2", hint="shape|results")
def one_number(y, h):
    z, Z_y, Z_h = line_innovation(y, h)
    return np.linalg.norm(z), Z_y, Z_h


@answer_to("22.2", hint="sign|square|distance|L")
def squared_distances(y, h):
    z, Z_y, Z_h = line_innovation(y, h)
    return z**2, 2 * z[:, None] * Z_y, 2 * z[:, None] * Z_h


@answer_to("22.2", hint="L|px|columns")
def only_the_first_end_moves(y, h):
    z, Z_y, Z_h = line_innovation(y, h)
    Z_y[1] = 0
    return z, Z_y, Z_h


# --- 22.3 born from one segment ---


@answer_to("22.3", right=True)
def chain_of_big_matrices(camera, y, b):
    m, M_y = camera.retro(np.array(y))
    n, N_c = unit(np.cross(m[:3], m[3:]))
    N_m = np.concatenate([N_c @ hat(m[3:]).T, N_c @ hat(m[:3])], axis=1)
    e1, e2, E1_n, E2_n = plane_base(n)
    L_n = np.concatenate([np.eye(3), b[0] * E1_n + b[1] * E2_n])
    L_b = np.zeros((6, 2))
    L_b[3:, 0], L_b[3:, 1] = e1, e2
    return [*n, *(np.column_stack([e1, e2]) @ b)], L_n @ N_m @ M_y, L_b


@answer_to("22.3", right=True)
def as_the_package_does(camera, y, b):
    m, M_y = camera.retro(y)
    l, L_m, L_b = PlkLin().from_rays(m, b)
    return l, L_m @ M_y, L_b


@answer_to("22.3", right=True)
def ends_moved_a_little(camera, y, b):
    value = lambda y, b: new_line(camera, y, b)[0]
    d = 1e-4
    L_y = [(value(y + d * e, b) - value(y - d * e, b)) / (2 * d) for e in np.eye(4)]
    return value(y, b), np.array(L_y).T, np.array([value(y, e) - value(y, 0 * e) for e in np.eye(2)]).T


@answer_to("22.3", hint="pixel|plane|n|camera")
def rays_of_the_ideal_lens(camera, y, b):
    l, L_y, L_b = new_line(camera, y, b)
    u0, v0, au, av = camera.k
    m = [np.array([(u - u0) / au, (v - v0) / av, 1.0]) for u, v in np.reshape(y, (2, 2))]
    return np.concatenate([unit(np.cross(*m))[0], l[3:]]), L_y, L_b


@answer_to("22.3", hint="unit|length|measured")
def normal_and_direction_scaled(camera, y, b):
    l, L_y, L_b = new_line(camera, y, b)
    return 2 * l, 2 * L_y, 2 * L_b


@answer_to("22.3", hint="shape|transpose")
def derivatives_lying(camera, y, b):
    l, L_y, L_b = new_line(camera, y, b)
    return l, L_y.T, L_b.T


@answer_to("22.3", hint="prior|measured|plane")
def prior_has_no_effect(camera, y, b):
    l, L_y, L_b = new_line(camera, y, b)
    return l, L_y, 0 * L_b


# --- 22.4 the condition ---


@answer_to("22.4", right=True)
def by_double_cross_product(l, P):
    """v without its part along n is n x (v x n) / n'n."""
    n, v = np.split(np.array(l), 2)
    nn, d = n @ n, np.cross(n, np.cross(v, n)) / (n @ n)
    D_v = -hat(n) @ hat(n) / nn
    D_n = (-hat(np.cross(v, n)) + hat(n) @ hat(v)) / nn - 2 * np.outer(d, n) / nn
    J = np.eye(6)
    J[3:, :3], J[3:, 3:] = D_n, D_v
    return np.append(n, d), J @ P @ J.T


@answer_to("22.4", right=True)
def by_differences_again(l, P):
    f = lambda l: np.concatenate([l[:3], l[3:] - l[:3] * (l[:3] @ l[3:]) / (l[:3] @ l[:3])])
    J = np.array([(f(l + 1e-6 * e) - f(l - 1e-6 * e)) / 2e-6 for e in np.eye(6)]).T
    return f(l).tolist(), (J @ P @ J.T).tolist()


@answer_to("22.4", right=True)
def block_by_block(l, P):
    n, v = l[:3], l[3:]
    u, r = n / np.linalg.norm(n), np.linalg.norm(n)
    U_n = (np.eye(3) - np.outer(u, u)) / r
    D_n = -(np.outer(u, v) + (u @ v) * np.eye(3)) @ U_n
    D_v = np.eye(3) - np.outer(u, u)
    nv = P[:3, :3] @ D_n.T + P[:3, 3:] @ D_v.T
    vv = D_n @ P[:3, :3] @ D_n.T + D_v @ P[3:, 3:] @ D_v.T
    both = D_n @ P[:3, 3:] @ D_v.T
    return np.hstack([n, v - (u @ v) * u]), np.block([[P[:3, :3], nv], [nv.T, vv + both + both.T]])


@answer_to("22.4", hint="n stays|measured|way")
def half_each(l, P):
    n, v = l[:3], l[3:]
    s = n @ v
    return np.concatenate([n - s / (v @ v) * v / 2, v - s / (n @ n) * n / 2]), P


@answer_to("22.4", hint="length|n'n|stays")
def n_made_a_unit_vector(l, P):
    l, P = tidy_line(l, P)
    return np.concatenate([l[:3] / np.linalg.norm(l[:3]), l[3:]]), P


@answer_to("22.4", hint="covariance")
def a_little_added(l, P):
    l, P = tidy_line(l, P)
    return l, P + 1e-3 * np.eye(6)


@answer_to("22.4", hint="J P J'|J")
def no_cross_covariance(l, P):
    l, P = tidy_line(l, P)
    return l, P * np.kron(np.eye(2), np.ones((3, 3)))


# --- 22.5 NEES of a line ---


@answer_to("22.5", right=True)
def by_the_null_space(l, P, truth):
    A = np.array([truth, np.roll(truth, 3)])
    B = null_space(A).T
    e = B @ l
    return float(e.T @ np.linalg.inv(B @ P @ B.T) @ e)


@answer_to("22.5", right=True)
def by_the_projector_and_the_pseudo_inverse(l, P, truth):
    across = orth(np.array([truth, [*truth[3:], *truth[:3]]]).T)
    T = np.eye(6) - across @ across.T
    C = T @ P @ T
    return (T @ l) @ pinvh(C / np.trace(C), rtol=1e-9) @ (T @ l) / np.trace(C)


@answer_to("22.5", right=True)
def with_the_truth_on_the_same_scale(l, P, truth):
    s = (l @ truth) / (truth @ truth)
    Q = np.linalg.qr(np.column_stack([truth, np.roll(truth, 3), np.eye(6)]))[0][:, 2:6]
    e = Q.T @ (l - s * truth)
    L = np.linalg.cholesky(Q.T @ P @ Q)
    return np.sum(np.linalg.solve(L, e) ** 2)


@answer_to("22.5", hint="C|covariance|B P B'")
def covariance_of_six(l, P, truth):
    e = l - truth
    return e @ np.linalg.solve(P + 1e-14 * np.trace(P) * np.eye(6), e)


@answer_to("22.5", hint="shape|number")
def as_four_numbers(l, P, truth):
    B = np.linalg.svd(np.stack([truth, np.roll(truth, 3)]))[2][2:]
    return B @ l / np.sqrt(np.diag(B @ P @ B.T))


@answer_to("22.5", hint="four|normal|C|B")
def of_the_normal_alone(l, P, truth):
    e = l[:3] / np.linalg.norm(l[:3]) - truth[:3] / np.linalg.norm(truth[:3])
    return e @ np.linalg.pinv(P[:3, :3]) @ e


@answer_to("22.5", hint="root|C|four|B")
def twice_as_sure(l, P, truth):
    return 4 * line_nees(l, P, truth)


# --- 22.6 the part that has been seen ---


@answer_to("22.6", right=True)
def by_the_common_perpendicular(t, l, c, m):
    """The nearest point to a ray lies in the plane of the ray and of what is across line and ray."""
    n, v = l[:3], l[3:]
    p0, d = np.cross(v, n) / (v @ v), v / np.linalg.norm(v)
    seen = []
    for ray in m:
        side = np.cross(ray, np.cross(d, ray))
        seen.append(((c - p0) @ side) / (d @ side))
    return [np.min([*t, *seen]), np.max([*t, *seen])]


@answer_to("22.6", right=True)
def by_least_squares(t, l, c, m):
    d = unit(l[3:])[0]
    p0 = np.cross(l[3:], l[:3]) / (l[3:] @ l[3:])
    s = [np.linalg.lstsq(np.stack([d, ray], 1), c - p0, rcond=None)[0][0] for ray in m]
    every = np.sort([*t, *s])
    return every[[0, -1]]


@answer_to("22.6", right=True)
def by_the_package(t, l, c, m):
    seen = abscissas(PlkLin(), l, c, np.asarray(m))
    return np.array([min(t.min(), seen.min()), max(t.max(), seen.max())])


@answer_to("22.6", hint="order|any|smallest")
def last_one_first(t, l, c, m):
    return extend(t, l, c, m)[::-1]


@answer_to("22.6", hint="smallest|largest|grows|seen")
def only_to_the_right(t, l, c, m):
    return np.array([t[0], extend(t, l, c, m)[1]])


@answer_to("22.6", hint="metres|p0|t|length")
def in_units_of_v(t, l, c, m):
    return extend(t, l, c, m) / np.linalg.norm(l[3:])


@answer_to("22.6", hint="inside|before|stays|both|seen")
def a_moving_average(t, l, c, m):
    return (t + extend(t, l, c, m)) / 2


@answer_to("22.4", hint="n stays as it is")
def the_step_taken_by_n(l, P):
    n, v = l[:3], l[3:]
    return np.concatenate([n - (n @ v) / (n @ n) * v, v]), tidy_line(l, P)[1]


@answer_to("22.6", hint="not p0 - c")
def from_the_camera_to_the_line(t, l, c, m):
    n, v = l[:3], l[3:]
    p0, d = np.cross(v, n) / (v @ v), v / np.linalg.norm(v)
    seen = [np.linalg.lstsq(np.column_stack([d, -ray]), p0 - c, rcond=None)[0][0] for ray in m]
    return np.array([min(t[0], *seen), max(t[1], *seen)])


@answer_to("22.6", hint="not -v / [|]v[|]")
def along_minus_v(t, l, c, m):
    n, v = l[:3], l[3:]
    d = -v / np.linalg.norm(v)
    p0 = np.cross(v, n) / (v @ v)
    seen = [np.linalg.lstsq(np.column_stack([d, -ray]), c - p0, rcond=None)[0][0] for ray in m]
    return np.array([min(t[0], *seen), max(t[1], *seen)])


test_the_check_is_right_about_it = check_of(__name__)
