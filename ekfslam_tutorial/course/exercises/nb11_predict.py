"""Exercise 11.2: the prediction in space: noise in the control."""

import numpy as np

from ..table import table
from .nb11_odo3 import odo3, pose, step


def predict(x, P, u, U):
    """Move a frame and its covariance by one step of odometry that has noise.

    x, shape (7,), and P, shape (7, 7): the frame [t, q] and its covariance. u, shape (6,), and U, shape (6, 6): the
    step [dx, dv] as measured, in the axes of the robot, and its covariance.
    Return the new x and P.
    """
    x2, X_x, X_u = odo3(x, u)
    return x2, X_x @ P @ X_x.T + X_u @ U @ X_u.T


def _covariance(rng, n, scale):
    A = scale * rng.normal(size=(n, n))
    return A @ A.T


def case(rng, before=1.0, noise=1.0):
    """Return a frame, a step, and their covariances, in these multiples."""
    return pose(rng), before * _covariance(rng, 7, 0.05), step(rng), noise * _covariance(rng, 6, 0.03)


def _as_wanted(got, want):
    """The two results with the sign of the quaternion that odo3 has: -q turns as q does."""
    side = np.ones(7)
    if got[0][3:] @ want[0][3:] < 0:
        side[3:] = -1
    return [side * got[0], np.outer(side, side) * got[1]]


LEFT = np.array([0, 0, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])  # it looks along y

exercise = table(
    "11.2 Predict in space",
    predict,
    hints=(
        "You have odo3: it returns the new state and both Jacobians.",
        "P passes through X_x. The noise of the control, 6 x 6, becomes 7 x 7 through X_u.",
        "x2, X_x, X_u = odo3(x, u); P2 = X_x @ P @ X_x.T + X_u @ U @ X_u.T.",
    ),
    returns="x, P",
    symbols="X_x, X_u = the derivatives of the new frame by the old one and by u, from odo3",
    settled=_as_wanted,
    cases={
        "any": lambda rng: [case(rng) for _ in range(3)],
        "U = 0": lambda rng: [case(rng, noise=0) for _ in range(3)],
        "ahead": lambda rng: [(LEFT, np.zeros((7, 7)), np.eye(6)[0], np.diag([0.04, 0, 0, 0, 0, 0]))],
        "P = 0": lambda rng: [case(rng, before=0) for _ in range(3)],
    },
    checks="""
    mean                    | x         | any   | The new x is the first result of odo3: the frame after one step u, as measured.
    no noise in the control | P         | U = 0 | With U = 0 the covariance is X_x P X_x'.
    noise ahead             | P[:3, :3] | ahead | The noise is in the robot's axes: with P = 0 and the variance 0.04 of dx ahead, a robot that looks along y errs along y, with the variance 0.04.
    noise of the control    | P         | P = 0 | The covariance of the control becomes one of the state: X_u U X_u'.
    both                    | P         | any   | P is the sum of the two: X_x P X_x' + X_u U X_u'.
    """,
    wrong="""
    noise forgotten | X_x.T + X_u @ U @ X_u.T -> X_x.T | Each step adds uncertainty: + X_u U X_u'.
    P not moved | X_x @ P @ X_x.T -> P | P passes through X_x, too: an error of q makes an error of the position.
    P thrown away | X_x @ P @ X_x.T + X_u -> X_u | The old uncertainty stays: X_x P X_x' + X_u U X_u'.
    noise in the axes of the world | return x2 -> X_u[:3, :3] = np.eye(3); return x2 | The noise is in the robot's axes: it must be turned with the robot, which X_u does.
    U put into the corner | X_u @ U @ X_u.T -> np.pad(U, (0, 1)) | U belongs to the six numbers of the control, not to the first six of the state: X_u U X_u'.
    only the diagonal of U | X_u @ U @ X_u.T -> X_u @ np.diag(np.diag(U)) @ X_u.T | The noises of a control may be correlated: use the whole U.
    step and turn apart | X_u @ U @ X_u.T -> X_u @ (U * np.kron(np.eye(2), np.ones((3, 3)))) @ X_u.T | U holds the covariance of step and turn, too, off its two blocks: use the whole U, X_u U X_u'.
    transposed the wrong way | X_x @ P @ X_x.T -> X_x.T @ P @ X_x | Write X_x @ P @ X_x.T, the transposed one behind.
    U squared | X_u @ U @ X_u.T -> X_u @ U @ U @ X_u.T | U is a covariance already.
    X_u after the step | return x2 -> X_u = odo3(x2, u)[2]; return x2 | The Jacobians belong to the pose *before* the step: odo3(x, u).
    X_x multiplied once | X_x @ P @ X_x.T -> X_x @ P | A covariance is multiplied from both sides.
    mean not moved | return x2 -> return x | odo3 returns the new x as its first result: return it.
    Jacobians after the step | return x2 -> _, X_x, X_u = odo3(x2, u); return x2 | Both Jacobians belong to the pose *before* the step: odo3(x, u).
    noise subtracted | X_x.T + X_u -> X_x.T - X_u | Noise makes the prediction less certain: plus X_u U X_u'.
    noise through X_x | X_x @ P @ X_x.T + X_u @ U @ X_u.T -> X_x @ (P + X_u @ U @ X_u.T) @ X_x.T | Your noise goes through X_x as well: it belongs to the state after the step, so add it after the motion.
    position by q forgotten | return x2 -> X_x[:3, 3:] = 0; return x2 | An error of q moves the end of the step: the block of the position by q belongs in X_x, as odo3 has it.
    a step drawn at random | x2, X_x, X_u = odo3(x, u) -> x2, X_x, X_u = odo3(x, u + np.random.default_rng(0).multivariate_normal(np.zeros(6), U)) | The mean moves by the step as measured. Its noise is in P, nothing is drawn at random.
    """,
)
