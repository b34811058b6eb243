"""What has to be done around corrections: who comes first, who becomes Euclidean, who is deleted."""

import numpy as np

from ..ekf import transform
from ..geometry import ORIGIN
from ..models.landmarks import EucPnt
from ..models.landmarks.lines import abscissas
from .objects import Event
from .projection import by_type, frame_range

EUCLIDEAN = {2: EucPnt(2), 3: EucPnt(3)}
"""Euclidean points by the dimension of their world: the types of reparametrised landmarks."""
ALIKE = 6
"""Decimals of log det(E) that count: what differs by less is equal, and rounding, which is not the same on every
computer, does not decide who is corrected first."""


def most_uncertain(obs, n_max):
    """Observations by decreasing uncertainty of the expectation, det(E), at most n_max of them.

    Landmarks that a robot sees again from where they were born are all as uncertain as R: their order is that of `obs`.
    """
    return sorted(obs, key=lambda o: -np.round(np.linalg.slogdet(o.E)[1], ALIKE))[:n_max]


def tidy(map, lmk, camera, opt):
    """Tidy up after a correction: inverse distances stay positive; a landmark that has become linear becomes Euclidean.

    Parameters
    ----------
    map : Map
    lmk : Lmk
    camera : ndarray, shape (d,)
        Where the sensor was when it saw the landmark, in the world.
    opt : Options
        `min_rho`, `reparametrize` and `lin_test`.
    """
    if lmk.r is not None and hasattr(lmk.type, "ahead"):
        map.x[lmk.r] = lmk.type.ahead(lmk.state(map), opt.min_rho)
    if opt.reparametrize and lmk.r is not None and hasattr(lmk.type, "linearity"):
        l = lmk.state(map)
        if lmk.type.linearity(l, map.block(lmk.r), camera) < opt.lin_test:
            p, P_l = lmk.type.point(l)
            lmk.type, lmk.r = EUCLIDEAN[len(p)], transform(map, lmk.r, p, P_l)


VAGUE = 0.05
"""The ends of a line are vague while their standard deviation is more than this fraction of its length."""


def tidy_line(map, rob, sen, lmk, y, opt):
    """Bring a line to its normal form, if it has one, and note where its ends are: those of the segment y, or more.

    Each end is the point of the line that is nearest to the ray of its pixel. While the line is vague, what is seen now
    replaces what was remembered: else a first bad guess of its distance would extend it for ever. Of a line that is
    seen in parts, the stretch between the outermost ends is kept.

    Parameters
    ----------
    map, rob, sen, opt
        As in `correct_known_lmks`.
    lmk : Lmk
        Its ends are None at birth.
    y : ndarray, shape (4,)
        Measured segment.
    """
    if hasattr(lmk.type, "normalized") and lmk.r is not None:
        transform(map, lmk.r, *lmk.type.normalized(lmk.state(map)))
    if opt.ends == "keep" and lmk.par is not None:
        return
    F = rob.frame(map).compose(sen.frame(map))[0]
    rays = F.from_frame(sen.model.retro(y)[0].reshape(2, 3), 0.0)[0]
    t = abscissas(lmk.type, lmk.state(map), F.t, rays)
    if lmk.par is not None:
        p, P = lmk.ends(map)
        if np.sqrt(np.trace(P, axis1=1, axis2=2).max()) < VAGUE * np.linalg.norm(p[1] - p[0]):
            t = np.array([min(*lmk.par, *t), max(*lmk.par, *t)])
    lmk.par = t


def delete_bad(map, rob, sen, lmks, seen, opt):
    """Delete landmarks that are rarely found, or rarely fit when found. Returns the events.

    Parameters
    ----------
    map, rob, sen, lmks, opt
        As in `correct_known_lmks`.
    seen : list of Obs
        Those that should have been found in this frame.
    """
    if not opt.min_match_ratio and not opt.min_inlier_ratio:
        return []
    bad = []
    for lmk in (lmks[o.lmk] for o in seen):
        unstable = lmk.n_match < opt.min_match_ratio * lmk.n_search
        inconsistent = lmk.n_inlier < opt.min_inlier_ratio * lmk.n_match
        if lmk.n_search >= opt.min_search and (unstable or inconsistent):
            bad.append(lmk.id)
    for id in bad:
        lmk = lmks.pop(id)
        if lmk.r is not None:
            map.remove(lmk.r)
    return [Event("deletion", rob.id, sen.id, id) for id in bad]


def let_go(map, rob, sen, lmks, events, opt):
    """Let landmarks that have been lost leave the map: tracks come and go, and a map has a budget. Returns the events.

    Parameters
    ----------
    map, rob, sen, lmks
        As in `correct_known_lmks`.
    events : list of Event
        What was done with what this sensor saw: who was found, or born.
    opt : Options
        `lost_after` looks in a row in which it was not found, None for never; `keep_lost` of the lost ones stay.
    """
    if opt.lost_after is None and not opt.wander:
        return []
    found = {e.lmk for e in events if e.kind == "initialisation" or (e.kind == "search" and e.flag)}
    for id, lmk in lmks.items():
        lmk.n_missed = 0 if id in found else lmk.n_missed + 1
    if opt.lost_after is None:
        return []
    lost = [lmk for lmk in lmks.values() if lmk.r is not None and lmk.n_missed >= opt.lost_after]
    going = sorted(lost, key=lambda lmk: -lmk.n_inlier)[opt.keep_lost :]
    for lmk in going:
        map.remove(lmks.pop(lmk.id).r)
    return [Event("deletion", rob.id, sen.id, lmk.id) for lmk in going]


def wander(map, lmks, dt, opt):
    """Process noise of landmarks: each that was found last time creeps a little, a random walk of its point in space.

        P_ll = P_ll + L_t w^2 dt L_t'

    Parameters
    ----------
    map : Map
    lmks : dict of int to Lmk
    dt : float
        s.
    opt : Options
        `wander` w, m/sqrt(s).
    """
    moving = [lmk for lmk in lmks.values() if lmk.r is not None and lmk.n_missed == 0]
    for group in by_type(moving) if opt.wander else ():
        at = np.array([range(lmk.r.start, lmk.r.stop) for lmk in group])
        O = ORIGIN[group[0].type.dim]
        L_t = group[0].type.from_frame(O, map.x[at])[1][..., : O.dim]  # to move the frame is to move the landmark
        map.P[at[:, :, None], at[:, None, :]] += opt.wander**2 * dt * L_t @ np.swapaxes(L_t, -1, -2)


def tilt(map, sens, dt):
    """Process noise of mountings that give way: random walks of the angles, and of the parameters, of each sensor.

        P_ss = P_ss + S_v s^2 dt S_v',    P_aa = P_aa + diag(w^2) dt

    Parameters
    ----------
    map : Map
    sens : list of Sen
        `tilt` s, rad/sqrt(s); `walk` w.
    dt : float
        s.
    """
    for sen in sens:
        if np.any(sen.walk):
            a = np.arange(sen.r.start + sen.frame_type.plain.size, sen.r.stop)
            map.P[a, a] += np.square(sen.walk) * dt
        if sen.tilt and sen.r is not None:
            O = ORIGIN[sen.frame_type.dim]
            S_v = (type(O)(sen.state(map)[: O.size]).compose(O)[2] @ O.X_step)[:, O.dim :]
            map.P[(frame_range(sen, O),) * 2] += sen.tilt**2 * dt * S_v @ S_v.T


def free_slot(lmks):
    """Return the first index that no landmark has."""
    slots = {lmk.slot for lmk in lmks}
    return next(i for i in range(len(slots) + 1) if i not in slots)


def well_inside(sensor, y, margin):
    """Return True if a measurement would still be visible if each of its numbers were off by the margin.

    The margin is in the unit of the first number, pixels for a camera; a depth in metres is left alone.
    """
    units = getattr(sensor, "units", None) or ("",) * len(y)
    off = margin * np.diag([float(unit == units[0]) for unit in units])
    y = np.concatenate([y[None], y + off, y - off])
    return bool(np.all(sensor.visible(y, sensor.retro(y)[0])))
