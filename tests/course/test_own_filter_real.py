"""A student's own filter in notebooks 08, 09 and 20: it is what runs there; the numbers in their texts are true."""

import contextlib
import io
import json
import re
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest

from ekfslam_tutorial.analysis import anees_band
from ekfslam_tutorial.course import build, figures, logbook, museum_runs, registry, widgets
from ekfslam_tutorial.course.keep import VARIABLE
from ekfslam_tutorial.course.my_file import MyFile

from .running import without_dots

MY_SLAM = '''
"""A filter in a student's own words. CALLS counts who was called."""

from collections import Counter
from math import atan2, cos, hypot, pi, sin

import numpy as np

CALLS = Counter()


def predict(x, P, u, U):
    CALLS["predict"] += 1
    n, c, s = len(x), cos(x[2]), sin(x[2])
    F = np.eye(n)
    F[:2, 2] = -s * u[0] - c * u[1], c * u[0] - s * u[1]
    G = np.zeros((n, 3))
    G[:3] = [c, -s, 0], [s, c, 0], [0, 0, 1]
    return x + G @ u, F @ P @ F.T + G @ U @ G.T


def observe(x, l):
    CALLS["observe"] += 1
    (px, py, theta), (lx, ly) = x[:3], x[l]
    dx, dy = lx - px, ly - py
    q = dx * dx + dy * dy
    E_l = np.array([[dx / q**0.5, dy / q**0.5], [-dy / q, dx / q]])
    H = np.zeros((2, len(x)))
    H[:, :2], H[1, 2], H[:, l] = -E_l, -1, E_l
    return [hypot(dx, dy), atan2(dy, dx) - theta], H


def correct(x, P, y, R, e, H):
    CALLS["correct"] += 1
    z = np.subtract(y, e)
    z[1] = (z[1] + pi) % (2 * pi) - pi
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    A = np.eye(len(x)) - K @ H
    return x + K @ z, A @ P @ A.T + K @ R @ K.T


def augment(x, P, y, R):
    CALLS["augment"] += 1
    n, a = len(x), x[2] + y[1]
    G_x = np.zeros((2, n))
    G_x[:, :3] = [1, 0, -y[0] * sin(a)], [0, 1, y[0] * cos(a)]
    G_y = np.array([[cos(a), -y[0] * sin(a)], [sin(a), y[0] * cos(a)]])
    J, N = np.vstack([np.eye(n), G_x]), np.zeros((n + 2, n + 2))
    N[n:, n:] = G_y @ R @ G_y.T
    return [*x, x[0] + y[0] * cos(a), x[1] + y[0] * sin(a)], (J @ P @ J.T + N).tolist()
'''
MISTAKE = "F[:2, 2] = -s * u[0] - c * u[1], c * u[0] - s * u[1]", "F[:2, 2] = s * u[0], -c * u[1]"  # of the Jacobian


@contextlib.contextmanager
def student(folder, text=MY_SLAM):
    """A student who has kept a filter: file, progress, and no real logs."""
    head, *functions = text.strip().split("\n\n\n")
    kept = MyFile([head + "\n"])
    for id, function in zip(("05.1", "05.2", "05.3", "05.4"), functions, strict=True):
        kept.put(id, registry.get(id).title, function)
    kept.write(folder / "my_slam.py")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(folder / "my_slam.py"))
        patch.setenv(logbook.VARIABLE, str(folder / "progress.json"))
        patch.setenv("EKFSLAM_CHECK_SECONDS", "200")
        patch.delenv("EKFSLAM_DATA", raising=False)
        for module in figures, widgets:
            patch.setattr(module, "display", lambda *objects, **options: None)
        without_dots(patch)
        yield patch
    sys.modules.pop("my_slam", None)


class Run:
    """A notebook that is run in one namespace, every cell once; `calls` counts those of the student's own functions.

    Answers are given by id, as functions or as text; else those of the solution are taken.
    """

    def __init__(self, number, answers=(), skip=()):
        (path,) = build.notebooks_folder().glob(f"{number}_*.ipynb")
        self.cells = json.loads(path.read_text("utf-8"))["cells"]
        self.space, self.printed = {"__name__": "__main__"}, ""
        for cell in self.cells:
            text, tags = build.source(cell), cell["metadata"].get("tags", [])
            if cell["cell_type"] != "code" or "exercise" in tags or any(word in text for word in skip):
                continue
            if "check" in tags:
                id, name = build.CHECK.search(text).groups()
                answer = dict(answers).get(id, registry.get(id).source())
                if isinstance(answer, str):
                    exec(answer, self.space)
                else:
                    self.space[name] = answer
            self.printed += self.run(text)
            if "= own(" in text:  # it has judged them, which is not the use that is counted
                self.calls = sys.modules["my_slam"].CALLS
                self.calls.clear()

    def run(self, text):
        """Run a cell; return what it prints."""
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(text, "a cell", "exec"), self.space)
        plt.close("all")
        return printed.getvalue()

    def cell(self, words):
        """The text of the code cell that begins with some words."""
        (found,) = (t for c in self.cells if c["cell_type"] == "code" for t in [build.source(c)] if t.startswith(words))
        return found

    def folded(self, words):
        """The one folded answer or debrief with some words in it."""
        texts = (build.source(c) for c in self.cells if c["cell_type"] == "markdown")
        (found,) = (t for text in texts for t in re.findall(r"<details>.*?</details>", text, re.S) if words in t)
        return found


def numbers(text):
    """All numbers of a text."""
    return [float(n) for n in re.findall(r"-?\d+\.?\d*", text)]


def rows(text):
    """The rows of the Markdown table in a text, without its head."""
    return [[c.strip() for c in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")][2:]


def notebook(number, skip=()):
    """A fixture: the notebook, run with the student's own filter; without cells that hold certain words."""

    @pytest.fixture(scope="module", name=f"nb{number}")
    def one(tmp_path_factory):
        with student(tmp_path_factory.mktemp(f"own{number}")):
            return Run(number, skip=skip)

    return one


nb08_run = notebook("08")
# Without a real log both logs are the twin: what takes long is asked of it once.
nb09_run = notebook("09", ("troubles_figure(which", "clock_figure(which", "noise_figure(which"))
nb20_run = notebook("20", ("nb20.zoo", "nb20.tests_figure"))  # of the package's filter, with bugs planted into it
YOURS = "predict (05.1), observe (05.2), correct (05.3), augment (05.4): yours, from my_slam.py"


# --- 08 ---


def test_08_runs_the_students_filter(nb08):
    assert YOURS in nb08.printed
    # 61 robots at rest and two of each drive with four landmarks, 10 or 40 steps: each step predicts the truth, too
    assert nb08.calls["augment"] > 200 and nb08.calls["predict"] > 2 * 2 * 20 * 40
    assert nb08.calls["correct"] > 60 * 100 + 4 * 20 * 40 and nb08.calls["observe"] > nb08.calls["correct"]
    assert re.findall(r"(\d) invisible directions", nb08.printed) == list("3034323")


def test_08_one_line_differs(nb08):
    before, after = (nb08.cell(words).splitlines() for words in ("R = np.diag", "def standing_fej"))
    before = before[before.index(next(line for line in before if line.startswith("def standing"))) :]
    code = [
        [line.split("  #")[0] for line in lines if '"""' not in line and "def " not in line]
        for lines in (before, after)
    ]
    gone, new = ([line for line in a if line not in b] for a, b in (code, code[::-1]))
    assert [line.strip() for line in gone if "log" not in line] == [
        "e, H = observe(x, 0)",
        "x, P = correct(x, P, y, R, e, H)",
    ]
    assert [line.strip() for line in new if "log" not in line] == ["x, P = correct_fej(x, P, y, 0, x_first, R)"]


def test_08_what_the_texts_say(nb08):
    error, sigma = nb08.space["standing"](30, 3)
    assert "to 2.3°" in nb08.folded("relative to the robot") and round(sigma[-1], 1) == 2.3
    assert "the error is 31°" in nb08.folded("relative to the robot") and round(error[-1]) == 31
    assert nb08.space["standing_fej"](30, 3)[1][-1] == pytest.approx(30, abs=0.05)
    assert "by up to 5.1 m in range" in nb08.folded("Without the robot")
    before, after = (nb08.space["move_solution"](*move, False)[2] for move in ((0, 0, 0), (3.0, 1.0, 40.0)))
    assert round(np.abs(after - before)[..., 0].max(), 1) == 5.1  # m, of a range


def test_08_the_debrief_is_measured(nb08):
    cell, table = nb08.cell("keep_robot"), rows(nb08.folded("first estimate of"))
    for (_, told), kept in zip(table, ((True, True), (False, True), (True, False), (False, False)), strict=True):
        said = nb08.run(re.sub(r"= True, True", f"= {kept[0]}, {kept[1]}", cell))
        assert numbers(said)[-1] == numbers(told)[0], (kept, said)
    assert [numbers(told)[0] for _, told in table] == [30.0, 30.0, 2.0, 2.0]


def test_08_the_joseph_form_does_not_fail(nb08):
    assert re.search(r"gain 1 % too large, float64 +100 +0\n", nb08.printed)
    assert "in 100 sequences of 100" in nb08.folded("the short form fails")


def test_08_goes_on_with_mistakes(tmp_path):
    """A kept function that is wrong is replaced, and a wrong answer is told; the notebook goes on with the others."""
    assert MISTAKE[0] in MY_SLAM

    ekf = "def correct_fej(x, P, y, i, x_first, R):\n    return correct(x, P, y, R, *observe(x, i))"
    with student(tmp_path, MY_SLAM.replace(*MISTAKE)):
        run = Run("08", {"08.2": ekf})
        assert "predict (05.1): the reference (yours in my_slam.py does not pass its check any more" in run.printed
        assert "observe (05.2), correct (05.3), augment (05.4): yours" in run.printed
        assert "[08.2] failed" in run.printed and "it is the ordinary EKF" in " ".join(run.printed.split())
        assert run.calls["predict"] == 0 and run.calls["correct"] > 6000
        assert run.space["standing_fej"](30, 3)[1][-1] == pytest.approx(30, abs=0.05)


# --- 09 ---


def test_09_runs_the_students_filter(nb09):
    assert YOURS in nb09.printed
    # a step between two pictures is made of predictions, one for each command; 30 runs of two minutes and more
    assert nb09.calls["predict"] > 30 * 120 / 0.05 and nb09.calls["augment"] > 30 * 10
    assert nb09.calls["correct"] > 30 * 800
    mine = re.findall(r"you +path (\S+) m, landmarks (\S+) m", nb09.printed)
    theirs = re.findall(r"package +path (\S+) m, landmarks (\S+) m", nb09.printed)
    assert len(mine) == len(theirs) == 1
    np.testing.assert_allclose(np.array(mine, float), np.array(theirs, float), rtol=0.1)
    assert float(mine[0][0]) < 0.05


def test_09_the_steps_are_those_of_the_package(nb09):
    """u and U from the student's predict, command by command, and from the package, all at once."""
    from ekfslam_tutorial.datasets.mrclam import ODOMETRY_NOISE
    from ekfslam_tutorial.datasets.odometry import steps

    commands, times = nb09.space["moves"]["simulated twin"], np.unique(nb09.space["logs"]["simulated twin"][1][0])[:300]
    u, U = steps(*commands.T, times, ODOMETRY_NOISE)
    for k in range(1, 300):
        mine = nb09.space["step"](commands, times[k - 1], times[k], nb09.space["tuned"])
        np.testing.assert_allclose(mine[0], u[k], atol=0.003)  # straight pieces, in their first or middle direction
        np.testing.assert_allclose(mine[1], U[k], atol=2e-4)


def test_09_the_calibration_finds_the_truth_of_the_twin(nb09):
    from ekfslam_tutorial.datasets import mrclam_twin as twin

    _, scale, delay = nb09.space["fits"]["simulated twin"]
    assert scale == pytest.approx(twin.TURN_SCALE) and delay == pytest.approx(twin.DELAY_TICKS * twin.TICK)


def test_09_the_clock_is_proved(nb09):
    found = re.findall(r"put in (\S+) s, found (\S+) s", nb09.printed)
    assert len(found) == 4 and all(put == back for put, back in found)
    assert "best offset 0.2 s" in nb09.printed


def test_09_what_the_texts_say(nb09):
    space, twin = nb09.space, "simulated twin"
    curves = space["curves"](twin, *space["clock_runs"](twin, space["offsets"]))
    turns, straight = curves["in turns"], curves["between turns"]
    right, too_far = list(space["offsets"]).index(0.2), list(space["offsets"]).index(0.4)
    told = numbers(nb09.folded("A robot that stands still"))
    for value in turns[right], turns[too_far], straight[right], straight[too_far]:
        assert round(value, 1) in told
    assert max(space["flat"]) < 2 and min(space["flat"]) == space["flat"][right]
    rows_of, sightings = space["twin"].odometry, space["twin"].sightings
    told = nb09.folded("is what you must be ready for")
    subjects = dict(zip(*space["twin"].barcodes.T[::-1], strict=True))
    seen = [subjects.get(int(code), 0) for code in sightings[:, 1]]
    assert f"{seen.count(0)} sightings with a barcode in no list" in told
    assert f"{sum(0 < s <= 5 for s in seen)} of other robots" in told
    assert f"up to {np.diff(np.sort(rows_of[:, 0])).max():.2f} s" in told
    nis, nees = space["tuning"](twin)
    quarter = space["factors"].index(0.25)
    assert f"its NIS is {nis[quarter]:.1f} and its NEES {nees[quarter]:.1f}" in nb09.folded(
        "The noise of the twin is white"
    )


def test_09_the_debrief_is_measured(nb09):
    cell, folded = nb09.cell("shift = 0.5"), nb09.folded("clock wrong by")
    for wrong, *told in rows(folded):
        said = nb09.run(cell.replace("shift = 0.5", f"shift = {numbers(wrong)[0]}")).splitlines()[-1]
        assert numbers(said)[1:] == [numbers(t)[0] for t in told], said
    honest = nb09.run(cell.replace("ids, ys))", "ids, ys), good_odometry, good_camera)")).splitlines()
    before, after = (numbers(line)[-1] for line in honest)
    assert f"from {before:.1f} to {after:.1f}" in folded


def test_09_goes_on_with_mistakes(tmp_path):
    """Wrong answers to all four exercises, and a kept prediction that is wrong."""
    answers = {
        "09.1": lambda rows: (rows, 0, 1.0),
        "09.2": lambda rows, table, robots: (rows[:, 0], rows[:, 1], rows[:, 2:]),
        "09.3": lambda offsets, z, Z: (offsets[0], np.zeros(len(offsets))),
        "09.4": lambda path, truth: (path, np.sqrt(np.mean((np.subtract(path, truth) ** 2).sum(1)))),
    }
    skip = "explore(", "clock_runs(TWIN", "clock_runs(which", "tuning(which)", "tuning(TWIN)"  # what takes long
    with student(tmp_path, MY_SLAM.replace(*MISTAKE)):
        run = Run("09", answers, skip)
        assert "predict (05.1): the reference (yours in my_slam.py does not pass its check any more" in run.printed
        assert all(f"[{id}] failed" in run.printed for id in answers)
        assert run.calls["predict"] == 0 and run.calls["correct"] > 2000
        assert "ATE 0.038 m; of the path moved by 54 m" in run.printed


def test_09_on_the_real_log(tmp_path, data_dir):
    """The answers about the real log, where there is one."""
    with student(tmp_path) as patch:  # what is patched last is restored first
        patch.setenv("EKFSLAM_DATA", str(data_dir))
        run = Run("09", skip=("explore(", "clock_figure", "for error in", "noise_figure(TWIN", "troubles_figure("))
        space = run.space
        if space["which"] == "simulated twin":
            pytest.skip("no set of MRCLAM is below EKFSLAM_DATA")
        nis, nees = space["tuning"](space["which"])
        told = run.folded("on the real log. With")
        assert f"the mean NIS is {nis[1]:.1f}" in told and f"goes from {nees[3]:.0f} to {nees[1]:.0f}" in told
        assert run.printed.count("path 0.1") == 2  # yours and the package's


# --- 20 ---


def test_20_plants_bugs_into_the_students_filter(nb20):
    assert YOURS in nb20.printed
    # five filters of 20 runs and one of 5, 251 frames; the late Jacobian predicts twice
    assert nb20.calls["predict"] > (5 * 20 + 20) * 251 and nb20.calls["augment"] > 105 * 12
    assert nb20.calls["correct"] > 5 * 20 * 500


def test_20_the_world_is_that_of_the_museum(nb20):
    world = museum_runs.world()
    np.testing.assert_array_equal(nb20.space["LANDMARKS"], world.points)
    np.testing.assert_allclose(nb20.space["STEP"], world.step)
    np.testing.assert_allclose(nb20.space["U"], world.U)
    np.testing.assert_allclose(nb20.space["R"], world.sensor.R)
    assert world.frames == 251


@pytest.mark.parametrize(
    ("mine", "key", "part"),
    [
        ("late", "late", "predict"),
        ("predict_pose_only", "pose_only", "predict"),
        ("pose_known", "mapping", "augment"),
        ("observe_over_q", "over_q", "observe"),
    ],
)
def test_20_the_planted_bugs_are_the_exhibits(nb20, mine, key, part):
    """Called alone, the student's mutant and the museum's give the same."""
    x, P, u, U = museum_runs.mutant_case()
    args = {"predict": (x, P, u, U), "augment": (x, P, np.array([4.0, -2.9]), np.diag([0.02, 0.003])),
            "observe": (x, slice(5, 7))}[part]  # fmt: skip
    theirs = getattr(museum_runs.museum.mutant(key), part)(*args)
    for a, b in zip(nb20.space[mine](*args), theirs, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_20_the_parts_are_judged_alone(nb20):
    space = nb20.space
    said = next(build.source(c) for c in nb20.cells if "Each bug of an initialisation" in build.source(c))
    found = {
        name: [space["first_sight"](space[name], *poses) for poses in (space["known"], space["lost"])]
        for name in ("augment", "pose_known", "used_twice")
    }
    (low, high), (least, most) = anees_band(2, 400, 0.999), anees_band(1, 400, 0.999)
    assert f"between {low:.1f} and {high:.1f} (heading: {least:.1f} to {most:.1f})" in said
    honest = lambda nees: low < nees < high
    assert [list(map(honest, pair)) for pair in found.values()] == [[True, True], [True, False], [False, True]]
    assert f"({found['pose_known'][1]:.1f})" in said and f"({found['used_twice'][0]:.1f})" in said
    for f in space["predict"], space["late"]:
        position, heading = space["sensor_covered"](*space["half_a_round"](f))
        assert honest(position) and least < heading < most


def test_20_what_the_texts_say(nb20):
    planted = {name: (nees.mean(), nis.mean(), nis.size) for name, (_, nees, nis, _) in nb20.space["planted"].items()}
    text = next(build.source(c) for c in nb20.cells if "No statistic of 20 runs sees these two" in build.source(c))
    low, high = anees_band(2, planted["used twice"][2], 0.999)
    assert f"between {low:.2f} and {high:.2f}" in text and f"{planted['new: pose as if known'][1]:.2f}" in text
    low, high = anees_band(3, 20, 0.99)
    assert f"between {low:.1f} and {high:.1f}" in text
    assert f"its NEES is {planted['new: pose as if known'][0]:.0f}, honest is 3" in text
    assert f"NEES {planted['late Jacobian'][0]:.1f} and {planted['used twice'][0]:.1f}" in text
    assert f"yours: {planted['your filter'][0]:.1f};" in text
    for name in "your filter", "late Jacobian", "used twice":
        assert low < planted[name][0] < high
    assert re.search(r"predict  largest difference \S+e-\d\d\nlate     largest difference 2", nb20.printed)


def test_20_the_debrief_is_measured(nb20):
    said, folded = nb20.run(nb20.cell("def observe_sharp")), nb20.folded("where your filter has")
    rmse, nees, _, nis, _ = numbers(said.splitlines()[0])
    assert f"RMSE {rmse:.2f} m, where your filter has {nb20.space['yours'][0]:.2f}" in folded
    assert f"The NEES, {nees:.1f}," in folded and f"The NIS is {nis:.2f}," in folded
    assert nees < anees_band(3, 20, 0.99)[1] and nis < anees_band(2, nb20.space["yours"][2].size, 0.999)[0]
    assert "H agrees with finite differences: False" in said
