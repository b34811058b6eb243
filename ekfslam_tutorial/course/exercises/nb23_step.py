"""Exercise 23.1: one step of an IMU, and how its biases come in."""

import numpy as np

from ...geometry import q2R, q_prod, unit, v2q
from .. import expect
from ..diagnose import same
from ..table import table
from .nb11_odo3 import as_wanted, positive  # noqa: F401

GRAVITY = np.array([0, 0, -9.81])


def imu_step(x, u, dt):
    """One step of an IMU: what it measures, made into motion, and what a change of the biases would change.

    x = [t, q, v, b_w, b_a], shape (16,): position (m), orientation and velocity (m/s) in the world, whose z axis points
    up; the biases of the gyrometer (rad/s) and of the accelerometer (m/s^2). u = [w, a], shape (6,): what the two
    measure, in the axes of the IMU (rad/s, m/s^2). dt: seconds.
    Without their biases, w and a hold for dt; a is turned into the world with the orientation in the middle of the
    step. Gravity is [0, 0, -9.81] m/s^2. The biases stay as they are.
    Return x2, shape (16,), without normalisation; and X_b, shape (16, 6): its derivative by the biases [b_w, b_a].
    """
    t, q, v, b = x[:3], x[3:7], x[7:10], x[10:]
    w, a = u[:3] - b[:3], u[3:] - b[3:]
    dq, DQ_w = v2q(w * dt)
    q2, _, Q_dq = q_prod(q, dq)
    half, HALF_w = v2q(w * dt / 2)
    m, _, M_half = q_prod(q, half)
    R, R_m = q2R(m)
    g = R @ a + np.array([0, 0, -9.81])
    G_w = np.einsum("ijk,j->ik", R_m, a) @ M_half @ HALF_w * dt / 2
    X_b = np.zeros((16, 6))
    X_b[:3] = np.hstack([G_w, R]) * -(dt**2) / 2
    X_b[3:7, :3] = -Q_dq @ DQ_w * dt
    X_b[7:10] = np.hstack([G_w, R]) * -dt
    X_b[10:] = np.eye(6)
    return np.concatenate([t + v * dt + g * dt**2 / 2, q2, v + g * dt, b]), X_b


def case(rng, turns=1.0, dt=None):
    """Return a state, a measurement and a time: everything counts, but for the turn if so wanted."""
    x = np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0], rng.uniform(-2, 2, 3)])
    b = np.concatenate([rng.uniform(-0.2, 0.2, 3), rng.uniform(-0.9, 0.9, 3)])
    w = turns * rng.uniform(-1.5, 1.5, 3) + b[:3]
    a = rng.uniform(-6, 12, 3)
    return np.concatenate([x, b]), np.concatenate([w, a]), float(rng.uniform(0.1, 0.5) if dt is None else dt)


def rest(rng):
    """Return an IMU that lies still, in any attitude: it measures its biases, and what holds it up."""
    x, u, dt = case(rng)
    x[7:10] = 0
    R = q2R(x[3:7])[0]
    return x, np.concatenate([x[10:13], -R.T @ GRAVITY + x[13:]]), dt


exercise = table(
    "23.1 One step of an IMU",
    imu_step,
    hints=(
        "First take the biases off: w = u[:3] - b_w, a = u[3:] - b_a. Then the turn: q2 = q times v2q(w dt). Then the acceleration of the world: R a + gravity, with R in the middle: q times v2q(w dt / 2).",
        "With g = R a + gravity: t2 = t + v dt + g dt^2 / 2 and v2 = v + g dt. A bias is subtracted from what is measured: its derivatives are those by w and a with the sign changed.",
        "G_w, the derivative of g by w: R, R_m = q2R(m); np.einsum('ijk,j->ik', R_m, a) by m; M_half of q_prod; HALF_w of v2q; and dt / 2. Then X_b[7:10] = -dt [G_w, R], X_b[:3] = -dt^2/2 [G_w, R], X_b[3:7, :3] = -Q_dq DQ_w dt.",
    ),
    returns="x2, X_b",
    symbols="DQ_w, HALF_w = the second results of v2q for the whole step and for half of it",
    settled=as_wanted,
    cases={
        "any": lambda rng: [case(rng) for _ in range(2)],
        "rest": lambda rng: [rest(rng) for _ in range(2)],
        "no turn": lambda rng: [case(rng, turns=0.0)],
    },
    checks="""
    at rest     | x2[:10]  | rest    | An IMU that lies still measures its biases, and 9.81 m/s^2 upwards: what is left of them is no motion.
    orientation | x2[3:7]  | any     | In dt the body turns by the rotation vector (w - b_w) dt, in its own axes: q v2q(...).
    velocity    | x2[7:10] | any     | v2 = v + (R (a - b_a) + gravity) dt; R is the orientation in the middle of the step: q, turned by half of the rotation vector, in the axes of the body.
    position    | x2[:3]   | any     | t2 = t + v dt + (R (a - b_a) + gravity) dt^2 / 2, with the old v.
    no turn     | x2       | no turn | Without a turn the orientation stays, and R is that of q.
    biases      | x2       | any     | The biases stay as they are, at the end of the state.
    """,
    wrong="""
    gravity forgotten | g = R @ a + np.array([0, 0, -9.81]) -> g = R @ a | An accelerometer does not feel gravity, only what holds it up: add gravity in the world.
    gravity upwards | np.array([0, 0, -9.81]) -> np.array([0, 0, 9.81]) | z points up, and things fall down: gravity, -9.81 along z, is added. At rest R (a - b_a) is +9.81 along z, and both together are zero.
    gravity in the axes of the IMU | g = R @ a + np.array([0, 0, -9.81]) -> g = R @ (a + np.array([0, 0, -9.81])) | Gravity is given in the world: add it after a is turned.
    biases added | w, a = u[:3] - b[:3], u[3:] - b[3:] -> w, a = u[:3] + b[:3], u[3:] + b[3:] | measured = true + bias. So the true one is measured *minus* bias.
    biases added in all: measured = true + bias. So the true one is measured *minus* bias: in the derivatives, too.
        w, a = u[:3] - b[:3], u[3:] - b[3:] -> w, a = u[:3] + b[:3], u[3:] + b[3:]
        np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([G_w, R]) * dt**2 / 2
        -Q_dq @ DQ_w * dt -> Q_dq @ DQ_w * dt
        np.hstack([G_w, R]) * -dt -> np.hstack([G_w, R]) * dt
    gyro bias added | w, a = u[:3] - b[:3] -> w, a = u[:3] + b[:3] | measured = true + bias. So the true turn rate is u[:3] *minus* b_w.
    acc bias added | u[3:] - b[3:] -> u[3:] + b[3:] | measured = true + bias. So the true acceleration is u[3:] *minus* b_a.
    gyro bias forgotten | w, a = u[:3] - b[:3] -> w, a = u[:3] | The gyrometer has a bias, too: w = u[:3] - b_w.
    acc bias forgotten | u[3:] - b[3:] -> u[3:] | The accelerometer has a bias, too: a = u[3:] - b_a.
    biases exchanged | w, a = u[:3] - b[:3], u[3:] - b[3:] -> w, a = u[:3] - b[3:], u[3:] - b[:3] | In the state the bias of the gyrometer comes first: x[10:13].
    a not turned | g = R @ a + -> g = a + | a is measured in the axes of the IMU: R a is it in the world.
    turned the wrong way | g = R @ a + -> g = R.T @ a + | R takes from the IMU into the world; R' the other way.
    orientation of the start: Take the orientation in the middle of the step: q v2q(w dt / 2). With that of the start the acceleration lags by half a step.
        v2q(w * dt / 2) -> v2q(0 * w)
        @ HALF_w * dt / 2 -> @ HALF_w * 0
    orientation of the end: Take the orientation in the middle of the step: q v2q(w dt / 2). That of the end is half a step too late.
        v2q(w * dt / 2) -> v2q(w * dt)
        @ HALF_w * dt / 2 -> @ HALF_w * dt
    turn in the axes of the world | q2, _, Q_dq = q_prod(q, dq) -> q2, Q_dq, _ = q_prod(dq, q) | w is in the axes of the body: its quaternion stands on the right.
    both turns in the axes of the world: w is in the axes of the body: its quaternion stands on the right, in the turn and in the middle of the step.
        q2, _, Q_dq = q_prod(q, dq) -> q2, Q_dq, _ = q_prod(dq, q)
        m, _, M_half = q_prod(q, half) -> m, M_half, _ = q_prod(half, q)
    dt forgotten in the turn | v2q(w * dt) -> v2q(w) | w is in radians per second: v2q(w dt).
    half the turn | v2q(w * dt) -> v2q(w * dt / 2) | v2q has the half angle in it already: v2q(w dt).
    a half forgotten in the position | v * dt + g * dt**2 / 2, q2 -> v * dt + g * dt**2, q2 | A constant acceleration moves by half of it times dt^2, as the new velocity holds at the end of the step only.
    a half forgotten in all: A constant acceleration moves by half of it times dt^2: the half is missing, in X_b, too.
        v * dt + g * dt**2 / 2, q2 -> v * dt + g * dt**2, q2
        np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([G_w, R]) * -(dt**2)
    no acceleration in the position | t + v * dt + g * dt**2 / 2, q2 -> t + v * dt, q2 | Within a step the velocity changes: half of the acceleration in the world, times dt^2, is missing.
    v in the axes of the body | t + v * dt + -> t + R @ v * dt + | Here v is in the axes of the world: it is not turned.
    dt forgotten in the velocity | v + g * dt, b -> v + g, b | An acceleration is in m/s^2: times dt it is a change of v.
    sign of the derivatives: A bias is subtracted: its derivatives have the opposite sign of those by the measurement.
        np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([G_w, R]) * dt**2 / 2
        -Q_dq @ DQ_w * dt -> Q_dq @ DQ_w * dt
        np.hstack([G_w, R]) * -dt -> np.hstack([G_w, R]) * dt
    v by b_w forgotten: A wrong turn rate turns the acceleration of the same step already, as R is in the middle: X_b[7:10, :3] and X_b[:3, :3] are not zero.
        G_w = np -> G_w = 0 * np
    q by b_w forgotten | -Q_dq @ DQ_w * dt -> 0 | The turn depends on b_w: X_b[3:7, :3] is not zero.
    biases by themselves forgotten | X_b[10:] = np.eye(6) -> X_b[10:] = 0 | The biases stay as they are: their derivative by themselves is the identity.
    dt forgotten in d(q2)/d(b_w) | -Q_dq @ DQ_w * dt -> -Q_dq @ DQ_w | The inner derivative: d(w dt)/dw = dt.
    position by the biases forgotten | np.hstack([G_w, R]) * -(dt**2) / 2 -> 0 | The position moves by half of the acceleration times dt^2, and that depends on both biases: X_b[:3] is not zero.
    R transposed in the derivatives: The derivative of the acceleration in the world by b_a is -R: R takes from the IMU into the world. In X_b yours is transposed.
        np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([G_w, R.T]) * -(dt**2) / 2
        np.hstack([G_w, R]) * -dt -> np.hstack([G_w, R.T]) * -dt
    small turn: The derivative of v2q must be taken at w dt for the turn, at w dt / 2 for the middle of the step, and not at zero.
        @ DQ_w * dt -> @ v2q(0 * w)[1] * dt
        @ HALF_w * dt / 2 -> @ v2q(0 * w)[1] * dt / 2
    columns of X_b exchanged | X_b[10:] = np.eye(6) -> X_b[10:] = np.eye(6); X_b = np.hstack([X_b[:, 3:], X_b[:, :3]]) | The columns of X_b are by b_w first, then by b_a, as the biases stand in x.
    acc bias added in all: measured = true + bias. So the true acceleration is measured *minus* bias: in the derivatives, too.
        u[3:] - b[3:] -> u[3:] + b[3:]
        X_b[:3] = np.hstack([G_w, R]) -> X_b[:3] = np.hstack([G_w, -R])
        X_b[7:10] = np.hstack([G_w, R]) -> X_b[7:10] = np.hstack([G_w, -R])
    gyro bias added in all: measured = true + bias. So the true turn rate is measured *minus* bias: in the derivatives, too.
        w, a = u[:3] - b[:3] -> w, a = u[:3] + b[:3]
        X_b[:3] = np.hstack([G_w, R]) -> X_b[:3] = np.hstack([-G_w, R])
        X_b[7:10] = np.hstack([G_w, R]) -> X_b[7:10] = np.hstack([-G_w, R])
        -Q_dq @ DQ_w * dt -> Q_dq @ DQ_w * dt
    derivative of the transpose | np.einsum("ijk,j->ik", R_m, a) -> np.einsum("ijk,i->jk", R_m, a) | The derivative of R by q has three indices, R[i, j] by q[k]. R a is a sum over j: summed over i, yours is the derivative of R' a.
    v and t by b_a: sign | np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([G_w, -R]) * -(dt**2) / 2 | b_a is subtracted from what is measured: the derivatives of v and t by it are -R dt and -R dt^2 / 2.
        np.hstack([G_w, R]) * -dt -> np.hstack([G_w, -R]) * -dt
    v and t by b_w: sign | np.hstack([G_w, R]) * -(dt**2) / 2 -> np.hstack([-G_w, R]) * -(dt**2) / 2 | b_w is subtracted from what is measured: its derivatives have the opposite sign of those by the measurement, those of v and t, too.
        np.hstack([G_w, R]) * -dt -> np.hstack([-G_w, R]) * -dt
    q by b_w: sign | -Q_dq @ DQ_w * dt -> Q_dq @ DQ_w * dt | b_w is subtracted from what is measured: the derivative of q2 by it has a minus.
    gravity forgotten in the position | g * dt**2 / 2, q2 -> (R @ a) * dt**2 / 2, q2 | What falls moves, too: the position has half of (R a + g) dt^2, gravity included.
    a with its bias in the derivative | G_w = np.einsum("ijk,j->ik", R_m, a) -> G_w = np.einsum("ijk,j->ik", R_m, u[3:]) | What R turns is a without its bias, a - b_a: so it is in the derivative of R a.
    the other derivative of the product | np.einsum("ijk,j->ik", R_m, a) @ M_half -> np.einsum("ijk,j->ik", R_m, a) @ q_prod(q, half)[1] | q_prod(q, half) has two derivatives, by q and by `half`: b_w sits in `half`, so it is the second one.
    half of the turn forgotten in the derivative | @ HALF_w * dt / 2 -> @ HALF_w * dt | The middle of the step turns by w dt / 2: its inner derivative is dt / 2 by w, and -dt / 2 by b_w.
    half of dt^2 forgotten in X_b | X_b[:3] = np.hstack([G_w, R]) * -(dt**2) / 2 -> X_b[:3] = np.hstack([G_w, R]) * -(dt**2) | The position has half of a dt^2, and so have its derivatives.
    """,
)


@exercise.link(
    "derivative by the biases",
    "A bias is subtracted from what is measured: X_b has the derivatives by w and a, with the sign changed, and ones for the biases themselves.",
    1,
)
def _(f, rng):
    names = [f"{n}_{i}" for n in ("t", "q", "v", "b_w", "b_a") for i in ("abcd" if n == "q" else "xyz")]
    for turns in 1.0, 0.0:
        x, u, dt = case(rng, turns)
        x2, X_b = expect.results(f(x, u, dt), "x2", "X_b")
        want = imu_step(x, u, dt)
        _, got = as_wanted((expect.array(x2, 16, "x2"), expect.array(X_b, (16, 6), "X_b")), want)
        if same(got, want[1]):
            continue
        value = lambda b, x=x, u=u, dt=dt: imu_step(np.concatenate([x[:10], b]), u, dt)[0]
        expect.jacobian(got, value, x[10:], "X_b", names, names[10:])
