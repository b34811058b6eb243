"""`ekfslam monte-carlo`: files that are whole, the same for any number of workers, and taken up after Ctrl-C."""

import csv
import json
import signal
import sys
from importlib import import_module

import numpy as np
import pytest

from ekfslam_tutorial.analysis import MonteCarlo, monte_carlo, series
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.graphics import monte_carlo_picture
from ekfslam_tutorial.toolbox import UserData

FILES = {"files.txt", "monte_carlo.json", "runs.csv", "over_time.csv", "monte_carlo.png", "runs.npz"}
TEXTS = "monte_carlo.json", "runs.csv", "over_time.csv"
SHORT = "--set", "time.last=10"


def ekfslam(*arguments):
    return main(["monte-carlo", *map(str, arguments)])


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_files_hold_the_figures_of_all_runs(tmp_path, capsys):
    assert ekfslam("range_bearing_2d", "--runs", 12, "--out", tmp_path, *SHORT) == 0
    out, s = capsys.readouterr(), json.loads((tmp_path / "monte_carlo.json").read_text())
    assert {p.name for p in tmp_path.iterdir()} == FILES
    assert "12 runs of 10 frames, RMSE " in out.out and "12/12" in out.err and "NEES" in out.out
    each, over = rows(tmp_path / "runs.csv"), rows(tmp_path / "over_time.csv")
    assert [row["run"] for row in each] == [str(i) for i in range(12)] and len(over) == 10
    rmse = np.array([float(row["rmse_m"]) for row in each])
    assert s["rmse_m"] == pytest.approx(np.sqrt((rmse**2).mean())) and s["complete"] and s["runs"] == 12
    assert float(over[-1]["nees"]) == pytest.approx(s["nees_last"]) and float(over[0]["band_low"]) == s["nees_band"][0]
    assert (tmp_path / "monte_carlo.png").read_bytes().startswith(b"\x89PNG")


def test_the_files_do_not_depend_on_the_number_of_workers(tmp_path):
    """A scenario of known poses: one task for each run. Two processes of their own, and none."""
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        assert ekfslam("lecture_mapping", "--runs", 5, "--workers", workers, "--out", folder, *SHORT) == 0
    for name in TEXTS:
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()
    assert json.loads((tmp_path / "1" / "monte_carlo.json").read_text())["nees_mean"] is None  # poses are known


WAITS = """
import time
from importlib import import_module

module = import_module("ekfslam_tutorial.analysis.monte_carlo")
score, before = module.score_block, iter(range(4))


def score_block(*block):
    if next(before) == 3:
        print("three runs are done", flush=True)
        time.sleep(3600)
    return score(*block)


module.score_block = score_block
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to another process")
def test_ctrl_c_keeps_what_is_done_and_resume_goes_on(tmp_path, capsys, ekfslam_process):
    """A file of the user's own makes the moment: its fourth run says that it has begun, and waits for the signal."""
    (tmp_path / "waits.py").write_text(WAITS)
    series = ["localisation_2d", "--runs", "15", "--set", "time.last=40", "--workers", "1"]
    process = ekfslam_process("monte-carlo", *series, "--out", tmp_path / "a", "--models", tmp_path / "waits.py")
    assert process.stdout.readline() == "three runs are done\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130 and "Traceback" not in err and "stopped after 3 of 15 runs" in err
    done = json.loads((tmp_path / "a" / "monte_carlo.json").read_text())
    assert done["runs"] == 3 and not done["complete"] and {p.name for p in (tmp_path / "a").iterdir()} == FILES

    assert ekfslam(*series, "--out", tmp_path / "a") == 2  # it would be overwritten
    assert "holds an unfinished series: resume it, or take another place" in capsys.readouterr().err
    assert ekfslam(*series, "--out", tmp_path / "a", "--resume") == 0
    assert ekfslam(*series, "--out", tmp_path / "b") == 0
    for name in TEXTS:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_cluster_by_its_address(tmp_path):
    distributed = pytest.importorskip("distributed", reason="the package distributed is not installed")
    cluster = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": ":0"}
    cluster["local_directory"] = str(tmp_path / "dask")
    with distributed.LocalCluster(**cluster, silence_logs=60) as local:
        address = local.scheduler_address
        assert ekfslam("range_bearing_2d", "--runs", 6, "--dask", address, "--out", tmp_path / "a", *SHORT) == 0
    assert ekfslam("range_bearing_2d", "--runs", 6, "--workers", 1, "--out", tmp_path / "b", *SHORT) == 0
    for name in TEXTS:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["range_bearing_2d", "--runs", 0], "--runs must be 1 or more, got 0"),
        (["range_bearing_2d", "--runs", 2, "--workers", 0], "--workers must be 1 or more, got 0"),
        (["range_bearin_2d", "--runs", 2], "did you mean range_bearing_2d?"),
        (["mrclam_single", "--runs", 2], "plays the data set 'mrclam': there is no chance in it, only one run"),
        (["range_bearing_2d", "--runs", 2, "--dask", "tcp://localhost:1", "--workers", 2], "--dask does not go with"),
        (["range_bearing_2d", "--runs", 2, "--set", "sensor.1.range_std=-1"], "range_std"),
    ],
)
def test_mistakes_are_one_sentence(arguments, sentence, tmp_path, capsys):
    assert ekfslam(*arguments, "--out", tmp_path) == 2
    err = capsys.readouterr().err
    assert sentence in err and err.startswith("ekfslam monte-carlo: ") and len(err.splitlines()) == 1


def test_nobody_at_the_address_is_one_sentence(tmp_path, capsys, monkeypatch):
    distributed = pytest.importorskip("distributed", reason="the package distributed is not installed")

    def client(address, timeout):
        raise OSError(f"Timed out trying to connect to {address} after {timeout}")

    monkeypatch.setattr(distributed, "Client", client)
    assert ekfslam("range_bearing_2d", "--runs", 2, "--dask", "tcp://localhost:1", "--out", tmp_path) == 2
    assert "no Dask scheduler answers at tcp://localhost:1" in capsys.readouterr().err


def test_own_models_go_to_the_workers(tmp_path):
    """A sensor of the user's own, in a file: each process loads it."""
    (tmp_path / "mine.py").write_text(
        "from dataclasses import dataclass\n"
        "from ekfslam_tutorial.models.sensors import RangeBearing\n\n\n"
        "@dataclass(frozen=True)\nclass MyLaser(RangeBearing):\n    pass\n"
    )
    arguments = ["range_bearing_2d", "--runs", 3, "--models", tmp_path / "mine.py", "--set", "sensor.1.type=my_laser"]
    assert ekfslam(*arguments, "--workers", 2, "--out", tmp_path / "a", *SHORT) == 0
    assert ekfslam("range_bearing_2d", "--runs", 3, "--workers", 1, "--out", tmp_path / "b", *SHORT) == 0
    mine, its = (series.read(tmp_path / name / "runs.npz")[2] for name in "ab")
    np.testing.assert_allclose(mine["position"], its["position"], rtol=0, atol=1e-9)  # one by one, and batched


def test_each_of_several_robots_has_a_picture(tmp_path):
    assert (
        ekfslam("two_robots_four_cameras", "--runs", 2, "--set", "time.last=5", "--out", tmp_path, "--workers", 1) == 0
    )
    wanted = FILES - {"monte_carlo.png"} | {"monte_carlo-1.png", "monte_carlo-2.png"}
    assert {p.name for p in tmp_path.iterdir()} == wanted
    assert [row["robot"] for row in rows(tmp_path / "over_time.csv")[:3]] == ["1", "2", "1"]


def test_the_picture_says_what_it_shows():
    data = UserData.from_toml(import_module("ekfslam_tutorial.cli.files").find_scenario("range_bearing_2d"))
    data.time.last = 10
    result = monte_carlo(data, 5)
    assert isinstance(result, MonteCarlo)
    fig = monte_carlo_picture(result)
    labels = [text for ax in fig.axes for text in ax.get_legend_handles_labels()[1]]
    assert "95 % band" in labels and "1σ: what the filter expects it to be" in labels and "RMSE over 5 runs" in labels
    assert [ax.get_ylabel() for ax in fig.axes] == [
        "NEES, mean of 5 runs (-)", "position error (m)", "heading error (deg)",
    ]  # fmt: skip
    (rms,) = [line for line in fig.axes[1].lines if line.get_label() == "RMSE over 5 runs"]
    np.testing.assert_allclose(rms.get_ydata(), np.sqrt((result.position**2).mean((0, 2))))
