"""Exercise 07.1: the gate, and what to do when two landmarks pass it."""

import numpy as np
from scipy.stats import chi2

from ..table import table
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


def away(rng, *sigmas, m=2, confidence=0.99, scales=(0.1, 1.0, 0.01, 0.3)):
    """Return innovations with these Mahalanobis distances (not squared), one for each landmark."""
    Zs = np.array([random_covariance(rng, m, scale) for scale in scales[: len(sigmas)]])
    zs = np.array([np.linalg.cholesky(Z) @ np.eye(m)[0] * d for d, Z in zip(sigmas, Zs, strict=True)])
    return zs, Zs, confidence


def some(rng, n):
    """Return innovations against n landmarks."""
    Zs = np.array([random_covariance(rng, 2, scale) for scale in rng.uniform(0.01, 2, n)])
    return rng.normal(size=(n, 2)), Zs, 0.99


def at_the_limit(rng):
    """Return innovations just inside and just outside of the gate; the other landmarks, m of them or none, are far."""
    limits = (
        (0.99, 3, 2.7, 3.2),  # 2 degrees of freedom let the first in, 1 does not
        (0.99, 2, 3.02, 3.05),
        (0.95, 2, 2.4, 2.5),
        (0.99, 1, 2.5, 2.65),
        (0.99, 3, 3.3, 3.45),
        (0.9, 2, 2.1, 2.2),
    )
    of_several = [
        away(rng, *[9.0] * m, sigma, m=m, confidence=confidence) for confidence, m, *both in limits for sigma in both
    ]
    return [*of_several, away(rng, 2.8)]  # alone in the map: with one degree of freedom it would be outside


def in_metres(rng):
    """Return two landmarks: 0.9 m away at 1.6 sigma, and 0.4 m away at 4.7 sigma."""
    wide, narrow = np.diag(np.square([0.6, 0.3])), np.diag(np.square([0.1, 0.02]))
    return np.array([[0.9, 0.2], [0.4, 0.05]]), np.array([wide, narrow]), 0.99


def distances(zs, Zs, confidence):
    """Return what the messages say of the arguments."""
    sigmas = ", ".join(f"{np.sqrt(z @ np.linalg.solve(Z, z)):.2f}" for z, Z in zip(zs, Zs, strict=True))
    return f"distances of {sigmas} sigma, m = {np.shape(zs)[1]}, confidence {confidence:g}"


gate = table(
    "07.1 The gate",
    choose,
    hints=(
        "The squared Mahalanobis distance is z' inv(Z) z: how large is z, in units of its own sigma?",
        "If the match is right, it is a chi-square number with m degrees of freedom. chi2.ppf(confidence, m) is the limit that a right match stays below with this probability.",
        "d2 = [z @ inv(Z) @ z for each landmark]; inside = np.flatnonzero(d2 <= chi2.ppf(confidence, m)); i is inside[0] if len(inside) == 1, else None.",
    ),
    returns="i, d2",
    kinds={"i": "an index counted from 0, or None"},
    shown=distances,
    cases={
        "any": lambda rng: [some(rng, n) for n in (4, 1, 6)],
        "one": lambda rng: [away(rng, *sigmas) for sigmas in ((2.0, 6.0, 7.0), (9.0, 2.5, 8.0), (30.0, 20.0, 2.9))],
        "none": lambda rng: [away(rng, 4.0, 6.0, 7.0), away(rng, 3.5)],
        "two": lambda rng: [away(rng, 1.0, 2.0, 7.0), away(rng, 9.0, 0.1, 2.9), away(rng, 1.0, 2.0, 0.5)],
        "metres": lambda rng: [in_metres(rng)],
        "limit": at_the_limit,
    },
    checks="""
    the distances       | d2 | any    | d2 = z' inv(Z) z, for each landmark, with the whole matrix Z.
    one landmark inside | i  | one    | Exactly one landmark passes the gate, d2 <= chi2.ppf(confidence, m): its index, a whole number from 0, is the answer.
    none inside         | i  | none   | If the measurement is far from every landmark, it belongs to none: return None.
    two inside          | i  | two    | Two landmarks are plausible: a wrong match is worse than none. Return None.
    metres mislead      | i  | metres | Near in metres is not near in sigma: the gate is a matter of d2.
    the limit           | i  | limit  | The gate is the chi-square quantile for m degrees of freedom: 9.2 for m = 2 and 99 %.
    """,
    wrong="""
    nearest of several | int(inside[0]) if len(inside) == 1 else None -> int(np.argmin(d2)) if len(inside) else None | Two landmarks pass the gate. The nearer one is only a guess: the ambiguous case must return None.
    index 0 becomes None | int(inside[0]) if len(inside) == 1 else None -> (int(inside[0]) if len(inside) == 1 else None) or None | Only index 0 becomes None: 0 counts as False in `if i` and in `i or None`. Ask `is None`, or len(inside) == 1.
    first of several | if len(inside) == 1 -> if len(inside) | Two landmarks pass the gate: which one comes first means nothing. Return None.
    divided by m | z @ np.linalg.solve(Z, z) -> z @ np.linalg.solve(Z, z) / len(z) | The gate of m degrees of freedom is for the sum, z' inv(Z) z: do not divide it by m.
    no gate | int(inside[0]) if len(inside) == 1 else None -> int(np.argmin(d2)) | The nearest landmark may be far away: without a gate every measurement is matched to something.
    Euclidean distance | z @ np.linalg.solve(Z, z) -> z @ z | z has a unit for each entry (m, rad), and each its own sigma: use z' inv(Z) z.
    not squared | z @ np.linalg.solve(Z, z) -> np.sqrt(z @ np.linalg.solve(Z, z)) | chi2.ppf is a limit for the *squared* distance: no root.
    root in the gate | d2 <= chi2 -> np.sqrt(d2) <= chi2 | chi2.ppf(confidence, m) is a limit for the *squared* distance: compare d2 with it as both are. In yours there is a root of d2, or a square of the limit.
    diagonal of Z | np.linalg.solve(Z, z) -> (z / np.diag(Z)) | The entries of z are correlated: use the whole Z.
    Z not inverted | np.linalg.solve(Z, z) -> Z @ z | In units of sigma: divide by Z, z' inv(Z) z.
    one Z for all | np.linalg.solve(Z, z) -> np.linalg.solve(Zs[0], z) | Each landmark has its own Z: Zs[k] belongs to zs[k].
    one degree of freedom | np.shape(zs)[1] -> 1 | d2 is a sum of m squares: chi2 has m degrees of freedom.
    one degree of freedom less | np.shape(zs)[1] -> np.shape(zs)[1] - 1 | d2 is a sum of m squares, and no mean was taken from them: chi2 has m degrees of freedom, not m - 1.
    two degrees of freedom always | np.shape(zs)[1] -> 2 | Do not fix the degrees of freedom to 2: m is the size of an innovation.
    as many degrees of freedom as landmarks | np.shape(zs)[1] -> len(zs) | Each landmark has its own gate, with m degrees of freedom.
    3 sigma | chi2.ppf(confidence, np.shape(zs)[1]) -> 9.0 | The limit follows from `confidence` and m: chi2.ppf(confidence, m).
    always 99 % | chi2.ppf(confidence, -> chi2.ppf(0.99, | The limit follows from `confidence`: 0.99 is only an example.
    root of the limit | chi2.ppf(confidence, np.shape(zs)[1]) -> np.sqrt(chi2.ppf(confidence, np.shape(zs)[1])) | d2 is the squared distance: compare it with chi2.ppf(confidence, m) itself, without a root.
    other tail | chi2.ppf(confidence, -> chi2.ppf(1 - confidence, | chi2.ppf(confidence, m), not of 1 - confidence: that gate lets almost nothing in.
    counted from 1 | int(inside[0]) -> int(inside[0]) + 1 | Indices are counted from 0 here.
    -1 for none | else None -> else -1 | Return None, not -1: -1 is the index of the last landmark.
    the list of all inside | int(inside[0]) if len(inside) == 1 else None -> inside.tolist() | Return one index or None, not a list.
    outside instead of inside | d2 <= chi2 -> d2 > chi2 | Inside is where d2 is *at most* the limit.
    quantile of both ends | chi2.ppf(confidence, -> chi2.ppf((1 + confidence) / 2, | A squared distance has one limit only: chi2.ppf(confidence, m). (1 + confidence) / 2 is for the two ends of a normal.
    confidence shared among the landmarks | chi2.ppf(confidence, -> chi2.ppf(1 - (1 - confidence) / len(zs), | Each landmark has its own gate, with `confidence` itself: a right match passes with this probability, however many landmarks there are.
    the other Cholesky factor | np.linalg.solve(Z, z) -> np.linalg.solve(np.linalg.cholesky(Z).T @ np.linalg.cholesky(Z), z) | With Z = L L' the whitened innovation is L^-1 z, and not the inverse of L' times z.
    nearest where none is inside | int(inside[0]) if len(inside) == 1 else None -> int(inside[0]) if len(inside) == 1 else (None if len(inside) else int(np.argmin(d2))) | If the measurement is far from every landmark, it belongs to none: return None, not the nearest.
    logarithm of the determinant added | z @ np.linalg.solve(Z, z) -> z @ np.linalg.solve(Z, z) + np.log(np.linalg.det(Z)) | The gate is for z' inv(Z) z alone. With log det Z it is a likelihood, and not chi-square.
    """,
)
