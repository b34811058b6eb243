"""Exercise 09.4: absolute trajectory error after the best rigid motion."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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
    aligned = a @ np.array([[c, s], [-s, c]]) + truth.mean(axis=0)
    return aligned, np.sqrt(np.mean(np.sum((aligned - truth) ** 2, axis=1)))


trajectory = Exercise(
    "09.4",
    "ATE after alignment",
    ate,
    hints=(
        "Shift both paths so that their mean is zero. Then only an angle is left to find.",
        "The best angle has the tangent sum(a x b) / sum(a . b), with a and b the shifted points: use arctan2. "
        "np.linalg.svd of b.T @ a does it, too; then see that the determinant is +1.",
        "aligned = R a + mean(truth) for each point. ATE: squared distance of each point, mean, root.",
    ),
)


def case(rng, n, turn, noise, scale=1.0):
    """Return a path and its truth in another frame, with noise."""
    path = scale * (np.cumsum(rng.normal(size=(n, 2)), axis=0) * [1.5, 0.7] + rng.normal(size=2) * 5)
    c, s = np.cos(turn), np.sin(turn)
    return path, path @ np.array([[c, s], [-s, c]]) + scale * (rng.normal(size=2) * 3 + noise * rng.normal(size=(n, 2)))


def _two(result, n):
    aligned, error = expect.results(result, "aligned", "ate")
    return expect.array(aligned, (n, 2), "aligned"), float(expect.array(error, (), "ate"))


@trajectory.link("two results", "The function must end with `return aligned, ate`: an array and a number.")
def _(f, rng):
    for n in (2, 9, 30):
        _two(f(*case(rng, n, 0.5, 0.1)), n)


@trajectory.link("identity", "A path that lies on the truth already must stay, with an ATE of zero.")
def _(f, rng):
    path = case(rng, 9, 0.0, 0.0)[0]
    aligned, error = _two(f(path, path.copy()), 9)
    expect.close(aligned, path, "aligned", at="path = truth")
    expect.close(error, 0.0, "ate", atol=1e-6, at="path = truth")


@trajectory.link(
    "alignment", "One angle and one vector for all points: subtract the means, find the best angle.", part=0
)
def _(f, rng):
    for n, turn, noise, scale in (
        (20, 0.6, 0.3, 1),
        (8, 2.5, 0.5, 10),
        (30, -3.0, 1.0, 0.1),
        (3, -1.2, 0.2, 1),
        (2, 0.7, 0.1, 1),
    ):
        path, truth = case(rng, n, turn, noise, scale)
        expect.close(_two(f(path, truth), n)[0], ate(path, truth)[0], "aligned", 1e-5, at=f"a turn of {turn} rad")
    path = case(rng, 12, 0.0, 0.0)[0]
    mirrored = path * [1.0, -1.0]
    want = ate(path, mirrored)[0]
    expect.close(_two(f(path, mirrored), 12)[0], want, "aligned", 1e-5, at="a truth that is a mirror image")


@trajectory.link("error", "Squared distance (x and y together) of each point, then the mean, then the root.", part=1)
def _(f, rng):
    for n, turn, noise in ((20, 0.6, 0.3), (8, 2.5, 0.5), (40, -1.0, 0.05)):
        path, truth = case(rng, n, turn, noise)
        expect.close(_two(f(path, truth), n)[1], ate(path, truth)[1], "ate", at=f"{n} points")


@trajectory.link("gauge", "The ATE must not change when the whole path is moved and turned.", part=1)
def _(f, rng):
    path, truth = case(rng, 15, 0.8, 0.4)
    moved = case(rng, 15, 0.0, 0.0)[0] * 0 + path @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + [30.0, -7.0]
    expect.close(
        _two(f(moved, truth), 15)[1], ate(path, truth)[1], "ate", 1e-5, at="a path moved and turned as a whole"
    )


def _turned(path, truth, R):
    return (path - path.mean(0)) @ R.T + truth.mean(0)


def _best(path, truth, mirror=False):
    U, s, Vt = np.linalg.svd((truth - truth.mean(0)).T @ (path - path.mean(0)))
    D = np.diag([1.0, 1.0 if mirror else np.linalg.det(U @ Vt)])
    return U @ D @ Vt, np.sum(s * np.diag(D)) / np.sum((path - path.mean(0)) ** 2)


def _wrong(name, hint, aligned=None, error=None):
    """A misconception in aligned(path, truth) or in error(distances)."""

    @trajectory.wrong(name, hint)
    def _(path, truth):
        p = aligned(path, truth) if aligned else ate(path, truth)[0]
        d = np.linalg.norm(p - truth, axis=1)
        return p, error(d) if error else np.sqrt(np.mean(d**2))


def _first_points(path, truth):
    """The first step of the path laid on that of the truth."""
    u, v = path[1] - path[0], truth[1] - truth[0]
    turn = np.arctan2(v[1], v[0]) - np.arctan2(u[1], u[0])
    c, s = np.cos(turn), np.sin(turn)
    return (path - path[0]) @ np.array([[c, s], [-s, c]]) + truth[0]


# fmt: off
_wrong("not aligned", "The map has its own origin and direction. Align first: nobody told the filter where the truth's "
       "frame is.", lambda p, t: p.copy())
_wrong("moved, not turned", "The direction of the start is not known either: find the angle, too.",
       lambda p, t: p - p.mean(0) + t.mean(0))
_wrong("turned, not moved", "After the turn, put the mean of the path on the mean of the truth.",
       lambda p, t: p @ _best(p, t)[0].T)
_wrong("turned about the origin", "Subtract the mean of the path before you turn it.",
       lambda p, t: p @ _best(p, t)[0].T + t.mean(0) - p.mean(0))
_wrong("turned the wrong way", "Your angle has the wrong sign, or R is transposed: it turns truth to path.",
       lambda p, t: _turned(p, t, _best(p, t)[0].T))
_wrong("with a scale", "Range measurements fix the scale: it is no gauge. A free scale hides errors.",
       lambda p, t: _turned(p, t, _best(p, t)[1] * _best(p, t)[0]))
_wrong("mirror allowed", "The SVD may give a mirror image. The determinant of R must be +1.",
       lambda p, t: _turned(p, t, _best(p, t, mirror=True)[0]))
_wrong("first points only", "Two points hold the noise of two points. Use all of them: least squares.", _first_points)
_wrong("first point on first point", "All points count alike: put mean on mean, not start on start.",
       lambda p, t: (p - p[0]) @ _best(p, t)[0].T + t[0])
_wrong("truth laid on the path", "Return the path in the frame of the truth, not the other way round.",
       lambda p, t: ate(t, p)[0])
_wrong("mean distance", "ATE is the root of the mean *square*: large errors count more.", error=np.mean)
_wrong("mean over x and y", "One distance per point: add x and y before the mean, so divide by n, not by 2 n.",
       error=lambda d: np.sqrt(np.mean(d**2) / 2))
_wrong("no root", "That is the mean squared distance, in square metres. Take the root.", error=lambda d: np.mean(d**2))
_wrong("no mean", "That grows with the length of the path: take the mean of the squares.",
       error=lambda d: np.sqrt(np.sum(d**2)))
_wrong("largest error", "That is the worst point. ATE is an average over all.", error=np.max)
_wrong("last point", "ATE is about the whole path, not about its end.", error=lambda d: d[-1])
# fmt: on


@trajectory.variant("SVD with the sign of the determinant, as lists")
def _(path, truth):
    aligned = _turned(path, truth, _best(path, truth)[0])
    return aligned.tolist(), float(np.linalg.norm(aligned - truth) / np.sqrt(len(path)))


@trajectory.variant("complex numbers")
def _(path, truth):
    p, t = (a[:, 0] + 1j * a[:, 1] for a in (path, truth))
    u = np.sum(np.conj(p - p.mean()) * (t - t.mean()))
    q = u / abs(u) * (p - p.mean()) + t.mean()
    return np.column_stack([q.real, q.imag]), np.sqrt(np.mean(abs(q - t) ** 2))


@trajectory.variant("the package")
def _(path, truth):
    from ...analysis import align

    aligned = align(path, truth).from_frame(path)[0]
    return aligned, np.sqrt(((aligned - truth) ** 2).sum(1).mean())
