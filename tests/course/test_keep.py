"""What a student has written lives on in my_slam.py: `keep` writes it, `own` reads it, nothing of theirs is lost."""

import contextlib
import importlib
import inspect
import io
import itertools
import linecache
import os
import subprocess
import sys
import textwrap
from collections import Counter

import numpy as np
import pytest

from ekfslam_tutorial.course import check, keep, own, registry
from ekfslam_tutorial.course.exercise import Exercise
from ekfslam_tutorial.course.my_file import MyFile
from ekfslam_tutorial.toolbox.files import locks

module = importlib.import_module("ekfslam_tutorial.course.keep")  # the package has the function of this name

GIVEN = """
import numpy as np
from ekfslam_tutorial.course import check, keep, own
from ekfslam_tutorial.datasets.lecture import SENSOR
from ekfslam_tutorial.geometry import Frame2, wrap

def inverse_observation(x_r, y):
    p, P_y = SENSOR.retro(y)
    l, L_r, L_p = Frame2(x_r).from_frame(p)
    return l, L_r, L_p @ P_y
"""
FILTER = ("05.1", "05.2", "05.3", "05.4", "05.5")
COUNT = itertools.count()


@pytest.fixture(autouse=True)
def file(tmp_path, monkeypatch):
    """The file of this test's own, and a new session."""
    monkeypatch.setenv(module.VARIABLE, str(tmp_path / "my_slam.py"))
    monkeypatch.setattr(module, "_passed", {})
    monkeypatch.setattr(module, "_owned", {})
    monkeypatch.syspath_prepend(str(tmp_path))
    sys.modules.pop("my_slam", None)
    yield tmp_path / "my_slam.py"
    sys.modules.pop("my_slam", None)


class Notebook:
    """Cells that are run in one namespace; Python finds their text, as it does in a notebook."""

    def __init__(self, given=GIVEN):
        self.space = {"__name__": "__main__"}
        self.run(given)

    def run(self, text):
        """Run a cell; return what it prints."""
        name, text = f"<cell {next(COUNT)}>", textwrap.dedent(text)
        linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(text, name, "exec"), self.space)
        return printed.getvalue()

    def solve(self, *ids, change=lambda text: text):
        """Answer with the text of the reference as the student's own, maybe changed."""
        for id in ids:
            exercise = registry.get(id)
            self.run(change(exercise.source()))
            said = self.run(f'{exercise.name} = check("{id}", {exercise.name})')
            assert said == f"[{id}] passed\n", said


@pytest.fixture
def notebook():
    return Notebook()


# --- what is written ---


def test_the_filter_is_kept_and_comes_back(notebook, file):
    notebook.solve(*FILTER)
    told = notebook.run("keep()")
    assert told == (
        "kept in my_slam.py: predict (05.1), observe (05.2), correct (05.3), augment (05.4), slam_frame (05.5)\n"
    )
    text = file.read_text()
    for id in FILTER:
        assert text.count(f"# ---- {id}  ") == text.count(f"# ---- end of {id} ") == 1
        assert registry.get(id).source() in text or id == "05.4"
    later = Notebook("from ekfslam_tutorial.course import own")
    said = later.run('predict, slam_frame = own("05.1", "05.5")')
    assert said == "predict (05.1), slam_frame (05.5): yours, from my_slam.py\n"
    assert later.space["predict"].__module__ == "my_slam"
    inner = inspect.unwrap(later.space["slam_frame"]).__globals__["predict"]
    assert inspect.unwrap(inner).__module__ == "my_slam"


def test_the_file_is_imported_plainly(notebook, file):
    notebook.solve(*FILTER)
    keep()
    command = "import my_slam; print(my_slam.observe(my_slam.np.array([0, 0, 0, 3, 4.0]), slice(3, 5))[0][0])"
    done = subprocess.run([sys.executable, "-c", command], cwd=file.parent, capture_output=True, text=True)
    assert done.stdout == "5.0\n", done.stderr


def test_the_given_function_of_the_notebook_gets_a_number_as_an_exercise_has_its_name(notebook, file):
    answer = "def augment(x, P, y, R):\n    l, L_r, L_y = inverse_observation(x[:3], y)\n"
    answer += "    P_lx = L_r @ P[:3]\n    P_ll = L_r @ P[:3, :3] @ L_r.T + L_y @ R @ L_y.T\n"
    answer += "    return np.concatenate([x, l]), np.block([[P, P_lx.T], [P_lx, P_ll]])\n"
    notebook.solve("05.4", change=lambda _: answer)
    notebook.run("keep()")
    text = file.read_text()
    assert "def inverse_observation_05(x_r, y):" in text
    assert "l, L_r, L_y = inverse_observation_05(x[:3], y)" in text
    assert "from ekfslam_tutorial.geometry import Frame2" in text
    assert "from ekfslam_tutorial.datasets.lecture import SENSOR" in text
    four = Notebook()
    four.solve("04.1")
    assert "kept in my_slam.py: inverse_observation (04.1)" in four.run("keep()")
    assert own("04.1", "05.4")[0].__name__ == "inverse_observation"


def test_helpers_constants_and_imports_come_along(notebook, file):
    notebook.run("""
        from math import atan2, hypot
        import scipy.linalg as la
        TURN = 2 * np.pi
        ZERO = np.zeros((2, 2))
        def angle(a):
            return (a + TURN / 2) % TURN - TURN / 2
        polar = lambda dx, dy: (hypot(dx, dy), atan2(dy, dx))
        """)
    notebook.run("""
        def observe(x, l):
            dx, dy = x[l] - x[:2]
            r, b = polar(dx, dy)
            H = np.zeros((2, len(x)))
            H[:, l] = np.array([[dx / r, dy / r], [-dy / r**2, dx / r**2]]) + ZERO
            H[:, :2], H[:, 2] = -H[:, l], [0, -1]
            return np.array([r, angle(b - x[2])]), la.block_diag(1, 1) @ H
        """)
    assert notebook.run('observe = check("05.2", observe)') == "[05.2] passed\n"
    assert notebook.run("keep()") == "kept in my_slam.py: observe (05.2)\n"
    text = file.read_text()
    for line in ("from math import atan2", "import scipy.linalg as la", "import numpy as np"):
        assert text.count(f"{line}\n") == 1
    assert f"TURN = {2 * np.pi!r}" in text and "ZERO = np.array([[0.0, 0.0], [0.0, 0.0]])" in text
    assert "polar = lambda dx, dy: (hypot(dx, dy), atan2(dy, dx))" in text
    assert own("05.2").__module__ == "my_slam"


def test_a_class_of_the_notebook_comes_along(notebook, file):
    notebook.run("""
        class Turn:
            def __init__(self, a):
                self.a = wrap(a)
        """)
    notebook.solve("05.3", change=lambda text: text.replace("wrap(y[1] - e[1])", "Turn(y[1] - e[1]).a"))
    assert notebook.run("keep()") == "kept in my_slam.py: correct (05.3)\n"
    assert "class Turn:" in file.read_text() and own("05.3").__module__ == "my_slam"


def test_another_name_and_a_lambda_are_kept_under_the_name_of_the_exercise(notebook, file):
    notebook.run("def my_wrap(angle):\n    return angle - 2 * np.pi * np.round(angle / (2 * np.pi))")
    notebook.run('wrap = check("00.1", my_wrap)')
    assert notebook.run("keep()") == "kept in my_slam.py: wrap_00 (00.1)\n"
    assert "def wrap_00(angle):" in file.read_text()
    notebook.run('wrap = check("00.1", lambda angle: (angle + np.pi) % (2 * np.pi) - np.pi)')
    assert notebook.run("keep()") == "kept in my_slam.py: wrap_00 (00.1)\n"
    assert "wrap_00 = lambda angle: (angle + np.pi) % (2 * np.pi) - np.pi\n" in file.read_text()


# --- what is not written ---


def test_what_did_not_pass_is_not_kept(notebook, file):
    notebook.run("def predict(x, P, u, U):\n    return x + 1, P")
    assert "failed" in notebook.run('predict = check("05.1", predict)')
    assert notebook.run('keep("05.1")').startswith("[05.1] is not kept now: ")
    assert notebook.run("keep()") == "nothing to keep yet: no function has passed its check in this session\n"
    assert not file.exists()


def test_the_last_check_counts(notebook, file):
    notebook.solve("05.1")
    notebook.run("def predict(x, P, u, U):\n    return x + 1, P")
    notebook.run('predict = check("05.1", predict)')
    assert notebook.run('keep("05.1")').startswith("[05.1] is not kept now: ") and not file.exists()


def test_a_self_test_and_an_unknown_number(notebook, file):
    assert notebook.run('keep("05.self")') == "[05.self] is not kept: a self-test has answers, not a function\n"
    for wrong in (keep, own):
        with pytest.raises(ValueError, match="did you mean"):
            wrong("05.9")
    with pytest.raises(ValueError, match="self-test"):
        own("05.self")
    with pytest.raises(ValueError, match="numbers of exercises"):
        own()


def test_a_project_is_no_function(notebook, file):
    said = notebook.run('keep("13.project")')
    assert said.startswith(
        "[13.project] is not kept: a project is a run, not a function. Its scenario and its loop stay"
    )
    with pytest.raises(ValueError, match="own cannot give 13.project: a project is a run"):
        own("13.project")
    assert not file.exists()


def test_what_is_written_by_hand_gives_arrays_too(notebook, file):
    file.write_text(
        "import math\n\ndef predict(x, P, u, U):\n    c, s = math.cos(x[2]), math.sin(x[2])\n"
        "    n, X = len(x), [[1, 0, -s * u[0] - c * u[1]], [0, 1, c * u[0] - s * u[1]], [0, 0, 1]]\n"
        "    X_u = [[c, -s, 0], [s, c, 0], [0, 0, 1]]\n"
        "    F = [[X[i][j] if i < 3 and j < 3 else float(i == j) for j in range(n)] for i in range(n)]\n"
        "    G = [X_u[i] if i < 3 else [0, 0, 0] for i in range(n)]\n"
        "    new = [x[0] + c * u[0] - s * u[1], x[1] + s * u[0] + c * u[1], x[2] + u[2], *x[3:]]\n"
        "    turned = lambda A, B: [[sum(A[i][k] * B[k][l] * A[j][l] for k in range(len(B)) for l in range(len(B)))\n"
        "                            for j in range(n)] for i in range(n)]\n"
        "    return new, [[a + b for a, b in zip(*rows)] for rows in zip(turned(F, P), turned(G, U))]\n"
    )
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        predict = own("05.1")
    assert printed.getvalue() == "predict (05.1): yours, from my_slam.py\n"
    x, P = predict(np.zeros(5), np.eye(5), np.array([1.0, 0.0, 0.1]), 0.01 * np.eye(3))
    assert isinstance(x, np.ndarray) and isinstance(P, np.ndarray) and P.shape == (5, 5)


def test_the_reference_is_not_kept_and_both_say_so(notebook, file):
    for id in FILTER[:4]:
        notebook.run(f'{registry.get(id).name} = check("{id}")')
    notebook.solve("05.5")
    told = notebook.run("keep()")
    assert told.splitlines()[0] == "kept in my_slam.py: slam_frame (05.5)"
    missing = "predict (05.1), observe (05.2), correct (05.3), augment (05.4)"
    assert told.splitlines()[1] == f"[05.5] uses {missing}: not kept, so the reference stands in the file"
    assert "# ---- 05.1  Predict: the reference, until you keep your own " in file.read_text()
    said = notebook.run('own("05.1", "05.5")')
    assert said == "predict (05.1): the reference (not kept yet); slam_frame (05.5): yours, from my_slam.py\n"


def test_what_cannot_be_kept_takes_nothing_else_along(notebook, file):
    """The function that uses it is kept, with the reference for it."""
    notebook.run("big = np.zeros((30, 30))")
    notebook.solve("05.1", change=lambda text: text.replace("c, s =", "big\n    c, s ="))
    notebook.solve(*FILTER[1:])
    told = notebook.run("keep()").splitlines()
    assert told[0] == "kept in my_slam.py: observe (05.2), correct (05.3), augment (05.4), slam_frame (05.5)"
    assert told[1].startswith("[05.1] is not kept: it uses `big` of the notebook")
    assert told[2] == "[05.5] uses predict (05.1): not kept, so the reference stands in the file" and len(told) == 3
    assert notebook.run('own("05.5")') == "slam_frame (05.5): yours, from my_slam.py\n"


def test_a_range_of_the_state_is_a_constant(notebook, file):
    notebook.run("ROBOT = slice(0, 3)")
    notebook.solve("05.1", change=lambda text: text.replace("c, s =", "ROBOT\n    c, s ="))
    assert notebook.run("keep()") == "kept in my_slam.py: predict (05.1)\n"
    assert "ROBOT = slice(0, 3, None)" in file.read_text()


@pytest.mark.parametrize(
    "cell, why",
    [
        ("big = np.zeros((30, 30))", "an array of shape (30, 30)"),
        ("big = iter([1])", "a list_iterator"),
    ],
)
def test_what_has_no_text_is_one_sentence(notebook, file, cell, why):
    notebook.run(cell)
    notebook.solve("05.1", change=lambda text: text.replace("c, s =", "big\n    c, s ="))
    told = notebook.run("keep()")
    assert told.startswith("[05.1] is not kept: it uses `big` of the notebook, ") and why in told
    assert not file.exists()


def test_functions_without_text_or_with_a_memory(notebook, file):
    notebook.run("""
        def outer():
            two = 2.0
            def wrap(a):
                return (a + np.pi) % (two * np.pi) - np.pi
            return wrap
        """)
    notebook.run('wrap = check("00.1", outer())')
    assert notebook.run("keep()") == (
        "[00.1] is not kept: `wrap` stands inside another function; define it in a cell of its own\n"
    )
    space = {"np": np}
    exec("def wrap(a):\n    return (a + np.pi) % (2 * np.pi) - np.pi", space)
    check("00.1", space["wrap"])
    assert notebook.run("keep()").startswith("[00.1] is not kept: the text of `wrap` cannot be found")
    assert not file.exists()


# --- names that clash ---


def test_names_that_exercises_share_follow_the_rule():
    """The plain name is that of notebook 05, and the others carry their number."""
    functions = [e for e in registry.everything() if isinstance(e, Exercise)]
    counts = Counter(e.name for e in functions)
    rule = {e.id: f"{e.name}_{e.id[:2]}" for e in functions if counts[e.name] > 1 and not e.id.startswith("05.")}
    assert {"00.1": "wrap_00", **rule} == module.SHARED  # the filter of 05 imports `wrap`
    names = [module.file_name(e) for e in functions]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("order", [("01.4", "05.3", "11.2", "05.1"), ("05.1", "11.2", "05.3", "01.4")])
def test_clashing_names_in_either_order(file, order):
    for id in order:
        one = Notebook(GIVEN + "from ekfslam_tutorial.course.exercises.nb11_odo3 import odo3\n")
        one.solve(id)
        assert f"({id})" in one.run("keep()")
    text = file.read_text()
    for name in ("correct", "correct_01", "predict", "predict_11"):
        assert text.count(f"def {name}(") == 1
    for id, function in zip(order, own(*order), strict=True):
        assert registry.get(id).judge(function).passed and function.__module__ == "my_slam"


def test_two_helpers_of_one_name_and_a_shared_one(file):
    helper = "def near(a):\n    return wrap(a)"
    for id, body in (
        ("05.3", helper),
        ("05.2", helper),
        ("00.1", "near = lambda a: (a + np.pi) % (2 * np.pi) - np.pi"),
    ):
        one = Notebook()
        one.run(body)
        if id == "00.1":
            one.solve(id, change=lambda _: "def wrap(angle):\n    return near(angle)")
        else:
            one.solve(id, change=lambda text: text.replace("wrap(", "near("))
        assert f"({id})" in one.run("keep()")
    text = file.read_text()
    assert text.count("def near(a):") == 1 and text.count("near_00 = lambda a:") == 1
    assert "return near_00(angle)" in text
    assert [f.__module__ for f in own("00.1", "05.2", "05.3")] == ["my_slam"] * 3


# --- kept again, edited, broken ---


def test_kept_twice_is_the_same_file(notebook, file):
    notebook.solve(*FILTER)
    keep()
    once = file.read_text()
    keep()
    assert file.read_text() == once


def test_out_of_order_gives_the_same_functions_in_the_order_of_the_course(notebook, file):
    notebook.solve(*FILTER)
    for id in ("05.5", "05.2", "05.4", "05.1", "05.3"):
        keep(id)
    text = file.read_text()
    assert [text.index(f"# ---- {id}") for id in FILTER] == sorted(text.index(f"# ---- {id}") for id in FILTER)
    assert "until you keep your own" not in text
    assert {f.__module__ for f in own(*FILTER)} == {"my_slam"}


def test_a_section_is_replaced_and_what_the_student_wrote_stays(notebook, file):
    notebook.solve("05.1", "05.2")
    keep()
    text = file.read_text()
    mine = "# my note\nLUCKY = 7\n\n\ndef mine():\n    return LUCKY\n"
    place = text.index("# ---- 05.2")
    file.write_text(text[:place] + mine + "\n" + text[place:] + "\n# the end\n")
    before = file.read_text()
    notebook.solve("05.1", change=lambda text: text.replace("return x, P", "return x, P  # mine"))
    keep()
    after = file.read_text()
    assert after == before.replace("    return x, P\n# ---- end of 05.1", "    return x, P  # mine\n# ---- end of 05.1")
    assert mine in after and after.endswith("# the end\n")
    keep("05.2")
    assert file.read_text() == after


@pytest.mark.parametrize(
    "edit, why",
    [
        (lambda text: text.replace("def predict(", "def predict((", 1), "it is not valid Python (line "),
        (
            lambda text: text.replace("# ---- end of 05.1 ", "# the end of 05.1 "),
            'the line "# ---- end of 05.1 ----" is',
        ),
        (lambda text: text.replace("# ---- 05.1 ", "# 05.1 "), 'the line "# ---- 05.1 ..." is missing'),
        (lambda text: text + text[text.index("# ---- 05.1") :], "it has two sections 05.1"),
        (lambda text: text + "\nprint(1 / 0)\n", "with ZeroDivisionError: division by zero"),
        (lambda text: text.encode() + b"# \xff\n", "it is not"),
    ],
)
def test_a_broken_file_is_never_touched(notebook, file, edit, why):
    notebook.solve("05.1")
    keep()
    broken = edit(file.read_text())
    file.write_bytes(broken if isinstance(broken, bytes) else broken.encode())
    before = file.read_bytes()
    told = notebook.run("keep()")
    assert told.startswith("my_slam.py stays as it is, and nothing is kept: ") and why in told
    assert file.read_bytes() == before and os.listdir(file.parent).count("my_slam.py") == 1
    if "ZeroDivision" not in why and "two sections" not in why:
        said = notebook.run('own("05.1")')
        assert said.startswith("predict (05.1): the reference (my_slam.py: ") and why in said


def test_a_function_that_was_edited_and_fails_is_replaced_and_said(notebook, file):
    notebook.solve("05.1", "05.3")
    keep()
    file.write_text(file.read_text().replace("wrap(y[1] - e[1])", "y[1] - e[1]"))
    said = notebook.run('predict, correct = own("05.1", "05.3")')
    assert said == (
        "predict (05.1): yours, from my_slam.py; correct (05.3): the reference (yours in my_slam.py does not pass its "
        'check any more: import my_slam; check("05.3", my_slam.correct))\n'
    )
    assert notebook.space["correct"] is registry.get("05.3").reference
    assert "failed" in notebook.run('import my_slam; check("05.3", my_slam.correct)')


def test_an_import_is_never_stale(notebook, file):
    notebook.solve("05.1")
    keep()
    assert "not_yet" not in vars(importlib.import_module("my_slam"))
    for number in (1, 2, 3):  # of one length, within one second
        file.write_text(file.read_text().split("# free")[0] + f"# free\nnot_yet = {number}\n")
        own("05.1")
        assert importlib.import_module("my_slam").not_yet == number
    notebook.solve("05.1", change=lambda text: text.replace("return x, P", "return [x, P]"))
    keep()
    assert isinstance(importlib.import_module("my_slam").predict(np.zeros(3), np.eye(3), np.ones(3), np.eye(3)), list)


def test_functions_that_return_lists_work_together_as_in_the_notebook(notebook, file):
    """What `check` returns gives arrays; so does what `own` returns, also where one function calls the other."""
    as_lists = lambda text: text.replace("return x, P", "return x.tolist(), P.tolist()").replace(
        "return e, H", "return list(e), H.tolist()"
    )
    notebook.solve(*FILTER, change=as_lists)
    assert notebook.run("keep()").count("(05.") == 5
    x, P = own("05.1")(np.zeros(3), np.eye(3), np.ones(3), np.eye(3))
    assert isinstance(x, np.ndarray) and isinstance(P, np.ndarray)
    assert own("05.5").__module__ == "my_slam"


def test_what_own_returned_can_be_kept_again_and_called_by_the_next(file):
    first = Notebook()
    first.solve(*FILTER[:4])
    keep()
    text = file.read_text()
    module._passed.clear()
    later = Notebook("import numpy as np\nfrom ekfslam_tutorial.course import check, keep, own")
    later.run('predict, observe, correct, augment = own("05.1", "05.2", "05.3", "05.4")')
    later.solve("05.5")
    assert later.run("keep()") == "kept in my_slam.py: slam_frame (05.5)\n"
    assert file.read_text().startswith(text.rstrip())
    later.run('predict = check("05.1", predict)')
    later.run('keep("05.1")')
    assert file.read_text().startswith(text.rstrip())


def test_lines_that_end_as_on_windows_stay(notebook, file):
    notebook.solve("05.1")
    keep()
    file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    notebook.solve("05.2")
    keep()
    assert file.read_bytes().count(b"\n") == file.read_bytes().count(b"\r\n")


def test_a_folder_that_cannot_be_written_is_one_sentence(notebook, file, monkeypatch):
    notebook.solve("05.1")
    (file.parent / "no").write_text("a file")
    monkeypatch.setenv(module.VARIABLE, str(file.parent / "no" / "my_slam.py"))
    told = notebook.run("keep()")
    assert len(told.splitlines()) == 1 and "nothing is kept" in told


def test_two_kernels_keep_one_after_the_other(notebook, file, monkeypatch):
    """From the reading of the file to its writing nobody else may change it; afterwards there is no trace of that."""
    seen, read = [], MyFile.read

    def looked_at(path):
        with pytest.raises(locks.Taken):
            locks._locked(path)
        seen.append(path)
        return read(path)

    monkeypatch.setattr(MyFile, "read", looked_at)
    notebook.solve("05.1")
    keep()
    notebook.solve("05.2")
    keep()
    assert len(seen) == 2 and {"05.1", "05.2"} <= read(file).sections().keys()
    os.close(locks._locked(file))
    assert not [p for p in file.parent.iterdir() if p.name.startswith(".") or p.suffix in (".lock", ".part")]


def test_a_full_disk_leaves_the_file(notebook, file, monkeypatch):
    notebook.solve("05.1")
    keep()
    before = file.read_text()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    notebook.solve("05.2")
    assert "cannot be written, and nothing is kept: No space left" in notebook.run("keep()")
    assert file.read_text() == before and not [p for p in file.parent.iterdir() if p.name.startswith(".")]


# --- in a real notebook's kernel, and in a script ---

CELLS = '''
from IPython.core.interactiveshell import InteractiveShell
from ekfslam_tutorial.course import registry

shell = InteractiveShell.instance()
def cell(text):
    result = shell.run_cell(text, store_history=True)
    assert result.success

cell("""{given}""")
for id in {ids}:
    cell(registry.get(id).source())
    cell(f'{{registry.get(id).name}} = check("{{id}}", {{registry.get(id).name}})')
cell("keep()")
'''


def run_python(text, file):
    script = file.parent / "student.py"
    script.write_text(text)
    command = [sys.executable, str(script)]
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, env={**os.environ})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_cells_of_ipython(file):
    out = run_python(CELLS.format(given=GIVEN, ids=FILTER), file)
    assert out.splitlines()[-1].startswith("kept in my_slam.py: predict (05.1), ")
    assert {f.__module__ for f in own(*FILTER)} == {"my_slam"}


def test_a_plain_script(file):
    text = GIVEN + "\n\n".join(registry.get(id).source() for id in FILTER)
    text += (
        "".join(f'\n{registry.get(id).name} = check("{id}", {registry.get(id).name})' for id in FILTER) + "\nkeep()\n"
    )
    out = run_python(text, file)
    assert out.splitlines()[-1].startswith("kept in my_slam.py: predict (05.1), ")
    assert {f.__module__ for f in own(*FILTER)} == {"my_slam"}
