"""Fast is plain: every scenario of the package, frame by frame, with each kind of fast map."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial import datasets
from ekfslam_tutorial.fast import programs, tables
from ekfslam_tutorial.models.landmarks import HmgPnt
from ekfslam_tutorial.slam import Jcbb, NearestNeighbour
from ekfslam_tutorial.toolbox import Data, UserData, universal_slam
from ekfslam_tutorial.toolbox.run_state import run_state

from .law import HOW, assert_same_runs

SCENARIOS = Path(__file__).parents[2] / "data" / "scenarios"
TWINS = {"victoria_park": "victoria_park_twin"}
TWINS |= {f"mrclam_{name}": "mrclam_twin" for name in ("joint", "localisation", "single", "twin")}
LOGS = "lost_in_the_woods", "starry_night"
LINES = "house_ahm"
OF_STATES = "descriptors", "doppler", "focal_length", "gps_compass", "ground_flow", "lever_arm", "lidar_in_space"
ELSEWHERE = *OF_STATES, "plaza", "monoslam_desk", *(f"house_{kind}" for kind in ("plk", "apl", "idp", "hmg", "ahm"))
ELSEWHERE += ("columns_idp",)
"""The beacons of `plaza` take a hundred frames to become landmarks: `tests/toolbox/test_rings.py` holds rings to the
law. Images need the extra `images`: `tests/images` does it. Lines are computed as they are written in `slam`: one
scenario, of points and lines, and few frames are enough; so are sensors with velocities or parameters among their
states, and other sensors in space, `tests/slam/test_sensor_states.py`."""
FEW = {"euroc_v101": 12}
"""Frames of logs that have much in each of them."""

SIMULATED = sorted({path.stem for path in SCENARIOS.glob("*.toml")} - {*TWINS, *LOGS, *FEW, *ELSEWHERE})
FRAMES, SHORT = 20, {"steered_car": 8}
"""So many frames; of a scenario that has other models only, fewer."""
LONG = {"victoria_park": 60, "mrclam_joint": 60}
"""Frames of logs, instead of 120: in these all that happens has happened by then."""
EXPECTED = {
    "cloister_idp": {("innovation", False), ("correction", True)},  # a gate
    "two_robots_four_cameras": {("deletion", True), ("correction", True)},
    "victoria_park": {("deletion", True), ("correction", True)},
    "mrclam_joint": {("meeting", True), ("meeting", False), ("correction", True)},
    "mrclam_localisation": {("innovation", False), ("correction", True)},
}
COMPRESSED = tuple(how for how in HOW.values() if "compressed" in how)
WHOLE = tuple(how for how in HOW.values() if "compressed" not in how)

interpreted = pytest.mark.usefixtures("interpreted")
each_kind = pytest.mark.parametrize("how", HOW.values(), ids=HOW)
both_ways = pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])


def scenario(name, frames=FRAMES, **options):
    data = UserData.from_toml(SCENARIOS / f"{name}.toml")
    return replace(data, options=replace(data.options, **options), time=replace(data.time, last=frames))


@interpreted
@both_ways
@pytest.mark.parametrize("name", SIMULATED)
def test_simulated_scenarios(name, joint):
    """Their options: a gate, deletions, reparametrisation, a limit of updates, self-calibration, several robots.

    Every two of scenario, way of correcting and kind of map come together, not every three: of every second scenario
    compressed maps are corrected one by one and the others jointly, of the rest the other way about. All three are
    together in `test_options_in_the_plane`, and in `test_random_use.py`.
    """
    hows = WHOLE if joint == (SIMULATED.index(name) % 2 == 0) else COMPRESSED
    seen = assert_same_runs(scenario(name, SHORT.get(name, FRAMES), joint=joint), hows=hows)[1]
    assert seen >= EXPECTED.get(name, {("correction", True)})


@interpreted
@both_ways
def test_points_and_lines_in_one_map(joint):
    seen = assert_same_runs(scenario(LINES, frames=2, joint=joint))[1]
    assert seen >= {("correction", True)}


@interpreted
@pytest.mark.parametrize("name", TWINS)
def test_logs(name):
    """The log of a data set's twin: other robots are met, sensors do not look in each frame."""
    data = scenario(name, frames=None)
    params = {key: value for key, value in data.data.params.items() if key in ("robots", "robot")}
    data = replace(data, data=Data(name=TWINS[name], params=params | {"duration": 25.0}))
    data, recording = datasets.prepare(data)
    seen = assert_same_runs(data, recording, frames=LONG.get(name, 120))[1]
    assert seen >= EXPECTED.get(name, {("correction", True)})


@interpreted
@pytest.mark.parametrize("name", [*LOGS, *FEW])
def test_logs_of_one_robot(name, monkeypatch):
    """The real log where it is, else its twin; where few frames must show all that happens, the twin, which moves."""
    if name in FEW:
        monkeypatch.delenv("EKFSLAM_DATA", raising=False)
    hasty = {"lost_after": 1, "keep_lost": 2} if name in FEW else {}
    data, recording = datasets.prepare(scenario(name, frames=None, **hasty))
    seen = assert_same_runs(data, recording, frames=FEW.get(name, 120))[1]
    assert ("correction", True) in seen and (("deletion", True) in seen or name != "euroc_v101")


OPTIONS = [
    dict(association=NearestNeighbour()),
    dict(association=Jcbb()),
    dict(association=NearestNeighbour(), n_updates=2),
    dict(capacity=20),
    dict(max_lmks=5),
    dict(n_updates=3, md2_threshold=2.0),
    dict(reproject=False),
    dict(min_match_ratio=0.9, min_inlier_ratio=0.9, md2_threshold=2.0, min_search=3),
    dict(reopen_after=2, md2_threshold=0.5),
    dict(first_estimates=True, error="additive"),
]


@interpreted
@both_ways
@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: ", ".join(options))
def test_options_in_the_plane(options, joint, monkeypatch):
    """Landmarks in view are looked for first, as where there are many."""
    monkeypatch.setattr(tables, "MANY", 4)
    seen = assert_same_runs(scenario("range_bearing_2d", joint=joint, **options))[1]
    expected = {"capacity": "refused", "max_lmks": "refused", "min_match_ratio": "deletion", "reopen_after": "recovery"}
    assert all((kind, True) in seen for option, kind in expected.items() if option in options)
    assert "md2_threshold" not in options or ("innovation", False) in seen


@interpreted
@pytest.mark.parametrize(
    "options", [dict(reproject=False), dict(capacity=60), dict(lin_test=0.5, min_rho=0.1)], ids=str
)
def test_options_in_space(options):
    seen = assert_same_runs(scenario("cloister_idp", **options))[1]
    assert "capacity" not in options or ("refused", True) in seen


@interpreted
@both_ways
def test_self_calibration_in_the_plane(joint):
    data = scenario("range_bearing_2d", joint=joint)
    sensor = replace(data.sensors[0], frame_in_map=True, position_std=0.05, orientation_std_deg=3.0)
    plain, seen = assert_same_runs(replace(data, sensors=[sensor]))
    assert plain.sens[0].r is not None and ("correction", True) in seen


@interpreted
@each_kind
def test_a_run_that_is_taken_up_ends_as_if_it_had_not_been_stopped(how):
    data = scenario("cloister_idp", 12, **how)
    *_, whole = universal_slam(data)
    run = universal_slam(data)
    half = [next(run) for _ in range(6)][-1]
    *_, end = universal_slam(data, resume=run_state(half, data))
    exact = "compressed" not in how  # what is active is settled when it is stored
    assert np.array_equal(end.map.x, whole.map.x) if exact else np.allclose(end.map.x, whole.map.x, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "joint", "kind"),
    [("range_bearing_2d", True, None), ("cloister_idp", False, None), ("omnicam", True, HmgPnt())],
)
def test_the_same_with_numba(name, joint, kind):
    """What is interpreted everywhere else is compiled here: by the first takes a second, each of the others two."""
    pytest.importorskip("numba", reason="numba, the extra `compiled`, is not installed")
    from ekfslam_tutorial.fast.compiled import step

    from .interpreter import build

    assert step.build is not build
    data = scenario(name, joint=joint)
    data = data if kind is None else replace(data, landmark=replace(data.landmark, model=kind))
    assert_same_runs(data, frames=25, hows=(HOW["compiled"],))
    made = {write for (write, *_), (_, program) in programs.known.items() if program}
    assert {step._write_expected, step._write_born} <= made
