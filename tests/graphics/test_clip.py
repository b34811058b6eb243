"""Clipping: what is drawn lies in the region, and what lies in the region is drawn."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame3
from ekfslam_tutorial.graphics import ellipse_points
from ekfslam_tutorial.graphics.clip import box, clip_curves, inside, pyramid

SQUARE = box([[-1, 1], [-1, 1]])


def drawn_length(rows):
    steps = np.diff(rows, axis=0)
    return np.nansum(np.linalg.norm(steps, axis=1))


def test_curves_inside_stay_whole():
    curves = 0.3 * np.random.default_rng(0).uniform(-1, 1, (5, 7, 2))
    rows = clip_curves(curves, SQUARE)
    assert np.isnan(rows[:, 0]).sum() == 5
    np.testing.assert_array_equal(rows[np.isfinite(rows[:, 0])], curves.reshape(-1, 2))


@pytest.mark.parametrize(
    "ends, length",
    [
        ([(-5, 0), (5, 0)], 2.0),  # through
        ([(0, 0), (5, 0)], 1.0),  # out
        ([(5, 0), (0, 0)], 1.0),  # in
        ([(-2, -2), (2, 2)], 2 * np.sqrt(2)),  # through two corners
        ([(-5, 2), (5, 2)], 0.0),  # past
        ([(3, 0), (0, 3)], 0.0),  # past a corner: both walls are crossed, but never at once
        ([(2, 2), (5, 5)], 0.0),
    ],
)
def test_segments(ends, length):
    assert drawn_length(clip_curves(np.array([ends], dtype=float), SQUARE)) == pytest.approx(length)


@pytest.mark.parametrize("d", [2, 3])
def test_random_segments_agree_with_dense_sampling(d):
    rng = np.random.default_rng(3)
    region = box([[-1, 1]] * d)
    segments = rng.uniform(-3, 3, (200, 2, d))
    rows = clip_curves(segments, region)
    finite = rows[np.isfinite(rows[:, 0])]
    assert (np.abs(finite) <= 1 + 1e-9).all()
    s = np.linspace(0, 1, 2001)[:, None]
    for a, b in segments:
        share = inside(a + s * (b - a), region).mean()
        length = drawn_length(clip_curves(np.array([[a, b]]), region))
        assert length == pytest.approx(share * np.linalg.norm(b - a), abs=2e-3 * np.linalg.norm(b - a))


def test_a_point_that_is_not_finite_interrupts_the_line_only_there():
    line = np.array([[[-0.5, 0.0], [0.0, 0.0], [np.nan, 0.0], [0.5, 0.5], [3.0, 0.5]]])
    assert drawn_length(clip_curves(line, SQUARE)) == pytest.approx(0.5 + 0.5)


def test_an_ellipse_of_kilometres_still_shows_its_flanks():
    """Seen from one place only, a landmark has such an ellipse; none of its points lies near the world."""
    long = ellipse_points([500.0, 0.0], np.diag([1e6, 0.01]))
    assert not inside(long, SQUARE).any()
    assert drawn_length(clip_curves(long[None], SQUARE)) == pytest.approx(4.0, rel=0.01)


def test_nothing_to_draw():
    assert clip_curves(np.zeros((0, 5, 2)), SQUARE).shape == (0, 2)


def test_pyramid_is_what_a_camera_sees():
    frame = Frame3([1.0, 2.0, 3.0, 0.5, -0.5, 0.5, -0.5])  # looks along x, its y axis down
    region = pyramid(frame, np.array([1.0, 0.75]), near=0.1)
    camera = np.array([[0, 0, 1], [0.9, 0.7, 1], [1.1, 0, 1], [0, -0.8, 1], [0, 0, -1], [0, 0, 0.05]])
    world = frame.from_frame(camera)[0]
    np.testing.assert_array_equal(inside(world, region), [True, True, False, False, False, False])
    assert world[0] @ [1, 0, 0] == pytest.approx(2.0)
