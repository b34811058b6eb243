"""Compiled steps on a compressed map: what is at hand is corrected by compiled code, and put back as ever.

Tolerance: as in `tests/ekf/test_compressed.py`, rounding only; the circuits are long, and close a loop.
"""

import copy
import pickle

import numpy as np
import pytest

from benchmarks.ours import Step
from benchmarks.world import circuit
from ekfslam_tutorial.cli.files import find_scenario
from ekfslam_tutorial.ekf import CompressedMap, Map
from ekfslam_tutorial.toolbox import UserData, universal_slam

from .side_by_side import near

TOL = 1e-10


@pytest.mark.parametrize("joint", [True, False], ids=["joint", "sequential"])
@pytest.mark.parametrize("active", [6, 40, 500])
def test_a_circuit_is_that_of_a_plain_map(active, joint):
    """Six states are fewer than a step needs; of 500 nothing is ever put back."""
    world, maps = circuit(60), (Map(), CompressedMap(active=active, compiled=True))
    runs = [Step(world, map, joint) for map in maps]
    for k in range(len(world.steps)):
        for run in runs:
            run.step(k)
    (x, P), (x_c, P_c) = (run.state() for run in runs)
    assert np.abs(x - x_c).max() < TOL * np.abs(x).max()
    assert np.abs(P - P_c).max() < TOL * np.abs(P).max()


@pytest.mark.parametrize("joint", [True, False], ids=["joint", "sequential"])
@pytest.mark.parametrize("name", ["cloister_idp", "two_robots_four_cameras", "constant_velocity", "localisation_2d"])
def test_scenarios(name, joint, interpreted):
    """Two cameras of the second are calibrated, so that the sensor is in the map, too."""
    ends = []
    for compiled in (False, True):
        changes = {"options.joint": joint, "options.compressed": True, "options.compiled": compiled, "time.last": 25}
        *_, now = universal_slam(UserData.from_toml(find_scenario(name), changes))
        ends.append(now)
    a, b = ends
    assert a.events == b.events and [lmk.r for lmk in a.lmks.values()] == [lmk.r for lmk in b.lmks.values()]
    assert b.map.compiled and near(b.map.x, a.map.x) and near(b.map.P, a.map.P)


def test_a_copy_goes_on_compiled():
    world = circuit(20)
    run = Step(world, CompressedMap(active=20, compiled=True), joint=True)
    for k in range(10):
        run.step(k)
    run.map.P  # noqa: B018 -- a copy has all put back: from here on both are the same
    for again in copy.deepcopy(run), pickle.loads(pickle.dumps(run.map)):
        map = again if isinstance(again, CompressedMap) else again.map
        assert map.compiled and np.array_equal(map.x, run.map.x) and np.array_equal(map.P, run.map.P)


def test_numba_is_asked_for_at_once(monkeypatch):
    monkeypatch.setattr("ekfslam_tutorial.ekf.extra.find_spec", lambda name: None)
    with pytest.raises(ImportError, match="a compiled map needs numba"):
        CompressedMap(compiled=True)
