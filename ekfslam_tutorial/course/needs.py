"""What a function of a notebook needs to stand in a file of its own: its text, imports, helpers and constants."""

from __future__ import annotations

import ast
import inspect
import linecache
import re
import symtable
import sys
import textwrap
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

PACKAGES = ("ekfslam_tutorial", "math", "numpy", "scipy")  # where a name of a notebook may have been imported from
MOST = 64  # entries of an array that is written out as a constant
INSTEAD = "hand it over as an argument, or make it inside the function"


class CannotKeep(Exception):
    """A sentence that says why a function cannot be written into a file."""


def source_of(thing, name: str) -> str:
    """Return the text that defines a function or class, as it was written; a bare lambda gets the name."""
    thing = inspect.unwrap(thing)
    if inspect.isclass(thing):
        return _text_of_class(thing)
    if not isinstance(thing, FunctionType):
        raise CannotKeep(f"`{name}` is a {type(thing).__name__}; only what is written with `def` has a text to keep")
    if thing.__code__.co_freevars:
        raise CannotKeep(f"`{name}` stands inside another function; define it in a cell of its own")
    try:
        text = textwrap.dedent(inspect.getsource(thing))
        body = ast.parse(text).body[0]
    except (OSError, TypeError, SyntaxError, IndexError):
        raise CannotKeep(f"the text of `{name}` cannot be found; define it with `def` in a cell or in a file") from None
    if isinstance(body, ast.FunctionDef):
        return text.rstrip()
    lambdas = [node for node in ast.walk(body) if isinstance(node, ast.Lambda)]
    if len(lambdas) != 1:
        raise CannotKeep(f"the text of `{name}` cannot be found; define it with `def`")
    return f"{name} = {ast.get_source_segment(text, lambdas[0])}"


def _text_of_class(thing) -> str:
    """The text of a class of a notebook: Python finds that of its methods, and the class stands round them."""
    method = next((m for m in vars(thing).values() if isinstance(m, FunctionType)), None)
    if method is not None:
        lines = linecache.getlines(method.__code__.co_filename)
        for node in ast.walk(ast.parse("".join(lines))):
            if isinstance(node, ast.ClassDef) and node.name == thing.__name__:
                first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
                return textwrap.dedent("".join(lines[first - 1 : node.end_lineno])).rstrip()
    raise CannotKeep(f"the text of the class `{thing.__name__}` cannot be found")


def defined_name(text: str) -> str:
    """Return the name that a text defines: of its function or class, or of what is set."""
    body = ast.parse(text).body[0]
    if isinstance(body, ast.Assign):
        return ast.unparse(body.targets[0])
    assert isinstance(body, ast.FunctionDef | ast.ClassDef)
    return body.name


def names_used(text: str) -> list[str]:
    """Return the names that a text takes from outside, in the order of the alphabet; builtins may be among them."""
    found: set[str] = set()

    def walk(table):
        outermost = table.get_type() == "module"
        for symbol in table.get_symbols():
            if symbol.is_referenced() and (outermost or symbol.is_global()):
                found.add(symbol.get_name())
        for child in table.get_children():
            walk(child)

    walk(symtable.symtable(text, "kept", "exec"))
    return sorted(found)


def renamed(text: str, names: dict[str, str]) -> str:
    """Return the text with other names for what it defines and for what it takes from outside."""
    names = {old: new for old, new in names.items() if old != new}
    if not names:
        return text
    tree, edits = ast.parse(text), []
    lines = [line.encode() for line in text.splitlines(keepends=True)]
    top = tree.body[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.arg) and node.arg in names:
            raise CannotKeep(f"`{node.arg}` is an argument here and something else outside; rename one of them")
        if isinstance(node, ast.Name) and node.id in names:
            if isinstance(node.ctx, ast.Store) and node not in getattr(top, "targets", ()):
                raise CannotKeep(f"`{node.id}` is two things, inside the function and outside; rename one of them")
            edits.append((node.lineno - 1, node.col_offset, node.id))
    if isinstance(top, ast.FunctionDef | ast.ClassDef) and top.name in names:
        line, word = top.lineno - 1, len("def " if isinstance(top, ast.FunctionDef) else "class ")
        edits.append(
            (
                line,
                lines[line].index(top.name.encode(), top.col_offset + word),
                top.name,
            )
        )
    for line, column, old in sorted(edits, reverse=True):
        lines[line] = lines[line][:column] + names[old].encode() + lines[line][column + len(old.encode()) :]
    return b"".join(lines).decode()


def plain(text: str) -> str:
    """Return the text without comments, in one form: two that say the same are equal."""
    return ast.unparse(ast.parse(text))


def world_of(thing) -> dict[str, Any]:
    """Return the global names that a function, or a class by its methods, can see."""
    if isinstance(thing, FunctionType):
        return thing.__globals__
    return next((m.__globals__ for m in vars(thing).values() if isinstance(m, FunctionType)), {})


def import_line(name: str, value: Any, world: dict[str, Any]) -> str | None:
    """Return the line that imports a value under this name; None if it is no import, or defined in this `world`."""
    if isinstance(value, ModuleType):
        return _as(f"import {value.__name__}", value.__name__, name)
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | tuple | list | dict | set):
        return None
    if getattr(value, "__globals__", None) is world or getattr(value, "__module__", "") == world.get("__name__"):
        return None
    for module in _modules(value):
        for known in (name, getattr(value, "__name__", name)):
            if vars(module).get(known) is value:
                return _as(f"from {module.__name__} import {known}", known, name)
    return None


def _as(line, known, name):
    return line if known == name else f"{line} as {name}"


def _modules(value):
    """The public modules that the value may come from, the shortest names first."""
    home = str(getattr(value, "__module__", None) or type(value).__module__).split(".")[0]
    roots = {home, *PACKAGES} - {"__main__", "builtins", "my_slam"}
    names = [
        name
        for name, module in list(sys.modules.items())
        if isinstance(module, ModuleType) and name.split(".")[0] in roots and "._" not in name
    ]
    return [sys.modules[name] for name in sorted(names, key=lambda n: (n.count("."), n)) if not OURS.search(name)]


OURS = re.compile(r"\.(exercises|projects)\b")  # solutions: what a student imports comes from elsewhere


def constant(name: str, value: Any) -> str:
    """Return a number, a text, a slice, a small array, or a tuple, list or dictionary of such, as Python writes it."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        if value.dtype.kind in "biuf" and value.size <= MOST and np.all(np.isfinite(value)):
            return f"np.array({value.tolist()!r})"
        raise CannotKeep(f"it uses `{name}` of the notebook, an array of shape {value.shape}; {INSTEAD}")
    if isinstance(value, slice) and all(n is None or isinstance(n, int) for n in (value.start, value.stop, value.step)):
        return repr(value)
    try:
        text = repr(value)
        if len(text) < 1000 and ast.literal_eval(text) == value:
            return text
    except (ValueError, SyntaxError, TypeError):
        pass
    raise CannotKeep(f"it uses `{name}` of the notebook, a {type(value).__name__}; {INSTEAD}")
