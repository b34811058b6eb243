"""Exercise 00.1: wrap an angle."""

import numpy as np

from .. import expect
from ..table import table


def wrap(angle):
    """The same direction, as an angle between -pi and pi.

    angle is in radians: one number, or an array of any shape. Where the direction is straight back, pi and -pi are
    both right. Do not change the input.
    """
    return np.pi - (np.pi - angle) % (2 * np.pi)


def one_seam(result):
    """Return the angles with -pi written as pi: the two are the same direction."""
    a = np.asarray(result, float)
    return np.where(np.abs(a + np.pi) < 1e-6, a + 2 * np.pi, a)


def angles(*values):
    """Return a case of these angles, one call each."""
    return [(float(value),) for value in values]


wrapping = table(
    "00.1 Wrap an angle",
    wrap,
    hints=(
        "Whole turns do not change a direction: add or subtract 2 pi until the angle is small enough.",
        "Python's % does it without a loop: a % (2 * np.pi) lies between 0 and 2 pi. You want -pi to pi: shift the angle before, and shift it back afterwards.",
        "(angle + np.pi) % (2 * np.pi) - np.pi. Another way: the arctan2 of the sine and the cosine.",
    ),
    returns="wrapped",
    canonical=one_seam,
    cases={
        "any": lambda rng: angles(0.5, -0.5, 200.0),  # 200 tells answers in degrees from those that do nothing
        "small": lambda rng: angles(0.0, 0.5, -0.5, 3.0, -3.0, *rng.uniform(-3, 3, 3)),
        "one": lambda rng: angles(
            4.0, -4.0, 6.0, -6.0, 3.3, -3.3, *rng.uniform(3.2, 9, 3), *rng.uniform(-9, -3.2, 3), 3.142, -3.142
        ),
        "many": lambda rng: angles(*(a + 2 * np.pi * turns for turns in (2, -2, 3, -5, 20, -20) for a in (0.7, -2.1))),
        "whole": lambda rng: [(4,), (np.array([4, -4, 7, 2]),)],  # of type int
        "arrays": lambda rng: [(rng.uniform(-20, 20, shape),) for shape in ((4,), (1,), (3, 2), (2, 3, 2))],
    },
    checks="""
    small angles      | wrapped | small  | An angle that is already between -pi and pi stays as it is, in radians.
    one turn too many | wrapped | one    | From pi to 2 pi one turn of 2 pi is taken away, from -2 pi to -pi one is added: the direction stays the same.
    many turns        | wrapped | many   | A robot may have turned many times, to the left or to the right. All whole turns of 2 pi are taken away: the same direction is left, between -pi and pi.
    an array          | wrapped | arrays | The function must take arrays of any shape, and give back that shape: each angle is turned by itself.
    whole numbers     | wrapped | whole  | Whole numbers must work, too: 4, or an array of type int. The result has decimals all the same; np.array(angle, dtype=float) makes floats of them.
    """,
    wrong="""
    nothing done | np.pi - (np.pi - angle) % (2 * np.pi) -> angle | Your function gives back its input. What is 2 pi more than 0.5?
    0 to 2 pi | np.pi - (np.pi - angle) % (2 * np.pi) -> angle % (2 * np.pi) | Yours lies between 0 and 2 pi. A small turn to the right must be a small negative number: -0.5, not 5.78.
    brackets forgotten | np.pi - (np.pi - angle) % (2 * np.pi) -> (angle + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    half a turn | np.pi - (np.pi - angle) % (2 * np.pi) -> (angle + np.pi) % np.pi - np.pi | A whole turn is 2 pi, not pi: `% (2 * np.pi)`.
    in degrees | np.pi - (np.pi - angle) % (2 * np.pi) -> 180 - (180 - angle) % 360 | The angle is in radians: a whole turn is 2 pi, not 360.
    converted to degrees | np.pi - (np.pi - angle) % (2 * np.pi) -> np.degrees(np.pi - (np.pi - angle) % (2 * np.pi)) | The result must be in radians, like the input.
    converted from degrees | np.pi - angle) -> np.pi - np.radians(angle)) | The input is in radians already: no conversion.
    half turns removed: Your results lie between -pi/2 and pi/2: half turns are gone, too, and ahead is no longer told from back. A whole turn is 2 pi, and it is arctan2(sine, cosine) that knows all directions.
        np.pi - (np.pi - angle) % (2 * np.pi) -> np.arctan(np.tan(angle))
    modulo pi | np.pi - (np.pi - angle) % (2 * np.pi) -> angle % np.pi | A whole turn is 2 pi, not pi: ahead and back have become the same.
    arcsine | np.pi - (np.pi - angle) % (2 * np.pi) -> np.arcsin(np.sin(angle)) | Two directions have the same sine, 3 and 0.14 rad. The sine and the cosine together tell them apart: arctan2.
    sign lost | np.pi - (np.pi - angle) % (2 * np.pi) -> np.abs(np.pi - (np.pi - angle) % (2 * np.pi)) | The sign is lost: left and right are different directions.
    arctan2 with its arguments swapped | np.pi - (np.pi - angle) % (2 * np.pi) -> np.arctan2(np.cos(angle), np.sin(angle)) | arctan2 takes the sine first, then the cosine.
    cut off | np.pi - (np.pi - angle) % (2 * np.pi) -> np.clip(angle, -np.pi, np.pi) | You cut the angle off at pi. Another angle is another direction: remove whole turns instead.
    shift not undone | np.pi - (np.pi - angle) % (2 * np.pi) -> (angle + np.pi) % (2 * np.pi) | Yours is pi too large. An angle that is shifted by pi before the % is shifted back afterwards.
    fmod | np.pi - (np.pi - angle) % (2 * np.pi) -> np.fmod(angle + np.pi, 2 * np.pi) - np.pi | Angles below -pi stay below -pi in yours. Python's % with a positive number brings them up, too; np.fmod and math.fmod do not: they keep the sign of the input.
    half a turn off | np.pi - (np.pi - angle) % (2 * np.pi) -> angle % (2 * np.pi) - np.pi | Yours is off by half a turn: add pi before the %, and subtract it afterwards.
    mirrored | np.pi - (np.pi - angle) % (2 * np.pi) -> (np.pi - angle) % (2 * np.pi) - np.pi | The sign is the wrong way round: left has become right.
    one turn only: Your function removes one turn. After several turns one is not enough: use a loop, or %.
        np.pi - (np.pi - angle) % (2 * np.pi) -> angle - 2 * np.pi * (np.asarray(angle) > np.pi) + 2 * np.pi * (np.asarray(angle) <= -np.pi)
    negative angles forgotten | np.pi - (np.pi - angle) % (2 * np.pi) -> angle - 2 * np.pi * (np.asarray(angle) > np.pi) | Angles below -pi stay as they are in yours: there a whole turn is added. And after several turns one is not enough.
    positive angles forgotten | np.pi - (np.pi - angle) % (2 * np.pi) -> angle + 2 * np.pi * (np.asarray(angle) <= -np.pi) | Angles above pi stay as they are in yours: there a whole turn is taken away. And after several turns one is not enough.
    ceil for floor | np.pi - (np.pi - angle) % (2 * np.pi) -> np.pi - (np.pi - angle) % (2 * np.pi) - 2 * np.pi | Yours is one turn too small: it is np.floor((angle + np.pi) / (2 * np.pi)) that counts the turns; np.ceil counts one too many.
    brackets forgotten in the division | np.pi - (np.pi - angle) % (2 * np.pi) -> angle - 2 * np.pi * np.floor((angle + np.pi) / 2 * np.pi) | Python reads `/ 2*np.pi` as `(... / 2) * np.pi`. The whole turn needs brackets: / (2 * np.pi).
    half a turn for each turn | np.pi - (np.pi - angle) % (2 * np.pi) -> angle - np.pi * np.floor((angle + np.pi) / (2 * np.pi)) | Each turn that you count is 2 pi, and you take away pi for it.
    angle // 2 pi: `//` counts the whole turns, `%` gives what is left of the angle without them: (angle + np.pi) % (2 * np.pi) - np.pi.
        np.pi - (np.pi - angle) % (2 * np.pi) -> angle // (2 * np.pi)
    turns added | np.pi - (np.pi - angle) % (2 * np.pi) -> angle + 2 * np.pi * np.floor((angle + np.pi) / (2 * np.pi)) | The turns that you count are taken away, not added.
    all in one row | return np.pi - (np.pi - angle) % (2 * np.pi) -> return np.ravel(np.pi - (np.pi - angle) % (2 * np.pi)) | The result has the shape of the input: one number for a number, a table for a table.
    """,
)


@wrapping.link(
    "the seam",
    "Straight back (pi, -pi, 3 pi, -3 pi) comes out as pi or -pi; 0.001 rad beside it, as the same direction between -pi and pi.",
    before="an array",
)
def _(f, rng):
    for angle in (np.pi, -np.pi, 3 * np.pi, -3 * np.pi, np.pi - 1e-3, np.pi + 1e-3, 1e-3 - np.pi, -np.pi - 1e-3):
        got = expect.array(f(angle), (), "wrapped")
        expect.close(one_seam(got), one_seam(wrap(angle)), "wrapped", atol=1e-7, at=f"angle = {angle:.4g}")


@wrapping.wrong(
    "whole numbers stay whole",
    "np.array(angle) of whole numbers is of type int: what you write into it loses its decimals. np.array(angle, dtype=float) keeps them.",
)
def _(angle):
    wrapped = np.array(angle)
    wrapped[...] = wrap(angle)
    return wrapped


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
