"""Answers to the exercises of notebook 17 that are in no list of the package: wrong ones, and odd right ones."""

import numpy as np
from scipy.stats import chi2

from ekfslam_tutorial.geometry import Frame3

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


test_the_check_is_right_about_it = check_of(__name__)
