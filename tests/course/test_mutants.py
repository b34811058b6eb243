"""Every edit of every expression of a solution that changes a result is rejected by the exercise's check.

Whether an edit changes a result is seen on inputs that the check does not use: those that its links draw from other
seeds. An edit at a limit (`<` for `<=`) changes nothing there, and another noise too little for a truth value or an
index to differ: so each of them must be rejected, or stand in EQUAL with the reason why no answer can differ.
"""

import contextlib

import numpy as np
import pytest

from ekfslam_tutorial.course import deadline, guard, registry
from ekfslam_tutorial.course.exercise import Exercise

from .mutants import OTHER_NOISES, mutants

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
FUNCTIONS = [exercise for exercise in registry.everything() if isinstance(exercise, Exercise)]
A_GATE = "a distance that is the limit itself has the probability zero, and another right formula rounds it otherwise"
EQUAL: dict[tuple[str, str], str] = {  # (id, edit): why it gives the same results
    (
        "07.1",
        "d2 <= chi2.ppf(confidence, np.shape(zs)[1]) -> d2 < chi2.ppf(confidence, np.shape(zs)[1])",
    ): A_GATE,
    ("07.3", "d2 <= chi2.ppf(confidence, len(z)) -> d2 < chi2.ppf(confidence, len(z))"): A_GATE,
    ("07.4", "D[i] > limit -> D[i] >= limit"): A_GATE,
}


def inputs(exercise, seeds=(11, 12)):
    """Return the arguments of the calls that the links make from other seeds."""
    found = []
    for seed in seeds:
        for link in exercise.links:
            f = guard.Guarded(exercise.solution, exercise.may_change, exercise.parameters())
            with contextlib.suppress(Exception):
                link.test(f, np.random.default_rng(seed))
            found += [call.args for call in f.calls[:6]]
    return found[:60]


def changes_a_result(exercise, mutant, known) -> bool:
    """Return True if a result differs, or the mutant fails where the solution does not."""
    return any(not exercise.alike(exercise.result(mutant, args), result) for args, result in known)


def rejected(exercise, mutant) -> bool:
    """Return True if some link of the check fails."""
    f = guard.Guarded(mutant, exercise.may_change, exercise.parameters())
    return exercise._first_failure(f, [exercise.links[0]]) is not None


EQUAL |= {
    ("10.4", "dq[0] >= 0 -> dq[0] > 0"): "a turn by just pi has two rotation vectors, and both are right",
    ("12.3", "p[:, 2] > 0 -> p[:, 2] >= 0"): "z is never zero, the text of the exercise says so",
    ("15.2", "1001 -> 1002"): "a finer grid is as good: the trace may be larger by one part in a thousand",
    ("17.2", "mean >= low -> mean > low"): "a mean that is the limit itself has the probability zero",
    ("17.2", "mean <= high -> mean < high"): "a mean that is the limit itself has the probability zero",
}


MEAN_ONLY = "the mean that is taken here does not depend on the noise"
EQUAL |= {
    (
        "13.2",
        "P_ll = L_F @ P_F @ L_F.T + L_y @ R @ L_y.T + L_n @ N @ L_n.T: N -> np.diag(np.diag(N))",
    ): "N has one row and one column",
    **{
        ("20.2", f"step = np.subtract(predict(x, P, u, U)[0], x_new): U -> {text.format('U')}"): MEAN_ONLY
        for text in OTHER_NOISES
    },
}


@pytest.mark.parametrize("exercise", FUNCTIONS, ids=lambda e: e.id)
def test_every_edit_that_changes_a_result_is_rejected(exercise):
    known = [(args, exercise.result(exercise.solution, args)) for args in inputs(exercise)]
    survivors, tried = [], 0
    for edit, mutant, strict in mutants(exercise.solution):
        if (exercise.id, edit) in EQUAL:
            continue
        tried += 1
        with contextlib.suppress(
            deadline.TookTooLong, guard.NotAttempted
        ):  # an endless loop is stopped in the check, too
            accepted, _ = deadline.run(lambda mutant=mutant: not rejected(exercise, mutant), 5.0)
            differs = lambda mutant=mutant: changes_a_result(exercise, mutant, known)
            if accepted and (strict or deadline.run(differs, 5.0)[0]):
                survivors.append(edit)
    assert not survivors, f"{len(survivors)} of {tried} edits pass the check: " + "; ".join(survivors)
