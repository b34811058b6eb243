"""What the tests of compiled maps share; without numba there is nothing to test."""

import pytest

pytest.importorskip("numba", reason="numba, the extra `compiled`, is not installed")

from .interpreter import interpreted

__all__ = ["interpreted"]
