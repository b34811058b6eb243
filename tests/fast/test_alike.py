"""What once made the two engines part, or one of them silent: the same outcome on all maps."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest

from ekfslam_tutorial import fast, slam
from ekfslam_tutorial.fast import programs
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing
from ekfslam_tutorial.slam import KnownIds

from .scenes import POINTS, Scenes, outcome, raw

pytestmark = pytest.mark.usefixtures("interpreted")
BOTH_WAYS = pytest.mark.parametrize("joint", [False, True], ids=["one by one", "joint"])


def outcomes(scenes, do):
    said, *others = [outcome(do, scene) for scene in scenes.all]
    assert others == [said] * len(others), (said, others)
    return said


def look(y):
    measurements = raw(range(len(y)), np.asarray(y, float))

    def do(scene):
        args = scene.map, scene.rob, scene.sen, scene.lmks
        events, new = scene.engine.correct_known_lmks(*args, scene.obs, measurements, scene.opt)
        return events + scene.engine.init_new_lmks(*args, measurements, new, scene.opt)

    return do


@dataclass(frozen=True)
class HalfAJacobian(RangeBearing):
    """Its derivative has one column."""

    def project(self, p):
        y, Y_p = super().project(p)
        return y, Y_p[..., :1]


@BOTH_WAYS
def test_a_jacobian_of_a_wrong_shape_is_named(joint, rng):
    scenes = Scenes(RangeBearing(0.1, 0.02), joint=joint)
    scenes.go(rng)
    y = scenes.measured(rng)
    for scene in scenes.all:
        scene.sen.model = HalfAJacobian(0.1, 0.02)
    kind, said = outcomes(scenes, look(y))
    assert kind is ValueError and said.startswith("HalfAJacobian.project: its Jacobian must have shape (..., 2, 2)")


@dataclass(frozen=True)
class Root(RangeBearing):
    """It can be seen where a root is large enough; that of a negative number is not."""

    def visible(self, y, p):
        with np.errstate(invalid="ignore"):
            return (np.asanyarray(p)[..., 1] + 0.5) ** 0.5 > 0.4


@BOTH_WAYS
def test_the_root_of_a_negative_number_is_no_complex_one(joint, rng):
    scenes = Scenes(Root(0.1, 0.02), joint=joint)
    for _ in range(3):
        scenes.go(rng)
    assert 0 < len(scenes.plain.lmks) < len(POINTS)


@BOTH_WAYS
@pytest.mark.parametrize("huge", [1e155, 1e308])
def test_a_measurement_too_far_away_for_a_float_does_not_pass(joint, huge, rng):
    """A laser's "no return". No gate is set; the distance of the innovation is infinite all the same."""
    scenes = Scenes(RangeBearing(0.1, 0.02), joint=joint)
    scenes.go(rng)
    y = scenes.measured(rng)
    y[2, 0] = huge
    events = outcomes(scenes, lambda scene: sorted(look(y)(scene)))  # equally uncertain ones: rounding orders them
    assert [(e.kind, e.lmk) for e in events if not e.flag] == [("innovation", 2)]
    assert all(np.isfinite(scene.map.P).all() for scene in scenes.all)


@dataclass(frozen=True)
class Scaled(Odometry2):
    """Two that compare as equal need not be so."""

    scale: float = field(default=1.0, compare=False)

    def move(self, x, u, dt):
        x2, X_x, X_u = super().move(x, self.scale * u, dt)
        return x2, X_x, self.scale * X_u


def test_models_that_compare_as_equal_and_are_not(rng):
    ends = []
    for scale in 1.0, 2.0:
        scenes = Scenes(RangeBearing(0.1, 0.02))
        for scene in scenes.all:
            scene.rob.motion = Scaled(scale)
        scenes.move(np.array([0.5, 0.0, 0.0]))
        ends.append(scenes.compiled.map.x[0])
    assert ends == pytest.approx([0.5, 1.0])


def test_a_class_whose_method_was_replaced_is_another_model():
    @dataclass(frozen=True)
    class Mine(Odometry2):
        size: ClassVar[int] = 3

    alike, made = programs._text(Mine()), []
    for times in 1.0, 2.0:
        made.append(programs.program(lambda motion: object(), Mine()))
        Mine.move = lambda self, x, u, dt, times=times: Odometry2.move(self, x, times * u, dt)
    assert programs._text(Mine()) != alike and made[0] is not made[1]


class Mine(KnownIds):
    """It looks at what it is given."""

    def __call__(self, map, obs, raw, sensor):
        self.given.append(sorted(o.lmk for o in obs))
        return super().__call__(map, obs, raw, sensor)


def test_an_association_of_ones_own_is_given_all_landmarks(rng):
    """Also those out of view, also if it is a kind of `KnownIds`."""
    Mine.given = []
    scenes = Scenes(RangeBearing(0.1, 0.02, max_range=5.0), joint=True, association=Mine())
    for _ in range(2):
        scenes.go(rng)
    plain, *others = (Mine.given[i :: len(scenes.all)] for i in range(len(scenes.all)))
    assert others == [plain] * len(others)


@pytest.mark.parametrize("how", [{}, {"compressed": True}], ids=["FastMap", "CompressedMap"])
def test_x_and_P_can_be_assigned_to(how):
    map = fast.new_map(**how)
    map.add([1.0, 2.0], np.eye(2))
    map.x += 1.0
    map.P *= 2.0
    assert np.array_equal(map.x, [2.0, 3.0]) and np.array_equal(map.P, 2 * np.eye(2))
    map.x, map.P = [5.0, 6.0], 3 * np.eye(2)
    assert np.array_equal(map.state(slice(0, 2)), [5.0, 6.0]) and np.array_equal(map.block(slice(0, 2)), 3 * np.eye(2))


def test_a_plain_map_is_refused_in_one_sentence(rng):
    scenes, map = Scenes(RangeBearing(0.1, 0.02)), slam.new_map()
    scene = scenes.compiled
    for step in (
        lambda: fast.move(map, scene.rob, 0.1),
        lambda: fast.correct_known_lmks(map, scene.rob, scene.sen, {}, {}, raw([], np.zeros((0, 2))), scene.opt),
        lambda: fast.init_new_lmks(map, scene.rob, scene.sen, {}, raw([], np.zeros((0, 2))), [], scene.opt),
    ):
        with pytest.raises(TypeError, match=r"need a map of `fast`: take fast.new_map\(\), got Map"):
            step()
