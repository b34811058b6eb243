"""A beacon with a bias and a scale: where a range sensor sees it, by the numbers of the range alone."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, check_jacobians
from ekfslam_tutorial.models import observe, retro_project
from ekfslam_tutorial.models.landmarks import Beacon
from ekfslam_tutorial.models.sensors import Range, RangeBearing, RangeBearingElevation
from ekfslam_tutorial.models.trials import check_stack, random_frame

dims = pytest.mark.parametrize("dim", [2, 3])


@dims
def test_where_it_seems_to_be(dim, rng):
    """In its own direction, at (1 + s) |p| + b; and back, for another guess of b and s each time."""
    lmk = Beacon(dim)
    for _ in range(4):
        p, n = 3 * rng.normal(size=dim), np.array([0.4, 0.2]) * rng.normal(size=2)
        l = np.concatenate([p, n])
        v = lmk.apparent(l)[0]
        r = np.linalg.norm(p)
        assert np.allclose(v, p / r * ((1 + n[1]) * r + n[0])) and np.array_equal(lmk.point(l)[0], p)
        assert np.allclose(lmk.from_apparent(v, n)[0], l)
        check_jacobians(lmk.apparent, l)
        check_jacobians(lmk.from_apparent, v, n)
    check_stack(lmk.apparent, "apparent", rng.normal(size=(5, lmk.size)))
    check_stack(lmk.from_apparent, "from_apparent", rng.normal(size=(5, dim)), 0.1 * rng.normal(size=(5, 2)))


@dims
def test_what_a_range_sensor_measures_of_it(dim, rng):
    F, lmk = (Frame2, Frame3)[dim - 2], Beacon(dim)
    Rf, Sf, l = random_frame(F, rng), random_frame(F, rng), np.concatenate([3 * rng.normal(size=dim), [0.3, -0.05]])
    e, *_ = observe(Rf, Sf, Range(0.1, bias=0.2, dim=dim), lmk, l)
    r = np.linalg.norm(l[:dim] - Rf.compose(Sf)[0].t)
    assert np.allclose(e, 0.95 * r + 0.3 + 0.2)
    check_jacobians(lambda R, S, l: observe(R, S, Range(0.1, dim=dim), lmk, l), Rf, Sf, l)
    sensor = RangeBearing(0.1, 0.1) if dim == 2 else RangeBearingElevation()
    y = np.array([4.0, 0.3, -0.2])[:dim]
    l, *_, L_n = retro_project(Rf, Sf, sensor, lmk, y, np.zeros(0))
    assert np.array_equal(l[dim:], [0, 0]) and L_n.shape == (dim + 2, 0)
    assert np.allclose(sensor.residual(observe(Rf, Sf, sensor, lmk, l)[0], y), 0)
