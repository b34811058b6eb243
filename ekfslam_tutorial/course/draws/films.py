"""Runs of the notebooks for the replay player: snapshots of loops that are written out, and state logs."""

from __future__ import annotations

import numpy as np

from ...graphics.player import StateLog
from ...simulation.simulator import SimLmk
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
