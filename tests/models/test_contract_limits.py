"""How wrong a model may be before a contract test says so: what is just within a tolerance, and what is just beyond."""

from copy import copy
from dataclasses import dataclass

import numpy as np
import pytest

from ekfslam_tutorial.models import (
    check_landmark,
    check_motion,
    check_pair,
    check_sensor,
    contracts,
    line_contracts,
    state_contracts,
)
from ekfslam_tutorial.models.landmarks import AhmPnt, AplLin, EucPnt, IdpLin, PlkLin
from ekfslam_tutorial.models.motion import ConstantTurn, ConstantVelocity, Imu, ImuClock, Odometry2
from ekfslam_tutorial.models.sensors import (
    BearingOnly2,
    Compass,
    Doppler,
    Gps,
    GroundFlow,
    OmniCam,
    PinHole,
    PointXY,
    Range,
    RangeBearing,
    RangeRate,
    SegmentCam,
    WheelSpeed,
)
from ekfslam_tutorial.models.state_contracts import check_parameters, check_states
from ekfslam_tutorial.models.trials import check_residual


@dataclass(frozen=True)
class Off(PointXY):
    """A sensor whose inverse is off to the side by so much."""

    by: float = 0.0

    def retro(self, y):
        v, V_y = super().retro(y)
        return v + [0.0, self.by], V_y


@dataclass(frozen=True)
class Seam(RangeBearing):
    """A sensor whose bearing is wrapped by a turn that is wrong by so much."""

    by: float = 0.0

    def residual(self, y, e):
        z = np.subtract(y, e, dtype=float)
        z[..., 1] -= (2 * np.pi + self.by) * np.round(z[..., 1] / (2 * np.pi))
        return z


@dataclass(frozen=True)
class Farsighted(RangeBearing):
    """A sensor that sees so many times as far as it says."""

    times: float = 1.0

    def visible(self, y, p):
        return (y[..., 0] > 0) & (y[..., 0] <= self.times * self.max_range)


def accepted(check, model, *more):
    try:
        check(model, *more)
    except AssertionError as error:
        return str(error)
    return True


def test_the_way_back_to_a_millionth():
    assert accepted(check_sensor, Off(by=0.95e-6)) is True
    assert accepted(check_sensor, Off(by=1.1e-6)) == "project(retro(y)) is not y"


def test_a_pair_to_a_hundred_thousandth():
    assert accepted(check_pair, Off(by=0.95e-5), EucPnt(2)) is True
    assert accepted(check_pair, Off(by=1.1e-5), EucPnt(2)) == "observe(retro_project(y)) is not y"


@pytest.mark.parametrize("by", [0.95e-6, -0.95e-6, 1.1e-6, -1.1e-6])
def test_a_seam_to_a_millionth(by):
    y = np.array([[2.0, 0.3], [3.0, -1.0]])
    said = accepted(check_residual, Seam(0.1, 0.1, by=by), y)
    assert said is True if abs(by) < 1e-6 else said.startswith("residual does not wrap: units[1] is 'rad'")


def test_points_at_twice_the_greatest_range_are_not_seen():
    assert accepted(check_sensor, Farsighted(0.1, 0.1, max_range=20.0, times=1.99)) is True
    assert accepted(check_sensor, Farsighted(0.1, 0.1, max_range=20.0, times=2.01)) == (
        "visible() accepts points beyond max_range"
    )


def test_a_motion_is_asked_for_a_tenth_of_a_second():
    asked = []

    class Noting(Odometry2):
        def move(self, x, u, dt):
            asked.append((dt, float(np.abs(u).max())))
            return super().move(x, u, dt)

    check_motion(Noting())
    assert {dt for dt, _ in asked} == {0.1}
    sizes = [u for _, u in asked]
    assert any(u == 0 for u in sizes) and any(0 < u < 2e-5 for u in sizes) and any(u > 0.5 for u in sizes)
    asked.clear()
    check_motion(Noting(), 0.5)
    assert {dt for dt, _ in asked} == {0.5}


# --- each derivative is asked for ---


def spoilt(model, method, *numbers, by=1.01):
    """The same model, but for some of the things that a method gives: too large by a hundredth."""

    class Spoilt(type(model)):
        pass

    def wrong(self, *args):
        out = list(getattr(super(Spoilt, self), method)(*args))
        for k in numbers:
            out[k] = by * out[k]
        return tuple(out)

    setattr(Spoilt, method, wrong)
    other = copy(model)
    object.__setattr__(other, "__class__", Spoilt)
    return other


K, LENS = (320.0, 240.0, 300.0, 310.0), (-0.3, 0.1)
OMNI = OmniCam((668.0, 438.0, 1.01, 0.002, -0.003), (644.7, -341.0, -29.0), fov=3.0)
ASKED = [  # the test, the model, its method, and which of the things it gives
    *((check_motion, Odometry2(), "move", k) for k in (1, 2)),
    *((check_motion, motion, "velocity", 1) for motion in (ConstantTurn(), ConstantVelocity(), Imu(), ImuClock())),
    *((check_landmark, EucPnt(2), method, k) for method in ("to_frame", "from_frame") for k in (1, 2)),
    *((check_landmark, EucPnt(2), method, 1) for method in ("point", "ray", "from_point")),
    *((check_landmark, AhmPnt(2), "from_ray", k) for k in (1, 2)),
    *((check_landmark, PlkLin(), method, k) for method in ("to_frame", "from_frame", "from_rays") for k in (1, 2)),
    *((check_landmark, line, "normal", 1) for line in (PlkLin(), IdpLin())),
    *((check_landmark, IdpLin(), "support", k) for k in (2, 3)),
    *((check_landmark, line, "normalized", 1) for line in (PlkLin(), AplLin())),
    *((check_sensor, RangeBearing(0.1, 0.1), method, 1) for method in ("project", "retro")),
    *((check_sensor, Doppler(0.1, 0.1), method, 1) for method in ("project", "retro")),
    *((check_sensor, sensor, "project", 1) for sensor in (Range(), RangeRate(), Gps(), Compass(dim=3), WheelSpeed())),
    *((check_sensor, SegmentCam(K, LENS), method, 1) for method in ("project", "retro", "innovation")),
    (check_sensor, SegmentCam(K, LENS), "innovation", 2),
    *((check_sensor, sensor, "project_parameters", 1) for sensor in (Compass(), WheelSpeed(), GroundFlow())),
    *((check_sensor, PinHole(K), method, 1) for method in ("project_parameters", "retro_parameters")),
    *((check_parameters, camera, method, k) for camera in (PinHole(K, LENS), OMNI)
      for method in ("project_parameters", "retro_parameters") for k in (1, 2)),
    *((check_parameters, PinHole(K, LENS, c=(0.3, 0.2)), method, 1)
      for method in ("project_parameters", "retro_parameters")),
]  # fmt: skip


@pytest.mark.parametrize(("check", "model", "method", "number"), ASKED)
def test_every_derivative_of_a_model_is_asked_for(check, model, method, number):
    assert "differs at entry" in accepted(check, spoilt(model, method, number))


PAIRED = [
    *((RangeBearing(0.1, 0.1), EucPnt(2), 0, method, 1) for method in ("project", "retro")),
    *((RangeBearing(0.1, 0.1), AhmPnt(2), 1, method, k) for method in ("to_frame", "from_frame") for k in (1, 2)),
    *((RangeBearing(0.1, 0.1), AhmPnt(2), 1, method, 1) for method in ("point", "from_point")),
    *((BearingOnly2(0.1), AhmPnt(2), 1, "from_ray", k) for k in (1, 2)),
    *((Doppler(0.1, 0.1), EucPnt(2), 0, method, 1) for method in ("project", "retro")),
    *((Doppler(0.1, 0.1), EucPnt(2), 1, method, k) for method in ("to_frame", "from_frame") for k in (1, 2)),
    *((SegmentCam(K), PlkLin(), 0, method, 1) for method in ("project", "retro", "innovation")),
    (SegmentCam(K), PlkLin(), 0, "innovation", 2),
    *((SegmentCam(K), PlkLin(), 1, method, k) for method in ("to_frame", "from_frame", "from_rays") for k in (1, 2)),
    (SegmentCam(K), PlkLin(), 1, "normal", 1),
]


@pytest.mark.parametrize(("sensor", "lmk", "of", "method", "number"), PAIRED)
def test_every_derivative_of_a_pair_is_asked_for(sensor, lmk, of, method, number):
    pair = [sensor, lmk]
    pair[of] = spoilt(pair[of], method, number)
    assert "differs at entry" in accepted(check_pair, *pair)


@pytest.mark.parametrize("method", ["project", "retro"])
def test_every_derivative_by_a_state_of_a_sensor_is_asked_for(method):
    """A bias alone asks for the derivatives by what is measured, too."""
    rng = np.random.default_rng
    for names in (("bias",), ("bias", "delay")):
        check_states(RangeBearing(0.1, 0.1), names, EucPnt(2), rng(1))
        said = accepted(check_states, spoilt(RangeBearing(0.1, 0.1), method, 1), names, EucPnt(2), rng(1))
        assert "differs at entry" in said


def test_a_sensor_that_sees_none_of_the_random_points_has_nothing_that_could_be_tested():
    """It has a view of 1e-6 of a pixel."""
    check_parameters(PinHole(K, LENS, image_size=(1e-6, 1e-6)))


class Beside(IdpLin):
    """A line that lies beside its ends."""

    def support(self, l):
        p0, *rest = super().support(l)
        return p0 + [0.1, 0.0, 0.0], *rest


@pytest.mark.parametrize(
    ("check", "model", "said"),
    [
        (check_motion, spoilt(ConstantTurn(), "velocity", 0), "Jacobian of argument 1"),
        (check_motion, spoilt(ConstantTurn(), "velocity", 0, 1), "velocity is not how the robot moves"),
        (check_landmark, Beside(), "normal(l) is not across the points of l"),
        (check_landmark, spoilt(PlkLin(), "to_frame", 0, by=[-1, -1, 1, 1, 1, 1]), "Jacobian of argument"),
        (check_sensor, spoilt(SegmentCam(K), "segments", 0), "the ends of a segment are not on its line"),
        (check_sensor, spoilt(SegmentCam(K), "segments", 1, by=False), "visible() refuses every edge in front"),
        (check_sensor, spoilt(Doppler(0.1, 0.1), "retro", 0, 1), "project(retro(y)) is not y"),
    ],
)
def test_what_is_wrong_in_itself(check, model, said):
    assert accepted(check, model).startswith(said)


@pytest.mark.parametrize(
    ("visible", "said"),
    [
        (lambda self, y, v: np.full(len(v), False), "visible() refuses all of them: is its sign right?"),
        (lambda self, y, v: True, "visible must give one bool per point, got shape () of"),
    ],
)
@pytest.mark.parametrize("kind", [Doppler, Gps, WheelSpeed])
def test_what_a_sensor_of_states_sees(kind, visible, said):
    cls = type("Blind", (kind,), {"visible": visible})
    assert accepted(check_sensor, cls(0.1, 0.1) if kind is Doppler else cls()).startswith(said)


def test_a_segment_is_seen_in_front_only():
    class Behind(SegmentCam):
        def segments(self, p):
            return super().segments(np.where(p[..., 2:3] < 0, -p, p))

        def visible(self, e, p):
            return self.segments(p)[1] & (p[..., 0] > 0)

    assert accepted(check_sensor, Behind(K)) == "visible() accepts edges behind the sensor"

    class Half(SegmentCam):
        def visible(self, e, p):
            return self.segments(p)[1] & (p[..., 0] > 0)

    assert accepted(check_sensor, Half(K)) == "visible() refuses what segments() sees"


def test_a_ray_to_the_side_of_the_landmark_leads_away_from_it():
    """Not straight away: by more than a right angle. It is measured by the angle, not by single coordinates."""

    class Aside(PointXY):
        bearing_only = True

        def project(self, p):
            r = np.hypot(p[..., 0], p[..., 1])[..., None]
            return r, (p / r)[..., None, :]

        def retro(self, y):
            v = np.array([-0.8, 0.6])
            return y * v, np.broadcast_to(v[:, None], (*np.shape(y)[:-1], 2, 1))

        def visible(self, y, p):
            return (0.1 * p[..., 0] < p[..., 1]) & (p[..., 1] < 0.5 * p[..., 0])

        R = np.eye(1)
        units = ("m",)

    assert accepted(check_sensor, Aside()) == "retro points away from the landmark"


@pytest.mark.parametrize("spoilt_one", ["project", "retro"])
def test_derivatives_of_a_pair_to_a_hundred_thousandth_of_the_largest(spoilt_one):
    """Of each way by itself, there and back."""

    class Spoilt(PointXY):
        by = 0.0

        def project(self, p):
            return p, (1 + self.by * (spoilt_one == "project")) * np.broadcast_to(np.eye(2), (*np.shape(p), 2))

        def retro(self, y):
            return y, (1 + self.by * (spoilt_one == "retro")) * np.broadcast_to(np.eye(2), (*np.shape(y), 2))

    for by, right in ((0.9e-5, True), (1.7e-5, False)):
        Spoilt.by = by
        said = accepted(check_pair, Spoilt(), EucPnt(2))
        assert said is True if right else "differs at entry" in said


@pytest.mark.parametrize("method", ["project", "retro"])
@pytest.mark.parametrize(
    "check",
    [
        lambda sensor: check_states(sensor, ("bias",), EucPnt(2), np.random.default_rng(1)),
        check_parameters,
    ],
    ids=["states", "parameters"],
)
def test_derivatives_of_states_to_a_hundred_thousandth_of_the_largest(check, method):
    """The largest is spoilt, too: so it is its own share that counts, less the 1e-9 of the differences."""
    for by, right in ((0.9e-5, True), (1.7e-5, False)):
        said = accepted(check, spoilt(RangeBearing(0.1, 0.1), method, 1, by=1 + by))
        assert said is True if right else "differs at entry" in said


def test_a_robot_moves_with_its_velocity_to_a_millimetre_a_second():
    class Slow(ConstantTurn):
        by = 0.0

        def velocity(self, x, u):
            V, V_x = super().velocity(x, u)
            return V + [0.0, self.by, 0.0], V_x

    for Slow.by, right in ((0.9e-3, True), (1.2e-3, False)):
        assert (accepted(check_motion, Slow()) is True) == right


CHAINS = [
    (contracts, "observe", lambda: check_pair(RangeBearing(0.1, 0.1), EucPnt(2)), (1, 2, 3)),
    (contracts, "retro_project", lambda: check_pair(RangeBearing(0.1, 0.1), EucPnt(2)), (1, 2, 3)),
    (state_contracts, "observe", lambda: check_pair(Doppler(0.1, 0.1), EucPnt(2)), (1, 2, 3)),
    (state_contracts, "retro_project", lambda: check_pair(Doppler(0.1, 0.1), EucPnt(2)), (1, 2, 3)),
    (state_contracts, "observe", lambda: check_sensor(Gps()), (1, 2)),
    (state_contracts, "observe", lambda: check_sensor(WheelSpeed()), (1, 2)),
    (line_contracts, "observe", lambda: check_pair(SegmentCam(K), PlkLin()), (1, 2, 3)),
    (line_contracts, "retro_project", lambda: check_pair(SegmentCam(K), PlkLin()), (1, 2, 3)),
]


@pytest.mark.parametrize(("module", "name", "check", "numbers"), CHAINS)
def test_every_derivative_of_the_whole_chain_is_asked_for(module, name, check, numbers, monkeypatch):
    """By robot, by sensor, by landmark or measurement; to a hundred-thousandth of the largest."""
    right = getattr(module, name)
    for number in numbers:
        small = name == "retro_project" and number == 3 and module is line_contracts  # a line by a pixel
        for by, well in ((0.9e-5, True), (1e-2 if small else 1.7e-5, False)):
            spoil = lambda out, k=number, by=by: tuple((1 + by) * J if i == k else J for i, J in enumerate(out))
            monkeypatch.setattr(module, name, lambda *args, spoil=spoil: spoil(right(*args)))
            said = accepted(lambda _: check(), None)
            assert said is True if well else "differs at entry" in str(said)
