"""The tests that say whether a model can do what `protocols.py` asks of it.

They are public: they are the tests of the package's own models and of those that a student writes. A model that is
still being written is tested as far as it goes; what is missing is said last.
"""

import inspect
from contextlib import contextmanager

import numpy as np

from ..geometry import Frame2, Frame3, check_jacobians
from .observation import observe, retro_project
from .protocols import METHODS, VALUES, lacking

SEEDS = range(8)
AXES = "let arrays have leading axes: p[..., 0] instead of p[0] or x, y = p, and np.where instead of if"


def _instance(model):
    """Refuse a class where one of its instances is meant."""
    if isinstance(model, type):
        raise TypeError(f"give an instance, {model.__name__}(...), not the class {model.__name__}")


def _frame(F, rng):
    """A random frame of class F, with a unit quaternion in 3D."""
    return F(np.concatenate([rng.normal(size=F.dim), rng.normal(size=F.size - F.dim)])).normalized()[0]


def _points(dim, rng, sensor=None):
    """Random points in front of a sensor: some that it can see, as far as it says which."""
    p = rng.normal(size=(100, dim)) * 3 + (0 if sensor is None else 4 * np.eye(dim)[-1 if dim == 3 else 0])
    if sensor is None or not _written(sensor, "visible"):
        return p
    seen = p[_seen(sensor, p)]
    assert len(seen), "visible() refuses every one of 100 random points: is its sign right?"
    return seen


def _seen(sensor, p):
    """Which of some points a sensor can see: one bool for each."""
    y = _of_stack(lambda p: sensor.project(p)[0], "project", p)
    assert np.shape(y)[:-1] == (len(p),), f"project gives shape {np.shape(y)} of {len(p)} points; {AXES}"
    seen = _of_stack(sensor.visible, "visible", y, p)
    got = f"{type(seen).__name__} {seen}" if np.ndim(seen) == 0 else f"shape {np.shape(seen)} of {len(p)} points"
    assert np.shape(seen) == (len(p),), f"visible must give one bool per point, got {got}"
    return np.asarray(seen, bool)


def _dim(model, default=3):
    return getattr(model, "dim", default)


def _written(model, name):
    """Return True if a part of a model is there: not left out, and not left as `ekfslam new --bare` writes it."""
    part = inspect.getattr_static(model, name, None)
    function = getattr(part, "fget", None) or getattr(part, "func", None) or part
    code = getattr(function, "__code__", None)
    return not lacking(model, [name]) and (code is None or code.co_names != ("NotImplementedError",))


def _complete(model, role):
    """Say what is still to be written."""
    missing = [name for name in (*VALUES[role], *METHODS[role]) if not _written(model, name)]
    assert not missing, f"{type(model).__name__} has no {', '.join(missing)} yet; what can be tested without is well"


@contextmanager
def _told_dim(model, dim):
    """Where an array has a wrong shape and a model has no `dim`, that is most likely why."""
    try:
        yield
    except (AssertionError, ValueError, IndexError) as error:
        of_shape = "shape" in str(error) or not isinstance(error, AssertionError)
        if dim is not None or hasattr(model, "dim") or not of_shape:
            raise
        raise AssertionError(f"{error}; {type(model).__name__} has no dim, so 3 is taken") from error


def check_motion(model, dt=0.1):
    """Test a motion model: shapes, Jacobians, stacks of states, a pose that stays a pose.

    Raises
    ------
    AssertionError
        With what is missing, or with the first property that does not hold.

    See Also
    --------
    check_jacobians : The test of the derivatives alone.
    """
    _instance(model)
    _complete(model, "motion")  # `move` is tested by all the rest
    n_u = sum(model.control_fields.values())
    assert model.size == model.frame.size + sum(model.state_fields.values()), "size is not frame + state_fields"
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x = np.concatenate([_frame(model.frame, rng).x, rng.normal(size=model.size - model.frame.size)])
        for u in (rng.normal(size=n_u), 1e-6 * rng.normal(size=n_u), np.zeros(n_u)):
            out = model.move(x, u, dt)
            shapes = (model.size,), (model.size, model.size), (model.size, n_u)
            assert isinstance(out, tuple) and len(out) == 3, (
                f"move must give three things, x2, X_x, X_u, got {_what(out)}"
            )
            for name, value, shape in zip(("x2", "X_x", "X_u"), out, shapes, strict=True):
                assert isinstance(value, np.ndarray), f"move must give arrays, got a {type(value).__name__} for {name}"
                assert value.shape == shape, f"move gives {name} of shape {value.shape}; it must be {shape}"
            check_jacobians(lambda x, u: model.move(x, u, dt), x, u)
    X, U = rng.normal(size=(4, model.size)), rng.normal(size=(4, n_u))
    _check_stack(lambda x, u: model.move(x, u, dt), "move", X, U)


def _what(out):
    """What a method has given, in a few words."""
    return f"{len(out)}" if isinstance(out, tuple) else f"a {type(out).__name__}"


def check_sensor(model, dim=None):
    """Test a sensor model: Jacobians, round trip, stacks, the residual, visibility, the noise.

    Parameters
    ----------
    model : SensorModel
    dim : int, optional
        Dimension of its world; `model.dim` if it has one, else 3.

    Raises
    ------
    AssertionError
        With the first property that does not hold; or, if all that is written is well, with what is missing.

    See Also
    --------
    check_pair : Together with a landmark type.
    """
    _instance(model)
    if _written(model, "R"):
        R = np.asarray(model.R)
        assert R.ndim == 2 and np.allclose(R, R.T) and (np.linalg.eigvalsh(R) > 0).all(), "R is not a covariance"
    if _written(model, "project"):
        with _told_dim(model, dim):
            for seed in SEEDS:
                _check_sensor(model, _dim(model) if dim is None else dim, np.random.default_rng(seed))
    _complete(model, "sensor")


def _check_sensor(model, dim, rng):
    """Test what is written of a sensor that has at least `project`."""
    p = _points(dim, rng, model)
    y, _ = _check_stack(model.project, "project", p)
    if _written(model, "R"):
        m = len(model.R)
        assert np.shape(y) == (len(p), m), f"project gives shape {np.shape(y)}; it must be ({len(p)}, {m})"
    check_jacobians(model.project, p[0])
    if _written(model, "residual"):
        _check_residual(model, y)
    reach = getattr(model, "max_range", np.inf)
    if np.isfinite(reach) and _written(model, "visible"):
        far = p * (2 * reach / np.linalg.norm(p, axis=-1, keepdims=True))
        assert not np.any(_seen(model, far)), "visible() accepts points beyond max_range"
    if _written(model, "retro"):  # without, it corrects with landmarks that other sensors have started
        _check_retro(model, p, y)


def _check_residual(model, y):
    """Test that a residual is a difference, and that its angles have no seam."""
    assert np.allclose(model.residual(y, y), 0), "residual(y, y) is not zero"
    for i, unit in enumerate(getattr(model, "units", ())):
        if unit == "rad":
            z = np.asarray(model.residual(y + 2 * np.pi * np.eye(y.shape[-1])[i], y))
            assert np.allclose(z, 0, atol=1e-6), (
                f"residual does not wrap: units[{i}] is 'rad', and an angle y[{i}] one turn further, by 2 pi, "
                f"gives {np.abs(z).max():.6g}; it must give 0"
            )


def _check_retro(model, p, y):
    """Test the way back, from the measurements y of some points p."""
    check_jacobians(model.retro, y[0])
    v, _ = _check_stack(model.retro, "retro", y)
    if _written(model, "residual"):
        back = model.project(v)[0]
        assert np.allclose(model.residual(back, y), 0, atol=1e-6), "project(retro(y)) is not y"
    scale = (v * p).sum(-1)
    assert (scale > 0).all(), "retro points away from the landmark"
    if _written(model, "bearing_only") and not model.bearing_only:
        assert np.allclose(v, p, atol=1e-6), "retro(project(p)) is not p, and the sensor is not bearing_only"


def check_landmark(lmk, dim=None):
    """Test a landmark type: Jacobians of all its maps, round trips, stacks.

    Parameters
    ----------
    lmk : LmkType
    dim : int, optional
        Dimension of its world; `lmk.dim` if it has one, else 3.

    Raises
    ------
    AssertionError
        With the first property that does not hold; or, if all that is written is well, with what is missing.

    See Also
    --------
    check_pair : Together with a sensor.
    """
    _instance(lmk)
    F = Frame2 if (_dim(lmk) if dim is None else dim) == 2 else Frame3
    births = [name for name in ("from_ray", "from_point") if _written(lmk, name)]
    assert births, f"{type(lmk).__name__} has neither from_point nor from_ray: nothing can start it, or be tested"
    with _told_dim(lmk, dim):
        for seed in SEEDS:
            for birth in births:
                _check_landmark(lmk, F, birth, np.random.default_rng(seed))
    _complete(lmk, "landmark")


def _check_landmark(lmk, F, birth, rng):
    """Test what is written of a landmark type that is started by `from_point` or `from_ray`."""
    frame, p = _frame(F, rng), _points(F.dim, rng)
    n = np.full(1 if birth == "from_ray" else 0, 0.3)
    start = lmk.from_ray if len(n) else lambda v, n: lmk.from_point(v)
    out = start(p[0], n)
    assert isinstance(out, tuple) and len(out) == 3, f"{birth} must give three things, l, L_v, L_n, got {_what(out)}"
    l, size = _of_stack(start, birth, p, np.broadcast_to(n, (len(p), len(n))))[0], np.shape(out[0])[-1]
    if _written(lmk, "size"):
        assert np.shape(l) == (len(p), lmk.size), f"a landmark has shape {np.shape(l)[1:]}; it must be ({lmk.size},)"
    assert np.shape(out[2]) == (size, len(n)), (
        f"{birth} gives L_n of shape {np.shape(out[2])}; it must be {(size, len(n))}: "
        + ("one column, of the prior" if len(n) else "no columns, a point needs no prior")
    )
    check_jacobians(start, p[0], n)
    if _written(lmk, "from_frame"):
        l = _of_stack(lmk.from_frame, "from_frame", frame, l)[0]
    for name in ("to_frame", "from_frame"):
        if _written(lmk, name):
            f = getattr(lmk, name)
            check_jacobians(f, frame, l[0])
            _check_stack(lambda l, f=f: f(frame, l), name, l)
    for name in ("point", "ray"):
        if _written(lmk, name):
            check_jacobians(getattr(lmk, name), l[0])
            _check_stack(getattr(lmk, name), name, l)
    if all(_written(lmk, name) for name in ("to_frame", "from_frame", "point")):
        back = lmk.to_frame(frame, lmk.from_frame(frame, l)[0])[0]
        assert np.allclose(lmk.point(back)[0], lmk.point(l)[0]), "to_frame(F, from_frame(F, l)) is not l"
    if _written(lmk, "ray") and _written(lmk, "point"):
        ray, point = lmk.ray(l)[0], lmk.point(l)[0]
        cos = (ray * point).sum(-1) / np.linalg.norm(ray, axis=-1) / np.linalg.norm(point, axis=-1)
        assert np.allclose(cos, 1), "ray(l) does not point at point(l)"


def check_pair(sensor, lmk, dim=None):
    """Test a sensor together with a landmark type: both observation models, their Jacobians, and the round trip.

    Raises
    ------
    AssertionError
        With the first property that does not hold.
    TypeError
        If the sensor cannot start a landmark of this type.

    See Also
    --------
    check_sensor, check_landmark : Each by itself.
    """
    F = Frame2 if (_dim(lmk) if dim is None else dim) == 2 else Frame3
    n = np.array([0.3]) if sensor.bearing_only else np.zeros(0)
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        Rf, Sf = _frame(F, rng), _frame(F, rng)
        y = sensor.project(_points(F.dim, rng, sensor))[0]
        l, *Ls = retro_project(Rf, Sf, sensor, lmk, y, np.broadcast_to(n, (len(y), len(n))))
        e, *_ = observe(Rf, Sf, sensor, lmk, l)
        assert np.allclose(sensor.residual(e, y), 0, atol=1e-5), "observe(retro_project(y)) is not y"
        for name, L, k in zip(("L_r", "L_s", "L_y", "L_n"), Ls, (F.size, F.size, y.shape[-1], len(n)), strict=True):
            got, want = np.shape(L)[-2:], (l.shape[-1], k)
            assert got == want, f"{name} of the landmark's birth has shape {got}; it must be {want}"
        check_jacobians(lambda R, S, y, n: retro_project(R, S, sensor, lmk, y, n), Rf, Sf, y[0], n, rtol=1e-5)
        check_jacobians(lambda R, S, l: observe(R, S, sensor, lmk, l), Rf, Sf, l[0], rtol=1e-5)


def _of_stack(f, name, *args):
    """What f makes of a stack of arguments; a sentence, if it only takes them one by one."""
    try:
        return f(*args)
    except (ValueError, TypeError, IndexError) as error:
        for one in zip(*(a if isinstance(a, np.ndarray) else [a] * len(args[-1]) for a in args), strict=True):
            f(*one)  # stops with its own error, if it is none of the stack
        raise AssertionError(f"{name} takes no stack of inputs; {AXES} ({error})") from error


def _check_stack(f, name, *args):
    """Refuse a method that makes of a stack of arguments no stack of results; return what it makes of it."""
    stacked, singles = _of_stack(f, name, *args), [f(*one) for one in zip(*args, strict=True)]
    for k, out in enumerate(stacked):
        want = np.stack([np.asarray(s[k]) for s in singles])
        try:
            same = np.allclose(np.broadcast_to(out, want.shape), want, equal_nan=True)
        except ValueError:  # of another shape
            same = False
        assert same, f"{name}: a stack of inputs does not give the stack of outputs; {AXES}"
    return stacked
