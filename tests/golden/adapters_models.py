"""Recorded functions of cameras, and of what they see, in this package's words.

The recorded observation functions join a landmark, a sensor and both frames by hand. Here the chain rule is written
once (`to_sensor`, `retro_project`), so the adapters only add the derivatives by intrinsics and distortion, which the
chain does not need.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models import retro_project, to_sensor
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, IdpPnt
from ekfslam_tutorial.models.landmarks.idp_pnt import POLE
from ekfslam_tutorial.models.sensors import PinHole, PinHoleDepth, lens
from ekfslam_tutorial.models.sensors import omni_cam as omni
from ekfslam_tutorial.models.sensors import pin_hole as pin

from .adapters_geometry import by_frame
from .births import RecordedAhmPnt
from .records import APPROXIMATE, DEGENERATE, Skip

NO_LENS = np.zeros(0)
UNIT_CAMERA = np.array([0.0, 0.0, 1.0, 1.0])


# --- camera ----------------------------------------------------------------------------------------------------------


def vec(d):
    """A vector of one number is recorded as a number."""
    return np.atleast_1d(d)


def pin_hole(p, k, d):
    return pin.pin_hole(p, k, vec(d))


def pinHole(record, p, k=UNIT_CAMERA, d=NO_LENS):
    u, U_p, U_k, U_d = pin_hole(p.T, k, d)
    return u.T, p[2], U_p, U_k, U_d


def pinHoleDepth(_, p, k, d):
    model = PinHoleDepth(tuple(k), tuple(vec(d)))
    v, V_p = model.project(p.T)
    if p.ndim == 2:
        return [v.T]
    _, _, U_k, U_d = pin_hole(p, k, d)
    return v, V_p, below(U_k), below(U_d)


def below(U):
    """A row of zeros under a Jacobian: the depth does not depend on the image."""
    return np.concatenate([U, np.zeros((1, U.shape[1]))])


def invPinHole(_, u, s, k, c):
    return pin.inv_pin_hole(u, vec(s), k, vec(c))


def invPinHoleDepth(_, v, k, c):
    p, P_u, P_s, P_k, P_c = pin.inv_pin_hole(v[:2], v[2:], k, vec(c))
    return p, np.concatenate([P_u, P_s], 1), P_s, P_k, P_c


def isVisible(_, u, depth, size, margin=0.0):
    """A margin is the same as a smaller image."""
    camera = PinHole(image_size=tuple(np.asarray(size) - 2 * margin))
    return [camera.visible(u - margin, np.array([0.0, 0.0, depth]))]


def inSquare(_, u, square, margin=0.0):
    square = np.ravel(square)
    low, high = square[[0, 2]] + margin, square[[1, 3]] - margin
    return [PinHole(image_size=tuple(high - low)).inside(u.T - low)]


def intrinsic(_, k):
    u0, A, _ = pin.pixellise(np.zeros(2), k)
    return [affine(A, u0)]


def invIntrinsic(_, k):
    u0, A, _ = pin.depixellise(np.zeros(2), k)
    return [affine(A, u0)]


def affine(A, t):
    return np.block([[A, np.asarray(t)[:, None]], [np.zeros((1, 2)), np.ones((1, 1))]])


def omniCam(_, p, k, d):
    u, U_p, U_k, U_d = omni.omni_cam(p, k, d)
    return u, p[2], U_p, U_k, U_d


def omni_retro(_, u, c):
    """The recorded Jacobians leave out the derivative of normalising the ray."""
    return omni.omni_retro(u, c)[0], Skip(APPROXIMATE), Skip(APPROXIMATE)


def invOmniCam(_, u, k, c):
    return omni.inv_omni_cam(u, k, c)[0], *[Skip(APPROXIMATE)] * 3


def omni_ray(u, k, c):
    """Pixel to a ray, and its derivatives by pixel, intrinsics and polynomial."""
    w, W_u, W_k = omni.omni_depixellise(u, k)
    v, V_w, V_c = omni.omni_ray(w, c)
    return v, V_w @ W_u, V_w @ W_k, V_c


# --- landmarks seen by a sensor, and started by one -------------------------------------------------------------------

POINT = SimpleNamespace(bearing_only=False)
RAY = SimpleNamespace(bearing_only=True)


@dataclass
class Given:
    """A stand-in sensor whose measurement is the ray, or the point, itself: it gives a birth's derivative by it."""

    bearing_only: bool

    def retro(self, v):
        return v, np.eye(3)


def pole(lmk, *states):
    """Whether an inverse-depth point's direction comes to lie on the z axis of some frame on its way.

    Its yaw has no meaning there. This package moves such a direction off the axis by 1e-8 rad, which is more than the
    tolerance of the comparison.
    """
    return isinstance(lmk, IdpPnt) and any((np.cos(l[..., 3]) < 10 * POLE).any() for l in states)


def seen(lens, lmk):
    """Adapter of a projection: landmark to robot frame, to sensor frame, through the lens (p, k, d)."""

    def project(record, Rf, Sf, k, d, l):
        lr = lmk.to_frame(Rf, l.T)[0]
        if pole(lmk, lr, lmk.to_frame(Sf, lr)[0]):
            return Skip(DEGENERATE)
        depth = to_sensor(Rf, Sf, POINT, lmk, l.T)[0][..., 2]
        v, V_r, V_s, V_l = to_sensor(Rf, Sf, RAY, lmk, l.T)
        u, U_v, U_k, U_d = lens(v, k, d)
        if l.ndim == 2:
            return u.T, depth
        return u, depth, by_frame(U_v @ V_r, Rf), by_frame(U_v @ V_s, Sf), U_k, U_d, U_v @ V_l

    return project


def seen_with_depth(record, Rf, Sf, k, d, l):
    v, V_r, V_s, V_l = to_sensor(Rf, Sf, POINT, EucPnt(), l)
    y, Y_v, Y_k, Y_d = pinHoleDepth(None, v, k, d)
    return y, by_frame(Y_v @ V_r, Rf), by_frame(Y_v @ V_s, Sf), Y_k, Y_d, Y_v @ V_l


def seen_by_sensor(_, Sf, k, d, l):
    """The same without a robot: its frame is the world's."""
    outs = seen(pin_hole, IdpPnt())(None, WORLD, Sf, k, d, l)
    return outs if isinstance(outs, Skip) else (*outs[:2], *outs[3:])


WORLD = Frame3(np.array([0.0, 0, 0, 1, 0, 0, 0]))


def started(inverse_lens, lmk, recorded=None):
    """Adapter of a birth: pixel through the inverse lens (u, k, c) to a ray, and the prior n, to a landmark.

    Where the recorded derivative of the birth is the approximate one, `recorded` is the landmark class that imitates
    it: the value and the Jacobians by the frames and the prior come from the package's class, those by pixel,
    intrinsics and correction from the imitation. (For the omnidirectional camera the recorded derivative by the
    polynomial is left out: it lacks the normalisation altogether.)
    """

    def birth(record, Rf, Sf, k, c, u, n):
        v, V_u, V_k, V_c = inverse_lens(u, k, c)
        n = vec(n)
        ls = lmk.from_ray(v, n)[0]
        lr = lmk.from_frame(Sf, ls)[0]
        if pole(lmk, ls, lr, lmk.from_frame(Rf, lr)[0]):
            return Skip(DEGENERATE)
        l, L_r, L_s, _, L_n = retro_project(Rf, Sf, Given(True), lmk, v, n)
        L_v = retro_project(Rf, Sf, Given(True), recorded or lmk, v, n)[3]
        L_c = Skip(APPROXIMATE) if inverse_lens is omni_ray else L_v @ V_c
        return l, by_frame(L_r, Rf), by_frame(L_s, Sf), L_v @ V_k, L_c, L_v @ V_u, L_n

    return birth


def started_at_camera(inverse_lens, lmk, recorded=None):
    """The same in the sensor frame, with the arguments (u, n, k, c)."""

    def birth(_, u, n, k, c):
        outs = started(inverse_lens, lmk, recorded)(None, WORLD, WORLD, k, c, u, n)
        if isinstance(outs, Skip):
            return outs
        l, _, _, L_k, L_c, L_u, L_n = outs
        return l, L_u, L_n, L_k, L_c

    return birth


def inverse_pin_hole(u, k, c):
    """Pixel to a ray of depth 1."""
    p, P_u, _, P_k, P_c = pin.inv_pin_hole(u, np.ones(1), k, vec(c))
    return p, P_u, P_k, P_c


def started_with_depth(_, Rf, Sf, k, c, v):
    p, P_v, P_s, P_k, _ = invPinHoleDepth(None, v, k, c)
    l, L_r, L_s, L_p, _ = retro_project(Rf, Sf, Given(False), EucPnt(), p, np.zeros(0))
    return l, by_frame(L_r, Rf), by_frame(L_s, Sf), L_p @ P_s, L_p @ P_k, L_p @ P_v


CAMERA = {
    "invDistortion": lambda _, d, n, k: [lens.inv_distortion(vec(d), int(n), k)],
    "distort": lambda _, u, d: lens.distort(u, vec(d)),
    "undistort": lambda _, u, c: lens.undistort(u, vec(c)),
    "pixellise": lambda _, u, k: pin.pixellise(u, k),
    "depixellise": lambda _, u, k: pin.depixellise(u, k),
    "persp_project": lambda _, p: pin.project(p),
    "persp_retro": lambda _, u, s: pin.retro(u, np.array([s])),
    "pinHole": pinHole,
    "pinHoleDepth": pinHoleDepth,
    "invPinHole": invPinHole,
    "invPinHoleDepth": invPinHoleDepth,
    "isVisible": isVisible,
    "inSquare": inSquare,
    "intrinsic": intrinsic,
    "invIntrinsic": invIntrinsic,
    "omniCam": omniCam,
    "omni_project": lambda _, p, d: omni.omni_project(p, d),
    "omni_retro": omni_retro,
    "invOmniCam": invOmniCam,
    "pixelliseOmniCam": lambda _, u, k: omni.omni_pixellise(u, k),
    "depixelliseOmniCam": lambda _, u, k: omni.omni_depixellise(u, k),
    "invOmniCamAhm": started_at_camera(omni_ray, AhmPnt(), RecordedAhmPnt()),
    "projEucPntIntoPinHoleOnRob": seen(pin_hole, EucPnt()),
    "projEucPntIntoPhdOnRob": seen_with_depth,
    "projEucPntIntoOmniCamOnRob": seen(omni.omni_cam, EucPnt()),
    "retroProjEucPntFromPhdOnRob": started_with_depth,
}
