"""Exercise 04.1: where a new landmark is, and how it depends on the pose and on the measurement."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def inverse_observation(x_r, y):
    """New landmark from the pose of the robot and a measurement, with both Jacobians.

    x_r = [x, y, theta] is the pose, y = [range, bearing] the measurement.
    Return l, shape (2,), L_r = dl/dx_r, shape (2, 3), and L_y = dl/dy, shape (2, 2).
    """
    r, a = y[0], x_r[2] + y[1]
    c, s = np.cos(a), np.sin(a)
    l = np.array([x_r[0] + r * c, x_r[1] + r * s])
    L_r = np.array([[1, 0, -r * s], [0, 1, r * c]])
    L_y = np.array([[c, -r * s], [s, r * c]])
    return l, L_r, L_y


inverse = Exercise(
    "04.1",
    "A new landmark and its two Jacobians",
    inverse_observation,
    hints=(
        "The beam points in the direction a = theta + beta, seen from the map. All else is made of r, cos(a) and "
        "sin(a).",
        "Move the robot by 1 m: where does the landmark go? Now turn the robot by a small angle: the landmark moves "
        "along a circle of radius r. The same happens when the bearing changes.",
        "L_r = [[1, 0, -r sin(a)], [0, 1, r cos(a)]]. The last column of L_y is the last column of L_r.",
    ),
)

LMK = ("x_l", "y_l")
POSE = ("x_r", "y_r", "theta")
MEASURED = ("range", "bearing")


def pose_and_measurement(rng):
    """Return a pose and a measurement at random."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)]), np.array([rng.uniform(1, 8), rng.uniform(-3, 3)])


def _three(result):
    return expect.results(result, "l", "L_r", "L_y")


@inverse.link("three results", "The function must end with `return l, L_r, L_y`.")
def _(f, rng):
    l, L_r, L_y = _three(f(*pose_and_measurement(rng)))
    expect.array(l, 2, "l")
    expect.true(L_r is not None and L_y is not None, "L_r or L_y is None: return three results")


@inverse.link(
    "the landmark, theta = 0", "A robot that looks along the x axis: l = x_r + r [cos(beta), sin(beta)].", part=0
)
def _(f, rng):
    for _ in range(3):
        x_r, y = pose_and_measurement(rng)
        x_r[2] = 0
        want = x_r[:2] + y[0] * np.array([np.cos(y[1]), np.sin(y[1])])
        expect.close(expect.array(_three(f(x_r, y))[0], 2, "l"), want, "l", at="a robot with theta = 0")


@inverse.link("the landmark", "What does the heading of the robot do to the direction of the beam?", part=0)
def _(f, rng):
    for _ in range(4):
        x_r, y = pose_and_measurement(rng)
        a = x_r[2] + y[1]
        want = x_r[:2] + y[0] * np.array([np.cos(a), np.sin(a)])
        expect.close(expect.array(_three(f(x_r, y))[0], 2, "l"), want, "l")


def _value(x_r, y):
    a = x_r[2] + y[1]
    return np.array([x_r[0] + y[0] * np.cos(a), x_r[1] + y[0] * np.sin(a)])


@inverse.link("L_r", "Differentiate l by the pose: three columns, by x, by y and by theta.", part=1)
def _(f, rng):
    for _ in range(5):
        x_r, y = pose_and_measurement(rng)
        L_r = expect.array(_three(f(x_r, y))[1], (2, 3), "L_r")
        expect.jacobian(L_r, lambda x, y=y: _value(x, y), x_r, "L_r", LMK, POSE)


@inverse.link("L_y", "Differentiate l by the measurement: two columns, by the range and by the bearing.", part=2)
def _(f, rng):
    for _ in range(5):
        x_r, y = pose_and_measurement(rng)
        L_y = expect.array(_three(f(x_r, y))[2], (2, 2), "L_y")
        expect.jacobian(L_y, lambda y, x_r=x_r: _value(x_r, y), y, "L_y", LMK, MEASURED)


def _inverse_wrong(name, hint, l=None, L_r=None, L_y=None):
    """A misconception in one of the three results, as a function of r, beta, theta and the true result."""

    @inverse.wrong(name, hint)
    def _(x_r, y):
        right = inverse_observation(x_r, y)
        changed = [g and np.asarray(g(*y, x_r, right[i])) for i, g in enumerate((l, L_r, L_y))]
        return tuple(right[i] if changed[i] is None else changed[i] for i in range(3))


def _at(x_r, r, a):
    return [x_r[0] + r * np.cos(a), x_r[1] + r * np.sin(a)]


# fmt: off
_inverse_wrong("heading forgotten", "Without theta this is right only for a robot that looks along the x axis: the "
               "beam points in the direction theta + beta.", l=lambda r, b, x, _: _at(x, r, b))
_inverse_wrong("bearing subtracted", "Angles count counter-clockwise: a bearing to the left is added to the heading.",
               l=lambda r, b, x, _: _at(x, r, x[2] - b))
_inverse_wrong("sine and cosine swapped", "cos belongs to x and sin to y.",
               l=lambda r, b, x, _: [x[0] + r * np.sin(x[2] + b), x[1] + r * np.cos(x[2] + b)])
_inverse_wrong("seen from the robot", "That is the landmark in a frame at the robot: add the robot's position.",
               l=lambda r, b, x, _: _at([0, 0], r, x[2] + b))
_inverse_wrong("range subtracted", "The landmark is in front of the sensor: add r in the direction of the beam.",
               l=lambda r, b, x, _: _at(x, -r, x[2] + b))
_inverse_wrong("angles taken as degrees", "Angles are in radians already: no np.radians here.",
               l=lambda r, b, x, _: _at(x, r, np.radians(x[2] + b)))
_inverse_wrong("columns instead of vectors", "Vectors have one axis here: l = np.array([x, y]), no columns.",
               l=lambda r, b, x, l: l[:, None])
_inverse_wrong("the pose is known", "L_r = 0 says: the landmark does not depend on the pose. That was notebook 02; now "
               "the pose is uncertain and its error goes into the landmark.", L_r=lambda r, b, x, _: np.zeros((2, 3)))
_inverse_wrong("turning does not matter", "Turn the robot by a small angle: the landmark swings along a circle of "
               "radius r. The last column of L_r is not zero.", L_r=lambda r, b, x, J: J * [1, 1, 0])
_inverse_wrong("only theta in the last column", "In the last column of L_r, sin and cos are taken of the whole "
               "direction theta + beta.", L_r=lambda r, b, x, J: [[1, 0, -r * np.sin(x[2])], [0, 1, r * np.cos(x[2])]])
_inverse_wrong("only beta in the last column", "In the last column of L_r, sin and cos are taken of the whole "
               "direction theta + beta.", L_r=lambda r, b, x, J: [[1, 0, -r * np.sin(b)], [0, 1, r * np.cos(b)]])
_inverse_wrong("range forgotten in the last column", "A landmark twice as far away swings twice as much: the last "
               "column of L_r has a factor r.", L_r=lambda r, b, x, J: J / [1, 1, r])
_inverse_wrong("sign of the last column", "d cos(a) = -sin(a) da and d sin(a) = +cos(a) da: check the signs in the "
               "last column of L_r.", L_r=lambda r, b, x, J: J * [1, 1, -1])
_inverse_wrong("minus sign forgotten in L_r", "d cos(a) = -sin(a) da: the upper right entry of L_r has a minus sign.",
               L_r=lambda r, b, x, J: J * [[1, 1, -1], [1, 1, 1]])
_inverse_wrong("position block negative", "Move the robot by 1 m: the new landmark moves with it, not against it.",
               L_r=lambda r, b, x, J: J * [-1, -1, 1])
_inverse_wrong("position block turned", "The robot's position is given in the map frame, and so is l: the first two "
               "columns of L_r are the identity.", L_r=lambda r, b, x, J: np.column_stack([_turn(x[2]), J[:, 2]]))
_inverse_wrong("L_r transposed", "Rows are outputs (x_l, y_l), columns are inputs (x, y, theta): L_r is 2 x 3.",
               L_r=lambda r, b, x, J: J.T)
_inverse_wrong("heading column in degrees", "The last column of L_r is in metres per degree: keep to radians.",
               L_r=lambda r, b, x, J: J * [1, 1, np.pi / 180])
_inverse_wrong("L_y transposed", "Rows are outputs (x_l, y_l), columns are inputs (range, bearing): L_y is transposed.",
               L_y=lambda r, b, x, J: J.T)
_inverse_wrong("range forgotten in L_y", "A landmark twice as far away moves twice as much when the bearing changes: "
               "the last column of L_y has a factor r.", L_y=lambda r, b, x, J: J / [1, r])
_inverse_wrong("heading forgotten in L_y", "In L_y, too, sin and cos are taken of the whole direction theta + beta.",
               L_y=lambda r, b, x, J: [[np.cos(b), -r * np.sin(b)], [np.sin(b), r * np.cos(b)]])
_inverse_wrong("sign in L_y", "d cos(a) = -sin(a) da: the upper right entry of L_y has a minus sign.",
               L_y=lambda r, b, x, J: J * [[1, -1], [1, 1]])
_inverse_wrong("columns of L_y swapped", "The order is range, then bearing, in y and in the columns of L_y.",
               L_y=lambda r, b, x, J: J[:, ::-1])
# fmt: on


def _turn(a):
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


@inverse.variant("by the chain rule, with a rotation matrix")
def _(x_r, y):
    R = _turn(x_r[2])
    in_robot = y[0] * np.array([np.cos(y[1]), np.sin(y[1])])
    swing = np.array([[0, -1], [1, 0]])
    L_y = R @ np.column_stack([in_robot / y[0], swing @ in_robot])
    return np.asarray(x_r)[:2] + R @ in_robot, np.hstack([np.eye(2), (R @ swing @ in_robot)[:, None]]), L_y


@inverse.variant("complex numbers, lists")
def _(x_r, y):
    beam = y[0] * np.exp(1j * (x_r[2] + y[1] - 4 * np.pi))
    unit, swing = beam / y[0], 1j * beam
    l = complex(x_r[0], x_r[1]) + beam
    L_y = [[unit.real, swing.real], [unit.imag, swing.imag]]
    return [l.real, l.imag], [[1, 0, swing.real], [0, 1, swing.imag]], L_y


@inverse.variant("finite differences")
def _(x_r, y):
    h = 1e-6
    L_r = [(_value(x_r + d, y) - _value(x_r - d, y)) / (2 * h) for d in h * np.eye(3)]
    L_y = [(_value(x_r, y + d) - _value(x_r, y - d)) / (2 * h) for d in h * np.eye(2)]
    return _value(x_r, y), np.transpose(L_r), np.transpose(L_y)
