"""The observation chain, written once for 2D and 3D, every sensor and every landmark.

Direct model (manual, section 5.1): landmark -> sensor frame in the world -> measurement space.
Inverse model (manual, section 5.2): measurement and prior -> sensor frame in the world -> landmark.
"""

from typing import Any

import numpy as np

from .calibrated import begun_with, seen_with


def to_sensor(Rf, Sf, sensor, lmk, l):
    """Landmarks seen from a sensor: points in the sensor frame, or rays towards them.

    For a bearing-only sensor, a landmark with an inverse distance w goes through the frame F as its ray m = w p:

        v = R' (m - w t)

    Its direction is not written as angles in between: an inverse-depth point on a camera's axis is no special case.

    A landmark that makes its own ranges wrong, as a radio beacon does, has `apparent`: where a sensor sees it. A sensor
    that needs something else than a ray says what in `asks`: one that sees lines asks for the `normal` of a plane.

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

    See Also
    --------
    observe : To the end of the chain, the measurement.
    """
    F, F_r, F_s = Rf.compose(Sf)
    if sensor.bearing_only and hasattr(lmk, "homogeneous"):
        m, w, M_l, W_l = lmk.homogeneous(l)
        v, V_f, V_m = F.to_frame(m, w)
        V_w = -F.Rt @ F.t[..., None]
        V_l = V_m @ M_l + V_w @ W_l
    else:
        ls, LS_f, LS_l = lmk.to_frame(F, l)
        point: Any = getattr(lmk, "apparent", None) or getattr(lmk, "point", None)
        v, V_ls = getattr(lmk, getattr(sensor, "asks", "ray"))(ls) if sensor.bearing_only else point(ls)
        V_f, V_l = V_ls @ LS_f, V_ls @ LS_l
    seen = v, V_f @ F_r, V_f @ F_s, V_l
    return seen_with(Rf, Sf, sensor, *seen) if hasattr(Rf, "velocity") or hasattr(Sf, "a") else seen


def birth(sensor):
    """Name of the method of a landmark that begins it: `from_ray`, `from_point`, or what the sensor says, `starts`."""
    return getattr(sensor, "starts", "from_ray" if sensor.bearing_only else "from_point")


def fits(sensor, lmk):
    """Return True unless one of them is for lines and the other for points, or the sensor sees no landmarks at all."""
    return hasattr(sensor, "innovation") == hasattr(lmk, "normal") and not hasattr(sensor, "without_lmks")


class ItsRobot:
    """Stand-in for a landmark, without a state, for a sensor that sees none: its own frame, F.x.

    GPS, a compass, a wheel: `without_lmks` sensors. They get F.x, and behind it what else they ask for.

    See Also
    --------
    to_sensor : Takes it as it takes a landmark type.
    """

    size = 0

    def to_frame(self, F, l):
        """Return the frame itself, a row for each l, and derivatives."""
        shape = np.shape(l)[:-1]
        return np.broadcast_to(F.x, (*shape, F.size)), np.eye(F.size), np.zeros((*shape, F.size, 0))

    def point(self, l):
        """Return the same."""
        return l, np.eye(l.shape[-1])


def expect(Rf, Sf, sensor, lmk, l):
    """Direct observation model, and what `sensor.visible` asks for: the expected measurement e = h(Rf, Sf, l).

    Parameters are those of `to_sensor`.

    Returns
    -------
    e : ndarray, shape (..., m)
        Expected measurement.
    v : ndarray, shape (..., d)
        Point in the sensor frame, or ray.
    E_r, E_s, E_l : ndarray, shape (..., m, size)
        With respect to the robot frame, the sensor frame and the landmark.

    See Also
    --------
    observe : The same without v.
    """
    v, V_r, V_s, V_l = to_sensor(Rf, Sf, sensor, lmk, l)
    e, E_v = sensor.project(v)
    if np.shape(E_v)[-2:] != (e.shape[-1], v.shape[-1]):
        refuse_derivative(sensor, E_v, (*e.shape, v.shape[-1]))
    E_v = np.broadcast_to(E_v, (*e.shape, v.shape[-1]))  # of a linear sensor it may be the same for all
    return e, v, E_v @ V_r, E_v @ V_s, E_v @ V_l


def refuse_derivative(sensor, E_v, shape):
    """Say that the derivative of `sensor.project` has another shape than it should.

    Raises
    ------
    ValueError
    """
    wanted = f"(..., {shape[-2]}, {shape[-1]})"
    raise ValueError(f"{type(sensor).__name__}.project: its Jacobian must have shape {wanted}, got {np.shape(E_v)}")


def observe(Rf, Sf, sensor, lmk, l):
    """Direct observation model: the expected measurement e = h(Rf, Sf, l). Manual, section 5.1.

    Parameters are those of `to_sensor`.

    Returns
    -------
    e : ndarray, shape (..., m)
        Expected measurement.
    E_r, E_s, E_l : ndarray, shape (..., m, size)
        With respect to the robot frame, the sensor frame and the landmark.

    See Also
    --------
    retro_project : The inverse model.
    observe_parameters : With respect to the sensor's parameters.
    """
    e, _, E_r, E_s, E_l = expect(Rf, Sf, sensor, lmk, l)
    return e, E_r, E_s, E_l


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

    See Also
    --------
    observe : The inverse, the direct model.
    retro_project_parameters : With respect to the sensor's parameters.
    check_fit : Which sensor can start which landmark.
    """
    check_fit(sensor, lmk, birth(sensor))
    known = not hasattr(Sf, "a")
    m, y = y.shape[-1], y if known else np.concatenate([y, np.broadcast_to(Sf.a, (*y.shape[:-1], len(Sf.a)))], -1)
    v, V_y = sensor.retro(y)
    start = getattr(lmk, birth(sensor))
    ls, LS_v, LS_n = start(v, n) if sensor.bearing_only else start(v)
    F, F_r, F_s = Rf.compose(Sf)
    l, L_f, L_ls = lmk.from_frame(F, ls)

    LS_y = LS_v @ V_y
    L_s, L_y = L_f @ F_s, L_ls @ LS_y
    return l, L_f @ F_r, *((L_s, L_y) if known else begun_with(Sf, L_s, L_y, m)), L_ls @ LS_n


def observe_parameters(Rf, Sf, sensor, lmk, l):
    """Direct model once more, with the derivatives by the sensor's parameters. Manual, section 5.1.

    Only for sensors that have `project_parameters`: the cameras.

    Returns
    -------
    e : ndarray, shape (..., m)
    E_k, E_d : ndarray, shape (..., m, ·)
        With respect to the intrinsic parameters and the distortion.

    See Also
    --------
    observe : With respect to frames and landmark.
    retro_project_parameters : The inverse model.
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

    See Also
    --------
    retro_project : With respect to frames, measurement and prior.
    observe_parameters : The direct model.
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

    See Also
    --------
    check_pair : Tests both models of a sensor and a landmark type.
    """
    sensor_name, lmk_name = type(sensor).__name__, type(lmk).__name__
    dims = getattr(sensor, "dim", None), getattr(lmk, "dim", None)
    if None not in dims and dims[0] != dims[1]:
        raise TypeError(f"{sensor_name} measures in {dims[0]} dimensions, and {lmk_name} is a landmark in {dims[1]}")
    needed = needed or getattr(sensor, "asks", "ray" if sensor.bearing_only else "point")
    if needed.startswith("from") and not hasattr(sensor, "retro"):
        raise TypeError(f"{lmk_name} cannot be started by {sensor_name}: it has no method retro")
    if not hasattr(lmk, needed):
        why = {"from_ray": "one ray does not fix it"}.get(needed, f"it has no method {needed}")
        verb = "started" if needed.startswith("from") else "observed"
        raise TypeError(f"{lmk_name} cannot be {verb} by {sensor_name}: {why}")
