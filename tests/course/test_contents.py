"""The tables of contents say what the notebooks on disk say."""

import base64
import io
import json
import re
import shutil

import numpy as np
import pytest
from PIL import Image

from ekfslam_tutorial.course import build, contents

ROOT = build.notebooks_folder().parent
PATHS = sorted(build.notebooks_folder().glob("*.ipynb"))


@pytest.fixture(scope="module")
def found():
    return contents.entries()


def pixels(picture):
    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=float)


def test_every_notebook_is_listed_once(found):
    assert [e.file for e in found] == [p.name for p in PATHS]
    numbers = [int(e.number) for e in found]
    assert sorted(set(numbers)) == numbers and all(e.file.startswith(e.number) for e in found)


def test_the_files_are_what_make_contents_writes():
    stale = [
        str(path.relative_to(ROOT))
        for path, data in contents.wanted(ROOT).items()
        if path.suffix in (".md", ".ipynb") and (not path.is_file() or path.read_bytes() != data)
    ]
    assert stale == [], "run `make contents` and commit what it writes"


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)
def test_the_small_picture_is_that_of_the_notebook(path):
    """Another version of the image library may pack the same picture otherwise: the pixels count, not the bytes."""
    entry = contents.entry(path)
    stored = (ROOT / "docs" / "images" / "notebooks" / f"{entry.number}.png").read_bytes()
    assert len(stored) <= 30_000
    assert pixels(stored).shape == pixels(entry.picture).shape
    assert abs(pixels(stored) - pixels(entry.picture)).mean() < 2, "run `make contents`"  # of 255


def test_notebook_00_lists_the_course_and_is_complete_alone(found):
    notebook = json.loads((build.notebooks_folder() / found[0].file).read_text(encoding="utf-8"))
    (cell,) = (c for c in notebook["cells"] if c["id"] == contents.CELL)
    assert build.source(cell) == build.source(contents.cell(found)), "run `make contents`"
    assert re.findall(r"\[\d\d [^]]+\]\(([^)]+)\)", build.source(cell)) == [e.file for e in found]
    for name in re.findall(r"\(attachment:([^)]+)\)", build.source(cell)):
        stored = (ROOT / "docs" / "images" / "notebooks" / name).read_bytes()
        assert base64.b64decode(cell["attachments"][name]["image/png"]) == stored


def test_an_entry_says_all(found):
    for e in found:
        assert 10 <= e.minutes <= 180 and 5 <= e.lecture_minutes <= 20
        assert 2 <= len(e.objectives.split(";")) <= 5, e.number  # four, and one for a project
        assert len(e.alt) > 30


def test_tracks_hold_what_is_there(found):
    text = contents.tracks([e for e in found if int(e.number) <= 5])
    minutes = sum(e.minutes for e in found if int(e.number) <= 5)
    assert f"| two lectures: mapping, then SLAM | 00 to 05 | {minutes / 60:.1f} h |" in text
    assert "3D only" not in text
    assert contents.runs([0, 1, 2, 5, 7, 8]) == "00 to 02, 05, 07 to 08"


@pytest.fixture
def course(tmp_path):
    """A small repository: two notebooks, and a README with a place for the table."""
    (tmp_path / "notebooks").mkdir()
    for path in PATHS[:2]:
        shutil.copy(path, tmp_path / "notebooks")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    (tmp_path / "README.md").write_text(f"above\n{contents.BEGIN}old{contents.END}\nbelow\n", encoding="utf-8")
    return tmp_path


def test_refresh_writes_once_and_follows_a_change(course):
    tables, pictures = {"README.md", "notebooks.md", PATHS[0].name}, {"00.png", "01.png"}
    assert {p.name for p in contents.refresh(course)} == tables | pictures
    assert contents.refresh(course) == []
    readme = (course / "README.md").read_text(encoding="utf-8")
    assert readme.startswith("above\n") and readme.endswith("\nbelow\n") and "old" not in readme
    path = course / "notebooks" / PATHS[1].name
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r"About \d+ minutes", "About 99 minutes", text), encoding="utf-8")
    assert {p.name for p in contents.refresh(course)} == tables
    assert "| 99 |" in (course / "README.md").read_text(encoding="utf-8")


def test_every_notebook_has_its_doors_below_the_title(found):
    for e in found:
        first, doors = json.loads((build.notebooks_folder() / e.file).read_text(encoding="utf-8"))["cells"][:2]
        assert build.source(first).startswith(f"# {e.number} ") and doors["id"] == f"{e.number}-doors"
        links = re.findall(r"\]\((https://[^)]+)\)", build.source(doors))
        assert len(links) == 3 and all(link.endswith(e.file) for link in links)


def test_the_doors_lead_to_the_repository_of_pyproject(tmp_path):
    (tmp_path / "pyproject.toml").write_text('[project.urls]\nRepository = "https://github.com/me/mine"\n')
    doors = contents.Doors.of(tmp_path)
    assert doors.browser("a.ipynb") == "https://me.github.io/mine/lite/lab/index.html?path=a.ipynb"
    assert doors.binder("a.ipynb") == "https://mybinder.org/v2/gh/me/mine/main?urlpath=lab/tree/notebooks/a.ipynb"
    assert doors.colab("a.ipynb") == "https://colab.research.google.com/github/me/mine/blob/main/notebooks/a.ipynb"
    assert "%pip install git+https://github.com/me/mine`" in doors.long("a.ipynb")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [("About ", "Some ", "minutes"), ("**The question:", "**A question:", "question"), ("# 01", "# One", "title")],
)
def test_a_first_cell_of_another_form_is_refused_with_the_form(course, old, new, said):
    path = course / "notebooks" / PATHS[1].name
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"{path.name}: the first cell has no {said}[\s\S]*Afterwards you can"):
        contents.refresh(course)


def test_the_cell_tagged_thumbnail_gives_the_picture():
    one, two = ({"data": {"image/png": base64.b64encode(x).decode()}, "metadata": {}} for x in (b"1", b"2"))
    cells = [{"metadata": {}, "outputs": [one]}, {"metadata": {"tags": ["thumbnail"]}, "outputs": [two]}]
    assert contents.shown_picture({"cells": cells}, "x")[0] == b"2"
    assert contents.shown_picture({"cells": cells[:1]}, "x")[0] == b"1"
    with pytest.raises(ValueError, match="no stored picture"):
        contents.shown_picture({"cells": []}, "x")
