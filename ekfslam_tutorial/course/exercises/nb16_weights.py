"""Exercise 16.4: the weights of several hypotheses after a measurement."""

import numpy as np

from .. import expect
from ..table import table


def reweigh(w, z, Z):
    """Weights of H hypotheses after a measurement: the rule of Bayes.

    w, shape (H,): the weights before, all positive; their sum is 1. Each hypothesis has its innovation z, shape (H,)
    (m), with the variance Z, shape (H,) (m^2): under that hypothesis z is drawn from a Gaussian, mean 0, variance Z.
    The likelihoods may all be as small as exp(-10000), where a computer has only zeros: work with their logarithms.
    Return the new weights, shape (H,), with the sum 1.
    """
    log_w = np.log(w) - 0.5 * (np.square(z) / Z + np.log(Z))
    new = np.exp(log_w - np.max(log_w))
    return new / new.sum()


def case(rng, H=5, z=None, Z=None):
    """Weights that differ, innovations, and variances that differ, or those given for all."""
    w, zs, Zs = rng.uniform(0.2, 1, H), rng.normal(0, 0.6, H), rng.uniform(0.05, 1.5, H)
    return w / w.sum(), zs if z is None else np.full(H, z), Zs if Z is None else np.full(H, Z)


def scaled(w, z, Z, by=1.0, more=0.0, Z_by=1.0):
    """The same with other sizes of the innovations and the variances."""
    return w, by * z + more, Z_by * Z


weighed = table(
    "16.4 Which hypothesis explains the measurement",
    reweigh,
    hints=(
        "New weight: old weight times likelihood, all divided by their sum. A Gaussian has a factor before the exp.",
        "The likelihood is exp(-z^2 / (2 Z)) / sqrt(2 pi Z). A wide Gaussian is low in the middle: 1 / sqrt(Z) counts.",
        "log w - z^2 / (2 Z) - log(Z) / 2; subtract the largest of them *before* exp, then divide by the sum.",
    ),
    returns="w",
    cases={
        "any": lambda rng: [case(rng, H) for H in (4, 5, 2, 1)],
        "alike": lambda rng: [case(rng, z=0.3, Z=0.2)],
        "equal Z": lambda rng: [case(rng, H, Z=0.3) for H in (4, 6)],
        "unlikely": lambda rng: [(np.array([0.4, 0.3, 0.2, 0.1]), np.array([0.1, 1.25, 0.3, -0.95]), np.full(4, 0.1))],
        "far": lambda rng: [scaled(*case(rng), 1, 40, 0.01), scaled(*case(rng), 0.1, 0, 1e-10)],
    },
    checks="""
    equal likelihoods | w | alike   | New weight = old weight times likelihood: if all explain the measurement alike, the weights stay what they were.
    innovations       | w | equal Z | All have the same Z here: the likelihood of each is exp(-z^2 / (2 Z)), but for a factor that all share. It is largest at z = 0 and falls to both sides.
    variances         | w | any     | The variances differ here: each hypothesis has the Gaussian of its own Z, exp(-z^2 / (2 Z)) / sqrt(Z) but for a factor that all share. One that is wide is low.
    unlikely ones     | w | unlikely | Two of the four explain little here. By the rule of Bayes their new weights are old weight times likelihood, divided by the sum, as those of the other two are: small numbers above 0.
    far from all      | w | far     | All likelihoods are as good as 0 here, but their logarithms are ordinary numbers: take these as they are, and subtract the largest before exp.
    """,
    wrong="""
    height of the Gaussian forgotten | / Z + np.log(Z)) -> / Z) | A wide Gaussian is low in the middle: the factor 1 / sqrt(Z) is missing. Without it the most uncertain hypothesis wins.
    old weights forgotten | np.log(w) - 0.5 -> -0.5 | What was known before counts: old weight *times* likelihood.
    Z taken for the sigma | / Z + np.log(Z)) -> / Z**2 + np.log(Z**2)) | Z is a variance: exp(-z^2 / (2 Z)) / sqrt(Z), no square of Z.
    Z instead of its root | + np.log(Z)) -> + 2 * np.log(Z)) | The Gaussian has 1 / sqrt(Z) before the exp, not 1 / Z.
    one half forgotten | np.square(z) / Z -> 2 * np.square(z) / Z | exp(-z^2 / (2 Z)): the one half is missing.
    innovation not squared | np.square(z) -> z | exp(-z^2 / (2 Z)): with z alone, an innovation of -1 m would be better than 0.
    absolute value | np.square(z) -> np.abs(z) | exp(-z^2 / (2 Z)): the square of z, not its absolute value.
    sign of the height | / Z + np.log(Z)) -> / Z - np.log(Z)) | A wide Gaussian is low: the likelihood is divided by sqrt(Z), so log(Z) / 2 is taken off its logarithm.
    sign of the exponent | np.square(z) / Z -> -np.square(z) / Z | The larger the innovation, the *less* likely: exp(-...).
    noise not used | (np.square(z) / Z + np.log(Z)) -> np.square(z) | An innovation is large or small only beside its sigma: z^2 / Z.
    zeros | np.exp(log_w - np.max(log_w)) -> np.exp(log_w) | Likelihoods like exp(-10000) are zero in the computer, and 0 / 0 is no number. Subtract the largest logarithm before exp: then the largest is exp(0) = 1.
    not divided by the sum | return new / new.sum() -> return np.exp(log_w) / np.sqrt(2 * np.pi) | Weights are probabilities: divide by their sum.
    divided by the largest | new.sum() -> new.max() | Weights are probabilities: divide by their *sum*, not by the largest.
    added | new = np.exp(log_w - np.max(log_w)) -> new = w + np.exp(-0.5 * z**2 / Z) / np.sqrt(2 * np.pi * Z) | Weight *times* likelihood: in logarithms this is a sum, in the weights it is not.
    added to the scaled likelihood | new = np.exp(log_w - np.max(log_w)) -> new = w + np.exp(log_w - np.log(w) - np.max(log_w - np.log(w))) | Weight *times* likelihood: in logarithms this is a sum, in the weights it is not.
    winner takes all | return new / new.sum() -> return np.eye(len(w))[np.argmax(new)] | One measurement seldom decides. Keep the weights of all hypotheses.
    w for its logarithm | np.log(w) - 0.5 -> w - 0.5 | The logarithm of a product is the sum of both logarithms: log w + log L, not w + log L.
    small ones dropped | return new / new.sum() -> new = new / new.sum(); new = np.where(new < 0.01, 0, new); return new / new.sum() | The rule of Bayes drops nothing: a hypothesis of 1 % keeps its weight here.
    mean taken off | log_w = np.log(w) - 0.5 * (np.square(z) / Z -> z = z - np.sum(w * z); log_w = np.log(w) - 0.5 * (np.square(z) / Z | The innovations are taken as they are: each hypothesis says what it expects, and a mean of them says nothing.
    Z for its root in the exponent | np.square(z) / Z + -> np.square(z / Z) + | Z is a variance: z^2 / Z, not (z / Z)^2.
    small ones dropped, beside the best | return new / new.sum() -> new = np.where(new < 1e-3, 0, new); return new / new.sum() | The rule of Bayes drops nothing: a hypothesis that is a thousand times less likely than the best keeps its weight here.
    """,
)


@weighed.link(
    "sum",
    "Weights are probabilities, with the sum 1: old weight times likelihood of each, divided by the sum of these products.",
    before="equal likelihoods",
)
def _(f, rng):
    for H in (5, 3):
        expect.close(expect.array(f(*case(rng, H)), H, "w").sum(), 1.0, "the sum of the weights")
