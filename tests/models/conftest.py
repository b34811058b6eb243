"""What the tests of models share."""

import pytest

from ekfslam_tutorial.geometry import jacobians

from .differences import at_once


@pytest.fixture
def all_at_once(monkeypatch):
    """All differences of `check_jacobians` are taken at once; what it looks at must take stacks, see `stacked`."""
    monkeypatch.setattr(jacobians, "numerical_jacobian", at_once)
