"""The command line on a terminal of 80 columns and in a pipe: help, lists, near words, tables, bars, the Tab key."""

import json
import os
import re
import subprocess
import sys

import pytest

from ekfslam_tutorial.analysis.progress import bar
from ekfslam_tutorial.cli import main, results, terminal
from ekfslam_tutorial.cli.files import scenarios, told

COLOUR = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")


@pytest.fixture
def screen(monkeypatch):
    """A terminal of 80 columns that knows colours."""
    monkeypatch.delenv("NO_COLOR", raising=False)
    for name, value in {"TERM": "xterm-256color", "COLUMNS": "80", "FORCE_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)


# --- what is possible ---


def test_the_command_alone_shows_its_help(capsys):
    assert main([]) == 0
    out = capsys.readouterr().out
    assert out.startswith("usage: ekfslam") and all(f"    {c} " in out for c in ("run", "lab", "doctor"))
    assert max(map(len, out.splitlines())) <= 80


def test_a_run_of_nothing_lists_the_scenarios_a_line_each(capsys):
    assert main(["run"]) == 0
    *lines, last = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(scenarios())
    assert all(told(path) in line for path, line in zip(scenarios().values(), lines, strict=True))
    assert max(map(len, [*lines, last])) <= 80 and "ekfslam run range_bearing_2d" in last


@pytest.mark.parametrize("name", scenarios())
def test_a_scenario_says_in_a_phrase_what_it_is(name):
    phrase = told(scenarios()[name])
    assert 20 <= len(phrase) <= 55 and phrase[0].isupper() and not phrase.endswith((".", ",", ":"))


@pytest.mark.parametrize(
    ("words", "near"),
    [
        (["rnu"], "did you mean run?"),
        (["evalute", "x"], "did you mean evaluate?"),
        (["run", "cloister_idp", "--recrod"], "did you mean --record?"),
        (["new", "sensr", "x"], "did you mean sensor?"),
        (["data", "fetsch"], "did you mean fetch?"),
        (["run", "cloister_ipd"], "did you mean cloister_idp?"),
        (["data", "fetch", "mrclm"], "did you mean 'mrclam'?"),
        (["run", "cloister_idp", "--set", "sensor.1.type=pinhole"], "did you mean 'pin_hole'?"),
        (["run", "mrclam_single", "--set", "data.name=mrclm"], "did you mean 'mrclam'?"),
    ],
)
def test_the_nearest_word_is_named(words, near, capsys, tmp_path):
    try:
        code = main([*words, *(["--out", str(tmp_path)] if words[0] == "run" else [])])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2 and near in capsys.readouterr().err


def test_nothing_is_named_that_is_not_near(capsys):
    with pytest.raises(SystemExit):
        main(["xyzzy"])
    err = capsys.readouterr().err
    assert "did you mean" not in err and "--help" in err


def completed(line, file):
    """What the Tab key offers at the end of a line, as the shell asks for it."""
    environment = os.environ | {
        "_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line)), "_ARGCOMPLETE_STDOUT_FILENAME": str(file),
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1", "_ARGCOMPLETE_IFS": "\n", "_ARGCOMPLETE_COMP_WORDBREAKS": " ",
    }  # fmt: skip
    code = "from ekfslam_tutorial.cli import main; main()"
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    return file.read_text().split("\n")


@pytest.mark.skipif(sys.platform == "win32", reason="the shells of Windows ask in another way")
def test_the_tab_key_completes_commands_options_and_scenarios(tmp_path):
    assert completed("ekfslam ru", tmp_path / "a") == ["run"]
    assert completed("ekfslam run --rec", tmp_path / "b") == ["--recording", "--record"]
    assert completed("ekfslam run mrclam_j", tmp_path / "c") == ["mrclam_joint"]


def test_the_shell_is_told_how(capsys):
    assert main(["completion"]) == 0 and "ekfslam" in capsys.readouterr().out


# --- tables and lines ---

HEAD, ROWS = ["run", "ATE aligned m", "NEES"], [["a", "0.123", "4.1"], ["long", "10", "3"]]


def test_a_table_in_a_pipe_is_plain_text(capsys):
    terminal.table(ROWS, HEAD)
    assert capsys.readouterr().out.splitlines() == [
        "run   ATE aligned m  NEES",
        "a             0.123   4.1",
        "long             10     3",
    ]


def test_a_table_is_never_wider_than_the_terminal(screen, capsys):
    terminal.table([[f"run {k}", *["0.1234567"] * 9] for k in range(2)], ["run", *(f"figure {k}" for k in range(9))])
    lines = COLOUR.sub("", capsys.readouterr().out).splitlines()
    assert max(map(len, lines)) <= 80 and lines[0].split() == ["run", "run", "0", "run", "1"]  # turned round
    assert [line.split()[-1] for line in lines[2:]] == ["0.1234567"] * 9


def test_colours_are_for_terminals_only(screen, capsys, monkeypatch):
    terminal.say("text", "bold")
    assert "\x1b[1mtext" in capsys.readouterr().out
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("FORCE_COLOR")
    terminal.say("text", "green")
    assert "\x1b[32m" not in capsys.readouterr().out


FIGURES = {
    "scenario": "s", "frames": 9, "n_landmarks": 3, "n_landmarks_refused": 0, "wall_s": 1.0, "ate_rmse_m": 0.1234,
    "dead_reckoning_ate_m": None, "heading_rmse_deg": None, "landmark_rmse_m": 0.5, "nees_mean": 4.0, "nees_dof": 3,
    "nis_mean": 1.9, "nis_dof": 2.0,
}  # fmt: skip


def test_a_figure_has_a_line_with_what_was_expected_beside_it(capsys):
    results.tell(FIGURES | {"dead_reckoning_ate_m": 0.7})
    first, *lines = capsys.readouterr().out.splitlines()
    assert first == "s: 9 frames, 3 landmarks, 1.00 s"
    assert [re.split(r"  +", line.strip()) for line in lines] == [
        ["position error (ATE)", "0.123 m", "dead reckoning: 0.7 m"],
        ["landmark error", "0.5 m"],
        ["NEES of the pose", "4", "expected: 3"],
        ["NIS", "1.9", "expected: 2"],
    ]


def test_the_nees_says_what_it_is_of(capsys):
    results.tell(FIGURES | {"nees_of": "position and velocity"})
    assert "NEES of the position and velocity" in capsys.readouterr().out


def test_fixes_in_a_frame_of_their_own_are_judged_after_alignment(capsys):
    results.tell(FIGURES | {"gps_rmse_best95_m": 1110.0, "gps_rmse_best95_aligned_m": 0.0434})
    assert "1.11e+03 m  aligned: 0.0434 m" in capsys.readouterr().out


def test_what_is_not_known_is_not_told(capsys):
    results.tell(FIGURES)
    assert "dead reckoning" not in (out := capsys.readouterr().out) and "heading" not in out


# --- bars ---


def test_a_bar_in_a_pipe_is_one_line_at_the_end(capsys):
    with bar(3, "frames") as done:
        for _ in range(2):
            done.update()
    assert capsys.readouterr().err == "frames: 2/3\n"


def test_a_bar_that_is_not_shown_counts(capsys):
    with bar(3, "frames", done=1, shown=False) as done:
        done.update()
        done.tell("more")
    assert done.n == 2 and capsys.readouterr().err == ""


def test_a_bar_on_a_terminal_fits_and_is_drawn_to_its_end(monkeypatch, capsys):
    for name, value in {"TERM": "xterm-256color", "COLUMNS": "80", "FORCE_COLOR": "1"}.items():
        monkeypatch.setenv(name, value)
    with bar(2000, "frames") as done:
        for _ in range(2000):
            done.update()
    drawn = [line.strip() for line in re.split(r"[\r\n]", COLOUR.sub("", capsys.readouterr().err)) if line.strip()]
    assert "2000/2000" in drawn[-1] and max(map(len, drawn)) <= 80 and len(drawn) < 20


def test_drawing_has_a_bar_too(tmp_path, capsys):
    assert main(["run", "range_bearing_2d", "--out", str(tmp_path), "--set", "time.last=3"]) == 0
    drawn = len(list(tmp_path.glob("*.png")))
    assert f"pictures: {drawn}/{drawn}\n" in capsys.readouterr().err
    assert json.loads((tmp_path / "result.json").read_text())["frames"] == 3
