"""Wrong answers as edits: the solution with one place written otherwise.

A row has three cells, a name, an edit `old -> new`, and a hint; more edits of the same mistake stand below it::

    heading subtracted | y[1] + x_r[2] -> x_r[2] - y[1] | A landmark on the left lies at theta *plus* beta.
    index i for 2i     | x[2 * i] -> x[i]               | Each landmark has two numbers.
        x[2 * i + 1] -> x[i + 1]

Or, where a row would have more than 240 characters, a block: a name, a hint, and below it the edits::

    heading subtracted: A landmark seen to the left (beta > 0) lies in the direction theta *plus* beta.
        y[1] + x_r[2] -> x_r[2] - y[1]

A name with a colon ends in two: `UP_p: not divided :: d(x/z)/dx = 1/z, not 1.`

An edit that does not match exactly one place of the solution is an error at once. Edits compose: two mistakes at once
are the edits of both.
"""

from __future__ import annotations

import ast
import contextlib
import inspect
import linecache
import re
import textwrap
from functools import cache, cached_property


def blocks(text: str) -> list[tuple[str, str, list[tuple[str, str]]]]:
    """Return name, hint and edits of each row or block.

    The hint of a block may go on in the next lines, up to its first edit.
    """
    found: list[tuple[str, str, list[tuple[str, str]]]] = []
    for line in textwrap.dedent(text).strip("\n").splitlines():
        if not line.strip():
            continue
        if line.startswith("    "):
            if not found:
                raise ValueError(f"an edit stands below a name and a hint; got {line.strip()!r} before any of them")
            found[-1][2].append(_edit(line))
        elif line.count(" | ") >= 2:
            name, cells = line.split(" | ", 1)
            edit, hint = cells.rsplit(" | ", 1)
            found.append((name.strip(), hint.strip(), [_edit(edit)]))
        elif found and not found[-1][2]:
            name, hint, places = found.pop()
            found.append((name, f"{hint} {line.strip()}", places))
        elif ": " in line:
            name, hint = line.split(" :: " if " :: " in line else ": ", 1)
            found.append((name, hint, []))
        else:
            raise ValueError(
                f"a wrong answer is written `name | edit | hint`, or `name: hint` above its edits; got {line!r}"
            )
    for name, _, places in found:
        if not places:
            raise ValueError(f"the wrong answer {name!r} has no edit")
    return found


def _edit(text: str) -> tuple[str, str]:
    if text.count(" -> ") != 1:
        raise ValueError(f"an edit is written `old -> new`, got {text.strip()!r}")
    old, new = text.strip().split(" -> ")
    return old, new


def mistake(solution, name, hint, places):
    """Return the misconception that writes these places of the solution otherwise; an edit must match once."""
    head, body = parts(solution)
    applied(body, places, name)
    return Mistake(solution, name, hint, tuple(places))


class Mistake:
    """A misconception whose answer is made when it is first needed."""

    def __init__(self, solution, name, hint, edits):
        self.solution, self.name, self.hint, self.edits = solution, name, hint, edits

    @cached_property
    def answer(self):
        """The solution with the edits."""
        head, body = parts(self.solution)
        return function(self.solution, head + applied(body, self.edits, self.name), self.name)


def form(solution, name, places):
    """Return the solution in another form, as a function whose source can be read as that of the solution can."""
    head, body = parts(solution)
    made = function(solution, head + applied(body, places, name), f"{name} of {solution.__module__}")
    source, file = head + applied(body, places, name), made.__code__.co_filename
    linecache.cache[file] = len(source), None, source.splitlines(keepends=True), file
    return made


def composed(solution, one, other):
    """Return the solution with both lists of edits, or None if one takes the other's place away."""
    head, body = parts(solution)
    for first, second in ((one, other), (other, one)):
        try:
            text = applied(applied(body, first, ""), second, "")
        except ValueError:
            continue
        try:
            return function(solution, head + text, "two mistakes")
        except SyntaxError:
            continue
    return None


def applied(body: str, places, name: str) -> str:
    """Return the text with each edit made."""
    for old, new in places:
        if body.count(old) != 1:
            raise ValueError(f"{name}: {old!r} stands {body.count(old)} times in the solution; an edit needs one place")
        body = body.replace(old, new)
    return body


@cache
def parts(solution) -> tuple[str, str]:
    """Return the source of a function: the head with the docstring, and the body."""
    source = textwrap.dedent(inspect.getsource(solution))
    tree = ast.parse(source).body[0]
    assert isinstance(tree, ast.FunctionDef)
    first = tree.body[1] if ast.get_docstring(tree) is not None and len(tree.body) > 1 else tree.body[0]
    lines = source.splitlines(keepends=True)
    at = first.lineno - 1
    return "".join(lines[:at]), "".join(lines[at:])


def function(solution, source: str, name: str):
    """Return the function that the source defines, with the names that the solution sees; its loops can be counted."""
    space = solution.__globals__ | {"_one_more": turns.one_more}
    exec(compile(LOOP.sub(r"\1\n\2_one_more()\n", source), f"<{name}>", "exec"), space)
    return space.pop(solution.__name__)  # or each would be in a circle with its names: thousands wait to be collected


LOOP = re.compile(r"^( *(?:for|while)\b.*:(?: *#.*)?)\n(?=( +))", re.MULTILINE)  # its line, and the indent of the next


class Endless(BaseException):
    """A loop has turned too often."""


class Turns:
    """How often all loops of edited solutions together may still turn: an edit can make one endless."""

    def __init__(self):
        self.left = float("inf")

    def one_more(self):
        """Count a turn."""
        self.left -= 1
        if self.left < 0:
            raise Endless

    @contextlib.contextmanager
    def at_most(self, n):
        """Raise `Endless` in the loop that would turn once more than n times."""
        before, self.left = self.left, n
        try:
            yield
        finally:
            self.left = before


turns = Turns()
