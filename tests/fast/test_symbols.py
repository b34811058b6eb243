"""What the tracer writes down computes what the model computes: all models of the package, and plain numpy.

Tolerances: both sides do the same operations on floats, in another order; the few hundred of them that lead to a number
leave some 1e-13 of the largest one, and 1e-9 leaves room for differences of nearly equal numbers in between.
"""

import inspect
from dataclasses import dataclass
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from ekfslam_tutorial.fast.symbols import NotTraceable, Symbol, Symbols, Tape
from ekfslam_tutorial.geometry import Frame2, Frame3, e2q
from ekfslam_tutorial.models import check_landmark, check_motion, check_sensor, expect, observe, retro_project
from ekfslam_tutorial.models.landmarks import AhmPnt, EucPnt, HmgPnt, IdpPnt
from ekfslam_tutorial.models.motion import ConstantVelocity, Odometry2, Odometry3, Unicycle, Vehicle
from ekfslam_tutorial.models.sensors import BearingOnly2, OmniCam, PinHole, PinHoleDepth, RangeBearing

NAMES = {"atan2": "arctan2", "atan": "arctan", "asin": "arcsin", "acos": "arccos"}
SAME = "cos", "sin", "tan", "sqrt", "exp", "log", "sinh", "cosh", "tanh", "hypot"
MATH = SimpleNamespace(**{name: getattr(np, NAMES.get(name, name)) for name in (*SAME, *NAMES)})
"""The functions of Python's math, but infinite or NaN where those raise: as compiled code does it."""


def program(function, *inputs):
    """Return a function of numbers that does what `function` has done with symbols.

    Each input is the length of a vector, or None for a single number; a stack of one of each vector is handed over.
    """
    tape = Tape()
    args = [tape.note(f"u{i}") if n is None else tape.inputs(f"u{i}[{{}}]", n)[None] for i, n in enumerate(inputs)]
    results = function(*args)

    def run(*numbers):
        known, values = {"math": MATH} | {f"u{i}": np.asarray(x, float)[()] for i, x in enumerate(numbers)}, []
        value = lambda x: values[x.at] if isinstance(x, Symbol) else np.float64(x)
        with np.errstate(all="ignore"):
            for template, args in tape.operations:
                names = {f"a{i}": value(x) for i, x in enumerate(args)}
                values.append(eval(template.format(*names) if args else template, known | names))
        return [np.vectorize(value, otypes=[float])(np.array(x, object)) if np.size(x) else x for x in results]

    return run


def same(got, expected):
    """Up to rounding."""
    expected = np.asarray(expected, float)
    scale = np.abs(expected[np.isfinite(expected)]).max(initial=1e-300)
    return np.allclose(got, expected, rtol=1e-9, atol=1e-9 * scale, equal_nan=True)


# --- the models of the package ---------------------------------------------------------------------------------------

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
}
KINDS = {2: (EucPnt(2), HmgPnt(2), AhmPnt(2)), 3: (EucPnt(3), HmgPnt(3), AhmPnt(3), IdpPnt())}
EXACT = "PinHole, d", "PinHoleDepth, d", "OmniCam"
"""The inverse of the lens is found by Newton's method, which ends by itself: not traceable."""

PAIRS = [pytest.param(name, kind, id=f"{name}-{kind}") for name, s in SENSORS.items() for kind in KINDS[s.dim]]


def frames(dim, rng):
    """A robot and a sensor on it, anywhere."""
    if dim == 2:
        return Frame2(rng.uniform([-3, -3, -4], [3, 3, 4])), Frame2(rng.uniform([-0.3, -0.3, -4], [0.3, 0.3, 4]))
    q = np.concatenate([rng.normal(size=3), rng.normal(size=4)])
    q[3:] /= np.linalg.norm(q[3:]) * rng.uniform(0.99, 1.01)  # of norm one but nearly
    return Frame3(q), Frame3(FORWARD + 0.01 * rng.normal(size=7))


def measurements(sensor, rng, n):
    """Measurements inside and outside of the view."""
    low, high = ([1, -4], [10, 4]) if sensor.dim == 2 else ([-10, -10, 1], [700, 500, 9])
    m = len(sensor.R)
    low, high = (low[1:], high[1:]) if m == 1 else (low[:m], high[:m])
    return rng.uniform(low, high, (n, m))


@pytest.mark.parametrize(("name", "kind"), PAIRS)
def test_expectations_and_what_is_visible(name, kind, rng):
    sensor, seen = SENSORS[name], 0
    F = Frame2 if sensor.dim == 2 else Frame3

    def expected(r, s, l):
        e, v, E_r, E_s, E_l = expect(F(r[0]), F(s[0]), sensor, kind, l)
        return e, v, E_r, E_s, E_l, sensor.visible(e, v), kind.point(l)[0]

    run = program(expected, F.size, F.size, kind.size)
    for _ in range(20):
        Rf, Sf = frames(sensor.dim, rng)
        p = rng.uniform([-4] * sensor.dim, [4] * sensor.dim)
        p[-1 if sensor.dim == 3 else 0] = rng.uniform(1, 9)
        l = kind.from_frame(Rf.compose(Sf)[0], kind.from_point(p)[0])[0]
        if rng.random() < 0.2 and kind.size > kind.dim:
            l[-1] *= -1
        *got, visible, point = run(Rf.x, Sf.x, l)
        *want, want_visible, want_point = expected(Rf.x[None], Sf.x[None], l[None])
        assert all(same(a, b) for a, b in zip(got[1:], want[1:], strict=True)) and same(point, want_point)
        assert np.abs(sensor.residual(got[0], want[0])).max() <= 1e-9 * np.abs(want[0]).max()
        assert np.array_equal(visible, want_visible)
        seen += visible.sum()
    assert seen > 5


@pytest.mark.parametrize(("name", "kind"), PAIRS)
def test_new_landmarks(name, kind, rng):
    sensor = SENSORS[name]
    F, m, n = (Frame2 if sensor.dim == 2 else Frame3), len(sensor.R), int(sensor.bearing_only)
    born = lambda r, s, y, n: retro_project(F(r[0]), F(s[0]), sensor, kind, y, n)
    if name in EXACT or (sensor.bearing_only and isinstance(kind, EucPnt)):
        with pytest.raises(TypeError):
            program(born, F.size, F.size, m, n)
        return
    run = program(born, F.size, F.size, m, n)
    for y in measurements(sensor, rng, 5):
        Rf, Sf = frames(sensor.dim, rng)
        got = run(Rf.x, Sf.x, y, np.full(n, 0.3))
        for a, b in zip(got, born(Rf.x[None], Sf.x[None], y[None], np.full((1, n), 0.3)), strict=True):
            assert same(np.broadcast_to(a, b.shape), b)


@pytest.mark.parametrize("name", SENSORS)
def test_a_measurement_is_inside_and_an_innovation(name, rng):
    sensor = SENSORS[name]
    m = len(sensor.R)
    inside = lambda y: [sensor.visible(y, sensor.retro(y)[0])]
    residual = lambda y, e: [sensor.residual(y, e)]
    Y = measurements(sensor, rng, 40)
    z = program(residual, m, m)
    for y, e in zip(Y, Y[::-1], strict=True):
        assert np.array_equal(z(y, e)[0][0], sensor.residual(y, e))
    if name in EXACT:
        with pytest.raises(TypeError):
            program(inside, m)
    else:
        run = program(inside, m)
        assert [bool(run(y)[0][0]) for y in Y] == [bool(sensor.visible(y, sensor.retro(y)[0])) for y in Y]


MOTIONS = {
    "Odometry2": (Odometry2(), [0.5, 0.1, 0.3]),
    "Odometry3": (Odometry3(), [0.5, 0.1, -0.2, 0.1, -0.2, 0.3]),
    "ConstantVelocity": (ConstantVelocity(), [0.1, -0.2, 0.3, 0.05, 0.02, 0.3]),
    "Unicycle": (Unicycle(), [1.2, 0.3]),
    "Vehicle": (Vehicle(), [5.0, 0.2, 0.01]),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_motions(name, rng):
    """Any controls, and those for which the models have series."""
    model, u = MOTIONS[name]
    run = program(model.move, model.size, len(u), None)
    for factor in (1.0, -1.0, 0.0, 1e-3, 1e-4, 9.99e-5, 1e-5, 1e-8, 1e-160):
        for dt in (0.1, 0.0, 2.0):
            x = rng.normal(size=model.size)
            x[10:] *= factor  # small turn rates of ConstantVelocity are in the state
            got = run(x, factor * np.array(u), dt)
            assert all(same(a[0], b) for a, b in zip(got, model.move(x, factor * np.array(u), dt), strict=True))


def test_a_quaternion_is_normalised_and_a_heading_is_wrapped_by_a_branch(rng):
    normalized = lambda x: (lambda N, N_f: (N.x, N_f))(*Frame3(x).normalized())
    run = program(normalized, 7)
    for size in (1e-3, 1.0, 50.0):
        x = size * rng.normal(size=7)
        assert all(same(a[0], b) for a, b in zip(run(x), normalized(x), strict=True))
    with pytest.raises(NotTraceable, match="must not depend on the values"):
        Frame2(Tape().inputs("x[{}]", 3)).normalized()


def test_a_single_vector_is_traced_as_a_stack_of_one_is(rng):
    tape, F, sensor = Tape(), Frame3, PinHole(K)
    r, s, l = tape.inputs("r[{}]", 7), tape.inputs("s[{}]", 7), tape.inputs("l[{}]", 6)
    e, *Es = observe(F(r), F(s), sensor, IdpPnt(), l)
    assert e.shape == (2,) and [E.shape for E in Es] == [(2, 7), (2, 7), (2, 6)]
    assert all(isinstance(x, Symbol) for x in e)


# --- models of others, in plain numpy --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sonar:
    """Squared distance and height, as somebody writes it who knows numpy and nothing else."""

    max_range: float = 9.0

    dim: ClassVar = 3
    bearing_only: ClassVar = False
    R: ClassVar = np.diag([0.01, 0.02, 0.01])

    def project(self, p):
        r = np.linalg.norm(p, axis=-1)
        flat = np.hypot(p[..., 0], p[..., 1])
        y = np.stack([r, np.arctan2(p[..., 2], flat), np.arctan2(p[..., 1], p[..., 0])], axis=-1)
        up = np.array([0.0, 0.0, 1.0])
        R_p = p / r[..., None]
        E_p = (up - R_p * np.sum(R_p * up, axis=-1, keepdims=True)) / flat[..., None]
        A_p = np.einsum("ij,...j->...i", [[0, -1, 0], [1, 0, 0], [0, 0, 0]], p) / np.square(flat)[..., np.newaxis]
        return y, np.stack([R_p, E_p, A_p], axis=-2)

    def retro(self, y):
        r, e, a = np.moveaxis(y, -1, 0)
        u = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], -1)
        u_e = np.stack([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)], -1)
        u_a = np.stack([-np.cos(e) * np.sin(a), np.cos(e) * np.cos(a), np.zeros_like(a)], -1)
        return r[..., None] * u, np.stack([u, r[..., None] * u_e, r[..., None] * u_a], -1)

    def residual(self, y, e):
        z = y - e
        return np.concatenate([z[..., :1], np.arctan2(np.sin(z[..., 1:]), np.cos(z[..., 1:]))], -1)

    def visible(self, y, p):
        return np.logical_and(y[..., 0] < self.max_range, np.all(np.abs(y[..., 1:]) < np.deg2rad(80), axis=-1))


@dataclass(frozen=True)
class Scooter:
    """A unicycle whose speed is limited, by Euler's formula."""

    frame: ClassVar = Frame2
    size: ClassVar = 3
    control_fields: ClassVar = {"v": 1, "w_deg": 1}
    state_fields: ClassVar = {}

    def move(self, x, u, dt):
        theta = x[..., 2]
        v = 3.0 * np.tanh(np.clip(u[..., 0], -20, 20) / 3.0)
        v_u = np.where(np.abs(u[..., 0]) < 20, 1 - np.tanh(u[..., 0] / 3.0) ** 2, 0.0)
        d = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], -1)
        turn = np.stack([-np.sin(theta), np.cos(theta), np.zeros_like(theta)], -1)
        up = np.broadcast_to([0.0, 0.0, 1.0], d.shape)
        X_x = np.eye(3) + dt * v[..., None, None] * turn[..., None] * np.array([0.0, 0.0, 1.0])
        X_u = np.stack([dt * v_u[..., None] * d, dt * up], axis=-1)
        return x + dt * (v[..., None] * d + u[..., 1:] * up), X_x, X_u


@dataclass(frozen=True)
class Doubled:
    """A point in the plane, stored in half metres and with its coordinates exchanged."""

    dim: ClassVar = 2
    size: ClassVar = 2
    M: ClassVar = np.array([[0.0, 0.5], [0.5, 0.0]])  # p = M l

    def to_frame(self, F, l):
        pf, PF_f, PF_p = F.to_frame(np.matmul(l, self.M.T))
        W = np.linalg.inv(self.M)
        return pf @ W.T, W @ PF_f, W @ PF_p @ self.M

    def from_frame(self, F, l):
        p, P_f, P_pf = F.from_frame(l @ self.M.T)
        W = np.linalg.inv(self.M)
        return p @ W.T, W @ P_f, W @ P_pf @ self.M

    def point(self, l):
        return np.flip(l, -1) / 2, self.M

    def ray(self, l):
        return l @ self.M.T, self.M

    def from_point(self, p):
        return 2 * np.flip(p, axis=-1), 4 * self.M, np.zeros((2, 0))


def test_a_sensor_in_plain_numpy(rng):
    sonar, run = Sonar(), None
    check_sensor(sonar, 3)
    run = program(lambda p: (*sonar.project(p), sonar.visible(sonar.project(p)[0], p)), 3)
    back = program(lambda y: (*sonar.retro(y), sonar.residual(y, 2 * y)), 3)
    seen = []
    for p in rng.normal(size=(20, 3)) * 3:
        y, Y_p = sonar.project(p)
        got = run(p)
        assert same(got[0][0], y) and same(got[1][0], Y_p) and bool(got[2][0]) == bool(sonar.visible(y, p))
        for a, b in zip(back(y), (*sonar.retro(y), sonar.residual(y, 2 * y)), strict=True):
            assert same(a[0], b)
        seen.append(bool(got[2][0]))
    assert len(set(seen)) == 2


def test_a_motion_in_plain_numpy(rng):
    check_motion(Scooter())
    run = program(Scooter().move, 3, 2, None)
    for u in rng.normal(size=(10, 2)) * 15:
        x = rng.normal(size=3)
        assert all(same(a[0], b) for a, b in zip(run(x, u, 0.1), Scooter().move(x, u, 0.1), strict=True))


def test_a_landmark_in_plain_numpy(rng):
    kind, sensor = Doubled(), RangeBearing(0.1, 0.02)
    check_landmark(kind)
    run = program(lambda r, s, l: expect(Frame2(r[0]), Frame2(s[0]), sensor, kind, l), 3, 3, 2)
    born = program(lambda r, s, y, n: retro_project(Frame2(r[0]), Frame2(s[0]), sensor, kind, y, n), 3, 3, 2, 0)
    for _ in range(5):
        (Rf, Sf), l = frames(2, rng), rng.normal(size=2)
        want = expect(Rf, Sf, sensor, kind, l)
        assert all(same(a[0], b) for a, b in zip(run(Rf.x, Sf.x, l), want, strict=True))
        new = retro_project(Rf, Sf, sensor, kind, want[0], np.zeros(0))
        for a, b in zip(born(Rf.x, Sf.x, want[0], np.zeros(0)), new, strict=True):
            assert same(np.broadcast_to(np.reshape(a, np.shape(a)[-b.ndim :]), b.shape), b)


# --- numpy -----------------------------------------------------------------------------------------------------------

TRACED = [
    lambda p: np.where(p == 0, 7.0, p),
    lambda p: np.where((p > 0) == (p < 2), 1.0, 2.0),
    lambda p: np.where((p > 0) & ~(p > 2) | (p < -1), p, -p),
    lambda p: np.where(np.logical_not(p > 0) | np.logical_and(p > 2, p < 4), p, 9.0),
    lambda p: np.where(np.logical_or(p, p > 1), 1.0, 2.0),
    lambda p: np.where(np.isnan(p / p) | ~np.isfinite(1 / p), 5.0, p),
    lambda p: (p > 0) * 2.0 + p,
    lambda p: abs(p) ** 0.5 + p**3 - p**0 + p**-1.0 % 3.0,
    lambda p: np.hypot(p, 2.0) - np.arctan2(1.0, p) * np.exp(-np.square(p)),
    lambda p: np.maximum(p, 1.0) + np.minimum(p / p, 0.5) + np.maximum(1.0, p / p),
    lambda p: np.clip(p, 0.0, 2.0) + p.clip(-1, 1) + np.clip(p, 0.5, np.abs(p) + 1),
    lambda p: np.sign(p) + np.deg2rad(p) + np.radians(p) + np.degrees(p),
    lambda p: np.linalg.norm(np.concatenate([p, 2 * p, np.ones_like(p)], -1), axis=-1, keepdims=True),
    lambda p: np.sum(np.stack([p, p**2], 0), axis=0) + np.mean(np.stack([p, p]), 0),
    lambda p: np.swapaxes(np.expand_dims(p, 0), 0, -1)[0].T + np.moveaxis(p[..., None], -1, 0)[0],
    lambda p: np.full_like(p, 3.0) * p + np.zeros_like(p) + np.empty_like(p, shape=(0,)).sum(),
    lambda p: np.einsum("...i,...i->...", p, p)[..., None] + np.matmul(p, [[2.0]]) + np.dot(p, [[3.0]]),
    lambda p: np.broadcast_to(p, (2, *p.shape))[1] + np.concatenate(np.split(p, [0], axis=-1), -1),
    lambda p: np.float64(2.0) * p[..., 0, None] + (np.float64(1.0) < p) * 1.0 + np.hstack([p])[..., :1],
    lambda p: np.where(np.all(np.stack([p, p - 1], -1) > 0, axis=-1), 1.0, p),
    lambda p: np.where(np.any(np.stack([p, p - 1], -1) > 0, -1), 1.0, p),
    lambda p: np.add(p, 1, out=np.empty_like(p)),
]
REFUSED = [
    lambda p: p if p[0, 0] > 0 else -p,
    lambda p: np.asarray(p, float),
    lambda p: p.astype(float),
    lambda p: np.array([float(p[0, 0])]),
    lambda p: _filled(np.zeros(p.shape), p),
    lambda p: np.nan_to_num(p / p),
    lambda p: np.divide(1.0, p, out=np.zeros_like(p), where=p != 0),
    lambda p: np.sort(np.concatenate([p, p - 1.0], -1), -1)[..., :1],
    lambda p: np.full_like(p, len(set(p.ravel().tolist()))),
    lambda p: p if 0.0 in p else p + 1.0,
    lambda p: np.linalg.norm(p, 1, axis=-1),
    lambda p: np.linalg.inv(p[..., None]),
    lambda p: p[p > 0],
]
words = lambda f: inspect.getsource(f).strip().removeprefix("lambda p: ").rstrip(",")


def _filled(a, p):
    a[..., 0] = p[..., 0]
    return a


@pytest.mark.parametrize("function", TRACED, ids=words)
@np.errstate(all="ignore")
def test_numpy_gives_the_same_through_symbols(function):
    """Also of numbers between which something changes, of zero, and of what is not finite."""
    run = program(lambda p: [function(p)], 1)
    for x in (0.0, -0.0, 1.0, 2.0, -3.0, 0.3, np.inf, -np.inf, np.nan):
        expected = np.asarray(function(np.array([[x]])), float)
        got = np.asarray(run([x])[0])
        assert got.shape == expected.shape and np.allclose(got, expected, rtol=1e-14, equal_nan=True), x


@pytest.mark.parametrize("function", REFUSED, ids=words)
def test_what_asks_for_a_value_is_refused(function):
    with pytest.raises((TypeError, ValueError, IndexError)):
        function(Tape().inputs("p[{}]", 1)[None])


def test_a_comparison_is_a_symbol_that_decides_nothing():
    x = Tape().inputs("x[{}]", 3)
    for decide in (lambda: x[0] == 0, lambda: x[0] != x[1], lambda: x[0] < 1.0, lambda: 1.0 < x[0]):
        assert isinstance(decide(), Symbol)
        with pytest.raises(NotTraceable):
            bool(decide())
    assert isinstance(x > 0, Symbols) and isinstance(np.cos(x[0]), Symbols)
    with pytest.raises(NotTraceable):
        bool(np.cos(x[0]) > 0)
