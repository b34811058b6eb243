"""Exercise 01.3: the innovation, with its angle wrapped."""

import numpy as np

from ...geometry import wrap
from ..table import table


def innovation(y, e):
    """Measured minus expected, z = y - e, for range and bearing.

    y = [range, bearing] and e = [range, bearing] have shape (2,), or (m, 2) for m measurements at once (m, rad).
    Bearings may hold whole turns. Return z of the same shape; its bearing is between -pi and pi.
    """
    z = np.subtract(y, e, dtype=float)
    z[..., 1] = wrap(z[..., 1])
    return z


def one_seam(result):
    """Return z with -pi written as pi: the two are the same direction."""
    z = np.array(result, float)
    z[..., 1] = np.where(np.abs(z[..., 1] + np.pi) < 1e-6, np.pi, z[..., 1])
    return z


def pairs(*found):
    """Return a case of these measurements and expectations."""
    return [(np.array(y, float), np.array(e, float)) for y, e in found]


def whole_turns(rng):
    """Return bearings that hold whole turns."""
    shift = 2 * np.pi * np.array([1, -1, 2, -3])
    return pairs(*(([3.0, 0.4 + a], [2.5, 0.6]) for a in shift), *(([3.0, -0.4], [2.5, -0.1 + a]) for a in shift))


surprise = table(
    "01.3 The innovation",
    innovation,
    hints=(
        "Subtract first. Then ask: which of the two numbers is an angle?",
        "`wrap` of notebook 00 is imported. Apply it to the *difference* of the bearings, not to the range.",
        "The last axis holds [range, bearing]: z[..., 1] is the bearing, for one measurement and for many.",
    ),
    returns="z",
    canonical=one_seam,
    cases={  # the bearings of 7 and 200 tell apart answers that are alike at the seam
        "any": lambda rng: pairs(
            ([3.0, 0.5], [2.8, 0.4]), ([9.0, -3.1], [3.0, 3.1]), ([3.0, 7.0], [3.0, -3.0]), ([3.0, 200.0], [3.0, -3.0])
        ),
        "small": lambda rng: pairs(
            ([3.0, 0.5], [2.8, 0.4]), ([2.0, -0.3], [2.5, 0.1]), ([1.0, -1.0], [3.0, -0.5]), ([2.0, 0.4], [2.5, 0.4])
        ),
        "seam": lambda rng: pairs(
            ([3.0, -3.1], [2.9, 3.1]), ([3.0, 3.12], [3.3, -3.10]), ([2.0, -2.0], [2.2, 2.5]), ([2.0, 1.6], [2.2, -1.6])
        ),
        "turns": whole_turns,
        "far": lambda rng: pairs(*(([50 + far, 0.3], [50.0, 0.1]) for far in (4.0, -5.0, 7.0, 40.0))),
        "many": lambda rng: [
            tuple(np.stack([rng.uniform(1, 20, m), rng.uniform(-6, 6, m)], -1) for _ in "ye") for m in (4, 2, 1, 7)
        ],
    },
    checks="""
    measured minus expected | z | small | z = y - e, in the shape of y: (2,) for one measurement, (m, 2) for m of them; positive where more was measured than expected.
    the seam                | z | seam  | At +-pi a small difference of bearings looks like a whole turn: -3.1 - 3.1 = -6.2 must come out as 0.083, the wrapped difference.
    whole turns             | z | turns | Bearings may hold one or several whole turns, in y or in e: 350, 710 and -10 degrees are the same direction. z[..., 1] is the same with them and without.
    the range is no angle   | z | far   | A range is a length: z[..., 0] is the plain difference y[..., 0] - e[..., 0], here 4, -5, 7 or 40 m, which is more than pi.
    many at once            | z | many  | For shape (m, 2) each row is a measurement: z[..., 1] holds all bearings.
    """,
    wrong="""
    not wrapped | wrap(z[..., 1]) -> z[..., 1] | 3.12 and -3.12 rad are nearly the same direction: wrap the difference of the bearings.
    range wrapped, too | return z -> return wrap(z) | The range is a length, not an angle: wrap the bearing only.
    range wrapped instead of the bearing | z[..., 1] = wrap(z[..., 1]) -> z[..., 0] = wrap(z[..., 0]) | The last axis is [range, bearing]: entry 0 is a length, entry 1 is the angle.
    bearings wrapped, not their difference | wrap(z[..., 1]) -> wrap(y[..., 1]) - wrap(e[..., 1]) | The difference of two wrapped angles can still be nearly 2 pi: subtract first, then wrap.
    wrapped to 0 ... 2 pi | wrap(z[..., 1]) -> z[..., 1] % (2 * np.pi) | A small negative difference must stay small and negative: wrap into -pi ... pi.
    brackets forgotten | wrap(z[..., 1]) -> (z[..., 1] + np.pi) % 2 * np.pi - np.pi | Python reads `% 2*np.pi` as `(... % 2) * np.pi`. The whole turn needs brackets: % (2 * np.pi).
    bearing expected minus measured | wrap(z[..., 1]) -> wrap(-z[..., 1]) | The bearing has the wrong sign: measured minus expected.
    range expected minus measured | return z -> z[..., 0] = -z[..., 0]; return z | The range has the wrong sign: measured minus expected.
    absolute value | wrap(z[..., 1]) -> np.abs(wrap(z[..., 1])) | The sign is lost: the filter must know which way it is off.
    absolute range | return z -> z[..., 0] = np.abs(z[..., 0]); return z | The sign of the range is lost: the filter must know which way it is off.
    degrees | wrap(z[..., 1]) -> np.degrees(wrap(z[..., 1])) | Angles are in radians everywhere.
    wrapped as degrees | wrap(z[..., 1]) -> (z[..., 1] + 180) % 360 - 180 | Angles are in radians: a whole turn is 2 pi, not 360.
    half turns removed | wrap(z[..., 1]) -> np.arctan(np.tan(z[..., 1])) | A whole turn is 2 pi. Directions that differ by pi are opposite, not the same.
    one turn only | wrap(z[..., 1]) -> z[..., 1] - 2 * np.pi * (z[..., 1] > np.pi) + 2 * np.pi * (z[..., 1] <= -np.pi) | Your function removes one turn at most. Bearings may hold several: use wrap.
    expected minus measured | np.subtract(y, e, dtype=float) -> np.subtract(e, y, dtype=float) | The innovation is measurement minus expectation, z = y - e.
    the measurement itself | z = np.subtract(y, e, dtype=float) -> return np.array(y) | z is the surprise: measured minus expected.
    the sum | np.subtract -> np.add | z = y *minus* e.
    one measurement only | z[..., 1] = wrap(z[..., 1]) -> z[1] = wrap(z[1]) | For shape (m, 2), z[1] is the second *row*, and only one measurement alone has its bearing there: write z[..., 1] for the bearings.
    sine for the wrapped angle | wrap(z[..., 1]) -> np.sin(z[..., 1]) | The sine of a small angle is nearly the angle, but not the angle. Take whole turns away: wrap.
    arcsine of the sine | wrap(z[..., 1]) -> np.arcsin(np.sin(z[..., 1])) | An arcsine ends at 90 degrees: a difference of 100 degrees becomes one of 80. arctan2(sine, cosine) knows all directions.
    shift not undone | wrap(z[..., 1]) -> (z[..., 1] + np.pi) % (2 * np.pi) | The bearing of your z is pi too large. An angle that is shifted by pi before the % is shifted back afterwards.
    """,
)
