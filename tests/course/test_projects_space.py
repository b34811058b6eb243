"""Projects 17, 18 and 19: right runs with other settings pass, wrong ones are told what is wrong with them.

Wrong loops are the reference's with one place written otherwise.
"""

import inspect
import pickle
import textwrap
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial.course import check, experiment, registry
from ekfslam_tutorial.course.projects import nb17, nb18, nb19

MODULES = {"17": nb17, "18": nb18, "19": nb19}
FRAMES = {"17": ("last = 60", "last = 50"), "18": ("last = 900", "last = 600"), "19": ("last = 600", "last = 300")}


@pytest.fixture(scope="module", autouse=True)
def without_real_logs():
    """Project 19 takes the real log where there is one: here it takes the twin, of which the truth is known."""
    forget = lambda: [cached.cache_clear() for cached in (nb19.log, nb19.by_the_package)]
    forget()
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("EKFSLAM_DATA", raising=False)
        patch.setattr(nb19, "here", lambda: nb19.TWIN)
        yield
    forget()


@pytest.fixture(scope="module", autouse=True)
def each_run_once():
    """Project 17 makes the runs of a scenario by the package, beside those of the student's loop: the same ones.

    Here a run of a scenario with a seed is made once, whoever asks for it; of its frames is kept what is measured.
    """
    runs, run = {}, nb17.universal_slam

    def once(data, seed):
        key = pickle.dumps(data), seed
        if key not in runs:
            runs[key] = list(map(seen, run(data, seed=seed)))
        return iter(runs[key])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(nb17, "universal_slam", once)
        yield


def seen(now):
    """What stays of a frame: its robots, their poses and the size of the map, copied, for the run goes on."""
    robs = [SimpleNamespace(id=r.id, r=r.r, motion=r.motion, u=np.array(r.u), U=np.array(r.U)) for r in now.robs]
    map = SimpleNamespace(x=now.map.x.copy(), P=now.map.P.copy(), n_used=now.map.n_used)
    truth = {id: np.array(pose) for id, pose in now.truth.items()}
    return SimpleNamespace(robs=robs, map=map, truth=truth, t=now.t, dt=now.dt, lmks=dict(now.lmks))


def edited(text, *edits):
    """The text with some places written otherwise; each place must be there once."""
    for old, new in edits:
        assert text.count(old) == 1, f"{old!r} is there {text.count(old)} times"
        text = text.replace(old, new)
    return text


def verdict(number, scenario=(), loop=(), start=False):
    """The verdict on a run of the reference with edits in its scenario and in its loop."""
    module = MODULES[number]
    text = edited(textwrap.dedent(inspect.getsource(module.loop)), *loop)
    space = dict(vars(module))
    exec(compile(text, "the student's cell", "exec"), space)
    scenario = edited(module.START if start else edited(module.SCENARIO, FRAMES[number]), *scenario)
    run = module.project.run(scenario, space["loop"])
    if number == "18" and not loop and not run.failed:
        module.project._kept[scenario] = run.trial  # it is a run of the reference: that need not run once more
    return module.project.judge(run)


def everywhere(module, old, new):
    """The edit of a scenario that changes a word in all its lines."""
    text = edited(module.SCENARIO, FRAMES["18"]) if module is nb18 else module.SCENARIO
    return (text, text.replace(old, new))


NOISE = "range_std=0.15, bearing_std_deg=1.0"

RIGHT = {
    "17 as it is": ("17", (), ()),
    "17 a coarser depth": ("17", [("depth_std = 0.1", "depth_std = 0.3")], ()),
    "17 all measurements are used": ("17", [(", n_updates = 10", "")], ()),
    "18 as it is": ("18", (), ()),
    "18 a finer sensor": ("18", [everywhere(nb18, NOISE, "range_std=0.1, bearing_std_deg=0.7")], ()),
    "18 a coarser sensor": ("18", [everywhere(nb18, NOISE, "range_std=0.3, bearing_std_deg=2.0")], ()),
    "19 as it is": ("19", (), ()),
    "19 a finer laser": ("19", [("range_std = 0.15", "range_std = 0.08"), ("deg = 0.7", "deg = 0.4")], ()),
    "19 wider gates": ("19", (), [("9.2, 25.0", "18.0, 30.0")]),
}


@pytest.mark.parametrize(("number", "scenario", "loop"), RIGHT.values(), ids=RIGHT)
def test_a_right_run_passes(number, scenario, loop):
    found = verdict(number, scenario, loop)
    assert found.passed, f"{found.link}: {found.message}"
    assert found.note  # the numbers of the run, for the progress


MET = "            for id, y in now.met[sen.id]:\n                x, P = correct(x, P, a, at[id], y, R)\n"
TAKEN_AS_NEWS = (
    "            for id, y in now.met[sen.id]:\n"
    "                b = at[id]\n"
    "                e, E_a, E_b = meet(x[a], x[b])\n"
    "                z = np.array([y[0] - e[0], wrap(y[1] - e[1])])\n"
    "                T = R + E_b @ P[b, b] @ E_b.T\n"
    "                if z @ np.linalg.solve(T + E_a @ P[a, a] @ E_a.T, z) < 13.8:\n"
    "                    x, P = correct_both(x, P, a, b, z, E_a, 0 * E_b, T)\n"
)
Z18 = "z = y - e\n        z[1] = wrap(z[1])"

WRONG = {  # number, edits of the scenario, of the loop; the link, and a word of the hint
    "17 one seed for all": (
        "17",
        (),
        [("universal_slam(data, seed=seed):", "universal_slam(data, seed=seeds[0]):")],
        "the measure",
        "own seed",
    ),
    "17 NEES / 6": ("17", (), [("true[None]))", "true[None]) / 6)")], "the measure", "pose_nees"),
    "17 another band": (
        "17",
        (),
        [("in_band(np.array(nees), 6)", "in_band(np.array(nees), 7)")],
        "the band",
        "in_band",
    ),
    "17 better odometry along the way": ("17", [("dx_std = 0.01", "dx_std = 0.002")], (), "scenario", "task"),
    "17 no corrections": ("17", [("n_updates = 10", "n_updates = 0")], (), "a map", "useless"),
    "17 better odometry": ("17", [("da_std_deg = 0.1", "da_std_deg = 0.01")], (), "scenario", "task"),
    "18 no sightings of robots": ("18", (), [(MET, "")], "robots see robots", "not used"),
    "18 taken as news": ("18", (), [(MET, TAKEN_AS_NEWS)], "robots see robots", "twice"),
    "18 who sees whom": (
        "18",
        (),
        [("correct(x, P, a, at[id], y, R)", "correct(x, P, at[id], a, y, R)")],
        "robots see robots",
        "now.met[sen.id] is what the robot",
    ),
    "18 expected minus measured": (
        "18",
        (),
        [(Z18, "z = e - y\n        z[1] = wrap(z[1])")],
        "better than nothing",
        "sign of the innovation",
    ),
    "18 no noise of motion": (
        "18",
        (),
        [("            P[r, r] += X_u @ now.U[rob.id] @ X_u.T\n", "")],
        "honest",
        "X_u U",
    ),
    "18 known landmarks unused": (
        "18",
        (),
        [("                    x, P = correct(x, P, a, lmks[id], y, R)\n", "                    pass\n")],
        "all is used",
        "are all landmarks in view corrected",
    ),
    "18 too sure of the sensor": (
        "18",
        [everywhere(nb18, NOISE, "range_std=0.05, bearing_std_deg=0.3")],
        (),
        "honest",
        "",
    ),
    "19 nobody is deleted": (
        "19",
        (),
        [("gone = np.array(gone, int)", "gone = np.array([], int)")],
        "the upkeep",
        "manage",
    ),
    "19 all are in view": (
        "19",
        (),
        [("visible | matched, matched", "np.ones(len(ids), bool), matched")],
        "the map",
        "behind the truck",
    ),
    "19 births at the start only": (
        "19",
        (),
        [("y[j == -1]:", "y[j == -1] if now.k < 20 else []:")],
        "the map",
        "started",
    ),
    "19 expected minus measured": ("19", (), [("x + K @ z[", "x - K @ z[")], "the path", "innovation"),
    "19 no noise of motion": ("19", (), [("        P[:3, :3] += B @ now.U[1] @ B.T\n", "")], "the path", "slip"),
    "19 births without cross-covariance": (
        "19",
        (),
        [("P_lx = L_r @ P[:3]", "P_lx = 0 * L_r @ P[:3]"), ("P_lx[:, :3] @ L_r.T", "L_r @ P[:3, :3] @ L_r.T")],
        "no more is claimed than can be known",
        "covariance with *all*",
    ),
    "19 no slip": (
        "19",
        (),
        [("[B, sideways]", "[B, 0 * sideways]")],
        "no more is claimed than can be known",
        "the slip",
    ),
    "19 P is not corrected": ("19", (), [("P - K @ Z @ K.T", "P")], "the covariance is corrected", "P is not"),
    "19 laser on the axle": ("19", (), [("(2.83, 0.76, 3.78, 0.50)", "(2.83, 0.76, 0.0, 0.0)")], "honest", "car"),
    "19 too sure of the laser": (
        "19",
        [("range_std = 0.15", "range_std = 0.02"), ("deg = 0.7", "deg = 0.05")],
        (),
        "honest",
        "R",
    ),
}


@pytest.mark.parametrize(("number", "scenario", "loop", "link", "word"), WRONG.values(), ids=WRONG)
def test_a_wrong_run_is_told_what_is_wrong(number, scenario, loop, link, word):
    found = verdict(number, scenario, loop)
    assert found.status == "failed" and found.link == link, f"{found.link}: {found.message}"
    assert word in found.hint, found.hint


@pytest.mark.parametrize(
    ("type", "word"),
    [("hmg_pnt", "on its way"), ("idp_pnt", "on its way"), ("ahm_pnt", "on its way"), ("euc_pnt", "docs/scenarios.md")],
)
def test_one_camera_is_not_honest_with_poor_odometry(type, word):
    """Project 17 begins with hmgPnt; another way of storing is not enough."""
    found = verdict("17", [('"hmg_pnt"', f'"{type}"'), ("last = 60", "last = 50")], start=True)
    assert found.status == "failed" and word in found.hint, found


@pytest.mark.parametrize(
    ("value", "says"),
    [(np.zeros((8, 60)), "returns one array: it must end"), ((x for x in "ab"), "has a `yield`"), (7, "returns int")],
)
def test_what_the_loop_of_17_must_return(value, says):
    with pytest.raises(nb17.Failed, match="return nees, inside") as told:
        nb17.told(value, 8, 60)
    assert says in str(told.value)


def test_a_result_that_is_none_is_not_a_run_that_ended_early(capsys):
    experiment("17.project", edited(nb17.SCENARIO, FRAMES["17"]), lambda data, seeds: (np.zeros((50, 8)), np.zeros(50)))
    told = " ".join(capsys.readouterr().out.split())
    assert "The result is not used: nees must have the shape (8, 50)" in told and "early" not in told


def test_the_means_of_17_are_told_with_the_same_digits():
    (measure,) = (s for s in nb17.SYMPTOMS if s.name == "the measure")
    said = measure.says.format(s=SimpleNamespace(told=6.004, mean=5.96, runs=8), p=None)
    assert "is 6.00; it is 5.96" in said


def test_a_prior_that_is_too_sure_is_seen_from_the_first_frames_on():
    edits = [('"hmg_pnt"', '"idp_pnt"'), ("non_obs_std = 0.1", "non_obs_std = 0.01"), ("last = 60", "last = 50")]
    found = verdict("17", edits, start=True)
    assert found.link == "honest" and "prior that is too sure" in found.hint


@pytest.mark.parametrize("number", MODULES)
def test_a_stub_is_not_an_attempt_and_the_reference_is_never_judged(number, capsys):
    project = MODULES[number].project

    def loop(*_):
        raise NotImplementedError

    assert project.judge(project.run(edited(project.scenario, FRAMES[number]), loop)).status == "not attempted"
    assert project.judge(reference(number)).status == "not attempted"
    assert registry.get(f"{number}.project") is project
    assert not check(f"{number}.project", reference(number)).passed
    assert "not attempted" in capsys.readouterr().out


@cache
def reference(number):
    """A short run of the reference."""
    project = MODULES[number].project
    return project.run(edited(project.scenario, FRAMES[number]), project.loop, reference=True)
