"""Where exercises are found: in `course.exercises`, `course.projects`, and a lecturer's own folder."""

from __future__ import annotations

import difflib
import importlib
import importlib.util
import os
import pkgutil
from pathlib import Path

from . import exercises, projects
from .exercise import Exercise
from .project import Project
from .quiz import Quiz, read_quizzes

PRIVATE = "EKFSLAM_PRIVATE_CHECKS"  # a folder of modules of the same form as course/exercises/nb02.py

_found: dict[str, Exercise | Quiz | Project] = {}
_read: set[str] = set()


def get(id: str) -> Exercise | Quiz | Project:
    """Return the exercise with this id; only the modules of its notebook are imported.

    Raises
    ------
    ValueError
        If there is none; the nearest id is named.
    """
    if not isinstance(id, str):
        raise ValueError(f'the id of an exercise is a text such as "02.3", got {id!r}')
    _read_notebook(id.split(".")[0])
    if id not in _found:
        known = [exercise.id for exercise in everything()]
        near = difflib.get_close_matches(id.rjust(4, "0"), known, 1) or known[:1]  # 2.3 means 02.3, not 12.3
        raise ValueError(f"there is no exercise {id!r}; did you mean {', '.join(map(repr, near))}?")
    return _found[id]


def everything() -> list[Exercise | Quiz | Project]:
    """Return all exercises, in the order of their ids."""
    names = [*_modules(exercises), *_modules(projects), *(path.stem for path in [*_quizzes(), *_private()])]
    for number in sorted(set(map(_number, names))):
        _read_notebook(number)
    return [_found[id] for id in sorted(_found)]


def of_notebook(number: str) -> list[Exercise | Quiz | Project]:
    """Return the exercises of one notebook, in the order of their ids; those of the others are not read."""
    _read_notebook(number)
    return [_found[id] for id in sorted(_found) if id.split(".")[0] == number]


def forget():
    """Forget what was read: for tests, and after a change of the private folder."""
    _found.clear()
    _read.clear()


def _read_notebook(number: str):
    if number in _read:
        return
    _read.add(number)
    for name in _modules(exercises):
        if _number(name) == number:
            _add(vars(importlib.import_module(f"{exercises.__name__}.{name}")).values())
    for name in _modules(projects):
        if _number(name) == number:
            _add(vars(importlib.import_module(f"{projects.__name__}.{name}")).values())
    for path in _quizzes():
        if _number(path.stem) == number:
            _add(read_quizzes(path))
    for path in _private():
        if _number(path.stem) == number:
            _add(vars(_load(path)).values(), private=True)


def _add(values, private=False):
    """Take the exercises among the values. A private one with a known id adds to what is asked there."""
    for exercise in values:
        if not isinstance(exercise, (Exercise, Quiz, Project)):
            continue
        known = _found.get(exercise.id)
        if known is not None and known is not exercise:
            if not private:
                raise ValueError(f"two exercises have the id {exercise.id!r}")
            exercise = _merged(known, exercise)
        _found[exercise.id] = exercise


def _merged(public, private):
    """The public exercise with the private links after its own."""
    if not (isinstance(public, Exercise) and isinstance(private, Exercise)):
        return private
    both = Exercise(
        public.id,
        public.title,
        public.solution,
        public.hints,
        may_change=public.may_change,
        canonical=public.canonical,
        seconds=public.seconds,
    )
    both.links = public.links + private.links
    both.misconceptions = public.misconceptions + private.misconceptions
    both.variants = public.variants + private.variants
    return both


def _modules(folder) -> list[str]:
    return [m.name for m in pkgutil.iter_modules(folder.__path__) if m.name.startswith("nb")]


def _quizzes() -> list[Path]:
    return sorted(path for folder in exercises.__path__ for path in Path(folder).glob("nb*.toml"))


def _private() -> list[Path]:
    folder = os.environ.get(PRIVATE)
    if not folder:
        return []
    if not Path(folder).is_dir():
        raise ValueError(f"{PRIVATE} names {folder!r}, which is not a folder")
    return sorted(Path(folder).glob("nb*.py"))


def _load(path: Path):
    spec = importlib.util.spec_from_file_location(f"ekfslam_private_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ValueError(f"{PRIVATE}: {path.name} cannot be read as a module")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ValueError(f"{PRIVATE}: {path.name} failed: {type(error).__name__}: {error}") from error
    return module


def _number(name: str) -> str:
    """'nb02_loop' -> '02'."""
    return name.removeprefix("nb").split("_")[0]
