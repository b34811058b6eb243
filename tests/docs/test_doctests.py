"""Every example in a docstring is run. Those that show a whole run get one: a scenario of the lecture, five frames."""

import doctest
import importlib
import pkgutil
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import ekfslam_tutorial
from ekfslam_tutorial.toolbox import UserData, universal_slam

SCENARIO = Path(__file__).resolve().parents[2] / "data" / "scenarios" / "range_bearing_2d.toml"


def examples():
    """All docstrings with examples. Templates are texts, not modules."""
    finder = doctest.DocTestFinder(exclude_empty=True)
    for module in pkgutil.walk_packages(ekfslam_tutorial.__path__, "ekfslam_tutorial."):
        if "templates" in module.name or module.name.endswith("__main__"):
            continue
        for test in finder.find(importlib.import_module(module.name), module=None):
            if test.examples:
                yield pytest.param(test, id=test.name.removeprefix("ekfslam_tutorial."))


EXAMPLES = list(examples())


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_shows_what_it_says(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # The names that an example may use without saying where they come from: those of a run.
    example.globs |= {"universal_slam": universal_slam, "display": lambda *_: None}
    example.globs["userdata"] = UserData.from_toml(SCENARIO, {"time.last": 5})
    if "fig" in "".join(e.source for e in example.examples):
        from ekfslam_tutorial.graphics import MapFig

        example.globs["fig"] = MapFig(next(universal_slam(example.globs["userdata"])))
    report = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=report.append)
    plt.close("all")
    assert not report, "".join(report)


def test_no_example_is_left_out():
    """Each example that a text search finds is one of those that are run."""
    files = [p for p in Path(ekfslam_tutorial.__path__[0]).rglob("*.py") if "templates" not in p.parts]
    found = sum(p.read_text(encoding="utf-8").count("    >>> ") for p in files)
    assert found == sum(len(example.values[0].examples) for example in EXAMPLES) > 15
    assert not [p for p in files if "doctest: +SKIP" in p.read_text(encoding="utf-8")]
