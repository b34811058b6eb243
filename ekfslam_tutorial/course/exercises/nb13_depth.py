"""Exercise 13.1: one correction of an inverse depth by a bearing."""

import numpy as np

from ...ekf import chi_square
from .. import expect
from ..exercise import Exercise


def correct_rho(rho, P, b, y, var):
    """One EKF correction of the inverse depths of N points, each by its own filter.

    A camera has moved b metres to the side; it looks ahead. A point straight ahead of its start, at the depth d,
    is now seen under the angle arctan(b / d). rho = 1 / d (1/m) and its variance P, shapes (N,), are the estimates
    before; they may be zero or negative: at infinity, or beyond. y, shape (N,), holds the measured angles (rad), and
    var their variance.
    Return the new rho and P, shapes (N,).
    """
    e = np.arctan(b * rho)
    H = b / (1 + (b * rho) ** 2)
    K = P * H / (H * P * H + var)
    return rho + K * (y - e), (1 - K * H) * P


corrected = Exercise(
    "13.1",
    "A bearing corrects an inverse depth",
    correct_rho,
    hints=(
        "Write the angle as a function of rho, not of d. Then differentiate: d arctan(s) / ds = 1 / (1 + s^2).",
        "e = arctan(b rho), H = de / d rho = b / (1 + (b rho)^2). All numbers are scalars: Z = H P H + var.",
        "K = P H / Z; rho + K (y - e); (1 - K H) P. Every line works for N points at once.",
    ),
)


def case(rng, n, b=None):
    """Estimates, variances, a step to the side, angles and the variance of these."""
    rho, b = rng.uniform(0.02, 0.6, n), rng.uniform(0.5, 3) if b is None else b
    return rho, rng.uniform(0.01, 0.2, n) ** 2, b, np.arctan(b * rho) + rng.normal(0, 0.05, n), rng.uniform(0.01, 0.1)


def _two(result, n):
    rho, P = expect.results(result, "rho", "P")
    return expect.array(rho, n, "rho"), expect.array(P, n, "P")


@corrected.link("two results", "The function must end with `return rho, P`: one number for each point.")
def _(f, rng):
    for n in (4, 1):
        _two(f(*case(rng, n)), n)


@corrected.link("expected angle", "Where the measured angle is the expected one, arctan(b rho), nothing moves.", part=0)
def _(f, rng):
    for b in (1.0, -0.7, 2.5):
        rho, P, _, _, var = case(rng, 5)
        expect.close(_two(f(rho, P, b, np.arctan(b * rho), var), 5)[0], rho, "rho", at="y = arctan(b rho)")


@corrected.link("at infinity and beyond", "rho = 0 is a point at infinity: arctan(b rho) has no trouble there.", part=0)
def _(f, rng):
    rho, P, b, var = np.array([0.0, -0.05, 0.2]), np.array([0.04, 0.01, 0.02]), 1.5, 1e-4
    y = np.arctan(b * rho)
    expect.close(_two(f(rho, P, b, y, var), 3)[0], rho, "rho", at="rho = 0, -0.05 and 0.2, each with its own angle")


@corrected.link("gain", "K = P H / (H P H + var) with H = de / d rho, not de / dd.", part=0)
def _(f, rng):
    for n in (5, 1, 3):
        args = case(rng, n)
        expect.close(_two(f(*args), n)[0], correct_rho(*args)[0], "rho", at=f"b = {args[2]:.2f}")


@corrected.link(
    "no step, no depth", "Without a step to the side (b = 0) the angle does not depend on the depth.", part=1
)
def _(f, rng):
    args = case(rng, 4, 0.0)
    expect.close(_two(f(*args), 4)[1], args[1], "P", at="b = 0")


@corrected.link("variance", "The variance shrinks by the factor 1 - K H.", part=1)
def _(f, rng):
    for n in (5, 1, 3):
        args = case(rng, n)
        expect.close(_two(f(*args), n)[1], correct_rho(*args)[1], "P", at=f"b = {args[2]:.2f}")


@corrected.link(
    "500 runs", "Depths of 2 to 100 m, 20 small steps: at least 97 % of the runs must end inside the 99 % gate."
)
def _(f, rng):
    d, var = np.exp(rng.uniform(np.log(2), np.log(100), 500)), np.radians(0.1) ** 2
    rho, P = np.full(500, 0.25), np.full(500, 0.125**2)
    for b in 0.05 * np.arange(1, 21):
        rho, P = _two(f(rho, P, b, np.arctan2(b, d) + np.sqrt(var) * rng.standard_normal(500), var), 500)
    inside = np.mean((rho - 1 / d) ** 2 / P < chi_square.quantile(0.99, 1))
    expect.true(inside >= 0.97, f"only {100 * inside:.1f} % of 500 runs end inside the 99 % gate")


def _wrong(name, hint, e=None, H=None, noise=None, P_of=None):
    """A misconception in the expectation, the Jacobian, the noise, or the new variance."""

    @corrected.wrong(name, hint)
    def _(rho, P, b, y, var):
        e_k = e(rho, b) if e else np.arctan(b * rho)
        H_k = H(rho, b) if H else b / (1 + (b * rho) ** 2)
        K = P * H_k / (H_k * P * H_k + (noise(var) if noise else var))
        return rho + K * (y - e_k), P_of(P, K, H_k, var) if P_of else (1 - K * H_k) * P


# fmt: off
_wrong("rho taken for the depth", "rho is *one over* the depth: arctan(b / d) = arctan(b rho).",
       lambda rho, b: np.arctan2(b, rho), lambda rho, b: -b / (rho**2 + b**2))
_wrong("differentiated by the depth", "-b / (d^2 + b^2) is the derivative by the depth d. The state is rho: "
       "differentiate arctan(b rho) by rho.", H=lambda rho, b: -b / (1 / (rho + 1e-300) ** 2 + b**2))
_wrong("inner derivative only", "d arctan(s) / ds = 1 / (1 + s^2) is missing: H = b / (1 + (b rho)^2).",
       H=lambda rho, b: b + 0 * rho)
_wrong("outer derivative only", "The inner derivative is missing: d(b rho) / d rho = b.",
       H=lambda rho, b: 1 / (1 + (b * rho) ** 2))
_wrong("tangent for angle", "y is an angle: the expectation is arctan(b rho), not b rho.", lambda rho, b: b * rho)
_wrong("by way of the depth", "With d = 1 / rho and arctan2(b, d) a point with a negative rho lies behind the camera. "
       "Use arctan(b rho): it is smooth through zero.",
       lambda rho, b: np.arctan2(b, 1 / np.where(rho == 0, 1e-300, rho)))
_wrong("standard deviation for variance", "`var` is a variance already: do not square it.", noise=lambda v: v**2)
_wrong("root of the variance", "`var` is a variance: Z = H P H + var, without a root.", noise=np.sqrt)
_wrong("noise forgotten", "Z is the variance of y - e: that of the expectation *plus* that of the measurement.",
       noise=lambda v: 0)
_wrong("P not updated", "A correction makes P smaller: (1 - K H) P.", P_of=lambda P, K, H, var: P)
_wrong("P grows", "Information is gained: (1 - K H) P, with a minus.", P_of=lambda P, K, H, var: (1 + K * H) * P)
# fmt: on


@corrected.wrong("innovation turned round", "The innovation is measured minus expected, y - e.")
def _(rho, P, b, y, var):
    right, P = correct_rho(rho, P, b, y, var)
    return 2 * rho - right, P


@corrected.variant("information form")
def _(rho, P, b, y, var):
    s = b * np.asarray(rho)
    H = b / (1 + s * s)
    new = 1 / (1 / P + H * H / var)
    return rho + new * H / var * (y - np.arctan(s)), new


@corrected.variant("point by point")
def _(rho, P, b, y, var):
    out = []
    for r, p, a in zip(rho, P, y, strict=True):
        H = b * np.cos(np.arctan(b * r)) ** 2
        K = p * H / (H * p * H + var)
        out.append((r + K * (a - np.arctan2(b * r, 1.0)), p - K * (H * p * H + var) * K))
    return [r for r, _ in out], [p for _, p in out]
