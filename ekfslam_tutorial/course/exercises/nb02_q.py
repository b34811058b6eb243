"""Exercise 02.3: the landmark initialisation function q and its Jacobian."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb02_h import h


def q(y, x_r):
    """Position of a new landmark and its Jacobian.

    y = [range, bearing] is measured from the known pose x_r = [x, y, theta].
    Return l = [x_l, y_l], shape (2,), and L_y = dl/dy (slide: L_z), shape (2, 2).
    """
    r, a = y[0], y[1] + x_r[2]
    c, s = np.cos(a), np.sin(a)
    l = np.array([x_r[0] + r * c, x_r[1] + r * s])
    L_y = np.array([[c, -r * s], [s, r * c]])
    return l, L_y


born = Exercise(
    "02.3",
    "The initialisation function q and its Jacobian",
    q,
    hints=(
        "In which direction of the map does the robot look when it looks at the landmark? Two angles add up.",
        "With a = theta + beta: l = x_r + r [cos a, sin a]. Differentiate it by r (first column), then by beta.",
        "The columns of L_y are [cos a, sin a] and r [-sin a, cos a].",
    ),
)


def random_pose(rng):
    """Some pose [x, y, theta]."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)])


def random_y(rng):
    """Some measurement [range, bearing]."""
    return np.array([rng.uniform(0.5, 6), rng.uniform(-3, 3)])


def _l(result):
    return expect.array(expect.results(result, "l", "L_y")[0], 2, "l")


def _L(result):
    return expect.array(expect.results(result, "l", "L_y")[1], (2, 2), "L_y")


def landmark_of(y, x_r):
    """The landmark, without a Jacobian."""
    a = x_r[2] + y[1]
    return x_r[:2] + y[0] * np.array([np.cos(a), np.sin(a)])


@born.link("two results", "The function must end with `return l, L_y`.")
def _(f, rng):
    result = f(random_y(rng), random_pose(rng))
    _l(result)
    expect.true(
        expect.results(result, "l", "L_y")[1] is not None, "L_y is None: return the Jacobian as the second result"
    )


@born.link("robot at the origin", "From polar to Cartesian: x = r cos(...), y = r sin(...).", part=0)
def _(f, rng):
    for y in ([2.0, 0.0], [3.0, np.pi / 2], [1.5, -2.5]):
        want = landmark_of(np.array(y), np.zeros(3))
        expect.close(_l(f(np.array(y), np.zeros(3))), want, "l", at=f"y = {np.round(y, 2)} and x_r = [0, 0, 0]")


@born.link("position of the robot", "The range is counted from the robot, the map from its own origin.", part=0)
def _(f, rng):
    x_r = np.array([2.0, -1.0, 0.0])
    y = random_y(rng)
    expect.close(_l(f(y, x_r)), landmark_of(y, x_r), "l", at=f"y = {y.round(3)} and x_r = [2, -1, 0]")


@born.link("heading of the robot", "The bearing is counted from the heading theta of the robot.", part=0)
def _(f, rng):
    for _ in range(4):
        y, x_r = random_y(rng), random_pose(rng)
        expect.close(_l(f(y, x_r)), landmark_of(y, x_r), "l", at=f"y = {y.round(3)} and x_r = {x_r.round(3)}")


@born.link("shape of L_y", "Two outputs (x_l, y_l) by two inputs (range, bearing).", part=1)
def _(f, rng):
    _L(f(random_y(rng), random_pose(rng)))


@born.link("derivative", "First column: dl/d range. Second column: dl/d bearing, it grows with the range.", part=1)
def _(f, rng):
    for _ in range(6):
        y, x_r = random_y(rng), random_pose(rng)
        smooth = lambda y, x_r=x_r: landmark_of(y, x_r)
        expect.jacobian(_L(f(y, x_r)), smooth, y, "L_y", ("x_l", "y_l"), ("range", "bearing"))


@born.link("q undoes h", "A measurement of the new landmark must give back y: h(q(y)) = y, and H L_y = I.")
def _(f, rng):
    for y in ([4.0, 3.1], [0.7, -3.1], [25.0, 0.5]):
        y, x_r = np.array(y), random_pose(rng)
        result = f(y, x_r)
        e, H = h(_l(result), 0, x_r)
        expect.close([e[0], wrap(e[1] - y[1])], [y[0], 0.0], "h(q(y)), range and bearing - beta,")
        expect.close(H @ _L(result), np.eye(2), "H L_y")


def _wrong_l(name, hint, l_of):
    """A misconception in the position only: l_of(r, beta, x, y, theta)."""

    @born.wrong(name, hint)
    def _(y, x_r):
        return np.array(l_of(*y, *x_r)), q(y, x_r)[1]


def _wrong_L(name, hint, L_of):
    """A misconception in the Jacobian only: L_of(r, beta, theta)."""

    @born.wrong(name, hint)
    def _(y, x_r):
        return q(y, x_r)[0], np.array(L_of(*y, x_r[2]))


cos, sin = np.cos, np.sin
_wrong_l(
    "heading forgotten",
    "beta is counted from the robot's heading. In the map the direction is theta + beta.",
    lambda r, b, x, y, th: [x + r * cos(b), y + r * sin(b)],
)
_wrong_l(
    "heading subtracted",
    "A landmark seen to the left (beta > 0) lies in the direction theta *plus* beta.",
    lambda r, b, x, y, th: [x + r * cos(th - b), y + r * sin(th - b)],
)
_wrong_l(
    "bearing minus heading",
    "h subtracts theta, so q must add it: the direction in the map is theta + beta.",
    lambda r, b, x, y, th: [x + r * cos(b - th), y + r * sin(b - th)],
)
_wrong_l(
    "bearing forgotten",
    "The landmark is not straight ahead: its direction in the map is theta + beta.",
    lambda r, b, x, y, th: [x + r * cos(th), y + r * sin(th)],
)
_wrong_l(
    "robot position forgotten",
    "That is the landmark as seen from the robot. Add the robot's own position.",
    lambda r, b, x, y, th: [r * cos(th + b), r * sin(th + b)],
)
_wrong_l(
    "robot position subtracted",
    "Walk from the map's origin to the robot, then to the landmark: the two vectors add up.",
    lambda r, b, x, y, th: [r * cos(th + b) - x, r * sin(th + b) - y],
)
_wrong_l(
    "behind the robot",
    "The landmark lies in the direction theta + beta *from the robot*: x_r plus, not minus.",
    lambda r, b, x, y, th: [x - r * cos(th + b), y - r * sin(th + b)],
)
_wrong_l(
    "sine and cosine swapped",
    "x goes with the cosine, y with the sine.",
    lambda r, b, x, y, th: [x + r * sin(th + b), y + r * cos(th + b)],
)
_wrong_l(
    "y mirrored",
    "The sign of the sine is wrong: bearings count to the left.",
    lambda r, b, x, y, th: [x + r * cos(th + b), y - r * sin(th + b)],
)
_wrong_l(
    "degrees converted",
    "All angles are in radians already: no conversion.",
    lambda r, b, x, y, th: [x + r * cos(np.radians(th + b)), y + r * sin(np.radians(th + b))],
)
_wrong_l(
    "range and bearing swapped",
    "y = [range, bearing]: the range comes first.",
    lambda r, b, x, y, th: [x + b * cos(th + r), y + b * sin(th + r)],
)


@born.wrong("column", "Vectors have one axis here: np.array([x, y]), no columns.")
def _(y, x_r):
    l, L_y = q(y, x_r)
    return l[:, None], L_y


_wrong_L(
    "transposed",
    "Rows are outputs (x_l, y_l), columns are inputs (range, bearing): yours is the transpose.",
    lambda r, b, th: [[cos(th + b), sin(th + b)], [-r * sin(th + b), r * cos(th + b)]],
)
_wrong_L(
    "r forgotten in the bearing column",
    "An error of the bearing moves the landmark by r times that angle: the second column has the factor r.",
    lambda r, b, th: [[cos(th + b), -sin(th + b)], [sin(th + b), cos(th + b)]],
)
_wrong_L(
    "minus sign forgotten",
    "The derivative of the cosine is *minus* the sine.",
    lambda r, b, th: [[cos(th + b), r * sin(th + b)], [sin(th + b), r * cos(th + b)]],
)
_wrong_L(
    "heading forgotten in L_y",
    "The angle in L_y is the same as in l: theta + beta.",
    lambda r, b, th: [[cos(b), -r * sin(b)], [sin(b), r * cos(b)]],
)
_wrong_L(
    "columns swapped",
    "The first column is the derivative by the range, the second by the bearing.",
    lambda r, b, th: [[-r * sin(th + b), cos(th + b)], [r * cos(th + b), sin(th + b)]],
)
_wrong_L(
    "the inverse: H instead of L_y",
    "That is the derivative of the measurement by the landmark, H. Here it is the other way round: dl/dy.",
    lambda r, b, th: [[cos(th + b), sin(th + b)], [-sin(th + b) / r, cos(th + b) / r]],
)
_wrong_L(
    "diagonal",
    "Both x_l and y_l depend on both range and bearing: no entry is zero in general.",
    lambda r, b, th: [[cos(th + b), 0.0], [0.0, r * cos(th + b)]],
)


@born.wrong(
    "derivative by the pose", "That is dl/dx_r (2 x 3): the pose is known here, the noise is in y. Differentiate by y."
)
def _(y, x_r):
    l, L_y = q(y, x_r)
    return l, np.column_stack([np.eye(2), L_y[:, 1]])


@born.variant("with complex numbers, as lists")
def _(y, x_r):
    u = np.exp(1j * (x_r[2] + y[1] + 2 * np.pi))
    l = complex(x_r[0], x_r[1]) + y[0] * u
    return [l.real, l.imag], [[u.real, (1j * y[0] * u).real], [u.imag, (1j * y[0] * u).imag]]


@born.variant("rotation matrix times point")
def _(y, x_r):
    R = np.array([[cos(x_r[2]), -sin(x_r[2])], [sin(x_r[2]), cos(x_r[2])]])
    u, v = np.array([cos(y[1]), sin(y[1])]), np.array([-sin(y[1]), cos(y[1])])
    return x_r[:2] + R @ (y[0] * u), R @ np.column_stack([u, y[0] * v])


@born.variant("L_y as the inverse of H")
def _(y, x_r):
    l = landmark_of(np.asarray(y), np.asarray(x_r))
    return tuple(l), np.linalg.inv(h(l, 0, x_r)[1])
