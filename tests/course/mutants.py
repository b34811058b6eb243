"""Edits of a function: each operator, number, name, comparison, call, factor and noise of its expressions changed.

What a student mistypes, one place at a time. The mutants come in a fixed order, with a text that says what was changed.
"""

import ast
import copy
import inspect
import textwrap

OPERATORS = {
    ast.Add: [ast.Sub],
    ast.Sub: [ast.Add],
    ast.Mult: [ast.Div],
    ast.Div: [ast.Mult],
    ast.MatMult: [ast.Mult],
    ast.Pow: [ast.Mult],
    ast.Mod: [ast.FloorDiv],
}
COMPARISONS = {
    ast.Lt: [ast.LtE, ast.Gt],
    ast.LtE: [ast.Lt, ast.GtE],
    ast.Gt: [ast.GtE, ast.Lt],
    ast.GtE: [ast.Gt, ast.LtE],
    ast.Eq: [ast.NotEq],
    ast.In: [ast.NotIn],
    ast.NotIn: [ast.In],
    ast.Is: [ast.IsNot],
    ast.IsNot: [ast.Is],
}
LIMITS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
FUNCTIONS = {
    "cos": "sin",
    "sin": "cos",
    "hypot": "maximum",
    "min": "max",
    "max": "min",
    "argmin": "argmax",
    "sqrt": "square",
}
TRANSPARENT = {
    "wrap",
    "sqrt",
    "square",
    "abs",
    "inv",
    "radians",
    "normalize",
    "round",
    "sorted",
}  # f(a) -> a makes sense
NOISES = {"R", "U", "N", "var"}  # parameters that are covariances of a noise: counted twice, squared, uncorrelated
OTHER_NOISES = "2 * {0}", "{0} @ {0}", "{0} ** 2", "np.diag(np.diag({0}))"


def mutants(function):
    """Yield (what was changed, changed function, strict) for each edit of the function's body.

    Strict are the edits that change no result in most cases: at a limit, and of a noise.
    """
    source = textwrap.dedent(inspect.getsource(function))
    tree = ast.parse(source)
    body = tree.body[0].body[1 if ast.get_docstring(tree.body[0]) is not None else 0 :]
    places = [node for statement in body for node in ast.walk(statement)]
    indices = {id(node): i for i, node in enumerate(ast.walk(tree))}
    statements = (node for node in ast.walk(tree) if isinstance(node, ast.stmt))
    of = {id(inner): statement for statement in statements for inner in ast.walk(statement)}  # the innermost is last
    noises = NOISES.intersection(inspect.signature(function).parameters)
    for node in places:
        noise = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in noises
        for change in _other_noises() if noise else _changes(node):
            fresh = copy.deepcopy(tree)
            twin = list(ast.walk(fresh))[indices[id(node)]]
            text = f"{ast.unparse(of[id(node)])}: {node.id}" if noise else ast.unparse(node)
            new = change(twin)
            if new is not twin:
                fresh = _Replace(twin, new).visit(fresh)
            ast.fix_missing_locations(fresh)
            space = dict(function.__globals__)
            try:
                exec(compile(fresh, "<mutant>", "exec"), space)
            except SyntaxError:
                continue
            limit = isinstance(node, ast.Compare) and type(twin.ops[0]) is LIMITS.get(type(node.ops[0]))
            yield f"{text} -> {ast.unparse(new)}", space[function.__name__], limit or noise


class _Replace(ast.NodeTransformer):
    def __init__(self, old, new):
        self.old, self.new = old, new

    def visit(self, node):
        return self.new if node is self.old else self.generic_visit(node)


def _changes(node):
    """Functions that change a copy of the node, in place or by giving another one."""
    if isinstance(node, ast.BinOp):
        for kind in OPERATORS.get(type(node.op), ()):
            yield lambda twin, kind=kind: _with(twin, op=kind())
        if isinstance(node.op, (ast.Mult, ast.MatMult, ast.Add, ast.Sub)):
            yield lambda twin: twin.left
            yield lambda twin: twin.right
        if isinstance(node.op, (ast.MatMult, ast.Sub)):
            yield lambda twin: _with(twin, left=twin.right, right=twin.left)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
        yield lambda twin: twin.operand
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for kind in COMPARISONS.get(type(node.ops[0]), ()):
            yield lambda twin, kind=kind: _with(twin, ops=[kind()])
    elif isinstance(node, ast.BoolOp):
        yield lambda twin: twin.values[0]
        yield lambda twin: twin.values[-1]
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield lambda twin: ast.Constant(twin.value + 1)
        if node.value:
            yield lambda twin: ast.UnaryOp(ast.USub(), ast.Constant(twin.value))
    elif isinstance(node, ast.Attribute) and node.attr == "T":
        yield lambda twin: twin.value
    elif isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in FUNCTIONS and isinstance(node.func, ast.Attribute):
            yield lambda twin: _with(twin, func=_with(twin.func, attr=FUNCTIONS[name]))
        if name in TRANSPARENT and len(node.args) == 1:
            yield lambda twin: twin.args[0]
        if len(node.args) == 2 and not any(isinstance(arg, ast.Starred) for arg in node.args):
            yield lambda twin: _with(twin, args=twin.args[::-1])
        for i in range(len(node.keywords)):
            yield lambda twin, i=i: _with(twin, keywords=twin.keywords[:i] + twin.keywords[i + 1 :])
    elif isinstance(node, ast.IfExp):
        yield lambda twin: twin.body
        yield lambda twin: twin.orelse


def _other_noises():
    """Functions that return another noise than that of a name."""
    for text in OTHER_NOISES:
        yield lambda twin, text=text: ast.parse(text.format(twin.id), mode="eval").body


def _with(node, **changes):
    for name, value in changes.items():
        setattr(node, name, value)
    return node
