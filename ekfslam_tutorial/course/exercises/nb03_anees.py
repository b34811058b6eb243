"""Exercise 03.2: the average NEES and the band it should stay in."""

import numpy as np
from scipy.stats import chi2, norm  # noqa: F401  # norm: one of the wrong answers

from ..table import table
from .nb04_blocks import random_covariance


def anees(e, P, confidence):
    """Average normalised estimation error squared of N independent runs, and its band.

    e, shape (N, n): the error of each run, estimate minus truth. P, shape (N, n, n): its covariance, as the filter
    has it. confidence, for example 0.95: the average of an honest filter stays in the band with this probability;
    the rest is left out in equal parts below and above.
    Return the average, a number, and the band [low, high], shape (2,).
    """
    N, n = np.shape(e)
    nees = [e_i @ np.linalg.solve(P_i, e_i) for e_i, P_i in zip(e, P, strict=True)]
    tail = (1 - confidence) / 2
    band = chi2.ppf([tail, 1 - tail], N * n) / N
    return np.mean(nees), band


def some(rng, N, n, confidence=0.95, scale=1.0):
    """Return errors and covariances that are honest, correlated, and different in each run."""
    P = np.array([random_covariance(rng, n, scale * rng.uniform(0.3, 3)) for _ in range(N)])
    return np.array([np.linalg.cholesky(P_i) @ rng.standard_normal(n) for P_i in P]), P, confidence


def other_units(rng):
    """Return the same runs in two systems of units."""
    e, P, confidence = some(rng, 6, 3)
    S = np.diag([1e3, 1e-2, 5.0])
    return [(e, P, confidence), (e @ S, S @ P @ S, confidence)]


averaged = table(
    "03.2 ANEES and its band",
    anees,
    hints=(
        "One run: NEES = e' P^-1 e, chi-square with n degrees of freedom. What is the distribution of a *sum* of N?",
        "The sum of N independent NEES is chi-square with N n degrees of freedom. Its band, divided by N, is that of the average.",
        "With tail = (1 - confidence) / 2 the band is chi2.ppf(tail, N n) / N to chi2.ppf(1 - tail, N n) / N.",
    ),
    returns="average, band",
    cases={
        "any": lambda rng: [some(rng, 20, 3), some(rng, 5, 2)],
        "one number": lambda rng: [(np.array([[0.2], [0.2]]), np.array([[[0.01]], [[0.01]]]), 0.95)],
        "runs": lambda rng: [
            some(rng, N, n, 0.95, rng.choice([1e-4, 1.0])) for N, n in ((20, 3), (7, 2), (3, 5), (40, 1), (6, 3))
        ],
        "one run": lambda rng: [some(rng, 1, n) for n in (3, 2, 6)],
        "many runs": lambda rng: [some(rng, N, n) for N, n in ((20, 3), (50, 3), (8, 2), (3, 6))],
        "confidences": lambda rng: [some(rng, 20, 3, 0.99), some(rng, 5, 2, 0.5), some(rng, 10, 4, 0.999)],
        "units": other_units,
    },
    checks="""
    one number          | average | one number  | Two runs, each with an error of 0.2 m and a sigma of 0.1 m: (0.2 / 0.1)^2 = 4 in both, so the average is 4, one number.
    average             | average | runs        | NEES of each run first, e' P^-1 e with its own P, then the mean over the runs.
    band of one run     | band    | one run     | With one run the band [low, high] is that of chi-square with n degrees of freedom: half of 1 - confidence lies below low, half above high.
    band of 20 runs     | band    | many runs   | 20 runs, 3 numbers each, 95 %: the band is 2.02 to 4.16.
    confidence          | band    | confidences | The band gets wider with the confidence. For 0.99 half a per cent is left out below low and half a per cent above high; for 0.5 it is 25 % and 25 %.
    unit                | average | units       | Metres or millimetres: the NEES has no unit and must not change.
    """,
    wrong="""
    multiplied by P | np.linalg.solve(P_i, e_i) -> P_i @ e_i | A large P forgives a large error: *divide* by P, e' P^-1 e.
    no P at all | np.linalg.solve(P_i, e_i) -> e_i | That is the squared error in metres. Normalised means: measured in units of P, e' P^-1 e.
    square root | [e_i @ np.linalg.solve(P_i, e_i) -> [np.sqrt(e_i @ np.linalg.solve(P_i, e_i)) | That is the Mahalanobis distance. The NEES is its square: no root.
    diagonal of P only | np.linalg.solve(P_i, e_i) -> (e_i / np.diag(P_i)) | The errors are correlated: use the whole P, not only its diagonal.
    entry by entry | np.linalg.solve(P_i, e_i) -> (1 / P_i) @ e_i | 1 / P takes the inverse of each entry. A matrix wants np.linalg.inv, or solve.
    variances taken for sigmas | np.linalg.solve(P_i, e_i) -> (e_i / np.diag(P_i) ** 2) | The diagonal of P holds variances already: do not square them.
    divided by the dimension | np.mean(nees) -> np.mean(nees) / n | Some authors divide by n, so that 1 is honest. Here the average stays near n.
    average and band divided by the dimension | np.mean(nees) -> np.mean(nees) / n | Some authors divide by n, so that 1 is honest. Here the average stays near n, and so does the band.
        N * n) / N -> N * n) / (N * n)
    sum instead of mean | np.mean(nees) -> np.sum(nees) | That is the sum of all runs. The average is the sum divided by N.
    NEES of the mean error | np.mean(nees) -> e.mean(0) @ np.linalg.solve(P.mean(0), e.mean(0)) | Errors of both signs cancel in the mean. Take the NEES of each run, then the mean.
    one P for all runs | np.linalg.solve(P_i, e_i) -> np.linalg.solve(P[0], e_i) | Each run has its own P: P[i] belongs to e[i].
    mean P | np.linalg.solve(P_i, e_i) -> np.linalg.solve(P.mean(0), e_i) | Each run has its own P: do not average the covariances first.
    median | np.mean(nees) -> np.median(nees) | The band is about the mean of the runs, not about their median.
    last run only | np.mean(nees) -> nees[-1] | All N runs are averaged: yours is the NEES of the last one.
    band of a single run | N * n) / N -> n) | That is the band of one run. The average of N runs scatters less.
    band of the sum | N * n) / N -> N * n) | That is the band of the *sum* of N runs. Divide it by N.
    n forgotten in the degrees of freedom | N * n) / N -> N) / N | Each of the N runs brings n degrees of freedom: N n in all.
    divided by the degrees of freedom | N * n) / N -> N * n) / (N * n) | The average is over N runs: divide the band by N, not by N n.
    one degree of freedom lost | N * n) / N -> N * n - 1) / N | Nothing is estimated from these runs: the sum has all N n degrees of freedom, not N n - 1.
    all of the rest on each side | (1 - confidence) / 2 -> 1 - confidence | 1 - confidence is left out in *both* tails together: half of it on each side.
    lower end zero | [tail, 1 - tail] -> [0, 1 - 2 * tail] | A filter can be too cautious, too: leave out half of the rest below and half above.
    all of the rest above | [tail, 1 - tail] -> [tail, 1 - 2 * tail] | At the upper end only half of the rest is left out: 1 - tail, not the confidence.
    all of the rest below | [tail, 1 - tail] -> [2 * tail, 1 - tail] | At the lower end only half of the rest is left out: (1 - confidence) / 2.
    confidence in per cent | [tail, 1 - tail] -> [49.5 + tail, 50.5 - tail] | The confidence is a number from 0 to 1: 1 - confidence is left out, not 100 - confidence.
    low and high swapped | [tail, 1 - tail] -> [1 - tail, tail] | Return the lower end first.
    normal instead of chi-square | chi2.ppf([tail, 1 - tail], N * n) / N -> n + norm.ppf([tail, 1 - tail]) * np.sqrt(2 * n / N) | n +- z sqrt(2 n / N) is good for many runs only. With few, use chi2.ppf.
    always 95 % | (1 - confidence) / 2 -> 0.025 | The third argument is the confidence: 0.95 is only an example.
    N - 1 | np.mean(nees) -> np.divide(np.sum(nees), N - 1) | All N runs count, and no mean was estimated from them: divide the sum by N, not by N - 1.
    N - 1 in the band | chi2.ppf([tail, 1 - tail], N * n) -> chi2.ppf([tail, 1 - tail], (N - 1) * n) | All N runs count, and no mean was estimated from them: N n degrees of freedom, not (N - 1) n.
    mean error taken off | N, n = np.shape(e) -> e = e - np.mean(e, axis=0); N, n = np.shape(e) | The errors are taken as they are. Without their mean nobody sees that a filter is always wrong on the same side.
    the other Cholesky factor | np.linalg.solve(P_i, e_i) -> np.linalg.solve(np.linalg.cholesky(P_i).T @ np.linalg.cholesky(P_i), e_i) | With P = L L' the whitened error is L^-1 e, and not the inverse of L' times e.
    normal band of one run | chi2.ppf([tail, 1 - tail], N * n) / N -> n + norm.ppf([tail, 1 - tail]) * np.sqrt(2 * n) | That is about the band of *one* run. The average of N runs scatters less: chi-square with N n degrees of freedom, divided by N.
    """,
)
