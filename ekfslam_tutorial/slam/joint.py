"""One joint correction by all landmarks that a sensor sees in a frame, instead of one correction after the other.

All are projected once, from the same estimate. So the results differ a little from those of the sequential update,
which linearises anew before each correction. What is gained is speed: P is read and written once, not once for each.
"""

from itertools import repeat
from math import isfinite

import numpy as np

from ..ekf import correct, covariance, cross, innovation
from .objects import Event
from .projection import normalize, project_lmks, sightings
from .upkeep import delete_bad, most_uncertain, tidy


def correct_jointly(map, rob, sen, lmks, obs, raw, opt):
    """`correct_known_lmks` with `Options(joint=True)`: parameters and results are the same.

    `obs` gets the observations of the visible landmarks only.
    """
    table = sightings(map, rob, sen, list(lmks.values()), in_view=True)
    seen = table.rows() if table else []
    by_id = getattr(opt.association, "by_id", False)
    if table and (not by_id or opt.n_updates is not None):
        table.keep(map)
    obs.update(zip([(sen.id, lmk.id) for lmk in table.lmks] if table else (), seen, strict=True))

    expected = seen if by_id else seen + _out_of_view(map, rob, sen, lmks, seen)
    matches = opt.association(map, expected, raw, sen.model)
    wanted = seen if opt.n_updates is None else most_uncertain(seen, opt.n_updates)
    events = []
    if table:
        table.match(matches.pairs, None if wanted is seen else {o.lmk for o in wanted})
        _correct(map, rob, sen, table, raw, opt)
        events += _recorded(table, [o.k for o in wanted], rob, sen)
    events += delete_bad(map, rob, sen, lmks, seen, opt)
    return events, matches.new


def _out_of_view(map, rob, sen, lmks, seen):
    """The other landmarks: a measurement that is near one which should just be out of view starts no new one."""
    visible = {o.lmk for o in seen}
    return [o for o in project_lmks(map, rob, sen, lmks.values()) if o.lmk not in visible]


def _correct(map, rob, sen, table, raw, opt):
    """Gate each landmark that was found on its own; correct with all that pass at once."""
    found = [k for k, i in enumerate(table.index) if i is not None]
    every = len(found) == len(table.index)
    if not every:
        table.keep(map)
    if not found:
        return
    blocks, e = (table.blocks(), table.e) if every else (table.blocks(found), table.e.take(found, 0))
    index = [table.index[k] for k in found]
    y, R = raw.y.take(index, 0), sen.model.R if raw.R is None else raw.R.take(index, 0)
    z = sen.model.residual(y, e)
    PHt = cross(map, blocks)
    E = covariance(PHt, blocks)
    E_each = E.reshape(*z.shape, *z.shape).diagonal(0, 0, 2).transpose(2, 0, 1)
    if every:
        table.E, table.y, table.z = E_each, y, z
    else:
        for k, y_k, z_k in zip(found, y, z, strict=True):
            table.y[k], table.z[k] = y_k, z_k
    for k, R_k in zip(found, repeat(R, len(found)) if raw.R is None else R, strict=True):
        table.R[k] = R_k

    if isfinite(opt.md2_threshold):
        passed = np.flatnonzero(_distances(z, E_each + R) < opt.md2_threshold).tolist()
        if len(passed) < len(found):
            found, z, R = [found[i] for i in passed], z[passed], R if raw.R is None else R[passed]
            blocks = table.blocks(found)
            PHt = cross(map, blocks) if found else PHt
            E = covariance(PHt, blocks) if found else E
    if found:
        camera = rob.frame(map).from_frame(sen.frame(map).t)[0] if opt.reparametrize else None
        correct(map, PHt, innovation(z, E, R))
        normalize(map, rob)
        normalize(map, sen)
        for k in found:
            table.updated[k] = True
            tidy(map, table.lmks[k], camera, opt)


def _distances(z, Z):
    """Squared Mahalanobis distances z' Z^-1 z, each innovation on its own."""
    return (z * np.linalg.solve(Z, z[..., None])[..., 0]).sum(-1)


def _recorded(table, wanted, rob, sen):
    """Count what has happened to the landmarks that were looked for. Returns the events."""
    events = []
    for k in wanted:
        lmk, matched, updated = table.lmks[k], table.matched[k], table.updated[k]
        lmk.n_search += 1
        lmk.n_match += matched
        lmk.n_inlier += updated
        events.append(Event("search", rob.id, sen.id, lmk.id, matched))
        if matched:
            events.append(Event("innovation", rob.id, sen.id, lmk.id, updated))
        if updated:
            events.append(Event("correction", rob.id, sen.id, lmk.id))
    return events
