"""Exercise 10.4: the error of a pose, six numbers."""

import numpy as np

from ...geometry import Frame3, q2e, q2qc, q2v, q_prod, unit, v2q
from .. import expect
from ..exercise import Exercise


def pose_error(x, truth):
    """Error of an estimated pose, in the tangent space of the true one.

    x, truth, shape (7,): frames [t, q] with unit quaternions.
    Return e, shape (6,): first t - t_truth; then v, the rotation vector (radians, in the true robot's axes) that
    turns the true orientation into the estimated one, q = q_truth v2q(v), the shorter way round: |v| <= pi.
    """
    dq, _, _ = q_prod(q2qc(truth[3:])[0], x[3:])
    v, _ = q2v(dq if dq[0] >= 0 else -dq)
    return np.concatenate([x[:3] - truth[:3], v])


exercise = Exercise(
    "10.4",
    "The error of a pose",
    pose_error,
    hints=(
        "Solve q = q_truth dq for dq: what is the inverse of a unit quaternion?",
        "dq = conjugate of q_truth, times q. q2v makes a rotation vector of it. Of dq and -dq, which is the short way?",
        "dq, _, _ = q_prod(q2qc(truth[3:])[0], x[3:]); if dq[0] < 0 take -dq; v, _ = q2v(dq).",
    ),
)


def _pose(rng):
    return np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])


def _off(truth, e):
    """The pose that has the error e."""
    return np.concatenate([truth[:3] + e[:3], q_prod(truth[3:], v2q(e[3:])[0])[0]])


def _vector(rng, angle):
    return angle * unit(rng.normal(size=3))[0]


def _e(result):
    return expect.array(result, 6, "e")


@exercise.link("six numbers", "A pose in space has six degrees of freedom: three of position, three of rotation.")
def _(f, rng):
    truth = _pose(rng)
    _e(f(_off(truth, 0.1 * rng.normal(size=6)), truth))


@exercise.link("position", "The first three numbers are t - t_truth.")
def _(f, rng):
    for _ in range(3):
        truth, d = _pose(rng), rng.normal(size=3)
        expect.close(_e(f(_off(truth, np.concatenate([d, np.zeros(3)])), truth))[:3], d, "e[:3]")


@exercise.link("a small turn", "q = q_truth dq, so dq = conjugate of q_truth, times q.")
def _(f, rng):
    level = np.array([0.0, 0, 0, 1, 0, 0, 0])
    for v in np.vstack([0.1 * np.eye(3), -0.2 * np.eye(3)]):
        e = _e(f(_off(level, np.concatenate([np.zeros(3), v])), level))
        expect.close(e[3:], v, "e[3:]", at=f"a true robot that is not turned, and an estimate turned by {v.tolist()}")
    for _ in range(3):
        truth, v = _pose(rng), _vector(rng, 0.3)
        e = _e(f(_off(truth, np.concatenate([rng.normal(size=3), v])), truth))
        expect.close(e[3:], v, "e[3:]", at="any truth")


@exercise.link("a large turn", "A rotation vector has the angle as its length, up to pi.")
def _(f, rng):
    for angle in (1.0, 2.0, 3.0):
        truth, v = _pose(rng), _vector(rng, angle)
        e = _e(f(_off(truth, np.concatenate([rng.normal(size=3), v])), truth))
        expect.close(e[3:], v, "e[3:]", at=f"an error of {angle} rad")


@exercise.link("q and -q", "q and -q are the same orientation, so the error must be the same.")
def _(f, rng):
    for angle in (0.0, 0.2, 2.5):
        truth, v = _pose(rng), _vector(rng, angle)
        x = _off(truth, np.concatenate([rng.normal(size=3), v]))
        for a, b in ((-1, 1), (1, -1), (-1, -1)):
            x2, truth2 = x.copy(), truth.copy()
            x2[3:] *= a
            truth2[3:] *= b
            expect.close(_e(f(x2, truth2))[3:], v, "e[3:]", atol=1e-6, at="a quaternion with the other sign")


def _dq(x, truth):
    dq = q_prod(q2qc(truth[3:])[0], x[3:])[0]
    return dq if dq[0] >= 0 else -dq


def _with(rotation):
    """A wrong answer: the right position error, another error of the rotation."""

    def answer(x, truth):
        return np.concatenate([np.subtract(x[:3], truth[:3]), rotation(np.asarray(x[3:]), np.asarray(truth[3:]))])

    return answer


def _short(q):
    return q2v(q if q[0] >= 0 else -q)[0]


# fmt: off
exercise.wrong("seven differences", "x - truth has 7 numbers, and q and -q would differ though they are the same "
               "orientation. Use the rotation vector of conj(q_truth) q.")(lambda x, truth: np.subtract(x, truth))
exercise.wrong("sign of dq not looked at", "q and -q are the same orientation. When dq[0] is negative take -dq, else "
               "you go the long way round.")(_with(lambda q, p: q2v(q_prod(q2qc(p)[0], q)[0])[0]))
exercise.wrong("truth minus estimate", "An error is estimate minus truth: you have the two the other way "
               "round.")(lambda x, truth: np.concatenate([np.subtract(truth[:3], x[:3]),
                                                          -q2v(_dq(x, truth))[0]]))
exercise.wrong("rotation the other way", "You turn the estimate into the truth. Conjugate the true quaternion, not the "
               "estimated one.")(_with(lambda q, p: _short(q_prod(q2qc(q)[0], p)[0])))
exercise.wrong("in the axes of the world", "q q_truth* is the turn in the axes of the world. q = q_truth dq: put the "
               "conjugate on the left.")(_with(lambda q, p: _short(q_prod(q, q2qc(p)[0])[0])))
exercise.wrong("no conjugate", "The product of two orientations is no difference: conjugate the true "
               "one.")(_with(lambda q, p: _short(q_prod(p, q)[0])))
exercise.wrong("difference of the quaternions", "Twice the difference of the vector parts is right for a truth that is "
               "not turned only: multiply by the conjugate.")(_with(lambda q, p: 2 * (q - p)[1:]))
exercise.wrong("vector part of dq", "[b, c, d] of dq is half the rotation vector, and for small angles only: use "
               "q2v.")(lambda x, truth: np.concatenate([np.subtract(x[:3], truth[:3]), _dq(x, truth)[1:]]))
exercise.wrong("twice the vector part", "2 [b, c, d] is the rotation vector for small angles only: use "
               "q2v.")(lambda x, truth: np.concatenate([np.subtract(x[:3], truth[:3]), 2 * _dq(x, truth)[1:]]))
exercise.wrong("difference of the Euler angles", "Euler angles cannot be subtracted, as little as quaternions: use the "
               "rotation vector of dq.")(_with(lambda q, p: q2e(q)[0] - q2e(p)[0]))
exercise.wrong("Euler angles of dq", "Roll, pitch and yaw of dq are no rotation vector, if the error is large: use "
               "q2v.")(lambda x, truth: np.concatenate([np.subtract(x[:3], truth[:3]), q2e(_dq(x, truth))[0]]))
exercise.wrong("difference of the rotation vectors", "Rotation vectors of two orientations cannot be subtracted: make "
               "dq first.")(_with(lambda q, p: _short(q) - _short(p)))
exercise.wrong("position in the axes of the robot", "The position error is asked in the axes of the world: t - "
               "t_truth.")(lambda x, truth: np.concatenate([Frame3(truth).to_frame(np.asarray(x[:3]))[0],
                                                            q2v(_dq(x, truth))[0]]))
# fmt: on


@exercise.variant("the package's difference")
def _(x, truth):
    return Frame3(x).minus(Frame3(truth))[0]


@exercise.variant("scipy's rotations")
def _(x, truth):
    from scipy.spatial.transform import Rotation

    q, p = (Rotation.from_quat(np.roll(y[3:], -1)) for y in (x, truth))  # scipy: scalar last
    return [*np.subtract(x[:3], truth[:3]), *(p.inv() * q).as_rotvec()]


@exercise.variant("with arctan2")
def _(x, truth):
    a, *b = q_prod(q2qc(truth[3:])[0], x[3:])[0]
    n = np.linalg.norm(b)
    if n < 1e-12:
        return np.array([*(x[:3] - truth[:3]), 0, 0, 0])
    angle = 2 * np.arctan2(n, a)
    angle = angle - 2 * np.pi if angle > np.pi else angle
    return np.array([*(x[:3] - truth[:3]), *(angle * np.array(b) / n)])
