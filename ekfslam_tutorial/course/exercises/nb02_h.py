"""Exercise 02.2: the measurement function h and its Jacobian."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..table import table


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


def unwrapped(x, i, x_r):
    """Return the measurement with its bearing as it comes, for derivatives."""
    dx, dy = x[2 * i : 2 * i + 2] - x_r[:2]
    return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - x_r[2]])


def some(rng, n=3, i=0):
    """Return landmark i of n, no landmark nearer than 1 m, and a pose."""
    x_r = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    a, r = rng.uniform(-np.pi, np.pi, n), rng.uniform(1, 6, n)
    return (x_r[:2] + np.stack([r * np.cos(a), r * np.sin(a)], -1)).ravel(), i, x_r


def looking(rng, theta):
    """Return a landmark, and a robot with this heading."""
    x, i, x_r = some(rng)
    return x, i, np.array([*x_r[:2], theta])


def along(angle):
    """Return a landmark in this direction of a robot that looks along the x axis."""
    return np.array([1 + 2 * np.cos(angle), -2 + 2 * np.sin(angle), 5.0, 5.0]), 0, np.array([1.0, -2.0, 0.0])


expected = table(
    "02.2 The measurement function h and its Jacobian",
    h,
    hints=(
        "Start with dx = x_l - x_r and dy = y_l - y_r: from the robot to the landmark. All else is made of them.",
        "Bearing: the direction arctan2(dy, dx), seen from a robot that is turned by theta. Only two columns of H are not zero: 2i and 2i + 1.",
        "With r2 = dx^2 + dy^2 and r = sqrt(r2), the two columns are [[dx/r, dy/r], [-dy/r2, dx/r2]].",
    ),
    returns="e, H",
    symbols="x_l, y_l = the two numbers of landmark i",
    angles={"e": 1},
    jacobians={"H": unwrapped},
    entries={"H": "range, bearing", "x": ", ".join(f"{c} of landmark {i}" for i in range(5) for c in "xy")},
    cases={
        "any": lambda rng: [some(rng) for _ in range(3)],
        "along x": lambda rng: [along(angle) for angle in (0.3, 1.2, 2.8, 3.13, -0.4, -2.0, -3.13)],
        "turned": lambda rng: [looking(rng, theta) for theta in (0.5, -1.0, 2.5)],
        "others": lambda rng: [some(rng, 4, i) for i in (3, 1, 2)],
        "sizes": lambda rng: [some(rng, n, n - 1) for n in (3, 1, 5)],
        "all": lambda rng: [some(rng, n, int(rng.integers(n))) for n in (3, 1, 5, 2, 3, 3)],
    },
    checks="""
    range                     | e[0]       | any     | The range is the distance from the robot to the landmark: the root of dx^2 + dy^2, with dx = x[2*i] - x_r[0], dy = x[2*i + 1] - x_r[1].
    bearing                   | e[1]       | along x | This robot looks along the x axis (theta = 0). The bearing is the angle from there to the landmark: positive to the left, negative to the right, near pi or -pi behind.
    heading                   | e[1]       | turned  | This robot is turned by theta. The bearing is the angle from the direction in which it looks to the direction of the landmark, both in the map; whole turns do not matter.
    landmark i                | e          | others  | Here i is 3, 1 or 2: the same range and bearing, of landmark i, which sits at x[2*i] and x[2*i + 1]; counting starts at 0. Whole turns of the bearing do not matter.
    shape of H                | H[:0]      | sizes   | H has one row per measured number and one column per number in the map.
    derivative of the range   | d H[0] / x | all     | Differentiate r = sqrt(dx^2 + dy^2) by x_l and by y_l.
    derivative of the bearing | d H[1] / x | all     | On the board: d beta = (cos(a) d y_l - sin(a) d x_l) / r, with the range r and a = arctan2(dy, dx). What stands before d x_l and d y_l are the two numbers of this row.
    """,
    wrong="""
    heading forgotten | np.arctan2(dy, dx) - x_r[2] -> np.arctan2(dy, dx) | That is the direction in the map frame. The robot measures from its own x axis: subtract theta.
    heading added | np.arctan2(dy, dx) - x_r[2] -> np.arctan2(dy, dx) + x_r[2] | Turn the robot to the left: the landmark moves to the right in its view. Subtract theta, do not add it.
    from the landmark to the robot | np.arctan2(dy, dx) -> np.arctan2(-dy, -dx) | Your bearing points the other way, from the landmark to the robot. arctan2 takes landmark minus robot.
    arctan2 swapped | np.arctan2(dy, dx) -> np.arctan2(dx, dy) | arctan2 takes y first: arctan2(dy, dx).
    arctan of the quotient | np.arctan2(dy, dx) -> np.arctan(dy / dx) | arctan(dy / dx) cannot tell ahead from behind. Use arctan2(dy, dx).
    bearing to the right | np.arctan2(dy, dx) - x_r[2] -> x_r[2] - np.arctan2(dy, dx) | Your bearing has the wrong sign: angles count to the left (counter-clockwise).
    bearing in degrees | wrap(np.arctan2(dy, dx) - x_r[2]) -> np.degrees(wrap(np.arctan2(dy, dx) - x_r[2])) | Angles are in radians everywhere.
    brackets forgotten | wrap(np.arctan2(dy, dx) - x_r[2]) -> (np.arctan2(dy, dx) - x_r[2] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    sign of the bearing lost | wrap(np.arctan2(dy, dx) - x_r[2]) -> np.abs(wrap(np.arctan2(dy, dx) - x_r[2])) | Left and right are different directions: a bearing to the right is negative.
    range squared | e = np.array([r, -> e = np.array([r2, | Take the square root: the range is in metres, dx^2 + dy^2 in square metres.
    distances added | e = np.array([r, -> e = np.array([abs(dx) + abs(dy), | The range is the straight distance: the root of dx^2 + dy^2, not the sum of both ways.
    bearing first | return e, H -> return e[::-1], H | The order is range, then bearing.
    robot at the origin | x[2 * i : 2 * i + 2] - x_r[:2] -> x[2 * i : 2 * i + 2] | The differences begin at the robot: subtract its position, x_r[:2].
    counts from one | dx, dy = x -> i = (i - 1) % (len(x) // 2); dx, dy = x | Python counts from 0: landmark i has the entries 2*i and 2*i + 1.
    index i instead of 2i | x[2 * i : 2 * i + 2] -> x[i : i + 2] | Each landmark takes two places in x: landmark i starts at 2*i.
        H[:, 2 * i : 2 * i + 2] -> H[:, i : i + 2]
    all x first | x[2 * i : 2 * i + 2] -> x[[i, len(x) // 2 + i]] | The map is stored landmark by landmark: x_0, y_0, x_1, y_1, ...
        H[:, 2 * i : 2 * i + 2] -> H[:, [i, len(x) // 2 + i]]
    right block, wrong columns | H[:, 2 * i : 2 * i + 2] -> H[:, i : i + 2] | H has the block of landmark i in the columns 2*i and 2*i + 1.
    only the 2 x 2 block | H = np.zeros((2, len(x))) -> H = np.zeros((2, 2)) | Put the 2 x 2 block into a matrix of zeros with one column per number in the map.
        H[:, 2 * i : 2 * i + 2] -> H[:, :]
    H transposed | return e, H -> return e, H.T | Rows are outputs (range, bearing), columns are inputs (the map): H is 2 x 2n.
    columns instead of vectors | return e, H -> return e[:, None], H | Vectors have one axis here: np.array([r, beta]), no columns, no extra brackets.
    derivative by the robot | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[-dx / r, -dy / r], [dy / r2, -dx / r2]] | That is the derivative by the robot's position. By the landmark's it has the other sign: dr/dx_l = +dx/r.
    sign of the range row | [[dx / r, dy / r], -> [[-dx / r, -dy / r], | The range grows when the landmark moves away: dr/dx_l = +dx/r, dr/dy_l = +dy/r.
    r for r^2 | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[dx / r, dy / r], [-dy / r, dx / r]] | The bearing row is [-dy / r^2, dx / r^2], which is [-sin(a) / r, cos(a) / r]: a landmark twice as far away turns half as fast. Yours lacks one division by r.
    r^2 for r | [[dx / r, dy / r], -> [[dx / r2, dy / r2], | The range row is divided by r, not by r^2: it is a unit vector.
    sign of the bearing row | [-dy / r2, dx / r2] -> [dy / r2, -dx / r2] | d bearing / d x_l = -dy/r^2 and d bearing / d y_l = +dx/r^2. Check with a landmark straight ahead.
    minus sign forgotten | [-dy / r2, dx / r2] -> [dy / r2, dx / r2] | d bearing / d x_l = -dy/r^2: a landmark on the left that moves forward (x_l grows) gets a smaller bearing.
    dx and dy swapped | [-dy / r2, dx / r2] -> [-dx / r2, dy / r2] | In the bearing row dy stands in the x column and dx in the y column: [-dy, dx] / r^2.
    block transposed | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[dx / r, -dy / r2], [dy / r, dx / r2]] | The 2 x 2 block is transposed: the first row is the derivative of the range, by x_l and by y_l.
    turned by theta | H = np.zeros -> c, s = np.cos(x_r[2]), np.sin(x_r[2]); dx, dy = c * dx + s * dy, c * dy - s * dx; H = np.zeros | x is in the map frame, and so are the columns of H. theta only shifts the bearing: it is not in H.
    in degrees | [-dy / r2, dx / r2] -> [np.degrees(-dy / r2), np.degrees(dx / r2)] | The bearing row is in degrees per metre: keep to radians.
    rows swapped | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[-dy / r2, dx / r2], [dx / r, dy / r]] | The first row of H is the derivative of the range, the second that of the bearing.
    r^3 for r^2 | [-dy / r2, dx / r2] -> [-dy / r**3, dx / r**3] | The bearing row is divided by r^2: [-dy, dx] / r^2, or [-sin, cos] / r.
    block under each landmark | return e, H -> return e, np.tile(H[:, 2 * i : 2 * i + 2], len(x) // 2) | The block stands in the two columns of landmark i only: the others are zero.
    derivative of the square of the range | [[dx / r, dy / r], -> [[2 * dx, 2 * dy], | That is the derivative of r^2. Of the range itself it is dx / r and dy / r.
    """,
)


@expected.link(
    "zero columns", "The measurement of landmark i says nothing about the others.", 1, "derivative of the range"
)
def _(f, rng):
    for i in (2, 0, 3):
        x, i, x_r = some(rng, 4, i)
        H = expect.array(expect.results(f(x, i, x_r), "e", "H")[1], (2, 8), "H")
        others = np.delete(H, [2 * i, 2 * i + 1], axis=1)
        expect.true(not others.any(), f"H for landmark {i} is not zero in the columns of other landmarks")
