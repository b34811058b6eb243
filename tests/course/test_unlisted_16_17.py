"""Answers to notebooks 16 and 17 that are in no list of the package: wrong ones and unusual right ones."""

import numpy as np
from scipy.stats import chi2, norm

from ekfslam_tutorial.course.exercises.nb16_birth import hypothesis
from ekfslam_tutorial.course.exercises.nb16_omni import omni_project
from ekfslam_tutorial.course.exercises.nb16_visible import beacon_visible
from ekfslam_tutorial.geometry import Frame3

from .probes import Probes, judged_rightly

probes = Probes()


@probes.each
def test_unlisted(id, says, answer):
    judged_rightly(id, says, answer)


# --- 16.1 the direct model of a range ---


@probes.wrong("16.1", "sign|away")
def absolute_components(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    return r, np.abs(p / r)[..., None, :]


@probes.wrong("16.1", "shape")
def no_axis_for_the_measurement(p):
    r = np.linalg.norm(p, axis=-1)
    return r, p / r[..., None]


@probes.wrong("16.1", "shape|transpose")
def column_jacobian(p):
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    return r, (p / r)[..., None]


@probes.wrong("16.1", "many points|p\\[")
def norm_of_all(p):
    r = np.linalg.norm(p)
    return np.full((*p.shape[:-1], 1), r), (p / r)[..., None, :]


@probes.wrong("16.1", "many points|p\\[|shape")
def for_lists_only(p):
    p = np.atleast_2d(p)
    r = np.hypot(p[:, 0], p[:, 1])
    return r[:, None], (p / r[:, None])[:, None, :]


@probes.right("16.1")
def by_einsum(p):
    r = np.sqrt(np.einsum("...i,...i->...", p, p))
    return np.expand_dims(r, -1), np.einsum("...i,...->...i", p, 1 / r).reshape(*p.shape[:-1], 1, 2)


# --- 16.2 what the sensor can see ---


@probes.wrong("16.2", "2.9|range|m,")
def a_little_too_far(y, p, max_range, fov):
    return beacon_visible(y, p, max_range + 0.2, fov)


@probes.wrong("16.2", "shape")
def keeps_the_axis(y, p, max_range, fov):
    return (y <= max_range) & (np.abs(np.arctan2(p[..., 1:], p[..., :1])) <= fov / 2)


@probes.wrong("16.2", "shape|truth value|decide")
def with_if(y, p, max_range, fov):
    if y[..., 0] <= max_range and abs(np.arctan2(p[..., 1], p[..., 0])) <= fov / 2:
        return True
    return False


@probes.right("16.2")
def with_where(y, p, max_range, fov):
    bearing = np.angle(p[..., 0] + 1j * p[..., 1])
    return np.where(np.squeeze(y, -1) > max_range, 0, np.where(2 * abs(bearing) > fov, 0, 1))


# --- 16.3 a range and a prior ---


@probes.wrong("16.3", "heading|theta|third column")
def heading_column_without_range(x, P, r, var, beta, N):
    p, P_pp, _ = hypothesis(x, P, r, var, beta, N)
    a = x[2] + beta
    J = np.array([[1, 0, -np.sin(a)], [0, 1, np.cos(a)]])
    own = P_pp - hypothesis(x, P, r, 0, beta, 0)[1]
    return p, J @ P @ J.T + own, J @ P


@probes.wrong("16.3", "degrees|direction|robot")
def degrees(x, P, r, var, beta, N):
    return hypothesis(np.array([x[0], x[1], np.degrees(x[2])]), P, r, var, np.degrees(beta), N)


@probes.wrong("16.3", "covariance|P_pp|terms")
def only_the_diagonal(x, P, r, var, beta, N):
    p, P_pp, P_px = hypothesis(x, P, r, var, beta, N)
    return p, np.diag(np.diag(P_pp)), P_px


@probes.right("16.3")
def by_samples_of_the_unscented_kind(x, P, r, var, beta, N):
    def g(u):
        return u[:2] + u[3] * np.array([np.cos(u[2] + u[4]), np.sin(u[2] + u[4])])

    u, h = np.array([*x, r, beta]), 1e-6
    J = np.array([(g(u + h * d) - g(u - h * d)) / (2 * h) for d in np.eye(5)]).T
    S = np.zeros((5, 5))
    S[:3, :3], S[3, 3], S[4, 4] = P, var, N
    return g(u), J @ S @ J.T, J @ S[:, :3]


# --- 16.4 weights ---


@probes.wrong("16.4", "zero|NaN|logarithm")
def densities(w, z, Z):
    new = w * norm.pdf(z, scale=np.sqrt(Z))
    return new / np.sum(new)


@probes.wrong("16.4", "sum|weights|likel")
def inverse_distance(w, z, Z):
    new = w / (1 + z**2 / Z)
    return new / np.sum(new)


@probes.right("16.4")
def as_log_sum_exp(w, z, Z):
    log = np.log(w) + norm.logpdf(np.array(z), 0, np.sqrt(Z))
    return np.exp(log - np.logaddexp.reduce(log))


# --- 16.5 a camera all round ---


@probes.wrong("16.5", "elevation")
def height(p):
    y, Y_p = omni_project(p)
    return np.stack([y[..., 0], p[..., 2]], -1), Y_p


@probes.wrong("16.5", "shape|transpose")
def transposed(p):
    y, Y_p = omni_project(p)
    return y, np.swapaxes(Y_p, -1, -2)


@probes.right("16.5")
def by_cross_products(p):
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(up, p)  # horizontal, across the line of sight
    s, r = np.linalg.norm(side, axis=-1), np.linalg.norm(p, axis=-1)
    above = np.cross(p, side) / (r * s)[..., None]  # the direction in which the elevation grows
    J = np.stack([side / s[..., None] ** 2, above / r[..., None]], axis=-2)
    return np.stack([np.arctan2(-side[..., 0], side[..., 1]) + 2 * np.pi, np.arcsin(p[..., 2] / r)], -1), J


# --- 17.1 NEES of a pose ---


@probes.wrong("17.1", "NEES|C")
def plain_inverse(x, P, truth):
    e = x - truth
    with np.errstate(all="ignore"):
        return np.einsum("ni,nij,nj->n", e, np.linalg.inv(P + 1e-15 * np.eye(7)), e)


@probes.wrong("17.1", "q|sign|orientation")
def shorter_chord_only(x, P, truth):
    s = np.sign((x[:, 3:] * truth[:, 3:]).sum(-1))[:, None]
    e = np.concatenate([x[:, :3] - truth[:, :3], x[:, 3:] - s * truth[:, 3:]], 1)
    return np.einsum("ni,nij,nj->n", e, np.linalg.pinv(P, rcond=1e-10), e)


@probes.wrong("17.1", "shape|one NEES|number")
def mean_of_all(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    C = E @ P @ E.transpose(0, 2, 1)
    return np.mean([a @ np.linalg.inv(B) @ a for a, B in zip(e, C, strict=True)])


@probes.wrong("17.1", "C|covariance")
def derivative_not_transposed(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    C = E @ E.transpose(0, 2, 1)
    return (e * np.linalg.solve(C, e[..., None])[..., 0]).sum(-1)


@probes.right("17.1")
def seen_from_the_estimate(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    R = np.zeros((len(x), 6, 6))
    R[:, :3, :3], R[:, 3:, 3:] = 2 * np.eye(3), -np.eye(3)  # any invertible change of coordinates
    e, E = np.einsum("nij,nj->ni", R, e), R @ E
    return np.einsum("ni,nij,nj->n", e, np.linalg.inv(E @ P @ E.transpose(0, 2, 1)), e)


# --- 17.2 in the band ---


@probes.wrong("17.2", "limit|too cautious|mean NEES")
def normal_approximation(nees, dof):
    runs = len(nees)
    return np.abs(np.mean(nees, 0) - dof) <= 1.96 * np.sqrt(2 * dof / runs)


@probes.wrong("17.2", "mean NEES|limit")
def pose_in_the_plane(nees, dof):
    low, high = chi2.ppf([0.025, 0.975], 3 * len(nees)) / len(nees)
    m = np.mean(nees, axis=0)
    return (m >= low) & (m <= high)


@probes.wrong("17.2", "shape|each frame")
def one_verdict(nees, dof):
    low, high = chi2.ppf([0.025, 0.975], dof * len(nees)) / len(nees)
    return low <= np.mean(nees) <= high


@probes.right("17.2")
def by_the_survival_function(nees, dof):
    total, n = np.add.reduce(np.array(nees), 0), np.shape(nees)[0] * dof
    return (chi2.sf(total, n) >= 0.025) * (chi2.cdf(total, n) >= 0.025)
