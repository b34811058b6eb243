"""Logs made by hand, each trouble of the published files once (handmade/README.md)."""

import shutil
from pathlib import Path

import pytest

HANDMADE = Path(__file__).parent / "handmade" / "MRCLAM_Dataset1"


@pytest.fixture
def handmade(tmp_path):
    """A copy of the hand-made set, to read and to damage."""
    return Path(shutil.copytree(HANDMADE, tmp_path / "MRCLAM_Dataset1"))
