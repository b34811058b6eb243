"""Exercise 01.2: the motion of the robot and its two Jacobians."""

import numpy as np

from ...models.motion import Unicycle  # noqa: F401  # one of the wrong answers
from ..table import table


def move(x, u, dt):
    """One step of the robot, and its derivatives by the pose and by the control.

    x = [x, y, theta] is the pose before the step, u = [v, w] the speed (m/s) and the turn rate (rad/s), dt the
    duration (s). The robot drives v dt straight ahead, the way it looks before the step; then it turns by w dt.
    Return the new pose x2, shape (3,), F_x = dx2/dx, shape (3, 3), and F_u = dx2/du, shape (3, 2).
    """
    d, c, s = u[0] * dt, np.cos(x[2]), np.sin(x[2])
    x2 = np.array([x[0] + d * c, x[1] + d * s, x[2] + u[1] * dt])
    F_x = np.array([[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]])
    F_u = np.array([[dt * c, 0], [dt * s, 0], [0, dt]])
    return x2, F_x, F_u


def some(rng, signs=((1, 1), (1, -1), (1, 1), (-1, -1), (1, -1), (-1, 1))):
    """Return steps of some poses, controls and durations; the control has these signs."""
    return [
        (
            np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)]),
            rng.uniform([0.3, 0.4], [2, 1.5]) * sign,
            rng.uniform(0.2, 2),
        )
        for sign in signs
    ]


def special(rng):
    """Return steps of a robot that stands still, turns on the spot, drives back, or turns fast."""
    controls = ([0.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 30.0])
    return [(some(rng)[0][0], np.array(u), dt) for u in controls for dt in (1.0, 0.05)]


motion = table(
    "01.2 The motion and its Jacobians",
    move,
    hints=(
        "Write the three lines of x2 on paper first. Then differentiate each line by x, y, theta, and by v, w.",
        "x2 = [x + v dt cos(theta), y + v dt sin(theta), theta + w dt], with the theta *before* the step. The third column of F_x holds the derivatives by theta.",
        "F_x = [[1, 0, -d s], [0, 1, d c], [0, 0, 1]] with d = v dt; F_u = [[dt c, 0], [dt s, 0], [0, dt]].",
    ),
    returns="x2, F_x, F_u",
    angles={"x2": 2},
    jacobians={"F_x": "x2", "F_u": "x2"},
    entries={"x2": "x, y, theta", "x": "x, y, theta", "u": "v, w"},
    cases={
        "any": some,
        "along": lambda rng: [
            (np.array([1.0, 2.0, 0.0]), np.array([v, 0.0]), dt) for v, dt in ((1.0, 1.0), (2.0, 0.5), (1.5, 0.1))
        ],
        "special": special,
    },
    checks="""
    the new heading      | x2[2]     | any     | theta + w dt: where w is positive, the robot turns to the left.
    straight along x     | x2        | along   | With theta = 0 and w = 0 the robot goes v dt along x: x grows by v dt, y and theta stay as they are.
    the new pose         | x2        | any     | The robot drives v dt straight ahead, the way it looks before the step: x + v dt cos(theta), y + v dt sin(theta).
    F_x                  | d F_x / x | any     | Differentiate each line of x2 by x, by y, and by theta.
    F_u                  | d F_u / u | any     | Differentiate each line of x2 by v and by w.
    special cases        | x2, F_x, F_u | special | The robot may also stand still, turn on the spot, drive back (v < 0) or turn fast: the same formulas hold for all v, w and dt, and need no division.
    """,
    wrong="""
    sine and cosine swapped | x[0] + d * c, x[1] + d * s -> x[0] + d * s, x[1] + d * c | x goes with the cosine, y with the sine.
    turned first | x[0] + d * c, x[1] + d * s -> x[0] + d * np.cos(x[2] + dt * u[1]), x[1] + d * np.sin(x[2] + dt * u[1]) | The robot drives first, the way it looks *before* the step, and then turns.
    half the turn first | x[0] + d * c, x[1] + d * s -> x[0] + d * np.cos(x[2] + dt * u[1] / 2), x[1] + d * np.sin(x[2] + dt * u[1] / 2) | The robot drives the way it looks *before* the step, not in the middle of the turn.
    arc | x2 = np.array([x[0] + d * c, x[1] + d * s, x[2] + u[1] * dt]) -> x2 = Unicycle().move(x, u, dt)[0] | Yours is the exact arc. Here the robot drives v dt straight ahead first, and then it turns.
    turned to the other side | x[2] + u[1] * dt -> x[2] - u[1] * dt | A positive w turns to the left: theta *plus* w dt.
    dt forgotten | x[0] + d * c, x[1] + d * s, x[2] + u[1] * dt -> x[0] + u[0] * c, x[1] + u[0] * s, x[2] + u[1] | v and w are per second: multiply both by dt.
    dt forgotten in the drive | x[0] + d * c, x[1] + d * s -> x[0] + u[0] * c, x[1] + u[0] * s | v is in m per second: the robot goes v dt.
    heading not used | x[0] + d * c, x[1] + d * s -> x[0] + d, x[1] | The robot drives the way it looks: v dt along x is right for theta = 0 only.
    dt forgotten in the turn | x[2] + u[1] * dt -> x[2] + u[1] | w is in rad per second: the heading grows by w dt.
    not turned | x[2] + u[1] * dt -> x[2] | After the step the robot looks another way: theta + w dt.
    degrees | x[0] + d * c, x[1] + d * s -> x[0] + d * np.cos(np.radians(x[2])), x[1] + d * np.sin(np.radians(x[2])) | The heading is in radians already: no conversion.
    turn in degrees | x[2] + u[1] * dt -> x[2] + np.radians(u[1] * dt) | The turn is in radians, like the heading: no conversion.
    driven backwards | x[0] + d * c, x[1] + d * s -> x[0] - d * c, x[1] - d * s | A positive v drives ahead: x *plus* v dt cos(theta).
    Jacobians after the move | [[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]] -> [[1, 0, -d * np.sin(x2[2])], [0, 1, d * np.cos(x2[2])], [0, 0, 1]] | You used the heading *after* the step in F_x and F_u. Differentiate at the pose before it.
        [[dt * c, 0], [dt * s, 0] -> [[dt * np.cos(x2[2]), 0], [dt * np.sin(x2[2]), 0]
    F_x after the move | [[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]] -> [[1, 0, -d * np.sin(x2[2])], [0, 1, d * np.cos(x2[2])], [0, 0, 1]] | You used the heading *after* the step in F_x. Differentiate at the pose before it.
    F_x transposed | return x2, F_x, F_u -> return x2, F_x.T, F_u | Rows are outputs, columns are inputs: yours is the transpose.
    F_x is the identity | [[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]] -> [[1, 0, 0], [0, 1, 0], [0, 0, 1]] | A small error of the heading moves the robot sideways by v dt: F_x has a third column.
    sign of the sine | [1, 0, -d * s] -> [1, 0, d * s] | The derivative of the cosine is *minus* the sine.
    derivative of the sine with a minus | [0, 1, d * c] -> [0, 1, -d * c] | The derivative of the sine is the cosine, with a plus.
    sine and cosine not differentiated | [[1, 0, -d * s], [0, 1, d * c] -> [[1, 0, d * c], [0, 1, d * s] | The third column of F_x is the derivative by theta: cos becomes -sin, sin becomes cos.
    diagonal of F_x forgotten | [[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]] -> [[0, 0, -d * s], [0, 0, d * c], [0, 0, 0]] | x2 = x + ...: the derivative of x2 by x is 1. The diagonal of F_x is 1, 1, 1.
    ones of the position forgotten | [[1, 0, -d * s], [0, 1, d * c], [0, 0, 1]] -> [[0, 0, -d * s], [0, 0, d * c], [0, 0, 1]] | x2 = x + ...: the derivative of x2 by x is 1. The diagonal of F_x is 1, 1, 1.
    dt forgotten in F_x | [[1, 0, -d * s], [0, 1, d * c] -> [[1, 0, -u[0] * s], [0, 1, u[0] * c] | The third column of F_x is the derivative by theta: v dt, not v, times -sin and cos.
    F_u after the move | [[dt * c, 0], [dt * s, 0] -> [[dt * np.cos(x2[2]), 0], [dt * np.sin(x2[2]), 0] | You used the heading *after* the step in F_u. Differentiate at the pose before it.
    dt forgotten in F_u | [[dt * c, 0], [dt * s, 0], [0, dt]] -> [[c, 0], [s, 0], [0, 1]] | x2 holds v dt and w dt: their derivatives by v and w have the factor dt.
    columns of F_u swapped | [[dt * c, 0], [dt * s, 0], [0, dt]] -> [[0, dt * c], [0, dt * s], [dt, 0]] | u = [v, w]: the first column is the derivative by v.
    v in F_u | [[dt * c, 0], [dt * s, 0], [0, dt]] -> [[d * c, 0], [d * s, 0], [0, u[1] * dt]] | The derivative of v dt cos(theta) by v is dt cos(theta): v itself is gone.
    sine and cosine swapped in F_u | [[dt * c, 0], [dt * s, 0] -> [[dt * s, 0], [dt * c, 0] | By v, the line of x becomes dt cos(theta), the line of y dt sin(theta).
    F_u transposed | return x2, F_x, F_u -> return x2, F_x, F_u.T | Rows are outputs, columns are inputs: F_u has shape (3, 2).
    column instead of vector | return x2, F_x, F_u -> return x2[:, None], F_x, F_u | Vectors have one axis here: x2 has shape (3,), no columns.
    entries of the heading column exchanged | [[1, 0, -d * s], [0, 1, d * c] -> [[1, 0, d * c], [0, 1, -d * s] | d cos = -sin belongs in the row of x, d sin = cos in the row of y: the two entries of the third column are exchanged.
    cosine for sine in the heading column | [[1, 0, -d * s], [0, 1, d * c] -> [[1, 0, -d * c], [0, 1, d * s] | d cos = -sin belongs in the row of x, d sin = cos in the row of y: in the third column yours has the cosine where the sine belongs, and the other way round.
    v left in F_u | [[dt * c, 0], [dt * s, 0], [0, dt]] -> [[d * c, 0], [d * s, 0], [0, dt]] | The derivative of v dt cos(theta) by v is dt cos(theta): v itself is gone.
    w left in F_u | [0, dt]]) -> [0, u[1] * dt]]) | The derivative of w dt by w is dt: w itself is gone.
    F_u multiplied by F_x | return x2, F_x, F_u -> return x2, F_x, F_x @ F_u | The robot drives first, then it turns: w moves no position, so F_u[0, 1] and F_u[1, 1] are 0. They are not if it turns before it drives, nor if F_u is multiplied by F_x.
    heading column in the axes of the robot | [[1, 0, -d * s], [0, 1, d * c] -> [[1, 0, 0], [0, 1, d] | The state is in the world: the way sideways, v dt, is turned with the heading: -v dt sin and v dt cos.
    dt forgotten in the turn of F_u | [0, dt]]) -> [0, 1]]) | x2 holds w dt: its derivative by w has the factor dt.
    """,
)
