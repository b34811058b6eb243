"""Exercise 21.3: marginalisation by the Schur complement."""

import numpy as np

from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def marginalise(A, b, keep):
    """Take unknowns out of the normal equations A x = b, without losing what they tell of the others.

    A, shape (n, n): information matrix. b, shape (n,): information vector; the mean is inv(A) b. keep: list of the
    indices that stay, in the order wanted; all others go.
    Return the A and the b of those that stay.
    """
    gone = [i for i in range(len(A)) if i not in keep]
    A_kk, A_kg, A_gg = A[np.ix_(keep, keep)], A[np.ix_(keep, gone)], A[np.ix_(gone, gone)]
    S = np.linalg.solve(A_gg, A_kg.T).T  # A_kg A_gg^-1
    A_new = A_kk - S @ A_kg.T
    b_new = b[keep] - S @ b[gone]
    return A_new, b_new


def case(rng, n=6, keep=(1, 4, 2)):
    """Normal equations with no zero in them."""
    return random_covariance(rng, n, 2.0), rng.normal(size=n), list(keep)


def unconnected(A, b, keep):
    """The same where those that go have no connection with the others."""
    A = A.copy()
    gone = [i for i in range(len(A)) if i not in keep]
    A[np.ix_(keep, gone)], A[np.ix_(gone, keep)] = 0, 0
    return A, b, keep


exercise = table(
    "21.3 Marginalise",
    marginalise,
    hints=(
        "To delete rows and columns of A is not enough: that would mean that the others are *known*. Solve the lower equations for the unknowns that go, and put the result into the upper ones.",
        "With k for keep and g for gone: x_g = A_gg^-1 (b_g - A_gk x_k). Put this into A_kk x_k + A_kg x_g = b_k.",
        "A_kk - A_kg A_gg^-1 A_gk, and b_k - A_kg A_gg^-1 b_g. Blocks: A[np.ix_(keep, gone)].",
    ),
    returns="A, b",
    symbols="A_kk, A_kg, A_gk, A_gg = the blocks of A, k for those that stay, g for those that go; "
    "b_k, b_g = the same parts of b",
    cases={
        "any": lambda rng: [case(rng, 6, keep) for keep in ((0, 1, 2), (1, 4, 2), (5, 0), (3,), (3, 4, 5, 0, 1))],
        "all": lambda rng: [case(rng, 4, (0, 1, 2, 3)), case(rng, 3, (2, 0, 1))],
        "unconnected": lambda rng: [unconnected(*case(rng, 5, keep)) for keep in ((0, 1, 2), (4, 1))],
    },
    checks="""
    all stay      | A, b | all         | Where nothing goes, A and b keep their numbers, in the order of keep.
    covariance    | A | any         | inv of the new A must be the block of inv(A): what was known of those that stay.
    mean          | b | any         | The mean of those that stay must not change: inv(A) b before and after.
    no connection | A, b | unconnected | An unknown that has nothing to do with the others goes without a trace.
    """,
    wrong="""
    rows and columns deleted | return A_new, b_new -> return A_kk, b[keep] | That is conditioning: it takes the others for known. To marginalise *their uncertainty* as well, subtract A_kg A_gg^-1 A_gk, and the same for b.
    b not corrected | return A_new, b_new -> return A_new, b[keep] | The mean of those that stay changes in your answer: b_k - A_kg A_gg^-1 b_g.
    A not corrected | return A_new, b_new -> return A_kk, b_new | A changes as well: A_kk - A_kg A_gg^-1 A_gk.
    plus | A_kk - S -> A_kk + S | Information is lost, not won: minus A_kg A_gg^-1 A_gk, and in b minus A_kg A_gg^-1 b_g.
        b[keep] - S -> b[keep] + S
    plus in b | b[keep] - S -> b[keep] + S | In b it is minus, too: b_k - A_kg A_gg^-1 b_g.
    inverse forgotten | np.linalg.solve(A_gg, A_kg.T).T -> A_kg @ A_gg | Between the two off-diagonal blocks stands the *inverse* of A_gg.
    A_gg left out | np.linalg.solve(A_gg, A_kg.T).T -> A_kg | Between the two off-diagonal blocks stands the inverse of A_gg.
    a block of the covariance | return A_new, b_new -> return np.linalg.inv(A)[np.ix_(keep, keep)], np.linalg.solve(A, b)[keep] | These are the covariance and the mean of those that stay. A is the inverse of that covariance, b is this A times the mean.
    mean instead of b | b[keep] - S @ b[gone] -> np.linalg.solve(A, b)[keep] | b is the information vector, A times the mean, not the mean.
    only the diagonal of A_gg | solve(A_gg, -> solve(np.diag(np.diag(A_gg)), | The unknowns that go are correlated: take the inverse of the whole block.
    keep sorted | gone = [i -> keep = sorted(keep); gone = [i | Keep the order that is asked for: A[np.ix_(keep, keep)].
    fill-in dropped | return A_new, b_new -> return np.diag(np.diag(A_new)), b_new | The Schur complement connects unknowns that were not connected: do not drop these entries.
    keep and gone swapped | gone = [i for i in range(len(A)) if i not in keep] -> gone, keep = keep, [i for i in range(len(A)) if i not in keep] | `keep` holds the indices that stay.
    the last ones dropped | gone = [i -> keep = list(range(len(keep))); gone = [i | Any of the unknowns may go: `keep` holds the indices that stay, in their order.
    plus in A | A_kk - S -> A_kk + S | Information is lost, not won: minus A_kg A_gg^-1 A_gk.
    inverse forgotten in b | b[keep] - S @ b[gone] -> b[keep] - A_kg @ A_gg @ b[gone] | In b, too, the *inverse* of A_gg stands between: b_k - A_kg A_gg^-1 b_g.
    b in rising order | b[keep] - S -> b[sorted(keep)] - S | b has the order of `keep`, as A has: b[keep].
    mean of those that go | b_new = b[keep] - S @ b[gone] -> b_new = b[keep] - A_kg @ np.linalg.solve(A, b)[gone] | That takes those that go for known, at their means. b_k loses A_kg A_gg^-1 b_g.
    only the diagonal subtracted | A_new = A_kk - S @ A_kg.T -> A_new = A_kk - np.diag(np.diag(S @ A_kg.T)) | Those that stay are linked anew by those that go: the whole of A_kg A_gg^-1 A_gk is subtracted, not its diagonal.
    """,
)


@exercise.link("one after the other", "Two at once or one by one: the result must be the same. Fill-in is kept.")
def _(f, rng):
    A, b, _ = case(rng, 7)
    once, part = f(A, b, [0, 2, 4, 6, 5]), f(A, b, [0, 1, 2, 4, 6, 5])
    step = f(*(np.array(result, float) for result in part), [0, 2, 3, 4, 5])
    for i, name in enumerate("Ab"):
        expect.close(once[i], step[i], f"{name}, two unknowns at once against one by one")
