"""Which modules of a package a source file imports, in whatever way, and circles among them.

Seen are `import`, `from`, relative ones, those inside functions and under TYPE_CHECKING, and calls of `import_module`,
`__import__` and `runpy.run_module`, under whatever name, with a name that is a text, or put together from texts,
`__name__`, `__package__`, constants of the file and names of imported modules. Where a part of the name is known at
run time only, every module that it may stand for is taken; where nothing is known, it is an error to be told.
"""

import ast
from fnmatch import fnmatchcase
from functools import cache
from types import SimpleNamespace

CALLS = {
    "importlib.import_module",
    "importlib.__import__",
    "builtins.__import__",
    "__import__",
    "runpy.run_module",
}
UNKNOWN = "*"


class Unseen(Exception):
    """A call imports what nobody can see without running it."""


def module_name(path, package):
    """Return the dotted name of a source file; a package's own file ends in `__init__`."""
    return ".".join([package.name, *path.relative_to(package).with_suffix("").parts])


def imported(path, package):
    """Return the dotted names that a source file imports; UNKNOWN stands for a part known at run time only.

    Parameters
    ----------
    path : Path
        The source file.
    package : Path
        The folder of the package that it is in.

    Raises
    ------
    Unseen
        If the name of what a call imports cannot be seen at all.
    """
    return _imported(path.read_text(encoding="utf-8"), module_name(path, package))


@cache
def _imported(code, module):
    """Return what the code of a module imports; three tests ask for it."""
    tree, here = ast.parse(code), module.split(".")
    space = {"__package__": ".".join(here[:-1]), "__name__": ".".join(here).removesuffix(".__init__")}
    names, aliases = set(), {name: name for name in ("__import__",)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                names.add(alias.name)
                aliases[alias.asname or alias.name.split(".")[0]] = alias.name if alias.asname else root(alias.name)
        elif isinstance(node, ast.ImportFrom):
            base = here[: -node.level] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                # `from .. import x` and `from package import x` may name a module: keep x in the path.
                names.add(source if alias.name == "*" else f"{source}.{alias.name}")
                aliases[alias.asname or alias.name] = f"{source}.{alias.name}"
    for node in ast.walk(tree):  # load = importlib.import_module; NAME = "a text"
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            if (full := dotted(node.value, aliases)) in CALLS:
                aliases[name] = full
            elif isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
                space[name] = UNKNOWN if name in space else node.value.value
    space |= {name: SimpleNamespace(__name__=full) for name, full in aliases.items() if name not in space}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (call := dotted(node.func, aliases)) in CALLS:
            names |= called(node, call, space, f"{'/'.join(here)}.py, line {node.lineno}")
    return frozenset(names)


def root(name):
    """Return the first part of a dotted name."""
    return name.split(".")[0]


def dotted(node, aliases):
    """Return the full dotted name that an expression stands for, or None."""
    if isinstance(node, ast.Name):
        return aliases.get(node.id)
    if isinstance(node, ast.Attribute) and (base := dotted(node.value, aliases)):
        return f"{base}.{node.attr}"
    return None


def called(node, call, space, where):
    """Return the names that one call imports."""
    arguments = dict(zip(("name", "package"), node.args, strict=False))
    if call.endswith("__import__"):  # name, globals, locals, fromlist, level
        arguments = dict(zip(("name", "globals", "locals", "fromlist", "level"), node.args, strict=False))
    arguments |= {keyword.arg: keyword.value for keyword in node.keywords}
    name = text(arguments.get("name"), space)
    if call.endswith("__import__") and "level" in arguments:
        level = value(arguments["level"], space)
        name = "." * level + name if isinstance(level, int) else UNKNOWN
        arguments["package"] = ast.Name("__package__", ast.Load())
    if name.startswith("."):
        base = text(arguments.get("package"), space).split(".")
        up = len(name) - len(name.lstrip("."))
        base = base[: len(base) - up + 1] if UNKNOWN not in base else [UNKNOWN]
        name = ".".join([*base, *filter(None, [name.lstrip(".")])])
    if root(name).startswith(UNKNOWN):
        raise Unseen(f"{where}: nobody can see what this imports: {ast.unparse(node)}")
    fromlist = value(arguments.get("fromlist"), space) or ()
    return {name, *(f"{name}.{part}" for part in fromlist)}


def value(node, space):
    """Return the value of an expression of what is known, or None."""
    if node is None:
        return None
    try:
        code = compile(ast.Expression(ast.fix_missing_locations(node)), "import", "eval")
        return eval(code, {"__builtins__": {}}, space)
    except Exception:  # whatever is not known
        return None


def text(node, space):
    """Return the text that an expression gives, with UNKNOWN for the parts that are not known."""
    if isinstance(node, ast.JoinedStr):
        return "".join(
            text(part.value if isinstance(part, ast.FormattedValue) else part, space) for part in node.values
        )
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return text(node.left, space) + text(node.right, space)
    found = value(node, space)
    return found if isinstance(found, str) else UNKNOWN


def import_graph(package):
    """Return for each module of a package the set of modules of the package that it imports, all by dotted names.

    A folder stands for its `__init__`. That a module needs the `__init__` of the folders it is in counts only where it
    takes something from there.
    """
    files = {module_name(path, package): path for path in sorted(package.rglob("*.py"))}
    graph = {}
    for name, path in files.items():
        found = set()
        for target in imported(path, package):
            if UNKNOWN in target:
                found |= {file for file in files if fnmatchcase(file, target) and not file.endswith("__init__")}
            else:
                found |= module_of(target, files)
        graph[name] = found - {name}
    return graph


def up(name):
    """Return a dotted name without its last part."""
    return name.rpartition(".")[0]


def module_of(target, files):
    """Return the file that an import reaches: the module, the folder's `__init__`, or what the name is taken from."""
    for name in (target, f"{target}.__init__", up(target), f"{up(target)}.__init__"):
        if name in files:
            return {name}
    return set()


def find_circle(graph):
    """Return the nodes of a shortest circle of a graph, the first of them again at its end; None if there is none."""
    circles = [circle for start in sorted(graph) if (circle := circle_from(start, graph))]
    return min(circles, key=len, default=None)


def circle_from(start, graph):
    """Return a shortest way from a node back to it."""
    came, to_do = {}, [start]
    for node in to_do:
        for there in sorted(graph[node]):
            if there not in came:
                came[there] = node
                to_do.append(there)
        if start in came:
            way = [start]
            while len(way) == 1 or way[-1] != start:
                way.append(came[way[-1]])
            return way[::-1]
    return None


def between_neighbours(graph, folder):
    """Return the graph of what stands in one folder, files and folders, without its own `__init__`."""
    below = {name for name in graph if name.startswith(f"{folder}.")}
    child = {name: name[len(folder) + 1 :].split(".")[0] for name in below}
    result = {one: set() for one in child.values() if one != "__init__"}
    for name in below:
        for there in graph[name] & below:
            if "__init__" not in (child[name], child[there]) and child[name] != child[there]:
                result[child[name]].add(child[there])
    return result
