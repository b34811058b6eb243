"""Exercise 17.1: NEES of poses in space, in the tangent space."""

import numpy as np

from ...geometry import Frame3, q2e, q2qc, q2v, q_prod, v2q, wrap
from .. import expect
from ..exercise import Exercise
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


tangent = Exercise(
    "17.1",
    "NEES of a pose in space",
    pose_nees,
    hints=(
        "NEES = e' C^-1 e, where C is the covariance of *that* e. Six numbers e need a 6 x 6 covariance.",
        "e is a function of x with the derivative E_x: its covariance is C = E_x P E_x'.",
        "C = E_x @ P @ np.swapaxes(E_x, -1, -2); np.linalg.solve(C, e[..., None])[..., 0] is C^-1 e for all N at once.",
    ),
)


def directions(q):
    """How a quaternion moves with a small turn in the frame's own axes: dq/dv, shape (4, 3)."""
    a, b, c, d = q
    return 0.5 * np.array([[-b, -c, -d], [a, -d, c], [d, a, -b], [-c, b, a]])


def poses(rng, angle, N=4, isotropic=False, position=True):
    """Estimates, covariances of rank 6 and true poses: turned by about `angle` (rad) from each other."""
    xs, Ps, truths = [], [], []
    for _ in range(N):
        truth = np.concatenate([rng.uniform(-3, 3, 3), rng.normal(size=4)])
        truth[3:] /= np.linalg.norm(truth[3:])
        v = rng.normal(size=3)
        v *= angle * rng.uniform(0.5, 1) / np.linalg.norm(v)
        q = q_prod(truth[3:], v2q(v)[0])[0]
        C = random_covariance(rng, 6, 0.05)
        C[3:] *= 0.02  # units differ: the angles are small
        C[:, 3:] *= 0.02
        if isotropic:
            C[3:], C[:, 3:] = 0, 0
            C[3:, 3:] = np.eye(3) * rng.uniform(0.2, 1) ** 2
        T = np.zeros((7, 6))
        T[:3, :3], T[3:, 3:] = np.eye(3), directions(q)
        xs.append(np.concatenate([truth[:3] + position * rng.normal(0, 0.3, 3), q]))
        Ps.append(T @ C @ T.T)
        truths.append(truth)
    return np.array(xs), np.array(Ps), np.array(truths)


def other_sign(x, P):
    """The same poses and covariances with the quaternion -q."""
    S = np.diag([1.0, 1, 1, -1, -1, -1, -1])
    return x @ S, S @ P @ S


def _nees(result, N):
    return expect.array(result, N, "the NEES")


@tangent.link("one for each", "Return N numbers: one NEES for each pose.")
def _(f, rng):
    for N in (4, 1):
        _nees(f(*poses(rng, 0.01, N)), N)


@tangent.link(
    "position",
    "Where the orientation is right, e is [t - t_truth, 0]; its covariance is still the whole C = E_x P E_x'.",
)
def _(f, rng):
    args = poses(rng, 1e-9)
    expect.close(_nees(f(*args), 4), pose_nees(*args), "the NEES", 3e-4, at="a right orientation")


@tangent.link("small errors", "NEES = e' C^-1 e with the covariance of e, C = E_x P E_x'.")
def _(f, rng):
    for angle, N in ((0.01, 4), (0.02, 7), (0.01, 1)):
        args = poses(rng, angle, N)
        expect.close(_nees(f(*args), N), pose_nees(*args), "the NEES", 3e-4)


@tangent.link("q and -q", "q and -q are one orientation: the NEES must not change with the sign.")
def _(f, rng):
    x, P, truth = poses(rng, 0.02)
    want = pose_nees(x, P, truth)
    expect.close(_nees(f(*other_sign(x, P), truth), 4), want, "the NEES", 3e-4, at="estimates with the other sign of q")
    flipped, _ = other_sign(truth, P)
    expect.close(_nees(f(x, P, flipped), 4), want, "the NEES", 3e-4, at="truths with the other sign of q")


@tangent.link(
    "large errors", "A rotation has a length of its own: the angle. The difference of two quaternions is a chord."
)
def _(f, rng):
    for angle in (1.0, 2.5):
        args = poses(rng, angle, 4, isotropic=True)
        expect.close(_nees(f(*args), 4), pose_nees(*args), "the NEES", 1e-4, at=f"errors of up to {angle} rad")


def _each(x, P, truth, one):
    """one(x, P, truth, e, E) for each pose."""
    e, E = Frame3(x).minus(Frame3(truth))
    with np.errstate(all="ignore"):
        return np.array([one(x[i], P[i], truth[i], e[i], E[i]) for i in range(len(x))])


def _wrong(name, hint, one):
    """A misconception: one(x, P, truth, e, E) for a single pose."""

    @tangent.wrong(name, hint)
    def _(x, P, truth):
        return _each(x, P, truth, one)


def _form(e, C):
    return e @ np.linalg.solve(C, e)


REST = [0, 1, 2, 4, 5, 6]  # all but the scalar part of q
SUBTRACTED = "q - q_truth is no error of an orientation: q and -q are the same, and P has no inverse along q. "


def _euler(x, P, truth):
    a, A_q = q2e(x[3:])
    b, _ = q2e(truth[3:])
    J = np.zeros((6, 7))
    J[:3, :3], J[3:, 3:] = np.eye(3), A_q
    return np.concatenate([x[:3] - truth[:3], wrap(a - b)]), J @ P @ J.T


# fmt: off
_wrong("quaternions subtracted, pseudo-inverse", SUBTRACTED + "The pseudo-inverse hides the second, not the first.",
       lambda x, P, t, e, E: (x - t) @ np.linalg.pinv(P, rcond=1e-9) @ (x - t))
_wrong("quaternions subtracted, a little added to P", SUBTRACTED + "What you add to P decides what comes out.",
       lambda x, P, t, e, E: _form(x - t, P + 1e-9 * np.eye(7)))
_wrong("first six rows of P", "A 6 x 6 corner of P is the covariance of six numbers of x, not of e: C = E_x P E_x'.",
       lambda x, P, t, e, E: _form(e, P[:6, :6]))
_wrong("scalar part left out", "Three numbers of a quaternion are no rotation vector: half the angle, and other "
       "axes. Take e and C.", lambda x, P, t, e, E: _form((x - t)[REST], P[np.ix_(REST, REST)]))
_wrong("position only", "That is the NEES of the position, 3 degrees of freedom. The orientation belongs to it.",
       lambda x, P, t, e, E: _form(e[:3], P[:3, :3]))
_wrong("correlations forgotten", "Position and orientation hang together: use the whole C, not its two blocks.",
       lambda x, P, t, e, E: _form(e[:3], (E @ P @ E.T)[:3, :3]) + _form(e[3:], (E @ P @ E.T)[3:, 3:]))
_wrong("P forgotten", "E_x E_x' is no covariance: P, what the filter says of its error, belongs between them.",
       lambda x, P, t, e, E: _form(e, E @ E.T))
_wrong("inverse forgotten", "Large where P is *small*: e' C^-1 e.", lambda x, P, t, e, E: e @ (E @ P @ E.T) @ e)
_wrong("root taken", "NEES is the *squared* distance: no root.", lambda x, P, t, e, E: np.sqrt(_form(e, E @ P @ E.T)))
_wrong("divided by six", "NEES of a pose is about 6, its degrees of freedom: do not divide by them.",
       lambda x, P, t, e, E: _form(e, E @ P @ E.T) / 6)
_wrong("Euler angles", "Euler angles have a place (pitch 90 degrees) where they break down, and near it everything is "
       "wrong. The tangent space has none.", lambda x, P, t, e, E: _form(*_euler(x, P, t)))
_wrong("covariance of a plain error", "The error is not scaled by its covariance: e' C^-1 e, not e' e.",
       lambda x, P, t, e, E: e @ e)
# fmt: on


@tangent.variant("pose by pose, with the inverse")
def _(x, P, truth):
    out = []
    for a, B, c in zip(x, P, truth, strict=True):
        e, E = Frame3(a).minus(Frame3(c))
        out.append(float(e @ np.linalg.inv(E @ B @ E.T) @ e))
    return out


@tangent.variant("in the axes of the world")
def _(x, P, truth):
    e, E_x = Frame3(x).minus(Frame3(truth))
    W = np.zeros((len(x), 6, 6))
    W[:, :3, :3], W[:, 3:, 3:] = np.eye(3), Frame3(truth).R
    e, E_x = (W @ e[..., None])[..., 0], W @ E_x
    L = np.linalg.cholesky(E_x @ P @ E_x.transpose(0, 2, 1))
    return (np.linalg.solve(L, e[..., None]) ** 2).sum((-1, -2))


@tangent.variant("without the toolbox")
def _(x, P, truth):
    out = []
    for a, B, c in zip(x, P, truth, strict=True):
        dq = q_prod(q2qc(c[3:])[0], a[3:])[0]
        v = q2v(dq if dq[0] > 0 else -dq)[0]
        E = np.zeros((6, 7))
        E[:3, :3], E[3:, 3:] = np.eye(3), 4 * directions(a[3:]).T
        e = np.concatenate([a[:3] - c[:3], v])
        out.append(e @ np.linalg.solve(E @ B @ E.T, e))
    return np.array(out)
