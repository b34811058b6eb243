"""Recorded functions of rotations and frames, in this package's words.

Each adapter takes the record and its arguments and gives the outputs in the recorded order.
"""

import numpy as np

from ekfslam_tutorial import geometry as g
from ekfslam_tutorial.geometry import Frame3

from .records import APPROXIMATE, DEGENERATE, EitherSign, Skip, Tangent


def by_q(J, q):
    """Jacobian by a quaternion."""
    return Tangent(J, [(0, q)])


def by_frame(J, F):
    """Jacobian by a frame's seven numbers."""
    return Tangent(J, [(3, F.q)])


def columns(R_x):
    """Jacobian (3, 3, n) of a matrix with its nine entries column by column, as recorded: shape (9, n)."""
    return np.swapaxes(R_x, 0, 1).reshape(9, -1)


def turn(q):
    """The frame at the origin with orientation q."""
    return Frame3(np.concatenate([np.zeros(3), q]))


# --- rotations -------------------------------------------------------------------------------------------------------


def q2R(_, q):
    R, R_q = g.q2R(q)
    return R, by_q(columns(R_q), q)


def q2e(_, q):
    e, E_q = g.q2e(q)
    return e, by_q(E_q, q)


def q2eG(_, q, Q):
    e, E_q = g.q2e(q)
    return e, E_q @ Q @ E_q.T


def q2v(_, q):
    v, V_q = g.q2v(q)
    return v, by_q(V_q, q)


def q2au(record, q):
    """Where it gives Jacobians, the recorded program takes an arbitrary axis for angles below 1e-7."""
    a, u, A_q, U_q = g.q2au(q)
    if record["nargout"] == 4 and np.linalg.norm(q[1:]) < 1e-7:
        return Skip(DEGENERATE)
    return a, u, by_q(A_q[None], q), by_q(U_q, q)


def R2e(_, R):
    if np.hypot(R[0, 0], R[1, 0]) < 1e-8:  # gimbal lock: roll and yaw are one rotation
        return Skip(DEGENERATE)
    return [g.q2e(g.R2q(R)[0])[0]]


def e2R(_, e):
    R, R_e = g.e2R(e)
    return R, columns(R_e)


def rotate(q, p):
    F = turn(q)
    rp, RP_f, RP_p = F.from_frame(p)
    return rp, by_q(RP_f[:, 3:], q), RP_p


def qRot(_, v, q):
    w, W_q, W_v = rotate(q, v)
    return w, W_v, W_q


def Rtp(_, q, p):
    rp, RP_f, RP_p = turn(q).to_frame(p)
    return rp, by_q(RP_f[:, 3:], q), RP_p


def hat(_, v):
    return g.hat(v), columns(np.stack([g.hat(e) for e in np.eye(3)], -1))


def right_jacobian(_, v):
    """The right Jacobian of the rotation group, from the derivative of v2q: q* dq = [0, Jr dv / 2]."""
    q, Q_v = g.v2q(v)
    return [2 * (g.q2Q(g.q2qc(q)[0]) @ Q_v)[1:]]


def normvec(_, v, method=0.0):
    u, U_v = g.unit(v)
    return u, Skip(APPROXIMATE) if method == 1 else U_v


def v2au(_, v):
    a, u, A_v, U_v = g.v2au(v)
    if a == 0:  # the axis of no rotation is not defined
        return a, Skip(DEGENERATE), A_v[None], Skip(DEGENERATE)
    return a, u, A_v[None], U_v


ROTATIONS = {
    "q2R": q2R,
    "q2e": q2e,
    "q2eG": q2eG,
    "q2v": q2v,
    "q2au": q2au,
    "q2qc": lambda _, q: g.q2qc(q),
    "q2Pi": lambda _, q: [g.q2Pi(q)],
    "q2Q": lambda _, q: [g.q2Q(q)],
    "q2Qn": lambda _, q: [g.q2Qn(q)],
    "pi2pc": lambda _, Pi: [g.pi2pc(Pi)],
    "qProd": lambda _, q1, q2: g.q_prod(q1, q2),
    "qRot": qRot,
    "Rp": lambda _, q, p: rotate(q, p),
    "Rtp": Rtp,
    "R2q": lambda _, R: [EitherSign(g.R2q(R)[0])],
    "R2e": R2e,
    "normquat": lambda _, q: g.unit(q),
    "e2R": e2R,
    "e2q": lambda _, e: g.e2q(e),
    "v2q": lambda _, v: g.v2q(v),
    "v2R": lambda _, v: [g.q2R(g.v2q(v)[0])[0]],
    "v2au": v2au,
    "au2q": lambda _, a, u: (lambda q, Q_a, Q_u: (q, Q_a[:, None], Q_u))(*g.au2q(a, u)),
    "w2omega": lambda _, w: [g.w2omega(w)],
    "hat": hat,
    "Jr": right_jacobian,
    "flu2rdf": lambda _: [g.e2R(np.radians([-90, 0, -90]))[0]],
    "normvec": normvec,
}


# --- frames ----------------------------------------------------------------------------------------------------------


def updateFrame(_, F, normalize=0.0):
    F = F if isinstance(F, Frame3) else Frame3(F["x"])
    return [F.normalized()[0] if normalize else F]


def composeFrames(_, F, G):
    H, H_f, H_g = F.compose(G)
    return H, by_frame(H_f, F), by_frame(H_g, G)


def invertFrame(_, F):
    I, I_f = F.inverse()
    return I, by_frame(I_f, F)


def frameIncrement(_, F, G):
    """G seen from F: the inverse of F composed with G."""
    vectors = not isinstance(F, Frame3)
    F, G = (Frame3(X) if vectors else X for X in (F, G))
    I, I_f = F.inverse()
    D, D_i, D_g = I.compose(G)
    return D.x if vectors else D, by_frame(D_i @ I_f, F), by_frame(D_g, G)


def points_in(change, F, p, w=1.0):
    """One point with Jacobians, or a matrix of points without."""
    if p.ndim == 2:
        return [change(p.T, w)[0].T]
    value, V_f, V_p = change(p, w)
    return value, by_frame(V_f, F), V_p


def qpose2epose(_, x):
    e, E_q = g.q2e(x[3:])
    return np.concatenate([x[:3], e]), Tangent(block(np.eye(3), E_q), [(3, x[3:])])


def qpose2vpose(_, x):
    v, V_q = g.q2v(x[3:])
    return np.concatenate([x[:3], v]), Tangent(block(np.eye(3), V_q), [(3, x[3:])])


def epose2qpose(_, x):
    q, Q_e = g.e2q(x[3:])
    return np.concatenate([x[:3], q]), block(np.eye(3), Q_e)


def vpose2qpose(_, x):
    q, Q_v = g.v2q(x[3:])
    return np.concatenate([x[:3], q]), block(np.eye(3), Q_v)


def block(A, B):
    """Block-diagonal matrix."""
    out = np.zeros((len(A) + len(B), A.shape[1] + B.shape[1]))
    out[: len(A), : A.shape[1]], out[len(A) :, A.shape[1] :] = A, B
    return out


def t2it(_, t, q):
    I, I_f = Frame3(np.concatenate([t, q])).inverse()
    return I.t, I_f[:3, :3], by_q(I_f[:3, 3:], q)


def frame2matrix(_, F):
    return [np.block([[F.R, F.t[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])]


FRAMES = {
    "updateFrame": updateFrame,
    "composeFrames": composeFrames,
    "invertFrame": invertFrame,
    "frameIncrement": frameIncrement,
    "toFrame": lambda _, F, p: points_in(F.to_frame, F, p),
    "fromFrame": lambda _, F, p: points_in(F.from_frame, F, p),
    "fromFrameVec": lambda _, F, v: points_in(F.from_frame, F, v, 0.0),
    "qpose2epose": qpose2epose,
    "epose2qpose": epose2qpose,
    "qpose2vpose": qpose2vpose,
    "vpose2qpose": vpose2qpose,
    "t2it": t2it,
    "frame2matrix": frame2matrix,
    "homogeneous": frame2matrix,
    "splitFrame": lambda _, F: (F.t, F.q, F.R, F.Rt),
    "getTR": lambda _, F: (F.t, F.R, F.Rt),
}
