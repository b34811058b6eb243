"""Exercises of notebook 02, first half: what is in the map, the functions h and q and their Jacobians."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from ..quiz import Quiz

# ---- 02.1 the questions of the slides --------------------------------------------------------------------

quiz = Quiz(
    "02.1",
    "The map and its covariance",
    hints=(
        "Write the covariance of two landmarks on paper, all 16 entries, with their names.",
        "The shapes follow from the products: the gain K turns an innovation (2 numbers) into a change of x.",
        "P is 2n x 2n. H is the derivative of 2 numbers by 2n numbers. Z = H P H' + R, and K = P H' inv(Z).",
    ),
)
quiz.ask(
    "symmetric",
    True,
    "is P symmetric?  True / False",
    "Compare cov(a, b) with cov(b, a).",
    {False: "cov(a, b) = cov(b, a), so P = P'. Only a block of two *different* landmarks need not be symmetric."},
)
quiz.ask(
    "block_ii",
    "b",
    "block P_ij for i == j?  a: zero  b: covariance of landmark i  c: identity  d: cross-correlation",
    "Put i = j into the block with the entries cov(x_i, x_j), cov(x_i, y_j) ...",
    {
        "a": "cov(x_i, x_i) is the variance of x_i: zero only if the landmark is known exactly.",
        "c": "The identity would say: 1 m^2 of variance for each landmark, whatever was measured.",
        "d": "A *cross*-correlation is between two landmarks; here there is only one.",
    },
)
quiz.ask(
    "f",
    "c",
    "the motion function f(x)?  a: zero  b: x + robot step  c: x itself",
    "The state holds landmarks only. What do they do between two steps?",
    {
        "a": "f(x) = 0 would move every landmark to the origin.",
        "b": "The robot moves, but the robot is not in the state. The landmarks stand still.",
    },
)
quiz.ask(
    "jacobian_of_f",
    "c",
    "its Jacobian with respect to x?  a: zero  b: there is none  c: identity",
    "Differentiate your f by x.",
    {
        "a": "The derivative of x by x is not zero: with J = 0 the prediction would delete all uncertainty.",
        "b": "f(x) = x is a function like any other: differentiate it.",
    },
)
quiz.ask(
    "prediction_grows_P",
    False,
    "does P grow in the prediction step?  True / False",
    "Put f and its Jacobian into P <- J P J' + (noise of the motion).",
    {True: "J = I and no noise enters the state: P stays. Motion noise makes the *robot* uncertain."},
)
quiz.ask(
    "shape_P",
    (14, 14),
    "n = 7 landmarks: shape of P?  e.g. (3, 3)",
    "Each landmark brings two numbers.",
    {(7, 7): "Each landmark has two coordinates: the state has 2n numbers."},
)
quiz.ask(
    "shape_H",
    (2, 14),
    "shape of the Jacobian H of one measurement (slide: G)?",
    "Rows: what is measured, range and bearing. Columns: the *whole* state.",
    {
        (2, 2): "That is the block of the seen landmark; H has one column for each number in the state.",
        (14, 2): "That is the transpose: rows are outputs, columns are inputs.",
        (2, 7): "Each landmark has two coordinates: the state has 2n numbers.",
    },
)
quiz.ask(
    "shape_Z",
    (2, 2),
    "shape of the innovation covariance Z = H P H' + R?",
    "Z is the covariance of the innovation: how many numbers does one measurement have?",
    {(14, 14): "H P H' has the size of the measurement, not of the state."},
)
quiz.ask(
    "shape_K",
    (14, 2),
    "shape of the gain K?",
    "K times the innovation (2 numbers) must give a change of the whole state.",
    {
        (2, 14): "That is the transpose: K takes 2 numbers and gives 2n.",
        (2, 2): "One innovation changes the whole state, so K has 2n rows.",
        (14, 14): "K multiplies the innovation, which has 2 numbers: 2 columns.",
        (7, 2): "Each landmark has two coordinates: the state has 2n numbers.",
    },
)

# ---- 02.2 the measurement function -----------------------------------------------------------------------


def h(x, i, x_r):
    """Expected measurement of landmark i (counted from 0) and its Jacobian.

    x is the map [x_0, y_0, x_1, y_1, ...] with 2n numbers, x_r = [x, y, theta] the known pose.
    Return e = [range, bearing], shape (2,), and H = de/dx (slide: G), shape (2, 2n).
    """
    dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
    r2 = dx**2 + dy**2
    r = np.sqrt(r2)
    e = np.array([r, wrap(np.arctan2(dy, dx) - x_r[2])])
    H = np.zeros((2, len(x)))
    H[:, 2 * i : 2 * i + 2] = [[dx / r, dy / r], [-dy / r2, dx / r2]]
    return e, H


def _wrapped(result):
    """The result with its bearing in (-pi, pi], to compare answers that differ by whole turns."""
    e, H = result
    return np.array([e[0], wrap(e[1])], float), H


expected = Exercise(
    "02.2",
    "The measurement function h and its Jacobian",
    h,
    canonical=_wrapped,
    hints=(
        "Start with dx = x_l - x_r and dy = y_l - y_r: from the robot to the landmark. All else is made of them.",
        "Bearing: the direction arctan2(dy, dx), seen from a robot that is turned by theta. Only two columns of H "
        "are not zero: 2i and 2i + 1.",
        "With r2 = dx^2 + dy^2 and r = sqrt(r2), the two columns are [[dx/r, dy/r], [-dy/r2, dx/r2]].",
    ),
)

ROWS = ("range", "bearing")


def _case(rng, n=3):
    """A map of n landmarks and a pose, no landmark nearer than 1 m."""
    x_r = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    a, r = rng.uniform(-np.pi, np.pi, n), rng.uniform(1, 6, n)
    return (x_r[:2] + np.stack([r * np.cos(a), r * np.sin(a)], -1)).ravel(), x_r


def _columns(n):
    return [f"{c} of landmark {i}" for i in range(n) for c in "xy"]


def _e(result):
    return expect.array(expect.results(result, "e", "H")[0], 2, "e")


def _H(result, n):
    return expect.array(expect.results(result, "e", "H")[1], (2, 2 * n), "H")


@expected.link("two results", "The function must end with `return e, H`.")
def _(f, rng):
    x, x_r = _case(rng)
    e, H = expect.results(f(x, 0, x_r), "e", "H")
    expect.array(e, 2, "e")
    expect.true(H is not None, "H is None: return the Jacobian as the second result")


@expected.link("range", "The range is the distance from the robot to the landmark.", part=0)
def _(f, rng):
    for _ in range(3):
        x, x_r = _case(rng)
        expect.close(_e(f(x, 0, x_r))[0], np.hypot(*(x[:2] - x_r[:2])), "the range")


@expected.link("bearing", "Look along the x axis of the robot: an angle to the left is positive.", part=0)
def _(f, rng):
    for angle in (0.3, 1.2, 2.8, -0.4, -2.0, -3.0):
        x_r = np.array([1.0, -2.0, 0.0])
        x = np.array([1 + 2 * np.cos(angle), -2 + 2 * np.sin(angle), 5.0, 5.0])
        expect.angle(_e(f(x, 0, x_r))[1], angle, "the bearing", at="a robot that looks along the x axis (theta = 0)")


@expected.link("heading", "The bearing is measured from where the robot looks: what does theta do to it?", part=0)
def _(f, rng):
    for theta in (0.5, -1.0, 2.5):
        x, x_r = _case(rng)
        x_r[2] = theta
        want = np.arctan2(x[1] - x_r[1], x[0] - x_r[0]) - theta
        expect.angle(_e(f(x, 0, x_r))[1], want, "the bearing", at=f"theta = {theta}")


@expected.link("landmark i", "Landmark i sits at x[2*i] and x[2*i + 1]; counting starts at 0.", part=0)
def _(f, rng):
    x, x_r = _case(rng, 4)
    for i in (3, 1, 2):
        e = _e(f(x, i, x_r))
        want = h(x, i, x_r)[0]
        expect.close(e[0], want[0], f"the range to landmark {i}")
        expect.angle(e[1], want[1], f"the bearing to landmark {i}")


@expected.link("shape of H", "H has one row per measured number and one column per number in the map.", part=1)
def _(f, rng):
    for n in (3, 1, 5):
        x, x_r = _case(rng, n)
        _H(f(x, n - 1, x_r), n)


@expected.link("zero columns", "The measurement of landmark i says nothing about the others.", part=1)
def _(f, rng):
    x, x_r = _case(rng, 4)
    for i in (2, 0, 3):
        others = np.delete(_H(f(x, i, x_r), 4), [2 * i, 2 * i + 1], axis=1)
        expect.true(not others.any(), f"H for landmark {i} is not zero in the columns of other landmarks")


def _unrolled(x, i, x_r, direction):
    """[range, bearing] without a seam: the angle is counted from the given direction."""
    dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
    c, s = np.cos(direction), np.sin(direction)
    return np.array([np.hypot(dx, dy), np.arctan2(c * dy - s * dx, c * dx + s * dy)])


def _row_is_derivative(f, rng, row):
    for _ in range(6):
        x, x_r = _case(rng)
        i = int(rng.integers(3))
        direction = np.arctan2(*(x[2 * i : 2 * i + 2] - x_r[:2])[::-1])
        smooth = lambda x, i=i, x_r=x_r, direction=direction: _unrolled(x, i, x_r, direction)
        expect.jacobian(_H(f(x, i, x_r), 3), smooth, x, "H", ROWS, _columns(3), row=row)


@expected.link("derivative of the range", "Differentiate r = sqrt(dx^2 + dy^2) by x_l and by y_l.", part=1)
def _(f, rng):
    _row_is_derivative(f, rng, 0)


@expected.link("derivative of the bearing", "d arctan2(dy, dx): [-dy, dx] over what? Does theta matter here?", part=1)
def _(f, rng):
    _row_is_derivative(f, rng, 1)


def _polar(dx, dy, theta):
    return np.array([np.hypot(dx, dy), wrap(np.arctan2(dy, dx) - theta)])


def _block(x, i, B):
    H = np.zeros((2, len(x)))
    H[:, 2 * i : 2 * i + 2] = B
    return H


def _good_block(dx, dy):
    r2 = dx**2 + dy**2
    r = np.sqrt(r2)
    return np.array([[dx / r, dy / r], [-dy / r2, dx / r2]])


def _wrong_e(name, hint, e_of):
    """A misconception in the value only: e_of(dx, dy, theta)."""

    @expected.wrong(name, hint)
    def _(x, i, x_r):
        dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
        return np.array(e_of(dx, dy, x_r[2])), _block(x, i, _good_block(dx, dy))


def _wrong_H(name, hint, B_of):
    """A misconception in the Jacobian only: the 2 x 2 block B_of(dx, dy, theta)."""

    @expected.wrong(name, hint)
    def _(x, i, x_r):
        dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
        return _polar(dx, dy, x_r[2]), _block(x, i, B_of(dx, dy, x_r[2]))


_wrong_e(
    "heading forgotten",
    "That is the direction in the map frame. The robot measures from its own x axis: subtract theta.",
    lambda dx, dy, th: [np.hypot(dx, dy), np.arctan2(dy, dx)],
)
_wrong_e(
    "heading added",
    "Turn the robot to the left: the landmark moves to the right in its view. Subtract theta, do not add it.",
    lambda dx, dy, th: [np.hypot(dx, dy), np.arctan2(dy, dx) + th],
)
_wrong_e(
    "from the landmark to the robot",
    "Your differences point from the landmark to the robot. Use landmark minus robot in arctan2.",
    lambda dx, dy, th: [np.hypot(dx, dy), np.arctan2(-dy, -dx) - th],
)
_wrong_e(
    "arctan2 swapped",
    "arctan2 takes y first: arctan2(dy, dx).",
    lambda dx, dy, th: [np.hypot(dx, dy), np.arctan2(dx, dy) - th],
)
_wrong_e(
    "arctan of the quotient",
    "arctan(dy / dx) cannot tell ahead from behind. Use arctan2(dy, dx).",
    lambda dx, dy, th: [np.hypot(dx, dy), np.arctan(dy / dx) - th],
)
_wrong_e(
    "bearing to the right",
    "Your bearing has the wrong sign: angles count to the left (counter-clockwise).",
    lambda dx, dy, th: [np.hypot(dx, dy), th - np.arctan2(dy, dx)],
)
_wrong_e(
    "bearing in degrees",
    "Angles are in radians everywhere.",
    lambda dx, dy, th: [np.hypot(dx, dy), np.degrees(wrap(np.arctan2(dy, dx) - th))],
)
_wrong_e(
    "range squared",
    "Take the square root: the range is in metres, dx^2 + dy^2 in square metres.",
    lambda dx, dy, th: [dx**2 + dy**2, np.arctan2(dy, dx) - th],
)
_wrong_e(
    "bearing first",
    "The order is range, then bearing.",
    lambda dx, dy, th: [np.arctan2(dy, dx) - th, np.hypot(dx, dy)],
)


@expected.wrong("counts from one", "Python counts from 0: landmark i has the entries 2*i and 2*i + 1.")
def _(x, i, x_r):
    j = (2 * i - 2) % len(x)
    dx, dy = x[j : j + 2] - x_r[:2]
    H = np.zeros((2, len(x)))
    H[:, j : j + 2] = _good_block(dx, dy)
    return _polar(dx, dy, x_r[2]), H


@expected.wrong("index i instead of 2i", "Each landmark takes two places in x: landmark i starts at 2*i.")
def _(x, i, x_r):
    dx, dy = x[i : i + 2] - x_r[:2]
    H = np.zeros((2, len(x)))
    H[:, i : i + 2] = _good_block(dx, dy)
    return _polar(dx, dy, x_r[2]), H


@expected.wrong("all x first", "The map is stored landmark by landmark: x_0, y_0, x_1, y_1, ...")
def _(x, i, x_r):
    n = len(x) // 2
    dx, dy = x[[i, n + i]] - x_r[:2]
    H = np.zeros((2, len(x)))
    H[:, [i, n + i]] = _good_block(dx, dy)
    return _polar(dx, dy, x_r[2]), H


@expected.wrong("right block, wrong columns", "H has the block of landmark i in the columns 2*i and 2*i + 1.")
def _(x, i, x_r):
    dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
    H = np.zeros((2, len(x)))
    H[:, i : i + 2] = _good_block(dx, dy)
    return _polar(dx, dy, x_r[2]), H


@expected.wrong(
    "only the 2 x 2 block", "Put the 2 x 2 block into a matrix of zeros with one column per number in the map."
)
def _(x, i, x_r):
    dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
    return _polar(dx, dy, x_r[2]), _good_block(dx, dy)


@expected.wrong("H transposed", "Rows are outputs (range, bearing), columns are inputs (the map): H is 2 x 2n.")
def _(x, i, x_r):
    e, H = h(x, i, x_r)
    return e, H.T


@expected.wrong(
    "columns instead of vectors", "Vectors have one axis here: np.array([r, beta]), no columns, no extra brackets."
)
def _(x, i, x_r):
    e, H = h(x, i, x_r)
    return e[:, None], H


_wrong_H(
    "derivative by the robot",
    "That is the derivative by the robot's position. By the landmark's it has the other sign: dr/dx_l = +dx/r.",
    lambda dx, dy, th: -_good_block(dx, dy),
)
_wrong_H(
    "r for r^2",
    "The bearing row is divided by r^2, not by r: a landmark twice as far away turns half as fast.",
    lambda dx, dy, th: np.array([[dx, dy], [-dy, dx]]) / np.hypot(dx, dy),
)
_wrong_H(
    "r^2 for r",
    "The range row is divided by r, not by r^2: it is a unit vector.",
    lambda dx, dy, th: np.array([[dx, dy], [-dy, dx]]) / (dx**2 + dy**2),
)
_wrong_H(
    "sign of the bearing row",
    "d bearing / d x_l = -dy/r^2 and d bearing / d y_l = +dx/r^2. Check with a landmark straight ahead.",
    lambda dx, dy, th: _good_block(dx, dy) * [[1], [-1]],
)
_wrong_H(
    "minus sign forgotten",
    "d bearing / d x_l = -dy/r^2: a landmark on the left that moves forward (x_l grows) gets a smaller bearing.",
    lambda dx, dy, th: _good_block(dx, dy) * [[1, 1], [-1, 1]],
)
_wrong_H(
    "dx and dy swapped",
    "In the bearing row dy stands in the x column and dx in the y column: [-dy, dx] / r^2.",
    lambda dx, dy, th: np.array([[dx, dy], [-dx, dy]]) / np.array([[np.hypot(dx, dy)], [dx**2 + dy**2]]),
)
_wrong_H(
    "block transposed",
    "The 2 x 2 block is transposed: the first row is the derivative of the range, by x_l and by y_l.",
    lambda dx, dy, th: _good_block(dx, dy).T,
)
_wrong_H(
    "turned by theta",
    "x is in the map frame, and so are the columns of H. theta only shifts the bearing: it is not in H.",
    lambda dx, dy, th: _good_block(dx, dy) @ [[np.cos(th), -np.sin(th)], [np.sin(th), np.cos(th)]],
)
_wrong_H(
    "in degrees",
    "The bearing row is in degrees per metre: keep to radians.",
    lambda dx, dy, th: _good_block(dx, dy) * [[1], [180 / np.pi]],
)


@expected.variant("with complex numbers")
def _(x, i, x_r):
    d = complex(*x[2 * i : 2 * i + 2]) - complex(x_r[0], x_r[1])
    e = [abs(d), np.angle(d * np.exp(-1j * x_r[2]))]
    g = 1j / d  # d(angle) = Im(dd / d)
    H = np.zeros((2, len(x)))
    H[0, 2 * i], H[0, 2 * i + 1] = d.real / abs(d), d.imag / abs(d)
    H[1, 2 * i], H[1, 2 * i + 1] = (1 / d).imag, g.imag
    return e, H


@expected.variant("lists, bearing not wrapped")
def _(x, i, x_r):
    dx, dy = float(x[2 * i] - x_r[0]), float(x[2 * i + 1] - x_r[1])
    r = (dx * dx + dy * dy) ** 0.5
    H = [[0.0] * len(x), [0.0] * len(x)]
    H[0][2 * i], H[0][2 * i + 1] = dx / r, dy / r
    H[1][2 * i], H[1][2 * i + 1] = -dy / r**2, dx / r**2
    return [r, float(np.arctan2(dy, dx)) - float(x_r[2]) + 2 * np.pi], H


@expected.variant("in the robot frame, by the chain rule")
def _(x, i, x_r):
    c, s = np.cos(x_r[2]), np.sin(x_r[2])
    T = np.array([[c, s], [-s, c]])
    px, py = T @ (np.asarray(x).reshape(-1, 2)[i] - x_r[:2])
    r = np.hypot(px, py)
    B = np.array([[px / r, py / r], [-py / r**2, px / r**2]]) @ T
    return (r, np.arctan2(py, px)), np.hstack([np.zeros((2, 2 * i)), B, np.zeros((2, len(x) - 2 * i - 2))])


@expected.variant("derivative by finite differences")
def _(x, i, x_r):
    def value(x):
        dx, dy = x[2 * i] - x_r[0], x[2 * i + 1] - x_r[1]
        return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - x_r[2]])

    d = 1e-6 * np.eye(len(x))
    return value(x), np.stack([(value(x + dj) - value(x - dj)) / 2e-6 for dj in d], axis=1)
