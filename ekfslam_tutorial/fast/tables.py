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
        if part is not None and not _as_noted(part, lmks):
            groups.forget()
            return sightings(map, rob, sen, lmks, Rf, Sf, in_view)
        parts += [part] if part is not None else []
    return merged(parts) if parts else None


def _part(map, rob, sen, group, Rf, Sf, in_view):
    """The table of the landmarks of one type; None if there are none."""
    traced = map.compiled and rob.first is None
    if in_view and len(group.lmks) > MANY:
        some, part = _seen(map, rob, sen, group, Rf, Sf, traced)
    else:
        some, part = None, _table(map, rob, sen, group.kind, group.lmks, group.indices, Rf, Sf, traced, not in_view)
    if part is not None:
        part.group, part.some = group, some
        part.untidy = hasattr(group.kind, "ahead") or hasattr(group.kind, "linearity")
    return part


def _seen(map, rob, sen, group, Rf, Sf, traced):
    """Those of many landmarks that may be seen, and their table: a quick look at all of them, most are elsewhere."""
    kind, indices, found = group.kind, group.indices, None
    ranges = frame_range(rob, Rf), sen.r
    if traced and indices is not None:
        found = compiled().expected_in_view(map, Rf, Sf, sen.model, kind, indices, *ranges)
    if found is not None:
        some, indices, *found = found
        some = some.tolist()
        lmks = [group.lmks[i] for i in some]
        return some, _as_compiled(sen, lmks, (*ranges, indices), Rf.size, *found) if some else None
    l = map.x[indices] if indices is not None else np.array([lmk.x for lmk in group.lmks], float)
    at = np.flatnonzero(may_be_seen(Rf, Sf, sen.model, kind, l))
    indices, some = None if indices is None else indices.take(at, 0), at.tolist()
    return some, _table(map, rob, sen, kind, [group.lmks[i] for i in some], indices, Rf, Sf, traced, False)


def _table(map, rob, sen, kind, lmks, indices, Rf, Sf, traced, every):
    """The table of some landmarks of one type, by compiled code if they can be traced; None if there are none."""
    if not lmks:
        return None
    l = np.array([lmk.x for lmk in lmks], float) if indices is None else map.state(indices)
    ranges = frame_range(rob, Rf), sen.r, indices
    found = compiled().expected(map, Rf, Sf, sen.model, kind, l, *ranges, every) if traced else None
    if found is not None:
        return _as_compiled(sen, lmks, ranges, Rf.size, *found)
    return _computed(rob, sen, lmks, kind, l, Rf, Sf, ranges)


def _as_compiled(sen, lmks, ranges, n, e, v, visible, J, E):
    """The table of what compiled code has found; E may come later."""
    table = Sightings(sen.id, lmks, e, v, visible, ranges, J=J, n=n)
    if E is not None:
        table.E, table.has_E = E, True
    return table


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _computed(rob, sen, lmks, kind, l, Rf, Sf, ranges):
    """The same, by numpy."""
    e, v, E_r, E_s, E_l, visible = expected(Rf, Sf, sen.model, kind, l)
    if E_l.ndim == 2:
        E_l = np.repeat(E_l[None], len(l), 0)  # the same for all
    if rob.first is not None:
        E_r, E_s, E_l = first_jacobians(rob, sen, Sf, lmks)
    if not isfinite(np.vdot(E_l, E_l)):
        visible = visible & np.isfinite(E_l.sum((-1, -2)))
    return Sightings(sen.id, lmks, e, v, visible, ranges, E_r, E_s, E_l)


def _as_noted(part, lmks):
    """Return True if the visible landmarks are those of the dict, with the types and the ranges that are noted."""
    group, some, seen, find = part.group, part.some, part.lmks, lmks.get
    keys, ranges, kinds = group.keys, group.ranges, group.kinds
    for k in part.in_view:
        i, lmk = k if some is None else some[k], seen[k]
        if find(keys[i]) is not lmk or lmk.r is not ranges[i] or lmk.type is not kinds[i]:
            return False
    return True
