"""The lecture cut of a notebook: the cells tagged ``lecture``, and in folded cells what they need from the others.

A lecturer runs the cut from the top. What it leaves out is not lost: between two cells of the cut the code of the
cells between them is run silently, with the reference solution in place of each exercise.
"""

from __future__ import annotations

import json
import re

from .build import CHECK, source

ONLY_SHOWN = re.compile(r"\s*(explore|hint|progress|reveal|show|replay)\(.*\)\s*", re.DOTALL)
REFERENCE = '{name} = reference("{id}")'
FOLDED = {"jupyter": {"source_hidden": True, "outputs_hidden": True}, "tags": ["folded"]}
HEAD = """%%capture
# What the cut leaves out: it is run, but nothing of it is shown.
from ekfslam_tutorial.course.lecture import reference"""


def tagged(notebook: dict) -> list[dict]:
    """Return the cells tagged ``lecture``.

    Raises
    ------
    ValueError
        If there are none.
    """
    cells = [cell for cell in notebook["cells"] if "lecture" in cell["metadata"].get("tags", [])]
    if not cells:
        raise ValueError("no cell of this notebook has the tag 'lecture'")
    return cells


def cut(notebook: dict) -> dict:
    """Return the cut as a notebook that runs by itself, without outputs.

    Parameters
    ----------
    notebook : dict
        As read from the ``.ipynb`` file; it is left as it is.
    """
    kept, waiting = [], []
    for cell in json.loads(json.dumps(notebook["cells"])):
        if "lecture" in cell["metadata"].get("tags", []):
            if waiting and cell["cell_type"] == "code":
                kept.append(folded(waiting, number=len(kept)))
                waiting = []
            if cell["cell_type"] == "code":
                cell["outputs"], cell["execution_count"] = [], None
            kept.append(cell)
        else:
            waiting += silent(cell)
    tagged({"cells": kept})  # says so if there are none
    return {**notebook, "cells": kept}


def silent(cell: dict) -> list[str]:
    """Return what is run in place of a cell that the cut leaves out: its code, or the reference of an exercise."""
    tags, text = cell["metadata"].get("tags", []), source(cell)
    if cell["cell_type"] != "code" or "exercise" in tags or ONLY_SHOWN.fullmatch(text):
        return []
    found = CHECK.search(text) if "check" in tags else None
    if found:
        return [] if found[1].endswith(".self") else [REFERENCE.format(id=found[1], name=found[2])]
    return [text]


def folded(codes: list[str], number: int) -> dict:
    """Return a folded cell that runs these pieces of code."""
    text = "\n\n".join([HEAD, *codes])
    return {
        "cell_type": "code",
        "execution_count": None,
        "id": f"folded-{number}",
        "metadata": FOLDED,
        "outputs": [],
        "source": text,
    }


def reference(id: str):
    """Return the reference solution of an exercise, without a word."""
    from . import registry

    return registry.get(id).reference
