"""Mistakes are told in the same words as by a plain map, and nothing has been changed then."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ekfslam_tutorial.cli import main
from ekfslam_tutorial.fast import CompressedMap, FastMap
from ekfslam_tutorial.models.landmarks import AhmPnt, IdpPnt
from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing
from ekfslam_tutorial.slam import Lmk
from ekfslam_tutorial.toolbox import UserData

from .scenes import POINTS, Scenes, outcome, raw

pytestmark = pytest.mark.usefixtures("interpreted", "undrawn")
IDS = range(len(POINTS))


def fails(scenes, do):
    """The sentence of all, up to the first number that is computed; their maps are what they were before."""
    before = [(scene.map.x.copy(), scene.map.P.copy(), dict(scene.lmks)) for scene in scenes.all]
    said, *others = [outcome(do, scene) for scene in scenes.all]
    assert isinstance(said, tuple) and others == [said] * len(others), (said, others)
    for scene, (x, P, lmks) in zip(scenes.all, before, strict=True):
        if isinstance(scene.map, CompressedMap) and (P.diagonal() < 0).any():
            continue  # no factor of that
        tiny = 1e-12 * np.abs(P).max() if isinstance(scene.map, CompressedMap) else 0.0  # to settle it takes sums
        assert np.array_equal(scene.map.x, x) and np.abs(scene.map.P - P).max() <= tiny and scene.lmks == lmks
    return said[1]


def look(pair, y, R=None):
    """A correction."""
    measurements = raw(range(len(y)), y, R)
    return lambda scene: scene.engine.correct_known_lmks(
        scene.map, scene.rob, scene.sen, scene.lmks, scene.obs, measurements, scene.opt
    )


@dataclass(frozen=True)
class Noisy(RangeBearing):
    """A sensor whose noise can be anything."""

    noise: Any = 1.0

    @property
    def R(self):
        return np.diag([self.noise, self.noise])


@pytest.fixture(params=[False, True], ids=["sequential", "joint"])
def pair(request, rng):
    """A robot that knows its landmarks."""
    pair = Scenes(RangeBearing(0.1, 0.02), joint=request.param)
    pair.go(rng), pair.go(rng)
    assert len(pair.compiled.obs) == len(POINTS)
    return pair


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_measurements_that_are_not_finite(pair, bad, rng):
    y = pair.measured(rng)
    y[3, 1] = bad
    assert "measurement 3 of landmark 3 must be finite" in fails(pair, look(pair, y))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_noise_of_a_measurement_that_is_none(pair, bad, rng):
    R = np.array([0.01 * np.eye(2)] * 5)
    R[2, 0, 0] = bad
    assert "the noise covariance of landmark 2 must be" in fails(pair, look(pair, pair.measured(rng), R))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -100.0])
def test_noise_of_a_sensor_that_is_none(pair, bad, rng):
    y = pair.measured(rng)
    for scene in pair.all:
        scene.sen.model = Noisy(0.1, 0.02, noise=bad)
    assert fails(pair, look(pair, y)) == "the innovation covariance must be positive definite"


def test_an_innovation_covariance_that_is_none(pair, rng):
    """Compressed maps ask for a P that is a covariance."""
    scenes = SimpleNamespace(all=[scene for scene in pair.all if not isinstance(scene.map, CompressedMap)])
    for scene in scenes.all:
        scene.map.P[:] = -1e4 * scene.map.P
    assert fails(scenes, look(pair, pair.measured(rng))) == "the innovation covariance must be positive definite"


def test_a_state_that_is_not_finite(pair, rng):
    """It cannot be seen, so it is not corrected; and nobody says that it was."""
    for scene in pair.all:
        scene.map.x[scene.lmks[1].r] = np.nan
    y = pair.measured(rng)
    outs = [look(pair, y)(scene) for scene in pair.all if not isinstance(scene.map, CompressedMap)]
    assert outs[0] and outs == [outs[0]] * len(outs)
    x, x_c = pair.plain.map.x, pair.compiled.map.x
    assert np.allclose(x, x_c, rtol=1e-9, atol=1e-12, equal_nan=True) and np.isnan(x).sum() == 2


def start(y, R=None):
    measurements = raw([99], np.array([y], float), R)
    return lambda scene: scene.engine.init_new_lmks(
        scene.map, scene.rob, scene.sen, scene.lmks, measurements, [0], scene.opt
    )


@pytest.mark.parametrize("y", [[3.0], [3.0, 0.1, 2.0]], ids=str)
def test_a_measurement_of_the_wrong_length(pair, y):
    fails(pair, start(y))


def test_noise_of_the_wrong_shape_or_not_finite(pair):
    fails(pair, start([3.0, 0.1], np.eye(3)[None]))
    assert "must be finite" in fails(pair, start([3.0, 0.1], np.full((1, 2, 2), np.nan)))


def test_priors_of_the_wrong_length():
    pair = Scenes(BearingOnly2(0.02), lmk_type=AhmPnt(2), n=[0.1, 0.2], N=0.1 * np.eye(2))
    fails(pair, start([0.1]))


def test_landmarks_of_another_kind_than_their_state(rng):
    """Five numbers are asked for, where two are: not those of its neighbours."""
    pair = Scenes(RangeBearing(0.1, 0.02))
    for scene in pair.all:
        scene.lmks[0] = Lmk(0, AhmPnt(2), r=scene.map.add([3.0, 0.5], np.eye(2)))
        scene.map.add(np.ones(9), np.eye(9))
    outs = []
    for scene in pair.all:
        try:
            outs.append(repr(look(pair, pair.measured(rng)[:1])(scene)))
        except (ValueError, IndexError) as error:
            outs.append(type(error))
    assert outs[0] == outs[1]


def test_landmarks_that_a_sensor_cannot_start(pair):
    for scene in pair.all:
        scene.sen.lmk_type = IdpPnt()
    assert fails(pair, start([3.0, 0.1]))


# --- numba is not there ----------------------------------------------------------------------------------------------

NEEDS = "a compiled map needs numba: pip install 'ekfslam_tutorial[compiled]'"
TABLE = {
    "world": {"type": "ring", "n": 12, "radius": 4.0},
    "robot": [{"motion": "odometry2", "da_deg": 5, "da_std_deg": 0.2}],
    "sensor": [{"type": "range_bearing", "range_std": 0.05, "bearing_std_deg": 0.5}],
    "options": {"compiled": True},
}


def test_without_numba_one_sentence_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("ekfslam_tutorial.fast.extra.find_spec", lambda name: None)
    with pytest.raises(ImportError) as error:
        FastMap(compiled=True)
    assert str(error.value) == NEEDS
    with pytest.raises(ValueError, match="numba") as error:
        UserData.from_dict(TABLE)
    assert NEEDS in str(error.value)
    assert main(["run", "range_bearing_2d", "--out", str(tmp_path), "--set", "options.compiled=true"]) != 0
    out = capsys.readouterr()
    assert NEEDS in out.err and "Traceback" not in out.err and not any(tmp_path.iterdir())


def test_the_command_line_compiles_if_it_is_asked_to(tmp_path, capsys):
    words = ["--set", "options.compiled=true", "--set", "time.last=3"]
    assert main(["run", "range_bearing_2d", "--out", str(tmp_path), *words]) == 0


@pytest.mark.parametrize("who", ["robot", "sensor"])
def test_a_known_frame_with_too_few_numbers(pair, who):
    """Machine code would read past its end."""
    for scene in pair.all:
        if who == "robot":
            scene.map.remove(scene.rob.r)
            scene.rob.r, scene.rob.x = None, np.zeros(2)
        else:
            scene.sen.x = np.zeros(2)
    wanted = "Frame2 needs 3 numbers [x, y, theta]"
    assert wanted in fails(pair, look(pair, np.ones((2, 2))))
    new = raw([50, 51], np.array([[2.0, 0.1], [3.0, 0.2]]))
    start = lambda s: s.engine.init_new_lmks(s.map, s.rob, s.sen, s.lmks, new, [0, 1], s.opt)
    assert wanted in fails(pair, start)
