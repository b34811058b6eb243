"""Exercise 10.3: a quaternion is normalised, and its covariance with it."""

import numpy as np

from ...geometry import Frame3, unit
from .. import expect
from ..exercise import Exercise


def normalize(x, P):
    """Give the quaternion of a frame the norm one again, after a correction.

    x, shape (7,): the frame [t, q]; q has lost its norm. P, shape (7, 7): its covariance.
    Return the new x, with the quaternion u = q / |q|, and the new P. With U_q = du/dq = (I - u u') / |q|.
    """
    n = np.linalg.norm(x[3:])
    u = x[3:] / n
    J = np.eye(7)
    J[3:, 3:] = (np.eye(4) - np.outer(u, u)) / n
    return np.concatenate([x[:3], u]), J @ P @ J.T


exercise = Exercise(
    "10.3",
    "Normalise, with the covariance",
    normalize,
    hints=(
        "The new state is a function of the old one, so the covariance goes through its Jacobian: J P J'.",
        "J is 7 x 7: the identity for the position, U_q for the quaternion. P_tq changes, too.",
        "J = np.eye(7); J[3:, 3:] = (np.eye(4) - np.outer(u, u)) / n; return the new x and J @ P @ J.T.",
    ),
)


def _case(rng, norm=None):
    """A frame whose quaternion is a bit too long or too short, and a full covariance."""
    q = unit(rng.normal(size=4))[0] * (rng.uniform(0.8, 1.3) if norm is None else norm)
    A = rng.normal(size=(7, 7)) * np.array([0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0.1])[:, None]
    return np.concatenate([rng.uniform(-3, 3, 3), q]), A @ A.T


def _out(result):
    x, P = expect.results(result, "x", "P")
    return expect.array(x, 7, "x"), expect.array(P, (7, 7), "P")


@exercise.link("two results", "The function must end with `return x, P`.")
def _(f, rng):
    _out(f(*_case(rng)))


@exercise.link("state", "u = q / |q|, and the position stays.", part=0)
def _(f, rng):
    for norm in (1.2, 0.7, 1.0, 3.0):
        x, P = _case(rng, norm)
        got = _out(f(x, P))[0]
        expect.close(got[:3], x[:3], "the position")
        expect.close(got[3:], x[3:] / norm, "the quaternion", at=f"|q| = {norm}")


@exercise.link("covariance of the position", "P_tt has nothing to do with the quaternion: it stays.", part=1)
def _(f, rng):
    x, P = _case(rng)
    expect.close(_out(f(x, P))[1][:3, :3], P[:3, :3], "P_tt")


@exercise.link("covariance of the quaternion", "The noise of q passes through U_q: P_qq = U_q P_qq U_q'.", part=1)
def _(f, rng):
    for norm in (1.0, 1.25, 0.6):
        x, P = _case(rng, norm)
        Q = _out(f(x, P))[1][3:, 3:]
        U = unit(x[3:])[1]
        expect.close(Q, U @ P[3:, 3:] @ U.T, "P_qq", at=f"|q| = {norm}")
        u = x[3:] / norm
        expect.close(u @ Q @ u, 0, "the variance along q, u' P_qq u", atol=1e-9, at="a quaternion of norm one")


@exercise.link("cross-covariance", "P_tq shares its columns with q: it is multiplied once, P_tq U_q'.", part=1)
def _(f, rng):
    for _ in range(3):
        x, P = _case(rng)
        new, U = _out(f(x, P))[1], unit(x[3:])[1]
        expect.close(new[:3, 3:], P[:3, 3:] @ U.T, "P_tq, the block between position and quaternion,")
        expect.close(new[3:, :3], U @ P[3:, :3], "P_qt, the block between quaternion and position,")


@exercise.link("still a covariance", "J P J' is symmetric and has no negative eigenvalue.", part=1)
def _(f, rng):
    for _ in range(3):
        _, P = _out(f(*_case(rng)))
        expect.symmetric(P, "P")
        expect.psd(P, "P")


def _J(x):
    return Frame3(x).normalized()[1]


def _x(x):
    return Frame3(x).normalized()[0].x


@exercise.wrong("covariance forgotten", "q has changed, so has its noise: P goes through the Jacobian of q / |q|.")
def _(x, P):
    return _x(x), np.array(P)


@exercise.wrong("q only made shorter", "Your U_q is I / |q|. The norm depends on q, too: U_q = (I - u u') / |q|.")
def _(x, P):
    J = np.eye(7)
    J[3:, 3:] /= np.linalg.norm(x[3:])
    return _x(x), J @ P @ J.T


@exercise.wrong(
    "cross-covariance forgotten", "You have changed P_qq only. P_tq is about q, too: use one J for all of P."
)
def _(x, P):
    new = np.array(P)
    U = unit(x[3:])[1]
    new[3:, 3:] = U @ new[3:, 3:] @ U.T
    return _x(x), new


@exercise.wrong("cross-covariance set to zero", "Position and quaternion stay correlated: P_tq becomes P_tq U_q'.")
def _(x, P):
    new, U = np.zeros((7, 7)), unit(x[3:])[1]
    new[:3, :3], new[3:, 3:] = P[:3, :3], U @ P[3:, 3:] @ U.T
    return _x(x), new


@exercise.wrong("the whole state is divided", "Only the quaternion has the norm one. The position is in metres.")
def _(x, P):
    n = np.linalg.norm(x[3:])
    J = np.eye(7) / n
    J[3:, 3:] = unit(x[3:])[1]
    return np.asarray(x) / n, J @ P @ J.T


@exercise.wrong("norm of the whole state", "Take the norm of the quaternion, x[3:], alone.")
def _(x, P):
    u, J = unit(np.asarray(x, float))
    return u, J @ P @ J.T


@exercise.wrong("projector, not divided", "U_q = (I - u u') / |q|: yours lacks the division by |q|.")
def _(x, P):
    J = np.eye(7)
    J[3:, 3:] = np.linalg.norm(x[3:]) * unit(x[3:])[1]
    return _x(x), J @ P @ J.T


@exercise.wrong("q q' of the long q", "The projector needs the unit vector: I - u u', with u = q / |q|, not q q'.")
def _(x, P):
    q, J = np.asarray(x[3:]), np.eye(7)
    J[3:, 3:] = (np.eye(4) - np.outer(q, q)) / np.linalg.norm(q)
    return _x(x), J @ P @ J.T


@exercise.wrong("plus", "U_q = (I - u u') / |q|, with a minus: the part of the noise along q is taken away.")
def _(x, P):
    u, J = unit(np.asarray(x[3:], float))[0], np.eye(7)
    J[3:, 3:] = (np.eye(4) + np.outer(u, u)) / np.linalg.norm(x[3:])
    return _x(x), J @ P @ J.T


@exercise.wrong("J applied once", "A covariance is multiplied from both sides: J P J'.")
def _(x, P):
    return _x(x), _J(x) @ P


@exercise.wrong("divided by the squared norm", "q / (q'q) is too short: divide by the square root, |q|.")
def _(x, P):
    q = np.asarray(x[3:], float)
    return np.concatenate([x[:3], q / (q @ q)]), _J(x) @ P @ _J(x).T


@exercise.variant("the package's frame")
def _(x, P):
    N, N_f = Frame3(x).normalized()
    return N.x, N_f @ P @ N_f.T


@exercise.variant("block by block, as lists")
def _(x, P):
    u, U = unit(x[3:])
    new = np.block([[P[:3, :3], P[:3, 3:] @ U.T], [U @ P[3:, :3], U @ P[3:, 3:] @ U.T]])
    return [*x[:3], *u], new.tolist()


@exercise.variant("finite differences")
def _(x, P):
    from ...geometry import numerical_jacobian

    J = numerical_jacobian(lambda x: np.concatenate([x[:3], x[3:] / np.sqrt(x[3:] @ x[3:])]), x)
    J[:3, :3], J[:3, 3:], J[3:, :3] = np.eye(3), 0, 0
    return np.concatenate([x[:3], x[3:] / np.sqrt(x[3:] @ x[3:])]), J @ P @ J.T
