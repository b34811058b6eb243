"""`ekfslam notebooks DEST`: the notebooks in a folder of the student's own, where nothing is ever overwritten.

The copies have no outputs: a question comes before its answer.
"""

import json
import shutil
import sys
from pathlib import Path

from .files import replacing, shipped, writable_folder

RUNNING = {"execution", "collapsed", "scrolled", "ExecuteTime"}  # what a notebook notes of a cell that was run
SKIP = shutil.ignore_patterns(".ipynb_checkpoints", "__pycache__", ".*")


def main(options):
    """Run the command."""
    source = shipped("notebooks")
    if not any(source.glob("*.ipynb")):
        raise FileNotFoundError(f"there are no notebooks in {source}; install the package again")
    destination = Path(options.destination)
    if destination.resolve() == source.resolve():
        raise ValueError(f"{destination} is where the notebooks come from; name another folder")
    writable_folder(destination)
    copied, kept = copy(source, destination)
    print(f"{len(copied)} files copied to {destination}" + (", those there already left as they are" if kept else ""))
    for path in kept:
        print(f"  kept: {path} differs from the package's; move yours away to get that one", file=sys.stderr)
    print(f"next: jupyter lab {destination}")
    return 0


def copy(source, destination):
    """Copy a tree without touching a file that is there.

    Returns
    -------
    copied, kept : list of Path
        Below `destination`; kept are files that were there and differ.
    """
    copied, kept = [], []
    for folder in (source, *sorted(p for p in source.rglob("*") if p.is_dir())):
        names = sorted(p.name for p in folder.iterdir())
        ignored = SKIP(str(folder), names)
        if any(part in SKIP(str(folder), [part]) for part in folder.relative_to(source).parts):
            continue
        for path in (folder / name for name in names if name not in ignored):
            target = destination / path.relative_to(source)
            if path.is_dir():
                target.mkdir(exist_ok=True)
            elif target.exists():
                kept += [] if content(target) == content(path) else [target]
            else:
                with replacing(target) as part:
                    part.write_bytes(content(path))
                copied.append(target)
    return copied, kept


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
