"""Tests of the filter run twice: with both triangles of the covariance kept up to date, and with one."""

import pytest

from ekfslam_tutorial.ekf import stochastic_map


@pytest.fixture(params=["both-triangles", "one-triangle"])
def triangles(request, monkeypatch):
    """A map keeps one triangle from so many states on."""
    monkeypatch.setattr(stochastic_map, "ONE_TRIANGLE", 400 if request.param == "both-triangles" else 0)
