"""Answers come after questions: each prediction has its answer folded below it, each "Break it" a debrief."""

import json
import re

import pytest

from ekfslam_tutorial.course import build

PATHS = sorted(build.notebooks_folder().glob("*.ipynb"))
every = pytest.mark.parametrize("path", PATHS, ids=lambda p: p.name)

QUESTION = re.compile(r"\*\*Predict(?: before you run)?[.:]\*\*|\*\*Predict before you run\b")
FOLD = re.compile(r"<details><summary>(Answer|Debrief)</summary>\n\n.*?\n\n</details>", re.DOTALL)
LETTER = re.compile(r"^\*\*\([a-d]\)\*\*[.,:]", re.MULTILINE)  # how an answer begins; an option goes on with words


def texts(path):
    """The text cells, in order."""
    cells = json.loads(path.read_text("utf-8"))["cells"]
    return [build.source(cell) for cell in cells if cell["cell_type"] == "markdown"]


@every
def test_each_prediction_has_its_answer_folded_before_the_next_one(path):
    whole = "\n".join(texts(path))
    questions = [found.start() for found in QUESTION.finditer(whole)] + [len(whole)]
    assert len(questions) > 1
    for begin, end in zip(questions, questions[1:], strict=False):
        assert FOLD.search(whole, begin, end), f"no folded answer: {whole[begin : begin + 120]}"


@every
def test_no_answer_stands_open(path):
    for text in texts(path):
        found = LETTER.search(FOLD.sub("", text))
        assert not found, f"an open answer: {text[found.start() : found.start() + 100]}"


@every
def test_break_it_has_a_folded_debrief_with_numbers(path):
    whole = "\n".join(texts(path))
    section = re.search(r"^## [^\n]*[Bb]reak it.*?(?=^## |\Z)", whole, re.MULTILINE | re.DOTALL)
    assert section, "no section 'Break it'"
    debrief = [fold[0] for fold in FOLD.finditer(section[0]) if fold[1] == "Debrief"]
    assert debrief and re.search(r"\d", debrief[0])


@every
def test_what_is_folded_is_closed_and_in_a_cell_of_its_own(path):
    for text in texts(path):
        assert text.count("<details>") == text.count("</details>") == len(FOLD.findall(text))
        assert "<details>" not in text or FOLD.fullmatch(text.strip())
