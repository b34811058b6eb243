"""Whole runs against recorded ones, within the limits that were agreed for each kind of run and reference."""

import json
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.geometry import check_jacobians

from .births import RecordedAhmPnt, RecordedHmgPnt, approximate_unit
from .measured import measured
from .replay import ENGINES, Run
from .runs import compare_run, main, names
from .scores import score, sigmas
from .synthetic import KNOWN_KINDS, make

KEPT = Path(__file__).parent / "data"

# An independent implementation of the same formulas: differences are those of harmless choices, at most 0.0008 mm.
EXACT = dict(in_order=1, per_frame=1, births_deaths=1, pose_mm=0.01, pose_deg=0.001, landmark_sigma=0.001)
# The recorded program approximates a few Jacobians: of normalising a direction at a landmark's birth, above all.
INVERSE_DEPTH = dict(per_frame=1, births_deaths=1, pose_mm=4, pose_deg=0.03, landmark_sigma=0.05)
TWO_ROBOTS = dict(per_frame=0.98, births_deaths=1, pose_mm=15, pose_deg=0.25, landmark_sigma=1)
ANCHORED = dict(per_frame=0.92, births_deaths=1, pose_mm=20, pose_deg=0.4, landmark_sigma=2.5)
OMNI = dict(per_frame=0.995, births_deaths=1, pose_mm=1.5)
CHAOTIC = dict(births_deaths=1)  # noisy constant velocity: a small difference grows; reported only
LINE = dict(in_order=0.998, per_frame=1, births_deaths=1, pose_mm=0.1, pose_deg=0.001, landmark_sigma=0.01)
PLUECKER = dict(births_deaths=1, pose_mm=20, pose_deg=0.3)  # its covariance has a part along the quaternion: see births
BIRTH = dict(in_order=1, births_deaths=1, pose_mm=0.1)
CHAOTIC_BIRTH = dict(per_frame=1, births_deaths=1, pose_mm=4)
BIRTHS = {"constvel_noise": CHAOTIC_BIRTH, "lin_ahm": {}, "lin_hmg": {}}  # {}: reported only

RECORDED = {
    "multi_2rob_4sen": TWO_ROBOTS,
    "pnt_ahm": ANCHORED,
    "pnt_hmg": ANCHORED,
    "omni_ahm": OMNI,
    "constvel_noise": CHAOTIC,
    "lin_idp": LINE,
    "lin_plk": PLUECKER,
    "lin_apl": {},
    "lin_hmg": {},
    "lin_ahm": {},  # a block of the recorded birth is a row too high: another filter
}
AT_LEAST = {"in_order", "per_frame", "births_deaths"}


def limits(line):
    """What a line must keep to."""
    if line["against"] == "exact":
        return EXACT
    if line["against"] == "recorded":
        return RECORDED.get(line["run"], INVERSE_DEPTH)
    return BIRTHS.get(line["run"], BIRTH)


def broken(line):
    """The limits that a line does not keep to."""
    bad = {}
    for key, limit in limits(line).items():
        value = line[key]
        if value is not None and not (value >= limit if key in AT_LEAST else value <= limit):
            bad[key] = (value, limit)
    return bad


def check(folder, name, engine="plain"):
    lines = measured(folder, name, engine)
    assert lines
    for line in lines:
        assert broken(line) == {}, line
    return lines


both_engines = pytest.mark.parametrize("engine", ENGINES)


@both_engines
@pytest.mark.parametrize("name", names(KEPT))
def test_kept_runs(name, engine):
    against = [line["against"] for line in check(KEPT, name, engine)]
    assert against[:2] == ["exact", "recorded"]
    assert ("recorded+birth" in against) == (name == "constvel_noise")


@both_engines
def test_all_runs(golden_dir, engine):
    lines = [line for name in names(golden_dir) for line in check(golden_dir, name, engine)]
    assert {line["run"] for line in lines} == set(names(golden_dir))


@pytest.mark.parametrize("name", KNOWN_KINDS)
def test_every_kind_of_recording_can_be_replayed(name, tmp_path):
    """Made-up recordings of this package's own results must be met to the last bit."""
    make(tmp_path / "runs", name, frames=12)
    lines = list(compare_run(tmp_path, name))
    assert lines[0]["against"] == "recorded" and lines[0]["events"] > 100
    assert all(lines[0][key] == 1 for key in AT_LEAST)
    assert lines[0]["pose_mm"] == lines[0]["pose_deg"] == lines[0]["landmark_sigma"] == 0
    birth = [line for line in lines if line["against"] == "recorded+birth"]
    assert len(birth) == ("ahm" in name or "hmg" in name)
    for line in birth:
        assert line["births_deaths"] == 1 and line["pose_mm"] > 0  # the imitated birth does change the run


def test_outliers_are_rejected_and_deleted(tmp_path):
    scenario = make(tmp_path / "runs", "pnt_idp_outliers", frames=60)
    ev = scenario.arrays["ev_int"]
    assert (ev[:, 0] == 4).sum() > 10
    first, later = ev[(ev[:, 0] == 3) & (ev[:, 1] == 1)], ev[(ev[:, 0] == 3) & (ev[:, 1] > 1)]
    assert len(first) == 10 and np.bincount(later[:, 1]).max() == 2


# --- the scores themselves -------------------------------------------------------------------------------------------


def run(events, poses=None, points=None):
    poses = np.array([[[0.0, 0, 0, 1, 0, 0, 0]]]) if poses is None else poses
    points = {1: np.zeros(3)} if points is None else points
    return Run(np.array(events), poses, points, {id: np.diag([1.0, 4.0, 0.0]) for id in points})


EVENTS = [[3, 1, 1, 1, 5, 0], [0, 2, 1, 1, 5, 0], [1, 2, 1, 1, 5, 1], [2, 2, 1, 1, 5, 0]]


def test_the_same_run_scores_full():
    s = score(run(EVENTS), run(EVENTS))
    assert all(s[key] == 1 for key in AT_LEAST) and s["pose_mm"] == s["pose_deg"] == s["landmark_sigma"] == 0


def test_events_are_counted_in_order_and_per_frame():
    swapped = [EVENTS[0], EVENTS[2], EVENTS[1], EVENTS[3]]
    s = score(run(swapped), run(EVENTS))
    assert s["in_order"] == 0.5 and s["per_frame"] == 1
    s = score(run(EVENTS[1:]), run(EVENTS))  # a birth is missing: everything after it has moved up
    assert s["in_order"] == 0 and s["per_frame"] == 0.75 and s["births_deaths"] == 0
    rejected = [*EVENTS[:2], [1, 2, 1, 1, 5, 0], EVENTS[3]]
    assert score(run(rejected), run(EVENTS))["in_order"] == 0.75


def test_poses_are_compared_in_millimetres_and_degrees():
    a = np.tile([0.0, 0, 0, 1, 0, 0, 0], (3, 2, 1))
    b = a.copy()
    b[1, 1, :3] += [0.003, 0.0, 0.004]
    half = np.radians(0.2) / 2
    b[2, 0, 3:] = -np.array([np.cos(half), 0, 0, np.sin(half)])  # q and -q are the same orientation
    s = score(run(EVENTS, a), run(EVENTS, b))
    assert np.isclose(s["pose_mm"], 5) and np.isclose(s["pose_deg"], 0.2)


def test_landmarks_are_compared_in_sigmas_and_nothing_is_divided_by_zero():
    assert sigmas(np.array([0.1, 0.4, 0.0]), np.diag([1.0, 4.0, 0.0])) == 0.2
    assert sigmas(np.zeros(3), np.zeros((3, 3))) == 0
    assert sigmas(np.array([0.0, 0.0, 1e-9]), np.diag([1.0, 4.0, 0.0])) == np.inf
    assert score(run(EVENTS), run(EVENTS, points={2: np.zeros(3)}))["landmark_sigma"] == np.inf


@pytest.mark.parametrize("lmk", [RecordedAhmPnt(), RecordedHmgPnt()])
def test_imitated_births_differ_in_one_jacobian_only(lmk, rng):
    """Value and derivative by the prior are the package's; that by the direction is I / |v|, which is not exact."""
    v, n = rng.normal(size=3), np.array([0.1])
    l, L_v, L_n = lmk.from_ray(v, n)
    exact_l, exact_v, exact_n = type(lmk).__mro__[1]().from_ray(v, n)
    assert (l == exact_l).all() and (L_n == exact_n).all()
    rows = np.abs(L_v - exact_v).max(-1) > 0
    assert (L_v[rows] == approximate_unit(v)[1]).all() and rows.sum() == 3
    with pytest.raises(AssertionError, match="argument 1"):
        check_jacobians(lmk.from_ray, v, n)


# --- the command line ------------------------------------------------------------------------------------------------


def test_one_line_per_comparison(capsys):
    assert main([str(KEPT), "phd_euc"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["against"] for line in lines] == ["exact", "recorded"]
    keys = ["events", "in_order", "per_frame", "pose_mm", "pose_deg", "landmark_sigma", "landmark_sigma_median"]
    assert set(lines[0]) >= {"run", "against", *keys}


def test_a_run_that_fails_is_named_and_the_others_go_on(tmp_path, capsys):
    make(tmp_path / "runs", "pnt_ahm", frames=3)
    make(tmp_path / "runs", "pnt_hmg", frames=3)
    path = tmp_path / "runs" / "pnt_ahm.json"
    path.write_text(path.read_text().replace('"pinHole"', '"fishEye"'))
    assert main([str(tmp_path)]) == 1
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert "fishEye" in lines[0]["error"] and lines[1]["run"] == "pnt_hmg"


@pytest.mark.parametrize("arguments, said", [(["nowhere"], "nowhere"), ([str(KEPT), "pnt_apl"], "pnt_apl")])
def test_what_is_not_there_is_named(arguments, said, capsys):
    with pytest.raises(SystemExit):
        main(arguments)
    assert said in capsys.readouterr().err
