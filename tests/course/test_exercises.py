"""Every exercise of every notebook: right answers pass, wrong ones are told what is wrong, nothing breaks a check.

The exercises are found by `registry.everything()`: a new one is tested without a new line here.
"""

import time

import numpy as np
import pytest

from ekfslam_tutorial.course import guard, registry
from ekfslam_tutorial.course.exercise import Exercise

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Casting complex")  # of bent answers
ALL = registry.everything()
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
    started = time.perf_counter()
    verdict = exercise.judge(exercise.reference)
    assert verdict.passed, f"{verdict.link}: {verdict.message}"
    assert time.perf_counter() - started < 1.0  # the limit for a student, who may be slower, is 1.5 s


@pytest.mark.parametrize("pair", WRONG, ids=name)
def test_a_misconception_is_rejected_with_its_own_hint(pair):
    exercise, misconception = pair
    started = time.perf_counter()
    verdict = exercise.judge(misconception.answer)
    assert verdict.status == "failed", f"{verdict.status}"
    assert verdict.misconception == misconception.name, f"{verdict.link}: {verdict.message}"
    assert verdict.hint == misconception.hint
    assert time.perf_counter() - started < 2.0


@pytest.mark.parametrize("pair", RIGHT, ids=name)
def test_a_variant_is_accepted(pair):
    exercise, variant = pair
    verdict = exercise.judge(variant.answer)
    assert verdict.passed, f"{verdict.link}: {verdict.message}"


@every
def test_an_exercise_has_enough_of_everything(exercise):
    assert len(exercise.misconceptions) >= 2 and len(exercise.variants) >= 1
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


@every
@pytest.mark.parametrize("what", NONSENSE)
def test_nonsense_fails_in_a_sentence(exercise, what):
    verdict = exercise.judge(NONSENSE[what])
    assert verdict.status == "failed"
    assert verdict.link and verdict.message and verdict.hint
    assert len(verdict.message) < 1000


# --- wrong answers that nobody has listed: the solution, bent in one place ---


def calls_of(exercise):
    """The arguments that the links use on the solution, and its results."""
    f = guard.Guarded(exercise.solution, exercise.may_change)
    assert exercise._first_failure(f, [exercise.links[0]]) is None
    return f.calls


def as_parts(result):
    return (list(result), True) if isinstance(result, tuple) else ([result], False)


def bend_result(exercise, part, change):
    """The solution with one of its results changed."""

    def answer(*args):
        parts, several = as_parts(exercise.solution(*args))
        if isinstance(parts[part], np.ndarray):
            parts[part] = change(parts[part].copy())
        return tuple(parts) if several else parts[0]

    return answer


def one_entry(a):
    """Change the entry that is largest in magnitude, by a tenth."""
    if a.size:
        i = np.unravel_index(np.argmax(np.abs(a)), a.shape)
        a[i] *= 1.1
    return a


def smallest_entry(a):
    """Change the smallest entry that is not zero, by a tenth."""
    if np.any(a):
        size = np.where(a == 0, np.inf, np.abs(a))
        i = np.unravel_index(np.argmin(size), a.shape)
        a[i] *= 1.1
    return a


BENDS = {
    "negative": lambda a: -a,
    "transposed": lambda a: a.T.copy(),
    "doubled": lambda a: 2 * a,
    "one per cent off": lambda a: 1.01 * a,
    "zero": lambda a: 0 * a,
    "in degrees": np.degrees,
    "squared": lambda a: a * np.abs(a),
    "reversed": lambda a: a[::-1].copy(),
    "rounded to whole numbers": np.round,
    "cut to int": lambda a: a.astype(int),
    "a column": lambda a: a[:, None] if a.ndim == 1 else a[..., None],
    "flat": lambda a: a.ravel() if a.ndim > 1 else a[None],
    "one row too many": lambda a: np.concatenate([a, a[:1]]) if len(a) else np.ones((1, *a.shape[1:])),
    "not finite": lambda a: a + np.inf,
    "largest entry off": one_entry,
    "smallest entry off": smallest_entry,
    "diagonal only": lambda a: np.diag(np.diag(a)) if a.ndim == 2 and a.shape[0] == a.shape[1] else a,
    "diagonal missing": lambda a: a - np.diag(np.diag(a)) if a.ndim == 2 and a.shape[0] == a.shape[1] else a,
}


def differs(exercise, answer, calls):
    """Whether an answer is wrong on what the links ask, modulo what the exercise takes as equal."""
    for call in calls:
        try:
            got = answer(*call.args)
        except Exception:
            return True
        a, b = got, call.result
        if exercise.canonical is not None:
            try:
                a, b = exercise.canonical(a), exercise.canonical(b)
            except Exception:
                return True
        if not guard.equal(a, b, rtol=1e-4, atol=1e-7):
            return True
    return False


@every_function
def test_a_bent_result_is_rejected(exercise):
    calls, tried = calls_of(exercise), 0
    for part in range(len(as_parts(calls[0].result)[0])):
        for name, change in BENDS.items():
            answer = bend_result(exercise, part, change)
            if differs(exercise, answer, calls):
                tried += 1
                assert exercise.judge(answer).status == "failed", f"result {part} {name}: accepted"
    assert tried >= 10


def zero_entry(place):
    def change(a):
        a[place] = 0
        return a

    return change


def input_bends(value):
    """Ways to misuse one array argument: an entry ignored, a matrix transposed, only its diagonal used."""
    yield "negated", lambda a: -a
    yield "taken as zero", lambda a: 0 * a
    if value.ndim == 2 and value.shape[0] == value.shape[1]:
        yield "reduced to its diagonal", lambda a: np.diag(np.diag(a))
        yield "replaced by the identity", lambda a: np.eye(len(a))
        yield "squared", lambda a: a @ a
    if value.ndim == 1:
        for i in range(min(len(value), 3)):
            yield f"without entry {i}", zero_entry(i)


def bend_argument(exercise, index, change):
    def answer(*args):
        args = list(args)
        if isinstance(args[index], np.ndarray):
            args[index] = change(args[index].astype(float).copy())
        return exercise.solution(*args)

    return answer


@every_function
def test_an_input_that_is_not_used_rightly_is_noticed(exercise):
    calls, names = calls_of(exercise), exercise.parameters()
    for index, name in enumerate(names):
        values = [call.args[index] for call in calls if isinstance(call.args[index], np.ndarray)]
        for value in values[:1]:
            for how, change in input_bends(value):
                answer = bend_argument(exercise, index, change)
                if differs(exercise, answer, calls):
                    assert exercise.judge(answer).status == "failed", f"`{name}` {how}: accepted"


@every_function
def test_an_answer_for_one_case_only_is_rejected(exercise):
    first = calls_of(exercise)[0].result
    assert exercise.judge(lambda *args: first).status == "failed", "the first result, whatever the arguments: accepted"
    kept = []

    def remembers(*args):
        kept.append(exercise.solution(*args))
        return kept[0] if len(kept) > 3 else kept[-1]

    assert exercise.judge(remembers).status == "failed", "an old result after some calls: accepted"


@every_function
def test_a_changed_input_is_noticed(exercise):
    for index, name in enumerate(exercise.parameters()):
        if name in exercise.may_change:
            continue

        def changes(*args, index=index):
            result = exercise.solution(*args)
            if isinstance(args[index], np.ndarray) and args[index].size:
                args[index].flat[0] += 1
            elif isinstance(args[index], list):
                args[index].append(0)
            return result

        verdict = exercise.judge(changes)
        array = any(isinstance(c.args[index], (np.ndarray, list)) for c in calls_of(exercise))
        if array:
            assert verdict.status == "failed" and f"`{name}`" in verdict.message, f"`{name}` changed: {verdict}"


@every_function
def test_right_numbers_in_other_containers_pass(exercise):
    def listed(value):
        return value.tolist() if isinstance(value, np.ndarray) else value

    def lists(*args):
        parts, several = as_parts(exercise.solution(*args))
        return tuple(listed(p) for p in parts) if several else listed(parts[0])

    def other_order(*args):
        parts, several = as_parts(exercise.solution(*args))
        parts = [np.asfortranarray(p) if isinstance(p, np.ndarray) else p for p in parts]
        return list(parts) if several else parts[0]

    def tiny_error(*args):
        parts, several = as_parts(exercise.solution(*args))
        parts = [p * (1 + 1e-12) if isinstance(p, np.ndarray) and p.dtype.kind == "f" else p for p in parts]
        return tuple(parts) if several else parts[0]

    def prints(*args):
        print("x" * 10_000)
        return exercise.solution(*args)

    for answer in (lists, other_order, tiny_error, prints):
        verdict = exercise.judge(answer)
        assert verdict.passed, f"{answer.__name__}: {verdict.link}: {verdict.message}"


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
