"""Values that come from outside: one clear sentence for what is wrong with them, and where."""

from contextlib import contextmanager

import numpy as np

from ..ekf.covariances import faults
from ..models.protocols import METHODS, VALUES, lacking

MAIN = {"motion": "move", "sensor": "project", "landmark": "from_frame"}
"""The method by which a model of a role is known."""


@contextmanager
def errors_at(place):
    """Let every error from within begin with the place it happened at: a file, an entry, a key."""
    try:
        yield
    except (ValueError, TypeError) as error:
        raise type(error)(f"{place}: {error}") from error


def finite_array(what, a, ndim=None):
    """Turn numbers into an array of floats, of the right number of axes and all finite.

    Raises
    ------
    ValueError
        Beginning with `what`.
    """
    if np.ma.is_masked(a):
        raise ValueError(f"{what} must not have masked entries: leave out what is not known")
    try:
        array = np.asarray(a)
    except ValueError:  # rows of different lengths
        array = None
    if array is None or (array.size and array.dtype.kind not in "iuf"):
        raise ValueError(f"{what} must be numbers, in rows of equal length, got {short_text(a)}")
    array = array.astype(float)
    if ndim is not None and array.ndim != ndim:
        raise ValueError(f"{what} must have {ndim} axes, got shape {array.shape}")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        first = tuple(bad[0])
        got = f"but row {first[0]} holds {array[first]}" if array.size > 9 else f"got {short_text(a)}"
        raise ValueError(f"{what} must be finite, {got}")
    return array


def covariance_stack(what, a, m):
    """Read a stack (n, m, m) of symmetric positive semi-definite matrices."""
    a = finite_array(what, a, 3)
    if a.shape[1:] != (m, m):
        raise ValueError(f"{what} must be {m} x {m} matrices, got shape {a.shape}")
    skew, negative = faults(a)
    for bad, fault in ((skew, "symmetric"), (negative, "positive semi-definite")):
        if bad.any():
            raise ValueError(f"{what} must be {fault}, but row {np.flatnonzero(bad)[0]} is not")
    return a


def sized_vector(what, value, size, default=None):
    """Read exactly `size` finite numbers; a bare number will do for one. None stands for the default."""
    v = np.atleast_1d(finite_array(what, default if value is None else value))
    if v.shape != (size,):
        raise ValueError(f"{what} must be {size} number{'s' * (size > 1)}, got {short_text(value)}")
    return v


def std_vector(what, value, size):
    """Read `size` standard deviations; one number stands for all of them, None for zero."""
    v = np.atleast_1d(finite_array(what, 0.0 if value is None else value))
    if v.shape not in ((1,), (size,)):
        raise ValueError(f"{what} must be one number or {size}, got {short_text(value)}")
    if (v < 0).any():
        raise ValueError(f"{what} is a standard deviation and must not be negative, got {short_text(value)}")
    return np.broadcast_to(v, (size,)).copy()


def check_id(what, value):
    """Refuse what is not a whole number, 0 or more."""
    if not is_whole(value) or value < 0:
        raise ValueError(f"{what} must be a whole number, 0 or more, got {short_text(value)}")


def is_whole(value):
    """Return True if a value is a whole number by its type: 3, and not 3.0."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def check_kind(what, value, kind):
    """Refuse what is no object of a class of the toolbox."""
    if not isinstance(value, kind):
        raise TypeError(f"{what} must be a toolbox.{kind.__name__}, got {short_text(value)}")


def check_model(what, value, role):
    """Refuse what is no model of a role ("motion", "sensor", "landmark"): a class, or what has not all its parts."""
    if isinstance(value, type):
        raise TypeError(f"{what} must be a model, got a class; write {value.__name__}(...)")
    if not hasattr(value, MAIN[role]):
        raise TypeError(f"{what} must be a model, with the method {MAIN[role]}, got {short_text(value)}")
    role = "line" if hasattr(value, "normal") else role
    needed = (*VALUES[role], *METHODS[role])
    if absent := lacking(value, needed):
        raise TypeError(f"{type(value).__name__} has {absent}; a {role} has {', '.join(needed)}")


def short_text(value, width=60):
    """Write a value as a text of bounded length."""
    text = " ".join(repr(value.tolist() if isinstance(value, np.ndarray) else value).split())
    return text if len(text) <= width else text[: width - 3] + "..."
