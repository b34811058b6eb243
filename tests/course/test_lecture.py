"""The lecture cut of every notebook: a notebook that runs by itself, and slides that are complete in themselves."""

import ast
import builtins
import json
import re

import pytest

from ekfslam_tutorial.cli import lecture as command
from ekfslam_tutorial.cli import main as ekfslam
from ekfslam_tutorial.course import build, lecture, registry
from ekfslam_tutorial.course.figures import stored

slides = pytest.importorskip("ekfslam_tutorial.course.slides", reason="slides need nbconvert")

PATHS = sorted(build.notebooks_folder().glob("*.ipynb"))
every = pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def code_of(notebook):
    return [build.source(c) for c in notebook["cells"] if c["cell_type"] == "code"]


# --- the cut ---


@every
def test_the_cut_shows_what_is_tagged_and_folds_the_rest(path):
    before = read(path)
    cut = lecture.cut(before)
    assert before == read(path)
    shown = [c for c in cut["cells"] if c["metadata"].get("tags") != ["folded"]]
    assert [c["id"] for c in shown] == [c["id"] for c in lecture.tagged(before)]
    for cell in cut["cells"]:
        assert cell["cell_type"] != "code" or (cell["outputs"] == [] and cell["execution_count"] is None)
        if cell["metadata"].get("tags") == ["folded"]:
            assert cell["metadata"]["jupyter"] == {"source_hidden": True, "outputs_hidden": True}
            assert cell["source"].startswith("%%capture\n")
            assert "raise NotImplementedError" not in cell["source"]


def bound(tree):
    """Names that code binds anywhere in it."""
    names = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and not isinstance(n.ctx, ast.Load)}
    names |= {n.name for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    names |= {n.arg for n in ast.walk(tree) if isinstance(n, ast.arg)}
    names |= {n.name for n in ast.walk(tree) if isinstance(n, ast.ExceptHandler) and n.name}
    imported = (a for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom) for a in n.names)
    return names | {(a.asname or a.name).split(".")[0] for a in imported}


@every
def test_every_name_in_the_cut_is_known_when_it_is_used(path):
    known = set(dir(builtins))
    for text in code_of(lecture.cut(read(path))):
        tree = ast.parse(text.removeprefix("%%capture\n"))
        known |= bound(tree)
        used = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
        assert used <= known, f"unknown in the cut: {used - known}"


def test_the_cut_runs(monkeypatch, capsys):
    for module in "figures", "widgets":
        monkeypatch.setattr(f"ekfslam_tutorial.course.{module}.display", lambda *objects, **options: None)
    space = {"__name__": "__main__"}
    (path,) = (p for p in PATHS if p.name.startswith("00"))
    for text in code_of(lecture.cut(read(path))):
        exec(compile(text.removeprefix("%%capture\n"), path.name, "exec"), space)
    assert space["wrap"] is registry.get("00.1").reference  # no word about an exercise that was not attempted
    assert "not attempted" not in capsys.readouterr().out


def test_a_notebook_without_a_cut_is_refused():
    with pytest.raises(ValueError, match="has the tag 'lecture'"):
        lecture.cut({"cells": [{"cell_type": "code", "metadata": {}, "source": "1", "outputs": []}]})


# --- the slides ---


@every
def test_the_slides_hold_all_of_the_cut(path):
    notebook = read(path)
    made = slides.slides(notebook)
    page = "\n".join(slide.html() for slide in made)
    pictures = [stored(o)[1] for c in lecture.tagged(notebook) for o in c.get("outputs", []) if stored(o)]
    assert [slide.kind for slide in made].count("picture") == len(pictures)
    assert all(picture in page.replace("\n", "") for picture in pictures)
    assert page.count("<img alt=") == len(pictures) and '<img alt=""' not in page
    assert made[0].kind == "title" and "The question" in made[0].html()
    assert "Run this cell" not in page and "(5 min)" not in page
    assert 8 <= len(made) <= 30, "10 to 15 minutes"


def cell(kind, text, *outputs, tags=("lecture",)):
    made = {"cell_type": kind, "metadata": {"tags": list(tags)}, "source": text}
    return made | ({"outputs": list(outputs), "execution_count": 1} if kind == "code" else {})


PICTURE = {"output_type": "display_data", "data": {"image/png": "AAAA"}, "metadata": {"image/png": {"alt": "seen"}}}
CAPTION = {"output_type": "display_data", "data": {"text/plain": "two\nlines"}, "metadata": {}}
WIDGET = {"output_type": "display_data", "data": {"text/plain": "VBox()", "application/vnd.x": {}}, "metadata": {}}
FIRST = cell("markdown", "# 05 Name\n\n**The question: why?**\n\nAbout 60 minutes. You need: luck.")


def made_of(*cells):
    return slides.slides({"cells": [FIRST, *cells]})


def test_a_widget_is_its_picture():
    _, slide = made_of(cell("code", "explore(f)", PICTURE, CAPTION, WIDGET))
    assert slide.kind == "picture" and slide.live and len(slide.folded) == 1
    assert [part for part in slide.parts if part][1:] == ['<p class="caption">two lines</p>']


def test_words_stand_where_they_belong():
    picture = cell("code", "show(f)", PICTURE)
    poll, answer = cell("markdown", "Which one? It is this"), cell("markdown", "**(b)**: because.")
    title, slide = made_of(poll, picture, answer)
    assert "Which one" in slide.parts[0] and "because" in slide.parts[-1] and "60 minutes" not in title.html()
    long = cell("markdown", "**(b)**. " + "word " * 40)
    assert [s.kind for s in made_of(picture, long)] == ["title", "picture", "text"]
    two = cell("markdown", "The answer is 3.\n\n## Next (5 min)\n\nNew.")
    assert [s.section for s in made_of(cell("markdown", "## First\n\n$$x$$"), two)] == [
        "05 Name",
        "First",
        "First",
        "Next",
    ]


def test_code_is_shown_where_it_prints_and_folded_elsewhere():
    printed = {"output_type": "stream", "name": "stdout", "text": ["1 < 2\n"]}
    slide = made_of(cell("code", "print(1)", printed))[-1]
    assert slide.kind == "code" and "1 &lt; 2" in slide.parts[-1]
    assert made_of(cell("code", "import numpy as np"))[0].folded


# --- the command ---


def test_the_command_writes_slides(tmp_path, capsys):
    target = tmp_path / "talk.html"
    assert ekfslam(["lecture", "2", "--slides", str(target)]) == 0
    text = target.read_text(encoding="utf-8")
    assert f"{text.count('<section')} slides" in capsys.readouterr().out
    assert not re.findall(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=[\"'](?!data:)", text.split("</head>")[1])
    assert ekfslam(["lecture", "77"]) == 2


def test_slides_into_a_folder_that_is_not_there_blame_the_folder(tmp_path, capsys):
    assert ekfslam(["lecture", "02", "--slides", str(tmp_path / "nowhere" / "y.html")]) == 2
    said = f"ekfslam lecture: there is no folder {tmp_path / 'nowhere'} to write y.html into\n"
    assert capsys.readouterr().err == said


def test_slides_without_mathjax_name_the_cure(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(slides, "MATHJAX", ("no-such-package", "x.js"))
    assert ekfslam(["lecture", "02", "--slides", str(tmp_path / "talk.html")]) == 2
    assert "python -m pip install no-such-package" in capsys.readouterr().err


def test_the_cut_is_opened_alone_with_large_letters_and_no_side_bars(monkeypatch):
    seen = {}

    def run(arguments, env, check):
        (folder,) = (a.split("=")[1] for a in arguments if a.startswith("--notebook-dir"))
        seen["cells"] = read(command.Path(folder, "02_mapping_with_known_poses.ipynb"))["cells"]
        settings = command.Path(env["JUPYTERLAB_SETTINGS_DIR"])
        seen["fonts"] = read(settings / "@jupyterlab" / "apputils-extension" / "themes.jupyterlab-settings")
        seen["arguments"], seen["folder"] = arguments, folder
        (layout,) = command.Path(env["JUPYTERLAB_WORKSPACES_DIR"]).glob("default*")
        seen["layout"] = read(layout)["data"]["layout-restorer:data"]
        return command.subprocess.CompletedProcess(arguments, 0)

    monkeypatch.setattr(command.subprocess, "run", run)
    assert ekfslam(["lecture", "02", "--lab", "--no-browser"]) == 0
    assert seen["arguments"][-1] == "--no-browser" and seen["fonts"]["overrides"] == command.FONTS
    assert any(c["metadata"].get("tags") == ["folded"] for c in seen["cells"])
    assert not seen["layout"]["left"]["visible"] and not seen["layout"]["right"]["visible"]
    assert not command.Path(seen["folder"]).exists()
