"""A run says which of its models were computed by numpy although the steps are compiled."""

import pytest

from ekfslam_tutorial.cli import main

pytestmark = pytest.mark.usefixtures("undrawn", "interpreted")

COMPILED = ["--set", "time.last=5", "--set", "options.compiled=true"]


@pytest.mark.parametrize(
    ("scenario", "note"), [("omnicam", "computed by numpy: born: OmniCam, AhmPnt"), ("range_bearing_2d", None)]
)
def test_run_says_what_was_not_compiled(tmp_path, capsys, monkeypatch, scenario, note):
    monkeypatch.setattr("ekfslam_tutorial.fast.programs.known", {})
    assert main(["run", scenario, "--out", str(tmp_path), *COMPILED]) == 0
    told = capsys.readouterr().err
    assert "takes some seconds more" in told
    assert note in told if note else "computed by numpy" not in told


def test_nothing_is_said_of_a_run_that_is_not_compiled(tmp_path, capsys):
    assert main(["run", "omnicam", "--out", str(tmp_path), "--set", "time.last=3"]) == 0
    assert "compil" not in capsys.readouterr().err
