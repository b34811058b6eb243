"""Notebooks with the exercises solved: ``python -m ekfslam_tutorial.course.build solved DEST``.

The cell tagged ``exercise`` is replaced by the source of the reference solution; the cell tagged ``check`` below
it says which exercise it is. For lecturers, and for the tests: in the copies every check must pass.
``python -m ekfslam_tutorial.course.build stub 02.3`` prints the text of an exercise cell.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from . import registry

CHECK = re.compile(r"""\bcheck\(\s*["'](\d\d\.\w+)["']\s*,\s*(\w+)""")


def notebooks_folder() -> Path:
    """Return the folder of the notebooks, in an installed package or in the repository."""
    package = Path(__file__).resolve().parent.parent
    shipped = package / "_share" / "notebooks"
    return shipped if shipped.is_dir() else package.parent / "notebooks"


def exercise_cells(notebook: dict) -> Iterator[tuple[dict, str, str]]:
    """Yield each exercise cell with the exercise's id and the name that is checked.

    Raises
    ------
    ValueError
        If an exercise cell is not followed by its check cell.
    """
    waiting = None
    for cell in notebook["cells"]:
        tags = cell.get("metadata", {}).get("tags", [])
        if "exercise" in tags:
            if waiting is not None:
                raise ValueError(f"two exercise cells and no check between them: {source(cell)[:60]!r}")
            waiting = cell
        elif "check" in tags:
            found = CHECK.search(source(cell))
            if found is None or waiting is None:
                raise ValueError(f"a check cell without its exercise cell: {source(cell)[:60]!r}")
            yield waiting, found[1], found[2]
            waiting = None
    if waiting is not None:
        raise ValueError(f"an exercise cell without its check: {source(waiting)[:60]!r}")


def source(cell: dict) -> str:
    """Return the text of a cell (a file may hold it as a list of lines)."""
    return "".join(cell["source"])


def solved(notebook: dict, answers: dict[str, str] | None = None) -> dict:
    """Return the notebook with every exercise cell filled in, and no outputs.

    Parameters
    ----------
    notebook : dict
        As read from the ``.ipynb`` file; it is left as it is.
    answers : dict of str to str, optional
        Text of the cell by exercise id, instead of the reference solution.
    """
    notebook = json.loads(json.dumps(notebook))
    for cell, id, name in exercise_cells(notebook):
        exercise = registry.get(id)
        if exercise.name != name:
            raise ValueError(f"{id} checks `{name}`, but the solution is called `{exercise.name}`")
        cell["source"] = (answers or {}).get(id, exercise.source())
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    return notebook


def write_solved(destination: Path, folder: Path | None = None) -> list[Path]:
    """Write the solved copy of every notebook into `destination` and return the files."""
    destination.mkdir(parents=True, exist_ok=True)
    written = []
    for path in sorted((folder or notebooks_folder()).glob("*.ipynb")):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        target = destination / path.name
        text = json.dumps(solved(notebook), indent=1, ensure_ascii=False) + "\n"
        target.write_text(text, encoding="utf-8", newline="\n")
        written.append(target)
    return written


def main(arguments: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m ekfslam_tutorial.course.build", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("solved", help="write solved copies").add_argument("destination", type=Path, metavar="DEST")
    commands.add_parser("stub", help="print an exercise cell").add_argument("id", metavar="ID")
    options = parser.parse_args(arguments)
    try:
        if options.command == "stub":
            print(registry.get(options.id).stub())
        else:
            written = write_solved(options.destination)
            print(f"{len(written)} solved notebooks in {options.destination}")
    except (OSError, ValueError) as error:
        print(f"build: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
