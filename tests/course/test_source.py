"""`source(function)`: how a figure was made."""

import functools
import importlib
import inspect
import textwrap

import numpy as np
import pytest
from IPython.core.interactiveshell import InteractiveShell

from ekfslam_tutorial.course import source
from ekfslam_tutorial.course.draws import nb05, parts


def test_the_code_of_a_figure_is_shown_as_it_stands_in_its_file():
    shown = source(nb05.slam_map)
    assert shown.code == inspect.getsource(nb05.slam_map).rstrip()
    assert shown.place == "ekfslam_tutorial/course/draws/nb05.py"
    assert str(shown).startswith("def slam_map(x, P, ids, poses):")


def test_the_helpers_of_the_same_module_are_named_and_can_be_shown():
    shown = source(nb05.slam_map)
    assert shown.helpers == ["ranges_of", "map_errors"]  # not those of other modules: true_path, robot, line
    assert shown.ask() == ["source(nb05.ranges_of)", "source(nb05.map_errors)"]
    assert source(nb05.ranges_of).helpers == []
    assert "It uses" not in str(source(nb05.ranges_of))


def test_a_notebook_gets_it_highlighted_and_everybody_else_plain():
    data, _ = InteractiveShell.instance().display_formatter.format(source(nb05.slam_map))
    assert data["text/markdown"].startswith("```python\ndef slam_map(")
    assert data["text/plain"].startswith("def slam_map(")
    for text in data.values():
        assert "From `ekfslam_tutorial/" in text or "# From ekfslam_tutorial/" in text
        assert "source(nb05.map_errors)" in text


def test_what_a_decorator_wraps_is_shown_with_its_decorator():
    @functools.wraps(parts.robot)
    def checked(*args):
        return parts.robot(*args)

    assert source(checked).code == source(parts.robot).code
    assert source(nb05.true_path).place == "ekfslam_tutorial/course/draws/rounds.py"  # imported there


def test_a_name_of_the_module_that_is_a_local_here_is_not_a_helper(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    slam = own_file(
        tmp_path,
        """
        def gate(E, R):
            return E + R


        def correct(x, E, R):
            gate = E + R
            return [gate for x in x]


        def loop(x):
            run = lambda y: correct(gate(y, 1), 1, 1)
            return [run(y) for y in x] or loop(x)
        """,
    )
    assert source(slam.correct).helpers == []
    assert source(slam.loop).helpers == ["correct", "gate"]
    assert source(slam.loop).place == "own_slam.py"  # no path of the student's computer
    assert source(slam.loop).ask()[0] == "source(own_slam.correct)"


def own_file(folder, code):
    (folder / "own_slam.py").write_text(textwrap.dedent(code).lstrip())
    return importlib.import_module("own_slam")


def test_a_function_of_the_notebook_itself():
    shell = InteractiveShell.instance()
    shell.run_cell("from ekfslam_tutorial.course import source\ndef half(x):\n    return x / 2\n")
    shell.run_cell("def quarter(x):\n    return half(half(x))\n\nshown = source(quarter)")
    shown = shell.user_ns["shown"]
    assert shown.place == "this notebook"
    assert shown.ask() == ["source(half)"]


made = {}
exec("def made_by_exec(x):\n    return x\n", made)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("nb05.slam_map", "source() shows a function that is written in Python; got 'nb05.slam_map', a str"),
        (np.add, "source() shows a function that is written in Python; got add, a ufunc"),
        (len, "source() shows a function that is written in Python; got len, a built-in function"),
        (None, "source() shows a function that is written in Python; got None, a NoneType"),
        (parts, "source() shows one function at a time; of parts it can show map_axes, robot, landmarks, "),
        (textwrap, "source() shows one function at a time; of textwrap it can show TextWrapper, wrap, "),
        (made["made_by_exec"], "the source of made_by_exec is not on file"),
        (int, "the source of int is not on file"),
    ],
)
def test_what_has_no_source_gets_one_clear_sentence(given, sentence):
    with pytest.raises(TypeError) as error:
        source(given)
    assert str(error.value).startswith(sentence)
    assert len(str(error.value).splitlines()) == 1
