"""`make notebooks`: what it stores, and what it refuses to store."""

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from tools import build_notebooks


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a notebook 07_trial.ipynb of the given cells."""

    def write(*cells):
        path = tmp_path / "07_trial.ipynb"
        nbformat.write(new_notebook(cells=list(cells)), path)
        return path

    return write


def test_outputs_are_stored_in_normal_form(write):
    path = write(
        new_markdown_cell("# Title"),
        new_code_cell("print('a', end='')\nprint('b')", execution_count=7, metadata={"collapsed": True}),
        new_code_cell("1 + 1", metadata={"tags": ["check"], "execution": {"iopub.status.busy": "now"}}),
        new_code_cell(
            "import ipywidgets\nipywidgets.IntSlider()", metadata={"tags": ["nbval-ignore-output"]}, id="07-mine"
        ),
    )
    assert build_notebooks.main([str(path)]) == 0
    nb = nbformat.read(path, as_version=4)
    title, printed, value, widget = nb.cells

    assert [cell.id for cell in nb.cells] == ["07-text-1", "07-code-1", "07-check-1", "07-mine"]
    assert [cell.execution_count for cell in nb.cells[1:]] == [1, 2, 3]
    assert [output.text for output in printed.outputs] == ["ab\n"]
    assert printed.metadata == {} and value.metadata == {"tags": ["check"]}
    assert value.outputs[0].data == {"text/plain": "2"} and value.outputs[0].execution_count == 2
    assert list(widget.outputs[0].data) == ["text/plain"] and "IntSlider" not in str(widget.outputs)
    assert "widgets" not in nb.metadata and "version" not in nb.metadata.language_info

    once = path.read_bytes()
    assert build_notebooks.main([str(path)]) == 0
    assert path.read_bytes() == once


@pytest.mark.parametrize(
    "source, reason",
    [
        ("1 / 0", "ZeroDivisionError"),
        ("import ipywidgets\nipywidgets.IntSlider()", "not tagged"),
        ("import os\nos.getcwd()", "path of this computer"),
        ("from IPython.display import HTML\nHTML('x' * 700_000)", "the limit is 600 kB"),
    ],
)
def test_a_refused_notebook_keeps_its_file(write, capsys, monkeypatch, source, reason):
    path = write(new_code_cell(source))
    monkeypatch.setattr(build_notebooks, "ROOT", path.parent)
    before = path.read_bytes()
    assert build_notebooks.main([str(path)]) == "Not stored: 07_trial.ipynb."
    assert reason in capsys.readouterr().out
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_an_allowed_error_is_refused_too(write, capsys):
    path = write(new_code_cell("1 / 0", metadata={"tags": ["raises-exception"]}))
    assert build_notebooks.main([str(path)]) != 0
    assert "ends in ZeroDivisionError" in capsys.readouterr().out
