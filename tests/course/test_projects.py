"""Projects: right runs of all kinds pass, wrong ones are told what went wrong, and the reference is never judged."""

import copy
import json
import time
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.cli import main as ekfslam
from ekfslam_tutorial.course import check, experiment, hint, logbook, nbgrader, registry, reveal
from ekfslam_tutorial.course.project import Project, Run
from ekfslam_tutorial.toolbox import UserData

IDS = ("13.project", "14.project", "15.project")
EYE = registry.get("13.project")
SEEDS = (201, 202)  # of the quick checks: other ones than those of the package


def quick(id, seeds=SEEDS):
    """A project whose check has three runs instead of seven, or fewer."""
    project = copy.copy(registry.get(id))
    project.seeds = seeds
    return project


def edited(project, *edits):
    """The loop of the reference with pieces of its text replaced: what a student may write."""
    text = project.texts()[-1]
    for old, new in edits:
        assert text.count(old) >= 1, f"no {old!r} in the loop of {project.id}"
        text = text.replace(old, new)
    space = {**project.loop.__globals__, "time": time}
    exec(compile(text, "<student>", "exec"), space)
    return space["loop"]


def judged(id, *edits, scenario=None, seeds=SEEDS):
    """The verdict on a run of an edited loop. Without an edit it is the reference's, which need not run once more."""
    project = quick(id, seeds)
    run = project.run(scenario or project.scenario, edited(project, *edits))
    if not edits and not run.failed:
        project._kept = project._kept | {run.scenario: run.trial}
    return project.judge(run)


@pytest.fixture
def student():
    """A namespace like that of the notebook of project 13."""
    space = {name: value for name, value in EYE.loop.__globals__.items() if name not in ("loop", "project")}
    return space | {"experiment": experiment}


def run_cell(text, space):
    exec(compile(text, "<cell>", "exec"), space)
    return space["run"]


# --- the project as a part of the course ---


@pytest.mark.parametrize("id", IDS)
def test_the_solution_passes_with_the_seeds_of_the_package(id, capsys):
    project = registry.get(id)
    run = project.run(project.scenario, project.loop)
    project._kept[run.scenario] = run.trial  # it is a run of the reference: that need not run once more
    verdict = check(id, run)
    assert verdict.passed and "mean NEES" in verdict.note
    assert capsys.readouterr().out.startswith(f"[{id}] passed")


@pytest.mark.parametrize("id", IDS)
def test_a_project_has_what_it_needs(id):
    project = registry.get(id)
    assert isinstance(project, Project) and len(project.hints) == 2 and all(len(h) > 100 for h in project.hints)
    assert project.band[0] < 6 < project.band[1]
    assert "raise NotImplementedError" in project.stub() and project.stub().endswith(project._last_line)
    assert project.source().endswith(project._last_line) and project.loop.__doc__ in project.stub()
    lines = project.texts()[-1].split('"""')[-1].strip().splitlines()
    assert len(lines) <= 45
    with pytest.raises(Exception, match="not the one of the task"):  # what is missing in the text is asked for
        project.read(project.start)


def test_the_reference_knows_that_it_is_one(student, own_progress, capsys):
    run = run_cell(EYE.stub(), student)
    assert run.reference and run.trial.failed is None
    for _ in range(2):
        assert check("13.project", run).status == "not attempted"
    assert "not written yet" in capsys.readouterr().out
    assert not own_progress.exists()
    assert EYE.judge(EYE.reference).status == "not attempted"


def test_a_lecturer_reads_the_verdict(student, capsys, monkeypatch):
    monkeypatch.setattr(EYE, "seeds", SEEDS)
    run = run_cell(EYE.source().replace("< 9", "< 0"), student)
    assert check("13.project", run).status == "failed"
    ekfslam(["progress", "13"])
    told = " ".join(capsys.readouterr().out.split())
    assert "tried once" in told and "failed 'corrections': the robots are off by" in told
    assert check("13.project", run_cell(EYE.source(), student)).passed
    ekfslam(["progress", "13"])
    lines = capsys.readouterr().out.splitlines()
    assert len({line.index(registry.get(line.split()[0]).title) for line in lines if line[2:4] == "13"}) == 1  # columns
    told = " ".join(" ".join(lines).split())
    assert "13.project passed" in told and "3 runs of 120 frames: mean NEES" in told and "s for a run" in told
    record = logbook.read()["13.project"]
    assert record["tries"] == 2 and record["passed"]
    check("13.project", EYE.run("seed = = 1", EYE.loop))
    capsys.readouterr()
    ekfslam(["progress", "13"])
    told = " ".join(capsys.readouterr().out.split())
    assert "3 runs of 120 frames: mean NEES" in told and "last try: failed 'scenario'" in told


def test_hints_and_reveal(capsys):
    hint("13.project")
    hint("13.project")
    reveal("13.project")
    told = capsys.readouterr().out
    assert "hint 1 of 2" in told and "hint 2 of 2" in told and "def loop(world):" in told


@pytest.mark.parametrize("wrong", [42, "a text", lambda world: None])
def test_what_is_no_run_is_refused(wrong):
    verdict = EYE.judge(wrong)
    assert verdict.status == "failed" and "run" in verdict.hint


def test_a_run_of_another_project_is_refused():
    other = registry.get("14.project")
    run = Run(other, other.scenario, other.loop)
    assert "a run of 14.project" in EYE.judge(run).message


def test_nothing_and_dots_are_not_attempted():
    assert EYE.judge(None).status == EYE.judge(...).status == "not attempted"


def test_experiment_refuses_an_exercise():
    with pytest.raises(ValueError, match="not a project"):
        experiment("13.1", "", None)


@pytest.mark.parametrize("id", IDS)
def test_the_answer_for_nbgrader_runs_and_its_students_version_is_the_stub(id):
    text = nbgrader.with_solution(registry.get(id))
    begin, end = nbgrader.SOLUTION
    head, _, rest = text.partition(f"    {begin}")
    tail = rest.partition(f"    {end}")[2]
    assert f"{head}    raise NotImplementedError  # your code here{tail}" == registry.get(id).stub()
    space = dict(registry.get(id).loop.__globals__) | {"experiment": experiment}
    assert not run_cell(text, space).reference and space["run"].failed is None


def test_nbgrader_gives_the_point_for_a_run_of_ones_own_only(student, monkeypatch):
    monkeypatch.setattr(EYE, "seeds", SEEDS)
    links = nbgrader.links(EYE)
    with pytest.raises(AssertionError, match="not attempted"):
        nbgrader.graded("13.project", EYE.reference, links).award()
    nbgrader.graded("13.project", run_cell(EYE.source(), student), links).award()


# --- the scenario ---

SCENARIOS = {
    "a slip of the keyboard": (("[[sensor]]", "[[senor]]"), "did you mean 'sensor'"),
    "no TOML": (("seed = 1", "seed = = 1"), "this is not TOML"),
    "a number that is none": (("dx_std = 0.005", 'dx_std = "small"'), "dx_std"),
    "another sensor": (('"pin_hole"', '"pin_hole_depth"'), "asks for [pin_hole]"),
    "other landmarks": (('"idp_pnt"', '"ahm_pnt"'), "asks for idp_pnt"),
    "too short": (("last = 120", "last = 12"), "the run has 12 frames"),
    "no noise": (("dx_std = 0.005", "dx_std = 0.0"), "robot 1 has dx_std = 0, the task asks for 0.002 or more"),
    "perfect pixels": (("pixel_std = 1.0", "pixel_std = 0.01"), "0.01 px"),
    "a small world": (('"cloister"}', '"random3", n = 9}'), "the world has 9 landmarks, the task asks for 20"),
    "a world that cannot be": (('"cloister"}', '"cloister", n = 2}'), "a cloister needs at least 4 columns"),
    "a known pose": (("[[robot]]", "[[robot]]\nin_map = false"), "its pose is to be estimated"),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_wrong_scenario_is_told_in_a_sentence(name):
    edit, says = SCENARIOS[name]
    run = EYE.run(EYE.scenario.replace(*edit), EYE.loop)
    verdict = EYE.judge(run)
    assert verdict.link == "scenario" and says in verdict.message, verdict.message


OTHERS = {  # project, edits, what is told; the last two say the same as the task in other words
    "another robot has the depth camera": (
        "14",
        ['robot = 2\ntype = "pin', 'robot = 1\ntype = "pin'],
        "one more pin_hole_depth",
    ),
    "a start in radians": ("14", ["[0, 0, 180]", "[0, 0, 3.14159]"], "robot 2 starts at position = [0.0, 5.0, 0.0]"),
    "a camera that looks up": ("14", ["orientation_deg = [-90, 0, -90]\n", ""], "the pin_hole on robot 1 is at"),
    "a camera to the left": ("15", ["-0.25", "0.25"], "in the task at position = [0.0, -0.25, 0.6]"),
    "screws of which nothing is said": ("15", ["orientation_std_deg = 2.0\n", ""], "orientation_std_deg = 0, the task"),
    "screws in radians": ("15", ["std_deg = 2.0", "std = 2.0"], "write orientation_std_deg = 2.0 for degrees"),
    "a laser in radians": ("19", ["bearing_std_deg", "bearing_std"], "the laser has bearing_std_deg = 40.1"),
    "other steps": ("14", ["dx = [0.06", "dx = [0.08"], "robot 2 drives with dx = [0.08, 0.0, 0.0]"),
    "as the task, turned to the right": ("14", ["[0, 0, 180]", "[0, 0, -180]"], None),
    "as the task, in radians": ("15", ["std_deg = 2.0", "std = 0.0349"], None),
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_scenario_of_another_task_is_refused(name):
    number, edit, says = OTHERS[name]
    project = registry.get(f"{number}.project")
    assert edit[0] in project.scenario
    told = project.run(project.scenario.replace(*edit), lambda world: None).failed
    assert told is not None  # a loop that gives nothing back
    assert (says or "your loop returns") in str(told)


def test_the_camera_that_is_calibrated_comes_first():
    """The other one would start all landmarks of the two, and nobody would see a birth without its mounting."""
    project = registry.get("15.project")
    head, calibrated, known, *rest = project.scenario.split("[[sensor]]")
    before, after = known.split("\n\n", 1)
    swapped = "[[sensor]]".join([head, before + "\n\n", calibrated.rstrip() + "\n\n" + after, *rest])
    assert "is not the first sensor" in str(project.run(swapped, project.loop).failed)


@pytest.mark.parametrize("used", [10, 1])
def test_what_is_said_of_a_run_that_is_not_whole(used, capsys):
    """A scenario that is refused, a loop that breaks, and a result that is none after the last frame."""
    experiment("13.project", EYE.scenario.replace("last = 120", "last = 12"), EYE.loop)
    assert "The run has not begun: the scenario" in capsys.readouterr().out
    at = f"        if now.k == {used + 1}: lmks = None\n        yield x, P, lmks"
    experiment("13.project", EYE.scenario, edited(EYE, ("        yield x, P, lmks", at)))
    told = " ".join(capsys.readouterr().out.split())
    assert "The run ended early: lmks after frame" in told
    assert told.endswith(f"a run that ended early, after {used} frame{'s' * (used > 1)}.")


def test_a_sigma_near_that_of_the_reference_is_no_fault_in_a_small_map():
    """Inverse depths that become points claim more: right loops have 0.94 in 200 frames, so the limit is 0.92."""
    project = registry.get("14.project")
    (claimed,) = (s for s in project.symptoms if s.name == "no more is claimed than can be known")
    assert [claimed.shows(SimpleNamespace(claim=claim), project) for claim in (0.90, 0.938)] == [True, False]
    assert "0.918 times" in claimed.says.format(s=SimpleNamespace(claim=0.9182), p=project)


def test_a_sensor_taken_for_another_and_a_mounting_that_is_none_are_told():
    """So is the line of a list in brackets."""
    base = registry.get("15.project")
    mix = (
        ("sen.model.residual(y, e)", "[y - e for _ in range(1)][0]"),
        ("observe(F, S, sen.model", "observe(F, S, world.sens[2].model"),
    )
    failed = base.run(base.scenario, edited(base, *mix)).failed
    assert "world.sens[id - 1]" in failed.hint and ", in line " in str(failed)
    failed = base.run(base.scenario, edited(base, ("sen.x if sen.r is None else x[sen.r]", "sen.x"))).failed
    assert "x[sen.r]" in failed.hint


def test_the_scenario_must_be_a_text():
    assert "a text in TOML, got UserData" in EYE.judge(EYE.run(UserData.from_text(EYE.scenario), EYE.loop)).message


# --- loops that break ---

BREAKS = {
    "an exception": (("H = np.zeros((2, len(x)))", "H = np.zeros((2, 5))"), "your loop raised"),
    "a name": (("Z, z = H", "Z, z = G"), "NameError"),
    "no yield": (("        yield x, P, lmks", "        pass\n    return x, P, lmks"), "your loop returns tuple"),
    "yield after the loop": (("        yield x, P, lmks", "        pass\n    yield x, P, lmks"), "has yielded 1 times"),
    "return after a frame": (("yield x, P, lmks", "yield x, P, lmks\n        return"), "has yielded 1 times when 1 of"),
    "two results": (("yield x, P, lmks", "yield x, P"), "must return 3 results"),
    "P of another size": (("yield x, P, lmks", "yield x, P[:3, :3], lmks"), "P after frame 1 has shape (3, 3)"),
    "no numbers": (("yield x, P, lmks", "yield x * np.nan, P, lmks"), "NaN"),
    "not symmetric": (
        ("yield x, P, lmks", "P[0, 1] += 0.01\n        yield x, P, lmks"),
        "not symmetric",
    ),
    "ranges that overlap": (
        ("lmks |= {i: slice(s.start - 3, s.stop - 3) for i, s in lmks.items() if s.start > r.start}", "break"),
        "lmks[",
    ),
    "a list of landmarks": (("yield x, P, lmks", "yield x, P, list(lmks)"), "must be a dictionary"),
}


@pytest.mark.parametrize("name", BREAKS)
def test_a_loop_that_breaks_is_told_where(name):
    edit, says = BREAKS[name]
    verdict = judged("13.project", edit)
    assert verdict.link == "loop" and says in verdict.message, verdict.message


def test_a_loop_that_is_too_slow_is_stopped(monkeypatch):
    monkeypatch.delenv("EKFSLAM_CHECK_SECONDS")
    project = quick("13.project")
    project.seconds = 1.0
    turns = []
    slow = edited(project, ("        for id, y in", "        turns.append(time.sleep(0.2))\n        for id, y in"))
    slow.__globals__["turns"] = turns
    run = project.run(project.scenario, slow)
    assert 0 < len(turns) < 120  # frames: it came to some of them
    assert "took more than 1 s" in project.judge(run).message


def test_a_loop_that_hangs_is_stopped(monkeypatch):
    monkeypatch.delenv("EKFSLAM_CHECK_SECONDS")
    project = quick("13.project")
    project.seconds = 1.0
    run = project.run(
        project.scenario, edited(project, ("        for id, y in", "        while True: pass\n        for id, y in"))
    )
    assert "was stopped" in project.judge(run).message


# --- runs that are wrong: name: (project, edits, what is told, a word of the hint) ---

NOISE = "X_u @ now.U[1] @ X_u.T"
BIRTH = ("            else:\n                F, F_r", "            if id not in lmks:\n                F, F_r")
TWICE = ("            if id in lmks:\n", "            for _ in range(2 * (id in lmks)):\n")
WRONG = {
    "no noise of the motion": ("13", [(NOISE, "0.0")], "the noise of the motion", "X_u U X_u'"),
    "noise 25 times too small": ("13", [(NOISE, NOISE + " / 25")], "honest", "oise in the filter"),
    "noise 4 times too large": ("13", [(NOISE, "4 * " + NOISE)], "all is used", "both counted once"),
    "births without cross-covariance": ("13", [("P_lx = new_idp", "P_lx = 0 * new_idp")], "honest", "cross-covariance"),
    "births in the first frame only": ("13", [("else:", "elif now.k == 1:")], "the map", "Births fail"),
    "no correction passes": ("13", [("< 9", "< 0")], "corrections", "no correction"),
    "x corrected, P not": (
        "13",
        [("x, P = x + K @ z, P - K @ Z @ K.T", "x = x + K @ z")],
        "the covariance is corrected",
        "P - K Z K'",
    ),
    "P corrected, x not": (
        "13",
        [("x, P = x + K @ z, P - K @ Z @ K.T", "P = P - K @ Z @ K.T")],
        "the mean is corrected",
        "x + K z",
    ),
    "the innovation has the wrong sign": ("13", [("y - e", "e - y")], "better than nothing", "sign of the innovation"),
    "R too small": ("13", [("+ camera.R, y", "+ camera.R / 25, y")], "honest", "or R"),
    "R too large": ("13", [("+ camera.R, y", "+ 100 * camera.R, y")], "all is used", "Is R that of the sensor"),
    "the mounting is left out": (
        "13",
        [("observe(Frame3(x[:7]), mount", "observe(Frame3(x[:7]), Frame3(np.eye(7)[3])")],
        "better than nothing",
        "mounting",
    ),
    "H without the robot": (
        "13",
        [("H[:, :7], H[:, r] = E_r, E_l", "H[:, r] = E_l")],
        "honest",
        "Jacobian",
    ),
    "X_x is the identity": (
        "13",
        [("new, X_x, X_u @", "new, np.eye(7), X_u @")],
        "no more is claimed than can be known",
        "X_x",
    ),
    "each pixel corrects twice": (
        "13",
        [BIRTH, TWICE],
        None,  # a mean NEES at the edge of the band, or a sigma that nobody can have: the hint is the same
        "twice",
    ),
    "points of three numbers at once": ("13", [("place) < 0.1", "place) < 1000")], "honest", "becomes too sure"),
    "a map that only grows": ("14", [("now.k - 5", "now.k - 500"), ("150", "300")], "the room", "find_range"),
    "nobody leaves": ("14", [("now.k - 5", "now.k - 500")], "who leaves", "odometry alone"),
    "one robot is not corrected": (
        "14",
        [("if z @ np.linalg.solve(Z, z) < 9", "if rob.id == 1 and z @ np.linalg.solve(Z, z) < 9")],
        "all is used",
        "corrected in every frame",
    ),
    "known landmarks are started again": (
        "14",
        [("np.array(list(lmks), int), 10", "np.zeros(0, int), 10")],
        "the map",
        "started again",
    ),
    "the mounting is no block": (
        "15",
        [(", (sen.r, E_s)", "")],
        None,  # a run may be worse than nothing
        "ounting",
    ),
    "births without the mounting": (
        "15",
        [("(0 if sen.r is None else L_s @ P[sen.r])", "0"), ("(0 if sen.r is None else P_lx[:, sen.r] @ L_s.T)", "0")],
        "the mounting is honest",
        "L_s in the births",
    ),
    "both robots make the steps of the first": (
        "14",
        [("now.u[rob.id]", "now.u[1]")],
        None,  # worse than nothing, or too sure: the hint is the same
        "ontrol of another robot",
    ),
}  # fmt: skip


FAINT = {"x corrected, P not"}  # it shows in three runs; the others show in two


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_run_is_told_what_went_wrong(name):
    number, edits, link, word = WRONG[name]
    verdict = judged(f"{number}.project", *edits, seeds=SEEDS if name in FAINT else SEEDS[:1])
    assert verdict.status == "failed", verdict.note
    assert link is None or verdict.link == link, f"{verdict.link}: {verdict.message}"
    assert word in verdict.hint, verdict.hint


# --- runs that are right, other than the reference ---

RIGHT = {
    "no conversion": ("13", [("place) < 0.1", "place) < 0")], ()),
    "a narrower gate": ("13", [("< 9", "< 7.4")], ()),
    "no gate": ("13", [("< 9", "< 1e9")], ()),
    "Joseph's form": (
        "13",
        [
            (
                "x, P = x + K @ z, P - K @ Z @ K.T",
                "J = np.eye(len(x)) - K @ H\n                    x, P = x + K @ z, J @ P @ J.T + K @ camera.R @ K.T",
            )
        ],
        (),
    ),
    "quaternion not normalised": ("13", [("x, P = change(x, P, slice(0, 7), F.x, F_x)", "pass")], ()),
    "three births in a frame": (
        "13",
        [("            else:", "            elif sum(r.stop - r.start == 6 for r in lmks.values()) < 12:")],
        (),
    ),
    "another prior": ("13", [], [("0.25", "0.1"), ("0.125", "0.2")]),
    "better odometry": ("13", [], [("da_std_deg = 0.3", "da_std_deg = 0.15")]),
    "worse odometry": ("13", [], [("da_std_deg = 0.3", "da_std_deg = 0.5")]),
    "blurred pixels": ("13", [], [("pixel_std = 1.0", "pixel_std = 2.0")]),
    "half the way": ("13", [], [("last = 120", "last = 60")]),
    "an uncertain start": ("13", [], [("dx = [", "position_std = 0.1\ndx = [")]),
    "seed 7": ("13", [], [("seed = 1", "seed = 7")]),
    "landmarks stay longer": ("14", [("now.k - 5", "now.k - 8")], ()),
    "five births in a frame": ("14", [("np.array(list(lmks), int), 10", "np.array(list(lmks), int), 5")], ()),
    "seed 3 of 14": ("14", [], [("seed = 1", "seed = 3")]),
    "better screws": ("15", [], [("orientation_std_deg = 2.0", "orientation_std_deg = 1.0")]),
    "seed 5 of 15": ("15", [], [("seed = 2", "seed = 5")]),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_run_passes(name):
    number, edits, changes = RIGHT[name]
    scenario = registry.get(f"{number}.project").scenario
    for old, new in changes:
        assert old in scenario
        scenario = scenario.replace(old, new)
    verdict = judged(f"{number}.project", *edits, scenario=scenario, seeds=SEEDS[:1])
    assert verdict.passed, f"{verdict.link}: {verdict.message}; {verdict.note}"


# --- nothing that a student says of the run is believed ---


def test_the_loop_gets_no_truth():
    seen = []

    def loop(world):
        for now in world:
            seen.append(now)
            yield world.x, world.P, {}

    EYE.run(EYE.scenario, loop)
    assert set(vars(seen[0])) == {"k", "t", "dt", "u", "U", "seen", "met", "image"} and seen[0].image == {}


def test_an_estimate_is_copied():
    """One array that goes on changing is not the history of the run."""
    kept = EYE.run(EYE.scenario, EYE.loop).trial
    x = edited(EYE, ("yield x, P, lmks", "yield x, P, lmks\n        x[:3] = 1e3"))
    assert np.array(EYE.run(EYE.scenario, x).trial.errors[1])[0, 0] == np.array(kept.errors[1])[0, 0]


def test_the_notebooks_show_the_tool_that_the_references_use():
    """`change` stands in the notebooks, and is that of the package."""
    import inspect

    from ekfslam_tutorial.course import build
    from ekfslam_tutorial.course.projects.nb13 import change

    text = inspect.getsource(change).strip()
    for number in ("13", "14", "15"):
        notebook = json.loads(nbgrader.find(number).read_text(encoding="utf-8"))
        assert any(build.source(cell).strip() == text for cell in notebook["cells"]), number
