"""Landmarks out of reach are never needed: the short list has all that pass the gate; estimates stay the same."""

import numpy as np
import pytest

from ekfslam_tutorial.fast import CompressedMap, FastMap, correct, covariance, cross, innovation
from ekfslam_tutorial.fast.gating import within_gate
from ekfslam_tutorial.fast.tables import sightings
from ekfslam_tutorial.graphics import SenFig
from ekfslam_tutorial.models.sensors import PinHoleDepth, RangeBearing
from ekfslam_tutorial.slam import Jcbb, NearestNeighbour, project_lmks
from ekfslam_tutorial.slam.association import distances
from ekfslam_tutorial.toolbox import UserData, universal_slam
from tests.slam.scenes import Scene


def correlated(scene, n, rng, spread):
    """Landmarks around the robot, whose errors hang together with the robot's and with each other's."""
    d = scene.rob.motion.frame.dim
    points = rng.uniform(-8, 8, (n, d)) + (np.array([0, 0, 10.0]) if d == 3 else 0)
    for i, p in enumerate(points):
        scene.add(i + 1, p, spread * np.eye(d))
    A = rng.normal(size=(scene.map.n, 4)) * np.sqrt(spread)
    scene.map.P[:] += A @ A.T
    if d == 3:
        scene.map.P[3:7] *= 0.05
        scene.map.P[:, 3:7] *= 0.05
    return dict(enumerate(points, start=1))


def quick(scene):
    """The same map as a quick one, and the table of all landmarks."""
    map, Rf, Sf = FastMap(), scene.rob.frame(scene.map), scene.sen.frame(scene.map)
    map.add(scene.map.x, scene.map.P)
    return map, sightings(map, scene.rob, scene.sen, scene.lmks, Rf, Sf)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("own_R", [False, True])
@pytest.mark.parametrize("gate", [5.0, 25.0])
@pytest.mark.parametrize("spread", [1e-4, 1e-2, 0.3])
def test_whatever_passes_the_gate_is_within_gate(d, own_R, gate, spread, rng):
    """20 random maps. Where the map is good, the list must be short, or it would be of no use."""
    kept = every = 0
    for _ in range(20):
        sensor = RangeBearing(0.1, 0.02) if d == 2 else PinHoleDepth(image_size=(1e4, 1e4), depth_std=0.1)
        scene = Scene(d, P=spread * np.eye(3 if d == 2 else 7), sensor=sensor)
        measured = scene.see(correlated(scene, 30, rng, spread), 2.0, rng)
        measured.ids, measured.y = measured.ids[:6], measured.y[:6]
        if own_R:
            measured.R = np.array([k * sensor.R for k in range(1, 7)])
        obs = project_lmks(scene.map, scene.rob, scene.sen, scene.lmks.values())
        D = distances(obs, measured, sensor)
        near = within_gate(*quick(scene), measured, sensor, gate)
        passing = set(np.flatnonzero((D <= gate).any(0)).tolist())
        assert passing <= set(near.tolist())
        kept, every = kept + len(near), every + D.shape[1]
    assert spread > 1e-4 or kept < 0.4 * every


def test_variances_of_a_compressed_map_are_never_too_small(rng):
    maps = FastMap(), CompressedMap(active=8)
    for map in maps:
        ranges = [map.add(np.zeros(2), np.eye(2)) for _ in range(12)]
    larger = 0
    for _ in range(40):
        i, j = rng.choice(12, 2, replace=False)
        J, z = rng.normal(size=(2, 1, 2)), rng.normal(size=1)
        for map in maps:
            blocks = (ranges[i], J[0]), (ranges[j], J[1])
            PHt = cross(map, blocks)
            correct(map, PHt, innovation(z, covariance(PHt, blocks), 0.5 * np.eye(1)))
        rows = np.array([[r.start, r.start + 1] for r in ranges])
        plain, compressed = (map.variances(rows) for map in maps)
        np.testing.assert_allclose(plain, np.diag(maps[0].P)[rows], rtol=1e-12)
        assert (compressed >= plain * (1 - 1e-9)).all()
        larger += (compressed > plain * 1.01).sum()
    assert larger, "some are far, so that this has been tested"


class All:
    """An association without `reach`: it is shown all landmarks."""

    def __init__(self, association):
        self.association = association
        self.birth_id = association.birth_id

    def __call__(self, map, obs, raw, sensor):
        return self.association(map, obs, raw, sensor)


@pytest.mark.parametrize("association", [NearestNeighbour(), Jcbb()])
def test_a_run_is_the_same_with_and_without_the_short_list(association):
    x = []
    for each in (association, All(association)):
        data = UserData.from_dict(
            {
                "seed": 5,
                "world": {"type": "random2", "n": 60, "x_min": -8, "x_max": 8, "y_min": -8, "y_max": 8},
                "time": {"last": 40},
                "robot": [{"motion": "odometry2", "dx": [0.4, 0.0], "da_deg": 7, "dx_std": 0.02, "da_std_deg": 1.0}],
                "sensor": [{"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 0.5, "max_range": 6.0}],
                "options": {"joint": True},
            }
        )
        object.__setattr__(data.options, "association", each)
        *_, now = universal_slam(data)
        x.append(np.array(now.map.x))
    np.testing.assert_array_equal(*x)


def test_what_is_out_of_reach_has_no_covariance_and_can_be_drawn():
    """Expectations far from every measurement are drawn as points without ellipses."""
    data = UserData.from_dict(
        {
            "world": {"type": "ring", "n": 12, "radius": 4.0},
            "time": {"last": 12},
            "robot": [{"motion": "odometry2", "da_deg": 5, "da_std_deg": 0.2}],
            "sensor": [{"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 0.5, "p_detect": 0.5}],
            "options": {"joint": True, "association": "nearest_neighbour"},
        }
    )
    *_, now = universal_slam(data)
    far = [o for o in now.obs.values() if np.isnan(o.E).all()]
    assert far and all(not o.matched for o in far) and all(np.isfinite(o.e).all() for o in far)
    SenFig(now, 1)
