"""The observation chain once more, for stacks of landmarks: one frame, from the world to the sensor, for all of them.

`models/observation.py` goes through the robot's frame and then through the sensor's. Here both are composed first, what
is the identity is not multiplied, and without derivatives none are made.
"""

from math import inf

import numpy as np

from ..models.observation import refuse_derivative

IDENTITIES = {n: np.eye(n).tobytes() for n in range(1, 9)}


def product(A, B):
    """Return the product of two Jacobians, or stacks of them. A single identity matrix costs nothing."""
    if A.ndim == 2 and _is_identity(A):
        return B
    if B.ndim > 2:
        return A @ B
    if _is_identity(B):
        return A
    return A.dot(B) if A.ndim == 2 else A.reshape(-1, len(B)).dot(B).reshape(*A.shape[:-1], B.shape[1])


def _is_identity(A):
    m, n = A.shape
    return m == n and A.dtype == float and A.tobytes() == IDENTITIES.get(n)


def seen_from(F, sensor, lmk, l):
    """Landmarks seen from a sensor whose frame in the world is F.

    For a bearing-only sensor, a landmark with an inverse distance w goes through the frame as its ray m = w p:
    v = R' (m - w t).

    Parameters
    ----------
    F : Frame2 or Frame3
    sensor : SensorModel
    lmk : LmkType
    l : ndarray, shape (..., lmk.size)

    Returns
    -------
    v : ndarray, shape (..., d)
        Points in the sensor frame, or rays.
    V_f, V_l : ndarray, shape (..., d, size)
    """
    if sensor.bearing_only and hasattr(lmk, "homogeneous"):
        m, w, M_l, W_l = lmk.homogeneous(l)
        v, V_f, V_m = F.to_frame(m, w)
        return v, V_f, product(V_m, M_l) - V_m.dot(F.t)[..., None] * W_l
    ls, LS_f, LS_l = lmk.to_frame(F, l)
    v, V_ls = lmk.ray(ls) if sensor.bearing_only else getattr(lmk, "apparent", lmk.point)(ls)
    return v, product(V_ls, LS_f), product(V_ls, LS_l)


def expect(Rf, Sf, sensor, lmk, l):
    """Direct observation model of a stack of landmarks, with all that a filter asks for.

    Parameters
    ----------
    Rf, Sf : Frame2 or Frame3
        Robot frame in the world; sensor frame in the robot.
    sensor, lmk, l
        As in `seen_from`, l of shape (K, lmk.size).

    Returns
    -------
    e : ndarray, shape (K, m)
        Expected measurements.
    v : ndarray, shape (K, d)
        Points in the sensor frame, or rays.
    E_r, E_s, E_l : ndarray, shape (K, m, size)
        Derivatives of e; E_l of shape (m, size) where it is the same for all.
    """
    F, F_r, F_s = Rf.compose(Sf)
    v, V_f, V_l = seen_from(F, sensor, lmk, l)
    e, E_v = sensor.project(v)
    shape = *e.shape, v.shape[-1]
    if E_v.shape[-2:] != shape[-2:]:
        refuse_derivative(sensor, E_v, shape)
    E_f = product(E_v, V_f)
    return e, v, product(E_f, F_r), product(E_f, F_s), product(E_v, V_l)


def sight(F, sensor, lmk, l):
    """Return what `expect` does first, e and v, without derivatives: to find those in view."""
    if sensor.bearing_only and hasattr(lmk, "homogeneous"):
        m, w, *_ = lmk.homogeneous(l)
        v = F.to_frame(m, w)[0]
    else:
        ls = lmk.to_frame(F, l)[0]
        v = lmk.ray(ls)[0] if sensor.bearing_only else getattr(lmk, "apparent", lmk.point)(ls)[0]
    return sensor.project(v)[0], v


def may_be_seen(Rf, Sf, sensor, lmk, l, off=0.0):
    """Return which of many landmarks can be visible: those in range; without a range, those in view.

    Parameters are those of `expect`, and `off`: by so much points may be elsewhere. It counts where only the range is
    looked at.

    Returns
    -------
    ndarray of bool, shape (...)
    """
    max_range = getattr(sensor, "max_range", inf)
    if max_range == inf or hasattr(lmk, "apparent"):
        e, v = sight(Rf.compose(Sf)[0], sensor, lmk, l)
        return np.broadcast_to(sensor.visible(e, v), e.shape[:-1])
    d = lmk.point(l)[0] - (Rf.R @ Sf.t + Rf.t)
    return np.einsum("...i,...i->...", d, d) <= (1 + 1e-9) * (max_range + off) ** 2  # rounding must leave out none
