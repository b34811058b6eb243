"""What a sensor can see does not depend on how many whole turns its bearing is written with."""

import numpy as np
import pytest

from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing
from ekfslam_tutorial.slam.upkeep import well_inside

SENSORS = {
    "range and bearing": lambda fov: RangeBearing(0.1, 0.02, max_range=10.0, fov=fov),
    "bearing": lambda fov: BearingOnly2(0.02, max_range=10.0, fov=fov),
}


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
@pytest.mark.parametrize("name", SENSORS)
def test_a_bearing_beyond_pi(name, turns):
    """A limited field of view, 90 degrees: inside, outside, on both sides, and behind."""
    sensor = SENSORS[name](np.pi / 2)
    bearings = np.array([0.0, 0.7, -0.7, 0.9, -0.9, 3.0, -3.0, np.pi])
    p = 2 * np.stack([np.cos(bearings), np.sin(bearings)], -1)
    y = sensor.project(p)[0]
    y[..., -1] = bearings + 2 * np.pi * turns
    wanted = [True, True, True, False, False, False, False, False]
    assert sensor.visible(y, p).tolist() == wanted
    assert [well_inside(sensor, one, 0.0) for one in y] == wanted


@pytest.mark.parametrize("name", SENSORS)
def test_the_edges_belong_to_the_view(name):
    sensor = SENSORS[name](np.pi / 2)
    edge = np.array([np.pi / 4, -np.pi / 4])
    p = 10 * np.stack([np.cos(edge), np.sin(edge)], -1)
    y = sensor.project(p)[0]
    y[..., -1] = edge
    p, y = np.clip(p, -7.07, 7.07), np.where(y > 9, 10.0, y)
    assert sensor.visible(y, p).all()
    y[..., -1] *= 1 + 1e-9
    assert not sensor.visible(y, p).any()
