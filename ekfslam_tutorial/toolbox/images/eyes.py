"""What the loop does for sensors that take pictures: it lets them look, and remembers what new landmarks look like."""

import numpy as np
import scipy  # which loads scipy.linalg at its first use

from ...ekf import MapFull, covariance, cross
from ...models.landmarks import EucPnt
from ...slam import Event, Lmk
from ...slam.association import fresh_id
from ...slam.projection import frame_range
from ...slam.upkeep import free_slot
from .appearance import look_at
from .picture import Picture


class Eyes:
    """All that a run of pictures has to do around the steps. Measurements that are no pictures pass untouched.

    Parameters
    ----------
    found : bool
        True: the target has been found already.
    """

    def __init__(self, found=False):
        self.found = found

    def look(self, rob, sen, lmks, raw):
        """Begin with a picture: `ActiveSearch` will ask for robot, sensor and landmarks; the target is looked for.

        Parameters
        ----------
        rob, sen, lmks, raw
            As in `correct_known_lmks`.
        """
        if not isinstance(raw, Picture):
            return
        raw.scene = rob, sen, lmks
        if raw.target is not None and not self.found:
            raw.given = raw.target.find(raw.image, sen.model)
            self.found = raw.given is not None

    def remember(self, map, rob, sen, lmks, raw):
        """End with a picture: new landmarks get their appearance, and what was given comes into the map.

        Parameters
        ----------
        map, rob, sen, lmks, raw
            As in `correct_known_lmks`.

        Returns
        -------
        list of Event
            What is done now.
        """
        if not isinstance(raw, Picture):
            return []
        raw.scene = None
        camera = rob.frame(map).compose(sen.frame(map))[0]
        for id, i in raw.born.items():
            if id in lmks and lmks[id].appearance is None:
                raw.ids[i], lmks[id].appearance = id, look_at(raw.image, raw.y[i], camera)
        done = []
        if raw.given is not None:
            done += self._give(map, rob, sen, lmks, raw, camera)
        if raw.forget:
            done += self._forget(map, rob, sen, lmks)
        return done

    def _give(self, map, rob, sen, lmks, raw, camera):
        """Put points that are known in the frame of the camera into the map: an `augment` of all of them at once."""
        Rf, Sf = rob.frame(map), sen.frame(map)
        F, F_r, F_s = Rf.compose(Sf)
        l, L_f, L_p = F.from_frame(raw.given.points)
        n = l.size
        blocks = (frame_range(rob, Rf), (L_f @ F_r).reshape(n, -1)), (sen.r, (L_f @ F_s).reshape(n, -1))
        PLt, L_p = cross(map, blocks), scipy.linalg.block_diag(*np.broadcast_to(L_p, (len(l), 3, 3)))
        P = covariance(PLt, blocks) + L_p @ raw.given.P @ L_p.T
        new, events, start = [], [], 1 if not lmks.keys() & set(range(1, n // 3 + 1)) else fresh_id(lmks)
        for i, (x, pixel) in enumerate(zip(l, raw.given.pixels, strict=True)):
            own, P_xm = slice(3 * i, 3 * i + 3), np.zeros((3, map.n))
            P_xm[:, : len(PLt)] = PLt[:, own].T
            for j, lmk in enumerate(new):
                P_xm[:, lmk.r] = P[own, 3 * j : 3 * j + 3]
            try:
                r = map.add(x, P[own, own], P_xm)
            except MapFull:
                break
            id, look = start + i, look_at(raw.image, pixel, camera, given=True)
            lmks[id] = Lmk(id, EucPnt(3), r=r, slot=free_slot(lmks.values()), appearance=look)
            new.append(lmks[id])
            events.append(Event("initialisation", rob.id, sen.id, id))
        return events

    @staticmethod
    def _forget(map, rob, sen, lmks):
        """Delete the landmarks that were given."""
        given = [lmk for lmk in lmks.values() if lmk.appearance is not None and lmk.appearance["given"]]
        for lmk in given:
            map.remove(lmks.pop(lmk.id).r)
        return [Event("deletion", rob.id, sen.id, lmk.id) for lmk in given]
