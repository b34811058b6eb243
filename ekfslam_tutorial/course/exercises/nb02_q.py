"""Exercise 02.3: the landmark initialisation function q and its Jacobian."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..table import table
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


def random_pose(rng):
    """Return some pose [x, y, theta]."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)])


def random_y(rng):
    """Return some measurement [range, bearing]."""
    return np.array([rng.uniform(0.5, 6), rng.uniform(-3, 3)])


def landmark_of(y, x_r):
    """Return the landmark without its Jacobian."""
    return q(y, x_r)[0]


born = table(
    "02.3 The initialisation function q and its Jacobian",
    q,
    hints=(
        "In which direction of the map does the robot look when it looks at the landmark? Two angles add up.",
        "With a = theta + beta: l = x_r + r [cos a, sin a]. Differentiate it by r (first column), then by beta.",
        "The columns of L_y are [cos a, sin a] and r [-sin a, cos a].",
    ),
    returns="l, L_y",
    jacobians={"L_y": "l"},
    entries={"l": "x_l, y_l", "y": "range, bearing"},
    cases={
        "any": lambda rng: [(random_y(rng), random_pose(rng)) for _ in range(6)],
        "origin": lambda rng: [(np.array(y), np.zeros(3)) for y in ([2.0, 0.0], [3.0, np.pi / 2], [1.5, -2.5])],
        "ahead": lambda rng: [(random_y(rng), np.array([*rng.uniform(-3, 3, 2), 0.0])) for _ in range(2)],
    },
    checks="""
    robot at the origin   | l         | origin | For a robot at the origin with theta = 0, from polar to Cartesian: x_l = r cos(beta), y_l = r sin(beta), with y = [r, beta].
    position of the robot | l         | ahead  | The range is counted from the robot, the map from its own origin.
    heading of the robot  | l         | any    | The bearing is counted from the heading theta of the robot.
    derivative            | d L_y / y | any    | First column: dl/d range, the unit vector along the line of sight. Second column: dl/d bearing, a quarter turn to the left of the first; its length is the range.
    """,
    wrong="""
    heading forgotten | l = np.array([x_r[0] + r * c, x_r[1] + r * s]) -> l = x_r[:2] + r * np.array([np.cos(y[1]), np.sin(y[1])]) | beta is counted from the robot's heading. In the map the direction is theta + beta.
    heading subtracted | l = np.array([x_r[0] + r * c, x_r[1] + r * s]) -> l = x_r[:2] + r * np.array([np.cos(x_r[2] - y[1]), np.sin(x_r[2] - y[1])]) | A landmark seen to the left (beta > 0) lies in the direction theta *plus* beta.
    bearing minus heading | l = np.array([x_r[0] + r * c, x_r[1] + r * s]) -> l = x_r[:2] + r * np.array([np.cos(y[1] - x_r[2]), np.sin(y[1] - x_r[2])]) | h subtracts theta, so q must add it: the direction in the map is theta + beta.
    bearing forgotten | l = np.array([x_r[0] + r * c, x_r[1] + r * s]) -> l = x_r[:2] + r * np.array([np.cos(x_r[2]), np.sin(x_r[2])]) | The landmark is not straight ahead: its direction in the map is theta + beta.
    robot position forgotten | [x_r[0] + r * c, x_r[1] + r * s] -> [r * c, r * s] | That is the landmark as seen from the robot. Add the robot's own position.
    robot position subtracted | [x_r[0] + r * c, x_r[1] + r * s] -> [r * c - x_r[0], r * s - x_r[1]] | Walk from the map's origin to the robot, then to the landmark: the two vectors add up.
    heading less bearing, in both: A landmark seen to the left (beta > 0) lies in the direction theta *plus* beta: in l, and so in L_y.
        y[1] + x_r[2] -> x_r[2] - y[1]
        [[c, -r * s], [s, r * c]] -> [[c, r * s], [s, -r * c]]
    behind the robot | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] - r * c, x_r[1] - r * s] | The landmark lies ahead, in the direction theta + beta: r [cos a, sin a] is added to the robot's position, not subtracted.
    sine and cosine swapped | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * s, x_r[1] + r * c] | x goes with the cosine, y with the sine.
    y mirrored | x_r[1] + r * s] -> x_r[1] - r * s] | The sign of the sine is wrong: bearings count to the left.
    degrees converted | y[1] + x_r[2] -> np.radians(y[1] + x_r[2]) | All angles are in radians already: no conversion.
    range and bearing swapped | r, a = y[0], y[1] + x_r[2] -> r, a = y[1], y[0] + x_r[2] | y = [range, bearing]: the range comes first.
    column | return l, L_y -> return l[:, None], L_y | Vectors have one axis here: np.array([x, y]), no columns.
    transposed | [[c, -r * s], [s, r * c]] -> [[c, s], [-r * s, r * c]] | Rows are outputs (x_l, y_l), columns are inputs (range, bearing): yours is the transpose.
    r forgotten in the bearing column | [[c, -r * s], [s, r * c]] -> [[c, -s], [s, c]] | An error of the bearing moves the landmark by r times that angle: the second column has the factor r.
    minus sign forgotten | [[c, -r * s] -> [[c, r * s] | The derivative of the cosine is *minus* the sine.
    heading forgotten in L_y | L_y = np -> c, s = np.cos(y[1]), np.sin(y[1]); L_y = np | The angle in L_y is the same as in l: theta + beta.
    columns swapped | [[c, -r * s], [s, r * c]] -> [[-r * s, c], [r * c, s]] | The first column is the derivative by the range, the second by the bearing.
    the inverse, H instead of L_y | [[c, -r * s], [s, r * c]] -> [[c, s], [-s / r, c / r]] | That is the derivative of the measurement by the landmark, H. Here it is the other way round: dl/dy.
    diagonal | [[c, -r * s], [s, r * c]] -> [[c, 0.0], [0.0, r * c]] | Both x_l and y_l depend on both range and bearing: no entry is zero in general.
    derivative by the pose | [[c, -r * s], [s, r * c]] -> [[1, 0, -r * s], [0, 1, r * c]] | That is dl/dx_r (2 x 3): the pose is known here, the noise is in y. Differentiate by y.
    arm from the origin | [[c, -r * s], [s, r * c]] -> [[c, -l[1]], [s, l[0]]] | A wrong bearing turns the landmark about the robot, not about the origin: the second column is r [-sin, cos].
    second column divided by r | [[c, -r * s], [s, r * c]] -> [[c, -s / r], [s, c / r]] | The second column is multiplied by r, not divided by it: the further the landmark, the more metres an error of the bearing makes.
    second column to the right | [[c, -r * s], [s, r * c]] -> [[c, r * s], [s, -r * c]] | A larger bearing turns the landmark to the left: the second column is r [-sin, cos].
    robot position turned, too | l = np.array([x_r[0] + r * c, x_r[1] + r * s]) -> k, w = np.cos(x_r[2]), np.sin(x_r[2]); l = np.array([[k, -w], [w, k]]) @ x_r[:2] + r * np.array([c, s]) | The robot's position is in the map frame already: turn what the robot sees, and add the position to it afterwards.
    """,
)


@born.link("q undoes h", "A measurement of the new landmark must give back y: h(q(y)) = y, and H L_y = I.")
def _(f, rng):
    for y in ([4.0, 3.1], [0.7, -3.1], [25.0, 0.5]):
        y, x_r = np.array(y), random_pose(rng)
        l, L_y = (np.asarray(part, float) for part in f(y, x_r))
        e, H = h(l, 0, x_r)
        expect.close([e[0], wrap(e[1] - y[1])], [y[0], 0.0], "h(q(y)), range and bearing - beta,")
        expect.close(H @ L_y, np.eye(2), "H L_y")
