"""`ekfslam notebooks DEST`: the notebooks in a folder of the student's own, where no work is ever overwritten.

The copies have no outputs: a question comes before its answer. What the package gave is kept beside them, in a hidden
folder; so at the next time what is new in the package can be told from what the student has written.
"""

import json
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path

from .files import replacing, shipped, writable_folder

RUNNING = {"execution", "collapsed", "scrolled", "ExecuteTime"}  # what a notebook notes of a cell that was run
SKIP = shutil.ignore_patterns(".ipynb_checkpoints", "__pycache__", ".*")
GIVEN = ".given"
"""The hidden folder in the student's: each file as it came from the package."""


def main(options):
    """Run the command."""
    source = shipped("notebooks")
    if not any(source.glob("*.ipynb")):
        raise FileNotFoundError(f"there are no notebooks in {source}; install the package again")
    destination = Path(options.destination)
    if destination.resolve() == source.resolve():
        raise ValueError(f"{destination} is where the notebooks come from; name another folder")
    writable_folder(destination)
    done = bring_up_to_date(source, destination)
    left = ", those there already left as they are" if done.kept else ""
    print(f"{len(done.copied)} files copied to {destination}{left}")
    for path in done.updated:
        print(f"  updated: {path}; the cells that you changed are as they were")
    for path in done.kept:
        print(f"  kept: {path} differs from the package's; move yours away to get that one", file=sys.stderr)
    print(f"next: jupyter lab {destination}")
    return 0


@dataclass
class Done:
    """Files of the student's folder: new ones, those with new cells, and those that differ from the package's."""

    copied: list = field(default_factory=list)
    updated: list = field(default_factory=list)
    kept: list = field(default_factory=list)


def bring_up_to_date(source, destination):
    """Copy a tree; of a file that is there already, bring in what is new and leave what the student has changed."""
    done = Done()
    for path in sorted(p for p in source.rglob("*") if p.is_file()):
        name = path.relative_to(source)
        if SKIP("", name.parts):
            continue
        target, given, new = destination / name, destination / GIVEN / name, content(path)
        if not target.exists():
            write(target, new)
            done.copied.append(target)
        elif content(target) != new:
            merged = new_cells(given, path, target)
            if merged is not None:
                write(target, merged)
                done.updated.append(target)
            if content(target) != new:
                done.kept.append(target)
        if not given.exists() or given.read_bytes() != new:
            write(given, new)
    return done


def write(path, content):
    """Write a file as a whole, with its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        part.write_bytes(content)


def new_cells(given, theirs, mine):
    """The student's file with what is new in the package's; None if there is nothing new, or if that cannot be told."""
    if not given.exists() or theirs.suffix != ".ipynb":
        unchanged = given.exists() and content(mine) == given.read_bytes()
        return theirs.read_bytes() if unchanged else None
    try:
        given, new, mine = (json.loads(path.read_bytes()) for path in (given, theirs, mine))
        cells = merged(given["cells"], json.loads(blank(new))["cells"], mine["cells"])
    except (ValueError, KeyError, TypeError, AttributeError):
        return None  # a file that the student has written in another way
    if cells == mine["cells"]:
        return None
    return (json.dumps({**mine, "cells": cells}, indent=1, ensure_ascii=False) + "\n").encode()


def merged(given, theirs, mine):
    """The cells of a notebook after an update; a cell is known by its id, wherever it stands.

    A cell that is as it was given becomes what it is in the package now, or goes if it is no more there. All others are
    the student's and stay, each behind the cell it stood behind; what the student has taken out stays out.
    """
    was, now, own = ({cell["id"]: cell for cell in cells} for cells in (given, theirs, mine))
    text = lambda cell: "".join(cell["source"])
    untouched = {id for id in own.keys() & was.keys() if text(own[id]) == text(was[id])}
    cells = []
    for cell in theirs:
        id = cell["id"]
        if id in own:
            same = id not in untouched or text(own[id]) == text(cell)
            cells.append(own[id] if same else cell)
        elif id not in was:
            cells.append(cell)
    for before, cell in zip([None, *mine], mine, strict=False):
        if cell["id"] not in now and cell["id"] not in untouched:
            ids = [c["id"] for c in cells]
            place = ids.index(before["id"]) + 1 if before and before["id"] in ids else 0 if before is None else len(ids)
            cells.insert(place, cell)
    return cells


def content(path):
    """The bytes of a file; of a notebook as nobody has run it, so that one that was only run is like a fresh one."""
    text = path.read_bytes()
    if path.suffix != ".ipynb":
        return text
    try:
        return blank(json.loads(text))
    except (ValueError, KeyError, TypeError, AttributeError):
        return text  # it may be anything, if a student has written it


def blank(notebook):
    """The file of a notebook without outputs and execution counts, as bytes."""
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
        for key in RUNNING & cell["metadata"].keys():
            del cell["metadata"][key]
        cell["source"] = "".join(cell["source"]).splitlines(keepends=True)  # one form of the two that are allowed
    notebook["metadata"].pop("widgets", None)  # states of controls
    notebook["metadata"].get("language_info", {}).pop("version", None)  # of the Python that ran it
    return (json.dumps(notebook, indent=1, ensure_ascii=False, sort_keys=True) + "\n").encode()
