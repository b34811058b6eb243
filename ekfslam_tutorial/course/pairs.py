"""Two mistakes at once, found among all pairs of changes of the solution.

A *change* is a listed mistake that is an edit, or a slip of any formula. Each is run once on some of the student's
calls: a table, a row for a change, a column for each number that came out. Where a number is what one change makes of
it, and no other one touches it, one of the pair is found; so most pairs are refused without being run. For the rest,
the differences from the right numbers add up, or their ratios multiply, to first order: the pairs are tried in that
order, the solution with both changes in it, and named is only one that answers every call as the student did.
"""

from __future__ import annotations

import copy
import hashlib
import itertools
import os.path
import pickle
import sys
import time
import types
import warnings
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from . import edits, guard, own_words

CALLS, FEWEST = 12, 5  # of the table; the fewest where there are more changes than
MANY = 600
STEPS, SEARCHED = 10_000_000, 4_000_000  # calls of functions, about 0.2 us each: of the table, and of the pairs tried
COMPILED = 400  # steps that it takes to make a change
CELLS = 250  # numbers of the table, of those that are wrong, and of those that are right
SURE_BITS = 4.0  # a fit with less evidence than this is chance: one in 16
PAIRED = 1000  # rows of the table, so many of which are paired
FEW_VALUES = 3  # fewer wrong numbers are twice the right ones by chance
LISTED = 0.1  # by so much nearer counts a pair for each of the two that is listed
LIKELY = (
    600  # pairs that are tried: of 143 that answers had, the last one found was the 447th. After these as many more
)
# of two listed mistakes: in a formula such as a root the effects of two neither add up nor multiply
BESIDE = 3  # listed mistakes, in the text of which slips are looked for
FIRST = 40  # pairs of rows of which more than one pair of changes is tried
TURNS = 100_000  # of loops in a few calls: where there are more, a change has made one endless
KEPT = 100  # results of a change: an answer that is tried again is asked with the same arguments
TRIED = 4  # changes with the same results that may stand for each other: one may be in the place of its partner


class Change:
    """One change of the solution, or of a function of another exercise that it calls.

    Parameters
    ----------
    mistake : Mistake or Slip
    """

    def __init__(self, mistake):
        self.mistake, self.function = mistake, mistake.solution
        self.old = edits.parts(mistake.solution)[1]
        self.listed = bool(mistake.edits)
        self.body = edits.applied(self.old, mistake.edits, "") if self.listed else mistake.body
        self._known = {}

    @cached_property
    def answer(self):
        """The function; None where the change makes nonsense."""
        return self.mistake.answer

    def results(self, calls, keys):
        """Return what it answers to each call, once computed for the same arguments; None if it does not end."""
        if len(self._known) > KEPT:
            self._known = {}
        known, new = self._known, [k for k, key in enumerate(keys) if key not in self._known]

        def work():
            known.update((keys[k], _called(self.answer, calls[k].args)) for k in new)
            return True

        return [known[key] for key in keys] if not new or _in_time(work) else None

    @cached_property
    def hunks(self):
        """What is written otherwise: start, end, and what stands there instead; each as short as it can be."""
        spans = []
        for old, new in self.mistake.edits or ((self.old, self.body),):
            start = self.old.find(old)
            if start < 0:  # an edit of an edit
                return [_shortest(0, self.old, self.body)]
            spans.append(_shortest(start, old, new))
        return spans

    @cached_property
    def size(self) -> int:
        """How many letters are written otherwise, without brackets round the whole."""
        quoted = getattr(self.mistake, "quoted", None)
        return sum(end - start + len(new) for start, end, new in ([_shortest(0, *quoted)] if quoted else self.hunks))

    @cached_property
    def places(self):
        """The same as edits: with so much of the text around each that it stands there once."""
        found = []
        for start, end, new in self.hunks:
            a, b = start, end
            while self.old.count(self.old[a:b]) != 1 or a == b:
                a, b = max(a - 1, 0), min(b + 1, len(self.old))
            found.append((self.old[a:b], self.old[a:start] + new + self.old[end:b]))
        return found


def _shortest(start, old, new):
    """The change of a text at `start` without what both have in common at the beginning and at the end."""
    a = len(os.path.commonprefix([old, new]))
    b = len(os.path.commonprefix([old[a:][::-1], new[a:][::-1]]))
    return start + a, start + len(old) - b, new[a : len(new) - b]


def composed(solution, one, other):
    """Yield the solution with both changes; twice where it matters which one is made first."""
    if isinstance(other, Beside):
        if (answer := other.mistake.answer) is not None:
            yield answer
        return
    if isinstance(one, Outer) or isinstance(other, Outer):
        inner, outer = (other, one) if isinstance(one, Outer) else (one, other)
        if inner.answer is not None:
            yield outer.around(inner.answer)
        return
    bodies = [{one.function: one.body, other.function: other.body}]
    if one.function is other.function:
        bodies = [{one.function: body} for body in _merged(one, other)]
    for texts in bodies:
        try:
            made = {f: edits.function(f, edits.parts(f)[0] + body, "two mistakes") for f, body in texts.items()}
        except Exception:
            continue
        main = made.pop(solution, solution)
        space = main.__globals__ | {f.__name__: new for f, new in made.items()}
        yield types.FunctionType(main.__code__, space, main.__name__, main.__defaults__) if made else main


def _merged(one, other):
    """The texts with both changes; none if one takes the other's place away."""
    hunks = sorted([*one.hunks, *other.hunks])
    if all(a[1] <= b[0] and a[:2] != b[:2] for a, b in itertools.pairwise(hunks)):
        text, at = "", 0
        for start, end, new in hunks:
            text, at = text + one.old[at:start] + new, end
        return [text + one.old[at:]]
    if not (one.listed and other.listed):  # a slip of what is wrong already: its sentence would quote that as right
        return []
    found = []
    for first, second in ((one, other), (other, one)):
        for places in (second.mistake.edits, second.places):
            try:
                found.append(edits.applied(first.body, places, ""))
                break
            except ValueError:
                continue
    return [body for body in dict.fromkeys(found) if body not in (one.body, other.body)]


def apart(table, one, other):
    """Yield the solution with both changes, but what one of them alone makes wrong as with that one alone.

    Who writes a formula out at each place may err at one of them: then the mistake is not in all results.
    """
    ways = table.ways(table.row_of[one], table.row_of[other])
    solution = table.exercise.solution
    for both in composed(solution, one, other) if 3 in ways else [None]:
        answers = solution, one.answer, other.answer, both

        def answer(*args, answers=answers):
            made = {way: answers[way](*map(_copy, args)) for way in set(ways)}
            return tuple(made[way][p] for p, way in enumerate(ways))

        yield answer


class Outer:
    """A slip of one result as a whole, whatever stands in the function: it goes with each other change.

    Parameters
    ----------
    exercise : Exercise
    part : int or None
        Which of several results.
    hint : str
    made, undone : callable
        What becomes of the result, and the way back, if there is one.
    """

    listed, function, size = False, None, 0

    def __init__(self, exercise, part, hint, made, undone=None):
        self.part, self.hint, self.made, self.undone = part, hint, made, undone
        self.name = f"slip: {hint}"
        self.mistake, self.edits, self.answer = self, (), self.around(exercise.solution)

    def around(self, answer):
        """The answer with the slip in its results."""
        return lambda *args: self.of(answer(*args), self.made)

    def results(self, calls, keys):
        """Return what the solution with the slip answers to each call."""
        return [_called(self.answer, call.args) for call in calls]

    def of(self, result, how):
        """The results with one of them changed."""
        with np.errstate(all="ignore"):
            if self.part is None:
                return how(np.asarray(result, float))
            return tuple(how(np.asarray(r, float)) if k == self.part else r for k, r in enumerate(result))


def _inverted(a):
    """The inverse; not of a matrix such as [[1, 0, a], [0, 1, b], [0, 0, 1]], of which a wrong sign is the same."""
    inverse = np.linalg.inv(a)
    if guard.equal(np.abs(inverse), np.abs(a), 1e-9):
        raise np.linalg.LinAlgError("a change of signs")
    return inverse


FACTORS = (
    ("`{}` has the wrong sign in yours.", np.negative, np.negative),
    ("Yours is twice as much: `{}`.", lambda a: 2 * a, lambda a: a / 2),
    ("Yours is half as much: `{}`.", lambda a: a / 2, lambda a: 2 * a),
)
OUTER = (
    ("`{}` is transposed in yours.", lambda a: a.T, lambda a: a.T),
    *FACTORS,
    ("`{}` is in degrees in yours: keep to radians.", np.degrees, np.radians),
    ("`{}` is converted from degrees in yours, and it is in radians already.", np.radians, np.degrees),
    ("Yours is the root: `{}`.", np.sqrt, np.square),
    ("Yours is the square: `{}`.", np.square, np.sqrt),
    ("Yours is the inverse: `{}`.", _inverted, _inverted),
    ("The entries of `{}` are in the wrong order.", lambda a: a[..., ::-1], lambda a: a[..., ::-1]),
    ("`{}` is 1 minus what it should be.", lambda a: 1 - a, lambda a: 1 - a),
)


ALWAYS = (
    ("In yours `{}` is zero, whatever goes in.", (1, 2), np.zeros_like),
    ("In yours `{}` is the identity, whatever goes in.", (2,), lambda a: np.eye(*a.shape)),
)


class Beside:
    """A slip in the text of a listed mistake: it is there only with that mistake.

    What its sentence says to belong is a part of the mistake, unless it stands in the solution, too. Then the listed
    mistake alone is told: the slip may be a trace of how the student has made it.
    """

    listed, function = False, None

    def __init__(self, slip):
        self.mistake = slip

    @cached_property
    def is_of_the_solution(self) -> bool:
        """What belongs by its sentence stands in the solution."""
        body = " ".join(edits.parts(self.mistake.solution)[1].split())
        return bool(self.mistake.quoted) and " ".join(self.mistake.quoted[0].split()) in body


def outers(exercise, right, kinds=OUTER):
    """Return the slips of whole results, of these kinds, that change a result of numbers."""
    names, several = exercise.returns, isinstance(right, tuple)
    found = []
    for k, part in enumerate(right if several else (right,)):
        numbers = guard.numbers(part)
        if numbers is not None and numbers.dtype.kind == "f":
            name = names[k] if k < len(names) else "the result"
            found += [Outer(exercise, k if several else None, hint.format(name), *ways) for hint, *ways in kinds]
    return found


def always(exercise, calls, right):
    """Return the slips that make one of several results, an array, the same in all calls: zero, or the identity.

    A formula hardly ever comes to that by a slip, and two slips that do, such as R R' in place of R R, are chance.
    """
    found, results = [], [call.result for call in calls]
    if not all(isinstance(r, tuple) and len(r) == len(exercise.returns) for r in (*right, *results)):
        return []
    for k, name in enumerate(exercise.returns):
        given, wanted = ([_floats(r[k]) for r in all_of] for all_of in (results, right))
        if not all(_is_floats(a) and _is_floats(b) and a.shape == b.shape for a, b in zip(given, wanted, strict=True)):
            continue
        for hint, axes, made in ALWAYS:
            fits = lambda a, axes=axes, made=made: a.size > 1 and a.ndim in axes and _near(a, made(a)).all()
            if all(map(fits, given)) and not all(map(fits, wanted)):
                found.append(Outer(exercise, k, hint.format(name), made))
    return found


class Table:
    """What each change answers to some calls, beside what is right and what the student gave.

    Attributes
    ----------
    rows : list of list of Change
        Changes with the same results, the listed ones first.
    V : ndarray, shape (rows, cells)
        The numbers.
    changed, fits : ndarray of bool, shape (rows, cells)
        Is it another number than the right one, and is it the student's?
    """

    def __init__(self, exercise, calls, patience, few=False, own=None):
        self.own = own
        most = 40 if few else CALLS
        end = time.process_time() + patience
        all_changes = changes(exercise)
        most = max(FEWEST, min(most, most * MANY // max(len(all_changes), 1)))
        self.exercise, self.steps = exercise, _steps(exercise, calls)
        affordable = int((STEPS / max(len(all_changes), 1) - COMPILED) / self.steps)
        most = max(FEWEST, min(most, affordable))
        all_changes = all_changes[: int(STEPS / (COMPILED + most * self.steps))]
        right = [exercise.answered(exercise.solution, call) for call in calls]
        self.calls = _chosen(exercise, calls, right, most)
        self.right = [exercise.answered(exercise.solution, call) for call in self.calls]
        if _only_raise(exercise, calls, right) or _always_the_same(exercise, calls, right):
            # Many slips raise, too, and none makes a constant of a formula: neither tells which slip it was.
            all_changes = [change for change in all_changes if change.listed]
        self.few = few
        self.t, self.s, self.kinds = self._columns()
        self.blank = list(map(_blank, self.kinds))
        keys = [_key(call.args) for call in self.calls]
        self.unlike = any(isinstance(given, guard.Raised) for kind in self.kinds for _, given, _ in kind)
        constants = always(exercise, self.calls, self.right)
        constant = np.isin(self.parts, [outer.part for outer in constants])
        rows, values = {}, []
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of changes that make nonsense
            for change in (*constants, *all_changes):
                if time.process_time() > end:
                    break
                if change.answer is None:
                    continue
                results = change.results(self.calls, keys)
                if results is None:
                    continue
                v = np.concatenate([self.numbers(result, k) for k, result in enumerate(results)])
                slip = not (change.listed or change in constants)
                if slip and not _near(v, self.t)[constant].all() and not _near(v, self.s).all():
                    continue
                key = (np.round(v, 7) + 0.0).tobytes()  # no zero with a minus
                if key not in rows:
                    values.append(v)
                rows.setdefault(key, []).append(change)
        self.rows = [sorted(row, key=self.rank) for row in rows.values()]
        self.row_of = {change: k for k, row in enumerate(self.rows) for change in row}
        self.V = np.array(values).reshape(len(values), len(self.t))
        self.changed, self.fits = ~_near(self.V, self.t), _near(self.V, self.s)
        self.wrong = ~_near(self.s, self.t)
        self.wrong_parts = np.array([self.wrong[self.parts == p].any() for p in range(int(self.parts.max()) + 1)])

    def _columns(self):
        """What is right, what the student gave, and by call and result whether it is compared number by number."""
        t, s, kinds, parts, calls, wholes = [], [], [], [], [], []
        for k, (call, right) in enumerate(zip(self.calls, self.right, strict=True)):
            (rights, given), kind = (self._parts(r) for r in (right, call.result)), []
            if len(rights) != len(given):
                rights, given = [right], [call.result]
            for p, (a, b) in enumerate(zip(rights, given, strict=True)):
                one = not (_is_floats(a) and _is_floats(b) and a.shape == b.shape)
                kind.append((a, b, one))
                t.append([0.0] if one else np.ravel(a))
                s.append([float(not _same(b, a))] if one else np.ravel(b))
                parts += [p] * len(t[-1])
                calls += [k] * len(t[-1])
                wholes += [one] * len(t[-1])
            kinds.append(kind)
        self.parts, self.of_call, self.as_whole = np.array(parts), np.array(calls), np.array(wholes)
        return np.concatenate(t), np.concatenate(s), kinds

    def _parts(self, result):
        """The results of a call as arrays of floats; what is no number as it is."""
        try:
            result = result if self.exercise.canonical is None else self.exercise.canonical(result)
        except Exception:
            pass
        parts = result if isinstance(result, tuple) else (result,)
        return [_floats(part) for part in parts]

    def numbers(self, result, k):
        """The numbers of a result of call k: NaN where it gives something else than numbers of that shape."""
        blank = self.blank[k]
        if blank is not None and isinstance(result, guard.Raised):
            return blank
        row, kind, parts = [], self.kinds[k], self._parts(result)
        parts = [result] if len(kind) == 1 and len(parts) != 1 else parts
        fit = len(parts) == len(kind)
        for i, (right, given, one) in enumerate(kind):
            part: Any = parts[i] if fit else None
            if one:
                row.append([0.0 if _same(part, right) else 1.0 if _same(part, given) else 2.0])
            elif _is_floats(part) and part.shape == right.shape:
                row.append(np.ravel(part))
            else:
                row.append(np.full(np.size(right), np.nan))
        return row[0] if len(row) == 1 else np.concatenate(row)

    def single(self):
        """The changes that alone give all that the student gave; none if there is no such row."""
        return self._told(np.flatnonzero(self.fits.all(1)))

    def rank(self, change):
        """By what the first of several changes with the same results is chosen: the listed ones, the likely ones."""
        return not change.listed, own_words.unlikely(change.mistake, self.own), not own_words.of_another(change.mistake)

    def _told(self, rows):
        """The changes of the first of these rows of which one may be told."""
        return next(filter(None, ([c for c in self.rows[k] if not self.doubtful(c)] for k in rows)), [])

    def doubtful(self, change) -> bool:
        """Return True if the student has written already what the change says to belong."""
        return own_words.doubtful(change.mistake, self.own)

    def may_tell(self, one, other) -> bool:
        """Return True if neither of two changes is doubtful; beside one that is, a listed mistake is told alone."""
        if any(own_words.foreign(change.mistake, self.own) for change in (one, other)):
            return False
        sure = [change for change in (one, other) if not self.doubtful(change)]
        return len(sure) == 2 or len(sure) == 1 and sure[0].listed

    def spoils(self, change) -> bool:
        """Return True if a slip alone changes numbers that the student has otherwise: then it is none alone."""
        row = self.row_of.get(change)
        return not change.listed and row is not None and bool((self.changed[row] & ~self.fits[row]).any())

    def of_part(self, part):
        """The changes that give what is wrong in one result, and spoil nothing that the student has otherwise."""
        here = self.wrong & (self.parts == part)
        good = self.fits[:, here].all(1) & ~(self.changed & ~self.fits).any(1) & self.has_decimals[here].any()
        return self._told(np.flatnonzero(good))

    @cached_property
    def has_decimals(self):
        """Which of the student's numbers are no whole ones: these are hit by no chance."""
        return _no_whole_numbers(self.s)

    @cached_property
    def counted(self):
        """Which numbers are an index, None, True or a count: neither the student's nor the right one has decimals."""
        return ~(self.has_decimals | _no_whole_numbers(self.t))

    @cached_property
    def apart(self) -> bool:
        """The answer has several results in all calls, so that a mistake may show in one of them only."""
        several = [len(kind) for kind in self.kinds]
        return not self.few and not self.unlike and several[0] > 1 and len(set(several)) == 1

    @cached_property
    def whole(self):
        """Which rows give all that the student gave in a result that is wrong, by row and result: no chance."""
        found = np.zeros((len(self.rows), len(self.wrong_parts)), bool)
        for p in np.flatnonzero(self.wrong_parts) if self.apart else ():
            here = self.parts == p
            wrong = here & self.wrong
            if self.has_decimals[wrong].sum() > 1:
                found[:, p] = self.fits[:, here].all(1)
        return found

    @cached_property
    def first(self):
        """The first result that each row changes: a mistake in it is no other one."""
        touched = np.stack([self.changed[:, self.parts == p].any(1) for p in range(len(self.wrong_parts))], 1)
        return touched.argmax(1)

    def ways(self, i, j):
        """By result: is it right (0), as with row i alone (1), as with row j alone (2), or as with both (3)?

        None if one of them is not needed, or if both are in all that is wrong.
        """
        if not (self.apart and self.needs(i, j) and self.needs(j, i)):
            return None
        ways = np.select([~self.wrong_parts, self.whole[i], self.whole[j]], [0, 1, 2], 3)
        some = {1, 2} <= set(ways) or self.rows[i][0].listed and self.rows[j][0].listed and (ways != 3).any()
        return tuple(ways) if some else None  # a slip that shows only with the other one may undo a part of it

    def needs(self, i, j) -> bool:
        """Return True if row j does not give all that is wrong, so that row i is in some of it, too."""
        return bool((self.wrong_parts & ~self.whole[j]).any())

    def in_place(self, i, j) -> bool:
        """Return True if the student's first result that row i changes is wrong, and not as with row j alone."""
        p = self.first[i]
        return not self.apart or bool(self.wrong_parts[p] and (self.whole[i, p] or not self.whole[j, p]))

    def alone(self):
        """The changes that give all that is wrong, though not in each result that they would be in."""
        good = self.apart & self.whole[:, self.wrong_parts].all(1) & self.wrong_parts[self.first]
        found = np.flatnonzero(good)
        spoilt = (self.changed & ~self.fits).sum(1)
        return self._told(found[np.argsort(spoilt[found], kind="stable")])

    def evident(self, i, j) -> bool:
        """Return True if a pair is no guess: one mistake in another formula may be two slips in this one by chance.

        Two listed mistakes are none. Beside a slip each must show alone: in numbers that it explains, and that the
        other one does not touch, or in a whole result. Nor do slips explain what is no number.
        """
        both = (i, j), (j, i)
        if not all(self.in_place(*each) for each in both):
            return False
        return all(self.rows[k][0].listed for k in (i, j)) or self.tells and all(self.shown(*each) for each in both)

    def shown(self, i, j) -> bool:
        """Return True if row i gives numbers that row j does not touch, or a whole result that j does not give."""
        alone = self.whole[i] & ~self.whole[j] & self.wrong_parts
        return bool((self.fits[i] & self.wrong & np.isfinite(self.s) & ~self.changed[j]).any() or alone.any())

    @cached_property
    def tells(self) -> bool:
        """The results are numbers with decimals, most of them: no two slips give them by chance."""
        return not self.few and not self.unlike and bool(np.isfinite(self.s).mean() > 0.5)

    def hidden(self, i, j) -> bool:
        """Return True if a slip of the two shows in no number alone: both are in all that is wrong."""
        return self.tells and not self.evident(i, j) and self.in_place(i, j) and self.in_place(j, i)

    def constant(self, cells) -> bool:
        """Return True if the student's results in which these numbers are have no decimals and are all the same.

        They say that the student is wrong, and not how: always True, or always zero, comes of many mistakes. What is
        compared as a whole is something else than such a number.
        """
        about = np.isin(self.parts, self.parts[cells])
        return not (self.has_decimals | self.as_whole)[about].any() and len(set(self.s[about])) < 2

    def bits(self) -> float:
        """What the wrong results say: each call as much as few rows of the table have that answer to it."""
        total, n, about = 0.0, max(len(self.rows), 1), np.isin(self.parts, self.parts[self.wrong])
        for k in range(len(self.calls)):
            total += np.log2(n / max(int(self.fits[:, about & (self.of_call == k)].all(1).sum()), 1))
        return total

    @cached_property
    def pairs(self):
        """The pairs of rows that may do it together, the likely ones first.

        What counts: numbers that are not what the one change that touches them makes of them; and how far the effects
        of both are from adding up, or from multiplying, to that of the student.
        """
        rows, cells = self._some_rows(), self._some_cells()
        listed = np.array([self.rows[k][0].listed for k in rows])
        key = -LISTED * (listed[:, None] + listed.astype(float))
        for p in np.unique(self.parts[cells]) if self.apart else [None]:
            here = cells if p is None else cells[self.parts[cells] == p]
            key_here = self._far(rows, here, self.wrong[cells].sum())
            if p is not None:
                alone = self.whole[rows, p] | ~self.wrong_parts[p]
                key_here[alone[:, None] | alone] = 0
            key = key + key_here
        key = np.where(np.tri(len(rows), dtype=bool), np.inf, key).ravel()
        few = np.argpartition(key, min(LIKELY, len(key) - 1))[:LIKELY]
        few = few[np.isfinite(key[few])]
        few = few[np.argsort(key[few], kind="stable")]
        both = np.flatnonzero((listed[:, None] & listed).ravel() & np.isfinite(key))  # what is made often, last of all
        both = both[np.argsort(key[both], kind="stable")]
        few = np.concatenate([few, both[~np.isin(both, few)][:LIKELY]])
        return list(zip(rows[few // len(rows)], rows[few % len(rows)], strict=True))

    def _far(self, rows, cells, n):
        """How far pairs of changes are from the student's numbers in these cells: 1 if all n are missed."""
        changed, fits = (a[np.ix_(rows, cells)].astype(np.float32) for a in (self.changed, self.fits))
        alone, spoils = 1 - changed, changed * (1 - fits)
        spoiled = spoils @ alone.T
        missed = (alone * self.wrong[cells]) @ alone.T + spoiled + spoiled.T
        if not self.wrong[cells].any():
            return missed / n
        one = np.minimum(self._misses(rows, cells, _difference), self._misses(rows, cells, _ratio))
        open_ = (changed * self.wrong[cells]) @ changed.T  # what both of them change: nothing else tells of these
        return missed / n + np.minimum(one, 1) * open_ / n

    def _some_rows(self):
        """The changes that are paired: the listed ones, and those that explain most."""
        hits = (self.fits & self.wrong).sum(1) + 1e6 * np.array([row[0].listed for row in self.rows])
        return np.sort(np.argsort(-hits, kind="stable")[:PAIRED]) if len(hits) else np.array([], int)

    def _some_cells(self):
        """The numbers that are compared: some of the wrong ones, and of the right ones."""
        rng = np.random.default_rng(0)
        few = lambda places: places if len(places) <= CELLS else np.sort(rng.choice(places, CELLS, replace=False))
        return np.concatenate([few(np.flatnonzero(self.wrong)), few(np.flatnonzero(~self.wrong))])

    def _misses(self, rows, cells, what):
        """How far the effects of two changes are from adding up to that of the student, by pair."""
        with np.errstate(all="ignore"):
            D, r = what(self.V[np.ix_(rows, cells)], self.t[cells]), what(self.s[cells], self.t[cells])
            weight = 1 / (1e-9 + np.abs(r) + np.abs(D).min(0, initial=1e9, where=np.abs(D) > 0))
        good = np.isfinite(r) & np.isfinite(weight) & (np.abs(r) > 0)
        if not good.any():
            return np.ones((len(rows), len(rows)))
        D, r = D[:, good] * weight[good], r[good] * weight[good]
        bad = ~np.isfinite(D)
        D = np.where(bad, 0, np.clip(D, -1e3, 1e3))
        G, n = D @ D.T, np.sum((D - r) ** 2, 1) - r @ r
        far = np.maximum(n[:, None] + n + 2 * G + r @ r, 0) / len(r)
        return far + bad.mean(1)[:, None] + bad.mean(1)


@lru_cache(maxsize=16)  # those of a notebook, with other forms: who tries again asks for the same ones
def changes(exercise):
    """Return the changes of the solution: listed mistakes first, then slips."""
    mistakes = (*exercise.misconceptions, *exercise.slips())
    return [Change(mistake) for mistake in mistakes if hasattr(mistake, "solution")]


def forms_of(exercise, own):
    """Return the other forms of the solution that the student may have written."""
    return [form for form in exercise.forms if own_words.as_near(own, form.solution, exercise.solution)]


def in_another_form(exercise, calls, own):
    """Return, as a list, a change of another form of the solution that answers every call as the student did."""
    wrong_first = sorted(calls, key=lambda c: _agree(exercise, c.result, _called(exercise.solution, c.args)))
    for form in forms_of(exercise, own):
        for change in changes(form):
            fits = lambda change=change: answers(exercise, change.answer, wrong_first)
            if change.answer and _in_time(fits) and not own_words.doubtful(change.mistake, own):
                return [in_form(form, change.mistake)]
    return []


def by_a_factor(table, calls):
    """Return, as a list, the factor of a whole result that answers every call as the student did: no two mistakes."""
    if len(set(table.s[table.wrong])) < FEW_VALUES:
        return []
    factors = outers(table.exercise, table.right[0], FACTORS)
    return [factor for factor in factors if answers(table.exercise, factor.answer, calls)][:1]


def in_form(form, mistake):
    """Return the mistake; a slip says in which form of the solution it is."""
    if not mistake.edits:
        mistake = copy.copy(mistake)
        mistake.hint = f"In the form {form.note}: {mistake.hint}"
    return mistake


def find(table, calls, patience):
    """Return two mistakes that together answer every call as the student did, in the order in which to mend them.

    Parameters
    ----------
    table : Table
    calls : sequence of Call
        Calls in which all right answers give the same.
    patience : float
        Seconds of the processor after which the search ends in any case: `SEARCHED` steps come first, so that what is
        found does not depend on how busy the computer is.

    Returns
    -------
    list of Mistake or Slip
        Two, or none.
    """
    exercise, end, found, tried, steps = table.exercise, time.process_time() + patience, [], 0, 0
    likely, hidden = _tried(table, table.evident), _tried(table, table.hidden)
    whole = lambda one, other: composed(exercise.solution, one, other)
    in_some = lambda one, other: apart(table, one, other)
    searches = (
        (itertools.chain(itertools.islice(likely, FIRST), _with_outer(table), likely), whole, 0.4),
        (_tried(table, lambda i, j: table.ways(i, j) is not None and table.evident(i, j)), in_some, 0.5),
        (hidden, whole, 2 / 3),
        (_beside(table), whole, 3 / 4),
    )
    for pairs, with_both, share in searches:
        for one, other in pairs:
            if steps > share * SEARCHED or time.process_time() > end:
                break
            tried += 1
            for answer in with_both(one, other):
                steps += COMPILED + 2 * table.steps  # most pairs fail in the first or second call
                fits = lambda answer=answer: all(answers(exercise, answer, some) for some in (table.calls, calls))
                if _in_time(fits) and table.may_tell(one, other):
                    found.append((one, other))
                    break
            if found and not table.few:
                break
        if found or table.few:
            break
    if table.few:
        found = _sure(table, found, tried)
    if found and isinstance(found[0][1], Beside) and not found[0][1].is_of_the_solution:
        return [found[0][0].mistake]
    for change in found[0] if found and not table.few else ():
        alone = getattr(change, "answer", None)  # not of what is beside another one
        if alone and answers(exercise, alone, calls):  # one is enough, to what counts as rounding in this exercise
            return [change.mistake]
    if found and not table.few and not all(change.listed for change in found[0]) and (both := two_listed(table, calls)):
        return both
    known = _no_guess(table, calls, *found[0]) if found else []
    known = [change for change in known if not table.doubtful(change)]
    if len(known) == 1 and table.spoils(known[0]):
        known = []
    mistakes = sorted((change.mistake for change in known), key=exercise.fails_at)
    rows = [table.row_of[change] for change in known if change in table.row_of]
    return list(map(_sure_of, mistakes)) if len(rows) == 2 and table.evident(*rows) else mistakes


def _sure_of(mistake):
    """The mistake; a slip that shows in numbers of its own is no trace of another one."""
    if not mistake.edits:
        mistake = copy.copy(mistake)
        mistake.shows = True
    return mistake


def two_listed(table, calls):
    """Return two listed mistakes that together answer every call as the student did, the one to mend first first.

    Asked where one slip of a step does so, too, and the student has written that step as it belongs; and where a pair
    with a slip does: what is listed is what students do.
    """
    exercise = table.exercise
    evident = _tried(table, lambda i, j: _are_listed(table, i, j) and table.evident(i, j))
    hidden = _tried(table, lambda i, j: _are_listed(table, i, j) and not table.evident(i, j))
    for one, other in itertools.chain(itertools.islice(evident, FIRST), itertools.islice(hidden, FIRST)):
        for answer in composed(exercise.solution, one, other):
            fits = lambda answer=answer: answers(exercise, answer, calls)
            if _in_time(fits) and table.may_tell(one, other):
                return sorted((one.mistake, other.mistake), key=exercise.fails_at)
    return []


def _are_listed(table, *rows):
    return all(table.rows[k][0].listed for k in rows)


def _no_guess(table, calls, one, other):
    """Of two changes those that no other mistake may stand for: one that shows in few values only may be another.

    A slip that shows in an index, None, True or a count only is not told: these come of many a slip. A listed
    mistake is, if no other listed one comes to the same beside the other change.
    """
    exercise, rows, of = table.exercise, table.rows, table.row_of
    known = []
    for change, beside in (one, other), (other, one):
        if change in of and beside in of:
            left = table.wrong & ~table.fits[of[beside]]
            needed = left & table.changed[of[change]]
            if not change.listed and any(cells.any() and table.counted[cells].all() for cells in (needed, left)):
                continue
            rivals = [row[0] for row in rows if row[0].listed and row[0].mistake.hint != change.mistake.hint]
            if not table.has_decimals[needed].any() and any(
                answers(exercise, answer, [*table.calls, *calls])
                for rival in rivals
                for answer in composed(exercise.solution, rival, beside)
            ):
                continue
        known.append(change)
    return known


def _sure(table, found, tried):
    """The only pair that fits, if the answers say more than chance does: few values fit many pairs, one fits any."""
    alone = len({tuple(sorted(change.mistake.hint for change in pair)) for pair in found}) == 1
    return found if alone and not table.constant(table.wrong) and table.bits() >= SURE_BITS + np.log2(tried) else []


def _tried(table, which):
    """Yield pairs of changes, the likely ones first; of the first rows all changes that have the same results.

    What is the same alone need not be the same beside another change, and one may be in the other's way. Of the first
    rows, two slips are the last to be believed.
    """
    good = ((i, j) for i, j in table.pairs if which(i, j))
    goes = lambda one, other: one.function is not other.function or one.function is None or _merged(one, other)
    both = lambda i, j: itertools.product(*(_plain(table, table.rows[k]) for k in (i, j)))
    first = [pair for rows in itertools.islice(good, FIRST) for pair in both(*rows) if goes(*pair)]
    yield from sorted(first, key=lambda pair: 2 - pair[0].listed - pair[1].listed)
    for rows in good:
        yield from itertools.islice((pair for pair in both(*rows) if goes(*pair)), 1)


def _beside(table):
    """Yield listed mistakes, those that are nearest first, with the slips that are in what they have written anew."""
    if not table.tells:
        return
    exercise, near = table.exercise, []
    with np.errstate(all="ignore"):
        for v, row in zip(table.V, table.rows, strict=True):
            same = _near(np.abs(v), np.abs(table.s)) & table.wrong
            near += [(same.sum(), change) for change in row if change.listed]
    for _, change in sorted(near, key=lambda each: -each[0])[:BESIDE]:
        said = lambda slip: slip.hint.partition(" (with ")[0]  # what a name means depends on the text
        known = set(map(said, exercise.slips()))
        for slip in exercise.slips(change.mistake):
            if said(slip) not in known:
                yield change, Beside(slip)


def _plain(table, row):
    """Of changes that have the same results those to be tried: the first by rank, then those that change least."""
    row = [change for change in row if change.listed or not table.few]
    return sorted(row, key=lambda change: (*table.rank(change), change.size))[:TRIED] if len(row) > 1 else row


def _with_outer(table):
    """Yield the changes with a slip of a whole result, if the student's results without that slip are theirs."""
    exercise = table.exercise
    for outer in outers(exercise, table.right[0]):
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                undone = [guard.Call(c.args, outer.of(c.result, outer.undone)) for c in table.calls]
                s = np.concatenate([table.numbers(call.result, k) for k, call in enumerate(undone)])
            except Exception:
                continue
        for k in np.flatnonzero(_near(table.V, s).all(1) & table.changed.any(1))[:1]:
            yield from ((one, outer) for one in table.rows[k][:1] if one.listed and not table.few)


def answers(exercise, answer, calls) -> bool:
    """Return True if the answer gives what the student's function gave, in every call."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return all(_agree(exercise, c.result, _called(answer, c.args)) for c in calls)


def _in_time(job):
    """What a job returns; None if it does not end. A list that grows in the loop over it would fill the memory."""
    try:
        with edits.turns.at_most(TURNS):
            return job()
    except edits.Endless:
        return None


def _no_whole_numbers(numbers):
    with np.errstate(all="ignore"):
        return np.abs(numbers - np.round(numbers)) > 1e-9


def _steps(exercise, calls) -> float:
    """How many functions a call of the solution calls: what it costs, on each computer the same."""
    count, before = itertools.count(), sys.getprofile()
    some = calls[:3]
    sys.setprofile(lambda *_: next(count))
    try:
        for call in some:
            _called(exercise.solution, call.args)
    finally:
        sys.setprofile(before)
    return max(next(count), 1) / max(len(some), 1)


def _called(answer, args):
    """The result, or `Raised`; as `Exercise.result`, and quicker."""
    try:
        with np.errstate(all="ignore"):
            return answer(*map(_copy, args))
    except Exception as error:
        return guard.Raised(type(error).__name__, str(error))


def _key(args):
    """What tells these arguments from others; what cannot be written down is like nothing else."""
    try:
        return hashlib.blake2b(pickle.dumps(args), digest_size=16).digest()
    except Exception:
        return object()


def _copy(value):
    return value.copy() if isinstance(value, np.ndarray) else copy.deepcopy(value)


def _agree(exercise, given, result):
    """The same result, or the same kind of exception: its words depend on how a line is written."""
    if isinstance(given, guard.Raised) and isinstance(result, guard.Raised):
        return given.kind == result.kind
    return exercise.alike(given, result)


def _chosen(exercise, calls, right, most):
    """Some calls: two of three with a wrong result, spread over all of them, first one of each kind.

    Of one kind are the calls in which the same listed mistakes show: a seam of angles is in few of them.
    """
    wrong = [not exercise.alike(call.result, t) for call, t in zip(calls, right, strict=True)]
    kinds = [_kind(exercise, *each) for each in zip(calls, right, strict=True)] if len(calls) > most else calls
    of = lambda kind: [k for k, w in enumerate(wrong) if w == kind]
    spread = lambda some, n: [some[k] for k in np.unique(np.linspace(0, len(some) - 1, min(n, len(some))).astype(int))]

    def few(some, n):
        if len(some) <= n or kinds is calls:
            return spread(some, n)
        first = list({kinds[k]: k for k in reversed(some)}.values())
        return [*spread(first, n), *spread([k for k in some if k not in first], n - min(len(first), n))]

    good = of(False)
    bad = few(of(True), 2 * most // 3 if good else most)
    chosen = [*bad, *few(good, most - len(bad))] if good else bad
    return [calls[k] for k in chosen]


def _blank(kind):
    """The numbers of a change that fails in a call; None where some are no numbers, and are compared as a whole."""
    return None if any(one for *_, one in kind) else np.full(sum(np.size(right) for right, *_ in kind), np.nan)


def _only_raise(exercise, calls, right) -> bool:
    """Return True if each call that is not right has raised: then no number tells one mistake from others."""
    wrong = (call.result for call, t in zip(calls, right, strict=True) if not exercise.alike(call.result, t))
    return all(isinstance(result, guard.Raised) for result in wrong)


def _always_the_same(exercise, calls, right) -> bool:
    """Return True if the student's results are all the same, though the right ones are not: no slip does that."""
    same = lambda results: all(exercise.alike(result, results[0]) for result in results[1:])
    return same([call.result for call in calls]) and not same(right)


def _kind(exercise, call, right):
    """Which listed mistakes show in a call: computed once for the same arguments, whoever answers."""
    known, key = _kinds(exercise), _key(call.args)
    if len(known) > 10 * KEPT:
        known.clear()
    if key not in known:
        known[key] = tuple(exercise.alike(_called(m.answer, call.args), right) for m in exercise.misconceptions)
    return known[key]


@lru_cache(maxsize=16)  # as many as there are of `changes`
def _kinds(exercise) -> dict:
    return {}


def _floats(value):
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    numbers = guard.numbers(value)
    return numbers.astype(float) if numbers is not None and numbers.dtype.kind in "fiub" else value


def _is_floats(value):
    return isinstance(value, np.ndarray) and value.dtype.kind == "f"


def _same(a, b):
    if isinstance(a, guard.Raised) and isinstance(b, guard.Raised):
        return a.kind == b.kind
    return not isinstance(a, guard.Raised) and not isinstance(b, guard.Raised) and guard.equal(a, b, 1e-6, 1e-8)


def _near(a, b):
    """The same numbers to rounding; of what is not finite one is as good as another."""
    with np.errstate(all="ignore"):
        return (np.abs(a - b) <= 1e-8 + 1e-6 * np.abs(b)) & np.isfinite(b) | ~np.isfinite(a) & ~np.isfinite(b)


def _difference(a, t):
    return a - t


def _ratio(a, t):
    """The logarithm of |a / t|; not finite where one of them is zero."""
    return np.log(np.abs(a / t))
