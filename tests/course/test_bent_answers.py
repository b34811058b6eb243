"""Wrong answers that nobody has listed, for every exercise: the solution, bent in one place.

A result changed, an input not used, an answer for one case only, an input written to: all must be rejected. The same
numbers in lists, or with rounding errors, must pass.
"""

from functools import cache

import numpy as np
import pytest

from ekfslam_tutorial.course import guard, registry
from ekfslam_tutorial.course.exercise import Exercise

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Casting complex")  # of bent answers
FUNCTIONS = [exercise for exercise in registry.everything() if isinstance(exercise, Exercise)]
every_function = pytest.mark.parametrize("exercise", FUNCTIONS, ids=lambda e: e.id)


@pytest.fixture(autouse=True)
def no_hints(monkeypatch):
    """The verdict is asked for here, not which mistake it was: that takes most of the time, and is tested elsewhere."""
    monkeypatch.setattr(Exercise, "_recognised", lambda *_: [])


@cache
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
        if isinstance(parts[part], (np.ndarray, np.floating)):
            parts[part] = change(np.array(parts[part]))
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
