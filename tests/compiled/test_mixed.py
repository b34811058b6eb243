"""Landmarks of several types in one frame, some of them known: one table, compiled."""

import numpy as np
import pytest

from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt
from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing
from ekfslam_tutorial.slam import Lmk

from .scenes import POINTS, Pair, raw

SENSORS = RangeBearing(0.1, 0.02), BearingOnly2(0.02)
OTHERS = {10: (AhmPnt(2), [5.0, 1.5]), 11: (HmgPnt(2), [4.0, -1.0]), 12: (AhmPnt(2), [6.0, 0.0])}
KNOWN = {20: [3.0, 1.0], 21: [5.0, -0.5]}


def add_others(pair, calibrate):
    """The same of every type into both maps; two known ones, and, if wanted, the sensor's frame."""
    for scene in (pair.plain, pair.compiled):
        if calibrate:
            scene.sen.r, scene.sen.x = scene.map.add(scene.sen.x, 1e-4 * np.eye(3)), None
        for slot, (id, (kind, p)) in enumerate(OTHERS.items(), 100):
            l = kind.from_point(np.array(p))[0]
            scene.lmks[id] = Lmk(id, kind, r=scene.map.add(l, 1e-4 * np.eye(len(l))), slot=slot)
        for slot, (id, p) in enumerate(KNOWN.items(), 200):
            scene.lmks[id] = Lmk(id, EucPnt(2), x=np.array(p), slot=slot)


@pytest.mark.parametrize("calibrate", [False, True], ids=["sensor known", "sensor in the map"])
@pytest.mark.parametrize("gate", [np.inf, 3.0], ids=["no gate", "gate"])
@pytest.mark.parametrize("active", [None, 6, 40])
@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize("sensor", SENSORS, ids=lambda sensor: type(sensor).__name__)
def test_they_are_as_in_a_plain_map(sensor, joint, active, gate, calibrate, interpreted, rng):
    kind = EucPnt(2) if sensor is SENSORS[0] else AhmPnt(2)
    pair = Pair(sensor, joint=joint, active=active, md2_threshold=gate, lmk_type=kind, n=[0.2], N=[[0.01]])
    pair.go(rng)
    add_others(pair, calibrate)
    points = np.concatenate([POINTS, [p for _, p in OTHERS.values()], list(KNOWN.values())])
    ids, used = [*range(len(POINTS)), *OTHERS, *KNOWN], set()
    for _ in range(4):
        pair.move(np.array([0.1, 0.02, 0.05]))
        pair.look(raw(ids, pair.measured(rng, points)))
        tables = {id(o.table): o.table for o in pair.compiled.obs.values()}
        assert len(tables) == 1 and all(table.J is not None for table in tables.values())
        used |= {o.lmk for o in pair.compiled.obs.values() if o.updated}
    assert used == set(ids)


def test_only_known_ones_of_two_types(interpreted, rng):
    pair = Pair(SENSORS[0], joint=True)
    for scene in (pair.plain, pair.compiled):
        for id, (kind, p) in OTHERS.items():
            scene.lmks[id] = Lmk(id, kind, x=kind.from_point(np.array(p))[0], slot=id)
    for _ in range(2):
        pair.move(np.array([0.1, 0.02, 0.05]))
        pair.look(raw(list(OTHERS), pair.measured(rng, np.array([p for _, p in OTHERS.values()]))))
    assert all(o.updated and o.table.J is not None for o in pair.compiled.obs.values())
