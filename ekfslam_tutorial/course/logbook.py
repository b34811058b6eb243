"""What a student has done so far, kept in one small JSON file in the home folder."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

VARIABLE = "EKFSLAM_PROGRESS"  # names another file

EMPTY = {"passed": None, "tries": 0, "hints": 0, "revealed": False}


def path() -> Path:
    """Return the file: what EKFSLAM_PROGRESS names, else ``.ekfslam/progress.json`` in the home folder.

    In a browser it is ``progress.json`` beside the notebooks: of all folders, only theirs outlives the page.
    """
    named = os.environ.get(VARIABLE)
    if named:
        return Path(named)
    if sys.platform == "emscripten":
        return Path("progress.json").absolute()
    try:
        return Path.home() / ".ekfslam" / "progress.json"
    except RuntimeError:  # no home folder
        return Path(tempfile.gettempdir()) / "ekfslam_progress.json"


def read() -> dict[str, dict]:
    """Return the records by exercise id; an unreadable file counts as an empty one."""
    try:
        data = json.loads(path().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(data, dict):
        return {}
    return {id: {**EMPTY, **record} for id, record in data.items() if isinstance(record, dict)}


def write(id: str, **changes):
    """Change the record of one exercise. The new file takes the place of the old one in one step.

    A folder that cannot be written costs the record, never the student's work: nothing is raised.
    """
    with contextlib.suppress(OSError):
        records = read()
        records[id] = {**EMPTY, **records.get(id, {}), **changes}
        _replace(path(), json.dumps(records, indent=1, sort_keys=True) + "\n")


def attempt(id: str, passed: bool):
    """Record a check of an answer. Once passed stays passed."""
    record = read().get(id, EMPTY)
    when = datetime.now(UTC).isoformat(timespec="seconds") if passed else None
    write(id, tries=record["tries"] + 1, passed=record["passed"] or when)


def merge(text: str):
    """Take over the records of another file. What has passed, here or there, has passed; counts are the larger ones."""
    try:
        others = json.loads(text)
    except ValueError:
        return
    for id, other in others.items() if isinstance(others, dict) else ():
        mine = read().get(id, EMPTY)
        with contextlib.suppress(TypeError, AttributeError):  # another one's file may hold anything
            most = {key: max(mine[key], other.get(key, EMPTY[key])) for key in ("tries", "hints", "revealed")}
            write(id, **{**other, **most, "passed": mine["passed"] or other.get("passed")})


def _replace(target: Path, text: str):
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=target.name, suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        for patience in (0.01, 0.1, None):  # on Windows another reader may hold the file for a moment
            try:
                os.replace(name, target)
                return
            except PermissionError:
                if patience is None:
                    raise
                time.sleep(patience)
    finally:
        with contextlib.suppress(OSError):
            os.unlink(name)
