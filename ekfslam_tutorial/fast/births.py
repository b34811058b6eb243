"""New landmarks: `init_new_lmks`, quicker."""

import numpy as np

from . import core
from .core import (
    EUCLIDEAN,
    Event,
    KnownIds,
    Lmk,
    MapFull,
    check_first_estimates,
    free_slot,
    transport,
    well_inside,
)
from .extra import compiled
from .filter import augment
from .frames import frame_of, frame_range, state_of
from .refused import check_map
from .straight import inside, retro_projected

NOTHING = np.zeros(0), np.zeros((0, 0))
"""The prior of what is measured completely."""


def init_new_lmks(map, rob, sen, lmks, raw, new, opt, n_max=None):
    """Start landmarks from measurements that belong to none: see `slam.init_new_lmks`."""
    check_map(map)
    if core.as_written(sen.model):
        return core.init_new_lmks(map, rob, sen, lmks, raw, new, opt, n_max)
    events, ids = [], None
    if type(opt.association) is KnownIds and new:  # most often all of them are there
        ids = np.asarray(raw.ids).tolist()
        new = [i for i in new if ids[i] not in lmks]
    for i in new:
        if n_max is not None and len(events) >= n_max:
            break
        if ids is None:
            id = opt.association.birth_id(raw, i, lmks)
        else:
            id = None if ids[i] in lmks else int(ids[i])  # as `KnownIds` says it
        if id is None:
            continue
        try:
            lmk = _started(map, rob, sen, lmks, id, raw.y[i], sen.model.R if raw.R is None else raw.R[i], opt)
        except MapFull:
            events.append(Event("refused", rob.id, sen.id, id))
            continue
        if lmk is not None:
            lmks[id] = lmk
            events.append(Event("initialisation", rob.id, sen.id, id))
    return events


def _started(map, rob, sen, lmks, id, y, R, opt):
    """One new landmark in the map, from one measurement, None if that is not well inside: see `slam.add_landmark`."""
    y, R = np.asarray(y, float), np.asarray(R, float)
    kind = sen.lmk_type or opt.lmk_type or EUCLIDEAN[sen.frame_type.dim]
    n, N = (opt.n, opt.N) if sen.model.bearing_only else NOTHING
    full = opt.max_lmks is not None and len(lmks) >= opt.max_lmks
    looked = full or opt.init_margin > 0
    if looked and not _well_inside(sen.model, y, opt.init_margin):
        return None
    if full:
        raise MapFull(f"the map is full: it has {len(lmks)} landmarks, the most that max_lmks allows")

    if map.compiled and rob.first is None and not opt.first_estimates:
        x_r, x_s = None if rob.r is not None else state_of(map, rob), None if sen.r is not None else state_of(map, sen)
        r = compiled().born(map, rob, sen, (x_r, x_s), kind, y, n, R, N)  # which looks whether y is inside
        if r is not None:
            return _in_a_slot(map, lmks, Lmk(id, kind, r=r, n=n, N=N)) if r else None
    if not looked and not _well_inside(sen.model, y, 0.0):
        return None
    Rf, Sf = frame_of(map, rob, rob.motion.frame), frame_of(map, sen, sen.frame_type)
    l, L_r, L_s, L_y, L_n = retro_projected(Rf, Sf, sen.model, kind, y, n)
    if opt.first_estimates:
        check_first_estimates(rob.motion.frame, [kind])
        L_r = L_r if rob.first is None else L_r @ transport(rob.first, Rf.x)
    blocks = (frame_range(rob, Rf), L_r), (sen.r, L_s)
    r = augment(map, l, blocks, L_y @ R @ L_y.T + L_n @ N @ L_n.T)
    return _in_a_slot(map, lmks, Lmk(id, kind, r=r, n=n, N=N, first=l if opt.first_estimates else None))


def _in_a_slot(map, lmks, lmk):
    """Give a new landmark the first slot that is free."""
    n, last, started = len(lmks), next(reversed(lmks.values()), None), map.notes.started(lmks)
    if last is not None and started == [last, n] and last.slot == n - 1:  # none has come or gone since
        lmk.slot = n
    else:
        lmk.slot = free_slot(lmks.values())
    started[:] = [lmk, n + 1] if lmk.slot == n else [None, 0]
    return lmk


def _well_inside(sensor, y, margin):
    """Return True if a measurement would still be visible if each of its numbers were off by the margin."""
    return well_inside(sensor, y, margin) if margin or y.shape != (len(sensor.R),) else inside(sensor, y)
