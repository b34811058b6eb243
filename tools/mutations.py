"""Single changes of a Python file, as somebody might make them by mistake: a sign, a comparison, a line left out.

A change that no test finds is a property of the code that nobody holds. `tools/mutants.py` makes them one by one.
"""

import ast
import copy
from dataclasses import dataclass

SWAPS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In, ast.And: ast.Or,
    ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
OPPOSITE = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt}
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any", "sin": "cos", "cos": "sin", "hstack": "vstack"}
NAMES |= {"zeros": "ones", "ones": "zeros", "argmin": "argmax", "argmax": "argmin"}


@dataclass(frozen=True)
class Mutation:
    """One change.

    Parameters
    ----------
    number : int
        In the order of the file.
    line : int
    function : str
        Name of the innermost function around it, with those of what it is in, as `__qualname__`; "" outside of one.
    what : str
        Before and after, in words.
    """

    number: int
    line: int
    function: str
    what: str


def mutations(text):
    """Return all changes of a source text.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of Mutation
    """
    found = []
    _Walk(ast.parse(text), lambda m, *_: found.append(m) and False).go()
    return found


def mutated(text, number):
    """Return the tree of the source with one of its changes made.

    Parameters
    ----------
    text : str
    number : int

    Returns
    -------
    ast.Module
    """
    tree = ast.parse(text)
    _Walk(tree, lambda m, *_: m.number == number).go()
    return ast.fix_missing_locations(tree)


class _Walk:
    """A walk over a tree that asks at each possible change whether it is to be made, and ends with the first one."""

    def __init__(self, tree, wanted):
        self.tree, self.wanted, self.count, self.inside = tree, wanted, 0, []

    def go(self):
        """Walk to the end, or to the first change that is made."""
        try:
            self.visit(self.tree, None, None)
        except StopIteration:
            pass

    def offer(self, node, new, put):
        """Ask for one change: the node is to become the new one."""
        before, after = (ast.unparse(n) if isinstance(n, ast.AST) else repr(n) for n in (node, new))
        what = f"{' '.join(before.split())[:70]} -> {' '.join(after.split())[:70]}"
        number, self.count = self.count, self.count + 1
        line = getattr(node, "lineno", 0) or node.target.lineno  # a comprehension has none
        if self.wanted(Mutation(number, line, self._function(), what)):
            put(ast.copy_location(new, node) if hasattr(node, "lineno") else new)
            raise StopIteration

    def visit(self, node, parent, put):
        """Offer what can be changed at a node, then in it."""
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.Assert):
            return  # words, and what holds words
        is_function = isinstance(node, ast.FunctionDef | ast.Lambda)
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            self.inside.append(node)
        if put is not None:
            for new in _instead(node, parent):
                self.offer(node, new, put)
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list") or (is_function and name == "args"):
                continue
            if isinstance(value, list):
                self._list(node, value)
            elif isinstance(value, ast.AST):
                self.visit(value, node, lambda new, name=name: setattr(node, name, new))
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            self.inside.pop()

    def _function(self):
        """The name of the function that the walk is in; a class alone is none."""
        names = []
        for node in self.inside:
            names += [node.name, "<locals>"] if isinstance(node, ast.FunctionDef) else [node.name]
        while self.inside and names and names[-1] != "<locals>":
            names.pop()
        return ".".join(names[:-1])

    def _list(self, node, values):
        for i, value in enumerate(values):
            if isinstance(value, ast.AST) and not _is_words(value):
                self.visit(value, node, lambda new, i=i: values.__setitem__(i, new))


def _is_words(node):
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _instead(node, parent):
    """What may stand in the place of a node."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in SWAPS:
        yield _with(node, op=SWAPS[type(node.op)]())
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        if ast.dump(node.left) != ast.dump(node.right):
            yield _with(node, left=node.right, right=node.left)
    elif isinstance(node, ast.BoolOp):
        yield _with(node, op=SWAPS[type(node.op)]())
    elif isinstance(node, ast.Compare):
        for table in (SWAPS, OPPOSITE):
            if type(node.ops[0]) in table:
                yield _with(node, ops=[table[type(node.ops[0])](), *node.ops[1:]])
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not | ast.Invert):
        yield copy.deepcopy(node.operand)
    elif isinstance(node, ast.Constant):
        yield from _other_constants(node.value)
    elif isinstance(node, ast.Attribute) and node.attr in ("T", "Rt"):
        yield copy.deepcopy(node.value) if node.attr == "T" else _with(node, attr="R")
    elif isinstance(node, ast.Attribute) and node.attr in NAMES:
        yield _with(node, attr=NAMES[node.attr])
    elif isinstance(node, ast.Name) and node.id in NAMES and isinstance(parent, ast.Call) and parent.func is node:
        yield _with(node, id=NAMES[node.id])
    elif isinstance(node, ast.If | ast.IfExp) and not isinstance(node.test, ast.Compare):
        yield _with(node, test=ast.UnaryOp(ast.Not(), node.test))
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield ast.Pass()
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Subscript | ast.Attribute):
        yield ast.Pass()
    elif isinstance(node, ast.Continue | ast.Break):
        yield ast.Pass()
    elif isinstance(node, ast.comprehension) and node.ifs:
        yield _with(node, ifs=node.ifs[1:])
    if isinstance(node, ast.AugAssign | ast.If) and not isinstance(parent, ast.Module):
        yield ast.Pass()


def _with(node, **changes):
    new = copy.deepcopy(node)
    for name, value in changes.items():
        setattr(new, name, value)
    return new


def _other_constants(value):
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, int):
        yield ast.Constant(value + 1)
        if value > 1:
            yield ast.Constant(value - 1)
    elif isinstance(value, float):
        yield ast.Constant(2 * value if value else 1.0)
