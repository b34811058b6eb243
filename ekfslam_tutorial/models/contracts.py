"""The tests that say whether a model can do what `protocols.py` asks of it.

They are public: they are the tests of the package's own models and of those that a student writes. A model that is
still being written is tested as far as it goes; what is missing is said last.
"""

import numpy as np

from ..geometry import Frame2, Frame3, check_jacobians
from .line_contracts import check_line
from .observation import birth, check_fit, observe, retro_project
from .state_contracts import check_parameters, check_velocity, pair_check, sensor_check
from .trials import (
    check_complete,
    check_noise,
    check_residual,
    check_retro,
    check_stack,
    check_three,
    dim_of,
    of_stack,
    random_frame,
    random_points,
    refuse_class,
    seen,
    told_dim,
    written,
)

SEEDS = range(8)


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
    refuse_class(model)
    check_complete(model, "motion")  # `move` is tested by all the rest
    n_u = sum(model.control_fields.values())
    assert model.size == model.frame.size + sum(model.state_fields.values()), "size is not frame + state_fields"
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x = np.concatenate([random_frame(model.frame, rng).x, rng.normal(size=model.size - model.frame.size)])
        for u in (rng.normal(size=n_u), 1e-6 * rng.normal(size=n_u), np.zeros(n_u)):
            out = model.move(x, u, dt)
            shapes = (model.size,), (model.size, model.size), (model.size, n_u)
            check_three(out, "move", "x2, X_x, X_u")
            for name, value, shape in zip(("x2", "X_x", "X_u"), out, shapes, strict=True):
                assert isinstance(value, np.ndarray), f"move must give arrays, got a {type(value).__name__} for {name}"
                assert value.shape == shape, f"move gives {name} of shape {value.shape}; it must be {shape}"
            check_jacobians(lambda x, u: model.move(x, u, dt), x, u)
            check_velocity(model, x, u)
    X, U = rng.normal(size=(4, model.size)), rng.normal(size=(4, n_u))
    check_stack(lambda x, u: model.move(x, u, dt), "move", X, U)


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
    refuse_class(model)
    if special := sensor_check(model):
        return special(model)
    if written(model, "R"):
        check_noise(model.R)
    if written(model, "project"):
        with told_dim(model, dim):
            for seed in SEEDS:
                _check_sensor(model, dim_of(model, dim), np.random.default_rng(seed))
        check_parameters(model) if hasattr(model, "parameters") else None
    check_complete(model, "sensor")


def _check_sensor(model, dim, rng):
    """Test what is written of a sensor that has at least `project`."""
    p = random_points(dim, rng, model)
    y, _ = check_stack(model.project, "project", p)
    if written(model, "R"):
        m = len(model.R)
        assert np.shape(y) == (len(p), m), f"project gives shape {np.shape(y)}; it must be ({len(p)}, {m})"
    check_jacobians(model.project, p[0])
    if written(model, "residual"):
        check_residual(model, y)
    max_range = getattr(model, "max_range", np.inf)
    if np.isfinite(max_range) and written(model, "visible"):
        far = p * (2 * max_range / np.linalg.norm(p, axis=-1, keepdims=True))
        assert not np.any(seen(model, far)), "visible() accepts points beyond max_range"
    if written(model, "retro"):  # without, it corrects with landmarks that other sensors have started
        check_retro(model, p, y)


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
    refuse_class(lmk)
    if hasattr(lmk, "normal"):
        return check_line(lmk)
    F = Frame2 if dim_of(lmk, dim) == 2 else Frame3
    births = [name for name in ("from_ray", "from_point") if written(lmk, name)]
    assert births, f"{type(lmk).__name__} has neither from_point nor from_ray: nothing can start it, or be tested"
    with told_dim(lmk, dim):
        for seed in SEEDS:
            for birth in births:
                _check_landmark(lmk, F, birth, np.random.default_rng(seed))
    check_complete(lmk, "landmark")


def _check_landmark(lmk, F, birth, rng):
    """Test what is written of a landmark type that is started by `from_point` or `from_ray`."""
    frame, p = random_frame(F, rng), random_points(F.dim, rng)
    n = np.full(1 if birth == "from_ray" else 0, 0.3)
    start = lmk.from_ray if len(n) else lambda v, n: lmk.from_point(v)
    out = start(p[0], n)
    check_three(out, birth, "l, L_v, L_n")
    l, size = of_stack(start, birth, p, np.broadcast_to(n, (len(p), len(n))))[0], np.shape(out[0])[-1]
    if written(lmk, "size"):
        assert np.shape(l) == (len(p), lmk.size), f"a landmark has shape {np.shape(l)[1:]}; it must be ({lmk.size},)"
    assert np.shape(out[2]) == (size, len(n)), (
        f"{birth} gives L_n of shape {np.shape(out[2])}; it must be {(size, len(n))}: "
        + ("one column, of the prior" if len(n) else "no columns, a point needs no prior")
    )
    check_jacobians(start, p[0], n)
    if written(lmk, "from_frame"):
        l = of_stack(lmk.from_frame, "from_frame", frame, l)[0]
    for name in ("to_frame", "from_frame"):
        if written(lmk, name):
            f = getattr(lmk, name)
            check_jacobians(f, frame, l[0])
            check_stack(lambda l, f=f: f(frame, l), name, l)
    for name in ("point", "ray"):
        if written(lmk, name):
            check_jacobians(getattr(lmk, name), l[0])
            check_stack(getattr(lmk, name), name, l)
    if all(written(lmk, name) for name in ("to_frame", "from_frame", "point")):
        back = lmk.to_frame(frame, lmk.from_frame(frame, l)[0])[0]
        assert np.allclose(lmk.point(back)[0], lmk.point(l)[0]), "to_frame(F, from_frame(F, l)) is not l"
    if written(lmk, "ray") and written(lmk, "point"):
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
    check_fit(sensor, lmk, birth(sensor))
    if special := pair_check(sensor):
        return special(sensor, lmk)
    F = Frame2 if dim_of(lmk, dim) == 2 else Frame3
    n = np.array([0.3]) if sensor.bearing_only else np.zeros(0)
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        Rf, Sf = random_frame(F, rng), random_frame(F, rng)
        y = sensor.project(random_points(F.dim, rng, sensor))[0]
        l, *Ls = retro_project(Rf, Sf, sensor, lmk, y, np.broadcast_to(n, (len(y), len(n))))
        e, *_ = observe(Rf, Sf, sensor, lmk, l)
        assert np.allclose(sensor.residual(e, y), 0, atol=1e-5), "observe(retro_project(y)) is not y"
        for name, L, k in zip(("L_r", "L_s", "L_y", "L_n"), Ls, (F.size, F.size, y.shape[-1], len(n)), strict=True):
            got, want = np.shape(L)[-2:], (l.shape[-1], k)
            assert got == want, f"{name} of the landmark's birth has shape {got}; it must be {want}"
        check_jacobians(lambda R, S, y, n: retro_project(R, S, sensor, lmk, y, n), Rf, Sf, y[0], n, rtol=1e-5)
        check_jacobians(lambda R, S, l: observe(R, S, sensor, lmk, l), Rf, Sf, l[0], rtol=1e-5)
