"""The folders are floors: imports go only upwards in this list, and the core needs numpy and scipy only."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import ekfslam_tutorial

PACKAGE = Path(ekfslam_tutorial.__file__).parent
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
CORE_MAY_IMPORT = {"numpy", "scipy", NAME} | sys.stdlib_module_names
HEAVY = {"matplotlib", "ipywidgets", "IPython", "tqdm"}
FILES = sorted(PACKAGE.rglob("*.py"))


def floor(parts):
    """Return the floor of a module from its path below the package; None for the package's own files."""
    return parts[0] if parts and parts[0] in FLOORS else None


def imported(path, package=PACKAGE):
    """Return the dotted names of the modules that a source file imports, relative imports made absolute."""
    module = [package.name, *path.relative_to(package).with_suffix("").parts]
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = module[: -node.level] if node.level else []
            source = [*base, *((node.module or "").split(".") if node.module else [])]
            # `from .. import x` and `from package import x` may name a module: keep x in the path.
            names += [".".join([*source, alias.name]) for alias in node.names]
    return names


def too_high(path, package=PACKAGE):
    """Return the imports of a file that reach a floor below its own in the list."""
    here = floor(path.relative_to(package).with_suffix("").parts)
    targets = [(name, floor(name.split(".")[1:])) for name in imported(path, package) if root(name) == NAME]
    if here is None:  # the package's __init__ and __main__
        return [name for name, _ in targets] if path.name == "__init__.py" else []
    return [name for name, there in targets if there and FLOORS.index(there) > FLOORS.index(here)]


def root(name):
    return name.split(".")[0]


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_imports_go_only_upwards(path):
    assert too_high(path) == []


def test_every_folder_is_a_floor():
    parts = {p.relative_to(PACKAGE).with_suffix("").parts[0] for p in FILES}
    assert parts - set(FLOORS) - {"__init__", "__main__"} == set()


@pytest.mark.parametrize(
    "source, wrong",
    [
        ("from ..slam import steps", [f"{NAME}.slam.steps"]),
        ("from .. import cli", [f"{NAME}.cli"]),
        (f"import {NAME}.graphics.styles", [f"{NAME}.graphics.styles"]),
        ("def f():\n    from ..course.checks import check", [f"{NAME}.course.checks.check"]),
        ("from ..geometry import wrap\nfrom .filter import correct\nimport numpy", []),
    ],
)
def test_the_check_itself_sees_a_wrong_import(tmp_path, source, wrong):
    path = tmp_path / NAME / "ekf" / "trial.py"
    path.parent.mkdir(parents=True)
    path.write_text(source)
    assert too_high(path, tmp_path / NAME) == wrong


@pytest.mark.parametrize("name", CORE)
def test_the_core_imports_numpy_and_scipy_only(name):
    files = sorted((PACKAGE / name).rglob("*.py"))
    assert files, f"{name}/ is empty"
    others = {root(imp) for path in files for imp in imported(path)} - CORE_MAY_IMPORT
    assert others == set()


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
