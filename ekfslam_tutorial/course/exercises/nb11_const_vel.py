"""Exercise 11.3: a body that keeps its velocity."""

import numpy as np

from ...geometry import q2R, q_prod, v2q  # noqa: F401
from ..table import table
from .nb11_odo3 import as_wanted, pose, positive, tangent  # noqa: F401


def const_vel(x, u, dt):
    """One step of a body that keeps its velocity but for a random impulse.

    x = [t, q, v, w], shape (13,): frame; velocity v (m/s) in the axes of the world; turn rate w (rad/s) in the axes of
    the body. u = [dv, dw], shape (6,): impulses, added to v and w at the end of the step. dt: seconds.
    Return x2, shape (13,); X_x, shape (13, 13), and X_u, shape (13, 6): its derivatives.
    """
    t, q, v, w = x[:3], x[3:7], x[7:10], x[10:]
    dq, DQ_a = v2q(w * dt)
    q2, Q_q, Q_dq = q_prod(q, dq)
    X_x, X_u = np.eye(13), np.zeros((13, 6))
    X_x[:3, 7:10] = dt * np.eye(3)
    X_x[3:7, 3:7] = Q_q
    X_x[3:7, 10:] = Q_dq @ DQ_a * dt
    X_u[7:] = np.eye(6)
    return np.concatenate([t + v * dt, q2, v + u[:3], w + u[3:]]), X_x, X_u


def case(rng, turns=True):
    """Return a state, an impulse and a time; without a turn rate if so wanted."""
    x = np.concatenate([pose(rng), rng.uniform(-2, 2, 6)])
    x[10:] *= turns
    return x, rng.uniform(-0.3, 0.3, 6), float(rng.uniform(0.1, 0.5))


STATE = "t_x, t_y, t_z, a, b, c, d, v_x, v_y, v_z, w_x, w_y, w_z"

exercise = table(
    "11.3 Constant velocity",
    const_vel,
    hints=(
        "Four lines: t2 = t + v dt; q2 = q times the quaternion of the turn w dt; v2 = v + dv; w2 = w + dw.",
        "X_x is the identity, but for three blocks: t2 by v, q2 by q, q2 by w. X_u has ones in the rows of v and w.",
        "dq, DQ_a = v2q(w * dt); q2, Q_q, Q_dq = q_prod(q, dq); X_x[3:7, 10:] = Q_dq @ DQ_a * dt.",
    ),
    returns="x2, X_x, X_u",
    symbols="Q_q = the derivative of the product by its first factor, from q_prod; DQ_a = the second result of v2q",
    jacobians={"X_x": "x2", "X_u": "x2"},
    entries={"x2": STATE, "x": STATE, "u": "dv_x, dv_y, dv_z, dw_x, dw_y, dw_z"},
    settled=as_wanted,
    along={"X_x": lambda x, u, dt: tangent(x)},
    cases={"any": lambda rng: [case(rng) for _ in range(4)], "w = 0": lambda rng: [case(rng, turns=False)]},
    checks="""
    position                  | x2[:3]   | any   | v is in the axes of the world: t2 = t + v dt.
    orientation               | x2[3:7]  | any   | In dt the body turns by the rotation vector w dt, in its own axes: q v2q(w dt).
    no turn                   | x2[3:7]  | w = 0 | With w = 0 the orientation stays: v2q(w dt) = [1, 0, 0, 0], and q2 = q.
    velocities                | x2       | any   | v and w keep their values, plus the impulses of this step: v2 = v + dv, w2 = w + dw.
    derivative by the state   | d X_x / x | any  | Besides the ones there are three blocks, each in the rows and columns of its own: t2 = t + v dt by v, and q2 = q v2q(w dt) by q and by w.
    derivative without a turn | d X_x / x | w = 0 | With w = 0, too, v2q has a derivative. Besides the ones there are three blocks: t2 = t + v dt by v, and q2 = q v2q(w dt) by q and by w.
    derivative by the impulse | d X_u / u | any  | The impulse comes at the end of the step: v2 = v + dv, w2 = w + dw, and the derivatives of t2 and q2 by u are zero.
    """,
    wrong="""
    dt forgotten in the position | t + v * dt -> t + v | v is in metres per second: t + v dt.
    v in the axes of the body | t + v * dt -> t + q2R(q)[0] @ v * dt | Here v is in the axes of the world: it is not turned.
    impulse used at once | t + v * dt -> t + (v + u[:3]) * dt | The impulse comes at the end of the step: the position moves with the old v.
    impulse of the turn used at once | v2q(w * dt) -> v2q((w + u[3:]) * dt) | The impulse comes at the end of the step: turn with the old w.
    impulse first: The impulse comes at the end of the step: t and q move with the old v and w.
        x[7:10], x[10:] -> x[7:10] + u[:3], x[10:] + u[3:]
        v + u[:3], w + u[3:] -> v, w
        X_u[7:] = np.eye(6) -> X_u[:] = X_x[:, 7:]
    turn in the axes of the world | q2, Q_q, Q_dq = q_prod(q, dq) -> q2, Q_dq, Q_q = q_prod(dq, q) | w is in the axes of the body: its quaternion stands on the right.
    dt forgotten in the turn | v2q(w * dt) -> v2q(w) | w is in radians per second: v2q(w dt).
    Euler's step | dt, q2, v + -> dt, q + 0.5 * dt * q_prod(q, np.r_[0, w])[0], v + | q + 1/2 q w dt leaves the unit sphere. The exact turn is q v2q(w dt).
    impulse times dt | v + u[:3], w + u[3:] -> v + u[:3] * dt, w + u[3:] * dt | u is a change of the velocity already, in m/s: it is not multiplied by dt.
    impulses forgotten | v + u[:3], w + u[3:] -> v, w | v2 = v + dv and w2 = w + dw.
    dt forgotten in d(t2)/d(v) | dt * np.eye(3) -> np.eye(3) | t2 = t + v dt: its derivative by v is dt I.
    dt forgotten in d(q2)/d(w) | DQ_a * dt -> DQ_a | The inner derivative: d(w dt)/dw = dt.
    q2 by w forgotten | Q_dq @ DQ_a * dt -> 0 | The turn depends on w: X_x[3:7, 10:] is not zero.
    q2 by q is the identity | X_x[3:7, 3:7] = Q_q -> X_x[3:7, 3:7] = np.eye(4) | q2 = q dq: its derivative by q is Q_q, from q_prod.
    small turn | DQ_a * dt -> v2q(0 * w)[1] * dt | DQ_a must be taken at w dt, not at zero.
    sign of the quaternion changed, but not of its derivatives: -q turns as q does, but then its derivatives change their sign, too: rows 3 to 6 of X_x.
        return np.concatenate([t + v * dt, q2, v + u[:3], w + u[3:]]) -> return positive(np.concatenate([t + v * dt, q2, v + u[:3], w + u[3:]]))[0]
    X_u in the rows of the frame | X_u[7:] = np.eye(6) -> X_u[:6] = np.eye(6) | The impulses change v and w: rows 7 to 12.
    dt in X_u | X_u[7:] = np.eye(6) -> X_u[7:] = dt * np.eye(6) | u is an impulse, not an acceleration: X_u has ones.
    half the turn | v2q(w * dt) -> v2q(w * dt / 2) | v2q has the half angle in it already: v2q(w dt).
    derivative by w in the columns of v | X_x[3:7, 10:] = -> X_x[3:7, 7:10] = | The state is [t, q, v, w]: columns 7 to 9 belong to v, 10 to 12 to w. q2 depends on w.
    dv and dw exchanged in X_u | X_u[7:] = np.eye(6) -> X_u[7:] = np.roll(np.eye(6), 3, axis=1) | u = [dv, dw]: v2 follows dv, the first three columns of X_u, and w2 follows dw, the last three.
    dw forgotten in X_u | X_u[7:] = np.eye(6) -> X_u[7:10, :3] = np.eye(3) | w2 = w + dw: X_u[10:, 3:] is an identity, as X_u[7:10, :3] is.
    dv and dw exchanged | v + u[:3], w + u[3:] -> v + u[3:], w + u[:3] | u = [dv, dw]: the impulse of v comes first, that of w behind it.
    v not kept | v + u[:3], w -> u[:3], w | The body keeps its velocity, and the impulse comes to it: v2 = v + dv.
    dv and dw exchanged, in X_u, too: u = [dv, dw]: the impulse of v comes first, that of w behind it.
        v + u[:3], w + u[3:] -> v + u[3:], w + u[:3]
        X_u[7:] = np.eye(6) -> X_u[7:] = np.roll(np.eye(6), 3, axis=1)
    dt forgotten in the turn, in X_x, too: w is in radians per second: v2q(w dt), and its derivative by w has the factor dt.
        v2q(w * dt) -> v2q(w)
        DQ_a * dt -> DQ_a
    impulse times dt, in X_u, too: u is an impulse, a change of the velocity already: it is not multiplied by dt.
        v + u[:3], w + u[3:] -> v + u[:3] * dt, w + u[3:] * dt
        X_u[7:] = np.eye(6) -> X_u[7:] = dt * np.eye(6)
    v and w forgotten in X_x | X_x[3:7, 3:7] = Q_q -> X_x[3:7, 3:7] = Q_q; X_x[7:, 7:] = 0 | v and w stay as they are, but for the impulses: their derivative by themselves is the identity.
    w by w forgotten | X_x[3:7, 3:7] = Q_q -> X_x[3:7, 3:7] = Q_q; X_x[10:, 10:] = 0 | w stays as it is, but for the impulse: its derivative by itself is the identity.
    v by v forgotten | X_x[3:7, 3:7] = Q_q -> X_x[3:7, 3:7] = Q_q; X_x[7:10, 7:10] = 0 | v stays as it is, but for the impulse: its derivative by itself is the identity.
    position by the impulse | X_u[7:] = np.eye(6) -> X_u[7:] = np.eye(6); X_u[:3, :3] = dt * np.eye(3) | The impulse comes at the end of the step: it does not move the position any more.
    mean velocity, in all: The impulse comes at the end of the step: t moves with the old v, not with the mean of both.
        t + v * dt -> t + (v + u[:3] / 2) * dt
        X_u[7:] = np.eye(6) -> X_u[7:] = np.eye(6); X_u[:3, :3] = dt / 2 * np.eye(3)
    v in the axes of the body, in all: Here v is in the axes of the world: it is not turned, and q does not move t.
        t + v * dt -> t + q2R(q)[0] @ v * dt
        X_x[:3, 7:10] = dt * np.eye(3) -> X_x[:3, 7:10] = dt * q2R(q)[0]; X_x[:3, 3:7] = dt * np.einsum("ijk,j->ik", q2R(q)[1], v)
    """,
)
