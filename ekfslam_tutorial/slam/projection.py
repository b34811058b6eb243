"""Where things are according to the map, and what a sensor should see of it."""

from math import isfinite

import numpy as np

from ..ekf import transform
from ..ekf.extra import compiled
from ..models.observation import expect, may_be_seen
from .first_estimates import first_jacobians
from .groups import groups_of
from .sightings import Obs, Sightings, merged

MANY = 100
"""Of more landmarks than this, those in view are found first; Jacobians are for them only."""


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
    """Bring the frame of a robot or sensor in the map to its normal form: unit quaternion, wrapped heading.

    Returns
    -------
    Frame2 or Frame3
        The frame.
    """
    F = obj.frame(map)
    if not F.is_normal and obj.r is not None:
        o = slice(obj.r.start + F.dim, obj.r.start + F.size)  # the orientation; the position stays as it is
        if F.dim == 2:  # whole turns are added to the heading, which changes no covariance
            map.move(o, F.normalized()[0].x[F.dim :])
            F = obj.frame(map)
        elif map.compiled and compiled().normalized(map, obj.r, type(F)):
            F = obj.frame(map)
        else:
            N, N_f = F.normalized()
            transform(map, o, N.x[F.dim :], N_f[F.dim :, F.dim :])
            obj.last = F = N
    obj.normal = F
    return F


def normal_frame(map, obj):
    """The frame in its normal form, as the last `normalize` left it, unless the state has been changed since then."""
    F = obj.frame(map)
    return F if F is obj.normal else normalize(map, obj)


def frame_range(obj, F):
    """Range of the frame in the map; a robot's state may have velocities behind it."""
    return None if obj.r is None else slice(obj.r.start, obj.r.start + F.size)


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
    table = sightings(map, rob, sen, lmks, rob.frame(map), sen.frame(map))
    if table is None:
        return []
    table.keep(map, range(len(lmks)))
    table.visible &= np.isfinite(table.E).all((-1, -2))
    at = {id(lmk): k for k, lmk in enumerate(table.lmks)}
    return [Obs(table, at[id(lmk)]) for lmk in lmks]


def sightings(map, rob, sen, lmks, Rf, Sf, in_view=False):
    """Expected observations of landmarks in one table, the landmarks of a type together; None if there are none.

    Rf and Sf are the frames of the robot and the sensor. With `in_view` landmarks may be left out that are not visible.
    """
    parts = []
    for group in groups_of(sen, lmks):
        kind, rows, r = group.kind, group.rows, group.ranges
        some = lmks if len(group.members) == len(lmks) else [lmks[i] for i in group.members]
        if in_view and len(some) > MANY:
            at = _in_view(map, Rf, Sf, sen.model, kind, some, rows)
            rows, at = None if rows is None else rows.take(at, 0), at.tolist()
            some, r = [some[i] for i in at], [r[i] for i in at]
        if some:
            l = np.array([lmk.x for lmk in some]) if rows is None else map.state(rows)
            ranges = frame_range(rob, Rf), sen.r, rows
            part = _compiled(map, rob, sen, some, kind, l, Rf, Sf, ranges, not in_view) if map.compiled else None
            part = part or _computed(rob, sen, some, kind, l, Rf, Sf, ranges)
            part.r, part.untidy = r, hasattr(kind, "ahead")
            parts.append(part)
    return merged(parts) if parts else None


def _in_view(map, Rf, Sf, sensor, kind, lmks, rows):
    """Indices of the landmarks that `may_be_seen`: a quick look at all of them, most of which are elsewhere."""
    x = map.x if rows is not None else np.concatenate([lmk.x for lmk in lmks], dtype=float)
    rows = np.arange(len(x)).reshape(len(lmks), -1) if rows is None else rows
    at = compiled().near(Rf, Sf, sensor, kind, x, rows) if map.compiled else None
    return np.flatnonzero(may_be_seen(Rf.compose(Sf)[0], sensor, kind, x[rows])) if at is None else at


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _computed(rob, sen, lmks, kind, l, Rf, Sf, ranges):
    """The table of landmarks of one type."""
    e, v, E_r, E_s, E_l = expect(Rf, Sf, sen.model, kind, l)
    if E_l.ndim == 2:
        E_l = np.repeat(E_l[None], len(lmks), 0)  # the same for all
    if rob.first is not None:
        E_r, E_s, E_l = first_jacobians(rob, sen, Sf, lmks)
    visible = sen.model.visible(e, v)
    if not isfinite(np.vdot(E_l, E_l)):
        visible &= np.isfinite(E_l.sum((-1, -2)))
    return Sightings(sen.id, lmks, e, v, visible, ranges, E_r, E_s, E_l)


def _compiled(map, rob, sen, lmks, kind, l, Rf, Sf, ranges, every):
    """The same by compiled code, with E; None if that cannot be."""
    if rob.first is not None:
        return None
    found = compiled().expected(map, Rf, Sf, sen.model, kind, l, *ranges, every)
    if found is None:
        return None
    e, v, visible, J, E = found
    table = Sightings(sen.id, lmks, e, v, visible, ranges, J=J, n=Rf.size)
    if E is not None:
        table.E, table.has_E = E, True
    return table
