"""`ekfslam run --recording`: a log that is not as it seems runs, but not without a word."""

import re

import numpy as np
import pytest

from ekfslam_tutorial.cli import main, views
from ekfslam_tutorial.toolbox import RawLog, Recording

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """The recording of a simulated walk."""
    out = tmp_path_factory.mktemp("walk")
    assert main(["run", "range_bearing_2d", "--record", "--set", "time.last=60", "--out", str(out)]) == 0
    return Recording.load(out / "recording.npz")


@pytest.fixture
def played(log, tmp_path, capsys, monkeypatch):
    """Play a changed log, without pictures; what is noted in the end."""
    monkeypatch.setattr(views, "write_figures", lambda *arguments: [])

    def play(*words, robots=None, raw=None):
        rec = Recording(log.name, log.t, robots or log.robots, raw or log.raw, log.truth)
        path = rec.save(tmp_path / "log.npz")
        assert main(["run", "range_bearing_2d", "--recording", str(path), "--out", str(tmp_path / "out"), *words]) == 0
        return [line for line in capsys.readouterr().err.splitlines() if line.startswith("note: ")]

    return play


def test_of_a_good_log_nothing_is_noted(played):
    assert played() == played("--set", "options.md2_threshold=1e9") == []


ASK = "are units, signs, mounting, ids and noise right?"
SIGN = "is the sign of the bearing right (positive to the left), and are units, mounting, ids and noise?"


@pytest.mark.parametrize(
    ("factor", "gate", "says"),
    [
        ([3.2808, 1], 1e9, r"the mean NIS is \S+, and 2 is expected: "),  # feet
        ([3.2808, 1], 9, r"of \d+ innovations \d+ did not pass the gate: "),
        ([1, -1], 9, r"of \d+ innovations \d+ did not pass the gate: "),  # bearings clockwise
        ([1000, 1], 9, "no landmark was measured a second time: "),  # millimetres: all is out of range
    ],
)
def test_units_and_signs_that_are_wrong_are_noticed(log, played, factor, gate, says):
    raw = log.raw[1]
    wrong = {1: RawLog(1, raw.offsets, raw.ids, raw.y * factor)}
    (note,) = played("--set", f"options.md2_threshold={gate}", raw=wrong)
    assert re.fullmatch("note: " + says + re.escape(SIGN if "gate" in says else ASK), note)


def test_what_the_scenario_leaves_out_is_named(log, played):
    more = log.robots | {4: log.robots[1], 2: log.robots[1]}
    assert played(robots=more) == ["note: the recording has more robots than the scenario; not used: 2, 4"]
    assert played(raw=log.raw | {7: log.raw[1]}) == [
        "note: the recording has more sensors than the scenario; not used: 7"
    ]


def test_copies_are_counted(log, played):
    """Each row of the first two frames that saw something, once more behind itself."""
    raw = log.raw[1]
    n = int(raw.offsets[np.flatnonzero(raw.offsets)[1]])
    again = np.r_[np.repeat(np.arange(n), 2), np.arange(n, len(raw.ids))]
    offsets = np.where(raw.offsets <= n, 2 * raw.offsets, raw.offsets + n)
    (note,) = played(raw={1: RawLog(1, offsets, raw.ids[again], raw.y[again])})
    assert note.startswith(f"note: {n} of the {len(raw.ids) + n:,} measurements of sensor 1 are copies of another one")


def test_of_a_few_frames_nothing_is_noted(log, played):
    """In so few of them no landmark need be seen again."""
    assert played("--set", "time.last=3") == []


def test_models_of_ones_own_are_suspected_first(tmp_path, capsys):
    assert main(["new", "sensor", "my_sonar", "--dir", str(tmp_path)]) == 0
    own = tmp_path / "my_sonar.py"
    text = own.read_text()
    own.write_text(text.replace("np.arctan2(y, x)], -1), Y_p", "np.arctan2(y, x)], 0), Y_p"))
    assert own.read_text() != text
    scenario = tmp_path / "mine.toml"
    scenario.write_text(
        '[world]\ntype = "lecture"\n[[robot]]\nmotion = "unicycle"\nv = 1.0\n[[sensor]]\ntype = "my_sonar"\n'
    )
    capsys.readouterr()
    assert main(["run", str(scenario), "--models", str(own), "--out", str(tmp_path / "out")]) == 2
    (said,) = (line for line in capsys.readouterr().err.splitlines() if line.startswith("ekfslam run: "))
    assert "shapes" in said and said.endswith(
        "does each model of your own pass its test? EKFSLAM_TRACEBACK=1 shows where"
    )
