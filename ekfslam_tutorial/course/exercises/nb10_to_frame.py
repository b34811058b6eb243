"""Exercise 10.1: a point, seen from a frame."""

import numpy as np

from ...geometry import Frame3, e2q
from ..table import table


def to_frame(t, R, p):
    """Express a point of the parent in a frame.

    t, shape (3,): where the frame stands in the parent. R, shape (3, 3): its rotation matrix, local to global.
    p, shape (3,): a point, in coordinates of the parent.
    Return pf, shape (3,): the same point in coordinates of the frame; PF_t and PF_p, both of shape (3, 3): its
    derivatives by t and by p.
    """
    pf = R.T @ (p - t)
    PF_t, PF_p = -R.T, R.T
    return pf, PF_t, PF_p


def case(rng):
    """Return position and rotation of a frame, and a point."""
    F = Frame3(np.concatenate([rng.uniform(-3, 3, 3), e2q(rng.uniform([-3, -1.4, -3], [3, 1.4, 3]))[0]]))
    return np.array(F.t), np.array(F.R), rng.uniform(-5, 5, 3)


def not_turned(t, R, p):
    """Return the same with a frame that is not turned."""
    return t, np.eye(3), p


def at_origin(t, R, p):
    """Return the same with a frame that stands at the origin."""
    return 0 * t, R, p


def at_the_point(t, R, p):
    """Return the same with the point at the origin of the frame."""
    return t, R, t.copy()


QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # a frame that looks along y

exercise = table(
    "10.1 To a frame",
    to_frame,
    hints=(
        "from_frame is p = R pf + t. You want pf. Solve that equation.",
        "First take t away, then turn back. The inverse of a rotation matrix is its transpose.",
        "pf = R' (p - t). It is linear in p and in t: the two derivatives are what stands before p and before t.",
    ),
    returns="pf, PF_t, PF_p",
    jacobians={"PF_t": "pf", "PF_p": "pf"},
    cases={
        "any": lambda rng: [case(rng) for _ in range(4)],
        "not turned": lambda rng: [not_turned(*case(rng)) for _ in range(3)],
        "at the origin": lambda rng: [
            (np.zeros(3), QUARTER, np.array([0.0, 2.0, 1.0])),
            *(at_origin(*case(rng)) for _ in range(3)),
        ],
        "p = t": lambda rng: [at_the_point(*case(rng)) for _ in range(3)],
    },
    checks="""
    a frame that is not turned | pf         | not turned    | A frame that is not turned, R = I, sees the point at p - t.
    a frame at the origin      | pf         | at the origin | R turns from the frame to the parent, R' from the parent to the frame.
    the origin of the frame    | pf         | p = t         | The origin of the frame, p = t, must become zero; R pf + t must be p again.
    any frame                  | pf         | any           | The origin of the frame, p = t, must become zero; R pf + t must be p again.
    derivative by t            | d PF_t / t | any           | Move the frame a little: how does the point move, seen from the frame?
    derivative by p            | d PF_p / p | any           | pf is linear in p: what stands before it?
    """,
    wrong="""
    from_frame | R.T @ (p - t) -> R @ p + t | R p + t takes a point *out of* the frame. Solve p = R pf + t for pf.
        -R.T, R.T -> np.eye(3), R
    R not transposed | R.T @ (p - t) -> R @ (p - t) | R turns from the frame to the parent. Back is its transpose: R' (p - t).
        -R.T, R.T -> -R, R
    t taken away last | R.T @ (p - t) -> R.T @ p - t | t is given in the parent: take it away *before* you turn. R' (p - t).
        -R.T, R.T -> -np.eye(3), R.T
    plus t | p - t -> p + t | The frame stands at t: seen from there, p is at p - t.
        -R.T, R.T -> R.T, R.T
    t - p | p - t -> t - p | The vector from the frame to the point is p - t.
        -R.T, R.T -> R.T, -R.T
    not turned | R.T @ (p - t) -> p - t | p - t is still in the axes of the parent: turn it into those of the frame with R'.
        -R.T, R.T -> -np.eye(3), np.eye(3)
    PF_t without rotation | -R.T, R.T -> -np.eye(3), R.T | t passes through R' as p does: PF_t = -R'.
    PF_t with the sign of PF_p | -R.T, R.T -> R.T, R.T | When the frame goes forward, the point comes nearer: PF_t has a minus.
    derivatives with R | -R.T, R.T -> -R, R | pf = R' (p - t): its derivatives have R', too.
    derivatives swapped | -R.T, R.T -> R.T, -R.T | Return the derivative by t first, then the one by p.
    PF_p with a minus | -R.T, R.T -> -R.T, -R.T | When the point goes forward, it does so in the frame, too: PF_p = R', with a plus.
    PF_p without rotation | -R.T, R.T -> -R.T, np.eye(3) | p passes through R': PF_p = R'.
    t turned by R | pf = R.T @ (p - t) -> pf = R.T @ p - R @ t | R' takes both p and t into the frame: R' p - R' t. R takes them out of it.
    PF_p not transposed | -R.T, R.T -> -R.T, R | p passes through R', the transpose: PF_p = R'.
    PF_t not transposed | -R.T, R.T -> -R, R.T | t passes through R', the transpose: PF_t = -R'.
    PF_t forgotten | -R.T, R.T -> np.zeros((3, 3)), R.T | When the frame moves, the point moves in it: PF_t = -R', not zero.
    t - p in the point alone | pf = R.T @ (p - t) -> pf = R.T @ (t - p) | The vector from the frame to the point is p - t.
    """,
)
