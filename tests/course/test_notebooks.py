"""The notebooks themselves: stubs, solutions, pictures and language, as every notebook of the course has them."""

import ast
import contextlib
import copy
import importlib
import io
import itertools
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from ekfslam_tutorial.course import build, figures, fleet, guard, registry, widgets
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.figures import stored
from ekfslam_tutorial.course.project import Project
from ekfslam_tutorial.course.quiz import Quiz

from .answers import collector
from .running import few_runs, few_seeds, needed, shorter_logs, tags, uses, without_dots

FOLDER = build.notebooks_folder()
PATHS = sorted(FOLDER.glob("*.ipynb"))
every = pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)

for path in Path(__file__).parent.joinpath("answers").glob("test_nb*.py"):
    importlib.import_module(f".answers.{path.stem}", __package__)  # now collector.RIGHT has them

LINES = 15  # of code in a cell that a student reads


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def text_of(notebook):
    return "\n".join(build.source(cell) for cell in notebook["cells"] if cell["cell_type"] == "markdown")


def same_code(a, b):
    """Equal but for spelling: a formatter may have moved brackets and quotes."""
    return ast.dump(ast.parse(a)) == ast.dump(ast.parse(b))


# --- exercises ---


@every
def test_an_exercise_cell_is_the_stub_of_its_exercise(path):
    for cell, id, name in build.exercise_cells(read(path)):
        exercise = registry.get(id)
        assert exercise.name == name
        assert same_code(build.source(cell), exercise.stub()), f"{id}: the cell is not the stub of the exercise"


@every
def test_every_exercise_of_the_notebook_is_in_it(path):
    number = path.name[:2]
    known = {e.id for e in registry.everything() if e.id.split(".")[0] == number}
    used = [id for _, id, _ in build.exercise_cells(read(path))]
    assert set(used) == known and len(used) == len(known)
    exercises = [id for id in used if not id.endswith(".self")]
    assert 2 <= len(exercises) <= 6
    assert f"{number}.self" in used and len(registry.get(f"{number}.self").questions) == 5


@every
def test_the_check_is_assigned_to_the_name(path):
    for cell in code_cells(read(path)):
        if "check" in tags(cell):
            exercise = r'(\w+) = check\("\d\d\.\w+", \1\)'
            project = r'verdict = check\("\d\d\.project", run\)'
            assert re.fullmatch(f"{exercise}|{project}", build.source(cell).strip())


def telling_lines(exercise):
    """The lines of a solution that give it away."""
    if isinstance(exercise, Quiz):
        return [f'"{q.key}": {q.right!r}' for q in exercise.questions]
    source = "\n".join(exercise.texts()) if isinstance(exercise, Project) else exercise.source()
    body = source.split('"""')[-1]
    lines = [" ".join(line.split("#")[0].split()) for line in body.splitlines()]
    return [line for line in lines if len(line) >= 18 and not line.startswith(("return", "for ", "if ", "ids = "))]


@every
def test_no_solution_is_in_the_notebook(path):
    squeezed = " ".join(path.read_text(encoding="utf-8").replace("\\n", " ").replace('\\"', '"').split())
    for _, id, _ in build.exercise_cells(read(path)):
        for line in telling_lines(registry.get(id)):
            assert line not in squeezed, f"{id}: the notebook holds the line `{line}` of the solution"


@every
def test_a_solved_copy_holds_the_solutions_and_no_outputs(path):
    before = read(path)
    copy = build.solved(before)
    for cell, id, _ in build.exercise_cells(copy):
        assert cell["source"] == registry.get(id).source()
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code_cells(copy))
    assert before == read(path)


def test_write_solved(tmp_path):
    written = build.write_solved(tmp_path / "new" / "solved")
    assert [p.name for p in written] == [p.name for p in PATHS]
    assert build.main(["solved", str(tmp_path / "again")]) == 0
    assert build.main(["stub", PATHS[0].name[:2] + ".1"]) == 0
    assert build.main(["stub", "99.9"]) == 1


def test_a_notebook_with_a_lost_check_is_refused():
    stub = {"cell_type": "code", "metadata": {"tags": ["exercise"]}, "source": "def f(): ..."}
    check = {"cell_type": "code", "metadata": {"tags": ["check"]}, "source": 'f = check("02.3", f)'}
    for cells in ([stub], [check], [stub, stub, check], [stub, check, check]):
        with pytest.raises(ValueError):
            build.solved({"cells": cells})


# --- running it, with answers of all kinds ---


@every
def test_the_notebook_goes_on_with_right_answers(path, tmp_path, monkeypatch):
    """Each exercise is answered by its solution's text and then in other words: what uses the answers goes on.

    Cells on which no answer has an effect are left out: they run once, as nbval runs the notebook. A fleet has three
    runs, a project is judged by two, and a log is its twin, which is shorter: that the cells go on is asked, not what
    they find. (That a project passes with all its seeds is asked in test_projects.py and test_projects_space.py.)
    """
    monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    hide = lambda *objects, **options: None
    for module in figures, widgets:
        monkeypatch.setattr(module, "display", hide)
    without_dots(monkeypatch)
    monkeypatch.setattr(fleet, "run", few_runs(fleet.run))
    shorter_logs(monkeypatch)
    for project in filter(lambda e: isinstance(e, Project), registry.everything()):
        monkeypatch.setattr(project, "seeds", project.seeds[:2])
    monkeypatch.setenv("EKFSLAM_MY_SLAM", str(tmp_path / "my_slam.py"))
    space, told = {"__name__": "__main__", "display": hide}, []
    for cell in touched(code_cells(read(path))):
        source = build.source(cell)
        code = compile(source, f"cell {cell['id']}", "exec")
        if "check" in tags(cell):
            id, name = build.CHECK.search(source).groups()
            for answer in right_answers(registry.get(id), space, monkeypatch):
                space[name] = answer
                told.append(printed(code, space))
        else:
            printed(code, space)
            few_seeds(space)
        plt.close("all")
    assert told and all(re.match(r"\[\d\d\.\w+\] passed\n", text) for text in told), told


def touched(cells):
    """Return the cells that an answer has an effect on, and those that they need, without the exercises' stubs."""
    cells = [cell for cell in cells if "exercise" not in tags(cell)]
    chosen, answered = set(), set()
    for k, cell in enumerate(cells):
        made, used = uses(cell)
        if "check" in tags(cell) or used & answered or not used | made:
            chosen.add(k)
            answered |= made
    return needed(cells, chosen)


def printed(code, space):
    """Run a cell; return what it prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        exec(code, space)
    return text.getvalue()


def right_answers(exercise, space, monkeypatch):
    """The solution as its text gives it in the notebook, and one that is not its text; most give lists for arrays."""
    exec(compile(exercise.source(), f"the solution of {exercise.id}", "exec"), space)
    if isinstance(exercise, Project):  # a run of the reference's text: beside it the reference need not run once more
        monkeypatch.setitem(exercise._kept, exercise.scenario, space[exercise.name].trial)
    yield space[exercise.name]
    if isinstance(exercise, Exercise):
        yield collector.RIGHT[exercise.id][0]
    elif not isinstance(exercise, Project):  # whose answer is a run: one is enough
        yield exercise.variants[0].answer


@pytest.mark.parametrize("exercise", [e for e in registry.everything() if isinstance(e, Exercise)], ids=lambda e: e.id)
def test_what_passed_gives_the_solutions_arrays(exercise):
    """So a notebook goes on in the same way whether an answer is made of lists or of arrays."""

    def listed(value):
        if isinstance(value, tuple):
            return tuple(map(listed, value))
        return value.tolist() if isinstance(value, np.ndarray) else value

    answer = exercise.in_arrays(lambda *args: listed(exercise.solution(*args)))
    f = guard.Guarded(exercise.solution, exercise.may_change, exercise.parameters())
    for link in exercise.links:
        with contextlib.suppress(Exception):
            link.test(f, np.random.default_rng(5))
    seen = [(call, answer(*copy.deepcopy(call.args))) for call in f.calls[:8]]
    assert seen
    for call, result in seen:
        pairs = zip(result, call.result, strict=True) if isinstance(call.result, tuple) else [(result, call.result)]
        for got, want in pairs:
            assert type(got) is type(want) or isinstance(want, np.generic)
            assert guard.equal(got, want)


def test_a_solved_copy_runs_in_a_kernel(tmp_path):
    """By the two commands for teachers; the first notebook stands for all, which are run above."""
    assert build.main(["solved", str(tmp_path)]) == 0
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--nbval-lax", "--nbval-current-env"]
    quick = os.environ | {"EKFSLAM_DPI": "48"}
    run = subprocess.run(
        [*command, str(tmp_path / PATHS[0].name)], cwd=tmp_path, env=quick, capture_output=True, text=True
    )
    assert run.returncode == 0 and " passed" in run.stdout, run.stdout[-2000:]


# --- what a reader sees ---


@every
def test_pictures_have_alternative_texts_and_captions(path):
    notebook, pictures = read(path), 0
    for cell in code_cells(notebook):
        outputs = [*cell["outputs"], {}]
        for output, following in itertools.pairwise(outputs):
            if picture := stored(output):
                pictures += 1
                _, _, alt = picture
                caption = " ".join("".join(following.get("data", {}).get("text/plain", "")).split())
                assert len(alt) > 30 and caption == alt, cell["id"]
            assert "image/svg+xml" not in output.get("data", {})
    assert pictures >= 3
    for link in re.findall(r"!\[(.*?)\]\(", text_of(notebook)):
        assert link, "a Markdown picture without alternative text"


@every
def test_a_notebook_has_the_parts_of_every_notebook(path):
    notebook = read(path)
    text = text_of(notebook)
    first = build.source(notebook["cells"][0])
    assert re.match(r"# \d\d ", first) and "?" in first and re.search(r"\d+ minutes", first)
    assert "Predict before you run" in text
    assert re.search(r"[Bb]reak it", text)
    assert re.search(r"^## .*[Ss]elf-test", text, re.MULTILINE)
    last = [build.source(c) for c in notebook["cells"] if c["cell_type"] == "markdown"][-1]
    assert len(re.findall(r"^[*-] ", last, re.MULTILINE)) == 3, "three things to take away, at the end"
    assert any("explore(" in build.source(c) for c in code_cells(notebook))
    assert f'progress("{path.name[:2]}")' in build.source(notebook["cells"][-1])
    lecture = [cell for cell in notebook["cells"] if "lecture" in tags(cell)]
    assert len(lecture) >= 5 and notebook["cells"][0] in lecture


@every
def test_cells_are_short_and_say_nothing_of_this_machine(path):
    for cell in code_cells(read(path)):
        source = build.source(cell)
        if "exercise" not in tags(cell):
            code = [line for line in source.splitlines() if line.strip() and not line.strip().startswith("#")]
            assert len(code) <= LINES, f"{cell['id']} has {len(code)} lines of code"
        assert not re.search(r"/(home|root|tmp|work)/|[A-Z]:\\", source)
        assert "random.seed" not in source
    assert path.stat().st_size <= 600_000
