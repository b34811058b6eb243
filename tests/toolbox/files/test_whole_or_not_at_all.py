"""A disk that is full, a program that is killed, two programs at once: a file is the old one or the new one, whole."""

import os
import runpy
import signal
import subprocess
import sys
import time
import types

import numpy as np
import pytest

from ekfslam_tutorial.simulation import SimLmk, SimObs
from ekfslam_tutorial.toolbox import Recording
from ekfslam_tutorial.toolbox.files import locks
from ekfslam_tutorial.toolbox.files.locks import Taken, one_at_a_time, only_here
from ekfslam_tutorial.toolbox.files.writing import PREFIX, replacing, sweep, written

unix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has neither such limits nor such signals")


def recording(name, n=40, truth=True):
    rng = np.random.default_rng(len(name))
    robots, raw = {1: rng.normal(size=(n, 2))}, {1: [SimObs(1, np.array([4]), rng.normal(size=(1, 2)))] * n}
    known = {1: rng.normal(size=(n, 3))} if truth else {}
    return Recording(name, np.arange(n) * 0.1, robots, raw, known, SimLmk(np.array([4]), rng.normal(size=(1, 2))))


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def same(a, b):
    assert (a.name, sorted(a.truth)) == (b.name, sorted(b.truth)) and (a.landmarks is None) == (b.landmarks is None)
    assert np.array_equal(a.robots[1].u, b.robots[1].u) and np.array_equal(a.raw[1].y, b.raw[1].y)


SAVE = """
import resource, signal, sys
from ekfslam_tutorial.toolbox import Recording
rec = Recording.load(sys.argv[1])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # then a write fails, as on a full disk
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[3]),) * 2)
try:
    rec.save(sys.argv[2])
except OSError as error:
    print(error)
    sys.exit(7)
"""


@unix
@pytest.mark.parametrize("name", ["log.npz", "log"])
def test_a_full_disk_leaves_the_old_recording(tmp_path, name):
    """Each file may have 700 bytes: enough for some of them, not for all."""
    here = tmp_path / "here"
    here.mkdir()
    recording("old").save(here / name)
    recording("the new one", 400).save(tmp_path / "new.npz")
    before = contents(here)
    words = [sys.executable, "-c", SAVE, str(tmp_path / "new.npz"), str(here / name), "700"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 7 and "File too large" in done.stdout, done.stderr
    assert contents(here) == before


def test_an_error_while_it_is_written_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "log.npz"
    recording("old").save(path)
    before = path.read_bytes()

    def torn(file, **_):
        file.write(b"PK")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", torn)
    with pytest.raises(OSError, match="No space") as caught:
        recording("new").save(path)
    assert caught.value.filename == str(path) and path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("named", [False, True])
def test_written(tmp_path, monkeypatch, text, named):
    """On systems with files that have no name yet, and on others."""
    if named:
        monkeypatch.delattr(os, "O_TMPFILE", raising=False)
    with written(tmp_path / "a", text) as file:
        file.write("1\n" if text else b"1\n")
        assert not (tmp_path / "a").exists()
    assert (tmp_path / "a").read_bytes() == b"1\n" and [p.name for p in tmp_path.iterdir()] == ["a"]
    with pytest.raises(ZeroDivisionError), written(tmp_path / "a", text) as file:
        file.write("2" if text else b"2")
        raise ZeroDivisionError
    assert (tmp_path / "a").read_bytes() == b"1\n" and [p.name for p in tmp_path.iterdir()] == ["a"]


# --- a folder that had another recording -----------------------------------------------------------------------------


def test_a_folder_has_one_recording(tmp_path):
    """Truth, fixes and sensors of the old one do not come back; what is of no recording stays."""
    old, new = recording("old"), recording("new", 30, truth=False)
    old.fixes, old.raw = {1: np.zeros((2, 3))}, {1: old.raw[1], 7: old.raw[1]}
    old.save(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    new.save(tmp_path)
    back = Recording.load(tmp_path)
    same(back, new)
    assert list(back.raw) == [1] and not back.fixes and (tmp_path / "notes.txt").read_text() == "mine"
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_a_file_of_no_recording_is_not_touched(tmp_path):
    (tmp_path / "landmarks.csv").write_text("mine")
    with pytest.raises(ValueError, match="holds landmarks.csv, which is of no recording; give another folder"):
        recording("new").save(tmp_path)
    assert contents(tmp_path).popitem()[1] == b"mine"


def test_files_that_do_not_belong_together_are_refused(tmp_path):
    recording("old").save(tmp_path / "a")
    recording("new", truth=False).save(tmp_path / "b")
    truth = tmp_path / "a" / "robot-1-truth.csv"
    (tmp_path / "b" / truth.name).write_bytes(truth.read_bytes())
    with pytest.raises(ValueError, match=f"{truth.name} is not in the rows of recording.json"):
        Recording.load(tmp_path / "b")
    truth.unlink()
    with pytest.raises(FileNotFoundError, match=f"{truth.name} is missing in"):
        Recording.load(tmp_path / "a")


def test_who_is_stopped_while_files_are_moved_leaves_no_mixture(tmp_path, monkeypatch):
    """Stopped after each of the moves in turn: no recording is read, or a whole one; and it can be written again."""
    old, new = recording("old"), recording("new", 30, truth=False)
    replace, moves, left = os.replace, 0, []

    def stopped(*paths):
        if not left:
            raise KeyboardInterrupt
        left.pop()
        replace(*paths)

    for moves in range(20):
        monkeypatch.setattr(os, "replace", replace)
        old.save(tmp_path)
        left[:] = [None] * moves
        monkeypatch.setattr(os, "replace", stopped)
        try:
            new.save(tmp_path)
            break
        except KeyboardInterrupt:
            pass
        try:
            same(Recording.load(tmp_path), old)
        except ValueError as refused:
            assert "is not a whole recording: whoever wrote it was stopped; write it anew" in str(refused)
    assert moves > 4
    same(Recording.load(tmp_path), new)


# --- several programs ------------------------------------------------------------------------------------------------


def test_a_folder_is_held_by_one(tmp_path):
    with only_here(tmp_path), pytest.raises(Taken, match="another run is writing into the folder"), only_here(tmp_path):
        pass
    with only_here(tmp_path):  # and given back
        assert not list(tmp_path.iterdir())


ADD = """
import sys
from pathlib import Path
from ekfslam_tutorial.toolbox.files import locks
from ekfslam_tutorial.toolbox.files.locks import one_at_a_time
from ekfslam_tutorial.toolbox.files.writing import written
path = Path(sys.argv[1])
for _ in range(50):
    with one_at_a_time(path):
        n = int(path.read_text() or 0)
        with written(path, text=True) as file:
            file.write(str(n + 1))
"""


def test_two_that_change_a_file_lose_nothing(tmp_path):
    path = tmp_path / "count"
    both = [subprocess.Popen([sys.executable, "-c", ADD, str(path)]) for _ in range(2)]
    assert [one.wait() for one in both] == [0, 0]
    assert path.read_text() == "100" and [p.name for p in tmp_path.iterdir()] == ["count"]


@pytest.mark.parametrize("module_fcntl", [None, types.ModuleType("fcntl")], ids=["is not there", "is empty"])
def test_where_nothing_can_be_locked_nobody_waits(tmp_path, monkeypatch, module_fcntl):
    """As in a browser: no locks, and no files that go with a program."""
    monkeypatch.setitem(sys.modules, "fcntl", module_fcntl)
    monkeypatch.setattr(locks, "flock", runpy.run_path(locks.__file__)["flock"])
    monkeypatch.delattr(os, "O_TEMPORARY", raising=False)
    monkeypatch.setattr(locks.time, "sleep", lambda seconds: pytest.fail("somebody waits"))
    with one_at_a_time(tmp_path / "a"), only_here(tmp_path), written(tmp_path / "a") as file:
        file.write(b"1")
    assert (tmp_path / "a").read_bytes() == b"1"


def test_in_a_browser_the_storage_sees_whole_files_only(tmp_path, monkeypatch):
    """It stops the kernel when a file of JSON is opened to be written anew, or is closed half written."""
    monkeypatch.setattr(sys, "platform", "emscripten")
    path, whole = tmp_path / "a.json", []
    write = type(path).write_bytes

    def write_bytes(self, data):
        whole.append((self, self.exists(), data))
        return write(self, data)

    monkeypatch.setattr(type(path), "write_bytes", write_bytes)
    for text in ("{}", "[1]"):
        with replacing(path) as part:
            part.write_text(text)
            assert part.suffix == ".json" and part.parent != tmp_path
    assert whole == [(path, False, b"{}"), (path, False, b"[1]")] and path.read_text() == "[1]"
    with pytest.raises(ZeroDivisionError), replacing(path) as part:
        part.write_text(str(1 / 0))
    assert path.read_text() == "[1]" and list(tmp_path.iterdir()) == [path]


def test_a_lock_alone_leaves_no_file(tmp_path):
    with one_at_a_time(tmp_path / "a"):
        pass
    assert not list(tmp_path.iterdir())


WRITE = """
import sys, time
from ekfslam_tutorial.toolbox.files.writing import {how}
with {how}(sys.argv[1]) as part:
    getattr(part, "write", getattr(part, "write_bytes", None))(b"half")
    print(flush=True)
    time.sleep(3600)
"""


@unix
@pytest.mark.parametrize("how", ["written", "replacing"])
def test_what_a_killed_program_leaves_goes_with_the_next_one(tmp_path, how):
    """Of `written` nothing is left from the beginning, where the system can do that. Files in use stay."""
    words = [sys.executable, "-c", WRITE.format(how=how), str(tmp_path / "a.bin")]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        there = sorted(tmp_path.iterdir())
        assert all(p.name.startswith(PREFIX) for p in there)
        if how == "written" and sys.platform == "linux":
            assert there == []
        sweep(tmp_path)
        assert sorted(tmp_path.iterdir()) == there
        process.send_signal(signal.SIGKILL)
    sweep(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_file_that_is_being_replaced_stays_until_then(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"old")
    with replacing(path) as part:
        part.write_bytes(b"new")
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new" and time.time() - path.stat().st_mtime < 3600
