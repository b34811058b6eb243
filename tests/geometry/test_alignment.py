"""The rigid motion between two sets of points."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ekfslam_tutorial.geometry import Frame2, Frame3, align


def frame(rng, d):
    if d == 2:
        return Frame2(rng.uniform(-4, 4, 3))
    q = rng.normal(size=4)
    return Frame3(np.concatenate([rng.uniform(-4, 4, 3), q / np.linalg.norm(q)]))


def cost(F, points, targets):
    return ((F.from_frame(points)[0] - targets) ** 2).sum()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([2, 3]), st.integers(2, 40))
def test_an_exact_motion_is_found(seed, d, n):
    assume(n >= d)
    rng = np.random.default_rng(seed)
    F, points = frame(rng, d), rng.normal(size=(n, d))
    found = align(points, F.from_frame(points)[0])
    np.testing.assert_allclose(found.minus(F)[0], 0, atol=1e-9)


@pytest.mark.parametrize("d", [2, 3])
def test_it_is_the_least_squares_motion(rng, d):
    """No motion nearby has a smaller sum of squares, and the translation leaves no mean error."""
    points = rng.normal(size=(20, d))
    targets = frame(rng, d).from_frame(points)[0] + 0.3 * rng.normal(size=(20, d))
    F = align(points, targets)
    best = cost(F, points, targets)
    np.testing.assert_allclose((F.from_frame(points)[0] - targets).mean(0), 0, atol=1e-12)
    for _ in range(200):
        x = F.x + rng.normal(size=F.size) * rng.choice([1e-1, 1e-2, 1e-3])
        assert cost(type(F)(x).normalized()[0], points, targets) > best - 1e-12


@pytest.mark.parametrize("d", [2, 3])
def test_a_mirrored_map_is_not_mirrored_back(rng, d):
    """The best orthogonal matrix is a reflection here; a rigid motion must be a rotation all the same."""
    points = rng.normal(size=(20, d))
    F = align(points, points * ([1, -1, 1][:d]))
    assert np.linalg.det(F.R) == pytest.approx(1.0)
    assert cost(F, points, points * ([1, -1, 1][:d])) > 1.0


def test_points_on_a_plane_in_space_suffice(rng):
    F = frame(rng, 3)
    points = np.column_stack([rng.normal(size=(3, 2)), np.zeros(3)])
    np.testing.assert_allclose(align(points, F.from_frame(points)[0]).minus(F)[0], 0, atol=1e-9)


@pytest.mark.parametrize(
    ("points", "targets", "words"),
    [
        (np.zeros((3, 2)), np.zeros((2, 2)), r"got \(3, 2\) and \(2, 2\)"),
        (np.zeros(3), np.zeros(3), r"shape \(n, 2\) or \(n, 3\)"),
        (np.zeros((3, 4)), np.zeros((3, 4)), r"got \(3, 4\)"),
        (np.zeros((0, 2)), np.zeros((0, 2)), "0 points do not fix a rotation in 2D"),
        (np.ones((1, 2)), np.ones((1, 2)), "1 points do not fix a rotation in 2D"),
        (np.ones((5, 2)), np.ones((5, 2)), "on top of each other"),
        (np.arange(9.0).reshape(3, 3), np.arange(9.0).reshape(3, 3), "do not fix a rotation in 3D"),
        (np.array([[0, 0], [1, np.nan]]), np.eye(2), "finite points"),
    ],
)
def test_what_cannot_be_aligned(points, targets, words):
    with pytest.raises(ValueError, match=words):
        align(points, targets)
