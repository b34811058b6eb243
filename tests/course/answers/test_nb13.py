"""Answers to the exercises of notebook 13 that are in no list of the package."""

import numpy as np

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import IdpPnt

from .collector import answer_to, check_of

# --- 13.1: the same in other words ---


@answer_to("13.1", right=True)
def information_form(rho, P, b, y, var):
    s = b * np.asarray(rho)
    H = b / (1 + s * s)
    new = 1 / (1 / P + H * H / var)
    return rho + new * H / var * (y - np.arctan(s)), new


@answer_to("13.1", right=True)
def point_by_point(rho, P, b, y, var):
    out = []
    for r, p, a in zip(rho, P, y, strict=True):
        H = b * np.cos(np.arctan(b * r)) ** 2
        K = p * H / (H * p * H + var)
        out.append((r + K * (a - np.arctan2(b * r, 1.0)), p - K * (H * p * H + var) * K))
    return [r for r, _ in out], [p for _, p in out]


# --- 13.3: the same in other words ---


@answer_to("13.3", right=True)
def with_the_packages_point(x, P, i):
    p, P_l = IdpPnt().point(np.asarray(x)[i : i + 6])
    rest = [k for k in range(len(x)) if not i <= k < i + 6]
    P_pm = P_l @ P[i : i + 6]
    out = np.insert(np.insert(P[np.ix_(rest, rest)], [i] * 3, 0, 0), [i] * 3, 0, 1)
    places = [k if k < i else k - 3 for k in rest]
    out[i : i + 3, places] = P_pm[:, rest]
    out[places, i : i + 3] = P_pm[:, rest].T
    out[i : i + 3, i : i + 3] = P_pm[:, i : i + 6] @ P_l.T
    return [*x[:i], *p, *x[i + 6 :]], out


@answer_to("13.3", right=True)
def by_central_differences(x, P, i):
    def g(x):
        p, t, rho = x[i + 3], x[i + 4], x[i + 5]
        m = np.array([np.cos(p) * np.cos(t), np.cos(p) * np.sin(t), np.sin(p)])
        return np.concatenate([x[:i], x[i : i + 3] + m / rho, x[i + 6 :]])

    J = np.array([(g(x + 1e-6 * d) - g(x - 1e-6 * d)) / 2e-6 for d in np.eye(len(x))]).T
    return g(x), J @ P @ J.T


# --- 13.2: the same in other words ---


def _parts_2(F, camera, y, n):
    """Value and Jacobians by F, y, n."""
    v, V_y = camera.retro(y)
    l_c, LC_v, LC_n = IdpPnt().from_ray(v, n)
    l, L_F, L_lc = IdpPnt().from_frame(F, l_c)
    return l, L_F, L_lc @ LC_v @ V_y, L_lc @ LC_n, l_c


@answer_to("13.2", right=True)
def one_big_jacobian(F, P_F, camera, y, R, n, N):
    l, L_F, L_y, L_n, _ = _parts_2(F, camera, y, n)
    J = np.hstack([L_F, L_y, L_n])
    C = np.zeros((10, 10))
    C[:7, :7], C[7:9, 7:9], C[9:, 9:] = P_F, R, N
    return l, J @ C @ J.T, (J @ C)[:, :7]


@answer_to("13.2", right=True)
def by_central_differences_too(F, P_F, camera, y, R, n, N):
    def g(a):
        l_c = IdpPnt().from_ray(camera.retro(a[7:9])[0], a[9:])[0]
        return IdpPnt().from_frame(Frame3(a[:7]), l_c)[0]

    a, h = np.concatenate([F.x, y, n]), 1e-6
    J = np.array([(g(a + h * d) - g(a - h * d)) / (2 * h) for d in np.eye(10)]).T
    noise = J[:, 7:9] @ R @ J[:, 7:9].T + J[:, 9:] @ N @ J[:, 9:].T
    return tuple(g(a)), J[:, :7] @ P_F @ J[:, :7].T + noise, J[:, :7] @ P_F


test_the_check_is_right_about_it = check_of(__name__)
