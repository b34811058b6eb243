"""Exercise 09.4: absolute trajectory error after the best rigid motion."""

import numpy as np

from ..table import table


def ate(path, truth):
    """Lay a path on the truth as well as a rigid motion can, and return its error.

    path and truth, shape (n, 2): positions at the same n instants, m, each in its own frame. Both x and y of all
    points turn by one angle and move by one vector; no scale, no mirror.
    Return the path seen from the frame of the truth, shape (n, 2), and the ATE: the root of the mean squared
    distance between the two, m.
    """
    a, b = path - path.mean(axis=0), truth - truth.mean(axis=0)
    turn = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s], [s, c]])
    aligned = a @ R.T + truth.mean(axis=0)
    d2 = np.sum((aligned - truth) ** 2, axis=1)
    return aligned, np.sqrt(np.mean(d2))


def case(rng, n, turn, noise, scale=1.0):
    """Return a path and its truth in another frame, with noise."""
    path = scale * (np.cumsum(rng.normal(size=(n, 2)), axis=0) * [1.5, 0.7] + rng.normal(size=2) * 5)
    c, s = np.cos(turn), np.sin(turn)
    return path, path @ np.array([[c, s], [-s, c]]) + scale * (rng.normal(size=2) * 3 + noise * rng.normal(size=(n, 2)))


def moved(path, truth):
    """Return the whole path turned by a right angle and moved."""
    return path @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + [30.0, -7.0], truth


def _on_itself(path, truth):
    return path, path.copy()


def _mirrored(path, truth):
    return path, path * [1.0, -1.0]


trajectory = table(
    "09.4 ATE after alignment",
    ate,
    hints=(
        "Shift both paths so that their mean is zero. Then only an angle is left to find.",
        "The best angle has the tangent sum(a x b) / sum(a . b), with a and b the shifted points: use arctan2. np.linalg.svd of b.T @ a does it, too; then see that the determinant is +1.",
        "aligned = R a + mean(truth) for each point. ATE: squared distance of each point, mean, root.",
    ),
    returns="aligned, ate",
    cases={
        "any": lambda rng: [
            case(rng, *what)
            for what in ((20, 0.6, 0.3), (8, 2.5, 0.5, 10), (30, -3.0, 1.0, 0.1), (3, -1.2, 0.2), (2, 0.7, 0.1))
        ],
        "same": lambda rng: [_on_itself(*case(rng, 9, 0.0, 0.0))],
        "mirrored": lambda rng: [_mirrored(*case(rng, 12, 0.0, 0.0)), _mirrored(*case(rng, 5, 0.0, 0.0))],
        "moved": lambda rng: [moved(*case(rng, 15, 0.8, 0.4))],
    },
    checks="""
    identity  | aligned | same | A path that lies on the truth already must stay, with an ATE of zero.
    alignment | aligned | any  | One angle and one vector for all points: subtract the means, find the best angle, and put the mean of the path on the mean of the truth.
    no mirror | aligned | mirrored | The truth is the mirror image of the path here. One angle and one vector make no mirror image: turn by the best angle, mean on mean, and a distance is left.
    no error  | ate | same     | The ATE is one number: the root of the mean squared distance. It is zero for a path that lies on the truth already.
    error     | ate | any      | Squared distance (x and y together) of each aligned point from its point of the truth, then the mean, then the root.
    gauge     | ate | moved    | The ATE must not change when the whole path is moved and turned.
    """,
    wrong="""
    not aligned | a @ R.T + truth.mean(axis=0) -> path | The map has its own origin and direction. Align first: nobody told the filter where the truth's frame is.
    moved, not turned | a @ R.T -> a | The direction of the start is not known either: find the angle, too.
    turned, not moved | a @ R.T + truth.mean(axis=0) -> path @ R.T | After the turn, put the mean of the path on the mean of the truth.
    turned about the origin | a @ R.T -> path @ R.T - path.mean(axis=0) | Subtract the mean of the path before you turn it.
    means over the wrong axis: axis=1 is the mean of the x and the y of each point. The mean of all points is that over axis=0.
        a, b = path - path.mean(axis=0), truth - truth.mean(axis=0) -> a, b = path - path.mean(axis=1, keepdims=True), truth - truth.mean(axis=1, keepdims=True)
        R.T + truth.mean(axis=0) -> R.T + truth.mean(axis=1, keepdims=True)
    means by n - 1: The mean of n points is their sum, divided by n, not by n - 1.
        a, b = path - path.mean(axis=0), truth - truth.mean(axis=0) -> m, t = (p.sum(axis=0) / (len(p) - 1) for p in (path, truth)); a, b = path - m, truth - t
        R.T + truth.mean(axis=0) -> R.T + t
    turned the wrong way | R.T -> R | Your angle has the wrong sign, or R is transposed: it turns truth to path.
    with a scale | a @ R.T -> np.sum(b * (a @ R.T)) / np.sum(a * a) * a @ R.T | Range measurements fix the scale: it is no gauge. A free scale hides errors.
    with the scale of the sizes | a @ R.T -> np.sqrt(np.sum(b * b) / np.sum(a * a)) * a @ R.T | Range measurements fix the scale: it is no gauge. A free scale hides errors.
    with the square of a scale | a @ R.T -> np.sum(b * b) / np.sum(a * a) * a @ R.T | Range measurements fix the scale: it is no gauge. A free scale hides errors.
    with the scale the other way | a @ R.T -> np.sum(a * a) / np.sum(b * (a @ R.T)) * a @ R.T | Range measurements fix the scale: it is no gauge. A free scale hides errors.
    mirror allowed | np.array([[c, -s], [s, c]]) -> _orthogonal(a, b) | The SVD may give a mirror image. The determinant of R must be +1.
    first points only | a, b = path - path.mean(axis=0), truth - truth.mean(axis=0) -> a, b = path - path[0], truth - truth[0] | Two points hold the noise of two points. Use all of them: least squares.
        np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b) -> a[1, 0] * b[1, 1] - a[1, 1] * b[1, 0], a[1] @ b[1]
        R.T + truth.mean(axis=0) -> R.T + truth[0]
    first and last point only | a, b = path - path.mean(axis=0), truth - truth.mean(axis=0) -> a, b = path - path[0], truth - truth[0] | Two points hold the noise of two points. Use all of them: least squares.
        np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b) -> a[-1, 0] * b[-1, 1] - a[-1, 1] * b[-1, 0], a[-1] @ b[-1]
        R.T + truth.mean(axis=0) -> R.T + truth[0]
    all from the first point: All points count alike: subtract the means, not the first points, for the angle and for the place.
        a, b = path - path.mean(axis=0), truth - truth.mean(axis=0) -> a, b = path - path[0], truth - truth[0]
        R.T + truth.mean(axis=0) -> R.T + truth[0]
    first point on first point | a @ R.T + truth.mean(axis=0) -> (path - path[0]) @ R.T + truth[0] | All points count alike: put mean on mean, not start on start.
    truth laid on the path | a @ R.T + truth.mean(axis=0) -> b @ R + path.mean(axis=0) | Return the path in the frame of the truth, not the other way round.
    plain arctan: np.arctan cannot tell an angle from the opposite one: np.arctan2 takes both sums.
        np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)) -> np.arctan(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / np.sum(a * b))
    turn in degrees: The functions of numpy take radians: no conversion.
        turn = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)) -> turn = np.degrees(np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)))
    mean distance | np.sqrt(np.mean(d2)) -> np.mean(np.sqrt(d2)) | ATE is the root of the mean *square*: large errors count more.
    mean over x and y | np.mean(d2) -> np.mean(d2) / 2 | One distance per point: add x and y before the mean, so divide by n, not by 2 n.
    no root | np.sqrt(np.mean(d2)) -> np.mean(d2) | That is the mean squared distance, in square metres. Take the root.
    no mean | np.mean(d2) -> np.sum(d2) | That grows with the length of the path: take the mean of the squares.
    largest error | np.mean(d2) -> np.max(d2) | That is the worst point. ATE is an average over all.
    last point | np.mean(d2) -> d2[-1] | ATE is about the whole path, not about its end.
    median | np.mean(d2) -> np.median(d2) | ATE is a mean: every point counts, the far ones most.
    angle of the first and the last point | turn = np.arctan2( -> v, w = path[-1] - path[0], truth[-1] - truth[0]; turn = np.arctan2(w[1], w[0]) - np.arctan2(v[1], v[0]) + 0 * np.arctan2( | All points tell the angle, not the first and the last one alone.
    mean of the single angles: Least squares weighs each point by how far it is from the mean: sum the products first, then one arctan2. Yours counts the angles of all points alike.
        turn = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)) -> g = np.arctan2(b[:, 1], b[:, 0]) - np.arctan2(a[:, 1], a[:, 0]); turn = np.arctan2(np.sin(g).sum(), np.cos(g).sum())
    mean of the single angles, wrapped: Least squares weighs each point by how far it is from the mean: sum the products first, then one arctan2. Yours counts the angles of all points alike.
        turn = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b)) -> g = np.arctan2(b[:, 1], b[:, 0]) - np.arctan2(a[:, 1], a[:, 0]); turn = np.mean((g + np.pi) % (2 * np.pi) - np.pi)
    """,
    forms="""
    a turn and a shift | a @ R.T + truth.mean(axis=0) -> path @ R.T + (truth.mean(axis=0) - R @ path.mean(axis=0)) | R p + t
    """,
)


def _orthogonal(a, b):
    """The best rotation or mirror image."""
    U, _, Vt = np.linalg.svd(b.T @ a)
    return U @ Vt
