"""Jacobians of the whole observation chain where it is nearly singular, for every sensor with every landmark."""

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, check_jacobians, e2q, wrap
from ekfslam_tutorial.models import observe, retro_project, to_sensor
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.sensors import OmniCam, PinHole, PinHoleDepth, RangeBearingElevation

from .differences import of_stacks
from .examples import LENSES, OMNI_D, OMNI_K, POINT_PAIRS, K, dim, ready

pytestmark = pytest.mark.usefixtures("all_at_once")
RDF = e2q(np.radians([-90, 0, -90]))[0]  # a camera that looks ahead
HALF_TURNS = [np.array([0.0, 1, 0, 0]), np.array([0.0, 0, 1, 0]), np.array([0.0, 0, 0, 1])]


def poses(d, rng):
    """Robot and sensor frames: ordinary ones, none at all, and half turns."""
    if d == 2:
        angles = [(0.3, -0.7), (0.0, 0.0), (np.pi, np.pi), (np.pi, -np.pi / 2)]
        return [[Frame2(np.append(rng.normal(size=2), a)) for a in pair] for pair in angles]
    at = lambda q: Frame3(np.concatenate([rng.normal(size=3), q])).normalized()[0]
    quaternions = [(rng.normal(size=4), rng.normal(size=4)), (np.eye(4)[0], RDF), *((q, RDF) for q in HALF_TURNS)]
    return [[at(q) for q in pair] for pair in quaternions]


def ahead(sensor):
    """Unit vector along the middle of the view."""
    return np.eye(dim(sensor))[0 if dim(sensor) == 2 or isinstance(sensor, RangeBearingElevation) else -1]


def sideways(sensor):
    return np.eye(dim(sensor))[1]


def placed(Rf, Sf, lmk, p, rho=None):
    """A landmark at the point p of the sensor frame; with an inverse distance of its own, if it has one."""
    if rho is None:
        ls = lmk.from_point(p)[0]
    else:
        ls = lmk.from_ray(p, np.array([rho]))[0]
    return lmk.from_frame(Rf, lmk.from_frame(Sf, ls)[0])[0]


def check_direct(Rf, Sf, sensor, lmk, l, rtol=1e-6):
    """Jacobians of `observe`, against differences. Pixels and their derivatives are large: tolerances are relative."""
    check_jacobians(lambda R, S, l: of_stacks(observe)(R, S, sensor, lmk, l), Rf, Sf, l, rtol=rtol)


def check_inverse(Rf, Sf, sensor, lmk, y, n, **tolerances):
    """Jacobians of `retro_project`, against differences that do not step over the seam of a yaw at pi."""
    l0 = retro_project(Rf, Sf, sensor, lmk, y, n)[0]

    def f(R, S, y, n):
        l, *Ls = of_stacks(retro_project)(R, S, sensor, lmk, y, n)
        if isinstance(lmk, IdpPnt):
            l[..., 4] = l0[4] + wrap(l[..., 4] - l0[4])
        return l, *Ls

    check_jacobians(f, Rf, Sf, y, n, **tolerances)


@pytest.mark.parametrize("sensor, lmk", POINT_PAIRS)
@pytest.mark.parametrize("off_axis, rtol", [(1e-1, 1e-6), (1e-3, 1e-5)])
def test_near_the_axis(sensor, lmk, off_axis, rtol, rng):
    """The error of a difference quotient of step h is (h / off_axis)^2 for a camera with a pole on its axis."""
    sensor, lmk = ready(sensor), ready(lmk)
    for Rf, Sf in poses(dim(sensor), rng):
        p = 3.0 * (ahead(sensor) + off_axis * sideways(sensor))
        check_direct(Rf, Sf, sensor, lmk, placed(Rf, Sf, lmk, p), rtol)


@pytest.mark.parametrize("sensor, lmk", POINT_PAIRS)
def test_on_the_axis(sensor, lmk, rng):
    """An omnidirectional camera has no derivative there, and says so; all others have."""
    sensor, lmk = ready(sensor), ready(lmk)
    for Rf, Sf in poses(dim(sensor), rng):
        l = placed(Rf, Sf, lmk, 3.0 * ahead(sensor))
        if not isinstance(sensor, OmniCam):
            check_direct(Rf, Sf, sensor, lmk, l)
    e, E_p = sensor.project(3.0 * ahead(sensor))
    assert np.isfinite(e).all() and np.isfinite(E_p).all() == (not isinstance(sensor, OmniCam))


@pytest.mark.parametrize("sensor, lmk", POINT_PAIRS)
def test_behind(sensor, lmk, rng):
    """The formulas hold behind the sensor as well; only a sensor that sees all round sees anything there."""
    sensor, lmk = ready(sensor), ready(lmk)
    for Rf, Sf in poses(dim(sensor), rng):
        p = -2.0 * ahead(sensor) + 0.4 * sideways(sensor)
        l = placed(Rf, Sf, lmk, p)
        check_direct(Rf, Sf, sensor, lmk, l)
        e, *_ = observe(Rf, Sf, sensor, lmk, l)
        v, *_ = to_sensor(Rf, Sf, sensor, lmk, l)
        all_round = not hasattr(sensor, "image_size") and getattr(sensor, "fov", 2 * np.pi) == 2 * np.pi
        assert bool(sensor.visible(e, v)) == all_round


PROJECTIVE = [p for p in POINT_PAIRS if p.values[0].bearing_only and hasattr(p.values[1], "from_ray")]


@pytest.mark.parametrize("rho", [0.3, 1e-3, 1e-9, 0.0])
@pytest.mark.parametrize("sensor, lmk", PROJECTIVE)
def test_inverse_distance_down_to_zero(sensor, lmk, rho, rng):
    """A ray is a point up to scale: a landmark at infinity is no special case for a bearing."""
    for Rf, Sf in poses(dim(sensor), rng):
        l = placed(Rf, Sf, lmk, ahead(sensor) + 0.2 * sideways(sensor), rho)
        aside = l.copy()
        aside[-1] = max(rho, 2e-6)  # a difference quotient across zero would have one foot behind the sensor
        check_direct(Rf, Sf, sensor, lmk, aside)
        e, *_, E_l = observe(Rf, Sf, sensor, lmk, l)
        assert np.isfinite(e).all() and np.isfinite(E_l).all()
        v, *_ = to_sensor(Rf, Sf, sensor, lmk, l)
        assert sensor.visible(e, v)


@pytest.mark.parametrize("sensor, lmk", [p for p in PROJECTIVE if dim(p.values[0]) == 3])
@pytest.mark.parametrize("rho", [-1e-9, -0.01, -0.3])
def test_a_negative_inverse_distance_lies_behind(sensor, lmk, rho, rng):
    """Seen from where it was born, such a landmark is on the other side: not visible, though the Jacobian is right."""
    for Rf, Sf in poses(3, rng):
        l = placed(Rf, Sf, lmk, ahead(sensor) + 0.2 * sideways(sensor), 0.3)
        l[-1] = rho
        if isinstance(lmk, HmgPnt):  # its direction starts at the origin of the world: turn all of it round
            l = -placed(Rf, Sf, lmk, -(ahead(sensor) + 0.2 * sideways(sensor)), -rho)
        e, *_ = observe(Rf, Sf, sensor, lmk, l)
        v, *_ = to_sensor(Rf, Sf, sensor, lmk, l)
        assert not sensor.visible(e, v)
        if rho < -1e-6:
            check_direct(Rf, Sf, sensor, lmk, l)


@pytest.mark.parametrize("sensor, lmk", PROJECTIVE)
def test_births_with_any_prior(sensor, lmk, rng):
    for Rf, Sf in poses(dim(sensor), rng):
        y = sensor.project(ahead(sensor) + 0.3 * sideways(sensor))[0]
        for n in (0.0, 0.01, -0.1):
            check_inverse(Rf, Sf, sensor, lmk, y, np.array([n]))


@pytest.mark.parametrize("lmk", [IdpPnt(), AhmPnt(), HmgPnt()])
def test_births_exactly_on_the_optical_axis(lmk, rng):
    """The yaw of a direction along z has no meaning; the chain of Jacobians goes through it all the same."""
    camera = PinHole(K)
    for Rf, Sf in poses(3, rng):
        y, n = np.array(K[:2]), np.array([0.2])
        l, *_ = retro_project(Rf, Sf, camera, lmk, y, n)
        back, *_ = observe(Rf, Sf, camera, lmk, l)
        assert np.allclose(back, y, atol=1e-5)  # 1e-8 rad off the axis, 3e-6 px
        check_inverse(Rf, Sf, camera, lmk, y, n, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("kind", [IdpPnt, AhmPnt, HmgPnt])
def test_all_point_types_agree_about_one_point(kind, rng):
    """The same point, however it is stored, gives the same pixel and the same sensitivity to the frames."""
    camera, lmk, euc = PinHole(K, LENSES[2]), kind(), EucPnt()
    for Rf, Sf in poses(3, rng):
        p = np.array([0.4, -0.3, 5.0])
        l = placed(Rf, Sf, lmk, p)
        e, E_r, E_s, E_l = observe(Rf, Sf, camera, lmk, l)
        point, P_l = lmk.point(l)
        want, W_r, W_s, W_p = observe(Rf, Sf, camera, euc, point)
        assert np.allclose(e, want, atol=1e-9)
        T = tangent(Rf), tangent(Sf)
        assert np.allclose(E_r @ T[0], W_r @ T[0], atol=1e-7) and np.allclose(E_s @ T[1], W_s @ T[1], atol=1e-7)
        assert np.allclose(E_l, W_p @ P_l, atol=1e-7)


def tangent(F):
    """Directions that keep the norm of the quaternion."""
    P = np.eye(7)
    P[3:, 3:] -= np.outer(F.q, F.q) / (F.q @ F.q)
    return P


@pytest.mark.parametrize("cls", [PinHole, PinHoleDepth])
@pytest.mark.parametrize("d", [(), (-0.05,), (0.2,), *LENSES[2:]])
def test_distortion_there_and_back(cls, d):
    """Over the whole image, corners included; without a correction vector the inverse is exact."""
    camera = cls(K, d)
    u, v = np.meshgrid(np.linspace(0, 640, 9), np.linspace(0, 480, 7))
    y = np.stack([u, v, *([np.full_like(u, 3.0)] if cls is PinHoleDepth else [])], -1)
    back = camera.project(camera.retro(y)[0])[0]
    assert np.allclose(back, y, atol=1e-8)


def test_beyond_the_fold_of_the_lens_nothing_is_seen():
    """A strong barrel distortion folds the image back: one pixel, two directions. Only the inner one counts."""
    camera = PinHole((320.0, 240.0, 320.0, 320.0), (-0.3,))
    inner, outer = np.array([0.5, 0.0, 1.0]), np.array([1.5, 0.0, 1.0])
    for p, seen in ((inner, True), (outer, False)):
        assert bool(camera.visible(camera.project(p)[0], p)) == seen
    assert camera.fold == pytest.approx(1 / np.sqrt(0.9))
    assert PinHole(K).fold == np.inf


def test_the_omnidirectional_camera_sees_half_of_the_world():
    camera = OmniCam(OMNI_K, OMNI_D, image_size=(1400, 1400))
    for z, seen in ((0.2, True), (-0.2, False)):
        p = np.array([0.5, -0.5, z])
        assert bool(camera.visible(camera.project(p)[0], p)) == seen
