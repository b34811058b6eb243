"""Exercise 16.1: what a range-only sensor measures of a point."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def beacon_project(p):
    """Range of points, and its derivative by the point.

    p, shape (..., 2): points in the frame of the sensor (m). The dots stand for any number of leading axes, also none:
    one point has the shape (2,), a list of n points (n, 2).
    Return y, shape (..., 1): the ranges (m), and Y_p, shape (..., 1, 2): the Jacobian of each.
    """
    r = np.linalg.norm(p, axis=-1, keepdims=True)
    return r, (np.asarray(p) / r)[..., None, :]


ranged = Exercise(
    "16.1",
    "The direct model of a range",
    beacon_project,
    hints=(
        "The range is the length of the vector. How does the length change when the point moves along x, or along y?",
        "y = sqrt(px^2 + py^2), Y_p = [px / y, py / y]. Sum over the last axis, axis=-1, and keep it as an axis.",
        "r = np.linalg.norm(p, axis=-1, keepdims=True) has the shape (..., 1); (p / r)[..., None, :] has (..., 1, 2).",
    ),
)

SHAPES = ((), (5,), (2, 3), (1,))


def _two(result, lead):
    y, Y_p = expect.results(result, "y", "Y_p")
    return expect.array(y, (*lead, 1), "y"), expect.array(Y_p, (*lead, 1, 2), "Y_p")


def some(rng, lead):
    """Points on all sides of the sensor, 1 to 6 m away."""
    a, r = rng.uniform(-np.pi, np.pi, lead), rng.uniform(1, 6, lead)
    return np.stack([r * np.cos(a), r * np.sin(a)], -1)


@ranged.link("one point", "One point of shape (2,) gives y of shape (1,) and Y_p of shape (1, 2).")
def _(f, rng):
    _two(f(some(rng, ())), ())


@ranged.link("range", "The range is the length of the vector, sqrt(px^2 + py^2).", part=0)
def _(f, rng):
    for p in (np.array([3.0, 4.0]), np.array([-5.0, 12.0]), some(rng, ())):
        expect.close(_two(f(p), ())[0], [np.hypot(*p)], "y", at=f"p = {p.round(2)}")


@ranged.link("Jacobian", "When the point moves along the line of sight by 1 m, the range grows by 1 m.", part=1)
def _(f, rng):
    for p in (np.array([3.0, 4.0]), np.array([-5.0, 0.5]), some(rng, ()), some(rng, ()) * 30):
        Y_p = _two(f(p), ())[1]
        expect.jacobian(Y_p, lambda q: beacon_project(q)[0], p, "Y_p", ["y"], ["px", "py"])


@ranged.link("many points", "Write p[..., 0] and axis=-1, not p[0] and axis=0: then a list of points is one call.")
def _(f, rng):
    for lead in SHAPES:
        p = some(rng, lead)
        y, Y_p = _two(f(p), lead)
        want, WANT = beacon_project(p)
        expect.close(y, want, "y", at=f"p of shape {p.shape}")
        expect.close(Y_p, WANT, "Y_p", at=f"p of shape {p.shape}")


def _wrong(name, hint, y=None, Y=None):
    """A misconception in the value y(p, r) or the Jacobian Y(p, r)."""

    @ranged.wrong(name, hint)
    def _(p):
        r = np.linalg.norm(p, axis=-1, keepdims=True)
        return (y(p, r) if y else r), (Y(p, r) if Y else p / r)[..., None, :]


# fmt: off
_wrong("squared range", "That is the square of the range. Take the root.", lambda p, r: r**2, lambda p, r: 2 * p)
_wrong("root forgotten", "That is the square of the range: the root is missing in y.", lambda p, r: r**2)
_wrong("city blocks", "|px| + |py| is the way round the corner. A range is the straight line.",
       lambda p, r: np.abs(p).sum(-1, keepdims=True))
_wrong("unit vector forgotten", "dr/dp is a *unit* vector: p / r, not p.", Y=lambda p, r: p)
_wrong("divided by the square", "dr/dp = p / r. Check the units: metres per metre, so no r^2.",
       Y=lambda p, r: p / r**2)
_wrong("derivative of the bearing", "[-py, px] / r^2 is the derivative of the bearing. The range grows *along* the "
       "line of sight.", Y=lambda p, r: np.stack([-p[..., 1], p[..., 0]], -1) / r**2)
_wrong("across the line of sight", "A step across the line of sight changes nothing. Y_p points along it: p / r.",
       Y=lambda p, r: np.stack([-p[..., 1], p[..., 0]], -1) / r)
_wrong("towards the sensor", "The sign: a point that moves away has a larger range.", Y=lambda p, r: -p / r)
_wrong("half of it", "The inner derivative of the square, 2 px, cancels the 1/2 of the root: p / r.",
       Y=lambda p, r: p / (2 * r))
# fmt: on


@ranged.wrong(
    "one point only", "p[0] is the first *point* of a list, and the first number of one point. Write p[..., 0]."
)
def _(p):
    r = np.hypot(p[0], p[1])
    return np.atleast_1d(r), np.atleast_2d([p[0] / r, p[1] / r])


@ranged.variant("with hypot and stack")
def _(p):
    x, y = np.asarray(p)[..., 0], np.asarray(p)[..., 1]
    r = np.hypot(x, y)
    return r[..., None], np.stack([x / r, y / r], axis=-1)[..., None, :]


@ranged.variant("by cosine and sine")
def _(p):
    a = np.arctan2(p[..., 1], p[..., 0])
    J = np.stack([np.cos(a), np.sin(a)], -1)
    return (p * J).sum(-1, keepdims=True), np.expand_dims(J, -2)
