"""Exercise 02.2: wrong and right answers."""

import numpy as np

from ...geometry import wrap
from .nb02_h import expected, h


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
