"""Exercise 04.2: what a new landmark brings to the covariance of the joint state."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_inverse import inverse_observation, pose_and_measurement


def new_blocks(P, L_r, L_y, R):
    """Blocks that a new landmark brings to the covariance of the joint state.

    P, shape (n, n): covariance of the state so far; the robot's pose is its first 3 numbers.
    L_r, shape (2, 3), and L_y, shape (2, 2): derivatives of the landmark by the pose and by the measurement.
    R, shape (2, 2): covariance of the measurement.
    Return P_lx, shape (2, n), the landmark's covariance with all of the state so far, and P_ll, shape (2, 2).
    """
    P_lx = L_r @ P[:3]
    P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T
    return P_lx, P_ll


def random_covariance(rng, n, scale=1.0):
    """Return a covariance with no zero in it, nothing equal, units mixed: n x n, well conditioned."""
    A = rng.normal(size=(n, n + 3)) * rng.uniform(0.3, 1.5, (n, 1))
    return scale * A @ A.T / n


def some(rng, n, scale=1.0):
    """Return the covariance of a state of n numbers, and the derivatives and the noise of a new landmark."""
    _, L_r, L_y = inverse_observation(*pose_and_measurement(rng))
    return random_covariance(rng, n, scale), L_r, L_y, random_covariance(rng, 2, 0.1 * scale)


def pose_known(rng, n):
    """Return the same for a robot whose pose is known exactly."""
    P, *others = some(rng, n)
    P[:3], P[:, :3] = 0, 0
    return P, *others


blocks = table(
    "04.2 The covariance of a new landmark",
    new_blocks,
    hints=(
        "Write the error of the landmark: dl = L_r dx_r + L_y v, with v the error of the measurement. Each block of the covariance is the mean of a product of two errors.",
        "cov(dl, dx) = L_r cov(dx_r, dx), as v has nothing to do with dx. The rows of P that belong to the robot are P[:3].",
        "P_lx = L_r P[:3] and P_ll = L_r P_rr L_r' + L_y R L_y' with P_rr = P[:3, :3].",
    ),
    returns="P_lx, P_ll",
    symbols="P_xl = the transpose of P_lx; P_rr = P[:3, :3]; dx_r, dl = the errors of the pose and of the landmark",
    rtol={"P_lx": 1e-3, "P_ll": 1e-3},
    cases={
        "any": lambda rng: [some(rng, n) for n in (7, 3, 5, 13)],
        "pose known": lambda rng: [pose_known(rng, 7), pose_known(rng, 3)],
        "exact": lambda rng: [(*some(rng, n)[:3], np.zeros((2, 2))) for n in (5, 9)],
        "scales": lambda rng: [some(rng, 7), some(rng, 3, 1e-4), some(rng, 11, 5.0)],
    },
    checks="""
    shapes                            | P_lx[:0], P_ll[:0] | any | P_lx is 2 x n: the 2 rows of the landmark, one column for each number of the state so far. P_ll is 2 x 2: the landmark with itself.
    pose known exactly                | P_ll        | pose known | If the pose has no error, this must be notebook 02 again: P_ll = L_y R L_y'. The pose is the first 3 numbers of the state.
    measurement exact                 | P_ll        | exact      | If the measurement has no error, the landmark is exactly as uncertain as the pose makes it: P_ll = L_r P_rr L_r', with P_rr = P[:3, :3].
    P_ll                              | P_ll        | scales     | Two causes of error, pose and measurement, and they are independent: what do their covariances do?
    covariance with the robot         | P_lx[:, :3] | any        | The error of the pose is in the landmark, too: cov(dl, dx_r) = L_r P_rr, and nothing else is in both.
    covariance with the old landmarks | P_lx[:, 3:] | any        | P_lx[:, 3:] is the covariance of dl = L_r dx_r + L_y v with the errors of the old landmarks: these are correlated with dx_r, and v, the noise of the measurement, is new.
    """,
    wrong="""
    zero cross-covariance | return P_lx, -> return 0 * P_lx, | P_lx = 0 says: landmark and robot err independently. Yet the landmark was seen from that very pose.
    mapping formula | P_lx = L_r @ P[:3] -> P_lx = np.zeros((2, len(P))) | That is the mapping formula of notebook 02, for a pose without error. The robot itself is uncertain now: its error enters through L_r, into P_ll and into P_lx.
    pose term only in P_lx | P_ll = P_lx[:, :3] @ L_r.T + L_y -> P_ll = L_y | P_ll has two terms: the pose is uncertain, too. Did you forget L_r P_rr L_r'?
    measurement noise forgotten | L_r.T + L_y @ R @ L_y.T -> L_r.T | P_ll has two terms: the measurement has noise, too. Did you forget L_y R L_y'?
    only the robot | return P_lx, -> P_lx[:, 3:] = 0; return P_lx, | The old landmarks are correlated with the robot, so the new one is correlated with them: take all columns of P[:3].
    P_lx transposed | return P_lx, -> return P_lx.T, | Rows belong to the landmark, columns to the state so far: P_lx is 2 x n. Yours is its transpose, P_xl.
    P_lr only | return P_lx, -> return P_lx[:, :3], | P_lx must reach over the whole state: one column for each number in it, not only for the robot's three.
    measurement noise not in metres | L_y @ R @ L_y.T -> R | R is in range and bearing (m, rad), P_ll in x and y (m, m): the Jacobian L_y brings one to the other, L_y R L_y'.
    L_y transposed | L_y @ R @ L_y.T -> L_y.T @ R @ L_y | The noise goes through L_y from the left: L_y R L_y'. Yours is L_y' R L_y.
    only the diagonal of R | L_y @ R @ L_y.T -> L_y @ np.diag(np.diag(R)) @ L_y.T | Use the whole R: the noise of range and bearing may be correlated.
    R squared | L_y @ R @ L_y.T -> L_y @ R @ R @ L_y.T | R holds variances already: do not square it.
    R entry by entry squared | L_y @ R @ L_y.T -> L_y @ R**2 @ L_y.T | R holds variances already: do not square it.
    square root of R | L_y @ R @ L_y.T -> L_y @ np.sqrt(np.abs(R)) @ L_y.T | R holds variances, and P_ll wants variances: no square root.
    noise subtracted | L_r.T + L_y -> L_r.T - L_y | Two causes of error make the landmark more uncertain than one: the two terms add up.
    double counting | return P_lx, P_ll -> return P_lx, P_ll / 2 | Your P_ll is half of what it should be: L_r P_rr L_r' and L_y R L_y' both count in full. A landmark is not corrected with the measurement that has started it.
    identity | return P_lx, P_ll -> return P_lx, np.eye(2) | An identity says: 1 m^2 of variance, whatever the pose and the sensor. The covariance follows from L_r, P, L_y and R.
    identity and zero | return P_lx, P_ll -> return 0 * P_lx, np.eye(2) | An identity says: 1 m^2 of variance, whatever the pose and the sensor. And zero says: no error in common with the robot.
    heading left out | P_lx = L_r @ -> L_r = L_r * [1, 1, 0]; P_lx = L_r @ | Far landmarks suffer most from the heading: take all three columns of L_r and all three rows of the robot.
    noise in the cross-covariance | return P_lx, -> P_lx[:, :2] += L_y @ R @ L_y.T; return P_lx, | The noise of a new measurement has nothing to do with the state so far: it is in P_ll, not in P_lx.
    sign of the cross-covariance | return P_lx, -> return -P_lx, | If the robot is further to the left than it thinks, the landmark is so, too: the sign of P_lx is plus.
    results in the wrong order | return P_lx, P_ll -> return P_ll, P_lx | The order is P_lx, then P_ll.
    last rows for those of the robot | P_lx = L_r @ P[:3] -> P_lx = L_r @ P[-3:] | The robot's pose is the first 3 numbers of the state: P[:3], not the last rows.
    last rows for those of the robot, in both | P_lx = L_r @ P[:3] -> P_lx = L_r @ P[-3:] | The robot's pose is the first 3 numbers of the state: P[:3], not the last rows.
        P_lx[:, :3] @ L_r.T -> P_lx[:, -3:] @ L_r.T
    fused like two measurements | P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T -> P_ll = np.linalg.inv(np.linalg.inv(P_lx[:, :3] @ L_r.T) + np.linalg.inv(L_y @ R @ L_y.T)) | Two causes of error make the landmark more uncertain than one: the two terms are added, not their inverses.
    half of the cross-covariance | return P_lx, P_ll -> return P_lx / 2, P_ll | P_lx stands in P twice, beside and above, each time in full: do not halve it.
    """,
)


@blocks.link("the whole covariance", "Robot, old landmarks and the new one together must be a covariance.")
def _(f, rng):
    P, *others = some(rng, 9)
    P_lx, P_ll = expect.results(f(P, *others), "P_lx", "P_ll")
    P_lx, P_ll = expect.array(P_lx, (2, 9), "P_lx"), expect.array(P_ll, (2, 2), "P_ll")
    expect.symmetric(P_ll, "P_ll", 1e-6)
    expect.psd(np.block([[P, P_lx.T], [P_lx, P_ll]]), "the whole covariance", 1e-6)
