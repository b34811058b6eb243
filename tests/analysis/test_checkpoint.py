"""A run that is killed goes on to the same end, to the last bit; a torn file is refused, not read as something else."""

import json
import os
import signal
import time
from multiprocessing import get_all_start_methods, get_context
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial import cli
from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.checkpoint import Checkpoint, resume
from ekfslam_tutorial.toolbox import UserData, universal_slam
from ekfslam_tutorial.toolbox.files import value_file

pytestmark = pytest.mark.usefixtures("undrawn")

SCENARIOS = Path(__file__).resolve().parents[2] / "data" / "scenarios"
INSTANTS, FREE = 50, 3
FRAMES = 500  # more than all instants together may bring
# Everything that a run can have in its map: poses, velocities, frames of sensors, landmarks that change their type,
# landmarks that are known, that are deleted, first estimates, one triangle, far states.
CASES = {
    "range_bearing_2d": ({}, 40),
    "two_robots_four_cameras": ({}, 16),
    "cloister_ahm": ({"options.joint": True}, 16),
    "constant_velocity": ({}, 16),
    "localisation_2d": ({}, 20),
    "first estimates": ({"options.first_estimates": True}, 40),
    "compressed": ({"options.compressed": True}, 40),
    "mrclam_twin": ({"options.association": "nearest_neighbour"}, 150),
}


def scenario(name, frames):
    changes, _ = CASES[name]
    file = SCENARIOS / f"{name if (SCENARIOS / f'{name}.toml').exists() else 'range_bearing_2d'}.toml"
    return UserData.from_toml(file, {**changes, "time.last": frames})


def source(data):
    from ekfslam_tutorial.datasets import prepare

    return (data, None) if data.data is None else prepare(data)


def bits(history):
    """All that a history holds, and the map at the end, as bytes."""
    s = history.last
    figures = [plain_bytes(history.state()), s.map.x.tobytes(), s.map.P.tobytes(), repr(list(s.lmks.values()))]
    return [*figures, json.dumps(history.summary(), default=str)]


def plain_bytes(values):
    arrays, small = {}, []
    tree = value_file._encode(values, arrays, small)
    return json.dumps(tree), [a.tobytes() for a in arrays.values()], np.array(small).tobytes()


@pytest.mark.parametrize("name", CASES)
def test_a_run_that_was_kept_goes_on_to_the_same_end(name, tmp_path):
    """With one checkpoint in the middle, written and read; the run that is not stopped writes it, too."""
    frames = CASES[name][1]
    data, recording = source(scenario(name, frames))
    kept, whole, run = tmp_path / "checkpoint.npz", History(), universal_slam(data, recording)
    keeper = Checkpoint(kept, data, recording, whole, every=frames // 2, n_frames=len(run))
    for s in run:
        whole.add(s)
        if s.k - data.time.first + 1 == frames // 2:
            keeper.add(s)

    again = History()
    rest = universal_slam(data, recording, resume=resume(kept, data, recording, again))
    assert sum(1 for _ in again.watch(rest)) == len(run) - frames // 2
    assert bits(again) == bits(whole)


@pytest.mark.skipif("forkserver" not in get_all_start_methods(), reason="this system cannot fork")
def test_killed_at_any_moment_it_goes_on_to_the_same_end(tmp_path):
    """kill -9 at 50 random instants of one run: its end is that of a run that nobody stopped."""
    rng, fresh = np.random.default_rng(8), get_context("forkserver")  # not a copy of this process, which has threads
    fresh.set_forkserver_preload([__name__])
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"
    whole.mkdir(), stopped.mkdir()
    drive(whole)
    for _ in range(INSTANTS):
        here, there = fresh.Pipe()
        child = fresh.Process(target=drive, args=(stopped, there))
        child.start()
        there.close()  # so that there is an end to read if it fails
        frames = rng.integers(1, 7)  # frames, not seconds: it comes on however busy the computer is
        here.send(frames + FREE)  # nor does it get to its end before the blow
        for _ in range(frames):
            here.recv()
        time.sleep(rng.uniform(0.0, 0.01))  # it is hit at any moment of these frames, or a little later
        child.kill()
        child.join()
        assert child.exitcode == -signal.SIGKILL  # it was still running
        if (stopped / "checkpoint.npz").exists():
            value_file.load(stopped / "checkpoint.npz")  # whole, wherever it was hit
    assert value_file.load(stopped / "checkpoint.npz")["run"]["frames"] > 3  # it came on between the blows
    drive(stopped)
    assert (stopped / "end.bin").read_bytes() == (whole / "end.bin").read_bytes()


def drive(folder, parent=None):
    """A run of the lecture's world that keeps itself every third frame and writes its end. Goes on if it can.

    A parent sends how many frames to make; it is told of each. After them, this process waits to be killed.
    """
    data, recording = source(scenario("range_bearing_2d", FRAMES))
    kept, history = folder / "checkpoint.npz", History()
    state = resume(kept, data, recording, history) if kept.exists() else None
    run = universal_slam(data, recording, resume=state)
    keeper = Checkpoint(kept, data, recording, history, every=3, n_frames=len(run))
    left = parent.recv() if parent else FRAMES
    for s in run:
        if parent:
            parent.send(s.k)
        history.add(s)
        keeper.add(s)
        left -= 1
        if parent and left == 0:
            parent.recv()
    (folder / "end.bin").write_bytes(repr(bits(history)).encode())


# --- the command -----------------------------------------------------------------------------------------------------


def run(out, *more):
    return cli.main(["run", "lecture_mapping", "--out", str(out), "--set", "time.last=20", *more])


def files(out):
    """What a run has written, without what depends on the clock."""
    texts = {p.name: p.read_text() for p in Path(out).iterdir() if p.suffix in (".json", ".csv", ".tum")}
    figures = json.loads(texts.pop("result.json"))
    return {k: v for k, v in figures.items() if k not in ("wall_s", "cpu_s", "frames_per_s")}, texts


def test_the_command_goes_on_after_an_interrupt(tmp_path, monkeypatch, capsys):
    assert run(tmp_path / "whole") == 0
    draw, count = History.add, iter(range(100))

    def stop_in_frame_8(self, s):
        draw(self, s)
        if next(count) == 8:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(History, "add", stop_in_frame_8)
    assert run(tmp_path / "stopped", "--checkpoint", "5") == 130
    monkeypatch.setattr(History, "add", draw)
    assert (tmp_path / "stopped" / "checkpoint.npz").exists()
    assert run(tmp_path / "stopped", "--resume") == 0
    assert "goes on after frame 9" in capsys.readouterr().err
    assert files(tmp_path / "stopped") == files(tmp_path / "whole")
    assert not (tmp_path / "stopped" / "checkpoint.npz").exists()


def test_resume_keeps_a_run_in_the_same_frames_as_before(tmp_path, monkeypatch):
    """Each checkpoint moves the last digits of a compressed map: without the same interval the end is not the same."""
    compressed = ["--set", "options.compressed=true", "--set", "time.last=40"]
    drive = lambda name, *more: cli.main(["run", "range_bearing_2d", "--out", str(tmp_path / name), *compressed, *more])
    assert drive("whole", "--checkpoint", "7") == 0
    add = History.add

    def killed_in_frame_16(self, s):
        add(self, s)
        if s.k == 16:
            raise KeyboardInterrupt  # nothing is kept here, unlike after the first Ctrl-C

    monkeypatch.setattr(History, "add", killed_in_frame_16)
    assert drive("killed", "--checkpoint", "7") == 130
    monkeypatch.setattr(History, "add", add)
    assert value_file.load(tmp_path / "killed" / "checkpoint.npz")["run"]["frames"] == 14
    assert drive("killed", "--resume") == 0
    assert files(tmp_path / "killed") == files(tmp_path / "whole")


def keep_five_frames(folder):
    """The begin of a run, as `Checkpoint` keeps it without the command."""
    data, _ = source(UserData.from_toml(SCENARIOS / "lecture_mapping.toml", {"time.last": 20}))
    history = History()
    frames = universal_slam(data)
    keeper = Checkpoint(folder / "checkpoint.npz", data, None, history, 5, len(frames))
    for _ in range(5):
        snapshot = next(frames)
        history.add(snapshot)
        keeper.add(snapshot)


@pytest.mark.parametrize(("more", "every"), [([], 200), (["--checkpoint", "4"], 4)])
def test_an_interval_that_is_given_goes_before_the_one_that_was_kept(tmp_path, monkeypatch, more, every):
    """Also where none was kept, as by `Checkpoint` without the command."""
    keep_five_frames(tmp_path)
    init, seen = Checkpoint.__init__, []
    monkeypatch.setattr(Checkpoint, "__init__", lambda *a: (seen.append(a[-2]), init(*a))[1])
    assert run(tmp_path, "--resume", *more) == 0
    assert seen == [every]


def test_without_a_checkpoint_it_begins_at_the_beginning_and_says_so(tmp_path, capsys):
    assert run(tmp_path, "--resume") == 0
    assert "from the beginning" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--seed", "99", "--resume"], "is of another run, changed is: seed; resume"),
        (["--set", "sensor.range_std=0.5", "--resume"], "changed is: sensors of the scenario; resume"),
        (["--checkpoint", "0"], "every 1 or more frames"),
        (["--checkpoint", "5", "--movie"], "cannot also write --movie"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, capsys, more, words):
    keep_five_frames(tmp_path)
    assert run(tmp_path, *more) == 2
    assert words in capsys.readouterr().err


def test_a_torn_file_is_refused(tmp_path, capsys):
    path = tmp_path / "values.npz"
    value_file.save(path, {"a": np.arange(500.0), "b": [1, (2.5, None)], "c": {3, 4}})
    good = path.read_bytes()
    rng = np.random.default_rng(1)
    for cut in rng.integers(0, len(good), 40):
        path.write_bytes(good[:cut])
        with pytest.raises(ValueError, match="damaged"):
            value_file.load(path)
    for at in rng.integers(0, len(good), 200):  # a flipped byte: found out, or outside of what is read
        path.write_bytes(good[:at] + bytes([good[at] ^ 0xFF]) + good[at + 1 :])
        try:
            kept = value_file.load(path)
        except ValueError:
            continue
        assert kept["a"].tobytes() == np.arange(500.0).tobytes() and kept["b"] == [1, (2.5, None)]


def test_a_full_disk_leaves_the_last_checkpoint(tmp_path, monkeypatch):
    path = tmp_path / "values.npz"
    value_file.save(path, [1])

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        value_file.save(path, [2])
    assert value_file.load(path) == [1] and [p.name for p in tmp_path.iterdir()] == ["values.npz"]


# --- a file of values ------------------------------------------------------------------------------------------------


def test_every_bit_of_every_value_comes_back(tmp_path):
    nan = np.frombuffer(b"\x01\x00\x00\x00\x00\x00\xf8\x7f", float)
    rows = [(0.1 * k, np.full(2, 1 / 3), np.full((2, 2), k / 7)) for k in range(100)]
    values = {
        "row": rows, 3: {"x": None, (1, 2): True}, "set": {5, 9},
        "f": np.asfortranarray(np.arange(200.0).reshape(10, 20)),
        "nan": nan, "ints": np.arange(3), "bools": np.array([True, False]), "r": slice(3, 5), "inf": float("-inf"),
        "big": 2**70, "empty": [(), [], {}, np.zeros((0, 3))], "one": [(1.0,)], "mixed": [(1.0,), (2, "a")],
    }  # fmt: skip
    value_file.save(tmp_path / "v.npz", values)
    back = value_file.load(tmp_path / "v.npz")
    assert plain_bytes(back) == plain_bytes(values)
    assert back["row"][7][0] == rows[7][0] and type(back["row"][7][0]) is float
    assert back["f"].flags.f_contiguous and not back["f"].flags.c_contiguous
    assert back["nan"].tobytes() == nan.tobytes() and back["mixed"] == values["mixed"] and back["big"] == 2**70


@pytest.mark.parametrize("value", [object(), [lambda: 0], np.array(["a"]), {"a": 1j}])
def test_only_plain_values_are_kept(tmp_path, value):
    with pytest.raises(TypeError, match="cannot be kept"):
        value_file.save(tmp_path / "v.npz", value)
    assert not list(tmp_path.iterdir())
