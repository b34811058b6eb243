"""Exercise 02.2: the measurement function h and its Jacobian."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


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
    for angle in (0.3, 1.2, 2.8, 3.13, -0.4, -2.0, -3.13):
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
    for n in (3, 1, 5, 2, 3, 3):
        x, x_r = _case(rng, n)
        i = int(rng.integers(n))
        direction = np.arctan2(*(x[2 * i : 2 * i + 2] - x_r[:2])[::-1])
        smooth = lambda x, i=i, x_r=x_r, direction=direction: _unrolled(x, i, x_r, direction)
        expect.jacobian(_H(f(x, i, x_r), n), smooth, x, "H", ROWS, _columns(n), row=row)


@expected.link("derivative of the range", "Differentiate r = sqrt(dx^2 + dy^2) by x_l and by y_l.", part=1)
def _(f, rng):
    _row_is_derivative(f, rng, 0)


@expected.link("derivative of the bearing", "d arctan2(dy, dx): [-dy, dx] over what? Does theta matter here?", part=1)
def _(f, rng):
    _row_is_derivative(f, rng, 1)
