"""Where things are according to the map, and what a sensor should see of it."""

import numpy as np

from ..ekf import covariance, cross, real, transform
from ..models.observation import expect
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


def frame_range(obj, F):
    """Range of the frame F of a robot or sensor in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


def normalize(map, obj):
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading.

    Its covariance goes through the Jacobian of that: with a quaternion, nothing of it is left along q. A correction
    moves all that is correlated with what was seen, other robots and sensors, too; so each step begins with this.
    """
    if obj.r is not None:
        F = obj.frame(map)
        N, N_f = F.normalized()
        transform(map, frame_range(obj, F), N.x, N_f)


def project_lmks(map, rob, sen, lmks):
    """Expected observations of landmarks by one sensor.

    A landmark at the lens, or in the plane of a camera, has no finite expectation; it is not visible.

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
        found |= {id(lmk): o for lmk, o in zip(group, _project(map, rob, sen, group), strict=True)}
    return [found[id(lmk)] for lmk in lmks]


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


def _project(map, rob, sen, lmks):
    """Expected observations of landmarks of one type."""
    Rf, Sf, obs = rob.frame(map), sen.frame(map), []
    r = frame_range(rob, Rf)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        e, v, *E_ = expect(Rf, Sf, sen.model, lmks[0].type, states(map, lmks))
        if rob.first is not None:
            E_ = first_jacobians(rob, sen, Sf, lmks)
        visible = np.broadcast_to(sen.model.visible(e, v), (len(lmks),))  # True alone: of all
        for k, (lmk, E_r, E_s, E_l) in enumerate(zip(lmks, *E_, strict=True)):
            blocks = (r, E_r), (sen.r, E_s), (lmk.r, E_l)
            E = covariance(cross(map, blocks), blocks)
            obs.append(Obs(sen.id, lmk.id, e[k], E, v[k], blocks, bool(visible[k] and np.isfinite(E).all())))
    return obs
