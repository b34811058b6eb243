"""The observation chain, written once for 2D and 3D, every sensor and every point landmark.

Direct model (manual, section 5.1): landmark -> sensor frame in the world -> measurement space.
Inverse model (manual, section 5.2): measurement and prior -> sensor frame in the world -> landmark.
"""

from math import inf

import numpy as np

from ..geometry.arrays import product


def to_sensor(Rf, Sf, sensor, lmk, l):
    """Landmarks seen from a sensor: points in the sensor frame, or rays towards them.

    Parameters
    ----------
    Rf, Sf : Frame2 or Frame3
        Robot frame in the world; sensor frame in the robot.
    sensor : SensorModel
        Its `bearing_only` tells whether a ray will do.
    lmk : LmkType
    l : ndarray, shape (..., lmk.size)
        Landmark states.

    Returns
    -------
    v : ndarray, shape (..., d)
        Point in the sensor frame in metres; for a bearing-only sensor a point up to a positive scale.
    V_r, V_s, V_l : ndarray, shape (..., d, size)
        With respect to the robot frame, the sensor frame and the landmark.
    """
    F, F_r, F_s = Rf.compose(Sf)
    v, V_f, V_l = seen_from(F, sensor, lmk, l)
    return v, product(V_f, F_r), product(V_f, F_s), V_l


def seen_from(F, sensor, lmk, l):
    """Landmarks seen from a sensor whose frame in the world is F.

    For a bearing-only sensor, a landmark with an inverse distance w goes through the frame as its ray m = w p:

        v = R' (m - w t)

    Its direction is not written as angles in between: an inverse-depth point on a camera's axis is no special case.

    Parameters
    ----------
    F : Frame2 or Frame3
    sensor, lmk, l
        As in `to_sensor`.

    Returns
    -------
    v : ndarray, shape (..., d)
    V_f, V_l : ndarray, shape (..., d, size)
    """
    if sensor.bearing_only and hasattr(lmk, "homogeneous"):
        m, w, M_l, W_l = lmk.homogeneous(l)
        v, V_f, V_m = F.to_frame(m, w)
        return v, V_f, product(V_m, M_l) - V_m.dot(F.t)[..., None] * W_l
    ls, LS_f, LS_l = lmk.to_frame(F, l)
    v, V_ls = lmk.ray(ls) if sensor.bearing_only else lmk.point(ls)
    return v, product(V_ls, LS_f), product(V_ls, LS_l)


def expect(Rf, Sf, sensor, lmk, l):
    """Direct observation model of a stack of landmarks, with all that a filter asks for.

    Parameters are those of `to_sensor`, l of shape (K, lmk.size).

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
    E_f = product(E_v, V_f)
    E_l = product(E_v, V_l)
    return e, v, product(E_f, F_r), product(E_f, F_s), np.broadcast_to(E_l, (*e.shape, E_l.shape[-1]))


def sight(F, sensor, lmk, l):
    """The expected measurements of many landmarks, without derivatives: to find those in view.

    Parameters are those of `seen_from`.

    Returns
    -------
    e : ndarray, shape (..., m)
        Expected measurements.
    v : ndarray, shape (..., d)
        Points in the sensor frame, or rays.
    """
    if sensor.bearing_only and hasattr(lmk, "homogeneous"):
        m, w, *_ = lmk.homogeneous(l)
        v = F.to_frame(m, w)[0]
    else:
        ls = lmk.to_frame(F, l)[0]
        v = lmk.ray(ls)[0] if sensor.bearing_only else lmk.point(ls)[0]
    return sensor.project(v)[0], v


def may_be_seen(F, sensor, lmk, l):
    """Which of many landmarks can be visible: those within the sensor's range; without a range, those in view.

    Parameters are those of `seen_from`.

    Returns
    -------
    ndarray of bool, shape (...)
    """
    reach = getattr(sensor, "max_range", inf)
    if reach == inf:
        return sensor.visible(*sight(F, sensor, lmk, l))
    d = lmk.point(l)[0] - F.t
    return np.einsum("...i,...i->...", d, d) <= (1 + 1e-9) * reach**2  # rounding must not leave out any


def observe(Rf, Sf, sensor, lmk, l):
    """Direct observation model: the expected measurement e = h(Rf, Sf, l). Manual, section 5.1.

    Parameters are those of `to_sensor`.

    Returns
    -------
    e : ndarray, shape (..., m)
        Expected measurement.
    E_r, E_s, E_l : ndarray, shape (..., m, size)
        With respect to the robot frame, the sensor frame and the landmark.
    """
    v, V_r, V_s, V_l = to_sensor(Rf, Sf, sensor, lmk, l)
    e, E_v = sensor.project(v)
    return e, E_v @ V_r, E_v @ V_s, E_v @ V_l


def retro_project(Rf, Sf, sensor, lmk, y, n):
    """Inverse observation model: the landmark l = g(Rf, Sf, y, n). Manual, section 5.2.

    Parameters
    ----------
    Rf, Sf, sensor, lmk
        As in `to_sensor`.
    y : ndarray, shape (..., m)
        Measurement.
    n : ndarray, shape (..., k)
        Prior of what the sensor does not measure (an inverse distance, 1/m); empty where it measures all.

    Returns
    -------
    l : ndarray, shape (..., lmk.size)
    L_r, L_s, L_y, L_n : ndarray, shape (..., lmk.size, ·)
        With respect to the robot frame, the sensor frame, the measurement and the prior (k columns, maybe none).

    Raises
    ------
    TypeError
        If the landmark type cannot be started from what the sensor measures.
    """
    check_fit(sensor, lmk, "from_ray" if sensor.bearing_only else "from_point")
    v, V_y = sensor.retro(y)
    ls, LS_v, LS_n = lmk.from_ray(v, n) if sensor.bearing_only else lmk.from_point(v)
    F, F_r, F_s = Rf.compose(Sf)
    l, L_f, L_ls = lmk.from_frame(F, ls)

    LS_y = product(LS_v, V_y)
    return l, product(L_f, F_r), product(L_f, F_s), product(L_ls, LS_y), product(L_ls, LS_n)


def observe_parameters(Rf, Sf, sensor, lmk, l):
    """Direct model once more, with the derivatives by the sensor's parameters. Manual, section 5.1.

    Only for sensors that have `project_parameters`: the cameras.

    Returns
    -------
    e : ndarray, shape (..., m)
    E_k, E_d : ndarray, shape (..., m, ·)
        With respect to the intrinsic parameters and the distortion.
    """
    v, *_ = to_sensor(Rf, Sf, sensor, lmk, l)
    return sensor.project_parameters(v)


def retro_project_parameters(Rf, Sf, sensor, lmk, y, n):
    """Inverse model once more, with the derivatives by the sensor's parameters. Manual, section 5.2.

    Only for sensors that have `retro_parameters`: the cameras.

    Returns
    -------
    l : ndarray, shape (..., lmk.size)
    L_k, L_c : ndarray, shape (..., lmk.size, ·)
        With respect to the intrinsic parameters and the correction vector (the distortion, if the sensor inverts it
        exactly).
    """
    v, V_k, V_c = sensor.retro_parameters(y)
    ls, LS_v, _ = lmk.from_ray(v, n) if sensor.bearing_only else lmk.from_point(v)
    l, _, L_ls = lmk.from_frame(Rf.compose(Sf)[0], ls)

    L_v = L_ls @ LS_v
    return l, L_v @ V_k, L_v @ V_c


def check_fit(sensor, lmk, needed=None):
    """Refuse a sensor and a landmark type that do not fit each other.

    Parameters
    ----------
    sensor : SensorModel
    lmk : LmkType
    needed : str, optional
        Method that the landmark type must have; by default the one that an observation needs.

    Raises
    ------
    TypeError
        Naming both.
    """
    sensor_name, lmk_name = type(sensor).__name__, type(lmk).__name__
    dims = getattr(sensor, "dim", None), getattr(lmk, "dim", None)
    if None not in dims and dims[0] != dims[1]:
        raise TypeError(f"{sensor_name} measures in {dims[0]} dimensions, and {lmk_name} is a landmark in {dims[1]}")
    needed = needed or ("ray" if sensor.bearing_only else "point")
    if not hasattr(lmk, needed):
        why = {"from_ray": "one ray does not fix it"}.get(needed, f"it has no method {needed}")
        verb = "started" if needed.startswith("from") else "observed"
        raise TypeError(f"{lmk_name} cannot be {verb} by {sensor_name}: {why}")
