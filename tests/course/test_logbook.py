"""The student's record: damaged by hand, or changed by two kernels at once, it loses nothing and says what happened."""

import errno
import json
import subprocess
import sys

import pytest

from ekfslam_tutorial.course import checks, logbook


@pytest.fixture
def own_progress(own_progress, tmp_path, monkeypatch):
    """By its usual name, in a folder of its own: the files beside it are looked at."""
    monkeypatch.setenv(logbook.VARIABLE, str(tmp_path / "progress.json"))
    return tmp_path / "progress.json"


@pytest.fixture
def twenty():
    for i in range(20):
        logbook.attempt(f"02.{i + 1}", passed=True)
    return logbook.read()


def test_one_comma_too_many_loses_no_record(twenty, capsys):
    text = logbook.path().read_text().replace("},", "},,", 1)
    logbook.path().write_text(text)
    assert logbook.read() == twenty
    logbook.attempt("03.1", passed=False)
    said = capsys.readouterr().out
    assert said.count("\n") == 1 and "is damaged (Expecting property name" in said
    assert "these are the 20 records of progress.backup.json beside it." in said
    assert said.endswith("The damaged file is kept as progress.damaged.json.\n")
    assert logbook.path().with_name("progress.damaged.json").read_text() == text
    assert logbook.damage() is None and logbook.read() == twenty | {"03.1": {**logbook.EMPTY, "tries": 1}}


def test_two_damaged_files_are_both_kept(twenty, capsys):
    for text in ("first", "second"):
        logbook.path().write_text(text)
        logbook.attempt("03.1", passed=False)
    folder = logbook.path().parent
    assert [(folder / f"progress.damaged{n}.json").read_text() for n in ("", "1")] == ["first", "second"]
    assert logbook.read()["03.1"]["tries"] == 2 and capsys.readouterr().out.count("is kept as") == 2


def test_a_damaged_file_and_a_full_disk_lose_no_record(twenty, monkeypatch, capsys):
    """Neither at once, nor when there is room again: the backup is asked as long as the damaged file is there."""
    logbook.path().write_text("{,")
    with monkeypatch.context() as full:

        def no_room(target, text):
            raise OSError(errno.ENOSPC, "No space left on device")

        full.setattr(logbook, "_replace", no_room)
        logbook.attempt("03.1", passed=True)
    assert logbook.read() == twenty and logbook.path().read_text() == "{," and capsys.readouterr().out == ""
    logbook.attempt("03.2", passed=False)
    assert logbook.read() == twenty | {"03.2": {**logbook.EMPTY, "tries": 1}}
    assert "The damaged file is kept as progress.damaged.json." in capsys.readouterr().out


def test_without_a_backup_it_is_said_that_nothing_can_be_read(capsys):
    logbook.path().write_text("[]")
    checks.progress("02")
    assert "is damaged (it holds no records): no record can be read." in capsys.readouterr().out
    assert logbook.path().read_text() == "[]"  # who only looks changes nothing


ATTEMPTS = "from ekfslam_tutorial.course import logbook; [logbook.attempt('02.1', False) for _ in range(100)]"


def test_two_kernels_at_once_lose_nothing(twenty):
    kernels = [subprocess.Popen([sys.executable, "-c", ATTEMPTS]) for _ in range(2)]
    assert [kernel.wait() for kernel in kernels] == [0, 0]
    assert logbook.read()["02.1"]["tries"] == 201 and len(logbook.read()) == 20
    names = {file.name for file in logbook.path().parent.iterdir()}
    assert names == {"progress.json", "progress.backup.json"} and json.loads(logbook.backup().read_text())
