"""Each note is provoked by a run that deserves it; an honest run is silent."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.analysis import History
from ekfslam_tutorial.analysis.notes import ASK, SIGN, far_lines, nis_band, notes
from ekfslam_tutorial.cli import main
from ekfslam_tutorial.toolbox import RawLog, Recorder, UserData, universal_slam

SCENARIO = Path(__file__).parents[2] / "data" / "scenarios" / "range_bearing_2d.toml"
GATE = {"options.md2_threshold": 13.8}


def scenario(**overrides):
    return UserData.from_toml(SCENARIO, {key.replace("__", "."): value for key, value in overrides.items()})


def figures_of(data, recording=None, seed=1):
    history = History()
    for s in universal_slam(data, recording, seed=seed):
        history.add(s)
    return history.summary()


def said(data, recording=None, seed=1):
    return notes(figures_of(data, recording, seed), data, recording)


@pytest.fixture(scope="module")
def log():
    recorder = Recorder()
    for s in universal_slam(scenario(time__last=80), seed=3):
        recorder.add(s)
    return recorder.recording("a walk")


def with_raw(log, y=None, ids=None):
    raw = log.raw[1]
    raw = RawLog(1, raw.offsets, raw.ids if ids is None else ids, raw.y if y is None else y)
    return replace(log, raw={1: raw})


def test_an_honest_run_is_silent(log):
    for seed in (1, 2, 3):
        assert said(scenario(options__md2_threshold=9.21), seed=seed) == []
    assert said(scenario(), log) == said(scenario(options__md2_threshold=13.8), log) == []


def test_a_few_per_cent_refused(log):
    y = log.raw[1].y.copy()
    y[::20, 0] += 3.0  # 5 % of the ranges
    data = scenario(options__md2_threshold=13.8)
    recording = with_raw(log, y)
    figures = figures_of(data, recording)
    share = 100 * figures["n_refused"] / figures["n_innovations"]
    assert 2 < share < 20
    found = notes(figures, data, recording)
    assert any(note.startswith(f"{share:.1f} % of ") and "--set options.md2_threshold=inf" in note for note in found)
    assert figures["nis_of"] == "innovations that passed the gate"
    scenario(options__md2_threshold=float("inf"))  # what the note says can be typed


def test_a_flipped_sign_of_the_bearing(log):
    (note,) = said(scenario(options__md2_threshold=9), with_raw(log, log.raw[1].y * [1, -1]))
    assert re.match(r"of [\d,]+ innovations [\d,]+ did not pass the gate: ", note) and note.endswith(SIGN)
    assert "sign of the bearing" in note


def test_no_gate_and_all_wrong(log):
    (note,) = said(scenario(options__md2_threshold=1e9), with_raw(log, log.raw[1].y * [3.28, 1]))
    assert note.startswith("the mean NIS is ") and note.endswith(ASK)


def test_ids_that_are_left_out(log):
    ids = log.raw[1].ids.copy()
    ids[::2] = -1
    recording, n = with_raw(log, ids=ids), len(ids)
    (note,) = said(scenario(), recording)
    assert note.startswith(f"{(n + 1) // 2:,} of the {n:,} measurements of sensor 1 have the id -1")
    assert "--set options.association=nearest_neighbour" in note
    assert not any("id -1" in note for note in notes(figures_of(scenario(), log), scenario(), log))
    nearest = scenario(options__association="nearest_neighbour")
    assert not any("id -1" in note for note in said(nearest, recording))


def test_noise_told_too_small_and_too_large():
    small = said(scenario(sensor__noise_factor=0.3, robot__noise_factor=0.3))
    large = said(scenario(sensor__noise_factor=9.0, robot__noise_factor=9.0))
    mounting_first = r"the mean NIS is .*first look at the mounting .*too small, and `ekfslam tune`"
    assert any(re.match(mounting_first, note) for note in small)
    assert any(re.match(r"sums of corrections over \d+ s .*`ekfslam tune`", note) for note in small)
    assert [re.match(r"the mean (NIS|NEES) is .*too large", note) is not None for note in large] == [True] * len(large)
    assert large


FIGURES = {"n_innovations": 1000, "n_refused": 0, "frames": 500, "nis_mean": 2.0, "nis_dof": 2.0, "nees_mean": 3.0}
FIGURES |= {"nees_dof": 3, "correction_ratio": 1.2, "correction_ratio_s": 10, "correction_ratio_limit": 1.8}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({}, None),
        ({"nis_mean": None, "nees_mean": None, "correction_ratio": None, "correction_ratio_limit": None}, None),
        ({"nees_mean": 12.7}, None),
        ({"nees_mean": 13.0}, "the mean NEES is 13, 3 is right and 0.072 to 12.8 would be chance"),
        ({"nees_mean": 0.05}, "the mean NEES is 0.05, "),
        ({"nis_mean": 1.55}, None),
        ({"nis_mean": 1.3}, "the mean NIS is 1.3, an honest filter has 1."),
        ({"nis_mean": 3.2}, "the mean NIS is 3.2, an honest filter has 1."),
        ({"correction_ratio": 1.9}, "sums of corrections over 10 s are 1.9 times as large"),
        ({"n_refused": 15}, None),
        ({"n_refused": 60}, "6.0 % of 1,000 innovations did not pass the gate, 0.1 % would be right"),
        ({"n_innovations": 0}, f"no landmark was measured a second time: {ASK}"),
    ],
)
def test_bands(change, says):
    found = notes(FIGURES | change, scenario(**{"options.md2_threshold": 13.8}))
    assert len(found) == (says is not None)
    assert says is None or found[0].startswith(says)


def test_the_band_of_the_nis_knows_of_the_gate():
    """White innovations through a gate at 90 %: their mean, from 200,000 of them, is the middle of the band."""
    squares = np.random.default_rng(1).chisquare(2, 200_000)
    passed = squares[squares < 4.605]
    low, high = nis_band(FIGURES | {"n_innovations": 10**9}, scenario(options__md2_threshold=4.605))
    assert low / 0.8 == pytest.approx(passed.mean(), rel=0.01) == high / 1.25


@pytest.mark.parametrize("kind, std, n_notes", [("plk_lin", 0.15, 1), ("plk_lin", 0.1, 0), ("apl_lin", 0.15, 0)])
def test_plucker_lines_with_a_prior_beyond_infinity(kind, std, n_notes):
    prior = {"landmark.non_obs_std": [std, std]}
    data = UserData.from_toml(SCENARIO.with_name(f"house_{kind[:3]}.toml"), prior)
    found = far_lines(None, data)
    assert bool(found) == bool(n_notes)
    assert not found or "a standard deviation of 0.15 1/m" in found and "landmark.type=apl_lin" in found


def test_landmarks_that_are_none_and_beacons_that_are_rings(tmp_path):
    """False measurements start landmarks that nobody sees again; a straight path does not tell a beacon's side."""
    run = ["run", str(SCENARIO), "--set", "sensor.1.clutter=0.5", "--set", "options.association=nearest_neighbour"]
    assert main([*run, "--out", str(tmp_path / "false")]) == 0
    assert "landmarks were measured once only" in (tmp_path / "false" / "result.json").read_text()
    (tmp_path / "beacon.toml").write_text(
        'time = {last = 20}\nworld = {type = "points", points = [[3.0, 2.0]]}\nlandmark = {hypotheses = 64}\n'
        '[[robot]]\nmotion = "unicycle"\nv = 1.0\n[[sensor]]\ntype = "range"\nrange_std = 0.1\n'
    )
    assert main(["run", str(tmp_path / "beacon.toml"), "--out", str(tmp_path / "ring")]) == 0
    assert "still a ring of hypotheses" in (tmp_path / "ring" / "result.json").read_text()
