"""Exercise 11.1: odometry in space."""

import numpy as np

from ...geometry import e2q, q2e, q2R, q_prod, unit, v2q  # noqa: F401
from ..table import table


def odo3(x, u):
    """One step of odometry in space, and its derivatives.

    x, shape (7,): the robot's frame [t, q]. u = [dx, dv], shape (6,): the step and the rotation vector (m, rad), both
    in the axes of the robot before the step.
    Return x2, shape (7,), without normalisation; X_x, shape (7, 7), and X_u, shape (7, 6): its derivatives.
    """
    R, R_q = q2R(x[3:])
    dq, DQ_v = v2q(u[3:])
    q2, Q_q, Q_dq = q_prod(x[3:], dq)
    t2 = x[:3] + R @ u[:3]
    X_x, X_u = np.eye(7), np.zeros((7, 6))
    X_x[:3, 3:] = np.einsum("ijk,j->ik", R_q, u[:3])
    X_x[3:, 3:] = Q_q
    X_u[:3, :3] = R
    X_u[3:, 3:] = Q_dq @ DQ_v
    return np.concatenate([t2, q2]), X_x, X_u


def pose(rng):
    """Return a frame that is turned about all axes."""
    return np.concatenate([rng.uniform(-9, 9, 3), unit(rng.normal(size=4))[0]])


def step(rng):
    """Return a step of about a metre and half a radian."""
    return np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-0.6, 0.6, 3)])


def tangent(x):
    """Return the projector on the changes of a state [t, q, ...] that keep |q| = 1."""
    T = np.eye(len(x))
    T[3:7, 3:7] -= np.outer(x[3:7], x[3:7])
    return T


def signed(results, want):
    """Return value and Jacobians with the sign of the quaternion, entries 3 to 6, that is wanted: -q turns as q does.

    With a quaternion its derivatives change their sign.
    """
    x2, *jacobians = (np.array(a, dtype=float) for a in results)
    if x2[3:7] @ want[3:7] < 0:
        for a in (x2, *jacobians):
            a[3:7] *= -1
    return x2, *jacobians


def as_wanted(results, right):
    """Return the results with the sign of the quaternion that the right ones have."""
    return signed(results, right[0])


def positive(x2, *jacobians):
    """Return value and Jacobians with a >= 0, as many programs write a quaternion [a, b, c, d]."""
    return signed((x2, *jacobians), np.eye(len(x2))[3])


LEVEL = np.eye(7)[3]
LEFT = np.concatenate([[1, 1, 0], e2q(np.array([0, 0, np.pi / 2]))[0]])  # at (1, 1, 0), it looks along y
AHEAD = np.array([2.0, 0, 0, 0, 0, 0])


def _no_turn(x, u):
    return x, np.concatenate([u[:3], np.zeros(3)])


exercise = table(
    "11.1 Odometry in space",
    odo3,
    hints=(
        "The step is a frame, given in the robot's frame: compose the two. The rotation vector becomes a quaternion with v2q.",
        "t2 = t + R(q) dx, q2 = q dq. The position depends on q through R: X_x has a block d(t2)/d(q), from R_q.",
        "X_x[:3, 3:] = np.einsum('ijk,j->ik', R_q, dx), X_x[3:, 3:] = Q_q, X_u[:3, :3] = R, X_u[3:, 3:] = Q_dq @ DQ_v.",
    ),
    returns="x2, X_x, X_u",
    symbols="R_q = the derivative of R by q, from q2R; "
    "Q_q, Q_dq = the derivatives of the product by its two factors, from q_prod; "
    "DQ_v = the derivative of dq by dv, from v2q",
    jacobians={"X_x": "x2", "X_u": "x2"},
    entries={"x2": "t_x, t_y, t_z, a, b, c, d", "x": "t_x, t_y, t_z, a, b, c, d", "u": "dx, dy, dz, dv_x, dv_y, dv_z"},
    settled=as_wanted,
    along={"X_x": lambda x, u: tangent(x)},
    cases={
        "any": lambda rng: [(pose(rng), scale * step(rng)) for scale in (1, 1, 1, 3)],
        "ahead": lambda rng: [(LEVEL, AHEAD), (LEFT, AHEAD)],
        "turns": lambda rng: [(LEVEL, np.concatenate([np.zeros(3), v])) for v in 0.5 * np.eye(3)],
        "no turn": lambda rng: [_no_turn(pose(rng), step(rng)), (pose(rng), np.zeros(6))],
    },
    checks="""
    ahead                     | x2[:3] | ahead   | The step is seen from the robot: turn it into the world with R(q), then add it to t. With dv = 0 the orientation stays: dq = [1, 0, 0, 0].
    position                  | x2[:3] | any     | The step is seen from the robot: turn it into the world with R(q), then add it to t.
    turns                     | x2[3:] | turns   | The robot is not turned yet, q = [1, 0, 0, 0], so q2 = q dq is dq: the quaternion of the whole rotation vector u[3:], half a radian about one axis.
    orientation               | x2[3:] | any     | The turn is in the axes of the robot: its quaternion stands on the right, q dq, and dq is that of the whole rotation vector u[3:].
    no turn                   | x2     | no turn | With dv = 0 the orientation stays: dq = [1, 0, 0, 0], q2 = q. The step is added as ever, t2 = t + R(q) dx.
    derivative by the state   | d X_x / x | any  | t2 depends on t, and through R(q) on q; q2 = q dq depends on q. So X_x has three blocks, and the fourth, q2 by t, is zero.
    derivative by the control | d X_u / u | any  | dx passes through R; dv passes through v2q, then through the product.
    derivative without a turn | d X_u / u | no turn | With dv = 0, too, v2q has a derivative, and X_u its two blocks: dx passes through R; dv passes through v2q, then through the product.
    """,
    wrong="""
    step in the axes of the world | R @ u[:3] -> u[:3] | dx is seen from the robot: turn it with R(q) before you add it.
    step turned back | R @ u[:3] -> R.T @ u[:3] | R(q) goes from the robot to the world, its transpose goes back: t + R dx.
    turned first | R @ u[:3] -> q2R(q2)[0] @ u[:3] | The step is seen from the robot *before* it turns: use R of the old q.
    turn in the axes of the world | q2, Q_q, Q_dq = q_prod(x[3:], dq) -> q2, Q_dq, Q_q = q_prod(dq, x[3:]) | dq q turns about the axes of the world. The turn is in the robot's: q dq.
    quaternions added | [t2, q2] -> [t2, x[3:] + dq] | Two rotations one after the other are a product: q_prod(q, dq).
    rotation vector as Euler angles | dq, DQ_v = v2q -> dq, DQ_v = e2q | dv is a rotation vector: use v2q, not e2q.
    half the rotation vector | v2q(u[3:]) -> v2q(0.5 * u[3:]) | v2q has the half angle in it already: it takes the whole rotation vector, u[3:].
    rotation vector from degrees | v2q(u[3:]) -> v2q(np.radians(u[3:])) | The rotation vector is in radians already: no conversion.
    quaternion of a small turn | dq, DQ_v = v2q(u[3:]) -> dq, DQ_v = np.append(1, u[3:] / 2), v2q(u[3:])[1] | [1, dv/2] is for small turns only, and its norm is not one: v2q gives the quaternion of any turn.
    Euler angles added | [t2, q2] -> [t2, e2q(q2e(x[3:])[0] + u[3:])[0]] | Angles of the world and turns of the robot cannot be added: use q_prod.
    rotation forgotten | [t2, q2] -> [t2, x[3:]] | The robot turns, too: q2 = q dq.
    position by q forgotten | X_x[:3, 3:] = np.einsum("ijk,j->ik", R_q, u[:3]) -> X_x[:3, 3:] = 0 | A small error of q moves the end of the step: X_x has a block d(t2)/d(q), from R_q.
    X_x is the identity | q2]), X_x, -> q2]), np.eye(7), | t2 and q2 depend on q: fill the columns of q.
    R_q of the new pose | R_q, u[:3]) -> q2R(q2)[1], u[:3]) | The derivatives belong to the pose *before* the step: R_q at the old q.
    R_q contracted with the wrong axis | "ijk,j->ik" -> "ijk,i->jk" | R_q[i, j, k] is the derivative of R_ij by q_k: sum over j with dx, einsum('ijk,j->ik').
    the two Jacobians of the product swapped | q2, Q_q, Q_dq = -> q2, Q_dq, Q_q = | q_prod(q, dq) returns q2, Q_q, Q_dq: the first Jacobian belongs to q, the second to dq.
    dx not turned in X_u | X_u[:3, :3] = R -> X_u[:3, :3] = np.eye(3) | dx passes through R(q) on its way to t2: X_u[:3, :3] = R.
    small turn taken for any turn | Q_dq @ DQ_v -> Q_dq @ v2q(0 * u[3:])[1] | Your block is right for dv = 0 only: use DQ_v of v2q(dv).
    dv lost in X_u | X_u[3:, 3:] = Q_dq @ DQ_v -> X_u[3:, 3:] = 0 | q2 depends on dv, through v2q: X_u[3:, 3:] = Q_dq @ DQ_v.
    sign of the quaternion changed, but not of its derivatives: -q turns as q does, but then its derivatives change their sign, too: rows 3 to 6 of X_x and X_u.
        np.concatenate([t2, q2]), X_x, X_u -> positive(np.concatenate([t2, q2]))[0], X_x, X_u
    half the turn | Q_dq @ DQ_v -> Q_dq @ DQ_v / 2 | v2q has the half angle in it already: its Jacobian must not be halved once more.
    position not moved | x[:3] + R @ u[:3] -> R @ u[:3] | The step begins where the robot stands: t2 = t + R(q) dx.
    step in the axes of the world, in all: dx is seen from the robot: turn it with R(q), in the derivatives, too.
        t2 = x[:3] + R @ u[:3] -> t2 = x[:3] + u[:3]
        X_x[:3, 3:] = np.einsum("ijk,j->ik", R_q, u[:3]) -> pass
        X_u[:3, :3] = R -> X_u[:3, :3] = np.eye(3)
    step turned back, in all: R(q) goes from the robot to the world, its transpose goes back: t + R dx, in the derivatives, too.
        t2 = x[:3] + R @ u[:3] -> t2 = x[:3] + R.T @ u[:3]
        "ijk,j->ik" -> "jik,j->ik"
        X_u[:3, :3] = R -> X_u[:3, :3] = R.T
    the other matrix of the product by q | X_x[3:, 3:] = Q_q -> X_x[3:, 3:] = q_prod(dq, x[3:])[2] | q2 = q dq: by q it is the matrix of a product with dq on the *right*. Yours is that with dq on the left.
    twice the rotation vector | dq, DQ_v = v2q(u[3:]) -> dq, DQ_v = v2q(2 * u[3:]); DQ_v = 2 * DQ_v | v2q halves the angle itself: hand it the rotation vector as it is.
    half the rotation vector, in X_u, too | dq, DQ_v = v2q(u[3:]) -> dq, DQ_v = v2q(0.5 * u[3:]); DQ_v = 0.5 * DQ_v | v2q has the half angle in it already: it takes the whole rotation vector, u[3:].
    DQ_v alone | Q_dq @ DQ_v -> DQ_v | The chain has two links: dv moves dq, and dq moves q2: Q_dq DQ_v.
    """,
)
