"""Exercise 20.3: repair a published prediction in which the thread found one bug of two."""

import numpy as np

from ...geometry import wrap
from ..table import table
from .nb04_blocks import random_covariance


def turn_go_turn(x, P, u, U):
    """Prediction with the control u = [r1, t, r2]: turn by r1, go t straight ahead, turn by r2 (rad, m, rad).

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks, which stand still. P, shape (n, n): its
    covariance. U, shape (3, 3): covariance of u.
    Return the new x and P. Do not change the inputs.
    """
    r1, t, r2 = u
    c, s = np.cos(x[2] + r1), np.sin(x[2] + r1)  # of the way, before anything has moved
    dx, dy = t * c, t * s
    X_x = np.array([[1, 0, -t * s], [0, 1, t * c], [0, 0, 1]])
    X_u = np.array([[-t * s, c, 0], [t * c, s, 0], [1, 0, 1]])
    x, P = np.array(x, float), np.array(P, float)
    x[:3] = x[0] + dx, x[1] + dy, wrap(x[2] + r1 + r2)
    P[:3] = X_x @ P[:3]
    P[:, :3] = P[:, :3] @ X_x.T
    P[:3, :3] += X_u @ U @ X_u.T
    return x, P


def case(rng, n=7, motion=1, before=1, noise=1):
    """A state, a covariance, a step and its covariance at random: nothing zero but what is asked for."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-1.5, 1.5)
    u = motion * np.array([rng.uniform(0.3, 0.8), rng.uniform(0.5, 2), rng.uniform(0.3, 0.8)])
    return x, before * random_covariance(rng, n), u, noise * random_covariance(rng, 3, 0.05)


def _late(x, u):
    """Cosine and sine of the direction, with the heading that has been changed."""
    return np.cos(x[2] + 2 * u[0] + u[2]), np.sin(x[2] + 2 * u[0] + u[2])


def _timely(x, u):
    return np.cos(x[2] + u[0]), np.sin(x[2] + u[0])


repair = table(
    "20.3 Repair the prediction",
    turn_go_turn,
    hints=(
        "Hand the broken function to your guard: it says which part of P is wrong. Repair what the thread says, and ask the guard again.",
        "The column of the heading is the derivative of t cos(theta + r1) and t sin(theta + r1) by theta. And which theta does the code use there: the old one, or one that has been changed two lines above?",
        "Take the direction a = x[2] + r1 before x changes. Column of the heading: [-t sin a, t cos a, 1]. X_u = [[-t sin a, cos a, 0], [t cos a, sin a, 0], [1, 0, 1]].",
    ),
    returns="x, P",
    symbols="X_x, X_u = the derivatives of the new pose by the old one and by u; P_rr = P[:3, :3]; P_rm = P[:3, 3:]; "
    "F_x, F_u = the same as X_x and X_u, for the whole state",
    angles={"x": 2},
    cases={
        "any": lambda rng: [case(rng, n, motion) for n, motion in ((7, 1), (3, -1), (5, 1), (11, -1))],  # back, too
        "still": lambda rng: [case(rng, motion=0, noise=0)],
        "U = 0": lambda rng: [case(rng, n, noise=0) for n in (7, 3, 5)],
        "P = 0": lambda rng: [case(rng, n, before=0) for n in (3, 7)],
    },
    checks="""
    mean                  | x         | any   | x + t cos(theta + r1), y + t sin(theta + r1), theta + r1 + r2, with the theta from before.
    no motion, no change  | P         | still | With u = 0 and U = 0 the state stays as it is, and so does P: X_x is the identity then.
    column of the heading | P[:3, :3] | U = 0 | With U = 0: P_rr = X_x P_rr X_x'. Ask finite differences for X_x, entry by entry.
    P_rm                  | P         | U = 0 | The covariance of the robot with the map: P_rm = X_x P_rm, and its transpose on the other side; the map's own block stays.
    noise                 | P         | P = 0 | X_u U X_u': the derivatives of the new pose by r1, t and r2, in this order.
    all together          | P         | any   | P = F_x P F_x' + F_u U F_u', in one step.
    """,
    wrong="""
    as it was reported | X_x = np -> c, s = _late(x, u); X_x = np | Both bugs are still there: sine and cosine, and one that the thread does not name. Ask your guard.
        [0, 1, t * c], [0, 0, 1]] -> [0, 1, t * s], [0, 0, 1]]
        [[1, 0, -t * s] -> [[1, 0, -t * c]
    the repair of the thread | X_x = np -> c, s = _late(x, u); X_x = np | The places of sine and cosine are right. But the Jacobians are made with the heading after the motion: take theta + r1 with the theta from before it.
    only X_u is still late | X_u = np -> c, s = _late(x, u); X_u = np | X_u still uses the heading after the motion: one angle, taken before, for both.
    only X_x is still late | X_x = np -> c, s = _late(x, u); X_x = np | X_x still uses the heading after the motion: one angle, taken before, for both.
        X_u = np -> c, s = _timely(x, u); X_u = np
    order repaired, sin and cos not | [[1, 0, -t * s], [0, 1, t * c], [0, 0, 1]] -> [[1, 0, -t * c], [0, 1, t * s], [0, 0, 1]] | The column of the heading is the derivative: cos becomes -sin, sin becomes cos.
    signs of the column | [[1, 0, -t * s], [0, 1, t * c], [0, 0, 1]] -> [[1, 0, t * s], [0, 1, -t * c], [0, 0, 1]] | The derivative of cos is -sin, that of sin is +cos.
    no minus | [[1, 0, -t * s], -> [[1, 0, t * s], | The derivative of cos is -sin: the first entry has a minus.
    r1 forgotten in X_x | [[1, 0, -t * s], [0, 1, t * c], [0, 0, 1]] -> [[1, 0, -t * np.sin(x[2])], [0, 1, t * np.cos(x[2])], [0, 0, 1]] | The robot has turned by r1 when it goes: the angle is theta + r1.
    r1 forgotten | np.cos(x[2] + r1), np.sin(x[2] + r1) -> np.cos(x[2]), np.sin(x[2]) | The robot turns by r1 first, then it goes: the direction is theta + r1.
        [[-t * s, c, 0], [t * c, s, 0], [1, 0, 1]] -> [[0, c, 0], [0, s, 0], [1, 0, 1]]
    both turns before going | dx, dy = t * c, t * s -> dx, dy = t * np.cos(x[2] + r1 + r2), t * np.sin(x[2] + r1 + r2) | The way lies between the two turns: its direction is theta + r1, without r2.
    transposed | X_u = np -> X_x = X_x.T; X_u = np | X_x P X_x', not X_x' P X_x.
    heading row zero | t * c], [0, 0, 1]] -> t * c], [0, 0, 0]] | The new heading is the old one plus r1 + r2: the last row is 0 0 1.
    P_rm not moved | P[:3] = X_x @ P[:3] -> P[:3, :3] = X_x @ P[:3, :3] | P_rm = X_x P_rm, and its mirror image: the robot's rows and columns, not P_rr only.
        P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T
    columns not moved | P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T | P_rm has its mirror image, P_rm' in the first three columns: these change, too, or P is not symmetric.
    noise as it is | X_u @ U @ X_u.T -> U | U is the covariance of r1, t and r2, not of x, y and theta: X_u U X_u'.
    noise forgotten | X_u @ U @ X_u.T -> 0 | The control is uncertain: + X_u U X_u'.
    first column of X_u forgotten | [[-t * s, c, 0], [t * c, s, 0], [1, 0, 1]] -> [[0, c, 0], [0, s, 0], [1, 0, 1]] | r1 moves the position, too: its column is [-t sin, t cos, 1].
    r2 forgotten in X_u | [t * c, s, 0], [1, 0, 1]] -> [t * c, s, 0], [1, 0, 0]] | Both turns change the heading: the last row of X_u is 1 0 1.
    U squared | X_u @ U @ X_u.T -> X_u @ U @ U @ X_u.T | U is a covariance already.
    X_u transposed | X_u @ U @ X_u.T -> X_u.T @ U @ X_u | X_u U X_u', not X_u' U X_u.
    r1 and r2 swapped | r1, t, r2 = u -> r2, t, r1 = u | The first number of u is the turn before the way.
    mean not moved | x[:3] = x[0] + dx, x[1] + dy, wrap(x[2] + r1 + r2) -> pass | The mean moves as well: return the new x.
    brackets of the wrapping | wrap(x[2] + r1 + r2) -> (x[2] + r1 + r2 + np.pi) % 2 * np.pi - np.pi | `%` and `*` are done from left to right: (angle + pi) % (2 * pi) - pi needs the brackets round 2 * pi.
    degrees | np.cos(x[2] + r1), np.sin(x[2] + r1) -> np.cos(np.radians(x[2] + r1)), np.sin(np.radians(x[2] + r1)) | All angles are in radians already: no conversion.
    noise before the motion: Your noise goes through X_x as well: it belongs to the pose after the step, so add it after the motion.
        P[:3, :3] += X_u @ U @ X_u.T -> pass
        P[:3] = X_x @ P[:3] -> P[:3, :3] += X_u @ U @ X_u.T; P[:3] = X_x @ P[:3]
    r2 moves the position in X_u | [[-t * s, c, 0], [t * c, s, 0], -> [[-t * s, c, -t * s], [t * c, s, t * c], | When the robot turns by r2, it has gone: r2 changes the heading only, and its column of X_u is [0, 0, 1].
    heading at the end in the Jacobians | X_x = np -> c, s = np.cos(x[2] + r1 + r2), np.sin(x[2] + r1 + r2); X_x = np | The Jacobians use the heading of the end. The way is driven under theta + r1, before the second turn: so are its derivatives.
    heading at the end in X_x | X_x = np.array([[1, 0, -t * s], [0, 1, t * c], -> X_x = np.array([[1, 0, -t * np.sin(x[2] + r1 + r2)], [0, 1, t * np.cos(x[2] + r1 + r2)], | X_x uses the heading of the end. The way is driven under theta + r1, before the second turn.
    both turns before going, in all: The way lies between the two turns: its direction is theta + r1, and r2 does not move the robot. So it is in X_x and X_u.
        np.cos(x[2] + r1), np.sin(x[2] + r1) -> np.cos(x[2] + r1 + r2), np.sin(x[2] + r1 + r2)
        [[-t * s, c, 0], [t * c, s, 0], -> [[-t * s, c, -t * s], [t * c, s, t * c],
    second turn forgotten | wrap(x[2] + r1 + r2) -> wrap(x[2] + r1) | The robot turns a second time: the new heading is theta + r1 + r2.
    middle of both turns, in all: The way lies between the two turns: its direction is theta + r1, not that in the middle of both.
        np.cos(x[2] + r1), np.sin(x[2] + r1) -> np.cos(x[2] + (r1 + r2) / 2), np.sin(x[2] + (r1 + r2) / 2)
        [[-t * s, c, 0], [t * c, s, 0], -> [[-t * s / 2, c, -t * s / 2], [t * c / 2, s, t * c / 2],
    P_mr by X_x | P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3], P[3:, :3] = P[:3, :3] @ X_x.T, P[3:, :3] @ X_x | X_x' stands behind the robot's columns, P[3:, :3]: they are the transpose of P_rm.
    """,
    forms="""
    matrices of the whole state | P[:3] = X_x @ P[:3] -> F, G = np.eye(len(x)), np.zeros((len(x), 3)) | F P F' + G U G' of the whole state
        P[:, :3] = P[:, :3] @ X_x.T -> F[:3, :3], G[:3] = X_x, X_u
        P[:3, :3] += X_u @ U @ X_u.T -> P = F @ P @ F.T + G @ U @ G.T
    """,
)
