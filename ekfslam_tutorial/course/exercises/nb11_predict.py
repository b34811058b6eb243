"""Exercise 11.2: the prediction in space: noise in the control."""

import numpy as np

from ...models.motion import Odometry3
from .. import expect
from ..exercise import Exercise
from .nb11_odo3 import odo3, pose, positive, step


def predict(x, P, u, U):
    """Move a frame and its covariance by one step of odometry that has noise.

    x, shape (7,), and P, shape (7, 7): the frame [t, q] and its covariance. u, shape (6,), and U, shape (6, 6): the
    step [dx, dv] as measured, in the axes of the robot, and its covariance.
    Return the new x and P.
    """
    x2, X_x, X_u = odo3(x, u)
    return x2, X_x @ P @ X_x.T + X_u @ U @ X_u.T


exercise = Exercise(
    "11.2",
    "Predict in space",
    predict,
    hints=(
        "You have odo3: it returns the new state and both Jacobians.",
        "P passes through X_x. The noise of the control, 6 x 6, becomes 7 x 7 through X_u.",
        "x2, X_x, X_u = odo3(x, u); P2 = X_x @ P @ X_x.T + X_u @ U @ X_u.T.",
    ),
)


def _cov(rng, n, scale):
    A = scale * rng.normal(size=(n, n))
    return A @ A.T


def _case(rng):
    return pose(rng), _cov(rng, 7, 0.05), step(rng), _cov(rng, 6, 0.03)


def _out(f, x, P, u, U):
    """The two results, with the sign of the quaternion that odo3 has: -q turns as q does."""
    x2, P2 = expect.results(f(x, P, u, U), "x", "P")
    x2, P2 = expect.array(x2, 7, "x"), expect.array(P2, (7, 7), "P")
    side = np.ones(7)
    if x2[3:] @ odo3(x, u)[0][3:] < 0:
        side[3:] = -1
    return side * x2, np.outer(side, side) * P2


@exercise.link("two results", "The function must end with `return x, P`: 7 numbers, and 7 x 7.")
def _(f, rng):
    _out(f, *_case(rng))


@exercise.link("mean", "The mean moves by odo3.", part=0)
def _(f, rng):
    for _ in range(3):
        x, P, u, U = _case(rng)
        expect.close(_out(f, x, P, u, U)[0], odo3(x, u)[0], "x")


@exercise.link("no noise in the control", "With U = 0 the covariance is X_x P X_x'.", part=1)
def _(f, rng):
    for _ in range(3):
        x, P, u, U = _case(rng)
        X = odo3(x, u)[1]
        expect.close(_out(f, x, P, u, 0 * U)[1], X @ P @ X.T, "P", at="U = 0")


@exercise.link("noise ahead", "The noise is in the robot's axes: a robot that looks along y errs along y.", part=1)
def _(f, rng):
    left = np.array([0, 0, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    U = np.diag([0.04, 0, 0, 0, 0, 0])
    P = _out(f, left, np.zeros((7, 7)), np.array([1.0, 0, 0, 0, 0, 0]), U)[1]
    expect.close(np.diag(P)[:3], [0, 0.04, 0], "the diagonal of P_tt", at="a robot along y, with noise ahead of 0.2 m")


@exercise.link("noise of the control", "The covariance of the control becomes one of the state: X_u U X_u'.", part=1)
def _(f, rng):
    for _ in range(3):
        x, P, u, U = _case(rng)
        X_u = odo3(x, u)[2]
        expect.close(_out(f, x, 0 * P, u, U)[1], X_u @ U @ X_u.T, "P", at="P = 0 before")
        x2, P2 = _out(f, x, 0 * P, u, U)
        expect.close(P2 @ np.concatenate([np.zeros(3), x2[3:]]), np.zeros(7), "P times [0, q]", atol=1e-10)


@exercise.link("both", "P is the sum of the two: X_x P X_x' + X_u U X_u'.", part=1)
def _(f, rng):
    for _ in range(3):
        x, P, u, U = _case(rng)
        got = _out(f, x, P, u, U)[1]
        _, X_x, X_u = Odometry3().move(x, u, 1.0)
        expect.close(got, X_x @ P @ X_x.T + X_u @ U @ X_u.T, "P")
        expect.symmetric(got, "P")
        expect.psd(got, "P")


def _wrong(name, hint, covariance):
    """A wrong answer: the right mean, and `covariance(P, U, X_x, X_u, x, u)`."""

    def answer(x, P, u, U):
        x2, X_x, X_u = odo3(x, u)
        return x2, covariance(np.asarray(P), np.asarray(U), X_x, X_u, x, u)

    exercise.wrong(name, hint)(answer)


def _world(P, U, X_x, X_u, x, u):
    """The noise added in the axes of the world."""
    W = X_u.copy()
    W[:3, :3] = np.eye(3)
    return X_x @ P @ X_x.T + W @ U @ W.T


def _padded(P, U, X_x, X_u, x, u):
    Q = np.zeros((7, 7))
    Q[:6, :6] = U
    return X_x @ P @ X_x.T + Q


# fmt: off
_wrong("noise forgotten", "Each step adds uncertainty: + X_u U X_u'.",
       lambda P, U, X_x, X_u, x, u: X_x @ P @ X_x.T)
_wrong("P not moved", "P passes through X_x, too: an error of q makes an error of the position.",
       lambda P, U, X_x, X_u, x, u: P + X_u @ U @ X_u.T)
_wrong("P thrown away", "The old uncertainty stays: X_x P X_x' + X_u U X_u'.",
       lambda P, U, X_x, X_u, x, u: X_u @ U @ X_u.T)
_wrong("noise in the axes of the world", "The noise is in the robot's axes: it must be turned with the robot, which "
       "X_u does.", _world)
_wrong("U put into the corner", "U belongs to the six numbers of the control, not to the first six of the state: "
       "X_u U X_u'.", _padded)
_wrong("only the diagonal of U", "The noises of a control may be correlated: use the whole U.",
       lambda P, U, X_x, X_u, x, u: X_x @ P @ X_x.T + X_u @ np.diag(np.diag(U)) @ X_u.T)
_wrong("transposed the wrong way", "Write X_x @ P @ X_x.T, the transposed one behind.",
       lambda P, U, X_x, X_u, x, u: X_x.T @ P @ X_x + X_u @ U @ X_u.T)
_wrong("U squared", "U is a covariance already.",
       lambda P, U, X_x, X_u, x, u: X_x @ P @ X_x.T + X_u @ (U @ U) @ X_u.T)
_wrong("X_u after the step", "The Jacobians belong to the pose *before* the step: odo3(x, u).",
       lambda P, U, X_x, X_u, x, u: X_x @ P @ X_x.T + (lambda J: J @ U @ J.T)(odo3(odo3(x, u)[0], u)[2]))
_wrong("X_x multiplied once", "A covariance is multiplied from both sides.",
       lambda P, U, X_x, X_u, x, u: X_x @ P + X_u @ U @ X_u.T)
# fmt: on


@exercise.wrong("mean not moved", "odo3 returns the new x as its first result: return it.")
def _(x, P, u, U):
    return np.array(x), predict(x, P, u, U)[1]


@exercise.variant("one big Jacobian")
def _(x, P, u, U):
    x2, X_x, X_u = odo3(x, u)
    J = np.hstack([X_x, X_u])
    S = np.zeros((13, 13))
    S[:7, :7], S[7:, 7:] = P, U
    return x2, (J @ S @ J.T).tolist()


@exercise.variant("the package's model, made symmetric")
def _(x, P, u, U):
    x2, X_x, X_u = Odometry3().move(x, u, 1.0)
    P = X_x @ P @ X_x.T + X_u @ U @ X_u.T
    return x2, (P + P.T) / 2


@exercise.variant("the quaternion with a >= 0")
def _(x, P, u, U):
    x2, X_x, X_u = positive(*odo3(x, u))
    return x2, X_x @ P @ X_x.T + X_u @ U @ X_u.T
