"""What a student has done so far, kept in one small JSON file in the home folder."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from ..toolbox.files.locks import one_at_a_time
from ..toolbox.files.writing import written

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


def backup() -> Path:
    """Return the file that has the same records once more."""
    return path().with_name(f"{path().stem}.backup{path().suffix}")


def read() -> dict[str, dict]:
    """Return the records by exercise id; those of the backup if the file is damaged."""
    return _loaded()[0]


def damage() -> str | None:
    """Return a sentence if the file cannot be read, else None."""
    records, why = _loaded()
    if why is None:
        return None
    rest = f"these are the {len(records)} records of {backup().name} beside it" if records else "no record can be read"
    return f"{path()} is damaged ({why}): {rest}."


def write(id: str, **changes):
    """Change the record of one exercise. The new file takes the place of the old one in one step.

    A folder that cannot be written costs the record, never the student's work: nothing is raised. A damaged file is
    kept under another name, which is printed.
    """
    with contextlib.suppress(OSError):
        _change(id, lambda record: changes)


def attempt(id: str, passed: bool):
    """Record a check of an answer. Once passed stays passed."""
    when = datetime.now(UTC).isoformat(timespec="seconds") if passed else None
    with contextlib.suppress(OSError):
        _change(id, lambda record: {"tries": record["tries"] + 1, "passed": record["passed"] or when})


def _change(id, changes):
    """Read, change, write; several kernels one after the other."""
    path().parent.mkdir(parents=True, exist_ok=True)
    with one_at_a_time(path()):
        sentence = damage()
        records = read()
        aside = _free_name() if sentence else None
        record = {**EMPTY, **records.get(id, {})}
        records[id] = record | changes(record)
        text = json.dumps(records, indent=1, sort_keys=True) + "\n"
        if aside:
            os.replace(path(), aside)
        try:
            for target in (path(), backup()):
                _replace(target, text)
        except OSError:
            if aside and not path().exists():  # without it the backup would not be asked any more
                os.replace(aside, path())
            raise
        if aside:
            print(f"{sentence} The damaged file is kept as {aside.name}.")


def _loaded():
    """The records, and None; those of the backup, and what is wrong, if the file is damaged."""
    try:
        return _parsed(path()), None
    except OSError:
        return {}, None
    except ValueError as error:
        why = " ".join(str(error).split())[:100]
    with contextlib.suppress(OSError, ValueError):
        return _parsed(backup()), why
    return {}, why


def _parsed(file):
    text = file.read_text(encoding="utf-8")
    data = json.loads(text) if text.strip() else {}
    if not isinstance(data, dict):
        raise ValueError("it holds no records")
    return {id: {**EMPTY, **record} for id, record in data.items() if isinstance(record, dict)}


def _free_name():
    """A name for a damaged file that none has yet."""
    names = (path().with_name(f"{path().stem}.damaged{n or ''}{path().suffix}") for n in itertools.count())
    return next(name for name in names if not name.exists())


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
    for patience in (0.01, 0.1, None):  # on Windows another reader may hold the file for a moment
        try:
            with written(target, text=True) as file:
                file.write(text)
            return
        except PermissionError:
            if patience is None:
                raise
            time.sleep(patience)
