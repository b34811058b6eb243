"""One look in all notebooks: the drawings' source says with which colours, colour maps and axis labels they draw."""

import ast
import re
from pathlib import Path

import pytest

from ekfslam_tutorial.course import draws

MODULES = sorted(Path(draws.__file__).parent.glob("*.py"))
every = pytest.mark.parametrize("path", MODULES, ids=lambda p: p.stem)

ROLE = re.compile(r"(the )?(truth|true (path|landmarks?|robot|places?|heading)|estimates?|estimated \w+)\b")
UNIT = re.compile(r"\[[^\]]*\]$")  # x [m]: a unit stands in round brackets, x (m)
BOTH_SIDES = {"PuOr", "PuOr_r", "RdBu", "RdBu_r", "RdYlBu", "BrBG", "PiYG", "bwr", "coolwarm", "seismic", "Spectral"}
CORRELATION = "PuOr_r"  # as in graphics.panels.covariance_panel


def calls(path):
    return [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.Call)]


def words(node):
    """The text of a string or f-string; what is computed in it as a star."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "*" for part in node.values)
    return ""


def by_hand(path):
    """Marks of truth or estimate whose colour or marker is given by hand, and not by a style."""
    for call in calls(path):
        given = {k.arg: k.value for k in call.keywords}
        if isinstance(call.func, ast.Attribute) and call.func.attr == "plot" and ROLE.match(words(given.get("label"))):
            formats = [words(a) for a in call.args if words(a)]
            if formats or given.keys() & {"color", "c", "marker"}:
                yield f"line {call.lineno}: {ast.unparse(call)[:100]}"


def labels(path):
    for call in calls(path):
        for key in call.keywords:
            if key.arg in ("xlabel", "ylabel", "zlabel"):
                yield call.lineno, words(key.value)
        if ast.unparse(call.func).endswith(("set_xlabel", "set_ylabel", "set_zlabel")) and call.args:
            yield call.lineno, words(call.args[0])


@every
def test_truth_and_estimate_have_the_look_of_their_styles(path):
    assert list(by_hand(path)) == []


@every
def test_units_of_axes_stand_in_round_brackets(path):
    assert [f"line {n}: {text}" for n, text in labels(path) if UNIT.search(text)] == []


@every
def test_the_axes_of_a_map_are_x_and_y_in_metres(path):
    assert [f"line {n}: {text}" for n, text in labels(path) if text.strip() in ("x", "y", "z", "x, m", "y, m")] == []


@every
def test_correlations_have_one_colour_map(path):
    maps = [k.value for call in calls(path) for k in call.keywords if k.arg == "cmap"]
    assert [words(m) for m in maps if words(m) in BOTH_SIDES - {CORRELATION}] == []


def test_the_rules_find_what_they_look_for(tmp_path):
    wrong = tmp_path / "nb99.py"
    wrong.write_text(
        "ax.plot(x, y, color=BLACK, label='true path')\nax.plot(x, y, 'k--', label=f'truth {n}')\n"
        "ax.plot(x, y, **line(TRUTH), label='true path')\nax.plot(x, y, color=BLUE, label='true error')\n"
        "ax.set(xlabel='x [m]', ylabel='y (m)')\nax.set_xlabel('x')\n"
    )
    assert [text.split(":")[0] for text in by_hand(wrong)] == ["line 1", "line 2"]
    assert list(labels(wrong)) == [(5, "x [m]"), (5, "y (m)"), (6, "x")]
