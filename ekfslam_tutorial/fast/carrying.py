"""The invariant error, quicker: after a correction the covariance is carried along to the new estimate.

`slam.correct_invariant` corrects and carries in one go. Here a correction is compiled, or takes a stack, so the two are
parted: `before` says to which estimate the covariance refers, `follow` lets it refer to the present one,

    P = T P T',    T = I + D E,    D = B(x) - B(x before).

D has rows for robots and landmarks only, and most often only those columns in which the world is turned: to shift the
world is the same direction at every estimate, but for homogeneous points.

A compressed map carries what is active, and is *lazy*: each far state remembers the estimate that its covariance refers
to, and is carried before it is used, `catch_up`. D does not depend on the way that led from one estimate to the other,
so what is known of moving the world stays what it was. But the robot by whose pose it is read has moved on in the
meantime, with some noise: an effect of the second order, and the one in which this map differs from the others.
"""

import numpy as np

from ..models.turning import turning
from .core import EUCLIDEAN, ORIGIN, by_type

PLANE, SPACE = EUCLIDEAN[2], EUCLIDEAN[3]


def before(map, rob, opt):
    """Return the estimate that the covariance of the map refers to, shape (n,); None if it is not to be carried."""
    if opt.error == "additive" or rob.r is None:
        return None
    return map.referred()


def follow(map, rob, parts, before):
    """Let the covariance of all robots, and of some landmarks, refer to the present estimate.

    Parameters
    ----------
    map : FastMap or CompressedMap
    rob : Rob
        By whose pose it is read how the world is moved.
    parts : iterable of (LmkType, ndarray of int, shape (K, k))
        Landmarks of one type each, and where they are in the map.
    before : ndarray, shape (n,)
        See `before`. A compressed map notes in it what has followed.
    """
    kind, at, D, shifts = rob.motion.frame, [], [], []
    for each in {id(rob): rob, **{id(rob): rob for rob in map.robs}}.values():
        if each.r is not None:
            at.append(np.arange(each.r.start, each.r.stop))
            D.append(_turned(each.motion, map.state(each.r)) - _turned(each.motion, before[each.r]))
    n = sum(len(i) for i in at)
    for lmk_type, indices in parts:
        D_l, S_l = _difference(lmk_type, map.state(indices), before[indices])
        at.append(indices.ravel())
        D.append(D_l)
        if S_l is not None:
            shifts.append((n, S_l))
        n += indices.size
    at, D, pose = np.concatenate(at), np.concatenate(D), slice(rob.r.start, rob.r.start + kind.size)
    E = _left_inverse(before[pose][kind.dim :])
    if not shifts:
        map.carry(at, D, slice(pose.start + kind.dim, pose.stop), E)
        return
    S = np.zeros((len(D), kind.dim))
    for start, S_l in shifts:
        S[start : start + len(S_l)] = S_l
    E_turn = np.concatenate([np.zeros((len(E), kind.dim)), E], 1)
    E_shift = np.eye(kind.dim, kind.size) - _turned(rob.motion, before[rob.r])[: kind.dim] @ E_turn
    map.carry(at, np.concatenate([S, D], 1), pose, np.concatenate([E_shift, E_turn]))


def all_parts(map, lmks):
    """Return the landmarks of a dict that are in the map, as `follow` takes them."""
    return [(group.kind, group.indices) for group in map.notes.groups(lmks).all if not group.known]


def visible_parts(table):
    """The same for the visible landmarks of a table of sightings, as they are now: some may have become Euclidean."""
    seen = by_type([table.lmks[k] for k in table.visible.nonzero()[0].tolist()])
    return [(g[0].type, np.array([range(o.r.start, o.r.stop) for o in g])) for g in seen if g[0].r is not None]


def catch_up(map, rob, table, before):
    """Let the visible landmarks of a table follow before they are used, where the map is lazy."""
    if before is not None and not map.all_active:
        follow(map, rob, visible_parts(table), before)


def _difference(kind, l, l0):
    """B(l) - B(l0) of landmarks of a type, shape (K k, ·): columns of the turns, and of the shifts, or None."""
    if kind == PLANE:
        return ((l0 - l)[:, ::-1] * [1.0, -1.0]).reshape(-1, 1), None
    if kind == SPACE:
        return _minus_hat(l - l0).reshape(-1, 3), None
    O = ORIGIN[kind.dim]
    D = (kind.to_frame(O, l0)[1] - kind.to_frame(O, l)[1]) @ O.X_step
    D = D.reshape(-1, O.dof)
    shift = D[:, : O.dim]
    return D[:, O.dim :], shift if shift.any() else None


def _minus_hat(v):
    """-[v]x of a stack of vectors."""
    H = np.zeros((*v.shape, 3))
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    H[..., 0, 1], H[..., 0, 2], H[..., 1, 2] = z, -y, x
    H[..., 1, 0], H[..., 2, 0], H[..., 2, 1] = -z, y, -x
    return H


def _turned(motion, x):
    """B of the state of a robot, as in `slam.gauge`, those columns in which the world is turned."""
    if motion.frame.dim == 3:
        w, i, j, k = (0.5 * x[3:7]).tolist()
        B = np.concatenate([_minus_hat(x[:3]), [[-i, -j, -k], [w, k, -j], [-k, w, i], [j, -i, w]]])
    else:
        B = np.array([[-x[1]], [x[0]], [1.0]])
    if len(x) > len(B):
        B = np.concatenate([B, turning(motion, x)])
    return B


def _left_inverse(o):
    """E with E B_o = I, for the orientation o of a robot: a heading, or a quaternion."""
    if len(o) == 1:
        return np.eye(1)
    w, i, j, k = (2.0 / (o @ o) * o).tolist()
    return np.array([[-i, w, -k, j], [-j, k, w, -i], [-k, -j, i, w]])
