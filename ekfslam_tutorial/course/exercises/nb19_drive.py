"""Exercise 19.1: the truck of Victoria Park, and the derivatives of its motion."""

import numpy as np

from ..table import table


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
    x2 = x + dt * k * v * way
    X_x = np.eye(3)
    X_x[:2, 2] = dt * k * v * np.array([-way[1], way[0]])
    X_v = dt * k * way
    T_a = 1 + t**2
    X_alpha = dt * v * T_a * (k**2 * H / L * way + k * around / L)
    return x2, X_x, np.column_stack([X_v, X_alpha])


def case(rng, theta=None, alpha=None):
    """Return a pose, a control, a time and a car."""
    x = np.array([*rng.uniform(-40, 40, 2), rng.uniform(-3, 3) if theta is None else theta])
    u = np.array([rng.uniform(0.5, 6), rng.uniform(-0.5, 0.5) if alpha is None else alpha])
    car = (rng.uniform(2, 4), rng.uniform(0.3, 1), rng.uniform(1, 4), rng.uniform(0.2, 0.8))
    return x, u, rng.uniform(0.05, 0.3), car


def standing(x, u, dt, car):
    """The same truck at rest."""
    return x, u * [0, 1], dt, car


STATE = "x, y, theta"
_right = drive  # in an edit `drive` is the wrong answer itself

truck = table(
    "19.1 A truck and its laser",
    drive,
    hints=(
        "First the velocity of the laser: that of the axle, v_c [cos, sin], plus w times the arm from axle to laser, turned by 90 degrees to the left. Then multiply by dt.",
        "The arm in the map is [a c - b s, a s + b c]; turned by 90 degrees it is [-a s - b c, a c - b s]. For X_u use the chain rule: dv_c/dv = k, dv_c/dalpha = v k^2 (1 + t^2) H / L, with t = tan(alpha), k = 1/(1 - H t / L).",
        "X_x is the identity but for its last column: dt v_c [-s + t/L (-a c + b s), c + t/L (-a s - b c)]. X_u = dt [k way, v (1 + t^2) (k^2 H/L way + k around/L)], with way = velocity / v_c and around = velocity / w of the turn alone.",
    ),
    returns="x, X_x, X_u",
    angles={"x": 2},
    jacobians={"X_x": "x", "X_u": "x"},
    entries={"x": STATE, "u": "v, alpha"},
    cases={
        "any": lambda rng: [case(rng, theta) for theta in (0.0, 0.8, -2.5, 3.0)],
        "straight": lambda rng: [case(rng, theta, 0.0) for theta in (0.0, 1.0, -2.2)],
        "right": lambda rng: [case(rng, alpha=alpha) for alpha in (-0.4, 0.4, -0.1)],
        "control": lambda rng: [case(rng, *c) for c in ((0.0, 0.0), (0.9, 0.3), (-2.0, -0.45), (2.8, None))],
        "turned": lambda rng: [case(rng, theta) for theta in (2 * np.pi + 0.4, -7.0)],
        "standing": lambda rng: [standing(*case(rng, 0.8))],
    },
    checks="""
    straight on   | x         | straight | With alpha = 0 all of the car moves along theta, by v dt, and theta stays.
    turn rate     | x[2:]     | any      | The new heading is theta + w dt, with w = v_c tan(alpha) / L. The speed of the left wheel is v; that of the middle is v_c = v / (1 - H tan(alpha) / L).
    position      | x         | any      | Step = velocity times dt, with theta from before the step. The velocity is v_c along theta, plus w times the arm from axle to laser (a ahead, b to the left), turned by 90 degrees to the left.
    right turn    | x         | right    | tan(alpha) has a sign: a right turn makes the left wheel faster than the middle.
    Jacobian X_x  | d X_x / x | any      | A shift of the start shifts the end by the same. In the last column, above a 1, stands the step, velocity times dt, turned by 90 degrees to the left.
    Jacobian X_u  | d X_u / u | control  | The step by v, then by alpha; both are in v_c and in w. Each term has the sign and the dt that it has in the step.
    a whole turn  | x, X_x | turned   | At theta + 2 pi the truck does the same.
    at rest       | X_u       | standing | A truck that stands has v = 0, and X_u has numbers there, too. Its column of v says what a small speed would do; its column of alpha is zero, as steering moves nothing.
    """,
    wrong="""
    the axle instead of the laser | = u, car -> = u, car; a = b = 0.0 | That is the pose of the rear axle. The laser is a ahead of it and b to the left: add w times the arm, turned by 90 degrees.
    b forgotten | = u, car -> = u, car; b = 0.0 | The laser is not in the middle: b metres to the left.
    a forgotten | = u, car -> = u, car; a = 0.0 | The laser is far ahead of the axle: a metres.
    b to the right | = u, car -> = u, car; b = -b | b counts to the left: the sign of its terms is wrong.
    laser behind the axle | = u, car -> = u, car; a = -a | The laser is ahead of the axle: the signs of the terms with a are wrong.
    a and b exchanged | = u, car -> = u, car; a, b = b, a | a is forward, b to the left.
    wheel speed taken for that of the middle | = u, car -> = u, car; H = 0.0 | The encoder is on the left wheel, which drives another circle: v_c = v / (1 - H tan(alpha) / L).
    wheel on the right | = u, car -> = u, car; H = -H | The encoder is on the left wheel: in a left turn the middle is faster than it, 1 minus H tan(alpha) / L.
    multiplied instead of divided | k = 1 / (1 - H * t / L) -> k = 1 - H * t / L | v = v_c (1 - H tan(alpha) / L), so v_c = v / (...).
    alpha for tan(alpha) | np.tan(alpha) -> alpha | The wheels stand at the angle alpha: w = v_c tan(alpha) / L.
    sin(alpha) for tan(alpha) | np.tan(alpha) -> np.sin(alpha) | w = v_c tan(alpha) / L: the speed is measured at the rear wheel.
    steering to the right | np.tan(alpha) -> np.tan(-alpha) | alpha counts to the left, as theta does.
    steering in degrees | np.tan(alpha) -> np.tan(np.radians(alpha)) | alpha is in radians.
    turn without the car's length | along = np.array([c, s, 0]) -> along = np.array([c, s, t - t / L]) | w = v_c tan(alpha) / L: a long car turns slowly.
    arm not turned by 90 degrees | [-a * s - b * c, a * c - b * s, 1] -> [a * c - b * s, a * s + b * c, 1] | The arm [a c - b s, a s + b c] is a place. Its velocity is w times the arm turned by 90 degrees.
    arm in the frame of the car | [-a * s - b * c, a * c - b * s, 1] -> [-b, a, 1] | The arm turns with the car: in the map it is [a c - b s, a s + b c], and its velocity is w [-a s - b c, a c - b s].
    sine and cosine exchanged | c, s, t = np.cos(x[2]), np.sin(x[2]) -> c, s, t = np.sin(x[2]), np.cos(x[2]) | theta = 0 points along x: velocity v_c [cos(theta), sin(theta)].
    at v_c, turn at v | x + dt * k * v * way -> x + dt * v * (k * along + around * t / L) | w is that of the middle: v_c tan(alpha) / L, not v tan(alpha) / L.
    heading after the turn | c, s, t = np.cos(x[2]), np.sin(x[2]) -> x = x + [0, 0, dt * v / (1 - H * np.tan(alpha) / L) * np.tan(alpha) / L]; c, s, t = np.cos(x[2]), np.sin(x[2]) | The velocity is that at the start of the step: cos and sin of theta, not of theta + w dt.
        x2 = x + -> x2 = x - [0, 0, dt * k * v * t / L] +
    not multiplied by dt | x + dt * k * v * way -> x + k * v * way | Step = velocity times dt.
    X_x after the move | return x2, X_x -> return x2, _right(x2, u, dt, car)[1] | Linearise at the pose before the step: theta, not theta + w dt.
    X_x of the axle | [-way[1], way[0]] -> [-s, c] | The arm turns with theta, too: the last column is dt times the whole velocity of the laser, turned by 90 degrees.
    X_x without the identity | X_x = np.eye(3) -> X_x = np.zeros((3, 3)) | The new pose is the old one plus a step: X_x = I + ...
    X_x is the identity | X_x[:2, 2] = dt -> X_x[:2, 2] = 0 * dt | Turn the start by a bit, and the whole step turns: the last column is not zero.
    X_x with the wrong sign | [-way[1], way[0]] -> [way[1], -way[0]] | d cos = -sin, d sin = +cos: the last column is [-step_y, step_x].
    X_x transposed | return x2, X_x -> return x2, X_x.T | Rows are outputs, columns are inputs: X_x[0, 2] = dx/dtheta.
    X_u without dt | np.column_stack([X_v, X_alpha]) -> np.column_stack([X_v, X_alpha]) / dt | The step is velocity times dt, and so is its derivative.
    dv_c/dalpha forgotten | k**2 * H / L * way + k -> k | alpha changes v_c, too: dv_c/dalpha = v (1 + tan^2) (H / L) / (1 - H tan / L)^2, with tan = tan(alpha).
    X_u of the axle | X_v = dt -> around = np.array([0, 0, 1]); way = along + around * t / L; X_v = dt | While it turns, the laser goes sideways: v and alpha act on that, too.
    divided by v | X_v = dt * k * way -> X_v = dt * k * v * way / v | At rest, with v = 0, that is 0 / 0. The speed is a factor of the step: its derivative by v is the step without v.
    derivative of tan forgotten | T_a = 1 + t**2 -> T_a = 1 | d tan(alpha) / d alpha = 1 + tan(alpha)^2.
    X_u by v_c | X_v = dt * k * way -> X_v = dt * way | The control is the wheel's speed: dv_c/dv = 1 / (1 - H tan(alpha) / L).
    X_u after the move | np.column_stack([X_v, X_alpha]) -> _right(x2, u, dt, car)[2] | Linearise at the pose before the step.
    columns of X_u exchanged | [X_v, X_alpha] -> [X_alpha, X_v] | The control is [v, alpha], in this order.
    sign of b in the y row of X_u | X_v = dt -> around = np.array([-a * s - b * c, a * c + b * s, 1]); way = along + around * t / L; X_v = dt | In X_u the arm is that of the step, turned by 90 degrees: [-a s - b c, a c - b s]. In the row of y, b has the other sign.
    sign of b in the x row of X_u | X_v = dt -> around = np.array([-a * s + b * c, a * c - b * s, 1]); way = along + around * t / L; X_v = dt | In X_u the arm is that of the step, turned by 90 degrees: [-a s - b c, a c - b s]. In the row of x, b has the other sign.
    X_x without dt | X_x[:2, 2] = dt * k -> X_x[:2, 2] = k | The step is velocity times dt, and so is its derivative by theta.
    X_x without dt in the y row | [-way[1], way[0]] -> [-way[1], way[0] / dt] | The step is velocity times dt, and so is its derivative by theta: in the row of y, too.
    heading by v forgotten in X_u | X_v = dt * k * way -> X_v = dt * k * way * [1, 1, 0] | The turn rate goes with the speed, w = v_c tan(alpha) / L: the last row of X_u is not zero in the column of v.
    X_u by v_c and w: The control is [v, alpha], what is measured, and not [v_c, w]: the chain rule brings one to the other.
        np.column_stack([X_v, X_alpha]) -> dt * np.column_stack([along, around])
    """,
)
