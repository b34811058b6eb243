"""What is refused before anything has been changed. What is good is found to be so quickly; if not, `slam` says why."""

from math import inf, isfinite

import numpy as np
from scipy.linalg.lapack import dpotrf  # pyright: ignore[reportAttributeAccessIssue]

from .core import check_control, check_raw, faults

FLOAT, NUMBER = np.dtype(float), (float, int)
ROUNDED = 1e-12
"""Of the largest number: asymmetry, and eigenvalues below zero. `faults` allows more; so little is beyond doubt."""


def check_map(map):
    """Refuse a map that these steps cannot work on."""
    if not hasattr(map, "notes"):
        raise TypeError(f"the steps of `fast` need a map of `fast`: take fast.new_map(), got {type(map).__name__}")


def check_step(map, rob, dt):
    """Refuse a control, a control covariance or a duration that no robot can move by."""
    check_map(map)
    noted, u, U = map.notes.of(rob), rob.u, rob.U
    motion, shape, covariance = noted.control
    good = motion is rob.motion and _floats(u) and u.shape == shape
    if good and u.ndim == 2:
        good = (
            isfinite(sum(u.ravel().tolist()))
            and _floats(dt)
            and dt.shape == shape[:1]
            and 0 <= dt.min(initial=0.0)
            and dt.max(initial=0.0) < inf
        )
    else:
        good = good and isfinite(sum(u.tolist())) and isinstance(dt, NUMBER) and 0 <= dt < inf
    if not good or not (rob.r is None or _written(U) == covariance or clearly_covariance(U, shape)):
        check_control(rob, dt)
        noted.control = rob.motion, np.shape(u), None if rob.r is None else _written(U)


def _floats(a):
    return type(a) is np.ndarray and a.dtype == FLOAT


def _written(U):
    """Return what a covariance is compared by, one like no other if it is not an array of floats."""
    return (U.shape, U.tobytes()) if _floats(U) else object()


def clearly_covariance(U, shape):
    """Return True if U is a covariance of a control of this shape beyond doubt: finite, symmetric but for rounding, and
    zero or with a Cholesky factor, which a robot that turns on the spot has but for rounding. That is found out sooner
    than eigenvalues are, and in many logs each control has a covariance of its own."""
    if not (_floats(U) and len(shape) == 1 and U.shape == shape * 2 and isfinite(sum(U.ravel().tolist()))):
        return False
    tiny = ROUNDED * U.max(initial=0.0)
    good = np.abs(U - U.T).max(initial=0.0) <= tiny
    return bool(good and (dpotrf(U + tiny * np.eye(len(U)))[1] == 0 or not U.any()))


def check_measurements(map, raw, sen):
    """Refuse raw measurements that are none of this sensor. Returns True if their squares are finite, too."""
    check_map(map)
    m, ids, y, R = len(sen.model.R), raw.ids, raw.y, raw.R
    good = type(ids) is np.ndarray and ids.ndim == 1 and ids.dtype.kind in "iu"
    good = good and _floats(y) and y.shape == (len(ids), m) and isfinite((numbers := y.ravel()).dot(numbers))
    if good and R is not None:
        good = _floats(R) and R.shape == (len(ids), m, m) and isfinite(np.vdot(R, R)) and not np.any(faults(R))
    if not good:
        check_raw(raw, sen)
    return good
