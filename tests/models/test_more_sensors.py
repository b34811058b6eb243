"""Stereo, Davison's lens, spherical coordinates, places and ranges, each against a formula written another way."""

import numpy as np
import pytest

from ekfslam_tutorial.models.motion import Ackermann, DifferentialDrive, Unicycle, Vehicle
from ekfslam_tutorial.models.sensors import (
    BearingOnly2,
    DavisonCam,
    OmniCam,
    PinHole,
    PinHoleDepth,
    PointXY,
    PointXYZ,
    Range,
    RangeBearing,
    RangeBearingElevation,
    StereoPinHole,
)

K = (320.0, 240.0, 300.0, 310.0)


def test_stereo_is_two_cameras(rng):
    """The right one stands 0.3 m to the right: its pixel is u - d."""
    stereo, left = StereoPinHole(K, 0.3), PinHole(K)
    p = rng.uniform([-1, -1, 2], [1, 1, 5], (50, 3))
    y, right = stereo.project(p)[0], left.project(p - [0.3, 0, 0])[0]
    assert np.allclose(y[:, :2], left.project(p)[0])
    assert np.allclose(y[:, 0] - y[:, 2], right[:, 0]) and np.allclose(y[:, 1], right[:, 1])


def test_the_noise_of_stereo_is_that_of_four_pixels(rng):
    """20,000 draws: each entry of the covariance within 5 of its own standard deviations, 2 / sqrt(20000) at most."""
    sensor = StereoPinHole(K, 0.3, pixel_std=1.5)
    n = rng.normal(0, 1.5, (20_000, 4))  # u_l, v_l, u_r, v_r
    y = np.stack([n[:, 0], (n[:, 1] + n[:, 3]) / 2, n[:, 0] - n[:, 2]], -1)
    assert np.abs(np.cov(y.T) - sensor.R).max() < 5 * 2 / np.sqrt(20_000) * sensor.R.max()


@pytest.mark.parametrize(
    "sensor, stds",
    [
        (RangeBearing(0.3, 0.05), [0.3, 0.05]),
        (RangeBearingElevation(0.3, 0.05, 0.07), [0.3, 0.05, 0.07]),
        (BearingOnly2(0.05), [0.05]),
        (Range(0.3), [0.3]),
        (PointXY(0.3), [0.3, 0.3]),
        (PointXYZ(0.3), [0.3, 0.3, 0.3]),
        (PinHole(K, pixel_std=3.0), [3.0, 3.0]),
        (DavisonCam(pixel_std=3.0), [3.0, 3.0]),
        (OmniCam((668.0, 438.0, 1.01, 0.002, -0.003), (644.7, -341.0), pixel_std=3.0), [3.0, 3.0]),
        (PinHoleDepth(K, pixel_std=3.0, depth_std=0.3), [3.0, 3.0, 0.3]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_noise_is_told_as_standard_deviations(sensor, stds):
    assert np.allclose(sensor.R, np.diag(np.square(stds)), rtol=1e-15, atol=0)


def test_stereo_sees_what_is_in_both_images():
    sensor = StereoPinHole(K, 0.3)
    for p, seen in (([0, 0, 3], True), ([-3.0, 0, 3], False), ([0, 0, 120.0], False), ([0, 0, -3], False)):
        p = np.array(p, float)
        assert bool(sensor.visible(sensor.project(p)[0], p)) == seen


def test_a_margin_makes_the_image_smaller():
    for sensor in (PinHole(K, margin=20.0), StereoPinHole(K, 0.3, margin=20.0), DavisonCam(margin=20.0)):
        y = np.array([[19.0, 100.0, 5.0], [30.0, 100.0, 5.0]])[:, : len(sensor.R)]
        assert list(sensor.inside(y)) == [False, True]
    with pytest.raises(ValueError, match="PinHole: margin must be less than 240, half of the image, got 300"):
        PinHole(K, margin=300)


def test_davisons_lens_is_its_equation(rng):
    """Solved the other way round: the undistorted radius that gives a distorted one, by the published formula."""
    cam = DavisonCam()
    y = rng.uniform([5, 5], [315, 235], (100, 2))
    centre = np.array(cam.k[:2])
    r_d = np.linalg.norm(y - centre, axis=1, keepdims=True)
    r_u = r_d / np.sqrt(1 - 2 * cam.k1 * r_d**2)
    assert np.allclose(r_u / np.sqrt(1 + 2 * cam.k1 * r_u**2), r_d)
    ideal = PinHole(cam.k, image_size=cam.image_size).project(cam.retro(y)[0])[0]
    assert np.allclose(np.linalg.norm(ideal - centre, axis=1, keepdims=True), r_u)


def test_without_a_coefficient_it_is_a_pin_hole(rng):
    p = rng.uniform([-1, -1, 2], [1, 1, 5], (50, 3))
    cam = DavisonCam(k1=0.0)
    for got, want in zip(cam.project(p), PinHole(cam.k).project(p), strict=True):
        assert np.allclose(got, want)


def test_a_pixel_that_no_ray_gives_is_no_number():
    assert np.isnan(DavisonCam(k1=1e-4).retro(np.array([310.0, 230.0]))[0]).any()


def test_on_the_horizon_it_is_range_and_bearing(rng):
    p = rng.normal(size=(50, 2)) * 4
    e = RangeBearingElevation().project(np.c_[p, np.zeros(50)])[0]
    assert np.allclose(e[:, :2], RangeBearing(0.1, 0.1).project(p)[0]) and np.allclose(e[:, 2], 0)


def test_elevation_is_up():
    assert np.allclose(RangeBearingElevation().project(np.array([1.0, 0.0, 1.0]))[0], [np.sqrt(2), 0, np.pi / 4])


def test_a_field_of_view_has_a_width_and_a_height():
    sensor = RangeBearingElevation(fov=np.pi / 2, fov_up=np.pi / 6)
    for p, seen in (([3, 0, 0], True), ([3, 2.9, 0], True), ([3, 3.1, 0], False), ([3, 0, 1.0], False)):
        p = np.array(p, float)
        assert bool(sensor.visible(sensor.project(p)[0], p)) == seen


def test_a_place_is_the_point_itself(rng):
    p = rng.normal(size=(5, 2))
    y, Y_p = PointXY(0.1).project(p)
    assert np.array_equal(y, p) and np.array_equal(Y_p, np.broadcast_to(np.eye(2), (5, 2, 2)))


def test_a_range_has_a_bias_and_cannot_start_a_landmark():
    y, _ = Range(0.1, bias=0.5).project(np.array([3.0, 4.0]))
    assert np.allclose(y, 5.5) and not hasattr(Range(0.1), "retro")


def test_wheels_and_steering_are_the_same_arc(rng):
    x, v, w = rng.normal(size=3), 1.3, 0.4
    want = Unicycle().move(x, np.array([v, w]), 0.2)[0]
    assert np.allclose(DifferentialDrive(0.5).move(x, np.array([v - 0.25 * w, v + 0.25 * w]), 0.2)[0], want)
    assert np.allclose(Ackermann(2.5).move(x, np.array([v, np.arctan(2.5 * w / v)]), 0.2)[0], want)
    truck = Vehicle(wheelbase=2.5, ahead=0.0, left=0.0, track=0.0)
    assert np.allclose(truck.move(x, np.array([v, np.arctan(2.5 * w / v), 0.0]), 0.2)[0], want)


@pytest.mark.parametrize(
    "make, sentence",
    [
        (lambda: DifferentialDrive(0), "base must be a positive number of metres, got 0"),
        (lambda: Ackermann(-1), "wheelbase must be a positive number of metres, got -1"),
        (lambda: PointXY(0), "std must be a positive number, got 0"),
        (lambda: Range(0.1, dim=4), "dim must be 2 or 3, got 4"),
        (lambda: Range(0.1, bias=np.nan), "bias must be a finite number of metres, got nan"),
        (lambda: StereoPinHole((1, 1, 0, 1)), "needs au and av above zero"),
        (lambda: StereoPinHole(baseline=0), "baseline must be a positive number, got 0"),
        (lambda: DavisonCam(k1=np.inf), "k1 must be a finite number, got inf"),
        (lambda: RangeBearingElevation(bearing_std=10), "bearing_std is in radians and at most 3.142, got 10; degrees"),
    ],
)
def test_what_makes_no_model_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
