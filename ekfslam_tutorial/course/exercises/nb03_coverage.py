"""Exercise 03.1: how much a k-sigma ellipse holds."""

import numpy as np
from scipy.special import erf  # noqa: F401  # some of the wrong answers
from scipy.stats import chi2, norm  # noqa: F401

from .. import expect
from ..table import table


def coverage(k, dof):
    """Probability that the k-sigma ellipse of a Gaussian contains the truth.

    k, shape (m,): several sizes of the ellipse, all > 0; an array, so that k**2 squares each of them.
    dof = 1, 2, 3, ...: the dimension (an interval, an ellipse, an ellipsoid, ...).
    Return the probability for each k, shape (m,): numbers between 0 and 1.
    """
    return chi2.cdf(k**2, dof)


def some(rng, dof):
    """Return several sizes near the border where most points lie."""
    return rng.uniform(0.3, 1.3, 1 + dof % 5) * np.sqrt(dof), dof


covered = table(
    "03.1 How much does a k-sigma ellipse hold?",
    coverage,
    hints=(
        "The truth is inside if e' P^-1 e < k^2. Which distribution does e' P^-1 e have?",
        "It is a sum of dof squared standard normal numbers: chi-square with dof degrees of freedom.",
        "The probability that it is below k^2 is the cdf: chi2.cdf(..., dof) of scipy.stats.",
    ),
    returns="p",
    rtol={"p": 1e-6},
    cases={
        "any": lambda rng: [(np.array(k), dof) for k, dof in (([1.0, 2.0, 3.0], 2), ([2.0], 1), ([0.5, 3.0], 3))],
        "line": lambda rng: [(np.array([1.0, 2.0, 3.0]), 1), (np.array([1, 2, 3]), 1)],
        "plane": lambda rng: [(np.array([1.0, 3.0, 0.5, 2.0, 2.5]), 2)],
        "all": lambda rng: [some(rng, dof) for dof in (3, 6, 4, 1, 11, 2, 32)],
    },
    checks="""
    one dimension  | p | line  | For dof = 1 you know: 68.3 %, 95.4 % and 99.7 %. Inside means e' P^-1 e < k^2, and that is chi-square with dof degrees of freedom; each k by itself.
    two dimensions | p | plane | In the plane the probability is 1 - exp(-k^2 / 2).
    any dimension  | p | all   | For every dof it is the probability that a sum of dof squared standard normal numbers is below k^2: the same formula for 1, 2, 3, 6 ... dimensions.
    """,
    wrong="""
    k not squared | k**2 -> k | chi-square is about *squared* distances: inside means e' P^-1 e < k^2.
    one dimension for all | chi2.cdf(k**2, dof) -> erf(k / np.sqrt(2)) | That is right for one number. An ellipse holds less: use dof.
    a box instead of an ellipse | chi2.cdf(k**2, dof) -> erf(k / np.sqrt(2)) ** dof | The power of the 1D value belongs to a *box*. An ellipse has no corners.
    the probability outside | chi2.cdf -> chi2.sf | That is the probability to be outside. The probability to be inside is 1 minus it: the cdf itself.
    always the plane | dof) -> 2) | 1 - exp(-k^2 / 2) is right for two dimensions only: use dof.
    always three dimensions | dof) -> 3) | The dimension is the argument dof: 3 is right for a point in space only.
    one side only | chi2.cdf(k**2, dof) -> norm.cdf(k) | That is the probability to be below +k, and the far left is in it as well: the interval has two ends.
    2 cdf - 1 | chi2.cdf(k**2, dof) -> 2 * chi2.cdf(k**2, dof) - 1 | 2 cdf - 1 belongs to the normal, which has two ends. A squared distance is below k^2 or not: the cdf itself.
    density | chi2.cdf -> chi2.pdf | pdf is the density. A probability is the cdf.
    arguments swapped | chi2.cdf(k**2, dof) -> chi2.cdf(dof, k**2) | scipy wants the value first: chi2.cdf(value, degrees of freedom).
    per cent | chi2.cdf -> 100 * chi2.cdf | Return a probability from 0 to 1, not per cent.
    the inverse | chi2.cdf(k**2, dof) -> k**2 | k^2 is a value of e' P^-1 e, no probability: wanted is the probability to be below it, the cdf.
    value for a probability | chi2.cdf -> chi2.ppf | ppf is the way back: from a probability to a value. Here you have the value, k^2, and want the probability: the cdf.
    degrees of freedom minus one | dof) -> max(dof - 1, 1)) | Nothing was fitted here: the degrees of freedom are the dimension itself.
    one degree of freedom too many | dof) -> dof + 1) | The degrees of freedom are the dimension itself: dof.
    k doubled, not squared | k**2 -> 2 * k | chi-square is about *squared* distances: k squared, k**2, not 2 k.
    one side of a box | chi2.cdf(k**2, dof) -> norm.cdf(k) ** dof | norm.cdf counts the far left as well, and the power belongs to a box, not to an ellipse.
    k squared divided by the dimension | k**2 -> k**2 / dof | e' P^-1 e is a sum of squares, not their mean: compare it with k^2, and the dimension enters by the degrees of freedom only.
    k divided by the dimension | k**2 -> (k / dof) ** 2 | k counts sigmas along every direction: the dimension enters by the degrees of freedom only.
    always the plane, without one half | chi2.cdf(k**2, dof) -> 1 - np.exp(-(k**2)) | In the plane it is 1 - exp(-k^2 / 2): the one half is missing. And that is for dof = 2 alone: chi2.cdf has the degrees of freedom as its second argument.
    """,
)


@covered.link(
    "between 0 and 1",
    "Probabilities, one for each k: numbers from 0 to 1, as chi2.cdf gives them.",
    before="one dimension",
)
def _(f, rng):
    for k, dof in covered.cases["any"](rng):
        p = expect.array(f(k, dof), len(k), "p")
        expect.true(np.all((p >= 0) & (p <= 1)), f"coverage({k}, {dof}) is {p.round(4).tolist()}: no probabilities")


CLOUD = "Draw many points from the Gaussian and count those inside: they must agree."


@covered.link("a cloud of points", CLOUD)
def _(f, rng):
    for dof in (2, 5):
        inside = np.mean((rng.standard_normal((20000, dof)) ** 2).sum(1) < 2.0**2)
        # 20000 draws: the share is right within 3.3 sqrt(0.25 / 20000) = 1.2 % (99.9 %)
        got = expect.array(f(np.array([2.0]), dof), 1, "p")[0]
        expect.true(abs(inside - got) < 0.015, f"{100 * inside:.1f} % are inside 2 sigma, yours is {100 * got:.1f} %")
