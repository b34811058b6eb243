"""Every exported model keeps its contract, and the contract tests find models that do not."""

from dataclasses import FrozenInstanceError, dataclass, fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from ekfslam_tutorial import models
from ekfslam_tutorial.geometry import Frame2, Frame3
from ekfslam_tutorial.models import check_landmark, check_motion, check_pair, check_sensor, contracts, retro_project
from ekfslam_tutorial.models.landmarks import EucPnt, IdpPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.observation import birth, observe
from ekfslam_tutorial.models.sensors import RangeBearing, RangeBearingElevation
from ekfslam_tutorial.models.state_contracts import pair_check
from ekfslam_tutorial.models.trials import check_stack

from .differences import of_stacks
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
    return hasattr(sensor, "retro") and hasattr(lmk, birth(sensor))


@pytest.mark.parametrize("sensor, lmk", PAIRS)
def test_pair(sensor, lmk, request, monkeypatch):
    sensor, lmk = ready(sensor), ready(lmk)
    if not pair_check(sensor):
        request.getfixturevalue("all_at_once")
        for f in (observe, retro_project):
            monkeypatch.setattr(contracts, f.__name__, of_stacks(f))
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


@dataclass(frozen=True)
class NoStackOfRays(EucPnt):
    def ray(self, l):
        return (l, np.eye(self.dim)) if np.ndim(l) == 1 else (l[::-1], super().ray(l)[1])


@pytest.mark.parametrize(
    "lmk, said",
    [
        (Backwards(2), "does not point at"),
        (NotInverse(2), "is not l"),
        (Unborn(), "nothing can start it"),
        (NoStackOfRays(2), "ray: a stack"),
    ],
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


def test_what_is_no_number_alone_is_none_in_a_stack_either():
    """A point that cannot be seen has no expectation; that is no reason to refuse a model."""
    root = lambda p: (np.where(p > 0, p, np.nan),)
    assert np.isnan(check_stack(root, "root", np.array([[-1.0, 1.0], [2.0, 3.0]]))[0][0, 0])
    with pytest.raises(AssertionError, match="root: a stack of inputs does not give the stack of outputs"):
        check_stack(lambda p: (root(p)[0] * (1 + p.ndim),), "root", np.array([[-1.0, 1.0], [2.0, 3.0]]))


# --- mistakes of those who write their first model -------------------------------------------------------------------


@dataclass(frozen=True)
class Lists(Odometry2):
    """All of `move` as lists: a compiled run would take them, the others not."""

    def move(self, x, u, dt):
        return tuple(a.tolist() for a in super().move(np.asarray(x), np.asarray(u), dt))


class ListsInPart(Odometry2):
    def move(self, x, u, dt):
        x2, X_x, X_u = super().move(x, u, dt)
        return x2, X_x, X_u.tolist()


class TwoThings(Odometry2):
    def move(self, x, u, dt):
        return super().move(x, u, dt)[:2]


class Unpacked(Odometry2):
    def move(self, x, u, dt):
        a, b, c = x
        dx, dy, da = u
        return super().move(np.array([a, b, c]), np.array([dx, dy, da]), dt)


class Branching(Odometry2):
    def move(self, x, u, dt):
        return super().move(x, u if abs(u[..., 2]) > 1e-9 else 1.0 * u, dt)


AXES = r"let arrays have leading axes: p\[\.\.\., 0\] instead of p\[0\] or x, y = p"


@pytest.mark.parametrize(
    "model, said",
    [
        (Lists(), "move must give arrays, got a list for x2"),
        (ListsInPart(), "move must give arrays, got a list for X_u"),
        (TwoThings(), "move must give three things, x2, X_x, X_u, got 2"),
        (Unpacked(), rf"move takes no stack of inputs; {AXES}.*\(too many values to unpack \(expected 3.*\)"),
        (Branching(), rf"move takes no stack of inputs; {AXES}.*truth value.*ambiguous"),
    ],
)
def test_what_a_motion_gives_wrongly_is_one_sentence(model, said):
    with pytest.raises(AssertionError, match=said):
        check_motion(model)


def test_a_motion_without_its_parts_is_told_which():
    @dataclass(frozen=True)
    class Half:
        size: int = 3

        def move(self, x, u, dt):
            raise NotImplementedError("move: your code here")

    with pytest.raises(AssertionError, match="^Half has no frame, control_fields, state_fields, move yet; "):
        check_motion(Half())


class SeesAll(RangeBearing):
    def visible(self, y, p):
        return True


class SeesOne(RangeBearing):
    def visible(self, y, p):
        return super().visible(y, p)[:, None]


class Seamed(RangeBearing):
    def residual(self, y, e):
        return np.subtract(y, e)


class OneRow(RangeBearing):
    def project(self, p):
        y, Y_p = super().project(p)
        return y, Y_p[..., :1, :]


class Transposed(RangeBearing):
    def project(self, p):
        y, Y_p = super().project(p)
        return y, np.concatenate([Y_p, Y_p], -1)


class UnpackedPoint(RangeBearing):
    def project(self, p):
        x, y = p
        return super().project(np.array([x, y]))


class FirstPoint(RangeBearing):
    def project(self, p):
        return super().project(np.array([p[0], p[1]]))


class BranchingView(RangeBearing):
    def visible(self, y, p):
        return 0 < y[..., 0] and y[..., 0] < 20


@pytest.mark.parametrize(
    "cls, said",
    [
        (SeesAll, "visible must give one bool per point, got bool True"),
        (SeesOne, r"visible must give one bool per point, got shape \(100, 1\) of 100 points"),
        (Seamed, r"residual does not wrap: units\[1\] is 'rad', and .* by 2 pi, gives 6.28319; it must give 0"),
        (OneRow, r"Jacobian of argument 1 has shape \(1, 2\); it must be \(2, 2\)"),
        (Transposed, r"Jacobian of argument 1 has shape \(2, 4\); it must be \(2, 2\)"),
        (UnpackedPoint, rf"project takes no stack of inputs; {AXES}.*\(too many values to unpack \(expected 2"),
        (FirstPoint, rf"project gives shape .*; {AXES}"),
        (BranchingView, rf"visible takes no stack of inputs; {AXES}.*truth value.*ambiguous"),
    ],
)
def test_what_a_sensor_gives_wrongly_is_one_sentence(cls, said):
    with pytest.raises(AssertionError, match=said):
        check_sensor(cls(0.1, 0.02))


def test_an_error_of_one_point_is_not_taken_for_one_of_many():
    class Misspelt(RangeBearing):
        def project(self, p):
            return np.array(p) + np.zeros(7), None

    with pytest.raises(ValueError, match="broadcast"):
        check_sensor(Misspelt(0.1, 0.02))


PARTS = ("R", "bearing_only", "project", "residual", "visible")


@pytest.mark.parametrize("n", range(len(PARTS)))
@pytest.mark.parametrize("bare", [False, True])
def test_a_sensor_is_tested_after_each_method_and_what_is_missing_is_listed(n, bare):
    def empty(*_):
        raise NotImplementedError("your code here")

    parts = {name: vars(RangeBearing).get(name, getattr(RangeBearing, name)) for name in PARTS}
    body = {name: parts[name] for name in PARTS[:n]}
    if bare:  # as `ekfslam new --bare` leaves them
        body |= {name: property(empty) if name in ("R", "bearing_only") else empty for name in PARTS[n:]} | {
            "retro": empty
        }
    given = {"range_std": 0.1, "bearing_std": 0.02, "max_range": 8.0, "fov": 6.0, "dim": 2, "units": ("m", "rad")}
    cls = type("Growing", (), body | given)
    if "R" in PARTS[:n]:
        cls.R = np.diag([0.1, 0.02]) ** 2
    with pytest.raises(AssertionError, match=f"^Growing has no {', '.join(PARTS[n:])} yet; "):
        check_sensor(cls())
    if "project" in PARTS[:n]:
        cls.project = lambda self, p: (parts["project"](self, p)[0], 1.01 * parts["project"](self, p)[1])
        with pytest.raises(AssertionError, match="argument 1 differs"):
            check_sensor(cls())


def without_dim(model):
    """The same model, with all but its dim."""

    class Dimless:
        def __getattr__(self, name):
            if name == "dim":
                raise AttributeError(name)
            return getattr(model, name)

    return Dimless()


def test_a_missing_dim_is_named_where_a_shape_is_wrong():
    said = r"Jacobian of argument 1 has shape \(2, 2\); it must be \(2, 3\); Dimless has no dim, so 3 is taken"
    with pytest.raises(AssertionError, match=said):
        check_sensor(without_dim(Height2()))
    check_sensor(without_dim(Height2()), dim=2)
    said = r"has shape \(3,\); it must be \(2,\); Dimless has no dim, so 3 is taken"
    with pytest.raises(AssertionError, match=said):
        check_landmark(without_dim(Plain()))
    check_landmark(without_dim(Plain()), dim=2)


def test_a_missing_dim_is_not_named_where_something_else_is_wrong():
    class Behind(RangeBearingElevation):
        def visible(self, y, p):
            return y[..., 0] < 0

    with pytest.raises(AssertionError, match="is its sign right") as caught:
        check_sensor(without_dim(Behind(0.1, 0.02, 0.02)))
    assert "dim" not in str(caught.value)


@dataclass(frozen=True)
class Plain(EucPnt):
    """A point in the plane that takes what it gets."""

    dim: int = 2

    def from_point(self, p):
        return p, np.eye(p.shape[-1]), np.zeros((p.shape[-1], 0))


class Height2(RangeBearing):
    """Works with two of the coordinates, whatever it gets."""

    def __init__(self):
        super().__init__(0.1, 0.02)

    def project(self, p):
        return super().project(p[..., :2])


@dataclass(frozen=True)
class Guessed(EucPnt):
    def from_point(self, p):
        l, L_p, _ = super().from_point(p)
        return l, L_p, np.ones((self.dim, 1))


@dataclass(frozen=True)
class NothingGuessed(IdpPnt):
    def from_ray(self, v, n):
        l, L_v, L_n = super().from_ray(v, n)
        return l, L_v, L_n[..., :0]


@dataclass(frozen=True)
class WrongGuess(IdpPnt):
    def from_ray(self, v, n):
        l, L_v, L_n = super().from_ray(v, n)
        return l, L_v, 2 * L_n


@dataclass(frozen=True)
class NoPrior(EucPnt):
    def from_point(self, p):
        return super().from_point(p)[:2]


@pytest.mark.parametrize(
    "lmk, said",
    [
        (Guessed(2), r"from_point gives L_n of shape \(2, 1\); it must be \(2, 0\): no columns"),
        (NothingGuessed(), r"from_ray gives L_n of shape \(6, 0\); it must be \(6, 1\): one column"),
        (WrongGuess(), "Jacobian of argument 2 differs"),
        (NoPrior(2), "from_point must give three things, l, L_v, L_n, got 2"),
    ],
)
def test_what_a_landmark_gives_wrongly_is_one_sentence(lmk, said):
    with pytest.raises(AssertionError, match=said):
        check_landmark(lmk)


def test_the_pair_names_the_jacobian_of_a_wrong_shape():
    with pytest.raises(AssertionError, match=r"L_n of the landmark's birth has shape \(2, 1\); it must be \(2, 0\)"):
        check_pair(RangeBearing(0.1, 0.02), Guessed(2))


@pytest.mark.parametrize("n", range(5))
def test_a_landmark_is_tested_after_each_method_and_what_is_missing_is_listed(n):
    names = ("size", "to_frame", "from_frame", "point", "ray")
    body = {name: vars(EucPnt)[name] for name in (*names[:n], "from_point")} | {"dim": 2}
    with pytest.raises(AssertionError, match=f"^Growing has no {', '.join(names[n:])} yet; "):
        check_landmark(type("Growing", (), body)())
    del body["from_point"]
    with pytest.raises(AssertionError, match="^Growing has neither from_point nor from_ray"):
        check_landmark(type("Growing", (), body)())


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
