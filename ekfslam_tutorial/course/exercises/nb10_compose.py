"""Exercise 10.2: a frame in a frame."""

import numpy as np

from ...geometry import Frame3, R2q, q2qc, q2R, q_prod, unit
from .. import expect
from ..exercise import Exercise


def compose(F, G):
    """Express frame G, which is given in frame F, in the parent of F.

    F, G, shape (7,): frames [t, q]; t is the position, q = [a, b, c, d] the unit quaternion, local to global.
    Return the composed frame [t, q], shape (7,).
    """
    R, _ = q2R(F[3:])
    t = F[:3] + R @ G[:3]
    q, _, _ = q_prod(F[3:], G[3:])
    return np.concatenate([t, q])


def _one_sign(x):
    """The frame with the one of q and -q whose largest entry is positive: both are the same rotation."""
    x = np.array(x, float)
    q = x[3:]
    return np.concatenate([x[:3], q * np.sign(q[np.argmax(np.abs(q))])])


exercise = Exercise(
    "10.2",
    "A frame in a frame",
    compose,
    canonical=_one_sign,
    hints=(
        "Where is the origin of G, seen from the parent? It is a point of F: take it out of F.",
        "t = R_F t_G + t_F. For the rotation: a vector of G is turned by G first, then by F.",
        "R, _ = q2R(F[3:]); t = R @ G[:3] + F[:3]; q, _, _ = q_prod(F[3:], G[3:]).",
    ),
)


def _frame(rng):
    return np.concatenate([rng.uniform(-3, 3, 3), unit(rng.normal(size=4))[0]])


def _out(result):
    return expect.array(result, 7, "the composed frame")


def _turns(x, want, at):
    """The orientation must turn vectors as wanted; both signs of q will do."""
    expect.close(np.linalg.norm(x[3:]), 1.0, "the norm of q", at=at)
    got, R = q2R(x[3:])[0], q2R(want)[0]
    expect.close(got, R, "the rotation matrix of the result", at=at)


@exercise.link("a frame comes out", "Return one array of 7 numbers, the position and the quaternion.")
def _(f, rng):
    _out(f(_frame(rng), _frame(rng)))


@exercise.link("no rotation", "Two steps without a turn: the positions add.")
def _(f, rng):
    F, G = _frame(rng), _frame(rng)
    F[3:] = G[3:] = [1, 0, 0, 0]
    expect.close(_out(f(F, G))[:3], F[:3] + G[:3], "t", at="two frames that are not turned")


@exercise.link("position", "The position of G is a point of F: turn it by R_F, then add the position of F.", part=None)
def _(f, rng):
    left = np.array([1.0, 2, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])  # turned a quarter to the left
    ahead = np.array([3.0, 0, 0, 1, 0, 0, 0])
    expect.close(_out(f(left, ahead))[:3], [1, 5, 0], "t", at="F at (1, 2, 0) looking along y, G 3 m ahead of it")
    for _ in range(4):
        F, G = _frame(rng), _frame(rng)
        expect.close(_out(f(F, G))[:3], q2R(F[3:])[0] @ G[:3] + F[:3], "t", at="any two frames")


@exercise.link("orientation", "Rotations do not commute: a vector of G is turned by G first, then by F.")
def _(f, rng):
    for _ in range(4):
        F, G = _frame(rng), _frame(rng)
        F0, G0 = np.concatenate([F[:3], [1, 0, 0, 0]]), np.concatenate([G[:3], [1, 0, 0, 0]])
        _turns(_out(f(F0, G)), G[3:], "F that is not turned")
        _turns(_out(f(F, G0)), F[3:], "G that is not turned")
        _turns(_out(f(F, G)), q_prod(F[3:], G[3:])[0], "any two frames")


@exercise.link("points", "Out of G, then out of F, must be the same as out of the composed frame.")
def _(f, rng):
    for _ in range(3):
        F, G, p = _frame(rng), _frame(rng), rng.normal(size=3)
        want = Frame3(F).from_frame(Frame3(G).from_frame(p)[0])[0]
        expect.close(Frame3(_out(f(F, G))).from_frame(p)[0], want, "a point of G in the parent of F")


@exercise.link("three frames", "(A B) C must be A (B C).")
def _(f, rng):
    A, B, C = (_frame(rng) for _ in range(3))
    left, right = _out(f(_out(f(A, B)), C)), _out(f(A, _out(f(B, C))))
    expect.close(_one_sign(left), _one_sign(right), "(A B) C")


def _package(F, G):
    return Frame3(F).compose(Frame3(G))[0].x


@exercise.wrong("frames swapped", "You put F into G: first out of G, then out of F, so F stands on the left.")
def _(F, G):
    return _package(G, F)


@exercise.wrong("quaternions swapped", "The positions are right, but the product is the wrong way round: q_F q_G.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], q_prod(G[3:], F[3:])[0]])


@exercise.wrong("positions added", "t_G is given in the axes of F: turn it with R_F before you add it.")
def _(F, G):
    return np.concatenate([F[:3] + G[:3], q_prod(F[3:], G[3:])[0]])


@exercise.wrong("everything added", "Frames cannot be added: turn t_G with R_F, and multiply the quaternions.")
def _(F, G):
    return np.asarray(F) + np.asarray(G)


@exercise.wrong("position turned back", "You go out of F: R_F, not its transpose.")
def _(F, G):
    return np.concatenate([F[:3] + q2R(F[3:])[0].T @ G[:3], q_prod(F[3:], G[3:])[0]])


@exercise.wrong("turned by G", "The position of G is a point of F: it is turned by F, not by G.")
def _(F, G):
    return np.concatenate([F[:3] + q2R(G[3:])[0] @ G[:3], q_prod(F[3:], G[3:])[0]])


@exercise.wrong("the wrong position is turned", "t_F is in the parent already. It is t_G that must be turned, by R_F.")
def _(F, G):
    return np.concatenate([q2R(F[3:])[0] @ F[:3] + G[:3], q_prod(F[3:], G[3:])[0]])


@exercise.wrong("product entry by entry", "The product of two quaternions is q_prod, not `*`.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], np.multiply(F[3:], G[3:])])


@exercise.wrong("quaternions added", "Two rotations one after the other: multiply the quaternions, q_prod.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], np.add(F[3:], G[3:])])


@exercise.wrong("added and normalised", "A sum of quaternions is some rotation between the two. Multiply: q_prod.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], unit(np.add(F[3:], G[3:]))[0]])


@exercise.wrong("a conjugate too many", "With the conjugate of q_G you turn back. Local to global: q_F q_G.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], q_prod(F[3:], q2qc(G[3:])[0])[0]])


@exercise.wrong("scalar part last", "q = [a, b, c, d]: the scalar part comes first, in the result, too.")
def _(F, G):
    return np.concatenate([_package(F, G)[:3], np.roll(_package(F, G)[3:], -1)])


@exercise.variant("with rotation matrices, as a list")
def _(F, G):
    R_F, R_G = q2R(F[3:])[0], q2R(G[3:])[0]
    return [*(R_F @ G[:3] + F[:3]), *R2q(R_F @ R_G)[0]]


@exercise.variant("with two quaternion products, and the other sign")
def _(F, G):
    q = F[3:]
    t = q_prod(q_prod(q, [0, *G[:3]])[0], q2qc(q)[0])[0][1:] + F[:3]
    return np.hstack([t, -q_prod(q, G[3:])[0]])


@exercise.variant("the package's frames")
def _(F, G):
    return Frame3(F).compose(Frame3(G))[0].x
