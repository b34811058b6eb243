"""The file that the student's functions are kept in: free text, and sections between two lines of marks.

    # ---- 05.1  Predict ---------------------------------------------------
    def predict(x, P, u, U):
        ...
    # ---- end of 05.1 -----------------------------------------------------

A section is replaced as a whole. Everything outside of sections is the student's own and stays.
"""

from __future__ import annotations

import ast
import os
import re
import types
from contextlib import suppress
from dataclasses import dataclass, field, replace
from importlib.util import cache_from_source
from pathlib import Path

from ..toolbox.files.writing import written

BEGIN = re.compile(r"# ---- (?!end of )(\S+)(?:  (.*?))? -{4,}\s*$")
END = re.compile(r"# ---- end of (\S+) -{4,}\s*$")
WIDTH = 100
IMPORTS = "imports"

HEAD = '''"""My own SLAM: what I have written in the notebooks of the course.

`keep` writes the sections, each from its line "# ---- ..." to its line "# ---- end of ...". If an exercise is kept
again, its section is written anew. All other lines are yours: they stay as they are.

Names: a function has the name that it has in its notebook. Where two share a name, it stays with the filter of notebook
05, and the other one carries the number of its notebook: wrap_00, correct_01, predict_11. So does a helper, an import
or a constant whose name is taken.
"""
'''


class Broken(Exception):
    """A sentence that says what is wrong with the file."""


@dataclass
class Section:
    """A part of the file that belongs to `keep`. Keys: "05.1" for an exercise, "05:name" for a helper, "imports"."""

    key: str
    title: str
    body: str

    def __str__(self):
        first = f"# ---- {self.key}  {self.title} ".rstrip() + " "
        last = f"# ---- end of {self.key} "
        return f"{first.ljust(WIDTH, '-')}----\n{self.body.rstrip()}\n{last.ljust(WIDTH, '-')}----\n"


@dataclass
class MyFile:
    """The file in parts: strings are the student's, sections are ours."""

    parts: list = field(default_factory=lambda: [HEAD])
    newline: str = "\n"

    @classmethod
    def read(cls, path: Path) -> MyFile:
        """Read the file; a new one if there is none.

        Raises
        ------
        Broken
            The file cannot be read, is not Python, or has a mark without its partner.
        """
        try:
            raw = path.read_bytes()
        except FileNotFoundError:
            return cls()
        except OSError as error:
            raise Broken(f"it cannot be read ({error.strerror})") from None
        if not raw:  # made this moment, to keep other kernels out
            return cls()
        try:
            text = raw.decode().replace("\r\n", "\n")
            ast.parse(text)
        except SyntaxError as error:
            raise Broken(f"it is not valid Python (line {error.lineno}: {error.msg})") from None
        except ValueError:
            raise Broken("it is not a text in UTF-8") from None
        return cls(_parts(text), "\r\n" if b"\r\n" in raw else "\n")

    def __str__(self):
        return "".join(map(str, self.parts))

    def copied(self) -> MyFile:
        """Return a copy: what is put into one of the two does not change the other."""
        return MyFile([part if isinstance(part, str) else replace(part) for part in self.parts], self.newline)

    def sections(self) -> dict[str, Section]:
        """Return the sections by key, in the order of the file."""
        return {part.key: part for part in self.parts if isinstance(part, Section)}

    def put(self, key: str, title: str, body: str, before: str = ""):
        """Replace the section, or put a new one into its place: imports, then helpers, then exercises by number.

        A helper can be asked to stand before the section that needs it, in case that one stands among the helpers.
        """
        section = self.sections().get(key)
        if section:
            section.title, section.body = title, body
            return
        after = [i for i, part in enumerate(self.parts) if isinstance(part, Section) and _rank(part.key) <= _rank(key)]
        place = after[-1] + 1 if after else self._behind_head()
        keys = [part.key if isinstance(part, Section) else "" for part in self.parts]
        if before in keys and ":" in before:
            place = min(place, keys.index(before))
        behind = "".join(map(str, self.parts[place:]))
        new: list = ["" if place and str(self.parts[place - 1]).endswith("\n\n") else "\n", Section(key, title, body)]
        if behind and not behind.startswith("\n"):
            new.append("\n")
        self.parts[place:place] = new

    def _behind_head(self):
        """Where the first section goes: behind the student's first text."""
        if self.parts and not isinstance(self.parts[0], Section):
            self.parts[0] = self.parts[0].rstrip("\n") + "\n" if self.parts[0].strip() else ""
            return 1
        return 0

    def bound(self, leave_out: str = "") -> dict[str, str]:
        """Return what the names of the file stand for, as text; those of one section can be left out."""
        found: dict[str, str] = {}
        for part in self.parts:
            if isinstance(part, Section) and part.key == leave_out:
                continue
            for node in ast.parse(str(part)).body:
                if isinstance(node, ast.Import | ast.ImportFrom):
                    found |= dict(_imported(node))
                else:
                    found |= {name: ast.unparse(node) for name in _set_by(node)}
        return found

    def write(self, path: Path):
        """Put the new file into the place of the old one, in one step; no old compiled copy stays behind."""
        path.parent.mkdir(parents=True, exist_ok=True)
        mode = path.stat().st_mode if path.exists() else None
        with written(path, text=True) as file:
            file.write(str(self).replace("\n", self.newline))
        if mode is not None:
            with suppress(OSError):
                os.chmod(path, mode)
        with suppress(OSError, NotImplementedError):
            os.unlink(cache_from_source(str(path)))


def load(text: str, path: Path) -> types.ModuleType:
    """Return the text as a module named after the file, without a look at what was imported before.

    Raises
    ------
    Broken
        The text cannot be run; the sentence names the line.
    """
    module = types.ModuleType(path.stem)
    module.__file__ = str(path)
    try:
        exec(compile(text, str(path), "exec"), vars(module))
    except SyntaxError as error:
        raise Broken(f"it is not valid Python (line {error.lineno}: {error.msg})") from None
    except (Exception, SystemExit) as error:
        line, trace = 0, error.__traceback__
        while trace is not None:
            line = trace.tb_lineno if trace.tb_frame.f_code.co_filename == str(path) else line
            trace = trace.tb_next
        raise Broken(f"it stops in line {line} with {type(error).__name__}: {error}") from None
    return module


def _parts(text):
    parts, free, section, lines = [], "", None, []
    for line in text.splitlines(keepends=True):
        begin, end = BEGIN.match(line), END.match(line)
        if section is None and begin:
            key = begin[1]
            if any(isinstance(part, Section) and part.key == key for part in parts):
                raise Broken(f"it has two sections {key}; delete one of them, with both of its lines of marks")
            parts.append(free)
            section, free, lines = Section(key, begin[2] or "", ""), "", []
        elif section is None and end:
            raise Broken(f'the line "# ---- {end[1]} ..." is missing before "# ---- end of {end[1]} ..."; put it back')
        elif section is None:
            free += line
        elif begin or (end and end[1] != section.key):
            break
        elif end:
            section.body = "".join(lines)
            parts.append(section)
            section = None
        else:
            lines.append(line)
    if section is not None:
        raise Broken(f'the line "# ---- end of {section.key} ----" is missing; put it back')
    return [*(part for part in parts if part != ""), *([free] if free else [])]


def _rank(key) -> tuple[int, str]:
    """The order of new sections: imports, helpers, exercises."""
    if key == IMPORTS:
        return (0, "")
    return (1, "") if ":" in key else (2, key)


def _imported(node):
    home = f"from {node.module} " if isinstance(node, ast.ImportFrom) else ""
    for alias in node.names:
        name = alias.asname or alias.name
        yield name.split(".")[0], f"{home}import {alias.name}" + (f" as {alias.asname}" if alias.asname else "")


def _set_by(node):
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    return [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
