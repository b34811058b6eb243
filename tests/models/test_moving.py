"""A robot that moves, as a sensor sees it, and controls split in time: against the exponential map, by matrices."""

import pickle

import numpy as np
import pytest
from scipy.linalg import expm

from ekfslam_tutorial.geometry import Frame2, Frame3, check_jacobians, hat
from ekfslam_tutorial.models import Moving
from ekfslam_tutorial.models.behind import frame_with
from ekfslam_tutorial.models.motion import (
    ConstantTurn,
    ConstantVelocity,
    Imu,
    ImuClock,
    Odometry2,
    Odometry3,
)
from ekfslam_tutorial.models.motion.odometry3 import SMALL, screw
from ekfslam_tutorial.models.state_contracts import AnyRobot, robot_state
from ekfslam_tutorial.models.trials import random_frame

both = pytest.mark.parametrize("F", [Frame2, Frame3])


def matrix(F):
    """Frame as a homogeneous matrix."""
    d = F.dim
    M = np.eye(d + 1)
    M[:d, :d], M[:d, d] = F.R, F.t
    return M


def rates(V):
    """[v; w] as the matrix whose exponential is the motion of a second."""
    d = 2 if len(V) == 3 else 3
    M = np.zeros((d + 1, d + 1))
    M[:d, :d], M[:d, d] = ([[0, -V[2]], [V[2], 0]] if d == 2 else hat(V[3:])), V[:d]
    return M


@both
def test_how_a_place_on_a_robot_moves(F, rng):
    """S^-1 V S, all as matrices; each number of it counts, also the turn, which no sensor of the package measures."""
    for _ in range(3):
        x, S = robot_state(F, rng), random_frame(F, rng)
        seen = Moving(AnyRobot(F), x)
        want = np.linalg.inv(matrix(S)) @ rates(x[F.size :]) @ matrix(S)
        assert np.allclose(rates(seen.velocity(S)[0]), want, atol=1e-12)
        check_jacobians(lambda x, S: Moving(AnyRobot(F), x).velocity(S), x, S)


@both
@pytest.mark.parametrize("before", [0, 2], ids=["delay first", "delay third"])
def test_where_a_late_sensor_was(F, before, rng):
    """The robot as it was, by a turn and a shift back; other parameters stand before the delay or behind it."""
    kind = frame_with(F, 4, F.size + before)
    for delay in (0.0, 0.3, -0.2):
        x, s = robot_state(F, rng), np.concatenate([random_frame(F, rng).x, rng.normal(size=4)])
        s[F.size + before] = delay
        V = rates(-delay * x[F.size :])
        back = expm(V)  # of the turn; the shift is straight
        back[: F.dim, F.dim] = V[: F.dim, F.dim]
        got = Moving(AnyRobot(F), x).compose(kind(s))
        assert np.allclose(matrix(got[0]), matrix(F(x[: F.size])) @ back @ matrix(F(s[: F.size])), atol=1e-12)
        check_jacobians(lambda x, s: Moving(AnyRobot(F), x).compose(kind(s)), x, s)


@both
def test_a_frame_with_parameters_behind_it(F, rng):
    """It is that frame: normalised and compared without them; and it is the same after a journey to a file and back."""
    kind, n = frame_with(F, 3, F.size + 1), F.size
    s, other = rng.normal(size=n + 3) + 2, kind(np.concatenate([random_frame(F, rng).x, rng.normal(size=3)]))
    s[n - 1] += 5  # more than half a turn
    S = kind(s)
    assert kind.size == n + 3 and np.array_equal(S.a, s[n:]) and S.delay == s[n + 1] and np.array_equal(S.t, s[: F.dim])
    N, J = S.normalized()
    plain, P = F(s[:n]).normalized()
    assert type(N) is kind and np.array_equal(N.x, [*plain.x, *s[n:]])
    want = np.eye(n + 3)
    want[:n, :n] = P
    assert np.array_equal(J, want) and not np.array_equal(N.x, s)
    for got, single in zip(N.minus(other), plain.minus(F(other.x[:n])), strict=True):
        assert np.array_equal(got, single)
    back = pickle.loads(pickle.dumps(S))
    assert np.array_equal(back.x, s) and back.size == n + 3 and back.delay == S.delay and back.plain is F
    assert frame_with(F, 3)(s).delay is None


def test_the_last_of_many_controls_is_the_one_of_now(rng):
    x, u = rng.normal(size=17), rng.normal(size=(3, 18))
    V = lambda u: Moving(ImuClock(), x, u).V
    assert np.array_equal(V(u), V(u[2])) and not np.allclose(V(u), V(u[0]))
    assert np.array_equal(V(None), V(np.zeros(18)))


# --- a control in two parts -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model, n", [(Odometry2(), 3), (Odometry3(), 6)], ids=["plane", "space"])
@pytest.mark.parametrize("turn", [1.0, 1e-2, 1e-5, 0.0])
def test_a_step_is_the_end_of_a_steady_motion(model, n, turn, rng):
    """Its part is where that motion is after a part of the time: exp(f log), of matrices, also beyond the end."""
    V, U = rng.normal(size=n), rng.normal(size=(n, n))
    V[model.frame.dim :] *= turn
    step = lambda f: matrix(model.frame(model.move(origin, model.part(u, U, f)[0], 1.0)[0]))
    origin = np.eye(7)[3] if n == 6 else np.zeros(3)
    end = expm(rates(V))
    u = np.concatenate([end[: model.frame.dim, -1], V[model.frame.dim :]])
    for f in (0.3, 1.0, 1.7):
        assert np.allclose(step(f), expm(rates(f * V)), atol=1e-11)
        assert np.array_equal(model.part(u, U, f)[1], f * U)


@pytest.mark.parametrize("a", [0.0, 1e-9, 0.999 * SMALL, SMALL, 1.001 * SMALL, 1.0, 3.0])
def test_a_screw_is_an_integral(a, rng):
    """int_0^1 R(s v) ds is a block of the exponential of a larger matrix."""
    v = rng.normal(size=3)
    v *= a / np.linalg.norm(v)
    whole = np.zeros((6, 6))
    whole[:3, :3], whole[:3, 3:] = hat(v), np.eye(3)
    assert np.allclose(screw(v), expm(whole)[:3, 3:], atol=1e-10) and SMALL == 1e-3


@pytest.mark.parametrize(
    "model, u_by, U_by",
    [  # powers of the share, by which each number of u and each standard deviation of U is multiplied
        (ConstantTurn(), [1] * 2, [0.5] * 2),
        (ConstantVelocity(), [1] * 6, [0.5] * 6),
        (Imu(), [0] * 6 + [1] * 6, [-0.5] * 6 + [0.5] * 6),
        (ImuClock(), [0] * 6 + [1] * 6 + [0] * 6, [-0.5] * 6 + [0.5] * 6 + [0] * 6),
    ],
    ids=lambda value: type(value).__name__,
)
def test_impulses_and_noise_in_parts(model, u_by, U_by, rng):
    n, f = len(u_by), 0.37
    u, A = rng.normal(size=n), rng.normal(size=(n, n))
    part, P = model.part(u, A @ A.T, f)
    assert np.allclose(part, f ** np.array(u_by, float) * u, rtol=1e-14)
    s = np.diag(f ** np.array(U_by, float))
    assert np.allclose(P, s @ A @ A.T @ s, rtol=1e-13)


def test_a_clock_that_is_ahead_measures_what_comes(rng):
    """With the offset s the control of `Imu` is [w; a] + s r, all else is as it was; the rates have no noise."""
    imu, clock = Imu(1e-3, 2e-3, 3e-3, 4e-3), ImuClock(1e-3, 2e-3, 3e-3, 4e-3)
    x, u = np.concatenate([random_frame(Frame3, rng).x, rng.normal(size=10)]), rng.normal(size=18)
    same = u[:12] + np.concatenate([x[16] * u[12:], np.zeros(6)])
    assert np.allclose(clock.move(x, u, 0.1)[0], [*imu.move(x[:16], same, 0.1)[0], x[16]])
    assert np.allclose(clock.velocity(x, u)[0], imu.velocity(x[:16], same)[0])
    check_jacobians(lambda x: clock.velocity(x, u), x)
    U = np.zeros((18, 18))
    U[:12, :12] = imu.noise(0.2)
    assert np.array_equal(clock.noise(0.2), U)
    assert np.allclose(
        np.diag(U), [*[1e-6 / 0.2] * 3, *[4e-6 / 0.2] * 3, *[9e-6 * 0.2] * 3, *[16e-6 * 0.2] * 3, *[0] * 6]
    )
    assert clock.turning(x).shape == (10, 3)


def test_what_turns_with_the_world(rng):
    """v of a state in the world, by the motion of the whole: X_x B(x) = B(x2) holds for a turn about the vertical."""
    x = np.concatenate([random_frame(Frame3, rng).x, rng.normal(size=6)])
    T = ConstantVelocity().turning(x)
    assert np.array_equal(T[:3], -hat(x[7:10])) and T.shape == (6, 3) and not T[3:].any()
    assert np.array_equal(ConstantTurn().turning(np.ones((4, 5))), np.zeros((4, 2, 1)))
