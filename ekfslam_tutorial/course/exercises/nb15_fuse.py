"""Exercise 15.2: covariance intersection, for estimates whose correlation nobody knows."""

from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def covariance_intersection(xa, Pa, xb, Pb):
    """Fuse two estimates of one state when nobody knows how much they have in common.

    xa and xb, shape (n,), are the two estimates, Pa and Pb, shape (n, n), their covariances. The rule is
        inv(P) = w inv(Pa) + (1 - w) inv(Pb),    x = P (w inv(Pa) xa + (1 - w) inv(Pb) xb)
    with that w between 0 and 1 for which the trace of P is smallest. It need not be exact: the trace may be larger by
    one part in a thousand.
    Return x, shape (n,), and P, shape (n, n).
    """
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    ws = np.linspace(0, 1, 1001)
    Ps = np.linalg.inv(ws[:, None, None] * Ia + (1 - ws[:, None, None]) * Ib)
    i = np.argmin(np.trace(Ps, axis1=1, axis2=2))
    w, P = ws[i], Ps[i]
    x = P @ (w * Ia @ xa + (1 - w) * Ib @ xb)
    return x, P


def case(rng, n=2, ratio=4.0):
    """Two estimates of different shape, not diagonal."""
    Pa, Pb = (random_covariance(rng, n) for _ in range(2))
    D = np.diag(np.geomspace(1, ratio, n))
    return rng.normal(size=n), D @ Pa @ D, rng.normal(size=n), D[::-1, ::-1] @ Pb @ D[::-1, ::-1]


def case_at(rng, w, n=2):
    """Two estimates of which w is the best weight, whatever other weights are tried: mistakes do not hide in the steps.

    With P_a = T diag(a) T' and P_b = T diag(b) T', the columns of T of length one, the trace of P is the sum of all
    1 / (w / a_i + (1 - w) / b_i); the last b is chosen so that its derivative by w is zero.
    """
    while True:
        T = rng.normal(size=(n, n))
        T /= np.linalg.norm(T, axis=0)
        a, b = 1 / rng.uniform(0.5, 2, n), 1 / rng.uniform(0.5, 2, n)
        slope = np.sum(((1 / a - 1 / b) / (w / a + (1 - w) / b) ** 2)[:-1])
        roots = np.roots(
            [slope * (1 - w) ** 2, 2 * slope * w * (1 - w) / a[-1] - 1, slope * (w / a[-1]) ** 2 + 1 / a[-1]]
        )
        good = [r.real for r in roots if abs(r.imag) < 1e-12 and 0.1 < r.real < 10]
        if good and abs(slope) > 0.1:
            b[-1] = 1 / good[0]
            return rng.normal(size=n), T @ np.diag(a) @ T.T, rng.normal(size=n), T @ np.diag(b) @ T.T


exercise = table(
    "15.2 Covariance intersection",
    covariance_intersection,
    hints=(
        "Try many w from 0 to 1 and keep the one whose P has the smallest trace. Then take x with the same w.",
        "For w in np.linspace(0, 1, 1001): P = inv(w inv(Pa) + (1 - w) inv(Pb)). np.trace(P) is the number to compare.",
        "Ia, Ib = inv(Pa), inv(Pb); the best w and its P; x = P @ (w * Ia @ xa + (1 - w) * Ib @ xb).",
    ),
    returns="x, P",
    form="Return x, shape (n,), and P, shape (n, n): the function must end with `return x, P`.",
    seconds=4,  # a loop over thousands of w, on a slow computer
    cases={"any": lambda rng: [case_at(rng, w, n) for w, n in ((0.3, 2), (0.6, 3), (0.2, 2))]},
    checks="",
    wrong="""
    information added: Adding the information is right for *independent* estimates. Here nobody knows that: each gets its weight, w and 1 - w.
        x = P @ (w * Ia @ xa + (1 - w) * Ib @ xb) -> P = np.linalg.inv(Ia + Ib); x = P @ (Ia @ xa + Ib @ xb)
    average, as if independent | return x, P -> return (xa + xb) / 2, (Pa + Pb) / 4 | (Pa + Pb) / 4 is the covariance of the mean of *independent* estimates. And the mean leaves open which one is better.
    average of both | return x, P -> return (xa + xb) / 2, (Pa + Pb) / 2 | Not covariances are averaged, but information, with a w that fits the two.
    covariances mixed | return x, P -> return w * xa + (1 - w) * xb, w * Pa + (1 - w) * Pb | The weights belong to the information matrices, inv(Pa) and inv(Pb), not to Pa and Pb.
    P not inverted | return x, P -> return x, np.linalg.inv(P) | w inv(Pa) + (1 - w) inv(Pb) is the information: its inverse is P.
    the better one alone | Ps = np.linalg.inv(ws[:, None, None] * Ia + (1 - ws[:, None, None]) * Ib) -> Ps = ws[:, None, None] * Pa + (1 - ws[:, None, None]) * Pb | Yours is one of the two alone, w is 0 or 1. Weigh the *informations*, inv(Pa) and inv(Pb): then the trace of P is smallest for a w in between.
    always one half | ws[i], Ps[i] -> ws[500], Ps[500] | w = 1/2 is allowed, but not the best: search for the smallest trace.
    trace of the information | np.trace(Ps, -> np.trace(np.linalg.inv(Ps), | The trace of the information is smallest where one of the two stands alone. Search for the smallest trace of P itself.
    weights forgotten in x | (w * Ia @ xa + (1 - w) * Ib @ xb) -> (Ia @ xa + Ib @ xb) | In x, too, each information has its weight, w and 1 - w.
    the largest trace | argmin -> argmax | The trace of P must be smallest: it is largest where the worse one of the two stands alone.
    determinant | np.trace(Ps, axis1=1, axis2=2) -> np.linalg.det(Ps) | Here the *trace* of P is to be smallest; the determinant makes another rule, and a usual one.
    weights of the traces | w, P = ws[i], Ps[i] -> w = np.trace(Pb) / np.trace(Pa + Pb); P = np.linalg.inv(w * Ia + (1 - w) * Ib) | w from the two traces is a rule of thumb. Search for the smallest trace.
    w exchanged in the mean | w * Ia @ xa + (1 - w) * Ib @ xb -> (1 - w) * Ia @ xa + w * Ib @ xb | The same w in both: w goes with a, 1 - w with b.
    mean without the covariances | P @ (w * Ia @ xa + (1 - w) * Ib @ xb) -> w * xa + (1 - w) * xb | The mean is weighted with the information, in each direction anew.
    mean of both | P @ (w * Ia @ xa + (1 - w) * Ib @ xb) -> (xa + xb) / 2 | The mean must lean to the better one: use the formula for x.
    mean not multiplied by P | P @ (w * Ia -> (w * Ia | w inv(Pa) xa + (1 - w) inv(Pb) xb is the information vector: x is P times it.
    each with the information of the other | w * Ia @ xa + (1 - w) * Ib @ xb -> w * Ib @ xa + (1 - w) * Ia @ xb | Each estimate is weighted with its own information: Ia with xa, Ib with xb.
    weights of the traces, the wrong way round | w, P = ws[i], Ps[i] -> w = np.trace(Pa) / np.trace(Pa + Pb); P = np.linalg.inv(w * Ia + (1 - w) * Ib) | w is searched: the one with the least trace of P. Yours comes from the traces, and gives the worse one the larger weight.
    diagonals inverted | Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb) -> Ia, Ib = np.diag(1 / np.diag(Pa)), np.diag(1 / np.diag(Pb)) | The inverse of a matrix is not that of its diagonal: the covariances in Pa and Pb count.
    few weights tried | np.linspace(0, 1, 1001) -> np.array([0.25, 0.5, 0.75]) | A few weights are not enough: search all of [0, 1] in small steps.
    largest trace of the information: The trace of the information is largest where one of the two stands alone. Search for the smallest trace of P itself.
        np.argmin(np.trace(Ps, -> np.argmax(np.trace(np.linalg.inv(Ps),
    """,
)


def _out(result, n):
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@exercise.link("the same estimate twice", "Hearing the same thing twice teaches nothing: x and P must stay.")
def _(f, rng):
    for n in (2, 3):
        xa, Pa, *_ = case(rng, n)
        x, P = _out(f(xa, Pa, xa, Pa), n)
        expect.close(P, Pa, "P", at="two equal estimates")
        expect.close(x, xa, "x", at="two equal estimates")


@exercise.link("the rule", "inv(P) = w inv(Pa) + (1 - w) inv(Pb), one w for both, between 0 and 1.")
def _(f, rng):
    for n in (2, 3, 5):
        xa, Pa, xb, Pb = case(rng, n)
        x, P = _out(f(xa, Pa, xb, Pb), n)
        w = _weight(P, Pa, Pb)
        want = np.linalg.inv(w * np.linalg.inv(Pa) + (1 - w) * np.linalg.inv(Pb))
        expect.close(P, want, "P", rtol=1e-5, at=f"the w that fits best, {w:.3f}")
        expect.true(-1e-6 <= w <= 1 + 1e-6, f"w is {w:.3g}: it must be between 0 and 1")


@exercise.link(
    "the best w",
    "Of all w between 0 and 1 take the one with the smallest trace of P. It may be larger by one part in a thousand: small steps of w will do.",
)
def _(f, rng):
    for n, ratio in ((2, 4.0), (3, 3.0), (2, 8.0), (1, 1.0)):
        xa, Pa, xb, Pb = case(rng, n, ratio)
        P = _out(f(xa, Pa, xb, Pb), n)[1]
        least = np.trace(best_weight(Pa, Pb)[0])
        expect.true(np.trace(P) <= 1.001 * least + 1e-12, f"trace(P) is {np.trace(P):.4g}; {least:.4g} is possible")


@exercise.link(
    "the mean",
    "x = P (w inv(Pa) xa + (1 - w) inv(Pb) xb), with the P that is returned and the w of it: inv(P) = w inv(Pa) + (1 - w) inv(Pb).",
)
def _(f, rng):
    for n in (2, 3, 1):
        xa, Pa, xb, Pb = case(rng, n)
        x, P = _out(f(xa, Pa, xb, Pb), n)
        w = _weight(P, Pa, Pb)
        want = P @ (w * np.linalg.solve(Pa, xa) + (1 - w) * np.linalg.solve(Pb, xb))
        expect.close(x, want, "x", rtol=1e-4, at=f"w = {w:.3f}")


@exercise.link(
    "one is better in all directions",
    "One of the two is better in all directions, Pb = 9 Pa or Pa = 9 Pb. It has all the weight, w = 1 if it is a, w = 0 if it is b: x and P are its own.",
)
def _(f, rng):
    xa, Pa, xb, _ = case(rng, 2)
    for of, *args in (("Pb = 9 Pa", xa, Pa, xb, 9 * Pa), ("Pa = 9 Pb", xb, 9 * Pa, xa, Pa)):
        x, P = _out(f(*args), 2)
        expect.close(P, Pa, "P", rtol=2e-3, at=of)
        expect.close(x, xa, "x", rtol=5e-3, atol=5e-3, at=of)


def _weight(P, Pa, Pb):
    """The w of which P is made, by least squares."""
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    try:
        I = np.linalg.inv(P)
    except np.linalg.LinAlgError:
        raise expect.Failed("P has no inverse: it must be a covariance") from None
    D = Ia - Ib
    return float(np.sum((I - Ib) * D) / np.sum(D * D))


def best_weight(Pa, Pb):
    """The P of smallest trace, and its w."""
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    fused = lambda w: np.linalg.inv(w * Ia + (1 - w) * Ib)
    found: Any = minimize_scalar(lambda w: np.trace(fused(w)), bounds=(0, 1), method="bounded", options={"xatol": 1e-9})
    w = min((0.0, float(found.x), 1.0), key=lambda w: np.trace(fused(w)))
    return fused(w), w
