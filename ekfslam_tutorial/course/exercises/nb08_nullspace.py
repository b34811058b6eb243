"""Exercise 08.1: how many directions of the state the measurements say nothing about."""

import numpy as np

from ..table import table


def observability(H, F):
    """Observability matrix, and the number of directions of the first state that no measurement can see.

    H = [H_0, H_1, ..., H_K]: Jacobian of all measurements made at time k, shape (m_k, n); m_k may differ.
    F = [F_0, ..., F_K-1]: Jacobian of the motion from time k to time k+1, shape (n, n).
    Return O, shape (m_0 + ... + m_K, n): what an error of the first state does to all measurements, in this order;
    and the number of invisible directions, a whole number from 0 (all is observable) to n.
    """
    rows, Phi = [H[0]], np.eye(H[0].shape[1])
    for H_k, F_k in zip(H[1:], F, strict=True):
        Phi = F_k @ Phi
        rows.append(H_k @ Phi)
    O = np.vstack(rows)
    return O, O.shape[1] - np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2))


def system(rng, n, d, sizes, scale=1.0):
    """Return Jacobians H, F of a made-up system in which d of the n directions are invisible from the first state on."""
    V = np.linalg.qr(rng.normal(size=(n, n)))[0]
    H, F, Phi = [], [], np.eye(n)
    for k, m in enumerate(sizes):
        if k:
            F.append(np.linalg.qr(rng.normal(size=(n, n)))[0] + 0.2 * np.triu(rng.normal(size=(n, n)), 1))
            Phi = F[-1] @ Phi
        seen = scale * rng.normal(size=(m, n - d)) @ V[:, d:].T  # blind for V[:, :d]
        H.append(seen @ np.linalg.inv(Phi))
    return H, F


# states, invisible directions, measurements at each time
SYSTEMS = ((6, 2, [3, 4, 5]), (5, 1, [2, 2, 2, 2]), (4, 0, [1, 2, 3]), (7, 3, [2, 2, 2, 2]), (5, 4, [2] * 3))
UNITS = (1e-12, 1e-7, 1e-5, 1e5, 1e7, 1e12)  # an absolute threshold is too small for one of them, or too large
AGAIN = ([np.repeat([[1.0, 0, 0]], 3, axis=0), np.eye(3)[:1]], [np.eye(3) + np.eye(3, k=1)])  # one row, three times


def sizes(H, F):
    """Return what the messages say of the arguments."""
    times = len(H)
    return f"{H[0].shape[1]} states, {' + '.join(str(len(h)) for h in H)} rows of H at {times} time{'s'[: times > 1]}"


hidden = table(
    "08.1 The directions that no measurement sees",
    observability,
    hints=(
        "An error dx_0 of the first state becomes F_0 dx_0, then F_1 F_0 dx_0 ... What does each H_k see?",
        "Stack H_0, H_1 F_0, H_2 F_1 F_0, ... to one matrix O. A direction v is invisible if O v = 0.",
        "The number of such directions is n minus the rank of O (np.linalg.matrix_rank); n is the number of columns.",
    ),
    returns="O, d",
    symbols="dx_0, dx_1 = the errors of the state at times 0 and 1",
    kinds={"d": "the number of invisible directions"},
    shown=sizes,
    cases={
        "any": lambda rng: [system(rng, *some) for some in SYSTEMS],
        "one motion": lambda rng: [system(rng, n, d, [2, m]) for n, d, m in ((6, 2, 3), (4, 0, 2))],
        "one time": lambda rng: [system(rng, n, d, [m]) for n, d, m in ((5, 2, 7), (4, 0, 6), (5, 2, 3))],
        "few rows": lambda rng: [system(rng, 7, 1, [2, 2]), system(rng, 6, 0, [1, 1, 2])],
        "units": lambda rng: [system(rng, 6, 2, [3, 3, 3], scale) for scale in UNITS],
        "again": lambda rng: [AGAIN],
        "blind": lambda rng: [([np.zeros((2, 3))] * 2, [np.eye(3)])],
    },
    checks="""
    first measurements     | O[:1] | any        | H_0 sees the first state itself: O begins with the rows of H_0, and those of all the others follow, up to H_K.
    one motion             | O     | one motion | H_1 sees the state at time 1, F_0 dx_0: these rows of O are H_1 F_0.
    several motions        | O     | any        | H_2 sees the state after two motions, F_0 and then F_1: these rows of O are H_2 F_1 F_0, and so on for every later time.
    one time only          | d     | one time   | Only H_0 and no motion: d is n minus the rank of H_0.
    fewer rows than columns | d    | few rows   | O has fewer rows than columns here. O v = 0 has n minus the rank of O independent solutions, and n is the number of *columns*.
    the same again         | d     | again      | A row that comes again tells nothing new, and a later one may: the rank of *all* rows of O.
    several times          | d     | any        | All measurements of all times together: the rank of the whole O.
    other units            | d     | units      | In other units the rank is the same. A fixed threshold depends on the units: compare the singular values with the largest of them.
    nothing is seen        | d     | blind      | A matrix of zeros sees nothing: all n directions are invisible.
    """,
    wrong="""
    motion forgotten | Phi = F_k @ Phi -> pass | H_1 sees the state at time 1. In terms of the first state that is H_1 F_0.
    only the last motion | Phi = F_k @ Phi -> Phi = F_k | From time 0 to time 2 there are two steps: H_2 F_1 F_0.
    only the first motion | Phi = F_k @ Phi -> Phi = F[0] | From time 0 to time 2 there are two steps: H_2 F_1 F_0.
    motions in the wrong order | F_k @ Phi -> Phi @ F_k | The first motion acts first, so it stands on the right: F_1 F_0.
    motion transposed | F_k @ Phi -> F_k.T @ Phi | dx_1 = F_0 dx_0: no transpose.
    motion undone | F_k @ Phi -> np.linalg.inv(F_k) @ Phi | dx_1 = F_0 dx_0: an error of the first state goes forward by F itself, not by its inverse.
    motion on the wrong side | Phi = F_k @ Phi -> Phi = np.linalg.multi_dot([np.eye(len(F_k)), *F]) | H_1 sees F_0 dx_0: the motion stands between H_1 and the first state, H_1 F_0.
    one time too late | Phi = F_k @ Phi -> pass | H_1 sees the state at time 1, after F_0: H_1 F_0. A product Phi of the motions has F_0 in it before H_1 comes: H_1 Phi.
        rows.append(H_k @ Phi) -> rows.append(H_k @ Phi); Phi = F_k @ Phi
    rank instead of what is missing | O.shape[1] - np -> np | That is the number of directions that *are* seen. Return n minus it.
    rows instead of columns | O.shape[1] - np -> len(O) - np | n is the number of columns, one for each state: O.shape[1], not len(O).
    only singular values that are zero | O.shape[1] - np -> min(O.shape) - np | O may have fewer rows than columns: then there are invisible directions without a zero singular value. n minus the rank counts all.
    only the first time | np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2)) -> np.linalg.matrix_rank(H[0]) | All measurements of all times together: take the rank of the whole O, not of H_0.
    always three | O.shape[1] - np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2)) -> 3 | Three is the answer for SLAM in the plane. Compute it: n minus the rank of O.
    no threshold | tol=1e-8 * np.linalg.norm(O, 2) -> tol=0.0 | Rounding never gives exactly zero: a singular value counts as zero if it is tiny beside the largest one.
    fixed threshold: A fixed threshold depends on the units. Compare with the largest singular value: s > 1e-10 * s.max(). np.linalg.matrix_rank(O) does so by itself; its `tol=` is a fixed threshold, too.
        tol=1e-8 * np.linalg.norm(O, 2) -> tol=1e-3
    fixed threshold, 1e-5: A fixed threshold depends on the units. Compare with the largest singular value: s > 1e-10 * s.max(). np.linalg.matrix_rank(O) does so by itself; its `tol=` is a fixed threshold, too.
        tol=1e-8 * np.linalg.norm(O, 2) -> tol=1e-5
    fixed threshold, 1e-8: A fixed threshold depends on the units. Compare with the largest singular value: s > 1e-10 * s.max(). np.linalg.matrix_rank(O) does so by itself; its `tol=` is a fixed threshold, too.
        tol=1e-8 * np.linalg.norm(O, 2) -> tol=1e-8
    fixed threshold, 1e-10: A fixed threshold depends on the units. Compare with the largest singular value: s > 1e-10 * s.max(). np.linalg.matrix_rank(O) does so by itself; its `tol=` is a fixed threshold, too.
        tol=1e-8 * np.linalg.norm(O, 2) -> tol=1e-10
    fixed threshold, 1e-12: A fixed threshold depends on the units. Compare with the largest singular value: s > 1e-10 * s.max(). np.linalg.matrix_rank(O) does so by itself; its `tol=` is a fixed threshold, too.
        tol=1e-8 * np.linalg.norm(O, 2) -> tol=1e-12
    H of the time before: The H before the motion is used: after F_k comes H_k+1, the next entry of the list. The rows of the last H are missing.
        zip(H[1:], F, strict=True) -> zip(H[:-1], F, strict=True)
    only the first n rows: O has more than n rows, and the later ones may see what the first ones do not: the rank of the whole O.
        np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2)) -> np.linalg.matrix_rank(O[: O.shape[1]])
    the last H left out: The rows of the last H are missing: there is one H more than F. A loop over the F, or over both with zip, ends one H too early.
        rows, Phi = [H[0]], np.eye(H[0].shape[1]) -> rows, Phi = [], np.eye(H[0].shape[1])
        for H_k, F_k in zip(H[1:], F, strict=True): -> for H_k, F_k in zip(H, F):
        Phi = F_k @ Phi -> pass
        rows.append(H_k @ Phi) -> rows.append(H_k @ Phi); Phi = F_k @ Phi
    the best of the single times: Several times together see more than each alone: the rank of the whole O counts, not that of its best block.
        return O, O.shape[1] - np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2)) -> return O, O.shape[1] - max(np.linalg.matrix_rank(B, tol=1e-8 * np.linalg.norm(O, 2)) for B in rows)
    """,
)


@hidden.wrong("one time too early", "H_0 belongs to the first state itself: no F. H_1 gets F_0, H_2 gets F_1 F_0.")
def _(H, F):
    if not F:
        return observability(H, F)
    Phi, rows = np.eye(len(F[0])), []
    for k, H_k in enumerate(H):
        Phi = F[k] @ Phi if k < len(F) else Phi
        rows.append(H_k @ Phi)
    O = np.vstack(rows)
    return O, O.shape[1] - np.linalg.matrix_rank(O, tol=1e-8 * np.linalg.norm(O, 2))
