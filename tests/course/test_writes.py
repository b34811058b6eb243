"""What the checks do with a student's code: they write nothing but the record of the progress, wherever they run."""

import os
import sys
from pathlib import Path

import pytest

from ekfslam_tutorial.course import logbook, registry

OPENED: list | None = None  # an audit hook cannot be taken away again; it writes here while somebody listens


def _hook(event, arguments):
    if OPENED is None:
        return
    if event == "open":
        path, mode, flags = arguments
        if not isinstance(path, int) and (flags or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            OPENED.append(os.fsdecode(path))
    elif event in ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "shutil.rmtree", "subprocess.Popen", "os.system"):
        OPENED.append(f"{event} {arguments[0]}")
    elif event == "socket.connect":
        OPENED.append(f"connects to {arguments[1]}")


@pytest.fixture
def own_progress(own_progress, tmp_path, monkeypatch):
    """In a folder of its own, which is there before anybody listens."""
    monkeypatch.setenv(logbook.VARIABLE, str(tmp_path / "progress.json"))
    return tmp_path / "progress.json"


@pytest.fixture
def listening():
    global OPENED
    if not getattr(sys, "_ekfslam_audit", False):
        sys.addaudithook(_hook)
        sys._ekfslam_audit = True
    OPENED = []
    yield OPENED
    OPENED = None


def test_the_hook_hears_what_is_written(listening, tmp_path):
    (tmp_path / "a").write_text("x")
    (tmp_path / "a").rename(tmp_path / "b")
    assert listening == [str(tmp_path / "a"), f"os.rename {tmp_path / 'a'}"]


def test_checks_write_only_the_progress(listening, tmp_path, capsys):
    """All exercises with a right answer and a wrong one of each; the reference itself is never judged nor counted."""
    from ekfslam_tutorial.course import check

    progress = Path(os.environ[logbook.VARIABLE]).parent
    for exercise in registry.everything():
        for answer in (*exercise.variants[:1], *exercise.misconceptions[:1]):
            check(exercise.id, answer.answer)
    assert len(listening) > 100  # the progress was written
    # Python may write the byte code of a module that it imports for the first time.
    strangers = [p for p in listening if not p.split(" ")[-1].startswith(str(progress)) and "__pycache__" not in p]
    assert not strangers
