"""Exercise 06.3: how well is one landmark known against another one?"""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def relative_covariance(P, a, b):
    """Covariance of the difference of two landmarks, d = l_b - l_a.

    P, shape (n, n): covariance of the joint state.
    a, b: the ranges of the two landmarks, slices of length 2.
    Return D, shape (2, 2), in m^2.
    """
    return P[a, a] + P[b, b] - P[a, b] - P[b, a]


relative = Exercise(
    "06.3",
    "One landmark against another one",
    relative_covariance,
    hints=(
        "Write the error of the difference: dd = dl_b - dl_a. Its covariance is the mean of dd dd'. Multiply out.",
        "E[dl_b dl_b'] is the block P[b, b]; E[dl_b dl_a'] is P[b, a]. There are four products: which have a minus?",
        "(dl_b - dl_a)(dl_b - dl_a)' = P[b, b] - P[b, a] - P[a, b] + P[a, a].",
    ),
)
A, B = slice(3, 5), slice(7, 9)
PAIRS = (
    (9, A, B),
    (9, B, A),
    (7, slice(5, 7), slice(3, 5)),
    (13, slice(9, 11), slice(3, 5)),
    (4, slice(0, 2), slice(2, 4)),
)


def _out(result):
    return expect.array(result, (2, 2), "D")


@relative.link("shape", "D belongs to the two numbers of the difference.")
def _(f, rng):
    for n, a, b in PAIRS:
        _out(f(random_covariance(rng, n), a, b))


@relative.link("independent landmarks", "Without a common error the two covariances add up.")
def _(f, rng):
    P = random_covariance(rng, 9)
    P[A, B], P[B, A] = 0, 0
    expect.close(_out(f(P, A, B)), P[A, A] + P[B, B], "D of two landmarks without a common error")


@relative.link("a common error cancels", "If both landmarks are shifted by the same error, their difference is exact.")
def _(f, rng):
    S = random_covariance(rng, 2)
    P = np.kron(np.ones((4, 4)), S)
    D = _out(f(P, slice(2, 4), slice(6, 8)))
    expect.close(D, np.zeros((2, 2)), "D of two landmarks with the same error", atol=1e-9)


@relative.link("the general case", "Multiply out (dl_b - dl_a)(dl_b - dl_a)': four blocks.")
def _(f, rng):
    for n, a, b in PAIRS:
        for scale in (1.0, 1e-4):
            P = random_covariance(rng, n, scale)
            J = np.zeros((2, n))
            J[:, a], J[:, b] = -np.eye(2), np.eye(2)
            expect.close(_out(f(P, a, b)), J @ P @ J.T, "D", 1e-4)


@relative.link("a covariance", "D must be symmetric and without negative eigenvalues.")
def _(f, rng):
    for n, a, b in PAIRS:
        D = _out(f(random_covariance(rng, n), a, b))
        expect.symmetric(D, "D", 1e-6)
        expect.psd(D, "D")


def _wrong(name, hint, answer):
    relative.wrong(name, hint)(answer)


# fmt: off
_wrong("cross-covariances forgotten", "That is right only if the two errors have nothing in common. They share the "
       "error of the robot: subtract P[a, b] and P[b, a].", lambda P, a, b: P[a, a] + P[b, b])
_wrong("covariances subtracted", "Errors are subtracted, covariances are not: (dl_b - dl_a)(dl_b - dl_a)' has "
       "+ P[a, a].",
       lambda P, a, b: P[b, b] - P[a, a])
_wrong("covariance of the sum", "That is the covariance of the sum l_a + l_b. For the difference the cross terms get a "
       "minus.", lambda P, a, b: P[a, a] + P[b, b] + P[a, b] + P[b, a])
_wrong("the same cross block twice", "P[a, b] and P[b, a] are transposes of each other, not the same: subtract one "
       "of each.", lambda P, a, b: P[a, a] + P[b, b] - 2 * P[a, b])
_wrong("the same cross block twice (b, a)", "P[a, b] and P[b, a] are transposes of each other, not the same: subtract "
       "one of each.", lambda P, a, b: P[a, a] + P[b, b] - 2 * P[b, a])
_wrong("one cross block", "There are two cross terms, P[a, b] and P[b, a]: subtract both.",
       lambda P, a, b: P[a, a] + P[b, b] - P[a, b])
_wrong("one cross block (b, a)", "There are two cross terms, P[a, b] and P[b, a]: subtract both.",
       lambda P, a, b: P[a, a] + P[b, b] - P[b, a])
_wrong("half of the cross terms", "There are two cross terms, P[a, b] and P[b, a]: subtract both in full.",
       lambda P, a, b: P[a, a] + P[b, b] - (P[a, b] + P[b, a]) / 2)
_wrong("the cross block alone", "P[a, b] tells what the two errors have in common, not what their difference is.",
       lambda P, a, b: 1 * P[a, b])
_wrong("the mean of the two", "A mean of the two covariances forgets what the errors have in common.",
       lambda P, a, b: (P[a, a] + P[b, b]) / 2)
_wrong("conditional covariance", "That is the covariance of l_b if l_a were known exactly: another question.",
       lambda P, a, b: P[b, b] - P[b, a] @ np.linalg.pinv(P[a, a]) @ P[a, b])
_wrong("diagonal only", "x and y of the difference are correlated, too: keep the whole 2 x 2 blocks.",
       lambda P, a, b: np.diag(np.diag(P[a, a] + P[b, b] - P[a, b] - P[b, a])))
_wrong("standard deviations", "The entries of D are variances: take no roots.",
       lambda P, a, b: np.sqrt(np.abs(P[a, a] + P[b, b] - P[a, b] - P[b, a])))
# fmt: on


@relative.variant("with the Jacobian of the difference")
def _(P, a, b):
    J = np.zeros((2, len(P)))
    J[:, a], J[:, b] = -np.eye(2), np.eye(2)
    return J @ P @ J.T


@relative.variant("the other way round, lists")
def _(P, a, b):
    J = np.hstack([np.eye(2), -np.eye(2)])
    return (J @ np.block([[P[a, a], P[a, b]], [P[b, a], P[b, b]]]) @ J.T).tolist()


@relative.variant("one cross block and its transpose")
def _(P, a, b):
    return P[a, a] + P[b, b] - (P[a, b] + P[a, b].T)
