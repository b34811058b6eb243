"""Exercise 22.5: NEES of a line, in its four degrees of freedom."""

import numpy as np

from ...geometry import unit
from ..table import table
from .nb04_blocks import random_covariance


def line_nees(l, P, truth):
    """NEES of an estimated Plücker line: four degrees of freedom.

    l = [n; v], shape (6,), is the estimate and P, shape (6, 6), its covariance. truth = [n; v], shape (6,), is the true
    line. Both have n' v = 0. Their scales are any, and differ: l and -3 l are the same line.
    A small error of a line has no meaning along `truth`: that is a change of scale. And it has no part along [v; n] of
    the true line: n' v = 0 forbids it. Four directions are left. `np.linalg.svd(A)[2][2:]`, for a matrix A of shape
    (2, 6), has unit vectors across both rows of A in its four rows.
    Return the NEES, a number: e' C^-1 e, with the four numbers e = B l and their covariance C.
    """
    n, v = truth[:3], truth[3:]
    B = np.linalg.svd(np.stack([truth, np.concatenate([v, n])]))[2][2:]
    e = B @ l
    return e @ np.linalg.solve(B @ P @ B.T, e)


SLANTED = np.array([[1.0, 0.0, -1.0], [0.0, np.sqrt(2), 0.0]])
"""n and v of a line for which [v; n] is across the same six numbers turned round, as it is across [v; -n]."""


def case(rng, scale=1.0, true_scale=1.0, sizes=(0.5, 2.0), line=None):
    """A true line and an estimate: small errors of all the filter can have, also along the scale.

    Along [v; n] a bit of P is left: so a wrong B gives a number of its own, not one of rounding. Another row than
    [v; n] does no harm, to first order, as long as [v; n] is not across it.
    """
    n, v = np.linalg.qr(rng.normal(size=(3, 2)))[0].T * rng.uniform(*sizes, (2, 1)) if line is None else line
    truth, across = np.concatenate([n, v]), unit(np.concatenate([v, n]))[0]
    T = np.eye(6) - (1 - 1e-4) * np.outer(across, across)
    P = T @ random_covariance(rng, 6, 1e-5) @ T
    error = T @ rng.normal(0, 1e-5, 6)
    l = truth + error
    l[3:] -= l[:3] * (l[:3] @ l[3:]) / (l[:3] @ l[:3])
    return scale * l, scale**2 * P, true_scale * truth


free = table(
    "22.5 NEES of a line",
    line_nees,
    hints=(
        "Six numbers, two of which mean nothing: take the four others, of the error and of the covariance alike.",
        "B has four rows, across truth and across [v; n]. B @ truth is zero, so B @ l is the error already. C = B P B'.",
        "e = B @ l; C = B @ P @ B.T; e @ np.linalg.solve(C, e).",
    ),
    returns="nees",
    rtol={"nees": 3e-3},  # first order in errors of 1e-5; P has lost digits
    cases={
        "any": lambda rng: [
            *(case(rng), case(rng), case(rng, 3e4, 3e4)),
            case(rng, sizes=(1, 1)),  # |n| = |v|, too
            case(rng, line=SLANTED),
        ],
        "scaled": lambda rng: [case(rng, a, b) for a, b in ((3.0, 1.0), (-0.4, 1.0), (1.0, 5.0), (2.0, -0.3))],
    },
    checks="""
    same scale | nees | any    | e' C^-1 e with four numbers: e = B l, C = B P B', and B across truth and across [v; n] of the truth.
    any scale  | nees | scaled | l, with its P, and truth have scales of their own: l and -3 l are the same line. With B across truth, e = B l and C = B P B', the NEES is the same for all scales.
    """,
    wrong="""
    six numbers: Two of the six have no meaning, and P says nothing of them. A pseudo-inverse hides that; the four directions B show what is left.
        e @ np.linalg.solve(B @ P @ B.T, e) -> (l - truth) @ np.linalg.pinv(P, rcond=1e-9) @ (l - truth)
    six numbers, both of length one: First take away what has no meaning: e = B l and C = B P B', four numbers each way. A pseudo-inverse of P lets the scale in; and P belongs to l as it stands, not to l / |l|.
        e @ np.linalg.solve(B @ P @ B.T, e) -> (d := l / np.linalg.norm(l) - truth / np.linalg.norm(truth)) @ np.linalg.pinv(P) @ d
    condition forgotten | np.stack([truth, np.concatenate([v, n])]))[2][2:] -> truth[None])[2][1:] | n'v = 0 takes away one direction more: across [v; n]. Five directions are one too many.
    sign in the condition | np.concatenate([v, n])])) -> np.concatenate([v, -n])])) | (n + dn)' (v + dv) = 0 forbids v'dn + n'dv: the second row is [v; n], with a plus.
    n and v kept apart | np.concatenate([v, n])])) -> np.concatenate([n, -v])])) | The second row is [v; n]: n'v = 0 forbids a part along it. With [n; -v], or with [n; 0] and [0; v], n and v have a scale each, and the distance of the line, their ratio, is lost.
    rows from 2 on | [2][2:] -> [2][:4] | The first two rows of svd (the first two columns, for A transposed) lie along truth and [v; n] themselves. Take those from 2 on: they are across both.
    columns for rows | np.linalg.svd(np.stack([truth, np.concatenate([v, n])]))[2][2:] -> np.linalg.svd(np.stack([truth, np.concatenate([v, n])]))[2][:, 2:].T | svd returns V transposed as its third result: the directions are the *rows* of it, from 2 on, not its columns.
    scale forgotten | np.stack([truth, np.concatenate([v, n])]))[2][2:] -> np.concatenate([v, n])[None])[2][1:] | A line has no scale: the direction of truth itself is to be taken away, too.
    directions of the estimate | n, v = truth[:3], truth[3:] -> truth = l; n, v = truth[:3], truth[3:] | B is across the *true* line, and e is B l: B truth is zero, and so is B l with a B across the estimate itself, whatever the error.
    the other directions | [2][2:] -> [2][:2] | Those are the two directions that mean nothing. The four that are left are the other rows.
    covariance not reduced | B @ P @ B.T, e) -> np.eye(4) * np.trace(P) / 6, e) | e = B l has the covariance B P B'.
    only the variances | np.linalg.solve(B @ P @ B.T, e) -> (e / np.diag(B @ P @ B.T)) | The four numbers are correlated: take the whole of B P B'.
    inverse forgotten | np.linalg.solve(B @ P @ B.T, e) -> (B @ P @ B.T @ e) | Large where C is *small*: e' C^-1 e.
    inverse before B | np.linalg.solve(B @ P @ B.T, e) -> (B @ np.linalg.pinv(P) @ B.T @ e) | First C = B P B', then its inverse: B P^-1 B' is another matrix, and P of a line has no inverse.
    root taken | return e @ np.linalg.solve(B @ P @ B.T, e) -> return np.sqrt(e @ np.linalg.solve(B @ P @ B.T, e)) | NEES is the *squared* distance: no root.
    divided by four | return e @ np.linalg.solve(B @ P @ B.T, e) -> return e @ np.linalg.solve(B @ P @ B.T, e) / 4 | NEES of a line is about 4, its degrees of freedom: do not divide by them.
    divided by six | return e @ np.linalg.solve(B @ P @ B.T, e) -> return e @ np.linalg.solve(B @ P @ B.T, e) / 6 | NEES of a line is about 4, its degrees of freedom: do not divide, neither by them nor by the six numbers.
    difference to the truth, scaled: P belongs to l as it stands. If you bring l to another scale, P must go to the square of it.
        e = B @ l -> e = B @ (l / np.linalg.norm(l))
    six numbers, the estimate's scale taken off: Two of the six have no meaning, and P says nothing of them. A pseudo-inverse hides that; the four directions B show what is left.
        e @ np.linalg.solve(B @ P @ B.T, e) -> (d := l - l @ truth / (truth @ truth) * truth) @ np.linalg.pinv(P) @ d
    the first four rows, the scale taken off: The first two rows of svd (the first two columns, for A transposed) lie along truth and [v; n] themselves. Take those from 2 on: they are across both.
        [2][2:] -> [2][:4]
        e = B @ l -> e = B @ (l - l @ truth / (truth @ truth) * truth)
    P by the scale, not by its square | e = B @ l -> k = np.linalg.norm(truth) / np.linalg.norm(l); e, P = B @ (k * l), k * P | If l is multiplied by k, its covariance is multiplied by k^2.
    l laid on the truth, P not | e = B @ l -> e = B @ (l * (truth @ truth) / (l @ truth)) | If l is multiplied by k, its covariance is multiplied by k^2. Or leave both as they are: the scale has no part in e = B l.
    numbers turned round | np.concatenate([v, n])])) -> truth[::-1]])) | [v; n] has n and v exchanged, each in its own order. truth[::-1] turns the three numbers of each round, too.
    directions of the estimate, with the difference: B is across the *true* line. Across the estimate it takes away all of l, and leaves the truth with the scale of another line.
        n, v = truth[:3], truth[3:] -> n, v = l[:3], l[3:]
        np.stack([truth, -> np.stack([l,
        e = B @ l -> e = B @ (l - truth)
    the other Cholesky factor | np.linalg.solve(B @ P @ B.T, e) -> np.linalg.solve((L := np.linalg.cholesky(B @ P @ B.T)).T @ L, e) | With C = L L' the whitened error is L^-1 e, and not the inverse of L' times e.
    """,
)
