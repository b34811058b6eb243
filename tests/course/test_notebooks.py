"""The notebooks themselves: stubs, solutions, pictures and language, as every notebook of the course has them."""

import ast
import itertools
import json
import re
import types

import matplotlib.pyplot as plt
import pytest

from ekfslam_tutorial.course import build, registry
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.quiz import Quiz

FOLDER = build.notebooks_folder()
PATHS = sorted(FOLDER.glob("*.ipynb"))
every = pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)

LINES = 15  # of code in a cell that a student reads


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def tags(cell):
    return cell["metadata"].get("tags", [])


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
    assert 2 <= len(exercises) <= 5
    assert f"{number}.self" in used and len(registry.get(f"{number}.self").questions) == 5


@every
def test_the_check_is_assigned_to_the_name(path):
    for cell in code_cells(read(path)):
        if "check" in tags(cell):
            assert re.fullmatch(r'(\w+) = check\("\d\d\.\w+", \1\)', build.source(cell).strip())


def telling_lines(exercise):
    """The lines of a solution that give it away."""
    if isinstance(exercise, Quiz):
        return [f'"{q.key}": {q.right!r}' for q in exercise.questions]
    body = exercise.source().split('"""')[-1]
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


def run(path, monkeypatch, answer_of):
    """Run the code cells of a notebook in this process; `answer_of(exercise)` takes the student's place.

    Returns
    -------
    list of str
        What `check` printed.
    """
    lines = []

    def display(*objects, **options):
        pass

    monkeypatch.setattr("ekfslam_tutorial.course.figures.display", display)
    monkeypatch.setattr("ekfslam_tutorial.course.widgets.display", display)
    space = {"__name__": "__main__", "display": display}
    module = types.ModuleType("notebook")
    space["__builtins__"] = module.__dict__.get("__builtins__", __builtins__)
    for cell in code_cells(read(path)):
        if "exercise" in tags(cell):
            continue
        source = build.source(cell)
        found = build.CHECK.search(source) if "check" in tags(cell) else None
        if found:
            exercise = registry.get(found[1])
            answer = answer_of(exercise)
            lines.append(f"{exercise.id} {exercise.judge(answer).status}")
            space[found[2]] = answer
        else:
            exec(compile(source, f"{path.name}: {cell.get('id')}", "exec"), space)
        plt.close("all")
    return lines


@every
@pytest.mark.parametrize("round", [0, 1, 2])
def test_the_notebook_goes_on_with_every_kind_of_right_answer(path, round, monkeypatch, capsys):
    def variant(exercise):
        return exercise.variants[round % len(exercise.variants)].answer

    lines = run(path, monkeypatch, variant)
    assert lines and all(line.endswith(" passed") for line in lines), lines


@every
def test_the_notebook_goes_on_with_lists(path, monkeypatch, capsys):
    def lists(exercise):
        if not isinstance(exercise, Exercise):
            return exercise.reference

        def answer(*args):
            result = exercise.solution(*args)
            listed = [
                r.tolist() if hasattr(r, "tolist") else r for r in (result if isinstance(result, tuple) else (result,))
            ]
            return tuple(listed) if isinstance(result, tuple) else listed[0]

        return answer

    lines = run(path, monkeypatch, lists)
    assert all(line.endswith(" passed") for line in lines), lines


# --- what a reader sees ---


@every
def test_pictures_have_alternative_texts_and_captions(path):
    notebook, pictures = read(path), 0
    for cell in code_cells(notebook):
        outputs = [*cell["outputs"], {}]
        for output, following in itertools.pairwise(outputs):
            if "image/png" in output.get("data", {}):
                pictures += 1
                alt = output["metadata"]["image/png"]["alt"]
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
