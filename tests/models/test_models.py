"""What single models promise beyond their contract: values known by other means, limits, and bad parameters."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, numerical_jacobian, wrap
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry2, Odometry3, Unicycle
from ekfslam_tutorial.models.sensors import BearingOnly2, OmniCam, PinHole, PinHoleDepth, RangeBearing
from ekfslam_tutorial.models.sensors.lens import distort, inv_distortion, undistort
from ekfslam_tutorial.models.sensors.pin_hole import pin_hole

from .examples import OMNI_D, OMNI_K, K

# --- motion ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("w", [0.0, 1e-9, 0.9e-3, 1.1e-3, 0.5, -2.0])
def test_a_unicycle_drives_the_arc_that_small_steps_add_up_to(w):
    """One exact step against 20 000 straight ones (Euler, midpoint heading: error of order dt^2)."""
    x, u, dt, n = np.array([1.0, -2.0, 0.7]), np.array([1.5, w]), 0.1, 20_000
    headings = x[2] + w * dt * (np.arange(n) + 0.5) / n
    end = x[:2] + u[0] * dt / n * np.array([np.cos(headings).sum(), np.sin(headings).sum()])
    assert np.allclose(Unicycle().move(x, u, dt)[0], [*end, x[2] + w * dt], atol=1e-11)


def test_a_circle_closes():
    x = np.array([0.3, 0.4, 0.5])
    end = x
    for _ in range(8):
        end = Unicycle().move(end, np.array([1.0, 2 * np.pi / 8]), 1.0)[0]
    assert np.allclose(end, x + [0, 0, 2 * np.pi])


def test_odometry_in_the_plane_and_in_space_are_the_same_motion():
    flat = Odometry2().move(np.array([1.0, 2.0, 0.4]), np.array([0.3, -0.1, 0.2]), 1.0)[0]
    q = lambda a: [np.cos(a / 2), 0, 0, np.sin(a / 2)]
    deep = Odometry3().move(np.array([1.0, 2.0, 0.0, *q(0.4)]), np.array([0.3, -0.1, 0, 0, 0, 0.2]), 1.0)[0]
    assert np.allclose(deep, [*flat[:2], 0, *q(flat[2])])


def test_constant_velocity_adds_up():
    """Many short steps with a constant rate are one long step: the quaternion is exact, not of first order."""
    x = np.concatenate([np.zeros(3), [1.0, 0, 0, 0], [1.0, 2.0, 3.0], [0.1, -0.2, 0.3]])
    end = x
    for _ in range(10):
        end = ConstantVelocity().move(end, np.zeros(6), 0.1)[0]
    assert np.allclose(end, ConstantVelocity().move(x, np.zeros(6), 1.0)[0])
    pushed = ConstantVelocity().move(x, np.arange(6.0), 0.1)[0]
    assert np.allclose(pushed[7:] - x[7:], np.arange(6.0))


# --- sensors ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sensor, column", [(RangeBearing(0.1, 0.02), 1), (BearingOnly2(0.02), 0)])
def test_the_difference_of_bearings_takes_the_short_way(sensor, column):
    n = len(sensor.R)
    y, e = np.zeros(n), np.zeros(n)
    y[column], e[column] = np.pi - 0.01, -np.pi + 0.02
    assert sensor.residual(y, e)[column] == pytest.approx(-0.03)
    assert sensor.residual(e, y)[column] == pytest.approx(0.03)
    y[column], e[column] = np.pi, 0.0
    assert sensor.residual(y, e)[column] == pytest.approx(np.pi)
    stack = sensor.residual(np.tile(y, (3, 2, 1)), e)
    assert stack.shape == (3, 2, n)


def test_residual_leaves_its_arguments_alone():
    y = np.array([1.0, 4.0])
    RangeBearing(0.1, 0.02).residual(y, np.zeros(2))
    assert np.array_equal(y, [1.0, 4.0])


def test_field_of_view_and_range():
    sensor = RangeBearing(0.1, 0.02, max_range=5.0, fov=np.pi / 2)
    points = np.array([[1.0, 0.0], [1.0, 0.99], [1.0, 1.01], [-1.0, 0.0], [4.9, 0.0], [5.1, 0.0]])
    assert sensor.visible(sensor.project(points)[0], points).tolist() == [True, True, False, False, True, False]


def test_a_landmark_on_top_of_the_sensor_has_no_bearing_and_is_not_visible():
    sensor, p = RangeBearing(0.1, 0.02), np.zeros(2)
    y, Y_p = sensor.project(p)
    assert y[0] == 0 and not np.isfinite(Y_p).all() and not sensor.visible(y, p)


def test_image_borders_belong_to_the_image():
    camera = PinHole(K)
    for u, seen in (([0.0, 0.0], True), ([640.0, 480.0], True), ([640.1, 240.0], False), ([320.0, -0.1], False)):
        assert bool(camera.visible(np.array(u), np.array([0.0, 0.0, 1.0]))) == seen


def test_pin_hole_by_hand():
    u, U_p, U_k, U_d = pin_hole(np.array([1.0, 2.0, 4.0]), K, np.array([0.1]))
    factor = 1 + 0.1 * (0.25**2 + 0.5**2)
    assert np.allclose(u, [320 + 300 * 0.25 * factor, 240 + 310 * 0.5 * factor])
    args = np.array([1.0, 2.0, 4.0]), np.array(K), np.array([0.1])
    for i, J in enumerate((U_p, U_k, U_d)):
        f = lambda x, i=i: pin_hole(*args[:i], x, *args[i + 1 :])[0]
        assert np.allclose(J, numerical_jacobian(f, args[i]), rtol=1e-6, atol=1e-6)


def test_the_correction_vector_is_a_fit_that_gets_better():
    """Each number more takes off a third of the root-mean-square error; no vector of that length fits better."""
    d, k = np.array([-0.3, 0.1]), (320.0, 240.0, 320.0, 320.0)
    r = np.linspace(0, 1.1 * np.hypot(1.0, 0.75), 101)
    up = np.stack([r, np.zeros_like(r)], -1)
    errors = lambda c: undistort(distort(up, d)[0], c)[0][:, 0] - r
    norms = []
    for n in (1, 2, 3, 4):
        c = inv_distortion(d, n, k)
        assert len(c) == n
        norms.append(np.linalg.norm(errors(c)))
        for step in (*np.eye(n), *-np.eye(n)):
            assert np.linalg.norm(errors(c + 1e-3 * step)) > norms[-1]
    assert all(b < a * 2 / 3 for a, b in zip(norms, norms[1:], strict=False))
    assert inv_distortion([], 1, k).size == 0


def test_depth_is_along_the_axis_and_not_the_range():
    camera = PinHoleDepth(K)
    assert camera.project(np.array([3.0, 0.0, 4.0]))[0][2] == 4.0


def test_polynomials_of_the_omnidirectional_camera_are_each_others_fit():
    """Calibration gives both, so a pixel comes back within a fraction of a pixel, not exactly."""
    fitted = OmniCam(OMNI_K, OMNI_D, c=(447.3, 0.0, -0.001068, 1.184e-06, -1.856e-09))
    exact = OmniCam(OMNI_K, OMNI_D)
    for y in np.array([[700.0, 500.0], [300.0, 250.0], [1000.0, 600.0]]):
        v, w = fitted.retro(y)[0], exact.retro(y)[0]
        assert np.allclose(exact.project(w)[0], y, atol=1e-9)
        assert np.linalg.norm(fitted.project(v)[0] - y) < 1.5
        assert np.degrees(np.arccos(v @ w / np.linalg.norm(v) / np.linalg.norm(w))) < 0.3


# --- landmarks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lmk", [IdpPnt(), AhmPnt(), HmgPnt()])
def test_the_prior_is_an_inverse_distance(lmk):
    """Whatever the length of the ray: from the birth place to the point it is 1 / n metres."""
    v = np.array([1.0, -2.0, 5.0])
    for scale in (1.0, 447.3):
        l, *_ = lmk.from_ray(scale * v, np.array([0.25]))
        assert np.linalg.norm(lmk.point(l)[0]) == pytest.approx(4.0)


@pytest.mark.parametrize("lmk", [IdpPnt(), AhmPnt()])
def test_linearity_falls_as_the_distance_becomes_known(lmk):
    """L = 4 sigma_d / d |cos a|, written out for a camera at the birth place: 4 sigma_rho / rho."""
    l, *_ = lmk.from_ray(np.array([0.0, 0.6, 0.8]), np.array([0.5]))
    P = np.zeros((lmk.size, lmk.size))
    for std in (0.1, 0.01):
        P[-1, -1] = std**2
        assert lmk.linearity(l, P, np.zeros(3)) == pytest.approx(4 * std / 0.5)
    beside = lmk.point(l)[0] + np.array([2.0, 0.0, 0.0])  # seen at a right angle, an error in depth is in the image
    assert lmk.linearity(l, P, beside) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("lmk", [IdpPnt(), AhmPnt()])
def test_an_inverse_distance_is_brought_back_ahead(lmk):
    l = np.arange(1.0, lmk.size + 1)
    assert np.array_equal(lmk.ahead(l, 0.001), l)
    l[-1] = -0.2
    back = lmk.ahead(l, 0.001)
    assert back[-1] == 0.001 and np.array_equal(back[:-1], l[:-1]) and l[-1] == -0.2


def test_a_homogeneous_point_at_infinity_is_not_moved_by_a_translation():
    l = np.array([0.6, 0.0, 0.8, 0.0])
    F = Frame3(np.array([5.0, -3.0, 2.0, 1, 0, 0, 0]))
    assert np.array_equal(HmgPnt().to_frame(F, l)[0], l)


def test_a_euclidean_point_in_the_plane():
    F = Frame2(np.array([1.0, 2.0, np.pi / 2]))
    assert np.allclose(EucPnt(2).to_frame(F, np.array([1.0, 5.0]))[0], [3.0, 0.0])
    assert wrap(RangeBearing(0.1, 0.1).project(np.array([0.0, -1.0]))[0][1]) == pytest.approx(-np.pi / 2)


# --- bad parameters --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make, said",
    [
        (lambda: PinHole((320, 240, 0, 320)), r"k = \[u0, v0, au, av\] is singular, au and av must not be zero"),
        (lambda: PinHole((320, 240, 320)), "k must be 4 finite numbers, got"),
        (lambda: PinHole((320, 240, 320, np.nan)), "k must be 4 finite numbers, got"),
        (lambda: PinHole(K, image_size=(640, 0)), "image_size must be two positive numbers"),
        (lambda: PinHole(K, image_size=(640, 480, 3)), "image_size must be 2 finite numbers"),
        (lambda: PinHole(K, pixel_std=-1.0), "pixel_std must be a positive number, got -1.0"),
        (lambda: PinHole(K, d=(np.inf,)), "d must be a list of finite numbers"),
        (lambda: PinHole(K, c=((0.1,),)), "c must be a list of finite numbers"),
        (lambda: PinHoleDepth(K, depth_std=0.0), "depth_std must be a positive number, got 0.0"),
        (lambda: OmniCam((668, 438, 1.0, 2.0, 0.5), OMNI_D), "is singular, c - d e must not be zero"),
        (lambda: RangeBearing(0.0, 0.1), "range_std must be a positive number, got 0.0"),
        (lambda: RangeBearing(0.1, 0.1, fov=-1.0), "fov must be a positive number"),
        (lambda: BearingOnly2(np.nan), "bearing_std must be a positive number, got nan"),
    ],
)
def test_bad_parameters_are_named(make, said):
    with pytest.raises(ValueError, match=said):
        make()
