"""Answers to the exercises of notebook 17 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.stats import chi2

from ekfslam_tutorial.course.exercises.nb17_nees import directions
from ekfslam_tutorial.geometry import Frame3, q2qc, q2v, q_prod

from .collector import answer_to, check_of

# --- 17.1 NEES of a pose ---


@answer_to("17.1", hint="NEES|C")
def plain_inverse(x, P, truth):
    e = x - truth
    with np.errstate(all="ignore"):
        return np.einsum("ni,nij,nj->n", e, np.linalg.inv(P + 1e-15 * np.eye(7)), e)


@answer_to("17.1", hint="q|sign|orientation")
def shorter_chord_only(x, P, truth):
    s = np.sign((x[:, 3:] * truth[:, 3:]).sum(-1))[:, None]
    e = np.concatenate([x[:, :3] - truth[:, :3], x[:, 3:] - s * truth[:, 3:]], 1)
    return np.einsum("ni,nij,nj->n", e, np.linalg.pinv(P, rcond=1e-10), e)


@answer_to("17.1", hint="shape|one NEES|number")
def mean_of_all(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    C = E @ P @ E.transpose(0, 2, 1)
    return np.mean([a @ np.linalg.inv(B) @ a for a, B in zip(e, C, strict=True)])


@answer_to("17.1", hint="C|covariance")
def derivative_not_transposed(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    C = E @ E.transpose(0, 2, 1)
    return (e * np.linalg.solve(C, e[..., None])[..., 0]).sum(-1)


@answer_to("17.1", right=True)
def seen_from_the_estimate(x, P, truth):
    e, E = Frame3(x).minus(Frame3(truth))
    R = np.zeros((len(x), 6, 6))
    R[:, :3, :3], R[:, 3:, 3:] = 2 * np.eye(3), -np.eye(3)  # any invertible change of coordinates
    e, E = np.einsum("nij,nj->ni", R, e), R @ E
    return np.einsum("ni,nij,nj->n", e, np.linalg.inv(E @ P @ E.transpose(0, 2, 1)), e)


# --- 17.2 in the band ---


@answer_to("17.2", hint="limit|too cautious|mean NEES")
def normal_approximation(nees, dof):
    runs = len(nees)
    return np.abs(np.mean(nees, 0) - dof) <= 1.96 * np.sqrt(2 * dof / runs)


@answer_to("17.2", hint="mean NEES|limit")
def pose_in_the_plane(nees, dof):
    low, high = chi2.ppf([0.025, 0.975], 3 * len(nees)) / len(nees)
    m = np.mean(nees, axis=0)
    return (m >= low) & (m <= high)


@answer_to("17.2", hint="shape|each frame")
def one_verdict(nees, dof):
    low, high = chi2.ppf([0.025, 0.975], dof * len(nees)) / len(nees)
    return low <= np.mean(nees) <= high


@answer_to("17.2", right=True)
def by_the_survival_function(nees, dof):
    total, n = np.add.reduce(np.array(nees), 0), np.shape(nees)[0] * dof
    return (chi2.sf(total, n) >= 0.025) * (chi2.cdf(total, n) >= 0.025)


# --- 17.2: the same in other words ---


@answer_to("17.2", right=True)
def with_the_sum(nees, dof):
    total = np.sum(nees, axis=0)
    p = chi2.cdf(total, len(nees) * dof)
    return np.abs(p - 0.5) <= 0.475


@answer_to("17.2", right=True)
def frame_by_frame(nees, dof):
    nees = np.asarray(nees)
    R = nees.shape[0]
    low, high = chi2.interval(0.95, R * dof)
    return [bool(low <= R * nees[:, k].mean() <= high) for k in range(nees.shape[1])]


# --- 17.1: the same in other words ---


@answer_to("17.1", right=True)
def pose_by_pose_with_the_inverse(x, P, truth):
    out = []
    for a, B, c in zip(x, P, truth, strict=True):
        e, E = Frame3(a).minus(Frame3(c))
        out.append(float(e @ np.linalg.inv(E @ B @ E.T) @ e))
    return out


@answer_to("17.1", right=True)
def in_the_axes_of_the_world(x, P, truth):
    e, E_x = Frame3(x).minus(Frame3(truth))
    W = np.zeros((len(x), 6, 6))
    W[:, :3, :3], W[:, 3:, 3:] = np.eye(3), Frame3(truth).R
    e, E_x = (W @ e[..., None])[..., 0], W @ E_x
    L = np.linalg.cholesky(E_x @ P @ E_x.transpose(0, 2, 1))
    return (np.linalg.solve(L, e[..., None]) ** 2).sum((-1, -2))


@answer_to("17.1", right=True)
def without_the_toolbox(x, P, truth):
    out = []
    for a, B, c in zip(x, P, truth, strict=True):
        dq = q_prod(q2qc(c[3:])[0], a[3:])[0]
        v = q2v(dq if dq[0] > 0 else -dq)[0]
        E = np.zeros((6, 7))
        E[:3, :3], E[3:, 3:] = np.eye(3), 4 * directions(a[3:]).T
        e = np.concatenate([a[:3] - c[:3], v])
        out.append(e @ np.linalg.solve(E @ B @ E.T, e))
    return np.array(out)


test_the_check_is_right_about_it = check_of(__name__)
