"""Answers that are in no list of the package, and what the student must read about them."""

import re

import pytest

from ekfslam_tutorial.course import registry


class Probes:
    """Collects answers to exercises, wrong and right ones; `each` makes a test of all of them."""

    def __init__(self):
        self.found = []

    def wrong(self, id, says):
        """Decorator: a wrong answer; `says` is a pattern that must be found in the message or the hint."""
        return lambda answer: self._add(id, says, answer)

    def right(self, id):
        """Decorator: a right answer, written in an unusual way."""
        return lambda answer: self._add(id, None, answer)

    def _add(self, id, says, answer):
        self.found.append(pytest.param(id, says, answer, id=f"{id}: {answer.__name__}"))
        return answer

    @property
    def each(self):
        """Decorator of the test: `test(id, says, answer)`."""
        return pytest.mark.parametrize(("id", "says", "answer"), self.found)


def judged_rightly(id, says, answer):
    """Assert that the check accepts a right answer, and rejects a wrong one with a hint at the right line."""
    verdict = registry.get(id).judge(answer)
    if says is None:
        assert verdict.passed, f"{verdict.link}: {verdict.message}"
        return
    assert verdict.status == "failed"
    told = f"{verdict.link}: {verdict.message} | {verdict.hint}"
    assert verdict.hint and re.search(says, told), f"the student reads: {told}"
