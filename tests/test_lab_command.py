"""`ekfslam lab` and `ekfslam notebooks`: a copy of one's own, which follows the package and keeps what was written."""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

from ekfslam_tutorial.cli import lab, main, notebooks

ROOT = Path(__file__).resolve().parents[1]


def notebook(*cells):
    """The bytes of a notebook with cells [id, text]."""
    made = [{"cell_type": "markdown", "id": id, "metadata": {}, "source": text} for id, text in cells]
    return json.dumps({"cells": made, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}).encode()


def cells(path):
    return [(cell["id"], "".join(cell["source"])) for cell in json.loads(path.read_bytes())["cells"]]


@pytest.fixture
def folders(tmp_path):
    """The package's notebooks, one of three cells, and a copy of them."""
    theirs, mine = tmp_path / "theirs", tmp_path / "mine"
    theirs.mkdir()
    (theirs / "00.ipynb").write_bytes(notebook("ax", "by", "cz"))
    (theirs / "text.md").write_text("one")
    assert sorted(p.name for p in notebooks.bring_up_to_date(theirs, mine).copied) == ["00.ipynb", "text.md"]
    return theirs, mine


@pytest.mark.parametrize(
    ("given", "theirs", "mine", "wanted"),
    [
        ("ax by", "ax by", "ax by", "ax by"),
        ("ax by", "ax bY", "ax by", "ax bY"),  # changed in the package
        ("ax by", "ax by", "ax bM", "ax bM"),  # changed by the student
        ("ax by", "ax bY", "ax bM", "ax bM"),  # by both: the student's stays
        ("ax by", "ax nn by", "aM by", "aM nn by"),  # a new cell comes in
        ("ax by", "ax", "ax by", "ax"),  # one that is gone goes
        ("ax by", "ax", "ax bM", "ax bM"),  # but not if the student has written in it
        ("ax by cz", "ax by cY", "ax m1 by m2 cz", "ax m1 by m2 cY"),  # cells of the student's own
        ("ax by cz", "ax by cY", "m1 ax by cz m2", "m1 ax by cY m2"),
        ("ax by cz", "ax by cY", "ax cz", "ax cY"),  # what the student has taken out stays out
    ],
)
def test_cells_are_brought_up_to_date_one_by_one(given, theirs, mine, wanted, folders):
    package, own = folders
    read = lambda text: notebook(*text.split())
    (own / notebooks.GIVEN / "00.ipynb").write_bytes(notebooks.blank(json.loads(read(given))))
    (package / "00.ipynb").write_bytes(read(theirs))
    (own / "00.ipynb").write_bytes(read(mine))
    done = notebooks.bring_up_to_date(package, own)
    assert cells(own / "00.ipynb") == [(c[0], c[1]) for c in wanted.split()]
    assert [p.name for p in done.updated] == (["00.ipynb"] if wanted != mine else [])
    assert notebooks.bring_up_to_date(package, own).updated == []


def test_a_file_that_is_no_notebook_is_replaced_only_if_nobody_has_touched_it(folders):
    package, own = folders
    (package / "text.md").write_text("two")
    assert [p.name for p in notebooks.bring_up_to_date(package, own).updated] == ["text.md"]
    assert (own / "text.md").read_text() == "two"
    (own / "text.md").write_text("mine")
    (package / "text.md").write_text("three")
    done = notebooks.bring_up_to_date(package, own)
    assert done.updated == [] and done.kept == [own / "text.md"] and (own / "text.md").read_text() == "mine"


@pytest.mark.parametrize("broken", [b"not JSON", b"[]", b'{"cells": [{}]}'])
def test_a_notebook_that_is_none_any_more_stays(broken, folders):
    package, own = folders
    (own / "00.ipynb").write_bytes(broken)
    (package / "00.ipynb").write_bytes(notebook("ax"))
    done = notebooks.bring_up_to_date(package, own)
    assert done.kept == [own / "00.ipynb"] and (own / "00.ipynb").read_bytes() == broken


def test_a_copy_of_an_older_version_has_nothing_to_compare_with_and_stays(folders):
    package, own = folders
    (own / notebooks.GIVEN / "00.ipynb").unlink()
    (package / "00.ipynb").write_bytes(notebook("aY"))
    assert notebooks.bring_up_to_date(package, own).kept == [own / "00.ipynb"]
    assert cells(own / "00.ipynb") == [("a", "x"), ("b", "y"), ("c", "z")]


def test_the_lab_opens_the_first_notebook_of_a_copy_without_other_tools(tmp_path, monkeypatch, capsys):
    seen = {}

    def run(arguments, env, check):
        (config,) = env["JUPYTER_CONFIG_PATH"].split(os.pathsep)
        seen["page"] = json.loads(Path(config, "labconfig", "page_config.json").read_text())
        seen["arguments"] = arguments
        return subprocess.CompletedProcess(arguments, 0)

    monkeypatch.delenv("JUPYTER_CONFIG_PATH", raising=False)
    monkeypatch.setattr(lab.subprocess, "run", run)
    assert main(["lab", str(tmp_path / "mine"), "--lab", "--no-browser"]) == 0
    assert f"--notebook-dir={tmp_path / 'mine'}" in seen["arguments"] and seen["arguments"][-1] == "--no-browser"
    assert "--LabApp.default_url=/lab/tree/00_start_here.ipynb" in seen["arguments"]
    assert not re.search(r"token|password|--ip|disable_check", " ".join(seen["arguments"]))
    assert seen["page"]["disabledExtensions"]["@jupyter/nbgrader"] is True
    assert f"your notebooks: {tmp_path / 'mine'} (" in capsys.readouterr().out
    given = json.loads((tmp_path / "mine" / "00_start_here.ipynb").read_text(encoding="utf-8"))
    assert not any(cell.get("outputs") for cell in given["cells"])


def test_a_visit_leaves_no_trace_in_the_repository():
    """What `make lab` writes is ignored by git."""
    if not (ROOT / ".git").exists():
        pytest.skip("this is no repository")
    names = ["my_notebooks/00_start_here.ipynb", "my_notebooks/.given/00_start_here.ipynb", "my_notebooks/my_slam.py"]
    asked = subprocess.run(["git", "check-ignore", *names], cwd=ROOT, capture_output=True, text=True)
    assert asked.stdout.split() == names
    assert "lab my_notebooks --lab $(LAB_ARGS)" in (ROOT / "Makefile").read_text(encoding="utf-8")
