"""Exercise 16.4: the weights of several hypotheses after a measurement."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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


weighed = Exercise(
    "16.4",
    "Which hypothesis explains the measurement",
    reweigh,
    hints=(
        "New weight: old weight times likelihood, all divided by their sum. A Gaussian has a factor before the exp.",
        "The likelihood is exp(-z^2 / (2 Z)) / sqrt(2 pi Z). A wide Gaussian is low in the middle: 1 / sqrt(Z) counts.",
        "log w - z^2 / (2 Z) - log(Z) / 2; subtract the largest of them *before* exp, then divide by the sum.",
    ),
)


def case(rng, H=5):
    """Weights that differ, innovations, and variances that differ."""
    w = rng.uniform(0.2, 1, H)
    return w / w.sum(), rng.normal(0, 0.6, H), rng.uniform(0.05, 1.5, H)


def _weights(result, H):
    w = expect.array(result, H, "w")
    expect.true(w.min() >= -1e-12, f"a weight is negative: {w.min():.3g}")
    return w


@weighed.link("one for each", "Return one weight for each hypothesis.")
def _(f, rng):
    for H in (5, 1, 2):
        expect.array(f(*case(rng, H)), H, "w")


@weighed.link("sum", "Divide by the sum: weights are probabilities.")
def _(f, rng):
    for H in (5, 3):
        got = expect.array(f(*case(rng, H)), H, "w")
        expect.close(got.sum(), 1.0, "the sum of the weights")


@weighed.link("equal likelihoods", "If all explain the measurement alike, the weights stay what they were.")
def _(f, rng):
    w, z, Z = case(rng)
    expect.close(_weights(f(w, 0 * z + 0.3, 0 * Z + 0.2), 5), w, "the weights", at="z and Z the same for all")


@weighed.link("innovations", "The smaller the innovation, the more likely: exp(-z^2 / (2 Z)).")
def _(f, rng):
    for H in (4, 6):
        w, z, Z = case(rng, H)
        args = (w, z, 0 * Z + 0.3)
        expect.close(_weights(f(*args), H), reweigh(*args), "the weights", at="Z the same for all")


@weighed.link("variances", "A Gaussian that is wide is low: 1 / sqrt(Z) is a part of the likelihood.")
def _(f, rng):
    for H in (4, 5, 1):
        args = case(rng, H)
        expect.close(_weights(f(*args), H), reweigh(*args), "the weights")


@weighed.link("far from all", "All likelihoods are 0 in the computer: subtract the largest logarithm before exp.")
def _(f, rng):
    w, z, Z = case(rng)
    args = (w, 40 + z, 0.01 * Z)
    expect.close(_weights(f(*args), 5), reweigh(*args), "the weights", at="innovations of 40 m")
    args = (w, 0.1 * z, 1e-10 * Z)
    expect.close(_weights(f(*args), 5), reweigh(*args), "the weights", at="very small variances")


def _wrong(name, hint, log):
    """A misconception: log(w, z, Z) are the logarithms of the new weights."""

    @weighed.wrong(name, hint)
    def _(w, z, Z):
        l = log(w, z, Z)
        new = np.exp(l - np.max(l))
        return new / new.sum()


# fmt: off
_wrong("height of the Gaussian forgotten", "A wide Gaussian is low in the middle: the factor 1 / sqrt(Z) is missing. "
       "Without it the most uncertain hypothesis wins.", lambda w, z, Z: np.log(w) - 0.5 * z**2 / Z)
_wrong("old weights forgotten", "What was known before counts: old weight *times* likelihood.",
       lambda w, z, Z: -0.5 * (z**2 / Z + np.log(Z)))
_wrong("Z taken for the sigma", "Z is a variance: exp(-z^2 / (2 Z)) / sqrt(Z), no square of Z.",
       lambda w, z, Z: np.log(w) - 0.5 * z**2 / Z**2 - np.log(Z))
_wrong("Z instead of its root", "The Gaussian has 1 / sqrt(Z) before the exp, not 1 / Z.",
       lambda w, z, Z: np.log(w) - 0.5 * z**2 / Z - np.log(Z))
_wrong("one half forgotten", "exp(-z^2 / (2 Z)): the one half is missing.",
       lambda w, z, Z: np.log(w) - z**2 / Z - 0.5 * np.log(Z))
_wrong("innovation not squared", "exp(-z^2 / (2 Z)): with z alone, an innovation of -1 m would be better than 0.",
       lambda w, z, Z: np.log(w) - 0.5 * (z / Z + np.log(Z)))
_wrong("sign of the exponent", "The larger the innovation, the *less* likely: exp(-...).",
       lambda w, z, Z: np.log(w) + 0.5 * z**2 / Z - 0.5 * np.log(Z))
_wrong("noise not used", "An innovation is large or small only beside its sigma: z^2 / Z.",
       lambda w, z, Z: np.log(w) - 0.5 * z**2)
# fmt: on


@weighed.wrong("zeros", "All the likelihoods are zero in the computer, and 0 / 0 is no number. Subtract the largest "
               "logarithm before exp.")  # fmt: skip
def _(w, z, Z):
    new = w * np.exp(-0.5 * z**2 / Z) / np.sqrt(Z)
    return new / new.sum()


@weighed.wrong("not divided by the sum", "Weights are probabilities: divide by their sum.")
def _(w, z, Z):
    return w * np.exp(-0.5 * z**2 / Z) / np.sqrt(2 * np.pi * Z)


@weighed.wrong("added", "Weight *times* likelihood: in logarithms this is a sum, in the weights it is not.")
def _(w, z, Z):
    new = w + np.exp(-0.5 * z**2 / Z) / np.sqrt(2 * np.pi * Z)
    return new / new.sum()


@weighed.wrong("winner takes all", "One measurement seldom decides. Keep the weights of all hypotheses.")
def _(w, z, Z):
    best = np.argmax(np.log(w) - 0.5 * (z**2 / Z + np.log(Z)))
    return np.eye(len(w))[best]


@weighed.variant("with scipy")
def _(w, z, Z):
    from scipy.special import softmax
    from scipy.stats import norm

    return softmax(np.log(w) + norm.logpdf(z, scale=np.sqrt(Z)))


@weighed.variant("one by one")
def _(w, z, Z):
    logs = [np.log(a) - b * b / (2 * c) - np.log(2 * np.pi * c) / 2 for a, b, c in zip(w, z, Z, strict=True)]
    return [float(1 / np.sum(np.exp(np.clip(np.array(logs) - one, -700, 700)))) for one in logs]
