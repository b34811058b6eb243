"""Slips that happen in every formula: the solution with one sign, factor, name ... of it written otherwise.

Where none of the listed mistakes explains an answer, one of these may. Its sentence quotes the place: the student's
results are those of one expression where another one belongs. So nothing is guessed.
"""

from __future__ import annotations

import ast
import copy
import itertools
import re
import sys
import types
from collections.abc import Iterator
from typing import Any

from . import edits

MOST = 1500  # slips of one solution; each costs a compilation
MOST_TERMS = 12  # that may be added to an angle
LONGEST = 90  # characters of an expression that is quoted
LONGEST_FORMULA = 60  # of one that may be written out in place of a name
A_NAME = r"[^\W\d]\w*"
LONGEST_MEANING, MOST_MEANINGS = 60, 4  # of what explains the names in a sentence

EXCHANGED = {"sin": "cos", "cos": "sin", "arctan": "tan", "arcsin": "sin", "arccos": "cos",
             "min": "max", "max": "min", "argmin": "argmax", "any": "all", "all": "any",
             "eye": "zeros", "hstack": "vstack", "sum": "mean", "mean": "sum", "flatnonzero": "nonzero",
             "isin": "not isin"}  # fmt: skip
AROUND = {"wrap": "wrap", "sqrt": "root", "inv": "inverse", "abs": "absolute value"}
COUNTING = {"linspace", "arange", "range", "full", "reshape"}  # arguments that nobody exchanges
COMPARED = {ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.GtE), ast.Gt: (ast.GtE, ast.Lt),
            ast.GtE: (ast.Gt, ast.LtE), ast.Eq: (ast.NotEq,)}  # fmt: skip


class Slip:
    """The solution, or a listed mistake, with one more slip.

    `quoted` is what its sentence says: what belongs there, and what stands there instead; None if it quotes nothing.
    `shows` is True if it is found beside another mistake, and in numbers that this one does not touch.
    """

    edits: tuple = ()
    shows = False

    def __init__(self, solution, hint, body, user=None, quoted=None):
        self.name = f"slip: {hint.partition(': your')[0]}"
        self.solution, self.hint, self.body, self.user, self.quoted = solution, hint, body, user, quoted

    @property
    def answer(self):
        """The function, or None where the slip makes nonsense. Made anew each time: there are a thousand slips."""
        try:
            made = edits.function(self.solution, edits.parts(self.solution)[0] + self.body, self.name)
        except Exception:
            return None
        if self.user is None:
            return made
        space = self.user.__globals__ | {made.__name__: made}
        return types.FunctionType(self.user.__code__, space, self.user.__name__, self.user.__defaults__)


def slips(solution, body=None) -> list[Slip]:
    """Return the slips of a solution, the likely ones first.

    Parameters
    ----------
    solution : function
    body : str, optional
        What stands in place of its own body: that of a listed mistake, for two mistakes at once.

    Returns
    -------
    list of Slip
    """
    own = edits.parts(solution)
    head, body = own[0], own[1] if body is None else body
    found, seen = [], {body}
    try:
        function = ast.parse(head + body).body[0]
    except SyntaxError:
        return []
    for sentence, text, *quoted in _of(function, _Text(head, body)):
        if text not in seen:
            seen.add(text)
            found.append(Slip(solution, sentence, text, quoted=tuple(quoted) or None))
    return found[:MOST]


def slips_of_helpers(solution) -> list[Slip]:
    """Return the slips of those functions of other exercises that a solution calls: a student may write them anew.

    First come the mistakes that the other exercise knows.
    """
    found = []
    for name in solution.__code__.co_names:
        helper = solution.__globals__.get(name)
        if isinstance(helper, types.FunctionType) and helper.__module__.startswith(f"{__package__}.exercises"):
            body = edits.parts(helper)[1]
            for known in _listed(helper):
                text = edits.applied(body, known.edits, known.name)
                found.append(Slip(helper, f"As in `{name}`. {known.hint}", text, solution))
            told = ((f"As in `{name}`. {s.hint}", s) for s in slips(helper))
            found += [Slip(helper, hint, s.body, solution, s.quoted) for hint, s in told]
    return found


def as_told(mistake, own):
    """Return a mistake as it is told to who has written `own`, a Counter of formulas or None.

    Who calls a function of another exercise has it right there: the mistake is in what is made of it.
    """
    if own and isinstance(mistake, Slip) and mistake.user is not None and own[f"name {mistake.solution.__name__}"]:
        called = f"`{mistake.solution.__name__}`"
        told = f"What you make of {called} comes out as if there were a mistake in it: "
        mistake = copy.copy(mistake)
        mistake.hint = mistake.hint.replace(f"As in {called}. ", told)
    return mistake


def _listed(helper) -> list:
    """The mistakes that are edits of a solution, by the exercise in whose module it stands."""
    made = vars(sys.modules[helper.__module__]).values()
    exercises = [e for e in made if getattr(e, "solution", None) is helper]
    return [m for e in exercises for m in e.misconceptions if m.edits]


class _Text:
    """A function as text, in which the place of a node is written otherwise."""

    def __init__(self, head, body):
        self.text, self.head = head + body, len(head)
        lines = self.text.splitlines(keepends=True)
        self.starts = [sum(map(len, lines[:i])) for i in range(len(lines) + 1)]

    def span(self, node):
        return self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset

    def of(self, node):
        start, end = self.span(node)
        return " ".join(self.text[start:end].split())

    def both(self, around, node, new):
        """An expression as it is, and with this node in it written otherwise."""
        (start, end), (a, b) = self.span(around), self.span(node)
        return self.text[start:end], self.text[start:a] + new + self.text[b:end]

    def with_(self, node, new, brackets=True):
        start, end = self.span(node)
        new = f"({new})" if brackets and not re.fullmatch(r"[a-z][\w.]*", new, re.IGNORECASE) else new
        return self.text[self.head : start] + new + self.text[end:]

    def with_all(self, nodes, new):
        body, at = "", self.head
        for start, end in sorted(map(self.span, nodes)):
            body, at = f"{body}{self.text[at:start]}({new})", end
        return body + self.text[at:]


def _of(function, text) -> Iterator[tuple[str, ...]]:
    """Yield the sentence and the new body of each slip; and, if it quotes them, what belongs and what stands there."""
    statements = [n for n in ast.walk(function) if isinstance(n, ast.stmt) and n is not function]
    if ast.get_docstring(function) is not None:
        statements.remove(function.body[0])
    parameters = [a.arg for a in function.args.args]
    means = _meanings(function, parameters)

    places = _Places(function, statements, text)

    def told(what, at, old, new):
        old, new = (" ".join(s.split()) for s in (old, new))
        if max(len(old), len(new)) > LONGEST:
            return f"{what}: look at `{old[:40]} ...`." if len(old) > LONGEST else f"{what}: look at `{old}`."
        where = places.of(at, old) + _explained(means, old, new)
        return f"{what}: your results are as if `{new}` stood where `{old}` belongs{where}."

    nodes = sorted(_nodes(function), key=lambda n: not isinstance(n, ast.Attribute))  # transposes first
    locals_ = [*parameters, *_assigned(function)]
    written = {id(n.value) for n in nodes if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store)}
    names = [n for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load) and n.id in locals_]
    names = [n for n in names if id(n) not in written]
    free = _free(function)
    for node in nodes:
        small = isinstance(node, ast.Constant) or node in names
        parent = _around(nodes, node, text) if small else node
        for what, new in [*_changes(node, text), *_of_name(node, names), *_by_dt(node, names, text, parameters)]:
            both = text.both(parent, node, new)
            if _one_number(both[1]):
                continue
            yield told(what, parent, *both), text.with_(node, new, id(node) not in free), *both
    yield from _of_parameters(function, parameters, text)
    for node in statements:
        yield from _of_statement(node, text, means)
    yield from _of_uses(function, nodes, names, places, text, means)
    yield from _of_repeated(statements, nodes, told, text)
    yield from _of_angles(function, statements, text, means)
    for node in names:
        around = _around(nodes, node, text)
        for other in locals_:
            if other != node.id:
                both = text.both(around, node, other)
                yield told(f"`{other}` for `{node.id}`", around, *both), text.with_(node, other, False), *both


def _one_number(text) -> bool:
    """Return True for a search in a single number: nobody makes that."""
    return bool(re.search(r"linspace\((\S+), \1,", text))


class _Places:
    """Where an expression stands, in words: the result or the name that its line gives a value."""

    def __init__(self, function, statements, text):
        self.statements, self.text = statements, text
        self.body = " ".join(text.text[text.head :].split())

    def of(self, node, old):
        """Return ", in `X_x`", or "" where what is quoted tells its place already."""
        (a, b), line = self.text.span(node), self.line(node)
        if isinstance(line, ast.Return):
            return ", in what is returned" if self.body.count(old) > 1 else ""
        if not isinstance(line, ast.Assign | ast.AugAssign):
            return ""
        target = line.targets[0] if isinstance(line, ast.Assign) else line.target
        if isinstance(target, ast.Tuple) and isinstance(line.value, ast.Tuple):  # one name for each value
            within = [t for t, v in zip(target.elts, line.value.elts, strict=False) if self._holds(v, a, b)]
            if len(within) != 1:
                return ""
            target = within[0]
        return f", in `{self.text.of(target)}`"

    def line(self, node):
        """Return the smallest statement that holds an expression."""
        a, b = self.text.span(node)
        lines = [s for s in self.statements if self.text.span(s)[0] <= a and b <= self.text.span(s)[1]]
        return min(lines, key=lambda s: self.text.span(s)[1] - self.text.span(s)[0], default=None)

    def _holds(self, value, a, b):
        start, end = self.text.span(value)
        return start <= a and b <= end


def _free(function):
    """What stands where no brackets are needed, whatever is written there: no operand, and no tuple."""
    inside = set()
    for node in ast.walk(function):
        if isinstance(node, ast.BinOp | ast.UnaryOp | ast.Compare | ast.BoolOp | ast.Attribute | ast.Starred):
            inside.update(map(id, ast.iter_child_nodes(node)))
        elif isinstance(node, ast.Subscript):
            inside.add(id(node.value))
        elif isinstance(node, ast.IfExp | ast.Call | ast.comprehension):
            inside.update(map(id, ast.iter_child_nodes(node)))
    return {id(n) for n in ast.walk(function) if isinstance(n, ast.expr) and not isinstance(n, ast.Tuple)} - inside


def _of_uses(function, nodes, names, places, text, means):
    """Slips at one place where a name is used: who has no such name writes its formula out, there and elsewhere."""
    formulas = _formulas(function)
    for node in names:
        formula = formulas.get(node.id)
        if formula is None or text.span(node)[0] < text.span(formula)[1]:
            continue
        around = _around(nodes, node, text, signs=True)
        here = places.of(around, text.of(around))
        where = f" in `{text.of(around)[:60]}`{here}" if around is not node else here.removeprefix(",")
        same = [n for n in names if n.id == node.id and places.line(n) is places.line(node)]
        for inner in (n for n in ast.walk(formula) if isinstance(n, ast.expr)):
            for what, new in _changes(inner, text):
                old, changed = text.both(formula, inner, new)
                if _one_number(changed):
                    continue
                told = f"{what}: your results are as if `{node.id}` were `{changed}`, not `{old}`,"
                known = _explained(means, old, changed)
                yield f"{told}{where}{known}.", text.with_(node, changed), old, changed
                if len(same) > 1 and node is same[0]:
                    line = text.of(places.line(node))[:60]
                    yield f"{told} in `{line}`{known}.", text.with_all(same, changed), old, changed


def _of_repeated(statements, nodes, told, text):
    """A slip of an expression that a line has several times: who gives it a name makes it at all of these places."""
    inside = lambda node, line: line.lineno <= node.lineno and node.end_lineno <= line.end_lineno
    for line in (s for s in statements if isinstance(s, ast.Assign | ast.AugAssign | ast.Return)):
        places: dict[str, list] = {}
        for node in nodes:
            if isinstance(node, ast.BinOp) and inside(node, line):
                places.setdefault(text.of(node), []).append(node)
        for old, same in places.items():
            for what, new in _changes(same[0], text) if len(same) > 1 else ():
                yield told(what, same[0], old, new), text.with_all(same, new), old, new


def _of_angles(function, statements, text, means):
    """A term too many in the argument of sines and cosines, at all places of one line: a turn that comes too early."""
    turns = ("sin", "cos")
    calls = [n for n in ast.walk(function) if isinstance(n, ast.Call) and getattr(n.func, "attr", "") in turns]
    angles = list(dict.fromkeys(text.of(n.args[0]) for n in calls if n.args))
    terms = _terms(function, text)
    for node in statements:
        start, end = text.span(node)
        line = text.text[start:end]
        for angle in (a for a in angles if a in line):
            here = rf"(?<![\w.]){re.escape(angle)}(?!\w)"
            for term, more in (
                (t, m) for t in terms[:MOST_TERMS] for m in ("+ {}", "- {}", "+ {} / 2") if t not in angle
            ):
                turned = f"{angle} {more.format(term)}"
                told = f"A term too many: your results are as if `{turned}` stood where `{angle}` belongs"
                told = f"{told}{_explained(means, angle, turned)}."
                yield told, text.with_(node, re.sub(here, f"({turned})", line), False), angle, turned


def _terms(function, text):
    """What may be added to an angle: entries of the parameters, their products, and names that stand for one entry."""
    parameters = {a.arg for a in function.args.args}
    number = lambda n: isinstance(n, ast.Constant) and isinstance(n.value, int)
    of_one = lambda n: isinstance(n.value, ast.Name) and n.value.id in parameters and number(n.slice)
    entries: list[Any] = [n for n in ast.walk(function) if isinstance(n, ast.Subscript) and of_one(n)]
    tuples = [n for n in ast.walk(function) if isinstance(n, ast.Tuple) and isinstance(n.ctx, ast.Store)]
    names = [text.of(e) for n in tuples for e in n.elts if isinstance(e, ast.Name)]
    products = [text.of(n) for n in ast.walk(function) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Mult)]
    last = [f"{p}[{1 + max(n.slice.value for n in entries if n.value.id == p)}]" for p in
            dict.fromkeys(n.value.id for n in entries)]  # fmt: skip
    short = [p for p in products if len(p) <= 12 and not re.search(r"\b[cs]\b", p)]
    return list(dict.fromkeys([*map(text.of, entries), *last, *names, *short]))


def _formulas(function):
    """What each name stands for that gets a value once, where that is short."""
    found: dict[str, ast.expr | None] = dict.fromkeys(_changed_in_place(function))
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
            elements = target.elts if isinstance(target, ast.Tuple) else []
            values = value.elts if isinstance(value, ast.Tuple) else []
            both = elements and values
            for name, formula in zip(elements, values, strict=False) if both else [(target, value)]:
                if isinstance(name, ast.Name):
                    short = isinstance(formula, ast.BinOp | ast.Call) and len(ast.unparse(formula)) <= LONGEST_FORMULA
                    found[name.id] = formula if short and name.id not in found else None
    return found


def _changed_in_place(function):
    """Names of which an entry is set, or to which something is added: they do not keep their formula."""
    stores = [n.value for n in ast.walk(function) if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store)]
    stores += [n.target for n in ast.walk(function) if isinstance(n, ast.AugAssign)]
    return {n.id for n in stores if isinstance(n, ast.Name)}


def _nodes(function):
    """The expressions of the body, without the docstring and the names that are called."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    found = [n for s in body for n in ast.walk(s) if isinstance(n, ast.expr)]
    below = {id(n.operand) for n in found if isinstance(n, ast.UnaryOp) and isinstance(n.operand, ast.Constant)}
    return [n for n in found if id(n) not in below]  # -1 is one number


def _meanings(function, parameters):
    """Short definitions of the names that the solution gives: the student may have others.

    A name that is filled entry by entry means more than the zeros with which it begins.
    """
    found, others = {}, {*parameters, *_changed_in_place(function)}
    written = lambda node: ast.unparse(node)[1:-1] if isinstance(node, ast.Tuple) else ast.unparse(node)
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = map(written, (node.targets[0], node.value))
            names = re.findall(A_NAME, target)
            short = re.fullmatch(r"[\w, ]+", target) and len(value) <= LONGEST_MEANING and others.isdisjoint(names)
            for name in (n for n in names if n != "_"):
                found[name] = f"{target} = {value}" if short and name not in found else None
    return {name: value for name, value in found.items() if value}


def _explained(means, *texts):
    """Return what the names in these texts stand for, and the names in that: " (with K = P @ H.T @ inv(Z), Z = R)"."""
    found = list(texts)
    for text in found:  # which grows
        words = set(re.findall(A_NAME, text))
        found += dict.fromkeys(f for name, f in means.items() if name in words and f not in found)
    known = found[len(texts) :][:MOST_MEANINGS]
    return f" (with {'; '.join(known)})" if known else ""


def _assigned(function):
    """Names that the body gives a value."""
    found = [n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return list(dict.fromkeys(found))


def _of_name(node, names):
    if node in names:
        yield "A square too many", f"{node.id}**2"
        yield "A root too many", f"np.sqrt({node.id})"


def _by_dt(node, names, text, parameters):
    """A factor dt too many, of a name or of some of its entries."""
    if isinstance(node, ast.Subscript):
        is_factor = isinstance(node.ctx, ast.Load) and isinstance(node.value, ast.Name)
    else:
        is_factor = node in names and node.id != "dt"
    if "dt" in parameters and is_factor:
        yield "A factor dt too many", f"{text.of(node)} * dt"


def _around(nodes, node, text, signs=False):
    """The smallest operation or call that a name or number stands in, for a quotation; with its minus, if so asked."""
    kinds = ast.BinOp | ast.Call | ast.Compare | ast.Subscript | ast.List
    kinds = kinds | ast.UnaryOp if signs else kinds
    (start, end) = text.span(node)
    holders = [n for n in nodes if isinstance(n, kinds)]
    holders = [n for n in holders if text.span(n)[0] <= start and end <= text.span(n)[1] and n is not node]
    return min(holders, key=lambda n: text.span(n)[1] - text.span(n)[0], default=node)


def _changes(node, text):
    """Yield what is wrong and the new text for each slip of an expression."""
    of = text.of
    if isinstance(node, ast.BinOp):
        yield from _of_operation(node, of(node.left), of(node.right))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        yield "A minus is missing", of(node.operand)
        if isinstance(node.operand, ast.Constant) and isinstance(node.operand.value, int):
            yield "A number is wrong", str(1 - node.operand.value)
            yield "A number is wrong", str(-1 - node.operand.value)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.Invert):
        yield "The condition is the wrong way round", of(node.operand)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for kind in COMPARED.get(type(node.ops[0]), ()):
            new = copy.deepcopy(node)
            new.ops = [kind()]
            yield "The comparison is wrong", ast.unparse(new)
    elif isinstance(node, ast.BoolOp):
        for value in node.values:
            yield "A condition is missing", f" {_word(node.op)} ".join(of(v) for v in node.values if v is not value)
        other = "or" if isinstance(node.op, ast.And) else "and"
        yield f"`{other}` for `{_word(node.op)}`", f" {other} ".join(map(of, node.values))
    elif isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        for new in (node.value + 1, node.value - 1):
            yield "A number is wrong", str(new)
    elif isinstance(node, ast.Attribute) and node.attr == "T":
        yield "A transpose is missing", of(node.value)
    elif isinstance(node, ast.Call):
        yield from _of_call(node, of)
    elif isinstance(node, ast.IfExp):
        yield "One of two cases is missing", of(node.body)
        yield "One of two cases is missing", of(node.orelse)
    elif isinstance(node, ast.List | ast.Tuple) and isinstance(node.ctx, ast.Load) and 1 < len(node.elts) <= 6:
        yield from _of_entries(node, of)


def _word(op):
    return "and" if isinstance(op, ast.And) else "or"


OPERATIONS = {
    ast.Add: (
        ("A sign is wrong", "{left} - {b}"),
        ("A sign is wrong", "{right} - {a}"),
        ("A term is missing", "{left}"),
        ("A term is missing", "{right}"),
        ("A term counts twice", "2 * {a} + {right}"),
        ("A term counts twice", "{left} + 2 * {b}"),
    ),
    ast.Sub: (
        ("A sign is wrong", "{left} + {right}"),
        ("The difference is the wrong way round", "{right} - {a}"),
        ("A term is missing", "{left}"),
        ("A term is missing", "-{b}"),
        ("A term is missing", "{right}"),
        ("A term counts twice", "{left} - 2 * {b}"),
    ),
    ast.Mult: (
        ("A factor is missing", "{left}"),
        ("A factor is missing", "{right}"),
        ("A sign is wrong", "-({left} * {right})"),
        ("Divided, not multiplied", "{left} / {b}"),
        ("Added, not multiplied", "{left} + {right}"),
        ("Twice as much", "2 * ({left} * {right})"),
        ("Half as much", "({left} * {right}) / 2"),
    ),
    ast.MatMult: (
        ("A factor is missing", "{left}"),
        ("A factor is missing", "{right}"),
        ("A sign is wrong", "-({left} @ {right})"),
        ("The factors are in the wrong order", "{b} @ {a}"),
        ("The product of matrices is `@`, and `*` goes entry by entry", "{a} * {b}"),
        ("A transpose too many", "{a}.T @ {b}"),
        ("A transpose too many", "{a} @ {b}.T"),
        ("Only the diagonal counts in yours", "np.diag(np.diag({left})) @ {b}"),
        ("Only the diagonal counts in yours", "{a} @ np.diag(np.diag({right}))"),
        ("An inverse", "np.linalg.inv({left}) @ {b}"),
        ("An inverse", "{a} @ np.linalg.inv({right})"),
        ("Twice as much", "2 * ({left} @ {right})"),
        ("Half as much", "({left} @ {right}) / 2"),
    ),
    ast.Div: (
        ("A division is missing", "{left}"),
        ("Multiplied, not divided", "{left} * {b}"),
        ("The quotient is upside down", "{right} / {a}"),
        ("A sign is wrong", "-{a} / {b}"),
        ("Divided by the square", "{left} / {b}**2"),
        ("Divided by the root", "{left} / np.sqrt({right})"),
        ("A factor is missing", "1 / {b}"),
    ),
    ast.Pow: (
        ("The power is missing", "{left}"),
        ("The power is another one", "{a} ** ({right} + 1)"),
        ("The power is another one", "{a} ** ({right} - 1)"),
        ("The power is another one", "{a} ** (2 * {b})"),
        ("A factor, not a power", "{a} * {b}"),
        ("A root too many", "np.sqrt({left}) ** {b}"),
    ),
    ast.BitAnd: (
        ("A condition is missing", "{left}"),
        ("A condition is missing", "{right}"),
        ("`|` for `&`", "{left} | {right}"),
    ),
    ast.BitOr: (
        ("A condition is missing", "{left}"),
        ("A condition is missing", "{right}"),
        ("`&` for `|`", "{left} & {right}"),
    ),
}
"""What may be written instead of an operation: `a` and `b` are `left` and `right`, in brackets where they need them."""


def _of_operation(node, left, right):
    """What may be written instead of an operation; `left` and `right` are its operands as they are (or with a slip)."""
    a, b = (f"({s})" if isinstance(n, ast.BinOp | ast.UnaryOp) else s
            for n, s in ((node.left, left), (node.right, right)))  # fmt: skip
    for words, text in OPERATIONS.get(type(node.op), ()):
        yield words, text.format(left=left, right=right, a=a, b=b)
    if isinstance(node.op, ast.Pow) and isinstance(node.left, ast.BinOp):
        yield "`**` goes before `*`, `/` and `-`: the brackets are missing", f"{left} ** {right}"


def _of_call(node, of):
    function, args = of(node.func), list(map(of, node.args))
    keywords = [f"{k.arg}={of(k.value)}" for k in node.keywords]
    stem, _, name = function.rpartition(".")
    if name in EXCHANGED:
        new = f"{stem}.{EXCHANGED[name]}" if stem else EXCHANGED[name]
        yield f"`{EXCHANGED[name]}` for `{name}`", f"{new}({', '.join(args + keywords)})"
    if name == "mean" and stem == "np" and len(args) == 1 and all(k.arg == "axis" for k in node.keywords):
        inside = ", ".join(args + keywords)
        yield "Divided by one less than there are", f"np.divide(np.sum({inside}), np.size({inside}) - 1)"
    if name in AROUND and len(args) == 1:
        yield f"The {AROUND[name]} is missing", args[0]
    if name in ("sin", "cos", "tan") and args:
        yield "Degrees and radians", f"{function}(np.radians({args[0]}))"
    if name == "arctan2" and len(args) == 2:
        quotient = f"{stem or 'np'}.arctan(({args[0]}) / ({args[1]}))"
        yield "`arctan` of the quotient cannot tell ahead from behind", quotient
    if name in ("inv", "solve") and args:
        yield (
            "Only the diagonal counts in yours",
            f"{function}({', '.join([f'np.diag(np.diag({args[0]}))', *args[1:]])})",
        )
    if name == "solve" and len(args) == 2:
        yield "The inverse is missing", f"({args[0]}) @ ({args[1]})"
    for i in range(len(args) - 1 if name not in COUNTING else 0):
        swapped = [*args[:i], args[i + 1], args[i], *args[i + 2 :]]
        yield "Two arguments are exchanged", f"{function}({', '.join(swapped + keywords)})"
    for i, keyword in enumerate(keywords):
        rest = keywords[:i] + keywords[i + 1 :]
        yield f"`{keyword}` is missing", f"{function}({', '.join(args + rest)})"


def _of_entries(node, of):
    if any(isinstance(entry, ast.Slice) for entry in node.elts):
        return
    entries = list(map(of, node.elts))
    opened, closed = ("[", "]") if isinstance(node, ast.List) else ("", "")
    row = lambda some: f"{opened}{', '.join(some)}{closed}"
    rows = [list(map(of, e.elts)) for e in node.elts if isinstance(e, ast.List | ast.Tuple)]
    if len(rows) == len(entries) and len({len(r) for r in rows}) == 1:
        matrix = lambda some: "[" + ", ".join("[" + ", ".join(r) + "]" for r in some) + "]"
        if len(rows) == len(rows[0]):
            yield "Rows and columns are exchanged", matrix(zip(*rows, strict=True))
        for j in range(len(rows[0]) - 1):
            swapped = [[*r[:j], r[j + 1], r[j], *r[j + 2 :]] for r in rows]
            yield "Two columns are exchanged", matrix(swapped)
        for j in range(len(rows[0])):
            yield "A column has the wrong sign", matrix([[*r[:j], f"-({r[j]})", *r[j + 1 :]] for r in rows])
            yield "A column is missing", matrix([[*r[:j], "0", *r[j + 1 :]] for r in rows])
        for i in range(len(rows)):
            yield "A row has the wrong sign", matrix([*rows[:i], [f"-({v})" for v in rows[i]], *rows[i + 1 :]])
            yield "A row is missing", matrix([*rows[:i], ["0"] * len(rows[i]), *rows[i + 1 :]])
        what = "Two rows are exchanged"
        yield from _of_two_entries(rows, matrix)
    else:
        what = "The order"
        for i, entry in enumerate(entries):
            for wrong, new in (
                ("An entry has the wrong sign", f"-({entry})"),
                *(
                    (("An entry is missing", "0"), ("An entry is 1", "1")) if opened else ()
                ),  # else it is a whole result
                ("An entry is twice as much", f"2 * ({entry})"),
                ("An entry is half as much", f"({entry}) / 2"),
            ):
                yield wrong, row([*entries[:i], new, *entries[i + 1 :]])
        yield from _of_terms(node, of, row)
    for i in range(len(entries) - 1):
        for j in range(i + 1, len(entries)):
            swapped = list(entries)
            swapped[i], swapped[j] = swapped[j], swapped[i]
            yield what, row(swapped)
    yield from _of_all_entries(entries, row)
    if len(rows) == len(entries) and len({len(r) for r in rows}) == 1:
        for j in range(len(rows[0])):
            for words, column in _of_all_entries([r[j] for r in rows], list):
                yield words, matrix([[*r[:j], new, *r[j + 1 :]] for r, new in zip(rows, column, strict=True)])


def _of_terms(node, of, row):
    """Two entries that are sums, from which the same term is missing: the first one, or the second."""
    sums = [i for i, e in enumerate(node.elts) if isinstance(e, ast.BinOp) and isinstance(e.op, ast.Add | ast.Sub)]
    for some in itertools.combinations(sums, 2):
        for side in "left", "right":
            left = [of(getattr(e, side)) if i in some else of(e) for i, e in enumerate(node.elts)]
            yield "A term is missing at two places", row(left)


def _of_two_entries(rows, matrix):
    """Two entries of a matrix, neither of them a number, that stand in two rows and two columns."""
    places = [(i, j) for i, r in enumerate(rows) for j, v in enumerate(r) if re.search("[a-z]", v)]
    for (i, j), (k, m) in itertools.combinations(places, 2):
        if i != k and j != m and rows[i][j] != rows[k][m]:
            some = [list(r) for r in rows]
            some[i][j], some[k][m] = some[k][m], some[i][j]
            yield "Two entries are exchanged", matrix(some)


FACTOR = r"(?<![\w.\]) ]) ?\b{0} \* | [*/] {0}\b(?:\*\*2)?(?! ?[\w(\[.])"


def _of_all_entries(entries, row):
    """A factor that is missing in all entries that have it, or a square that is: one idea, several places."""
    names = {n for entry in entries for n in re.findall(r"\b[a-z]\w*\b", entry)} - {"np"}
    for name in sorted(names):
        without = [re.sub(FACTOR.format(name), "", entry) for entry in entries]
        if sum(a != b for a, b in zip(entries, without, strict=True)) > 1:
            divides = any(re.search(rf"/ {name}\b", entry) for entry in entries)
            yield f"The {'division by' if divides else 'factor'} `{name}` is missing", row(without)
    for pattern, new in (r"\*\*2\b", ""), (r"/ (\w+)\b(?!\*\*)", r"/ \1**2"), (r"/ (\w+)\b(?!\*\*)", r"/ np.sqrt(\1)"):
        other = [re.sub(pattern, new, entry) for entry in entries]
        if sum(a != b for a, b in zip(entries, other, strict=True)) > 1:
            yield "Divided by another power" if "/" in pattern else "The square is missing", row(other)


def _of_parameters(function, parameters, text):
    """Slips of an input, wherever it stands."""
    first = function.body[1 if ast.get_docstring(function) is not None else 0]
    indent = " " * first.col_offset
    before = lambda line: f"{indent}{line}\n{text.text[text.head :]}"
    for p in parameters:
        for sentence, new in (
            (f"`{p}` has no effect in yours", f"0 * np.asarray({p})"),
            (f"`{p}` comes in with the wrong sign", f"-np.asarray({p})"),
            (f"`{p}` is squared in yours", f"np.asarray({p}) ** 2"),
            (f"Yours takes the root of `{p}`", f"np.sqrt({p})"),
            (f"`{p}` counts twice in yours", f"2 * np.asarray({p})"),
            (f"`{p}` is transposed in yours", f"{p}.T"),
            (f"`{p}` is inverted in yours", f"np.linalg.inv({p})"),
            (f"`{p}` is multiplied by itself in yours", f"{p} @ {p}"),
            (f"Only the diagonal of `{p}` counts in yours: the rest of it matters, too", f"np.diag(np.diag({p}))"),
            (f"`{p}` is in radians already: no conversion", f"np.radians({p})"),
            (f"`{p}` is turned into degrees in yours: keep to radians", f"np.degrees({p})"),
        ):
            yield f"{sentence}.", before(f"{p} = {new}")
        for sentence, new in (
            (f"`{p}` is multiplied by dt in yours", f"{p} * dt"),
            (f"`{p}` is multiplied by dt^2 in yours", f"{p} * dt**2"),
            (f"`{p}` is divided by dt in yours", f"{p} / dt"),
        ):
            if "dt" in parameters and p != "dt":
                yield f"{sentence}.", before(f"{p} = {new}")
        shape = re.search(rf"\b{p}\b[^.]*?shape \(([^)]*)\)", text.text[: text.head])
        matrix = shape and re.fullmatch("[^,]+,[^,]+", shape[1])
        called = (lambda i, p=p: f"column {i} of `{p}`") if matrix else (lambda i, p=p: f"`{p}[{i}]`")
        for i in range(5):
            entry = f"{p} = np.array({p}, float); {p}[..., {i}]"
            yield f"Without effect in yours: {called(i)}.", before(f"{entry} = 0")
            yield f"With the wrong sign in yours: {called(i)}.", before(f"{entry} *= -1")
            yield f"In radians already, so no conversion: {called(i)}.", before(f"{entry} *= np.pi / 180")
            for j in range(i + 1, 4):
                both = f"{p} = np.array({p}, float); {p}[..., [{i}, {j}]] = {p}[..., [{j}, {i}]]"
                yield f"Exchanged in yours: {called(i)} and {called(j)}.", before(both)
    for i, p in enumerate(parameters):
        for q in parameters[i + 1 :]:
            yield f"`{p}` and `{q}` are exchanged in yours.", before(f"{p}, {q} = {q}, {p}")


def _of_a_part(node, text):
    """A step that reaches some of its entries only: the others stay as they were."""
    whole, step = re.fullmatch(r"(\w+)\[:(\d)\]", text.of(node.target)), text.of(node)
    name, n = (whole[1], int(whole[2])) if whole else ("", 0)
    for left in (f"{i}:{j}" for j in range(2, n + 1) for i in range(j - 1) if j - i < n):
        i = left[0]
        kept = f"{name}_0 = np.array({name}); {step}; {name}[{left}] = {name}_0[{left}]"
        place = f"{name}[{left if i != '0' else left[1:]}]"
        yield (
            f"`{place}` is not changed in yours: your results are as if it stayed as it was.",
            text.with_(node, kept, False),
        )


def _of_statement(node, text, means):
    """Slips of a line: left out, added the wrong way, results in another order."""
    if isinstance(node, ast.Assign | ast.AugAssign | ast.Expr):
        whole = text.of(node)
        yield f"A step is missing: `{whole[:LONGEST]}`.", text.with_(node, "pass", False), whole, "pass"
    if isinstance(node, ast.For):
        over = text.of(node.iter)
        for as_if, some in (
            ("only the last of `{}` counted", "[-1:]"),
            ("only the first of `{}` counted", "[:1]"),
            ("the first of `{}` did not count", "[1:]"),
            ("the last of `{}` did not count", "[:-1]"),
        ):
            yield f"Your results are as if {as_if.format(over)}.", text.with_(node.iter, f"[*({over})]{some}")
    if isinstance(node, ast.AugAssign):
        yield from _of_a_part(node, text)
        target, value = text.of(node.target), text.of(node.value)
        for sign in ("", "-", "+"):
            new = f"{target} {sign}= {value}"
            told = f"Your results are as if `{new}` stood where `{text.of(node)}` belongs."
            yield told, text.with_(node, new, False), text.of(node), new
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
        names = list(map(text.of, node.targets[0].elts))
        for i in range(len(names) - 1):
            for j in range(i + 1, len(names)):
                swapped = list(names)
                swapped[i], swapped[j] = swapped[j], swapped[i]
                new = text.with_(node.targets[0], ", ".join(swapped), False)
                yield f"`{names[i]}` and `{names[j]}` are exchanged in yours.", new
    if isinstance(node, ast.Assign) and not isinstance(node.targets[0], ast.Tuple):
        value = text.of(node.value)
        for what, new in (("minus", f"-({value})"), ("twice", f"2 * ({value})"), ("the square of", f"({value}) ** 2"),
                          ("the root of", f"np.sqrt({value})"), ("the transpose of", f"({value}).T"),
                          ("half of", f"({value}) / 2"), ("the inverse of", f"np.linalg.inv({value})")):  # fmt: skip
            place, cut = text.of(node.targets[0]), value if len(value) <= LONGEST else value[:40] + " ..."
            told = f"Your results are as if `{place}` were {what} `{cut}`{_explained(means, cut)}."
            yield told, text.with_(node.value, new), value, new
