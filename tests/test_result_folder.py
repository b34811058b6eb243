"""The folder that a command writes into: one run's files, one run at a time, whatever ends it."""

import json
import signal
import sys
import time

import psutil
import pytest

from ekfslam_tutorial.cli import main
from ekfslam_tutorial.cli.workers import Workers

unix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
LONG = "--set", "time.last=1000000"


def names(folder):
    return {path.name for path in folder.iterdir()}


def wait_for(path, process):
    while not path.exists():
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.02)


def run(out, scenario, *more):
    return main(["run", scenario, "--out", str(out), "--set", "time.last=4", *more])


def test_a_used_folder_has_no_file_of_the_run_before(tmp_path):
    """What the second run does not have is gone; what is not ours stays."""
    assert run(tmp_path, "lecture_mapping", "--record") == 0
    before = names(tmp_path)
    (tmp_path / "sensor-99.png").write_text("mine")
    (tmp_path / "mine").mkdir()
    assert run(tmp_path, "lecture_mapping") == 0
    assert before - names(tmp_path) == {"recording.npz", "estimate.rec"}
    assert names(tmp_path) - before == {"sensor-99.png", "mine"}
    assert names(tmp_path) - {"files.txt"} > set((tmp_path / "files.txt").read_text().split())


def test_a_list_of_files_reaches_into_no_other_folder(tmp_path):
    here, mine = tmp_path / "here", tmp_path / "mine.txt"
    here.mkdir(), mine.write_text("mine")
    (here / "files.txt").write_text(f"../mine.txt\n{mine}\n..\n.\n\nmap.csv\n")
    (here / "map.csv").write_text("old")
    assert run(here, "lecture_mapping") == 0
    assert mine.read_text() == "mine" and (here / "map.csv").read_text() != "old"


def test_a_folder_with_something_unfinished_of_another_command_is_not_taken(tmp_path, capsys):
    (tmp_path / "checkpoint.npz").write_bytes(b"kept")
    assert main(["monte-carlo", "lecture_mapping", "--runs", "2", "--out", str(tmp_path)]) == 2
    assert "holds a run that was kept on the way: resume it, or take another folder" in capsys.readouterr().err


@unix
def test_the_second_of_two_runs_is_told(tmp_path, capsys, ekfslam_process):
    first = ekfslam_process("run", "range_bearing_2d", "--checkpoint", 5, "--out", tmp_path, *LONG)
    wait_for(tmp_path / "checkpoint.npz", first)
    assert run(tmp_path, "lecture_mapping") == 2
    told = f"ekfslam run: another run is writing into the folder {tmp_path}: wait for it, or take another folder\n"
    assert capsys.readouterr().err == told
    assert main(["monte-carlo", "lecture_mapping", "--runs", "2", "--out", str(tmp_path)]) == 2
    first.send_signal(signal.SIGKILL)
    first.wait()
    assert not [name for name in names(tmp_path) if name.startswith(".")]  # a killed run leaves nothing hidden
    assert run(tmp_path, "lecture_mapping") == 0  # and no lock
    assert "checkpoint.npz" not in names(tmp_path)


@unix
def test_sigterm_keeps_what_ctrl_c_keeps(tmp_path, ekfslam_process):
    """A batch system sends it when the time is over."""
    words = "run", "range_bearing_2d", "--checkpoint", 5, "--out", tmp_path, *LONG
    stopped = ekfslam_process(*words)
    wait_for(tmp_path / "checkpoint.npz", stopped)
    stopped.send_signal(signal.SIGTERM)
    _, err = stopped.communicate()
    assert stopped.returncode == 130 and "--resume goes on" in err
    figures = json.loads((tmp_path / "result.json").read_text())
    assert figures["frames"] >= 5 and not figures["complete"]
    assert {"checkpoint.npz", "trajectory.csv", "map.png", "files.txt"} <= names(tmp_path)
    assert not [name for name in names(tmp_path) if name.startswith(".")]


def workers_of(series, n=1):
    """Workers of a series, as soon as there are n of them."""
    while True:
        found = psutil.Process(series.pid).children(recursive=True)
        found = [one for one in found if "spawn_main" in " ".join(one.cmdline())]
        if len(found) >= n:
            return found
        assert series.poll() is None, series.stderr.read()
        time.sleep(0.02)


@unix
def test_sigterm_keeps_the_runs_of_a_series(tmp_path, ekfslam_process):
    """Sent to the parent and to its workers; to a worker that has just begun, too, which goes on."""
    words = "monte-carlo", "lecture_mapping", "--runs", 10**4, "--workers", 2, "--out", tmp_path, "--set", "time.last=3"
    series = ekfslam_process(*words)
    for worker in workers_of(series):
        worker.send_signal(signal.SIGTERM)
    wait_for(tmp_path / "runs.npz", series)
    for worker in workers_of(series):
        worker.send_signal(signal.SIGTERM)
    series.send_signal(signal.SIGTERM)
    _, err = series.communicate()
    assert series.returncode == 130 and "--resume goes on" in err, err
    assert json.loads((tmp_path / "monte_carlo.json").read_text())["runs"] > 0


@unix
def test_a_series_whose_worker_is_killed_ends_and_says_so(tmp_path, ekfslam_process):
    """It does not wait for ever for the other worker, which takes no notice of SIGTERM."""
    words = "monte-carlo", "lecture_mapping", "--runs", 10**4, "--workers", 2, "--out", tmp_path, "--set", "time.last=3"
    series = ekfslam_process(*words)
    workers_of(series, 2)[0].kill()
    _, err = series.communicate()
    assert series.returncode == 2 and "a worker process has died" in err, err


@unix
def test_workers_that_a_pool_has_left_are_ended():
    """One that began when another died is unknown to the thread that ends the others."""
    context = Workers()
    left = context.Process(target=signal.pause)
    left.start()
    context.end()
    left.join()
    assert left.exitcode == -signal.SIGKILL
