"""Exercise 07.1: the gate, and what to do when two landmarks pass it."""

import numpy as np
from scipy.stats import chi2

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def choose(zs, Zs, confidence):
    """Which landmark does one measurement belong to?

    zs, shape (n, m): its innovation against each of n landmarks, y - e, bearings wrapped.
    Zs, shape (n, m, m): the covariances of the innovations.
    confidence: a right match passes the gate with this probability; chi2 with m degrees of freedom.
    Return i, the index of the only landmark inside its gate; None if there is none, or if there are several.
    Return second d2, shape (n,): the squared Mahalanobis distances.
    """
    d2 = np.array([z @ np.linalg.solve(Z, z) for z, Z in zip(zs, Zs, strict=True)])
    inside = np.flatnonzero(d2 <= chi2.ppf(confidence, np.shape(zs)[1]))
    return (int(inside[0]) if len(inside) == 1 else None), d2


gate = Exercise(
    "07.1",
    "The gate",
    choose,
    hints=(
        "The squared Mahalanobis distance is z' inv(Z) z: how large is z, in units of its own sigma?",
        "If the match is right, it is a chi-square number with m degrees of freedom. chi2.ppf(confidence, m) is the "
        "limit that a right match stays below with this probability.",
        "d2 = [z @ inv(Z) @ z for each landmark]; inside = np.flatnonzero(d2 <= chi2.ppf(confidence, m)); i is "
        "inside[0] if len(inside) == 1, else None.",
    ),
)
STD = np.array([0.2, 0.03])
WIDE, NARROW = np.diag(np.square([0.6, 0.3])), np.diag(np.square([0.1, 0.02]))


def _out(result, n):
    i, d2 = expect.results(result, "i", "d2")
    return i, expect.array(d2, n, "d2")


def _index(i, want, what):
    if want is None:
        expect.true(i is None, f"{what}: i must be None, got {i!r:.40}")
        return
    expect.true(i is not None, f"{what}: i must be {want}, got None")
    good = isinstance(i, (int, np.integer, float)) and not isinstance(i, bool) and i == want
    if isinstance(i, np.ndarray):
        good = i.ndim == 0 and i == want
    expect.true(good, f"{what}: i must be {want} (an index, counted from 0), got {i!r:.40}")


def _d2(zs, Zs):
    L = np.linalg.cholesky(Zs)
    return np.sum(np.linalg.solve(L, zs[..., None])[..., 0] ** 2, -1)


def _case(k, Zs):
    """Innovations with given Mahalanobis distances k (not squared), in the direction of the first axis of Z."""
    return np.array([np.linalg.cholesky(Z) @ np.eye(len(Z))[0] * d for d, Z in zip(k, Zs, strict=True)])


@gate.link("two results", "End with `return i, d2`.")
def _(f, rng):
    Zs = np.array([random_covariance(rng, 2, 0.1) for _ in range(3)])
    _out(f(_case((1.0, 6.0, 7.0), Zs), Zs, 0.99), 3)


@gate.link("the distances", "d2 = z' inv(Z) z, for each landmark, with the whole matrix Z.", part=1)
def _(f, rng):
    for n in (4, 1, 6):
        Zs = np.array([random_covariance(rng, 2, s) for s in rng.uniform(0.01, 2, n)])
        zs = rng.normal(size=(n, 2))
        expect.close(_out(f(zs, Zs, 0.99), n)[1], _d2(zs, Zs), "d2")


@gate.link("one landmark inside", "Exactly one landmark passes the gate: that is the answer.", part=0)
def _(f, rng):
    for k, want in (((2.0, 6.0, 7.0), 0), ((9.0, 2.5, 8.0), 1), ((9.0, 20.0, 2.9), 2)):
        Zs = np.array([random_covariance(rng, 2, s) for s in (0.1, 1.0, 0.01)])
        _index(_out(f(_case(k, Zs), Zs, 0.99), 3)[0], want, f"distances {k} sigma")


@gate.link("none inside", "If the measurement is far from every landmark, it belongs to none: return None.", part=0)
def _(f, rng):
    Zs = np.array([random_covariance(rng, 2, 0.1) for _ in range(3)])
    _index(_out(f(_case((4.0, 6.0, 7.0), Zs), Zs, 0.99), 3)[0], None, "the nearest landmark is 4 sigma away")


@gate.link("two inside", "Two landmarks are plausible: a wrong match is worse than none. Return None.", part=0)
def _(f, rng):
    Zs = np.array([random_covariance(rng, 2, 0.1) for _ in range(3)])
    _index(_out(f(_case((1.0, 2.0, 7.0), Zs), Zs, 0.99), 3)[0], None, "landmarks at 1 and at 2 sigma")
    _index(_out(f(_case((9.0, 0.1, 2.9), Zs), Zs, 0.99), 3)[0], None, "landmarks at 0.1 and at 2.9 sigma")


@gate.link("metres mislead", "Near in metres is not near in sigma: the gate is a matter of d2.", part=0)
def _(f, rng):
    zs, Zs = np.array([[0.9, 0.2], [0.4, 0.05]]), np.array([WIDE, NARROW])
    _index(_out(f(zs, Zs, 0.99), 2)[0], 0, "a landmark 0.4 m away at 4.7 sigma, another 0.9 m away at 1.6 sigma")


@gate.link("the limit", "The gate is the chi-square quantile for m degrees of freedom: 9.2 for m = 2 and 99 %.", part=0)
def _(f, rng):
    for confidence, m, low, high in (
        (0.99, 2, 2.95, 3.1),
        (0.95, 2, 2.4, 2.5),
        (0.99, 1, 2.5, 2.65),
        (0.99, 3, 3.3, 3.45),
    ):
        Zs = np.array([random_covariance(rng, m, 0.1)])
        at = f"m = {m}, confidence {confidence}"
        _index(_out(f(_case((low,), Zs), Zs, confidence), 1)[0], 0, f"{low} sigma, {at}")
        _index(_out(f(_case((high,), Zs), Zs, confidence), 1)[0], None, f"{high} sigma, {at}")


def _pick(inside, d2):
    return int(inside[0]) if len(inside) == 1 else None


def _maha(zs, Zs):
    return np.array([z @ np.linalg.solve(Z, z) for z, Z in zip(zs, Zs, strict=True)])


def _wrong(name, hint, d2=_maha, limit=lambda c, m: chi2.ppf(c, m), pick=_pick):
    @gate.wrong(name, hint)
    def _(zs, Zs, confidence):
        d = d2(zs, Zs)
        return pick(np.flatnonzero(d <= limit(confidence, np.shape(zs)[1])), d), d


# fmt: off
_wrong("nearest of several", "Two landmarks pass the gate. The nearer one is only a guess: the ambiguous case must "
       "return None.", pick=lambda inside, d: int(np.argmin(d)) if len(inside) else None)
_wrong("first of several", "Two landmarks pass the gate: which one comes first means nothing. Return None.",
       pick=lambda inside, d: int(inside[0]) if len(inside) else None)
_wrong("no gate", "The nearest landmark may be far away: without a gate every measurement is matched to something.",
       pick=lambda inside, d: int(np.argmin(d)))
_wrong("Euclidean distance", "z has a unit for each entry (m, rad), and each its own sigma: use z' inv(Z) z.",
       d2=lambda zs, Zs: np.sum(np.square(zs), 1))
_wrong("not squared", "chi2.ppf is a limit for the *squared* distance: no root.",
       d2=lambda zs, Zs: np.sqrt(_maha(zs, Zs)))
_wrong("diagonal of Z", "The entries of z are correlated: use the whole Z.",
       d2=lambda zs, Zs: np.array([np.sum(np.square(z) / np.diag(Z)) for z, Z in zip(zs, Zs, strict=True)]))
_wrong("Z not inverted", "In units of sigma: divide by Z, z' inv(Z) z.",
       d2=lambda zs, Zs: np.array([z @ Z @ z for z, Z in zip(zs, Zs, strict=True)]))
_wrong("one degree of freedom", "d2 is a sum of m squares: chi2 has m degrees of freedom.",
       limit=lambda c, m: chi2.ppf(c, 1))
_wrong("two degrees of freedom always", "Do not fix the degrees of freedom to 2: m is the size of an innovation.",
       limit=lambda c, m: chi2.ppf(c, 2))
_wrong("as many degrees of freedom as landmarks", "Each landmark has its own gate, with m degrees of freedom.",
       limit=lambda c, m: chi2.ppf(c, m + 1))
_wrong("3 sigma", "The limit follows from `confidence` and m: chi2.ppf(confidence, m).", limit=lambda c, m: 9.0)
_wrong("other tail", "chi2.ppf(confidence, m), not of 1 - confidence: that gate lets almost nothing in.",
       limit=lambda c, m: chi2.ppf(1 - c, m))
_wrong("counted from 1", "Indices are counted from 0 here.",
       pick=lambda inside, d: int(inside[0]) + 1 if len(inside) == 1 else None)
_wrong("-1 for none", "Return None, not -1: -1 is the index of the last landmark.",
       pick=lambda inside, d: int(inside[0]) if len(inside) == 1 else -1)
_wrong("the list of all inside", "Return one index or None, not a list.", pick=lambda inside, d: inside.tolist())
_wrong("outside instead of inside", "Inside is where d2 is *at most* the limit.",
       pick=lambda inside, d: _pick(np.setdiff1d(np.arange(len(d)), inside), d))
# fmt: on


@gate.variant("with the inverse, a loop, lists")
def _(zs, Zs, confidence):
    d2, inside = [], []
    for i, (z, Z) in enumerate(zip(zs, Zs, strict=True)):
        d2.append(float(z @ np.linalg.inv(Z) @ z))
        if d2[-1] < chi2.ppf(confidence, len(z)):
            inside.append(i)
    return (inside[0] if len(inside) == 1 else None), d2


@gate.variant("probabilities instead of limits")
def _(zs, Zs, confidence):
    d2 = np.einsum("ni,nij,nj->n", zs, np.linalg.inv(Zs), zs)
    ok = chi2.cdf(d2, np.shape(zs)[-1]) <= confidence
    return (np.argmax(ok) if ok.sum() == 1 else None), d2


@gate.variant("Cholesky factors")
def _(zs, Zs, confidence):
    d2 = _d2(np.asarray(zs), np.asarray(Zs))
    i = [k for k in range(len(d2)) if d2[k] <= chi2.ppf(confidence, zs.shape[1])]
    return (i[0], d2) if len(i) == 1 else (None, d2)
