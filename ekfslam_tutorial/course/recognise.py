"""Which wrong answer is it? Recognised by what it returns, never by how it is written.

One listed mistake is named if it answers every compared call as the student did. Where none does, a slip of any formula
may, or two of them all (`pairs`). Nothing is named by chance: where an answer has few values (None, True, a small
number), one call says little, so more calls are compared, and if mistakes with different hints still fit, none is
named.
"""

from __future__ import annotations

import numpy as np

from . import guard, own_words, pairs

MOST = 40  # calls that are compared
SURE_BITS = 4.0  # a fit with less evidence than this is chance: one in 16


def recognise(exercise, calls, part=None):
    """Return the listed mistake that answers every call as the student did, as a list.

    Parameters
    ----------
    exercise : Exercise
    calls : sequence of Call
        The student's calls.
    part : int, optional
        The result that failed. A mistake that explains it is named even if another result is wrong, too.

    Returns
    -------
    list of Misconception
        None or one.
    """
    half = MOST // 2
    calls = [*calls[:half], *calls[half:][-half:]]
    truth = right_results(exercise, calls)
    if all(exercise.alike(call.result, right) for call, right in zip(calls, truth, strict=True)):
        return []
    wrong = wrong_part(exercise, calls, truth, part)
    if few_values(exercise, calls, wrong):
        return _unlike_chance(exercise, calls, truth, None, wrong) or _unlike_chance(
            exercise, calls, truth, wrong, wrong
        )
    whole = _fitting(exercise, calls, truth, None)
    return whole or (_fitting(exercise, calls, truth, part) if part is not None else [])


def recognise_more(exercise, calls, part, known, formulas=lambda: None):
    """Return what explains more than the listed mistake that is known, if one is: a pair of mistakes, or a slip.

    Parameters
    ----------
    exercise : Exercise
    calls : sequence of Call
        Calls in which all right answers give the same.
    part : int or None
        The result that failed.
    known : list of Misconception
        What `recognise` has found: none, or one.
    formulas : callable, optional
        Returns the formulas that the student has written, a Counter: what contradicts them is not told.
    """
    left = [call for call in calls if known and not _answers(exercise, known[0].answer, [call])]
    if not calls or known and not left:
        return known
    calls = [*_spread(calls, MOST), *_spread(left, MOST // 2)]
    few = few_values(exercise, calls)
    if not few and not any(_has_numbers(call.result) for call in calls):  # no slip of a formula gives that
        return known
    own = formulas()
    table = pairs.Table(exercise, calls, exercise.patience, few, own)
    if not (table.wrong & np.isfinite(table.s)).any():  # NaN comes of many mistakes: it tells none from the others
        return known
    few = table.few = few or not _has_decimals(table.t[table.wrong])  # what is wrong is what tells
    alone = [change.mistake for change in table.single() if _answers(exercise, change.mistake.answer, calls)]
    if few and len({mistake.hint for mistake in alone}) > 1 and not alone[0].edits:
        alone = []  # several slips come to the same: nobody knows which one it is
    if alone and (not few or not table.constant(table.wrong) and table.bits() >= SURE_BITS + np.log2(len(table.rows))):
        as_if = own_words.of_a_step(alone[0]) and not (own and own_words.written(alone[0], own))
        as_if = as_if or own_words.not_subtracted(alone[0], own)
        if as_if and table.tells:  # rather what students do: two mistakes, or one in another form
            listed = [mistake for mistake in pairs.in_another_form(exercise, calls, own) if mistake.edits]
            return pairs.two_listed(table, calls) or listed or alone[:1]
        return alone[:1]
    if table.tells and (alone := pairs.in_another_form(exercise, calls, own)):
        return alone
    if not known and (alone := table.alone()):
        return [alone[0].mistake]
    if not known and (alone := pairs.by_a_factor(table, calls)):
        return alone
    both = pairs.find(table, calls, exercise.patience)
    for form in pairs.forms_of(exercise, own)[:1] if table.tells and not both and not known else ():
        both = pairs.find(pairs.Table(form, calls, exercise.patience, own=own), calls, exercise.patience)
        both = [pairs.in_form(form, mistake) for mistake in both]
    if both or known or few:
        return both or known
    return [change.mistake for change in table.of_part(part or 0)[:1]]


def _spread(calls, most):
    return [calls[k] for k in np.unique(np.linspace(0, len(calls) - 1, most).astype(int))] if calls else []


def _has_numbers(result) -> bool:
    return any(guard.numbers(value) is not None for value in (result if isinstance(result, tuple) else (result,)))


def as_asked(calls, cases):
    """Return the calls in which what is symmetric in all the cases, a covariance, is symmetric, too.

    A link may hand on what the student's function has returned: what that makes of a P that is none says nothing.
    """
    places = [k for k, column in enumerate(zip(*(c.args for c in cases), strict=False)) if all(map(_symmetric, column))]
    return [call for call in calls if all(_symmetric(call.args[k]) for k in places if k < len(call.args))]


def _symmetric(value) -> bool:
    square = isinstance(value, np.ndarray) and value.ndim == 2 and value.shape[0] == value.shape[1]
    return square and guard.equal(value, value.T, 1e-6, 1e-9)


def right_results(exercise, calls):
    """Return what the solution answers to each call."""
    return [exercise.answered(exercise.solution, call) for call in calls]


def wrong_part(exercise, calls, truth, part):
    """The part of the results that a link is about, if it is wrong in a call; else None: it is another one."""
    return part if any(not exercise.alike(c.result, t, part) for c, t in zip(calls, truth, strict=True)) else None


def _fitting(exercise, calls, truth, part):
    """The first mistake that fits in this part of the results (None: as a whole), as a list."""
    sample = _sample(exercise, calls, truth, part)
    fitting = (m for m in exercise.misconceptions if _answers(exercise, m.answer, sample, part))
    return next(([m] for m in fitting if part is None or not _contradicts(exercise, m, sample)), [])


def _contradicts(exercise, mistake, calls) -> bool:
    """Return True if the mistake spoils a result that the student has right: then it is another one."""
    for call in calls:
        right, wrong = (exercise.answered(f, call) for f in (exercise.solution, mistake.answer))
        parts = range(len(right)) if isinstance(right, tuple) else ()
        if any(exercise.alike(call.result, right, p) and not exercise.alike(wrong, right, p) for p in parts):
            return True
    return False


def _unlike_chance(exercise, calls, truth, of, part):
    """The one mistake that fits in all calls, as a list; empty if others fit, too, or if the fit may be chance.

    It fits in the whole of the results, or in one of them (`of`), if it spoils no other one that is right.
    """
    found = [m for m in exercise.misconceptions if _answers(exercise, m.answer, calls, of)]
    found = [m for m in found if of is None or not _contradicts(exercise, m, calls)]
    if len({m.hint for m in found}) != 1 or _bits(exercise, calls, truth, part) < SURE_BITS:
        return []
    return found[:1]


def _sample(exercise, calls, truth, part):
    """Some wrong calls, which tell most, and some right ones."""
    right, wrong = [], []
    for call, known in zip(calls, truth, strict=True):
        (right if exercise.alike(call.result, known, part) else wrong).append(call)
    return wrong[-6:] + right[-4:] if wrong else []


def _answers(exercise, answer, calls, part=None) -> bool:
    """Return True if the answer gives what the student's function gave, in every call."""
    return bool(calls) and all(exercise.alike(c.result, exercise.answered(answer, c), part) for c in calls)


# ---- how much a call says ----------------------------------------------------------------------------------


def few_values(exercise, calls, part=None) -> bool:
    """Return True if no right result, or no such part of it, has decimals: then mistakes coincide by chance."""
    right = right_results(exercise, calls[:MOST])
    return not any(_has_decimals(value if part is None else value[part]) for value in right)


def _has_decimals(value) -> bool:
    if isinstance(value, dict):
        return any(map(_has_decimals, value.values()))
    if isinstance(value, (list, tuple, set)):
        return any(map(_has_decimals, value))
    if hasattr(value, "__dict__") and not isinstance(value, (type, guard.Raised)) and not callable(value):
        return _has_decimals(vars(value))
    numbers = guard.numbers(value)
    with np.errstate(all="ignore"):
        return numbers is not None and bool(np.any(np.abs(numbers - np.round(np.real(numbers))) > 1e-9))


def _bits(exercise, calls, truth, part) -> float:
    """Evidence in the calls: each says as much as the answers to it differ, the solution's and the listed mistakes'."""
    total = 0.0
    for call, right in zip(calls, truth, strict=True):
        answers = [right, *(exercise.answered(m.answer, call) for m in exercise.misconceptions)]
        same = sum(exercise.alike(call.result, answer, part) for answer in answers)
        total += np.log2(len(answers) / max(same, 1))
    return total
