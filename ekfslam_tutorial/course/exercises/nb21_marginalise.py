"""Exercise 21.3: marginalisation by the Schur complement."""

import numpy as np

from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def marginalise(A, b, keep):
    """Take unknowns out of the normal equations A x = b, without losing what they tell of the others.

    A, shape (n, n): information matrix. b, shape (n,): information vector; the mean is inv(A) b. keep: list of the
    indices that stay, in the order wanted; all others go.
    Return the A and the b of those that stay.
    """
    gone = [i for i in range(len(A)) if i not in keep]
    A_kk, A_kg = A[np.ix_(keep, keep)], A[np.ix_(keep, gone)]
    S = np.linalg.solve(A[np.ix_(gone, gone)], A_kg.T).T
    return A_kk - S @ A_kg.T, b[keep] - S @ b[gone]


exercise = Exercise(
    "21.3",
    "Marginalise",
    marginalise,
    hints=(
        "To delete rows and columns of A is not enough: that would mean that the others are *known*. Solve the lower "
        "equations for the unknowns that go, and put the result into the upper ones.",
        "With k for keep and g for gone: x_g = A_gg^-1 (b_g - A_gk x_k). Put this into A_kk x_k + A_kg x_g = b_k.",
        "A_kk - A_kg A_gg^-1 A_gk, and b_k - A_kg A_gg^-1 b_g. Blocks: A[np.ix_(keep, gone)].",
    ),
)


def case(rng, n=6, keep=(1, 4, 2)):
    """Normal equations with no zero in them."""
    return random_covariance(rng, n, 2.0), rng.normal(size=n), list(keep)


def two(result, n):
    """Return the results A and b as arrays."""
    A, b = expect.results(result, "A", "b")
    return expect.array(A, (n, n), "A"), expect.array(b, n, "b")


@exercise.link("two results", "The function must end with `return A, b`.")
def _(f, rng):
    for keep in ((0, 1), (5,), (3, 4, 5)):
        two(f(*case(rng, 6, keep)), len(keep))


@exercise.link("all stay", "Where nothing goes, nothing changes, but for the order.")
def _(f, rng):
    A, b, _ = case(rng, 4)
    got = two(f(A, b, [0, 1, 2, 3]), 4)
    expect.close(got[0], A, "A where all stay")
    expect.close(got[1], b, "b where all stay")


@exercise.link("covariance", "inv of the new A must be the block of inv(A): what was known of those that stay.", 0)
def _(f, rng):
    for keep in ((0, 1, 2), (1, 4, 2), (5, 0)):
        A, b, keep = case(rng, 6, keep)
        expect.close(two(f(A, b, keep), len(keep))[0], marginalise(A, b, keep)[0], f"A for keep = {keep}")


@exercise.link("mean", "The mean of those that stay must not change: inv(A) b before and after.", 1)
def _(f, rng):
    for keep in ((0, 1, 2), (1, 4, 2), (5, 0)):
        A, b, keep = case(rng, 6, keep)
        got = two(f(A, b, keep), len(keep))
        expect.close(got[1], marginalise(A, b, keep)[1], f"b for keep = {keep}")
        expect.close(np.linalg.solve(*got), np.linalg.solve(A, b)[keep], "the mean of those that stay")


@exercise.link("no connection", "An unknown that has nothing to do with the others goes without a trace.")
def _(f, rng):
    A = np.zeros((5, 5))
    A[:3, :3], A[3:, 3:] = random_covariance(rng, 3), random_covariance(rng, 2)
    b = rng.normal(size=5)
    got = two(f(A, b, [0, 1, 2]), 3)
    expect.close(got[0], A[:3, :3], "A, where the unknowns that go have no connection")
    expect.close(got[1], b[:3], "b, where the unknowns that go have no connection")


@exercise.link("one after the other", "Two at once or one by one: the result must be the same. Fill-in is kept.")
def _(f, rng):
    A, b, _ = case(rng, 7)
    once = two(f(A, b, [0, 2, 4, 6, 5]), 5)
    step = two(f(*two(f(A, b, [0, 1, 2, 4, 6, 5]), 6), [0, 2, 3, 4, 5]), 5)
    expect.close(once[0], step[0], "A, two unknowns at once against one by one")
    expect.close(once[1], step[1], "b, two unknowns at once against one by one")


# ---- wrong and right answers ---------------------------------------------------------------------------------------


def _parts(A, keep):
    gone = [i for i in range(len(A)) if i not in list(keep)]
    return gone, A[np.ix_(keep, keep)], A[np.ix_(keep, gone)], A[np.ix_(gone, gone)]


def _wrong(name, hint, answer):
    def wrapped(A, b, keep):
        A, b, keep = np.asarray(A, float), np.asarray(b, float), list(keep)
        return answer(A, b, keep, *_parts(A, keep))

    exercise.wrong(name, hint)(wrapped)


inv = np.linalg.inv
# fmt: off
_wrong("rows and columns deleted", "That is conditioning: it takes the others for known. To marginalise *their "
       "uncertainty* as well, subtract A_kg A_gg^-1 A_gk, and the same for b.",
       lambda A, b, keep, gone, kk, kg, gg: (kk, b[keep]))
_wrong("b not corrected", "The mean of those that stay changes in your answer: b_k - A_kg A_gg^-1 b_g.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ inv(gg) @ kg.T, b[keep]))
_wrong("A not corrected", "A changes as well: A_kk - A_kg A_gg^-1 A_gk.",
       lambda A, b, keep, gone, kk, kg, gg: (kk, b[keep] - kg @ inv(gg) @ b[gone]))
_wrong("plus", "Information is lost, not won: minus A_kg A_gg^-1 A_gk.",
       lambda A, b, keep, gone, kk, kg, gg: (kk + kg @ inv(gg) @ kg.T, b[keep] + kg @ inv(gg) @ b[gone]))
_wrong("plus in b", "In b it is minus, too: b_k - A_kg A_gg^-1 b_g.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ inv(gg) @ kg.T, b[keep] + kg @ inv(gg) @ b[gone]))
_wrong("inverse forgotten", "Between the two off-diagonal blocks stands the *inverse* of A_gg.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ gg @ kg.T, b[keep] - kg @ gg @ b[gone]))
_wrong("A_gg left out", "Between the two off-diagonal blocks stands the inverse of A_gg.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ kg.T, b[keep] - kg @ b[gone]))
_wrong("a block of the covariance", "That is the covariance of those that stay. Its inverse is their information.",
       lambda A, b, keep, gone, kk, kg, gg: (inv(A)[np.ix_(keep, keep)], inv(A)[keep] @ b))
_wrong("mean instead of b", "A is right. b is the information vector, A times the mean, not the mean.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ inv(gg) @ kg.T, inv(A)[keep] @ b))
_wrong("only the diagonal of A_gg", "The unknowns that go hang together: the inverse of the whole block.",
       lambda A, b, keep, gone, kk, kg, gg: (kk - kg @ np.diag(1 / np.diag(gg)) @ kg.T,
                                             b[keep] - kg @ np.diag(1 / np.diag(gg)) @ b[gone]))
_wrong("keep sorted", "Keep the order that is asked for: A[np.ix_(keep, keep)].",
       lambda A, b, keep, gone, kk, kg, gg: marginalise(A, b, sorted(keep)))
_wrong("fill-in dropped", "The Schur complement connects unknowns that were not connected: do not drop these entries.",
       lambda A, b, keep, gone, kk, kg, gg: (np.diag(np.diag(kk - kg @ inv(gg) @ kg.T)),
                                             b[keep] - kg @ inv(gg) @ b[gone]))
_wrong("keep and gone swapped", "`keep` holds the indices that stay.",
       lambda A, b, keep, gone, kk, kg, gg: marginalise(A, b, gone) if len(gone) == len(keep) else (kk, b[keep]))
# fmt: on


@exercise.variant("by way of the covariance")
def _(A, b, keep):
    P = np.linalg.inv(A)
    B = np.linalg.inv(P[np.ix_(keep, keep)])
    return B, B @ (P @ b)[keep]


@exercise.variant("Gauss elimination, one unknown after the other, lists")
def _(A, b, keep):
    A, b = np.array(A, float), np.array(b, float)
    for i in range(len(A)):
        if i not in keep:
            others = [j for j in range(len(A)) if j != i]
            f = A[:, i] / A[i, i]
            for j in others:
                b[j] -= f[j] * b[i]
            A[others] -= np.outer(f[others], A[i])
            A[:, i] = 0
    return A[np.ix_(keep, keep)].tolist(), b[keep].tolist()


@exercise.variant("with masks")
def _(A, b, keep):
    out = np.ones(len(A), bool)
    out[keep] = False
    G = np.linalg.inv(A[out][:, out]) if out.any() else np.zeros((0, 0))
    B = A[keep][:, out]
    return A[keep][:, keep] - B @ G @ B.T, np.asarray(b)[keep] - B @ G @ np.asarray(b)[out]
