"""Exercise 05.1: the prediction step of EKF-SLAM."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..table import table
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


def case(rng, n=7):
    """Return a state, a covariance, a step and its covariance at random: nothing zero, nothing symmetric."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-3, 3)
    u = np.array([rng.uniform(0.5, 2), rng.uniform(-1, 1), rng.uniform(-1, 1)])
    return x, random_covariance(rng, n), u, random_covariance(rng, 3, 0.05)


def along_x(rng):
    """Return the same for a robot that looks along the x axis."""
    x, *others = case(rng)
    x[2] = 0
    return x, *others


def without_noise(rng, n):
    """Return the same for a step that is exact."""
    x, P, u, U = case(rng, n)
    return x, P, u, 0 * U


def nearly_certain(rng, n):
    """Return the same for a robot whose pose is nearly certain."""
    x, P, u, U = case(rng, n)
    P[:3] *= 1e-3
    P[:, :3] *= 1e-3
    return x, P, u, U


prediction = table(
    "05.1 Predict",
    predict,
    hints=(
        "The step is seen from the robot: turn it by theta before you add it to the pose. X_x and X_u are the derivatives of the new pose, taken at the old one.",
        "With c = cos(theta), s = sin(theta): X_u = [[c, -s, 0], [s, c, 0], [0, 0, 1]] and the new pose is x_r + X_u u. Its derivative by theta is the last column of X_x.",
        "The last column of X_x is [-s dx - c dy, c dx - s dy, 1]. Then P_rr = X_x P_rr X_x' + X_u U X_u', P_rm = X_x P_rm, P_mr = P_rm', and P_mm stays.",
    ),
    returns="x, P",
    symbols="X_x, X_u = the derivatives of the new pose by the old one and by u; P_rr = P[:3, :3]; P_rm = P[:3, 3:]; "
    "P_mr = P[3:, :3]; P_mm = P[3:, 3:]",
    angles={"x": 2},
    cases={
        "any": lambda rng: [case(rng, n) for n in (7, 3, 5, 11)],
        "along x": lambda rng: [along_x(rng) for _ in range(3)],
        "no noise": lambda rng: [without_noise(rng, n) for n in (3, 7, 3)],
        "certain": lambda rng: [nearly_certain(rng, n) for n in (3, 7)],
    },
    checks="""
    the landmarks stay           | x[3:]     | any      | Only the robot moves: x[3:] does not change.
    the pose, theta = 0          | x[:3]     | along x  | A robot that looks along the x axis: the step is simply added.
    the pose                     | x[:3]     | any      | The step is seen from the robot: which way are `ahead` and `to the left` in the map? And the heading grows by dtheta.
    X_x P X_x'                   | P[:3, :3] | no noise | Without noise: P_rr becomes X_x P_rr X_x', with X_x taken at the pose before the step.
    X_u U X_u'                   | P[:3, :3] | certain  | The pose is nearly certain here, so P_rr is nearly X_u U X_u': the noise of the step, ahead, to the left and in the turn, brought into the map.
    block of the map             | P[3:, 3:] | any      | Landmarks stand still, and no motion noise reaches them: P_mm stays.
    blocks between robot and map | P[:3, 3:], P[3:, :3] | any | P_rm becomes X_x P_rm, and P_mr its transpose.
    """,
    wrong="""
    step not turned | x[:3] += X_u @ u -> x[:3] += u | The step is seen from the robot, the pose is in the map: turn the step by theta first.
    step turned the other way | x[:3] += X_u @ u -> x[:3] += X_u.T @ u | [[c, s], [-s, c]] brings the map to the robot. Here a step of the robot goes into the map: [[c, -s], [s, c]].
    turned first, then driven: The step is seen from the robot *before* the step: turn it by the old heading.
        x[:3] += X_u @ u -> x[2] += u[2]; x[:2] += [np.cos(x[2]) * u[0] - np.sin(x[2]) * u[1], np.sin(x[2]) * u[0] + np.cos(x[2]) * u[1]]
    step to the left forgotten | x[:3] += X_u @ u -> x[:3] += X_u @ [u[0], 0, u[2]] | u has three numbers: dx ahead, dy to the left, dtheta.
    step to the right | x[:3] += X_u @ u -> x[:3] += X_u @ [u[0], -u[1], u[2]] | dy counts to the left: with theta = 0 it is added to y.
    heading not changed | x[:3] += X_u @ u -> x[:3] += X_u @ [u[0], u[1], 0] | The robot turns, too: theta + dtheta.
    heading turned the other way | x[:3] += X_u @ u -> x[:3] += X_u @ [u[0], u[1], -u[2]] | A positive dtheta turns to the left: theta *plus* dtheta.
    sine and cosine swapped | x[:3] += X_u @ u -> x[:3] += np.array([[s, -c, 0], [c, s, 0], [0, 0, 1]]) @ u | cos belongs to x and sin to y.
    theta taken as degrees | x[:3] += X_u @ u -> c, s = np.cos(np.radians(x[2])), np.sin(np.radians(x[2])); x[:3] += np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ u | Angles are in radians already.
    theta taken as degrees in the Jacobians | P[:3] = X_x -> c, s = np.cos(np.radians(x[2] - u[2])), np.sin(np.radians(x[2] - u[2])); X_x[:2, 2] = -s * u[0] - c * u[1], c * u[0] - s * u[1]; X_u[:2, :2] = [[c, -s], [s, c]]; P[:3] = X_x | Angles are in radians already, in X_x and X_u, too.
    Jacobians after the move: X_x and X_u are taken at the pose *before* the step: compute them before you change x.
        P[:3] = X_x -> c, s = np.cos(x[2]), np.sin(x[2]); X_x[:2, 2] = -s * u[0] - c * u[1], c * u[0] - s * u[1]; X_u[:2, :2] = [[c, -s], [s, c]]; P[:3] = X_x
    X_u after the move | P[:3] = X_x -> c, s = np.cos(x[2]), np.sin(x[2]); X_u = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]); P[:3] = X_x | X_u is taken at the pose *before* the step, as X_x is: compute it before you change x.
    X_x is the identity | P[:3] = X_x -> X_x = np.eye(3); P[:3] = X_x | The new position depends on theta, too: the last column of X_x is not [0, 0, 1].
    X_x' P X_x | P[:3] = X_x -> P[:3] = X_x.T | The Jacobian stands on the left and its transpose on the right: X_x P X_x'.
        P[:, :3] @ X_x.T -> P[:, :3] @ X_x
    sign in X_x | [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]] -> [[1, 0, s * u[0] + c * u[1]], [0, 1, s * u[1] - c * u[0]] | d cos(theta) = -sin(theta): check the signs in the last column of X_x.
    sign of one entry of X_x | -s * u[0] - c * u[1] -> s * u[0] + c * u[1] | d cos(theta) = -sin(theta): the first entry of the last column is -s dx - c dy.
    dy forgotten in X_x | [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]] -> [[1, 0, -s * u[0]], [0, 1, c * u[0]] | The last column of X_x is [-s dx - c dy, c dx - s dy, 1]: dy is in it, too.
    X_x not turned | [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]] -> [[1, 0, -u[1]], [0, 1, u[0]] | The last column of X_x holds the step in the map, turned by 90 degrees: use sin and cos of theta.
    U not turned | X_u @ U @ X_u.T -> U | U says how uncertain the step is, ahead and to the left. In the map that is X_u U X_u'.
    U turned the other way | X_u @ U @ X_u.T -> X_u.T @ U @ X_u | Either the order is wrong, or X_u is the transpose: X_u U X_u' with X_u = [[c, -s, 0], [s, c, 0], [0, 0, 1]], from the robot to the map.
    U squared | X_u @ U @ X_u.T -> X_u @ U**2 @ X_u.T | U holds variances already: do not square it.
    dtheta for its derivative | X_u @ U @ X_u.T -> (X_u * [1, 1, u[2]]) @ U @ (X_u * [1, 1, u[2]]).T | The heading grows by dtheta: its derivative by dtheta is 1, whatever dtheta is. X_u[2, 2] = 1.
    only the diagonal of U | X_u @ U @ X_u.T -> X_u @ np.diag(np.diag(U)) @ X_u.T | Use the whole U: the errors of the step may be correlated.
    no noise | P[:3, :3] += X_u @ U @ X_u.T -> pass | The odometry is not exact: add X_u U X_u' to the block of the robot.
    only noise | P[:3, :3] += X_u -> P[:3, :3] = X_u | The old uncertainty does not vanish: P_rr becomes X_x P_rr X_x' + X_u U X_u'.
    noise subtracted | P[:3, :3] += X_u -> P[:3, :3] -= X_u | Noise makes the robot more uncertain: X_u U X_u' is added.
    P_rm not propagated | P[:3] = X_x @ P[:3] -> P[:3, :3] = X_x @ P[:3, :3] | The landmarks stand still, but the robot does not: P_rm becomes X_x P_rm.
        P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T
    P_rm forgotten | return x, P -> P[:3, 3:], P[3:, :3] = 0, 0; return x, P | Moving does not make robot and map independent: P_rm becomes X_x P_rm, not zero.
    P_mr not changed | P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T | P_mr is the transpose of P_rm: change the columns of the robot, too.
    noise on the landmarks | return x, P -> P[3:, 3:] += U[0, 0] * np.eye(len(P) - 3); return x, P | The landmarks stand still: no noise is added to P_mm.
    landmarks pushed along | return x, P -> x[3::2] += (X_u @ u)[0]; x[4::2] += (X_u @ u)[1]; return x, P | The landmarks stand still: only x[:3] changes.
    entries of the heading column exchanged: The two entries of the last column of X_x are exchanged: -s dx - c dy belongs in the row of x, c dx - s dy in the row of y.
        [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]] -> [[1, 0, c * u[0] - s * u[1]], [0, 1, -s * u[0] - c * u[1]]
    noise before the motion: Your noise goes through X_x as well: it belongs to the pose after the step, so add it after the motion.
        P[:3, :3] += X_u @ U @ X_u.T -> pass
        P[:3] = X_x @ P[:3] -> P[:3, :3] += X_u @ U @ X_u.T; P[:3] = X_x @ P[:3]
    root of U | X_u @ U @ X_u.T -> X_u @ np.sqrt(np.abs(U)) @ X_u.T | U holds variances already: no root.
    noise on the last three states | P[:3, :3] += X_u -> P[-3:, -3:] += X_u | The robot's pose is the first three numbers of the state: the noise goes into P[:3, :3].
    noise on the position only | P[:3, :3] += X_u @ U @ X_u.T -> P[:2, :2] += (X_u @ U @ X_u.T)[:2, :2] | The turn has noise, too: X_u U X_u' is added to all of P[:3, :3].
    noise twice | P[:3, :3] += X_u -> P[:3, :3] += 2 * X_u | The noise of the step comes once: + X_u U X_u'.
    diagonal of the noise only | P[:3, :3] += X_u @ U @ X_u.T -> P[:3, :3] += np.diag(np.diag(X_u @ U @ X_u.T)) | In the map the errors of x, y and theta are correlated: add the whole X_u U X_u'.
    turned the other way, in all: [[c, s], [-s, c]] brings the map to the robot. Here a step of the robot goes into the map: [[c, -s], [s, c]], in X_x and X_u, too.
        [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]] -> [[1, 0, -s * u[0] + c * u[1]], [0, 1, -c * u[0] - s * u[1]]
        [[c, -s, 0], [s, c, 0] -> [[c, s, 0], [-s, c, 0]
    turned first, then driven, in all: The step is seen from the robot *before* the step: turn it by the old heading, in X_x and X_u, too.
        c, s = np.cos(x[2]), np.sin(x[2]) -> c, s = np.cos(x[2] + u[2]), np.sin(x[2] + u[2])
        x, P = x.copy() -> N = X_u.copy(); N[:2, 2] = X_x[:2, 2]; x, P = x.copy()
        P[:3, :3] += X_u @ U @ X_u.T -> P[:3, :3] += N @ U @ N.T
    the first landmark only | return x, P -> Q = P.copy(); Q[:3, 5:], Q[5:, :3] = old[:3, 5:], old[5:, :3]; return x, Q | All landmarks are correlated with the robot: all of P_rm changes, columns 3 to the end.
        x, P = x.copy(), P.copy() -> old = P; x, P = x.copy(), P.copy()
    P_mr from the new P_rm, moved again | return x, P -> P[3:, :3] = P[:3, 3:].T @ X_x.T; return x, P | P_mr is the transpose of the new P_rm, and no more: it is not multiplied by X_x once more.
    arm from the origin in X_x | P[:3] = X_x @ P[:3] -> X_x[:2, 2] = -x[1], x[0]; P[:3] = X_x @ P[:3] | A wrong heading turns the *step*, not the whole way from the origin: the last column is that of the new position less the old one.
    half of the turn, in all: The step is seen from the robot *before* the step: turn it by the old heading, in X_x and X_u, too.
        c, s = np.cos(x[2]), np.sin(x[2]) -> c, s = np.cos(x[2] + u[2] / 2), np.sin(x[2] + u[2] / 2)
    X_x twice in P_rr | P[:3, :3] += X_u -> P[:3, :3] = X_x @ P[:3, :3]; P[:3, :3] += X_u | X_x comes in twice on the left of P_rr: that happens if its rows have gone through X_x before. Compute each block from the old P.
    """,
    forms="""
    matrices of the whole state | P[:3] = X_x @ P[:3] -> F, G = np.eye(len(x)), np.zeros((len(x), 3)) | F P F' + G U G' of the whole state
        P[:, :3] = P[:, :3] @ X_x.T -> F[:3, :3], G[:3] = X_x, X_u
        P[:3, :3] += X_u @ U @ X_u.T -> P = F @ P @ F.T + G @ U @ G.T
    """,
)


@prediction.link("thirty steps", "After many steps P must still be symmetric, without negative eigenvalues.", part=1)
def _(f, rng):
    x, P, u, U = case(rng, 7)
    for _ in range(30):
        x, P = expect.results(f(x, P, u, 0.1 * U), "x", "P")
        x, P = expect.array(x, 7, "x"), expect.array(P, (7, 7), "P")
    expect.symmetric(P, "P after 30 steps", 1e-6)
    expect.psd(P, "P after 30 steps", 1e-7)
