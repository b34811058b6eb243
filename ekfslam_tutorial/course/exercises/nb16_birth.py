"""Exercise 16.3: a range and an assumed bearing make a landmark."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def hypothesis(x, P, r, var, beta, N):
    """One hypothesis of where a beacon is: the inverse model of a range, with a prior for what it leaves open.

    x = [x; y; theta], shape (3,), is the pose of the robot (m, rad) and P, shape (3, 3), its covariance. r (m) is a
    measured range with the variance var. The range says nothing of the bearing: beta (rad, from the robot's x axis) is
    assumed, with the variance N.
    Return the point p, shape (2,), in the world, its covariance P_pp, shape (2, 2), and its covariance with the robot
    P_px, shape (2, 3).
    """
    c, s = np.cos(x[2] + beta), np.sin(x[2] + beta)
    p = x[:2] + r * np.array([c, s])
    P_x = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]])  # dp/dx
    P_r, P_beta = np.array([c, s]), r * np.array([-s, c])  # dp/dr, dp/dbeta
    P_pp = P_x @ P @ P_x.T + var * np.outer(P_r, P_r) + N * np.outer(P_beta, P_beta)
    P_px = P_x @ P
    return p, P_pp, P_px


def case(rng, scale=1.0, pose=1.0, range_=1.0, prior=1.0):
    """A pose with a full covariance, a range, an assumed bearing, and their variances, in these multiples."""
    x = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
    P = pose * random_covariance(rng, 3, 0.3 * scale)
    var, N = range_ * (0.1 * scale) ** 2 * rng.uniform(0.5, 2), prior * rng.uniform(0.01, 0.09)
    return x, P, rng.uniform(1, 6), var, rng.uniform(-3, 3), N


born = table(
    "16.3 A range and a prior make a point",
    hypothesis,
    hints=(
        "p = [x, y] + r [cos(theta + beta), sin(theta + beta)]. Uncertain in it: the pose, the range, the bearing.",
        "One Jacobian for each: by the pose (2 x 3), by r: m = [c, s], by beta: r [-s, c]. Each makes a term of P_pp.",
        "P_pp = P_x P P_x' + m var m' + (r m') N (r m')', with m' = [-s, c]; P_px = P_x P.",
    ),
    returns="p, P_pp, P_px",
    symbols="P_x = dp/dx",
    cases={
        "any": lambda rng: [case(rng, scale) for scale in (1.0, 0.1, 3.0)],
        "prior": lambda rng: [case(rng, pose=0, range_=0) for _ in range(2)],
        "range": lambda rng: [case(rng, pose=0, prior=0) for _ in range(2)],
    },
    checks="""
    the point                 | p    | any   | From the robot, r metres in the direction theta + beta.
    pose and range known      | P_pp | prior | Where pose and range are known (P = 0, var = 0) only the prior is left: the point is uncertain *across* the line of sight. How far does a small step of beta move it?
    pose and bearing known    | P_pp | range | Where pose and bearing are known (P = 0, N = 0) only the range is left: the point is uncertain *along* the line of sight, by as much as the range is.
    covariance with the robot | P_px | any   | Error of the pose in, error of the point out: P_px = P_x P.
    own covariance            | P_pp | any   | Three causes of error, three terms: pose, range, prior of the bearing. The last two are tested before, with P = 0. With var = 0 and N = 0 the first is left: what the error of the pose, P, makes of the point through P_x.
    """,
    wrong="""
    heading forgotten | p = x[:2] + r * np.array([c, s]) -> p = x[:2] + r * np.array([np.cos(beta), np.sin(beta)]) | beta is counted from the robot's x axis. In the world the direction is theta + beta.
    heading subtracted | p = x[:2] + r * np.array([c, s]) -> p = x[:2] + r * np.array([np.cos(beta - x[2]), np.sin(beta - x[2])]) | From the robot into the world: theta + beta, with a plus.
    left in the robot's frame | p = x[:2] + r -> p = r | Add the position of the robot.
    sine and cosine swapped | p = x[:2] + r * np.array([c, s]) -> p = x[:2] + r * np.array([s, c]) | x goes with the cosine, y with the sine.
    degrees | p = x[:2] + r * np.array([c, s]) -> p = x[:2] + r * np.array([np.cos(np.radians(x[2] + beta)), np.sin(np.radians(x[2] + beta))]) | All angles are in radians already: no conversion.
    prior forgotten | + N * np.outer(P_beta, P_beta) -> + 0 | Without the term of N the filter believes that it has measured the bearing.
    angle for a length | N * np.outer(P_beta, P_beta) -> N / r**2 * np.outer(P_beta, P_beta) | An angle is no length: across the line of sight it makes r times the angle, so r^2 N.
    range once | N * np.outer(P_beta, P_beta) -> N / r * np.outer(P_beta, P_beta) | The variance goes with the *square* of the Jacobian: r^2 N, not r N.
    N as a standard deviation | N * np.outer(P_beta, P_beta) -> N**2 * np.outer(P_beta, P_beta) | N is a variance already: do not square it.
    range noise forgotten | + var * np.outer(P_r, P_r) -> + 0 | The range is noisy, too: its variance lies along the line of sight.
    var as a standard deviation | var * np.outer(P_r, P_r) -> var**2 * np.outer(P_r, P_r) | var is a variance already: do not square it.
    along and across swapped | P_r, P_beta = np.array([c, s]), r * np.array([-s, c]) -> P_r, P_beta = np.array([-s, c]), r * np.array([c, s]) | The range is known *along* the line of sight, the bearing is open *across* it.
    pose taken as known | P_x @ P @ P_x.T + -> 0 + | That is the formula of mapping. The pose is uncertain: P_x P P_x' belongs in P_pp, and P_px = P_x P.
        P_px = P_x @ P -> P_px = 0 * P_x
    pose forgotten in P_pp | P_x @ P @ P_x.T + -> 0 + | P_px is there, but P_pp lacks the error of the pose: P_x P P_x'.
    zero cross-covariance | P_px = P_x @ P -> P_px = 0 * P_x | The point is made from the robot's pose: their errors are correlated, P_px = P_x P.
    heading taken as known | [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]] -> [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] | A wrong heading turns the point round the robot: the third column of P_x is r [-s, c].
    heading column without the range | [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]] -> [[1.0, 0.0, -s], [0.0, 1.0, c]] | An angle is no length: a wrong heading moves the point by r times it. The third column of P_x is r [-s, c].
    P_x instead of P_px | P_px = P_x @ P -> P_px = P_x | A Jacobian is not a covariance: P_px = P_x P.
    P_xp | P_px = P_x @ P -> P_px = P @ P_x.T | P_px has the point in its rows: shape (2, 3).
    arm from the origin | [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]] -> [[1.0, 0.0, -p[1]], [0.0, 1.0, p[0]]] | A wrong heading turns the point round the *robot*, not round the origin: the arm is p - x[:2], r [c, s].
    both variances squared: var and N are variances already: do not square them.
        var * np.outer(P_r -> var**2 * np.outer(P_r
        N * np.outer(P_beta -> N**2 * np.outer(P_beta
    rows of P alone | P_px = P_x @ P -> P_px = P[:2] | The heading moves the point as well as the position does: P_px = P_x P, with all three columns of P_x.
    heading the wrong way | P_x = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]]) -> P_x = np.array([[1.0, 0.0, r * s], [0.0, 1.0, -r * c]]) | Turned to the left, the robot moves the point to its left: the third column of P_x is r [-s, c].
    heading subtracted, in all: From the robot into the world: theta + beta, with a plus, in the derivatives, too.
        c, s = np.cos(x[2] + beta), np.sin(x[2] + beta) -> c, s = np.cos(beta - x[2]), np.sin(beta - x[2])
        [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]] -> [[1.0, 0.0, r * s], [0.0, 1.0, -r * c]]
    prior in the covariance of the robot | P_px = P_x @ P -> P_px = P_x @ (P + np.diag([0, 0, N])) | The prior of the bearing is no error of the robot: P_px = P_x P, with P as it is.
    prior twice | + N * np.outer(P_beta, P_beta) -> + 2 * N * np.outer(P_beta, P_beta) | The variance of the bearing counts once.
    width of a sector | N * np.outer(P_beta, P_beta) -> N**2 / 12 * np.outer(P_beta, P_beta) | N is the variance itself, not the width of a sector.
    turned by the heading only | P_r, P_beta = np.array([c, s]), r * np.array([-s, c]) -> P_r, P_beta = np.array([np.cos(x[2]), np.sin(x[2])]), r * np.array([-np.sin(x[2]), np.cos(x[2])]) | Range and bearing err along and across the *ray*: its direction is theta + beta, not theta.
    no correlation of position and heading | P_x @ P @ P_x.T + var -> P_x @ (P * [[1, 1, 0], [1, 1, 0], [0, 0, 1]]) @ P_x.T + var | Position and heading are correlated: P_x P P_x' with the whole P.
    heading column by beta alone | [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]] -> [[1.0, 0.0, -r * np.sin(beta)], [0.0, 1.0, r * np.cos(beta)]] | A wrong heading moves the point across the ray, and its direction is theta + beta.
    axes of the beam not turned: Along and across are directions in the world: they turn with theta + beta, and so do the variances.
        var * np.outer(P_r, P_r) + N * np.outer(P_beta, P_beta) -> np.diag([var, N * r**2])
    inner products | var * np.outer(P_r, P_r) + N * np.outer(P_beta, P_beta) -> var * (P_r @ P_r) + N * (P_beta @ P_beta) | The terms of r and beta are matrices, 2 x 2. Of flat vectors `a @ a.T` is one number, which is added to all four entries: take np.outer(a, a), or columns of the shape (2, 1).
    inner product of the prior | N * np.outer(P_beta, P_beta) -> N * (P_beta @ P_beta) | The term of beta is a matrix, 2 x 2. Of flat vectors `a @ a.T` is one number, which is added to all four entries: take np.outer(a, a), or columns of the shape (2, 1).
    inner product of the range | var * np.outer(P_r, P_r) -> var * (P_r @ P_r) | The term of r is a matrix, 2 x 2. Of flat vectors `a @ a.T` is one number, which is added to all four entries: take np.outer(a, a), or columns of the shape (2, 1).
    """,
)
