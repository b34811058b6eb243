"""Exercise 11.3: a body that keeps its velocity."""

import numpy as np

from ...geometry import numerical_jacobian, q2R, q_prod, v2q
from ...models.motion import ConstantVelocity
from .. import expect
from ..exercise import Exercise
from .nb11_odo3 import by_state, pose, positive, signed, tangent


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


exercise = Exercise(
    "11.3",
    "Constant velocity",
    const_vel,
    hints=(
        "Four lines: t2 = t + v dt; q2 = q times the quaternion of the turn w dt; v2 = v + dv; w2 = w + dw.",
        "X_x is the identity, but for three blocks: t2 by v, q2 by q, q2 by w. X_u has ones in the rows of v and w.",
        "dq, DQ_a = v2q(w * dt); q2, Q_q, Q_dq = q_prod(q, dq); X_x[3:7, 10:] = Q_dq @ DQ_a * dt.",
    ),
)

STATE = (*("t_x", "t_y", "t_z", "a", "b", "c", "d"), *("v_x", "v_y", "v_z", "w_x", "w_y", "w_z"))
CONTROL = ("dv_x", "dv_y", "dv_z", "dw_x", "dw_y", "dw_z")


def _case(rng):
    return np.concatenate([pose(rng), rng.uniform(-2, 2, 6)]), rng.uniform(-0.3, 0.3, 6), float(rng.uniform(0.1, 0.5))


def _value(x, u, dt):
    return ConstantVelocity().move(x, u, dt)[0]


def _out(result):
    return expect.results(result, "x2", "X_x", "X_u")


def _x2(result):
    return expect.array(_out(result)[0], 13, "x2")


def _turn(f, x, u, dt):
    """The quaternion, with the sign that the solution has."""
    return signed([_x2(f(x, u, dt))], _value(x, u, dt))[0][3:7]


def _jacobian(f, x, u, dt, which, shape, name):
    """One of the Jacobians, with the sign that the quaternion of the solution has."""
    results = _out(f(x, u, dt))
    J = expect.array(results[which], shape, name)
    return signed([_x2(results), J], _value(x, u, dt))[1]


@exercise.link("three results", "The function must end with `return x2, X_x, X_u`.")
def _(f, rng):
    _, X_x, X_u = _out(f(*_case(rng)))
    expect.true(X_x is not None and X_u is not None, "X_x or X_u is None: return all three results")


@exercise.link("position", "v is in the axes of the world: t2 = t + v dt.", part=0)
def _(f, rng):
    for _ in range(3):
        x, u, dt = _case(rng)
        expect.close(_x2(f(x, u, dt))[:3], x[:3] + dt * x[7:10], "the position", at=f"dt = {dt:.2f} s")


@exercise.link("orientation", "In dt the body turns by the rotation vector w dt, in its own axes: q v2q(w dt).", part=0)
def _(f, rng):
    for _ in range(3):
        x, u, dt = _case(rng)
        expect.close(_turn(f, x, u, dt), _value(x, u, dt)[3:7], "the quaternion", at=f"dt = {dt:.2f} s")
    x, u, dt = _case(rng)
    x[10:] = 0
    expect.close(_turn(f, x, u, dt), x[3:7], "the quaternion", at="w = 0")


@exercise.link("velocities", "They keep their values, plus the impulses of this step.", part=0)
def _(f, rng):
    for _ in range(2):
        x, u, dt = _case(rng)
        got = _x2(f(x, u, dt))
        expect.close(got[7:10], x[7:10] + u[:3], "the velocity v")
        expect.close(got[10:], x[10:] + u[3:], "the turn rate w")


@exercise.link("derivative by the state", "Besides the ones: t2 by v, q2 by q, q2 by w. Where does dt stand?", part=1)
def _(f, rng):
    for _ in range(4):
        x, u, dt = _case(rng)
        X_x = _jacobian(f, x, u, dt, 1, (13, 13), "X_x")
        by_state(X_x, lambda x, u=u, dt=dt: _value(x, u, dt), x, "X_x", STATE, STATE)


@exercise.link(
    "derivative by the impulse", "The impulse comes at the end of the step: it moves v2 and w2 only.", part=2
)
def _(f, rng):
    for _ in range(2):
        x, u, dt = _case(rng)
        X_u = _jacobian(f, x, u, dt, 2, (13, 6), "X_u")
        expect.jacobian(X_u, lambda u, x=x, dt=dt: _value(x, u, dt), u, "X_u", STATE, CONTROL)


def _numerical(f):
    """The answer with the value f and its exact derivatives."""

    def answer(x, u, dt):
        x, u = np.asarray(x, float), np.asarray(u, float)
        by_x, by_u = numerical_jacobian(lambda x: f(x, u, dt), x), numerical_jacobian(lambda u: f(x, u, dt), u)
        return f(x, u, dt), by_x, by_u

    return answer


def _state(t=None, q=None, v=None, w=None):
    """A value function with some of its four parts replaced by others."""

    def f(x, u, dt):
        x2 = _value(x, u, dt)
        for part, place in ((t, slice(0, 3)), (q, slice(3, 7)), (v, slice(7, 10)), (w, slice(10, 13))):
            if part is not None:
                x2[place] = part(x, u, dt)
        return x2

    return f


def _wrong(name, hint, change):
    def answer(x, u, dt):
        return change(np.asarray(x), np.asarray(u), dt, *const_vel(x, u, dt))

    exercise.wrong(name, hint)(answer)


def _put(A, rows, cols, B):
    A = A.copy()
    A[rows, cols] = B
    return A


T, Q, V, W = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)


# fmt: off
exercise.wrong("dt forgotten in the position", "v is in metres per second: t + v dt.")(
    _numerical(_state(t=lambda x, u, dt: x[:3] + x[7:10])))
exercise.wrong("v in the axes of the body", "Here v is in the axes of the world: it is not turned.")(
    _numerical(_state(t=lambda x, u, dt: x[:3] + dt * q2R(x[3:7])[0] @ x[7:10])))
exercise.wrong("impulse used at once", "The impulse comes at the end of the step: the position moves with the old v.")(
    _numerical(_state(t=lambda x, u, dt: x[:3] + dt * (x[7:10] + u[:3]))))
exercise.wrong("impulse of the turn used at once", "The impulse comes at the end of the step: turn with the old w.")(
    _numerical(_state(q=lambda x, u, dt: q_prod(x[3:7], v2q((x[10:] + u[3:]) * dt)[0])[0])))
exercise.wrong("turn in the axes of the world", "w is in the axes of the body: its quaternion stands on the right.")(
    _numerical(_state(q=lambda x, u, dt: q_prod(v2q(x[10:] * dt)[0], x[3:7])[0])))
exercise.wrong("dt forgotten in the turn", "w is in radians per second: v2q(w dt).")(
    _numerical(_state(q=lambda x, u, dt: q_prod(x[3:7], v2q(x[10:])[0])[0])))
exercise.wrong("Euler's step", "q + 1/2 q w dt leaves the unit sphere. The exact turn is q v2q(w dt).")(
    _numerical(_state(q=lambda x, u, dt: x[3:7] + 0.5 * dt * q_prod(x[3:7], np.r_[0, x[10:]])[0])))
exercise.wrong("impulse times dt", "u is a change of the velocity already, in m/s: it is not multiplied by dt.")(
    _numerical(_state(v=lambda x, u, dt: x[7:10] + dt * u[:3], w=lambda x, u, dt: x[10:] + dt * u[3:])))
exercise.wrong("impulses forgotten", "v2 = v + dv and w2 = w + dw.")(
    _numerical(_state(v=lambda x, u, dt: x[7:10], w=lambda x, u, dt: x[10:])))
_wrong("dt forgotten in d(t2)/d(v)", "t2 = t + v dt: its derivative by v is dt I.",
       lambda x, u, dt, x2, X_x, X_u: (x2, _put(X_x, T, V, np.eye(3)), X_u))
_wrong("dt forgotten in d(q2)/d(w)", "The inner derivative: d(w dt)/dw = dt.",
       lambda x, u, dt, x2, X_x, X_u: (x2, _put(X_x, Q, W, X_x[Q, W] / dt), X_u))
_wrong("q2 by w forgotten", "The turn depends on w: X_x[3:7, 10:] is not zero.",
       lambda x, u, dt, x2, X_x, X_u: (x2, _put(X_x, Q, W, 0), X_u))
_wrong("q2 by q is the identity", "q2 = q dq: its derivative by q is Q_q, from q_prod.",
       lambda x, u, dt, x2, X_x, X_u: (x2, _put(X_x, Q, Q, np.eye(4)), X_u))
_wrong("small turn", "DQ_a must be taken at w dt, not at zero.",
       lambda x, u, dt, x2, X_x, X_u: (x2, _put(X_x, Q, W, q_prod(x[Q], v2q(x[W] * dt)[0])[2]
                                                @ v2q(0 * x[W])[1] * dt), X_u))
_wrong("sign of the quaternion changed, but not of its derivatives", "-q turns as q does, but then its derivatives "
       "change their sign, too: rows 3 to 6 of X_x.", lambda x, u, dt, x2, X_x, X_u: (positive(x2)[0], X_x, X_u))
_wrong("X_u in the rows of the frame", "The impulses change v and w: rows 7 to 12.",
       lambda x, u, dt, x2, X_x, X_u: (x2, X_x, np.roll(X_u, -7, axis=0)))
_wrong("dt in X_u", "u is an impulse, not an acceleration: X_u has ones.",
       lambda x, u, dt, x2, X_x, X_u: (x2, X_x, dt * X_u))
# fmt: on


@exercise.variant("the package's model")
def _(x, u, dt):
    return ConstantVelocity().move(x, u, dt)


@exercise.variant("finite differences, as lists")
def _(x, u, dt):
    return tuple(a.tolist() for a in _numerical(_value)(x, u, dt))


@exercise.variant("in blocks, along the sphere")
def _(x, u, dt):
    x2, X_x, _ = const_vel(x, u, dt)
    return x2, X_x @ tangent(x), np.vstack([np.zeros((7, 6)), np.eye(6)])


@exercise.variant("the quaternion with a >= 0")
def _(x, u, dt):
    return positive(*const_vel(x, u, dt))
