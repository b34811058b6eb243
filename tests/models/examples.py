"""Example objects of every exported model. A model whose parameters all have defaults needs no entry here.

Tests are parametrised over what `models.motion`, `models.sensors` and `models.landmarks` export, so a new class is
tested as soon as it is exported; if it cannot be made without arguments, the tests ask for an entry.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from ekfslam_tutorial.models import landmarks, motion, sensors
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import Unicycle
from ekfslam_tutorial.models.sensors import (
    BearingOnly2,
    Compass,
    DavisonCam,
    Doppler,
    Gps,
    OmniCam,
    PinHole,
    PinHoleDepth,
    Range,
    RangeBearing,
    RangeRate,
    SegmentCam,
    StereoPinHole,
)

K = (320.0, 240.0, 300.0, 310.0)
LENSES = [(), (-0.3,), (-0.3, 0.1), (-0.25, 0.08, 0.01)]  # distortion vectors of length 0 to 3
OMNI_K = (668.0, 438.0, 1.01, 0.002, -0.003)
OMNI_D = (644.7, -341.0, -29.01, -57.7, 18.49, 5.415, 50.65, -56.14, 15.91)

EXAMPLES = {
    "Unicycle": [Unicycle()],
    "PinHole": [PinHole(K, d) for d in LENSES],
    "PinHoleDepth": [PinHoleDepth(K, d) for d in LENSES],
    "OmniCam": [OmniCam(OMNI_K, OMNI_D, image_size=(1280, 960), fov=3.0)],
    "RangeBearing": [RangeBearing(0.1, 0.02), RangeBearing(0.1, 0.02, max_range=8.0, fov=2.0)],
    "DavisonCam": [DavisonCam(), DavisonCam(k1=0.0, margin=10.0), DavisonCam(k1=-2e-6)],
    "StereoPinHole": [StereoPinHole(K, 0.3, margin=4.0)],
    "SegmentCam": [SegmentCam(K, d) for d in LENSES],
    "Range": [Range(0.1), Range(0.1, bias=0.5, max_range=9.0, dim=3)],
    "BearingOnly2": [BearingOnly2(0.02), BearingOnly2(0.02, fov=2.0)],
    "Doppler": [Doppler(0.1, 0.02), Doppler(0.1, 0.02, 8.0, 2.0, rate_std=0.05)],
    "RangeRate": [RangeRate(0.1), RangeRate(0.1, 9.0, dim=3)],
    "Gps": [Gps(), Gps(0.3, dim=3)],
    "Compass": [Compass(), Compass(0.01, -0.1, dim=3)],
    "EucPnt": [EucPnt(2), EucPnt(3)],
    "HmgPnt": [HmgPnt(2), HmgPnt(3)],
    "AhmPnt": [AhmPnt(2), AhmPnt(3)],
    "IdpPnt": [IdpPnt()],
}


@dataclass(frozen=True)
class Beacon:
    """A sensor from outside the package: a range only, nothing that could start a landmark, so no `retro`."""

    R: ClassVar = np.array([[0.01]])
    dim: ClassVar = 2
    bearing_only: ClassVar = False

    def project(self, p):
        r = np.linalg.norm(p, axis=-1, keepdims=True)
        return r, (p / r)[..., None, :]

    def residual(self, y, e):
        return np.subtract(y, e)

    def visible(self, y, p):
        return y[..., 0] < 20


def examples(module):
    """Examples of all classes that a module exports, as pytest parameters.

    A class without an example becomes a parameter that is an error message.
    """
    return [param for name in module.__all__ for param in of(module, name)]


def of(module, name):
    """Examples of one exported class."""
    found = EXAMPLES.get(name)
    if found is None:
        try:
            found = [getattr(module, name)()]
        except TypeError:
            text = f"{name} is exported from {module.__name__} and needs arguments: add an example of it to EXAMPLES"
            return [pytest.param(text, id=f"{name}-without-example")]
    return [pytest.param(model, id=f"{name}-{i}") for i, model in enumerate(found)]


def ready(model):
    """The model, or a failed test with the message that stands in its place."""
    if isinstance(model, str):
        pytest.fail(model)
    return model


def dim(model):
    """Dimension of the world that a model lives in."""
    return getattr(model, "dim", 3)


MOTIONS, SENSORS, LANDMARKS = examples(motion), examples(sensors), examples(landmarks)
PAIRS = [
    pytest.param(s.values[0], l.values[0], id=f"{s.id}-{l.id}")
    for s in SENSORS
    for l in LANDMARKS
    if isinstance(s.values[0], str) or isinstance(l.values[0], str) or dim(s.values[0]) == dim(l.values[0])
]

POINT_PAIRS = [
    p
    for p in PAIRS
    if not any(hasattr(p.values[0], name) for name in ("innovation", "asks_robot", "without_lmks"))
    and not hasattr(p.values[1], "normal")
]
