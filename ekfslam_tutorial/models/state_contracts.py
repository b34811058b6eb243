"""The contract tests of sensors that ask for more than a point: a velocity, their own frame, parameters.

`contracts.py` calls them.
"""

from typing import Any

import numpy as np

from ..geometry import ORIGIN, Frame2, Frame3, check_jacobians
from .calibrated import Calibrated, state_class
from .line_contracts import check_line_pair, check_line_sensor
from .moving import Moving
from .observation import ItsRobot, observe, retro_project
from .trials import check_complete, check_noise, check_residual, check_stack, random_frame, random_points, written

SEEDS = range(4)


class AnyRobot:
    """A motion model whose state is a frame and its velocity: to test sensors with."""

    control_fields = {"none": 1}

    def __init__(self, frame):
        self.frame, self.size = frame, frame.size + frame.dof

    def velocity(self, x, u):
        """Velocity behind the frame."""
        return x[self.frame.size :], np.eye(self.frame.dof, self.size, self.frame.size)


def sensor_check(model):
    """Return the test for sensors of this kind, where it is not that of a point; or None."""
    if hasattr(model, "innovation"):
        return check_line_sensor
    return check_state_sensor if hasattr(model, "asks_robot") or hasattr(model, "without_lmks") else None


def pair_check(sensor):
    """The same for a sensor together with a landmark type."""
    if hasattr(sensor, "innovation"):
        return check_line_pair
    return check_moving_pair if hasattr(sensor, "asks_robot") else None


def check_state_sensor(model):
    """Test a sensor that gets its own velocity, or its own frame: Jacobians, stacks, noise, residual, the way back.

    Raises
    ------
    AssertionError
        With the first property that does not hold.

    See Also
    --------
    check_sensor : Calls it.
    """
    R, F = check_noise(model.R), Frame2 if model.dim == 2 else Frame3
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        alone, moving = hasattr(model, "without_lmks"), hasattr(model, "asks_robot")
        p = np.array([random_frame(F, rng).x for _ in range(9)]) if alone else random_points(F.dim, rng)
        v = np.concatenate([p, rng.normal(size=(len(p), F.dof * moving))], -1)
        y = model.project(v)[0]
        seen = np.asarray(model.visible(y, v))
        assert seen.shape == (len(v),), f"visible must give one bool per point, got shape {seen.shape} of {len(v)}"
        assert seen.any(), "visible() refuses all of them: is its sign right?"
        p, v = p[seen], v[seen]
        y, _ = check_stack(model.project, "project", v)
        assert y.shape == (len(v), len(R)), f"project gives shape {y.shape}; it must be ({len(v)}, {len(R)})"
        check_jacobians(model.project, v[0])
        check_residual(model, y)
        if written(model, "retro"):
            check_jacobians(model.retro, y[0])
            back = np.concatenate([check_stack(model.retro, "retro", y)[0], v[:, F.dim :]], -1)
            assert np.allclose(model.residual(model.project(back)[0], y), 0, atol=1e-6), "project(retro(y)) is not y"
    check_parameters(model)
    check_complete(model, "sensor")
    if hasattr(model, "without_lmks"):
        check_pair_with(model, ItsRobot(), np.zeros(0))


def check_moving_pair(sensor, lmk):
    """Test a sensor that measures velocities together with a landmark type: both observation models, the round trip."""
    F = Frame2 if sensor.dim == 2 else Frame3
    n = np.array([0.3]) if sensor.bearing_only else np.zeros(0)
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x, Sf = robot_state(F, rng), random_frame(F, rng)
        y = sensor.project(np.concatenate([random_points(F.dim, rng), rng.normal(size=(100, F.dof))], -1))[0][0]
        birth = lambda x, S, y, n: retro_project(Moving(AnyRobot(F), x), S, sensor, lmk, y, n)
        check_jacobians(birth, x, Sf, y, n, rtol=1e-5)
        check_pair_with(sensor, lmk, birth(x, Sf, y, n)[0])


def check_pair_with(sensor, lmk, l):
    """Test the derivatives of an expectation: by the whole state of a robot that moves, by the mounting, by l."""
    F = Frame2 if sensor.dim == 2 else Frame3
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        x, Sf = robot_state(F, rng), random_frame(F, rng)
        if hasattr(sensor, "asks_robot"):
            check_jacobians(lambda x, S, l: observe(Moving(AnyRobot(F), x), S, sensor, lmk, l), x, Sf, l, rtol=1e-5)
        else:
            check_jacobians(lambda R, S, l: observe(R, S, sensor, lmk, l), F(x[: F.size]), Sf, l, rtol=1e-5)


def robot_state(F, rng):
    """A random state of `AnyRobot`."""
    return np.concatenate([random_frame(F, rng).x, rng.normal(size=F.dof)])


def check_velocity(model, x, u, dt=1e-5):
    """Test the velocity that a motion model says: its Jacobian; and that the robot moves so."""
    if not hasattr(model, "velocity"):
        return
    n, O = model.frame.size, ORIGIN[model.frame.dim]
    check_jacobians(lambda x: model.velocity(x, u), x)
    here, there = (model.frame(s[:n]) for s in (x, model.move(x, u, dt)[0]))
    step = here.inverse()[0].compose(there)[0].minus(O)[0] / dt
    assert np.allclose(model.velocity(x, u)[0], step, atol=1e-3), (
        "velocity is not how the robot moves, in its own frame"
    )


def check_parameters(model):
    """Test the derivatives of a sensor model by its `parameters`, with `bias`, and by `delay` in the whole chain.

    Raises
    ------
    AssertionError
        With the first property that does not hold.

    See Also
    --------
    Calibrated : Makes states of them.
    """
    if hasattr(model, "innovation"):
        return
    names = (*getattr(model, "parameters", ()), "bias")
    if getattr(model, "c", None) is not None:
        names = tuple(name for name in names if name != "d")
    free, F = Calibrated(model, names), Frame2 if getattr(model, "dim", 3) == 2 else Frame3
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        p = random_frame(F, rng).x[None] if hasattr(model, "without_lmks") else random_points(F.dim, rng, None)
        p = np.concatenate([p, rng.normal(size=(len(p), F.dof * hasattr(model, "asks_robot")))], -1)
        p = p[np.asarray(model.visible(model.project(p)[0], p))][:1]
        if not len(p):
            continue
        a = free.start * (1 + 0.01 * rng.normal(size=len(free.start)))
        a[free.slices()["bias"]] = 0.01 * rng.normal(size=len(model.R))
        check_jacobians(free.project, np.concatenate([p[0], a]), rtol=1e-5)
        if written(model, "retro"):
            y = free.project(np.concatenate([p[0], a]))[0]
            check_jacobians(free.retro, np.concatenate([y, a]), rtol=1e-5)


def check_states(sensor, names, lmk, rng):
    """Test the whole chain of a sensor with parameters that are states, `delay` among them: E_r, E_s, E_l and L.

    Raises
    ------
    AssertionError
    """
    free: Any = Calibrated(sensor, names)
    F = Frame2 if sensor.dim == 2 else Frame3
    kind = state_class(F, free)
    moving = hasattr(free, "asks_robot")
    x, a = robot_state(F, rng), free.start + 0.01 * rng.normal(size=len(free.start))
    s = np.concatenate([random_frame(F, rng).x, a])
    robot: Any = (lambda x: Moving(AnyRobot(F), x)) if moving else F
    x = x if moving else x[: F.size]
    y = sensor.project(random_points(F.dim, rng, sensor))[0][0]
    n = np.array([0.3]) if sensor.bearing_only else np.zeros(0)
    check_jacobians(lambda x, s, y, n: retro_project(robot(x), kind(s), free, lmk, y, n), x, s, y, n, rtol=1e-5)
    l = retro_project(robot(x), kind(s), free, lmk, y, n)[0]
    check_jacobians(lambda x, s, l: observe(robot(x), kind(s), free, lmk, l), x, s, l, rtol=1e-5)
    assert np.allclose(free.residual(observe(robot(x), kind(s), free, lmk, l)[0], y), 0, atol=1e-5)
