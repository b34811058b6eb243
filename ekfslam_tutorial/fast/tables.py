"""What a sensor should see of the landmarks in a map: from the map to a table of sightings."""

from math import isfinite

import numpy as np

from ..models.observation import fits
from .core import first_jacobians
from .expectation import may_be_seen
from .extra import compiled
from .frames import frame_range
from .sightings import Sightings, merged
from .straight import expected

MANY = 100
"""Of more landmarks than this, those in view are found first; Jacobians are for them only."""


def sightings(map, rob, sen, lmks, Rf, Sf, in_view=False):
    """Expected observations of a dict of landmarks in one table, in their order; None if there are none.

    Rf and Sf are the frames of the robot and the sensor. With `in_view` landmarks may be left out that are not visible.
    """
    groups, parts = map.notes.groups(lmks), []
    for group in groups.all:
        if not fits(sen.model, group.kind):
            continue
        part = _part(map, rob, sen, group, Rf, Sf, in_view)
        if part is not None and not _as_noted(part):
            groups.forget()
            return sightings(map, rob, sen, lmks, Rf, Sf, in_view)
        parts += [part] if part is not None else []
    return merged(parts) if parts else None


def _part(map, rob, sen, group, Rf, Sf, in_view):
    """The table of the landmarks of one type; None if there are none."""
    kind, indices, lmks = group.kind, group.indices, group.lmks
    r, places, kinds = group.ranges, group.places, group.kinds
    if in_view and len(lmks) > MANY:
        at = _in_view(map, Rf, Sf, sen.model, kind, lmks, indices)
        indices, at = None if indices is None else indices.take(at, 0), at.tolist()
        lmks, r, places, kinds = ([each[i] for i in at] for each in (lmks, r, places, kinds))
    if not lmks:
        return None
    l = np.array([lmk.x for lmk in lmks], float) if indices is None else map.state(indices)
    ranges = frame_range(rob, Rf), sen.r, indices
    part = _compiled(map, rob, sen, lmks, kind, l, Rf, Sf, ranges, not in_view) if map.compiled else None
    part = part or _computed(rob, sen, lmks, kind, l, Rf, Sf, ranges)
    part.r, part.places, part.kinds = r, places, kinds
    part.untidy = hasattr(kind, "ahead") or hasattr(kind, "linearity")
    return part


def _as_noted(part):
    """Return True if the visible landmarks have the types and the ranges that are noted of them."""
    lmks, r, kinds = part.lmks, part.r, part.kinds
    for k in part.visible.nonzero()[0].tolist():
        lmk = lmks[k]
        if lmk.r is not r[k] or lmk.type is not kinds[k]:
            return False
    return True


def _in_view(map, Rf, Sf, sensor, kind, lmks, indices):
    """Indices of the landmarks that `may_be_seen`: a quick look at all of them, most of which are elsewhere."""
    if map.compiled and indices is not None:
        at = compiled().in_view(map, Rf, Sf, sensor, kind, indices)
        if at is not None:
            return at
    l = map.x[indices] if indices is not None else np.array([lmk.x for lmk in lmks], float)
    return np.flatnonzero(may_be_seen(Rf, Sf, sensor, kind, l))


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _computed(rob, sen, lmks, kind, l, Rf, Sf, ranges):
    """The table of landmarks of one type."""
    e, v, E_r, E_s, E_l, visible = expected(Rf, Sf, sen.model, kind, l)
    if E_l.ndim == 2:
        E_l = np.repeat(E_l[None], len(l), 0)  # the same for all
    if rob.first is not None:
        E_r, E_s, E_l = first_jacobians(rob, sen, Sf, lmks)
    if not isfinite(np.vdot(E_l, E_l)):
        visible = visible & np.isfinite(E_l.sum((-1, -2)))
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
