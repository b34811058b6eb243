"""Collects answers to exercises, right and wrong ones, and checks what the student reads about each."""

import re
from collections import defaultdict

import pytest

from ekfslam_tutorial.course import registry

FOUND = defaultdict(list)  # by the module that they stand in
RIGHT = defaultdict(list)  # the right ones, by the id of the exercise


def answer_to(id, right=False, hint=""):
    """Decorator: an answer to the exercise `id`; for a wrong one, `hint` is a pattern that the student must read."""

    def collect(answer):
        if right:
            RIGHT[id].append(answer)
        FOUND[answer.__module__].append(pytest.param(id, right, hint, answer, id=f"{id}: {answer.__name__}"))
        return answer

    return collect


def check_of(module):
    """Return the test of all answers that stand in a module: its last line."""

    @pytest.mark.parametrize(("id", "right", "hint", "answer"), FOUND[module])
    def the_check_is_right_about_it(id, right, hint, answer):
        verdict = registry.get(id).judge(answer)
        if right:
            assert verdict.passed, f"{verdict.link}: {verdict.message}"
            return
        assert verdict.status == "failed"
        told = f"{verdict.link}: {verdict.message} | {verdict.hint}"
        assert verdict.message and verdict.hint and re.search(hint, told), f"the student reads: {told}"

    return the_check_is_right_about_it
