"""Exercise 10.4: the error of a pose, six numbers."""

import numpy as np

from ...geometry import Frame3, q2e, q2qc, q2v, q_prod, unit, v2q  # noqa: F401
from .. import expect
from ..diagnose import same
from ..table import table


def pose_error(x, truth):
    """Error of an estimated pose, in the tangent space of the true one.

    x, truth, shape (7,): frames [t, q] with unit quaternions.
    Return e, shape (6,): first t - t_truth; then v, the rotation vector (radians, in the true robot's axes) that
    turns the true orientation into the estimated one, q = q_truth v2q(v), the shorter way round: |v| <= pi.
    """
    dq, _, _ = q_prod(q2qc(truth[3:])[0], x[3:])
    v, _ = q2v(dq if dq[0] >= 0 else -dq)
    return np.concatenate([x[:3] - truth[:3], v])


def pose(rng):
    """Return some frame."""
    return np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])


def off(truth, d, v):
    """Return the pose that has the error [d, v], and the truth."""
    return np.concatenate([truth[:3] + d, q_prod(truth[3:], v2q(np.asarray(v, float))[0])[0]]), truth


def some(rng, angle):
    """Return a pose that is turned by so much from the truth, about any axis, and the truth."""
    return off(pose(rng), rng.normal(size=3), angle * unit(rng.normal(size=3))[0])


LEVEL = np.eye(7)[3]

exercise = table(
    "10.4 The error of a pose",
    pose_error,
    hints=(
        "Solve q = q_truth dq for dq: what is the inverse of a unit quaternion?",
        "dq = conjugate of q_truth, times q. q2v makes a rotation vector of it. Of dq and -dq, which is the short way?",
        "dq, _, _ = q_prod(q2qc(truth[3:])[0], x[3:]); if dq[0] < 0 take -dq; v, _ = q2v(dq).",
    ),
    returns="e",
    cases={
        "any": lambda rng: [some(rng, 0.3) for _ in range(4)],
        "level": lambda rng: [off(LEVEL, np.zeros(3), v) for v in (*(0.1 * np.eye(3)), *(-0.2 * np.eye(3)))],
        "no turn": lambda rng: [(np.r_[1, 2, 3, q], np.r_[1, 2, 4, q]) for q in (LEVEL[3:], np.full(4, 0.5))],
        "large": lambda rng: [some(rng, angle) for angle in (1.0, 2.0, 3.0, 3.1)],
    },
    checks="""
    position      | e[:3] | any   | A pose in space has six degrees of freedom: three of position, three of rotation. The first three numbers are t - t_truth.
    level         | e[3:] | level | The truth is not turned here, so dq is q itself, and v is the rotation vector of q, about one axis. In general q = q_truth dq, so dq = conjugate of q_truth, times q.
    a small turn  | e[3:] | any   | q = q_truth dq, so dq = conjugate of q_truth, times q; v is the rotation vector of dq.
    no turn       | e[3:] | no turn | No turn is left: v is zero, and its axis is 0/0. Treat |v| = 0, or use q2v.
    a large turn  | e[3:] | large | A rotation vector has the angle as its length, up to pi.
    """,
    wrong="""
    seven differences | np.concatenate([x[:3] - truth[:3], v]) -> x - truth | x - truth has 7 numbers, and q and -q would differ though they are the same orientation. Use the rotation vector of conj(q_truth) q.
    sign of dq not looked at | dq if dq[0] >= 0 else -dq -> dq | q and -q are the same orientation. When dq[0] is negative take -dq, else you go the long way round.
    sign of q looked at | dq if dq[0] >= 0 else -dq -> dq if x[3] >= 0 else -dq | Two quaternions with a >= 0 may still be the long way round from each other: it is the sign of dq[0] that tells.
    signs of both looked at | dq if dq[0] >= 0 else -dq -> dq if x[3] * truth[3] >= 0 else -dq | Two quaternions with a >= 0 may still be the long way round from each other: it is the sign of dq[0] that tells, after the product.
    each component wrapped | q2v(dq if dq[0] >= 0 else -dq) -> q2v(dq); v = (v + np.pi) % (2 * np.pi) - np.pi | Shorten v along its axis, not each component: if |v| > pi, take v (1 - 2 pi / |v|), or -dq for dq.
    sign of zero | dq if dq[0] >= 0 else -dq -> dq * np.sign(dq[0]) | Half a turn has dq[0] = 0, and np.sign(0) is 0: half a turn vanishes. Use `if dq[0] < 0`, so that 0 is on one of the two sides.
    truth minus estimate | np.concatenate([x[:3] - truth[:3], v]) -> np.concatenate([truth[:3] - x[:3], -v]) | An error is estimate minus truth: you have the two the other way round.
    rotation the other way | q_prod(q2qc(truth[3:])[0], x[3:]) -> q_prod(q2qc(x[3:])[0], truth[3:]) | This is the turn from the estimate to the truth. v turns the truth into the estimate: dq = conjugate of q_truth, times q.
    in the axes of the world | q_prod(q2qc(truth[3:])[0], x[3:]) -> q_prod(x[3:], q2qc(truth[3:])[0]) | q q_truth* is the turn in the axes of the world. q = q_truth dq: put the conjugate on the left.
    no conjugate | q2qc(truth[3:])[0] -> truth[3:] | The product of two orientations is no difference: conjugate the true one.
    difference of the quaternions | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = 2 * (x - truth)[4:] | Twice the difference of the vector parts is right for a truth that is not turned only: multiply by the conjugate.
    vector part of dq | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = (dq if dq[0] >= 0 else -dq)[1:] | [b, c, d] of dq is half the rotation vector, and for small angles only: use q2v.
    twice the vector part | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = 2 * (dq if dq[0] >= 0 else -dq)[1:] | 2 [b, c, d] is the rotation vector for small angles only: use q2v.
    difference of the Euler angles | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = q2e(x[3:])[0] - q2e(truth[3:])[0] | Euler angles cannot be subtracted, as little as quaternions: use the rotation vector of dq.
    Euler angles of dq | q2v( -> q2e( | Roll, pitch and yaw of dq are no rotation vector, if the error is large: use q2v.
    difference of the rotation vectors | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = _short(x[3:]) - _short(truth[3:]) | Rotation vectors of two orientations cannot be subtracted: make dq first.
    position in the axes of the robot | x[:3] - truth[:3] -> Frame3(truth).to_frame(x[:3])[0] | The position error is asked in the axes of the world: t - t_truth.
    position the other way | x[:3] - truth[:3] -> truth[:3] - x[:3] | The position error is estimate minus truth, t - t_truth.
    degrees | v, _ = q2v(dq if dq[0] >= 0 else -dq) -> v = np.degrees(q2v(dq if dq[0] >= 0 else -dq)[0]) | The rotation vector is asked in radians: q2v gives radians.
    orientation first | [x[:3] - truth[:3], v] -> [v, x[:3] - truth[:3]] | The error of the position comes first, then the rotation vector.
    half the turn | np.concatenate([x[:3] - truth[:3], v]) -> np.concatenate([x[:3] - truth[:3], v / 2]) | A quaternion holds *half* the angle: the rotation vector has the angle 2 arctan2(|dq[1:]|, dq[0]).
    angle shortened, axis kept | q2v(dq if dq[0] >= 0 else -dq) -> q2v(dq); a = np.linalg.norm(v); v = v * (2 * np.pi - a) / a if a > np.pi else v | The shorter way round goes about the *opposite* axis: where dq[0] < 0 take -dq, all four numbers, before angle and axis are computed. Or later: v becomes v (1 - 2 pi / |v|) where |v| > pi.
    """,
)


@exercise.link(
    "q and -q",
    "q and -q are the same orientation, so the error must be the same, with |v| <= pi. The long way is shortened along its axis: -dq for dq.",
)
def _(f, rng):
    for angle in (0.0, 0.2, 2.5):
        x, truth = some(rng, angle)
        want = pose_error(x, truth)
        for a, b in ((-1, 1), (1, -1), (-1, -1)):
            sides = [np.concatenate([np.ones(3), np.full(4, s)]) for s in (a, b)]
            e = expect.array(f(sides[0] * x, sides[1] * truth), 6, "e")
            message = (
                f"e[3:] is {e[3:].round(4)} for a quaternion with the other sign, it should be {want[3:].round(4)}"
            )
            expect.true(same(e[3:], want[3:], atol=1e-6), message)


@exercise.link(
    "half a turn",
    "Half a turn has dq[0] = 0, and dq and -dq are equally short: either will do. v has the length pi, along the axis or against it.",
)
def _(f, rng):
    for axis in np.eye(3):
        e = expect.array(f(np.array([0, 0, 0, 0, *axis]), LEVEL), 6, "e")
        expect.close(np.abs(e[3:]), np.pi * axis, "|e[3:]|", at=f"half a turn about {axis}")  # v and -v are the same


def _short(q):
    return q2v(q if q[0] >= 0 else -q)[0]
