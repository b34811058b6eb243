"""Where things are according to the map, and what a sensor should see of it."""

from typing import Any

import numpy as np

from ..ekf import transform
from ..models.observation import to_sensor
from .objects import Obs


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
    if np.shape(x) != (size,) or not np.isfinite(x).all():
        raise ValueError(f"{type(obj).__name__} {obj.id}: the state must be {size} finite numbers, got {x}")
    if P is None:
        obj.x, obj.r = np.array(x, float), None
    else:
        obj.x, obj.r = None, map.add(x, P)


def normalize(map, obj):
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading."""
    if obj.r is None:
        return
    F = obj.frame(map)
    N, N_f = F.normalized()
    if N is not F:
        transform(map, frame_range(obj, N), N.x, N_f)


def frame_range(obj, F):
    """Range of the frame in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def project_lmks(map, rob, sen, lmks):
    """Expected observations of landmarks by one sensor: all landmarks of a type in one call.

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
    lmks = list(lmks)
    Rf, Sf = rob.frame(map), sen.frame(map)
    rr, rs = frame_range(rob, Rf), sen.r
    obs: list[Any] = [None] * len(lmks)
    for (kind, _), members in _by_type(lmks):
        group = [lmks[i] for i in members]
        l = np.array([lmk.state(map) for lmk in group])
        v, *V = to_sensor(Rf, Sf, sen.model, kind, l)
        e, E_v = sen.model.project(v)
        E_r, E_s, E_l = (E_v @ J for J in V)
        E = _covariances(map, rr, rs, group, E_r, E_s, E_l)
        visible = sen.model.visible(e, v) & np.isfinite(E).all((-1, -2))
        for k, i in enumerate(members):
            blocks = ((rr, E_r[k]), (rs, E_s[k]), (group[k].r, E_l[k]))
            obs[i] = Obs(sen.id, group[k].id, e[k], E[k], blocks, v[k], bool(visible[k]))
    return obs


def _by_type(lmks):
    """Indices of the landmarks of each type, those in the map and the known ones apart."""
    groups = {}
    for i, lmk in enumerate(lmks):
        groups.setdefault((lmk.type, lmk.r is None), []).append(i)
    return groups.items()


def _covariances(map, rr, rs, lmks, E_r, E_s, E_l):
    """Covariances H P H' of many expectations at once, shape (len(lmks), m, m)."""
    n, m = E_l.shape[:2]
    H, rows = [np.zeros((n, m, 0))], [np.zeros((n, 0), int)]
    for r, J in (rr, E_r), (rs, E_s):
        if r is not None:
            H.append(J)
            rows.append(np.broadcast_to(np.arange(r.start, r.stop), (n, J.shape[-1])))
    if lmks[0].r is not None:
        H.append(E_l)
        rows.append(np.array([lmk.r.start for lmk in lmks])[:, None] + np.arange(E_l.shape[-1]))
    H, rows = np.concatenate(H, -1), np.concatenate(rows, -1)
    return H @ map.P[rows[:, :, None], rows[:, None, :]] @ np.swapaxes(H, -1, -2)
