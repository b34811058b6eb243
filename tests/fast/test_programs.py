"""What the tracer writes down computes what the model computes, for every model of the package.

Tolerances: both sides do the same operations on floats, in another order; the few hundred of them that lead to a number
leave some 1e-13 of the largest one, and 1e-9 leaves room for differences of nearly equal numbers in between.
"""

import copy

import numpy as np
import pytest

from ekfslam_tutorial.fast import FastMap, augment, covariance, cross
from ekfslam_tutorial.fast.compiled import step
from ekfslam_tutorial.fast.straight import inside
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q, wrap
from ekfslam_tutorial.models import retro_project
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import (
    Ackermann,
    ConstantVelocity,
    DifferentialDrive,
    Imu,
    Odometry2,
    Odometry3,
    Unicycle,
    Vehicle,
)
from ekfslam_tutorial.models.observation import expect
from ekfslam_tutorial.models.sensors import (
    BearingOnly2,
    DavisonCam,
    OmniCam,
    PinHole,
    PinHoleDepth,
    PointXY,
    RangeBearing,
    RangeBearingElevation,
    StereoPinHole,
)
from ekfslam_tutorial.slam import Rob, Sen

pytestmark = pytest.mark.usefixtures("interpreted")

K, D, C = (320.0, 240.0, 300.0, 310.0), (-0.3, 0.1), (0.3, 0.17, 0.1)
OMNI_K = (668.0, 438.0, 1.01, 0.002, -0.003)
OMNI_D = (644.7, -341.0, -29.01, -57.7, 18.49, 5.415, 50.65, -56.14, 15.91)
OMNI_C = (370.0, 0.0, -6e-4, -1e-8, -1e-11)
FORWARD = np.concatenate([[0.1, 0.0, 0.5], e2q(np.radians([-90, 0, -90]))[0]])

SENSORS = {
    "RangeBearing": RangeBearing(0.1, 0.02),
    "RangeBearing, near and ahead": RangeBearing(0.1, 0.02, max_range=8.0, fov=2.0),
    "BearingOnly2": BearingOnly2(0.02),
    "BearingOnly2, near and ahead": BearingOnly2(0.02, max_range=8.0, fov=2.0),
    "PinHole": PinHole(K),
    "PinHole, d": PinHole(K, D),
    "PinHole, d and c": PinHole(K, D, c=C),
    "PinHoleDepth": PinHoleDepth(K),
    "PinHoleDepth, d": PinHoleDepth(K, D),
    "PinHoleDepth, d and c": PinHoleDepth(K, D, c=C),
    "OmniCam": OmniCam(OMNI_K, OMNI_D, fov=3.0),
    "OmniCam, c": OmniCam(OMNI_K, OMNI_D, c=OMNI_C, fov=3.0),
    "DavisonCam": DavisonCam(K, 2e-6, image_size=(640, 480), margin=7.0),
    "StereoPinHole": StereoPinHole(K, 0.3),
    "RangeBearingElevation": RangeBearingElevation(max_range=9.0, fov=5.0, fov_up=2.0),
    "PointXY": PointXY(max_range=8.0),
}
KINDS = {2: (EucPnt(2), HmgPnt(2), AhmPnt(2)), 3: (EucPnt(3), HmgPnt(3), AhmPnt(3), IdpPnt())}
EXACT = "PinHole, d", "PinHoleDepth, d", "OmniCam"
"""The inverse of the lens is found by Newton's method, which ends by itself: not traceable."""

PAIRS = [pytest.param(name, kind, id=f"{name}-{kind}") for name, s in SENSORS.items() for kind in KINDS[s.dim]]


MOTION_IN = {2: Odometry2(), 3: Odometry3()}
SEEN_OR_NOT = (slice, True), (bool, False)
NOT_COMPILED = (type(None), True), (type(None), False)


def compilable(name, kind):
    """Return True if a new landmark of this type can be started by compiled code."""
    bearing_only = SENSORS[name].bearing_only
    return name not in EXACT and not (bearing_only and isinstance(kind, EucPnt))


def frames(dim, rng):
    """A robot and a sensor on it, anywhere."""
    if dim == 2:
        return Frame2(rng.uniform([-3, -3, -4], [3, 3, 4])), Frame2(rng.uniform([-0.3, -0.3, -4], [0.3, 0.3, 4]))
    q = np.concatenate([rng.normal(size=3), rng.normal(size=4)])
    q[3:] /= np.linalg.norm(q[3:]) * rng.uniform(0.99, 1.01)  # of norm one but nearly
    return Frame3(q), Frame3(FORWARD + 0.01 * rng.normal(size=7))


def points(dim, rng, n=30):
    """Points in a sensor's frame: two thirds of them in front, the others anywhere."""
    p = rng.uniform([-4] * dim, [4] * dim, (n, dim))
    p[: n // 3 * 2, -1 if dim == 3 else 0] = rng.uniform(1, 9, n // 3 * 2)
    return p


SPECIAL = {
    2: [[0, 0], [-3, 1e-13], [-3, -1e-13], [-3, 0], [-3, -0.0], [8, 0], [8 + 1e-9, 0], [0, 2], [1e-300, 0], [-1, 0]],
    3: [[0, 0, 0], [0, 0, 3], [0, 0, -3], [1, 1, 0], [1, 1, 1e-300], [1e-9, 0, 2], [3, 3, 3], [0, 5, 0], [1, 1, -1]],
}
"""Where something ends or has no meaning: at the sensor, on its axis, at the back, on the border of the view."""


def landmarks(F, kind, p):
    """Landmarks of a type at these points, seen from F; with an inverse distance also at -rho and zero."""
    with np.errstate(all="ignore"):
        l = kind.from_frame(F, kind.from_point(p)[0])[0]
    if not isinstance(kind, EucPnt):
        behind, far = l.copy(), l[-4:].copy()
        behind[:, -1] *= -1
        far[:, -1] = 0.0
        l = np.concatenate([l, behind, far])
    return l[np.isfinite(l).all(-1)]


def same(got, expected):
    """Up to rounding."""
    return np.allclose(got, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max(initial=1e-300))


def agree(sensor, got, e):
    """The same for measurements, where pi and -pi are the same angle."""
    return np.abs(sensor.residual(got, e)).max(initial=0.0) <= 1e-9 * np.abs(e).max(initial=0.0)


def full(J, K):
    """A Jacobian for each of K landmarks."""
    return np.broadcast_to(J, (K, *J.shape[-2:]))


@pytest.mark.parametrize(("name", "kind"), PAIRS)
def test_expectations_are_those_of_the_model(name, kind, rng):
    sensor, seen = SENSORS[name], 0
    for _ in range(3):
        Rf, Sf = frames(sensor.dim, rng)
        l = landmarks(Rf.compose(Sf)[0], kind, points(sensor.dim, rng))
        map = FastMap()
        r, s = map.add(Rf.x, np.eye(Rf.size)), map.add(Sf.x, np.eye(Sf.size))
        at = [map.add(x, np.eye(len(x))) for x in l]
        A = rng.normal(size=map.P.shape)
        map.P[:] = A @ A.T
        rows = np.array([np.arange(a.start, a.stop) for a in at])
        with np.errstate(all="ignore"):
            e, v, *J = expect(Rf, Sf, sensor, kind, l)
            visible = sensor.visible(e, v) & np.isfinite(full(J[2], len(l))).all((-1, -2))
        got = step.expected(map, Rf, Sf, sensor, kind, l, r, s, rows, True)
        assert got is not None, "no longer compiled"
        assert np.array_equal(got[2], visible)
        J = [full(each, len(l)) for each in J]
        assert agree(sensor, got[0][visible], e[visible]) and same(got[1][visible], v[visible])
        assert same(got[3][visible], np.concatenate(J, -1)[visible])
        for k in np.flatnonzero(visible):
            blocks = (r, J[0][k]), (s, J[1][k]), (at[k], J[2][k])
            assert same(got[4][k], covariance(cross(map, blocks), blocks))
        seen += visible.sum()
        whole, visible = got[4], got[2]
        E = step.expected(map, Rf, Sf, sensor, kind, l, r, s, rows, False)[4]
        assert np.array_equal(E[visible], whole[visible]) and np.isnan(E[~visible]).all()
    assert seen > 10


@pytest.mark.parametrize(("name", "kind"), PAIRS)
def test_the_same_are_visible_where_a_model_is_singular(name, kind):
    """All frames are the world's, so that nothing is rounded on the way to the sensor."""
    sensor = SENSORS[name]
    F = Frame2(np.zeros(3)) if sensor.dim == 2 else Frame3(np.eye(7)[3])
    l = landmarks(F, kind, np.array(SPECIAL[sensor.dim], float))
    with np.errstate(all="ignore"):
        e, v, *_, E_l = expect(F, F, sensor, kind, l)
        visible = sensor.visible(e, v) & np.isfinite(full(E_l, len(l))).all((-1, -2))
    got = step.expected(FastMap(), F, F, sensor, kind, l, None, None, None, True)
    assert np.array_equal(got[2], visible) and visible.any()
    assert agree(sensor, got[0][visible], e[visible])
    assert same(got[3][visible][..., -kind.size :], full(E_l, len(l))[visible])


@pytest.mark.parametrize(("name", "kind"), PAIRS)
def test_new_landmarks_are_those_of_the_model_wherever_they_can_be_compiled(name, kind, rng):
    sensor = SENSORS[name]
    N, m = (np.array([[0.2]]), len(sensor.R)) if sensor.bearing_only else (np.zeros((0, 0)), len(sensor.R))
    seen = 0
    for _ in range(20):
        Rf, Sf = frames(sensor.dim, rng)
        map, r, s = FastMap(), *(None, None)
        r, s = map.add(Rf.x, np.eye(Rf.size)), map.add(Sf.x, np.eye(Sf.size))
        A = rng.normal(size=map.P.shape)
        map.P[:] = A @ A.T
        y = rng.uniform(*{1: ([-4], [4]), 2: ([1, -4], [9, 4]), 3: ([0, 0, 1], [640, 480, 9])}[m])
        if sensor.dim == 3:
            y[:2] = rng.uniform([100, 100], [540, 380])
        if name == "RangeBearingElevation":
            y = rng.uniform([-1, -4, -2], [10, 4, 2])
        n, R = np.full(len(N), 0.3), 2.0 * sensor.R
        other = copy.deepcopy(map)
        rob, sen = Rob(1, MOTION_IN[sensor.dim], r=r), Sen(1, 1, sensor, type(Sf), r=s)
        got = step.born(map, rob, sen, (Rf.x, Sf.x), kind, y, n, R, N)
        visible = bool(np.all(sensor.visible(y, sensor.retro(y)[0])))
        assert (type(got), visible) in (SEEN_OR_NOT if compilable(name, kind) else NOT_COMPILED)
        seen += visible
        if not got:
            assert map.n == other.n
            continue
        l, L_r, L_s, L_y, L_n = retro_project(Rf, Sf, sensor, kind, y, n)
        assert got == augment(other, l, ((r, L_r), (s, L_s)), L_y @ R @ L_y.T + L_n @ N @ L_n.T)
        assert same(map.x, other.x) and same(map.P, other.P) and np.array_equal(map.P, map.P.T)
    assert seen


@pytest.mark.parametrize("name", SENSORS)
def test_a_measurement_is_inside_where_the_model_says_so(name, rng):
    sensor = SENSORS[name]
    low, high = ([-10, -10], [700, 500]) if sensor.dim == 3 else ([-1, -4], [10, 4])
    low, high = (np.append(low, -1), np.append(high, 9)) if len(sensor.R) == 3 else (low, high)
    low, high = (low[1:], high[1:]) if len(sensor.R) == 1 else (low, high)
    low, high = ([-1, -4, -2], [10, 4, 2]) if name == "RangeBearingElevation" else (low, high)
    Y = rng.uniform(low, high, (60, len(sensor.R)))
    got = [inside(sensor, y) for y in Y]
    assert got == [bool(sensor.visible(y, sensor.retro(y)[0])) for y in Y]
    assert all(type(each) is bool for each in got) and (all(got) or len(set(got)) == 2)


@pytest.mark.parametrize("name", SENSORS)
def test_innovations_are_those_of_the_model(name, rng):
    """Also of angles that differ by pi. Each of 20 of 200 landmarks has another one of 40 measurements."""
    sensor = SENSORS[name]
    m = len(sensor.R)
    y, e = rng.uniform(-7, 7, (40, m)), rng.uniform(-7, 7, (200, m))
    y[:4], e[:4] = [[np.pi], [-np.pi], [2.0], [2.0 - np.pi]], [[-np.pi], [np.pi], [2.0 - np.pi], [2.0]]
    found, index = [0, 1, 2, 3, *range(100, 116)], [0, 1, 2, 3, *range(39, 23, -1)]
    map, J, E = FastMap(compiled=True), np.zeros((200, m, 6)), np.zeros((200, m, m))
    map.add(np.zeros(3), np.eye(3))
    places = slice(0, 3), None, None
    z, passed = step.correct_found(map, sensor, places, 3, J, e, E, None, found, index, y, np.eye(m), np.inf)
    assert np.array_equal(z, sensor.residual(y[index], e[found])) and passed == found


# --- motion ----------------------------------------------------------------------------------------------------------

MOTIONS = {
    "Odometry2": (Odometry2(), [0.5, 0.1, 0.3]),
    "Odometry3": (Odometry3(), [0.5, 0.1, -0.2, 0.1, -0.2, 0.3]),
    "ConstantVelocity": (ConstantVelocity(), [0.1, -0.2, 0.3, 0.05, 0.02, 0.3]),
    "Unicycle": (Unicycle(), [1.2, 0.3]),
    "Vehicle": (Vehicle(), [5.0, 0.2, 0.01]),
    "Ackermann": (Ackermann(), [5.0, 0.2]),
    "DifferentialDrive": (DifferentialDrive(), [0.5, 0.6]),
    "Imu": (Imu(), [0.1, -0.2, 0.3, 0.5, 0.2, 9.0, *[1e-3] * 6]),
}


def motions(name, rng):
    """A model, states and controls: any, and those for which the models have series."""
    model, u = MOTIONS[name]
    u = np.array(u)
    for factor in (1.0, -1.0, 0.0, 1e-3, 1e-4, 9.99e-5, 1e-5, 1e-8, 1e-160):
        yield model, rng.normal(size=model.size), np.where(np.arange(len(u)) < (3 if len(u) == 6 else 1), u, factor * u)
        yield model, rng.normal(size=model.size), factor * u


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("dt", [0.1, 0.0, 2.0])
def test_motions_are_those_of_the_model(name, dt, rng):
    """And those that turn in the plane have a heading in its normal form, before and after."""
    for model, x, u in motions(name, rng):
        if name == "ConstantVelocity":
            x[10:] *= u[-1]  # small turn rates are in the state
        map = FastMap()
        map.add(np.zeros(2), np.eye(2))
        r = map.add(x, np.eye(len(x)))
        map.add(np.zeros(3), np.eye(3))
        A, B = rng.normal(size=map.P.shape), rng.normal(size=(len(u), len(u)))
        map.P[:] = A @ A.T
        U, before = B @ B.T, map.P.copy()
        plane = model.frame is Frame2
        x2, X_x, X_u = model.move(np.r_[x[:2], wrap(x[2]), x[3:]] if plane else x, u, dt)
        x2[2] = wrap(x2[2]) if plane else x2[2]
        J = np.eye(map.n)
        J[r, r] = X_x
        P = J @ before @ J.T
        P[r, r] += X_u @ U @ X_u.T
        assert step.move(map, r, model, u, U, dt), "no longer compiled"
        assert same(map.x[r], x2) and same(map.P, P) and np.array_equal(map.P, map.P.T)


def test_a_quaternion_is_normalised_as_the_frame_does_it(rng):
    for size in (1e-3, 1.0, 50.0):
        map = FastMap()
        map.add(np.zeros(2), np.eye(2))
        r = map.add(size * rng.normal(size=13), np.eye(13))
        A = rng.normal(size=map.P.shape)
        map.P[:] = A @ A.T
        N, N_f = Frame3(map.x[r][:7]).normalized()
        J = np.eye(map.n)
        J[2:9, 2:9] = N_f
        P, x = J @ map.P @ J.T, map.x.copy()
        x[2:9] = N.x
        assert step.normalized(map, r, Frame3)
        assert same(map.x, x) and same(map.P, P)


def test_a_heading_is_wrapped_by_a_branch_so_that_is_not_compiled():
    map = FastMap()
    assert not step.normalized(map, map.add([0.0, 0.0, 4.0], np.eye(3)), Frame2)
