"""Every piece of code in docs/ is true: python blocks run and print what the page says, excerpts are the source.

Four rules for a page:

* ```` ```python ```` blocks run from top to bottom in one namespace, as a reader would type them;
* a ```` ```text ```` block that follows at once is what the block before it prints, or the error it ends with;
* after `<!-- source: FILE NAME ... -->` the block is not run: its lines stand, docstrings apart, in those functions;
* after `<!-- needs: NAME -->` the block is run where that optional package is installed.
"""

import ast
import contextlib
import io
import re
import textwrap
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

import ekfslam_tutorial

PACKAGE = Path(ekfslam_tutorial.__file__).parent
PAGES = sorted((Path(__file__).parents[2] / "docs").glob("*.md"))
MARK = re.compile(r"<!-- source: (\S+) (.+) -->")
NEEDS = re.compile(r"<!-- needs: (\w+) -->")


@dataclass
class Block:
    """One fenced block of a page."""

    language: str
    line: int  # of its first line of code, from 1
    code: str
    source: tuple | None = None  # (file, [names]) of an excerpt
    output: str | None = None  # of the text block that follows at once
    needs: str | None = None  # a package


def blocks_of(text):
    """The fenced blocks of a page, in order."""
    blocks, fence, mark, needs, last = [], None, None, None, None
    for number, line in enumerate(text.splitlines(), 1):
        if fence is None and line.startswith("```"):
            fence = Block(line[3:].strip(), number + 1, "", mark, needs=needs)
        elif fence is not None and line.startswith("```"):
            if fence.language == "text" and last is not None:
                last.output = fence.code
            blocks.append(fence)
            last, fence, mark, needs = (fence if fence.language == "python" else None), None, None, None
        elif fence is not None:
            fence.code += line + "\n"
        elif line.strip():
            found = MARK.fullmatch(line.strip())
            mark, last = ((found[1], found[2].split()) if found else None), None
            needs = package[1] if (package := NEEDS.fullmatch(line.strip())) else None
    assert fence is None, f"the block at line {fence.line} has no end"
    return blocks


def source_of(file, name):
    """Lines of a function or class of the package, without its docstring, dedented. `Class.method` finds a method."""
    lines = (PACKAGE / file).read_text(encoding="utf-8").splitlines()
    node = ast.parse("\n".join(lines))
    for part in name.split("."):
        node = next((n for n in node.body if getattr(n, "name", None) == part), None)
        assert node is not None, f"{file} has no {name}"
    first = min([node.lineno, *(d.lineno for d in node.decorator_list)]) - 1
    keep = lines[first : node.end_lineno]
    if ast.get_docstring(node) is not None:
        doc = node.body[0]
        del keep[doc.lineno - 1 - first : doc.end_lineno - first]
    return textwrap.dedent("\n".join(keep)).splitlines()


def stands_in(part, whole):
    """Return True if lines stand one after the other in others; a piece of a function is dedented by itself."""
    windows = (whole[i : i + len(part)] for i in range(len(whole) - len(part) + 1))
    return any(textwrap.dedent("\n".join(w)).splitlines() == part for w in windows)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_excerpts_stand_in_the_source(page):
    for block in blocks_of(page.read_text(encoding="utf-8")):
        if block.source is None:
            continue
        file, names = block.source
        pieces = re.split(r"\n\n\n+", block.code.rstrip("\n"))
        assert len(pieces) == len(names), f"{page.name}:{block.line}: {len(names)} names, {len(pieces)} pieces"
        for name, piece in zip(names, pieces, strict=True):
            now = source_of(file, name)
            if not stands_in(piece.splitlines(), now):
                pytest.fail(f"{page.name}:{block.line}: in {file} this reads now\n" + "\n".join(now), pytrace=False)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_code_blocks_run_and_print_what_the_page_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("EKFSLAM_CACHE", str(tmp_path))
    namespace = {"__name__": page.stem}
    for block in blocks_of(page.read_text(encoding="utf-8")):
        if block.language != "python" or block.source is not None:
            continue
        if block.needs is not None and find_spec(block.needs) is None:
            continue
        printed = run(block, page, namespace)
        if block.output is not None and printed != block.output:
            pytest.fail(f"{page.name}:{block.line} prints\n{printed}", pytrace=False)


def run(block, page, namespace):
    """What a block prints, and the last line of its error if the page announces one."""
    code = compile("\n" * (block.line - 1) + block.code, str(page), "exec")
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        try:
            exec(code, namespace)
        except Exception as error:
            name = type(error).__name__
            if not (block.output or "").splitlines()[-1:] or not block.output.splitlines()[-1].startswith(name):
                raise
            print(f"{name}: {error}")
    return out.getvalue()


def test_the_checks_themselves_see_a_wrong_page():
    page = (
        "```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n<!-- source: geometry/angles.py wrap -->\n```python\nx\n```\n"
    )
    shown, excerpt = (b for b in blocks_of(page) if b.language == "python")
    assert (shown.output, shown.line, excerpt.source) == ("3\n", 2, ("geometry/angles.py", ["wrap"]))
    assert run(shown, Path("page.md"), {}) == "2\n"
    assert not stands_in(["x"], source_of("geometry/angles.py", "wrap"))
    line = "return np.pi - np.subtract(np.pi, angle) % (2 * np.pi)"
    assert stands_in([line], source_of("geometry/angles.py", "wrap"))
    with pytest.raises(ZeroDivisionError):
        run(Block("python", 1, "1 / 0"), Path("page.md"), {})
    (optional,) = blocks_of("<!-- needs: numba -->\n```python\n1 / 0\n```\n")
    assert optional.needs == "numba"
    announced = Block("python", 1, "1 / 0", output="ZeroDivisionError: division by zero\n")
    assert run(announced, Path("page.md"), {}) == announced.output
