"""Exercise 06.1: from covariances to correlation coefficients."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def correlation(P):
    """Correlation coefficients of a covariance matrix.

    P, shape (n, n): covariance; all variances are positive.
    Return C, shape (n, n): numbers without a unit, between -1 and 1.
    """
    s = np.sqrt(np.diag(P))
    return P / np.outer(s, s)


corr = Exercise(
    "06.1",
    "Correlation coefficients",
    correlation,
    hints=(
        "The correlation of two numbers is their covariance, measured in units of their standard deviations.",
        "C[i, j] = P[i, j] / (s[i] * s[j]), where s holds the standard deviations: the roots of the diagonal of P.",
        "s = np.sqrt(np.diag(P)), and np.outer(s, s) is the table of all products s[i] * s[j].",
    ),
)


@corr.link("shape", "C has one entry for each entry of P.")
def _(f, rng):
    for n in (2, 5, 1):
        expect.array(f(random_covariance(rng, n)), (n, n), "C")


@corr.link("the diagonal", "Every number is fully correlated with itself: C[i, i] = 1.")
def _(f, rng):
    P = random_covariance(rng, 4) * np.outer([1, 20, 0.1, 3], [1, 20, 0.1, 3])
    expect.close(np.diag(expect.array(f(P), (4, 4), "C")), np.ones(4), "the diagonal of C")


@corr.link("two numbers", "Divide the covariance by the two standard deviations: one each.")
def _(f, rng):
    for s, t, c in ((2.0, 0.5, 0.8), (0.1, 3.0, -0.6), (1.0, 1.0, 0.0)):
        P = np.array([[s * s, c * s * t], [c * s * t, t * t]])
        expect.close(expect.array(f(P), (2, 2), "C"), [[1, c], [c, 1]], "C", at=f"sigmas {s} and {t}")


@corr.link("many numbers", "C[i, j] = P[i, j] / (s[i] s[j]), for every pair.")
def _(f, rng):
    for n in (3, 7):
        P = random_covariance(rng, n)
        want = [[P[i, j] / np.sqrt(P[i, i] * P[j, j]) for j in range(n)] for i in range(n)]
        expect.close(expect.array(f(P), (n, n), "C"), want, "C")


@corr.link("other units", "A correlation has no unit: in centimetres it is the same as in metres.")
def _(f, rng):
    P, u = random_covariance(rng, 5), np.array([100.0, 1.0, 57.3, 1e-3, 1e4])
    C = expect.array(f(P), (5, 5), "C")
    expect.close(expect.array(f(P * np.outer(u, u)), (5, 5), "C"), C, "C in other units")


def _wrong(name, hint, answer):
    corr.wrong(name, hint)(answer)


# fmt: off
_wrong("divided by the variances", "The diagonal of P holds variances. A correlation is in units of the standard "
       "deviations: take the roots.", lambda P: P / np.outer(np.diag(P), np.diag(P)))
_wrong("divided by one of them", "Two numbers, two standard deviations: divide by s[i] *and* s[j].",
       lambda P: P / np.sqrt(np.diag(P)))
_wrong("divided by one variance", "Divide by s[i] s[j], not by the variance of one of the two.",
       lambda P: P / np.diag(P))
_wrong("divided by the rows' variance", "Divide by s[i] s[j], not by the variance of one of the two.",
       lambda P: P / np.diag(P)[:, None])
_wrong("the covariance itself", "These are covariances, with units. Divide by the standard deviations.",
       lambda P: 1 * P)
_wrong("always positive", "Keep the sign: two errors may go in opposite directions.",
       lambda P: np.abs(P) / np.sqrt(np.outer(np.diag(P), np.diag(P))))
_wrong("squared", "That is the square of the correlation: the sign is lost.",
       lambda P: P**2 / np.outer(np.diag(P), np.diag(P)))
_wrong("scaled by the largest", "One scale for all does not make the diagonal 1: each number has its own sigma.",
       lambda P: P / P.max())
_wrong("multiplied", "Divide by the standard deviations, do not multiply.",
       lambda P: P * np.outer(np.sqrt(np.diag(P)), np.sqrt(np.diag(P))))
_wrong("np.corrcoef of P", "np.corrcoef wants samples, not a covariance matrix.",
       lambda P: np.corrcoef(P) if len(P) > 1 else np.ones((1, 1)))
# fmt: on


@corr.variant("scaled from both sides")
def _(P):
    D = np.diag(1 / np.sqrt(np.diag(P)))
    return D @ P @ D


@corr.variant("two loops, lists")
def _(P):
    n = len(P)
    return [[P[i][j] / (P[i][i] * P[j][j]) ** 0.5 for j in range(n)] for i in range(n)]


@corr.variant("rows, then columns")
def _(P):
    s = np.diag(P) ** 0.5
    return P / s / s[:, None]
