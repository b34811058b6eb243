"""Exercise 03.2: the average NEES and the band it should stay in."""

import numpy as np
from scipy.stats import chi2, norm

from .. import expect
from ..exercise import Exercise
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


averaged = Exercise(
    "03.2",
    "ANEES and its band",
    anees,
    hints=(
        "One run: NEES = e' P^-1 e, chi-square with n degrees of freedom. What is the distribution of a *sum* of N?",
        "The sum of N independent NEES is chi-square with N n degrees of freedom. Its band, divided by N, is that of "
        "the average.",
        "With tail = (1 - confidence) / 2 the band is chi2.ppf(tail, N n) / N to chi2.ppf(1 - tail, N n) / N.",
    ),
)


def case(rng, N, n, scale=1.0):
    """Return errors and covariances that are honest, correlated, and different in each run."""
    P = np.array([random_covariance(rng, n, scale * rng.uniform(0.3, 3)) for _ in range(N)])
    return np.array([np.linalg.cholesky(P_i) @ rng.standard_normal(n) for P_i in P]), P


def _two(result):
    average, band = expect.results(result, "average", "band")
    return float(expect.array(average, (), "average")), expect.array(band, 2, "band")


def average(e, P):
    """Mean of e' P^-1 e."""
    return float(np.mean([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)]))


@averaged.link("two results", "The function must end with `return average, band`: a number, and two numbers.")
def _(f, rng):
    for N, n in ((20, 3), (5, 2)):
        _two(f(*case(rng, N, n), 0.95))


@averaged.link("one run, one number", "One error of 0.2 m with sigma 0.1 m: (0.2 / 0.1)^2 = 4.", part=0)
def _(f, rng):
    got = _two(f(np.array([[0.2]]), np.array([[[0.01]]]), 0.95))[0]
    expect.close(got, 4.0, "the average", at="one error of 0.2 with the variance 0.01")


@averaged.link("average", "NEES of each run first, e' P^-1 e with its own P, then the mean over the runs.", part=0)
def _(f, rng):
    for N, n in ((20, 3), (7, 2), (3, 5), (40, 1), (6, 3)):
        e, P = case(rng, N, n, rng.choice([1e-4, 1.0]))
        expect.close(_two(f(e, P, 0.95))[0], average(e, P), "the average", at=f"{N} runs, {n} numbers each")


@averaged.link("band of one run", "With one run the band is that of chi-square with n degrees of freedom.", part=1)
def _(f, rng):
    for n in (3, 2, 6):
        got = _two(f(*case(rng, 1, n), 0.95))[1]
        expect.close(got, chi2.ppf([0.025, 0.975], n), "the band", 1e-5, at=f"one run of {n} numbers, 95 %")


@averaged.link("band of 20 runs", "20 runs, 3 numbers each, 95 %: the band is 2.02 to 4.16.", part=1)
def _(f, rng):
    for N, n in ((20, 3), (50, 3), (8, 2), (3, 6)):
        got = _two(f(*case(rng, N, n), 0.95))[1]
        expect.close(got, chi2.ppf([0.025, 0.975], N * n) / N, "the band", 1e-5, at=f"{N} runs of {n} numbers, 95 %")


@averaged.link("confidence", "The band gets wider with the confidence: equal parts are left out on both sides.", part=1)
def _(f, rng):
    for N, n, c in ((20, 3, 0.99), (5, 2, 0.5), (10, 4, 0.999)):
        got = _two(f(*case(rng, N, n), c))[1]
        want = chi2.ppf([(1 - c) / 2, (1 + c) / 2], N * n) / N
        expect.close(got, want, "the band", 1e-5, at=f"{N} runs of {n} numbers, confidence {c:g}")


@averaged.link("unit", "Metres or millimetres: the NEES has no unit and must not change.", part=0)
def _(f, rng):
    e, P = case(rng, 6, 3)
    S = np.diag([1e3, 1e-2, 5.0])
    a, b = _two(f(e, P, 0.95))[0], _two(f(e @ S, S @ P @ S, 0.95))[0]
    expect.close(b, a, "the average after a change of units", 1e-5)


def _wrong(name, hint, average=average, band=None):
    """A misconception in the average(e, P) or in the band(N, n, tail, average)."""

    @averaged.wrong(name, hint)
    def _(e, P, confidence):
        (N, n), tail = e.shape, (1 - confidence) / 2
        a = average(e, P)
        return a, np.array(band(N, n, tail, a) if band else chi2.ppf([tail, 1 - tail], N * n) / N)


def _mean(one):
    return lambda e, P: float(np.mean([one(a, B) for a, B in zip(e, P, strict=True)]))


# fmt: off
_wrong("multiplied by P", "A large P forgives a large error: *divide* by P, e' P^-1 e.", _mean(lambda a, B: a @ B @ a))
_wrong("no P at all", "That is the squared error in metres. Normalised means: measured in units of P, e' P^-1 e.",
       _mean(lambda a, B: a @ a))
_wrong("square root", "That is the Mahalanobis distance. The NEES is its square: no root.",
       _mean(lambda a, B: np.sqrt(a @ np.linalg.solve(B, a))))
_wrong("diagonal of P only", "The errors are correlated: use the whole P, not only its diagonal.",
       _mean(lambda a, B: (a * a / np.diag(B)).sum()))
_wrong("entry by entry", "1 / P takes the inverse of each entry. A matrix wants np.linalg.inv, or solve.",
       _mean(lambda a, B: a @ (1 / B) @ a))
_wrong("variances taken for sigmas", "The diagonal of P holds variances already: do not square them.",
       _mean(lambda a, B: (a * a / np.diag(B) ** 2).sum()))
_wrong("divided by the dimension", "Some authors divide by n, so that 1 is honest. Here the average stays near n.",
       _mean(lambda a, B: a @ np.linalg.solve(B, a) / len(a)))
_wrong("sum instead of mean", "That is the sum of all runs. The average is the sum divided by N.",
       lambda e, P: average(e, P) * len(e))
_wrong("NEES of the mean error", "Errors of both signs cancel in the mean. Take the NEES of each run, then the mean.",
       lambda e, P: e.mean(0) @ np.linalg.solve(P.mean(0), e.mean(0)))
_wrong("one P for all runs", "Each run has its own P: P[i] belongs to e[i].",
       lambda e, P: float(np.mean([a @ np.linalg.solve(P[0], a) for a in e])))
_wrong("mean P", "Each run has its own P: do not average the covariances first.",
       lambda e, P: float(np.mean([a @ np.linalg.solve(P.mean(0), a) for a in e])))
_wrong("median", "The band is about the mean of the runs, not about their median.",
       lambda e, P: float(np.median([a @ np.linalg.solve(B, a) for a, B in zip(e, P, strict=True)])))

_wrong("band of a single run", "That is the band of one run. The average of N runs scatters less.",
       band=lambda N, n, t, a: chi2.ppf([t, 1 - t], n))
_wrong("band of the sum", "That is the band of the *sum* of N runs. Divide it by N.",
       band=lambda N, n, t, a: chi2.ppf([t, 1 - t], N * n))
_wrong("n forgotten in the degrees of freedom", "Each of the N runs brings n degrees of freedom: N n in all.",
       band=lambda N, n, t, a: chi2.ppf([t, 1 - t], N) / N)
_wrong("divided by the degrees of freedom", "The average is over N runs: divide the band by N, not by N n.",
       band=lambda N, n, t, a: chi2.ppf([t, 1 - t], N * n) / (N * n))
_wrong("all of the rest on each side", "1 - confidence is left out in *both* tails together: half of it on each side.",
       band=lambda N, n, t, a: chi2.ppf([2 * t, 1 - 2 * t], N * n) / N)
_wrong("lower end zero", "A filter can be too cautious, too: leave out half of the rest below and half above.",
       band=lambda N, n, t, a: (0.0, chi2.ppf(1 - 2 * t, N * n) / N))
_wrong("all of the rest above", "At the upper end only half of the rest is left out: 1 - tail, not the confidence.",
       band=lambda N, n, t, a: chi2.ppf([t, 1 - 2 * t], N * n) / N)
_wrong("all of the rest below", "At the lower end only half of the rest is left out: (1 - confidence) / 2.",
       band=lambda N, n, t, a: chi2.ppf([2 * t, 1 - t], N * n) / N)
_wrong("confidence in per cent", "The confidence is a number from 0 to 1: 1 - confidence is left out, not 100 - "
       "confidence.", band=lambda N, n, t, a: chi2.ppf([49.5 + t, 50.5 - t], N * n) / N)
_wrong("low and high swapped", "Return the lower end first.",
       band=lambda N, n, t, a: chi2.ppf([1 - t, t], N * n) / N)
_wrong("normal instead of chi-square", "n +- z sqrt(2 n / N) is good for many runs only. With few, use chi2.ppf.",
       band=lambda N, n, t, a: n + norm.ppf([t, 1 - t]) * np.sqrt(2 * n / N))
_wrong("always 95 %", "The third argument is the confidence: 0.95 is only an example.",
       band=lambda N, n, t, a: chi2.ppf([0.025, 0.975], N * n) / N)
# fmt: on


@averaged.variant("einsum and the inverse, chi2.interval")
def _(e, P, confidence):
    N, n = e.shape
    d = np.einsum("ki,kij,kj->k", e, np.linalg.inv(P), e)
    low, high = chi2.interval(confidence, N * n)
    return float(d.mean()), (low / N, high / N)


@averaged.variant("Cholesky factors, sums; as a list")
def _(e, P, confidence):
    N, n = len(e), len(e[0])
    total = sum(np.sum(np.linalg.solve(np.linalg.cholesky(B), a) ** 2) for a, B in zip(e, P, strict=True))
    return [total / N, [chi2.isf(0.5 + confidence / 2, N * n) / N, chi2.isf(0.5 - confidence / 2, N * n) / N]]


@averaged.variant("the package")
def _(e, P, confidence):
    from ...analysis import anees_band, md2

    return np.mean(md2(e, P)), anees_band(e.shape[1], len(e), confidence)
