"""Exercise 16.2: which points a sensor can see."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def beacon_visible(y, p, max_range, fov):
    """Whether a range-only sensor can see points.

    y, shape (..., 1): the ranges (m) of the points p, shape (..., 2), in the frame of the sensor (m); any number of
    leading axes, also none. The antenna looks along the x axis. It sees a point that is not further away than
    max_range (m), and not more than fov / 2 (rad) to the left or to the right; fov is the whole width of its view.
    Return True or False for each point, shape (...).
    """
    bearing = np.arctan2(p[..., 1], p[..., 0])
    return (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2)


seen = Exercise(
    "16.2",
    "What the sensor can see",
    beacon_visible,
    hints=(
        "Two conditions, and both must hold: the range, and the bearing of the point.",
        "The bearing is arctan2(py, px). fov is the whole width, half of it on each side: |bearing| <= fov / 2.",
        "For arrays `and` does not work: (y[..., 0] <= max_range) & (np.abs(bearing) <= fov / 2).",
    ),
)


def _flags(result, lead):
    flags = expect.array(result, lead, "the result")
    expect.true(np.isin(flags, (0, 1)).all(), "the result must be True or False for each point")
    return flags


def polar(r, bearing_deg):
    """Ranges and points, y and p, from ranges and bearings in degrees."""
    r, a = np.broadcast_arrays(np.asarray(r, float), np.radians(np.asarray(bearing_deg, float)))
    return r[..., None].copy(), r[..., None] * np.stack([np.cos(a), np.sin(a)], -1)


def _compare(f, args, at):
    want = beacon_visible(*args)
    got = _flags(f(*args), want.shape)
    if not np.array_equal(got, want):
        i = int(np.argmax(np.ravel(got != want)))
        p, said = np.reshape(args[1], (-1, 2))[i], bool(np.ravel(got)[i])
        raise expect.Failed(
            f"the point at {np.hypot(*p):.1f} m, {np.degrees(np.arctan2(p[1], p[0])):.0f} deg, {at}: you say {said}"
        )


@seen.link("one point", "One point gives one truth value, an array or a number without axes.")
def _(f, rng):
    _flags(f(*polar(2.0, 10.0), 5.0, np.pi), ())
    _flags(f(*polar(9.0, 10.0), 5.0, np.pi), ())


@seen.link("range", "Not further away than max_range, and not too far to the side.")
def _(f, rng):
    y, p = polar([1.0, 4.9, 5.1, 20.0, 3, 3, 3, 3, 3, 3], [0, 5, -5, 0, 40, -40, 60, -60, 130, -130])
    for max_range in (5.0, 15.0):
        _compare(f, (y, p, max_range, np.radians(100)), f"max_range {max_range:.0f} m, fov 100 deg")


@seen.link("field of view", "fov / 2 to the left, fov / 2 to the right, in radians.")
def _(f, rng):
    for fov in (60.0, 120.0):
        angles = [0, fov / 2 - 1, -fov / 2 + 1, fov / 2 + 1, -fov / 2 - 1, fov - 1, 1 - fov]
        _compare(f, (*polar(3.0, angles), 5.0, np.radians(fov)), f"max_range 5 m, fov {fov:.0f} deg")


@seen.link("behind it", "arctan(py / px) cannot tell ahead from behind: take arctan2(py, px).")
def _(f, rng):
    _compare(f, (*polar(3.0, [180, 170, -170, 95, -95, 20]), 5.0, np.pi / 2), "max_range 5 m, fov 90 deg")
    _compare(f, (*polar(3.0, [179, -179, 100, -100, 20]), 5.0, 2 * np.pi), "max_range 5 m, fov 360 deg")


@seen.link("any number of points", "p[..., 0] and y[..., 0] work for one point, for a list, and for a table of points.")
def _(f, rng):
    for lead in ((40,), (6, 7), (1,), ()):
        y, p = polar(rng.uniform(1, 8, lead), rng.uniform(-180, 180, lead))
        _compare(f, (y, p, rng.uniform(3, 6), rng.uniform(1, 5)), f"in a stack of shape {lead}")


def _wrong(name, hint, flags):
    """A misconception: flags(r, bearing, max_range, fov, p)."""

    @seen.wrong(name, hint)
    def _(y, p, max_range, fov):
        with np.errstate(all="ignore"):
            return flags(y[..., 0], np.arctan2(p[..., 1], p[..., 0]), max_range, fov, p)


# fmt: off
_wrong("the whole fov on each side", "fov is the *whole* width: only half of it lies on each side.",
       lambda r, b, m, fov, p: (r <= m) & (np.abs(b) <= fov))
_wrong("sign of the bearing", "A point to the right has a negative bearing, and would always be seen: take |bearing|.",
       lambda r, b, m, fov, p: (r <= m) & (b <= fov / 2))
_wrong("only to the left", "The view goes to the right, too: -fov / 2 <= bearing <= fov / 2.",
       lambda r, b, m, fov, p: (r <= m) & (b >= 0) & (b <= fov / 2))
_wrong("from zero to fov", "The x axis is the *middle* of the view: -fov / 2 to fov / 2.",
       lambda r, b, m, fov, p: (r <= m) & (b >= 0) & (b <= fov))
_wrong("degrees", "Everything is in radians, fov too.",
       lambda r, b, m, fov, p: (r <= m) & (np.abs(np.degrees(b)) <= fov / 2))
_wrong("one of the two", "Both must hold: `&`, not `|`.", lambda r, b, m, fov, p: (r <= m) | (np.abs(b) <= fov / 2))
_wrong("range forgotten", "A point beyond max_range is not seen.", lambda r, b, m, fov, p: np.abs(b) <= fov / 2)
_wrong("view forgotten", "A point outside the field of view is not seen.", lambda r, b, m, fov, p: r <= m)
_wrong("arctan", "arctan(py / px) takes a point behind for one ahead. Take arctan2(py, px).",
       lambda r, b, m, fov, p: (r <= m) & (np.abs(np.arctan(p[..., 1] / p[..., 0])) <= fov / 2))
_wrong("px and py swapped", "arctan2 takes y first: arctan2(py, px).",
       lambda r, b, m, fov, p: (r <= m) & (np.abs(np.arctan2(p[..., 0], p[..., 1])) <= fov / 2))
_wrong("the other way round", "That is True where the sensor is blind.",
       lambda r, b, m, fov, p: ~((r <= m) & (np.abs(b) <= fov / 2)))
# fmt: on


@seen.variant("by the cosine")
def _(y, p, max_range, fov):
    p = np.asarray(p)
    wide = fov >= 2 * np.pi - 1e-9
    return np.logical_and(y[..., 0] <= max_range, wide | (p[..., 0] >= np.cos(fov / 2) * np.linalg.norm(p, axis=-1)))


@seen.variant("one by one")
def _(y, p, max_range, fov):
    flat = [
        r <= max_range and -fov / 2 <= np.arctan2(b, a) <= fov / 2
        for r, (a, b) in zip(np.ravel(y), np.reshape(p, (-1, 2)), strict=True)
    ]
    return np.array(flat).reshape(np.shape(p)[:-1])
