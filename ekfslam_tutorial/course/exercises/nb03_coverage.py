"""Exercise 03.1: how much a k-sigma ellipse holds."""

import numpy as np
from scipy.special import erf, gammainc
from scipy.stats import chi2, norm

from .. import expect
from ..exercise import Exercise


def coverage(k, dof):
    """Probability that the k-sigma ellipse of a Gaussian contains the truth.

    k, shape (m,): several sizes of the ellipse, all > 0; an array, so that k**2 squares each of them.
    dof = 1, 2, 3, ...: the dimension (an interval, an ellipse, an ellipsoid, ...).
    Return the probability for each k, shape (m,): numbers between 0 and 1.
    """
    return chi2.cdf(k**2, dof)


covered = Exercise(
    "03.1",
    "How much does a k-sigma ellipse hold?",
    coverage,
    hints=(
        "The truth is inside if e' P^-1 e < k^2. Which distribution does e' P^-1 e have?",
        "It is a sum of dof squared standard normal numbers: chi-square with dof degrees of freedom.",
        "The probability that it is below k^2 is the cdf: chi2.cdf(..., dof) of scipy.stats.",
    ),
)


def _p(f, k, dof):
    return expect.array(f(np.array(k, float), dof), len(k), "the result")


@covered.link("between 0 and 1", "Probabilities, one for each k: numbers from 0 to 1, not per cent.")
def _(f, rng):
    for k, dof in (([1.0, 2.0, 3.0], 2), ([2.0], 1), ([0.5, 3.0], 3)):
        p = _p(f, k, dof)
        expect.true(np.all((p >= 0) & (p <= 1)), f"coverage({k}, {dof}) is {p.round(4).tolist()}: no probabilities")


@covered.link("one dimension", "For dof = 1 you know: 68.3 %, 95.4 % and 99.7 %. Inside means e' P^-1 e < k^2.")
def _(f, rng):
    want = [0.682689492, 0.954499736, 0.997300204]
    expect.close(_p(f, [1, 2, 3], 1), want, "coverage([1, 2, 3], 1)", 1e-6)


@covered.link("two dimensions", "In the plane the probability is 1 - exp(-k^2 / 2).")
def _(f, rng):
    k = np.array([1.0, 3.0, 0.5, 2.0, 2.5])
    expect.close(_p(f, k, 2), 1 - np.exp(-(k**2) / 2), f"coverage({k.tolist()}, 2)", 1e-6)


@covered.link("any dimension", "The same formula must hold for 1, 2, 3, 6 ... dimensions.")
def _(f, rng):
    for dof in (3, 6, 4, 1, 11, 2, 32):
        k = rng.uniform(0.3, 1.3, 1 + dof % 5) * np.sqrt(dof)
        expect.close(_p(f, k, dof), gammainc(dof / 2, k * k / 2), f"coverage({k.round(3).tolist()}, {dof})", 1e-6)


@covered.link("a cloud of points", "Draw many points from the Gaussian and count those inside: they must agree.")
def _(f, rng):
    for dof in (2, 5):
        inside = np.mean((rng.standard_normal((20000, dof)) ** 2).sum(1) < 2.0**2)
        # 20000 draws: the share is right within 3.3 sqrt(0.25 / 20000) = 1.2 % (99.9 %)
        got = _p(f, [2.0], dof)[0]
        expect.true(abs(inside - got) < 0.015, f"{100 * inside:.1f} % are inside 2 sigma, yours is {100 * got:.1f} %")


def _wrong(name, hint, p):
    covered.wrong(name, hint)(p)


_wrong("k not squared", "chi-square is about *squared* distances: inside means e' P^-1 e < k^2.",
       lambda k, dof: chi2.cdf(k, dof))  # fmt: skip
_wrong("one dimension for all", "That is right for one number. An ellipse holds less: use dof.",
       lambda k, dof: erf(k / np.sqrt(2)))  # fmt: skip
_wrong("a box instead of an ellipse", "The power of the 1D value belongs to a *box*. An ellipse has no corners.",
       lambda k, dof: erf(k / np.sqrt(2)) ** dof)  # fmt: skip
_wrong("the probability outside", "That is the probability to be outside. Take 1 minus it: the cdf, not the sf.",
       lambda k, dof: chi2.sf(k**2, dof))  # fmt: skip
_wrong("always the plane", "1 - exp(-k^2 / 2) is right for two dimensions only: use dof.",
       lambda k, dof: 1 - np.exp(-(k**2) / 2))  # fmt: skip
_wrong("one side only", "norm.cdf counts all that is below +k, the far left as well: the interval has two ends.",
       lambda k, dof: norm.cdf(k))  # fmt: skip
_wrong("density", "pdf is the density. A probability is the cdf.",
       lambda k, dof: chi2.pdf(k**2, dof))  # fmt: skip
_wrong("arguments swapped", "scipy wants the value first: chi2.cdf(value, degrees of freedom).",
       lambda k, dof: chi2.cdf(dof, k**2))  # fmt: skip
_wrong("per cent", "Return a probability from 0 to 1, not per cent.",
       lambda k, dof: 100 * chi2.cdf(k**2, dof))  # fmt: skip
_wrong("the inverse", "ppf turns a probability into a value. Here you have the value, k^2, and want the probability.",
       lambda k, dof: chi2.ppf(coverage(k, dof), dof))  # fmt: skip
_wrong("degrees of freedom minus one", "Nothing was fitted here: the degrees of freedom are the dimension itself.",
       lambda k, dof: chi2.cdf(k**2, max(dof - 1, 1)))  # fmt: skip


_wrong("one degree of freedom too many", "The degrees of freedom are the dimension itself: dof.",
       lambda k, dof: chi2.cdf(k**2, dof + 1))  # fmt: skip
_wrong("k doubled, not squared", "chi-square is about *squared* distances: k squared, k**2, not 2 k.",
       lambda k, dof: chi2.cdf(2 * k, dof))  # fmt: skip
_wrong("one side of a box", "norm.cdf counts the far left as well, and the power belongs to a box, not to an ellipse.",
       lambda k, dof: norm.cdf(k) ** dof)  # fmt: skip


@covered.variant("incomplete gamma function")
def _(k, dof):
    return gammainc(dof / 2, np.asarray(k) ** 2 / 2)


@covered.variant("one by one, a list of plain floats")
def _(k, dof):
    return [float(1 - chi2(df=dof).sf(k_i * k_i)) for k_i in k]


@covered.variant("by recursion over the dimension")
def _(k, dof):
    from math import gamma

    p = erf(k / 2**0.5) if dof % 2 else 1 - np.exp(-k * k / 2)
    for n in range(2 - dof % 2, dof, 2):
        p = p - (k * k / 2) ** (n / 2) * np.exp(-k * k / 2) / gamma(n / 2 + 1)
    return p
