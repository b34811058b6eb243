"""An exercise whose answers are values, not a function: yes or no, a shape, one of a few letters."""

from __future__ import annotations

import ast
import difflib
import numbers
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .exercise import Misconception, Variant, Verdict

WORDS = {"true": True, "yes": True, "y": True, "false": False, "no": False, "n": False}


@dataclass(frozen=True)
class Question:
    """One entry of the student's dictionary."""

    key: str
    right: Any
    comment: str  # above the entry, in the notebook
    help: str  # for a wrong answer that nobody foresaw
    wrong: dict = field(default_factory=dict)  # answer: hint


class Reference(dict):
    """The right answers as `check` hands them out: they know what they are."""


class Quiz:
    """Questions answered in one dictionary, in an exercise cell of the form ``answers = {"key": ..., }``.

    Parameters
    ----------
    id, title : str
    hints : sequence of three str
    name : str
        What the dictionary is called in the notebook.
    """

    may_change = ()

    def __init__(self, id, title, hints, name="answers"):
        self.id, self.title, self.hints, self.name = id, title, tuple(hints), name
        self.questions: list[Question] = []

    def ask(self, key, right, comment, help, wrong=None):
        """Add a question.

        Parameters
        ----------
        key : str
            The entry of the dictionary.
        right : bool, tuple of int, or str
            The answer: yes or no, the shape of a matrix, or a letter.
        comment : str
            The question in a few words; it stands above the entry.
        help : str
            What to tell for a wrong answer that is not in `wrong`.
        wrong : dict, optional
            Wrong answers and the hint for each.
        """
        self.questions.append(Question(key, right, comment, help, dict(wrong or {})))

    @property
    def reference(self) -> dict:
        """The right answers."""
        return Reference((q.key, q.right) for q in self.questions)

    def is_reference(self, answer) -> bool:
        """Return True if these are the right answers as an earlier check has handed them out."""
        return isinstance(answer, Reference)

    def in_arrays(self, answer):
        """Return the answers: there is nothing to be made an array."""
        return answer

    @property
    def misconceptions(self) -> list[Misconception]:
        """The right answers with one of them made wrong, for each wrong answer that is foreseen."""
        return [
            Misconception(f"{q.key} = {answer!r}", hint, {**self.reference, q.key: answer})
            for q in self.questions
            for answer, hint in q.wrong.items()
        ]

    @property
    def variants(self) -> list[Variant]:
        """The right answers in other spellings."""
        return [
            Variant("as words and lists", {key: _respelled(value) for key, value in self.reference.items()}),
            Variant("in another order", dict(reversed(self.reference.items()))),
        ]

    def source(self) -> str:
        """Return the right answers as text for a notebook cell."""
        return self.text({q.key: f'"{q.right}"' if isinstance(q.right, str) else repr(q.right) for q in self.questions})

    def stub(self) -> str:
        """Return the text of the exercise cell as a student gets it."""
        return self.text({q.key: "..." for q in self.questions})

    def text(self, values) -> str:
        """Return a cell that assigns the dictionary, each question above its entry."""
        lines = [line for q in self.questions for line in (f"    # {q.comment}", f'    "{q.key}": {values[q.key]},')]
        return "\n".join([f"{self.name} = {{", *lines, "}"])

    def judge(self, answer) -> Verdict:
        """Compare the answers one by one; the first that is missing or wrong is told."""
        if answer is None or answer is Ellipsis:
            return Verdict("not attempted")
        if not isinstance(answer, dict):
            message = f"`{self.name}` must be the dictionary of the exercise cell, got {type(answer).__name__}"
            return Verdict("failed", "is a dictionary", message, 'Keep the form {"question": answer, ...}.')
        if all(_empty(answer.get(q.key)) for q in self.questions) and answer.keys() <= self.reference.keys():
            return Verdict("not attempted")
        for q in self.questions:
            if q.key not in answer:
                return Verdict("failed", q.key, self._no_entry(q.key, answer), "Do not rename the entries.")
            verdict = _judge_one(q, answer[q.key])
            if verdict:
                return verdict
        return Verdict("passed")

    def _no_entry(self, key, answer):
        strange = [str(k) for k in answer if k not in self.reference]
        near = difflib.get_close_matches(key, strange, 1)
        return f"there is no entry '{key}'" + (f", but there is '{near[0]}'" if near else "")


def read_quizzes(path: Path) -> list[Quiz]:
    """Return the quizzes of a TOML file.

    A table `[[quiz]]` for each, with id, title, hints, perhaps name, and ask: a text in which each question is a line
    with its key, the right answer, and what stands above the entry. Below it, indented, stand the wrong answers that
    are foreseen, each with its hint, and last the help for all others::

        shape_H = (2, 3) | shape of H, the derivative of [range, bearing] by the pose?
            (3, 2): That is the transpose: rows are outputs, columns are inputs.
            else: Rows: outputs. Columns: inputs.

    Raises
    ------
    ValueError
        If the file has another form; the file and the question are named.
    """
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
        return [_quiz(table) for table in found["quiz"]]
    except (ValueError, KeyError, TypeError) as error:
        what = f"it has no {error}" if isinstance(error, KeyError) else error
        raise ValueError(f"{path.name} is not a file of quizzes: {what}") from None


def _quiz(table) -> Quiz:
    options = {key: table[key] for key in table if key not in ("id", "title", "hints", "ask")}
    quiz = Quiz(table["id"], table["title"], table["hints"], **options)
    for key, right, comment, answers in _questions(table["ask"]):
        if "else" not in answers:
            raise ValueError(f"question {key!r} of quiz {quiz.id} has no line `else: ...`, the help for other answers")
        help = answers.pop("else")
        quiz.ask(key, right, comment, help, answers)
    return quiz


def _questions(text):
    """Key, right answer, comment and hints of each question in a text."""
    found: list[tuple[str, Any, str, dict]] = []
    for line in filter(str.strip, text.splitlines()):
        asked = re.fullmatch(r"(\w+) = (.+?) \| (.+)", line)
        answer = re.fullmatch(r"\s+(.+?): (.+)", line)
        if asked:
            found.append((asked[1], _value(asked[2]), asked[3], {}))
        elif answer and found:
            found[-1][3][_value(answer[1])] = answer[2]
        else:
            raise ValueError(
                f"a line is `key = right answer | question` or, below it, `    answer: hint`; got {line!r}"
            )
    return found


def _value(text):
    """The answer that is written so: a shape, a number, True or False; anything else is a letter or a word."""
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def _judge_one(q: Question, value) -> Verdict | None:
    if _empty(value):
        return Verdict("failed", q.key, "not answered yet", q.comment)
    got = _plain(value, q.right)
    if got is None:
        return Verdict("failed", q.key, f"{value!r:.60} is not an answer: give {_kind(q.right)}", q.comment)
    if got == q.right:
        return None
    for answer, hint in q.wrong.items():
        if _plain(answer, q.right) == got:
            return Verdict("failed", q.key, f"{value!r:.60} is wrong", hint, f"{q.key} = {answer!r}")
    return Verdict("failed", q.key, f"{value!r:.60} is wrong", q.help)


def _empty(value) -> bool:
    return value is None or value is Ellipsis or (isinstance(value, str) and not value.strip(" ."))


def _plain(value, like):
    """The answer in the type of `like`, or None if it cannot be one."""
    try:
        if isinstance(like, bool):
            if isinstance(value, str):
                return WORDS.get(value.strip().lower())
            return bool(value) if value in (0, 1) else None
        if isinstance(like, tuple):
            return _shape(value)
        if isinstance(like, str):
            return value.strip(" ()[].'\"").lower() if isinstance(value, str) else None
        if isinstance(value, numbers.Number) and not isinstance(value, bool):
            return value
    except (TypeError, ValueError):
        pass
    return None


def _shape(value):
    if isinstance(value, str):
        value = value.strip(" ()[]").lower().replace("×", "x").replace(",", "x").split("x")
        value = [int(v) for v in value if str(v).strip()]
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        value = (value,)
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, Sequence) and all(float(v) == int(v) for v in value):
        return tuple(int(v) for v in value)
    return None


def _kind(right) -> str:
    if isinstance(right, bool):
        return "True or False"
    if isinstance(right, tuple):
        return "a shape such as (2, 3)"
    return "one of the letters" if isinstance(right, str) else "a number"


def _respelled(value):
    if isinstance(value, bool):
        return "Yes" if value else "no"
    if isinstance(value, tuple):
        return list(value)
    return f" ({value.upper()}) " if isinstance(value, str) else value
