"""Ctrl-C in long work: one line, exit code 130, and a word on how to go on."""

import signal
import sys
import time

import pytest

from ekfslam_tutorial.cli import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one child process")


def wait_for(path, process):
    """Wait until a process has written a file, however busy the computer is."""
    while not path.exists():
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.05)


# IPython runs this file when the kernel starts: there it waits, or in the first cell.
MOMENTS = {
    "the kernel starts": "begun()",
    "a cell runs": "get_ipython().events.register('pre_run_cell', begun)",
}
BEGUN = """
def begun(*_):
    import pathlib, time
    pathlib.Path({path!r}).touch()
    time.sleep(3600)

"""


@pytest.mark.parametrize("moment", MOMENTS)
def test_slides_that_are_being_run(moment, tmp_path, ekfslam_process):
    """nbclient has another error for each moment."""
    startup, out, here = tmp_path / "profile_default" / "startup", tmp_path / "out", tmp_path / "here"
    startup.mkdir(parents=True), out.mkdir()
    (startup / "waits.py").write_text(BEGUN.format(path=str(here)) + MOMENTS[moment])
    run = ekfslam_process("lecture", "03", "--run", "--slides", out / "talk.html", IPYTHONDIR=str(tmp_path))
    wait_for(here, run)
    run.send_signal(signal.SIGINT)
    said, err = run.communicate()
    assert err.endswith("ekfslam lecture: stopped\n") and said == "" and run.returncode == 130
    assert "nbclient" not in err  # a kernel that is stopped while it starts may have its own last words
    assert not list(out.iterdir())


def test_a_run_that_is_kept_says_how_to_go_on(tmp_path, capsys, ekfslam_process):
    """The first checkpoint is the moment; without the signal the run would take minutes."""
    words = ["range_bearing_2d", "--checkpoint", "20", "--out", str(tmp_path)]
    run = ekfslam_process("run", *words, "--set", "time.last=1000000")
    wait_for(tmp_path / "checkpoint.npz", run)
    run.send_signal(signal.SIGINT)
    _, err = run.communicate()
    assert run.returncode == 130 and "--resume goes on" in err
    assert main(["run", *words, "--set", "time.last=30"]) == 0
    assert "of an earlier run is written over; --resume would go on with it" in capsys.readouterr().err
