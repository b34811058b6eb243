"""A student's way from notebook 05 to 07 with a filter of their own: right, in another style, and with mistakes in it.

The code cells of the notebooks are run in this process, one notebook after the other, with one my_slam.py. What they
say is compared with what is stored in the notebooks, and counters in the student's functions say who did the work.
"""

import contextlib
import importlib
import io
import json
import linecache
import re
import sys
import textwrap
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from ekfslam_tutorial.course import build, figures, logbook, registry, sweep

module = importlib.import_module("ekfslam_tutorial.course.keep")  # the package has the function of this name

NUMBERS = ("05", "06", "07")
FILTER = ("05.1", "05.2", "05.3", "05.4", "05.5")
MATCHING = ("07.1", "07.2", "07.3", "07.4")


def counted(id):
    """The reference's text as the student's own, with a counter that lives in the notebook, or in the file."""
    exercise = registry.get(id)
    text, name = exercise.source(), exercise.name
    return text.replace('\n    """\n', f'\n    """\n    CALLS["{name}"] = CALLS.get("{name}", 0) + 1\n', 1)


SAME = {id: counted(id) for id in (*FILTER, *MATCHING)}

OTHER_STYLE = {
    "05.1": """
        CALLS = {"predict": 0, "observe": 0, "correct": 0, "augment": 0, "slam_frame": 0}

        def turned(a):
            return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

        def predict(x, P, u, U):
            CALLS["predict"] += 1
            n, T = len(x), turned(x[2])
            F, G = np.eye(n), np.zeros((n, 3))
            F[:2, 2] = T @ np.array([-u[1], u[0]])
            G[:2, :2], G[2, 2] = T, 1
            moved = [*(x[:2] + T @ u[:2]), x[2] + u[2], *x[3:]]
            return moved, (F @ P @ F.T + G @ U @ G.T).tolist()
        """,
    "05.2": """
        from math import atan2, hypot

        def observe(x, l):
            CALLS["observe"] += 1
            dx, dy = x[l][0] - x[0], x[l][1] - x[1]
            r, H = hypot(dx, dy), np.zeros((2, len(x)))
            H[0, [0, 1, l.start, l.start + 1]] = -dx / r, -dy / r, dx / r, dy / r
            H[1, [0, 1, 2, l.start, l.start + 1]] = dy / r**2, -dx / r**2, -1, -dy / r**2, dx / r**2
            return [r, atan2(dy, dx) - x[2]], H
        """,
    "05.3": """
        def half_turn(a):
            while a > np.pi:
                a -= 2 * np.pi
            while a <= -np.pi:
                a += 2 * np.pi
            return a

        def correct(x, P, y, R, e, H):
            CALLS["correct"] += 1
            K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
            A = np.eye(len(x)) - K @ H
            return x + K @ [y[0] - e[0], half_turn(y[1] - e[1])], A @ P @ A.T + K @ R @ K.T
        """,
    "05.4": """
        def augment(x, P, y, R):
            CALLS["augment"] += 1
            l, L_r, L_y = inverse_observation(x[:3], y)
            n = len(x)
            A = np.vstack([np.eye(n), np.hstack([L_r, np.zeros((2, n - 3))])])
            B = np.vstack([np.zeros((n, 2)), L_y])
            return np.append(x, l), A @ P @ A.T + B @ R @ B.T
        """,
    "05.5": """
        def slam_frame(x, P, ids, u, U, seen, ys, R):
            CALLS["slam_frame"] += 1
            x, P = predict(x, P, u, U)
            ids, told = list(ids), dict(zip(seen, ys))
            for id in reversed([id for id in told if id in ids]):
                start = 3 + 2 * ids.index(id)
                x, P = correct(x, P, told[id], R, *observe(x, slice(start, start + 2)))
            for id in told:
                if id not in ids:
                    x, P = augment(x, P, told[id], R)
                    ids.append(id)
            return x, P, ids
        """,
}

MISTAKES = {
    **SAME,
    "05.2": SAME["05.2"].replace("[0, -1]", "[0, 1]"),  # the column of the heading has the wrong sign
    "05.3": SAME["05.3"].replace("wrap(y[1] - e[1])", "y[1] - e[1]"),
    "07.1": "def choose(zs, Zs, confidence):\n    d2 = np.array([z @ np.linalg.solve(Z, z) for z, Z in zip(zs, Zs)])\n"
    "    return int(np.argmin(d2)), d2",
}


class Way:
    """A student who works through the notebooks, with answers by exercise; no answer: the cell as it is."""

    def __init__(self, folder, answers):
        self.file, self.progress, self.answers = folder / "my_slam.py", folder / "progress.json", answers
        self.spaces, self.said, self.widgets = {}, {}, {}

    def go(self, *numbers):
        """Run notebooks, each in a session of its own."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv(module.VARIABLE, str(self.file))
            patch.setenv(logbook.VARIABLE, str(self.progress))
            patch.setenv("EKFSLAM_CHECK_SECONDS", "200")
            patch.setattr("ekfslam_tutorial.course.show", lambda fig, caption: print(figures.one_line(caption)))
            patch.setattr("ekfslam_tutorial.course.replay", lambda *args, **options: None)
            for number in numbers:
                patch.setattr(module, "_passed", {})
                self.widgets[number] = []
                note = lambda draw, *given, to=self.widgets[number]: to.append(draw)
                patch.setattr("ekfslam_tutorial.course.explore", note)
                self._run(number)
        return self

    def _run(self, number):
        path = next(build.notebooks_folder().glob(f"{number}_*.ipynb"))
        space, said = {"__name__": "__main__", "CALLS": {}}, {}
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            if cell["cell_type"] != "code":
                continue
            text = build.source(cell)
            if "exercise" in cell["metadata"].get("tags", []):
                name = next(n for n in self.names(number) if re.search(rf"def {n}\(|^{n} =", text))
                text = textwrap.dedent(self.answers.get(self.names(number)[name], text))
            file = f"<{self.file.parent.name} {cell['id']}>"
            linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(text, file, "exec"), space)
            plt.close("all")
            said[cell["id"]] = printed.getvalue()
        self.spaces[number], self.said[number] = space, said

    @staticmethod
    def names(number):
        return {e.name: e.id for e in registry.everything() if e.id.startswith(number)}

    def says(self, number, words):
        """The one cell output with these words."""
        found = [text for text in self.said[number].values() if words in text]
        assert len(found) == 1, (words, found)
        return found[0]


def stored(number):
    """What the cells of the notebook say in the repository."""
    path, said = next(build.notebooks_folder().glob(f"{number}_*.ipynb")), {}
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            texts = [o.get("text") or o["data"]["text/plain"] for o in cell["outputs"]]
            said[cell["id"]] = " ".join(t for t in map("".join, texts) if t != "<Figure>").split()
    return said


def numbers_agree(way, number):
    """The texts of all cells that say something of the run are those that are stored."""
    compared = 0
    for id, words in stored(number).items():
        text = way.said[number][id]
        of_the_student = re.search(r"\[\d\d\.|kept|exercises passed|reference|yours, from", text)
        if text and not of_the_student:
            assert text.split() == words, id
            compared += 1
    return compared


@pytest.fixture(scope="module")
def nothing(tmp_path_factory):
    """Who does no exercise."""
    return Way(tmp_path_factory.mktemp("nothing"), {}).go(*NUMBERS)


@pytest.fixture(scope="module")
def same(tmp_path_factory):
    """Who answers as the reference does."""
    return Way(tmp_path_factory.mktemp("same"), SAME).go(*NUMBERS)


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    """Who answers in another style: lists, helpers of their own, Joseph's form, another order of the landmarks."""
    return Way(tmp_path_factory.mktemp("other"), OTHER_STYLE).go(*NUMBERS)


@pytest.fixture(scope="module")
def mistakes(tmp_path_factory):
    """Who has two of the five functions wrong, and the gate."""
    return Way(tmp_path_factory.mktemp("mistakes"), MISTAKES).go(*NUMBERS)


# --- who answers nothing ---


def test_without_a_file_all_is_the_reference_and_the_stored_numbers_come_out(nothing):
    assert not nothing.file.exists()
    assert nothing.says("05", "nothing to keep yet") == (
        "nothing to keep yet: no function has passed its check in this session\n"
    )
    for number in NUMBERS[1:]:
        assert ": the reference (my_slam.py is not there yet)\n" in nothing.says(number, "not there yet")
    assert [numbers_agree(nothing, number) >= 6 for number in NUMBERS] == [True] * 3


# --- whose functions do the work ---


def calls(way, number):
    """How often the student's functions were called in the session of a notebook."""
    return module.inspect.unwrap(way.spaces[number]["slam_frame"]).__globals__["CALLS"]


@pytest.mark.parametrize("way", ["same", "other"])
def test_the_students_functions_do_the_work(way, request):
    way = request.getfixturevalue(way)
    assert "kept in my_slam.py: predict (05.1), observe (05.2), correct (05.3), augment (05.4), slam_frame (05.5)" in (
        way.says("05", "kept in")
    )
    said = way.says("06", "yours, from")
    assert said == "slam_frame (05.5), observe (05.2), correct (05.3): yours, from my_slam.py\n"
    assert ": yours, from my_slam.py\n" in way.says("07", "yours, from")
    for number in ("06", "07"):
        space = way.spaces[number]
        assert module.inspect.unwrap(space["slam_frame"]).__module__ == "my_slam"
        counts = calls(way, number)
        frames = 3 * 253 + 2 * 253 + 505 if number == "06" else 4 * 127  # of the drives in the notebook
        assert counts["slam_frame"] >= frames
        assert min(counts[name] for name in ("predict", "observe", "correct", "augment")) >= 20


def test_the_same_functions_give_the_stored_numbers(same):
    assert [numbers_agree(same, number) >= 6 for number in NUMBERS] == [True] * 3


def test_another_order_of_the_landmarks_is_seen_in_the_numbers_to_centimetres(nothing, other):
    """So the numbers are those of the student's functions, and they are right."""
    a, b = nothing.spaces["06"]["moments"][-1], other.spaces["06"]["moments"][-1]
    d = np.abs(a.x - b.x).max()
    assert 1e-6 < d < 0.1
    assert isinstance(b.x, np.ndarray) and isinstance(b.P, np.ndarray)
    assert abs(np.mean(other.spaces["05"]["nees"]) - np.mean(nothing.spaces["05"]["nees"])) < 0.5


def test_the_gate_and_the_joint_test_work_in_the_students_loop(same):
    space = same.spaces["07"]
    counts = space["CALLS"]
    assert min(counts[name] for name in ("choose", "mutual_nearest", "jointly_compatible", "new_ones")) > 100
    runs = space["runs"]
    assert sum(m.wrong for m in runs["your joint test"]) == 0 < sum(m.wrong for m in runs["your gate"])
    told = same.says("07", "kept in")
    assert "choose (07.1), mutual_nearest (07.2), jointly_compatible (07.3), new_ones (07.4)" in told
    assert "slam_frame (05.5)" not in told
    text = same.file.read_text()
    assert all(f"# ---- {id}  " in text for id in (*FILTER, *MATCHING))


# --- with mistakes ---


def test_what_is_wrong_is_not_kept_and_the_way_goes_on(mistakes):
    told = mistakes.says("05", "kept in")
    assert told.splitlines()[0] == "kept in my_slam.py: predict (05.1), augment (05.4), slam_frame (05.5)"
    assert "uses observe (05.2), correct (05.3): not kept, so the reference stands in the file" in told
    said = mistakes.says("06", "yours, from")
    assert "slam_frame (05.5): yours, from my_slam.py; " in said
    assert "observe (05.2), correct (05.3): the reference (not kept yet)" in said
    counts = calls(mistakes, "06")
    assert counts["predict"] > 1000 > counts["correct"]  # those that were counted in the checks of notebook 05
    assert [numbers_agree(mistakes, number) >= 6 for number in NUMBERS] == [True] * 3
    assert "[07.1] failed" in mistakes.says("07", "[07.1]")
    assert "choose" not in mistakes.says("07", "kept in")


def test_a_mended_function_takes_its_place_later(mistakes):
    """A second session with notebook 05: only what was wrong is answered again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(module.VARIABLE, str(mistakes.file))
        patch.setenv(logbook.VARIABLE, str(mistakes.progress))
        patch.setattr(module, "_passed", {})
        before = mistakes.file.read_text()
        again = Way(mistakes.file.parent, {})
        space = mistakes.spaces["05"]
        text = SAME["05.3"] + '\ncorrect = check("05.3", correct)\nkeep("05.3")\n'
        linecache.cache["<again>"] = (len(text), None, text.splitlines(keepends=True), "<again>")
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(text, "<again>", "exec"), space)
        assert printed.getvalue() == "[05.3] passed\nkept in my_slam.py: correct (05.3)\n"
    assert "until you keep your own" in before.split("05.3")[1].splitlines()[0]
    again.go("06")
    assert "slam_frame (05.5), correct (05.3): yours, from my_slam.py; observe (05.2): the reference" in (
        again.says("06", "yours, from")
    )
    assert calls(again, "06")["correct"] > 1000
    assert numbers_agree(again, "06") >= 6


def test_an_edit_that_breaks_a_function_is_said_and_the_reference_goes_on(same, tmp_path):
    text = same.file.read_text().replace("P[:3, :3] += X_u @ U @ X_u.T", "P[:3, :3] -= X_u @ U @ X_u.T")
    assert text != same.file.read_text()
    (tmp_path / "my_slam.py").write_text(text)
    way = Way(tmp_path, {}).go("06")
    said = way.says("06", "yours")
    assert "slam_frame (05.5): the reference (yours in my_slam.py does not pass its check any more: " in said
    assert "observe (05.2), correct (05.3): yours, from my_slam.py" in said
    assert numbers_agree(way, "06") >= 6


# --- the numbers of the folded answers ---


def folded(number):
    """The folded texts of a notebook."""
    path = next(build.notebooks_folder().glob(f"{number}_*.ipynb"))
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return "\n".join(build.source(c) for c in cells if c["cell_type"] == "markdown" and "<details>" in build.source(c))


def test_every_question_has_its_answer_folded():
    for number, questions in zip(NUMBERS, (4, 5, 6), strict=True):
        path = next(build.notebooks_folder().glob(f"{number}_*.ipynb"))
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        texts = [build.source(c) for c in cells if c["cell_type"] == "markdown"]
        question = r"\*\*(Predict before you run|.* for you to guess now)\.\*\*"
        asked = sum(len(re.findall(question, text)) for text in texts)
        answers = [text for text in texts if re.match(r"<details><summary>(Answer|Debrief</summary>\s+\*\*\()", text)]
        assert asked == len(answers) == questions, (number, asked, len(answers))
        assert not any(re.search(r"[Tt]he answer .*is \*\*\([a-d]\)", text) for text in texts)
        assert all(text.count("<details>") == text.count("</details>") for text in texts)


def variants_of_the_frame(space):
    """The savings of section 11 of notebook 05, and the other order of section 6."""
    frame, observe, correct, augment = (space[name] for name in ("slam_frame", "observe", "correct", "augment"))

    def between_landmarks(x, P, ids, *more):
        x, P, ids = frame(x, P, ids, *more)
        kept = np.zeros_like(P)
        kept[:3], kept[:, :3] = P[:3], P[:, :3]
        for k in range(3, len(x), 2):
            kept[k : k + 2, k : k + 2] = P[k : k + 2, k : k + 2]
        return x, kept, ids

    def quarter(x, P, ids, u, U, seen, ys, R):
        return frame(x, P, ids, u, U, seen, ys, R / 4)

    def twice(x, P, ids, u, U, seen, ys, R):
        x, P, ids = frame(x, P, ids, u, U, seen, ys, R)
        for id, y in zip(seen, ys, strict=True):
            k = 3 + 2 * ids.index(id)
            x, P = correct(x, P, y, R, *observe(x, slice(k, k + 2)))
        return x, P, ids

    def new_ones_first(x, P, ids, u, U, seen, ys, R):
        x, P = space["predict"](x, P, u, U)
        known = list(ids)
        for id, y in zip(seen, ys, strict=True):
            if id not in known:
                x, P = augment(x, P, y, R)
                ids = [*ids, id]
        for id, y in zip(seen, ys, strict=True):
            if id in known:
                k = 3 + 2 * ids.index(id)
                x, P = correct(x, P, y, R, *observe(x, slice(k, k + 2)))
        return x, P, ids

    robot_map = space["broken_frame"]
    return SimpleNamespace(**{k: v for k, v in locals().items() if callable(v)})


def test_the_debrief_of_05(nothing):
    space, text = nothing.spaces["05"], folded("05")
    frames = variants_of_the_frame(space)

    def mean_and_worst(frame):
        runs = [space["error_and_nees"](space["simulate"](frame, seed)) for seed in range(20)]
        return np.mean([nees for _, nees in runs]), max(np.abs(d[3:]).max() for d, _ in runs)

    rows = (frames.robot_map, frames.between_landmarks, frames.quarter, frames.twice)
    told = re.findall(r"^\| .+ \| (\d+) \| ([\d.]+) m \|", text, re.MULTILINE)
    assert len(told) == 4
    for frame, (nees, worst) in zip(rows, told, strict=True):
        mean, error = mean_and_worst(frame)
        assert f"{mean:.0f}" == nees and f"{error:.1f}" == worst
    mean, error = mean_and_worst(frames.frame)
    assert f"NEES {mean:.0f} for 35 states, and the worst landmark of all runs is off by {error:.1f} m" in text


def test_the_order_of_correct_and_augment_matters_little(nothing):
    """Notebook 05 says: no landmark moves by more than 3 cm, and the NEES stays the same."""
    space = nothing.spaces["05"]
    other = variants_of_the_frame(space).new_ones_first
    for seed in range(20):
        a, b = (space["simulate"](frame, seed) for frame in (space["slam_frame"], other))
        where = {id: b.x[3 + 2 * k : 5 + 2 * k] for k, id in enumerate(b.ids)}
        assert all(np.hypot(*(a.x[3 + 2 * k : 5 + 2 * k] - where[id])) < 0.03 for k, id in enumerate(a.ids))
        assert abs(space["error_and_nees"](a)[1] - space["error_and_nees"](b)[1]) < 0.5
    assert registry.get("05.5").judge(other).passed


def test_the_answers_of_06(nothing):
    space, text = nothing.spaces["06"], folded("06")
    k, moments = space["k"], space["moments"]
    before, after = (space["position_correlations"](moments[i]) for i in (k - 1, k))
    assert f"from {before[0, 19]:.2f} to {after[0, 19]:.2f}" in text
    assert all(before[0, j] > before[0, 19] - 0.02 for j in range(19))  # a chain: the ends have least in common
    assert 4 < np.argmin(after[0]) < 16 and np.argmin(after[10]) in (0, 19)  # a ring: half way round has
    assert f"moves the robot by {np.hypot(*(moments[k].x[:2] - moments[k - 1].x[:2])):.1f} m" in text
    said = nothing.says("06", "with cross-covariances")
    assert "13 landmarks move by more than 0.2 m; without them 0 landmarks" in said
    assert "13 landmarks move by more than 0.2 m. Without them, none does" in text
    assert "20 of 20 landmarks are below their floor. The lowest, landmark 8: 0.52 m, floor 1.34 m" in (
        nothing.says("06", "20 of 20")
    )
    assert "For landmark 8 the filter claims 0.52 m, and no filter can know it better than to 1.34 m" in text
    moved = {i: np.hypot(*(moments[k].x[r] - moments[118].x[r])) for i, r in moments[118].ranges.items()}
    assert [i for i, d in moved.items() if d > 1.6] == list(range(13, 20)) and sorted(moments[k].seen) == [0, 19]


def test_the_answers_of_07(nothing):
    space, text = nothing.spaces["07"], folded("07")
    wrong = {name: sum(m.wrong for m in moments) for name, moments in space["runs"].items()}
    nearest, gate = wrong["your nearest neighbour"], wrong["your gate"]
    assert wrong["your joint test"] == 0
    assert f"The nearest neighbour makes {nearest} wrong matches, the gate {gate}, the joint test none." in text
    ahead = space["drive_without_ids"](space["corridor_log"](push=0.7), np.zeros(3), space["by_joint_test"])
    assert f"the joint test makes {sum(m.wrong for m in ahead)} wrong matches, too" in text
    nees, shape = space["curves"][40].T
    assert f"jumps from {shape[39]:.2f} m to {shape[40]:.2f} m" in text
    assert f"is {nees[40]:.0f} after the swap, and still {nees[126]:.0f} at the end" in text
    assert len(space["bad"][-1].origin) - len(space["good"][-1].origin) == 9 and "9 doubles" in text
    at_40 = space["measure"](space["AHEAD"])[40].ids
    assert sorted(at_40[i] for i in space["neighbours"](space["ROOM"][at_40])) == [9, 10]


# --- widgets that stand in the notebooks ---


def test_widgets_of_the_notebooks_work_at_the_ends_of_their_controls(nothing):
    found = [draw for number in NUMBERS for draw in nothing.widgets[number] if draw.__module__ == "__main__"]
    assert [draw.__name__ for draw in found] == ["sandbox", "scrubber", "swap"]
    for draw in found:
        assert sweep(draw, corners=2) >= 5


def teardown_module():
    sys.modules.pop("my_slam", None)
