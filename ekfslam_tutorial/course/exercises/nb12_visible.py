"""Exercise 12.3: which points does the camera see?"""

import numpy as np

from .. import expect
from ..exercise import Exercise


def visible(p, u, size, fold):
    """Which of N points does the camera see?

    p, shape (N, 3), are the points in the frame of the camera, z ahead; z is never zero. u, shape (N, 2), are the
    pixels that the model gives for them. size, shape (2,), is [width, height] of the image in pixels; its corner is
    the pixel [0, 0], and points on its border count as seen.
    fold, a number, is the length of up = [x/z, y/z] at which the lens folds back, maybe infinite: only points nearer
    to the axis are seen.
    Return N truth values, shape (N,).
    """
    inside = np.all((u >= 0) & (u <= size), axis=1)
    ahead = p[:, 2] > 0
    r = np.linalg.norm(p[:, :2], axis=1) / np.abs(p[:, 2])
    return inside & ahead & (r < fold)


seen = Exercise(
    "12.3",
    "What the camera sees",
    visible,
    hints=(
        "Three conditions, and all of them must hold: ahead of the camera, in the image, not beyond the fold.",
        "Ahead: z > 0. In the image: 0 <= u <= width, 0 <= v <= height. Before the fold: sqrt(x^2 + y^2) / z < fold.",
        "Join arrays of truth values with &, each in brackets: (a > 0) & (b < c). u >= 0 tests both columns at once; "
        "np.all(..., axis=1) joins them.",
    ),
)

SIZE = np.array([640.0, 480.0])


def _in_image(rng, n):
    return rng.uniform([20, 20], [620, 460], (n, 2))


def _ahead(rng, n, r=0.5):
    a, z = rng.uniform(-np.pi, np.pi, n), rng.permutation(np.geomspace(0.05, 8, n))  # near points, too
    return z[:, None] * np.column_stack([r * np.cos(a), r * np.sin(a), np.ones(n)])


def _answer(f, p, u, size, fold):
    got = expect.array(f(p, u, size, fold), len(p), "the result")
    odd = got[~np.isin(got, (0, 1))]
    expect.true(not len(odd), f"truth values are wanted, True or False; got {odd[:1]}")
    return got == 1


def _same(f, p, u, fold, of, size=SIZE):
    got, want = _answer(f, p, u, size, fold), visible(p, u, size, fold)
    for i in np.flatnonzero(got != want)[:1]:
        says = "seen" if got[i] else "not seen"
        expect.true(
            False,
            f"a point {of} is {says}: p = {p[i].round(2).tolist()}, pixel {u[i].round(1).tolist()}, "
            f"image {size.astype(int).tolist()}, fold {fold:.3g}",
        )


@seen.link("one truth value for each point", "Use & and np.all(..., axis=1): one truth value for each row.")
def _(f, rng):
    for n in (4, 1):
        _answer(f, _ahead(rng, n), _in_image(rng, n), SIZE, np.inf)
    p, u = _ahead(rng, 3), _in_image(rng, 3)
    _answer(f, -p, u, SIZE, np.inf)
    message = "points in front of the camera, in the middle of the image, must be seen"
    expect.true(_answer(f, p, u, SIZE, np.inf).all(), message)


@seen.link("behind the camera", "The formula x/z gives the same pixel for p and -p. Only z > 0 is ahead.")
def _(f, rng):
    p = np.vstack([_ahead(rng, 4), -_ahead(rng, 4)])
    _answer(f, p, -_in_image(rng, 8), SIZE, np.inf)
    _same(f, p, _in_image(rng, 8), np.inf, "behind the camera or ahead of it")


@seen.link("outside the image", "0 <= u <= width and 0 <= v <= height: four borders.")
def _(f, rng):
    out = np.array([[-5.0, 240], [645, 240], [320, -5], [320, 485], [500, 470], [630, 300], [560, 500], [-3, -3]])
    _same(f, _ahead(rng, 8), out, np.inf, "near the border of the image")
    _same(f, _ahead(rng, 3), np.array([[300.0, 700], [700, 300], [460, 620]]), np.inf, "of an upright image",
          np.array([480.0, 640]))  # fmt: skip
    border = np.array([[0.0, 0], [640, 480], [0, 480], [640, 0]])
    _same(f, _ahead(rng, 4), border, np.inf, "on the border")


@seen.link("beyond the fold", "Beyond the fold two points share a pixel. Compare sqrt(x^2 + y^2) / z with fold.")
def _(f, rng):
    p = np.vstack([_ahead(rng, 4, 0.95), _ahead(rng, 4, 1.05)])
    _same(f, p, _in_image(rng, 8), 1.0, "near the fold")
    a = np.vstack([_ahead(rng, 4, 0.65), _ahead(rng, 4, 0.78)])
    _same(f, a, _in_image(rng, 8), 0.7, "near the fold")


@seen.link("all together", "All three must hold: join them with &.")
def _(f, rng):
    p = np.vstack([_ahead(rng, 20, 0.6), _ahead(rng, 20, 1.2), -_ahead(rng, 20, 0.6)])
    u = rng.uniform(-200, 850, (60, 2))
    _same(f, p, u, 0.9, "of a random set")


def _wrong(name, hint, ahead=None, inside=None, before=None, join=None):
    """A misconception in one of the three conditions, or in how they are joined."""

    @seen.wrong(name, hint)
    def _(p, u, size, fold):
        a = ahead(p) if ahead else p[:, 2] > 0
        i = inside(u, size) if inside else np.all((u >= 0) & (u <= size), axis=1)
        b = before(p, fold) if before else np.linalg.norm(p[:, :2], axis=1) / np.abs(p[:, 2]) < fold
        return join(a, i, b) if join else a & i & b


# fmt: off
_wrong("no test of the depth", "A point behind the camera has a pixel, too: that of the point -p. Only z > 0 is ahead.",
       ahead=lambda p: p[:, 2] != 0)
_wrong("z turned round", "z points ahead: what is seen has z > 0.", ahead=lambda p: p[:, 2] < 0)
_wrong("x ahead", "The camera's axes are x right, y down, z ahead: z > 0.", ahead=lambda p: p[:, 0] > 0)
_wrong("width and height swapped", "u goes with the width, v with the height.",
       inside=lambda u, s: np.all((u >= 0) & (u <= s[::-1]), axis=1))
_wrong("centre of the image at zero", "Pixels are counted from the corner: from 0 to the width, not from minus half.",
       inside=lambda u, s: np.all(np.abs(u) <= np.asarray(s) / 2, axis=1))
_wrong("one coordinate is enough", "Both u and v must be inside: np.all(..., axis=1).",
       inside=lambda u, s: np.any((u >= 0) & (u <= s), axis=1))
_wrong("left and upper border forgotten", "A pixel may be negative: 0 <= u is a condition, too.",
       inside=lambda u, s: np.all(np.asarray(u) <= s, axis=1))
_wrong("right and lower border forgotten", "The image ends at its width and height: u <= width, v <= height.",
       inside=lambda u, s: np.all(np.asarray(u) >= 0, axis=1))
_wrong("border not seen", "Points on the border count as seen: >= and <=.",
       inside=lambda u, s: np.all((np.asarray(u) > 0) & (np.asarray(u) < s), axis=1))
_wrong("image not tested", "The pixel must lie in the image: 0 <= u <= width, 0 <= v <= height.",
       inside=lambda u, s: u[:, 0] == u[:, 0])
_wrong("no test of the fold", "A point beyond the fold gets a pixel inside the image, but the light does not come "
       "there. Test sqrt(x^2 + y^2) / z < fold.", before=lambda p, f: p[:, 2] == p[:, 2])
_wrong("fold in metres", "fold is a length of up = [x/z, y/z]: divide by z before you compare.",
       before=lambda p, f: np.linalg.norm(p[:, :2], axis=1) < f)
_wrong("radius not rooted", "x^2 + y^2 is the square of the radius: take the root, or square the fold.",
       before=lambda p, f: (p[:, :2] ** 2).sum(1) / p[:, 2] ** 2 < f)
_wrong("fold on each axis", "The lens is round: the length of [x/z, y/z] counts, not each of the two.",
       before=lambda p, f: np.all(np.abs(p[:, :2] / p[:, 2:]) < f, axis=1))
_wrong("beyond, not before", "What is seen lies before the fold: radius < fold.",
       before=lambda p, f: np.linalg.norm(p[:, :2], axis=1) / np.abs(p[:, 2]) > f)
_wrong("one condition is enough", "All three must hold: & (and), not | (or).", join=lambda a, i, b: a | i | b)
# fmt: on


@seen.variant("point by point, a list")
def _(p, u, size, fold):
    out = []
    for (x, y, z), (c, r) in zip(p, u, strict=True):
        out.append(bool(z > 0 and 0 <= c <= size[0] and 0 <= r <= size[1] and x * x + y * y < fold**2 * z * z))
    return out


@seen.variant("the angle of the ray, as 0 and 1")
def _(p, u, size, fold):
    angle = np.arctan2(np.hypot(p[:, 0], p[:, 1]), p[:, 2])
    middle = np.asarray(size) / 2
    near = (np.abs(u - middle) <= middle).all(axis=1)
    return (near * (angle < np.pi / 2) * (angle < np.arctan(fold))).astype(int)
