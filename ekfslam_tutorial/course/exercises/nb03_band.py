"""Exercise 03.5: errors of a pose, and the band they should stay in."""

import numpy as np
from scipy.special import erf  # noqa: F401  (an edit below uses both)
from scipy.stats import chi2  # noqa: F401

from ...geometry import wrap
from ..table import table
from .nb04_blocks import random_covariance


def error_band(x, truth, P, k):
    """Errors of a robot's pose at T times, and how large they may be.

    x and truth, shape (T, 3): the estimated and the true poses [x, y, theta]; whole turns of theta do not count.
    P, shape (T, 3, 3): the covariances of the filter. k: the size of the band, in sigmas.
    Return e, shape (T, 3), estimate minus truth, and w, shape (T, 3): the band goes from -w to +w.
    """
    e = x - truth
    e[:, 2] = wrap(e[:, 2])
    w = k * np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    return e, w


def _case(rng, T, k, large=False, turns=0):
    """Poses with errors, and covariances that differ from time to time; the heading crosses the seam."""
    P = np.array([random_covariance(rng, 3, rng.uniform(0.02, 0.3)) for _ in range(T)])
    truth = np.column_stack([rng.uniform(-9, 9, (T, 2)), rng.uniform(-0.1, 0.1, T) + np.pi])
    x = truth + rng.uniform(-0.4, 0.4, (T, 3)) + (np.array([7.0, -5.0, 0.0]) if large else 0.0)
    x[:, 2], truth[:, 2] = wrap(x[:, 2]), wrap(truth[:, 2])
    x[:, 2] += 2 * np.pi * turns
    return x, truth, P, k


def _turned_away(x, truth, P, k):
    """The same with headings that are far off, by more than a quarter turn."""
    return np.column_stack([x[:, :2], wrap(truth[:, 2] + np.array([2.0, -2.5, 1.7, -3.0]))]), truth, P, k


def _easy(rng):
    """One time, no seam, no correlations."""
    P = np.diag([0.04, 0.25, 0.01])[None]
    return [(np.array([[1.1, 2.0, 0.3]]), np.array([[1.0, 2.4, 0.2]]), P, k) for k in (1.0, 3.0)]


banded = table(
    "03.5 The error band",
    error_band,
    hints=(
        "The band of x is about one number: which entry of P is its variance?",
        "The variances of x, y and theta are the diagonal of P; a sigma is the root of a variance. The error of an angle is a difference of angles.",
        "e = x - truth, then e[:, 2] = wrap(e[:, 2]). np.diagonal(P, axis1=1, axis2=2) gives the variances at all times, shape (T, 3); w is k times their root.",
    ),
    returns="e, w",
    cases={
        "any": lambda rng: [_case(rng, T, k) for T, k in ((5, 3.0), (1, 1.0), (8, 2.5))],
        "one pose": _easy,
        "far off": lambda rng: [_case(rng, 6, 2.0, large=True)],
        "turns": lambda rng: [_case(rng, 4, 3.0, turns=turns) for turns in (1, -1, 3)],
        "lost": lambda rng: [_turned_away(*_case(rng, 4, 2.0))],
    },
    checks="""
    one error      | e[:, :2] | one pose | Estimate minus truth: 1.1 m for 1.0 m is an error of +0.1 m.
    one band       | w        | one pose | w[t, i] is k sigma, and P[t, i, i] is sigma squared: a variance of 0.04 m^2 is a sigma of 0.2 m, 3 sigma are 0.6 m.
    errors         | e        | any      | Estimate minus truth at each time, for x, y and theta. Here some headings lie on both sides of +-pi: 179 degrees minus -179 degrees is an error of -2 degrees.
    metres         | e        | far off  | x and y are lengths, of any size, and the robot is far off here: an error of 7 m stays an error of 7 m.
    whole turns    | e        | turns    | A robot that turns round and counts on has the same heading: whole turns are no error, however many.
    a heading far off | e     | lost     | The heading is off by 2, -2.5, 1.7 and -3 rad here. All of these lie between -pi and pi, and so they come out.
    band           | w        | any      | k times the root of the variances: the diagonal of P, at each time.
    """,
    wrong="""
    truth minus estimate | x - truth -> truth - x | The error is the estimate minus the truth, as a plot of it should say where the filter is.
    half turns removed | wrap(e[:, 2]) -> np.arctan(np.tan(e[:, 2])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    arcsine of the sine | wrap(e[:, 2]) -> np.arcsin(np.sin(e[:, 2])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    heading not wrapped | wrap(e[:, 2]) -> e[:, 2] | A heading of 179 deg and one of -179 deg are 2 deg apart: wrap the third column of e.
    all of it wrapped | e[:, 2] = wrap(e[:, 2]) -> e = wrap(e) | Only the heading is an angle. Metres are not wrapped.
    heading between 0 and 2 pi | wrap(e[:, 2]) -> e[:, 2] % (2 * np.pi) | A heading that is 1 degree too small has an error of -1 degree, not of 359: wrap into -pi ... pi.
    size of the error only | x - truth -> np.abs(x - truth) | Keep the sign: a filter that is always wrong on the same side shows it in the plot.
    variance for sigma | np.sqrt(np.diagonal(P, axis1=1, axis2=2)) -> np.diagonal(P, axis1=1, axis2=2) | The diagonal of P holds variances, in square metres. The band wants sigmas: take the root.
    k under the root | k * np.sqrt(np.diagonal(P, axis1=1, axis2=2)) -> np.sqrt(k * np.diagonal(P, axis1=1, axis2=2)) | First the root, then times k: k sigma.
    k squared | k * -> k**2 * | k squared belongs to squared distances. The band ends at k sigma.
    k forgotten | k * np.sqrt -> np.sqrt | That is the band of 1 sigma, whatever k is: 32 % of the errors may leave it.
    always 3 sigma | k * -> 3 * | The size of the band is the argument k; 3 is only what is drawn most.
    the whole width | k * -> 2 * k * | The band goes from -w to +w: w is half of its width, k sigma.
    eigenvalues of P | np.diagonal(P, axis1=1, axis2=2) -> np.linalg.eigvalsh(P) | They are variances along the axes of the *ellipsoid*. The band of x wants the variance of x: P[0, 0].
    the first P for all | np.sqrt(np.diagonal(P, axis1=1, axis2=2)) -> np.tile(np.sqrt(np.diag(P[0])), (len(P), 1)) | P changes from time to time: P[t] belongs to the error at t.
    the last P for all | np.sqrt(np.diagonal(P, axis1=1, axis2=2)) -> np.tile(np.sqrt(np.diag(P[-1])), (len(P), 1)) | P changes from time to time: P[t] belongs to the error at t.
    the mean P for all | np.sqrt(np.diagonal(P, axis1=1, axis2=2)) -> np.tile(np.sqrt(np.diag(P.mean(0))), (len(P), 1)) | P changes from time to time: P[t] belongs to the error at t.
    band of the ellipsoid | k * -> np.sqrt(chi2.ppf(erf(k / np.sqrt(2)), 3)) * | That is the size of an ellipsoid, for three numbers together. Each band is about one number.
    heading in degrees | return e, w -> return e * [1, 1, 180 / np.pi], w * [1, 1, 180 / np.pi] | All in radians: degrees are for the axis of a plot.
    the inverse of P | np.diagonal(P, axis1=1, axis2=2) -> 1 / np.diagonal(np.linalg.inv(P), axis1=1, axis2=2) | P says how uncertain, its inverse how certain. The band of one number, whatever the others are, wants the diagonal of P itself.
    size of the error, after the wrap | return e, w -> return np.abs(e), w | Keep the sign: a filter that is always wrong on the same side shows it in the plot.
    band of a mean | w = k * -> w = k / np.sqrt(len(x)) * | The band is that of one error at one time, and no mean is taken: it is not divided by the root of how many there are.
    turned into the axes of the robot | w = k * -> c, s = np.cos(truth[:, 2]), np.sin(truth[:, 2]); e[:, :2] = np.stack([c * e[:, 0] + s * e[:, 1], c * e[:, 1] - s * e[:, 0]], 1); w = k * | P is of x and y in the world, and so is the error: the plain difference, not turned.
    mean error taken off | w = k * -> e = e - e.mean(0); w = k * | The errors are taken as they are: without their mean a filter that is always wrong on the same side looks right.
    one turn only | wrap(e[:, 2]) -> e[:, 2] - 2 * np.pi * np.sign(e[:, 2]) * (np.abs(e[:, 2]) > np.pi) | Yours takes off one turn at most. An estimate that has counted several turns has more of them: use wrap.
    made smooth in time | wrap(e[:, 2]) -> np.unwrap(e[:, 2]) | np.unwrap makes the errors go on without a jump, but keeps whole turns, those of the first error in all. Each error is brought to -pi ... pi: wrap.
    each heading wrapped, not the difference | wrap(e[:, 2]) -> wrap(x[:, 2]) - wrap(truth[:, 2]) | First the difference, then the wrap: two wrapped headings can still be nearly 2 pi apart.
    """,
)
