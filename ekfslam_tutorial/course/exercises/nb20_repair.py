"""Exercise 20.3: repair a published prediction in which the thread found one bug of two."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance
from .nb05_predict import heading_wrapped


def turn_go_turn(x, P, u, U):
    """Prediction with the control u = [r1, t, r2]: turn by r1, go t straight ahead, turn by r2 (rad, m, rad).

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks, which stand still. P, shape (n, n): its
    covariance. U, shape (3, 3): covariance of u.
    Return the new x and P. Do not change the inputs.
    """
    r1, t, r2 = u
    c, s = np.cos(x[2] + r1), np.sin(x[2] + r1)  # of the way, before anything has moved
    X_x = np.array([[1, 0, -t * s], [0, 1, t * c], [0, 0, 1]])
    X_u = np.array([[-t * s, c, 0], [t * c, s, 0], [1, 0, 1]])
    x, P = np.array(x, float), np.array(P, float)
    x[:3] = x[0] + t * c, x[1] + t * s, wrap(x[2] + r1 + r2)
    P[:3] = X_x @ P[:3]
    P[:, :3] = P[:, :3] @ X_x.T
    P[:3, :3] += X_u @ U @ X_u.T
    return x, P


repair = Exercise(
    "20.3",
    "Repair the prediction",
    turn_go_turn,
    canonical=heading_wrapped,
    hints=(
        "Hand the broken function to your guard: it says which part of P is wrong. Repair what the thread says, and "
        "ask the guard again.",
        "The column of the heading is the derivative of t cos(theta + r1) and t sin(theta + r1) by theta. And which "
        "theta does the code use there: the old one, or one that has been changed two lines above?",
        "Take the direction a = x[2] + r1 before x changes. Column of the heading: [-t sin a, t cos a, 1]. X_u = [[-t "
        "sin a, cos a, 0], [t cos a, sin a, 0], [1, 0, 1]].",
    ),
)


def case(rng, n=7):
    """A state, a covariance, a step and its covariance at random: nothing zero, nothing symmetric."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-1.5, 1.5)
    u = np.array([rng.uniform(0.3, 0.8), rng.uniform(0.5, 2), rng.uniform(0.3, 0.8)])
    return x, random_covariance(rng, n), u, random_covariance(rng, 3, 0.05)


def two(result, n):
    """Return the results x and P as arrays."""
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@repair.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n in (3, 7):
        two(f(*case(rng, n)), n)


@repair.link(
    "mean", "x + t cos(theta + r1), y + t sin(theta + r1), theta + r1 + r2, with the theta from before.", part=0
)
def _(f, rng):
    for n in (7, 3):
        c = case(rng, n)
        got, want = two(f(*c), n)[0], turn_go_turn(*c)[0]
        expect.close(np.delete(got, 2), np.delete(want, 2), "x (without the heading)")
        expect.angle(got[2], want[2], "the heading")


@repair.link("no motion, no change", "With u = 0 and U = 0 the state stays as it is.")
def _(f, rng):
    x, P, u, U = case(rng)
    got = two(f(x, P, 0 * u, 0 * U), 7)
    expect.close(got[1], P, "P after no motion")


@repair.link(
    "column of the heading", "With U = 0: P_rr = X_x P_rr X_x'. Ask finite differences for X_x, entry by entry.", 1
)
def _(f, rng):
    for n in (7, 3):
        x, P, u, U = case(rng, n)
        got, want = two(f(x, P, u, 0 * U), n)[1], turn_go_turn(x, P, u, 0 * U)[1]
        expect.close(got[:3, :3], want[:3, :3], "P_rr without noise")


@repair.link("P_rm", "The covariance of the robot with the map: P_rm = X_x P_rm; the map's own block stays.", 1)
def _(f, rng):
    for n in (7, 5):
        x, P, u, U = case(rng, n)
        got, want = two(f(x, P, u, 0 * U), n)[1], turn_go_turn(x, P, u, 0 * U)[1]
        expect.close(got, want, "P without noise")


@repair.link("noise", "X_u U X_u': the derivatives of the new pose by r1, t and r2, in this order.", 1)
def _(f, rng):
    for n in (3, 7):
        x, P, u, U = case(rng, n)
        expect.close(two(f(x, 0 * P, u, U), n)[1], turn_go_turn(x, 0 * P, u, U)[1], "P from the noise alone")


@repair.link("all together", "P = F_x P F_x' + F_u U F_u', in one step.")
def _(f, rng):
    for n in (5, 3, 11):
        c = case(rng, n)
        (x, P), (x_want, P_want) = two(f(*c), n), turn_go_turn(*c)
        expect.close(np.delete(x, 2), np.delete(x_want, 2), "x (without the heading)")
        expect.angle(x[2], x_want[2], "the heading")
        expect.close(P, P_want, "P")
        expect.symmetric(P, "P")


# ---- wrong and right answers ---------------------------------------------------------------------------------------


def _variation(X_x=None, X_u=None, N=None, mean=None, map_too=True):
    """The right prediction with one part replaced: each argument gets (theta, r1, t, r2) and what is right."""

    def answer(x, P, u, U):
        th, (r1, t, r2) = x[2], u
        a = th + r1
        F = np.array([[1, 0, -t * np.sin(a)], [0, 1, t * np.cos(a)], [0, 0, 1]])
        G = np.array([[-t * np.sin(a), np.cos(a), 0], [t * np.cos(a), np.sin(a), 0], [1, 0, 1]])
        F = F if X_x is None else X_x(F, th, r1, t, r2)
        G = G if X_u is None else X_u(G, th, r1, t, r2)
        x2, P2 = np.array(x, float), np.array(P, float)
        x2[:3] += [t * np.cos(a), t * np.sin(a), r1 + r2] if mean is None else mean(th, r1, t, r2)
        P2[:3, :3] = F @ P[:3, :3] @ F.T + (G @ U @ G.T if N is None else N(G, U))
        if map_too:
            P2[:3, 3:] = F @ P[:3, 3:]
            P2[3:, :3] = P2[:3, 3:].T
        return x2, P2

    return answer


def _column(F, x, y):
    F = F.copy()
    F[:2, 2] = x, y
    return F


def _late(change):
    """X_x and X_u taken after the heading has changed; `change(t, a)` is the column of the heading."""
    X_x = lambda F, th, r1, t, r2: _column(F, *change(t, th + r1 + r2 + r1))

    def X_u(G, th, r1, t, r2):
        a = th + r1 + r2 + r1
        return np.array([[-t * np.sin(a), np.cos(a), 0], [t * np.cos(a), np.sin(a), 0], [1, 0, 1]])

    return X_x, X_u


RIGHT, SWAPPED = lambda t, a: (-t * np.sin(a), t * np.cos(a)), lambda t, a: (-t * np.cos(a), t * np.sin(a))


def _wrong(name, hint, answer):
    repair.wrong(name, hint)(answer)


# fmt: off
_wrong("as it was reported", "Both bugs are still there: sine and cosine, and one that the thread does not name. Ask "
       "your guard.", _variation(*_late(SWAPPED)))
_wrong("the repair of the thread", "Sine and cosine are right now. But x[2] has been changed before the Jacobians use "
       "it: take the angle before the motion.", _variation(*_late(RIGHT)))
_wrong("only X_u is still late", "X_x is right. X_u still uses the heading after the motion: one angle, taken before, "
       "for both.", _variation(None, _late(RIGHT)[1]))
_wrong("only X_x is still late", "X_u is right. X_x still uses the heading after the motion: one angle, taken before, "
       "for both.", _variation(_late(RIGHT)[0]))
_wrong("order repaired, sin and cos not", "The angle is right now. The column of the heading is the derivative: cos "
       "becomes -sin, sin becomes cos.", _variation(lambda F, th, r1, t, r2: _column(F, *SWAPPED(t, th + r1))))
_wrong("signs of the column", "The derivative of cos is -sin, that of sin is +cos.",
       _variation(lambda F, th, r1, t, r2: _column(F, t * np.sin(th + r1), -t * np.cos(th + r1))))
_wrong("no minus", "The derivative of cos is -sin: the first entry has a minus.",
       _variation(lambda F, th, r1, t, r2: _column(F, t * np.sin(th + r1), t * np.cos(th + r1))))
_wrong("r1 forgotten in X_x", "The robot has turned by r1 when it goes: the angle is theta + r1.",
       _variation(lambda F, th, r1, t, r2: _column(F, *RIGHT(t, th))))
_wrong("r1 forgotten", "The robot turns by r1 first, then it goes: the direction is theta + r1.",
       _variation(lambda F, th, r1, t, r2: _column(F, *RIGHT(t, th)),
                 lambda G, th, r1, t, r2: np.array([[0, np.cos(th), 0], [0, np.sin(th), 0], [1, 0, 1]]),
                 mean=lambda th, r1, t, r2: [t * np.cos(th), t * np.sin(th), r1 + r2]))
_wrong("both turns before going", "The way lies between the two turns: its direction is theta + r1, without r2.",
       _variation(mean=lambda th, r1, t, r2: [t * np.cos(th + r1 + r2), t * np.sin(th + r1 + r2), r1 + r2]))
_wrong("transposed", "X_x P X_x', not X_x' P X_x.", _variation(lambda F, *_: F.T))
_wrong("heading row zero", "The new heading is the old one plus r1 + r2: the last row is 0 0 1.",
       _variation(lambda F, *_: np.diag([1, 1, 0]) @ F))
_wrong("P_rm not moved", "P_rm = X_x P_rm, and its mirror image: the robot's rows and columns, not P_rr only.",
       _variation(map_too=False))
_wrong("noise as it is", "U is the covariance of r1, t and r2, not of x, y and theta: X_u U X_u'.",
       _variation(N=lambda G, U: U))
_wrong("noise forgotten", "The control is uncertain: + X_u U X_u'.", _variation(N=lambda G, U: 0 * U))
_wrong("first column of X_u forgotten", "r1 moves the position, too: its column is [-t sin, t cos, 1].",
       _variation(None, lambda G, *_: G * [[0, 1, 1], [0, 1, 1], [1, 1, 1]]))
_wrong("r2 forgotten in X_u", "Both turns change the heading: the last row of X_u is 1 0 1.",
       _variation(None, lambda G, *_: G * [[1, 1, 1], [1, 1, 1], [1, 1, 0]]))
_wrong("U squared", "U is a covariance already.", _variation(N=lambda G, U: G @ U @ U @ G.T))
_wrong("X_u transposed", "X_u U X_u', not X_u' U X_u.", _variation(N=lambda G, U: G.T @ U @ G))
_wrong("r1 and r2 swapped", "The first number of u is the turn before the way.",
       lambda x, P, u, U: turn_go_turn(x, P, u[::-1], U))
_wrong("mean not moved", "The mean moves as well: return the new x.",
       lambda x, P, u, U: (np.array(x), turn_go_turn(x, P, u, U)[1]))
# fmt: on


@repair.variant("whole matrices")
def _(x, P, u, U):
    n, (r1, t, r2) = len(x), u
    a = x[2] + r1
    F, G = np.eye(n), np.zeros((n, 3))
    F[0, 2], F[1, 2] = -t * np.sin(a), t * np.cos(a)
    G[:3] = [[-t * np.sin(a), np.cos(a), 0], [t * np.cos(a), np.sin(a), 0], [1, 0, 1]]
    return x + G[:, 1] * t + [0, 0, r1 + r2, *(n - 3) * [0]], F @ P @ F.T + G @ U @ G.T


@repair.variant("from its own mean by finite differences, lists, whole turns added")
def _(x, P, u, U):
    def mean(x, u):
        new = np.array(x, float)
        new[:3] += [u[1] * np.cos(x[2] + u[0]), u[1] * np.sin(x[2] + u[0]), u[0] + u[2] + 4 * np.pi]
        return new

    from ...geometry import numerical_jacobian

    F, G = numerical_jacobian(lambda a: mean(a, u), x), numerical_jacobian(lambda b: mean(x, b), u)
    return mean(x, u).tolist(), (F @ P @ F.T + G @ U @ G.T).tolist()


@repair.variant("three motions of the package, one after the other")
def _(x, P, u, U):
    from ...models.motion import Odometry2

    x, P, A = np.array(x, float), np.array(P, float), np.zeros((3, 3))
    for step, row in (([0, 0, u[0]], 0), ([u[1], 0, 0], 1), ([0, 0, u[2]], 2)):
        x[:3], X_x, X_u = Odometry2().move(x[:3], np.array(step), 1.0)
        P[:3] = X_x @ P[:3]
        P[:, :3] = P[:, :3] @ X_x.T
        A = X_x @ A
        A[:, row] += X_u[:, 0 if row == 1 else 2]
    P[:3, :3] += A @ U @ A.T
    return x, P
