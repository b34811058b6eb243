"""Every file of `examples/` runs, prints what its docstring says, and is short enough to be read at once."""

import ast
import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


def told(path):
    """What an example says that it prints."""
    docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    text, _, printed = (docstring or "").partition("\n\nIt prints\n\n")
    assert text.split("\n")[0].endswith((".", "?")), f"{path.name}: its docstring must begin with a sentence"
    return [line.removeprefix("    ") for line in printed.splitlines()]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_prints_what_it_says(path, capsys, monkeypatch, tmp_path):
    if "rosbags" in path.read_text(encoding="utf-8"):
        pytest.importorskip("rosbags", reason="it needs rosbags: pip install ekfslam_tutorial[bags]")
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.splitlines() == told(path)
    assert not list(tmp_path.iterdir()), "it leaves files behind"


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 80


def test_the_page_of_examples_shows_each():
    page = (EXAMPLES[0].parents[1] / "docs" / "examples.md").read_text(encoding="utf-8")
    shown = [line.split()[-1] for line in page.splitlines() if line.startswith("```{literalinclude}")]
    assert sorted(shown) == [f"../examples/{path.name}" for path in EXAMPLES] and len(EXAMPLES) >= 15
