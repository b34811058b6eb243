"""Parameters that make no sensor are refused, early and in one sentence."""

import numpy as np


def _as_float(model, name):
    """A field as a float, NaN if it is none."""
    try:
        return float(getattr(model, name))
    except (TypeError, ValueError):
        return np.nan


def check_positive(model, *names, infinite=()):
    """Refuse fields that are not positive numbers; those named in `infinite` may be infinite.

    Raises
    ------
    ValueError

    See Also
    --------
    check_angle : For angles.
    finite_numbers : For lists of numbers.
    """
    for name in names:
        value = _as_float(model, name)
        if not value > 0 or (value == np.inf and name not in infinite):
            raise ValueError(f"{type(model).__name__}: {name} must be a positive number, got {getattr(model, name)!r}")


def check_angle(model, name, limit):
    """Refuse an angle above the limit: it was meant in degrees.

    Raises
    ------
    ValueError

    See Also
    --------
    check_positive : For all positive parameters.
    """
    value = _as_float(model, name)
    if value > limit + 1e-9:
        raise ValueError(
            f"{type(model).__name__}: {name} is in radians and at most {limit:.4g}, got {value:.6g}; degrees?"
        )


def check_dim(model):
    """Refuse a field `dim` that is neither 2 nor 3.

    Raises
    ------
    ValueError

    See Also
    --------
    check_positive : For all positive parameters.
    """
    if model.dim not in (2, 3):
        raise ValueError(f"{type(model).__name__}: dim must be 2 or 3, got {model.dim!r}")


def finite_numbers(model, name, size=None):
    """A field as an array of finite numbers.

    Raises
    ------
    ValueError
        Saying what the field must be.

    See Also
    --------
    check_positive : For single numbers.
    """
    try:
        value = np.asarray(getattr(model, name), float)
    except (TypeError, ValueError):
        value = np.full(1, np.nan)
    if value.ndim != 1 or (size is not None and value.size != size) or not np.isfinite(value).all():
        count = "a list of" if size is None else size
        raise ValueError(f"{type(model).__name__}: {name} must be {count} finite numbers, got {getattr(model, name)!r}")
    return value
