"""Exercise 06.1: from covariances to correlation coefficients."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def correlation(P):
    """Correlation coefficients of a covariance matrix.

    P, shape (n, n): covariance; all variances are positive.
    Return C, shape (n, n): numbers without a unit, between -1 and 1.
    """
    s = np.sqrt(np.diag(P))
    return P / np.outer(s, s)


def two(s, t, c):
    """Return the covariance of two numbers with these sigmas and this correlation."""
    return (np.array([[s * s, c * s * t], [c * s * t, t * t]]),)


def scaled(rng, *units):
    """Return a covariance in other units."""
    return (random_covariance(rng, len(units)) * np.outer(units, units),)


corr = table(
    "06.1 Correlation coefficients",
    correlation,
    hints=(
        "The correlation of two numbers is their covariance, measured in units of their standard deviations.",
        "C[i, j] = P[i, j] / (s[i] * s[j]), where s holds the standard deviations: the roots of the diagonal of P.",
        "s = np.sqrt(np.diag(P)), and np.outer(s, s) is the table of all products s[i] * s[j].",
    ),
    returns="C",
    cases={
        "any": lambda rng: [(random_covariance(rng, n),) for n in (2, 5, 1)],
        "two": lambda rng: [two(2.0, 0.5, 0.8), two(0.1, 3.0, -0.6), two(1.0, 1.0, 0.0)],
        "many": lambda rng: [(random_covariance(rng, n),) for n in (3, 7)],
        "units": lambda rng: [scaled(rng, 100.0, 1.0, 57.3, 1e-3, 1e4)],
    },
    checks="""
    shape        | C[:0] | any   | C has one entry for each entry of P.
    two numbers  | C     | two   | C[0, 1] and C[1, 0] are the covariance, divided by the two standard deviations: one each.
    many numbers | C     | many  | C[i, j] = P[i, j] / (s[i] s[j]), for every pair, with the standard deviations s.
    other units  | C     | units | A correlation has no unit: in centimetres it is the same as in metres.
    """,
    wrong="""
    divided by the variances | np.sqrt(np.diag(P)) -> np.diag(P) | The diagonal of P holds variances. A correlation is in units of the standard deviations: take the roots.
    divided by one of them | np.outer(s, s) -> s | Two numbers, two standard deviations: divide by s[i] *and* s[j].
    divided by one of the rows | np.outer(s, s) -> s[:, None] | Two numbers, two standard deviations: divide by s[i] *and* s[j].
    divided by one variance | np.outer(s, s) -> s**2 | Divide by s[i] s[j], not by the variance of one of the two.
    divided by the rows' variance | np.outer(s, s) -> np.diag(P)[:, None] | Divide by s[i] s[j], not by the variance of one of the two.
    roots of the norms of the rows | np.sqrt(np.diag(P)) -> np.sqrt(np.linalg.norm(P, axis=1)) | The sigma of a number is the root of its own variance, P[i, i]: the other entries of the row are not in it.
    norms of the rows | np.sqrt(np.diag(P)) -> np.linalg.norm(P, axis=1) | The sigma of a number is the root of its own variance, P[i, i]: the other entries of the row are not in it.
    only the lower triangle | P / np.outer(s, s) -> np.tril(P / np.outer(s, s)) | C is symmetric, as P is: yours lacks what stands above the diagonal.
    only the upper triangle | P / np.outer(s, s) -> np.triu(P / np.outer(s, s)) | C is symmetric, as P is: yours lacks what stands below the diagonal.
    the covariance itself | P / np.outer(s, s) -> 1 * P | These are covariances, with units. Divide by the standard deviations.
    always positive | P / np.outer(s, s) -> np.abs(P / np.outer(s, s)) | Keep the sign: two errors may go in opposite directions.
    squared | P / np.outer(s, s) -> (P / np.outer(s, s)) ** 2 | That is the square of the correlation: the sign is lost.
    scaled by the largest | np.outer(s, s) -> P.max() | One scale for all does not make the diagonal 1: each number has its own sigma.
    multiplied | P / np.outer(s, s) -> P * np.outer(s, s) | Divide by the standard deviations, do not multiply.
    np.corrcoef of P | P / np.outer(s, s) -> np.reshape(np.corrcoef(P), P.shape) if len(P) > 1 else np.ones((1, 1)) | np.corrcoef wants samples, not a covariance matrix.
    zeros on the diagonal | P / np.outer(s, s) -> P / np.outer(s, s) * (1 - np.eye(len(P))) | Every number is fully correlated with itself: C[i, i] = 1, not 0.
    in per cent | P / np.outer(s, s) -> 100 * P / np.outer(s, s) | A correlation is a number between -1 and 1: no per cent.
    sum of the sigmas | np.outer(s, s) -> np.add.outer(s, s) | Divide by the product s[i] s[j], not by the sum of both.
    divided in place | P / np.outer(s, s) -> _in_place(P) | Take the standard deviations before anything is changed. Where C is divided in place its diagonal is 1 already when the rest needs it.
    diagonal counted twice | P / np.outer(s, s) -> P / np.outer(s, s) * (1 + np.eye(len(P))) | Mirrored and added, a triangle with its diagonal counts the diagonal twice: C[i, i] = 1.
    mean of the variances | np.outer(s, s) -> np.add.outer(s**2, s**2) / 2 | Divide by the *product* of the two standard deviations, not by the mean of the two variances.
    eigenvalues for variances | np.sqrt(np.diag(P)) -> np.sqrt(np.abs(np.linalg.eigvalsh(P))) | The variances are the diagonal of P. Its eigenvalues are those along other axes.
    divided by the variances, the diagonal set to one | P / np.outer(s, s) -> np.where(np.eye(len(P)) > 0, 1, P / np.outer(s**2, s**2)) | The diagonal of P holds variances. A correlation is in units of the standard deviations: take the roots.
    np.corrcoef of P, as it comes | P / np.outer(s, s) -> np.corrcoef(P) | np.corrcoef wants samples, not a covariance matrix. And of one row it makes a number, not a 1 x 1 matrix.
    """,
)


@corr.link("the diagonal", "Every number is fully correlated with itself: C[i, i] = 1.", before="two numbers")
def _(f, rng):
    C = expect.array(f(*scaled(rng, 1, 20, 0.1, 3)), (4, 4), "C")
    expect.close(np.diag(C), np.ones(4), "the diagonal of C")


def _in_place(P):
    """The correlations by a loop that divides entry by entry, and takes the variances from what is divided already."""
    C = np.array(P, float)
    for i in range(len(C)):
        for j in range(len(C)):
            C[i, j] /= np.sqrt(C[i, i] * C[j, j])
    return C
