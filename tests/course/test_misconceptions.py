"""The page of wrong ideas tells the truth: each has a widget and an exercise, which are where the page says.

That a named wrong answer is rejected with its own hint is tested in test_exercises.py, for all of them.
"""

import re
from pathlib import Path

import nbformat
import pytest

from ekfslam_tutorial.course import draws, registry
from ekfslam_tutorial.course.build import exercise_cells

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "misconceptions.md"
WIDGET = re.compile(r"`(\w+)\.(\w+)` in \[(\d\d)\]\(\.\./notebooks/([^)]+)\)")
EXERCISE = re.compile(r"`(\d\d\.\w+)` ((?:`[^`]+`(?:; )?)+)")
DRAWINGS = {(draw.__module__.rpartition(".")[2], draw.__name__) for draw in draws.everything()}
COUNT = 33


def rows(text):
    """The rows of the table whose first cell is a number, each as a list of its cells."""
    cells = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in text.splitlines()]
    return [row for row in cells if row[0].isdigit()]


def notebook(number):
    """The notebook with this number, as (name, content)."""
    (path,) = (ROOT / "notebooks").glob(f"{number}_*.ipynb")
    return path.name, nbformat.read(path, as_version=4)


def parts(cell, pattern):
    """What the pattern finds in each line of a cell; a line that it does not match wholly is an error."""
    found = [(line, pattern.fullmatch(line)) for line in cell.split(" <br> ")]
    assert all(match for _, match in found), [line for line, match in found if not match]
    return [match.groups() for _, match in found]


def wrong_widgets(cell):
    """Those of the widgets of a cell that do not exist, or are not in the notebook named beside them."""
    bad = []
    for module, name, number, file in parts(cell, WIDGET):
        real, nb = notebook(number)
        code = "\n".join(c.source for c in nb.cells if c.cell_type == "code")
        shown = re.search(rf"\bexplore\((?:{module}\.)?{name}\b", code)
        there = (module, name) in DRAWINGS or f"def {name}(" in code  # the notebook's own
        if not there or file != real or not shown:
            bad.append(f"{module}.{name}")
    return bad


def wrong_exercises(cell):
    """Those of the wrong answers of a cell that are on no list, or whose exercise is not in its notebook."""
    bad = []
    for id, names in parts(cell, EXERCISE):
        asked = {id for _, id, _ in exercise_cells(notebook(id[:2])[1])}
        known = {m.name for m in registry.get(id).misconceptions} if id in asked else set()
        bad += [f"{id}: {name}" for name in re.findall(r"`([^`]+)`", names) if name not in known]
    return bad


ROWS = rows(PAGE.read_text(encoding="utf-8"))


def test_the_page_has_all_of_them_once():
    assert [int(row[0]) for row in ROWS] == list(range(1, COUNT + 1))
    assert all(len(row) == 5 and len(row[2]) > 20 for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_it_has_its_widget_and_its_exercise(row):
    assert wrong_widgets(row[3]) == []
    assert wrong_exercises(row[4]) == []


def test_an_untrue_row_is_found():
    """A drawing of another notebook, one that there is not, an exercise and a wrong answer that there are not."""
    name = notebook("03")[0]
    for draw in "nb04.web", "nb03.dials":
        assert wrong_widgets(f"`{draw}` in [03](../notebooks/{name})") == [draw]
    assert wrong_widgets("`nb03.dial` in [03](../notebooks/03.ipynb)") == ["nb03.dial"]
    assert wrong_exercises("`03.1` `per mille`; `per cent`") == ["03.1: per mille"]
    assert wrong_exercises("`03.9` `per cent`") == ["03.9: per cent"]
    with pytest.raises(AssertionError):
        wrong_widgets("nb03.dial, notebook 03")
