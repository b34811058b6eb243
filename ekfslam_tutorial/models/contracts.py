"""The tests that say whether a model can do what `protocols.py` asks of it.

They are public: they are the tests of the package's own models and of those that a student writes.
"""

import numpy as np

from ..geometry import Frame2, Frame3, check_jacobians
from .observation import observe, retro_project

SEEDS = range(8)


def _instance(model):
    """Refuse a class where one of its instances is meant."""
    if isinstance(model, type):
        raise TypeError(f"give an instance, {model.__name__}(...), not the class {model.__name__}")


def _frame(F, rng):
    """A random frame of class F, with a unit quaternion in 3D."""
    return F(np.concatenate([rng.normal(size=F.dim), rng.normal(size=F.size - F.dim)])).normalized()[0]


def _points(dim, rng, sensor=None):
    """Random points in front of a sensor: some that it can see."""
    p = rng.normal(size=(100, dim)) * 3 + (0 if sensor is None else 4 * np.eye(dim)[-1 if dim == 3 else 0])
    if sensor is None:
        return p
    seen = p[np.asarray(sensor.visible(sensor.project(p)[0], p), bool)]
    assert len(seen), "visible() refuses every one of 100 random points: is its sign right?"
    return seen


def _dim(model, default=3):
    return getattr(model, "dim", default)


def check_motion(model, dt=0.1):
    """Test a motion model: shapes, Jacobians, stacks of states, a pose that stays a pose.

    Raises
    ------
    AssertionError
        With the first property that does not hold.

    See Also
    --------
    check_jacobians : The test of the derivatives alone.
    """
    _instance(model)
    n_u = sum(model.control_fields.values())
    assert model.size == model.frame.size + sum(model.state_fields.values()), "size is not frame + state_fields"
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x = np.concatenate([_frame(model.frame, rng).x, rng.normal(size=model.size - model.frame.size)])
        for u in (rng.normal(size=n_u), 1e-6 * rng.normal(size=n_u), np.zeros(n_u)):
            x2, X_x, X_u = model.move(x, u, dt)
            assert np.shape(x2) == (model.size,), f"move gives shape {np.shape(x2)}; it must be ({model.size},)"
            assert np.shape(X_u) == (model.size, n_u), (
                f"X_u has shape {np.shape(X_u)}; it must be ({model.size}, {n_u})"
            )
            check_jacobians(lambda x, u: model.move(x, u, dt), x, u)
    X, U = rng.normal(size=(4, model.size)), rng.normal(size=(4, n_u))
    _check_stack(model.move(X, U, dt), [model.move(x, u, dt) for x, u in zip(X, U, strict=True)], "move")


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
        With the first property that does not hold.

    See Also
    --------
    check_pair : Together with a landmark type.
    """
    _instance(model)
    dim = _dim(model) if dim is None else dim
    R = np.asarray(model.R)
    assert R.ndim == 2 and np.allclose(R, R.T) and (np.linalg.eigvalsh(R) > 0).all(), "R is not a covariance"
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        p = _points(dim, rng, model)
        y, Y_p = model.project(p)
        assert np.shape(y) == (len(p), len(R)), f"project gives shape {np.shape(y)}; it must be ({len(p)}, {len(R)})"
        _check_stack((y, Y_p), [model.project(pi) for pi in p], "project")
        check_jacobians(model.project, p[0])
        assert np.allclose(model.residual(y, y), 0), "residual(y, y) is not zero"
        reach = getattr(model, "max_range", np.inf)
        if np.isfinite(reach):
            far = p * (2 * reach / np.linalg.norm(p, axis=-1, keepdims=True))
            assert not np.any(model.visible(model.project(far)[0], far)), "visible() accepts points beyond max_range"
        if not hasattr(model, "retro"):  # it corrects with landmarks that other sensors have started
            continue
        check_jacobians(model.retro, y[0])
        v, V_y = model.retro(y)
        _check_stack((v, V_y), [model.retro(yi) for yi in y], "retro")
        back = model.project(v)[0]
        assert np.allclose(model.residual(back, y), 0, atol=1e-6), "project(retro(y)) is not y"
        scale = (v * p).sum(-1)
        assert (scale > 0).all(), "retro points away from the landmark"
        if not model.bearing_only:
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
        With the first property that does not hold.

    See Also
    --------
    check_pair : Together with a sensor.
    """
    _instance(lmk)
    F = Frame2 if (_dim(lmk) if dim is None else dim) == 2 else Frame3
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        frame, p = _frame(F, rng), _points(F.dim, rng)
        births = [lambda v: lmk.from_point(v)[:2]] if hasattr(lmk, "from_point") else []
        births += [lambda v: lmk.from_ray(v, np.array([0.3]))[:2]] if hasattr(lmk, "from_ray") else []
        assert births, f"{type(lmk).__name__} has neither from_point nor from_ray: nothing can start it"
        for birth in births:
            l = lmk.from_frame(frame, birth(p)[0])[0]
            assert l.shape == (len(p), lmk.size), f"a landmark has shape {l.shape[1:]}; it must be ({lmk.size},)"
            check_jacobians(birth, p[0])
            for f in (lmk.to_frame, lmk.from_frame):
                check_jacobians(f, frame, l[0])
                _check_stack(f(frame, l), [f(frame, li) for li in l], f.__name__)
            for f in (lmk.point, lmk.ray):
                check_jacobians(f, l[0])
                _check_stack(f(l), [f(li) for li in l], f.__name__)
            back = lmk.to_frame(frame, lmk.from_frame(frame, l)[0])[0]
            assert np.allclose(lmk.point(back)[0], lmk.point(l)[0]), "to_frame(F, from_frame(F, l)) is not l"
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
        assert [L.shape[-1] for L in Ls] == [F.size, F.size, y.shape[-1], len(n)], "wrong Jacobian shapes"
        check_jacobians(lambda R, S, y, n: retro_project(R, S, sensor, lmk, y, n), Rf, Sf, y[0], n, rtol=1e-5)
        check_jacobians(lambda R, S, l: observe(R, S, sensor, lmk, l), Rf, Sf, l[0], rtol=1e-5)


def _check_stack(stacked, singles, name):
    """Test that a stack of arguments gives the stack of the results."""
    for k, out in enumerate(stacked):
        want = np.stack([np.asarray(s[k]) for s in singles])
        got = np.broadcast_to(out, want.shape)
        assert np.allclose(got, want, equal_nan=True), f"{name}: a stack of inputs does not give the stack of outputs"
