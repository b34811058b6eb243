"""Two mistakes at once, found among all pairs of changes of the solution.

A *change* is a listed mistake that is an edit, or a slip of any formula. Each is run once on some of the student's
calls: a table, a row for a change, a column for each number that came out. Where a number is what one change makes of
it, and no other one touches it, one of the pair is found; so most pairs are refused without being run. For the rest,
the differences from the right numbers add up, or their ratios multiply, to first order: the pairs are tried in that
order, the solution with both changes in it, and named is only one that answers every call as the student did.
"""

from __future__ import annotations

import copy
import itertools
import os.path
import time
import types
import warnings

import numpy as np

from . import edits, guard

CALLS = 12  # of the table
CELLS = 250  # numbers of the table, of those that are wrong, and of those that are right
SURE_BITS = 4.0  # a fit with less evidence than this is chance: one in 16
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

    def hunks(self):
        """What is written otherwise: start, end, and what stands there instead; each as short as it can be."""
        spans = []
        for old, new in self.mistake.edits or ((self.old, self.body),):
            start = self.old.find(old)
            if start < 0:  # an edit of an edit
                return [_shortest(0, self.old, self.body)]
            spans.append(_shortest(start, old, new))
        return spans

    def places(self):
        """The same as edits: with so much of the text around each that it stands there once."""
        found = []
        for start, end, new in self.hunks():
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


def composed(solution, one: Change, other: Change):
    """Return the solution with both changes, or None if they do not go together."""
    made = {}
    for change in (one, other):
        body = change.body if change.function not in made else _merged(one, other)
        if body is None:
            return None
        made[change.function] = body
    try:
        made = {f: edits.function(f, edits.parts(f)[0] + body, "two mistakes") for f, body in made.items()}
    except Exception:
        return None
    main = made.pop(solution, solution)
    if not made:
        return main
    space = main.__globals__ | {f.__name__: new for f, new in made.items()}
    return types.FunctionType(main.__code__, space, main.__name__, main.__defaults__)


def _merged(one, other):
    """The text with both changes; None if one takes the other's place away."""
    hunks = sorted([*one.hunks(), *other.hunks()])
    if all(a[1] <= b[0] and a[:2] != b[:2] for a, b in itertools.pairwise(hunks)):
        text, at = "", 0
        for start, end, new in hunks:
            text, at = text + one.old[at:start] + new, end
        return text + one.old[at:]
    for first, second in ((one, other), (other, one)):
        try:
            return edits.applied(first.body, second.places(), "")
        except ValueError:
            continue
    return None


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

    def __init__(self, exercise, calls, patience, most=CALLS):
        end = time.process_time() + patience
        self.exercise = exercise
        right = [exercise.result(exercise.solution, call.args) for call in calls]
        self.calls = _chosen(exercise, calls, right, most)
        self.right = [exercise.result(exercise.solution, call.args) for call in self.calls]
        self.t, self.s, self.kinds = self._columns()
        rows, values = {}, []
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of changes that make nonsense
            for change in changes(exercise):
                if time.process_time() > end:
                    break
                answer = change.mistake.answer
                if answer is None:
                    continue
                v = self._row(answer)
                key = np.round(v, 7).tobytes()
                if key not in rows:
                    values.append(v)
                rows.setdefault(key, []).append(change)
        self.rows = list(rows.values())
        self.V = np.array(values).reshape(len(values), len(self.t))
        self.changed, self.fits = ~_near(self.V, self.t), _near(self.V, self.s)
        self.wrong = ~_near(self.s, self.t)

    def _columns(self):
        """What is right, what the student gave, and by call and result whether it is compared number by number."""
        t, s, kinds, parts, calls = [], [], [], [], []
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
            kinds.append(kind)
        self.parts, self.of_call = np.array(parts), np.array(calls)
        return np.concatenate(t), np.concatenate(s), kinds

    def _parts(self, result):
        """The results of a call as arrays of floats; what is no number as it is."""
        try:
            result = result if self.exercise.canonical is None else self.exercise.canonical(result)
        except Exception:
            pass
        parts = result if isinstance(result, tuple) else (result,)
        return [_floats(part) for part in parts]

    def _row(self, answer):
        """The numbers of one change: NaN where it gives something else than numbers of that shape."""
        row = []
        for call, kind in zip(self.calls, self.kinds, strict=True):
            result = _called(answer, call.args)
            parts = self._parts(result)
            parts = [result] if len(kind) == 1 and len(parts) != 1 else parts
            fit = len(parts) == len(kind)
            for i, (right, given, one) in enumerate(kind):
                part = parts[i] if fit else None
                if one:
                    row.append([0.0 if _same(part, right) else 1.0 if _same(part, given) else 2.0])
                elif _is_floats(part) and part.shape == right.shape:
                    row.append(np.ravel(part))
                else:
                    row.append(np.full(np.size(right), np.nan))
        return np.concatenate(row)

    def single(self):
        """The changes that alone give all that the student gave; none if there is no such row."""
        found = np.flatnonzero(self.fits.all(1))
        return self.rows[found[0]] if len(found) else []

    def of_part(self, part):
        """The changes that give what is wrong in one result, and spoil nothing that the student has otherwise."""
        here = self.wrong & (self.parts == part)
        good = self.fits[:, here].all(1) & ~(self.changed & ~self.fits).any(1) & here.any()
        found = np.flatnonzero(good)
        return self.rows[found[0]] if len(found) else []

    def bits(self) -> float:
        """How much the student's answers say: each call as much as few rows of the table have that answer to it."""
        total, n = 0.0, max(len(self.rows), 1)
        for k in range(len(self.calls)):
            total += np.log2(n / max(int(self.fits[:, self.of_call == k].all(1).sum()), 1))
        return total

    def pairs(self):
        """Yield pairs of rows that may do it together, the likely ones first."""
        cells = self._some_cells()
        changed, fits, wrong = self.changed[:, cells], self.fits[:, cells], self.wrong[cells]
        as_floats = lambda a: a.astype(np.float32)
        ch, alone, spoils = as_floats(changed), as_floats(~changed), as_floats(changed & ~fits)
        missed = (alone * wrong) @ alone.T
        spoiled = spoils @ alone.T
        possible = np.triu((missed + spoiled + spoiled.T) == 0, 1)
        i, j = np.nonzero(possible)
        if not len(i):
            return
        error = np.minimum(self._misses(cells, i, j, _difference), self._misses(cells, i, j, _ratio))
        listed = np.array([row[0].listed for row in self.rows])
        slips = 2 - listed[i].astype(int) - listed[j]
        for k in np.lexsort((slips, np.round(error, 4) + 0 * ch[0, 0])):
            yield i[k], j[k]

    def _some_cells(self):
        """The numbers that are compared: some of the wrong ones, and of the right ones."""
        rng = np.random.default_rng(0)
        few = lambda places: places if len(places) <= CELLS else np.sort(rng.choice(places, CELLS, replace=False))
        return np.concatenate([few(np.flatnonzero(self.wrong)), few(np.flatnonzero(~self.wrong))])

    def _misses(self, cells, i, j, what):
        """How far the effects of two changes are from adding up to that of the student, by pair."""
        with np.errstate(all="ignore"):
            D, r = what(self.V[:, cells], self.t[cells]), what(self.s[cells], self.t[cells])
            weight = 1 / (1e-9 + np.abs(r) + (np.abs(D).min(0, initial=np.inf, where=np.abs(D) > 0)))
        good = np.isfinite(r) & np.isfinite(weight)
        if not good.any():
            return np.full(len(i), np.inf)
        D, r = D[:, good] * weight[good], r[good] * weight[good]
        bad = ~np.isfinite(D)
        D = np.where(bad, 0, np.clip(D, -1e6, 1e6))
        G, g = D @ D.T, D @ r
        n = np.diag(G) - 2 * g
        return np.maximum(n[i] + n[j] + 2 * G[i, j] + r @ r, 0) / len(r) + 10 * (bad.mean(1)[i] + bad.mean(1)[j])


def changes(exercise):
    """Yield the changes of the solution: listed mistakes first, then slips."""
    for mistake in (*exercise.misconceptions, *exercise.slips()):
        if hasattr(mistake, "solution"):
            yield Change(mistake)


def find(table, calls, patience, few=False):
    """Return two mistakes that together answer every call as the student did, in the order in which to mend them.

    Parameters
    ----------
    table : Table
    calls : sequence of Call
        Calls in which all right answers give the same.
    patience : float
        Seconds of the processor.
    few : bool
        Answers have few values, so that pairs fit by chance: one is returned only if it is the only one that fits, and
        if the calls say more than it takes to find one pair of so many.

    Returns
    -------
    list of Mistake or Slip
        Two, or none.
    """
    exercise, end, found = table.exercise, time.process_time() + patience, []
    for n, (one, other) in enumerate(_tried(table), 1):
        if time.process_time() > end:
            break
        answer = composed(exercise.solution, one, other)
        if answer is None or not answers(exercise, answer, table.calls) or not answers(exercise, answer, calls):
            continue
        found.append((one, other))
        if not few:
            break
    if not found or few and (len(found) > 1 or table.bits() < SURE_BITS + np.log2(n)):
        return []
    return sorted((change.mistake for change in found[0]), key=exercise.fails_at)


def _tried(table):
    """Yield pairs of changes; of rows with several changes the first ones, as long as they are in each other's way."""
    for i, j in table.pairs():
        for one, other in itertools.product(table.rows[i][:TRIED], table.rows[j][:TRIED]):
            if one.function is not other.function or _merged(one, other) is not None:
                yield one, other
                break


def answers(exercise, answer, calls) -> bool:
    """Return True if the answer gives what the student's function gave, in every call."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return all(_agree(exercise, c.result, _called(answer, c.args)) for c in calls)


def _called(answer, args):
    """The result, or `Raised`; as `Exercise.result`, and quicker."""
    try:
        with np.errstate(all="ignore"):
            return answer(*map(_copy, args))
    except Exception as error:
        return guard.Raised(type(error).__name__, str(error))


def _copy(value):
    return value.copy() if isinstance(value, np.ndarray) else copy.deepcopy(value)


def _agree(exercise, given, result):
    """The same result, or the same kind of exception: its words depend on how a line is written."""
    if isinstance(given, guard.Raised) and isinstance(result, guard.Raised):
        return given.kind == result.kind
    return exercise.alike(given, result)


def _chosen(exercise, calls, right, most):
    """Some calls: two of three with a wrong result, spread over all of them."""
    wrong = [not exercise.alike(call.result, t) for call, t in zip(calls, right, strict=True)]
    of = lambda kind: [call for call, w in zip(calls, wrong, strict=True) if w == kind]
    few = lambda some, n: [some[k] for k in np.unique(np.linspace(0, len(some) - 1, min(n, len(some))).astype(int))]
    bad, good = few(of(True), 2 * most // 3), of(False)
    return [*bad, *few(good, most - len(bad))] if good else bad


def _floats(value):
    numbers = guard.numbers(value)
    return numbers.astype(float) if numbers is not None and numbers.dtype.kind in "fiub" else value


def _is_floats(value):
    return isinstance(value, np.ndarray) and value.dtype.kind == "f"


def _same(a, b):
    if isinstance(a, guard.Raised) and isinstance(b, guard.Raised):
        return a.kind == b.kind
    return not isinstance(a, guard.Raised) and not isinstance(b, guard.Raised) and guard.equal(a, b, 1e-6, 1e-8)


def _near(a, b):
    with np.errstate(all="ignore"):
        return (np.abs(a - b) <= 1e-8 + 1e-6 * np.abs(b)) | (a == b)


def _difference(a, t):
    return a - t


def _ratio(a, t):
    """The logarithm of |a / t|; not finite where one of them is zero."""
    return np.log(np.abs(a / t))
