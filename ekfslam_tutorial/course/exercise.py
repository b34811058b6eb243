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
import contextlib
import copy
import functools
import inspect
import os
import re
import textwrap
import time
import warnings
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from . import deadline, edits, guard, own_words, slips
from .diagnose import LOST_DECIMALS
from .expect import Failed
from .recognise import as_asked, few_values, recognise, recognise_more, right_results, wrong_part

PATIENCE = 3.0  # seconds of the processor after which a search for slips ends, though `pairs` counts its steps
FEW = 3  # wrong calls of the cases; with fewer, or with none beyond a known mistake, later links are asked, too
LATER_S = 0.5  # that later links may take: they may show another mistake, or that a slip is none
AN_ID = "An id is the name of a landmark, and says nothing of its place: `ids.index(id)` is the place of `id` in `ids`."
TYPE_INT = (
    "Your array is of type int: what is written into it loses its decimals. Make it one of floats, `dtype=float`."
)
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
    """A named wrong answer and what to tell the student who gives it.

    `edits` are pairs of texts, old and new: the places of the solution that the mistake writes otherwise.
    """

    name: str
    hint: str
    answer: Any
    edits: tuple[tuple[str, str], ...] = ()


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
    cases : dict of str to callable, optional
        ``rng -> list of argument tuples``, for links that share them.
    ids : tuple, optional
        ``(parameter, names of functions)``: a list of ids, and the functions that take places, never ids.
    """

    def __init__(
        self, id, title, solution, hints, *, may_change=(), canonical=None, seconds=SECONDS, cases=None, ids=None
    ):
        self.id, self.title, self.solution, self.hints = id, title, solution, tuple(hints)
        self.may_change, self.canonical, self.seconds = tuple(may_change), canonical, seconds
        self.cases, self.ids = dict(cases or {}), ids
        self.returns: list[str] = []  # names of the results
        self.symbols: list[str] = []  # what the hints call so: "P_x = dp/dx"
        self.links: list[Link] = []
        self.misconceptions: list[Misconception | edits.Mistake] = []
        self.patience = PATIENCE
        self.variants: list[Variant] = []
        self.forms: list[Exercise] = []
        self.asks_helpers, self.note = True, ""

    # ---- how a module fills it -------------------------------------------------------------------------

    def link(self, name: str, help: str, part: int | None = None, before: str | None = None):
        """Decorator: the next link, `test(f, rng)`, or one before the link of that name."""
        at = len(self.links) if before is None else [link.name for link in self.links].index(before)

        def add(test):
            self.links.insert(at, Link(name, help, test, part))
            return test

        return add

    def edited(self, text: str):
        """Add wrong answers that are the solution with some places written otherwise: see `edits.blocks`."""
        for name, hint, places in edits.blocks(text):
            self.misconceptions.append(edits.mistake(self.solution, name, hint, places))

    def written(self, text: str):
        """Add right answers in other forms, as edits: a slip in P - K Z K' is another one than that in P - K H P."""
        for name, note, places in edits.blocks(text):
            form = copy.copy(self)
            form.note = note
            form.asks_helpers = False  # they are the same as in the solution
            form.solution, form.misconceptions, form.forms = edits.form(self.solution, name, places), [], []
            for known in self.misconceptions:
                with contextlib.suppress(ValueError):  # of a place that this form has not
                    form.misconceptions.append(edits.mistake(form.solution, known.name, known.hint, known.edits))
            self.forms.append(form)

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

    def is_reference(self, answer) -> bool:
        """Return True if this is the solution itself, as an earlier check has handed it out."""
        return answer is self.solution

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
        return list(self._signature)

    @cached_property
    def _signature(self) -> tuple:
        return tuple(inspect.signature(self.solution).parameters)

    def judge(self, answer, forgiven=()) -> Verdict:
        """Test an answer, which may change these of its inputs. Never raises for what the student has written."""
        started = time.perf_counter()
        if answer is None or answer is Ellipsis or answer is NotImplemented:
            return Verdict("not attempted")
        if not callable(answer):
            hint = f'Hand over the function itself, without brackets: check("{self.id}", {self.name}).'
            return Verdict("failed", "is a function", f"a function is wanted, got {type(answer).__name__}", hint)
        missing = guard.misses_arguments(answer, self.parameters())
        if missing:
            return Verdict("failed", "arguments", missing, "Keep the `def` line of the exercise as it is.")
        f = guard.Guarded(answer, [*self.may_change, *forgiven], self.parameters())
        limit = self._limit()
        at = [self.links[0]]
        try:
            outcome, printed = deadline.run(lambda: self._first_failure(f, at), limit)
        except guard.NotAttempted:
            return Verdict("not attempted")
        except deadline.TookTooLong:
            message = f"your function took more than {limit:g} s and was stopped{deadline.HOW}"
            return Verdict("failed", at[0].name, message, "Look for a loop that does not end, or has very many turns.")
        seconds = time.perf_counter() - started
        if outcome is None:
            return Verdict("passed", printed=printed, seconds=seconds)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of mistakes that are tried: these are not the student's
            cut = self._cut_off(f.calls)
            known = [] if outcome.certain or cut else self._recognised(f, at[0], limit - seconds)
        name, hint = " + ".join(m.name for m in known), self._help(outcome, at[0])
        if not known and self.ids and own_words.ids_as_places(answer, *self.ids):
            raised = any(isinstance(call.result, guard.Raised) for call in f.calls[-1:])
            hint = AN_ID if raised else f"{AN_ID} {hint}"  # such a place is no matter of counting from 0
        if outcome.certain and not forgiven:  # who changes an input may have made another mistake, too
            besides = self.judge(answer, forgiven=self.parameters())
            if besides.misconception and not besides.misconception.startswith("slip: "):  # it may come of the change
                name, hint = besides.misconception, f"{hint} And besides: {besides.hint}"
        if len(known) == 1:
            tested = hint if at[0] is self.links[0] else at[0].help
            slip = not known[0].edits
            hint = f"{known[0].hint} What is tested here: {tested}" if slip else known[0].hint
        elif known:
            tested = f" What is tested here: {at[0].help}" if not any(m.edits for m in known) else ""
            same = known[0].name == known[1].name  # one slip, made twice
            things = "The same thing at two places." if same else "Two things, in this order."
            sure = all(m.edits or getattr(m, "shows", False) for m in known)  # else it may be a trace of the other one
            if not (same or sure):
                things = "Two things, in this order (one mistake may be behind both)."
            hint = f"{things} First: {known[0].hint} Then: {known[1].hint}{tested}"
        hint = f"{TYPE_INT} {hint}" if cut and not outcome.certain else hint
        message = str(outcome) if _has_whole(f.calls) else str(outcome).removesuffix(LOST_DECIMALS).rstrip()
        return Verdict("failed", at[0].name, message, self._with_symbols(hint), name, printed, seconds)

    def _help(self, outcome, link) -> str:
        """What to say where no listed mistake is recognised: the advice of the failure, then the link's own help."""
        if not outcome.hint or outcome.certain or link is self.links[0]:  # the first asks for the form of the results
            return outcome.hint or link.help
        return f"{outcome.hint} What is tested here: {link.help}"

    def _with_symbols(self, hint) -> str:
        """The hint, and what the names in it mean that the statement does not have."""
        names = lambda text: set(re.findall(r"[^\W\d]\w*", text))
        new = names(hint) - names(self.solution.__doc__ or "")
        told = lambda name, means: names(name) | (names(means) if means.startswith("[") else set())  # q = [u, v, 1]
        used = [text for text in self.symbols if told(*text.split(" = ", 1)) & new and text not in hint]
        return f"{hint} Here {', '.join(used)}." if used else hint

    def _cut_off(self, calls) -> bool:
        """Return True if a result of the last call is the right one, but in an array of type int, without decimals."""
        if not calls or isinstance(calls[-1].result, guard.Raised):
            return False
        got, right = calls[-1].result, self.answered(self.solution, calls[-1])
        if isinstance(right, tuple) and isinstance(got, tuple):
            return any(map(_is_cut_off, got, right))
        return _is_cut_off(got, right)

    def _recognised(self, f, failed, limit):
        """The listed mistakes in the answer, by its calls so far; where these do not tell it all, by more of them."""
        self.patience = PATIENCE
        part = wrong_part(self, f.calls, right_results(self, f.calls), failed.part)
        if few := few_values(self, f.calls, part):
            self._call_more(lambda: self._go_on(f, failed), limit)
        known = recognise(self, f.calls, failed.part)
        more = guard.Guarded(f.function, self.may_change, self.parameters())
        self._call_more(lambda: self._cases(more), limit)
        explained = known[0].answer if known else self.solution
        left = sum(not self.alike(c.result, self.answered(explained, c)) for c in more.calls)
        if not few and left < (1 if known else FEW):
            n = len(more.calls)
            self._call_more(lambda: self._go_on(more, failed), min(limit, LATER_S * deadline.SLOWER))
            more.calls[n:] = as_asked(more.calls[n:], more.calls[:n])
        right = right_results(self, more.calls)
        of_cases = any(not self.alike(call.result, t) for call, t in zip(more.calls, right, strict=True))
        calls = [*more.calls, *f.calls] if few and part is None else more.calls if of_cases else f.calls
        own = functools.cache(lambda: own_words.formulas(f.function))
        return [slips.as_told(m, own()) for m in recognise_more(self, calls, failed.part, known, own)]

    @staticmethod
    def _call_more(calls, limit):
        with contextlib.suppress(deadline.TookTooLong):
            deadline.run(calls, max(limit, 0.1))

    def _go_on(self, f, failed):
        for link in self.links[self.links.index(failed) + 1 :]:
            with contextlib.suppress(Exception):
                link.test(f, self._rng(link))

    def _cases(self, f):
        for name, case in self.cases.items():
            for args in case(np.random.default_rng(zlib.crc32(f"{self.id} {name}".encode()))):
                with contextlib.suppress(Exception):
                    f(*args)

    def _limit(self) -> float:
        """Seconds after which an answer is stopped."""
        asked = os.environ.get("EKFSLAM_CHECK_SECONDS", self.seconds * deadline.SLOWER)
        try:
            return float(asked)
        except ValueError:
            raise ValueError(f"EKFSLAM_CHECK_SECONDS must be a number of seconds, got {asked!r}") from None

    def _first_failure(self, f, at) -> Failed | None:
        """Test the links in order; return the failure of the first that fails. `at[0]` follows."""
        for link in self.links:
            at[0] = link
            try:
                link.test(f, self._rng(link))
            except Failed as failed:
                return failed
            except guard.NotAttempted:
                raise
            except Exception as error:  # a result so odd that the link stumbles over it
                return Failed(f"your result cannot be used ({type(error).__name__}: {error})"[:300])
        return None

    def _rng(self, link):
        return np.random.default_rng(zlib.crc32(f"{self.id} {link.name}".encode()))

    # ---- what recognising a mistake needs ------------------------------------------------------------------

    def result(self, function, args):
        """Return what a function answers: its result, or `Raised`."""
        f = guard.Guarded(function, self._signature, self._signature)
        try:
            with np.errstate(all="ignore"):
                return f(*args)
        except (Failed, guard.NotAttempted):
            return f.calls[-1].result if f.calls else guard.Raised("NotImplementedError")

    def answered(self, function, call):
        """Return what a function answers to a call of the student's: asked once, for many ask."""
        if function not in call.answers:
            call.answers[function] = self.result(function, call.args)
        return call.answers[function]

    def alike(self, a, b, part=None) -> bool:
        """Return True if two results are the same to rounding, as a whole or in one part."""
        if isinstance(a, guard.Raised) or isinstance(b, guard.Raised):
            return type(a) is type(b) and a == b  # an array would compare itself entry by entry
        try:
            if self.canonical is not None:
                a, b = self.canonical(a), self.canonical(b)
            if part is not None:
                a, b = a[part], b[part]
        except Exception:
            return False
        return guard.equal(a, b, rtol=1e-6, atol=None)

    def composed(self, one: Misconception, other: Misconception):
        """Return the solution with the edits of two mistakes, or None if they do not go together."""
        key = one.name, other.name
        if key not in self._pairs:
            self._pairs[key] = edits.composed(self.solution, one.edits, other.edits)
        return self._pairs[key]

    @cached_property
    def _pairs(self) -> dict:
        return {}

    def slips(self, known=None) -> list:
        """Return the slips that any formula may have, in the solution or beside a mistake that is known."""
        if known is None:
            return self._slips
        if isinstance(known, slips.Slip):
            return slips.slips(self.solution, known.body) if known.user is None else []
        if not known.edits:
            return []
        return slips.slips(self.solution, edits.applied(edits.parts(self.solution)[1], known.edits, known.name))

    @cached_property
    def _slips(self) -> list:
        helpers = slips.slips_of_helpers(self.solution) if self.asks_helpers else []
        return slips.slips(self.solution) + helpers

    def fails_at(self, mistake: Misconception) -> int:
        """Return the number of the link at which a mistake fails."""
        at = [self.links[-1]]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self._first_failure(guard.Guarded(mistake.answer, self.may_change, self.parameters()), at)
        return self.links.index(at[0])

    # ---- arrays where arrays are asked for -----------------------------------------------------------------

    def in_arrays(self, function):
        """Return the student's function, with arrays where the solution gives arrays, of the same kind of numbers.

        So a right answer made of lists works in the rest of the notebook, and an index stays a whole number.
        `inspect.unwrap` gives the function back.
        """
        forms = self._forms

        @functools.wraps(function)
        def answer(*args, **kwargs):
            result = function(*args, **kwargs)
            if len(forms) == 1:
                return _as_array(result, forms[0])
            if not isinstance(result, (tuple, list)) or len(result) != len(forms):
                return result
            return tuple(_as_array(part, kind) for part, kind in zip(result, forms, strict=True))

        return answer if any(kind is not None for kind in forms) else function

    @cached_property
    def _forms(self) -> list:
        """The kind of numbers in each result of the solution that is an array; None for other results."""
        f = guard.Guarded(self.solution, self.may_change, self.parameters())
        for link in self.links:
            with contextlib.suppress(Exception):
                link.test(f, self._rng(link))
            if f.calls:
                break
        result = f.calls[0].result if f.calls else None
        parts = result if isinstance(result, tuple) else (result,)
        return [part.dtype if isinstance(part, np.ndarray) else None for part in parts]


def _has_whole(calls) -> bool:
    """Return True if the last call gave whole numbers, alone or among its results."""
    result = calls[-1].result if calls else None
    parts = map(guard.numbers, [result, *(result if isinstance(result, tuple) else ())])
    return any(part is not None and part.dtype.kind in "iu" for part in parts)


def _is_cut_off(got, want) -> bool:
    """Return True if `got` is what an array of type int keeps of `want`."""
    arrays = all(isinstance(a, np.ndarray) for a in (got, want)) and np.shape(got) == np.shape(want)
    if not arrays or got.dtype.kind != "i" or want.dtype.kind != "f":
        return False
    return not np.array_equal(got, want) and np.array_equal(got, np.trunc(want))


def _as_array(value, kind):
    """A list of numbers as an array of this kind, unless that would change a number; anything else as it is."""
    if kind is None:
        return value
    if type(value) is np.ndarray and value.dtype == kind:  # a filter asks for ten thousand of them
        return value.copy()
    numbers = guard.numbers(value)
    if numbers is None or numbers.dtype.kind == "c":
        return value
    with np.errstate(invalid="ignore"):  # a NaN is no whole number
        kept = numbers.astype(kind)
    return kept if np.array_equal(kept, numbers) else numbers
