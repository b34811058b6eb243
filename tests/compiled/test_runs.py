"""Whole runs: a plain and a compiled map side by side, and everything that can be seen of them is the same."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial import datasets
from ekfslam_tutorial.compiled import step
from ekfslam_tutorial.slam import Jcbb, NearestNeighbour
from ekfslam_tutorial.toolbox import Data, Recorder, UserData, universal_slam
from ekfslam_tutorial.toolbox.run_state import run_state

from .interpreter import build
from .side_by_side import side_by_side

SCENARIOS = Path(__file__).parents[2] / "data" / "scenarios"
SIMULATED = (
    "cloister_ahm", "cloister_hmg", "cloister_idp", "constant_velocity", "depth_camera", "lecture_mapping",
    "localisation_2d", "omnicam", "range_bearing_2d", "two_robots_four_cameras",
)  # fmt: skip


def scenario(name, frames=40, **options):
    data = UserData.from_toml(SCENARIOS / f"{name}.toml")
    options = options if data.options.capacity is None else {"capacity": data.options.capacity} | options
    return replace(data, options=replace(data.options, **options), time=replace(data.time, last=frames))


def kinds_of(now):
    return {type(lmk.type).__name__ for lmk in now.lmks.values()}


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize("name", SIMULATED)
def test_the_scenarios_of_the_package(name, joint, interpreted):
    """Their options: a gate, deletions, reparametrisation, a limit of updates, self-calibration, several robots."""
    plain, compiled, seen = side_by_side(scenario(name, joint=joint))
    assert ("correction", True) in seen and len(plain.lmks) > 10
    assert all(o.table.J is not None for o in compiled.obs.values()) or len(kinds_of(plain)) > 1
    assert {at[0] for at, (_, program) in step._programs.items() if program} >= {step._write_expected}
    if name == "two_robots_four_cameras":
        assert ("deletion", True) in seen and kinds_of(plain) == {"EucPnt", "IdpPnt"}
        assert any(sen.r is not None for sen in plain.sens) and len(plain.robs) == 2
    elif name == "cloister_idp":
        assert ("innovation", False) in seen and "EucPnt" in kinds_of(plain)  # refused, and reparametrised


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize("association", [NearestNeighbour(), Jcbb()], ids=["nearest", "jcbb"])
def test_measurements_without_names(association, joint, interpreted):
    plain, compiled, seen = side_by_side(scenario("range_bearing_2d", association=association, joint=joint))
    assert ("correction", True) in seen and len(plain.lmks) > 10


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize(
    "options",
    [
        dict(capacity=20),
        dict(max_lmks=5),
        dict(n_updates=3, md2_threshold=2.0),
        dict(reproject=False),
        dict(min_match_ratio=0.9, min_inlier_ratio=0.9, md2_threshold=2.0, min_search=3),
        dict(reopen_after=2, md2_threshold=0.5),
        dict(association=NearestNeighbour(), n_updates=2),
    ],
    ids=lambda options: ", ".join(options),
)
def test_options_in_the_plane(options, joint, interpreted):
    seen = side_by_side(scenario("range_bearing_2d", joint=joint, **options))[2]
    expected = {"capacity": "refused", "max_lmks": "refused", "min_match_ratio": "deletion", "reopen_after": "recovery"}
    assert all((kind, True) in seen for option, kind in expected.items() if option in options)
    assert "md2_threshold" not in options or ("innovation", False) in seen


@pytest.mark.parametrize(
    "options", [dict(reproject=False), dict(capacity=60), dict(lin_test=0.5, min_rho=0.1)], ids=str
)
def test_options_in_space(options, interpreted):
    seen = side_by_side(scenario("cloister_idp", **options))[2]
    assert "capacity" not in options or ("refused", True) in seen


def test_self_calibration_in_the_plane(interpreted):
    data = scenario("range_bearing_2d")
    sensor = replace(data.sensors[0], frame_in_map=True, position_std=0.05, orientation_std_deg=3.0)
    plain, _, seen = side_by_side(replace(data, sensors=[sensor]))
    assert plain.sens[0].r is not None and ("correction", True) in seen


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
def test_first_estimates_fall_back(joint, interpreted):
    side_by_side(scenario("range_bearing_2d", first_estimates=True, joint=joint), frames=10)
    written = {at[0] for at, (_, program) in step._programs.items() if program}
    assert step._write_expected not in written and step._write_born not in written


@pytest.mark.parametrize("name", ["mrclam_twin", "victoria_park_twin"])
def test_recordings(name, interpreted):
    """The log of a data set's twin: other robots are met, sensors do not look in each frame."""
    data = scenario(name.replace("_twin", "") if "park" in name else name)
    data = replace(data, data=Data(name=name, params={"duration": 40.0}))
    data, recording = datasets.prepare(data)
    plain, _, seen = side_by_side(data, recording, frames=200)
    assert ("correction", True) in seen and plain.lmks


def test_a_recorded_run_is_played_back(interpreted):
    data, recorder = scenario("range_bearing_2d", 15), Recorder()
    for now in universal_slam(replace(data, options=replace(data.options, compiled=True))):
        recorder.add(now)
    _, compiled, _ = side_by_side(data, recorder.recording("recorded"))
    assert np.array_equal(compiled.map.x, now.map.x) and np.array_equal(compiled.map.P, now.map.P)


def test_a_run_that_is_taken_up_ends_as_if_it_had_not_been_stopped(interpreted):
    data = scenario("cloister_idp", 12, compiled=True)
    *_, whole = universal_slam(data)
    run = universal_slam(data)
    half = [next(run) for _ in range(6)][-1]
    *_, end = universal_slam(data, resume=run_state(half, data))
    assert np.array_equal(end.map.x, whole.map.x) and np.array_equal(end.map.P, whole.map.P)


@pytest.mark.parametrize(("name", "joint"), [("range_bearing_2d", True), ("cloister_idp", False)])
def test_the_same_with_numba(name, joint):
    """What is interpreted everywhere else is compiled here: by the first takes a second, each of the second two."""
    assert step.build is not build
    side_by_side(scenario(name, joint=joint), frames=25)
    assert all(
        callable(program[0] if isinstance(program, tuple) else program)
        for _, program in step._programs.values()
        if program
    )
