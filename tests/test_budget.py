"""The core can be read in an evening: how much code it has, and how much of it one measurement visits.

A line is one of code if there is a word in it that is neither in a comment nor in a docstring.
"""

import ast
import itertools
import os
import sys
import tokenize
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import ekfslam_tutorial
from ekfslam_tutorial.ekf import Map
from ekfslam_tutorial.geometry import Frame2
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place

PACKAGE = Path(ekfslam_tutorial.__file__).parent
CORE_LINES, MODEL_LINES, FUNCTION_LINES = 1500, 130, 40
ONE_MODEL, LONGER = 80, {"pin_hole.py", "omni_cam.py"}
"""Lines of a sensor, a landmark or a motion; but for two cameras, whose files hold the manual's functions as well."""
VISIT = {"files": 12, "functions": 75, "code lines": 190, "changes of file": 65}
LAYOUT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING,
    tokenize.ENDMARKER,
}  # fmt: skip


def sources(*folders):
    return [path for folder in folders for path in sorted((PACKAGE / folder).rglob("*.py"))]


def span(node):
    return set(range(node.lineno, node.end_lineno + 1))


def code_lines(path):
    """Return the numbers of the lines of code of a file."""
    with open(path, "rb") as file:
        words = [t for t in tokenize.tokenize(file.readline) if t.type not in LAYOUT]
    lines = {line for t in words for line in range(t.start[0], t.end[0] + 1)}
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    holders = [n for n in nodes if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)]
    return lines - {line for n in holders if ast.get_docstring(n) is not None for line in span(n.body[0])}


def long_functions(path, limit=FUNCTION_LINES):
    """Return the functions of a file with more lines of code than the limit, and how many they have."""
    lines, tree = code_lines(path), ast.parse(path.read_text(encoding="utf-8"))
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    return {f.name: n for f in functions if (n := len(lines & span(f))) > limit}


# --- how much there is ---


def test_geometry_ekf_and_slam_are_small():
    sizes = {path.relative_to(PACKAGE).as_posix(): len(code_lines(path)) for path in sources("geometry", "ekf", "slam")}
    assert sizes and sum(sizes.values()) <= CORE_LINES, sizes


@pytest.mark.parametrize("path", sources("models"), ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_a_file_of_models_is_small(path):
    one = path.parent.name in ("sensors", "landmarks", "motion") and path.name not in LONGER
    assert len(code_lines(path)) <= (ONE_MODEL if one else MODEL_LINES)


@pytest.mark.parametrize("folder", ["geometry", "models", "ekf", "slam", "toolbox", "datasets"])
def test_functions_fit_on_a_screen(folder):
    found = {path.relative_to(PACKAGE).as_posix(): long_functions(path) for path in sources(folder)}
    assert {path: functions for path, functions in found.items() if functions} == {}


EXAMPLE = '''"""Text."""

import a  # with a comment


def f(
    x,
):
    """Text
    of two lines."""
    # a comment

    y = """two
    lines"""
    def g():
        return 1

    return y


N = 3
"""What it is: no docstring, but a text that is code for Python."""
'''


def test_lines_are_counted_as_they_are_meant(tmp_path):
    path = tmp_path / "example.py"
    path.write_text(EXAMPLE)
    assert sorted(code_lines(path)) == [3, 6, 7, 8, 13, 14, 15, 16, 18, 21, 22]
    assert long_functions(path, 7) == {"f": 8} and long_functions(path, 8) == {}


# --- how much of it one measurement visits ---


class Visit:
    """What runs in the package meanwhile: the calls in their order, and the lines."""

    def __init__(self):
        self.calls, self.lines = [], set()

    def __enter__(self):
        self.before = sys.gettrace()
        sys.settrace(self.note)
        return self

    def __exit__(self, *_):
        sys.settrace(self.before)

    def note(self, frame, event, _):
        code = frame.f_code
        if not code.co_filename.startswith(f"{PACKAGE}{os.sep}"):
            return None
        if event == "call":
            self.calls.append((code.co_filename, code.co_qualname if hasattr(code, "co_qualname") else code.co_name,
                               code.co_firstlineno))  # fmt: skip
        elif event == "line":
            self.lines.add((code.co_filename, frame.f_lineno))
        return self.note

    def figures(self):
        files = [file for file, *_ in self.calls]
        return {
            "files": len(set(files)),
            "functions": len(set(self.calls)),
            "code lines": len(self.lines),
            "changes of file": sum(a != b for a, b in itertools.pairwise(files)),
        }

    def report(self):
        """Return the visited functions by file, for whoever has to find what is too much."""
        by_file = {}
        for file, name, _ in self.calls:
            by_file.setdefault(Path(file).relative_to(PACKAGE).as_posix(), {})[name] = None
        return "\n".join([f"{self.figures()}, wanted {VISIT}", *(f"  {f}: {', '.join(n)}" for f, n in by_file.items())])


def twelve_landmarks(joint):
    """Return a function that moves a robot among twelve landmarks, and one that corrects by those it is given."""
    rng, map, lmks, obs = np.random.default_rng(1), Map(), {}, {}
    rob = Rob(1, Unicycle(), u=np.array([1.0, 0.1]), U=np.diag([0.01, 0.001]))
    sen = Sen(1, 1, RangeBearing(0.1, 0.02), Frame2, x=np.zeros(3))
    options = Options(lmk_type=EucPnt(2), md2_threshold=13.8, joint=joint)
    world = rng.uniform(-5, 5, (12, 2))
    place(map, rob, np.zeros(3), np.eye(3) * 0.01)

    def measured(ids):
        x, y, a = rob.state(map)
        dx, dy = (world[ids] - [x, y]).T
        ideal = np.stack([np.hypot(dx, dy), np.arctan2(dy, dx) - a], -1)
        return SimpleNamespace(ids=np.array(ids), y=ideal + rng.normal(size=ideal.shape) * [0.02, 0.005], R=None)

    init_new_lmks(map, rob, sen, lmks, measured(list(range(12))), list(range(12)), options)
    step = lambda: move(map, rob, 0.1)
    return step, measured, lambda raw: correct_known_lmks(map, rob, sen, lmks, obs, raw, options)


@pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])
def test_one_correction_visits_little(joint):
    """Everything is warm: what is computed once for all has been."""
    step, measured, correct = twelve_landmarks(joint)
    for _ in range(3):
        step()
        correct(measured([0, 3, 5]))
    step()
    raw = measured([3])
    with Visit() as visit:
        correct(raw)
    figures = visit.figures()
    assert all(0 < figures[what] <= most for what, most in VISIT.items()), visit.report()
