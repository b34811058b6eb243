"""The vehicle of Victoria Park against the differential equations of its authors, and against circles drawn by hand."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ekfslam_tutorial.geometry import check_jacobians
from ekfslam_tutorial.models import check_motion
from ekfslam_tutorial.models.motion import Unicycle, Vehicle

L, a, b, H = 2.83, 3.78, 0.5, 0.76


def guivant_nebot(t, x, v, steer):
    """Equations (1) to (3) of the paper, for the pose of the laser."""
    phi, tan = x[2], np.tan(steer)
    v_c = v / (1 - tan * H / L)
    return [
        v_c * (np.cos(phi) - tan / L * (a * np.sin(phi) + b * np.cos(phi))),
        v_c * (np.sin(phi) + tan / L * (a * np.cos(phi) - b * np.sin(phi))),
        v_c * tan / L,
    ]


@pytest.mark.parametrize("u", [(3.0, 0.2), (2.0, -0.6), (-0.5, 0.3), (4.0, 0.0)])
def test_it_solves_the_equations_of_its_authors(u):
    x = np.array([-67.0, 41.0, 2.0])
    solution = solve_ivp(guivant_nebot, (0, 0.7), x, args=u, rtol=1e-11, atol=1e-11).y[:, -1]
    np.testing.assert_allclose(Vehicle().move(x, np.array([*u, 0.0]), 0.7)[0], solution, atol=1e-8)


def test_jacobians_at_steering_angles_a_truck_has():
    rng = np.random.default_rng(0)
    for _ in range(20):
        x, u = rng.normal(size=3), np.array([rng.uniform(-2, 7), rng.uniform(-0.7, 0.7), rng.normal(scale=0.2)])
        check_jacobians(lambda x, u: Vehicle().move(x, u, 0.21), x, u)
        check_jacobians(Vehicle().axle, u[:2])


def test_other_vehicles_keep_the_contract():
    check_motion(Vehicle(wheelbase=1.2, ahead=-0.3, left=0.1, track=-0.4))


def test_without_a_mount_it_is_a_unicycle():
    car, u = Vehicle(wheelbase=2.0, ahead=0, left=0, track=0), np.array([3.0, 0.4, 0.0])
    x = np.array([1.0, 2.0, 0.3])
    v, w = 3.0, 3.0 * np.tan(0.4) / 2.0
    np.testing.assert_allclose(car.move(x, u, 0.5)[0], Unicycle().move(x, np.array([v, w]), 0.5)[0], atol=1e-14)


def test_the_laser_keeps_its_distance_from_the_centre_of_the_turn():
    """In a left turn the centre is L / tan(steer) to the left of the rear axle; the measured wheel is nearer to it."""
    car, steer = Vehicle(), 0.35
    radius = L / np.tan(steer)
    laser = np.array([a, b])
    centre = np.array([0.0, radius]) - laser  # seen from the laser, before the turn
    x, angle = np.zeros(3), 0.0
    for _ in range(50):
        x = car.move(x, np.array([2.0, steer, 0.0]), 0.3)[0]
        angle += 2.0 / (radius - H) * 0.3  # the wheel drives 2 m/s on its own circle
        assert np.linalg.norm(x[:2] - centre) == pytest.approx(np.hypot(a, radius - b), abs=1e-10)
        assert x[2] == pytest.approx(angle, abs=1e-10)


def test_a_car_that_slips_goes_where_it_does_not_point():
    """It turns as it would without slip; its axle goes the same way in another direction."""
    car, slip = Vehicle(ahead=0.0, left=0.0), 0.3
    straight, slid = (car.move(np.zeros(3), np.array([2.0, 0.4, s]), 0.5)[0] for s in (0.0, slip))
    assert slid[2] == straight[2]
    assert np.hypot(*slid[:2]) == pytest.approx(np.hypot(*straight[:2]))
    assert np.arctan2(slid[1], slid[0]) - np.arctan2(straight[1], straight[0]) == pytest.approx(slip)


@pytest.mark.parametrize("wrong", [{"wheelbase": 0}, {"wheelbase": -2.0}, {"wheelbase": np.inf}, {"ahead": np.nan}])
def test_what_is_no_vehicle_is_refused(wrong):
    with pytest.raises(ValueError, match="Vehicle: .*got"):
        Vehicle(**wrong)
