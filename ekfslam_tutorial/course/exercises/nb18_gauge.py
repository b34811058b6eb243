"""Exercise 18.3: several robots in one filter have one gauge."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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
    ates = [np.sqrt(np.mean(np.sum((k @ R.T + t - s) ** 2, axis=1))) for k, s in zip(paths, truths, strict=True)]
    return np.array([*t, theta]), np.array(ates)


def whole_turns(result):
    """Results with the angle in (-pi, pi], to compare answers that differ by whole turns."""
    F, ates = result
    F = np.array(F, float)
    return np.array([*F[:2], np.arctan2(np.sin(F[2]), np.cos(F[2]))]), ates


gauge = Exercise(
    "18.3",
    "Five trajectories, one gauge",
    align_all,
    canonical=whole_turns,
    hints=(
        "One filter has one frame, so there is one alignment. Put all positions of all robots into one long array.",
        "Then it is exercise 09.4: subtract the means, theta = arctan2(sum(a x b), sum(a . b)), "
        "t = mean(truth) - R mean(path). The mean is over all instants of all robots.",
        "ATE of robot i: move its own path by R and t, squared distance of each instant, mean, root.",
    ),
)


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


CASES = (((20, 7, 40), 0.7, 0.2), ((5, 5), -2.5, 0.5), ((3, 30, 4, 9, 12), 3.0, 0.3), ((12,), -1.0, 0.2))


def _two(result, k):
    F, ates = expect.results(result, "F", "ates")
    return expect.array(F, 3, "F"), expect.array(ates, k, "ates")


@gauge.link("two results", "The function must end with `return F, ates`: three numbers, and one for each robot.")
def _(f, rng):
    for sizes, turn, noise in CASES:
        _two(f(*case(rng, sizes, turn, noise)), len(sizes))


@gauge.link("no error", "Where paths and truths differ by a rigid motion only, F is that motion.", part=0)
def _(f, rng):
    for turn in (0.0, 0.9, -2.0):
        paths, truths = case(rng, (9, 4), turn, 0.0)
        F, ates = _two(f(paths, truths), 2)
        want = align_all(paths, truths)[0]
        expect.close(F[:2], want[:2], "[x, y] of F", 1e-5, 1e-6, at=f"a turn of {turn} rad")
        expect.angle(F[2], want[2], "theta of F", at=f"a turn of {turn} rad")
        expect.close(ates, [0, 0], "ates", 0, 1e-6, at="paths without errors")


@gauge.link(
    "one alignment", "One angle and one vector for all positions of all robots, each instant counting once.", part=0
)
def _(f, rng):
    for sizes, turn, noise in CASES:
        paths, truths = case(rng, sizes, turn, noise)
        F, want = _two(f(paths, truths), len(sizes))[0], align_all(paths, truths)[0]
        expect.angle(F[2], want[2], "theta of F", 1e-5, at=f"robots with {sizes} instants")
        expect.close(F[:2], want[:2], "[x, y] of F", 1e-5, at=f"robots with {sizes} instants")


@gauge.link("ATE of each robot", "The same F for all, then the error of each robot's own instants.", part=1)
def _(f, rng):
    for sizes, turn, noise in CASES:
        paths, truths = case(rng, sizes, turn, noise)
        got = _two(f(paths, truths), len(sizes))[1]
        expect.close(got, align_all(paths, truths)[1], "ates", 1e-5, at=f"robots with {sizes} instants")


@gauge.link(
    "robots out of place", "A robot that lies wrong to the others is an error: no alignment may hide it.", part=1
)
def _(f, rng):
    paths, truths = case(rng, (10, 10), 0.4, 0.0)
    truths[1] = truths[1] + [3.0, 0.0]
    got = _two(f(paths, truths), 2)[1]
    expect.close(got, align_all(paths, truths)[1], "ates", 1e-5, at="a second robot that is 3 m out of place")


def _frame(p, q):
    return align_all([p], [q])[0]


def _apart(F, paths, truths, error=lambda d: np.sqrt(np.mean(d**2))):
    c, s = np.cos(F[2]), np.sin(F[2])
    R = np.array([[c, -s], [s, c]])
    return np.array([error(np.linalg.norm(p @ R.T + F[:2] - q, axis=1)) for p, q in zip(paths, truths, strict=True)])


def _wrong(name, hint, F=None, ates=None):
    """A misconception in F(paths, truths) or in ates(F, paths, truths)."""

    @gauge.wrong(name, hint)
    def _(paths, truths):
        frame = np.asarray(F(paths, truths)) if F else align_all(paths, truths)[0]
        return frame, ates(frame, paths, truths) if ates else _apart(frame, paths, truths)


def _means(paths, truths):
    return align_all([np.array([p.mean(0) for p in paths])], [np.array([q.mean(0) for q in truths])])[0]


def _robots_alike(paths, truths):
    """Each robot counts the same, however many instants it has."""
    w = np.concatenate([np.full(len(p), 1 / len(p)) for p in paths])[:, None] / len(paths)
    p, q = np.concatenate(paths), np.concatenate(truths)
    mp, mq = (w * p).sum(0), (w * q).sum(0)
    a, b = p - mp, q - mq
    theta = np.arctan2(np.sum(w[:, 0] * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), np.sum(w * a * b))
    R = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    return [*(mq - R @ mp), theta]


def _back(F):
    c, s = np.cos(F[2]), np.sin(F[2])
    return np.array([*(-np.array([[c, s], [-s, c]]) @ F[:2]), -F[2]])


# fmt: off
_wrong("each robot on its own", "One filter has one frame. If each path gets an alignment of its own, 15 numbers are "
       "free instead of 3, and robots that lie wrong to each other look right.",
       ates=lambda F, p, t: np.array([_apart(_frame(a, b), [a], [b])[0] for a, b in zip(p, t, strict=True)]))
_wrong("aligned by the first robot", "Robot 1 alone does not tell how the others lie, and its own errors tilt them "
       "all: use all positions.", F=lambda p, t: _frame(p[0], t[0]))
_wrong("mean of five alignments", "Frames cannot be averaged number by number. Put all positions together, then align "
       "once.", F=lambda p, t: np.mean([_frame(a, b) for a, b in zip(p, t, strict=True)], axis=0))
_wrong("means of the robots", "The mean of each path throws away how it is turned. Use all positions.",
       F=lambda p, t: _means(p, t) if len(p) > 1 else [0, 0, 0])
_wrong("every robot counts the same", "Least squares over all positions: each instant counts once, so a long path "
       "counts more.", F=_robots_alike)
_wrong("not aligned", "The filter chose its own frame: find the one motion first.", F=lambda p, t: [0.0, 0, 0])
_wrong("moved, not turned", "The heading of the first robot is the x axis of the map: find the angle, too.",
       F=lambda p, t: [*(np.concatenate(t).mean(0) - np.concatenate(p).mean(0)), 0])
_wrong("truth laid on the path", "F takes a position of the filter to the survey, not back.",
       F=lambda p, t: _back(align_all(p, t)[0]), ates=lambda F, p, t: align_all(p, t)[1])
_wrong("difference of the means", "t = mean(truth) - R mean(path): the mean of the paths turns, too.",
       F=lambda p, t: [*(np.concatenate(t).mean(0) - np.concatenate(p).mean(0)), align_all(p, t)[0][2]])
_wrong("angle with the wrong sign", "Your angle turns the truth to the paths.",
       F=lambda p, t: align_all(p, t)[0] * [1, 1, -1])
_wrong("angle in degrees", "Angles are in radians everywhere.",
       F=lambda p, t: align_all(p, t)[0] * [1, 1, 180 / np.pi], ates=lambda F, p, t: align_all(p, t)[1])
_wrong("mean distance", "ATE is the root of the mean *square*: large errors count more.",
       ates=lambda F, p, t: _apart(F, p, t, np.mean))
_wrong("no root", "That is the mean squared distance, in square metres. Take the root.",
       ates=lambda F, p, t: _apart(F, p, t, lambda d: np.mean(d**2)))
_wrong("mean over x and y", "One distance for each instant: add x and y before the mean.",
       ates=lambda F, p, t: _apart(F, p, t, lambda d: np.sqrt(np.mean(d**2) / 2)))
_wrong("one number for all", "One ATE for each robot: use its own instants.",
       ates=lambda F, p, t: np.full(len(p), _apart(F, [np.concatenate(p)], [np.concatenate(t)])[0]))
# fmt: on


@gauge.variant("SVD")
def _(paths, truths):
    p, q = np.vstack(paths), np.vstack(truths)
    U, _, Vt = np.linalg.svd((q - q.mean(0)).T @ (p - p.mean(0)))
    R = U @ np.diag([1, np.linalg.det(U @ Vt)]) @ Vt
    t = q.mean(0) - R @ p.mean(0)
    ates = [float(np.linalg.norm(a @ R.T + t - b) / np.sqrt(len(a))) for a, b in zip(paths, truths, strict=True)]
    return [*t.tolist(), float(np.arctan2(R[1, 0], R[0, 0]))], ates


@gauge.variant("complex numbers, a whole turn more")
def _(paths, truths):
    p, q = ([a[:, 0] + 1j * a[:, 1] for a in some] for some in (paths, truths))
    all_p, all_q = np.concatenate(p), np.concatenate(q)
    u = np.sum(np.conj(all_p - all_p.mean()) * (all_q - all_q.mean()))
    u = u / abs(u)
    t = all_q.mean() - u * all_p.mean()
    ates = [np.sqrt(np.mean(abs(u * a + t - b) ** 2)) for a, b in zip(p, q, strict=True)]
    return np.array([t.real, t.imag, np.angle(u) + 2 * np.pi]), np.array(ates)


@gauge.variant("the package")
def _(paths, truths):
    from ...geometry import align

    F = align(np.concatenate(paths), np.concatenate(truths))
    return F.x, [np.sqrt(((F.from_frame(p)[0] - q) ** 2).sum(1).mean()) for p, q in zip(paths, truths, strict=True)]
