"""Every exercise of every notebook: right answers pass, wrong ones are told what is wrong, nothing breaks a check.

The exercises are found by `registry.everything()`: a new one is tested without a new line here.
"""

import numpy as np
import pytest

from ekfslam_tutorial.course import guard, registry
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.expect import Failed
from ekfslam_tutorial.course.project import Project
from ekfslam_tutorial.course.quiz import read_quizzes
from tests.pace import within

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Casting complex")  # of bent answers
ALL = [exercise for exercise in registry.everything() if not isinstance(exercise, Project)]  # see test_projects.py
FUNCTIONS = [exercise for exercise in ALL if isinstance(exercise, Exercise)]
WRONG = [(e, m) for e in ALL for m in e.misconceptions]
RIGHT = [(e, v) for e in ALL for v in e.variants]

every = pytest.mark.parametrize("exercise", ALL, ids=lambda e: e.id)
every_function = pytest.mark.parametrize("exercise", FUNCTIONS, ids=lambda e: e.id)


def name(pair):
    return f"{pair[0].id}: {pair[1].name}"


# --- what the module of an exercise promises ---


@every
def test_the_solution_passes_quickly(exercise):
    verdict = within(1.0, lambda: exercise.judge(exercise.reference))  # a student, who may be slower, has 1.5 s
    assert verdict.passed, f"{verdict.link}: {verdict.message}"


@pytest.mark.parametrize("pair", WRONG, ids=name)
def test_a_misconception_is_rejected_with_its_own_hint(pair):
    exercise, misconception = pair
    verdict = within(2.0, lambda: exercise.judge(misconception.answer))
    assert verdict.status == "failed", f"{verdict.status}"
    assert verdict.misconception == misconception.name, f"{verdict.link}: {verdict.message}"
    assert verdict.hint.startswith(misconception.hint)  # what its names mean may stand behind it


@pytest.mark.parametrize("pair", RIGHT, ids=name)
def test_a_variant_is_accepted(pair):
    exercise, variant = pair
    verdict = exercise.judge(variant.answer)
    assert verdict.passed, f"{verdict.link}: {verdict.message}"


@every
def test_an_exercise_has_enough_of_everything(exercise):
    assert len(exercise.misconceptions) >= 2
    assert len(exercise.hints) == 3 and all(len(hint) > 20 for hint in exercise.hints)
    names = [m.name for m in exercise.misconceptions]
    assert len(set(names)) == len(names)
    assert all(m.hint.strip().endswith((".", "?", "!")) for m in exercise.misconceptions)


@every_function
def test_the_text_of_the_solution_stands_alone(exercise):
    # As in a notebook: the names that notebooks import, and the solutions of earlier exercises.
    space = {name: value for name, value in exercise.solution.__globals__.items() if name != exercise.name}
    exec(compile(exercise.source(), "cell", "exec"), space)
    verdict = exercise.judge(space[exercise.name])
    assert verdict.passed, f"{verdict.link}: {verdict.message}"
    assert exercise.solution.__doc__ and exercise.solution.__doc__ in exercise.stub()


# --- what a student may hand in instead ---


WHOLE = {  # id: arguments; what stands in the results whose numbers are no floats
    "14.1": ((np.zeros(9, bool), 3), "i"),
    "14.2": ((np.array([3, 5, 8]), np.array([5]), 1), "ii"),
    "19.2": ((np.array([[1.0, 90.0], [80.0, 70.0]]), 9.2, 25.0), "i"),
    "19.3": ((np.array([3, 4]), np.array([3, 1]), np.array([True, True]), np.array([True, False]), 9, 0.2), "ii"),
}


@pytest.mark.parametrize("id", ["14.1", "14.2", "19.2", "19.3"])
def test_an_index_stays_a_whole_number(id):
    """After a passed check, too: of arrays, of lists, and of arrays of floats, which pass as well."""
    exercise, (args, kinds) = registry.get(id), WHOLE[id]
    for form in np.array, np.ndarray.tolist, lambda a: a.astype(float):
        as_told = lambda *args, form=form: _formed(exercise.solution(*args), form)
        got = exercise.in_arrays(as_told)(*args)
        assert guard.equal(got, exercise.solution(*args))
        parts = got if isinstance(got, tuple) else (got,)
        assert "".join(part.dtype.kind for part in parts[: len(kinds)]) == kinds


def _formed(value, form):
    """A result with its arrays in another form."""
    if isinstance(value, tuple):
        return tuple(_formed(part, form) for part in value)
    return form(value) if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("use", [lambda i: [1, 2][i], lambda i: np.zeros(2)[i], lambda i: np.zeros(2)[np.array([i])]])
def test_an_index_that_is_a_float_is_told(use):
    with pytest.raises(Failed) as told:
        guard.Guarded(lambda x: use(x + 0.0))(1)
    assert "`int(i)`" in told.value.hint and "whole number" in told.value.hint


def stub(*args):
    raise NotImplementedError


@every
@pytest.mark.parametrize("nothing", [None, ..., stub], ids=["None", "...", "stub"])
def test_not_attempted_is_no_failure(exercise, nothing):
    if nothing is stub and not isinstance(exercise, Exercise):
        pytest.skip("a quiz has no stub")
    assert exercise.judge(nothing).status == "not attempted"


def _raise(error):
    raise error


class Odd:
    def __array__(self, *args, **kwargs):
        raise RuntimeError("no array")

    def __len__(self):
        raise RuntimeError("no length")

    def __eq__(self, other):
        raise RuntimeError("no comparison")

    __hash__ = None


NONSENSE = {
    "returns None": lambda *a: None,
    "returns text": lambda *a: "abc",
    "returns a number": lambda *a: 0.0,
    "returns an empty list": lambda *a: [],
    "returns a ragged list": lambda *a: ([[1], [2, 3]], [[1], [2, 3]]),
    "returns NaN": lambda *a: (np.full(2, np.nan), np.full((2, 2), np.nan)),
    "returns complex numbers": lambda *a: (np.full(2, 1j), np.eye(2) * 1j),
    "returns dictionaries": lambda *a: ({1: 2}, {3: 4}),
    "returns a set": lambda *a: {1, 2},
    "returns three of them": lambda *a: (np.zeros(2),) * 3,
    "returns seven of them": lambda *a: (np.zeros(2),) * 7,
    "returns objects": lambda *a: (Odd(), Odd()),
    "returns an object": lambda *a: Odd(),
    "returns a generator": lambda *a: (k for k in range(3)),
    "returns a function": lambda *a: lambda: 0,
    "returns itself": lambda *a: NONSENSE,
    "returns huge arrays": lambda *a: (np.zeros((300, 300)), np.zeros((300, 300))),
    "returns its arguments": lambda *a: a,
    "returns its first argument": lambda *a: a[0],
    "returns booleans": lambda *a: (True, False),
    "returns an Ellipsis": lambda *a: ...,
    "raises": lambda *a: _raise(ValueError("mine")),
    "raises an odd error": lambda *a: _raise(type("E", (Exception,), {"__str__": lambda self: "\n" * 9})()),
    "exits": lambda *a: _raise(SystemExit(3)),
    "interrupts": lambda *a: _raise(KeyboardInterrupt()),
    "stops a generator": lambda *a: _raise(StopIteration()),
    "takes no arguments": lambda: 0,
    "takes too many": lambda a, b, c, d, e, f, g, h, i, j: 0,
    "is a class": Odd,
    "is print": print,
    "is a number": 3,
    "is text": "abc",
    "is an array": np.eye(3),
    "is a list": [1, 2],
    "is an object": Odd(),
    "is a dictionary": {"a": 1},
    "is NaN": float("nan"),
}


IN_TURN = 16
"""The search for the mistake takes nearly all of the time. It is made for one kind of nonsense in so many: the first
exercise takes kinds 0, 16, 32, the second 1, 17, 33 ... So each kind meets it in every sixteenth exercise."""


@every
def test_nonsense_fails_in_a_sentence(exercise, monkeypatch):
    """Each kind of nonsense in each exercise; that the search for its mistake bears it is asked in turn."""
    search, turn = Exercise._recognised, ALL.index(exercise) % IN_TURN
    for k, (what, answer) in enumerate(NONSENSE.items()):
        monkeypatch.setattr(Exercise, "_recognised", search if k % IN_TURN == turn else lambda *_: [])
        verdict = exercise.judge(answer)
        assert verdict.status == "failed", what
        assert verdict.link and verdict.message and verdict.hint, what
        assert len(verdict.message) < 1000, what


# --- quizzes ---


@pytest.mark.parametrize("quiz", [e for e in ALL if not isinstance(e, Exercise)], ids=lambda e: e.id)
def test_a_quiz_takes_each_wrong_value(quiz):
    for q in quiz.questions:
        for value in (
            True,
            False,
            "maybe",
            "z",
            "",
            7,
            -1.5,
            (1,),
            (99, 99),
            [],
            {},
            object(),
            np.zeros(3),
            float("nan"),
        ):
            verdict = quiz.judge({**quiz.reference, q.key: value})
            same = isinstance(value, type(q.right)) and not isinstance(value, np.ndarray) and value == q.right
            assert verdict.passed if same else verdict.status == "failed", (q.key, value, verdict)
            assert verdict.passed or verdict.link == q.key
    part = {q.key: (q.right if i == 0 else ...) for i, q in enumerate(quiz.questions)}
    assert quiz.judge(part).link == quiz.questions[1].key
    assert "no entry" in quiz.judge({k + "s": v for k, v in quiz.reference.items()}).message
    assert eval(quiz.source().split("=", 1)[1]) == quiz.reference
    assert quiz.judge(eval(quiz.stub().split("=", 1)[1])).status == "not attempted"


QUIZ = """
[[quiz]]
id = "99.1"
title = "Sizes"
hints = ["one", "two", "three"]
ask = '''
shape = (2, 3) | what size is it?
    (3, 2): Rows are outputs: the other way round.
    else: Count rows, then columns.
letter = b | which of the two?  a: this  b: that
    a: No: that one.
    else: Look again.
'''
"""


def test_a_quiz_is_read_from_a_text(tmp_path):
    file = tmp_path / "nb99_quiz.toml"
    file.write_text(QUIZ)
    (quiz,) = read_quizzes(file)
    assert quiz.reference == {"shape": (2, 3), "letter": "b"}
    shape, letter = quiz.questions
    assert shape.comment == "what size is it?" and shape.wrong == {(3, 2): "Rows are outputs: the other way round."}
    assert letter.help == "Look again." and letter.wrong == {"a": "No: that one."}


@pytest.mark.parametrize(
    "old, new, told",
    [
        ("    else: Look again.\n", "", "question 'letter' of quiz 99.1 has no line `else: ...`"),
        ("shape = (2, 3) | what", "shape: what", "a line is `key = right answer | question` or, below it"),
        ('title = "Sizes"\n', "", "it has no 'title'"),
        ("hints = [", "hints = ", "is not a file of quizzes"),
    ],
)
def test_a_quiz_in_another_form_is_told(tmp_path, old, new, told):
    file = tmp_path / "nb99_quiz.toml"
    file.write_text(QUIZ.replace(old, new))
    with pytest.raises(ValueError, match="nb99_quiz.toml is not a file of quizzes") as error:
        read_quizzes(file)
    assert told in str(error.value)
