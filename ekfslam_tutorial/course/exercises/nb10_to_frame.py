"""Exercise 10.1: a point, seen from a frame."""

import numpy as np

from ...geometry import Frame3, e2q
from .. import expect
from ..exercise import Exercise


def to_frame(t, R, p):
    """Express a point of the parent in a frame.

    t, shape (3,): where the frame stands in the parent. R, shape (3, 3): its rotation matrix, local to global.
    p, shape (3,): a point, in coordinates of the parent.
    Return pf, shape (3,): the same point in coordinates of the frame; PF_t and PF_p, both of shape (3, 3): its
    derivatives by t and by p.
    """
    return R.T @ (p - t), -R.T, R.T


exercise = Exercise(
    "10.1",
    "To a frame",
    to_frame,
    hints=(
        "from_frame is p = R pf + t. You want pf. Solve that equation.",
        "First take t away, then turn back. The inverse of a rotation matrix is its transpose.",
        "pf = R' (p - t). It is linear in p and in t: the two derivatives are what stands before p and before t.",
    ),
)


def _frame(rng):
    F = Frame3(np.concatenate([rng.uniform(-3, 3, 3), e2q(rng.uniform([-3, -1.4, -3], [3, 1.4, 3]))[0]]))
    return np.array(F.t), np.array(F.R)


def _out(result):
    return expect.results(result, "pf", "PF_t", "PF_p")


def _pf(result):
    return expect.array(_out(result)[0], 3, "pf")


@exercise.link("three results", "The function must end with `return pf, PF_t, PF_p`.")
def _(f, rng):
    t, R = _frame(rng)
    _, PF_t, PF_p = _out(f(t, R, rng.normal(size=3)))
    expect.true(PF_t is not None, "PF_t is None: return the derivative by t as the second result")
    expect.true(PF_p is not None, "PF_p is None: return the derivative by p as the third result")


@exercise.link("a frame that is not turned", "Seen from the frame, the point is p - t away.", part=0)
def _(f, rng):
    for _ in range(3):
        t, p = rng.normal(size=(2, 3))
        expect.close(_pf(f(t, np.eye(3), p)), p - t, "pf", at="R = I")


@exercise.link("a frame at the origin", "R turns from the frame to the parent. You go the other way.", part=0)
def _(f, rng):
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    ahead = np.array([0.0, 2.0, 0.0])
    expect.close(_pf(f(np.zeros(3), quarter, ahead)), [2, 0, 0], "pf", at="a frame that looks along y, and a p on y")
    for _ in range(3):
        _, R = _frame(rng)
        v = rng.normal(size=3)
        expect.close(_pf(f(np.zeros(3), R, R @ v)), v, "pf", at="t = 0 and p = R v")


@exercise.link("any frame", "The origin of the frame, p = t, must become zero; R pf + t must be p again.", part=0)
def _(f, rng):
    for _ in range(4):
        t, R = _frame(rng)
        expect.close(_pf(f(t, R, t.copy())), np.zeros(3), "pf", atol=1e-7, at="p = t")
        p = rng.uniform(-5, 5, 3)
        expect.close(R @ _pf(f(t, R, p)) + t, p, "R pf + t", at="any p (it should be p)")


def _derivative(f, rng, part, name):
    for _ in range(3):
        t, R = _frame(rng)
        p = rng.uniform(-5, 5, 3)
        J = expect.array(_out(f(t, R, p))[part], (3, 3), name)
        value = (lambda x, R=R, p=p: R.T @ (p - x)) if part == 1 else (lambda x, R=R, t=t: R.T @ (x - t))
        expect.jacobian(J, value, t if part == 1 else p, name)


@exercise.link("derivative by t", "Move the frame a little: how does the point move, seen from the frame?", part=1)
def _(f, rng):
    _derivative(f, rng, 1, "PF_t")


@exercise.link("derivative by p", "pf is linear in p: what stands before it?", part=2)
def _(f, rng):
    _derivative(f, rng, 2, "PF_p")


@exercise.wrong("from_frame", "R p + t takes a point *out of* the frame. Solve p = R pf + t for pf.")
def _(t, R, p):
    return R @ p + t, np.eye(3), R


@exercise.wrong("R not transposed", "R turns from the frame to the parent. Back is its transpose: R' (p - t).")
def _(t, R, p):
    return R @ (p - t), -R, R


@exercise.wrong("t taken away last", "t is given in the parent: take it away *before* you turn. R' (p - t).")
def _(t, R, p):
    return R.T @ p - t, -np.eye(3), R.T


@exercise.wrong("plus t", "The frame stands at t: seen from there, p is at p - t.")
def _(t, R, p):
    return R.T @ (p + t), R.T, R.T


@exercise.wrong("t - p", "The vector from the frame to the point is p - t.")
def _(t, R, p):
    return R.T @ (t - p), R.T, -R.T


@exercise.wrong("not turned", "p - t is still in the axes of the parent: turn it into those of the frame with R'.")
def _(t, R, p):
    return p - t, -np.eye(3), np.eye(3)


@exercise.wrong("PF_t without rotation", "t passes through R' as p does: PF_t = -R'.")
def _(t, R, p):
    return R.T @ (p - t), -np.eye(3), R.T


@exercise.wrong("PF_t with the sign of PF_p", "When the frame goes forward, the point comes nearer: PF_t has a minus.")
def _(t, R, p):
    return R.T @ (p - t), R.T, R.T


@exercise.wrong("derivatives with R", "Your pf has R', so have its derivatives.")
def _(t, R, p):
    return R.T @ (p - t), -R, R


@exercise.wrong("derivatives swapped", "Return the derivative by t first, then the one by p.")
def _(t, R, p):
    return R.T @ (p - t), R.T, -R.T


@exercise.variant("solve, and lists")
def _(t, R, p):
    R = np.asarray(R)
    back = np.linalg.inv(R)
    return np.linalg.solve(R, np.subtract(p, t)).tolist(), (-back).tolist(), back.tolist()


@exercise.variant("row vectors")
def _(t, R, p):
    PF_p = R.T.copy()
    return (p - t) @ R, -1 * PF_p, PF_p


@exercise.variant("the package's frame")
def _(t, R, p):
    from ...geometry import R2q

    pf, PF_f, PF_p = Frame3(np.concatenate([t, R2q(R)[0]])).to_frame(p)
    return pf, PF_f[:, :3], PF_p
