"""`ekfslam tune`: a scenario is written that `run` takes; it can be stopped; what makes no sense is one sentence."""

import json
import re
import signal
import sys

import pytest

from ekfslam_tutorial.analysis.corrections import CorrectionRatio
from ekfslam_tutorial.analysis.tuning import Tuning
from ekfslam_tutorial.cli import main, views
from ekfslam_tutorial.cli.tune import report
from ekfslam_tutorial.toolbox import ControlLog, RawLog, Recording, UserData

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch):
    monkeypatch.setattr(views, "write_figures", lambda *arguments: [])


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A recording without truth whose ranges are 0.8 m too long."""
    out = tmp_path_factory.mktemp("walk")
    words = ["--set", "time.last=100", "--out", str(out)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(views, "write_figures", lambda *arguments: [])
        assert main(["run", "range_bearing_2d", "--record", *words]) == 0
    log = Recording.load(out / "recording.npz")
    raw = log.raw[1]
    raw = RawLog(1, raw.offsets, raw.ids, raw.y + [0.8, 0.0])
    return Recording("walk", log.t, {1: log.robots[1].u}, {1: raw}).save(out / "log.npz")


def test_what_it_writes_can_be_run(walk, tmp_path, capsys):
    out = tmp_path / "walk-tuned.toml"
    assert main(["tune", str(walk), "--scenario", "range_bearing_2d", "--out", str(out)]) == 0
    said, progress = capsys.readouterr()
    assert re.search(r"ranges too long by: \+0\.[78]\d* \+- \S+ m \(kept\)", said)
    assert "R and U times " in said and "blind to: " in said
    assert re.search(r"frames, .*: (\d+)/\1\n", progress)  # all of all runs
    assert f"next: ekfslam run {out} --recording {walk}" in said
    text = out.read_text(encoding="utf-8")
    assert text.startswith("# Written by: ekfslam tune ") and "\n# ranges too long by: " in text
    sensor = UserData.from_toml(out).sensors[0]
    assert abs(sensor.biases()[0] - 0.8) < 0.1 and 0.8 < sensor.noise_factor < 1.25

    notes = {}
    for name in ("range_bearing_2d", str(out)):
        assert main(["run", name, "--recording", str(walk), "--out", str(tmp_path / "run")]) == 0
        notes[name] = json.loads((tmp_path / "run" / "result.json").read_text(encoding="utf-8"))["notes"]
    assert notes["range_bearing_2d"] and notes[str(out)] == []


@pytest.mark.parametrize("after", [1.1, 5.75])
def test_what_does_not_explain_the_log_is_not_to_be_trusted(after):
    ratios = (CorrectionRatio(value, 10, 1.8, {}) for value in (7.0, after))
    found = Tuning([], 2.0, (1.8, 2.2), "likelihood", *ratios, complete=True)
    doubted = [line for line in report(found) if "does not explain the log, so do not trust it: first look at" in line]
    assert len(doubted) == (after > 1.8)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["LOG"], "is a recording; which models it belongs to says --scenario NAME"),
        (["range_bearing_2"], "did you mean range_bearing_2d?"),
        (["range_bearing_2d", "--out", "a.txt"], "--out names the scenario file to write, NAME.toml"),
    ],
)
def test_one_sentence(words, says, walk, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(["tune", *(str(walk) if word == "LOG" else word for word in words)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ekfslam tune: ") and says in line


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child process")
def test_stopped_after_the_first_run_it_writes_what_it_has(tmp_path, ekfslam_process):
    """The second run has begun when its name is on the terminal. It is long: it cannot end before the signal comes."""
    out = tmp_path / "tuned.toml"
    words = "tune", "range_bearing_2d", "--set", "time.last=2000", "--out", out
    tune = ekfslam_process(*words, FORCE_COLOR="1")  # its bar is drawn into a pipe, too
    said = ""
    while "with the sensors' yaw" not in said:
        letter = tune.stderr.read(1)
        assert letter, f"it has ended: {said}"
        said += letter
    tune.send_signal(signal.SIGINT)
    text, _ = tune.communicate()
    assert tune.returncode == 130 and "stopped: what was found so far" in text
    assert UserData.from_toml(out).sensors[0].noise_factor >= 1


SETTINGS = {
    "sensor.1.range_std=0.5": "the recording has its own noise R; --set sensor.1.noise_factor=2 tells twice that R",
    "robot.v_std=0.3": "the recording has its own noise U; --set robot.1.noise_factor=2 tells twice that U",
    "robot.1.v=2": "the recording has its own controls",
    "sensor.p_detect=0.5": "that is for simulations, and a recording is played",
    "world.type=random2": "that is for simulations, and a recording is played",
    "time.dt=0.1": "that is for simulations, and a recording is played",
}


@pytest.mark.parametrize("setting", SETTINGS)
def test_settings_without_effect_are_named(setting, own_noise, tmp_path, capsys):
    words = ["--recording", str(own_noise), "--out", str(tmp_path), "--set", setting]
    assert main(["run", "range_bearing_2d", *words]) == 0
    note = f"--set {setting} has no effect: {SETTINGS[setting]}"
    assert f"note: {note}\n" in capsys.readouterr().err
    assert note in json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["notes"]


@pytest.mark.parametrize(
    "setting", ["sensor.1.max_range=4", "sensor.noise_factor=1.1", "robot.noise_factor=1.1", "seed=3"]
)
def test_settings_with_an_effect_are_not(setting, own_noise, tmp_path, capsys):
    words = ["--recording", str(own_noise), "--out", str(tmp_path), "--set", setting]
    assert main(["run", "range_bearing_2d", *words]) == 0
    assert "no effect" not in capsys.readouterr().err


def test_noise_of_the_scenario_has_an_effect_where_the_recording_has_none(walk, tmp_path, capsys):
    words = ["--recording", str(walk), "--out", str(tmp_path), "--set", "sensor.range_std=0.2"]
    assert main(["run", "range_bearing_2d", *words]) == 0
    assert "no effect" not in capsys.readouterr().err


@pytest.fixture(scope="module")
def own_noise(walk, tmp_path_factory):
    """A short recording that has its own R and U."""
    log = Recording.load(walk)
    raw, n = log.raw[1], 20
    k = raw.offsets[n]
    R = [[[0.01, 0], [0, 3e-4]]] * k
    raw = RawLog(1, raw.offsets[: n + 1], raw.ids[:k], raw.y[:k] - [0.8, 0], R)
    robots = {1: ControlLog(log.robots[1].u[:n], [[[0.01, 0], [0, 1.2e-3]]] * n)}
    return Recording("own", log.t[:n], robots, {1: raw}).save(tmp_path_factory.mktemp("own") / "log.npz")


def test_a_run_with_a_factor_is_not_recorded(tmp_path, capsys):
    words = ["--record", "--set", "sensor.noise_factor=2", "--out", str(tmp_path)]
    assert main(["run", "range_bearing_2d", *words]) == 2
    assert "record without them" in capsys.readouterr().err
