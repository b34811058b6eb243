"""The command line: every scenario runs, results are whole and repeatable, mistakes are told before the run."""

import csv
import importlib.metadata
import importlib.util
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from ekfslam_tutorial.cli import doctor, main, robot_views, views
from ekfslam_tutorial.cli import run as run_command
from ekfslam_tutorial.cli.files import file_name, find_scenario, replacing, save_figure, scenarios, shipped
from ekfslam_tutorial.cli.notebooks import GIVEN
from ekfslam_tutorial.cli.templates import motion as new_motion
from ekfslam_tutorial.cli.templates import sensor as new_sensor
from ekfslam_tutorial.fast.symbols import Symbol, Tape
from ekfslam_tutorial.toolbox import Recording, UserData, universal_slam

pytestmark = pytest.mark.usefixtures("undrawn")
PNG = b"\x89PNG\r\n\x1a\n"
FIGURES = {
    "scenario", "seed", "engine", "frames", "n_landmarks", "n_landmarks_refused", "ate_rmse_m", "heading_rmse_deg",
    "landmark_rmse_m", "dead_reckoning_ate_m", "nees_mean", "nis_mean", "wall_s", "robots",
}  # fmt: skip
EACH = FIGURES - {"scenario", "seed", "engine", "frames", "n_landmarks_refused", "wall_s", "robots"}


def ekfslam(*arguments):
    return main([str(a) for a in arguments])


def result(folder):
    return json.loads((folder / "result.json").read_text())


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


# --- threads of the linear algebra ------------------------------------------------------------------------------------


def blas_threads():
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.mark.parametrize(("words", "n"), [([], 1), (["--threads", "2"], 2)])
def test_a_run_limits_its_linear_algebra_says_so_and_leaves_no_limit(words, n, tmp_path, capsys, monkeypatch):
    during, before, environment = [], blas_threads(), dict(os.environ)

    def watched(*arguments, **named):
        during.append(blas_threads())
        return universal_slam(*arguments, **named)

    monkeypatch.setattr(run_command, "universal_slam", watched)
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path, "--set", "time.last=3", *words) == 0
    assert during == [{n}] and blas_threads() == before and dict(os.environ) == environment
    assert f"linear algebra on {n} thread" in capsys.readouterr().err


@pytest.mark.parametrize("n", ["0", "-1", "two"])
def test_a_number_of_threads_is_a_number(n, capsys):
    with pytest.raises(SystemExit) as stopped:
        ekfslam("run", "range_bearing_2d", f"--threads={n}")
    assert stopped.value.code == 2 and f"1 or more, got '{n}'" in capsys.readouterr().err


# --- run -------------------------------------------------------------------------------------------------------------


OF_EACH_KIND = {
    "range_bearing_2d", "cloister_idp", "euroc_v101", "gps_compass", "house_idp", "lecture_mapping", "mrclam_single",
    "plaza", "two_robots_four_cameras",
}  # fmt: skip
"""Robots in the plane and in space, alone and several, with an IMU, in a map that is aligned, at places that are given:
their pictures are drawn. Those of the map and of the sensors are drawn for all."""


@pytest.mark.parametrize("name", [name for name in scenarios() if name != "monoslam_desk"])  # tests/images runs it
def test_every_scenario_that_comes_with_the_package_runs(name, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(views, "save_figure", save_figure)
    if name in OF_EACH_KIND:
        monkeypatch.setattr(robot_views, "save_figure", save_figure)
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    # A beacon is born when enough places have told where on its ring it is; its ranges scatter by 0.6 m.
    # The robot with the IMU stands for a second: its path cannot be laid on the truth before it moves.
    last, far = {"plaza": (150, 1.0), "euroc_v101": (60, 0.5)}.get(name, (15, 0.5))
    assert ekfslam("run", name, "--out", tmp_path, "--set", f"time.last={last}") == 0
    figures, out = result(tmp_path), capsys.readouterr()
    data = UserData.from_toml(find_scenario(name))
    assert FIGURES <= set(figures) and figures["frames"] == last and figures["complete"]
    assert figures["robots"] and all(EACH <= set(each) for each in figures["robots"].values())
    assert figures["ate_rmse_m"] < far and figures["n_landmarks"] > 0
    assert f"{last} frames" in out.out and f"{last}/{last}" in out.err  # the sentence, and the progress bar
    drawn = [s for s in data.sensors if data.data is None and not hasattr(s.model, "without_lmks")]
    pictures = ("map.png", *(f"sensor-{s.id}.png" for s in drawn))
    for path in tmp_path.glob("*.png") if name in OF_EACH_KIND else map(tmp_path.joinpath, pictures):
        assert path.read_bytes().startswith(PNG)
    assert all((tmp_path / file).exists() for file in pictures)
    assert len(rows(tmp_path / "trajectory.csv")) == last * len(figures["robots"])
    mapped = [file for file in ("map.csv", "lines.csv") if (tmp_path / file).exists()]
    assert sum(len(rows(tmp_path / file)) for file in mapped) == figures["n_landmarks"]
    assert sorted(p.name for p in tmp_path.iterdir() if p.name.startswith(".")) == []  # no temporary files


def test_tables_hold_estimates_truths_and_uncertainties(tmp_path):
    ekfslam("run", "two_robots_four_cameras", "--out", tmp_path, "--set", "time.last=20")
    path, places = rows(tmp_path / "trajectory.csv"), rows(tmp_path / "map.csv")
    number = lambda table, *names: np.array([[float(row[n]) for n in names] for row in table])
    assert [(r["frame"], r["robot"]) for r in path[:4]] == [("1", "1"), ("1", "2"), ("2", "1"), ("2", "2")]
    error = number(path, "x", "y", "z") - number(path, "true_x", "true_y", "true_z")
    ate = np.sqrt((error**2).sum(1).mean())
    assert ate == pytest.approx(result(tmp_path)["ate_rmse_m"], rel=1e-9)
    assert (np.abs(error) < 5 * number(path, "std_x", "std_y", "std_z")).all()
    p, true = number(places, "x", "y", "z"), number(places, "true_x", "true_y", "true_z")
    P = number(places, "P_xx", "P_xy", "P_xz", "P_xy", "P_yy", "P_yz", "P_xz", "P_yz", "P_zz").reshape(-1, 3, 3)
    assert (np.linalg.eigvalsh(P)[:, 0] > 0).all() and np.median(np.linalg.norm(p - true, axis=1)) < 0.5
    assert {row["type"] for row in places} <= {"IdpPnt", "EucPnt"}


def test_the_same_seed_gives_the_same_files(tmp_path, monkeypatch):
    monkeypatch.setattr(views, "save_figure", save_figure)
    a, b, c = (tmp_path / name for name in "abc")
    for folder, seed in ((a, 5), (b, 5), (c, 6)):
        ekfslam("run", "range_bearing_2d", "--out", folder, "--set", "time.last=30", "--seed", seed)
    same = lambda x, y, file: (x / file).read_bytes() == (y / file).read_bytes()
    for file in ("trajectory.csv", "map.csv", "map.png", "sensor-1.png"):
        assert same(a, b, file) and not same(a, c, file)
    figures = [
        {k: v for k, v in result(folder).items() if k not in ("wall_s", "cpu_s", "frames_per_s")} for folder in (a, b)
    ]
    assert figures[0] == figures[1] and figures[0]["seed"] == 5


@pytest.mark.parametrize(
    ("words", "ran"),
    [
        ([], "fast"),
        (["--set", "options.engine=plain"], "plain"),
        (["--set", "options.engine=fast", "--set", "options.compressed=true"], "fast, compressed"),
    ],
)
def test_a_run_says_which_engine_computed_it(words, ran, tmp_path, capsys):
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path, "--set", "time.last=3", *words) == 0
    assert result(tmp_path)["engine"] == ran
    assert f"engine: {ran}" in capsys.readouterr().err.splitlines()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--set", "options.engine=quick"], "engine must be 'plain' or 'fast', got 'quick'"),
        (
            ["--set", "options.engine=plain", "--set", "options.compressed=true"],
            "compressed is an option of the engine",
        ),
    ],
)
def test_an_engine_that_cannot_be_is_refused_before_the_run(words, message, tmp_path, capsys):
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path / "out", *words) == 2
    err = capsys.readouterr().err
    assert message in err and "Traceback" not in err and not (tmp_path / "out").exists()


def test_a_recorded_run_is_played_again(tmp_path):
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path / "a", "--set", "time.last=30", "--record") == 0
    log = tmp_path / "a" / "recording.npz"
    assert len(Recording.load(log)) == 30
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path / "b", "--recording", log) == 0
    assert (tmp_path / "a" / "map.csv").read_bytes() == (tmp_path / "b" / "map.csv").read_bytes()
    assert result(tmp_path / "b")["recording"] == "range_bearing_2d"


def test_missing_data_are_replaced_by_their_twin_which_says_so(tmp_path, capsys, monkeypatch):
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    assert ekfslam("run", "data/scenarios/mrclam_single.toml", "--out", tmp_path, "--set", "time.last=40") == 0
    assert "MRCLAM set 9 is not found" in (said := capsys.readouterr().err) and "twin" in said
    assert any("twin" in note for note in result(tmp_path)["notes"])


def test_changes_reach_the_run(tmp_path):
    few = ["--set", "time.last=12", "--set", "options.max_lmks=3"]
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path, *few) == 0
    assert result(tmp_path)["n_landmarks"] == 3 and result(tmp_path)["n_landmarks_refused"] >= 1


def test_a_movie_is_made(tmp_path):
    short = ["--set", "time.last=4", "--set", "figure.period=2", "--set", "figure.orbit_deg=5"]
    assert ekfslam("run", "cloister_idp", "--out", tmp_path, "--movie", *short) == 0
    (movie,) = tmp_path.glob("movie.*")
    assert movie.stat().st_size > 10_000


def test_results_go_to_a_folder_named_after_the_scenario(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert ekfslam("run", "lecture_mapping", "--set", "time.last=2") == 0
    assert (tmp_path / "results" / "lecture_mapping" / "result.json").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["cloister_idq"], "no scenario file cloister_idq; known names: .*did you mean cloister_idp"),
        (["cloister_idp", "--set", "foo"], "--set 'foo': write KEY=VALUE"),
        (["cloister_idp", "--set", "robot.1.dxx=3"], r"cloister_idp\.toml: robot 1: unknown key 'dxx'"),
        (["cloister_idp", "--set", "landmark.type=euc_pnt"], "EucPnt landmarks cannot be started by a PinHole"),
        (["cloister_idp", "--seed", "-3"], "seed must be a whole number, 0 or more"),
        (["cloister_idp", "--recording", "none.npz"], r"no recording at none\.npz"),
        (["cloister_idp", "--models", "none.py"], r"no Python file none\.py"),
        (["mrclam_single", "--set", "data.robots=[9]"], "robots must be some of"),
        (["mrclam_single", "--set", "data.nam=9"], "unknown key 'nam'"),
        (["cloister_idp", "--live"], "--live needs a display"),
    ],
)
def test_mistakes_are_told_in_one_sentence_before_the_run(arguments, message, tmp_path, capsys):
    assert ekfslam("run", *arguments, "--out", tmp_path) == 2
    out = capsys.readouterr()

    assert re.search(message, out.err) and "frames" not in out.err and out.out == ""
    assert len(out.err.strip().splitlines()) <= 1 + ("mrclam" in arguments[0])
    assert not (tmp_path / "result.json").exists()


def test_a_folder_that_cannot_be_written_is_told_before_the_run(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        assert ekfslam("run", "cloister_idp", "--out", folder) == 2
        assert f"cannot write into the folder {folder}: " in (said := capsys.readouterr().err) and "/200" not in said


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child process")
def test_ctrl_c_writes_what_there_is(tmp_path, ekfslam_process):
    words = ["range_bearing_2d", "--out", tmp_path, "--set", "time.last=1000000", "--checkpoint", "20"]
    run = ekfslam_process("run", *words)
    while not (tmp_path / "checkpoint.npz").exists():  # some frames are done, most are not
        assert run.poll() is None, run.stderr.read()
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate()
    figures = result(tmp_path)
    assert run.returncode == 130 and "stopped after" in err and "written to" in out
    assert 0 < figures["frames"] < figures["frames_wanted"] == 1_000_000 and not figures["complete"]
    assert len(rows(tmp_path / "trajectory.csv")) == figures["frames"]
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)


def test_files_appear_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), replacing(path) as part:
        part.write_text("half of the n")
        raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]
    with replacing(path) as part:
        part.write_text("new")
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


# --- the other commands ----------------------------------------------------------------------------------------------


def test_version():
    out = subprocess.run([sys.executable, "-m", "ekfslam_tutorial", "--version"], capture_output=True, text=True)
    assert out.stdout.startswith("ekfslam 0.")


def test_new_models_pass_their_own_tests_and_run_in_a_scenario(tmp_path, capsys):
    kinds = {"sensor": "MySonar", "landmark": "MyPoint", "motion": "MyCart"}
    files = {kind: tmp_path / f"my_{name[2:].lower()}.py" for kind, name in kinds.items()}
    for kind, name in kinds.items():
        assert ekfslam("new", kind, name, "--dir", tmp_path) == 0
        assert f"class {name}" in (text := files[kind].read_text()) and "New" not in text
    words = [sys.executable, "-m", "pytest", "-q", "-rA", "-p", "no:cacheprovider", "."]
    test = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert test.returncode == 0, test.stdout
    assert all(f"PASSED test_{file.name}" in test.stdout for file in files.values()), test.stdout
    for kind, file in files.items():
        before = file.read_bytes()
        assert ekfslam("new", kind, file.stem, "--dir", tmp_path) == 2
        assert "is there already, and nothing is overwritten" in capsys.readouterr().err
        assert file.read_bytes() == before


def test_a_new_model_can_be_called_with_symbols_and_so_be_compiled():
    tape = Tape()
    p, x, u = tape.inputs("p[{}]", 2)[None], tape.inputs("x[{}]", 3)[None], tape.inputs("u[{}]", 2)[None]
    y, Y_p = new_sensor.NewSensor().project(p)
    assert isinstance(Y_p[0, 1, 1], Symbol) and isinstance(new_sensor.NewSensor().visible(y, p)[0], Symbol)
    assert isinstance(new_sensor.NewSensor().retro(y)[1][0, 1, 1], Symbol)
    assert isinstance(new_motion.NewMotion().move(x, u, tape.note("dt"))[1][0, 1, 2], Symbol)


def test_a_bare_model_stops_where_code_is_needed(tmp_path):
    for kind, method in (("sensor", "project"), ("landmark", "to_frame"), ("motion", "move")):
        assert ekfslam("new", kind, f"my_{kind}", "--dir", tmp_path, "--bare") == 0
        text = (tmp_path / f"my_{kind}.py").read_text()
        assert (
            text.count("raise NotImplementedError") == text.count("    def ") and "return" not in text.split("def ")[-1]
        )
        space = {"__name__": "mine"}
        exec(compile(text, kind, "exec"), space)
        with pytest.raises(NotImplementedError, match=f"{method}: your code here"):
            getattr(space[f"My{kind.capitalize()}"](), method)(
                *[None] * text.split(f"def {method}(")[1].split(")")[0].count(",")
            )


def test_a_model_of_ones_own_runs_from_the_command_line(tmp_path):
    ekfslam("new", "landmark", "my_point", "--dir", tmp_path)
    own = ["--models", tmp_path / "my_point.py", "--set", "landmark.type=my_point", "--set", "time.last=10"]
    assert ekfslam("run", "range_bearing_2d", "--out", tmp_path / "out", *own) == 0
    assert {row["type"] for row in rows(tmp_path / "out" / "map.csv")} == {"MyPoint"}


@pytest.mark.parametrize("name", ["3x", "class", "a-b", "", "ünder", "a b", "../x"])
def test_names_that_are_none_are_refused(name, tmp_path, capsys):
    assert ekfslam("new", "sensor", name, "--dir", tmp_path) == 2
    assert "is no name for a model" in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_names_of_the_package_are_not_taken_again(tmp_path, capsys):
    assert ekfslam("new", "sensor", "PinHole", "--dir", tmp_path) == 2
    assert "the package has a sensor 'pin_hole' already" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["numpy", "Pytest", "random"])
def test_a_model_does_not_hide_a_module_that_others_import(name, tmp_path, capsys):
    assert ekfslam("new", "sensor", name, "--dir", tmp_path) == 2
    assert f"{name.lower()}.py would hide the module" in capsys.readouterr().err and list(tmp_path.iterdir()) == []


def test_broken_models_are_told_with_their_error(tmp_path, capsys):
    (tmp_path / "bad.py").write_text("import nothing_like_this\n")
    assert ekfslam("run", "range_bearing_2d", "--models", tmp_path / "bad.py", "--out", tmp_path) == 2
    assert "bad.py cannot be loaded: ModuleNotFoundError" in capsys.readouterr().err


OWN = """
import numpy as np
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing

class MySonar(RangeBearing):
    def {method}(self, {arguments}):
        {body}

class Wagon(Unicycle):
    def move(self, x, u, dt):
        {move}
        return super().move(x, u, dt)
"""
SCENARIO = """
[world]
type = "lecture"
[[robot]]
motion = "wagon"
v = 1.0
[[sensor]]
type = "my_sonar"
range_std = 0.1
bearing_std_deg = 1
"""


@pytest.fixture
def run_own(tmp_path):
    """Run a scenario with a sensor, one of whose methods has this body, and a motion with a line more."""

    def run(method, arguments, body, move="pass", command=("run",), more=()):
        (tmp_path / "own.py").write_text(
            OWN.format(method=method, arguments=arguments, body=body, move=move), encoding="utf-8"
        )
        (tmp_path / "mine.toml").write_text(SCENARIO, encoding="utf-8")
        return ekfslam(
            *(command[0], tmp_path / "mine.toml", "--models", tmp_path / "own.py", "--out", tmp_path / "out"),
            *(*command[1:], "--set", "time.last=5", *more),
        )

    return run


FINE = ("visible", "y, p", "return y[..., 0] < 9")
ASKS = "; does each model of your own pass its test? EKFSLAM_TRACEBACK=1 shows where"


@pytest.mark.parametrize("engine", ["plain", "fast"])
@pytest.mark.parametrize(
    "given, said",
    [
        (
            ("visible", "y, p", "return y.nothing"),
            "MySonar.visible stops with AttributeError: .* no attribute 'nothing'",
        ),
        (
            ("residual", "y, e", "return y[..., [0, 5]] - e"),
            "MySonar.residual stops with IndexError: index 5 is out of",
        ),
        (("project", "p", "return p + None"), "MySonar.project stops with TypeError: unsupported operand"),
        (("retro", "y", "return {}[2]"), "MySonar.retro stops with KeyError: 2"),
        (("retro", "y", "raise NotImplementedError"), "MySonar.retro stops with NotImplementedError"),
        (("retro", "y", "return np.reshape(y, 17)"), "MySonar.retro stops with ValueError: cannot reshape array"),
        ((*FINE, "a, b = x"), "Wagon.move stops with ValueError: too many values to unpack"),
    ],
)
def test_an_error_inside_a_model_of_ones_own_is_one_sentence_that_names_it(given, said, engine, run_own, capsys):
    assert run_own(*given, more=("--set", f"options.engine={engine}")) == 2
    (line,) = (t for t in capsys.readouterr().err.splitlines() if t.startswith("ekfslam run: "))
    assert re.match(f"ekfslam run: {said}", line) and line.endswith(ASKS)


def test_with_many_seeds_too(run_own, capsys):
    many = ("monte-carlo", "--runs", "2", "--workers", "1")
    assert run_own("project", "p", "return p + None", command=many) == 2
    assert "ekfslam monte-carlo: MySonar.project stops with TypeError: " in capsys.readouterr().err


def test_a_mistake_of_the_package_shows_its_traceback_though_there_are_models(run_own, monkeypatch):
    def broken(*_):
        raise TypeError("of the package")

    monkeypatch.setattr(run_command.results, "summary", broken)
    with pytest.raises(TypeError, match="^of the package\n") as raised:
        run_own(*FINE)
    assert raised.value.__notes__ == ["models of your own are in use: does each pass its test?"]


def test_the_traceback_of_a_model_is_there_for_those_who_ask(run_own, monkeypatch):
    monkeypatch.setenv("EKFSLAM_TRACEBACK", "1")
    with pytest.raises(ValueError, match="MySonar.project") as raised:
        run_own("project", "p", "return p + None")
    assert isinstance(raised.value.__cause__, TypeError)


def test_a_model_that_lacks_a_method_is_refused_before_the_run(tmp_path, capsys):
    (tmp_path / "mine.toml").write_text(SCENARIO.replace("wagon", "unicycle").split("range_std")[0])
    (tmp_path / "own.py").write_text(
        "class MySonar:\n    R, bearing_only = [[1.0]], False\n    def project(self, p): ...\n"
    )
    assert ekfslam("run", tmp_path / "mine.toml", "--models", tmp_path / "own.py", "--out", tmp_path / "out") == 2
    said = "ekfslam run: mine.toml: sensor 1: MySonar has no method residual, no method visible; a sensor has R, "
    assert capsys.readouterr().err.startswith(said) and not (tmp_path / "out").exists()


def test_notebooks_are_copied_and_work_is_never_overwritten(tmp_path, capsys):
    mine = tmp_path / "course"
    assert ekfslam("notebooks", mine) == 0
    hidden = mine / GIVEN
    there = sorted(p.relative_to(mine) for p in mine.rglob("*.ipynb") if hidden not in p.parents)
    assert there == sorted(p.relative_to(shipped("notebooks")) for p in shipped("notebooks").rglob("*.ipynb")
                           if not any(part.startswith(".") for part in p.parts))  # fmt: skip
    first = mine / there[0]
    first.write_text("my work")
    (mine / there[-1]).unlink() if len(there) > 1 else None
    assert ekfslam("notebooks", mine) == 0
    assert first.read_text() == "my work" and (mine / there[-1]).exists()
    assert f"kept: {first}" in capsys.readouterr().err
    assert ekfslam("notebooks", shipped("notebooks")) == 2
    assert "is where the notebooks come from" in capsys.readouterr().err


def test_the_copies_have_no_outputs_and_say_the_same(tmp_path):
    assert ekfslam("notebooks", tmp_path) == 0
    for path in sorted(shipped("notebooks").glob("*.ipynb")):
        theirs, mine = (json.loads((folder / path.name).read_text("utf-8")) for folder in (path.parent, tmp_path))
        assert any(cell.get("outputs") for cell in theirs["cells"])
        for a, b in zip(theirs["cells"], mine["cells"], strict=True):
            assert "".join(a["source"]) == "".join(b["source"]) and a["id"] == b["id"]
            assert a["metadata"].get("tags") == b["metadata"].get("tags")
            assert b.get("outputs", []) == [] and b.get("execution_count") is None


def test_a_copy_that_was_run_or_changed_stays_and_only_a_changed_one_is_named(tmp_path, capsys):
    assert ekfslam("notebooks", tmp_path) == 0
    ran, changed, *_ = sorted(tmp_path.glob("*.ipynb"))
    shutil.copy(shipped("notebooks") / ran.name, ran)  # with outputs: as a student has run it
    notebook = json.loads(changed.read_text("utf-8"))
    notebook["cells"][-1]["source"] = "my own words"
    changed.write_text(json.dumps(notebook), "utf-8")
    before = ran.read_bytes(), changed.read_bytes()
    capsys.readouterr()
    assert ekfslam("notebooks", tmp_path) == 0
    assert (ran.read_bytes(), changed.read_bytes()) == before
    said = capsys.readouterr()
    assert "0 files copied" in said.out and f"kept: {changed}" in said.err and str(ran) not in said.err


def test_doctor_finds_this_environment_well(capsys):
    assert ekfslam("doctor") == 0, capsys.readouterr().out
    assert "all is well" in capsys.readouterr().out


def test_doctor_has_a_cure_of_one_line_for_each_problem(monkeypatch, capsys, tmp_path):
    def version(name):
        if name == "ipywidgets":
            raise doctor.importlib.metadata.PackageNotFoundError(name)
        return "1.25.3" if name == "numpy" else "99.0"

    monkeypatch.setattr(doctor.importlib.metadata, "version", version)
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    monkeypatch.setenv("EKFSLAM_DATA", str(tmp_path / "gone"))
    assert ekfslam("doctor") == 1
    out = capsys.readouterr().out.splitlines()
    problems = [i for i, line in enumerate(out) if line.startswith("PROBLEM")]
    assert {out[i].split()[1] for i in problems} == {"numpy", "ipywidgets", "kernel", "widgets", "data"}
    assert all("cure: " in out[i + 1] for i in problems) and out[-1] == "5 problems"
    assert "1.25.3, older than 1.26" in "\n".join(out)


def test_doctor_says_whether_steps_can_be_compiled(monkeypatch, tmp_path):
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path))
    if importlib.util.find_spec("numba"):
        found, cure = doctor.compiled()[1:]
        assert (tmp_path / "compiled").is_dir() and str(tmp_path / "compiled") in found and cure == ""
        assert importlib.metadata.version("numba") in found

        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        (tmp_path / "a file").write_text("")
        monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path / "a file"))  # no folder can be made in it
        assert "EKFSLAM_CACHE" in doctor.compiled()[2]

        monkeypatch.setattr(importlib.metadata, "version", lambda name: "0.1")
        assert "older than" in doctor.compiled()[1] and "[compiled]" in doctor.compiled()[2]
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    found, cure = doctor.compiled()[1:]
    assert "ekfslam_tutorial[compiled]" in found and cure == ""


def test_doctor_asks_for_the_numba_of_the_extra():
    file = Path(__file__).resolve().parents[1] / "pyproject.toml"
    project = tomllib.loads(file.read_text(encoding="utf-8"))["project"]
    (asked,) = project["optional-dependencies"]["compiled"]
    assert asked.startswith(f"numba>={doctor.NUMBA};")


def test_progress_lists_the_exercises(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("EKFSLAM_PROGRESS", str(tmp_path / "progress.json"))
    assert ekfslam("progress") == 0
    assert "exercises passed" in capsys.readouterr().out
    assert ekfslam("progress", "02") == 0 and "02.1" in capsys.readouterr().out
    assert ekfslam("progress", "2") == 0 and "02.1" in capsys.readouterr().out
    assert ekfslam("progress", "77") == 2 and "no exercises of a notebook '77'" in capsys.readouterr().err


def test_data_tells_where_to_get_what_is_missing(capsys, monkeypatch):
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    assert ekfslam("data", "--quick") == 0
    assert "mrclam" in (out := capsys.readouterr().out) and "not found" in out and "http" in out


def test_a_reader_that_goes_away_is_no_error():
    command = f"{shlex.quote(sys.executable)} -m ekfslam_tutorial doctor | head -1"
    out = subprocess.run(command, shell=True, capture_output=True, text=True)
    assert out.stdout.startswith("ok") and "Traceback" not in out.stderr and "pipe" not in out.stderr.lower()


def test_shipped_files_are_found(tmp_path):
    assert {"range_bearing_2d", "cloister_idp", "two_robots_four_cameras"} <= set(scenarios())
    assert find_scenario("anywhere/cloister_idp.toml") == scenarios()["cloister_idp"]
    assert Path(find_scenario(scenarios()["cloister_idp"])) == scenarios()["cloister_idp"]
    assert find_scenario("monoslam") == scenarios()["monoslam_desk"]  # no other name begins so
    with pytest.raises(FileNotFoundError, match="no scenario file cloister; known names"):
        find_scenario("cloister")
    (tmp_path / "cloister_idp").mkdir()  # of results: not the scenario of that name
    with pytest.raises(FileNotFoundError, match="cloister_idp is a folder; give the scenario that it was made with"):
        find_scenario(tmp_path / "cloister_idp")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("cloister_idp", "cloister_idp"),
        ("../../etc", "etc"),
        ("/a b\\c", "a_b_c"),
        ("Zürich 1.5", "Zürich_1.5"),
        ("..", "unnamed"),
    ],
)
def test_a_scenarios_name_never_leads_out_of_the_results(name, expected):
    assert file_name(name) == expected


def test_a_live_view_draws_every_frame_asked_for(monkeypatch):
    drawn = []
    monkeypatch.setattr(views.plt, "pause", drawn.append)
    monkeypatch.setattr(views.plt, "show", lambda block: drawn.append(block))
    data = UserData.from_toml(find_scenario("cloister_idp"), {"time.last": 5, "figure.period": 2, "figure.view": "top"})
    before = views.plt.get_fignums()
    with views.Live(data.figure) as live:
        for snapshot in universal_slam(data):
            live.add(snapshot)
        assert len(live.figures) == 2
    assert drawn == [0.001, 0.001, 0.001, True] and views.plt.get_fignums() == before


def test_known_landmarks_that_nobody_has_seen_are_no_false_ones(tmp_path, capsys):
    """With unknown ids a note is on landmarks that were measured once only; those of a known map have not begun."""
    words = "--set", "options.association=nearest_neighbour", "--set", "time.last=8", "--out", str(tmp_path)
    assert main(["run", "localisation_2d", *words]) == 0
    assert "measured once only" not in capsys.readouterr().err
    assert json.loads((tmp_path / "result.json").read_text())["n_seen_once"] == 0
