"""Derivatives of both observation models by the cameras' own parameters: intrinsics, distortion, correction."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame3, check_jacobians
from ekfslam_tutorial.models import observe, observe_parameters, retro_project, retro_project_parameters
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.sensors import OmniCam, PinHole, PinHoleDepth

FORWARD = (644.7, -341.0, -29.01, -57.7, 18.49, 5.415, 50.65, -56.14, 15.91, 0.0, 0.0)
CAMERAS = [
    PinHole(),
    PinHole(d=(-0.3,)),
    PinHole(d=(-0.3, 0.1)),
    PinHole(d=(-0.3, 0.1), c=(0.29, 0.36, -0.37)),
    PinHoleDepth(d=(-0.25, 0.08, 0.01)),
    PinHoleDepth(d=(-0.3, 0.1), c=(0.29, 0.36, -0.37)),
    OmniCam(k=(668.0, 438.0, 1.0, 0.01, 0.02), d=FORWARD),
]


def _pairs():
    for camera in CAMERAS:
        for lmk in (IdpPnt(), AhmPnt(), HmgPnt()) if camera.bearing_only else (EucPnt(), IdpPnt(), AhmPnt()):
            yield pytest.param(camera, lmk, id=f"{type(camera).__name__}-{camera.d}-{camera.c}-{type(lmk).__name__}")


@pytest.mark.parametrize(("camera", "lmk"), list(_pairs()))
@pytest.mark.parametrize("seed", range(3))
def test_parameter_jacobians(camera, lmk, seed):
    rng = np.random.default_rng(seed)
    Rf, Sf = (Frame3(rng.normal(size=7)).normalized()[0] for _ in range(2))
    y = camera.project(np.array([0.3, -0.2, 2.0]) + 0.1 * rng.normal(size=3))[0]
    n = np.array([0.3]) if camera.bearing_only else np.zeros(0)
    l = retro_project(Rf, Sf, camera, lmk, y, n)[0]
    inverse = "d" if camera.c is None else "c"  # what the inverse model depends on
    k, d, c = (np.array(getattr(camera, name), float) for name in ("k", "d", inverse))

    def direct(k, d):
        return observe_parameters(Rf, Sf, replace(camera, k=tuple(k), d=tuple(d)), lmk, l)

    def back(k, c):
        changed = replace(camera, **{"k": tuple(k), inverse: tuple(c)})
        return retro_project_parameters(Rf, Sf, changed, lmk, y, n)

    assert np.allclose(direct(k, d)[0], observe(Rf, Sf, camera, lmk, l)[0], rtol=1e-12)  # of the same models
    assert np.allclose(back(k, c)[0], l, rtol=1e-12)
    check_jacobians(direct, k, d, rtol=1e-5)  # differences of numbers near 1000 pixels
    check_jacobians(back, k, c, rtol=1e-5)


@pytest.mark.parametrize("camera", [CAMERAS[2], CAMERAS[3], CAMERAS[4], CAMERAS[6]], ids=lambda c: type(c).__name__)
def test_stack_of_landmarks(camera):
    lmk, rng = IdpPnt() if camera.bearing_only else EucPnt(), np.random.default_rng(0)
    Rf, Sf = (Frame3(rng.normal(size=7)).normalized()[0] for _ in range(2))
    y = camera.project(np.array([0.3, -0.2, 2.0]) + 0.1 * rng.normal(size=(5, 3)))[0]
    n = np.array([0.3]) if camera.bearing_only else np.zeros(0)
    l = retro_project(Rf, Sf, camera, lmk, y, n)[0]
    for stack, one in (
        (observe_parameters(Rf, Sf, camera, lmk, l), lambda i: observe_parameters(Rf, Sf, camera, lmk, l[i])),
        (
            retro_project_parameters(Rf, Sf, camera, lmk, y, n),
            lambda i: retro_project_parameters(Rf, Sf, camera, lmk, y[i], n),
        ),
    ):
        for out, single in zip(stack, one(3), strict=True):
            assert np.shape(out) == (5, *np.shape(single))
            np.testing.assert_allclose(out[3], single, atol=1e-12)
