"""Recorded functions of point landmarks, worlds and ellipses, in this package's words."""

import numpy as np

from ekfslam_tutorial.graphics import half_axes
from ekfslam_tutorial.models.landmarks import AhmPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.landmarks.idp_pnt import POLE, py2vec, vec2py
from ekfslam_tutorial.models.sensors import omni_cam as omni
from ekfslam_tutorial.simulation import worlds

from .adapters_geometry import by_frame
from .adapters_models import (
    inverse_pin_hole,
    omni_ray,
    pin_hole,
    pole,
    seen,
    seen_by_sensor,
    started,
    started_at_camera,
)
from .births import RecordedAhmPnt, RecordedHmgPnt
from .records import APPROXIMATE, DEGENERATE, Masked, Skip

# --- points ----------------------------------------------------------------------------------------------------------


def euclidean(lmk):
    """Adapter of a conversion to a Euclidean point."""

    def point(_, l):
        p, P_l = lmk.point(l.T)
        return (p.T,) if l.ndim == 2 else (p, P_l)

    return point


def frame_change(name, lmk):
    def change(_, F, l):
        value, L_f, L_l = getattr(lmk, name)(F, l)
        if pole(lmk, value):
            return Skip(DEGENERATE)
        return value, by_frame(L_f, F), L_l

    return change


def idp2ahp(_, l):
    m, M_py = py2vec(l[3:5])
    J = np.zeros((7, 6))
    J[:3, :3], J[3:6, 3:5], J[6, 5] = np.eye(3), M_py, 1
    return np.concatenate([l[:3], m, l[5:]]), J


def near_pole(v):
    """Whether a direction is so near to the z axis that its yaw has no digits: this package moves it off the axis."""
    return np.hypot(v[0], v[1]) < POLE * abs(v[2])


def ahp2idp(_, l):
    if near_pole(l[3:6]):
        return Skip(DEGENERATE)
    py, PY_m = vec2py(l[3:6])
    J = np.zeros((6, 7))
    J[:3, :3], J[3:5, 3:6], J[5, 6] = np.eye(3), PY_m, 1
    return np.concatenate([l[:3], py, l[6:]]), J


def p2idp(record, p, p0):
    """A point as seen first from p0. With Jacobians, the recorded inverse distance is documented as wrong."""
    l, L_p, _ = IdpPnt().from_point(p - p0)
    if pole(IdpPnt(), l):
        return Skip(DEGENERATE)
    l = l + np.concatenate([p0, np.zeros(3)])
    if record["nargout"] == 1:
        return [l]
    L_p0 = np.concatenate([np.eye(3), np.zeros((3, 3))]) - L_p
    return Masked(l, [5], APPROXIMATE), Masked(L_p, [5], APPROXIMATE), Masked(L_p0, [5], APPROXIMATE)


def pinHoleHmg(_, l, k, d):
    v, V_l = HmgPnt().ray(l)
    u, U_v, U_k, U_d = pin_hole(v, k, d)
    return u, HmgPnt().point(l)[0][2], U_v @ V_l, U_k, U_d


def linearity(lmk):
    def test(_, Rf, Sf, l, P):
        return [lmk.linearity(l, P, Rf.from_frame(Sf.t)[0])]

    return test


POINTS = {
    "idp2euc": euclidean(IdpPnt()),
    "ahm2euc": euclidean(AhmPnt()),
    "hmg2euc": euclidean(HmgPnt()),
    "idp2ahp": idp2ahp,
    "ahp2idp": ahp2idp,
    "py2vec": lambda _, py: py2vec(py),
    "vec2py": lambda _, v: Skip(DEGENERATE) if near_pole(v) else vec2py(v),
    "p2idp": p2idp,
    "euc2hmg": lambda _, p: (np.append(p, 1.0), np.eye(4)[:, :3]),
    "toFrameIdp": frame_change("to_frame", IdpPnt()),
    "fromFrameIdp": frame_change("from_frame", IdpPnt()),
    "toFrameHmg": frame_change("to_frame", HmgPnt()),
    "fromFrameHmg": frame_change("from_frame", HmgPnt()),
    "toFrameAhm": frame_change("to_frame", AhmPnt()),
    "fromFrameAhm": frame_change("from_frame", AhmPnt()),
    "pinHoleHmg": pinHoleHmg,
    "invPinHoleIdp": started_at_camera(inverse_pin_hole, IdpPnt()),
    "invPinHoleHmg": started_at_camera(inverse_pin_hole, HmgPnt(), RecordedHmgPnt()),
    "invPinHoleAhm": started_at_camera(inverse_pin_hole, AhmPnt(), RecordedAhmPnt()),
    "projIdpPntIntoPinHole": seen_by_sensor,
    "projIdpPntIntoPinHoleOnRob": seen(pin_hole, IdpPnt()),
    "projHmgPntIntoPinHoleOnRob": seen(pin_hole, HmgPnt()),
    "projAhmPntIntoPinHoleOnRob": seen(pin_hole, AhmPnt()),
    "projAhmPntIntoOmniCamOnRob": seen(omni.omni_cam, AhmPnt()),
    "retroProjIdpPntFromPinHoleOnRob": started(inverse_pin_hole, IdpPnt()),
    "retroProjHmgPntFromPinHoleOnRob": started(inverse_pin_hole, HmgPnt(), RecordedHmgPnt()),
    "retroProjAhmPntFromPinHoleOnRob": started(inverse_pin_hole, AhmPnt(), RecordedAhmPnt()),
    "retroProjAhmPntFromOmniCamOnRob": started(omni_ray, AhmPnt(), RecordedAhmPnt()),
    "golden_idplin": linearity(IdpPnt()),
    "golden_ahmlin": linearity(AhmPnt()),
}


# --- worlds and ellipses ----------------------------------------------------------------------------------------------


def cloister(_, x_min, x_max, y_min, y_max, n):
    return [worlds.cloister(x_min, x_max, y_min, y_max, int(n), height=None)[1].T]


def thick_cloister(_, x_min, x_max, y_min, y_max, height, n):
    return [worlds.cloister(x_min, x_max, y_min, y_max, int(n), height=height)[1].T]


def on_ellipse(record, x, P, n_sigma, _):
    """The point of this package's ellipse, or ellipsoid, in the direction of each recorded point: where it starts and
    which way it turns is not laid down."""
    A = n_sigma * half_axes(P)
    points = np.stack([np.ravel(out["value"]) for out in record["outs"]], -1)
    circle = np.linalg.solve(A, (points - x).T)
    return list(x[:, None] + A @ (circle / np.linalg.norm(circle, axis=0)))


OTHER = {
    "cloister": cloister,
    "thickCloister": thick_cloister,
    "golden_c2e": on_ellipse,
    "golden_c3e": on_ellipse,
}
