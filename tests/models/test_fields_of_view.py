"""What a sensor sees does not depend on how its bearing is written; parameters that make no model are refused."""

import numpy as np
import pytest

from ekfslam_tutorial.models import contracts
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt
from ekfslam_tutorial.models.motion import Odometry2
from ekfslam_tutorial.models.sensors import BearingOnly2, RangeBearing, RangeBearingElevation
from ekfslam_tutorial.slam.upkeep import well_inside

SENSORS = {
    "range and bearing": lambda fov: RangeBearing(0.1, 0.02, max_range=10.0, fov=fov),
    "bearing": lambda fov: BearingOnly2(0.02, max_range=10.0, fov=fov),
}


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
@pytest.mark.parametrize("name", SENSORS)
def test_a_bearing_beyond_pi(name, turns):
    """A limited field of view, 90 degrees: inside, outside, on both sides, and behind."""
    sensor = SENSORS[name](np.pi / 2)
    bearings = np.array([0.0, 0.7, -0.7, 0.9, -0.9, 3.0, -3.0, np.pi])
    p = 2 * np.stack([np.cos(bearings), np.sin(bearings)], -1)
    y = sensor.project(p)[0]
    y[..., -1] = bearings + 2 * np.pi * turns
    wanted = [True, True, True, False, False, False, False, False]
    assert sensor.visible(y, p).tolist() == wanted
    assert [well_inside(sensor, one, 0.0) for one in y] == wanted


@pytest.mark.parametrize("name", SENSORS)
def test_a_view_of_more_than_half_a_turn(name):
    """270 degrees: what is behind is not seen, what is at the back of each side is."""
    sensor = SENSORS[name](1.5 * np.pi)
    bearings = np.array([0.0, 2.0, -2.0, 2.3, -2.3, 2.4, -2.4, np.pi])
    p = 2 * np.stack([np.cos(bearings), np.sin(bearings)], -1)
    assert sensor.visible(sensor.project(p)[0], p).tolist() == [True] * 5 + [False] * 3


@pytest.mark.parametrize("name", SENSORS)
def test_the_edges_belong_to_the_view(name):
    sensor = SENSORS[name](np.pi / 2)
    edge = np.array([np.pi / 4, -np.pi / 4])
    p = 10 * np.stack([np.cos(edge), np.sin(edge)], -1)
    y = sensor.project(p)[0]
    y[..., -1] = edge
    p, y = np.clip(p, -7.07, 7.07), np.where(y > 9, 10.0, y)
    assert sensor.visible(y, p).all()
    y[..., -1] *= 1 + 1e-9
    assert not sensor.visible(y, p).any()


@pytest.mark.parametrize(
    ("make", "limit"),
    [
        (lambda fov: RangeBearing(0.1, 0.02, fov=fov), 2 * np.pi),
        (lambda fov: BearingOnly2(0.02, fov=fov), 2 * np.pi),
        (lambda std: RangeBearing(0.1, std), np.pi),
        (lambda std: BearingOnly2(std), np.pi),
        (lambda fov: RangeBearingElevation(fov=fov), 2 * np.pi),
        (lambda fov: RangeBearingElevation(fov_up=fov), np.pi),
        (lambda std: RangeBearingElevation(bearing_std=std), np.pi),
        (lambda std: RangeBearingElevation(elevation_std=std), np.pi),
    ],
)
def test_angles_that_are_meant_in_degrees(make, limit):
    """A whole turn is an angle, with its rounding; more is none."""
    make(limit)
    make(limit * (1 + 1e-12))
    with pytest.raises(ValueError, match="is in radians and at most .* degrees"):
        make(limit * (1 + 1e-6))


@pytest.mark.parametrize("name", ["max_range", "fov", "bearing_std"])
def test_only_a_range_may_be_infinite(name):
    for make in (lambda **more: RangeBearing(**{"range_std": 0.1, "bearing_std": 0.1} | more), BearingOnly2):
        given = {"bearing_std": 0.1, name: np.inf}
        if name == "max_range":
            assert make(**given).max_range == np.inf
        else:
            with pytest.raises(ValueError, match=f"{name} must be a positive number, got inf"):
                make(**given)


@pytest.mark.parametrize("c", [((0.1, 0.2),), (((0.1,),),), 3.0, "text", None])
def test_a_list_of_numbers_is_one_row(c):
    from ekfslam_tutorial.models.sensors import PinHole

    with pytest.raises(ValueError, match="d must be a list of finite numbers"):
        PinHole(d=c)


@pytest.mark.parametrize("kind", [EucPnt, AhmPnt, HmgPnt])
def test_landmarks_are_in_the_plane_or_in_space(kind):
    assert [kind(dim).dim for dim in (2, 3)] == [2, 3]
    for dim in (1, 4, "3", None):
        with pytest.raises(ValueError, match=f"{kind.__name__}: dim must be 2 or 3, got {dim!r}"):
            kind(dim)


@pytest.mark.parametrize(
    ("check", "kind"),
    [(contracts.check_motion, Odometry2), (contracts.check_sensor, RangeBearing), (contracts.check_landmark, EucPnt)],
)
def test_a_class_is_no_model(check, kind):
    with pytest.raises(TypeError, match=rf"give an instance, {kind.__name__}\(...\), not the class"):
        check(kind)
