"""What a wrong array has in common with the right one: the slips that happen in every exercise."""

from __future__ import annotations

import numpy as np

DEGREES = 180 / np.pi
LOST_DECIMALS = (
    "Yours has lost its decimals: is an array of type int?"  # untrue where all that is returned is of floats
)


def diagnose(got, want, rtol=1e-5) -> str:
    """Name the slip that turns `want` into `got`, or return an empty string.

    Parameters
    ----------
    got, want : array_like
        Numbers of the same shape, the student's and the right ones.
    rtol : float
        What counts as rounding, relative to the largest entry.

    Returns
    -------
    str
        One sentence, or "" if no common slip explains the difference.
    """
    got, want = np.asarray(got, float), np.asarray(want, float)
    if got.shape != want.shape or not np.isfinite(got).all():
        return ""
    if got.ndim > 0 and _is_nothing(got, want):
        return "Yours is zero."
    with np.errstate(all="ignore"):
        said = [sentence for explains, sentence in _SLIPS if explains(got, want, rtol)]
    if len({sentence[:20] for sentence in said}) > 1:  # of 4, 2 is the half and the root
        return ""
    return said[0] if said else _one_entry(got, want, rtol) or _rounded(got, want)


def same(a, b, rtol=1e-5, atol=1e-9) -> bool:
    """Return True if two arrays of one shape are equal but for rounding, relative to their largest entry."""
    scale = np.max(np.abs(b), initial=0.0)
    return bool(np.all(np.abs(np.subtract(a, b)) <= atol + rtol * scale))


def _alike(a, b, rtol=1e-5):
    """The same without an absolute tolerance: to it variances of 1e-8 and of 1e-12 are alike."""
    return same(a, b, rtol, atol=0.0)


def _is_nothing(got, want) -> bool:
    """Return True for zeros, and for what rounding has left of them."""
    return bool(np.all(np.abs(got) <= 1e-12 * np.max(np.abs(want), initial=0.0)))


def _is_square(a):
    return a.ndim == 2 and a.shape[0] == a.shape[1] > 1


def _is_covariance(a):
    """Return True for what can be a covariance: of several numbers, symmetric, no negative variance."""
    return _is_square(a) and _alike(a, a.T) and bool((np.diag(a) >= 0).all())


def _inverted(got, want, rtol):
    return _is_square(want) and _alike(got @ want, np.eye(len(want)), 1e-4) and not _alike(got, want, rtol)


def _lost_decimals(got, want, rtol):
    """Return True if it is no chance that all are whole: several large numbers are, and not the same ones."""
    large = (np.abs(want) > 1) & (want != np.round(want))
    return len(np.unique(got[large])) > 1 and any(np.array_equal(got, whole(want)) for whole in (np.trunc, np.round))


def _reversed_differs(want, rtol):
    return want.ndim == 1 and want.size > 1 and not _alike(want[::-1], want, rtol)


def _turns(got, want):
    """The entries that differ by whole turns, and those of them that were wrapped; none if others differ, too."""
    turns = (got - want) / (2 * np.pi)
    off = (np.abs(turns) > 0.5) & same(turns, np.round(turns), rtol=0, atol=1e-6)
    seam = np.pi + 1e-6
    return off, off & (np.abs(got) <= seam) & (np.abs(want) > seam)


def _not_wrapped(got, want, rtol):
    off, wrapped = _turns(got, want)
    return off.any() and not wrapped.any()


def _wrapped(got, want, rtol):
    off, wrapped = _turns(got, want)
    return off.any() and (wrapped == off).all()


def _wrapped_without_brackets(got, want, rtol):
    """Return True if the wrong entries are (a + pi) % 2 * pi - pi of the angles, for some whole turns."""
    got, want = np.ravel(got), np.ravel(want)
    off = np.abs(got - want) > 1e-9
    angles = want[off, None] + 2 * np.pi * np.arange(-4, 5)
    slipped = (angles + np.pi) % 2 * np.pi - np.pi
    return bool(off.any()) and bool(np.isclose(slipped, got[off, None], rtol=0, atol=1e-6).any(axis=1).all())


# Slips of all entries, the likely ones first. Each: what explains the difference, what to tell the student.
# Decimals are compared exactly: beside a large entry, such as a time stamp, the small ones would count as rounding.
_SLIPS = (
    (lambda g, w, r: _alike(g, -w, r), "The sign is the wrong way round."),
    (lambda g, w, r: _is_square(w) and _alike(g, w.T, r) and not _alike(w, w.T, r), "Yours is the transpose."),
    (_inverted, "Yours is the inverse."),
    (lambda g, w, r: _alike(g, 2 * w, r), "Yours is twice as large."),
    (lambda g, w, r: _is_covariance(w) and _alike(g, w / 2, r), "Yours is exactly half: was something counted twice?"),
    (lambda g, w, r: _alike(g, w / 2, r), "Yours is exactly half."),
    (lambda g, w, r: _alike(g, w * DEGREES, r), "Yours is in degrees: keep to radians."),
    (
        lambda g, w, r: _alike(g, w / DEGREES, r),
        "Yours looks converted from degrees: all angles are in radians already.",
    ),
    (_not_wrapped, "Yours is off by whole turns of 2 pi: wrap the angle."),
    (_wrapped, "Yours has lost whole turns of 2 pi: only an angle is wrapped."),
    (
        _wrapped_without_brackets,
        "Python reads `% 2*np.pi` as `(... % 2) * np.pi`: the whole turn needs brackets, `% (2 * np.pi)`.",
    ),
    (
        lambda g, w, r: _is_covariance(w) and _alike(g**2, w, r),
        "Yours is the square root: a covariance holds variances.",
    ),
    (lambda g, w, r: _alike(g**2, w, r), "Yours is the square root."),
    (lambda g, w, r: _alike(g, w**2, r), "Yours is the square."),
    (_lost_decimals, LOST_DECIMALS),
    (lambda g, w, r: _reversed_differs(w, r) and _alike(g, w[::-1], r), "The entries are in the wrong order."),
)


def _one_entry(got, want, rtol) -> str:
    """Say it if every wrong entry has the wrong sign, if symmetry is lost, or if only some entries are wrong."""
    scale = np.max(np.abs(want), initial=0.0)
    wrong = np.abs(got - want) > 1e-9 * min(scale, 1.0) + rtol * scale
    if got.ndim == 0 or not wrong.any():
        return ""
    places = [tuple(int(i) for i in place) for place in np.argwhere(wrong)]
    named = ", ".join(_bracket(p) for p in places[:4]) + (" ..." if len(places) > 4 else "")
    size, turned = np.abs(want[wrong]), _alike(got[wrong], -want[wrong], rtol)
    chosen = same(size, np.round(size), rtol) and _alike(size, size[:1], rtol)  # of 1 and -1 the sign tells little
    if turned and (len(places) > 2 or not chosen):
        return f"Wrong sign at {named}."
    if _alike(got[wrong], want[wrong] * DEGREES, rtol):
        return f"In degrees at {named}: keep to radians."
    if _alike(got[wrong], want[wrong] / DEGREES, rtol):
        return f"Converted from degrees at {named}: all angles are in radians already."
    if _is_nothing(got[wrong], want):
        return f"Missing (zero) at {named}."
    for entries, and_sign in ((want[wrong], ""), (-want[wrong], ", and their sign is wrong")):
        if 1 < len(places) <= 4 and not (and_sign and turned) and _alike(np.sort(got[wrong]), np.sort(entries), rtol):
            return f"The entries at {named} are exchanged{and_sign}."
    if _is_covariance(want) and not _alike(want, np.diag(np.diag(want))) and not same(got, got.T, 1e-4, 1e-4 * scale):
        return "Yours is not symmetric: what stands at [i, j] must stand at [j, i], too."
    return f"Wrong at {named} only." if len(places) <= want.size // 2 else ""


def _rounded(got, want) -> str:
    """Say it if the numbers were rounded."""
    for digits in (1, 2, 3, 4):
        if np.round(want, digits).any() and np.allclose(got, np.round(want, digits), 1e-12, 1e-9):
            return f"Yours is rounded to {digits} decimals: keep them all."
    return ""


def _bracket(place):
    return "[" + ", ".join(str(i) for i in place) + "]"
