"""Every exported model keeps its contract, and the contract tests find models that do not."""

from dataclasses import FrozenInstanceError, dataclass, fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial import models
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models import check_landmark, check_motion, check_pair, check_sensor, retro_project
from ekfslam_tutorial.models.landmarks import EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import RangeBearing

from .examples import LANDMARKS, MOTIONS, PAIRS, SENSORS, Beacon, of, ready


@pytest.mark.parametrize("model", MOTIONS)
def test_motion(model):
    check_motion(ready(model))


@pytest.mark.parametrize("model", SENSORS)
def test_sensor(model):
    check_sensor(ready(model))


@pytest.mark.parametrize("lmk", LANDMARKS)
def test_landmark(lmk):
    check_landmark(ready(lmk))


def can_start(sensor, lmk):
    return hasattr(lmk, "from_ray" if sensor.bearing_only else "from_point")


@pytest.mark.parametrize("sensor, lmk", PAIRS)
def test_pair(sensor, lmk):
    sensor, lmk = ready(sensor), ready(lmk)
    if can_start(sensor, lmk):
        check_pair(sensor, lmk)
    else:
        names = f"{type(lmk).__name__} cannot be started by {type(sensor).__name__}"
        with pytest.raises(TypeError, match=names):
            check_pair(sensor, lmk)


@pytest.mark.parametrize("model", [*MOTIONS, *SENSORS, *LANDMARKS])
def test_models_are_frozen_values(model):
    model = ready(model)
    assert model == replace(model) and hash(model) == hash(replace(model))
    for field in fields(model):
        with pytest.raises(FrozenInstanceError):
            setattr(model, field.name, 0)


def test_what_the_folder_exports_is_tested():
    assert set(models.__all__) >= {"check_landmark", "check_motion", "check_pair", "check_sensor"}
    for params in (MOTIONS, SENSORS, LANDMARKS):
        assert len(params) >= 4


def test_a_class_without_an_example_is_named():
    class NeedsArguments:
        def __init__(self, k):
            self.k = k

    module = SimpleNamespace(__name__="models.sensors", NeedsArguments=NeedsArguments)
    (param,) = of(module, "NeedsArguments")
    with pytest.raises(pytest.fail.Exception, match="NeedsArguments is exported from models.sensors and needs arg"):
        ready(param.values[0])


# --- broken models ---------------------------------------------------------------------------------------------------


class WrongMotionJacobian(Odometry2):
    def move(self, x, u, dt):
        x2, X_x, X_u = super().move(x, u, dt)
        return x2, X_x, 1.01 * X_u


class WrongSize(Odometry2):
    size = 4


class NoStacks(Odometry2):
    def move(self, x, u, dt):
        if np.ndim(x) > 1:
            return super().move(x, u[::-1], dt)
        return super().move(x, u, dt)


@pytest.mark.parametrize(
    "model, said", [(WrongMotionJacobian(), "argument 2"), (WrongSize(), "size"), (NoStacks(), "stack")]
)
def test_a_broken_motion_is_found(model, said):
    with pytest.raises(AssertionError, match=said):
        check_motion(model)


class WrongJacobian(RangeBearing):
    def project(self, p):
        y, Y_p = super().project(p)
        return y, Y_p * [1, 1.001]


class WrongRetro(RangeBearing):
    def retro(self, y):
        v, V_y = super().retro(y)
        return 1.1 * v, 1.1 * V_y


class WrongSign(RangeBearing):
    def visible(self, y, p):
        return y[..., 0] < 0


class NoWrap(RangeBearing):
    def residual(self, y, e):
        return np.subtract(y, e) + [0, 2 * np.pi]


class Farsighted(RangeBearing):
    def visible(self, y, p):
        return y[..., 0] > 0


class NegativeNoise(RangeBearing):
    R = np.diag([1.0, -1.0])


@pytest.mark.parametrize(
    "cls, said",
    [
        (WrongJacobian, "argument 1 differs"),
        (WrongRetro, "is not y"),
        (WrongSign, "is its sign right"),
        (NoWrap, "is not"),
        (Farsighted, "beyond max_range"),
        (NegativeNoise, "R is not a covariance"),
    ],
)
def test_a_broken_sensor_is_found(cls, said):
    with pytest.raises(AssertionError, match=said):
        check_sensor(cls(0.1, 0.02, max_range=20.0))


@dataclass(frozen=True)
class Backwards(EucPnt):
    def ray(self, l):
        return -l, -np.eye(self.dim)


@dataclass(frozen=True)
class NotInverse(EucPnt):
    def to_frame(self, F, l):
        return F.from_frame(l)


@dataclass(frozen=True)
class Unborn:
    dim: int = 2
    size: int = 2


@pytest.mark.parametrize(
    "lmk, said", [(Backwards(2), "does not point at"), (NotInverse(2), "is not l"), (Unborn(), "nothing can start it")]
)
def test_a_broken_landmark_is_found(lmk, said):
    with pytest.raises(AssertionError, match=said):
        check_landmark(lmk)


def test_a_broken_pair_is_found():
    @dataclass(frozen=True)
    class Elsewhere(EucPnt):
        def from_point(self, p):
            l, L_p, L_n = super().from_point(p)
            return l + 1.0, L_p, L_n

    with pytest.raises(AssertionError, match="observe"):
        check_pair(RangeBearing(0.1, 0.02), Elsewhere(2))


# --- a model from outside the package --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Height:
    """Measures how far a landmark is to the left, and how far ahead: written as a student would, no base class."""

    std: float = 0.1
    dim: int = 2
    bearing_only: bool = False

    @property
    def R(self):
        return self.std**2 * np.eye(2)

    def project(self, p):
        turn = np.array([[0.0, 1.0], [1.0, 0.0]])
        return p @ turn.T, np.broadcast_to(turn, (*p.shape, 2))

    def retro(self, y):
        return self.project(y)

    def residual(self, y, e):
        return np.subtract(y, e)

    def visible(self, y, p):
        return y[..., 1] > 0


def test_a_sensor_of_ones_own_needs_no_registration():
    check_sensor(Height())
    check_pair(Height(), EucPnt(2))
    F = Frame2(np.zeros(3))
    l, *_ = retro_project(F, F, Height(), EucPnt(2), np.array([1.0, 2.0]), np.zeros(0))
    assert np.array_equal(l, [2.0, 1.0])


def test_a_sensor_that_starts_no_landmark_needs_no_retro():
    check_sensor(Beacon())

    class Squared(Beacon):
        def project(self, p):
            y, Y_p = super().project(p)
            return y**2, Y_p

    with pytest.raises(AssertionError, match="argument 1 differs"):
        check_sensor(Squared())


def test_what_does_not_fit_is_a_type_error_that_names_both():
    F = Frame3(np.eye(7)[3])
    with pytest.raises(TypeError, match="EucPnt cannot be started by PinHole: one ray does not fix it"):
        retro_project(F, F, models.sensors.PinHole(), EucPnt(), np.array([300.0, 200.0]), np.array([0.1]))
