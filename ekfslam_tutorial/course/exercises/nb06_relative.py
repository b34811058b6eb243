"""Exercise 06.3: how well is one landmark known against another one?"""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def relative_covariance(P, a, b):
    """Covariance of the difference of two landmarks, d = l_b - l_a.

    P, shape (n, n): covariance of the joint state.
    a, b: the ranges of the two landmarks, slices of length 2.
    Return D, shape (2, 2), in m^2.
    """
    return P[a, a] + P[b, b] - P[a, b] - P[b, a]


A, B = slice(3, 5), slice(7, 9)


def some(rng, scale=1.0):
    """Return covariances of many sizes, and two landmarks in each, in both orders."""
    pairs = ((9, A, B), (9, B, A), (7, slice(5, 7), A), (13, slice(9, 11), A), (4, slice(0, 2), slice(2, 4)))
    return [(random_covariance(rng, n, scale), a, b) for n, a, b in pairs]


def independent(rng):
    """Return two landmarks without a common error."""
    P = random_covariance(rng, 9)
    P[A, B], P[B, A] = 0, 0
    return P, A, B


relative = table(
    "06.3 One landmark against another one",
    relative_covariance,
    hints=(
        "Write the error of the difference: dd = dl_b - dl_a. Its covariance is the mean of dd dd'. Multiply out.",
        "E[dl_b dl_b'] is the block P[b, b]; E[dl_b dl_a'] is P[b, a]. There are four products: which have a minus?",
        "(dl_b - dl_a)(dl_b - dl_a)' = P[b, b] - P[b, a] - P[a, b] + P[a, a].",
    ),
    returns="D",
    symbols="dl_a, dl_b = the errors of the two landmarks",
    cases={
        "any": some,
        "independent": lambda rng: [independent(rng)],
        "common": lambda rng: [(np.kron(np.ones((4, 4)), random_covariance(rng, 2)), slice(2, 4), slice(6, 8))],
        "small": lambda rng: some(rng, 1e-4),
    },
    checks="""
    shape                  | D[:0] | any         | D belongs to the two numbers of the difference.
    independent landmarks  | D     | independent | Without a common error the two covariances add up: P[a, a] + P[b, b].
    a common error cancels | D     | common      | If both landmarks are shifted by the same error, their difference is exact: P[a, b] and P[b, a] are taken away.
    the general case       | D     | any         | Multiply out (dl_b - dl_a)(dl_b - dl_a)': four blocks.
    small numbers          | D     | small       | All covariances are 10 000 times smaller here, and D with them: the same four blocks of (dl_b - dl_a)(dl_b - dl_a)'.
    """,
    wrong="""
    cross-covariances forgotten | - P[a, b] - P[b, a] -> - 0 | That is right only if the two errors have nothing in common. They share the error of the robot: subtract P[a, b] and P[b, a].
    covariances subtracted | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> P[b, b] - P[a, a] | Errors are subtracted, covariances are not: (dl_b - dl_a)(dl_b - dl_a)' has + P[a, a].
    covariance of the sum | - P[a, b] - P[b, a] -> + P[a, b] + P[b, a] | That is the covariance of the sum l_a + l_b. For the difference the cross terms get a minus.
    the same cross block twice | - P[b, a] -> - P[a, b] | P[a, b] and P[b, a] are transposes of each other, not the same: subtract one of each.
    the same cross block twice (b, a) | - P[a, b] -> - P[b, a] | P[a, b] and P[b, a] are transposes of each other, not the same: subtract one of each.
    one cross block | - P[a, b] - P[b, a] -> - P[a, b] | There are two cross terms, P[a, b] and P[b, a]: subtract both.
    one cross block (b, a) | - P[a, b] - P[b, a] -> - P[b, a] | There are two cross terms, P[a, b] and P[b, a]: subtract both.
    one cross block added | - P[a, b] - P[b, a] -> - P[a, b] + P[b, a] | Both cross terms have a minus: each is the product of + dl_b and - dl_a.
    half of the cross terms | - P[a, b] - P[b, a] -> - (P[a, b] + P[b, a]) / 2 | There are two cross terms, P[a, b] and P[b, a]: subtract both in full.
    the cross block alone | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> 1 * P[a, b] | P[a, b] tells what the two errors have in common, not what their difference is.
    one landmark alone | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> 1 * P[b, b] | The other landmark is uncertain, too: P[a, a] and P[b, b] are both in D.
    one landmark twice | P[a, a] + P[b, b] -> P[a, a] + P[a, a] | Each of the two landmarks has its own covariance: P[a, a] and P[b, b], not one of them twice.
    one landmark twice (b) | P[a, a] + P[b, b] -> P[b, b] + P[b, b] | Each of the two landmarks has its own covariance: P[a, a] and P[b, b], not one of them twice.
    one landmark and one cross block | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> P[b, b] - P[a, b] | Multiply out (dl_b - dl_a)(dl_b - dl_a)': two of the four blocks are missing, P[a, a] and one cross block.
    one landmark and one cross block (b, a) | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> P[b, b] - P[b, a] | Multiply out (dl_b - dl_a)(dl_b - dl_a)': two of the four blocks are missing, P[a, a] and one cross block.
    the mean of the two | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> (P[a, a] + P[b, b]) / 2 | A mean of the two covariances forgets what the errors have in common.
    conditional covariance | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> P[b, b] - P[b, a] @ np.linalg.pinv(P[a, a]) @ P[a, b] | That is the covariance of l_b if l_a were known exactly: another question.
    diagonal only | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> np.diag(np.diag(P[a, a] + P[b, b] - P[a, b] - P[b, a])) | x and y of the difference are correlated, too: keep the whole 2 x 2 blocks.
    standard deviations | P[a, a] + P[b, b] - P[a, b] - P[b, a] -> np.sqrt(np.abs(P[a, a] + P[b, b] - P[a, b] - P[b, a])) | The entries of D are variances: take no roots.
    only the diagonal of the cross term | - P[a, b] - P[b, a] -> - 2 * np.diag(np.diag(P[a, b])) | The x of one landmark and the y of the other are correlated, too: take the whole blocks P[a, b] and P[b, a].
    covariance of the robot added | P[a, a] + P[b, b] -> P[:2, :2] + P[a, a] + P[b, b] | Both landmarks are told in the world: where the robot is has no part in their difference.
    mean of the two in the sum | P[a, a] + P[b, b] -> (P[a, a] + P[b, b]) / 2 | The two covariances are added in full, not averaged.
    """,
)


@relative.link("a covariance", "D must be symmetric and without negative eigenvalues.")
def _(f, rng):
    for args in some(rng):
        D = expect.array(f(*args), (2, 2), "D")
        expect.symmetric(D, "D", 1e-6)
        expect.psd(D, "D")
