"""One joint correction by all landmarks that a sensor sees in a frame, instead of one correction after the other.

All are projected once, from the same estimate. So the results differ a little from those of the sequential update,
which linearises anew before each correction. What is gained is speed: P is read and written once, not once for each.
"""

from math import isfinite

import numpy as np

from ..ekf import correct, covariance, cross, innovation
from .objects import Event
from .projection import merged, normalize, project_lmks, stacks_in_view
from .upkeep import delete_bad, most_uncertain, tidy


def correct_jointly(map, rob, sen, lmks, obs, raw, opt):
    """`correct_known_lmks` with `Options(joint=True)`: parameters and results are the same.

    `obs` gets the observations of the visible landmarks only.
    """
    stacks = stacks_in_view(map, rob, sen, lmks.values())
    by_id = getattr(opt.association, "by_id", False)
    all_E = not by_id or opt.n_updates is not None
    seen = [o for stack in stacks for o in stack.obs(sen, stack.covariances(map) if all_E else None)]
    obs.update({(sen.id, o.lmk): o for o in seen})

    expected = seen if by_id else seen + _out_of_view(map, rob, sen, lmks, seen)
    matches = opt.association(map, expected, raw, sen.model)
    wanted = seen if opt.n_updates is None else most_uncertain(seen, opt.n_updates)
    for o in wanted:
        o.measured, o.index = True, matches.pairs.get(o.lmk)
        o.matched = o.index is not None
    if seen:
        _correct(map, rob, sen, lmks, merged(stacks), seen, raw, opt)
    events = [event for o in wanted for event in _recorded(lmks[o.lmk], o, rob, sen)]
    events += delete_bad(map, rob, sen, lmks, seen, opt)
    return events, matches.new


def _out_of_view(map, rob, sen, lmks, seen):
    """The other landmarks: a measurement that is near one which should just be out of view starts no new one."""
    visible = {o.lmk for o in seen}
    return [o for o in project_lmks(map, rob, sen, lmks.values()) if o.lmk not in visible]


def _correct(map, rob, sen, lmks, stack, seen, raw, opt):
    """Gate each landmark that was found on its own; correct with all that pass at once."""
    found = [k for k, o in enumerate(seen) if o.matched]
    if len(found) < len(seen):
        lost = [k for k, o in enumerate(seen) if o.E is None and not o.matched]
        for k, E in zip(lost, stack.take(lost).covariances(map) if lost else (), strict=True):
            seen[k].E = E
        stack, seen = stack.take(found), [seen[k] for k in found]
    if not seen:
        return
    index = [o.index for o in seen]
    y, R = raw.y[index], sen.model.R if raw.R is None else raw.R[index]
    z = sen.model.residual(y, stack.e)
    PHt = cross(map, stack.blocks)
    E = covariance(PHt, stack.blocks)
    E_each = np.einsum("kikj->kij", E.reshape(*z.shape, *z.shape))
    for k, o in enumerate(seen):
        o.y, o.R, o.z, o.E = y[k], R if raw.R is None else R[k], z[k], E_each[k]

    if isfinite(opt.md2_threshold):
        passed = np.flatnonzero(_distances(z, E_each + R) < opt.md2_threshold).tolist()
        if len(passed) < len(seen):
            stack, seen, z = stack.take(passed), [seen[k] for k in passed], z[passed]
            R = R if raw.R is None else R[passed]
            PHt = cross(map, stack.blocks) if seen else PHt
            E = covariance(PHt, stack.blocks) if seen else E
    if seen:
        camera = rob.frame(map).from_frame(sen.frame(map).t)[0] if opt.reparametrize else None
        correct(map, PHt, innovation(z, E, R))
        normalize(map, rob)
        normalize(map, sen)
        for o in seen:
            o.updated = True
            tidy(map, lmks[o.lmk], camera, opt)


def _distances(z, Z):
    """Squared Mahalanobis distances z' Z^-1 z, each innovation on its own."""
    return (z * np.linalg.solve(Z, z[..., None])[..., 0]).sum(-1)


def _recorded(lmk, o, rob, sen):
    """Count what has happened to a landmark that was looked for. Returns the events."""
    lmk.n_search += 1
    lmk.n_match += o.matched
    lmk.n_inlier += o.updated
    events = [Event("search", rob.id, sen.id, lmk.id, o.matched)]
    if o.matched:
        events.append(Event("innovation", rob.id, sen.id, lmk.id, o.updated))
    if o.updated:
        events.append(Event("correction", rob.id, sen.id, lmk.id))
    return events
