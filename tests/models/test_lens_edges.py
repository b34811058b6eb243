"""The inverse of a lens where its derivative is exactly one, and where it has none."""

import numpy as np

from ekfslam_tutorial.models.sensors.lens import distort, exact_undistort


def test_a_lens_that_bends_nothing():
    """Its derivative is the identity, of determinant 1."""
    up, UP_ud = exact_undistort(np.array([[0.3, -0.2], [0.0, 0.0]]), np.zeros(2))
    assert np.array_equal(up, [[0.3, -0.2], [0.0, 0.0]]) and np.array_equal(UP_ud, [np.eye(2)] * 2)


def test_at_the_fold_there_is_no_derivative():
    """r (1 - r^2 / 3) has its top at r = 1. There, and in no other place, the derivative is singular: NaN, no error."""
    d = np.array([-1 / 3])
    ud = distort(np.array([[0.5, 0.0], [1.0, 0.0], [0.0, 0.2]]), d)[0]
    up, UP_ud = exact_undistort(ud, d)
    assert np.allclose(up[[0, 2]], [[0.5, 0.0], [0.0, 0.2]]) and np.isfinite(UP_ud[[0, 2]]).all()
    assert not np.isfinite(UP_ud[1]).all() or np.abs(UP_ud[1]).max() > 1e3
    assert np.isnan(exact_undistort(np.array([[0.7, 0.0]]), d)[0]).all()  # beyond it
