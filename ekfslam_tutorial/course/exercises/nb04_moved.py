"""Exercise 04.3: the covariance of the joint state when the robot moves."""

import numpy as np

from ...models.motion import Odometry2, Unicycle
from .. import expect
from ..table import table
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


def some(rng, n, model=None):
    """Return a covariance and the Jacobians of a real step: odometry (3 controls) or speed and turn rate (2)."""
    model = model or Odometry2()
    k = sum(model.control_fields.values())
    u = rng.uniform(0.5, 2, k) * rng.choice([-1, 1], k)
    _, X_x, X_u = model.move(np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)]), u, 0.8)
    return random_covariance(rng, n), X_x, X_u, random_covariance(rng, k, 0.2)


motion = table(
    "04.3 The robot moves, the landmarks stand still",
    moved,
    hints=(
        "Write the errors after the step: dx_r' = X_x dx_r + X_u w for the robot, dm' = dm for the map. Then multiply.",
        "Three blocks: P_rr becomes X_x P_rr X_x' + X_u U X_u', P_rm becomes X_x P_rm, P_mm stays. And P_mr = P_rm'.",
        "Copy P. Multiply its first three rows by X_x from the left, then its first three columns by X_x' from the right, then add X_u U X_u' to P[:3, :3].",
    ),
    returns="P",
    symbols="P_rr = P[:3, :3]; P_rm = P[:3, 3:]; P_mr = P[3:, :3]; P_mm = P[3:, 3:]",
    cases={
        "any": lambda rng: [*(some(rng, n) for n in (7, 3, 5, 13)), some(rng, 7, Unicycle())],
        "alone": lambda rng: [some(rng, 3), some(rng, 3, Unicycle()), some(rng, 3)],
        "sizes": lambda rng: [some(rng, n) for n in (7, 5, 11)],
    },
    checks="""
    shape                        | P[:0]     | any   | P keeps its size: no state comes, none goes.
    no landmarks                 | P         | alone | With the robot alone this is the prediction of localisation: X_x P X_x' + X_u U X_u'.
    block of the robot           | P[:3, :3] | any   | P_rr becomes X_x P_rr X_x' + X_u U X_u', whatever the landmarks are.
    block of the map             | P[3:, 3:] | sizes | Landmarks stand still, and no motion noise reaches them: P_mm stays as it is.
    blocks between robot and map | P[:3, 3:] | sizes | The robot's error turns and moves with it: P_rm becomes X_x P_rm.
    symmetric                    | P[3:, :3] | sizes | P_mr is the transpose of P_rm: it becomes P_mr X_x'.
    """,
    wrong="""
    P_rm not propagated: The landmarks stand still, but the robot does not: its covariance with them becomes X_x P_rm. Left as it was, P does not fit together any more, and the filter diverges.
        P[:3] = X_x @ P[:3] -> P[:3, :3] = X_x @ P[:3, :3]
        P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T
    P_rm forgotten | return P -> P[:3, 3:], P[3:, :3] = 0, 0; return P | Moving does not make robot and map independent: P_rm becomes X_x P_rm, not zero.
    P_rm transposed Jacobian | P[:3] = X_x @ P[:3] -> P[:3, :3], P[:3, 3:] = X_x @ P[:3, :3], X_x.T @ P[:3, 3:] | The error of the robot goes through X_x, not through X_x': P_rm becomes X_x P_rm.
        P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3], P[3:, :3] = P[:3, :3] @ X_x.T, P[:3, 3:].T
    P_mr not changed | P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3] = P[:3, :3] @ X_x.T | P_mr is the transpose of P_rm: change the columns of the robot, too.
    X_x behind P_mr | P[:, :3] = P[:, :3] @ X_x.T -> P[:3, :3], P[3:, :3] = P[:3, :3] @ X_x.T, P[3:, :3] @ X_x | X_x' stands behind P_mr, the transpose: P_mr becomes P_mr X_x'.
    P_rm not changed | P[:3] = X_x @ P[:3] -> P[:3, :3] = X_x @ P[:3, :3] | P_rm is the transpose of P_mr: change the rows of the robot over the whole width.
    X_x' P X_x | P = P.copy() -> old, P = P, P.copy() | The Jacobian stands on the left and its transpose on the right: X_x P X_x'.
        P[:3, :3] += X_u -> P[:3, :3] = X_x.T @ old[:3, :3] @ X_x + X_u
    X_x' on the left, X_x on the right | X_x @ P[:3] -> X_x.T @ P[:3] | The Jacobian stands on the left and its transpose on the right: X_x P X_x'.
        P[:, :3] @ X_x.T -> P[:, :3] @ X_x
    no noise | P[:3, :3] += X_u @ U @ X_u.T -> pass | The control is not exact: add X_u U X_u' to the block of the robot.
    only noise | P[:3, :3] += X_u -> P[:3, :3] = X_u | The old uncertainty does not vanish: P_rr becomes X_x P_rr X_x' + X_u U X_u'.
    noise added, nothing turned | P = P.copy() -> old, P = P, P.copy() | The heading error moves the robot sideways as it drives: that is X_x P_rr X_x'.
        P[:3, :3] += X_u -> P[:3, :3] = old[:3, :3] + X_u
    nothing but noise added | P[:3] = X_x @ P[:3] -> pass | The heading error moves the robot sideways as it drives: rows and columns of the robot go through X_x.
        P[:, :3] = P[:, :3] @ X_x.T -> pass
    U squared | X_u @ U @ X_u.T -> X_u @ U @ U @ X_u.T | U holds variances already: do not square it.
    U entry by entry squared | X_u @ U @ X_u.T -> X_u @ U**2 @ X_u.T | U holds variances already: do not square it.
    only the diagonal of U | X_u @ U @ X_u.T -> X_u @ np.diag(np.diag(U)) @ X_u.T | Use the whole U: the errors of the control may be correlated.
    noise subtracted | P[:3, :3] += X_u -> P[:3, :3] -= X_u | Noise makes the robot more uncertain: X_u U X_u' is added.
    noise on the landmarks | return P -> P[3:, 3:] += np.mean(np.diag(X_u @ U @ X_u.T)) * np.eye(len(P) - 3); return P | The landmarks stand still: no noise is added to P_mm.
    a bit of noise for safety | return P -> P[3:, 3:] += 1e-3 * np.eye(len(P) - 3); return P | The landmarks stand still: no noise is added to P_mm, however little.
    map forgotten | return P -> P[3:, 3:] = 0; return P | The map does not vanish when the robot moves: P_mm stays as it is.
    U not brought to the pose | X_u @ U @ X_u.T -> U | U belongs to the control, P_rr to the pose: X_u brings one to the other.
    noise everywhere | return P -> P[3:, 3:] += np.trace(X_u @ U @ X_u.T); return P | Only the robot moves: X_u U X_u' is added to P[:3, :3], the rest of P gets no noise.
    only the robot is left | return P -> return P[:3, :3] | P must keep the size of the joint state: robot and landmarks.
    X_x twice, by the rows: X_x comes in twice on the left of P_rr: that happens if its rows have gone through X_x before P_rr is computed. Compute each block from the old P.
        P[:, :3] = P[:, :3] @ X_x.T -> P[3:, :3], P[:3, :3] = P[:3, 3:].T, X_x @ P[:3, :3] @ X_x.T
    X_x twice, by the block: X_x comes in twice on both sides of P_rr: that happens if P_rr has a line of its own, and its rows and columns are multiplied, too. Compute each block from the old P.
        P[:3] = X_x @ P[:3] -> P[:3, :3] = X_x @ P[:3, :3] @ X_x.T; P[:3] = X_x @ P[:3]
    noise on the first landmark: The landmarks stand still: X_u U X_u' is added to the robot's rows and columns only, P[:3, :3]. Behind them, in rows 3 and 4, there is no noise, and with the robot alone there are no such rows.
        P[:3, :3] += X_u @ U @ X_u.T -> G = np.zeros((len(P), len(U))); G[:3] = X_u; G[3:5] = X_u[:2]; P += G @ U @ G.T
    noise before the motion: Your noise goes through X_x as well: it belongs to the pose after the step, so add it after the motion.
        P[:3, :3] += X_u @ U @ X_u.T -> pass
        P[:3] = X_x @ P[:3] -> P[:3, :3] += X_u @ U @ X_u.T; P[:3] = X_x @ P[:3]
    noise in X_x twice | X_u @ U @ X_u.T -> 2 * X_u @ U @ X_u.T | The noise of the control comes once: + X_u U X_u'.
    only the diagonal of P_rr | P[:3] = X_x @ P[:3] -> P[:3, :3] = np.diag(np.diag(P[:3, :3])); P[:3] = X_x @ P[:3] | The errors of the pose are correlated: use the whole block P_rr.
    X_x on one side of P_rr: The block of the robot stands in its rows and in its columns: X_x P_rr X_x', from both sides. Yours has gone through X_x from one side only.
        P = P.copy() -> old, P = P, P.copy()
        P[:, :3] = P[:, :3] @ X_x.T -> P[:, :3] = old[:, :3] @ X_x.T
    X_x twice in P_rm: Of the two errors in P_rm one is the robot's: X_x comes in once, X_x P_rm.
        P[:, :3] = P[:, :3] @ X_x.T -> P[:, :3] = P[:, :3] @ X_x.T; P[:3, 3:] = X_x @ P[:3, 3:]; P[3:, :3] = P[:3, 3:].T
    noise of the position on each landmark: The landmarks stand still: no noise is added to P_mm.
        return P -> P[3:, 3:] += np.kron(np.eye((len(P) - 3) // 2), (X_u @ U @ X_u.T)[:2, :2]); return P
    root of U | X_u @ U @ X_u.T -> X_u @ np.sqrt(np.abs(U)) @ X_u.T | U holds variances already: no root.
    X_x twice, by the columns: X_x comes in twice: when P_rr is computed, your columns have gone through X_x already. Compute each block from the old P.
        P[:, :3] = P[:, :3] @ X_x.T -> P[3:, :3], P[:3, :3] = P[:3, 3:].T, P[:3, :3] @ X_x.T @ X_x.T
    diagonal of the noise only | X_u @ U @ X_u.T -> np.diag(np.diag(X_u @ U @ X_u.T)) | The errors that a step adds to x, y and theta are correlated: add the whole of X_u U X_u'.
    identity added to X_x | P = P.copy() -> P, X_x = P.copy(), X_x + np.eye(3) | X_x is the derivative of the new pose by the old one, and has its ones on the diagonal already: no identity is added.
    """,
    forms="""
    matrices of the whole state | P = P.copy() -> F, G = np.eye(len(P)), np.zeros((len(P), X_u.shape[1])) | F P F' + G U G' of the whole state
        P[:3] = X_x @ P[:3] -> F[:3, :3] = X_x
        P[:, :3] = P[:, :3] @ X_x.T -> G[:3] = X_u
        P[:3, :3] += X_u @ U @ X_u.T -> P = F @ P @ F.T + G @ U @ G.T
    """,
)


@motion.link("there and back", "A step and its exact inverse, both without noise, must leave P as it was.")
def _(f, rng):
    P, X_x, X_u, U = some(rng, 9)
    there = expect.array(f(P, X_x, X_u, 0 * U), P.shape, "P")
    back = expect.array(f(there, np.linalg.inv(X_x), X_u, 0 * U), P.shape, "P")
    expect.close(back, P, "P after a step there and back without noise")


@motion.link("still a covariance", "After many steps P must have no negative eigenvalue.")
def _(f, rng):
    P = random_covariance(rng, 7)
    for _ in range(20):
        _, X_x, X_u, U = some(rng, 7)
        P = expect.array(f(P, X_x, X_u, 0.01 * U), P.shape, "P")
    expect.psd(P, "P after 20 steps", 1e-7)
