"""Exercise 04.3: the covariance of the joint state when the robot moves."""

import numpy as np

from ...models.motion import Odometry2, Unicycle
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def moved(P, X_x, X_u, U):
    """Covariance of the joint state after a step of the robot; the landmarks stand still.

    P, shape (n, n): covariance before; the robot's pose is its first 3 numbers, the landmarks follow.
    X_x, shape (3, 3), and X_u, shape (3, m): derivatives of the new pose by the old one and by the control.
    U, shape (m, m): covariance of the control.
    Return the new P. Do not change the input.
    """
    P = P.copy()
    P[:3] = X_x @ P[:3]
    P[:, :3] = P[:, :3] @ X_x.T
    P[:3, :3] += X_u @ U @ X_u.T
    return P


motion = Exercise(
    "04.3",
    "The robot moves, the landmarks stand still",
    moved,
    hints=(
        "Write the errors after the step: dx_r' = X_x dx_r + X_u w for the robot, dm' = dm for the map. Then multiply.",
        "Three blocks: P_rr becomes X_x P_rr X_x' + X_u U X_u', P_rm becomes X_x P_rm, P_mm stays. And P_mr = P_rm'.",
        "Copy P. Multiply its first three rows by X_x from the left, then its first three columns by X_x' from the "
        "right, then add X_u U X_u' to P[:3, :3].",
    ),
)


def _case(rng, n, model=None):
    """A covariance and the Jacobians of a real step: odometry (3 controls) or speed and turn rate (2)."""
    model = model or Odometry2()
    k = sum(model.control_fields.values())
    u = rng.uniform(0.5, 2, k) * rng.choice([-1, 1], k)
    _, X_x, X_u = model.move(np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)]), u, 0.8)
    return random_covariance(rng, n), X_x, X_u, random_covariance(rng, k, 0.2)


def _P(f, case):
    return expect.array(f(*case), case[0].shape, "P")


@motion.link("shape", "P keeps its size: no state comes, none goes.")
def _(f, rng):
    for n in (7, 3, 5, 13):
        _P(f, _case(rng, n))
    _P(f, _case(rng, 7, Unicycle()))


@motion.link("no landmarks", "With the robot alone this is the prediction of localisation: X_x P X_x' + X_u U X_u'.")
def _(f, rng):
    for model in (Odometry2(), Unicycle(), Odometry2()):
        P, X_x, X_u, U = case = _case(rng, 3, model)
        expect.close(_P(f, case), X_x @ P @ X_x.T + X_u @ U @ X_u.T, "P of a robot without landmarks")


@motion.link("block of the robot", "P_rr becomes X_x P_rr X_x' + X_u U X_u', whatever the landmarks are.")
def _(f, rng):
    for n in (7, 5):
        P, X_x, X_u, U = case = _case(rng, n)
        expect.close(_P(f, case)[:3, :3], X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T, "P_rr")


@motion.link("block of the map", "Landmarks stand still, and no motion noise reaches them: P_mm stays as it is.")
def _(f, rng):
    for n in (7, 5, 11):
        case = _case(rng, n)
        expect.close(_P(f, case)[3:, 3:], case[0][3:, 3:], "P_mm, the block of the landmarks,", 1e-7)


@motion.link("blocks between robot and map", "The robot's error turns and moves with it: P_rm becomes X_x P_rm.")
def _(f, rng):
    for n in (7, 5, 11):
        P, X_x, *_ = case = _case(rng, n)
        expect.close(_P(f, case)[:3, 3:], X_x @ P[:3, 3:], "P_rm, rows of the robot, columns of the map,")


@motion.link("symmetric", "P_mr is the transpose of P_rm: both must follow.")
def _(f, rng):
    for n in (7, 5):
        expect.symmetric(_P(f, _case(rng, n)), "the new P", 1e-7)


@motion.link("there and back", "A step and its exact inverse, both without noise, must leave P as it was.")
def _(f, rng):
    P, X_x, X_u, U = _case(rng, 9)
    there = _P(f, (P, X_x, X_u, 0 * U))
    back = _P(f, (there, np.linalg.inv(X_x), X_u, 0 * U))
    expect.close(back, P, "P after a step there and back without noise")


@motion.link("still a covariance", "After many steps P must have no negative eigenvalue.")
def _(f, rng):
    P = random_covariance(rng, 7)
    for _ in range(20):
        _, X_x, X_u, U = _case(rng, 7)
        P = _P(f, (P, X_x, X_u, 0.01 * U))
    expect.psd(P, "P after 20 steps", 1e-7)


def _wrong(name, hint, robot=None, cross=None, landmarks=None, both=True):
    """A misconception in one of the three blocks; `both` False changes P_rm and leaves P_mr."""

    @motion.wrong(name, hint)
    def _(P, X_x, X_u, U):
        new = moved(P, X_x, X_u, U)
        if robot:
            new[:3, :3] = robot(P[:3, :3], X_x, X_u, U)
        if cross:
            new[:3, 3:] = cross(P[:3, 3:], X_x)
            new[3:, :3] = new[:3, 3:].T if both else P[3:, :3]
        if landmarks:
            new[3:, 3:] = landmarks(P[3:, 3:], X_u @ U @ X_u.T)
        return new


# fmt: off
_wrong("P_rm not propagated", "The landmarks stand still, but the robot does not: its covariance with them becomes X_x "
       "P_rm. Left as it was, P does not fit together any more, and the filter diverges.", cross=lambda C, X: C)
_wrong("P_rm forgotten", "Moving does not make robot and map independent: P_rm becomes X_x P_rm, not zero.",
       cross=lambda C, X: 0 * C)
_wrong("P_rm transposed Jacobian", "The error of the robot goes through X_x, not through X_x': P_rm becomes X_x P_rm.",
       cross=lambda C, X: X.T @ C)
_wrong("P_mr not changed", "P_mr is the transpose of P_rm: change the columns of the robot, too.",
       cross=lambda C, X: X @ C, both=False)
_wrong("X_x' P X_x", "The Jacobian stands on the left and its transpose on the right: X_x P X_x'.",
       robot=lambda P, X, G, U: X.T @ P @ X + G @ U @ G.T)
_wrong("no noise", "The control is not exact: add X_u U X_u' to the block of the robot.",
       robot=lambda P, X, G, U: X @ P @ X.T)
_wrong("only noise", "The old uncertainty does not vanish: P_rr becomes X_x P_rr X_x' + X_u U X_u'.",
       robot=lambda P, X, G, U: G @ U @ G.T)
_wrong("noise added, nothing turned", "The heading error moves the robot sideways as it drives: that is X_x P_rr X_x'.",
       robot=lambda P, X, G, U: P + G @ U @ G.T)
_wrong("U squared", "U holds variances already: do not square it.",
       robot=lambda P, X, G, U: X @ P @ X.T + G @ U @ U @ G.T)
_wrong("U entry by entry squared", "U holds variances already: do not square it.",
       robot=lambda P, X, G, U: X @ P @ X.T + G @ U**2 @ G.T)
_wrong("noise subtracted", "Noise makes the robot more uncertain: X_u U X_u' is added.",
       robot=lambda P, X, G, U: X @ P @ X.T - G @ U @ G.T)
_wrong("noise on the landmarks", "The landmarks stand still: no noise is added to P_mm.",
       landmarks=lambda P, Q: P + np.mean(np.diag(Q)) * np.eye(len(P)))
_wrong("a bit of noise for safety", "The landmarks stand still: no noise is added to P_mm, however little.",
       landmarks=lambda P, Q: P + 1e-3 * np.eye(len(P)))
_wrong("map forgotten", "The map does not vanish when the robot moves: P_mm stays as it is.",
       landmarks=lambda P, Q: 0 * P)
# fmt: on


@motion.wrong("U not brought to the pose", "U belongs to the control, P_rr to the pose: X_u brings one to the other.")
def _(P, X_x, X_u, U):
    new = moved(P, X_x, X_u, 0 * U)
    new[:3, :3] += U
    return new


@motion.wrong(
    "noise everywhere", "Only the robot moves: X_u U X_u' is added to P[:3, :3], the rest of P gets no noise."
)
def _(P, X_x, X_u, U):
    new = moved(P, X_x, X_u, U)
    new[3:, 3:] += np.trace(X_u @ U @ X_u.T)
    return new


@motion.wrong("only the robot is left", "P must keep the size of the joint state: robot and landmarks.")
def _(P, X_x, X_u, U):
    return X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T


@motion.variant("one big Jacobian")
def _(P, X_x, X_u, U):
    F, G = np.eye(len(P)), np.zeros((len(P), np.shape(U)[0]))
    F[:3, :3], G[:3] = X_x, X_u
    return F @ P @ F.T + G @ U @ G.T


@motion.variant("block by block, np.block")
def _(P, X_x, X_u, U):
    P_rm = X_x @ P[:3, 3:]
    return np.block([[X_x @ P[:3, :3] @ X_x.T + X_u @ U @ X_u.T, P_rm], [P_rm.T, P[3:, 3:]]])


@motion.variant("by a square root of P, lists")
def _(P, X_x, X_u, U):
    w, V = np.linalg.eigh(P)
    S = V * np.sqrt(np.clip(w, 0, None))
    S[:3] = np.dot(X_x, S[:3])
    new = S @ S.T
    new[:3, :3] += np.linalg.multi_dot([X_u, U, np.transpose(X_u)])
    return new.tolist()
