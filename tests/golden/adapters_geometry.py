"""Recorded functions of rotations, frames, motion and mathematics, in this package's words.

Each adapter takes the record and its arguments and gives the outputs in the recorded order.
"""

import numpy as np

from ekfslam_tutorial import geometry as g
from ekfslam_tutorial.ekf import Innovation, Map, correct, covariance, cross, innovation, predict
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3

from .records import APPROXIMATE, DEGENERATE, NOT_HERE, EitherSign, Graph, Masked, Skip, Tangent


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


# --- motion ----------------------------------------------------------------------------------------------------------


def odo3(_, F, u):
    x, X_x, X_u = Odometry3().move(F.x, u, 1.0)
    return Frame3(x), by_frame(X_x, F), X_u


def constVel(record, x, *u_dt):
    """Constant velocity: this package's exact quaternion; the recorded Jacobians belong to a first-order rule.

    Where two versions of the recorded program differ, the one with the exact value is taken.
    """
    u, dt = u_dt if len(u_dt) == 2 else (np.zeros(6), *u_dt)
    x2, X_x, X_u = ConstantVelocity().move(x, u, dt)
    outs = x2, Masked(X_x, [3, 4, 5, 6], APPROXIMATE), X_u
    return Graph(outs) if "outs_graph" in record else outs


def qpredict(record, q, w, dt, method="tustin"):
    """Integration of an angular rate: the first-order rule q + dt/2 Omega(w) q, or the exact product.

    The recorded Jacobians always belong to the first-order rule; where the value is the exact one, they are skipped.
    """
    Omega = g.w2omega(w)
    if "outs_graph" not in record and method in ("tustin", "euler"):
        return q + dt / 2 * Omega @ q, by_q(np.eye(4) + dt / 2 * Omega, q), dt / 2 * g.q2Pi(q)
    outs = g.q_prod(q, g.v2q(w * dt)[0])[0], Skip(APPROXIMATE), Skip(APPROXIMATE)
    return Graph(outs) if "outs_graph" in record else outs


def rpredict(_, r, v, *a_dt):
    """Constant velocity, or constant acceleration; a position alone has no class here."""
    if len(a_dt) == 2:
        return Skip(NOT_HERE)
    (dt,) = a_dt
    x2, X_x, _ = ConstantVelocity().move(np.concatenate([r, [1.0], np.zeros(3), v, np.zeros(3)]), np.zeros(6), dt)
    return x2[:3], X_x[:3, :3], X_x[:3, 7:10]


MOTION = {"odo3": odo3, "constVel": constVel, "qpredict": qpredict, "rpredict": rpredict}


# --- mathematics -----------------------------------------------------------------------------------------------------


def innovation_(_, y, R, e, E):
    inn = innovation(y - e, E, R)
    return inn.z, inn.Z, inn.iL.T @ inn.iL, inn.md2, Skip(NOT_HERE), Skip(NOT_HERE)


def propagate_pose(_, x, P):
    e, E_x = qpose2epose(None, x)
    return e, E_x.J @ P @ E_x.J.T


def propagate_idp(_, l, P):
    p, P_l = IdpPnt().point(l)
    return p, P_l @ P @ P_l.T


def filled(P, used):
    """A map of this covariance in which some states are free."""
    map = Map()
    map.add(np.zeros(len(P)), np.eye(len(P)))
    map.P[:] = P
    for i in np.flatnonzero(used == 0):
        map.remove(slice(i, i + 1))
    return map


def runs(r):
    """Recorded positions, counted from 1, as the contiguous ranges of this package's blocks."""
    r = np.asarray(r, int) - 1
    cuts = np.flatnonzero(np.diff(r) != 1) + 1
    return [(slice(part[0], part[-1] + 1), slice(k, k + len(part))) for k, part in enumerate_parts(np.split(r, cuts))]


def enumerate_parts(parts):
    k = 0
    for part in parts:
        yield k, part
        k += len(part)


def ekfcorr(_, x, P, used, r, H, z, R):
    map = filled(P, used)
    map.x[:] = x
    blocks = [(rng, H[:, cols]) for rng, cols in runs(r)]
    PHt = cross(map, blocks)
    correct(map, PHt, innovation(z, covariance(PHt, blocks), R))
    return map.x, unused_as_before(map.P, P, used)


def ekfpred(_, P, used, r, F_r, U, F_u):
    map = filled(P, used)
    ((rng, _),) = runs(r)
    predict(map, rng, np.zeros(len(r)), F_r, F_u, U)
    return [unused_as_before(map.P, P, used)]


def unused_as_before(new, old, used):
    """Rows and columns of free states hold old numbers in the recorded program and zeros here: put the former back."""
    both = np.outer(used, used) > 0
    return np.where(both, new, old)


MATH = {
    "mahalanobis": lambda _, x, m, P: [np.sqrt(Innovation(x - m, P).md2)],
    "nees": lambda _, x, m, P: [Innovation(x - m, P).md2],
    "innovation": innovation_,
    "golden_prop": propagate_pose,
    "golden_prop_idp": propagate_idp,
    "normAngle": lambda _, a: [g.wrap(a)],
    "crossJ": lambda _, a, b: (g.hat(a) @ b, -g.hat(b), g.hat(a)),
    "golden_ekfcorr": ekfcorr,
    "golden_ekfpred": ekfpred,
}
