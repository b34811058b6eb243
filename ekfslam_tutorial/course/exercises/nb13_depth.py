"""Exercise 13.1: one correction of an inverse depth by a bearing."""

import numpy as np

from ...ekf import chi_square
from .. import expect
from ..table import table


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


def case(rng, n, b=None):
    """Estimates, variances, a step to the side, angles and the variance of these."""
    rho, b = rng.uniform(0.02, 0.6, n), rng.uniform(0.5, 3) if b is None else b
    return rho, rng.uniform(0.01, 0.2, n) ** 2, b, np.arctan(b * rho) + rng.normal(0, 0.05, n), rng.uniform(0.01, 0.1)


def as_expected(rho, P, b, y, var):
    """The same with the angles that are expected."""
    return rho, P, b, np.arctan(b * rho), var


FAR = np.array([0.0, -0.05, 0.2]), np.array([0.04, 0.01, 0.02]), 1.5

corrected = table(
    "13.1 A bearing corrects an inverse depth",
    correct_rho,
    hints=(
        "Write the angle as a function of rho, not of d. Then differentiate: d arctan(s) / ds = 1 / (1 + s^2).",
        "e = arctan(b rho), H = de / d rho = b / (1 + (b rho)^2). All numbers are scalars: Z = H P H + var.",
        "K = P H / Z; rho + K (y - e); (1 - K H) P. Every line works for N points at once.",
    ),
    returns="rho, P",
    symbols="H = the derivative of the expected angle by rho; K = P H / (H P H + var)",
    cases={
        "any": lambda rng: [case(rng, n) for n in (5, 1, 3)],
        "expected": lambda rng: [as_expected(*case(rng, 5, b)) for b in (1.0, -0.7, 2.5)],
        "infinity": lambda rng: [as_expected(*FAR, 0, 1e-4)],
        "beyond": lambda rng: [(*FAR, np.array([0.02, -0.1, 0.25]), 1e-4)],
        "b = 0": lambda rng: [case(rng, 4, 0.0)],
    },
    checks="""
    expected angle          | rho | expected | Where the measured angle is the expected one, arctan(b rho), rho stays. b may be negative: a step to the other side.
    at infinity and beyond  | rho | infinity | rho is 0 (at infinity), -0.05 (beyond) and 0.2: arctan(b rho) has no trouble there. Each measured angle is the expected one: rho stays.
    gain                    | rho | any      | The new rho is rho + K (y - e), with e = arctan(b rho), K = P H / (H P H + var) and H = b / (1 + (b rho)^2). P and var are variances.
    no step, no depth       | P   | b = 0    | Without a step to the side (b = 0) the angle does not depend on the depth: H = 0, rho and the variance P stay.
    variance                | P   | any      | The variance shrinks by the factor 1 - K H.
    far points              | rho, P | beyond | rho is 0 (at infinity), -0.05 (beyond) and 0.2: the same correction for all three, whatever the sign of rho is, before and after.
    """,
    wrong="""
    rho taken for the depth | np.arctan(b * rho) -> np.arctan2(b, rho) | rho is *one over* the depth: arctan(b / d) = arctan(b rho).
        b / (1 + (b * rho) ** 2) -> -b / (rho**2 + b**2)
    differentiated by the depth | b / (1 + (b * rho) ** 2) -> -b / (1 / (rho + 1e-300) ** 2 + b**2) | -b / (d^2 + b^2) is the derivative by the depth d. The state is rho: differentiate arctan(b rho) by rho.
    inner derivative only | b / (1 + (b * rho) ** 2) -> b + 0 * rho | d arctan(s) / ds = 1 / (1 + s^2) is missing: H = b / (1 + (b rho)^2).
    outer derivative only | b / (1 + -> 1 / (1 + | The inner derivative is missing: d(b rho) / d rho = b.
    H at the measured angle | b / (1 + (b * rho) ** 2) -> b / (1 + np.tan(y) ** 2) | H belongs to the estimate: take the derivative at rho, b / (1 + (b rho)^2). Yours is taken at tan(y) / b, the inverse depth that was measured.
    tangent for angle | np.arctan(b * rho) -> b * rho | y is an angle: the expectation is arctan(b rho), not b rho.
    by way of the depth | np.arctan(b * rho) -> np.arctan2(b, 1 / np.where(rho == 0, 1e-300, rho)) | With d = 1 / rho and arctan2(b, d) a point with a negative rho lies behind the camera. Use arctan(b rho): it is smooth through zero.
    in degrees | np.arctan(b * rho) -> np.degrees(np.arctan(b * rho)) | y is in radians: np.arctan gives radians, no conversion.
    standard deviation for variance | + var) -> + var**2) | `var` is a variance already: do not square it.
    root of the variance | + var) -> + np.sqrt(var)) | `var` is a variance: Z = H P H + var, without a root.
    noise forgotten | + var) -> ) | Z is the variance of y - e: that of the expectation *plus* that of the measurement.
    P not updated | (1 - K * H) * P -> P | A correction makes P smaller: (1 - K H) P.
    K H taken off | (1 - K * H) * P -> P - K * H | K H is a share, and no variance: P - K H P.
    P grows | (1 - K * H) * P -> (1 + K * H) * P | Information is gained: (1 - K H) P, with a minus.
    innovation turned round | y - e -> e - y | The innovation is measured minus expected, y - e.
    Joseph without the noise | (1 - K * H) * P -> (1 - K * H) ** 2 * P | (1 - K H) stands twice in your variance. Once is right: (1 - K H) P. Squared, as in Joseph's form, a second term belongs there: + K^2 var.
    rho taken for the depth, by arctan2 | np.arctan(b * rho) -> np.arctan2(b, rho) | rho is one over the depth: b / d = b rho.
    rho made positive | e = np -> rho = np.abs(rho); e = np | A negative rho is an estimate like others, beyond infinity: it keeps its sign.
    new rho made positive | return rho + K * (y - e), -> return np.abs(rho + K * (y - e)), | A negative rho is an estimate like others, beyond infinity: it keeps its sign.
    negative rho set to zero | return rho + K * (y - e), -> return np.maximum(rho + K * (y - e), 0), | A negative rho is an estimate like others, beyond infinity: it is not cut off at zero.
    K var K taken off | (1 - K * H) * P -> P - K * var * K | P falls by K Z K with the whole Z = H P H + var, not with var alone.
    b and rho the wrong way | np.arctan(b * rho) -> np.arctan(rho / b) | The expected angle is arctan(b rho): a product.
    1 - K | (1 - K * H) * P -> (1 - K) * P | The variance shrinks by 1 - K H: the derivative H belongs to it.
    root of the derivative | H = b / (1 + (b * rho) ** 2) -> H = b / np.sqrt(1 + (b * rho) ** 2) | The derivative of arctan(s) is 1 / (1 + s^2), without a root.
    gain of the new rho for P | return rho + K * (y - e), (1 - K * H) * P -> rho = rho + K * (y - e); H = b / (1 + (b * rho) ** 2); return rho, (1 - P * H / (H * P * H + var) * H) * P | One H and one K, at the rho before the correction, for rho and for P.
    linear expectation | e = np.arctan(b * rho) -> e = b * rho / (1 + (b * rho) ** 2) | The expectation is arctan(b rho) itself. The derivative H is for the gain and the variance only.
    variance with the new derivative | (1 - K * H) * P -> (1 - K * b / (1 + (b * (rho + K * (y - e))) ** 2)) * P | One correction, one H: that of the estimate before, for the gain and for the variance.
    one gain for all points | K = P * H / (H * P * H + var) -> K = P * H / (np.sum(H * P * H) + var) | Each point has a filter of its own: H P H + var entry by entry, not summed over the points.
    only rho squared | (1 + (b * rho) ** 2) -> (1 + b * rho**2) | d arctan(s) / ds = 1 / (1 + s^2) with s = b rho: b is squared, too.
    """,
    forms="""
    P - K Z K | (1 - K * H) * P -> P - K * (H * P * H + var) * K | P - K Z K
    Joseph | (1 - K * H) * P -> (1 - K * H) ** 2 * P + K**2 * var | of Joseph
    """,
)


@corrected.link(
    "500 runs", "Depths of 2 to 100 m, 20 small steps: at least 97 % of the runs must end inside the 99 % gate."
)
def _(f, rng):
    d, var = np.exp(rng.uniform(np.log(2), np.log(100), 500)), np.radians(0.1) ** 2
    rho, P = np.full(500, 0.25), np.full(500, 0.125**2)
    for b in 0.05 * np.arange(1, 21):
        y = np.arctan2(b, d) + np.sqrt(var) * rng.standard_normal(500)
        rho, P = (expect.array(a, 500, name) for a, name in zip(f(rho, P, b, y, var), ("rho", "P"), strict=True))
    inside = np.mean((rho - 1 / d) ** 2 / P < chi_square.quantile(0.99, 1))
    expect.true(inside >= 0.97, f"only {100 * inside:.1f} % of 500 runs end inside the 99 % gate")
