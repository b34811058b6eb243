"""The experiment of a notebook, taken from the notebook itself: what a test or a tool runs is what the student sees."""

from __future__ import annotations

import json

from . import build

TAG = "experiment"


def experiment_of(number: str, **names) -> dict:
    """Run the cells of a notebook that are tagged `experiment`, and return the names that they define.

    Parameters
    ----------
    number : str
        Of the notebook, "17".
    **names
        What else the cells use: the functions of exercises.

    Returns
    -------
    dict
        Name to value, as after the cells.
    """
    (path,) = build.notebooks_folder().glob(f"{number}_*.ipynb")
    space = dict(names)
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if TAG in cell["metadata"].get("tags", []):
            exec(compile(build.source(cell), f"cell {cell.get('id')} of {path.name}", "exec"), space)
    return space
