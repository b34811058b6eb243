"""A notebook as an nbgrader assignment: solutions between marks, checks as hidden tests, one point an exercise.

`assignment` makes the instructor's version; ``nbgrader generate_assignment`` makes the students' from it, with the
same exercise cells and check cells as in the course. When nbgrader grades, `graded` judges the answer before `check`
can put the reference in its place: a wrong answer gets no point, and the cells below still run. Self-tests stay
without points.
"""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from . import logbook, registry
from .build import exercise_cells, notebooks_folder, solved, source
from .exercise import Exercise, Verdict
from .project import Project
from .quiz import Quiz

SOLUTION = ("### BEGIN SOLUTION", "### END SOLUTION")
HIDDEN = ("### BEGIN HIDDEN TESTS", "### END HIDDEN TESTS")
POINTS = 1


def assignment(notebook: dict) -> dict:
    """Return the instructor's version of a notebook.

    Private checks (``EKFSLAM_PRIVATE_CHECKS``) are part of the hidden tests: their number is noted, and grading
    without them is refused.

    Parameters
    ----------
    notebook : dict
        As read from the ``.ipynb`` file; it is left as it is.

    Returns
    -------
    dict
        Without outputs; ready for ``nbgrader generate_assignment``.
    """
    stubs = {id: source(cell) for cell, id, _ in exercise_cells(notebook)}
    notebook = solved(notebook, stubs)  # a copy without outputs
    cells = iter(notebook["cells"])
    for cell, id, _ in list(exercise_cells(notebook)):
        check = next(c for c in cells if "check" in c["metadata"].get("tags", []))
        if id.endswith(".self"):
            continue
        exercise = registry.get(id)
        cell["source"] = with_solution(exercise)
        cell["metadata"]["nbgrader"] = role(id, "answer", solution=True, locked=False)
        check["source"] = with_hidden_test(exercise, source(check))
        check["metadata"]["nbgrader"] = role(id, "check", solution=False, locked=True) | {"points": POINTS}
    return notebook


def role(id: str, part: str, solution: bool, locked: bool) -> dict:
    """Return what nbgrader wants to know of a cell (its schema 3)."""
    return {
        "schema_version": 3,
        "grade_id": f"exercise-{id.replace('.', '-')}-{part}",
        "grade": not solution,
        "solution": solution,
        "locked": locked,
        "task": False,
    }


def with_solution(exercise: Exercise | Quiz | Project) -> str:
    """Return the exercise cell: what the student sees, and the solution between nbgrader's marks."""
    begin, end = SOLUTION
    if isinstance(exercise, Project):
        return exercise.solution_between(begin, end)
    if isinstance(exercise, Quiz):
        note = "# Answer in the dictionary above, and delete the next two lines."
        return "\n".join([exercise.stub(), note, begin, exercise.source(), end])
    head = exercise.stub().splitlines()[:-1]  # without the line that raises
    body = exercise.source().splitlines()[len(head) :]
    indent = head[-1][: len(head[-1]) - len(head[-1].lstrip())]
    return "\n".join([*head, indent + begin, *body, indent + end])


def with_hidden_test(exercise: Exercise | Quiz | Project, check: str) -> str:
    """Return the check cell, the student's answer judged before it and the point given or refused after it."""
    begin, end = HIDDEN
    name = exercise.name
    return "\n".join(
        [
            begin,
            f"from {__name__} import graded",
            f'{name} = globals().get("{name}")',
            f'_mark = graded("{exercise.id}", {name}, links={links(exercise)})',
            end,
            check,
            begin,
            "_mark.award()",
            end,
        ]
    )


def links(exercise: Exercise | Quiz | Project) -> int:
    """Return how many properties a check tests."""
    return len(exercise.questions) if isinstance(exercise, Quiz) else len(exercise.links)


class graded:
    """Judge an answer for a mark. `award` passes or raises: nbgrader gives all points or none.

    Parameters
    ----------
    id : str
        Number of the exercise.
    answer : callable or dict
        The student's; None if the cell failed.
    links : int
        How many properties were tested when the assignment was made.

    Attributes
    ----------
    verdict : Verdict
    """

    def __init__(self, id: str, answer: Any, links: int):
        os.environ.setdefault(logbook.VARIABLE, str(Path(tempfile.gettempdir()) / "ekfslam_graded.json"))
        self.exercise = registry.get(id)
        self.links = links
        self.verdict = self._judge(answer)

    def _judge(self, answer) -> Verdict:
        if isinstance(self.exercise, Project):  # it knows the reference's run
            return self.exercise.judge(answer)
        if str(getattr(answer, "__module__", "")).startswith(__name__.partition(".")[0] + "."):
            message = f"`{self.exercise.name}` is not defined in this notebook, but comes from the package"
            return Verdict("failed", "is the student's own", message)
        return self.exercise.judge(answer)

    def award(self):
        """Return if the answer is right.

        Raises
        ------
        RuntimeError
            If fewer properties are tested than when the assignment was made: private checks are missing.
        AssertionError
            If the answer is wrong or missing, with what `check` says.
        """
        here = links(self.exercise)
        if here != self.links:
            raise RuntimeError(
                f"[{self.exercise.id}] has {here} checks here, and had {self.links} when the assignment was made: "
                f"set {registry.PRIVATE} to the same folder as then, or make the assignment again"
            )
        if not self.verdict.passed:
            v = self.verdict
            raise AssertionError(f"[{self.exercise.id}] {v.status}" + (f" '{v.link}': {v.message}" if v.link else ""))


def write(number: str, course: Path) -> Path:
    """Write a notebook into ``source/`` of an nbgrader course.

    Parameters
    ----------
    number : str
        Of the notebook: "02".
    course : Path
        Folder of the nbgrader course; it is made if it is not there.

    Returns
    -------
    Path
        The instructor's version. Its folder has the name of the assignment.

    Raises
    ------
    FileExistsError
        If it is there already: it may hold the lecturer's own changes.
    ValueError
        If there is no such notebook.
    """
    path = find(number)
    target = course / "source" / path.stem / path.name
    if target.exists():
        raise FileExistsError(f"{target} is there already, and nothing is overwritten; move it away to get a new one")
    notebook = assignment(json.loads(path.read_text(encoding="utf-8")))
    target.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    target.write_text(text, encoding="utf-8", newline="\n")
    return target


def find(number: str) -> Path:
    """Return the notebook with a number: "02", or "2".

    Raises
    ------
    ValueError
        If there is none, naming those there are.
    """
    known = {path.name[:2]: path for path in sorted(notebooks_folder().glob("[0-9][0-9]_*.ipynb"))}
    if number.zfill(2) not in known:
        raise ValueError(f"there is no notebook {number!r}; there are {', '.join(known) or 'none'}")
    return known[number.zfill(2)]
