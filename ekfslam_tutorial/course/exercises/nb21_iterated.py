"""Exercise 21.1: the correction of an iterated EKF."""

import numpy as np

from ...geometry import wrap
from .. import expect, museum
from ..table import table
from .nb04_blocks import random_covariance


def iterated_correct(x, P, y, R, observe, iterations):
    """Correction that is linearised again at its own result, several times; the prior x, P is the same each time.

    x, shape (n,): state, heading in x[2]. P, shape (n, n): its covariance. y = [range, bearing], R, shape (2, 2): the
    measurement and its covariance. observe(x) returns the expected [range, bearing] at x and the Jacobian H, (2, n).
    iterations = 1 is the ordinary EKF. Return the new x and P. Do not change the inputs.
    """
    at, P_new = np.array(x, float), P
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
        at, P_new = x + K @ (z - H @ (x - at)), P - K @ H @ P
    return at, P_new


class Sight:
    """Range and bearing of the landmark in the state, as a function of the state."""

    def __init__(self, r=slice(3, 5)):
        self.r = r

    def __call__(self, x):
        """Return expectation and Jacobian."""
        return museum.observe(np.asarray(x, float), self.r)


def case(rng, n=5, iterations=2, far=0.4):
    """A state with a landmark, an uncertain prior, and a measurement that is far from what is expected."""
    x = np.concatenate([rng.uniform(-1, 1, 2), [rng.uniform(-1, 1)], rng.uniform(2, 4, n - 3)])
    P = random_covariance(rng, n, 0.15)
    sight = Sight(slice(n - 2, n))
    y = sight(x)[0] + rng.choice([-1, 1], 2) * rng.uniform(far, 1.5 * far, 2)
    return x, P, y, random_covariance(rng, 2, 0.003), sight, iterations


def behind(x, P, y, R, sight, iterations, side=1):
    """The landmark behind the robot: expected bearing and measured one on different sides of the seam."""
    x = x.copy()
    x[2] += sight(x)[0][1] + np.pi - side * 0.02
    e = sight(x)[0]
    return x, P, np.array([e[0] + 0.2, wrap(e[1] - side * 0.1)]), R, sight, iterations


def aside(x, P, y, R, sight, iterations, off):
    """A bearing that is so far off."""
    e = sight(x)[0]
    return x, P, np.array([e[0] + 0.2, wrap(e[1] + off)]), R, sight, iterations


def farther(x, P, y, R, sight, iterations):
    """The landmark 5 m farther away than expected."""
    return x, P, y + [5.0, 0.0], R, sight, iterations


exercise = table(
    "21.1 Iterated correction",
    iterated_correct,
    hints=(
        "Only the point of linearisation moves. The prior stays x, P in every iteration: the measurement is used once.",
        "At the point `at`, h is e + H (x - at) for the prior x. So the innovation of the prior, seen from there, is z - H (x - at), with z = y - e wrapped.",
        "In the loop: e, H = observe(at); z; K = P H' inv(H P H' + R); at = x + K (z - H (x - at)). After the loop: return at, P - K H P.",
    ),
    returns="x, P",
    symbols="Z = H P H' + R",
    angles={"x": 2},
    cases={
        "any": lambda rng: [case(rng, n) for n in (5, 7, 5)],
        "one": lambda rng: [case(rng, n, 1) for n in (5, 7)],
        "more": lambda rng: [case(rng, 5, count) for count in (2, 4)],
        "seam": lambda rng: [behind(*case(rng, 5, 3, 0.1), side) for side in (-1, 1)],
        "aside": lambda rng: [aside(*case(rng, 5, count), off) for count, off in ((1, 2.0), (1, -2.5))],
        "far": lambda rng: [farther(*case(rng, 5, count)) for count in (1, 3)],
    },
    checks="""
    one iteration          | x, P | one  | With iterations = 1 it is the ordinary EKF: x + K z, P - K H P, each once.
    mean of two iterations | x | any  | In each iteration e, H and K are taken at the last result; x and P are those of the prior. Seen from a last result `at`, the innovation of the prior is y - e - H (x - at).
    covariance             | P | more | P is that of one correction of the prior, with the last K and H: the data are used once.
    mean of more           | x | more | Two or four iterations. In each, e, H and K are taken at the last result; x and P are those of the prior. Seen from a last result `at`, the innovation of the prior is y - e - H (x - at).
    seam of the bearing    | x | seam | A landmark behind the robot: y and e lie on two sides of the seam, and the heading may be beyond pi. Two differences of angles can hold a whole turn, and are wrapped then: the bearing of y - e, or the heading of x - at.
    a bearing far off      | x | aside | The bearing of y - e is 2 rad here, and then -2.5 rad, or a whole turn more or less. Wrapped it lies between -pi and pi.
    the range is no angle  | x | far  | The landmark is 5 m farther away than expected. In z = y - e the range may be larger than pi and stays as it is; the bearing is wrapped.
    """,
    wrong="""
    half turns removed | wrap(y[1] - e[1]) -> np.arctan(np.tan(y[1] - e[1])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    arcsine of the sine | wrap(y[1] - e[1]) -> np.arcsin(np.sin(y[1] - e[1])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    prior forgotten: You start the second iteration at the result of the first, as if that were a new prior: the measurement is used twice. Start from x every time, and take H (x - at) into account.
        x + K @ (z - H @ (x - at)) -> at + K @ z
    prior forgotten, and P shrinks each time | x + K @ (z - H @ (x - at)) -> at + K @ z | Each round uses the measurement again, with a smaller P: that is counting it several times. Prior x, P in every round.
        np.linalg.solve(H @ P @ H.T + R, H @ P).T -> np.linalg.solve(H @ P_new @ H.T + R, H @ P_new).T
        P - K @ H @ P -> P_new - K @ H @ P_new
    P shrinks each time | np.linalg.solve(H @ P @ H.T + R, H @ P).T -> np.linalg.solve(H @ P_new @ H.T + R, H @ P_new).T | P is the prior's in every iteration. Only the last K and H make the new P.
        P - K @ H @ P -> P_new - K @ H @ P_new
    P corrected in the loop and once more | np.linalg.solve(H @ P @ H.T + R, H @ P).T -> np.linalg.solve(H @ P_new @ H.T + R, H @ P_new).T | The measurement is used once: keep the prior P in the loop, and return P - K H P of that P, with the last K and H.
        P - K @ H @ P -> P_new - K @ H @ P_new
        return at, P_new -> return at, P_new - K @ H @ P_new
    H (x - at) forgotten | z - H @ (x - at) -> z | e and H belong to the point `at`. Seen from there the prior x expects e + H (x - at): the innovation is z - H (x - at).
    H (x - at) with the other sign | z - H @ (x - at) -> z + H @ (x - at) | The prior expects e + H (x - at): subtract it from the measurement.
    heading wrapped in the result only | at, P_new = x + K @ (z - H @ (x - at)), P - K @ H @ P -> at, P_new = x + K @ (z - H @ (x - at)), P - K @ H @ P; at[2] = wrap(at[2]) | With the heading of `at` wrapped, that of the prior may have a whole turn more. x - at is a difference of angles, too: wrap its entry 2, or wrap no heading before the end.
    always the first H | z = np -> H = observe(x)[1]; z = np | Take H anew at each point: e, H = observe(at).
    Z left out | P - K @ H @ P -> P - K @ K.T | P falls by K Z K', which is K H P: Z stands between the two gains.
    covariance of the first iteration | P - K @ H @ P -> P - K @ H @ P if P_new is P else P_new | The P of the result comes from the last K and H, not from the first.
    correction added to the last result | x + K @ (z - H @ (x - at)) -> at + K @ (z - H @ (x - at)) | The correction is that of the prior: x + K (z - H (x - at)), with the prior x in front, too.
    one iteration only | range(iterations) -> range(1) | Repeat: linearise again at the corrected state. Is `return` inside the loop?
    one iteration too many | range(iterations) -> range(iterations + 1) | iterations = 1 is the ordinary EKF.
    bearing not wrapped | wrap(y[1] - e[1]) -> y[1] - e[1] | y and e may differ by 2 pi near the seam: wrap the bearing of z.
    brackets of the wrapping | wrap(y[1] - e[1]) -> (y[1] - e[1] + np.pi) % 2 * np.pi - np.pi | `%` and `*` are done from left to right: (angle + pi) % (2 * pi) - pi needs the brackets round 2 * pi.
    range wrapped, too | [y[0] - e[0], -> [wrap(y[0] - e[0]), | The range is a distance, not an angle: wrap z[1] only.
    degrees | wrap(y[1] - e[1]) -> np.degrees(wrap(y[1] - e[1])) | All angles are in radians already: no conversion.
    R forgotten | H.T + R -> H.T + 1e-12 * R | Z = H P H' + R.
    prior not corrected | return at, P_new -> return at, P | Return the corrected P as well: P - K H P.
    P with a new Jacobian at the end | return at, P_new -> H = observe(at)[1]; return at, P - np.linalg.solve(H @ P @ H.T + R, H @ P).T @ H @ P | Use the K and H of the last iteration for P, together.
    P falls with each iteration | P - K @ H @ P -> P_new - K @ H @ P_new | The measurement is used once: P is that of the prior, P - K H P with the last K and H. Yours falls again in every iteration.
    P corrected twice | return at, P_new -> return at, (P_new - K @ H @ P_new) | One measurement, one correction of P: P - K H P, with the last K and H, once.
    pushed away from the prior | x + K @ (z - H @ (x - at)) -> at + K @ z + (np.eye(len(x)) - K @ H) @ (at - x) | The prior pulls back: with H' R^-1 z in the step there is P^-1 (x - at), prior minus last result. Yours has the other sign.
    R shared among the iterations | e, H = observe(at) -> e, H = observe(at); R = R * iterations if _ == 0 else R | Each iteration takes the measurement anew, with the same prior: R stays as it is.
    """,
    forms="""
    P - K Z K' | P - K @ H @ P -> P - K @ (H @ P @ H.T + R) @ K.T | P - K Z K'
    """,
)


@exercise.link(
    "the best fit",
    "After many iterations the result must be the best fit to prior and measurement.",
    0,
    "seam of the bearing",
)
def _(f, rng):
    x, P, y, R, sight, count = case(rng, 5, 40, 0.15)
    at = expect.array(expect.results(f(x, P, y, R, sight, count), "x", "P")[0], 5, "x")
    e, H = sight(at)
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    d = x - at
    d[2] = wrap(d[2])
    pull = H.T @ np.linalg.solve(R, z)
    flat = np.abs(pull + np.linalg.solve(P, d)).max() < 1e-4 * max(np.abs(pull).max(), 1)
    expect.true(
        flat,
        f"after {count} iterations the result is not the best fit to prior and measurement: the slope of the cost "
        "is not 0",
    )
