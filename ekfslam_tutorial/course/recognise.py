"""Which wrong answer is it? Recognised by what it returns, never by how it is written.

One listed mistake is named if it answers every compared call as the student did. Two listed mistakes at once are named
if both are edits of the solution, and the solution with both of them answers so. Nothing is named by chance: where an
answer has few values (None, True, a small number), one call says little, so more calls are compared, and if mistakes
with different hints still fit, or two pairs of them, none is named.
"""

from __future__ import annotations

import itertools
import time
import warnings

import numpy as np

from . import guard

MOST = 40  # calls that are compared
SURE_BITS = 4.0  # a fit with less evidence than this is chance: one in 16


def recognise(exercise, calls, part=None):
    """Return the mistakes that answer every call as the student did, in the order in which to mend them.

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
        None of them, one, or two.
    """
    half = MOST // 2
    calls = [*calls[:half], *calls[half:][-half:]]
    truth = right_results(exercise, calls)
    if all(exercise.alike(call.result, right) for call, right in zip(calls, truth, strict=True)):
        return []
    wrong = wrong_part(exercise, calls, truth, part)
    if few_values(exercise, calls, wrong):
        return _unlike_chance(exercise, calls, truth, wrong) or _pair_unlike_chance(exercise, calls, truth)
    whole = _fitting(exercise, calls, truth, None)
    if whole:
        return whole
    sample = _sample(exercise, calls, truth, None)
    if not any(isinstance(call.result, guard.Raised) for call in sample):  # two edits that break each other explain all
        pairs = list(_pairs(exercise, calls, sample))
        if len(pairs) == 1:
            return pairs[0]
        if pairs:  # what they have in common is sure
            return [m for m in pairs[0] if all(m in pair for pair in pairs)][:1]
    listed = _fitting(exercise, calls, truth, part) if part is not None else []
    return listed or _any_slip(exercise, calls, truth, part)


def _any_slip(exercise, calls, truth, part):
    """The slip that explains all that is wrong, or else the part that failed; none where the call itself breaks."""
    for of in dict.fromkeys((None, part)):
        sample = _sample(exercise, calls, truth, of)
        if any(isinstance(call.result, guard.Raised) for call in sample):
            return []
        if not any(_has_numbers(call.result) for call in sample):  # no slip of a formula gives that
            return []
        if slip := _slip(exercise, exercise.slips(), sample, of):
            return [slip]
    return []


def _has_numbers(result) -> bool:
    return any(guard.numbers(value) is not None for value in (result if isinstance(result, tuple) else (result,)))


def _slip(exercise, slips, calls, part=None, beside=None):
    """The first slip that answers as the student did, or None; `beside` is what the answer would be without it."""
    beside, began = beside or exercise.solution, time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of slips that make nonsense
        for slip in slips:
            if time.process_time() - began > exercise.patience:
                break
            answer = slip.answer
            if answer is None or not _answers(exercise, answer, calls, part):
                continue
            if part is not None and _contradicts(exercise, slip, calls):
                continue
            if _tells(exercise, slip, beside, calls):
                return slip
    exercise.patience -= time.process_time() - began
    return None


def _tells(exercise, slip, beside, calls) -> bool:
    """Return True if a number with decimals shows the slip: truth values and small integers agree by chance."""
    for call in calls:
        results = [exercise.result(f, call.args) for f in (beside, slip.answer)]
        if any(isinstance(result, guard.Raised) for result in results):
            continue
        parts = range(len(results[0])) if isinstance(results[0], tuple) else (None,)
        for p in parts:
            if not exercise.alike(*results, p) and _has_decimals(results[0] if p is None else results[0][p]):
                return True
    return False


def right_results(exercise, calls):
    """Return what the solution answers to each call."""
    return [exercise.result(exercise.solution, call.args) for call in calls]


def wrong_part(exercise, calls, truth, part):
    """The part of the results that a link is about, if it is wrong in a call; else None: it is another one."""
    return part if any(not exercise.alike(c.result, t, part) for c, t in zip(calls, truth, strict=True)) else None


def with_partner(exercise, calls, known):
    """The mistake that is known, and the one that explains with it what it does not explain alone, if there is one.

    Parameters
    ----------
    exercise : Exercise
    calls : sequence of Call
        Calls in which all right answers give the same.
    known : Misconception
        What was recognised at the link that failed.

    Returns
    -------
    list of Misconception
        One or two, in the order in which to mend them.
    """
    unlike = lambda answer: [c for c in calls if not exercise.alike(c.result, exercise.result(answer, c.args))]
    left = unlike(known.answer)
    if all(isinstance(call.result, guard.Raised) for call in left):
        return [known]
    if not known.edits:
        return [known, *_partner_slip(exercise, calls, left, known)]
    found = []
    for other in exercise.misconceptions:
        both = exercise.composed(known, other) if other.edits and other is not known else None
        if both is not None and _answers(exercise, both, left) and not unlike(both):
            found.append(other)
    if not found:
        return [known, *_partner_slip(exercise, calls, left, known)]
    if len({other.hint for other in found}) != 1:
        return [known]
    if few_values(exercise, calls):
        truth = right_results(exercise, left)
        if _bits(exercise, left, truth, None) < SURE_BITS + np.log2(len(exercise.misconceptions)):
            return [known]
    return sorted((known, found[0]), key=exercise.fails_at)


def _fitting(exercise, calls, truth, part):
    """The first mistake that fits in this part of the results (None: as a whole), as a list."""
    sample = _sample(exercise, calls, truth, part)
    fitting = (m for m in exercise.misconceptions if _answers(exercise, m.answer, sample, part))
    return next(([m] for m in fitting if part is None or not _contradicts(exercise, m, sample)), [])


def _contradicts(exercise, mistake, calls) -> bool:
    """Return True if the mistake spoils a result that the student has right: then it is another one."""
    for call in calls:
        right, wrong = (exercise.result(f, call.args) for f in (exercise.solution, mistake.answer))
        parts = range(len(right)) if isinstance(right, tuple) else ()
        if any(exercise.alike(call.result, right, p) and not exercise.alike(wrong, right, p) for p in parts):
            return True
    return False


def _unlike_chance(exercise, calls, truth, part):
    """The one mistake that fits in all calls, as a list; empty if others fit, too, or if the fit may be chance."""
    found = [m for m in exercise.misconceptions if _answers(exercise, m.answer, calls)]
    if len({m.hint for m in found}) != 1 or _bits(exercise, calls, truth, part) < SURE_BITS:
        return []
    return found[:1]


def _pair_unlike_chance(exercise, calls, truth):
    """The one pair of mistakes that answers all calls; empty if others do, too, or if many may fit by chance."""
    sample = _sample(exercise, calls, truth, None)
    if any(isinstance(call.result, guard.Raised) for call in sample):
        return []
    n = sum(bool(m.edits) for m in exercise.misconceptions)
    if _bits(exercise, calls, truth, None) < SURE_BITS + np.log2(max(n * (n - 1) / 2, 1)):
        return []
    given = [guard.numbers(call.result) for call in calls]
    if all(one is not None and one.dtype.kind == "b" and one.all() for one in given):
        return []  # True to everything: it fits many pairs
    pairs = list(_pairs(exercise, calls, sample))
    return pairs[0] if len(pairs) == 1 else []


def _sample(exercise, calls, truth, part):
    """Some wrong calls, which tell most, and some right ones."""
    right, wrong = [], []
    for call, known in zip(calls, truth, strict=True):
        (right if exercise.alike(call.result, known, part) else wrong).append(call)
    return wrong[-6:] + right[-4:] if wrong else []


def _answers(exercise, answer, calls, part=None) -> bool:
    """Return True if the answer gives what the student's function gave, in every call."""
    return bool(calls) and all(exercise.alike(c.result, exercise.result(answer, c.args), part) for c in calls)


def _pairs(exercise, calls, sample):
    """Two mistakes at once, each an edit of the solution, that together answer as the student did."""
    edits = [m for m in exercise.misconceptions if m.edits]
    for one, other in itertools.combinations(edits, 2):
        both = exercise.composed(one, other)
        if both is not None and _answers(exercise, both, sample) and _answers(exercise, both, calls):  # few, then all
            yield sorted((one, other), key=exercise.fails_at)


def _partner_slip(exercise, calls, left, known):
    """The slip that explains, beside a known mistake, what is left; none if one slip alone explains everything."""
    if not left or _slip(exercise, exercise.slips(), calls[-12:]):
        return []
    slip = _slip(exercise, exercise.slips(known), [*left[-6:], *calls[-6:]], beside=known.answer)
    return [slip] if slip else []


# ---- how much a call says ----------------------------------------------------------------------------------


def few_values(exercise, calls, part=None) -> bool:
    """Return True if no right result, or no such part of it, has decimals: then mistakes coincide by chance."""
    right = [exercise.result(exercise.solution, call.args) for call in calls[:MOST]]
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
        answers = [right, *(exercise.result(m.answer, call.args) for m in exercise.misconceptions)]
        same = sum(exercise.alike(call.result, answer, part) for answer in answers)
        total += np.log2(len(answers) / max(same, 1))
    return total
