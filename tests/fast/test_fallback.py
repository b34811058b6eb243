"""What cannot be compiled is computed as ever, and what can be is not: models that are not the package's own."""

import inspect
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import pytest

from ekfslam_tutorial.fast import FastMap, programs
from ekfslam_tutorial.fast.compiled import step
from ekfslam_tutorial.fast.symbols import NotTraceable, Symbol, Tape
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models import landmarks, motion, sensors
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import PinHole, RangeBearing
from ekfslam_tutorial.slam import move

from .scenes import Scenes

pytestmark = pytest.mark.usefixtures("interpreted")


def written():
    """Which pieces have been compiled, and which could not be."""
    yes, no = set(), set()
    mine = [(at, program) for at, (_, program) in programs.known.items() if at[0].__module__ == step.__name__]
    for at, program in mine:
        (no if program is None else yes).add(at[0].__name__.removeprefix("_write_"))
    return yes, no


@dataclass(frozen=True)
class Squared:
    """A sensor of one's own, as simple as can be: squared distance, and the y coordinate."""

    dim: ClassVar = 2
    bearing_only: ClassVar = False
    R: ClassVar = np.diag([0.01, 0.02])
    scale: float = 2.0

    def project(self, p):
        x, y = p[..., 0], p[..., 1]
        e = np.stack([self.scale * (x * x + y * y), y], -1)
        rows = np.stack([2 * self.scale * x, 2 * self.scale * y], -1), np.stack([0 * y, 0 * y + 1], -1)
        return e, np.stack(rows, -2)

    def retro(self, y):
        a, b = y[..., 0] / self.scale, y[..., 1]
        x = np.sqrt(a - b * b)
        rows = np.stack([0.5 / self.scale / x, -b / x], -1), np.stack([0 * b, 0 * b + 1], -1)
        return np.stack([x, b], -1), np.stack(rows, -2)

    def residual(self, y, e):
        return np.subtract(y, e)

    def visible(self, y, p):
        return p[..., 0] > 0


class Branching(Squared):
    """It asks for the value of a number."""

    def visible(self, y, p):
        return np.array([bool(x > 0) for x in p[..., 0].ravel()]).reshape(p.shape[:-1])

    def project(self, p):
        if np.max(p) > 1e9:
            raise ValueError("far away")
        return super().project(p)


@dataclass
class Open:
    """Not frozen: it may change between two steps."""

    scale: float = 2.0
    dim: ClassVar = 2
    bearing_only: ClassVar = False
    R: ClassVar = Squared.R
    project, retro, residual, visible = Squared.project, Squared.retro, Squared.residual, Squared.visible


class Bare:
    """No dataclass."""

    scale, dim, bearing_only, R = 2.0, 2, False, Squared.R
    project, retro, residual, visible = Squared.project, Squared.retro, Squared.residual, Squared.visible


@dataclass(frozen=True)
class Listed(Squared):
    """Its parameters cannot be hashed."""

    scale: Any = 2.0
    extra: list = field(default_factory=lambda: [1.0, 2.0])


@dataclass(frozen=True)
class Everywhere(Squared):
    """It sees all there is, and says so with a constant."""

    def visible(self, y, p):
        return np.ones(len(p), bool)


@dataclass(frozen=True)
class Failing(Squared):
    """With symbols it fails in a way of its own."""

    def project(self, p):
        table = {float: 1.0}
        return Squared.project(self, p * table[type(p.ravel()[0].item() if p.dtype == float else p.ravel()[0])])


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
@pytest.mark.parametrize(
    ("sensor", "compiles"),
    [
        (Squared(), {"expected", "born", "correction"}),
        (Listed(), {"expected", "born", "correction"}),
        (Everywhere(), {"expected", "born", "correction"}),
        (Branching(), set()),
        (Failing(), {"born"}),
        (Open(), set()),
        (Bare(), set()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_sensors_of_ones_own(sensor, compiles, joint, rng):
    pair = Scenes(sensor, joint=joint)
    for _ in range(4):
        pair.go(rng)
    assert pair.compiled.lmks and any(o.updated for o in pair.compiled.obs.values())
    yes, no = written()
    asked = {"expected", "born"} | ({"correction"} if joint and "expected" in compiles else set())
    assert yes - {"move"} == asked & compiles and no == asked - compiles


@pytest.mark.parametrize("joint", [False, True], ids=["sequential", "joint"])
def test_a_model_that_changes_is_followed(joint, rng):
    pair = Scenes(Open(), joint=joint)
    pair.go(rng)
    pair.change(lambda sensor: setattr(sensor, "scale", 5.0))
    pair.go(rng)
    assert any(o.updated for o in pair.compiled.obs.values())


def test_equal_parameters_share_a_program_and_others_do_not(rng):
    for scale in (2.0, 3.0):
        for _ in range(2):
            pair = Scenes(Squared(scale))
            pair.go(rng), pair.go(rng)
    runs = {id(program[0]) for at, (_, program) in programs.known.items() if at[0] is step._write_expected}
    assert len(runs) == 2


@dataclass(frozen=True)
class WrongShape(Odometry2):
    """Its Jacobian by the control has a column too few: numpy says so, a program would read what is not there."""

    def move(self, x, u, dt):
        x, X_x, X_u = super().move(x, u, dt)
        return x, X_x, X_u[..., :2]


def test_a_model_with_a_wrong_shape_says_so_as_ever():
    pair, said = Scenes(RangeBearing(0.1, 0.02)), []
    for scene in pair.all:
        scene.rob.motion, scene.rob.u = WrongShape(), np.array([0.1, 0.0, 0.0])
        with pytest.raises(ValueError, match="must have shapes") as error:
            move(scene.map, scene.rob, 0.1)
        said.append(str(error.value))
    assert said[0] == said[1]


def test_a_model_that_decides_by_a_value_is_not_traceable():
    x = Tape().inputs("x[{}]", 3)
    with pytest.raises(NotTraceable, match="must not depend on the values"):
        Frame2(x).normalized()
    for decide in (lambda: x[0] == 0, lambda: x[0] != x[1], lambda: x[0] < 1.0):
        assert isinstance(decide(), Symbol)
        with pytest.raises(NotTraceable):
            bool(decide())


@pytest.mark.parametrize(
    "function",
    [
        lambda p: np.where(p == 0, 7.0, p),
        lambda p: np.where(p != 0, p, 7.0),
        lambda p: np.where((p > 0) == (p < 2), 1.0, 2.0),
        lambda p: np.where((p > 0) & ~(p > 2) | (p < -1), p, -p),
        lambda p: np.sinc(p),
        lambda p: (p > 0) * 2.0 + p,
        lambda p: abs(p) ** 0.5 + p**3 - p**0 + p**-1.0 % 3.0,
        lambda p: np.hypot(p, 2.0) - np.arctan2(1.0, p) * np.exp(-np.square(p)),
        lambda p: np.maximum(p, 1.0),
        lambda p: np.clip(p, 0.0, 2.0),
        lambda p: np.sign(p),
        lambda p: np.nan_to_num(p / p),
        lambda p: np.divide(1.0, p, out=np.zeros_like(p), where=p != 0),
        lambda p: 1.0 / (p * 0.0 + (p > 5.0)),
        lambda p: 0.0 * p / (0.0 * p),
        lambda p: np.isfinite(p) * 1.0,
        lambda p: p.astype(float),
        lambda p: np.sort(np.concatenate([p, p - 1.0], -1), -1)[..., :1],
        lambda p: np.full_like(p, len(set(p.ravel().tolist()))),
        lambda p: p if 0.0 in p else p + 1.0,
    ],
    ids=lambda f: inspect.getsource(f).strip().removeprefix("lambda p: ").rstrip(","),
)
def test_numpy_gives_the_same_through_symbols_or_is_refused(function):
    """Never another result without a word: of numbers between which something changes, and of zero."""

    @dataclass(frozen=True)
    class Any:
        R: ClassVar = np.eye(1)
        dim, bearing_only = 2, False

        def project(self, p):
            return function(p[..., :1]), 0.0 * p[..., None, :] + 1.0

        def visible(self, y, p):
            return p[..., 0] < 1e9

    l = np.array([[0.0, 1.0], [-0.0, 2.0], [1.0, 0.0], [2.0, 5.0], [-3.0, 1.0], [0.3, 4.0]])
    F = Frame2(np.zeros(3))
    got = step.expected(Scenes(RangeBearing(1.0, 1.0)).compiled.map, F, F, Any(), EucPnt(2), l, None, None, None, True)
    if got is not None:
        with np.errstate(all="ignore"):
            expected = function(l[:, :1])
        assert np.allclose(got[0], expected, rtol=1e-14, equal_nan=True)


def test_all_exported_models_are_frozen():
    """So that they can be compiled at all."""
    for module in (sensors, motion, landmarks):
        assert all(getattr(module, name).__dataclass_params__.frozen for name in module.__all__)


def test_parameters_of_any_sequence(rng):
    """A scenario file has lists and arrays where Python code has tuples."""
    F, map, indices = Frame3(np.eye(7)[3]), FastMap(compiled=True), np.arange(3)[None]
    map.add([0.1, -0.2, 2.0], np.eye(3))
    for k in ([320.0, 240.0, 320.0, 320.0], np.array([320.0, 240.0, 320.0, 320.0])):
        assert step.expected_in_view(map, F, F, PinHole(k=k), EucPnt(3), indices, None, None)[0].tolist() == [0]
