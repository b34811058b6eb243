"""Exercise 05.4: a new landmark comes into the joint state."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance
from .nb04_inverse import inverse_observation


def augment(x, P, y, R):
    """Start a new landmark with its first measurement: it comes to the end of the state.

    x, shape (n,), and P, shape (n, n): joint state, the robot's pose first, and its covariance.
    y = [range, bearing]: the measurement; R, shape (2, 2): its covariance.
    Return the new x, shape (n + 2,), and P, shape (n + 2, n + 2). Do not change the inputs.
    """
    l, L_r, L_y = inverse_observation(x[:3], y)
    P_lx = L_r @ P[:3]
    P_ll = P_lx[:, :3] @ L_r.T + L_y @ R @ L_y.T
    return np.concatenate([x, l]), np.block([[P, P_lx.T], [P_lx, P_ll]])


def case(rng, n=7, scale=0.1):
    """Return a joint state, its covariance, and the first measurement of a new landmark."""
    x = rng.uniform(-4, 4, n)
    x[2] = rng.uniform(-3, 3)
    y = np.array([rng.uniform(1, 8), rng.uniform(-3, 3)])
    return x, random_covariance(rng, n, scale), y, random_covariance(rng, 2, 0.1 * scale)


def pose_known(rng, n):
    """Return the same for a robot whose pose is known exactly."""
    x, P, y, R = case(rng, n)
    P[:3], P[:, :3] = 0, 0
    return x, P, y, R


def second(rng):
    """Return a state in which one landmark has just been started, and the measurement of another one."""
    x, P, y, R = case(rng, 3)
    return *augment(x, P, y, R), y + [0.5, 1.0], R


augmentation = table(
    "05.4 Augment",
    augment,
    hints=(
        "l, L_r, L_y = inverse_observation(x[:3], y) gives the landmark. Then the blocks of notebook 04.",
        "P_lx = L_r P[:3], with all columns, and P_ll = L_r P_rr L_r' + L_y R L_y'.",
        "x: np.concatenate([x, l]). P: np.block([[P, P_lx.T], [P_lx, P_ll]]).",
    ),
    returns="x, P",
    symbols="P_xl = the transpose of P_lx; P_lx = the covariance of the new landmark with all the states before; "
    "P_ll = the covariance of the new landmark; L_r, L_y = the derivatives of the new landmark by the pose and by y; "
    "P_rr = P[:3, :3]; x_r = x[:3]",
    angles={"x": 2},
    rtol={"P": 1e-3},
    cases={
        "any": lambda rng: [case(rng, n) for n in (7, 3, 5, 11)],
        "pose known": lambda rng: [pose_known(rng, n) for n in (7, 3)],
        "scales": lambda rng: [case(rng, 7), case(rng, 3, 1.0), case(rng, 9, 1e-5)],
        "second": lambda rng: [second(rng)],
    },
    checks="""
    two numbers more | x[:0], P[:0]        | any        | The state grows by the two numbers of the landmark, and P with it.
    the old state    | x[:-2], P[:-2, :-2] | any        | A new landmark tells nothing about the rest of the state: x[:n] and P[:n, :n] are the old x and P, entry by entry.
    the landmark     | x[-2:]              | any        | l = x[:2] + r [cos(theta + beta), sin(theta + beta)], with theta = x[2], at the end of x.
    P_ll, pose known | P[-2:, -2:]         | pose known | If the pose had no error, P_ll would be L_y R L_y'.
    P_ll             | P[-2:, -2:]         | scales     | Two independent causes of error, pose and measurement: their covariances add, P_ll = L_r P_rr L_r' + L_y R L_y'.
    P_lx             | P[-2:, :-2]         | any        | cov(l, x) = L_r P[:3]: with the robot and with all old landmarks.
    two in turn      | P[-2:, :-2]         | second     | The second new landmark shares the robot's error with the first one.
    """,
    wrong="""
    zero cross-covariance | return np -> P_lx = 0 * P_lx; return np | Zero beside P_ll says: landmark and robot err independently. Yet the landmark was seen from that very pose: P_lx = L_r P[:3].
    mapping formula | P_lx = L_r @ P[:3] -> P_lx = 0 * L_r @ P[:3] | That is the mapping formula, for a pose without error. The robot is uncertain, too: its error enters through L_r, into P_ll and into P_lx.
    pose term forgotten | P_ll = P_lx[:, :3] @ L_r.T + L_y -> P_ll = L_y | P_ll has two terms: the pose is uncertain, too. Did you forget L_r P_rr L_r'?
    measurement noise forgotten | L_r.T + L_y @ R @ L_y.T -> L_r.T | P_ll has two terms: did you forget L_y R L_y'?
    only the robot | return np -> P_lx[:, 3:] = 0; return np | The old landmarks are correlated with the robot, so the new one is correlated with them: take all columns of P[:3].
    P_xl forgotten | [[P, P_lx.T] -> [[P, 0 * P_lx.T] | P must be symmetric: above the diagonal stands P_lx'.
    P_lx forgotten | [P_lx, P_ll] -> [0 * P_lx, P_ll] | P must be symmetric: below the diagonal stands P_lx, the transpose of what stands above.
    noise not in metres | L_y @ R @ L_y.T -> R | R is in range and bearing, P_ll in x and y: L_y brings one to the other, L_y R L_y'.
    L_y transposed | L_y @ R @ L_y.T -> L_y.T @ R @ L_y | The noise goes through L_y from the left: L_y R L_y'.
    L_y of the wrong direction | L_y @ R @ L_y.T -> np.linalg.inv(L_y) @ R @ np.linalg.inv(L_y).T | L_y brings range and bearing to x and y; its inverse, the Jacobian E_l of the observation, goes the other way.
    L_r without the heading | P_lx = L_r -> L_r = np.eye(2, 3); P_lx = L_r | A turned robot sees the landmark elsewhere: the last column of L_r is not zero.
    sign of the heading in L_r | P_lx = L_r -> L_r = L_r * [1, 1, -1]; P_lx = L_r | Turned to the left, the robot puts the landmark further to the left: look at the sign of the last column of L_r.
    R squared | L_y @ R @ L_y.T -> L_y @ R**2 @ L_y.T | R holds variances already: do not square it.
    only the diagonal of R | L_y @ R @ L_y.T -> L_y @ np.diag(np.diag(R)) @ L_y.T | Use the whole R: the noise of range and bearing may be correlated.
    noise subtracted | L_r.T + L_y -> L_r.T - L_y | Two causes of error make the landmark more uncertain than one: the two terms add up.
    identity | return np -> P_ll = np.eye(2); return np | An identity says: 1 m^2 of variance, whatever the pose and the sensor.
    identity and zero | return np -> P_ll, P_lx = np.eye(2), 0 * P_lx; return np | An identity says: 1 m^2, whatever pose and sensor. And zero says: nothing in common with the robot.
    very uncertain, and that is all | return np -> P_ll, P_lx = 1e6 * np.eye(2), 0 * P_lx; return np | A huge covariance must be followed by a correction with the same measurement; otherwise it is simply wrong.
    old map forgotten | [[P, -> [[np.diag(np.diag(P)), | A new landmark changes nothing between the others: the old P stays as it is.
    sign of the cross-covariance | return np -> P_lx = -P_lx; return np | If the robot is further left than it thinks, so is the landmark: plus L_r P[:3].
    landmark in the robot's frame | [x, l] -> [x, y[0] * np.array([np.cos(y[1]), np.sin(y[1])])] | That is where the robot sees it. The map wants the map frame: inverse_observation.
    the last three numbers for the pose | inverse_observation(x[:3], y) -> inverse_observation(x[-3:], y) | The robot's pose is the *first* 3 numbers of x: x[:3].
    landmark first in P | [[P, P_lx.T], [P_lx, P_ll]] -> [[P_ll, P_lx], [P_lx.T, P]] | The landmark is at the end of x, so the new rows and columns of P come last, too.
    the measurement itself | [x, l] -> [x, y] | Range and bearing are no place in the map: inverse_observation(x[:3], y) gives it.
    double counting: The measurement is used up when it has started the landmark. A correction with it again counts it twice.
        return np.concatenate([x, l]), -> n, W = len(x), np.linalg.inv(L_y); H = np.hstack([-W @ L_r, np.zeros((2, n - 3)), W]); x, P = np.concatenate([x, l]),
        [P_lx, P_ll]]) -> [P_lx, P_ll]]); K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R); return x, P - K @ H @ P
    landmark in front | return np.concatenate([x, l]), -> n = len(x); x, P = np.concatenate([x, l]), | The new landmark comes to the end of the state: the places of the others stay.
        [P_lx, P_ll]]) -> [P_lx, P_ll]]); i = np.r_[0:3, n : n + 2, 3:n]; return x[i], P[np.ix_(i, i)]
    P does not grow | np.block([[P, P_lx.T], [P_lx, P_ll]]) -> P | P needs two rows and columns more, as x does.
    P_mm for P_rr | P_lx[:, :3] @ L_r.T -> L_r @ P[-3:, -3:] @ L_r.T | The pose's covariance is the first block of P, P[:3, :3].
    only the diagonal of P_rr | P_lx[:, :3] @ L_r.T -> L_r @ np.diag(np.diag(P[:3, :3])) @ L_r.T | The errors of position and heading are correlated: use the whole block P[:3, :3].
    the heading's share forgotten in P_ll | P_lx[:, :3] @ L_r.T -> P[:2, :2] | A wrong heading moves the landmark, too: P_ll has L_r P_rr L_r', not the position's block alone.
    pose term twice | P_lx[:, :3] @ L_r.T -> 2 * P_lx[:, :3] @ L_r.T | P_ll has each cause of error once: L_r P_rr L_r' + L_y R L_y'.
    no correlation of position and heading | P_lx[:, :3] @ L_r.T -> L_r @ (P[:3, :3] * [[1, 1, 0], [1, 1, 0], [0, 0, 1]]) @ L_r.T | The errors of position and heading are correlated: use the whole block P[:3, :3].
    rows of the position alone | P_lx = L_r @ P[:3] -> P_lx = P[:2] | A wrong heading moves the landmark, too: P_lx = L_r P[:3], with all three rows.
        P_ll = P_lx[:, :3] @ L_r.T -> P_ll = L_r @ P[:3, :3] @ L_r.T
    """,
)


@augmentation.link(
    "symmetric",
    "P is symmetric: P_xl, above the diagonal, is the transpose of P_lx, below it. And no eigenvalue of P is negative.",
    1,
    "two in turn",
)
def _(f, rng):
    for n in (7, 3):
        P = expect.array(expect.results(f(*case(rng, n)), "x", "P")[1], (n + 2, n + 2), "P")
        expect.symmetric(P, "P", 1e-6)
        expect.psd(P, "P", 1e-6)
