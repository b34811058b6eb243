"""An exercise: what its answer must do, the wrong answers students give, and the help they get.

An exercise module (``exercises/nb02.py``) reads like this::

    def scaled(x, a):
        '''Return a x.'''
        return a * x

    exercise = Exercise("02.9", "Scaling", scaled, hints=("level 1", "level 2", "level 3"))

    @exercise.link("size", "Is every entry multiplied?")
    def _(f, rng):
        x = rng.normal(size=3)
        expect.close(expect.array(f(x, 2.0), 3, "the result"), 2 * x, "the result")

    @exercise.wrong("forgets a", "The factor a has no effect in your function.")
    def _(x, a):
        return x

    @exercise.variant("as a sum")
    def _(x, a):
        return [a * xi for xi in x]

A link is one property of the answer. Links are tested in order, and the first that fails is what the student
is told. A wrong answer is recognised by what it returns, not by how it is written.
"""

from __future__ import annotations

import ast
import inspect
import os
import textwrap
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import deadline, guard
from .expect import Failed

SECONDS = 1.5  # a check is over, whatever the student's function does, in less than 2 s


@dataclass(frozen=True)
class Link:
    """One property of the answer: `test(f, rng)` raises `Failed`; `help` says where to look.

    `part` is the index of the result that the link is about, for a function that returns several.
    """

    name: str
    help: str
    test: Callable
    part: int | None = None


@dataclass(frozen=True)
class Misconception:
    """A named wrong answer and what to tell the student who gives it."""

    name: str
    hint: str
    answer: Any


@dataclass(frozen=True)
class Variant:
    """A right answer that is written differently: the check must accept it."""

    name: str
    answer: Any


@dataclass(frozen=True)
class Verdict:
    """The outcome of a check."""

    status: str  # "passed", "failed", "not attempted"
    link: str = ""  # the link that failed first
    message: str = ""  # what was got, what was expected
    hint: str = ""  # of the misconception if one was recognised, else of the link
    misconception: str = ""
    printed: str = ""
    seconds: float = 0.0
    note: str = ""  # of a project: what was measured

    @property
    def passed(self) -> bool:
        """True if the answer is right."""
        return self.status == "passed"


class Exercise:
    """A function the student writes.

    Parameters
    ----------
    id : str
        Notebook and number, "02.3".
    title : str
    solution : function
        The reference, single source: the fall-back of the notebook, the text of `reveal` and of the solved
        copies. Its signature and docstring are those of the student's stub.
    hints : sequence of three str
        From a nudge to nearly all.
    may_change : sequence of str
        Parameters that the function is asked to change in place.
    canonical : callable, optional
        Applied to results before they are compared with those of wrong answers (an angle modulo 2 pi).
    seconds : float
        Deadline for all calls together.
    """

    def __init__(self, id, title, solution, hints, *, may_change=(), canonical=None, seconds=SECONDS):
        self.id, self.title, self.solution, self.hints = id, title, solution, tuple(hints)
        self.may_change, self.canonical, self.seconds = tuple(may_change), canonical, seconds
        self.links: list[Link] = []
        self.misconceptions: list[Misconception] = []
        self.variants: list[Variant] = []

    # ---- how a module fills it -------------------------------------------------------------------------

    def link(self, name: str, help: str, part: int | None = None):
        """Decorator: the next link, `test(f, rng)`."""

        def add(test):
            self.links.append(Link(name, help, test, part))
            return test

        return add

    def wrong(self, name: str, hint: str):
        """Decorator: a wrong answer that students give, and the hint for it."""

        def add(answer):
            self.misconceptions.append(Misconception(name, hint, answer))
            return answer

        return add

    def variant(self, name: str):
        """Decorator: a right answer in other words."""

        def add(answer):
            self.variants.append(Variant(name, answer))
            return answer

        return add

    # ---- what check needs ------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """The name the student's function has in the notebook."""
        return self.solution.__name__

    @property
    def reference(self):
        """What the notebook goes on with when the answer is missing or wrong."""
        return self.solution

    def source(self) -> str:
        """Return the solution as text for a notebook cell."""
        return textwrap.dedent(inspect.getsource(self.solution)).rstrip()

    def stub(self) -> str:
        """Return the text of the exercise cell as a student gets it: signature and docstring."""
        source = self.source()
        function = ast.parse(source).body[0]
        assert isinstance(function, ast.FunctionDef)
        head = source.splitlines()[: function.body[0].end_lineno]
        return "\n".join([*head, "    raise NotImplementedError  # your code here"])

    def parameters(self) -> list[str]:
        """Return the names of the parameters, as in the stub."""
        return list(inspect.signature(self.solution).parameters)

    def judge(self, answer) -> Verdict:
        """Test an answer. Never raises for what the student has written."""
        started = time.perf_counter()
        if answer is None or answer is Ellipsis or answer is NotImplemented:
            return Verdict("not attempted")
        if not callable(answer):
            hint = f'Hand over the function itself, without brackets: check("{self.id}", {self.name}).'
            return Verdict("failed", "is a function", f"a function is wanted, got {type(answer).__name__}", hint)
        missing = guard.misses_arguments(answer, self.parameters())
        if missing:
            return Verdict("failed", "arguments", missing, "Keep the `def` line of the exercise as it is.")
        f = guard.Guarded(answer, self.may_change, self.parameters())
        limit = self._limit()
        at = [self.links[0]]
        try:
            outcome, printed = deadline.run(lambda: self._first_failure(f, at), limit)
        except guard.NotAttempted:
            return Verdict("not attempted")
        except deadline.TookTooLong:
            message = f"your function took more than {limit:g} s and was stopped"
            return Verdict("failed", at[0].name, message, "Look for a loop that does not end.")
        seconds = time.perf_counter() - started
        if outcome is None:
            return Verdict("passed", printed=printed, seconds=seconds)
        known = None if outcome.certain else self.recognise(f.calls, at[0].part)
        hint = known.hint if known else outcome.hint or at[0].help
        return Verdict("failed", at[0].name, str(outcome), hint, known.name if known else "", printed, seconds)

    def _limit(self) -> float:
        """Seconds after which an answer is stopped."""
        asked = os.environ.get("EKFSLAM_CHECK_SECONDS", self.seconds)
        try:
            return float(asked)
        except ValueError:
            raise ValueError(f"EKFSLAM_CHECK_SECONDS must be a number of seconds, got {asked!r}") from None

    def _first_failure(self, f, at) -> Failed | None:
        """Test the links in order; return the failure of the first that fails. `at[0]` follows."""
        for link in self.links:
            at[0] = link
            try:
                link.test(f, np.random.default_rng(zlib.crc32(f"{self.id} {link.name}".encode())))
            except Failed as failed:
                return failed
            except guard.NotAttempted:
                raise
            except Exception as error:  # a result so odd that the link stumbles over it
                return Failed(f"your result cannot be used ({type(error).__name__}: {error})"[:300])
        return None

    def recognise(self, calls: list[guard.Call], part: int | None = None) -> Misconception | None:
        """Return the misconception that answers every call as the student did, or None.

        Parameters
        ----------
        calls : list of Call
            The student's calls. Those with a wrong result tell most; some right ones are compared, too.
        part : int, optional
            Compare this one of the results first, so that a second mistake elsewhere does not hide the first.
        """
        calls = calls[:20] + calls[20:][-20:]
        truth = {id(call): self._result(self.solution, call.args) for call in calls}
        for p in (part, None) if part is not None else (None,):
            fitting = self._fitting(calls, truth, p)
            if fitting:  # of those that fit in one part, one may fit as a whole
                whole = self._fitting(calls, truth, None) if p is not None else []
                return next((m for m in fitting if m in whole), fitting[0])
        return None

    def _fitting(self, calls, truth, part):
        """The misconceptions that answer as the student did, compared in one part or as a whole."""
        right, wrong = [], []
        for call in calls:
            (right if self._alike(call.result, truth[id(call)], part) else wrong).append(call)
        sample = wrong[-6:] + right[-4:]
        return [
            m
            for m in (self.misconceptions if wrong else ())
            if all(self._alike(c.result, self._result(m.answer, c.args), part) for c in sample)
        ]

    def _result(self, function, args):
        f = guard.Guarded(function, self.parameters())
        try:
            with np.errstate(all="ignore"):
                return f(*args)
        except (Failed, guard.NotAttempted):
            return f.calls[-1].result if f.calls else guard.Raised("NotImplementedError")

    def _alike(self, a, b, part):
        if isinstance(a, guard.Raised) or isinstance(b, guard.Raised):
            return type(a) is type(b) and a == b  # an array would compare itself entry by entry
        try:
            if self.canonical is not None:
                a, b = self.canonical(a), self.canonical(b)
            if part is not None:
                a, b = a[part], b[part]
        except Exception:
            return False
        return guard.equal(a, b, rtol=1e-6, atol=1e-8)
