"""Answers to the exercises of notebook 12 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
import scipy.optimize
from scipy.optimize import fsolve

from ekfslam_tutorial.course.exercises.nb12_distort import distort
from ekfslam_tutorial.course.exercises.nb12_observe import proj_euc_pnt
from ekfslam_tutorial.course.exercises.nb12_pin_hole import pin_hole
from ekfslam_tutorial.course.exercises.nb12_undistort import undistort
from ekfslam_tutorial.course.exercises.nb12_visible import visible
from ekfslam_tutorial.geometry import Frame3, numerical_jacobian
from ekfslam_tutorial.models.sensors.lens import radial
from ekfslam_tutorial.models.sensors.pin_hole import pin_hole as package_pin_hole

from .collector import answer_to, check_of

# --- 12.1 distort ---


@answer_to("12.1", hint="UD_d.*column|2 rows")
def one_row_for_each_of_d(up, d):
    ud, UD_up, UD_d = distort(up, d)
    return ud, UD_up, UD_d.T


@answer_to("12.1", hint="d may have any length|IndexError")
def always_two_numbers_in_d(up, d):
    r2 = up @ up
    f = 1 + d[0] * r2 + d[1] * r2**2
    return f * up, f * np.eye(2) + 2 * (d[0] + 2 * d[1] * r2) * np.outer(up, up), np.outer(up, [r2, r2**2])


@answer_to("12.1", hint="r = .up|the point")
def sum_for_the_length(up, d):
    _, UD_up, UD_d = distort(up, d)
    return up * (1 + abs(up.sum()) ** (2 * np.arange(1, len(d) + 1)) @ d), UD_up, UD_d


@answer_to("12.1", hint="UD_up")
def derivative_by_r_for_that_by_r2(up, d):
    ud, _, UD_d = distort(up, d)
    k, r = np.arange(1, len(d) + 1), np.linalg.norm(up)
    return ud, (1 + r ** (2 * k) @ d) * np.eye(2) + (2 * k * r ** (2 * k - 1)) @ d * np.outer(up, up), UD_d


@answer_to("12.1", hint=r"up = \[0, 0\]|UD_up")
def divided_by_r(up, d):
    ud, _, UD_d = distort(up, d)
    k, r = np.arange(1, len(d) + 1), np.linalg.norm(up)
    e = up / r
    return ud, (1 + r ** (2 * k) @ d) * np.eye(2) + (2 * k * r ** (2 * k)) @ d * np.outer(e, e), UD_d


@answer_to("12.1", hint="changes its input")
def bent_in_place(up, d):
    _, UD_up, UD_d = distort(up, d)
    up *= 1 + (up @ up) ** np.arange(1, len(d) + 1) @ d
    return up, UD_up, UD_d


@answer_to("12.1", right=True)
def horner(up, d):
    r2, f, g = up[0] ** 2 + up[1] ** 2, 0.0, 0.0
    for di in [*d[::-1], 1.0]:
        g = g * r2 + f
        f = f * r2 + di
    columns = [[c * r2 ** (i + 1) for i in range(len(d))] for c in up]
    J = [[f + 2 * g * up[0] ** 2, 2 * g * up[0] * up[1]], [2 * g * up[0] * up[1], f + 2 * g * up[1] ** 2]]
    return [f * c for c in up], J, np.reshape(columns, (2, len(d)))


@answer_to("12.1", right=True)
def complex_step(up, d):
    def g(p):
        return p * (1 + sum(di * (p[0] ** 2 + p[1] ** 2) ** (i + 1) for i, di in enumerate(d)))

    J = np.column_stack([g(up + 1e-30j * e).imag / 1e-30 for e in np.eye(2)])
    return g(up), J, np.array([up * (up @ up) ** (i + 1) for i in range(len(d))]).reshape(len(d), 2).T


# --- 12.2 pin_hole ---


@answer_to("12.2", hint="no distortion|pixel")
def whole_pixels(p, k, d):
    u, *J = pin_hole(p, k, d)
    return np.round(u), *J


@answer_to("12.2", hint="U_p")
def points_by_pixels(p, k, d):
    u, U_p, U_k, U_d = pin_hole(p, k, d)
    return u, U_p.T, U_k, U_d


@answer_to("12.2", hint="U_k")
def u_and_v_of_k_swapped(p, k, d):
    u, U_p, U_k, U_d = pin_hole(p, k, d)
    return u, U_p, U_k[::-1], U_d


@answer_to("12.2", hint="U_d")
def U_d_at_the_ideal_point_only(p, k, d):
    u, U_p, U_k, U_d = pin_hole(p, k, d)
    return u, U_p, U_k, U_d / (1 + d.sum())


@answer_to("12.2", hint="any depth.*each z")
def not_nearer_than_a_tenth_of_a_metre(p, k, d):
    return pin_hole(np.array([p[0], p[1], max(p[2], 0.1)]), k, d)


@answer_to("12.2", hint="U_p")
def U_p_without_the_sign_of_the_depth(p, k, d):
    u, U_p, U_k, U_d = pin_hole(p, k, d)
    return u, U_p * np.sign(p[2]), U_k, U_d


@answer_to("12.2", hint="return u, U_p, U_k, U_d|4 results|shapes")
def the_pixel_only(p, k, d):
    return pin_hole(p, k, d)[0]


@answer_to("12.2", right=True)
def homogeneous(p, k, d):
    u0, v0, au, av = k
    ud, UD_up, UD_d = distort(np.divide(p, p[2])[:2], d)
    C = np.array([[au, 0, u0], [0, av, v0]])
    UP_p = (np.eye(3)[:2] - np.outer(p[:2] / p[2], [0, 0, 1])) / p[2]
    return C @ [*ud, 1], C[:, :2] @ UD_up @ UP_p, [[1, 0, ud[0], 0], [0, 1, 0, ud[1]]], C[:, :2] @ UD_d


@answer_to("12.2", right=True)
def by_five_point_differences(p, k, d):
    g = lambda p, k, d: pin_hole(p, k, d)[0]
    args, out = [p, k, d], [g(p, k, d)]
    for i, a in enumerate(args):
        h = 1e-3 * np.maximum(1, np.abs(a))
        at = lambda s, i=i, a=a: g(*[a + s if i == j else b for j, b in enumerate(args)])
        J = [(8 * (at(e) - at(-e)) - at(2 * e) + at(-2 * e)) / (12 * max(e)) for e in np.diag(h)]
        out.append(np.reshape(J, (len(a), 2)).T)
    return tuple(out)


# --- 12.3 visible ---


@answer_to("12.3", hint="ahead|z > 0|behind|front")
def nothing_nearer_than_half_a_metre(p, u, size, fold):
    return visible(p, u, size, fold) & (p[:, 2] > 0.5)


@answer_to("12.3", hint="fold")
def the_fold_in_pixels(p, u, size, fold):
    return visible(p, u, size, np.inf) & (np.linalg.norm(u - size / 2, axis=1) < fold * size[0])


@answer_to("12.3", hint="truth value|shape|one")
def one_answer_for_all(p, u, size, fold):
    return bool(visible(p, u, size, fold).all())


@answer_to("12.3", hint="shape|truth value|one")
def the_numbers_of_those_seen(p, u, size, fold):
    return np.flatnonzero(visible(p, u, size, fold))


@answer_to("12.3", hint="ambiguous|&|truth value")
def joined_with_and(p, u, size, fold):
    return p[:, 2] > 0 and np.all(u >= 0, axis=1) and np.all(u <= size, axis=1)


@answer_to("12.3", hint="truth value")
def conditions_counted(p, u, size, fold):
    r = np.hypot(p[:, 0], p[:, 1]) / np.abs(p[:, 2])
    return 1 * (p[:, 2] > 0) + np.all((u >= 0) & (u <= size), axis=1) + (r < fold)


@answer_to("12.3", right=True)
def one_after_the_other(p, u, size, fold):
    seen = []
    for (x, y, z), (a, b) in zip(p, u, strict=True):
        seen.append(z > 0 and 0 <= a <= size[0] and 0 <= b <= size[1] and x * x + y * y < (fold * z) ** 2)
    return seen


@answer_to("12.3", right=True)
def product_of_zeros_and_ones(p, u, size, fold):
    angle = np.arctan2(np.linalg.norm(p[:, :2], axis=1), p[:, 2])  # more than a right angle behind the camera
    return np.prod([angle < np.arctan(fold), *(u.T >= 0), *(u <= size).T], axis=0)


# --- 12.4 proj_euc_pnt ---


@answer_to("12.4", hint="U_l")
def the_point_moves_like_the_robot(Rf, Sf, k, d, l):
    u, U_r, U_s, U_k, U_d, _ = proj_euc_pnt(Rf, Sf, k, d, l)
    return u, U_r, U_s, U_k, U_d, U_r[:, :3]


@answer_to("12.4", hint="U_s")
def frame_of_the_camera_in_the_world(Rf, Sf, k, d, l):
    u, U_r, _, U_k, U_d, U_l = proj_euc_pnt(Rf, Sf, k, d, l)
    ls, LS_c, _ = Rf.compose(Sf)[0].to_frame(l)
    return u, U_r, pin_hole(ls, k, d)[1] @ LS_c, U_k, U_d, U_l


@answer_to("12.4", hint="U_r")
def the_robot_does_not_turn(Rf, Sf, k, d, l):
    u, U_r, *rest = proj_euc_pnt(Rf, Sf, k, d, l)
    return u, np.hstack([U_r[:, :3], np.zeros((2, 4))]), *rest


@answer_to("12.4", hint="U_k|U_d|shape|[Ss]ix")
def the_order_of_the_arguments(Rf, Sf, k, d, l):
    u, U_r, U_s, U_k, U_d, U_l = proj_euc_pnt(Rf, Sf, k, d, l)
    return u, U_l, U_r, U_s, U_k, U_d


@answer_to("12.4", right=True)
def by_the_composed_frame(Rf, Sf, k, d, l):
    C, C_r, C_s = Rf.compose(Sf)
    ls, LS_c, LS_l = C.to_frame(l)
    u, U_ls, U_k, U_d = pin_hole(ls, k, d)
    return u, U_ls @ LS_c @ C_r, U_ls @ LS_c @ C_s, U_k, U_d, U_ls @ LS_l


@answer_to("12.4", right=True)
def the_point_moves_against_the_robot(Rf, Sf, k, d, l):
    u, U_r, U_s, U_k, U_d, _ = proj_euc_pnt(Rf, Sf, k, d, l)
    return [u.tolist(), U_r.tolist(), U_s.tolist(), U_k, U_d, -U_r[:, :3]]


# --- 12.5 undistort ---


@answer_to("12.5", hint="there and back|fold|steps|round trip")
def six_divisions(ud, d):
    up = ud.copy()
    for _ in range(6):
        up = ud / (1 + (up @ up) ** np.arange(1, len(d) + 1) @ d)
    return up, np.linalg.inv(distort(up, d)[1])


@answer_to("12.5", hint="there and back|round trip")
def a_series(ud, d):
    d2, d4 = [*d, 0, 0][:2]
    r2 = ud @ ud
    up = ud * (1 - d2 * r2 + (3 * d2**2 - d4) * r2**2)
    return up, np.linalg.inv(distort(up, d)[1])


@answer_to("12.5", hint="there and back|ideal|one answer|steps")
def the_largest_root(ud, d):
    up = _along_the_radius(ud, d, max)
    return up, np.linalg.inv(distort(up, d)[1])


@answer_to("12.5", hint=r"\[0, 0\]")
def direction_of_nothing(ud, d):
    up = np.linalg.norm(undistort(ud, d)[0]) * ud / np.linalg.norm(ud)
    return up, undistort(ud, d)[1]


@answer_to("12.5", hint="UP_ud")
def inverse_to_first_order(ud, d):
    up, _ = undistort(ud, d)
    return up, 2 * np.eye(2) - distort(up, d)[1]


def _along_the_radius(ud, d, which):
    """The ideal point from the real, positive roots of r + d2 r^3 + d4 r^5 + ... = |ud|."""
    rd = np.hypot(*ud)
    if rd == 0:
        return np.zeros(2)
    odd = np.zeros(2 * len(d) + 2)
    odd[0], odd[1], odd[3::2] = -rd, 1, d
    roots = np.roots(np.trim_zeros(odd[::-1], "f"))
    return ud / rd * which(z.real for z in roots if abs(z.imag) < 1e-9 and z.real > 0)


@answer_to("12.5", right=True)
def roots_of_a_polynomial(ud, d):
    up = _along_the_radius(ud, d, min)
    return up, np.linalg.inv(distort(up, d)[1])


@answer_to("12.5", right=True)
def solved_by_scipy(ud, d):
    up = scipy.optimize.fsolve(lambda up: distort(up, d)[0] - ud, ud, xtol=1e-13)
    return up, np.linalg.pinv(distort(up, d)[1]).tolist()


@answer_to("12.5", right=True)
def three_hundred_divisions(ud, d):
    up = 1.0 * ud
    for _ in range(300):
        up = ud / (1 + sum(di * (up @ up) ** (i + 1) for i, di in enumerate(d)))
    return up, np.linalg.solve(distort(up, d)[1], np.eye(2))


# --- 12.1: the same in other words ---


@answer_to("12.1", right=True)
def a_loop_lists(up, d):
    x, y = up
    r2, f, f_r2, UD_d = x * x + y * y, 1.0, 0.0, [[], []]
    for i, di in enumerate(d):
        f += di * r2 ** (i + 1)
        f_r2 += (i + 1) * di * r2**i
        UD_d[0].append(x * r2 ** (i + 1))
        UD_d[1].append(y * r2 ** (i + 1))
    return [f * x, f * y], [[f + 2 * f_r2 * x * x, 2 * f_r2 * x * y], [2 * f_r2 * x * y, f + 2 * f_r2 * y * y]], UD_d


@answer_to("12.1", right=True)
def central_differences(up, d):
    d = np.array(d, float)

    def g(u, d):
        r = np.hypot(*u)
        return u * (1 + sum(c * r ** (2 * i + 2) for i, c in enumerate(d)))

    h = 1e-6
    J = np.array([(g(up + h * e, d) - g(up - h * e, d)) / (2 * h) for e in np.eye(2)]).T
    D = np.array([(g(up, d + h * e) - g(up, d - h * e)) / (2 * h) for e in np.eye(len(d))]).reshape(len(d), 2).T
    return g(up, d), J, D


@answer_to("12.1", right=True)
def with_the_packages_function(up, d):
    return radial(np.asarray(up), np.asarray(d, float))


# --- 12.4: the same in other words ---


def _value_4(Rf, Sf, k, d, l):
    return package_pin_hole(Sf.to_frame(Rf.to_frame(l)[0])[0], k, d)[0]


def _value_with_4(args, place, x):
    """The pixel with another value of one argument."""
    args[place] = Frame3(x) if place < 2 else x
    return _value_4(*args)


@answer_to("12.4", right=True)
def by_composition_of_the_frames(Rf, Sf, k, d, l):
    C, C_r, C_s = Rf.compose(Sf)
    ls, LS_c, LS_l = C.to_frame(l)
    u, U_ls, U_k, U_d = pin_hole(ls, k, d)
    U_c = U_ls @ LS_c
    return u, U_c @ C_r, U_c @ C_s, U_k, U_d, U_ls @ LS_l


@answer_to("12.4", right=True)
def finite_differences_as_lists(Rf, Sf, k, d, l):
    args = [Rf, Sf, np.asarray(k, float), np.asarray(d, float), np.asarray(l, float)]

    def by(i):
        def value(x):
            return _value_with_4(list(args), i, x)

        return numerical_jacobian(value, getattr(args[i], "x", args[i])).tolist()

    return (_value_4(*args).tolist(), *(by(i) for i in range(5)))


# --- 12.2: the same in other words ---


@answer_to("12.2", right=True)
def written_out_as_lists(p, k, d):
    x, y, z = (float(c) for c in p)
    u0, v0, au, av = k
    (a, b), J, D = distort(np.array([x / z, y / z]), d)
    J, D = np.asarray(J), np.asarray(D)
    rows = [[au / z * J[0, 0], au / z * J[0, 1], -au / z**2 * (J[0] @ [x, y])],
            [av / z * J[1, 0], av / z * J[1, 1], -av / z**2 * (J[1] @ [x, y])]]  # fmt: skip
    return [u0 + au * a, v0 + av * b], rows, [[1, 0, a, 0], [0, 1, 0, b]], [au * D[0], av * D[1]]


@answer_to("12.2", right=True)
def homogeneous_coordinates(p, k, d):
    up = np.asarray(p) / p[2]
    ud, UD_up, UD_d = distort(up[:2], d)
    A = np.array([[k[2], 0, k[0]], [0, k[3], k[1]]])
    UP_p = (np.eye(3)[:2] - np.outer(up[:2], np.eye(3)[2])) / p[2]
    U_k = np.column_stack([np.eye(2), [ud[0], 0], [0, ud[1]]])
    return A @ np.append(ud, 1), A[:, :2] @ UD_up @ UP_p, U_k, A[:, :2] @ UD_d


@answer_to("12.2", right=True)
def with_the_packages_function_too(p, k, d):
    return package_pin_hole(np.asarray(p), k, np.asarray(d))


# --- 12.5: the same in other words ---


def _f_5(u, d):
    return 1 + (u @ u) ** np.arange(1, len(d) + 1) @ d


@answer_to("12.5", right=True)
def fixed_point_lists(ud, d):
    up = np.array(ud, float)
    for _ in range(150):
        up = np.asarray(ud) / _f_5(up, d)
    return up.tolist(), np.linalg.inv(np.asarray(distort(up, d)[1])).tolist()


@answer_to("12.5", right=True)
def newton_on_the_radius(ud, d):
    rd, k = np.linalg.norm(ud), np.arange(1, len(d) + 1)
    r = rd
    for _ in range(30):
        r = r - (r * (1 + r ** (2 * k) @ d) - rd) / (1 + r ** (2 * k) @ ((2 * k + 1) * d))
    up = np.asarray(ud) * (r / rd if rd else 1.0)
    return up, np.linalg.solve(np.asarray(distort(up, d)[1]), np.eye(2))


@answer_to("12.5", right=True)
def scipys_fsolve_central_differences(ud, d):
    back = lambda u: np.asarray(fsolve(lambda x: np.asarray(distort(x, d)[0]) - u, u, xtol=1e-11))
    h = 1e-5
    return back(ud), np.array([(back(ud + h * e) - back(ud - h * e)) / (2 * h) for e in np.eye(2)]).T


@answer_to("12.5", right=True)
def roots_of_a_polynomial_too(ud, d):
    rd = np.linalg.norm(ud)
    c = np.zeros(2 * len(d) + 2)
    c[1::2] = [1, *d]
    c[0] = -rd
    roots = np.roots(c[::-1])
    r = min(roots[(np.abs(roots.imag) < 1e-9) & (roots.real >= -1e-12)].real) if rd else 0.0
    up = np.asarray(ud) * (r / rd if rd else 1.0)
    return up, np.linalg.inv(distort(up, d)[1])


# --- 12.3: the same in other words ---


@answer_to("12.3", right=True)
def point_by_point_a_list(p, u, size, fold):
    out = []
    for (x, y, z), (c, r) in zip(p, u, strict=True):
        out.append(bool(z > 0 and 0 <= c <= size[0] and 0 <= r <= size[1] and x * x + y * y < fold**2 * z * z))
    return out


@answer_to("12.3", right=True)
def the_angle_of_the_ray_as_0_and_1(p, u, size, fold):
    angle = np.arctan2(np.hypot(p[:, 0], p[:, 1]), p[:, 2])
    middle = np.asarray(size) / 2
    near = (np.abs(u - middle) <= middle).all(axis=1)
    return (near * (angle < np.pi / 2) * (angle < np.arctan(fold))).astype(int)


test_the_check_is_right_about_it = check_of(__name__)
