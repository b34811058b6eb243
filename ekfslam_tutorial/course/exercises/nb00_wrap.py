"""Exercise 00.1: wrap an angle."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def wrap(angle):
    """The same direction, as an angle between -pi and pi.

    angle is in radians: one number, or an array of any shape. Where the direction is straight back, pi and -pi are
    both right. Do not change the input.
    """
    return np.pi - (np.pi - angle) % (2 * np.pi)


def _one_seam(result):
    """The result with -pi written as pi: the two are the same direction."""
    a = np.asarray(result, float)
    return np.where(np.abs(a + np.pi) < 1e-6, a + 2 * np.pi, a)


wrapping = Exercise(
    "00.1",
    "Wrap an angle",
    wrap,
    canonical=_one_seam,
    hints=(
        "Whole turns do not change a direction: add or subtract 2 pi until the angle is small enough.",
        "Python's % does it without a loop: a % (2 * np.pi) lies between 0 and 2 pi. You want -pi to pi: shift the "
        "angle before, and shift it back afterwards.",
        "(angle + np.pi) % (2 * np.pi) - np.pi. Another way: the arctan2 of the sine and the cosine.",
    ),
)


def _value(f, angle, shape):
    return expect.array(f(angle), shape, "the result")


def _test(f, angle):
    """The result must be between -pi and pi, and must point where the input points."""
    angle = np.asarray(angle, float)
    got = _value(f, angle.copy() if angle.ndim else float(angle), angle.shape)
    expect.close(_one_seam(got), _one_seam(wrap(angle)), "the result", atol=1e-7, at=f"the input {_name(angle)}")


def _name(angle):
    if angle.size == 1:
        return f"{angle.item():.4g} rad ({np.degrees(angle.item()):.4g} deg)"
    return f"of shape {angle.shape}"


@wrapping.link("small angles", "An angle that is already between -pi and pi stays as it is, in radians.")
def _(f, rng):
    for angle in (0.0, 0.5, -0.5, 3.0, -3.0, *rng.uniform(-3, 3, 3)):
        _test(f, angle)


@wrapping.link("one turn too many", "Between pi and 2 pi the direction is the same as one turn of 2 pi less.")
def _(f, rng):
    _value(f, 200.0, ())  # not judged here: it tells answers in degrees from those that do nothing
    for angle in (4.0, -4.0, 6.0, -6.0, 3.3, -3.3, *rng.uniform(3.2, 9, 3), *rng.uniform(-9, -3.2, 3)):
        _test(f, angle)


@wrapping.link("many turns", "A robot may have turned many times: remove all turns, not only one.")
def _(f, rng):
    for turns in (2, -2, 3, -5, 20, -20):
        _test(f, 0.7 + 2 * np.pi * turns)
        _test(f, -2.1 + 2 * np.pi * turns)


@wrapping.link("the seam", "Straight back: pi or -pi, and nothing else.")
def _(f, rng):
    for angle in (np.pi, -np.pi, 3 * np.pi, -3 * np.pi, np.pi - 1e-3, np.pi + 1e-3, 1e-3 - np.pi, -np.pi - 1e-3):
        _test(f, angle)


@wrapping.link("an array", "The function must take arrays of any shape, too: no `if` on the whole array.")
def _(f, rng):
    for shape in ((4,), (1,), (3, 2), (2, 3, 2)):
        _test(f, rng.uniform(-20, 20, shape))


# ---- wrong and right answers -----------------------------------------------------------------------------------------


def _wrong(name, hint, answer):
    wrapping.wrong(name, hint)(answer)


_wrong("nothing done", "Your function gives back its input. What is 2 pi more than 0.5?", lambda angle: angle)
_wrong(
    "0 to 2 pi",
    "Yours lies between 0 and 2 pi. A small turn to the right must be a small negative number: -0.5, not 5.78.",
    lambda angle: angle % (2 * np.pi),
)
_wrong(
    "in degrees",
    "The angle is in radians: a whole turn is 2 pi, not 360.",
    lambda angle: (angle + 180) % 360 - 180,
)
_wrong(
    "converted to degrees",
    "The result must be in radians, like the input.",
    lambda angle: np.degrees(np.arctan2(np.sin(angle), np.cos(angle))),
)
_wrong(
    "converted from degrees",
    "The input is in radians already: no conversion.",
    lambda angle: np.arctan2(np.sin(np.radians(angle)), np.cos(np.radians(angle))),
)
_wrong(
    "half turns removed",
    "Your results lie between -pi/2 and pi/2: half turns are gone, too, and ahead is no longer told from back. A whole "
    "turn is 2 pi, and it is arctan2(sine, cosine) that knows all directions.",
    lambda angle: np.arctan(np.tan(angle)),
)
_wrong(
    "modulo pi",
    "A whole turn is 2 pi, not pi: ahead and back have become the same.",
    lambda angle: angle % np.pi,
)
_wrong(
    "arcsine",
    "Two directions have the same sine, 3 and 0.14 rad. The sine and the cosine together tell them apart: arctan2.",
    lambda angle: np.arcsin(np.sin(angle)),
)
_wrong(
    "arctan2 with its arguments swapped",
    "arctan2 takes the sine first, then the cosine.",
    lambda angle: np.arctan2(np.cos(angle), np.sin(angle)),
)
_wrong(
    "cut off",
    "You cut the angle off at pi. Another angle is another direction: remove whole turns instead.",
    lambda angle: np.clip(angle, -np.pi, np.pi),
)
_wrong(
    "shift not undone",
    "You shifted the angle by pi before the %: shift it back afterwards.",
    lambda angle: (angle + np.pi) % (2 * np.pi),
)
_wrong(
    "fmod",
    "np.fmod and math.fmod keep the sign of the input. Python's % with a positive number never gives a negative one.",
    lambda angle: np.fmod(angle + np.pi, 2 * np.pi) - np.pi,
)
_wrong("sign lost", "The sign is lost: left and right are different directions.", lambda angle: np.abs(_wrapped(angle)))
_wrong("mirrored", "The sign is the wrong way round: left has become right.", lambda angle: -_wrapped(angle))
_wrong(
    "one turn only",
    "Your function removes one turn. After several turns one is not enough: use a loop, or %.",
    lambda angle: angle - 2 * np.pi * (np.asarray(angle) > np.pi) + 2 * np.pi * (np.asarray(angle) <= -np.pi),
)


def _wrapped(angle):
    return np.arctan2(np.sin(angle), np.cos(angle))


@wrapping.wrong(
    "one number only",
    "For one number it is right. For an array, `if` and `while` cannot decide: one expression with % does all at once.",
)
def _(angle):
    while angle > np.pi:
        angle = angle - 2 * np.pi
    while angle <= -np.pi:
        angle = angle + 2 * np.pi
    return angle


wrapping.variant("arctan2 of sine and cosine")(_wrapped)


@wrapping.variant("% with a shift")
def _(angle):
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


@wrapping.variant("nearest whole turn removed")
def _(angle):
    return angle - 2 * np.pi * np.round(np.asarray(angle) / (2 * np.pi))


@wrapping.variant("complex numbers")
def _(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))


@wrapping.variant("a loop over the entries, as lists")
def _(angle):
    def one(a):
        while a > np.pi:
            a -= 2 * np.pi
        while a < -np.pi:
            a += 2 * np.pi
        return a

    a = np.asarray(angle, float)
    return one(float(a)) if a.ndim == 0 else np.array([one(v) for v in a.ravel()]).reshape(a.shape).tolist()
