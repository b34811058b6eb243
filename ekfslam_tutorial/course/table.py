"""An exercise as a table: the solution, cases, what each check looks at, and wrong answers as edits.

::

    def scaled(x, a):
        '''Return a x.'''
        return a * x

    exercise = table(
        "02.9 Scaling", scaled,
        hints=("level 1", "level 2", "level 3"),
        returns="ax",
        cases={"any": lambda rng: [(rng.normal(size=3), a) for a in (2.0, -0.5)]},
        checks='''
        size       | ax     | any | Is every entry multiplied?
        ''',
        wrong='''
        forgets a: The factor a has no effect in your function.
            a * x -> x
        ''',
    )

What does not fit into the table is added to it: ``@exercise.link(...)`` for a property of another kind,
``@exercise.wrong(...)`` for a wrong answer that is no edit.
"""

from __future__ import annotations

import functools
import re

import numpy as np

from ..geometry import numerical_jacobian, wrap
from . import expect, guard
from .diagnose import same
from .exercise import Exercise

DERIVATIVE = r"d (\w+)(?:\[(\d)\])? / (\w+)"  # a matrix, perhaps one row of it, and by what
NEXT = r", (?=[A-Za-z])"  # between two results, not between two indices


def table(
    title,
    solution,
    *,
    hints,
    returns,
    cases,
    checks,
    wrong,
    jacobians=None,
    angles=None,
    entries=None,
    rtol=None,
    settled=None,
    along=None,
    shown=None,
    kinds=None,
    form=None,
    forms="",
    symbols="",
    **options,
):
    """Build an `Exercise`.

    Parameters
    ----------
    title : str
        Number and title: ``"02.9 Scaling"``.
    solution, hints, **options
        As of `Exercise`.
    returns : str
        Names of the results, in order: ``"l, L_y"``. Their shapes are those of the solution's results.
    cases : dict of str to callable
        ``rng -> list of argument tuples``. The case ``any`` is wanted; take one for the limits, too.
    checks : str
        A line each: ``name | result | case | help``. The result is a name, or a part of it (``P[:3, :3]``), or
        ``d L_y / y``, which compares the Jacobian L_y with differences; ``d L_y[0] / y`` its first row. Several of
        them, ``x, P``, make a link each.
    wrong : str
        A block each: ``name: hint``, and below it, indented, edits ``old -> new`` of the solution's source.
    jacobians : dict, optional
        The result, or function of the same arguments, that each Jacobian is the derivative of:
        ``{"L_y": "l"}``. A function is wanted where the result wraps an angle.
    angles : dict, optional
        Which entries of a result are angles, compared up to whole turns: ``{"x": 2}``; all of them: ``{"a": ...}``.
    entries : dict, optional
        What the entries of a result or a parameter are called, for the messages about Jacobians:
        ``{"l": "x_l, y_l", "y": "range, bearing"}``.
    rtol : dict, optional
        What counts as rounding in a result, relative to its largest entry, if it is not 1e-5: ``{"P": 1e-3}``. More
        is for results that some right answers have with less precision, such as after a first guess of 1e6.
    settled : callable, optional
        ``results, right ones -> results``, before they are compared: brings results that mean the same to one
        form, such as q and -q.
    along : dict, optional
        Where formulas differ that are equal for all states that there are (off the unit sphere of q): a projector
        behind which a Jacobian is compared, ``{"X_x": lambda x, u: tangent(x)}``.
    shown : callable, optional
        What the messages call the arguments: ``arguments -> text``, if it is not their values.
    kinds : dict, optional
        What kind of value a result is, if it is no array: ``{"i": "an index counted from 0, or None"}``.
    form : str, optional
        What the first link says of results of a wrong form, where no check says more of them.
    forms : str, optional
        Right answers in other forms, written as `wrong` is: slips are looked for in them, too. The cell of the hint
        says what is written so, ``P = P - K H P``.
    symbols : str, optional
        What the hints call by names that the statement does not have: ``"P_x = dp/dx; q = [u, v, 1]"``. Of those that
        a hint names the student is told.

    Returns
    -------
    Exercise
        Its first link, "the results", asks for the right number of results, of the right shapes.
    """
    names = [name.strip() for name in returns.split(",")]
    angles = {names.index(name): entry for name, entry in (angles or {}).items()}
    if angles and "canonical" not in options:
        options["canonical"] = lambda result: _turned(result, angles, len(names))
    id, title = title.split(" ", 1)
    made = Exercise(id, title, solution, hints, cases=cases, **options)
    made.returns, made.symbols = names, [text.strip() for text in symbols.split(";") if text.strip()]
    params, lines = made.parameters(), rows(checks)
    said = shown or (lambda *args: at(params, args))
    helps, of_row = {}, {}
    for _name, what, case, help in lines:
        helps.setdefault(_part(what, names), (help, case))
        of_row.setdefault((case, help), {})[_part(what, names)] = ("", case)

    def help_to(i, args, right, row):
        """The help to result i; where inputs decide its size, not the help that goes with a case of another size."""
        help, case = (helps | of_row.get(row, {})).get(i, ("", None))
        if not help:
            return ""
        there = solution(*cases[case](np.random.default_rng(0))[0])
        same = np.shape(there[i] if len(names) > 1 else there) == np.shape(right)
        of_here = same or case == (row or ("any",))[0]
        if of_here or form:
            return help if of_here else form
        shown = said(*args)
        return "" if "an array (" in shown else f"A case that you can do on paper: {shown}."

    def parts(args, result, row=()):
        """The results of one call in the types and shapes of the solution's, else `Failed`.

        With the help to the part that fails; for the parts that a row is about its links have their own.
        """
        right = solution(*args)
        if len(names) == 1:
            taken, right = [_taken(result, right, names[0], lambda: help_to(0, args, right, row))], [right]
        else:
            given = expect.results(result, *names)
            _in_order(given, right, returns)
            taken = [
                _taken(value, want, name, functools.partial(help_to, i, args, want, row))
                for i, (value, want, name) in enumerate(zip(given, right, names, strict=True))
            ]
        return settled(taken, right) if settled else taken

    @made.link("the results", form or _form(names, returns))
    def _(f, rng):
        for args in cases["any"](rng):
            parts(args, f(*args))

    for name, what, case, help in lines:
        part = _part(what, names)
        if case not in cases:
            raise ValueError(f"{id}, {name}: there is no case {case!r}; there are {', '.join(cases)}")
        of_this = functools.partial(parts, row=(case, help))
        derivative, sphere = re.fullmatch(DERIVATIVE, what), (along or {}).get(names[part])
        if derivative:
            of = (jacobians or {})[names[part]]
            value = _one(solution, names.index(of)) if isinstance(of, str) else of
            labels = _labels(entries, of if isinstance(of, str) else names[part]), _labels(entries, derivative[3])
            row, place = int(derivative[2]) if derivative[2] else None, params.index(derivative[3])
            test = _derivative(cases[case], of_this, part, names[part], value, place, labels, row, sphere)
        else:
            right, rounding = _one(solution, part if len(names) > 1 else None), (rtol or {}).get(names[part], 1e-5)
            kind = f" ({kinds[names[part]]})" if kinds and names[part] in kinds else ""
            test = _value(cases[case], of_this, part, what, kind, right, said, angles, rounding, sphere)
        made.link(name, help, part if len(names) > 1 else None)(test)
    made.edited(wrong)
    made.written(forms)
    return made


def rows(text: str) -> list[list[str]]:
    """Return lines of four cells between bars; a line about several results is one line for each."""
    found = [[cell.strip() for cell in line.split("|", 3)] for line in text.strip().splitlines() if line.strip()]
    for row in found:
        if len(row) != 4:
            raise ValueError(f"a check is written `name | result | case | help`, got {' | '.join(row)!r}")
    return [
        [name if i == 0 else f"{name}: {what}", what, case, help]
        for name, several, case, help in found
        for i, what in enumerate(re.split(NEXT, several))
    ]


def _part(what, names):
    """The number of the result that a check looks at."""
    derivative = re.fullmatch(DERIVATIVE, what)
    name = derivative[1] if derivative else what.split("[")[0]
    if name not in names:
        raise ValueError(f"there is no result {name!r}; there are {', '.join(names)}")
    return names.index(name)


def _one(solution, part):
    """The function that gives one result of the solution."""
    return solution if part is None else lambda *args: solution(*args)[part]


def _in_order(given, right, returns):
    """Raise `Failed` if the results have the right shapes, but in another order only.

    Of lists nothing is said: where the right ones have three places and none, another mistake may give none and three.
    """
    wanted, shapes = (list(map(_shape_of, values)) for values in (right, given))
    moved = [want for shape, want in zip(shapes, wanted, strict=True) if shape != want]
    lists = all(want is not None and len(want) == 1 for want in moved)
    if not lists and None not in wanted and sorted(shapes, key=str) == sorted(wanted, key=str):
        said = ", ".join(map(str, shapes))
        raise expect.Failed(
            f"your results have the shapes {said}, so they are in another order than `return {returns}`",
            f"The order of the results counts: `return {returns}`. Whoever calls your function takes them apart so.",
        )


def _shape_of(value):
    """The shape of a number or an array, None for anything else."""
    numbers = guard.numbers(value)
    return None if numbers is None else numbers.shape


def _form(names, returns) -> str:
    """What is wanted of the form of the results."""
    if len(names) == 1:
        return f"One thing is returned, {returns}, in the shape that the statement says."
    return f"{len(names)} things are returned, in this order: {returns}. Each has the shape that the statement says."


def _taken(value, right, name, help):
    """A student's result in the type of the right one: arrays and numbers as float arrays, ids as plain values."""
    if not _is_numeric(right):
        return value
    if np.size(right) == 0 and isinstance(value, (list, tuple)) and len(value) == 0:
        return np.zeros(np.shape(right))  # an empty list has no second axis that could be wrong
    try:
        return expect.array(value, np.shape(right), name)
    except expect.Failed as failed:
        help = help()
        both = failed.hint == expect.NO_NUMBER and help
        raise expect.Failed(str(failed), f"{failed.hint} {help}" if both else failed.hint or help) from None


def _is_numeric(value) -> bool:
    return isinstance(value, (np.ndarray, float, np.floating, np.bool_))


def _value(cases, parts, part, what, kind, right, said, angles, rtol, sphere):
    """The test that one result, or a part of it, is that of the solution."""
    place, name = _place(what), what + kind

    def test(f, rng):
        for args in cases(rng):
            want, shown = right(*args), said(*args)
            try:
                got = parts(args, f(*args))[part]
            except expect.Failed as failed:
                if " has shape " not in str(failed):
                    raise
                raise expect.Failed(f"{failed} for {shown}", failed.hint) from None
            if not _is_numeric(want):
                message = f"{name} is {_shown(got)} for {shown}, it should be {_shown(want)}"
                expect.true(_is_truth(got) == _is_truth(want) and guard.equal(got, want), message)
                continue
            if np.asarray(want).dtype.kind in "biu":
                _told_apart(_whole(got, want)[place], want[place], name, shown)
                continue
            got, want = np.array(got, float), np.asarray(want, float)
            if part in angles:
                got[angles[part]] = _turned_to(got[angles[part]], want[angles[part]])
            if sphere and same(got @ sphere(*args), want @ sphere(*args)):
                continue
            expect.close(got[place], want[place], name, rtol, at=shown)

    return test


def _told_apart(got, want, name, shown):
    """Whole numbers and truth values must be those wanted: they have no slips of decimals, signs or units."""
    swapped = want.dtype.kind != "b" and np.array_equal(np.sort(got, None), np.sort(want, None))
    order = ". The entries are in the wrong order" if swapped else ""
    if np.array_equal(got, want):
        return
    got_text, want_text = _shown(got), _shown(want)
    if got_text == want_text:  # too many to be shown: the first that differs
        at = tuple(np.argwhere(got != want)[0])
        name = f"{name}, entry [{', '.join(map(str, at))}],"
        got_text, want_text = _shown(got[at]), _shown(want[at])
    raise expect.Failed(f"{name} is {got_text} for {shown}, it should be {want_text}{order}")


def _whole(got, want):
    """The numbers in the type of the right ones, if they are such: for the messages."""
    whole = np.asarray(got).astype(np.asarray(want).dtype)
    return whole if np.array_equal(whole, got) else got


def _turned_to(got, want):
    """The angles without the whole turns by which they differ; wrong ones as they are, so that a message shows them."""
    off = wrap(got - want)
    return np.where(np.abs(off) < 1e-5 * (1 + np.abs(want)), want + off, got)


def _place(what):
    """The index in a text such as `P[:3, :3]`."""
    inside = re.fullmatch(r"\w+\[(.*)\]", what)
    return eval(f"np.s_[{inside[1]}]", {"np": np}) if inside else ...


def _labels(entries, name):
    """What the entries are called, or None."""
    text = (entries or {}).get(name)
    return text and [entry.strip() for entry in text.split(",")]


def _derivative(cases, parts, part, name, value, at, labels, row, sphere):
    """The test that a Jacobian agrees with differences."""

    def test(f, rng):
        for args in cases(rng):
            got = parts(args, f(*args))[part]
            along = lambda x, args=args: np.asarray(value(*args[:at], x, *args[at + 1 :]))
            if sphere and same(got @ sphere(*args), numerical_jacobian(along, args[at]) @ sphere(*args)):
                continue
            expect.jacobian(got, along, args[at], name, *labels, row=row)

    return test


def _turned(result, angles, n):
    """The results with their angles wrapped, so that whole turns do not count."""
    parts = [result] if n == 1 else list(result)
    for i, entry in angles.items():
        parts[i] = np.array(parts[i], float)
        seam = wrap(parts[i][entry])
        parts[i][entry] = np.where(np.abs(np.abs(seam) - np.pi) < 3e-5, np.pi, seam)
    return parts[0] if n == 1 else tuple(parts)


def at(params, args) -> str:
    """Return the arguments as a student reads them; large ones only by their shape."""
    return ", ".join(f"{name} = {_shown(value)}" for name, value in zip(params, args, strict=True))


def _is_truth(value) -> bool:
    """Return True for truth values: True is no index, 1 no truth value."""
    numbers = guard.numbers(value)
    return numbers is not None and numbers.dtype.kind == "b"


def _shown(value) -> str:
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, np.ndarray):
        if value.ndim == 1 and value.size <= 30 and value.dtype.kind in "biu":
            return str(value.astype(int).tolist())
        if value.size > 9:
            return f"an array {value.shape}"
        most = np.abs(value).max(initial=0) if value.dtype.kind == "f" else 0
        if 0 < most < 0.1:  # a covariance of small errors: three digits of each entry, and rounding is zero
            small = lambda v: f"{v:.3g}" if abs(v) > 1e-9 * most else "0"
            return np.array2string(value, formatter={"float_kind": small}, separator=", ").replace("\n", "")
        return np.array2string(value, precision=3, suppress_small=True, separator=", ").replace("\n", "")
    if isinstance(value, (float, np.floating)):
        return f"{value:.4g}" if abs(value - 1) > 5e-4 or value == 1 else f"{value:.10g}"  # not 1 for 0.999999
    if isinstance(getattr(value, "x", None), np.ndarray):  # a frame
        return f"{type(value).__name__}({_shown(value.x)})"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."
