"""What decides the numbers decides the name: one byte of any input is another run, and it is said which input."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial import analysis, cli
from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.checkpoint import Checkpoint, resume
from ekfslam_tutorial.cli.run import own_models
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.simulation import SimLmk
from ekfslam_tutorial.toolbox import Recording, UserData, identity, universal_slam
from ekfslam_tutorial.toolbox.recordings import ControlLog, RawLog

SCENARIO = Path(__file__).resolve().parents[2] / "data" / "scenarios" / "range_bearing_2d.toml"
WORDS = r"is of another run, changed is: {}; resume with the same, or without --resume"


def recording():
    """Every array that a recording can have."""
    rng = np.random.default_rng(3)
    n, k = 12, np.array([0, *range(1, 12), 12])
    y, R = rng.uniform(1, 3, (n, 2)), np.tile(np.eye(2), (n, 1, 1))
    log = RawLog(1, k, np.arange(n) % 3, y, R)
    met = RawLog(1, np.zeros(n + 1, int), np.zeros(0, int), np.zeros((0, 2)))
    landmarks = SimLmk(np.arange(3), rng.normal(size=(3, 2)))
    robots = {1: ControlLog(rng.normal(size=(n, 2)), np.tile(0.01 * np.eye(2), (n, 1, 1)))}
    fixes = {1: rng.normal(size=(4, 3))}
    t = 0.1 * np.arange(n)
    return Recording("log", t, robots, {1: log}, {1: rng.normal(size=(n, 3))}, landmarks, [], {1: met}, fixes=fixes)


PLACES = {
    "times of the recording": lambda rec: rec.t,
    "controls of robot 1": lambda rec: rec.robots[1].u,
    "controls of robot 1 ": lambda rec: rec.robots[1].U,
    "measurements of sensor 1": lambda rec: rec.raw[1].y,
    "measurements of sensor 1 ": lambda rec: rec.raw[1].R,
    "measurements of sensor 1  ": lambda rec: rec.raw[1].ids,
    "truth of robot 1": lambda rec: rec.truth[1],
    "fixes of robot 1": lambda rec: rec.fixes[1],
    "landmarks of the recording": lambda rec: rec.landmarks.points,
    "landmarks of the recording ": lambda rec: rec.landmarks.ids,
}


def keep_five(data, rec, path):
    """The begin of a run, kept."""
    history, run = History(), universal_slam(data, rec)
    keeper = Checkpoint(path, data, rec, history, 5, len(run))
    for _ in range(5):
        snapshot = next(run)
        history.add(snapshot)
        keeper.add(snapshot)


def simulated(**changes):
    return UserData.from_toml(SCENARIO, {"time.last": 12, **changes})


@pytest.mark.parametrize("place", PLACES)
def test_one_byte_of_a_recording(place, tmp_path):
    """The lowest bit of its last number, which no sum and no length shows."""
    keep_five(simulated(), recording(), tmp_path / "kept")
    other = recording()
    PLACES[place](other).view(np.uint8).reshape(-1)[-8] ^= 1
    with pytest.raises(ValueError, match=WORDS.format(place.strip())):
        resume(tmp_path / "kept", simulated(), other, History())
    assert resume(tmp_path / "kept", simulated(), recording(), History())["frames"] == 5


def test_other_sensors_robots_and_frames_of_a_recording(tmp_path):
    whole = identity.of_recording(recording())
    by_event = replace(recording(), by_event=True)
    assert identity.changed(whole, identity.of_recording(by_event)) == "times of the recording"
    fewer = replace(recording(), truth={}, fixes={})
    assert identity.changed(whole, identity.of_recording(fewer)) == "truth of robot 1, fixes of robot 1"
    assert identity.changed(whole, whole) == "" and identity.changed(whole, {}).endswith(" and 5 more")


@pytest.mark.parametrize(
    ("key", "value", "what"),
    [
        ("sensor.1.range_std", 0.1 + 1e-15, "sensors of the scenario"),
        ("robot.1.v_std", 0.123, "robots of the scenario"),
        ("options.md2_threshold", 9.2, "options of the scenario"),
        ("options.engine", "plain", "options of the scenario"),
        ("time.dt", 0.30000000000000004, "time of the scenario"),
        ("world.type", "cloister", "world of the scenario"),
        ("landmark.in_map", False, "landmark of the scenario"),
    ],
)
def test_one_number_of_a_scenario(key, value, what):
    base = identity.of_scenario(simulated(**{"sensor.1.range_std": 0.1}))
    assert identity.changed(base, identity.of_scenario(simulated(**{"sensor.1.range_std": 0.1, key: value}))) == what


# --- models of the user's own ----------------------------------------------------------------------------------------

MODEL = '''
from dataclasses import dataclass
from ekfslam_tutorial.models.sensors import RangeBearing
import beside

@dataclass(frozen=True)
class MyLaser(RangeBearing):
    def project(self, p):
        y, Y_p = super().project(p)
        return y + beside.offset(), Y_p
'''  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A model in a file that imports one beside it, which imports one of a folder."""
    (tmp_path / "my_laser.py").write_text(MODEL)
    (tmp_path / "beside.py").write_text("from deeper.still import BASE\n\ndef offset():\n    return BASE + 0.0\n")
    (tmp_path / "deeper").mkdir()
    (tmp_path / "deeper" / "__init__.py").write_text("")
    (tmp_path / "deeper" / "still.py").write_text("BASE = 0.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in ("my_laser", "beside", "deeper", "deeper.still"):
        sys.modules.pop(name, None)


def fresh(folder):
    """As a new process would see the files."""
    for name in ("my_laser", "beside", "deeper", "deeper.still"):
        sys.modules.pop(name, None)
    for cache in folder.rglob("__pycache__"):
        shutil.rmtree(cache)


@pytest.mark.parametrize("name", ["my_laser.py", "beside.py", "deeper/still.py"])
def test_one_byte_of_an_own_model_is_another_run(folder, name, capsys):
    """The equation in the file given by --models, and what it imports beside it."""
    words = ["run", str(SCENARIO), "--models", str(folder / "my_laser.py"), "--set", "sensor.1.type=my_laser"]
    words += ["--out", str(folder / "out"), "--set", "time.last=12"]
    [model] = own_models(folder / "my_laser.py")
    data = UserData.from_toml(SCENARIO, {"sensor.1.type": "my_laser", "time.last": 12}, [model])
    (folder / "out").mkdir()
    keep_five(data, None, folder / "out" / "checkpoint.npz")
    text = (folder / name).read_text()
    fresh(folder)
    (folder / name).write_text(text.replace("0.0", "1.0") if "0.0" in text else text.replace("y +", "y -"))
    assert cli.main([*words, "--resume"]) == 2
    assert f"changed is: own model {Path(name).name}; resume" in capsys.readouterr().err
    fresh(folder)
    (folder / name).write_text(text)
    assert cli.main([*words, "--resume"]) == 0


def test_an_edited_model_is_another_series(folder):
    own = lambda: UserData.from_toml(SCENARIO, {"sensor.1.type": "my_laser", "time.last": 3}, own_models(file))
    file, path = folder / "my_laser.py", folder / "runs.npz"
    analysis.monte_carlo(own(), 2, path=path)
    assert len(analysis.monte_carlo(own(), 3, path=path, resume=True).runs) == 3
    fresh(folder)
    file.write_text(MODEL.replace("y +", "y -"))
    with pytest.raises(ValueError, match="another scenario, changed is: own model my_laser.py; give another folder"):
        analysis.monte_carlo(own(), 3, path=path, resume=True)


NOTEBOOK = """
from dataclasses import dataclass
import numpy as np
from ekfslam_tutorial.models.sensors import RangeBearing

GAIN, UNUSED = 1.0, 5

def helper(y):
    return GAIN * y

@dataclass(frozen=True)
class Own(RangeBearing):
    def project(self, p):
        y, Y_p = super().project(p)
        return np.array([helper(row) for row in y]), Y_p
"""


def of_notebook(text):
    """The class as a cell of a notebook defines it: there is no file."""
    space = {"__name__": "__main__"}
    exec(text, space)
    [sensor] = (s := simulated()).sensors
    return identity.of_scenario(replace(s, sensors=[replace(sensor, model=space["Own"](0.1, 0.02))]))


def test_a_model_of_a_notebook():
    """Its code, and all that it uses of the notebook; other cells, comments and lines do not count."""
    base = of_notebook(NOTEBOOK)
    for old, new in (("GAIN, UNUSED = 1.0", "GAIN, UNUSED = 1.5"), ("GAIN * y", "GAIN + y"), ("super()", "2, super()")):
        assert identity.changed(base, of_notebook(NOTEBOOK.replace(old, new))) == "own model Own", old
    for old, new in (("= 1.0, 5", "= 1.0, 6"), ("\ndef", "# a word\n\n\ndef")):
        assert of_notebook(NOTEBOOK.replace(old, new)) == base


def test_the_program_itself(monkeypatch, tmp_path):
    """The text of all that computes: an edited equation is another version, in the middle of development, too."""
    for name in identity.DECIDE:
        shutil.copytree(identity.PACKAGE / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    here = identity.program()
    monkeypatch.setattr(identity, "PACKAGE", tmp_path)
    identity.program.cache_clear()
    assert identity.program() == here
    file = tmp_path / "ekf" / "filter.py"
    file.write_text(file.read_text().replace("W @ W.T", "W @ W.t"))
    identity.program.cache_clear()
    assert identity.program() != here
    monkeypatch.undo()
    identity.program.cache_clear()


def test_a_kept_run_of_another_program(monkeypatch, tmp_path):
    keep_five(simulated(), None, tmp_path / "kept")
    monkeypatch.setattr(identity, "program", lambda: "0.1 abc")
    with pytest.raises(ValueError, match=r"is of another version of the program \(.*, not 0.1 abc\): resume with that"):
        resume(tmp_path / "kept", simulated(), None, History())


def test_the_package_is_no_model_of_a_users():
    assert not [what for what in identity.of_scenario(simulated()) if what.startswith("own model")]
    assert RangeBearing.__module__.split(".")[0] in identity.LIBRARIES
