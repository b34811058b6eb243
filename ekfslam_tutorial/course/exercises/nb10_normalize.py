"""Exercise 10.3: a quaternion is normalised, and its covariance with it."""

import numpy as np

from ...geometry import unit
from ..table import table


def normalize(x, P):
    """Give the quaternion of a frame the norm one again, after a correction.

    x, shape (7,): the frame [t, q]; q has lost its norm. P, shape (7, 7): its covariance.
    Return the new x, with the quaternion u = q / |q|, and the new P. With U_q = du/dq = (I - u u') / |q|.
    """
    n = np.linalg.norm(x[3:])
    u = x[3:] / n
    J = np.eye(7)
    J[3:, 3:] = (np.eye(4) - np.outer(u, u)) / n
    return np.concatenate([x[:3], u]), J @ P @ J.T


def case(rng, norm):
    """Return a frame whose quaternion is too long or too short, and a full covariance."""
    q = unit(rng.normal(size=4))[0] * norm
    A = rng.normal(size=(7, 7)) * np.array([0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.1])[:, None]
    return np.concatenate([rng.uniform(-3, 3, 3), q]), A @ A.T


def _block(P, U, cross):
    """The covariance with its blocks treated one by one."""
    return np.block([[P[:3, :3], cross], [cross.T, U @ P[3:, 3:] @ U.T]])


exercise = table(
    "10.3 Normalise, with the covariance",
    normalize,
    hints=(
        "The new state is a function of the old one, so the covariance goes through its Jacobian: J P J'.",
        "J is 7 x 7: the identity for the position, U_q for the quaternion. P_tq changes, too.",
        "J = np.eye(7); J[3:, 3:] = (np.eye(4) - np.outer(u, u)) / n; return the new x and J @ P @ J.T.",
    ),
    returns="x, P",
    symbols="P_tt, P_tq, P_qq = the blocks of P, with t = x[:3] and q = x[3:]; "
    "J = the derivative of the new state by the old one",
    cases={"any": lambda rng: [case(rng, norm) for norm in (1.2, 0.7, 1.0, 3.0, 0.6)]},
    checks="""
    position                     | x[:3]     | any | u = q / |q|, and the position stays.
    state                        | x         | any | u = q / |q|, and the position stays.
    covariance of the position   | P[:3, :3] | any | P_tt has nothing to do with the quaternion: it stays.
    covariance of the quaternion | P[3:, 3:] | any | The noise of q passes through U_q: P_qq = U_q P_qq U_q'.
    cross-covariance             | P[:3, 3:] | any | The columns of P_tq belong to q: P_tq becomes P_tq U_q'.
    still a covariance           | P         | any | J P J' is symmetric: its block P[3:, :3] is the transpose of P[:3, 3:].
    """,
    wrong="""
    covariance forgotten | J @ P @ J.T -> P | q has changed, so has its noise: P goes through the Jacobian of q / |q|.
    q only made shorter | (np.eye(4) - np.outer(u, u)) -> np.eye(4) | I / |q| is the derivative for a norm that stays the same. The norm depends on q, too: U_q = (I - u u') / |q|.
    scalar part made positive | [x[:3], u] -> [x[:3], u * np.sign(u[0])] | -u is the same orientation, but u = q / |q| was asked for, and P belongs to it: keep the sign.
    cross-covariance forgotten | J @ P @ J.T -> _block(P, J[3:, 3:], P[:3, 3:]) | You have changed P_qq only. P_tq is about q, too: use one J for all of P.
    cross-covariance set to zero | J @ P @ J.T -> _block(P, J[3:, 3:], np.zeros((3, 4))) | Position and quaternion stay correlated: P_tq becomes P_tq U_q'.
    the whole state is divided | [x[:3], u] -> [x[:3] / n, u] | Only the quaternion has the norm one. The position is in metres.
        np.eye(7) -> np.eye(7) / n
    norm of the whole state | return np.concatenate([x[:3], u]) -> u, J = unit(x); return u | Take the norm of the quaternion, x[3:], alone.
    norm of the whole state, position kept | np.linalg.norm(x[3:]) -> np.linalg.norm(x) | Take the norm of the quaternion, x[3:], alone.
    projector, not divided | (np.eye(4) - np.outer(u, u)) / n -> np.eye(4) - np.outer(u, u) | U_q = (I - u u') / |q|, with the |q| of the old q: yours is not divided by it.
    q q' of the long q | np.outer(u, u) -> np.outer(x[3:], x[3:]) | The projector needs the unit vector: I - u u', with u = q / |q|, not q q'.
    plus | np.eye(4) - np.outer -> np.eye(4) + np.outer | U_q = (I - u u') / |q|, with a minus: the part of the noise along q is taken away.
    J applied once | J @ P @ J.T -> J @ P | A covariance is multiplied from both sides: J P J'.
    divided by the squared norm | u = x[3:] / n -> u = x[3:] / n | q / (q'q) is too short: divide by the square root, |q|.
        [x[:3], u] -> [x[:3], u / n]
    divided twice | np.outer(u, u)) / n -> np.outer(u, u)) / n**2 | u has been divided by |q| already: U_q = (I - u u') / |q|, once.
    position lost in J | J = np.eye(7) -> J = np.zeros((7, 7)) | The position stays as it is: its derivative by itself is the identity, not zero.
    multiplied by the norm | np.outer(u, u)) / n -> np.outer(u, u)) * n | U_q = (I - u u') / |q|: divided by |q|, not multiplied.
    x as it was | np.concatenate([x[:3], u]) -> x.copy() | Return the new x, too: the position, and the quaternion u = q / |q|.
    one of the two cross blocks: P_tq changes, and P_qt with it: use one J for all of P, or P is not symmetric any more.
        return np.conc -> Q = J @ P @ J.T; Q[:3, 3:] = P[:3, 3:]; return np.conc
        u]), J @ P @ J.T -> u]), Q
    one for the outer product | np.outer(u, u) -> u @ u | u @ u' of two vectors is the number 1. The outer product is a matrix: np.outer(u, u).
    P_tq divided only | J @ P @ J.T -> np.block([[P[:3, :3], P[:3, 3:] / n], [P[3:, :3] / n, (J @ P @ J.T)[3:, 3:]]]) | P_tq goes through the same U_q as the rest: it is multiplied, P_tq U_q', and not divided by |q| only.
    squared norm in all: The norm |q| is the square root of q'q: divide by it, not by its square, in u and in U_q.
        [x[:3], u] -> [x[:3], u / n]
        np.outer(u, u)) / n -> np.outer(u, u)) / n**2
    """,
)
