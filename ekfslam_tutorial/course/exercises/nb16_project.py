"""Exercise 16.1: what a range-only sensor measures of a point."""

import numpy as np

from ..table import table


def beacon_project(p):
    """Range of points, and its derivative by the point.

    p, shape (..., 2): points in the frame of the sensor (m). The dots stand for any number of leading axes, also none:
    one point has the shape (2,), a list of n points (n, 2).
    Return y, shape (..., 1): the ranges (m), and Y_p, shape (..., 1, 2): the Jacobian of each.
    """
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    Y_p = (np.asarray(p) / r)[..., None, :]
    return r, Y_p


def some(rng, lead=(), scale=1.0):
    """Points on all sides of the sensor, 1 to 6 m away."""
    a, r = rng.uniform(-np.pi, np.pi, lead), scale * rng.uniform(1, 6, lead)
    return np.stack([r * np.cos(a), r * np.sin(a)], -1)


ranged = table(
    "16.1 The direct model of a range",
    beacon_project,
    hints=(
        "The range is the length of the vector. How does the length change when the point moves along x, or along y?",
        "y = sqrt(px^2 + py^2), Y_p = [px / y, py / y]. Sum over the last axis, axis=-1, and keep it as an axis.",
        "r = np.linalg.norm(p, axis=-1, keepdims=True) has the shape (..., 1); (p / r)[..., None, :] has (..., 1, 2).",
    ),
    returns="y, Y_p",
    jacobians={"Y_p": "y"},
    entries={"y": "y", "p": "px, py"},
    cases={
        "any": lambda rng: [(p,) for p in (np.array([3.0, 4]), np.array([-5.0, 12]), some(rng), some(rng, (), 30))],
        "many": lambda rng: [(some(rng, lead),) for lead in ((5,), (2, 3), (2,), (1,))],
    },
    checks="""
    range       | y         | any  | The range is the length of the vector, sqrt(px^2 + py^2): one point of shape (2,) gives y of shape (1,).
    Jacobian    | d Y_p / p | any  | When the point moves away by 1 m, along the line of sight, the range grows by 1 m: Y_p is p / |p|. One point gives Y_p of shape (1, 2).
    many points | y, Y_p | many | Each point has its own range and its own row of Y_p: p (5, 2) gives y (5, 1) and Y_p (5, 1, 2), and p / y divides each point by its own range. p[..., 0], and norms with axis=-1, take any number of leading axes.
    """,
    wrong="""
    squared range | return r, Y_p -> return r**2, 2 * r[..., None] * Y_p | That is the square of the range. Take the root.
    root forgotten | return r, -> return r**2, | That is the square of the range: the root is missing in y.
    city blocks | return r, -> return np.abs(p).sum(-1, keepdims=True), | |px| + |py| is the way round the corner. A range is the straight line.
    unit vector forgotten | np.asarray(p) / r -> np.asarray(p) | dr/dp is a *unit* vector: p / r, not p.
    divided by the square | np.asarray(p) / r -> np.asarray(p) / r**2 | dr/dp = p / r. Check the units: metres per metre, so no r^2.
    derivative of the bearing | np.asarray(p) / r -> np.stack([-p[..., 1], p[..., 0]], -1) / r**2 | [-py, px] / r^2 is the derivative of the bearing. The range grows *along* the line of sight.
    across the line of sight | np.asarray(p) / r -> np.stack([-p[..., 1], p[..., 0]], -1) / r | A step across the line of sight changes nothing. Y_p points along it: p / r.
    Jacobian of the square | np.asarray(p) / r -> 2 * np.asarray(p) | 2 p is the derivative of the squared range. The range itself has p / r.
    towards the sensor | np.asarray(p) / r -> -np.asarray(p) / r | The sign: a point that moves away has a larger range.
    half of it | np.asarray(p) / r -> np.asarray(p) / (2 * r) | The inner derivative of the square, 2 px, cancels the 1/2 of the root: p / r.
    one point only | r = np.linalg.norm(p, axis=-1, keepdims=True) -> r = np.atleast_1d(np.hypot(p[0], p[1])) | p[0] is the first *point* of a list, and the first number of one point. Write p[..., 0].
    a column | [..., None, :] -> [..., None] | Rows are outputs, columns are inputs: one row and two columns for each point, shape (..., 1, 2).
    no axis for the row | (np.asarray(p) / r)[..., None, :] -> np.asarray(p) / r | The Jacobian of one number by two has one row and two columns: shape (..., 1, 2).
    mean for the sum | r = np.linalg.norm(p, axis=-1, keepdims=True) -> r = np.sqrt(np.mean(np.square(p), axis=-1, keepdims=True)) | The length of a vector is the root of the *sum* of the squares, not of their mean.
    twice the derivative | Y_p = (np.asarray(p) / r) -> Y_p = (2 * np.asarray(p) / r) | dr/dp = p / r, a vector of length one: yours is twice as long.
    without its sign | Y_p = (np.asarray(p) / r) -> Y_p = (np.abs(np.asarray(p)) / r) | The sign of p counts: towards the beacon the range falls, away from it it grows.
    """,
)
