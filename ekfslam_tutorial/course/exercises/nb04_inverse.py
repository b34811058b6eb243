"""Exercise 04.1: where a new landmark is, and how it depends on the pose and on the measurement."""

import numpy as np

from ..table import table


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


def pose_and_measurement(rng):
    """Return a pose and a measurement at random."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)]), np.array([rng.uniform(1, 8), rng.uniform(-3, 3)])


def along_x(rng):
    """Return a pose that looks along the x axis, and a measurement."""
    x_r, y = pose_and_measurement(rng)
    return np.array([x_r[0], x_r[1], 0.0]), y


inverse = table(
    "04.1 A new landmark and its two Jacobians",
    inverse_observation,
    hints=(
        "The beam points in the direction a = theta + beta, seen from the map. All else is made of r, cos(a) and sin(a).",
        "Move the robot by 1 m: where does the landmark go? Now turn the robot by a small angle: the landmark moves along a circle of radius r. The same happens when the bearing changes.",
        "L_r = [[1, 0, -r sin(a)], [0, 1, r cos(a)]]. The last column of L_y is the last column of L_r.",
    ),
    returns="l, L_r, L_y",
    symbols="l = [x_l, y_l]",
    jacobians={"L_r": "l", "L_y": "l"},
    entries={"l": "x_l, y_l", "x_r": "x_r, y_r, theta", "y": "range, bearing"},
    cases={
        "any": lambda rng: [pose_and_measurement(rng) for _ in range(5)],
        "along x": lambda rng: [along_x(rng) for _ in range(3)],
    },
    checks="""
    the landmark, theta = 0 | l           | along x | A robot that looks along the x axis: l = x_r + r [cos(beta), sin(beta)].
    the landmark            | l           | any     | A robot turned by theta: which way does the beam point in the map, and from which point does it start?
    L_r                     | d L_r / x_r | any     | Differentiate l by the pose: three columns, by x, by y and by theta.
    L_y                     | d L_y / y   | any     | Differentiate l by the measurement: two columns, by the range and by the bearing.
    """,
    wrong="""
    heading forgotten | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.cos(y[1]), x_r[1] + r * np.sin(y[1])] | Without theta this is right only for a robot that looks along the x axis: the beam points in the direction theta + beta.
    bearing subtracted | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.cos(x_r[2] - y[1]), x_r[1] + r * np.sin(x_r[2] - y[1])] | Angles count counter-clockwise: a bearing to the left is added to the heading.
    bearing forgotten | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.cos(x_r[2]), x_r[1] + r * np.sin(x_r[2])] | The landmark is not straight ahead: the beam points in the direction theta + beta.
    sine and cosine swapped | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * s, x_r[1] + r * c] | cos belongs to x and sin to y.
    arm from the origin | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, -l[1]], [0, 1, l[0]]] | The robot turns about itself, not about the origin: the arm is l less the position of the robot, r c and r s.
    seen from the robot | [x_r[0] + r * c, x_r[1] + r * s] -> [r * c, r * s] | That is the landmark in a frame at the robot: add the robot's position.
    range subtracted | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] - r * c, x_r[1] - r * s] | The landmark is in front of the sensor: add r in the direction of the beam.
    angles taken as degrees | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.cos(np.radians(a)), x_r[1] + r * np.sin(np.radians(a))] | Angles are in radians already: no conversion from degrees is needed.
    columns instead of vectors | return l, -> return l[:, None], | Vectors have one axis here: l = np.array([x, y]), no columns.
    the pose is known | [[1, 0, -r * s], [0, 1, r * c]] -> [[0, 0, 0], [0, 0, 0]] | L_r = 0 says: the landmark does not depend on the pose. That was notebook 02; now the pose is uncertain and its error goes into the landmark.
    turning does not matter | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, 0], [0, 1, 0]] | Turn the robot by a small angle: the landmark swings along a circle of radius r. The last column of L_r is not zero.
    only theta in the last column | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, -r * np.sin(x_r[2])], [0, 1, r * np.cos(x_r[2])]] | In the last column of L_r, sin and cos are taken of the whole direction theta + beta.
    only beta in the last column | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, -r * np.sin(y[1])], [0, 1, r * np.cos(y[1])]] | In the last column of L_r, sin and cos are taken of the whole direction theta + beta.
    range forgotten in the last column | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, -s], [0, 1, c]] | A landmark twice as far away swings twice as much: the last column of L_r has a factor r.
    sine and cosine swapped in the last column | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, -r * c], [0, 1, r * s]] | d cos(a) = -sin(a) da: the sine stands in the row of x_l, the cosine in the row of y_l.
    sign of the last column | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, r * s], [0, 1, -r * c]] | d cos(a) = -sin(a) da and d sin(a) = +cos(a) da: check the signs in the last column of L_r.
    minus sign forgotten in L_r | [1, 0, -r * s] -> [1, 0, r * s] | d cos(a) = -sin(a) da: the upper right entry of L_r has a minus sign.
    position block negative | [[1, 0, -r * s], [0, 1, r * c]] -> [[-1, 0, -r * s], [0, -1, r * c]] | Move the robot by 1 m: the new landmark moves with it, not against it.
    position block turned: The robot's position is given in the map frame, and so is l: the first two columns of L_r are the identity.
        L_r = np.array([[1, 0, -r * s], [0, 1, r * c]]) -> u, v = np.cos(x_r[2]), np.sin(x_r[2]); L_r = np.array([[u, -v, -r * s], [v, u, r * c]])
    L_r transposed | return l, L_r, L_y -> return l, L_r.T, L_y | Rows are outputs (x_l, y_l), columns are inputs (x, y, theta): L_r is 2 x 3.
    heading column in degrees | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, np.radians(-r * s)], [0, 1, np.radians(r * c)]] | The last column of L_r is in metres per degree: keep to radians.
    L_y transposed | L_r, L_y -> L_r, L_y.T | Rows are outputs (x_l, y_l), columns are inputs (range, bearing): L_y is transposed.
    range forgotten in L_y | [[c, -r * s], [s, r * c]] -> [[c, -s], [s, c]] | A landmark twice as far away moves twice as much when the bearing changes: the last column of L_y has a factor r.
    heading forgotten in L_y | L_y = np -> c, s = np.cos(y[1]), np.sin(y[1]); L_y = np | In L_y, too, sin and cos are taken of the whole direction theta + beta.
    heading forgotten in the column of the bearing | [[c, -r * s], [s, r * c]] -> [[c, -r * np.sin(y[1])], [s, r * np.cos(y[1])]] | In the last column of L_y, too, sin and cos are taken of the whole direction theta + beta.
    heading forgotten in the column of the range | [[c, -r * s], [s, r * c]] -> [[np.cos(y[1]), -r * s], [np.sin(y[1]), r * c]] | In the first column of L_y, too, sin and cos are taken of the whole direction theta + beta.
    sign in L_y | [[c, -r * s] -> [[c, r * s] | d cos(a) = -sin(a) da: the upper right entry of L_y has a minus sign.
    columns of L_y swapped | [[c, -r * s], [s, r * c]] -> [[-r * s, c], [r * c, s]] | The order is range, then bearing, in y and in the columns of L_y.
    rotation transposed | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.cos(y[1] - x_r[2]), x_r[1] + r * np.sin(y[1] - x_r[2])] | From the robot into the map it is R(theta) = [[cos, -sin], [sin, cos]], not its transpose: theta is added to the bearing.
    sine and cosine of the bearing swapped | [x_r[0] + r * c, x_r[1] + r * s] -> [x_r[0] + r * np.sin(y[1] - x_r[2]), x_r[1] + r * np.cos(y[1] - x_r[2])] | In the frame of the robot the landmark is r [cos(beta), sin(beta)]: the cosine first.
    position block turned by the whole direction | [[1, 0, -r * s], [0, 1, r * c]] -> [[c, -s, -r * s], [s, c, r * c]] | The robot's position is given in the map frame, and so is l: the first two columns of L_r are the identity, not a rotation.
    derivative of the rotation transposed: dR/dtheta = [[-sin, -cos], [cos, -sin]] is not transposed: the last column of L_r is dR/dtheta p, with p the landmark in the frame of the robot.
        [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, r * np.sin(y[1] - x_r[2])], [0, 1, -r * np.cos(y[1] - x_r[2])]]
    factors of L_y exchanged: l = t + R p(y): R stands on the left in the derivative, too, L_y = R dp/dy. Matrices do not commute.
        L_y = np.array([[c, -r * s], [s, r * c]]) -> u, v, C, S = np.cos(y[1]), np.sin(y[1]), np.cos(x_r[2]), np.sin(x_r[2]); L_y = np.array([[u, -r * v], [v, r * u]]) @ [[C, -S], [S, C]]
    sign in the derivative by the bearing: d cos(beta) = -sin(beta) d beta: in dp/dy, the derivative in the frame of the robot, the upper right entry is -r sin(beta).
        L_y = np.array([[c, -r * s], [s, r * c]]) -> u, v, C, S = np.cos(y[1]), np.sin(y[1]), np.cos(x_r[2]), np.sin(x_r[2]); L_y = np.array([[C, -S], [S, C]]) @ [[u, r * v], [v, r * u]]
    bearing subtracted, in the Jacobians, too: Angles count counter-clockwise: a bearing to the left is added to the heading.
        r, a = y[0], x_r[2] + y[1] -> r, a = y[0], x_r[2] - y[1]
        [[c, -r * s], [s, r * c]] -> [[c, r * s], [s, -r * c]]
    rotation not derived | [[1, 0, -r * s], [0, 1, r * c]] -> [[1, 0, r * c], [0, 1, r * s]] | The last column of L_r is the derivative by theta: cos becomes -sin, and sin becomes cos.
    """,
    forms="""
    with a rotation | r, a = y[0], x_r[2] + y[1] -> u, v, p = np.cos(y[1]), np.sin(y[1]), y[0] * np.array([np.cos(y[1]), np.sin(y[1])]) | l = t + R p, and L_y = R dp/dy
        c, s = np.cos(a), np.sin(a) -> C = np.array([[np.cos(x_r[2]), -np.sin(x_r[2])], [np.sin(x_r[2]), np.cos(x_r[2])]])
        np.array([x_r[0] + r * c, x_r[1] + r * s]) -> x_r[:2] + C @ p
        np.array([[1, 0, -r * s], [0, 1, r * c]]) -> np.column_stack([np.eye(2), np.array([[-np.sin(x_r[2]), -np.cos(x_r[2])], [np.cos(x_r[2]), -np.sin(x_r[2])]]) @ p])
        np.array([[c, -r * s], [s, r * c]]) -> C @ np.array([[u, -y[0] * v], [v, y[0] * u]])
    """,
)
