"""How a figure was made: the source of a function, shown in the notebook.

The notebooks compute; the drawing stands in `ekfslam_tutorial.course.draws`. Nothing there is secret::

    source(nb05.slam_map)
"""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
from pathlib import Path
from types import FunctionType, MethodType, ModuleType

from .. import __file__ as package


class Source:
    """The source of a function, its file, and what it calls there: highlighted in a notebook, plain elsewhere.

    Parameters
    ----------
    code : str
    place : str
        The file, as the reader knows it.
    helpers : list of str
        Names of the functions and classes of the same module that the code uses.
    module : str
        The last part of the module's name; with it `source` is asked for a helper.
    """

    def __init__(self, code: str, place: str, helpers: list[str], module: str):
        self.code, self.place, self.helpers, self.module = code, place, helpers, module

    def ask(self) -> list[str]:
        """Return for each helper the line that shows it."""
        dotted = "" if self.module == "__main__" else f"{self.module}."
        return [f"source({dotted}{name})" for name in self.helpers]

    def __repr__(self) -> str:
        used = f"\n# It uses, of the same module: {', '.join(self.ask())}." if self.helpers else ""
        return f"{self.code}\n\n# From {self.place}.{used}"

    def _repr_markdown_(self) -> str:
        # Markdown, not HTML with colours of its own: each notebook highlights it in its own theme, dark ones too
        used = f"It uses, of the same module: {', '.join(f'`{line}`' for line in self.ask())}." if self.helpers else ""
        return f"```python\n{self.code}\n```\n\nFrom `{self.place}`. {used}".rstrip()


def source(function) -> Source:
    """Show how a function is written: ``source(nb05.slam_map)`` as the last line of a cell.

    Parameters
    ----------
    function : function
        Of this package, of a file of your own or of the notebook itself.

    Returns
    -------
    shown : Source
        A notebook shows it highlighted, `print` as plain text.

    Raises
    ------
    TypeError
        If it is not a function whose source can be read.
    """
    if isinstance(function, ModuleType):
        raise TypeError(
            f"source() shows one function at a time; of {last(function.__name__)} it can show {own(function)}"
        )
    if not isinstance(function, (FunctionType, MethodType, type)):
        given = getattr(function, "__name__", None) or repr(function)
        raise TypeError(f"source() shows a function that is written in Python; got {shorten(given)}, {kind(function)}")
    written = inspect.unwrap(function)
    try:
        code = textwrap.dedent(inspect.getsource(written)).rstrip()
    except (OSError, TypeError):
        raise TypeError(
            f"the source of {function.__name__} is not on file: Python knows only the compiled code"
        ) from None
    module = sys.modules.get(written.__module__)
    return Source(code, place(written), helpers(code, written, module), last(written.__module__))


def place(function) -> str:
    """Return the file as its reader knows it: below the package, beside the notebook, or the notebook."""
    if function.__module__ == "__main__":
        return "this notebook"
    file, root = Path(inspect.getsourcefile(function) or "").resolve(), Path(package).resolve().parent.parent
    return file.relative_to(root).as_posix() if file.is_relative_to(root) else file.name


def helpers(code: str, function, module) -> list[str]:
    """Return the functions and classes of `module` that the code names, in the order in which it does."""
    nodes = [node for node in ast.walk(parsed(code)) if isinstance(node, ast.Name)]
    names = dict.fromkeys(node.id for node in sorted(nodes, key=lambda n: (n.lineno, n.col_offset)))
    compiled = getattr(function, "__code__", None)
    local = {*compiled.co_varnames, *compiled.co_cellvars} if compiled else set()
    return [n for n in names if n not in local | {function.__name__} and is_own(getattr(module, n, None), module)]


def parsed(code: str) -> ast.AST:
    """Return the tree of the code; of a lambda that stands in the middle of a call, nothing."""
    try:
        return ast.parse(code)
    except SyntaxError:
        return ast.Module([], [])


def is_own(value, module) -> bool:
    """Return True if the value is a function or class that was written in this module."""
    return isinstance(inspect.unwrap(value), (FunctionType, type)) and value.__module__ == module.__name__


def own(module) -> str:
    """Return the names of a module's functions as one phrase."""
    names = [name for name, value in vars(module).items() if is_own(value, module)]
    return ", ".join(names) or "nothing: it has no functions of its own"


def kind(value) -> str:
    """Return what a value is, with its article."""
    name = {"builtin_function_or_method": "built-in function"}.get(type(value).__name__, type(value).__name__)
    return f"{'an' if name[0] in 'aeio' else 'a'} {name}"


def last(name: str) -> str:
    """Return the last part of a dotted name."""
    return name.rsplit(".", 1)[-1]


def shorten(text: str, width: int = 40) -> str:
    """Return the text, cut to a width."""
    return text if len(text) <= width else text[: width - 3] + "..."
