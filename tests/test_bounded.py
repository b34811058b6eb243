"""Input that never ends, or would fill the memory, is refused at once and in one sentence."""

import os
import sys

import numpy as np
import pytest

from ekfslam_tutorial import cli
from ekfslam_tutorial.datasets.sources import find_file
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import SimLmk, SimRob, SimSen, sim_observation, worlds
from ekfslam_tutorial.toolbox import Recording
from tests.pace import Watch

pytestmark = pytest.mark.timeout(600)  # a pipe that is opened waits for ever; what is right takes seconds
unix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")


def refused(capsys, *words):
    with Watch() as it:
        assert cli.main([str(word) for word in words]) == 2
    said = capsys.readouterr().err.removeprefix("linear algebra on 1 thread (--threads)\n")
    assert said.count("\n") == 1 and it.seconds < 5
    return said


@unix
@pytest.mark.parametrize("kind", ["pipe", "/dev/zero"])
def test_what_is_no_file_is_not_read(kind, tmp_path, capsys, monkeypatch):
    """Given itself, behind a link, and in a folder beside others."""
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path))
    made, into = tmp_path / "log.npz", tmp_path / "into"
    into.mkdir()
    os.mkfifo(made) if kind == "pipe" else made.symlink_to(kind)
    words = "it is no regular file, but a folder, a pipe or a device"
    assert words in refused(capsys, "data", "import", made, "--to", into)
    (tmp_path / "link").symlink_to(made)
    assert words in refused(capsys, "data", "import", tmp_path / "link", "--to", into)
    assert words in refused(capsys, "run", "range_bearing_2d", "--recording", made, "--out", tmp_path / "out")
    assert "holds no data set" in refused(capsys, "data", "import", tmp_path, "--to", into)
    assert "no scenario file" in refused(capsys, "run", made, "--out", tmp_path / "out")
    assert find_file("log.npz") is None and not list(into.iterdir())
    with pytest.raises(ValueError, match=words):
        find_file("log.npz", made)


@unix
@pytest.mark.parametrize("name", ["recording.json", "frames.csv"])
def test_a_pipe_in_a_recording(name, tmp_path):
    Recording("log", np.arange(3.0), {1: np.zeros((3, 2))}, {}).save(tmp_path)
    (tmp_path / name).unlink()
    os.mkfifo(tmp_path / name)
    with pytest.raises(ValueError, match="it is no regular file, but a folder, a pipe or a device"):
        Recording.load(tmp_path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("sensor.1.clutter=1e9", "clutter is a mean number in a frame, 10000 at most, got 1e+09"),
        ("sensor.1.clutter=10001", "10000 at most, got 10001"),
        ("world={type='random2', n=1000000000}", "a world has 1000000 landmarks at most, got n = 1e+09"),
        ("world={type='ring', n=1000000000}", "a world has 1000000 landmarks at most"),
        ("world={type='cloister', n=1000000000, height=1.0}", "a world has 1000000 landmarks at most"),
    ],
)
def test_numbers_that_would_fill_the_memory(change, words, tmp_path, capsys):
    assert words in refused(capsys, "run", "range_bearing_2d", "--set", change, "--out", tmp_path)


def test_the_simulator_itself():
    rob = SimRob(1, "", Unicycle(), np.zeros(3), np.zeros(2), [1], "")
    sen = SimSen(1, "", 1, Frame2(np.zeros(3)), RangeBearing(0.1, 0.02), 1.0, 1e9)
    lmk = SimLmk(np.array([1]), np.ones((1, 2)))
    with pytest.raises(ValueError, match="sensor 1: clutter must be 10000 a frame at most"):
        sim_observation(rob, sen, lmk, np.random.default_rng(1), np.random.default_rng(2))
    assert len(worlds.random2(np.random.default_rng(1), 1000)[0]) == 1000
