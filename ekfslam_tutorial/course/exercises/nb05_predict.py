"""Exercise 05.1: the prediction step of EKF-SLAM."""

import numpy as np

from ...geometry import wrap
from ...models.motion import Odometry2
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def predict(x, P, u, U):
    """One step of the robot in the joint state; the landmarks stand still.

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks. P, shape (n, n): its covariance.
    u = [dx, dy, dtheta]: the step that odometry has measured, seen from the robot before the step: so far ahead,
    so far to the left, then so much turned. U, shape (3, 3): its covariance.
    Return the new x and P. Do not change the inputs.
    """
    c, s = np.cos(x[2]), np.sin(x[2])
    X_x = np.array([[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]], [0, 0, 1]])
    X_u = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    x, P = x.copy(), P.copy()
    x[:3] += X_u @ u
    P[:3] = X_x @ P[:3]
    P[:, :3] = P[:, :3] @ X_x.T
    P[:3, :3] += X_u @ U @ X_u.T
    return x, P


def heading_wrapped(result):
    """Results (x, P) with the heading in (-pi, pi], to compare answers that differ by whole turns."""
    x, P = result
    x = np.array(x, float)
    x[2] = wrap(x[2])
    return x, P


prediction = Exercise(
    "05.1",
    "Predict",
    predict,
    canonical=heading_wrapped,
    hints=(
        "The step is seen from the robot: turn it by theta before you add it to the pose. X_x and X_u are the "
        "derivatives of the new pose, taken at the old one.",
        "With c = cos(theta), s = sin(theta): X_u = [[c, -s, 0], [s, c, 0], [0, 0, 1]] and the new pose is x_r + X_u "
        "u. Its derivative by theta is the last column of X_x.",
        "The last column of X_x is [-s dx - c dy, c dx - s dy, 1]. Then P_rr = X_x P_rr X_x' + X_u U X_u', P_rm = X_x "
        "P_rm, P_mr = P_rm', and P_mm stays.",
    ),
)

ROWS = ("x", "y", "theta")


def case(rng, n=7):
    """Return a state, a covariance, a step and its covariance at random: nothing zero, nothing symmetric."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-3, 3)
    u = np.array([rng.uniform(0.5, 2), rng.uniform(-1, 1), rng.uniform(-1, 1)])
    return x, random_covariance(rng, n), u, random_covariance(rng, 3, 0.05)


def two(result, n):
    """Return the results x and P as arrays."""
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@prediction.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    for n in (7, 3, 5, 11):
        two(f(*case(rng, n)), n)


@prediction.link("the landmarks stay", "Only the robot moves: x[3:] does not change.", part=0)
def _(f, rng):
    c = case(rng, 9)
    expect.close(two(f(*c), 9)[0][3:], c[0][3:], "x[3:], the landmarks,")


def _pose(f, c, what):
    got, want = two(f(*c), len(c[0]))[0][:3], Odometry2().move(c[0][:3], c[2], 1.0)[0]
    expect.close(got[:2], want[:2], f"the new position of {what}")
    expect.angle(got[2], want[2], f"the new heading of {what}")


@prediction.link("the pose, theta = 0", "A robot that looks along the x axis: the step is simply added.", part=0)
def _(f, rng):
    for _ in range(3):
        x, *rest = case(rng)
        x[2] = 0
        _pose(f, (x, *rest), "a robot with theta = 0")


@prediction.link("the pose", "The step is seen from the robot: which way is `ahead` in the map?", part=0)
def _(f, rng):
    for n in (7, 3, 5):
        _pose(f, case(rng, n), "a robot that looks anywhere")


@prediction.link("X_x P X_x'", "Without noise: P_rr becomes X_x P_rr X_x'. Is X_x taken before the step?", part=1)
def _(f, rng):
    for n in (3, 7, 3):
        x, P, u, U = case(rng, n)
        X_x = Odometry2().move(x[:3], u, 1.0)[1]
        got = two(f(x, P, u, 0 * U), n)[1][:3, :3]
        expect.close(got, X_x @ P[:3, :3] @ X_x.T, "P_rr after a step without noise", at="U = 0")


@prediction.link(
    "X_u U X_u'", "The noise is that of the step, ahead and to the left: X_u turns it into the map.", part=1
)
def _(f, rng):
    for n in (3, 7):
        x, P, u, U = case(rng, n)
        _, X_x, X_u = Odometry2().move(x[:3], u, 1.0)
        P[:3, :3] *= 1e-6
        P[:3, 3:], P[3:, :3] = 1e-3 * P[:3, 3:], 1e-3 * P[3:, :3]
        got = two(f(x, P, u, U), n)[1][:3, :3]
        expect.close(got, X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T, "P_rr", at="a pose that is nearly certain")


@prediction.link("block of the map", "Landmarks stand still, and no motion noise reaches them: P_mm stays.", part=1)
def _(f, rng):
    for n in (7, 5, 11):
        c = case(rng, n)
        expect.close(two(f(*c), n)[1][3:, 3:], c[1][3:, 3:], "P_mm, the block of the landmarks,", 1e-7)


@prediction.link("blocks between robot and map", "P_rm becomes X_x P_rm, and P_mr its transpose.", part=1)
def _(f, rng):
    for n in (7, 5, 11):
        x, P, u, U = case(rng, n)
        got, X_x = two(f(x, P, u, U), n)[1], Odometry2().move(x[:3], u, 1.0)[1]
        expect.close(got[:3, 3:], X_x @ P[:3, 3:], "P_rm, rows of the robot, columns of the map,")
        expect.symmetric(got, "P", 1e-7)


@prediction.link("thirty steps", "After many steps P must still be symmetric, without negative eigenvalues.", part=1)
def _(f, rng):
    x, P, u, U = case(rng, 7)
    for _ in range(30):
        x, P = two(f(x, P, u, 0.1 * U), 7)
    expect.symmetric(P, "P after 30 steps", 1e-6)
    expect.psd(P, "P after 30 steps", 1e-7)


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def jacobians(theta, u):
    """Return X_x and X_u, written with the heading `theta`."""
    c, s = np.cos(theta), np.sin(theta)
    X_x = np.array([[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]], [0, 0, 1]])
    return X_x, np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def covariance(P, X_x, noise):
    """Return the moved covariance."""
    F = np.eye(len(P))
    F[:3, :3] = X_x
    P = F @ P @ F.T
    P[:3, :3] += noise
    return P


def with_cross(P, X_x, X_u, U, P_rm, P_mr):
    """Return the moved covariance with other blocks between robot and map."""
    return np.block([[X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T, P_rm], [P_mr, P[3:, 3:]]])


def _wrong(name, hint, pose=None, P_of=None):
    """A misconception in the new pose, pose(x_r, u), or in the new covariance, P_of(P, X_x, X_u, U, theta, u)."""

    @prediction.wrong(name, hint)
    def _(x, P, u, U):
        X_x, X_u = jacobians(x[2], u)
        new = x.copy()
        new[:3] = x[:3] + X_u @ u if pose is None else pose(x[:3], u)
        return new, P_of(P, X_x, X_u, U, x[2], u) if P_of else covariance(P, X_x, X_u @ U @ X_u.T)


# fmt: off
_wrong("step not turned", "The step is seen from the robot, the pose is in the map: turn the step by theta first.",
       pose=lambda x, u: x + u)
_wrong("step turned the other way", "[[c, s], [-s, c]] brings the map to the robot. Here a step of the robot goes into "
       "the map: [[c, -s], [s, c]].", pose=lambda x, u: x + jacobians(-x[2], u)[1] @ u)
_wrong("turned first, then driven", "The step is seen from the robot *before* the step: turn it by the old heading.",
       pose=lambda x, u: x + jacobians(x[2] + u[2], u)[1] @ u)
_wrong("step to the left forgotten", "u has three numbers: dx ahead, dy to the left, dtheta.",
       pose=lambda x, u: x + jacobians(x[2], u)[1] @ [u[0], 0, u[2]])
_wrong("heading not changed", "The robot turns, too: theta + dtheta.",
       pose=lambda x, u: x + jacobians(x[2], u)[1] @ [u[0], u[1], 0])
_wrong("sine and cosine swapped", "cos belongs to x and sin to y.",
       pose=lambda x, u: x + jacobians(np.pi / 2 - x[2], u)[1] @ u)
_wrong("theta taken as degrees", "Angles are in radians "
       "already.", pose=lambda x, u: x + jacobians(np.radians(x[2]), u)[1] @ u)

_wrong("Jacobians after the move", "X_x and X_u are taken at the pose *before* the step: compute them before you "
       "change x.",
       P_of=lambda P, X, G, U, th, u: covariance(P, (J := jacobians(th + u[2], u))[0], J[1] @ U @ J[1].T))
_wrong("X_x is the identity", "The new position depends on theta, too: the last column of X_x is not [0, 0, 1].",
       P_of=lambda P, X, G, U, th, u: covariance(P, np.eye(3), G @ U @ G.T))
_wrong("X_x' P X_x", "The Jacobian stands on the left and its transpose on the right: X_x P X_x'.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X.T, G @ U @ G.T))
_wrong("sign in X_x", "d cos(theta) = -sin(theta): check the signs in the last column of X_x.",
       P_of=lambda P, X, G, U, th, u: covariance(P, 2 * np.eye(3) - X, G @ U @ G.T))
_wrong("sign of one entry of X_x", "d cos(theta) = -sin(theta): the first entry of the last column is -s dx - c dy.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X * [[1, 1, -1], [1, 1, 1], [1, 1, 1]], G @ U @ G.T))
_wrong("dy forgotten in X_x", "The last column of X_x is [-s dx - c dy, c dx - s dy, 1]: dy is in it, too.",
       P_of=lambda P, X, G, U, th, u: covariance(P, jacobians(th, [u[0], 0, 0])[0], G @ U @ G.T))
_wrong("X_x not turned", "The last column of X_x holds the step in the map, turned by 90 degrees: use sin and cos of "
       "theta.",
       P_of=lambda P, X, G, U, th, u: covariance(P, jacobians(0, u)[0], G @ U @ G.T))
_wrong("U not turned", "U says how uncertain the step is, ahead and to the left. In the map that is X_u U X_u'.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X, U))
_wrong("U turned the other way", "The noise goes through X_u from the left: X_u U X_u'.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X, G.T @ U @ G))
_wrong("U squared", "U holds variances already: do not square it.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X, G @ U**2 @ G.T))
_wrong("no noise", "The odometry is not exact: add X_u U X_u' to the block of the robot.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X, 0))
_wrong("P_rm not propagated", "The landmarks stand still, but the robot does not: P_rm becomes X_x P_rm.",
       P_of=lambda P, X, G, U, th, u: with_cross(P, X, G, U, P[:3, 3:], P[3:, :3]))
_wrong("P_rm forgotten", "Moving does not make robot and map independent: P_rm becomes X_x P_rm, not zero.",
       P_of=lambda P, X, G, U, th, u: with_cross(P, X, G, U, 0 * P[:3, 3:], 0 * P[3:, :3]))
_wrong("P_mr not changed", "P_mr is the transpose of P_rm: change the columns of the robot, too.",
       P_of=lambda P, X, G, U, th, u: with_cross(P, X, G, U, X @ P[:3, 3:], P[3:, :3]))
_wrong("noise on the landmarks", "The landmarks stand still: no noise is added to P_mm.",
       P_of=lambda P, X, G, U, th, u: covariance(P, X, G @ U @ G.T) + np.diag([0] * 3 + [U[0, 0]] * (len(P) - 3)))
# fmt: on


@prediction.wrong("landmarks pushed along", "The landmarks stand still: only x[:3] changes.")
def _(x, P, u, U):
    new, P = predict(x, P, u, U)
    new[3::2] += new[0] - x[0]
    new[4::2] += new[1] - x[1]
    return new, P


@prediction.variant("one big Jacobian, heading wrapped")
def _(x, P, u, U):
    X_x, X_u = jacobians(x[2], u)
    new = np.concatenate([x[:3] + X_u @ u, x[3:]])
    new[2] = np.arctan2(np.sin(new[2]), np.cos(new[2]))
    F, G = np.eye(len(x)), np.zeros((len(x), 3))
    F[:3, :3], G[:3] = X_x, X_u
    return new, F @ P @ F.T + G @ U @ G.T


@prediction.variant("the model of the toolbox, whole turns added, lists")
def _(x, P, u, U):
    x_r, X_x, X_u = Odometry2().move(x[:3], u, 1.0)
    return [*x_r[:2], x_r[2] + 4 * np.pi, *x[3:]], covariance(P, X_x, X_u @ U @ X_u.T).tolist()


@prediction.variant("finite differences, block by block")
def _(x, P, u, U):
    step = lambda v: (
        v[:3] + np.array([[np.cos(v[2]), -np.sin(v[2]), 0], [np.sin(v[2]), np.cos(v[2]), 0], [0, 0, 1]]) @ v[3:]
    )
    v = np.concatenate([x[:3], u])
    J = np.stack([(step(v + d) - step(v - d)) / 2e-6 for d in 1e-6 * np.eye(6)], 1)
    C = J[:, :3] @ P[:3, 3:]
    return np.concatenate([step(v), x[3:]]), np.block(
        [[J[:, :3] @ P[:3, :3] @ J[:, :3].T + J[:, 3:] @ U @ J[:, 3:].T, C], [C.T, P[3:, 3:]]]
    )
