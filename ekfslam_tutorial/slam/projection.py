"""Where things are according to the map, and what a sensor should see of it."""

import numpy as np

from ..ekf import carry, correct, covariance, cross, real, transform
from ..geometry import ORIGIN
from ..models.landmarks.lines import ends
from ..models.observation import expect
from ..models.turning import turning
from .first_estimates import first_jacobians
from .objects import Obs, states


def place(map, obj, x, P=None):
    """Put a robot or a sensor where it starts: into the map with covariance P, or known if there is none.

    Parameters
    ----------
    map : Map
    obj : Rob or Sen
    x : ndarray, shape (k,)
    P : ndarray, shape (k, k), optional

    Raises
    ------
    ValueError
        If the state is not finite or has the wrong length, or P is not a covariance.
    """
    size = obj.motion.size if hasattr(obj, "motion") else obj.frame_type.size
    x = real(f"{type(obj).__name__} {obj.id}: the state", x)
    if x.shape != (size,) or not np.isfinite(x).all():
        raise ValueError(f"{type(obj).__name__} {obj.id}: the state must be {size} finite numbers, got {x}")
    if P is None:
        obj.x, obj.r = x.copy(), None
    else:
        obj.x, obj.r = None, map.add(x, P)
        map.robs.extend([obj] if hasattr(obj, "motion") else [])


def frame_range(obj, F):
    """Range of the frame F of a robot or sensor in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


def normalize(map, *objs):
    """Bring the frames of robots and sensors in the map to their normal form: unit quaternion, wrapped heading.

    Its covariance goes through the Jacobian of that: with a quaternion, nothing of it is left along q. A correction
    moves all that is correlated with what was seen, other robots and sensors, too; so each step begins with this.
    """
    for obj in objs:
        if obj.r is not None:
            N, N_f = obj.frame(map).normalized()
            transform(map, frame_range(obj, N), N.x, N_f)


def correct_invariant(map, rob, lmks, PHt, inn, opt):
    """Correct the map; with the invariant error, carry the covariance along.

        x, P = correct(...),    P = T P T'

    Where the whole scene lies in the world, and how it is turned, no measurement can tell. An extended Kalman filter
    learns it all the same: to move the world is one direction of the state before a correction and another one after
    it, and what was measured across the one is taken for knowledge of the other. `carry` sets that right; this is the
    right-invariant filter. A. Barrau, S. Bonnabel, "An EKF-SLAM algorithm with consistency properties",
    arXiv:1510.06263; in space T. Zhang et al., IEEE RA-L 2(2), 2017.

    Parameters
    ----------
    map : Map
    rob : Rob
        Who has measured. If its pose is known, so is where the world lies: nothing has to be carried.
    lmks : dict of int to Lmk
        All that are in the map.
    PHt, inn
        As in `ekf.correct`.
    opt : Options
        `error`.
    """
    if opt.error == "additive" or rob.r is None:
        return correct(map, PHt, inn)
    B = gauge(map, rob, lmks)
    correct(map, PHt, inn)
    carry(map, slice(rob.r.start, rob.r.start + rob.motion.frame.size), B, gauge(map, rob, lmks))


def gauge(map, rob, lmks):
    """Derivative of the state by a small motion g of the whole world, a shift and a turn about its axes: B = dx/dg.

    Points are shifted, and go round the origin; so do poses, whose orientation turns as well. How velocities turn is
    said by the motion model. The frame of a sensor on its robot stays what it is. For a landmark its `to_frame` says
    it: to move the landmark is to move the frame back.

    Parameters
    ----------
    map : Map
    rob : Rob
        A robot in the map; all those that `place` has put there count, too.
    lmks : dict of int to Lmk

    Returns
    -------
    ndarray, shape (n, 3), or (n, 6) in space
        Per metre and per radian.
    """
    O = ORIGIN[rob.motion.frame.dim]
    B = np.zeros((len(map.x), O.dof))
    for group in by_type(lmks.values()):
        if group[0].r is not None:
            at = np.array([range(lmk.r.start, lmk.r.stop) for lmk in group])
            B[at] = -group[0].type.to_frame(O, map.x[at])[1] @ O.X_step
    for each in (rob, *map.robs):
        if each.r is not None:
            x, at = map.x[each.r], slice(each.r.start, each.r.start + O.size)
            B[at] = O.compose(type(O)(x[: O.size]))[1] @ O.X_step
            if len(x) > O.size:
                B[at.stop : each.r.stop, O.dim :] = turning(each.motion, x)
    return B


def project_lmks(map, rob, sen, lmks):
    """Expected observations of landmarks by one sensor.

    A landmark at the lens, or in the plane of a camera, has no finite expectation; it is not visible. Points are not
    asked for by a sensor for lines, nor lines by one for points: they are left out.

    Parameters
    ----------
    map : Map
    rob : Rob
    sen : Sen
    lmks : iterable of Lmk

    Returns
    -------
    list of Obs
        In the order of `lmks`: expectation e, its covariance E = H P H', Jacobian blocks, visibility.
    """
    lmks, found = list(lmks), {}
    for group in by_type(lmks):
        if hasattr(group[0].type, "normal") == hasattr(sen.model, "innovation"):
            found |= {id(lmk): o for lmk, o in zip(group, _project(map, rob, sen, group), strict=True)}
    return [found[id(lmk)] for lmk in lmks if id(lmk) in found]


def by_type(lmks):
    """Return the landmarks in groups that can be computed together: of one type, in the map or known."""
    groups = []
    for lmk in lmks:
        like = [group for group in groups if group[0].type == lmk.type and (group[0].r is None) == (lmk.r is None)]
        if like:
            like[0].append(lmk)
        else:
            groups.append([lmk])
    return groups


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _project(map, rob, sen, lmks):
    """Expected observations of landmarks of one type."""
    Rf, Sf, obs = getattr(rob, getattr(sen.model, "asks_robot", "frame"))(map), sen.frame(map), []
    e, v, *E_ = expect(Rf, Sf, sen.model, lmks[0].type, states(map, lmks))
    if rob.first is not None:
        E_ = first_jacobians(rob, sen, Sf, lmks)
    v = v if lmks[0].par is None else _ends_seen(map, Rf.compose(Sf)[0], lmks)
    r, visible = frame_range(rob, Rf), np.broadcast_to(sen.model.visible(e, v), (len(lmks),))  # one True stands for all
    for k, (lmk, E_r, E_s, E_l) in enumerate(zip(lmks, *E_, strict=True)):
        blocks = (r, E_r), (sen.r, E_s), (lmk.r, E_l)
        E = covariance(cross(map, blocks), blocks)
        obs.append(Obs(sen.id, lmk.id, e[k], E, v[k], blocks, bool(visible[k] and np.isfinite(E).all())))
    return obs


def _ends_seen(map, F, lmks):
    """Ends of lines in the frame F of a sensor, (K, 6): what can be seen of a line is the stretch between them."""
    p, _ = ends(lmks[0].type, states(map, lmks), np.array([lmk.par for lmk in lmks]))
    return F.to_frame(p)[0].reshape(len(lmks), -1)
