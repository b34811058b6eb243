"""Exercise 19.1: the truck of Victoria Park, and the derivatives of its motion."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def drive(x, u, dt, car):
    """One small step of a car whose laser is estimated, not its axle.

    x, shape (3,): pose [x, y, theta] of the laser. u, shape (2,): [v, alpha], the speed of the rear left wheel, m/s,
    and the steering, rad. dt: s. car: (L, H, a, b), m: from axle to axle; from the middle of the rear axle to its left
    wheel; from the middle of the rear axle to the laser, a forward and b to the left.
    The middle of the rear axle has the speed v_c = v / (1 - H tan(alpha) / L) and turns by w = v_c tan(alpha) / L.
    Its velocity is along theta; that of the laser, a and b away, has the turn in it, too. Step = velocity times dt.
    Return the new pose, shape (3,), and its Jacobians X_x, shape (3, 3), and X_u, shape (3, 2).
    """
    (v, alpha), (L, H, a, b) = u, car
    c, s, t = np.cos(x[2]), np.sin(x[2]), np.tan(alpha)
    k = 1 / (1 - H * t / L)
    along = np.array([c, s, 0])  # velocity of the laser for v_c = 1 and w = 0
    around = np.array([-a * s - b * c, a * c - b * s, 1])  # for v_c = 0 and w = 1
    way = along + around * t / L
    T_a = 1 + t**2
    X_x = np.eye(3)
    X_x[:2, 2] = dt * k * v * np.array([-way[1], way[0]])
    X_v = dt * k * way
    X_alpha = dt * v * T_a * (k**2 * H / L * way + k * around / L)
    return x + dt * k * v * way, X_x, np.column_stack([X_v, X_alpha])


truck = Exercise(
    "19.1",
    "A truck and its laser",
    drive,
    hints=(
        "First the velocity of the laser: that of the axle, v_c [cos, sin], plus w times the arm from axle to laser, "
        "turned by 90 degrees to the left. Then multiply by dt.",
        "The arm in the map is [a c - b s, a s + b c]; turned by 90 degrees it is [-a s - b c, a c - b s]. For X_u use "
        "the chain rule: dv_c/dv = k, dv_c/dalpha = v k^2 (1 + t^2) H / L, with t = tan(alpha), k = 1/(1 - H t / L).",
        "X_x is the identity but for its last column: dt v_c [-s + t/L (-a c + b s), c + t/L (-a s - b c)]. "
        "X_u = dt [k way, v (1 + t^2) (k^2 H/L way + k around/L)], with way = velocity / v_c and around = velocity / w "
        "of the turn alone.",
    ),
)

CAR = (2.83, 0.76, 3.78, 0.5)
ROWS, STATE, CONTROL = ("x", "y", "theta"), ("x", "y", "theta"), ("v", "alpha")


def case(rng, theta=None, alpha=None):
    """Return a pose, a control, a time and a car."""
    x = np.array([*rng.uniform(-50, 50, 2), rng.uniform(-3, 3) if theta is None else theta])
    u = np.array([rng.uniform(0.5, 6), rng.uniform(-0.5, 0.5) if alpha is None else alpha])
    car = (rng.uniform(2, 4), rng.uniform(0.3, 1), rng.uniform(1, 4), rng.uniform(0.2, 0.8))
    return x, u, rng.uniform(0.05, 0.3), car


def _three(result):
    x, X_x, X_u = expect.results(result, "x", "X_x", "X_u")
    return expect.array(x, 3, "x"), expect.array(X_x, (3, 3), "X_x"), expect.array(X_u, (3, 2), "X_u")


def _step(x, u, dt, car):
    return drive(np.asarray(x, float), np.asarray(u, float), dt, car)[0]


@truck.link("three results", "The function must end with `return x, X_x, X_u`.")
def _(f, rng):
    _three(f(*case(rng)))


@truck.link("straight on", "With alpha = 0 all of the car moves along theta.", part=0)
def _(f, rng):
    for theta in (0.0, 1.0, -2.2):
        args = case(rng, theta, 0.0)
        expect.close(_three(f(*args))[0], _step(*args), "x", at=f"alpha = 0 and theta = {theta}")


@truck.link("turn rate", "w = v_c tan(alpha) / L, with v_c from the speed of the left wheel.", part=0)
def _(f, rng):
    for _ in range(4):
        args = case(rng)
        got, want = _three(f(*args))[0][2], _step(*args)[2]
        expect.close(got, want, "theta", 1e-7, 1e-9, at=f"alpha = {args[1][1]:.2f}")


@truck.link(
    "position",
    "The laser is a metres ahead of the axle and b to the left: while the car turns, it goes sideways.",
    part=0,
)
def _(f, rng):
    for theta in (0.0, 0.8, -2.5, 3.0):
        args = case(rng, theta)
        expect.close(
            _three(f(*args))[0], _step(*args), "x", 1e-8, 1e-9, at=f"theta = {theta}, alpha = {args[1][1]:.2f}"
        )


@truck.link("right turn", "tan(alpha) has a sign: a right turn makes the left wheel faster than the middle.", part=0)
def _(f, rng):
    for alpha in (-0.4, 0.4):
        args = case(rng, alpha=alpha)
        expect.close(_three(f(*args))[0], _step(*args), "x", 1e-8, 1e-9, at=f"alpha = {alpha}")


@truck.link("Jacobian X_x", "Only theta matters: a shift of the start shifts the end. The last column is the velocity "
            "turned by 90 degrees.", part=1)  # fmt: skip
def _(f, rng):
    for theta in (0.0, 0.9, -2.0, 2.8):
        x, u, dt, car = case(rng, theta)
        J = _three(f(x, u, dt, car))[1]
        expect.jacobian(J, lambda p, u=u, dt=dt, car=car: _step(p, u, dt, car), x, "X_x", ROWS, STATE)


@truck.link("Jacobian X_u", "Both v and alpha are in v_c and in w: chain rule.", part=2)
def _(f, rng):
    for theta, alpha in ((0.0, 0.0), (0.9, 0.3), (-2.0, -0.45), (2.8, None)):
        x, u, dt, car = case(rng, theta, alpha)
        J = _three(f(x, u, dt, car))[2]
        expect.jacobian(J, lambda p, x=x, dt=dt, car=car: _step(x, p, dt, car), u, "X_u", ROWS, CONTROL)


@truck.link("a whole turn", "At theta + 2 pi the truck does the same.")
def _(f, rng):
    x, u, dt, car = case(rng)
    one, two = _three(f(x, u, dt, car)), _three(f(x + [0, 0, 2 * np.pi], u, dt, car))
    expect.close(two[0][:2], one[0][:2], "x, one turn later", 1e-7)
    expect.close(two[1], one[1], "X_x, one turn later", 1e-7)


def _other(name, hint, car=None, u=None, x=None):
    """A misconception in value and Jacobians alike: another car, control, or step."""

    @truck.wrong(name, hint)
    def _(x_, u_, dt, car_):
        return drive(x_, u(u_, car_) if u else u_, dt, car(*car_) if car else car_)


def _value(name, hint, way):
    """A misconception in the velocity (3,) = way(v, t, k, c, s, L, H, a, b); the Jacobians are right."""

    @truck.wrong(name, hint)
    def _(x, u, dt, car):
        t, (L, H, a, b) = np.tan(u[1]), car
        c, s = np.cos(x[2]), np.sin(x[2])
        velocity = np.array(way(u[0], t, 1 / (1 - H * t / L), c, s, L, H, a, b))
        return x + dt * velocity, *drive(x, u, dt, car)[1:]


def _jacobian(name, hint, X_x=None, X_u=None):
    """A misconception in a Jacobian: X_x(X_x, x, u, dt, car), X_u likewise."""

    @truck.wrong(name, hint)
    def _(x, u, dt, car):
        y, A, B = drive(x, u, dt, car)
        return y, X_x(A, x, u, dt, car) if X_x else A, X_u(B, x, u, dt, car) if X_u else B


def _moved(x, u, dt, car):
    return drive(drive(x, u, dt, car)[0], u, dt, car)


def _without_vc(X_u, x, u, dt, car):
    """dv_c/dalpha forgotten."""
    (v, alpha), (L, H, a, b) = u, car
    c, s, t = np.cos(x[2]), np.sin(x[2]), np.tan(alpha)
    around = np.array([-a * s - b * c, a * c - b * s, 1])
    return np.column_stack([X_u[:, 0], dt * v / (1 - H * t / L) * (1 + t**2) * around / L])


# fmt: off
_other("the axle instead of the laser", "That is the pose of the rear axle. The laser is a ahead of it and b to the "
       "left: "
       "add w times the arm, turned by 90 degrees.", car=lambda L, H, a, b: (L, H, 0.0, 0.0))
_other("b forgotten", "The laser is not in the middle: b metres to the left.", car=lambda L, H, a, b: (L, H, a, 0.0))
_other("a forgotten", "The laser is far ahead of the axle: a metres.", car=lambda L, H, a, b: (L, H, 0.0, b))
_other("b to the right", "b counts to the left: the sign of its terms is wrong.", car=lambda L, H, a, b: (L, H, a, -b))
_other("laser behind the axle", "The laser is ahead of the axle: the signs of the terms with a are wrong.",
       car=lambda L, H, a, b: (L, H, -a, b))
_other("a and b exchanged", "a is forward, b to the left.", car=lambda L, H, a, b: (L, H, b, a))
_other("wheel speed taken for that of the middle", "The encoder is on the left wheel, which drives another circle: "
       "v_c = v / (1 - H tan(alpha) / L).", car=lambda L, H, a, b: (L, 0.0, a, b))
_other("wheel on the right", "The encoder is on the left wheel: in a left turn the middle is faster than it, 1 minus "
       "H tan(alpha) / L.", car=lambda L, H, a, b: (L, -H, a, b))
_other("multiplied instead of divided", "v = v_c (1 - H tan(alpha) / L), so v_c = v / (...).",
       u=lambda u, car: np.array([u[0] * (1 - car[1] * np.tan(u[1]) / car[0]) ** 2, u[1]]))
_other("alpha for tan(alpha)", "The wheels stand at the angle alpha: w = v_c tan(alpha) / L.",
       u=lambda u, car: np.array([u[0], np.arctan(u[1])]))
_other("sin(alpha) for tan(alpha)", "w = v_c tan(alpha) / L: the speed is measured at the rear wheel.",
       u=lambda u, car: np.array([u[0], np.arctan(np.sin(u[1]))]))
_other("steering to the right", "alpha counts to the left, as theta does.", u=lambda u, car: u * [1, -1])
_other("steering in degrees", "alpha is in radians.", u=lambda u, car: np.array([u[0], np.radians(u[1])]))
_value("turn without the car's length", "w = v_c tan(alpha) / L: a long car turns slowly.",
       lambda v, t, k, c, s, L, H, a, b:
       k * v * np.array([c - t / L * (a * s + b * c), s + t / L * (a * c - b * s), t]))
_value("arm not turned by 90 degrees", "The arm [a c - b s, a s + b c] is a place. Its velocity is w times the arm "
       "turned "
       "by 90 degrees.",
       lambda v, t, k, c, s, L, H, a, b:
       k * v * np.array([c + t / L * (a * c - b * s), s + t / L * (a * s + b * c), t / L]))
_value("arm in the frame of the car", "The arm turns with the car: [a c - b s, a s + b c] in the map.",
       lambda v, t, k, c, s, L, H, a, b: k * v * np.array([c - t / L * b, s + t / L * a, t / L]))
_value("sine and cosine exchanged", "theta = 0 points along x: velocity v_c [cos(theta), sin(theta)].",
       lambda v, t, k, c, s, L, H, a, b:
       k * v * np.array([s - t / L * (a * c + b * s), c + t / L * (a * s - b * c), t / L]))
_value("at v_c, turn at v", "w is that of the middle: v_c tan(alpha) / L, not v tan(alpha) / L.",
       lambda v, t, k, c, s, L, H, a, b:
       v * np.array([k * c - t / L * (a * s + b * c), k * s + t / L * (a * c - b * s), t / L]))
_jacobian("X_x after the move", "Linearise at the pose before the step: theta, not theta + w dt.",
          X_x=lambda A, x, u, dt, car: _moved(x, u, dt, car)[1])
_jacobian("X_x of the axle", "The arm turns with theta, too: the last column is dt times the whole velocity of the "
       "laser, "
          "turned by 90 degrees.", X_x=lambda A, x, u, dt, car: drive(x, u, dt, (*car[:2], 0.0, 0.0))[1])
_jacobian("X_x without the identity", "The new pose is the old one plus a step: X_x = I + ...",
          X_x=lambda A, x, u, dt, car: A - np.eye(3))
_jacobian("X_x is the identity", "Turn the start by a bit, and the whole step turns: the last column is not zero.",
          X_x=lambda A, x, u, dt, car: np.eye(3))
_jacobian("X_x with the wrong sign", "d cos = -sin, d sin = +cos: the last column is [-step_y, step_x].",
          X_x=lambda A, x, u, dt, car: 2 * np.eye(3) - A)
_jacobian("X_x transposed", "Rows are outputs, columns are inputs: X_x[0, 2] = dx/dtheta.",
          X_x=lambda A, x, u, dt, car: A.T)
_jacobian("X_u without dt", "The step is velocity times dt, and so is its derivative.",
          X_u=lambda B, x, u, dt, car: B / dt)
_jacobian("dv_c/dalpha forgotten", "alpha changes v_c, too: dv_c/dalpha = v k^2 (1 + tan^2) H / L.", X_u=_without_vc)
_jacobian("X_u of the axle", "While it turns, the laser goes sideways: v and alpha act on that, too.",
          X_u=lambda B, x, u, dt, car: drive(x, u, dt, (*car[:2], 0.0, 0.0))[2])
_jacobian("derivative of tan forgotten", "d tan(alpha) / d alpha = 1 + tan(alpha)^2.",
          X_u=lambda B, x, u, dt, car: B / [1, 1 + np.tan(u[1]) ** 2])
_jacobian("X_u by v_c", "The control is the wheel's speed: dv_c/dv = 1 / (1 - H tan(alpha) / L).",
          X_u=lambda B, x, u, dt, car: B * [1 - car[1] * np.tan(u[1]) / car[0], 1])
_jacobian("X_u after the move", "Linearise at the pose before the step.",
          X_u=lambda B, x, u, dt, car: _moved(x, u, dt, car)[2])
_jacobian("columns of X_u exchanged", "The control is [v, alpha], in this order.",
          X_u=lambda B, x, u, dt, car: B[:, ::-1])
# fmt: on


@truck.variant("equation by equation, lists")
def _(x, u, dt, car):
    from math import cos, sin, tan

    (v, al), (L, H, a, b) = u, car
    c, s, t = cos(x[2]), sin(x[2]), tan(al)
    vc = v / (1 - t * H / L)
    y = [
        x[0] + dt * vc * (c - t / L * (a * s + b * c)),
        x[1] + dt * vc * (s + t / L * (a * c - b * s)),
        x[2] + dt * vc / L * t,
    ]
    A = [
        [1, 0, -dt * vc * (s + t / L * (a * c - b * s))],
        [0, 1, dt * vc * (c - t / L * (a * s + b * c))],
        [0, 0, 1],
    ]
    T, V = 1 / cos(al) ** 2, vc / (1 - t * H / L) / cos(al) ** 2 * H / L
    B = [
        [
            dt / (1 - t * H / L) * (c - t / L * (a * s + b * c)),
            dt * (V * (c - t / L * (a * s + b * c)) - vc * T / L * (a * s + b * c)),
        ],
        [
            dt / (1 - t * H / L) * (s + t / L * (a * c - b * s)),
            dt * (V * (s + t / L * (a * c - b * s)) + vc * T / L * (a * c - b * s)),
        ],
        [dt / (1 - t * H / L) * t / L, dt * (V * t + vc * T) / L],
    ]
    return y, A, B


@truck.variant("by the chain rule through [v_c, w]")
def _(x, u, dt, car):
    (v, alpha), (L, H, a, b) = u, car
    t = np.tan(alpha)
    k, T = L / (L - H * t), 1 + t * t
    C_u = np.array([[k, v * k * k * T * H / L], [k * t / L, v * T / L * (k * k * t * H / L + k)]])
    turn = np.array([[np.cos(x[2]), -np.sin(x[2]), 0], [np.sin(x[2]), np.cos(x[2]), 0], [0, 0, 1]])
    V_c = turn @ np.array([[1.0, -b], [0.0, a], [0.0, 1.0]])
    step = dt * V_c @ np.array([k * v, k * v * t / L])
    X_x = np.eye(3) + np.outer([-step[1], step[0], 0], [0, 0, 1])
    return x + step, X_x, dt * V_c @ C_u


@truck.variant("complex numbers, numerical Jacobians")
def _(x, u, dt, car):
    from ...geometry import numerical_jacobian

    def f(p, q):
        L, H, a, b = car
        t = np.tan(q[1])
        vc = q[0] / (1 - H * t / L)
        w = vc * t / L
        d = (vc + 1j * w * complex(a, b)) * np.exp(1j * p[2]) * dt
        return np.array([p[0] + d.real, p[1] + d.imag, p[2] + w * dt])

    x, u = np.asarray(x, float), np.asarray(u, float)
    return f(x, u), numerical_jacobian(lambda p: f(p, u), x), numerical_jacobian(lambda q: f(x, q), u)
