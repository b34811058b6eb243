"""Exercise 18.3: several robots in one filter have one gauge."""

import numpy as np

from ..table import table


def align_all(paths, truths):
    """Lay the paths of several robots on the truth with one rigid motion for all, and say how far off each one is.

    paths and truths: lists with one array of shape (n_i, 2) for each robot: its positions at n_i instants, m, all paths
    in the frame of the one filter, all truths in that of the survey. The n_i may differ.
    Return F = [x, y, theta], shape (3,), the frame of the filter seen from the survey: p -> R(theta) p + [x, y] brings
    all positions of all robots as near to the truth as one rigid motion can (least squares); and the ATE of each
    robot, shape (number of robots,), m.
    """
    p, q = np.concatenate(paths), np.concatenate(truths)
    a, b = p - p.mean(axis=0), q - q.mean(axis=0)
    theta = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    R = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    t = q.mean(axis=0) - R @ p.mean(axis=0)
    d2 = [np.sum((k @ R.T + t - s) ** 2, axis=1) for k, s in zip(paths, truths, strict=True)]
    return np.array([*t, theta]), np.array([np.sqrt(np.mean(d)) for d in d2])


def case(rng, sizes=(20, 7, 40), turn=0.7, noise=0.2):
    """Return paths and truths of robots, each with an error of its own that stays over the whole path."""
    c, s = np.cos(turn), np.sin(turn)
    R, t = np.array([[c, -s], [s, c]]), rng.normal(size=2) * 4
    paths, truths = [], []
    for n in sizes:
        p = rng.normal(size=2) * 4 + np.cumsum(rng.normal(size=(n, 2)), axis=0) * [0.7, 0.4]
        paths.append(p)
        truths.append(p @ R.T + t + noise * (2 * rng.normal(size=2) + rng.normal(size=(n, 2))))
    return paths, truths


def second_apart(paths, truths):
    """The second robot 3 m out of place."""
    return paths, [truths[0], truths[1] + [3.0, 0.0]]


def mirrored(paths, truths):
    """Truths that are mirror images of the paths."""
    return paths, [p * [1.0, -1.0] for p in paths]


gauge = table(
    "18.3 Five trajectories, one gauge",
    align_all,
    hints=(
        "One filter has one frame, so there is one alignment. Put all positions of all robots into one long array.",
        "Then it is exercise 09.4: subtract the means, theta = arctan2(sum(a x b), sum(a . b)), t = mean(truth) - R mean(path). The mean is over all instants of all robots.",
        "ATE of robot i: move its own path by R and t, squared distance of each instant, mean, root.",
    ),
    returns="F, ates",
    angles={"F": 2},
    cases={
        "any": lambda rng: [
            case(rng, *c)
            for c in (((20, 7, 40), 0.7, 0.2), ((5, 5), -2.5, 0.5), ((3, 30, 4, 9, 12), 3.0, 0.3), ((12,), -1.0, 0.2))
        ],
        "no error": lambda rng: [case(rng, (9, 4), turn, 0.0) for turn in (0.0, 0.9, -2.0)],
        "mirrored": lambda rng: [mirrored(*case(rng, sizes)) for sizes in ((15, 6), (9,), (5, 4, 8))],
        "apart": lambda rng: [second_apart(*case(rng, (10, 10), 0.4, 0.0))],
    },
    checks="""
    no error            | F    | no error | Where paths and truths differ by a rigid motion only, F is that motion: theta in all four quadrants, t = mean(truth) - R mean(path).
    one alignment       | F    | any      | Here the paths have errors, and F is the least-squares motion: one angle and one vector for all positions of all robots. In each mean and each sum every instant of every robot counts once.
    no mirror           | F    | mirrored | The truths are mirror images of the paths here. A rigid motion never mirrors: of all R with determinant +1, F has the one that brings the positions nearest (least squares).
    ATE of each robot   | ates | any      | The same F for all: move each path by it. Then the root of the mean squared distance over the robot's own instants.
    robots out of place | ates | apart    | A robot that lies wrong to the others is an error: no alignment may hide it.
    """,
    wrong="""
    each robot on its own: One filter has one frame. If each path gets an alignment of its own, 15 numbers are free instead of 3, and robots that lie wrong to each other look right.
        np.array([np.sqrt(np.mean(d)) for d in d2]) -> _each_alone(paths, truths)
    aligned by the first robot | p, q = np.concatenate(paths), np.concatenate(truths) -> p, q = paths[0], truths[0] | Robot 1 alone does not tell how the others lie, and its own errors tilt them all: use all positions.
    mean of five alignments | d2 = [np -> t, theta, R = _mean_of_frames(paths, truths); d2 = [np | Frames cannot be averaged number by number. Put all positions together, then align once.
    means of the robots | p, q = np.concatenate(paths), np.concatenate(truths) -> p, q = (np.array([k.mean(0) for k in some]) for some in (paths, truths)) | The mean of each path throws away how it is turned. Use all positions.
    every robot counts the same | d2 = [np -> t, theta, R = _robots_alike(paths, truths); d2 = [np | Least squares over all positions: each instant counts once, so a long path counts more.
    not aligned | d2 = [np -> t, theta, R = np.zeros(2), 0.0, np.eye(2); d2 = [np | The filter chose its own frame: find the one motion first.
    moved, not turned | theta = np.arctan2( -> theta = 0 * np.arctan2( | The heading of the first robot is the x axis of the map: find the angle, too.
    truth laid on the path | np.array([*t, theta]) -> np.array([*(-R.T @ t), -theta]) | F takes a position of the filter to the survey, not back.
    difference of the means | R @ p.mean(axis=0) -> p.mean(axis=0) | t = mean(truth) - R mean(path): the mean of the paths turns, too.
    angle with the wrong sign | theta = np.arctan2( -> theta = -np.arctan2( | Your angle turns the truth to the paths.
    angle in degrees | [*t, theta] -> [*t, np.degrees(theta)] | Angles are in radians everywhere.
    plain arctan | theta = np.arctan2( -> theta = (lambda y, x: np.arctan(y / x))( | np.arctan cannot tell an angle from the opposite one: np.arctan2 takes both sums.
    mirror allowed | t = q.mean -> R = _orthogonal(a, b); theta = np.arctan2(R[1, 0], R[0, 0]); t = q.mean | The SVD may give a mirror image. The determinant of R must be +1.
    each path moved to its truth | (k @ R.T + t - s) ** 2 -> (k @ R.T - s - np.mean(k @ R.T - s, axis=0)) ** 2 | One motion for all robots: do not take the mean error of each off, it belongs to its ATE.
    mean distance | np.sqrt(np.mean(d)) -> np.mean(np.sqrt(d)) | ATE is the root of the mean *square*: large errors count more.
    no root | np.sqrt(np.mean(d)) -> np.mean(d) | That is the mean squared distance, in square metres. Take the root.
    mean over x and y | np.mean(d) -> np.mean(d) / 2 | One distance for each instant: add x and y before the mean.
    one number for all | for d in d2]) -> for d in [np.concatenate(d2)] * len(d2)]) | One ATE for each robot: use its own instants.
    each centred on its own | a, b = p - p.mean(axis=0), q - q.mean(axis=0) -> a, b = (np.concatenate([k - k.mean(axis=0) for k in some]) for some in (paths, truths)) | One rigid motion for all: subtract the mean of all positions of all robots, not that of each robot.
    divided by all positions | np.mean(d) -> np.sum(d) / len(p) | Each robot has its own n_i: the mean over its own positions.
    not centred | a, b = p - p.mean(axis=0), q - q.mean(axis=0) -> a, b = p, q | A rotation is found about the means: take them off before the angle, else the place of the paths counts as a turn.
    mean of the means | a, b = p - p.mean(axis=0), q - q.mean(axis=0) -> p0, q0 = (np.mean([k.mean(axis=0) for k in some], axis=0) for some in (paths, truths)); a, b = p - p0, q - q0 | Each instant counts once: the mean of all positions, not the mean of the robots' means.
        t = q.mean(axis=0) - R @ p.mean(axis=0) -> t = q0 - R @ p0
    with a scale | R = np.array -> scale = np.hypot(np.sum(a * b), np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])) / np.sum(a * a); R = scale * np.array | A rigid motion has no scale: ranges fix it, and a free one hides errors.
    """,
)


def _orthogonal(a, b):
    """The best rotation or mirror image."""
    U, _, Vt = np.linalg.svd(b.T @ a)
    return U @ Vt


def _each_alone(paths, truths):
    return np.array([align_all([p], [q])[1][0] for p, q in zip(paths, truths, strict=True)])


def _mean_of_frames(paths, truths):
    *t, theta = np.mean([align_all([p], [q])[0] for p, q in zip(paths, truths, strict=True)], axis=0)
    c, s = np.cos(theta), np.sin(theta)
    return np.array(t), theta, np.array([[c, -s], [s, c]])


def _robots_alike(paths, truths):
    """Each robot counts the same, however many instants it has."""
    w = np.concatenate([np.full(len(p), 1 / len(p)) for p in paths])[:, None] / len(paths)
    p, q = np.concatenate(paths), np.concatenate(truths)
    mp, mq = (w * p).sum(0), (w * q).sum(0)
    a, b = p - mp, q - mq
    theta = np.arctan2(np.sum(w[:, 0] * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), np.sum(w * a * b))
    c, s = np.cos(theta), np.sin(theta)
    R = np.array([[c, -s], [s, c]])
    return mq - R @ mp, theta, R
