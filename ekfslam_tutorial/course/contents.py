"""Tables of contents, made from the notebooks' own first cells: ``python -m ekfslam_tutorial.course.contents``.

The first cell of a notebook says its title, its question, how long it takes, what it needs and what it is good
for, always in the same form (`FORM`). The table in the README, the page ``docs/notebooks.md``, the cell of
notebook 00 that lists the course, and the small pictures in them are made from that and from nothing else.
"""

from __future__ import annotations

import base64
import io
import json
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from .build import notebooks_folder, source
from .doors import Doors
from .figures import stored

FORM = """# 10 Title

**The question: ... ?**

About 90 minutes. You need: notebook 01. Cells with the tag `lecture` make a cut of 14 minutes.

**Afterwards you can** do this; do that; and do a third thing."""

TITLE = re.compile(r"# (\d\d) (.+)")
QUESTION = re.compile(r"\*\*The question: (.+\?)\*\*")
MINUTES = re.compile(
    r"About (\d+) minutes\. You need: (.+)\. Cells with the tag `lecture` make a cut of (\d+) minutes\."
)
OBJECTIVES = re.compile(r"\*\*Afterwards you can\*\* (.+)\.")

TRACKS = {
    "the lecture on mapping": range(3),
    "two lectures: mapping, then SLAM": range(6),
    "one term": range(22),
    "3D only": range(10, 18),
    "after one term: lines, an IMU, images": range(22, 25),
}
CELL = "00-contents"  # the cell of notebook 00 that is written here
DOORS = "doors"  # the cell of each notebook, "05-doors", that says where it opens with nothing installed
WIDTH, COLOURS = 320, 64  # of a small picture
BEGIN, END = "<!-- notebooks: written by `make contents` -->\n", "\n<!-- end of notebooks -->"


@dataclass(frozen=True)
class Entry:
    """What the first cell of a notebook says, and the picture that stands for it."""

    file: str
    number: str
    title: str
    question: str
    minutes: int
    needs: str
    lecture_minutes: int
    objectives: str
    picture: bytes  # PNG
    alt: str


def entries(folder: Path | None = None) -> list[Entry]:
    """Return one entry for each notebook of a folder, in order."""
    return [entry(path) for path in sorted((folder or notebooks_folder()).glob("[0-9][0-9]_*.ipynb"))]


def entry(path: Path) -> Entry:
    """Read the first cell of a notebook and its picture.

    Raises
    ------
    ValueError
        Naming the file and the line of the first cell that is missing or has another form.
    """
    notebook = json.loads(path.read_text(encoding="utf-8"))
    first = source(notebook["cells"][0])
    found = {}
    for name, line in ("title", TITLE), ("question", QUESTION), ("minutes", MINUTES), ("objectives", OBJECTIVES):
        match = re.search(rf"^{line.pattern}$", first, re.MULTILINE)
        if match is None:
            raise ValueError(f"{path.name}: the first cell has no {name} in the usual form, which is:\n\n{FORM}")
        found[name] = match.groups()
    picture, alt = shown_picture(notebook, path.name)
    number, title = found["title"]
    minutes, needs, lecture_minutes = found["minutes"]
    return Entry(
        path.name,
        number,
        title,
        found["question"][0][0].upper() + found["question"][0][1:],
        int(minutes),
        needs,
        int(lecture_minutes),
        found["objectives"][0],
        thumbnail(picture),
        alt,
    )


def shown_picture(notebook: dict, name: str) -> tuple[bytes, str]:
    """Return the stored PNG of the cell tagged ``thumbnail``, else the first one, and its alternative text."""
    cells = notebook["cells"]
    chosen = [cell for cell in cells if "thumbnail" in cell["metadata"].get("tags", [])]
    for output in (output for cell in chosen + cells for output in cell.get("outputs", [])):
        kind, code, alt = stored(output) or ("", "", "")
        if kind == "image/png":
            return base64.b64decode(code), alt
    raise ValueError(f"{name}: there is no stored picture; run `make notebooks NB=notebooks/{name}`")


def thumbnail(picture: bytes) -> bytes:
    """Return a small copy of a picture, as PNG."""
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    buffer = io.BytesIO()
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(buffer, format="png", optimize=True)
    return buffer.getvalue()


# --- as text ---


def short_table(found: list[Entry], doors: Doors, folder: str = "notebooks") -> str:
    """Return the table of the README: notebook, question, minutes, where it opens."""
    rows = [
        f"| [{e.number} {e.title}]({folder}/{e.file}) | {e.question} | {e.minutes} | {doors.short(e.file)} |"
        for e in found
    ]
    return "\n".join(["| notebook | question | minutes | open in |", "|---|---|---|---|", *rows])


def long_table(found: list[Entry], folder: str, picture_of: Callable[[Entry], str], doors: Doors | None = None) -> str:
    """Return the table with everything; `picture_of(entry)` is the address of its picture."""
    rows = [
        f"| ![{plain(e.alt)}]({picture_of(e)}) | **[{e.number} {e.title}]({folder}{e.file})** <br> {e.question} "
        f"<br> *Afterwards you can* {e.objectives}.{f' <br> {doors.short(e.file)}' if doors else ''} "
        f"| {e.minutes} | {e.needs} |"
        for e in found
    ]
    return "\n".join(["| | notebook | minutes | you need |", "|---|---|---|---|", *rows])


def plain(text: str) -> str:
    """Return a text that may stand in the alternative text of a picture in a table."""
    return re.sub(r"[\[\]|`*$<>]", "", text) or "A figure of this notebook."


def tracks(found: list[Entry]) -> str:
    """Return the table of the ways through the course, as far as their notebooks are there."""
    rows = []
    for name, numbers in TRACKS.items():
        chosen = [e for e in found if int(e.number) in numbers]
        if chosen:
            hours = sum(e.minutes for e in chosen) / 60
            rows.append(f"| {name} | {runs([int(e.number) for e in chosen])} | {hours:.1f} h |")
    return "\n".join(["| track | notebooks | time |", "|---|---|---|", *rows])


def runs(numbers: list[int]) -> str:
    """Return a list of numbers in short: "00 to 05, 07"."""
    starts = [n for n in numbers if n - 1 not in numbers]
    ends = [n for n in numbers if n + 1 not in numbers]
    return ", ".join(f"{a:02}" if a == b else f"{a:02} to {b:02}" for a, b in zip(starts, ends, strict=True))


def page(found: list[Entry], doors: Doors) -> str:
    """Return the text of ``docs/notebooks.md``."""
    table = long_table(found, "../notebooks/", lambda e: f"images/notebooks/{e.number}.png", doors)
    return f"""# The notebooks

<!-- This page is written by `make contents`, from the first cells of the notebooks. -->

{len(found)} notebooks; the minutes are those of a student who does the exercises. How to project them, to grade
them and to add your own checks: [Teaching with the notebooks](teaching.md). *browser* is a page with Python in it:
nothing to install, [how it works](browser.md).

{tracks(found)}

{table}
"""


def cell(found: list[Entry]) -> dict:
    """Return the cell of notebook 00 that lists the course. Its pictures are attachments: it is complete alone."""
    text = f"""## 10  The course

{tracks(found)}

If you know the EKF for localisation well, do the exercises of notebook 01 and leave out the rest.

{long_table(found, "", lambda e: f"attachment:{e.number}.png")}"""
    pictures = {f"{e.number}.png": {"image/png": base64.b64encode(e.picture).decode()} for e in found}
    lines = text.splitlines(keepends=True)
    return {"attachments": pictures, "cell_type": "markdown", "id": CELL, "metadata": {}, "source": lines}


def with_doors(notebook: dict, e: Entry, doors: Doors) -> dict:
    """Return the notebook with the cell that says where it opens, as its second one."""
    id = f"{e.number}-{DOORS}"
    lines = doors.long(e.file).splitlines(keepends=True)
    first, *others = notebook["cells"]
    others = [c for c in others if c.get("id") != id]
    here = {"cell_type": "markdown", "id": id, "metadata": {}, "source": lines}
    return {**notebook, "cells": [first, here, *others]}


# --- the files ---


def wanted(root: Path) -> dict[Path, bytes]:
    """Return what the files with a table of contents should hold, below the root of the repository."""
    found, doors = entries(root / "notebooks"), Doors.of(root)
    readme = (root / "README.md").read_text(encoding="utf-8")
    if readme.count(BEGIN) != 1 or readme.count(END) != 1:
        raise ValueError(f"README.md has no place for the table, between {BEGIN.strip()} and {END.strip()}")
    before, rest = readme.split(BEGIN)
    files = {
        root / "README.md": f"{before}{BEGIN}\n{short_table(found, doors)}\n{END}{rest.split(END)[1]}",
        root / "docs" / "notebooks.md": page(found, doors),
    }
    notebooks = {root / "notebooks" / e.file: e for e in found}
    contents = {path: with_doors(json.loads(path.read_text("utf-8")), e, doors) for path, e in notebooks.items()}
    start = root / "notebooks" / found[0].file
    notebook = contents[start]
    places = [i for i, c in enumerate(notebook["cells"]) if c.get("id") == CELL]
    if len(places) != 1:
        raise ValueError(f"{start.name} has {len(places)} cells with the id {CELL!r}, and needs one")
    notebook["cells"][places[0]] = cell(found)
    files |= {path: json.dumps(nb, indent=1, ensure_ascii=False) + "\n" for path, nb in contents.items()}
    pictures = {root / "docs" / "images" / "notebooks" / f"{e.number}.png": e.picture for e in found}
    return {path: text.encode("utf-8") for path, text in files.items()} | pictures


def refresh(root: Path) -> list[Path]:
    """Write the files that are not as they should be, and return them."""
    changed = []
    for path, data in wanted(root).items():
        if not path.is_file() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            changed.append(path)
    return changed


def main() -> int:
    """Command line: refresh the repository that this package is in."""
    root = notebooks_folder().parent
    try:
        changed = refresh(root)
    except (OSError, ValueError) as error:
        print(f"contents: {error}", file=sys.stderr)
        return 1
    for path in changed:
        print(f"written: {path.relative_to(root)}")
    print(f"{len(entries(root / 'notebooks'))} notebooks, {len(changed)} files changed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
