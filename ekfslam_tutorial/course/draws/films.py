"""Runs of the notebooks for the replay player: snapshots of loops that are written out, and state logs."""

from __future__ import annotations

import numpy as np

from ...ekf import Map
from ...geometry import Frame2
from ...graphics.player import StateLog
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...simulation.simulator import SimLmk, SimObs
from ...slam import Event, Lmk, Rob, Sen, move, place, project_lmks
from ...toolbox import Snapshot


def snapshot(k, map, rob, sen, lmks, obs, raw, events, truth, points) -> Snapshot:
    """Return frame k of a run with one robot and one sensor, one frame a second.

    Parameters
    ----------
    k : int
    map : Map
    rob, sen : Rob, Sen
    lmks, obs, raw, events
        As the functions of ``slam`` take and return them.
    truth : ndarray, shape (3,)
        True pose.
    points : ndarray, shape (N, 2)
        True landmarks; their ids are 0, 1, ...
    """
    raw, truth, world = {sen.id: raw}, {rob.id: truth}, SimLmk(np.arange(len(points)), points)
    return Snapshot(k, float(k), 1.0, map, [rob], [sen], lmks, obs, raw, {}, events, set(), truth, [], [], world)


def film(title: str, snapshots, period: int = 1) -> StateLog:
    """Return the state log of a run. Estimate and truth are shown in the same frame, as they are."""
    log = StateLog(title, period=period, align=False)
    for now in snapshots:
        log.add(now)
    return log


def film_of(title: str, moments, sensor, points, period: int = 1) -> StateLog:
    """Return the state log of a run of the student's own filter, with known ids.

    Parameters
    ----------
    title : str
    moments : sequence
        The filter after each frame: `x`, `P`, and `ranges` of the landmarks by id; `u`, `U`: the measured step before
        it; `seen`, `ys`: ids and measurements; `truth`: the true pose.
    sensor : RangeBearing
    points : ndarray, shape (N, 2)
        True landmarks; their ids are 0, 1, ...
    period : int
        Keep every so many frames.
    """
    return film(title, _snapshots(moments, sensor, points), period)


def _snapshots(moments, sensor, points):
    """The frames as the toolbox has them. An innovation is that against the state before all corrections."""
    rob, sen, before = Rob(1, Odometry2()), Sen(1, 1, sensor, Frame2, x=np.zeros(3)), None
    for k, now in enumerate(moments):
        obs, known = {}, before.ranges if before is not None else {}
        if before is not None:
            map, lmks = _objects(before, rob)
            rob.u, rob.U = now.u, now.U
            move(map, rob, 1.0)
            for o in project_lmks(map, rob, sen, [lmks[id] for id in now.seen if id in known]):
                o.index = list(now.seen).index(o.lmk)
                o.y, o.R = now.ys[o.index], sensor.R
                o.z, o.measured, o.matched, o.updated = sensor.residual(o.y, o.e), True, True, True
                obs[sen.id, o.lmk] = o
        map, lmks = _objects(now, rob)
        events = [Event("initialisation", rob.id, sen.id, id) for id in now.ranges if id not in known]
        raw = SimObs(sen.id, np.array(now.seen, int), np.reshape(now.ys, (-1, 2)))
        yield snapshot(k, map, rob, sen, lmks, obs, raw, events, now.truth, points)
        before = now


def _objects(moment, rob):
    """Map and landmarks of one moment; the robot is put into the map."""
    map = Map()
    place(map, rob, moment.x[:3], moment.P[:3, :3])
    lmks = {id: Lmk(id, EucPnt(2), r=map.add(moment.x[r], moment.P[r, r])) for id, r in moment.ranges.items()}
    n = len(moment.x)
    map.x[:n], map.P[:n, :n] = moment.x, moment.P
    return map, lmks
