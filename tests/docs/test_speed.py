"""The figures of README.md and docs/performance.md are those of the stored run; each peer stands in its better way."""

import re
from pathlib import Path

import pytest

from benchmarks.quote import PAGES, PART, PARTS, figure, pair, quoted
from benchmarks.results import Results
from benchmarks.ways import WAYS

ROOT = Path(__file__).parents[2]
RUN = Results.load(ROOT / "benchmarks" / "results.json")


def page(name):
    return (ROOT / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PAGES)
def test_what_is_quoted_is_the_stored_run(name):
    assert quoted(page(name), RUN) == page(name), f"write {name} anew: python -m benchmarks.quote"


def test_every_part_is_quoted_once():
    names = [name for file in PAGES for _, name, _ in PART.findall(page(file))]
    assert sorted(names) == sorted(PARTS)


def cpu(n, way, which="median"):
    """Straight from the file, without the functions that wrote the page."""
    (row,) = [r for r in RUN.data["grid"] if (r["n_lmks"], r["m"], r["variant"]) == (n, 10, way)]
    return row["cpu_us"][which]


@pytest.mark.parametrize(
    ("line", "ways"),
    [
        ("times faster than filterpy, one joint update", ["filterpy, joint"]),
        ("... that and the motion by hand, its better way", list(WAYS["filterpy"])),
        ("... ten updates, one by one", ["filterpy"]),
        ("times faster than Stone Soup's updater", list(WAYS["Stone Soup"])),
    ],
)
def test_the_ratios_of_the_readme_are_quotients_of_the_file(line, ways):
    cells = re.search(rf"^\| {re.escape(line)} \| (.*) \|$", page("README.md"), re.MULTILINE)[1].split(" | ")
    for cell, n in zip(cells, (10, 100, 500), strict=True):
        peer = min(cpu(n, way) for way in ways)
        for stated, ours in zip(cell.split("; "), ("step, joint", "step, joint, compiled"), strict=True):
            value = float(stated.replace(",", ""))
            assert value == pytest.approx(peer / cpu(n, ours), rel=0.06), (line, n, ours)


def test_the_worse_figure_stands_beside():
    """Numpy first, then compiled, with two digits at least; nothing is rounded up to a tie."""
    assert pair(figure, 0.676, 1.84) == "0.68; 1.8"
    assert figure(0.994) == "0.99" and figure(9.94) == "9.9" and figure(12.4) == "12"
    assert figure(1234.0) == "1,230" and figure(None) == "-"


def test_the_check_itself_sees_a_wrong_figure():
    text = page("README.md")
    wrong = text.replace(
        "| times faster than filterpy, one joint update | ", "| times faster than filterpy, one joint update | 9"
    )
    assert wrong != text and quoted(wrong, RUN) == quoted(text, RUN) != wrong
