"""Exercise 21.1: the correction of an iterated EKF."""

import numpy as np

from ...geometry import wrap
from .. import expect, museum
from ..exercise import Exercise
from .nb04_blocks import random_covariance
from .nb05_predict import heading_wrapped


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


exercise = Exercise(
    "21.1",
    "Iterated correction",
    iterated_correct,
    canonical=heading_wrapped,
    hints=(
        "Only the point of linearisation moves. The prior stays x, P in every iteration: the measurement is used once.",
        "At the point `at`, h is e + H (x - at) for the prior x. So the innovation of the prior, seen from there, is "
        "z - H (x - at), with z = y - e wrapped.",
        "In the loop: e, H = observe(at); z; K = P H' inv(H P H' + R); at = x + K (z - H (x - at)). After the loop: "
        "return at, P - K H P.",
    ),
)


class Sight:
    """Range and bearing of the landmark in the state, as a function of the state."""

    def __init__(self, r=slice(3, 5)):
        self.r = r

    def __call__(self, x):
        """Return expectation and Jacobian."""
        return museum.observe(np.asarray(x, float), self.r)


def case(rng, n=5, far=0.4):
    """A state with a landmark, an uncertain prior, and a measurement that is far from what is expected."""
    x = np.concatenate([rng.uniform(-1, 1, 2), [rng.uniform(-1, 1)], rng.uniform(2, 4, n - 3)])
    P = random_covariance(rng, n, 0.15)
    sight = Sight(slice(n - 2, n))
    y = sight(x)[0] + rng.choice([-1, 1], 2) * rng.uniform(far, 1.5 * far, 2)
    return x, P, y, random_covariance(rng, 2, 0.003), sight


def two(result, n):
    """Return the results x and P as arrays."""
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


def _same(got, want, what, rtol=1e-5):
    (x, P), (x_want, P_want) = got, want
    expect.close(np.delete(x, 2), np.delete(x_want, 2), f"x (without the heading) {what}", rtol)
    expect.angle(x[2], x_want[2], f"the heading {what}", 1e-5)
    expect.close(P, P_want, f"P {what}", rtol)


@exercise.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n in (5, 7):
        x, P, y, R, sight = case(rng, n)
        two(f(x, P, y, R, sight, 2), n)


@exercise.link("one iteration", "With one iteration it is the ordinary EKF: x + K z, P - K H P.")
def _(f, rng):
    for n in (5, 7):
        x, P, y, R, sight = case(rng, n)
        _same(two(f(x, P, y, R, sight, 1), n), iterated_correct(x, P, y, R, sight, 1), "after one iteration")


@exercise.link(
    "mean of two iterations", "The second iteration starts from the prior again: only H and e are taken elsewhere.", 0
)
def _(f, rng):
    for n in (5, 7, 5):
        x, P, y, R, sight = case(rng, n)
        got, want = two(f(x, P, y, R, sight, 2), n), iterated_correct(x, P, y, R, sight, 2)
        _same((got[0], want[1]), want, "after two iterations")


@exercise.link(
    "covariance", "P is that of one correction of the prior, with the last K and H: the data are used once.", 1
)
def _(f, rng):
    for count in (2, 4):
        x, P, y, R, sight = case(rng)
        got, want = two(f(x, P, y, R, sight, count), 5)[1], iterated_correct(x, P, y, R, sight, count)[1]
        expect.close(got, want, f"P after {count} iterations")
        expect.symmetric(got, "P", 1e-6)


@exercise.link("the best fit", "After many iterations the result must be the best fit to prior and measurement.", 0)
def _(f, rng):
    x, P, y, R, sight = case(rng, 5, 0.15)
    at = two(f(x, P, y, R, sight, 40), 5)[0]
    e, H = sight(at)
    z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
    d = x - at
    d[2] = wrap(d[2])
    slope = H.T @ np.linalg.solve(R, z) + np.linalg.solve(P, d)
    scale = np.abs(H.T @ np.linalg.solve(R, z)).max()
    message = (
        "after 40 iterations the result is not the best fit to prior and measurement: the slope of the cost is not 0"
    )
    expect.true(np.abs(slope).max() < 1e-4 * max(scale, 1), message)


@exercise.link("seam of the bearing", "A landmark behind the robot: the bearing of y - e must be wrapped.", 0)
def _(f, rng):
    for side in (-1, 1):
        x, P, _, R, sight = case(rng, 5, 0.1)
        x[2] += sight(x)[0][1] + np.pi - side * 0.02
        e = sight(x)[0]
        y = np.array([e[0] + 0.2, wrap(e[1] - side * 0.1)])
        got, want = two(f(x, P, y, R, sight, 3), 5), iterated_correct(x, P, y, R, sight, 3)
        _same((got[0], want[1]), want, "for a landmark behind the robot")


# ---- wrong and right answers ---------------------------------------------------------------------------------------


def _variation(shift=None, forget=False, cov="last", jacobian="new", wrapped=True, sign=1.0, noise=1.0):
    """The right answer with one thing broken."""

    def answer(x, P, y, R, observe, iterations):
        at, S, H0, first = np.array(x, float), np.array(P, float), observe(x)[1], None
        for _ in range(iterations):
            e, H = observe(at)
            H = H0 if jacobian == "first" else H
            z = np.array([y[0] - e[0], wrap(y[1] - e[1]) if wrapped else y[1] - e[1]])
            Q = S if cov == "each" else P
            K = Q @ H.T @ np.linalg.inv(H @ Q @ H.T + noise * np.asarray(R))
            back = np.zeros(2) if shift == "none" else sign * (H @ (x - at))
            at = (at if forget else x) + K @ (z - back)
            S = Q - K @ H @ Q
            first = S if first is None else first
        return at, first if cov == "first" else S

    return answer


def _wrong(name, hint, answer):
    exercise.wrong(name, hint)(answer)


# fmt: off
_wrong("prior forgotten", "You start the second iteration at the result of the first, as if that were a new prior: the "
       "measurement is used twice. Start from x every time, and take H (x - at) into account.",
       _variation("none", forget=True))
_wrong("prior forgotten, and P shrinks each time", "Each round uses the measurement again, with a smaller P: that is "
       "counting it several times. Prior x, P in every round.", _variation("none", forget=True, cov="each"))
_wrong("P shrinks each time", "P is the prior's in every iteration. Only the last K and H make the new P.",
       _variation(cov="each"))
_wrong("H (x - at) forgotten", "e and H belong to the point `at`. Seen from there the prior x expects e + H (x - at): "
       "the innovation is z - H (x - at).", _variation("none"))
_wrong("H (x - at) with the other sign", "The prior expects e + H (x - at): subtract it from the measurement.",
       _variation(sign=-1.0))
_wrong("always the first H", "Take H anew at each point: e, H = observe(at).", _variation(jacobian="first"))
_wrong("covariance of the first iteration", "The P of the result comes from the last K and H, not from the first.",
       _variation(cov="first"))
_wrong("one iteration only", "Repeat: linearise again at the corrected state. Is `return` inside the loop?",
       lambda x, P, y, R, observe, iterations: iterated_correct(x, P, y, R, observe, 1))
_wrong("one iteration too many", "iterations = 1 is the ordinary EKF.",
       lambda x, P, y, R, observe, iterations: iterated_correct(x, P, y, R, observe, iterations + 1))
_wrong("bearing not wrapped", "y and e may differ by 2 pi near the seam: wrap the bearing of z.",
       _variation(wrapped=False))
_wrong("R forgotten", "Z = H P H' + R.", _variation(noise=1e-12))
_wrong("prior not corrected", "Return the corrected P as well: P - K H P.",
       lambda x, P, y, R, observe, iterations: (iterated_correct(x, P, y, R, observe, iterations)[0], np.array(P)))
_wrong("P with a new Jacobian at the end", "Use the K and H of the last iteration for P, together.",
       lambda x, P, y, R, observe, iterations: (
           iterated_correct(x, P, y, R, observe, iterations)[0],
           iterated_correct(x, P, y, R, observe, iterations + 1)[1]))
# fmt: on


@exercise.variant("information form: Gauss-Newton on prior and measurement, lists")
def _(x, P, y, R, observe, iterations):
    at, W, V = np.array(x, float), np.linalg.inv(P), np.linalg.inv(R)
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], np.arctan2(np.sin(y[1] - e[1]), np.cos(y[1] - e[1]))])
        S = np.linalg.inv(W + H.T @ V @ H)
        at = at + S @ (H.T @ V @ z + W @ (x - at))
    return at.tolist(), S.tolist()


@exercise.variant("Joseph form, whole turns added")
def _(x, P, y, R, observe, iterations):
    at, K, H = np.array(x, float), np.zeros((len(x), 2)), np.zeros((2, len(x)))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.asarray(y) - e - H @ (x - at)
        z[1] += 2 * np.pi * np.round((wrap(y[1] - e[1]) - (y[1] - e[1])) / (2 * np.pi))
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        at = x + K @ z
    A = np.eye(len(x)) - K @ H
    return at + [0, 0, 2 * np.pi, *(len(x) - 3) * [0]], A @ P @ A.T + K @ R @ K.T


@exercise.variant("least squares of all residuals together")
def _(x, P, y, R, observe, iterations):
    at, L, M = np.array(x, float), np.linalg.inv(np.linalg.cholesky(P)), np.linalg.inv(np.linalg.cholesky(R))
    for _ in range(iterations):
        e, H = observe(at)
        z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
        J, r = np.vstack([L, M @ H]), np.concatenate([L @ (x - at), M @ z])
        at = at + np.linalg.lstsq(J, r, rcond=None)[0]
    return at, np.linalg.inv(J.T @ J)
