"""Which stretch of an edge a camera sees: against every point of it, asked one by one."""

import numpy as np
import pytest

from ekfslam_tutorial.models.sensors import PinHole, SegmentCam

K, SIZE = (100.0, 70.0, 120.0, 110.0), (240.0, 160.0)
CAMERAS = {
    "no lens": {},
    "a margin": {"margin": 15.0},
    "a border outside": {"margin": -20.0},
    "a lens": {"d": (-0.2, 0.03)},
    "a lens with a margin": {"d": (-0.2, 0.03), "margin": 15.0},
    "a lens with a fold in the image": {"d": (-0.45,)},
    "a lens that widens": {"d": (0.3,)},
}
N = 4001


def edges(rng):
    """Ends [p1; p2]: through the view, out of it, behind, and along the axes, where a wall is never met."""
    p = rng.normal(size=(40, 6)) * np.tile([4.0, 3.0, 2.0], 2) + np.tile([0.0, 0.0, 3.0], 2)
    flat, upright, across = rng.normal(size=(3, 8, 6)) * np.tile([4.0, 3.0, 1.0], 2) + np.tile([0.0, 0.0, 3.0], 2)
    flat[:, 5], upright[:, 3], across[:, 4:] = flat[:, 2], upright[:, 0], across[:, 1:3]
    return np.concatenate([p, flat, upright, across])


@pytest.mark.parametrize("name", CAMERAS)
def test_the_stretch_that_is_seen(name, rng):
    """By 4,001 points of each edge, to two of their steps. An edge that a lens shows in two pieces is left out."""
    more = CAMERAS[name]
    camera = SegmentCam(K, image_size=SIZE, min_length=1e-9, **more)
    points = PinHole(K, image_size=SIZE, **more)
    p, s = edges(rng), np.linspace(0, 1, N)
    q = p[:, None, :3] + s[:, None] * (p[:, 3:] - p[:, :3])[:, None]
    with np.errstate(all="ignore"):
        seen = points.visible(points.project(q)[0], q)
    one = np.abs(np.diff(seen.astype(int), axis=1)).sum(1) + seen[:, 0] + seen[:, -1] <= 2
    y, found = camera.segments(p)
    assert 20 < seen.any(1).sum() < len(p) - 5
    assert one.sum() > 40 and (found[one & (seen.sum(1) > 80)]).all() and not found[~seen.any(1)].any()
    for k in np.flatnonzero(one & (seen.sum(1) > 80)):
        first, last = np.flatnonzero(seen[k])[[0, -1]]
        pixels = points.project(q[k, [first, first + 2, last, last - 2]])[0].reshape(2, 2, 2)
        steps = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=-1)
        assert (np.linalg.norm(y[k].reshape(2, 2) - pixels[:, 0], axis=-1) <= steps + 1e-9).all()
        assert points.inside(y[k].reshape(2, 2) * (1 - 1e-9) + 1e-9 * np.array(K[:2])).all()


@pytest.mark.parametrize("d", [(), (1e-12,)], ids=["no lens", "a lens"])
def test_the_shortest_segment_that_is_seen(d):
    """120 pixels of the ideal image, and an edge that is wholly inside keeps its ends."""
    p = np.array([[-0.25, 0.1, 1.0, 0.75, 0.1, 1.0], [0.1, -0.25, 2.0, 0.1, 0.75, 2.0]])
    for least, wanted in (
        (55.0, [True, True]),
        (55.0 + 1e-9, [True, False]),
        (120.0 - 1e-9, [True, False]),
        (120.1, [False, False]),
    ):
        y, seen = SegmentCam(K, d, image_size=SIZE, min_length=least).segments(p)
        assert seen.tolist() == wanted
    assert np.allclose(y, [[70.0, 81.0, 190.0, 81.0], [106.0, 56.25, 106.0, 111.25]], atol=1e-6)


def test_an_edge_on_the_border_of_the_image_is_seen():
    """The border belongs to the image: an edge that lies in the plane of the left wall is wholly there."""
    left = np.array([-100.0 / 120.0, -0.3, 1.0, -100.0 / 120.0, 0.3, 1.0])
    camera = SegmentCam((100.0, 70.0, 128.0, 128.0), image_size=(228.0, 198.0))
    left[[0, 3]] = -100.0 / 128.0
    y, seen = camera.segments(left)
    assert seen and np.allclose(y, [0.0, 70 - 0.3 * 128, 0.0, 70 + 0.3 * 128])
    assert not camera.segments(left - [1e-9, 0, 0] * 2)[1]
