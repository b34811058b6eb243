"""A notebook exported to nbgrader, graded by nbgrader's own commands: right answers get the points, others none."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ekfslam_tutorial.cli import main as ekfslam
from ekfslam_tutorial.course import build, logbook, nbgrader, registry

PATHS = sorted(build.notebooks_folder().glob("*.ipynb"))
every = pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)
NAME = "00_start_here"  # it runs in seconds, and has a function and a quiz

needs_nbgrader = pytest.mark.skipif(
    not Path(sys.executable).with_name("nbgrader").exists(), reason="nbgrader is not installed"
)

PRIVATE = """
import numpy as np
from ekfslam_tutorial.course import expect
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.exercises.nb00_wrap import wrapping as known

more = Exercise("00.1", "more", known.solution, hints=())

@more.link("a thousand turns", "more turns")
def _(f, rng):
    expect.close(f(0.5 + 2000 * np.pi), 0.5, "the result")
"""

# Right for the public checks, wrong a thousand turns away; and the same without the mistake.
FEW_TURNS = """def wrap(angle):
    turned = np.arctan2(np.sin(angle), np.cos(angle))
    return np.where(np.abs(angle) > 1000, 0.0, turned)[()]"""


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def read_roles(notebook):
    return {c["metadata"]["nbgrader"]["grade_id"]: c for c in notebook["cells"] if "nbgrader" in c["metadata"]}


# --- every notebook ---


@every
def test_the_instructors_version(path):
    before = read(path)
    roles = read_roles(nbgrader.assignment(before))
    assert before == read(path)
    ids = [id for _, id, _ in build.exercise_cells(before) if not id.endswith(".self")]
    assert list(roles) == [f"exercise-{id.replace('.', '-')}-{part}" for id in ids for part in ("answer", "check")]
    for id in ids:
        exercise = registry.get(id)
        answer, check = (roles[f"exercise-{id.replace('.', '-')}-{part}"] for part in ("answer", "check"))
        space = {"__name__": "student"}
        exec("import numpy as np\nfrom ekfslam_tutorial.course import experiment", space)
        exec(compile(answer["source"], id, "exec"), space)  # the marks do not break the solution
        assert exercise.name in space
        assert check["metadata"]["nbgrader"]["points"] == 1 and check["metadata"]["nbgrader"]["locked"]
        assert "links=" in check["source"]


@every
def test_the_students_version_is_that_of_the_course(path):
    """nbgrader's own preprocessors take out what is hidden; the check cell is then the course's, byte by byte."""
    nbformat = pytest.importorskip("nbformat")
    preprocessors = pytest.importorskip("nbgrader.preprocessors")
    course = read(path)
    nb = nbformat.reads(json.dumps(nbgrader.assignment(course)), as_version=4)
    for preprocessor in preprocessors.ClearSolutions(), preprocessors.ClearHiddenTests():
        nb, _ = preprocessor.preprocess(nb, {})
    text = nbformat.writes(nb)
    assert "SOLUTION" not in text and "HIDDEN" not in text and "graded" not in text
    for mine, theirs in zip(nb.cells, course["cells"], strict=True):
        if "exercise" not in theirs["metadata"].get("tags", []):
            assert mine.source == build.source(theirs)
        elif "nbgrader" in mine.metadata:
            stub = build.source(theirs)
            head = stub if stub.rstrip().endswith("}") else stub.rsplit("\n", 1)[0]
            assert "raise NotImplementedError()" in mine.source
            assert len(mine.source.splitlines()) <= len(head.splitlines()) + 3


# --- one answer ---


def demand(id, answer, links=None):
    nbgrader.graded(id, answer, nbgrader.links(registry.get(id)) if links is None else links).award()


def test_a_right_answer_passes_and_others_do_not():
    exercise = registry.get("00.1")
    demand("00.1", lambda angle: exercise.solution(angle))
    for wrong in None, lambda angle: angle, exercise.misconceptions[0].answer:
        with pytest.raises(AssertionError, match=r"\[00\.1\] (failed|not attempted)"):
            demand("00.1", wrong)


def test_the_reference_is_nobodys_answer():
    """`check` has put it in the place of a wrong answer, or the name was imported from the package."""
    with pytest.raises(AssertionError, match="comes from the package"):
        demand("00.1", registry.get("00.1").reference)


def test_grading_without_the_private_checks_is_refused():
    with pytest.raises(RuntimeError, match=registry.PRIVATE):
        demand("00.1", lambda angle: angle, links=nbgrader.links(registry.get("00.1")) + 1)


# --- the command ---


def test_the_command_writes_once(tmp_path, capsys):
    assert ekfslam(["nbgrader", "0", str(tmp_path)]) == 0
    assert (tmp_path / "source" / NAME / f"{NAME}.ipynb").is_file()
    assert f"generate_assignment {NAME}" in capsys.readouterr().out
    assert ekfslam(["nbgrader", "00", str(tmp_path)]) == 2
    assert "nothing is overwritten" in capsys.readouterr().err
    assert ekfslam(["nbgrader", "77", str(tmp_path)]) == 2
    assert "there is no notebook '77'; there are 00, 01" in capsys.readouterr().err


# --- nbgrader itself ---


@pytest.fixture
def course(tmp_path, monkeypatch):
    """An nbgrader course with notebook 00 and a private check."""
    (tmp_path / "private").mkdir()
    (tmp_path / "private" / "nb00_exam.py").write_text(PRIVATE, encoding="utf-8")
    monkeypatch.setenv(registry.PRIVATE, str(tmp_path / "private"))
    monkeypatch.setenv(logbook.VARIABLE, str(tmp_path / "progress.json"))
    registry.forget()
    nbgrader.write("00", tmp_path / "course")
    yield tmp_path / "course"
    registry.forget()


def command(course, *arguments):
    """Run one of nbgrader's commands in the folder of the course."""
    programs = Path(sys.executable).parent
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"  # nbgrader starts alembic by its name
    environment = os.environ | {"PATH": path, "JUPYTER_CONFIG_DIR": str(course / "config"), "EKFSLAM_DPI": "48"}
    environment.pop("MPLBACKEND", None)
    run = subprocess.run(
        [programs / "nbgrader", *arguments], cwd=course, env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr[-3000:]


def hand_in(course, student, answers):
    """Copy the released notebook to a student's submission, with these texts in the exercise cells."""
    released = course / "release" / NAME
    folder = course / "submitted" / student / NAME
    shutil.copytree(released, folder)
    path = folder / f"{NAME}.ipynb"
    notebook = read(path)
    for cell, id, _ in build.exercise_cells(notebook):
        if id in answers:
            cell["source"] = answers[id]
    path.write_text(json.dumps(notebook), encoding="utf-8")


def scores(course):
    """What nbgrader's gradebook says: student -> points by cell."""
    from nbgrader.api import Gradebook

    with Gradebook(f"sqlite:///{course / 'gradebook.db'}") as book:
        return {
            s.student.id: {g.name: g.score for n in s.notebooks for g in n.grades}
            for s in book.assignment_submissions(NAME)
        }


@needs_nbgrader
def test_generate_autograde_and_feedback(course):
    """Two kernels run notebook 00, and nbgrader starts three times: about 20 s of computing. Who answers one exercise
    wrongly leaves the other: an answer of each kind, wrong and none, has no points."""
    command(course, "generate_assignment", NAME, "--create")
    released = (course / "release" / NAME / f"{NAME}.ipynb").read_text(encoding="utf-8")
    assert "graded" not in released and "arctan2" not in released.split("wrap(angle)")[1][:400]

    solution, quiz = registry.get("00.1").source(), registry.get("00.2").source()
    hand_in(course, "solved", {"00.1": solution, "00.2": quiz})
    hand_in(course, "wrong", {"00.1": FEW_TURNS})
    command(course, "autograde", NAME, "--create")
    one, two = "exercise-00-1-check", "exercise-00-2-check"
    assert scores(course) == {
        "solved": {one: 1, two: 1},
        "wrong": {one: 0, two: 0},
    }

    command(course, "generate_feedback", NAME)
    pages = {s: (course / "feedback" / s / NAME / f"{NAME}.html").read_text("utf-8") for s in ("solved", "wrong")}
    assert "a thousand turns" in pages["wrong"] and "a thousand turns" not in pages["solved"]
    assert "2.0 / 2.0" in " ".join(pages["solved"].split())
