"""Exercise 01.3: the innovation, with its angle wrapped."""

import numpy as np

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise


def innovation(y, e):
    """Measured minus expected, z = y - e, for range and bearing.

    y = [range, bearing] and e = [range, bearing] have shape (2,), or (m, 2) for m measurements at once (m, rad).
    Bearings may hold whole turns. Return z of the same shape; its bearing is between -pi and pi.
    """
    z = np.subtract(y, e, dtype=float)
    z[..., 1] = wrap(z[..., 1])
    return z


def _one_seam(result):
    """The result with -pi written as pi: the two are the same direction."""
    z = np.array(result, float)
    z[..., 1] = np.where(np.abs(z[..., 1] + np.pi) < 1e-6, np.pi, z[..., 1])
    return z


surprise = Exercise(
    "01.3",
    "The innovation",
    innovation,
    canonical=_one_seam,
    hints=(
        "Subtract first. Then ask: which of the two numbers is an angle?",
        "`wrap` of notebook 00 is imported. Apply it to the *difference* of the bearings, not to the range.",
        "The last axis holds [range, bearing]: z[..., 1] is the bearing, for one measurement and for many.",
    ),
)


def _test(f, y, e, at=""):
    y, e = np.asarray(y, float), np.asarray(e, float)
    z = expect.array(f(y, e), y.shape, "z")
    expect.close(_one_seam(z), _one_seam(innovation(y, e)), "z", at=at or f"y = {y}, e = {e}")


@surprise.link("measured minus expected", "z = y - e: positive where more was measured than expected.")
def _(f, rng):
    for y, e in (([3.0, 0.5], [2.8, 0.4]), ([2.0, -0.3], [2.5, 0.1]), ([1.0, -1.0], [3.0, -0.5])):
        _test(f, y, e)


@surprise.link("the seam", "At +-pi a small difference of bearings looks like a whole turn: wrap it.")
def _(f, rng):
    for bearing in (7.0, 200.0):  # not judged here: they tell apart answers that are alike at the seam
        expect.array(f(np.array([3.0, bearing]), np.array([3.0, -3.0])), 2, "z")
    for y, e in (([3.0, -3.1], [2.9, 3.1]), ([3.0, 3.12], [3.3, -3.10]), ([2.0, -2.0], [2.2, 2.5])):
        _test(f, y, e)


@surprise.link("whole turns", "A bearing of 350 degrees and one of -10 degrees are the same direction.")
def _(f, rng):
    for turns in (1, -1, 2, -3):
        _test(f, [3.0, 0.4 + 2 * np.pi * turns], [2.5, 0.6])
        _test(f, [3.0, -0.4], [2.5, -0.1 + 2 * np.pi * turns])


@surprise.link("the range is no angle", "Only the bearing is wrapped: a range may be off by more than pi.")
def _(f, rng):
    for far in (4.0, -5.0, 7.0, 40.0):
        _test(f, [50 + far, 0.3], [50.0, 0.1])


@surprise.link("many at once", "For shape (m, 2) each row is a measurement: z[..., 1] holds all bearings.")
def _(f, rng):
    for m in (4, 2, 1, 7):
        y, e = (np.stack([rng.uniform(1, 20, m), rng.uniform(-6, 6, m)], -1) for _ in "ye")
        _test(f, y, e, at=f"{m} measurements at once")


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def _wrong(name, hint, bearing=None, range=None):
    """A misconception in the bearing or in the range; each is a function of (y, e)."""

    @surprise.wrong(name, hint)
    def _(y, e):
        y, e, z = np.asarray(y, float), np.asarray(e, float), innovation(y, e)
        if bearing:
            z[..., 1] = bearing(y[..., 1], e[..., 1])
        if range:
            z[..., 0] = range(y[..., 0], e[..., 0])
        return z


# fmt: off
_wrong("not wrapped", "3.12 and -3.12 rad are nearly the same direction: wrap the difference of the bearings.",
       lambda b, a: b - a)
_wrong("range wrapped, too", "The range is a length, not an angle: wrap the bearing only.",
       range=lambda b, a: wrap(b - a))
_wrong("bearings wrapped, not their difference", "The difference of two wrapped angles can still be nearly 2 pi: "
       "subtract first, then wrap.", lambda b, a: wrap(b) - wrap(a))
_wrong("wrapped to 0 ... 2 pi", "A small negative difference must stay small and negative: wrap into -pi ... pi.",
       lambda b, a: (b - a) % (2 * np.pi))
_wrong("bearing expected minus measured", "The bearing has the wrong sign: measured minus expected.",
       lambda b, a: wrap(a - b))
_wrong("absolute value", "The sign is lost: the filter must know which way it is off.",
       lambda b, a: np.abs(wrap(b - a)))
_wrong("absolute range", "The sign of the range is lost: the filter must know which way it is off.",
       range=lambda b, a: np.abs(b - a))
_wrong("degrees", "Angles are in radians everywhere.", lambda b, a: np.degrees(wrap(b - a)))
_wrong("wrapped as degrees", "Angles are in radians: a whole turn is 2 pi, not 360.",
       lambda b, a: (b - a + 180) % 360 - 180)
_wrong("half turns removed", "A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.",
       lambda b, a: np.arctan(np.tan(b - a)))
_wrong("one turn only", "Your function removes one turn at most. Bearings may hold several: use wrap.",
       lambda b, a: b - a - 2 * np.pi * (b - a > np.pi) + 2 * np.pi * (b - a <= -np.pi))
# fmt: on


@surprise.wrong("expected minus measured", "The innovation is measurement minus expectation, z = y - e.")
def _(y, e):
    return innovation(e, y)


@surprise.wrong("the measurement itself", "z is the surprise: measured minus expected.")
def _(y, e):
    return np.array(y, float)


@surprise.wrong("the sum", "z = y *minus* e.")
def _(y, e):
    z = np.add(y, e)
    z[..., 1] = wrap(z[..., 1])
    return z


@surprise.wrong(
    "one measurement only",
    "For one measurement it is right. For shape (m, 2), z[1] is the second *row*: write z[..., 1] for the bearings.",
)
def _(y, e):
    z = np.subtract(y, e, dtype=float)
    z[1] = wrap(z[1])
    return z


@surprise.variant("arctan2 of sine and cosine")
def _(y, e):
    d = np.asarray(y) - np.asarray(e)
    return np.stack([d[..., 0], np.arctan2(np.sin(d[..., 1]), np.cos(d[..., 1]))], -1)


@surprise.variant("bearings wrapped before, too; lists")
def _(y, e):
    y, e = np.array(y, float), np.array(e, float)
    b = (wrap(y[..., 1]) - wrap(e[..., 1]) + np.pi) % (2 * np.pi) - np.pi
    return np.stack([y[..., 0] - e[..., 0], b], -1).tolist()


@surprise.variant("nearest whole turn removed")
def _(y, e):
    z = np.asarray(y, float) - e
    return z - 2 * np.pi * np.round(z / (2 * np.pi)) * [0, 1]
