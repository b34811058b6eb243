"""Recorded functions of lines and segments, in this package's words.

The recorded program takes an image line as [a, b, c] where this package takes the two pixels of a segment; the adapters
carry derivatives from one to the other.
"""

import numpy as np

from ekfslam_tutorial.models import retro_project
from ekfslam_tutorial.models.landmarks import AhmLin, AplLin, HmgLin, IdpLin, PlkLin
from ekfslam_tutorial.models.landmarks.lines import ends, vector_product
from ekfslam_tutorial.models.sensors import SegmentCam, pin_hole

from .adapters_geometry import by_frame
from .adapters_models import pole
from .births import FreeAplLin, RecordedHmgLin
from .records import APPROXIMATE, DEGENERATE, NOT_HERE, Skip

PLK, APL, IDP, HMG, AHM = PlkLin(), AplLin(), IdpLin(), HmgLin(), AhmLin()


def on_a_pole(lmk, *lines):
    """Whether the direction of an inverse-depth point of a line comes to lie on the z axis: see `pole`."""
    return lmk is IDP and pole(IDP.kind, *(l[[0, 1, 2, *last]] for l in lines for last in ((3, 4, 5), (6, 7, 8))))


def changed(name, lmk):
    """Adapter of a change of frame."""

    def change(_, F, l):
        value, L_f, L_l = getattr(lmk, name)(F, l)
        if on_a_pole(lmk, value):
            return Skip(DEGENERATE)
        return value, by_frame(L_f, F), L_l

    return change


def ends_of(lmk):
    """Adapter of the two points of a line with two abscissas: one vector, and its derivative."""

    def segment(_, l, t):
        p, P_l = ends(lmk, l, np.ravel(t))
        return p.ravel(), P_l.reshape(6, -1)

    return segment


def two_ends(lmk):
    """Adapter of the same as two points."""

    def endpoints(_, l, t1, t2):
        p, P_l = ends(lmk, l, np.array([t1, t2]))
        d = lmk.support(l)[1]
        return (*p, *P_l, d, d) if lmk is PLK else (*p, *P_l)

    return endpoints


def image(k, Sf, Rf, lmk, l):
    """Image line of a line, with its derivatives by both frames and the line, and the direction in the sensor."""
    F, F_r, F_s = Rf.compose(Sf)
    ls, LS_f, LS_l = lmk.to_frame(F, l)
    n, N_ls = lmk.normal(ls)
    e, E_n = SegmentCam(tuple(k)).project(n)
    scale = k[3] / E_n[0, 0]  # the recorded line is not normalised
    N_f = scale * E_n @ N_ls @ LS_f
    return scale * e, N_f @ F_r, N_f @ F_s, scale * E_n @ N_ls @ LS_l, lmk.support(ls)[1]


def projected(lmk):
    """Adapter of the projection of a Plücker line."""

    def project(_, Rf, Sf, k, l):
        h, H_r, H_s, H_l, _ = image(k, Sf, Rf, lmk, l)
        return h, Skip(NOT_HERE), by_frame(H_r, Rf), by_frame(H_s, Sf), Skip(NOT_HERE), H_l

    return project


def projected_ends(lmk):
    """Adapter of the projection of the two points of a line."""

    def project(_, Rf, Sf, k, l):
        F, F_r, F_s = Rf.compose(Sf)
        p, P_l = ends(lmk, l, np.array([0.0, 1.0]))
        v, V_f, V_p = F.to_frame(p)
        u, U_v, *_ = pin_hole.pin_hole(v, k, ())
        U_f = (U_v @ V_f).reshape(4, 7)
        S_r, S_s = by_frame(U_f @ F_r, Rf), by_frame(U_f @ F_s, Sf)
        return u.ravel(), Skip(NOT_HERE), S_r, S_s, Skip(NOT_HERE), (U_v @ V_p @ P_l).reshape(4, -1)

    return project


def started(lmk, recorded=None):
    """Adapter of a birth from a segment.

    Of an anchored homogeneous line one block of the recorded derivative is a row too high: see docs/differences.md.
    """

    def birth(_, Rf, Sf, k, segment, n):
        camera = SegmentCam(tuple(k))
        l, L_r, L_s, _, L_n = retro_project(Rf, Sf, camera, lmk, segment, n)
        L_y = retro_project(Rf, Sf, camera, recorded or lmk, segment, n)[3] if lmk is not AHM else Skip(APPROXIMATE)
        ls, *_ = lmk.from_rays(camera.retro(segment)[0], n)
        if on_a_pole(lmk, ls, lmk.from_frame(Sf, ls)[0], l):
            return Skip(DEGENERATE)
        return l, by_frame(L_r, Rf), by_frame(L_s, Sf), Skip(NOT_HERE), L_y, L_n

    return birth


def started_by_line(lmk):
    """Adapter of a birth from an image line: from two pixels of it, in the order that gives its sign."""

    def birth(_, Rf, Sf, k, h, beta):
        normal, w = h[:2] / (h[:2] @ h[:2]), np.array([-h[1], h[0]])
        y = np.concatenate([-h[2] * normal, -h[2] * normal + w])
        u, v = np.append(y[:2], 1), np.append(y[2:], 1)
        line, H_u, H_v = vector_product(u, v)
        if line @ h < 0:
            y, (line, H_u, H_v) = np.roll(y, 2), vector_product(v, u)
        l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, SegmentCam(tuple(k)), lmk, y, beta)
        H_y = np.concatenate([H_u[:, :2], H_v[:, :2]], 1) * np.sqrt((h @ h) / (line @ line))
        return l, by_frame(L_r, Rf), by_frame(L_s, Sf), Skip(NOT_HERE), L_y @ np.linalg.pinv(H_y), L_n

    return birth


def hms2hh(_, h, segment):
    """Distances of the ends of a segment from a line."""
    z, Z_y, Z_e = SegmentCam((0.0, 0.0, 1.0, 1.0)).innovation(segment, h)
    return z, Z_e, Z_y


def golden_innov_line(_, y, R, e, E):
    z, Z_e, Z_y = hms2hh(None, e, y)
    Z = Z_e @ E @ Z_e.T + Z_y @ R @ Z_y.T
    iZ = np.linalg.inv(Z)
    return z, Z, iZ, z @ iZ @ z, Z_e, Z_y


def moved_segment(_, F, s):
    v, V_f, V_p = F.to_frame(s.reshape(2, 3))
    J = np.zeros((6, 6))
    J[:3, :3] = J[3:, 3:] = V_p
    return v.ravel(), by_frame(V_f.reshape(6, 7), F), J


def visibleSegment(_, s, depths, size, margin, least):
    """The same by points in space: at these depths, in a camera of focal length 1."""
    camera = SegmentCam((0.0, 0.0, 1.0, 1.0), image_size=tuple(size), margin=margin, min_length=least)
    p = np.append(s.reshape(2, 2), np.ones((2, 1)), 1) * depths[:, None]
    y, seen = camera.segments(p.ravel())
    return (y if seen else np.zeros(4)), float(seen)


def anchored(_, L, x):
    return np.concatenate([x, L[:3] - np.cross(x, L[3:]), L[3:]]), Skip(NOT_HERE), Skip(NOT_HERE)


LINES = {
    "toFramePlucker": changed("to_frame", PLK),
    "fromFramePlucker": changed("from_frame", PLK),
    "fromFrameAPlucker": changed("from_frame", APL),
    "fromFrameIdpLin": changed("from_frame", IDP),
    "fromFrameHmgLin": changed("from_frame", HMG),
    "fromFrameAhmLin": changed("from_frame", AHM),
    "pluckerSegment": ends_of(PLK),
    "aPluckerSegment": ends_of(FreeAplLin()),
    "idpLinSegment": ends_of(IDP),
    "hmgLinSegment": ends_of(HMG),
    "ahmLinSegment": ends_of(AHM),
    "idpLin2seg": lambda _, l: ends_of(IDP)(None, l, np.array([0.0, 1.0])),
    "hmgLin2seg": lambda _, l: ends_of(HMG)(None, l, np.array([0.0, 1.0])),
    "ahmLin2seg": lambda _, l: ends_of(AHM)(None, l, np.array([0.0, 1.0])),
    "pluckerEndpoints": two_ends(PLK),
    "idpLinEndpoints": two_ends(IDP),
    "hmgLinEndpoints": two_ends(HMG),
    "ahmLinEndpoints": two_ends(AHM),
    "pluckerOrigin": lambda _, l: PLK.support(l)[0::2],
    "unanchorPlucker": lambda _, l: (np.concatenate([APL.normal(l)[0], l[6:]]), Skip(NOT_HERE)),
    "anchorPlucker": anchored,
    "projPlkLinIntoPinHoleOnRob": projected(PLK),
    "projAplLinIntoPinHoleOnRob": projected(APL),
    "projIdpLinIntoPinHoleOnRob": projected_ends(IDP),
    "projHmgLinIntoPinHoleOnRob": projected_ends(HMG),
    "projAhmLinIntoPinHoleOnRob": projected_ends(AHM),
    "retroProjPlkLinFromPinHoleOnRob": started_by_line(PLK),
    "retroProjAplLinFromPinHoleOnRob": started_by_line(APL),
    "retroProjIdpLinFromPinHoleOnRob": started(IDP),
    "retroProjHmgLinFromPinHoleOnRob": started(HMG, RecordedHmgLin()),
    "retroProjAhmLinFromPinHoleOnRob": started(AHM),
    "hms2hh": hms2hh,
    "golden_innov_line": golden_innov_line,
    "toFrameSegment": moved_segment,
    "visibleSegment": visibleSegment,
}
