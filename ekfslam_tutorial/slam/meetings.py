"""Measurements of robots: of others, whose position is a landmark that moves, and of the one that measures."""

import numpy as np

from ..ekf import covariance, cross, innovation
from ..models.landmarks import EucPnt
from ..models.observation import ItsRobot
from .first_estimates import note_first_estimates
from .objects import Event, Lmk
from .projection import correct_invariant, normalize, project_lmks
from .steps import check_raw, match


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
    if rob.r is None:
        return Lmk(rob.id, EucPnt(F.dim), x=F.t)
    first = (F.x if rob.first is None else rob.first)[: F.dim]
    return Lmk(rob.id, EucPnt(F.dim), r=slice(rob.r.start, rob.r.start + F.dim), first=first)


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
        The landmarks in the map. They have no part in the measurement, but the correction moves them; so with the
        invariant error their covariance is carried along, too.

    Returns
    -------
    list of Event
        One of kind meeting for each sighting; its lmk is the id of the robot that was seen, its flag says whether it
        passed the gate.
    """
    check_raw(raw, sen)
    known, events = {other.id: other for other in robs if other.id != rob.id}, []
    for each in robs if opt.first_estimates else ():
        note_first_estimates(map, each, {})
    for i, id in enumerate(np.asarray(raw.ids).tolist()):
        if id in known:
            (o,) = project_robots(map, rob, sen, [known[id]])
            _correct_by(map, rob, sen, o, i, raw, opt, lmks or {}, known[id])
            events.append(Event("meeting", rob.id, sen.id, id, o.updated))
    return events


def correct_without_lmks(map, rob, sen, obs, raw, opt, lmks):
    """Correct the map with measurements of the robot itself, by sensors that see no landmark: GPS, a compass, a wheel.

    As a landmark is observed, but there is none: e = h(F) or h(F, V), with the frame F of the sensor in the world and
    its velocity V. One after the other, each projected from the map as corrected so far, gated and corrected.

    Parameters
    ----------
    map : Map
    rob, sen : Rob, Sen
    obs : dict of (int, int) to Obs
        Gets the last observation, by (sensor id, -1).
    raw : raw measurements
        `ids` are not looked at.
    opt : Options
        The gate `md2_threshold`, and the error.
    lmks : dict of int to Lmk
        The landmarks in the map: what is correlated with the robot moves with it.

    Returns
    -------
    list of Event
        One of kind innovation for each measurement; its lmk is -1, its flag says whether it passed the gate.
    """
    check_raw(raw, sen)
    normalize(map, rob, sen)
    events = []
    for i in range(len(raw.y)):
        (o,) = project_lmks(map, rob, sen, [Lmk(-1, ItsRobot(), x=())])
        _correct_by(map, rob, sen, o, i, raw, opt, lmks, rob)
        obs[sen.id, -1] = o
        events.append(Event("innovation", rob.id, sen.id, -1, o.updated))
    return events


def _correct_by(map, rob, sen, o, i, raw, opt, lmks, seen):
    """Gate measurement i of what was observed, a robot, and correct the map by it."""
    match(o, i, raw, sen)
    PHt = cross(map, o.blocks)
    o.z, o.E = sen.model.residual(o.y, o.e), covariance(PHt, o.blocks)
    inn = innovation(o.z, o.E, o.R)
    o.updated = inn.md2 < opt.md2_threshold
    if o.updated:
        correct_invariant(map, rob, lmks, PHt, inn, opt)
        normalize(map, rob, seen, sen)
