"""No test touches the progress of whoever runs the tests, and none sees a lecturer's private checks.

Nor does an answer fail because the computer is busy: what takes more than the 1.5 s of a student's patience is left to
the tests of that limit, and how quick a check is, is measured in time of the processor.
"""

import ast
import contextlib
import inspect
import io
import itertools
import json

import matplotlib.pyplot as plt
import pytest

from ekfslam_tutorial import course
from ekfslam_tutorial.course import build, exercise, fleet, logbook, registry

from .running import few_runs, needed, shorter_logs


@pytest.fixture(scope="session")
def progress_files(tmp_path_factory):
    """Return a function that names a new file each time. A folder for each test would cost more than most tests."""
    folder, number = tmp_path_factory.mktemp("progress"), itertools.count()
    return lambda: folder / f"{next(number):05}.json"


@pytest.fixture(autouse=True)
def own_progress(progress_files, monkeypatch):
    """Keep the progress in a file of this test's own."""
    path = progress_files()
    monkeypatch.setenv(logbook.VARIABLE, str(path))
    monkeypatch.delenv(registry.PRIVATE, raising=False)
    monkeypatch.setenv("EKFSLAM_CHECK_SECONDS", "200")
    return path


@pytest.fixture
def time_to_search(monkeypatch):
    """A slow computer searches four times as long for two mistakes at once: what is found shall not depend on it."""
    monkeypatch.setattr(exercise, "PATIENCE", 4 * exercise.PATIENCE)
    monkeypatch.setattr(exercise, "LATER_S", 20 * exercise.LATER_S)  # by the clock on the wall


@pytest.fixture(scope="session")
def handed(tmp_path_factory):
    """What its notebook hands over to a drawing: the notebook is run, once, and its `explore` is asked."""
    runs = {}

    def given(draw):
        if all(name in draw.controls for name in inspect.signature(draw).parameters):
            return ()
        number = draw.__module__.rsplit(".nb")[-1].split("_")[0]
        if number not in runs:
            runs[number] = explored(number, tmp_path_factory.mktemp("handed"))
        return runs[number][draw]

    return given


def explored(number, folder):
    """Run a notebook in which nobody has answered; return what it hands over to each of its drawings.

    Only the lines run that make what is handed over, without what only shows something, over shorter logs.
    """
    (path,) = build.notebooks_folder().glob(f"{number}_*.ipynb")
    asked, space = {}, {"__name__": "__main__"}

    def explore(draw, *given):
        asked[draw] = given

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(course, "explore", explore)
        for module in course.figures, course.widgets:
            patch.setattr(module, "display", lambda *objects, **options: None)
        patch.setenv(logbook.VARIABLE, str(folder / "progress.json"))
        patch.delenv("EKFSLAM_DATA", raising=False)  # on the twins of the logs: they are shorter
        patch.setattr(fleet, "run", few_runs(fleet.run))
        shorter_logs(patch)
        cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        cells = needed(cells, [k for k, cell in enumerate(cells) if "explore(" in build.source(cell)])
        lines = [line for cell in cells for line in lines_of(cell)]
        # of assignments those that are used: another one may be a run of a minute for a figure that is not shown here
        for line in needed(lines, [k for k, line in enumerate(lines) if not line["assigns"]]):
            with contextlib.redirect_stdout(io.StringIO()):
                exec(compile(build.source(line), f"cell {line['id']}", "exec"), space)
            plt.close("all")
    return asked


def lines_of(cell):
    """The statements of a cell, each as a cell of its own, but for those that show something."""
    for line in ast.parse(build.source(cell)).body:
        text, assigns = ast.unparse(line), isinstance(line, (ast.Assign, ast.AugAssign))
        if not text.startswith(("show(", "print(")):
            yield cell | {"source": text, "assigns": assigns}
