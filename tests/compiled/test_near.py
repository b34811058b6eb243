"""Which of many landmarks can be visible, found by compiled code."""

import numpy as np
import pytest

from ekfslam_tutorial.compiled import near
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.observation import may_be_seen
from ekfslam_tutorial.models.sensors import BearingOnly2, PinHole, RangeBearing
from ekfslam_tutorial.slam import Lmk, projection

from .scenes import Pair, raw

FAR = RangeBearing(0.1, 0.02, max_range=6.0, fov=4.0)
PAIRS = [
    (FAR, EucPnt(2)), (FAR, AhmPnt(2)), (FAR, HmgPnt(2)), (RangeBearing(0.1, 0.02, fov=2.0), EucPnt(2)),
    (BearingOnly2(0.02, fov=2.0), AhmPnt(2)), (PinHole(), EucPnt(3)), (PinHole(), IdpPnt()),
]  # fmt: skip


@pytest.mark.parametrize("sensor, kind", PAIRS, ids=lambda model: f"{type(model).__name__}{getattr(model, 'dim', '')}")
def test_the_same_landmarks(sensor, kind, interpreted, rng):
    if kind.dim == 2:
        Rf, Sf = Frame2(rng.normal(size=3)), Frame2(0.3 * rng.normal(size=3))
    else:
        Rf, Sf = (Frame3(rng.normal(size=7)).normalized()[0] for _ in range(2))
    l = np.array([kind.from_point(p)[0] for p in rng.uniform(-10, 10, (200, kind.dim))])
    expected = np.flatnonzero(may_be_seen(Rf.compose(Sf)[0], sensor, kind, l))
    x, rows = np.zeros(l.size + 7), 7 + rng.permutation(l.size).reshape(l.shape)
    x[rows] = l
    found = near(Rf, Sf, sensor, kind, x, rows)
    assert np.array_equal(found, expected) and 0 < len(found) < len(l)
    assert len(near(Rf, Sf, sensor, kind, x, rows[:0])) == 0


def test_known_landmarks_may_be_integers(rng):
    lmks = [Lmk(i, EucPnt(2), x=rng.integers(-9, 9, 2)) for i in range(50)]
    F = Frame2(np.zeros(3))
    a, b = (projection._in_view(map, F, F, FAR, EucPnt(2), lmks, None) for map in (Map(), Map(compiled=True)))
    assert np.array_equal(a, b) and 0 < len(a) < 50


@pytest.mark.parametrize("active", [None, 5, 15])
@pytest.mark.parametrize("sensor, kind", PAIRS[:5:4], ids=["by range", "by bearing"])
def test_a_run_that_looks_for_them_first(sensor, kind, active, interpreted, monkeypatch, rng):
    """The numpy map and the compiled one take the same landmarks, and so go the same way."""
    monkeypatch.setattr(projection, "MANY", 1)
    pair = Pair(sensor, lmk_type=kind, n=[0.2], N=[[0.01]], active=active, joint=True)
    points, out_of_view = rng.uniform([1, -3], [9, 3], (12, 2)), False
    for k in range(12):
        pair.move(np.array([0.1, 0.02, 0.25 if k > 4 else 0.0]))
        ids = [i for i in range(12) if np.linalg.norm(points[i] - pair.truth.t) < 5]
        pair.look(raw(ids, pair.measured(rng, points[ids])))
        out_of_view |= 0 < len(pair.plain.obs) < len(pair.plain.lmks)
    assert out_of_view
