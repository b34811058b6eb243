"""Robots that see each other: the position of a robot is a landmark that moves."""

import numpy as np

from ..ekf import covariance, cross, innovation
from ..models.landmarks import EucPnt
from .first_estimates import note_first_estimates
from .objects import Event, Lmk
from .projection import correct_invariant, frame_range, normalize, project_lmks
from .steps import check_raw


def project_robots(map, rob, sen, others):
    """Expected observations of other robots by one sensor.

    The position of a robot is the head of its state, so the chain of a landmark at that place serves: the Jacobian by
    the other robot's frame o is [E_l, 0], because its orientation does not show.

        e = h(r, s, t_o),    E = H P H' with the blocks (r, E_r), (s, E_s), (t_o, E_l)

    Parameters
    ----------
    map : Map
    rob, sen : Rob, Sen
        Who looks.
    others : iterable of Rob
        Who is looked at.

    Returns
    -------
    list of Obs
        In the order of `others`; `lmk` is the id of the robot.
    """
    return project_lmks(map, rob, sen, [_as_landmark(map, other) for other in others])


def _as_landmark(map, rob):
    """The position of a robot as a landmark: the same range in the map, or the same known numbers."""
    F = rob.frame(map)
    r = frame_range(rob, F)
    if r is None:
        return Lmk(rob.id, EucPnt(F.dim), x=F.t)
    first = (F.x if rob.first is None else rob.first)[: F.dim]
    return Lmk(rob.id, EucPnt(F.dim), r=slice(r.start, r.start + F.dim), first=first)


def correct_met_robots(map, rob, sen, robs, raw, opt, lmks=None):
    """Correct the map with sightings of other robots: both robots, and all that is correlated with them.

    All robots must have moved to the time of the sighting. One after the other: each is projected from the map as
    corrected so far, gated and corrected.

    Parameters
    ----------
    map : Map
    rob, sen : Rob, Sen
        Who looks.
    robs : list of Rob
        All robots.
    raw : raw measurements
        `ids` (k,), ids of robots; `y` (k, m); `R` (k, m, m) or None. Ids of robots that are not there are passed over.
    opt : Options
        The gate `md2_threshold`, and the error.
    lmks : dict of int to Lmk, optional
        The landmarks in the map, which have no part in the measurement: with the invariant error the covariance of all
        that such a correction moves has to be with it.

    Returns
    -------
    list of Event
        One of kind meeting for each sighting; its lmk is the id of the robot that was seen, its flag says whether it
        passed the gate.
    """
    check_raw(raw, sen)
    known = {other.id: other for other in robs if other.id != rob.id}
    events = []
    for each in robs if opt.first_estimates else ():
        note_first_estimates(map, each, {})
    for i, id in enumerate(np.asarray(raw.ids).tolist()):
        if id not in known:
            continue
        (o,) = project_robots(map, rob, sen, [known[id]])
        R = sen.model.R if raw.R is None else raw.R[i]
        PHt = cross(map, o.blocks)
        inn = innovation(sen.model.residual(np.asarray(raw.y[i], float), o.e), covariance(PHt, o.blocks), R)
        accepted = inn.md2 < opt.md2_threshold
        events.append(Event("meeting", rob.id, sen.id, id, accepted))
        if accepted:
            correct_invariant(map, rob, lmks or {}, PHt, inn, opt)
            normalize(map, rob, known[id], sen)
    return events
