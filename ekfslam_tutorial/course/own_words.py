"""What a student has written, where it can be read: a last look at a hint before it is told.

A mistake is recognised by what an answer returns, and formulas may agree by chance. A sentence that quotes what belongs
is doubtful if that very formula stands in the answer as often as in the solution, and the wrong one nowhere: then it
would send the student to a place that is right. Names that stand for a formula, the order of terms and of factors,
and brackets do not count.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections import Counter
from functools import lru_cache

INLINED = 8  # names in names at most
AS_IT_STANDS = "as it stands: "
TWICE, TWO = "*2.0", "the number 2, as a factor"
DIVIDED = "a division, in whatever words"
DIVIDES = {"divide", "true_divide", "reciprocal", "inv", "pinv", "solve", "mean", "average", "normalize"}


def formulas(function) -> Counter | None:
    """Return how often each formula stands in a function, in a normal form; None if its text cannot be read."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError, IndexError):
        return None
    return _counted(tree) if isinstance(tree, ast.FunctionDef) else None


def doubtful(mistake, own: Counter | None) -> bool:
    """Return True if what a slip says to belong is what the student has written already, and the wrong form is not."""
    quoted = getattr(mistake, "quoted", None)
    if not own or not quoted or quoted[0].isidentifier():
        return False
    known = _solution(mistake.solution)
    if known is None:
        return False
    means, right = known
    try:
        belongs, wrong = (_normal(ast.parse(text).body[0], means) for text in quoted)
    except (SyntaxError, IndexError):
        return False
    literal = [AS_IT_STANDS + _normal(ast.parse(text).body[0], {}) for text in quoted]
    if right[literal[0]] and own[literal[0]] >= right[literal[0]] and not own[literal[1]]:
        return True  # what is wrong is in what its names stand for
    if wrong.count(TWICE) > belongs.count(TWICE) and not own[TWO] and own[belongs] <= right[belongs]:
        return True  # nothing is there twice, so it is missing elsewhere
    if " / " in quoted[1] and " / " not in quoted[0] and not own[DIVIDED]:
        return True
    return right[belongs] > 0 and own[belongs] >= right[belongs] and not own[wrong]


def of_a_step(mistake) -> bool:
    """Return True if a slip says of a whole intermediate result that it is as if it were another one."""
    return _said(mistake).startswith("Your results are as if")


def of_another(mistake) -> bool:
    """Return True for a mistake that another exercise lists of its function: `As in ...`, and nothing is quoted."""
    return mistake.name.startswith("slip: As in `") and not getattr(mistake, "quoted", None)


def _said(mistake) -> str:
    """The name of a slip, without the function of another exercise in which it is."""
    return re.sub(r"^slip: (As in `\w+`\. )?", "", mistake.name)


def written(mistake, own: Counter) -> bool:
    """Return True if the student has written the wrong formula that a slip quotes, or no right one."""
    known = _solution(mistake.solution)
    if known is None or not mistake.quoted:
        return True
    belongs, wrong = (_normal(ast.parse(text).body[0], known[0]) for text in mistake.quoted)
    return own[wrong] > 0 or not own[belongs]


def unlikely(mistake, own: Counter | None) -> bool:
    """Return True if a slip is one name for another, and what would be wrong is not in what the student has written.

    Such a slip may come to the same as another one: with E n = 0, `n` for a term is that term left out.
    """
    quoted = getattr(mistake, "quoted", None)
    if not own or not quoted or not _said(mistake).startswith("`"):
        return False
    known = _solution(mistake.solution)
    if known is None:
        return False
    try:
        return not own[_normal(ast.parse(quoted[1]).body[0], known[0])]
    except (SyntaxError, IndexError):
        return False


def not_subtracted(mistake, own: Counter | None) -> bool:
    """Return True if a slip is a minus before a name, `-(E_a)`, and the student has no minus before that name."""
    quoted = getattr(mistake, "quoted", None)
    if not own or not quoted:
        return False
    belongs, wrong = (set(re.findall(r"-\((\w+)\)", text)) for text in quoted)
    names = wrong - belongs
    return bool(names) and not any(own[f"minus {name}"] for name in names)


def as_near(own: Counter | None, form, solution) -> bool:
    """Return True if the student has written as many formulas of one form of the solution as of the other one."""
    common = lambda known: sum(n for key, n in (own & known[1]).items() if not key.startswith(AS_IT_STANDS))
    shared = [common(known) for known in map(_solution, (form, solution)) if own and known]
    return len(shared) < 2 or shared[0] >= shared[1]


def ids_as_places(function, ids: str, functions: tuple[str, ...]) -> bool:
    """Return True if an entry of the list `ids` is used as a place: multiplied, in a slice, or handed to a function.

    An id is a name: `ids.index(id)` and the like are places. False if the text cannot be read.
    """
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return False
    named = {name for target, value in _loops(tree) for name in _entries_of(target, value, ids)}

    def is_id(node):
        """Return True for an entry of the list, and for one more or less than it."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub | ast.Mod):
            return is_id(node.left) and not isinstance(node.right, ast.Name)
        entry = isinstance(node, ast.Subscript) and _is(node.value, ids)
        return entry or isinstance(node, ast.Name) and node.id in named

    for node in (n for n in ast.walk(tree) if isinstance(n, ast.Assign)):
        named |= {name for name, value in _pairs(node.targets[0], node.value) if is_id(value)}
    for node in ast.walk(tree):
        factors = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and (node.left, node.right)
        ends = isinstance(node, ast.Slice) and (node.lower, node.upper)
        given = isinstance(node, ast.Call) and getattr(node.func, "id", "") in functions and node.args
        if any(map(is_id, factors or ends or given or ())):
            return True
    return False


def _is(node, name) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def _loops(tree):
    """Yield what is given a value, and from what: by loops, and one name by one value."""
    for node in ast.walk(tree):
        if isinstance(node, ast.For | ast.comprehension):
            yield node.target, node.iter
        elif isinstance(node, ast.Assign):
            for name, entry in _pairs(node.targets[0], node.value):
                if isinstance(entry, ast.Subscript):
                    yield ast.Name(name), ast.List([entry.value], ast.Load())


def _entries_of(target, values, ids):
    """Yield the names that a loop gives to the entries of the list `ids`."""
    if isinstance(values, ast.List) and len(values.elts) == 1:
        values = values.elts[0]
    if _is(values, ids) and isinstance(target, ast.Name):
        yield target.id
    if isinstance(values, ast.Call) and isinstance(target, ast.Tuple):
        called = getattr(values.func, "id", "")
        args = [None, *values.args] if called == "enumerate" else values.args if called == "zip" else []
        for part, inner in zip(target.elts, args, strict=False):
            if inner is not None:
                yield from _entries_of(part, inner, ids)


def foreign(mistake, own: Counter | None) -> bool:
    """Return True if a slip says that a name stands for another one, and neither the statement nor the student has it.

    Alone it explains all; beside another mistake it may do so by chance.
    """
    quoted = getattr(mistake, "quoted", None)
    if not quoted or not mistake.name.startswith("slip: `"):
        return False
    old, new = (set(re.findall(r"[^\W\d]\w*", text)) for text in quoted)
    known = set(inspect.signature(mistake.solution).parameters)
    return any(name not in known and not (own and own[f"name {name}"]) for name in new - old)


@lru_cache(maxsize=64)
def _solution(solution):
    """The names of a solution with their formulas, and how often each formula stands in it."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(solution))).body[0]
    return (_meanings(tree), _counted(tree)) if isinstance(tree, ast.FunctionDef) else None


class _Meanings(dict):
    """What names stand for, and the normal forms of the nodes of one tree so far."""

    def __init__(self, means):
        super().__init__(means)
        self.forms: dict = {}


def _counted(function) -> Counter:
    means, names, found = _Meanings(_meanings(function)), _Meanings({}), Counter()
    for node in ast.walk(function):
        if isinstance(node, ast.expr | ast.stmt):
            found[_normal(node, means)] += 1
            found[AS_IT_STANDS + _normal(node, names)] += 1
        if isinstance(node, ast.Name):
            found[f"name {node.id}"] += 1
        for part in ast.walk(_taken_away(node)):
            if isinstance(part, ast.Name):
                found[f"minus {part.id}"] += 1
        called = getattr(node, "attr", getattr(node, "id", ""))
        found[DIVIDED] += called in DIVIDES or isinstance(node, ast.Div | ast.Pow)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
            found[TWO] += any(isinstance(n, ast.Constant) and n.value == 2 for n in (node.left, node.right))
    return found


def _taken_away(node):
    """What has a minus before it in an operation; nothing in another one."""
    if isinstance(getattr(node, "op", None), ast.Sub | ast.USub):
        return getattr(node, "right", getattr(node, "operand", getattr(node, "value", ast.Pass())))
    return ast.Pass()


def _meanings(function) -> dict:
    """What each name stands for that gets a value once, and is changed nowhere."""
    given: dict[str, list] = {a.arg: [None] for a in function.args.args}
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                for name, value in _pairs(target, node.value):
                    given.setdefault(name, []).append(value)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            given.setdefault(node.id, [])
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store) and isinstance(node.value, ast.Name):
            given.setdefault(node.value.id, []).append(None)
        elif isinstance(node, ast.AugAssign | ast.For | ast.comprehension):
            for name in (n.id for n in ast.walk(node.target) if isinstance(n, ast.Name)):
                given.setdefault(name, []).append(None)
    return {name: values[0] for name, values in given.items() if len(values) == 1 and values[0] is not None}


def _pairs(target, value):
    """Yield the names of an assignment with the formula of each; a vector that is taken apart has entries."""
    if isinstance(target, ast.Name):
        yield target.id, value
    elif isinstance(target, ast.Tuple):
        values = value.elts if isinstance(value, ast.Tuple) and len(value.elts) == len(target.elts) else None
        for k, part in enumerate(target.elts):
            entry = ast.Subscript(value, ast.Constant(k), ast.Load()) if values is None else values[k]
            yield from _pairs(part, entry)


def _normal(node, means, depth=0) -> str:
    """A formula as text: names written out, terms and factors sorted."""
    if not isinstance(means, _Meanings):
        return _written_out(node, means, depth)
    key = id(node), depth
    if key not in means.forms:
        means.forms[key] = _written_out(node, means, depth)
    return means.forms[key]


def _written_out(node, means, depth) -> str:
    if isinstance(node, ast.Expr):
        return _normal(node.value, means, depth)
    if isinstance(node, ast.Name):
        known = means.get(node.id) if depth < INLINED else None
        return node.id if known is None else _normal(known, means, depth + 1)
    if isinstance(node, ast.BinOp | ast.UnaryOp) and isinstance(
        node.op, ast.Add | ast.Sub | ast.USub | ast.Mult | ast.Div
    ):
        terms = sorted(_terms(node, means, depth))
        return terms[0][1:] if len(terms) == 1 and terms[0][0] == "+" else f"({' '.join(terms)})"
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return f"({' @ '.join(_chain(node, means, depth))})"
    if isinstance(node, ast.Constant):
        return repr(float(node.value)) if type(node.value) is int else repr(node.value)
    parts = []
    for _, value in ast.iter_fields(node):
        values = value if isinstance(value, list) else [value]
        parts += [_normal(v, means, depth) if isinstance(v, ast.AST) else str(v) for v in values]
    kind = type(node).__name__
    return "" if kind in ("Load", "Store") else f"{kind}({', '.join(p for p in parts if p)})"


def _chain(node, means, depth):
    """The factors of a product of matrices, in their order, whatever the brackets."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return [*_chain(node.left, means, depth), *_chain(node.right, means, depth)]
    if isinstance(node, ast.Name) and depth < INLINED and node.id in means:
        return _chain(means[node.id], means, depth + 1)
    return [_normal(node, means, depth)]


def _terms(node, means, depth):
    """The terms of a sum, each with its sign."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        right = _terms(node.right, means, depth)
        return _terms(node.left, means, depth) + (right if isinstance(node.op, ast.Add) else list(map(_turned, right)))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return list(map(_turned, _terms(node.operand, means, depth)))
    if isinstance(node, ast.Name) and depth < INLINED and node.id in means:
        return _terms(means[node.id], means, depth + 1)
    sign, factors = _factors(node, means, depth)
    return [sign + (factors[0][1:] if len(factors) == 1 and factors[0][0] == "*" else " ".join(sorted(factors)))]


def _turned(term):
    return ("-" if term[0] == "+" else "+") + term[1:]


def _factors(node, means, depth):
    """The sign of a product, and its factors, each with `*` or `/`."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
        (s, left), (t, right) = (_factors(n, means, depth) for n in (node.left, node.right))
        if isinstance(node.op, ast.Div):
            right = [("*" if f[0] == "/" else "/") + f[1:] for f in right]
        return ("+" if s == t else "-"), left + right
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        sign, factors = _factors(node.operand, means, depth)
        return _turned(sign), factors
    if isinstance(node, ast.Name) and depth < INLINED and node.id in means:
        return _factors(means[node.id], means, depth + 1)
    return "+", [f"*{_normal(node, means, depth)}"]
