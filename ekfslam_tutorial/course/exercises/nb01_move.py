"""Exercise 01.2: the motion of the robot and its two Jacobians."""

import numpy as np

from ...geometry import wrap
from ...models.motion import Unicycle
from .. import expect
from ..exercise import Exercise


def move(x, u, dt):
    """One step of the robot, and its derivatives by the pose and by the control.

    x = [x, y, theta] is the pose before the step, u = [v, w] the speed (m/s) and the turn rate (rad/s), dt the
    duration (s). The robot drives v dt straight ahead, the way it looks before the step; then it turns by w dt.
    Return the new pose x2, shape (3,), F_x = dx2/dx, shape (3, 3), and F_u = dx2/du, shape (3, 2).
    """
    d, c, s = u[0] * dt, np.cos(x[2]), np.sin(x[2])
    x2 = np.array([x[0] + d * c, x[1] + d * s, x[2] + u[1] * dt])
    F_x = np.array([[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]])
    F_u = np.array([[dt * c, 0], [dt * s, 0], [0, dt]])
    return x2, F_x, F_u


def _heading_wrapped(result):
    x2, F_x, F_u = result
    x2 = np.array(x2, float)
    x2[2] = wrap(x2[2])
    return x2, F_x, F_u


motion = Exercise(
    "01.2",
    "The motion and its Jacobians",
    move,
    canonical=_heading_wrapped,
    hints=(
        "Write the three lines of x2 on paper first. Then differentiate each line by x, y, theta, and by v, w.",
        "x2 = [x + v dt cos(theta), y + v dt sin(theta), theta + w dt], with the theta *before* the step. The third "
        "column of F_x holds the derivatives by theta.",
        "F_x = [[1, 0, -d s], [0, 1, d c], [0, 0, 1]] with d = v dt; F_u = [[dt c, 0], [dt s, 0], [0, dt]].",
    ),
)

POSE, CONTROL = ("x", "y", "theta"), ("v", "w")


def _case(rng):
    return (
        np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)]),
        rng.uniform([0.3, 0.4], [2, 1.5]),
        rng.uniform(0.2, 2),
    )


def _parts(f, x, u, dt):
    x2, F_x, F_u = expect.results(f(x, u, dt), "x2", "F_x", "F_u")
    return expect.array(x2, 3, "x2"), expect.array(F_x, (3, 3), "F_x"), expect.array(F_u, (3, 2), "F_u")


def _f(x, u, dt):
    """The motion alone."""
    return np.array([x[0] + u[0] * dt * np.cos(x[2]), x[1] + u[0] * dt * np.sin(x[2]), x[2] + u[1] * dt])


@motion.link("three results", "The function must end with `return x2, F_x, F_u`.")
def _(f, rng):
    _parts(f, *_case(rng))


def _pose(f, x, u, dt, at=""):
    x2, want = _parts(f, x, u, dt)[0], _f(x, u, dt)
    expect.close(x2[:2], want[:2], "the new position", at=at)
    expect.angle(x2[2], want[2], "the new heading", at=at)


@motion.link("the new heading", "theta + w dt: where w is positive, the robot turns to the left.", part=0)
def _(f, rng):
    for k in range(4):
        x, u, dt = _case(rng)
        expect.angle(_parts(f, x, u if k < 2 else -u, dt)[0][2], _f(x, u if k < 2 else -u, dt)[2], "the new heading")


@motion.link("straight along x", "With theta = 0 and w = 0 the robot goes v dt along x, and nothing else.", part=0)
def _(f, rng):
    for v, dt in ((1.0, 1.0), (2.0, 0.5), (1.5, 0.1)):
        _pose(f, np.array([1.0, 2.0, 0.0]), np.array([v, 0.0]), dt, f"theta = 0, v = {v}, w = 0, dt = {dt}")


@motion.link("the new pose", "The robot drives the way it looks: cos(theta) goes with x, sin(theta) with y.", part=0)
def _(f, rng):
    for k in range(6):
        x, u, dt = _case(rng)
        _pose(f, x, u if k < 3 else -u, dt)


@motion.link("F_x", "Differentiate each line of x2 by x, by y, and by theta.", part=1)
def _(f, rng):
    for k in range(6):
        x, u, dt = _case(rng)
        u = u * [1, -1] if k % 2 else u
        F_x = _parts(f, x, u, dt)[1]
        expect.jacobian(F_x, lambda x, u=u, dt=dt: _f(x, u, dt), x, "F_x", POSE, POSE)


@motion.link("F_u", "Differentiate each line of x2 by v and by w.", part=2)
def _(f, rng):
    for k in range(6):
        x, u, dt = _case(rng)
        u = u * [1, -1] if k % 2 else u
        F_u = _parts(f, x, u, dt)[2]
        expect.jacobian(F_u, lambda u, x=x, dt=dt: _f(x, u, dt), u, "F_u", POSE, CONTROL)


@motion.link("special cases", "No division by v, w or dt is needed: the robot may also stand still, or drive back.")
def _(f, rng):
    for u in ([0.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 30.0]):
        for dt in (1.0, 0.05):
            x, u = _case(rng)[0], np.array(u)
            _pose(f, x, u, dt, f"u = {u}, dt = {dt}")
            for got, want, name in zip(_parts(f, x, u, dt)[1:], move(x, u, dt)[1:], ("F_x", "F_u"), strict=True):
                expect.close(got, want, name, at=f"u = {u}, dt = {dt}")


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def _wrong(name, hint, x2=None, F_x=None, F_u=None):
    """A misconception in one result; each is a function of (x, u, dt)."""

    @motion.wrong(name, hint)
    def _(x, u, dt):
        right = move(x, u, dt)
        return tuple(np.array(g(x, u, dt)) if g else r for g, r in zip((x2, F_x, F_u), right, strict=True))


def _after(x, u, dt):
    """The pose with the heading after the turn."""
    return np.array([x[0], x[1], x[2] + u[1] * dt])


# fmt: off
_wrong("sine and cosine swapped", "x goes with the cosine, y with the sine.",
       x2=lambda x, u, dt: [x[0] + u[0] * dt * np.sin(x[2]), x[1] + u[0] * dt * np.cos(x[2]), x[2] + u[1] * dt])
_wrong("turned first", "The robot drives first, the way it looks *before* the step, and then turns.",
       x2=lambda x, u, dt: [*_f(_after(x, u, dt), u, dt)[:2], x[2] + u[1] * dt])
_wrong("half the turn first", "The robot drives the way it looks *before* the step, not in the middle of the turn.",
       x2=lambda x, u, dt: [*_f([x[0], x[1], x[2] + u[1] * dt / 2], u, dt)[:2], x[2] + u[1] * dt])
_wrong("arc", "Yours is the exact arc. Here the robot drives v dt straight ahead first, and then it turns.",
       x2=lambda x, u, dt: Unicycle().move(x, u, dt)[0])
_wrong("turned to the other side", "A positive w turns to the left: theta *plus* w dt.",
       x2=lambda x, u, dt: [*_f(x, u, dt)[:2], x[2] - u[1] * dt])
_wrong("dt forgotten", "v and w are per second: multiply both by dt.",
       x2=lambda x, u, dt: _f(x, u, 1.0))
_wrong("heading not used", "The robot drives the way it looks: v dt along x is right for theta = 0 only.",
       x2=lambda x, u, dt: [x[0] + u[0] * dt, x[1], x[2] + u[1] * dt])
_wrong("dt forgotten in the turn", "w is in rad per second: the heading grows by w dt.",
       x2=lambda x, u, dt: [*_f(x, u, dt)[:2], x[2] + u[1]])
_wrong("degrees", "The heading is in radians already: no conversion.",
       x2=lambda x, u, dt: _f([x[0], x[1], np.radians(x[2])], u, dt) * [1, 1, 0] + [0, 0, x[2] + u[1] * dt])
_wrong("F_x after the move", "You used the heading *after* the step in F_x. Differentiate at the pose before it.",
       F_x=lambda x, u, dt: move(_after(x, u, dt), u, dt)[1])
_wrong("F_x transposed", "Rows are outputs, columns are inputs: yours is the transpose.",
       F_x=lambda x, u, dt: move(x, u, dt)[1].T)
_wrong("F_x is the identity", "A small error of the heading moves the robot sideways by v dt: F_x has a third column.",
       F_x=lambda x, u, dt: np.eye(3))
_wrong("sign of the sine", "The derivative of the cosine is *minus* the sine.",
       F_x=lambda x, u, dt: move(x, u, dt)[1] * [[1, 1, -1], [1, 1, 1], [1, 1, 1]])
_wrong("derivative of the sine with a minus", "The derivative of the sine is the cosine, with a plus.",
       F_x=lambda x, u, dt: move(x, u, dt)[1] * [[1, 1, 1], [1, 1, -1], [1, 1, 1]])
_wrong("sine and cosine not differentiated", "The third column of F_x is the derivative by theta: cos becomes -sin, "
       "sin becomes cos.", F_x=lambda x, u, dt: [[1, 0, u[0] * dt * np.cos(x[2])], [0, 1, u[0] * dt * np.sin(x[2])],
                                             [0, 0, 1]])
_wrong("diagonal of F_x forgotten", "x2 = x + ...: the derivative of x2 by x is 1. The diagonal of F_x is 1, 1, 1.",
       F_x=lambda x, u, dt: move(x, u, dt)[1] - np.eye(3))
_wrong("dt forgotten in F_x", "The third column of F_x is the derivative by theta: v dt, not v, times -sin and cos.",
       F_x=lambda x, u, dt: move(x, u, 1.0)[1])
_wrong("F_u after the move", "You used the heading *after* the step in F_u. Differentiate at the pose before it.",
       F_u=lambda x, u, dt: move(_after(x, u, dt), u, dt)[2])
_wrong("dt forgotten in F_u", "x2 holds v dt and w dt: their derivatives by v and w have the factor dt.",
       F_u=lambda x, u, dt: move(x, u, 1.0)[2])
_wrong("columns of F_u swapped", "u = [v, w]: the first column is the derivative by v.",
       F_u=lambda x, u, dt: move(x, u, dt)[2][:, ::-1])
_wrong("v in F_u", "The derivative of v dt cos(theta) by v is dt cos(theta): v itself is gone.",
       F_u=lambda x, u, dt: move(x, u, dt)[2] * [u[0], u[1]])
_wrong("sine and cosine swapped in F_u", "By v, the line of x becomes dt cos(theta), the line of y dt sin(theta).",
       F_u=lambda x, u, dt: [[dt * np.sin(x[2]), 0], [dt * np.cos(x[2]), 0], [0, dt]])
_wrong("F_u transposed", "Rows are outputs, columns are inputs: F_u has shape (3, 2).",
       F_u=lambda x, u, dt: move(x, u, dt)[2].T)
_wrong("column instead of vector", "Vectors have one axis here: x2 has shape (3,), no columns.",
       x2=lambda x, u, dt: _f(x, u, dt)[:, None])
# fmt: on


@motion.variant("lists, heading with a turn more")
def _(x, u, dt):
    x2, F_x, F_u = move(x, u, dt)
    return [x2[0], x2[1], x2[2] + 2 * np.pi], F_x.tolist(), F_u.tolist()


@motion.variant("heading wrapped, Jacobians filled entry by entry")
def _(x, u, dt):
    v, w = u
    F_x, F_u = np.eye(3), np.zeros((3, 2))
    F_x[0, 2], F_x[1, 2] = -v * dt * np.sin(x[2]), v * dt * np.cos(x[2])
    F_u[0, 0], F_u[1, 0], F_u[2, 1] = dt * np.cos(x[2]), dt * np.sin(x[2]), dt
    x2 = x + F_u @ u
    return np.array([x2[0], x2[1], np.arctan2(np.sin(x2[2]), np.cos(x2[2]))]), F_x, F_u


@motion.variant("finite differences")
def _(x, u, dt):
    from ...geometry import numerical_jacobian

    return _f(x, u, dt), numerical_jacobian(lambda a: _f(a, u, dt), x), numerical_jacobian(lambda a: _f(x, a, dt), u)
