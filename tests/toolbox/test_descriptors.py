"""Landmarks that are told apart by what they look like: in space, with ids that nobody knows."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ekfslam_tutorial.simulation import Looks, SimObs
from ekfslam_tutorial.slam import Lmk, Obs
from ekfslam_tutorial.toolbox import Recorder, Recording, UserData, universal_slam
from ekfslam_tutorial.toolbox.descriptors import MEMORY, Descriptors, described, remember
from ekfslam_tutorial.toolbox.recordings.logs import RawLog
from ekfslam_tutorial.toolbox.run_state import run_state

from ..fast.law import ALL, assert_same_runs

SCENARIO = Path(__file__).parents[2] / "data" / "scenarios" / "descriptors.toml"


def scenario(**overrides):
    return UserData.from_toml(SCENARIO, {"time.last": 60} | overrides)


def matches(data, recording=None):
    """True ids of all that each landmark was matched with, and the last snapshot."""
    owners = {}
    for now in universal_slam(data, recording):
        for (sen, lmk), o in now.obs.items():
            if o.matched:
                owners.setdefault(lmk, Counter())[int(now.raw[sen].ids[o.index])] += 1
    return owners, now


def wrong(owners):
    """Share of the matches that are not with the thing that the landmark mostly is."""
    most, all = (sum(f(c) for c in owners.values()) for f in (lambda c: c.most_common(1)[0][1], Counter.total))
    return 1 - most / all


def test_place_and_look_together_are_right_where_the_place_alone_is_not():
    """The camera sees no distance, so a new landmark could be many: of 500 matches none is wrong."""
    by_look, now = matches(scenario())
    by_place, _ = matches(scenario(**{"options.association": "nearest_neighbour"}))
    assert sum(map(Counter.total, by_look.values())) > 400
    assert wrong(by_look) == 0.0 and wrong(by_place) > 0.0
    assert not now.named and all(set(lmk.appearance) == {"d", "n"} for lmk in now.lmks.values())
    seen = [lmk.appearance["n"] for lmk in now.lmks.values()]
    assert max(seen) == MEMORY and min(seen) >= 1


def test_both_engines_and_a_run_that_is_taken_up():
    data = scenario(**{"time.last": 12})
    plain, kinds = assert_same_runs(data, hows=ALL[:1])
    assert {("initialisation", True), ("correction", True)} <= kinds
    run = universal_slam(data)
    half = [next(run) for _ in range(6)][-1]
    *_, end = universal_slam(data, resume=run_state(half, data))
    *_, whole = universal_slam(data)
    assert np.array_equal(end.map.x, whole.map.x)
    assert all(np.array_equal(end.lmks[i].appearance["d"], l.appearance["d"]) for i, l in whole.lmks.items())


@pytest.mark.parametrize("name", ["log.npz", "log"])
def test_descriptors_are_recorded(tmp_path, name):
    data, recorder = scenario(**{"time.last": 8}), Recorder()
    for now in universal_slam(data):
        recorder.add(now)
    recording = recorder.recording("looks")
    back = Recording.load(recording.save(tmp_path / name))
    assert recording.raw[1].d.shape[1] == 10 and np.array_equal(back.raw[1].d, recording.raw[1].d)
    *_, again = universal_slam(data, back)
    assert np.allclose(again.map.x, now.map.x, rtol=0, atol=1e-12)


def test_the_association_by_hand():
    """Two landmarks at one place: the look decides; far away it does not; and what looks like none is new."""

    class Points:
        R = np.eye(2) * 0.01
        residual = staticmethod(np.subtract)

    looks = {1: np.array([1.0, 0.0, 0.0]), 2: np.array([0.0, 1.0, 0.0])}
    lmks = {id: Lmk(id, None, x=np.zeros(2), appearance={"d": d, "n": 1}) for id, d in looks.items()}
    obs = [Obs(1, id, np.zeros(2), np.eye(2) * 0.01, np.zeros(2), ()) for id in lmks]
    y = np.array([[0.05, 0.0], [0.0, 0.1], [0.1, 0.1], [9.0, 0.0]])
    d = np.array([[0.05, 0.98, 0.0], [1.0, 0.0, 0.1], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    raw = described(SimObs(1, np.full(4, -1), y, d=d), lmks)
    found = Descriptors(std=0.1)(None, obs, raw, Points)
    assert found.pairs == {2: 0, 1: 1} and found.new == [2, 3]
    assert Descriptors().birth_id(raw, 2, lmks) == 3 and raw.born == {3: 2}
    lmks[3], obs[0].index, obs[0].updated = Lmk(3, None, x=np.zeros(2)), 1, True
    remember(type("Sen", (), {"id": 1}), lmks, {(1, 1): obs[0], (1, 2): obs[1]}, raw)
    assert np.allclose(lmks[1].appearance["d"], [1.0, 0.0, 0.05]) and lmks[1].appearance["n"] == 2
    assert np.array_equal(lmks[3].appearance["d"], d[2]) and lmks[2].appearance["n"] == 1


def test_simulated_looks_have_the_noise_that_is_stated():
    """10,000 numbers: their standard deviation is within 3 per cent, four of its own."""
    looks = Looks(np.arange(3), 10, 0.3, np.random.default_rng(1), np.random.default_rng(2))
    d = looks.of(np.tile([2], 1000))
    assert abs(np.std(d - d.mean(0)) / 0.3 - 1) < 0.03
    apart = [np.sum((looks.of(np.array([0])) - looks.of(np.array([i]))) ** 2) for i in (0, 1, -1)]
    assert apart[0] < min(apart[1:])
    assert looks.of(np.zeros(0, int)).shape == (0, 10)


def test_what_is_wrong_is_said():
    data = scenario(**{"sensor.1.descriptor_size": 0, "time.last": 2})
    with pytest.raises(ValueError, match="those of sensor 1 have no descriptors: record them as d1, d2"):
        list(universal_slam(data))
    with pytest.raises(ValueError, match="std must be a positive number, got 0"):
        Descriptors(std=0)
    with pytest.raises(ValueError, match="descriptor_size must be a whole number, 0 to 4096, got 2.5"):
        replace(data.sensors[0], descriptor_size=2.5)
    with pytest.raises(ValueError, match="descriptor_std must be 0 or more"):
        replace(data.sensors[0], descriptor_std=-1.0)
    with pytest.raises(ValueError, match="1 descriptors for 2 measurements"):
        RawLog(1, np.array([0, 2]), np.array([1, 2]), np.zeros((2, 2)), d=np.zeros((1, 3)))
    some = [SimObs(1, np.array([1]), np.zeros((1, 2)), d=d) for d in (np.zeros((1, 3)), None)]
    with pytest.raises(ValueError, match="some frames have descriptors d and some do not"):
        RawLog.of(1, some)
