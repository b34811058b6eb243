"""The student's own functions in a file: what passed its check is kept in ``my_slam.py``, and lives on from there.

keep("05.1", "05.3")                    # at the end of notebook 05
predict, correct = own("05.1", "05.3")  # in notebook 06
"""

from __future__ import annotations

import inspect
import linecache
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..toolbox.files.locks import one_at_a_time
from . import needs, registry
from .exercise import Exercise
from .my_file import IMPORTS, Broken, MyFile, load
from .needs import CannotKeep
from .project import Project

VARIABLE = "EKFSLAM_MY_SLAM"  # names another file

SHARED = {"00.1": "wrap_00", "01.4": "correct_01", "11.2": "predict_11"}  # the filter of 05 has the plain names

_passed: dict[str, Any] = {}  # what passed its last check in this session
_owned: dict[int, tuple[str, Any]] = {}  # by address: id and function, of what `own` has handed out


def path() -> Path:
    """Return the file: what EKFSLAM_MY_SLAM names, else ``my_slam.py`` in the working folder, beside the notebooks."""
    return Path(os.environ.get(VARIABLE) or "my_slam.py").absolute()


def remember(id: str, answer):
    """Note the answer that passed its check, or None for one that did not."""
    if answer is None:
        _passed.pop(id, None)
    else:
        _passed[id] = answer


def reference(id: str):
    """Return the reference solution of an exercise: what my_slam.py has in place of what is not kept."""
    return registry.get(id).reference


def keep(*ids: str):
    """Write functions that passed their checks into ``my_slam.py``, beside the notebooks.

    Parameters
    ----------
    ids : str
        Numbers of exercises, "05.1". None: all that passed in this session.

    Returns
    -------
    None
        What was kept, and what was not, is printed.
    """
    name, told = path().name, []
    wanted = [id for id in sorted(set(ids or _passed)) if _can_be_kept(id, told, asked=bool(ids))]
    try:
        with one_at_a_time(path()):  # another notebook may keep something, too
            file = MyFile.read(path())
            old = str(file)
            kept = _kept(wanted, file, told)
            if str(file) != old:
                file.write(path())
                _forget_imported()
    except Broken as error:
        print(f"{name} stays as it is, and nothing is kept: {error}.")
        return
    except OSError as error:
        print(f"{name} cannot be written, and nothing is kept: {error.strerror}.")
        return
    if kept:
        print(f"kept in {name}: {_list(kept)}")
    elif not told:
        print("nothing to keep yet: no function has passed its check in this session")
    for line in told:
        print(line)


def own(*ids: str):
    """Return the student's functions from ``my_slam.py``, and the reference for what is not there.

    Each function is checked once more. One that was edited and does not pass any more is replaced by the reference.
    A line is printed that says which is which.

    Parameters
    ----------
    ids : str
        Numbers of exercises, "05.1".

    Returns
    -------
    callable or tuple of callables
        One function for one id.

    Raises
    ------
    ValueError
        If there is no exercise with such an id.
    """
    if not ids:
        raise ValueError('own wants the numbers of exercises, for example own("05.1", "05.3")')
    exercises = [_function(id) for id in ids]
    module, why = None, f"{path().name} is not there yet"
    if path().exists():
        try:
            module = _loaded(MyFile.read(path()), ids)
            _forget_imported()
            sys.modules[path().stem] = module  # a plain import now finds this one, too
        except Broken as error:
            why = f"{path().name}: {error}"
    functions, sources = [], []
    for exercise in exercises:
        function, source = (exercise.reference, f"the reference ({why})") if module is None else _own(exercise, module)
        functions.append(function)
        sources.append(source)
    words = []
    for source in dict.fromkeys(sources):
        words.append(f"{_list([e.id for e, s in zip(exercises, sources, strict=True) if s == source])}: {source}")
    print("; ".join(words))
    return tuple(functions) if len(ids) > 1 else functions[0]


# ---- keep -----------------------------------------------------------------------------------------------------------


def _can_be_kept(id, told, asked) -> bool:
    """True if the exercise asks for a function, and the student's passed."""
    exercise = registry.get(id)
    if not isinstance(exercise, Exercise):
        if asked:
            told.append(f"[{id}] is not kept: {_no_function(exercise)}")
        return False
    if id not in _passed:
        told.append(f"[{id}] is not kept now: in this session, no answer of yours has passed its last check")
        return False
    return True


def _kept(wanted, file: MyFile, told) -> list[str]:
    """Put the functions into the file; return the ids of those that pass their checks there, too."""
    empty = file.copied()
    while True:
        file.parts = empty.copied().parts
        keeper = _Keeper(file, wanted)
        kept = [id for id in wanted if keeper.put(id)]
        if kept != wanted:  # once more: in those that use what cannot be kept, the reference stands for it
            told += keeper.told
            wanted = kept
            continue
        module = _loaded(file)
        bad = [id for id in kept if not _passes(registry.get(id), module)]
        if not bad:
            told += keeper.told
            for id, others in keeper.missing.items():
                told.append(f"[{id}] uses {_list(sorted(set(others)))}: not kept, so the reference stands in the file")
            return kept
        told += [f"[{id}] is not kept: in a file, without the rest of the notebook, it does not pass" for id in bad]
        wanted = [id for id in wanted if id not in bad]


class _Keeper:
    """Writes functions, and what they need of the notebook, into a file.

    `told` are sentences for the student; `missing` are the exercises, by function, that the reference stands for.
    """

    def __init__(self, file: MyFile, wanted: list[str]):
        self.file, self.wanted, self.told, self.missing = file, wanted, [], {}

    def put(self, id) -> bool:
        """Write the function of one exercise and what it needs; False, and nothing is written, if that cannot be."""
        exercise, function = registry.get(id), inspect.unwrap(_passed[id])
        name, before = file_name(exercise), self.file.copied()
        try:
            text = needs.source_of(function, exercise.name)
            names = self.bring(text, function.__globals__, id, asks=id)
            text = needs.renamed(text, {**names, needs.defined_name(text): name})
            if name in self.file.bound(leave_out=id):
                raise CannotKeep(f"the file has another `{name}`, outside of the section {id}; rename that one")
        except CannotKeep as error:
            self.file.parts = before.parts
            self.told.append(f"[{id}] is not kept: {error}")
            self.missing.pop(id, None)
            return False
        self.file.put(id, exercise.title, text)
        return True

    def bring(self, text, world, id, asks, under_way=()) -> dict[str, str]:
        """Put into the file what a text needs of the notebook's `world`; return the names that it has there."""
        names, itself = {}, needs.defined_name(text)
        for name in needs.names_used(text):
            if name not in world or name == itself or f"{_number(id)}:{name}" in under_way:
                continue
            value = world[name]
            other = _exercise_of(value, name, _number(id), world)
            if other:
                names[name] = self.bring_exercise(other, name, id)
            elif (line := needs.import_line(name, value, world)) is not None:
                names[name] = self.bring_import(name, line, id)
            else:
                names[name] = self.bring_helper(name, value, id, asks, under_way)
        return names

    def bring_exercise(self, other, name, id) -> str:
        """Another exercise's function: the student's if it is kept, else the reference, and a sentence says so."""
        exercise = registry.get(other)
        new, section = file_name(exercise), self.file.sections().get(other)
        if section is None and other not in self.wanted:
            self.bring_import("reference", "from ekfslam_tutorial.course.keep import reference", id)
            title = f"{exercise.title}: the reference, until you keep your own"
            self.file.put(other, title, f'{new} = reference("{other}")')
        if other not in self.wanted and f'= reference("{other}")' in self.file.sections()[other].body:
            self.missing.setdefault(id, []).append(other)
        return new

    def bring_import(self, name, line, id) -> str:
        """Return the name under which the import stands in the file."""
        for new in (name, f"{name}_{_number(id)}"):
            line = line if new == name else f"{line.split(' as ')[0]} as {new}"
            taken = self.file.bound().get(new)
            if taken == line or (taken is None and new not in _names_of_exercises()):
                break
        else:
            raise CannotKeep(f"the file has another `{name}`, and another `{new}`, too; rename one of them")
        if taken is None:
            known = self.file.sections().get(IMPORTS)
            lines = [*(known.body.splitlines() if known else []), line]
            self.file.put(IMPORTS, "", "\n".join(sorted(lines, key=lambda text: (text.startswith("from"), text))))
        return new

    def bring_helper(self, name, value, id, asks, under_way) -> str:
        """A function, class or constant of the notebook: return its name in the file."""
        key, names, title = f"{_number(id)}:{name}", {}, f"of notebook {_number(id)}"
        inner = inspect.unwrap(value) if callable(value) else value
        if inspect.isfunction(inner) or inspect.isclass(inner):
            text = needs.source_of(inner, name)
            world = needs.world_of(inner)
            names = self.bring(text, world, id, key, (*under_way, key))
        else:
            text = f"{name} = {needs.constant(name, value)}"
            if "np." in text:
                names = {"np": self.bring_import("np", "import numpy as np", id)}
        taken, new = self.file.bound(leave_out=key), name
        if name in taken and needs.plain(needs.renamed(text, names)) == taken[name]:
            return name  # it is there already, from another notebook
        if name in taken or name in _names_of_exercises():
            new = f"{name}_{_number(id)}"
        self.file.put(key, title, needs.renamed(text, {**names, needs.defined_name(text): new}), before=asks)
        return new


def _number(id) -> str:
    """The number of the notebook."""
    return id.split(".")[0]


def _exercise_of(value, name, number, world) -> str | None:
    """The exercise whose function this is, the student's or the reference; or None."""
    if not callable(value):
        return None
    function = inspect.unwrap(value)
    if id(function) in _owned:
        return _owned[id(function)][0]
    for known, answer in _passed.items():
        if inspect.unwrap(answer) is function:
            return known
    home = str(getattr(function, "__module__", ""))
    of_the_course = ".exercises.nb" in home or ".projects.nb" in home
    home = home.rpartition(".nb")[2].split("_")[0] if of_the_course else number
    for exercise in registry.everything():
        if isinstance(exercise, Exercise) and _number(exercise.id) == home:
            mine = exercise.name == name and getattr(function, "__globals__", None) is world
            if mine or exercise.is_reference(function):
                return exercise.id
    return None


# ---- own ------------------------------------------------------------------------------------------------------------


def file_name(exercise) -> str:
    """Return the name that the function of an exercise has in the file."""
    return SHARED.get(exercise.id) or exercise.name


def _names_of_exercises() -> set[str]:
    """The names that no helper, import or constant may take."""
    return {file_name(exercise) for exercise in registry.everything()}


def _function(id) -> Exercise:
    exercise = registry.get(id)
    if not isinstance(exercise, Exercise):
        raise ValueError(f"own cannot give {id}: {_no_function(exercise)}")
    return exercise


def _no_function(exercise) -> str:
    """Say what there is instead of a function that could be kept."""
    if isinstance(exercise, Project):
        return (
            "a project is a run, not a function. Its scenario and its loop stay in their cell; the functions that the "
            "loop calls can be kept"
        )
    return "a self-test has answers, not a function"


def _own(exercise, module):
    """The function to go on with, and what to say of it."""
    name = file_name(exercise)
    function = getattr(module, name, None)
    if function is None or exercise.is_reference(inspect.unwrap(function)):
        return exercise.reference, "the reference (not kept yet)"
    if not _passes(exercise, module):
        see = f'import {path().stem}; check("{exercise.id}", {path().stem}.{name})'
        return exercise.reference, f"the reference (yours in {path().name} does not pass its check any more: {see})"
    _owned[id(inspect.unwrap(function))] = exercise.id, function
    return function, f"yours, from {path().name}"


def _loaded(file: MyFile, asked=()):
    """The file as a module; its functions give arrays, as those that `check` returns: they call each other.

    So do those that are `asked` for, by id, and stand outside of the sections, written by hand.
    """
    module = load(str(file), path())
    for key in dict.fromkeys([*file.sections(), *asked]):
        with suppress(ValueError):  # a helper, or a section that the student has made
            exercise = registry.get(key)
            function = getattr(module, file_name(exercise), None)
            if (
                isinstance(exercise, Exercise)
                and callable(function)
                and not exercise.is_reference(inspect.unwrap(function))
            ):
                setattr(module, file_name(exercise), exercise.in_arrays(function))
    return module


def _passes(exercise, module) -> bool:
    """True if the function of the exercise, as it stands in the file, passes its check."""
    return exercise.judge(inspect.unwrap(getattr(module, file_name(exercise), print))).passed


def _forget_imported():
    """A plain `import my_slam` reads the file as it is now."""
    sys.modules.pop(path().stem, None)
    linecache.checkcache(str(path()))


def _list(ids) -> str:
    """'predict (05.1), correct (05.3)'."""
    return ", ".join(f"{file_name(registry.get(id))} ({id})" for id in ids)
