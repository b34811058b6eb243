"""What the contract tests are made of: random frames and points, stacks, and which parts of a model are written yet."""

import inspect
from contextlib import contextmanager

import numpy as np

from ..geometry import check_jacobians
from .protocols import METHODS, VALUES, lacking

AXES = "let arrays have leading axes: p[..., 0] instead of p[0] or x, y = p, and np.where instead of if"


def refuse_class(model):
    """Refuse a class where one of its instances is meant."""
    if isinstance(model, type):
        raise TypeError(f"give an instance, {model.__name__}(...), not the class {model.__name__}")


def check_noise(R):
    """Test the noise covariance R (m, m) of a sensor. Returns it."""
    R = np.asarray(R)
    assert R.ndim == 2 and np.allclose(R, R.T) and (np.linalg.eigvalsh(R) > 0).all(), "R is not a covariance"
    return R


def random_frame(F, rng):
    """A random frame of class F, with a unit quaternion in 3D."""
    return F(np.concatenate([rng.normal(size=F.dim), rng.normal(size=F.size - F.dim)])).normalized()[0]


def random_points(dim, rng, sensor=None):
    """Random points in front of a sensor: some that it can see, as far as it says which."""
    p = rng.normal(size=(100, dim)) * 3 + (0 if sensor is None else 4 * np.eye(dim)[-1 if dim == 3 else 0])
    if sensor is None or not written(sensor, "visible"):
        return p
    near = p[seen(sensor, p)]
    assert len(near), "visible() refuses every one of 100 random points: is its sign right?"
    return near


def seen(sensor, p):
    """Return True for each point that a sensor can see."""
    y = of_stack(lambda p: sensor.project(p)[0], "project", p)
    assert np.shape(y)[:-1] == (len(p),), f"project gives shape {np.shape(y)} of {len(p)} points; {AXES}"
    visible = of_stack(sensor.visible, "visible", y, p)
    got = f"shape {np.shape(visible)} of {len(p)} points" if np.ndim(visible) else f"{type(visible).__name__} {visible}"
    assert np.shape(visible) == (len(p),), f"visible must give one bool per point, got {got}"
    return np.asarray(visible, bool)


def dim_of(model, dim=None):
    """The dimension to test a model in: the one that is asked for, its own, or 3."""
    return getattr(model, "dim", 3) if dim is None else dim


def written(model, name):
    """Return True if a part of a model is there: not left out, and not left as `ekfslam new --bare` writes it."""
    part = inspect.getattr_static(model, name, None)
    function = getattr(part, "fget", None) or getattr(part, "func", None) or part
    code = getattr(function, "__code__", None)
    return not lacking(model, [name]) and (code is None or code.co_names != ("NotImplementedError",))


def check_complete(model, role):
    """Say what is still to be written."""
    missing = [name for name in (*VALUES[role], *METHODS[role]) if not written(model, name)]
    assert not missing, f"{type(model).__name__} has no {', '.join(missing)} yet; what can be tested without is well"


@contextmanager
def told_dim(model, dim):
    """Name the likely cause where an array has a wrong shape: a model without `dim`."""
    try:
        yield
    except (AssertionError, ValueError, IndexError) as error:
        of_shape = "shape" in str(error) or not isinstance(error, AssertionError)
        if dim is not None or hasattr(model, "dim") or not of_shape:
            raise
        raise AssertionError(f"{error}; {type(model).__name__} has no dim, so 3 is taken") from error


def check_three(out, name, wanted):
    """Refuse what is not a value and two Jacobians."""
    got = len(out) if isinstance(out, tuple) else f"a {type(out).__name__}"
    assert got == 3, f"{name} must give three things, {wanted}, got {got}"


def of_stack(f, name, *args):
    """Call f with a stack of arguments; say in a sentence if it only takes them one by one."""
    try:
        return f(*args)
    except (ValueError, TypeError, IndexError) as error:
        for one in zip(*(a if isinstance(a, np.ndarray) else [a] * len(args[-1]) for a in args), strict=True):
            f(*one)  # stops with its own error, if it is none of the stack
        raise AssertionError(f"{name} takes no stack of inputs; {AXES} ({error})") from error


def check_stack(f, name, *args):
    """Refuse a method that makes of a stack of arguments no stack of results; return what it makes of it."""
    stacked, singles = of_stack(f, name, *args), [f(*one) for one in zip(*args, strict=True)]
    for k, out in enumerate(stacked):
        want = np.stack([np.asarray(s[k]) for s in singles])
        try:
            same = np.allclose(np.broadcast_to(out, want.shape), want, equal_nan=True)
        except ValueError:  # of another shape
            same = False
        assert same, f"{name}: a stack of inputs does not give the stack of outputs; {AXES}"
    return stacked


def check_residual(model, y):
    """Test that a residual is a difference, and that its angles have no seam."""
    assert np.allclose(model.residual(y, y), 0), "residual(y, y) is not zero"
    for i, unit in enumerate(getattr(model, "units", ())):
        if unit == "rad":
            z = np.asarray(model.residual(y + 2 * np.pi * np.eye(y.shape[-1])[i], y))
            assert np.allclose(z, 0, atol=1e-6), (
                f"residual does not wrap: units[{i}] is 'rad', and an angle y[{i}] one turn further, by 2 pi, "
                f"gives {np.abs(z).max():.6g}; it must give 0"
            )


def check_retro(model, p, y):
    """Test the way back, from the measurements y of some points p."""
    check_jacobians(model.retro, y[0])
    v, _ = check_stack(model.retro, "retro", y)
    if written(model, "residual"):
        back = model.project(v)[0]
        assert np.allclose(model.residual(back, y), 0, atol=1e-6), "project(retro(y)) is not y"
    scale = (v * p).sum(-1)
    assert (scale > 0).all(), "retro points away from the landmark"
    if written(model, "bearing_only") and not model.bearing_only:
        assert np.allclose(v, p, atol=1e-6), "retro(project(p)) is not p, and the sensor is not bearing_only"
