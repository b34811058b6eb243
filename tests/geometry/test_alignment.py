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
        (np.zeros((5, 2)), np.zeros((5, 2)), "on top of each other"),
        (np.arange(9.0).reshape(3, 3), np.arange(9.0).reshape(3, 3), "do not fix a rotation in 3D"),
        (np.array([[0, 0], [1, np.nan]]), np.eye(2), "finite points"),
    ],
)
def test_what_cannot_be_aligned(points, targets, words):
    with pytest.raises(ValueError, match=words):
        align(points, targets)


# --- weights ---


@pytest.mark.parametrize("d", [2, 3])
def test_a_weight_counts_as_often_as_it_says(rng, d):
    """Two for one is the same as the pair written twice, zero as left out; all times ten changes nothing."""
    points = rng.normal(size=(8, d))
    targets = frame(rng, d).from_frame(points)[0] + 0.3 * rng.normal(size=(8, d))
    weights = np.array([1, 2, 0, 1, 3, 1, 0, 1])
    twice = np.repeat(np.arange(8), weights)
    wanted = align(points[twice], targets[twice])
    for factor in (1.0, 10.0, 1e-9):
        got = align(points, targets, (factor * weights).tolist())
        np.testing.assert_allclose(got.minus(wanted)[0], 0, atol=1e-12)
    assert np.abs(align(points, targets).minus(wanted)[0]).max() > 1e-2
    assert align(points, targets) == align(points, targets, np.ones(8))


@pytest.mark.parametrize(
    "weights", [[1.0, 1.0], [1.0, 1.0, -1e-300], [1, 1, np.nan], [1, 1, np.inf], np.ones((3, 1)), 1.0]
)
def test_weights_that_are_none(weights):
    with pytest.raises(ValueError, match="alignment of 3 points needs as many weights, finite and not negative"):
        align(np.eye(3)[:, :2], np.eye(3)[:, :2], weights)


def test_points_without_weight_do_not_fix_a_rotation():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    for weights in ([0, 0, 0], [1, 0, 0]):
        with pytest.raises(ValueError, match="3 points do not fix a rotation in 2D"):
            align(points, points, weights)
    assert np.allclose(align(points, points, [1, 0, 1]).x, 0, atol=1e-15)


def test_how_near_to_a_line_points_in_space_may_be():
    """The second singular value of the cross-covariance: 1e-12 of the first is rounding, a little more is not."""
    for side, fixed in ((2e-6, True), (0.5e-6, False)):
        points = np.array([[-1.0, 0, 0], [1.0, 0, 0], [0, side, 0], [0, -side, 0]])
        if fixed:
            assert np.allclose(align(points, points).minus(Frame3(np.eye(7)[3]))[0], 0, atol=1e-3)
        else:
            with pytest.raises(ValueError, match="4 points do not fix a rotation in 3D"):
                align(points, points)
    for far in (1e3, 1e8):  # in one place but for rounding
        with pytest.raises(ValueError, match="do not fix a rotation"):
            align(np.full((5, 2), far) + 1e-16, np.full((5, 2), far))
