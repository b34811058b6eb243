"""How wrong a model may be before a contract test says so: what is just within a tolerance, and what is just beyond."""

from dataclasses import dataclass

import numpy as np
import pytest

from ekfslam_tutorial.models import check_landmark, check_motion, check_pair, check_sensor
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import PointXY, RangeBearing
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


# --- each derivative of a landmark is asked for ---


def spoilt(lmk, method, number):
    """A landmark type one of whose Jacobians is too large by a hundredth; values are right."""

    class Spoilt(type(lmk)):
        pass

    def wrong(self, *args):
        out = list(getattr(super(Spoilt, self), method)(*args))
        out[number] = 1.01 * out[number]
        return tuple(out)

    setattr(Spoilt, method, wrong)
    return Spoilt(lmk.dim)


@pytest.mark.parametrize(
    ("lmk", "method", "argument"),
    [(EucPnt(2), method, k) for method in ("to_frame", "from_frame") for k in (1, 2)]
    + [(EucPnt(2), method, 1) for method in ("point", "ray", "from_point")]
    + [(AhmPnt(2), "from_ray", k) for k in (1, 2)],
)
def test_every_derivative_of_a_landmark_is_asked_for(lmk, method, argument):
    said = accepted(check_landmark, spoilt(lmk, method, argument))
    assert said.startswith(f"Jacobian of argument {argument} differs at entry")


@pytest.mark.parametrize("argument", [1, 2])
def test_every_derivative_of_a_motion_is_asked_for(argument):
    class Spoilt(Odometry2):
        def move(self, x, u, dt):
            out = list(super().move(x, u, dt))
            out[argument] = 1.01 * out[argument]
            return tuple(out)

    assert accepted(check_motion, Spoilt()).startswith(f"Jacobian of argument {argument} differs at entry")


@pytest.mark.parametrize("method", ["project", "retro"])
def test_every_derivative_of_a_sensor_is_asked_for(method):
    class Spoilt(RangeBearing):
        pass

    def wrong(self, a):
        value, J = getattr(super(Spoilt, self), method)(a)
        return value, 1.01 * J

    setattr(Spoilt, method, wrong)
    assert accepted(check_sensor, Spoilt(0.1, 0.1)).startswith("Jacobian of argument 1 differs at entry")


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
