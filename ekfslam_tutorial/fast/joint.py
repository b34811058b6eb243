"""One joint correction by all landmarks that a sensor sees in a frame: P is read and written only once."""

from functools import lru_cache
from math import isfinite

import numpy as np

from .carrying import all_parts, before, catch_up, follow, visible_parts
from .core import Event, Jcbb, KnownIds, NearestNeighbour, delete_bad, gate
from .extra import compiled
from .filter import update
from .frames import camera_position, normalize
from .gating import within_gate
from .notes import MANY
from .obs import Obs
from .tables import sightings
from .tidy import most_uncertain, tidy


def correct_jointly(map, rob, sen, lmks, obs, raw, opt, Rf, Sf, threshold):
    """`correct_known_lmks` with `opt.joint`: parameters and results are the same; frames of both, and the gate."""
    by_id = type(opt.association) is KnownIds  # if not, a measurement near one out of view starts no other
    table = sightings(map, rob, sen, lmks, Rf, Sf, in_view=by_id)
    if table is None:
        return [], opt.association(map, [], raw, sen.model).new
    in_view = table.in_view
    near = in_view if by_id else _candidates(map, table, raw, sen, opt)
    catch_up(map, rob, table, before(map, rob, opt))
    soon = by_id and opt.n_updates is None and table.J is not None and not table.has_E  # E comes with the correction
    if not soon:
        table.keep(map, near)
    seen, id = [Obs(table, k) for k in in_view], sen.id
    for o in seen:
        obs[id, o.lmk] = o

    expected = seen if by_id else [Obs(table, k) for k in near]
    pairs, new, refused = associated(opt.association, map, expected, raw, sen.model)
    wanted = in_view if opt.n_updates is None else most_uncertain(table, in_view, opt.n_updates)
    found = sorted(table.match(pairs, wanted))  # in the order of the table, of which they may be all
    if refused:
        out = [k for k in found if table.lmks[k].id in refused]
        found = [k for k in found if table.lmks[k].id not in refused]
    if found:
        camera = camera_position(Rf, Sf) if opt.reparametrize else None
        _correct(map, rob, sen, lmks, table, found, in_view if soon else None, raw, opt, camera, threshold)
    elif soon:
        table.keep(map, near)
    if refused:
        table.refuse(out, raw, sen.model)
    events = _recorded(table, wanted, rob, sen)
    events += delete_bad(map, rob, sen, lmks, seen, opt)
    return events, new


def associated(association, map, obs, raw, sensor):
    """Return what an association says: measurements by landmark, those that may start a landmark, whose are refused.

    Of `KnownIds` the first has ids of other landmarks, too.
    """
    if type(association) is not KnownIds:
        matches = association(map, obs, raw, sensor)
        return matches.pairs, matches.new, matches.refused
    ids = np.asarray(raw.ids).tolist()
    index = {id: i for i, id in enumerate(ids)}
    if len(index) < len(ids):  # the first of those with the same id counts
        index = dict(zip(reversed(ids), range(len(ids) - 1, -1, -1), strict=True))
    order = sorted(index)
    if order == ids and (not ids or ids[0] >= 0):  # most often
        return index, list(range(len(ids))), ()
    if order and order[0] < 0:
        order = [id for id in order if id >= 0]
        index = {id: index[id] for id in order}
    return index, [index[id] for id in order], ()


def _candidates(map, table, raw, sen, opt):
    """The landmarks that an association has to look at: those that can be within its gate, if it says what that is."""
    chosen = opt.association
    if opt.n_updates is not None or type(chosen) not in (NearestNeighbour, Jcbb):
        return range(table.K)
    widest = gate(max(chosen.confidence, chosen.new_confidence), len(sen.model.R))
    return within_gate(map, table, raw, sen.model, widest).tolist()


def _correct(map, rob, sen, lmks, table, found, no_E, raw, opt, camera, threshold):
    """Gate each that was found on its own; correct with all that pass at once. E of `no_E` is not there yet."""
    referred = before(map, rob, opt)
    found = _corrected(map, sen, table, found, no_E, raw, threshold)
    if found:
        if referred is not None:
            follow(map, rob, all_parts(map, lmks) if map.all_active else visible_parts(table), referred)
        normalize(map, rob, rob.motion.frame)
        if sen.r is not None:
            normalize(map, sen, sen.frame_type)
        updated = table.updated
        for k in found:
            updated[k] = True
        if table.untidy:
            for lmk in [table.lmks[k] for k in found]:
                tidy(map, lmk, camera, opt)


def _corrected(map, sen, table, found, no_E, raw, threshold):
    """Those by which the map has been corrected."""
    y, index = np.array(raw.y, float, order="C"), [table.index[k] for k in found]
    R = sen.model.R if raw.R is None else np.asarray(raw.R).take(index, 0)
    if table.J is not None:
        e = table.e
        E = table.E if no_E is None else np.empty((table.K, e.shape[1], e.shape[1]))
        done = compiled().correct_found(
            map, sen.model, table.ranges, table.n, table.J, e, E, no_E, found, index, y, R, threshold
        )
        if done is not None:
            (z, passed), table.E, table.has_E = done, E, True
            table.measure(found, index, y, z, R)
            return passed
    if no_E is not None:
        table.keep(map, no_E)
    z = sen.model.residual(y.take(index, 0), table.e.take(found, 0))
    table.measure(found, index, y, z, R)
    if isfinite(threshold):
        passed = np.flatnonzero(_distances(z, table.E[found] + R) < threshold).tolist()
        if len(passed) < len(found):
            found, z, R = [found[i] for i in passed], z[passed], R if raw.R is None else R[passed]
    if found:
        correct_with(map, table, found, z, R)
    return found


def correct_with(map, table, found, z, R):
    """Correct the map with the innovations z of some landmarks of a table, all at once."""
    if table.J is not None:
        spots = map.spots(*table.ranges, found)
        if compiled().correct_some(map, spots, table.n, table.n, table.J, found, z, R):
            return
    update(map, table.blocks(None if len(found) == table.K else found), z, R)


def _distances(z, Z):
    """Squared Mahalanobis distances z' Z^-1 z, each innovation on its own."""
    return (z * np.linalg.solve(Z, z[..., None])[..., 0]).sum(-1)


def _recorded(table, wanted, rob, sen):
    """Count what has happened to the landmarks that were looked for. Returns the events."""
    events, happened = [], _of_used(rob.id, sen.id)
    lmks, matched, updated = table.lmks, table.matched, table.updated
    for k in wanted:
        lmk, found, used = lmks[k], matched[k], updated[k]
        lmk.n_search += 1
        lmk.n_match += found
        lmk.n_inlier += used
        events += happened[lmk.id] if used else _events(rob.id, sen.id, lmk.id, found, False)
    return events


class _OfUsed(dict):
    """What has happened to a landmark, by its id, if its measurement was used: the same, most often, as last time."""

    def __init__(self, rob, sen):
        super().__init__()
        self.by = rob, sen

    def __missing__(self, lmk):
        if len(self) >= 10_000:
            self.clear()
        self[lmk] = events = _events(*self.by, lmk, True, True)
        return events


_of_used = lru_cache(MANY)(_OfUsed)


def _events(rob, sen, lmk, matched, updated):
    """Return what has happened to one landmark."""
    events = [Event("search", rob, sen, lmk, matched)]
    if matched:
        events.append(Event("innovation", rob, sen, lmk, updated))
    if updated:
        events.append(Event("correction", rob, sen, lmk, True))
    return tuple(events)
