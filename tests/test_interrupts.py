"""Ctrl-C in long work: one line, exit code 130, and a word on how to go on."""

import signal
import subprocess
import sys
import time

import psutil
import pytest

from ekfslam_tutorial.cli import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child process")


def started(*words):
    command = [sys.executable, "-m", "ekfslam_tutorial", *map(str, words)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def wait_until(true, seconds=60):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not come so far"
        time.sleep(0.05)


def test_slides_that_are_being_run(tmp_path):
    target = tmp_path / "talk.html"
    run = started("lecture", "03", "--run", "--slides", target)
    wait_until(lambda: psutil.Process(run.pid).children())
    time.sleep(2)  # the kernel starts, or a cell runs: nbclient has another error for each
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    assert err.endswith("ekfslam lecture: stopped\n") and out == "" and run.returncode == 130
    assert "nbclient" not in err  # a kernel that is stopped while it starts may have its own last words
    assert not list(tmp_path.iterdir())


def test_a_run_that_is_kept_says_how_to_go_on(tmp_path, capsys):
    words = ["run", "range_bearing_2d", "--set", "time.last=100000", "--checkpoint", "20", "--out", str(tmp_path)]
    run = started(*words)
    wait_until((tmp_path / "checkpoint.npz").exists)
    run.send_signal(signal.SIGINT)
    _, err = run.communicate(timeout=60)
    assert run.returncode == 130 and "--resume goes on" in err
    assert main(["run", "range_bearing_2d", "--set", "time.last=30", "--checkpoint", "20", "--out", str(tmp_path)]) == 0
    assert "of an earlier run is written over; --resume would go on with it" in capsys.readouterr().err
