"""Angles live in (-pi, pi], whatever number stands for them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ekfslam_tutorial.geometry import wrap

ANGLES = st.floats(-1e6, 1e6, allow_nan=False)


@given(ANGLES)
def test_the_interval_is_half_open(angle):
    assert -np.pi < wrap(angle) <= np.pi


@given(ANGLES)
def test_the_direction_stays(angle):
    # The argument is rounded to 1e6 * 2^-53: that much of the direction was never there.
    assert np.allclose([np.cos(wrap(angle)), np.sin(wrap(angle))], [np.cos(angle), np.sin(angle)], atol=1e-9)


@pytest.mark.parametrize(
    "angle, wrapped",
    [(0.0, 0.0), (np.pi, np.pi), (-np.pi, np.pi), (3 * np.pi, np.pi), (1.5 * np.pi, -0.5 * np.pi)],
)
def test_the_seam(angle, wrapped):
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-15)


def test_just_past_the_seam_the_sign_changes():
    above, below = np.nextafter(np.pi, 4), np.nextafter(-np.pi, -4)
    assert wrap(above) == pytest.approx(-np.pi) and wrap(below) == pytest.approx(np.pi)


def test_arrays_keep_their_shape():
    a = np.linspace(-10, 10, 24).reshape(2, 3, 4)
    assert wrap(a).shape == a.shape
    assert np.array_equal(wrap(a)[1, 2], wrap(a[1, 2]))
