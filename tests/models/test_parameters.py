"""Derivatives of both observation models by the cameras' own parameters: intrinsics, distortion, correction."""

from dataclasses import replace

import numpy as np
import pytest

from ekfslam_tutorial.geometry import Frame2, Frame3, check_jacobians
from ekfslam_tutorial.models import (
    Calibrated,
    Moving,
    observe,
    observe_parameters,
    retro_project,
    retro_project_parameters,
    state_class,
)
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.observation import expect
from ekfslam_tutorial.models.sensors import BearingOnly2, Doppler, OmniCam, PinHole, PinHoleDepth, RangeBearing
from ekfslam_tutorial.models.state_contracts import AnyRobot, robot_state
from ekfslam_tutorial.models.trials import random_frame

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


STATES = [
    (RangeBearing(0.1, 0.1), ("bias",), EucPnt(2)),
    (Doppler(0.1, 0.1), ("delay", "bias"), EucPnt(2)),
    (BearingOnly2(0.1), ("bias", "delay"), AhmPnt(2)),
    (PinHole(d=(-0.3, 0.1)), ("bias", "k", "d"), IdpPnt()),
    (PinHole(d=(-0.3, 0.1)), ("f", "delay"), HmgPnt()),
    (PinHoleDepth(d=(-0.25,)), ("f", "bias"), EucPnt()),
]


@pytest.mark.parametrize(("sensor", "names", "lmk"), STATES, ids=lambda value: str(value)[:20])
def test_a_stack_of_landmarks_with_parameters_that_are_states(sensor, names, lmk, rng):
    """Of many measurements and many landmarks at once as of each; and of none at all."""
    free, F = Calibrated(sensor, names), Frame2 if sensor.dim == 2 else Frame3
    x, a = robot_state(F, rng), free.start + 0.01 * rng.normal(size=len(free.start))
    Rf = Moving(AnyRobot(F), x) if hasattr(free, "asks_robot") else F(x[: F.size])
    Sf = state_class(F, free)(np.concatenate([random_frame(F, rng).x, a]))
    p = np.eye(sensor.dim)[-1] * 3 + 0.3 * rng.normal(size=(5, sensor.dim))
    y = sensor.project(np.concatenate([p, np.zeros((5, F.dof))], -1) if isinstance(sensor, Doppler) else p)[0]
    n = np.full((5, 1), 0.3) if sensor.bearing_only else np.zeros((5, 0))
    births = retro_project(Rf, Sf, free, lmk, y, n)
    l = births[0]
    seen = expect(Rf, Sf, free, lmk, l)
    for i in range(5):
        for stack, one in (
            (births, retro_project(Rf, Sf, free, lmk, y[i], n[i])),
            (seen, expect(Rf, Sf, free, lmk, l[i])),
        ):
            for out, single in zip(stack, one, strict=True):
                out = np.broadcast_to(out, (5, *np.shape(single)))
                np.testing.assert_allclose(out[i], single, rtol=1e-9, atol=1e-12)
    at = [slice(F.size + s.start, F.size + s.stop) for s in free.slices().values()]
    assert all(np.shape(J)[-1] == Sf.size for J in (births[2], seen[3])) and at[-1].stop == Sf.size
    for name, s in zip(names, at, strict=True):
        assert name == "delay" or (np.abs(seen[3][..., s]).max() > 0 and np.abs(births[2][..., s]).max() > 0)
    assert [np.shape(out)[0] for out in expect(Rf, Sf, free, lmk, l[:0])] == [0] * 5
    v = expect(Rf, Sf, free, lmk, l)[1]
    assert free.visible(seen[0], v).shape == (5,)


def test_what_a_sensor_with_parameters_sees_is_told_without_its_bias(rng):
    """A pixel at the border of the image, with a bias: it is where the lens has put it that counts."""
    free = Calibrated(PinHole(), ("bias",))
    v, y = np.array([0.0, 0.0, 2.0, 5.0, -3.0]), np.array([0.0, 0.0])
    assert free.visible(y + [5.0, -3.0], v) and not free.visible(y + [4.9, -3.0], v)
    assert free.visible(y, v[:3]) and not free.visible(y, v)


@pytest.mark.parametrize("names", [("k",), ("f", "bias"), ("d", "bias", "f")])
def test_a_camera_at_other_parameters(names):
    """`f` multiplies both focal lengths of k as it was; numbers stand in the order of the names."""
    camera = PinHole((320.0, 240.0, 300.0, 330.0), (-0.3, 0.1))
    free = Calibrated(camera, names)
    values = {"k": [310.0, 250.0, 280.0, 350.0], "f": [330.0], "d": [-0.2, 0.05], "bias": [0.5, -0.5]}
    model, bias = free.at(np.concatenate([values[name] for name in names]))
    k = (320.0, 240.0, 330.0, 363.0) if "f" in names else tuple(values["k"])
    assert np.allclose(model.k, k) and model.d == (tuple(values["d"]) if "d" in names else camera.d)
    assert np.array_equal(bias, values["bias"]) if "bias" in names else bias == 0.0
    starts = {"k": camera.k, "f": [300.0], "d": camera.d, "bias": [0.0, 0.0]}
    assert np.array_equal(free.start, np.concatenate([starts[name] for name in names]))
