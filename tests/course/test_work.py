"""A student's work goes from a browser to another computer: what is packed, what is taken up, what is refused."""

import json
import zipfile

import pytest

from ekfslam_tutorial.course import logbook, work
from ekfslam_tutorial.course.keep import VARIABLE

SLAM = "def wrap(angle):\n    return angle\n"


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """An empty folder to work in, with files of its own for the functions and the progress."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "my_slam.py"))
    monkeypatch.setenv(logbook.VARIABLE, str(tmp_path / "home" / "progress.json"))
    return tmp_path


def pack(path, **files):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in files.items():
            file.writestr(name.replace("__", "/").replace("_DOT_", "."), text)


def test_what_is_taken_home_is_taken_up_elsewhere(desk, capsys):
    (desk / "my_slam.py").write_text(SLAM)
    logbook.attempt("02.1", passed=True)
    work.take_home()
    assert 'take_home("my_work.zip")' in capsys.readouterr().out and not (desk / "my_work.zip").exists()
    work.take_home("my_work.zip")
    assert "written: my_work.zip" in capsys.readouterr().out
    (desk / "my_slam.py").unlink()
    logbook.path().unlink()

    work.take_up()
    assert (desk / "my_slam.py").read_text() == SLAM
    assert logbook.read()["02.1"]["passed"]
    assert "my_slam.py" in capsys.readouterr().out


def test_an_empty_desk_packs_nothing(desk, capsys):
    work.take_home("my_work.zip")
    work.take_up()
    assert "nothing" in capsys.readouterr().out


def test_notebooks_come_to_their_places(desk):
    pack("my_work.zip", **{"00_start_here_DOT_ipynb": "{}", "scenarios__mine_DOT_toml": "a = 1"})
    work.take_up()
    assert (desk / "00_start_here.ipynb").read_text() == "{}"
    assert (desk / "scenarios" / "mine.toml").read_text() == "a = 1"


def test_what_has_passed_stays_passed(desk):
    logbook.attempt("02.1", passed=True)
    before = logbook.read()["02.1"]
    logbook.attempt("02.2", passed=False)
    other = {"02.1": {"tries": 7}, "02.2": {"passed": "2026-01-01", "tries": 1, "hints": 2}, "02.3": {"tries": "bad"}}
    pack("my_work.zip", progress_DOT_json=json.dumps(other))
    work.take_up()
    now = logbook.read()
    assert now["02.1"] == {**before, "tries": 7}
    assert (now["02.2"]["passed"], now["02.2"]["tries"], now["02.2"]["hints"]) == ("2026-01-01", 1, 2)
    assert "02.3" not in now


@pytest.mark.parametrize("name", ["../outside.py", "/outside.py", "a/../../outside.py", "..\\outside.py"])
def test_a_name_that_leads_out_is_refused(desk, name):
    with zipfile.ZipFile("my_work.zip", "w") as file:
        file.writestr(name, "x")
    with pytest.raises(ValueError, match="leads out of this folder"):
        work.take_up()
    assert not (desk.parent / "outside.py").exists()


def test_another_file_is_refused_with_one_sentence(desk):
    with pytest.raises(ValueError, match="there is no my_work.zip here"):
        work.take_up()
    (desk / "my_work.zip").write_text("no zip")
    with pytest.raises(ValueError, match="is not a zip file"):
        work.take_up()


def test_in_a_browser_there_are_buttons(desk, monkeypatch):
    shown = []
    monkeypatch.setattr(work, "display", lambda html: shown.append(html.data))
    monkeypatch.setattr(work, "IN_BROWSER", True)
    monkeypatch.setattr(work, "DRIVE", desk)
    work.take_home()
    work.take_up()
    assert [name in html for name, html in zip(("take-home", "take-up"), shown, strict=True)] == [True, True]


def test_where_the_browser_keeps_nothing_there_is_a_link(desk, monkeypatch, capsys):
    shown = []
    monkeypatch.setattr(work, "display", lambda html: shown.append(html.data))
    monkeypatch.setattr(work, "IN_BROWSER", True)
    monkeypatch.setattr(work, "DRIVE", desk / "none")
    work.take_home()
    assert "data:application/zip;base64," in shown[0] and "save the notebook" in capsys.readouterr().out
