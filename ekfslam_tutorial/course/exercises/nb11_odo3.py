"""Exercise 11.1: odometry in space."""

import numpy as np

from ...geometry import Frame3, e2q, numerical_jacobian, q2e, q2R, q_prod, unit, v2q
from ...models.motion import Odometry3
from .. import expect
from ..diagnose import same
from ..exercise import Exercise


def odo3(x, u):
    """One step of odometry in space, and its derivatives.

    x, shape (7,): the robot's frame [t, q]. u = [dx, dv], shape (6,): the step and the rotation vector (m, rad), both
    in the axes of the robot before the step.
    Return x2, shape (7,), without normalisation; X_x, shape (7, 7), and X_u, shape (7, 6): its derivatives.
    """
    R, R_q = q2R(x[3:])
    dq, DQ_v = v2q(u[3:])
    q2, Q_q, Q_dq = q_prod(x[3:], dq)
    X_x, X_u = np.eye(7), np.zeros((7, 6))
    X_x[:3, 3:] = np.einsum("ijk,j->ik", R_q, u[:3])
    X_x[3:, 3:] = Q_q
    X_u[:3, :3] = R
    X_u[3:, 3:] = Q_dq @ DQ_v
    return np.concatenate([x[:3] + R @ u[:3], q2]), X_x, X_u


exercise = Exercise(
    "11.1",
    "Odometry in space",
    odo3,
    hints=(
        "The step is a frame, given in the robot's frame: compose the two. The rotation vector becomes a quaternion "
        "with v2q.",
        "t2 = t + R(q) dx, q2 = q dq. The position depends on q through R: X_x has a block d(t2)/d(q), from R_q.",
        "X_x[:3, 3:] = np.einsum('ijk,j->ik', R_q, dx), X_x[3:, 3:] = Q_q, X_u[:3, :3] = R, X_u[3:, 3:] = Q_dq @ DQ_v.",
    ),
)


def pose(rng):
    """Return a frame that is turned about all axes."""
    return np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])


def step(rng):
    """Return a step of about a metre and half a radian."""
    return np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-0.6, 0.6, 3)])


def value(x, u):
    """Return the new frame."""
    return Odometry3().move(x, u, 1.0)[0]


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


def positive(x2, *jacobians):
    """Return value and Jacobians with a >= 0, as many programs write a quaternion [a, b, c, d]."""
    return signed((x2, *jacobians), np.eye(len(x2))[3])


def by_state(J, f, x, name, rows, cols):
    """J must be the derivative of f at x; along q, where formulas may differ off the sphere, it is not compared."""
    try:
        expect.jacobian(J, f, x, name, rows, cols)
    except expect.Failed:
        if not same(J @ tangent(x), numerical_jacobian(f, x) @ tangent(x)):
            raise


STATE = ("t_x", "t_y", "t_z", "a", "b", "c", "d")
CONTROL = ("dx", "dy", "dz", "dv_x", "dv_y", "dv_z")


def _out(result):
    return expect.results(result, "x2", "X_x", "X_u")


def _x2(result):
    return expect.array(_out(result)[0], 7, "x2")


def _turn(f, x, u):
    """The quaternion, with the sign that the solution has."""
    return signed([_x2(f(x, u))], value(x, u))[0][3:]


def _jacobian(f, x, u, which, shape, name):
    """One of the Jacobians, with the sign that the quaternion of the solution has."""
    results = _out(f(x, u))
    J = expect.array(results[which], shape, name)
    return signed([_x2(results), J], value(x, u))[1]


@exercise.link("three results", "The function must end with `return x2, X_x, X_u`.")
def _(f, rng):
    _, X_x, X_u = _out(f(pose(rng), step(rng)))
    expect.true(X_x is not None and X_u is not None, "X_x or X_u is None: return all three results")


@exercise.link("position", "The step is seen from the robot: turn it into the world with R(q), then add it.", part=0)
def _(f, rng):
    u = np.array([2.0, 0, 0, 0, 0, 0])
    level, left = np.eye(7)[3], np.concatenate([[1, 1, 0], e2q(np.array([0, 0, np.pi / 2]))[0]])
    expect.close(_x2(f(level, u))[:3], [2, 0, 0], "the new position", at="a robot that looks along x, 2 m ahead")
    expect.close(_x2(f(left, u))[:3], [1, 3, 0], "the new position", at="a robot at (1, 1, 0) that looks along y")
    for _ in range(3):
        x, u = pose(rng), step(rng)
        expect.close(_x2(f(x, u))[:3], value(x, u)[:3], "the new position", at="any pose")


@exercise.link("orientation", "The turn is in the axes of the robot: its quaternion stands on the right, q dq.", part=0)
def _(f, rng):
    level = np.eye(7)[3]
    for v in 0.5 * np.eye(3):
        u = np.concatenate([np.zeros(3), v])
        expect.close(_turn(f, level, u), v2q(v)[0], "q2", at=f"the turn {v.tolist()}")
    for scale in (1.0, 1.0, 3.0):
        x, u = pose(rng), scale * step(rng)
        expect.close(_turn(f, x, u), value(x, u)[3:], "q2", at="any pose and turn")
    x, u = pose(rng), np.concatenate([rng.normal(size=3), np.zeros(3)])
    expect.close(_turn(f, x, u), x[3:], "q2", at="a step without a turn")


@exercise.link("derivative by the state", "t2 depends on t, and through R(q) on q; q2 depends on q only.", part=1)
def _(f, rng):
    for _ in range(4):
        x, u = pose(rng), step(rng)
        X_x = _jacobian(f, x, u, 1, (7, 7), "X_x")
        by_state(X_x, lambda x, u=u: value(x, u), x, "X_x", STATE, STATE)


@exercise.link(
    "derivative by the control", "dx passes through R; dv passes through v2q, then through the product.", part=2
)
def _(f, rng):
    for _ in range(4):
        x, u = pose(rng), step(rng)
        X_u = _jacobian(f, x, u, 2, (7, 6), "X_u")
        expect.jacobian(X_u, lambda u, x=x: value(x, u), u, "X_u", STATE, CONTROL)
    x, u = pose(rng), np.zeros(6)
    X_u = _jacobian(f, x, u, 2, (7, 6), "X_u")
    expect.jacobian(X_u, lambda u: value(x, u), u, "X_u", STATE, CONTROL)


def _wrong(name, hint, change):
    """A wrong answer: `change(x, u, x2, X_x, X_u)` spoils the right results."""

    def answer(x, u):
        return change(np.asarray(x), np.asarray(u), *odo3(x, u))

    exercise.wrong(name, hint)(answer)


def _put(A, block, B):
    A = A.copy()
    A[block] = B
    return A


TQ, QV, TT = (slice(0, 3), slice(3, 7)), (slice(3, 7), slice(3, 6)), (slice(0, 3), slice(0, 3))


def _numerical(f):
    """The answer with the value f and its exact derivatives."""

    def answer(x, u):
        return f(x, u), numerical_jacobian(lambda x: f(x, u), x), numerical_jacobian(lambda u: f(x, u), u)

    return answer


# fmt: off
exercise.wrong("step in the axes of the world", "dx is seen from the robot: turn it with R(q) before you add "
               "it.")(_numerical(lambda x, u: np.concatenate([x[:3] + u[:3], value(x, u)[3:]])))
exercise.wrong("step turned back", "R(q) goes from the robot to the world, its transpose goes back: t + R dx.")(
    _numerical(lambda x, u: np.concatenate([x[:3] + q2R(x[3:])[0].T @ u[:3], value(x, u)[3:]])))
exercise.wrong("turned first", "The step is seen from the robot *before* it turns: use R of the old q.")(
    _numerical(lambda x, u: np.concatenate([x[:3] + q2R(value(x, u)[3:])[0] @ u[:3], value(x, u)[3:]])))
exercise.wrong("turn in the axes of the world", "dq q turns about the axes of the world. The turn is in the robot's: "
               "q dq.")(_numerical(lambda x, u: np.concatenate([value(x, u)[:3], q_prod(v2q(u[3:])[0], x[3:])[0]])))
exercise.wrong("quaternions added", "Two rotations one after the other are a product: q_prod(q, dq).")(
    _numerical(lambda x, u: np.concatenate([value(x, u)[:3], x[3:] + v2q(u[3:])[0]])))
exercise.wrong("rotation vector as Euler angles", "dv is a rotation vector: use v2q, not e2q.")(
    _numerical(lambda x, u: np.concatenate([value(x, u)[:3], q_prod(x[3:], e2q(u[3:])[0])[0]])))
exercise.wrong("Euler angles added", "Angles of the world and turns of the robot cannot be added: use q_prod.")(
    _numerical(lambda x, u: np.concatenate([value(x, u)[:3], e2q(q2e(x[3:])[0] + u[3:])[0]])))
exercise.wrong("rotation forgotten", "The robot turns, too: q2 = q dq.")(
    _numerical(lambda x, u: np.concatenate([value(x, u)[:3], x[3:] + 0 * u[0]])))
_wrong("position by q forgotten", "A small error of q moves the end of the step: X_x has a block d(t2)/d(q), from R_q.",
       lambda x, u, x2, X_x, X_u: (x2, _put(X_x, TQ, 0), X_u))
_wrong("X_x is the identity", "t2 and q2 depend on q: fill the columns of q.",
       lambda x, u, x2, X_x, X_u: (x2, np.eye(7), X_u))
_wrong("R_q of the new pose", "The derivatives belong to the pose *before* the step: R_q at the old q.",
       lambda x, u, x2, X_x, X_u: (x2, odo3(x2, u)[1], X_u))
_wrong("R_q contracted with the wrong axis", "R_q[i, j, k] is the derivative of R_ij by q_k: sum over j with dx, "
       "einsum('ijk,j->ik').",
       lambda x, u, x2, X_x, X_u: (x2, _put(X_x, TQ, np.einsum("ijk,i->jk", q2R(x[3:])[1], u[:3])), X_u))
_wrong("the two Jacobians of the product swapped", "q_prod(q, dq) returns q2, Q_q, Q_dq: the first Jacobian belongs to "
       "q, the second to dq.",
       lambda x, u, x2, X_x, X_u: (x2, _put(X_x, (slice(3, 7),) * 2, q_prod(x[3:], v2q(u[3:])[0])[2]),
                                   _put(X_u, QV, q_prod(x[3:], v2q(u[3:])[0])[1] @ v2q(u[3:])[1])))
_wrong("dx not turned in X_u", "dx passes through R(q) on its way to t2: X_u[:3, :3] = R.",
       lambda x, u, x2, X_x, X_u: (x2, X_x, _put(X_u, TT, np.eye(3))))
_wrong("small turn taken for any turn", "Your block is right for dv = 0 only: use DQ_v of v2q(dv).",
       lambda x, u, x2, X_x, X_u: (x2, X_x, _put(X_u, QV, q_prod(x[3:], v2q(u[3:])[0])[2] @ v2q(0 * u[3:])[1])))
_wrong("dv lost in X_u", "q2 depends on dv, through v2q: X_u[3:, 3:] = Q_dq @ DQ_v.",
       lambda x, u, x2, X_x, X_u: (x2, X_x, _put(X_u, QV, 0)))
_wrong("sign of the quaternion changed, but not of its derivatives", "-q turns as q does, but then its derivatives "
       "change their sign, too: rows 3 to 6 of X_x and X_u.",
       lambda x, u, x2, X_x, X_u: (positive(x2, X_x, X_u)[0], X_x, X_u))
_wrong("half the turn", "v2q has the half angle in it already: its Jacobian must not be halved once more.",
       lambda x, u, x2, X_x, X_u: (x2, X_x, _put(X_u, QV, X_u[QV] / 2)))
# fmt: on


@exercise.variant("composition of frames")
def _(x, u):
    q, Q_v = v2q(u[3:])
    F, X_x, X_s = Frame3(x).compose(Frame3(np.concatenate([u[:3], q])))
    return F.x, X_x, np.hstack([X_s[:, :3], X_s[:, 3:] @ Q_v])


@exercise.variant("finite differences, as lists")
def _(x, u):
    x2, X_x, X_u = _numerical(value)(x, u)
    return x2.tolist(), X_x.tolist(), X_u.tolist()


@exercise.variant("derivative along the sphere")
def _(x, u):
    x2, X_x, X_u = odo3(x, u)
    return x2, X_x @ tangent(x), X_u


@exercise.variant("the quaternion with a >= 0")
def _(x, u):
    return positive(*odo3(x, u))
