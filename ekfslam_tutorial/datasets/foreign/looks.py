"""What is in a log, said before anything is run: rates, gaps, time bases, units, jumps, ids."""

import numpy as np

from .meaning import ANGLES, ENDINGS, KIND, LINE, NOISE, ROLES, STEP, TWIST, UNITS, plain

RATES = 0.25, 2000.0
"""Times are in the unit, of s, ms, us, ns, that makes the rate one of a sensor, Hz."""
EPOCHS = (1e17, "ns"), (1e14, "us"), (1e11, "ms")
"""A time above this is the time of day in this unit."""
GAP = 5.0
"""A gap is so many times as long as the usual step."""
TURN = 2 * np.pi
PER = "", "/s"
FASTEST = 50.0
"""No robot here is faster, m/s: then these are millimetres."""
FARTHEST = 500.0
"""Half of the ranges beyond this: then these are millimetres."""
STEEPEST = 1.3
"""No wheel is turned farther to steer, rad: then these are degrees."""
TOGETHER = TWIST[:3], TWIST[3:], STEP[3:], ANGLES
"""Columns of one unit: one of them alone may be too small to tell it."""
SPEEDS = "v", "left", "right", *TWIST[:3]
RATES_OF_TURN = "w", *TWIST[3:]
AGREE = 0.5
"""Headings go with a path if the mean of exp(i difference) is so long; else a sign is wrong, and it tells no unit."""
JUMP = 20.0
"""A step of a path that is so many times as long as nine in ten is a jump."""


def time_unit(t):
    """The unit of times without one: "s", "ms", "us" or "ns"."""
    t = t[np.isfinite(t)]
    for bound, unit in EPOCHS:
        if len(t) and np.median(t) > bound:
            return unit
    steps = np.diff(np.unique(np.asarray(t, float)))
    if not len(steps):
        return "s"
    for unit, seconds in UNITS["t"].items():
        if RATES[0] <= 1 / (np.median(steps) * seconds) <= RATES[1]:
            return unit
    return "s"


def units(entry, table, of_time=None, degrees=False):
    """The unit of each kind of columns of an entry, and how it is known.

    Parameters
    ----------
    entry : dict
        Of a plan, checked.
    table : Table
    of_time : str, optional
        The unit of another table's times, where these look alike.
    degrees : bool
        Other angles of the log are degrees.

    Returns
    -------
    dict of str to (float, str)
        By meaning: factor to SI and radians; words.
    """
    found = {}
    known = [m for m in entry if m in ROLES["odometry"] + ROLES["scan"] and m not in NOISE]
    for meaning in (m for m in known if KIND.get(m, "length")):
        turns = meaning in ("left", "right") and ("radius" in entry or turning(entry))
        kind = "angle" if turns else KIND.get(meaning, "length")
        said, ending = entry.get(f"{kind}_unit"), plain(entry[meaning])[1]
        if said:
            found[meaning] = UNITS[kind][said], f"{said}, as told"
        elif entry[meaning] == LINE:
            unit, words = of_time or "s", "" if of_time else ": a step of 1 s each, for the log has no times"
            found[meaning] = UNITS["t"][unit], f"{unit}, by the order of the lines{words}"
        elif ending in ENDINGS[kind]:
            found[meaning] = ENDINGS[kind][ending], f"{ending}, by its name"
        elif turns:
            found[meaning] = 1.0, f"rad/s, times the radius of {entry.get('radius')} m"
        elif meaning == "theta" and {"x", "y"} <= set(entry):
            unit, words = heading_unit(*(table.columns[entry[m]] for m in ("x", "y", "theta")))
            found[meaning] = UNITS[kind][unit], f"{unit}, {words}"
        else:
            like = next((group for group in TOGETHER if meaning in group and meaning != "theta"), (meaning,))
            a = np.concatenate([table.columns[entry[m]] for m in like if m in entry])
            factor, words = _guessed(kind, meaning, a, of_time, degrees)
            found[meaning] = factor, words + f"; its unit {ending!r} is not known" * (ending is not None)
    return found | {m: _of_noise(m, entry[m], found) for m in entry if m in NOISE}


def turning(entry):
    """Return True if the speeds of wheels are angles by the names of their columns: `left_rad_s`."""
    return any(plain(entry[m])[1] in ENDINGS["angle"] for m in ("left", "right") if m in entry)


def _of_noise(meaning, column, found):
    """The unit of a measurement's own noise: by its name, else that of what is measured."""
    of, ending = NOISE[meaning], plain(column)[1]
    units = ENDINGS.get(KIND.get(of[0], "length"), {}) if len(of) == 1 else {}
    if ending in units:
        return units[ending], f"{ending}, by its name"
    factor = float(np.prod([found[m][0] for m in of if m in found]))
    return factor, f"in the unit of {of[0]}{', squared' * (len(of) > 1)}"


def heading_unit(x, y, theta):
    """The unit of headings, "rad" or "deg", and how it is known.

    It is the one by which they go with the path, be it forward or backward; if they do not, it is told by their size.

    Returns
    -------
    str, str
    """
    by_size = "deg" if np.nanmax(np.abs(theta), initial=0) > TURN else "rad"
    way = np.arctan2(np.diff(y), np.diff(x))
    moved = np.hypot(np.diff(x), np.diff(y)) > 0
    if not moved.any():
        return by_size, "by their size"
    agree = {unit: abs(np.nanmean(np.exp(1j * (way - f * theta[:-1]))[moved])) for unit, f in UNITS["angle"].items()}
    best = max(agree, key=lambda unit: agree[unit])
    if agree[best] > AGREE:
        return best, "as the path goes"
    return by_size, "by their size; they do not go with the path: is y to the left, and the heading, too?"


def _guessed(kind, meaning, a, of_time, degrees):
    a = a[np.isfinite(a)]
    if kind == "t":
        unit = of_time or time_unit(a)
        return UNITS["t"][unit], f"{unit}, by its rate"
    large = float(np.quantile(np.abs(a), 0.95)) if len(a) else 0.0
    if kind == "angle":
        in_degrees = large > (STEEPEST if meaning == "steer" else TURN) or (
            degrees and meaning in ("dtheta", *RATES_OF_TURN) and large > 1.0
        )
        unit = "deg" if in_degrees else "rad"
        return UNITS["angle"][unit], f"{unit}{PER[meaning in RATES_OF_TURN]}: up to {large:.3g}"
    middle = float(np.median(np.abs(a))) if len(a) else 0.0
    limit = FASTEST if meaning in SPEEDS else FARTHEST if meaning == "range" else np.inf
    unit = "mm" if middle > limit else "m"
    words = f"{unit}{PER[meaning in SPEEDS]}: up to {large:.3g}"
    return UNITS["length"][unit], words + "; length_unit = m says otherwise" * (unit == "mm")


def rate(t):
    """Words on the times of a table, s: how many, from when to when, rate, gaps."""
    times = np.unique(t)
    if len(times) < 2:
        return f"{len(t)} rows at one time"
    steps = np.diff(times)
    usual = float(np.median(steps))
    words = f"{len(t):,} rows, {times[0]:.10g} to {times[-1]:.10g} s, {1 / usual:.3g} Hz"
    gaps = np.flatnonzero(steps > max(GAP * usual, 0.5))
    if len(gaps):
        longest = gaps[np.argmax(steps[gaps])]
        words += f", {len(gaps)} gap{'s' * (len(gaps) > 1)}, the longest {steps[longest]:.3g} s"
        words += f" at {times[longest]:.10g} s"
    return words


def jumps(p):
    """Words on the jumps of a path, shape (n, d); nothing if there are none."""
    step = np.linalg.norm(np.diff(p, axis=0), axis=1)
    usual = float(np.quantile(step, 0.9)) if len(step) else 0.0
    far = np.flatnonzero(step > JUMP * max(usual, 1e-3))
    if not len(far):
        return None
    jumps = f"{len(far)} jump{'s' * (len(far) > 1)} of up to {step.max():.3g} m"
    return f"{jumps}, nine steps in ten are below {usual:.2g} m"


def ids(values):
    """Words on ids: how many different ones, how often each."""
    known = values[np.isfinite(values) & (values >= 0)]
    if not len(known):
        return "no ids: whose measurement it is must be found out"
    _, counts = np.unique(known, return_counts=True)
    words = f"{len(counts)} different ids, each {counts.min()} to {counts.max()} times"
    without = len(values) - len(known)
    return words + (f"; {without:,} rows without one" if without else "")
