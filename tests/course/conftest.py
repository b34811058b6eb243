"""No test touches the progress of whoever runs the tests, and none sees a lecturer's private checks.

Nor does an answer fail because the computer is busy: what takes more than the 1.5 s of a student's patience is left to
the tests of that limit, and how quick a check is, is measured in time of the processor.
"""

import pytest

from ekfslam_tutorial.course import logbook, registry


@pytest.fixture(autouse=True)
def own_progress(tmp_path, monkeypatch):
    """Keep the progress in a file of this test's own."""
    monkeypatch.setenv(logbook.VARIABLE, str(tmp_path / "progress.json"))
    monkeypatch.delenv(registry.PRIVATE, raising=False)
    monkeypatch.setenv("EKFSLAM_CHECK_SECONDS", "200")
    return tmp_path / "progress.json"
