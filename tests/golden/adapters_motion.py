"""Recorded functions of motion and of the filter's mathematics, in this package's words."""

import numpy as np

from ekfslam_tutorial import geometry as g
from ekfslam_tutorial.ekf import Innovation, Map, correct, covariance, cross, innovation, predict
from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.models.landmarks import IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry3

from .adapters_geometry import by_frame, by_q, qpose2epose
from .records import APPROXIMATE, NOT_HERE, Graph, Masked, Skip

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
    for _ in used:
        map.add(np.zeros(1), np.eye(1))
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
