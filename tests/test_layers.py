"""The folders are floors: imports go only upwards in this list, never in a circle, and the core needs numpy only.

`fast`, the wing that exists to be quick, stands on the core; four folders know that it is there.
"""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ekfslam_tutorial

from .imports import UNKNOWN, Unseen, between_neighbours, find_circle, import_graph, imported, root

PACKAGE = Path(ekfslam_tutorial.__file__).parent
REPOSITORY = Path(__file__).resolve().parent.parent
NAME = PACKAGE.name
FLOORS = [
    "geometry",
    "models",
    "ekf",
    "slam",
    "fast",
    "simulation",
    "toolbox",
    "datasets",
    "analysis",
    "graphics",
    "course",
    "cli",
]
CORE = ["geometry", "models", "ekf", "slam"]
CORE_MAY_IMPORT = {"numpy", "scipy", NAME} | sys.stdlib_module_names - {"importlib", "runpy", "pkgutil"}
MAY_IMPORT_FAST = {"fast", "toolbox", "analysis", "cli"}
HEAVY = {"matplotlib", "ipywidgets", "IPython", "rich"}
OF_MACHINES = "compiled|numba|cache|triangle|blas|microsecond"
FILES = sorted(PACKAGE.rglob("*.py"))

each_file = pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(PACKAGE).as_posix())


def floor(parts):
    """Return the floor of a module from its path below the package; None for the package's own files."""
    if parts and parts[0] == UNKNOWN:  # it may be any: the highest
        return FLOORS[-1]
    return parts[0] if parts and parts[0] in FLOORS else None


def too_high(path, package=PACKAGE):
    """Return the imports of a file that reach a floor below its own in the list."""
    here = floor(path.relative_to(package).with_suffix("").parts)
    targets = [(name, floor(name.split(".")[1:])) for name in imported(path, package) if root(name) == NAME]
    if here is None:  # the package's __init__ and __main__
        return [name for name, _ in targets] if path.name == "__init__.py" else []
    return [name for name, there in targets if there and FLOORS.index(there) > FLOORS.index(here)]


def to_fast(path, package=PACKAGE):
    """Return the imports of the wing in a file that may not know of it."""
    names = imported(path, package)
    if floor(path.relative_to(package).parts) in MAY_IMPORT_FAST:
        return []
    return [name for name in names if name.startswith(f"{NAME}.fast") or name == f"{NAME}.{UNKNOWN}"]


@each_file
def test_imports_go_only_upwards(path):
    assert too_high(path) == []


@each_file
def test_four_folders_import_the_wing(path):
    assert to_fast(path) == []


def test_beside_the_package_only_benchmarks_and_tests_import_the_wing():
    sources = [p for folder in ("docs", "tools", "notebooks") for p in (REPOSITORY / folder).rglob("*")]
    readers = [p for p in sources if p.suffix in (".py", ".ipynb") and ".ipynb_checkpoints" not in p.parts]
    pattern = rf"{NAME}\.fast\b|from {NAME} import .*\bfast\b"
    assert readers and [p.name for p in readers if re.search(pattern, p.read_text(encoding="utf-8"))] == []


# --- no circle ---


@pytest.fixture(scope="module")
def graph():
    return import_graph(PACKAGE)


def the_way(circle):
    return " -> ".join(circle or [])


def test_no_circle_of_files(graph):
    assert the_way(find_circle(graph)) == ""


FOLDERS = [NAME, *(".".join([NAME, *p.parent.relative_to(PACKAGE).parts]) for p in FILES if p.name == "__init__.py")]


@pytest.mark.parametrize("folder", sorted(set(FOLDERS)))
def test_no_circle_between_what_stands_in_one_folder(graph, folder):
    assert the_way(find_circle(between_neighbours(graph, folder))) == ""


def test_every_folder_is_a_floor():
    parts = {p.relative_to(PACKAGE).with_suffix("").parts[0] for p in FILES}
    assert parts - set(FLOORS) - {"__init__", "__main__"} == set()


# --- the checks themselves ---


def house(folder, files):
    """Write a package of these files, given without `.py`, and return its folder."""
    package = folder / NAME
    for name, source in files.items():
        path = (package / name).with_suffix(".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source)
        for parent in path.parents:
            if parent.is_relative_to(package):
                (parent / "__init__.py").touch()
    return package


SEEN = {
    "import x as y": f"import {NAME}.graphics.style as style",
    "from": "from ..slam import steps",
    "from the top": "from .. import cli",
    "all names": "from ..cli import *",
    "inside a function": "def f():\n    from ..course.checks import check",
    "in a class": "class A:\n    from ..course.checks import check",
    "for a type checker": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..cli import main",
    "import_module": f"import importlib\nimportlib.import_module('{NAME}.cli')",
    "relative to a package": "from importlib import import_module\nimport_module('..cli', __package__)",
    "package by its keyword": "from importlib import import_module\nimport_module(package=__package__, name='..cli')",
    "another name": "from importlib import import_module as load\nload('..cli', __package__)",
    "another name of importlib": "import importlib as il\ndef f():\n    return il.import_module('..cli', __package__)",
    "a name given later": "import importlib\nload = importlib.import_module\nload('..cli', __package__)",
    "__import__": f"__import__('{NAME}.cli.main')",
    "__import__ with a level": "__import__('cli', globals(), locals(), ['main'], 2)",
    "by builtins": f"import builtins\nbuiltins.__import__('{NAME}.cli')",
    "runpy": f"import runpy\nrunpy.run_module('{NAME}.cli')",
    "a text with __package__": "import importlib\nimportlib.import_module(__package__.replace('.ekf', '.cli'))",
    "a text with __name__": "import importlib\nimportlib.import_module(__name__.split('.')[0] + '.cli')",
    "a formatted text": "import importlib\nimportlib.import_module(f'{__name__[:16]}.{\"cli\"}')",
    "a constant": "from importlib import import_module\nTOP = '..cli'\nimport_module(TOP, __package__)",
    "a part known later": "import importlib\ndef f(x):\n    importlib.import_module(f'..cli.{x}', __package__)",
    "any floor": "import importlib\ndef f(x):\n    importlib.import_module(f'..{x}', __package__)",
}


@pytest.mark.parametrize("source", SEEN.values(), ids=SEEN)
def test_every_way_to_import_is_seen(tmp_path, source):
    package = house(tmp_path, {"ekf/trial": source})
    assert too_high(package / "ekf" / "trial.py", package)


@pytest.mark.parametrize(
    "source, wrong",
    [
        ("from ..slam import steps", [f"{NAME}.slam.steps"]),
        ("from .. import cli", [f"{NAME}.cli"]),
        (f"import {NAME}.graphics.styles", [f"{NAME}.graphics.styles"]),
        ("def f():\n    from ..course.checks import check", [f"{NAME}.course.checks.check"]),
        ("from ..geometry import wrap\nfrom .filter import correct\nimport numpy", []),
        ("from importlib import import_module\nimport_module('..geometry.angles', __package__)", []),
    ],
)
def test_a_wrong_import_is_named_and_a_right_one_is_not(tmp_path, source, wrong):
    package = house(tmp_path, {"ekf/trial": source})
    assert too_high(package / "ekf" / "trial.py", package) == wrong


def test_a_name_that_nobody_can_see_is_refused(tmp_path):
    package = house(tmp_path, {"ekf/trial": "from importlib import import_module\n\ndef f(x):\n    import_module(x)"})
    with pytest.raises(Unseen, match="ekf/trial.py, line 4: nobody can see what this imports: import_module"):
        imported(package / "ekf" / "trial.py", package)


@pytest.mark.parametrize(
    "source, refused",
    [("from ..fast import move", True), ("from .. import fast", True), ("from ..slam import x", False)],
)
def test_the_wing_is_kept_from_those_who_may_not_know_of_it(tmp_path, source, refused):
    package = house(tmp_path, {"graphics/trial": source, "analysis/trial": source})
    assert bool(to_fast(package / "graphics" / "trial.py", package)) is refused
    assert to_fast(package / "analysis" / "trial.py", package) == []


def test_a_circle_is_named(tmp_path):
    files = {
        "ekf/a": "def f():\n    from .b import g",
        "ekf/b": "from importlib import import_module as load\nload('.c', __package__)",
        "ekf/c": "from . import a",
        "slam/x/one": "from ..y import two",
        "slam/y/two": "",
        "slam/y/three": "from ..x.four import f",
        "slam/x/four": "",
    }
    graph, ekf = import_graph(house(tmp_path, files)), f"{NAME}.ekf"
    assert the_way(find_circle(graph)) == f"{ekf}.a -> {ekf}.b -> {ekf}.c -> {ekf}.a"
    slam = between_neighbours(graph, f"{NAME}.slam")  # no circle of files, but one of folders
    assert the_way(find_circle(slam)) == "x -> y -> x"
    assert find_circle(between_neighbours(graph, f"{NAME}.slam.x")) is None


def test_a_folder_whose_own_file_is_asked_from_below_is_a_circle(tmp_path):
    files = {"ekf/__init__": "from .a import f", "ekf/a": "from . import something"}
    graph, ekf = import_graph(house(tmp_path, files)), f"{NAME}.ekf"
    assert the_way(find_circle(graph)) == f"{ekf}.__init__ -> {ekf}.a -> {ekf}.__init__"


# --- the core ---


@pytest.mark.parametrize("name", CORE)
def test_the_core_imports_numpy_and_scipy_only(name):
    files = sorted((PACKAGE / name).rglob("*.py"))
    assert files, f"{name}/ is empty"
    others = {root(imp) for path in files for imp in imported(path, PACKAGE)} - CORE_MAY_IMPORT
    assert others == set()


@pytest.mark.parametrize("name", CORE)
def test_the_core_says_nothing_of_machines(name):
    lines = [
        f"{path.relative_to(PACKAGE).as_posix()}:{i}: {line.strip()}"
        for path in sorted((PACKAGE / name).rglob("*.py"))
        for i, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if re.search(OF_MACHINES, line.replace("cached_property", ""), re.IGNORECASE)
    ]
    assert lines == []


@pytest.mark.parametrize("module", [NAME, *(f"{NAME}.{name}" for name in CORE)])
def test_importing_the_core_starts_no_plotting(module):
    code = f"import sys, {module}; print(*sorted({HEAVY!r} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == []


@pytest.mark.parametrize("name", [name for name in FLOORS if name != "cli"])
def test_each_floor_says_what_lives_there(name):
    doc = ast.get_docstring(ast.parse((PACKAGE / name / "__init__.py").read_text(encoding="utf-8")))
    assert doc and len(doc.splitlines()) >= 2, f"{name}/__init__.py says what lives there and what may not"
