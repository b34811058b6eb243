"""Exercise 17.1: NEES of poses in space, in the tangent space."""

import numpy as np

from ...geometry import Frame3, q2e, q_prod, unit, v2q, wrap
from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def pose_nees(x, P, truth):
    """NEES of N estimated poses in space: 6 degrees of freedom each.

    x, shape (N, 7): estimated frames [t, q], q a unit quaternion; -q is the same orientation. P, shape (N, 7, 7): the
    covariances, as the filter has them. Rounding apart, P has rank 6: nothing is uncertain along q. truth, shape
    (N, 7): the true frames.
    `Frame3(x).minus(Frame3(truth))` returns e, E_x: the errors in the tangent space, shape (N, 6), and their
    derivatives by x, shape (N, 6, 7).
    Return the NEES of each pose, shape (N,).
    """
    e, E_x = Frame3(x).minus(Frame3(truth))
    C = E_x @ P @ np.swapaxes(E_x, -1, -2)  # covariance of e, rank 6
    return (e * np.linalg.solve(C, e[..., None])[..., 0]).sum(-1)


def directions(q):
    """How a quaternion moves with a small turn in the frame's own axes: dq/dv, shape (4, 3)."""
    a, b, c, d = q
    return 0.5 * np.array([[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]])


def poses(rng, angle, N=4, isotropic=False):
    """Estimates, covariances of rank 6 and true poses: turned by about `angle` (rad) from each other."""
    xs, Ps, truths = [], [], []
    for _ in range(N):
        truth = np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])
        v = angle * rng.uniform(0.5, 1) * unit(rng.normal(size=3))[0]
        q = q_prod(truth[3:], v2q(v)[0])[0]
        C = random_covariance(rng, 6, 0.05)
        C[3:] *= 0.02  # units differ: the angles are small
        C[:, 3:] *= 0.02
        if isotropic:
            C[3:], C[:, 3:] = 0, 0
            C[3:, 3:] = np.eye(3) * rng.uniform(0.2, 1) ** 2
        T = np.zeros((7, 6))
        T[:3, :3], T[3:, 3:] = np.eye(3), directions(q)
        xs.append(np.concatenate([truth[:3] + rng.normal(0, 0.3, 3), q]))
        Ps.append(T @ C @ T.T)
        truths.append(truth)
    return np.array(xs), np.array(Ps), np.array(truths)


SIGN = np.diag([1.0, 1, 1, -1, -1, -1, -1])


def signs(x, P, truth):
    """The same with -q in the estimates, and with -q in the truths."""
    return [(x, P, truth), (x @ SIGN, SIGN @ P @ SIGN, truth), (x, P, truth @ SIGN)]


tangent = table(
    "17.1 NEES of a pose in space",
    pose_nees,
    hints=(
        "NEES = e' C^-1 e, where C is the covariance of *that* e. Six numbers e need a 6 x 6 covariance.",
        "e is a function of x with the derivative E_x: its covariance is C = E_x P E_x'.",
        "C = E_x @ P @ np.swapaxes(E_x, -1, -2); np.linalg.solve(C, e[..., None])[..., 0] is C^-1 e for all N at once.",
    ),
    returns="nees",
    symbols="C = the covariance of e",
    rtol={"nees": 3e-4},  # P has lost digits
    cases={
        "any": lambda rng: [poses(rng, angle, N) for angle, N in ((0.01, 4), (0.02, 7), (0.01, 1))],
        "right turn": lambda rng: [poses(rng, 1e-9)],
        "signs": lambda rng: signs(*poses(rng, 0.02)),
    },
    checks="""
    one for each | nees | any        | Return N numbers, one NEES for each pose: e' C^-1 e, all six numbers of e, with its covariance C = E_x P E_x', E_x and P of that pose.
    position     | nees | right turn | Where the orientation is right, e is [t - t_truth, 0]; its covariance is still the whole C = E_x P E_x'.
    q and -q     | nees | signs      | q and -q are one orientation: the NEES must not change with the sign.
    """,
    wrong="""
    quaternions subtracted, pseudo-inverse: q - q_truth is no error of an orientation: q and -q are the same, and P has no inverse along q. A pseudo-inverse hides the second, not the first.
        C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, C = x - truth, np.linalg.pinv(P, rcond=1e-9)
        np.linalg.solve(C, e[..., None]) -> (C @ e[..., None])
    quaternions subtracted, a little added to P: q - q_truth is no error of an orientation: q and -q are the same, and P has no inverse along q. What is added to P decides what comes out.
        C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, C = x - truth, P + 1e-9 * np.eye(7)
    first six rows of P | C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> C = P[:, :6, :6] | A 6 x 6 corner of P is the covariance of six numbers of x, not of e: C = E_x P E_x'.
    scalar part left out: Three numbers of a quaternion are no rotation vector: half the angle, and other axes. Take e and C.
        C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, C = np.delete(x - truth, 3, 1), np.delete(np.delete(P, 3, 1), 3, 2)
    position only | C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, C = e[:, :3], P[:, :3, :3] | That is the NEES of the position, 3 degrees of freedom. The orientation belongs to it.
    correlations forgotten | np.swapaxes(E_x, -1, -2) -> np.swapaxes(E_x, -1, -2) * np.kron(np.eye(2), np.ones((3, 3))) | Position and orientation are correlated: use the whole C, not its two blocks.
    P forgotten | E_x @ P @ np -> E_x @ np | E_x E_x' is no covariance: P, what the filter says of its error, belongs between them.
    truth minus estimate: Take the estimate minus the truth: E_x is the derivative by x, and so the covariance is E_x P E_x'. The other way round it is the derivative by the truth.
        Frame3(x).minus(Frame3(truth)) -> Frame3(truth).minus(Frame3(x))
    inverse forgotten | np.linalg.solve(C, e[..., None]) -> (C @ e[..., None]) | Large where P is *small*: e' C^-1 e.
    root taken | .sum(-1) -> .sum(-1) ** 0.5 | NEES is the *squared* distance: no root.
    divided by six | .sum(-1) -> .sum(-1) / 6 | NEES is the sum e' C^-1 e, about 6 for a pose, its degrees of freedom: it is neither divided by them nor a mean.
    Euler angles | C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, C = _euler(x, P, truth) | Euler angles have a place (pitch 90 degrees) where they break down, and near it everything is wrong. The tangent space has none.
    covariance of a plain error | np.linalg.solve(C, e[..., None])[..., 0] -> e | The error is not scaled by its covariance: e' C^-1 e, not e' e.
    only the variances of C | np.swapaxes(E_x, -1, -2) -> np.swapaxes(E_x, -1, -2) * np.eye(6) | The six errors are correlated: use the whole C.
    one number for all | [..., 0]).sum(-1) -> [..., 0]).sum(-1).mean() + np.zeros(len(e)) | One NEES for each pose: no mean over them.
    the mean only | .sum(-1) -> .sum(-1).mean() | Return one NEES for each pose, shape (N,), and not their mean.
    orientation only | C = E_x @ P @ np.swapaxes(E_x, -1, -2) -> e, E_x = e[:, 3:], E_x[:, 3:]; C = E_x @ P @ np.swapaxes(E_x, -1, -2) | That is the NEES of the orientation alone: all six numbers of e count.
    derivative of the first pose | C = E_x -> E_x = E_x[:1]; C = E_x | Each pose has its own E_x: yours takes that of the first for all.
    rotation vector doubled | C = E_x @ P -> e = e * [1, 1, 1, 2, 2, 2]; C = E_x @ P | `minus` returns the rotation vector itself, with the whole angle: do not double it.
    one covariance for all | np.linalg.solve(C, e -> np.linalg.solve(C.mean(0), e | Each pose has its own covariance: the mean over all of them is that of none.
    information through E_x | np.linalg.solve(C, e[..., None])[..., 0] -> (E_x @ np.linalg.pinv(P, rcond=1e-9) @ np.swapaxes(E_x, -1, -2) @ e[..., None])[..., 0] | Covariances go through E_x, not their inverses: C = E_x P E_x' first, then its inverse.
    rotation vector halved | e, E_x = Frame3(x).minus(Frame3(truth)) -> e, E_x = Frame3(x).minus(Frame3(truth)); e = e * [1, 1, 1, 0.5, 0.5, 0.5] | e holds the rotation vector itself, the whole angle: it is not halved.
    """,
)


@tangent.link(
    "large errors",
    "The orientations are off by up to 2.5 rad here. The last three numbers of e are a rotation vector: its length is the whole angle, more than a chord or a sine. With that e goes C = E_x P E_x'.",
)
def _(f, rng):
    for angle in (1.0, 2.5):
        args = poses(rng, angle, 4, isotropic=True)
        got = expect.array(f(*args), 4, "the NEES")
        expect.close(got, pose_nees(*args), "the NEES", 1e-4, at=f"errors of up to {angle} rad")


def _euler(x, P, truth):
    """Errors in Euler angles, and their covariances."""
    J = np.zeros((len(x), 6, 7))
    J[:, :3, :3], J[:, 3:, 3:] = np.eye(3), [q2e(q)[1] for q in x[:, 3:]]
    turn = [wrap(q2e(q)[0] - q2e(p)[0]) for q, p in zip(x[:, 3:], truth[:, 3:], strict=True)]
    return np.hstack([x[:, :3] - truth[:, :3], turn]), J @ P @ np.swapaxes(J, -1, -2)
