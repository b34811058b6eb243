"""Exercise 05.2: the expected measurement and its Jacobian by the whole state."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..table import table


def observe(x, l):
    """Expected measurement of one landmark, and its derivative by the whole joint state.

    x, shape (n,): the robot's pose [x, y, theta], then the landmarks.
    l: the range of the landmark in the state, a slice: its position is x[l].
    Return e = [range, bearing], shape (2,), and H = de/dx, shape (2, n).
    """
    dx, dy = x[l] - x[:2]
    r2 = dx**2 + dy**2
    r = np.sqrt(r2)
    e = np.array([r, wrap(np.arctan2(dy, dx) - x[2])])
    E_l = np.array([[dx / r, dy / r], [-dy / r2, dx / r2]])
    H = np.zeros((2, len(x)))
    H[:, :2], H[:, 2], H[:, l] = -E_l, [0, -1], E_l
    return e, H


def unwrapped(x, l):
    """Return the measurement with its bearing as it comes, for derivatives."""
    dx, dy = x[l] - x[:2]
    return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - x[2]])


def case(rng, n=9, at=5, theta=None, bearing=None):
    """Return a state with a landmark in the range at:at+2, a few metres from the robot."""
    x = rng.uniform(-5, 5, n)
    x[2] = rng.uniform(-3, 3) if theta is None else theta
    a, r = rng.uniform(-np.pi, np.pi) if bearing is None else x[2] + bearing, rng.uniform(1, 6)
    x[at : at + 2] = x[:2] + r * np.array([np.cos(a), np.sin(a)])
    return x, slice(at, at + 2)


observation = table(
    "05.2 Expect",
    observe,
    hints=(
        "e is that of notebook 02. What is new: the pose is in the state, so H has columns for the robot, too.",
        "e depends on differences only, landmark minus robot. So what are the first two columns, compared with those of the landmark? And what happens to range and bearing when the robot turns?",
        "With E_l the 2 x 2 block of the landmark: H[:, l] = E_l, H[:, :2] = -E_l, H[:, 2] = [0, -1], and zero elsewhere.",
    ),
    returns="e, H",
    symbols="x[l] = [x_l, y_l]; E_l = the derivative of e by the landmark, H[:, l]",
    angles={"e": 1},
    jacobians={"H": unwrapped},
    entries={"H": "range, bearing", "x": "x, y, theta, " + ", ".join(f"x[{i}]" for i in range(3, 13))},
    cases={
        "any": lambda rng: [case(rng, n, at) for n, at in ((9, 5), (5, 3), (11, 7), (9, 3), (13, 11))],
        "turned": lambda rng: [  # to the left and to the right, ahead and behind
            case(rng, 9, 5, 0.0, 0.8),
            case(rng, 5, 3, 0.7, -2.0),
            case(rng, 11, 7, -2.5, 2.6),
            case(rng, 9, 3, 2.9, -0.4),
        ],
        "l = 5:7": lambda rng: [case(rng, n, 5) for n in (9, 7, 11)],
    },
    checks="""
    range                          | e[0]      | any     | e = [range, bearing]: the range is the distance from the robot to the landmark in x[l].
    bearing                        | e[1]      | turned  | Look from the robot, with [dx, dy] = x[l] - x[:2]: the bearing is arctan2(dy, dx) minus the heading theta, up to whole turns.
    shape of H                     | H[:0]     | any     | H has one column for each number of the joint state: robot and all landmarks.
    columns of the landmark        | H[:, 5:7] | l = 5:7 | The block of notebook 02, in the columns l of H.
    columns of the robot's position | H[:, :2] | any     | The first two columns: only the difference landmark minus robot counts, so they are minus those of the landmark, range row and bearing row.
    column of the heading          | H[:, 2]   | any     | The column of theta: turn the robot a bit to the left: what happens to range and bearing?
    the world as a whole           | d H / x   | any     | H is the derivative of e by all of x, wherever l is. Shift or turn robot and landmarks together: no measurement changes.
    """,
    wrong="""
    heading forgotten | np.arctan2(dy, dx) - x[2] -> np.arctan2(dy, dx) | That is the direction in the map. The robot measures from its own x axis: subtract theta.
    heading added | np.arctan2(dy, dx) - x[2] -> np.arctan2(dy, dx) + x[2] | Turn the robot to the left: the landmark moves to the right in its view. Subtract theta.
    derivative by the heading in the column of x | H[:, :2], H[:, 2], H[:, l] = -E_l, [0, -1], E_l -> H[:, :2], H[:, l] = -E_l, E_l; H[1, 0] = -1 | d bearing / d theta = -1 stands in the column of theta, H[1, 2]; yours stands in the column of x.
    from the landmark to the robot | np.arctan2(dy, dx) -> np.arctan2(-dy, -dx) | Use landmark minus robot in arctan2.
    arctan2 swapped | np.arctan2(dy, dx) -> np.arctan2(dx, dy) | arctan2 takes y first: arctan2(dy, dx).
    arctan of the quotient | np.arctan2(dy, dx) -> np.arctan(dy / dx) | arctan(dy / dx) cannot tell ahead from behind. Use arctan2(dy, dx).
    bearing to the right | np.arctan2(dy, dx) - x[2] -> x[2] - np.arctan2(dy, dx) | Your bearing has the wrong sign: angles count to the left (counter-clockwise).
    bearing in degrees | wrap(np.arctan2(dy, dx) - x[2]) -> np.degrees(wrap(np.arctan2(dy, dx) - x[2])) | Angles are in radians everywhere.
    brackets forgotten | wrap(np.arctan2(dy, dx) - x[2]) -> (np.arctan2(dy, dx) - x[2] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    sign of the bearing lost | wrap(np.arctan2(dy, dx) - x[2]) -> np.abs(wrap(np.arctan2(dy, dx) - x[2])) | Left and right are different directions: a bearing to the right is negative.
    range squared | e = np.array([r, -> e = np.array([r2, | Take the square root: the range is in metres.
    robot at the origin | x[l] - x[:2] -> x[l] | The differences begin at the robot: subtract its position, x[:2].
    the mapping Jacobian | -E_l, [0, -1], E_l -> 0, 0, E_l | That is H of notebook 02, where the pose was known. Now the pose is in the state: it has columns of its own, the first three.
    the localisation Jacobian | -E_l, [0, -1], E_l -> -E_l, [0, -1], 0 | The landmark is in the state, too: its block belongs in the columns l.
    heading column forgotten | [0, -1] -> [0, 0] | The bearing is measured from the robot's own axis: d bearing / d theta = -1. Without it a bearing says nothing of the heading itself.
    heading column positive | [0, -1] -> [0, 1] | Turn the robot to the left: the landmark moves to the right in its view. d bearing / d theta = -1.
    heading in the range | [0, -1] -> [-1, 0] | Turning on the spot changes no distance: d range / d theta = 0, d bearing / d theta = -1.
    heading in both rows | [0, -1] -> [-1, -1] | Turning on the spot changes no distance: d range / d theta = 0.
    heading in degrees | [0, -1] -> [0, -180 / np.pi] | The column of the heading is in degrees: keep to radians.
    same sign for robot and landmark | = -E_l, -> = E_l, | What the robot moves one way looks as if the landmark moved the other way: the position columns of the robot are minus those of the landmark, in both rows.
    signs swapped | -E_l, [0, -1], E_l -> E_l, [0, -1], -E_l | The signs of robot and landmark are exchanged: dr/dx_l = +dx/r.
    position columns zero | = -E_l, -> = 0, | A robot that moves sees the landmark at another range: the first two columns are -E_l.
    r for r^2 | [-dy / r2, dx / r2] -> [-dy / r, dx / r] | The bearing row is divided by r^2, not by r.
    r^2 for r | [dx / r, dy / r] -> [dx / r2, dy / r2] | The range row is divided by r, not by r^2: it is a unit vector.
    minus sign forgotten | [-dy / r2 -> [dy / r2 | d bearing / d x_l = -dy / r^2: the lower left entry of the block has a minus sign.
    sign of the bearing row | [-dy / r2, dx / r2] -> [dy / r2, -dx / r2] | d bearing / d x_l = -dy/r^2 and d bearing / d y_l = +dx/r^2.
    dx and dy swapped | [-dy / r2, dx / r2] -> [-dx / r2, dy / r2] | In the bearing row dy stands in the x column and dx in the y column: [-dy, dx] / r^2.
    block transposed | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[dx / r, -dy / r2], [dy / r, dx / r2]] | The first row is the derivative of the range, by x and by y: your block is transposed.
    rows swapped | return e, H -> return e, H[::-1] | The first row of H is the derivative of the range, the second that of the bearing.
    turned by theta | H = np.zeros -> c, s = np.cos(x[2]), np.sin(x[2]); E_l = E_l @ [[c, -s], [s, c]]; H = np.zeros | The state is in the map frame, and so are the columns of H: theta only shifts the bearing.
    only five columns | return e, H -> return e, np.hstack([H[:, :3], E_l]) | H has a column for each number of the state: put the blocks into a matrix of zeros, 2 x n.
    landmark right behind the robot | H[:, l] -> H[:, 3:5] | The landmark's block belongs in the columns l, not always in 3:5.
    H transposed | return e, H -> return e, H.T | Rows are outputs (range, bearing), columns are inputs (the state): H is 2 x n.
    the first landmark always | dx, dy = -> l = slice(3, 5); dx, dy = | The landmark asked for is x[l], not always x[3:5].
    columns instead of vectors | return e, -> return e[:, None], | Vectors have one axis here: e = np.array([r, beta]), no columns.
    bearing row of the robot exchanged | = -E_l, -> = [[-dx / r, -dy / r], [-dx / r2, dy / r2]], | In the robot's two columns the bearing row is [dy, -dx] / r^2: yours has the two entries exchanged.
    landmark with the sign of the robot | = -E_l, [0, -1], E_l -> = -E_l, [0, -1], -E_l | The difference is landmark minus robot: the columns of the landmark have the opposite sign of those of the robot, +E_l.
    always the last columns | H[:, l] = -> H[:, -2:] = | The landmark's block belongs in the columns l, not always in the last two.
    entries of the bearing row exchanged | [[dx / r, dy / r], [-dy / r2, dx / r2]] -> [[dx / r, dy / r], [dx / r2, -dy / r2]] | The bearing is an angle: d bearing / d x_l = -dy/r^2 comes first, then +dx/r^2.
    """,
)

OTHERS = "A measurement of one landmark does not depend on the others."


@observation.link("columns of the others", OTHERS, 1, "the world as a whole")
def _(f, rng):
    for n, at in ((9, 5), (11, 3)):
        H = expect.array(expect.results(f(*case(rng, n, at)), "e", "H")[1], (2, n), "H")
        others = np.delete(H[:, 3:], [at - 3, at - 2], axis=1)
        expect.true(not others.any(), "H is not zero in the columns of other landmarks")
