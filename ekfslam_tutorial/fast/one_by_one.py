"""Active search, one correction after the other: each landmark is projected again from the map as corrected so far."""

import numpy as np

from .carrying import all_parts, before, catch_up, follow, visible_parts
from .core import Event, delete_bad
from .extra import compiled
from .filter import correct, covariance, cross, innovation
from .frames import camera_position, frame_of, frame_range, normalize
from .joint import associated, correct_with
from .obs import Obs
from .straight import expected_of_one
from .tables import sightings
from .tidy import most_uncertain, tidy


def correct_one_by_one(map, rob, sen, lmks, obs, raw, opt, Rf, Sf):
    """`correct_known_lmks` without `opt.joint`: parameters and results are the same, and the frames of both."""
    table = sightings(map, rob, sen, lmks, Rf, Sf)
    if table is None:
        return [], opt.association(map, [], raw, sen.model).new
    catch_up(map, rob, table, before(map, rob, opt))
    table.keep_all(map)
    slots = [lmk.slot for lmk in table.lmks[: table.K]]
    order = sorted(range(table.K), key=slots.__getitem__)
    expected, visible, id = [Obs(table, k) for k in order], table.visible.tolist(), sen.id
    obs.update({(id, o.lmk): o for o in expected})
    pairs, new, refused = associated(opt.association, map, expected, raw, sen.model)

    search = _Search(map, rob, sen, lmks, table, raw, opt, Rf, Sf, refused)
    in_view = [k for k in order if visible[k]]
    wanted = most_uncertain(table, in_view, opt.n_updates)
    for k in wanted:
        search.look(k, pairs.get(table.lmks[k].id))
    for k in wanted:  # after all has gone well
        lmk = table.lmks[k]
        lmk.n_search, lmk.n_match = lmk.n_search + 1, lmk.n_match + table.matched[k]
        lmk.n_inlier += table.updated[k]
    return search.events + delete_bad(map, rob, sen, lmks, [o for o in expected if visible[o.k]], opt), new


class _Search:
    """The corrections of one sensor in one frame."""

    def __init__(self, map, rob, sen, lmks, table, raw, opt, Rf, Sf, refused):
        self.map, self.rob, self.sen, self.lmks, self.table, self.raw, self.opt = map, rob, sen, lmks, table, raw, opt
        self.Rf, self.Sf, self.stale, self.events, self.refused = Rf, Sf, False, [], refused

    def look(self, k, index):
        """Look for one landmark: match, project again if its expectation is stale, gate, correct."""
        map, rob, sen, table, opt = self.map, self.rob, self.sen, self.table, self.opt
        lmk, found, PHt = table.lmks[k], index is not None, None
        table.measured[k], table.matched[k], table.index[k] = True, found, index
        self.events.append(Event("search", rob.id, sen.id, lmk.id, found))
        if not found:
            return

        if opt.reproject and self.stale:
            self._project_again(k)
        if not table.has_E or (self.stale and not opt.reproject):  # E is not there, or not that of now
            blocks = Obs(table, k).blocks
            PHt = cross(map, blocks)
            table.E[k] = covariance(PHt, blocks)
        y = np.asarray(self.raw.y[index], float)
        R = sen.model.R if self.raw.R is None else np.asarray(self.raw.R[index], float)
        inn = innovation(sen.model.residual(y, table.e[k]), table.E[k], R)
        table.y[k], table.R[k], table.z[k] = y, R, inn.z
        accepted = inn.md2 < opt.md2_threshold and lmk.id not in self.refused
        self.events.append(Event("innovation", rob.id, sen.id, lmk.id, accepted))
        if not accepted:
            return

        camera, referred = camera_position(self.Rf, self.Sf) if opt.reparametrize else None, before(map, rob, opt)
        if PHt is None:
            correct_with(map, table, [k], inn.z[None], R)
        else:
            correct(map, PHt, inn)
        if referred is not None:
            follow(map, rob, all_parts(map, self.lmks) if map.all_active else visible_parts(table), referred)
        table.updated[k] = self.stale = True
        normalize(map, rob, rob.motion.frame)
        normalize(map, sen, sen.frame_type)
        self.Rf, self.Sf = frame_of(map, rob, rob.motion.frame), frame_of(map, sen, sen.frame_type)
        tidy(map, lmk, camera, opt)
        self.events.append(Event("correction", rob.id, sen.id, lmk.id))

    def _project_again(self, k):
        """The expectation of a landmark from the map as corrected so far."""
        map, table, lmk, Rf, Sf, model = self.map, self.table, self.table.lmks[k], self.Rf, self.Sf, self.sen.model
        if table.J is not None:
            size, l = lmk.type.size, lmk.state(map)[None]
            indices = None if lmk.r is None else table.ranges[2][k : k + 1, :size].copy()
            e, _, _, J, E = compiled().expected(map, Rf, Sf, model, lmk.type, l, *table.ranges[:2], indices, True)
            n = J.shape[-1] - size
            table.e[k], table.J[k, :, :n], table.E_l[k, :, :size] = e[0], J[0, :, :n], J[0, :, n:]
            if lmk.r is not None:
                table.H_l[k, :, :size] = J[0, :, n:]
            if E is not None:
                table.E[k] = E[0]
            return
        e, E_r, E_s, E_l = expected_of_one(Rf, Sf, model, lmk.type, lmk.state(map))
        table.e[k] = e
        if self.rob.first is None:
            Obs(table, k).blocks = (frame_range(self.rob, Rf), E_r), (self.sen.r, E_s), (lmk.r, E_l)
