"""Exercise 22.4: the condition n'v = 0 of a Plücker line, after a correction."""

import numpy as np

from ..table import table
from .nb04_blocks import random_covariance


def tidy_line(l, P):
    """Bring a Plücker line back to n' v = 0: v gives way, n stays.

    l = [n; v], shape (6,), is the line after a correction, n neither zero nor of length one, and P, shape (6, 6), its
    covariance. The part of v along n is taken away:
        s = n' v / n' n,    d = v - s n
    Return the line [n; d], shape (6,), and its covariance J P J', shape (6, 6): J is its derivative by l.
    """
    n, v = l[:3], l[3:]
    s = n @ v / (n @ n)
    D_v = np.eye(3) - np.outer(n, n) / (n @ n)
    D_n = -s * np.eye(3) - np.outer(n, v - 2 * s * n) / (n @ n)
    J = np.block([[np.eye(3), np.zeros((3, 3))], [D_n, D_v]])
    return np.concatenate([n, v - s * n]), J @ P @ J.T


def case(rng, off=0.3):
    """A line with n' v = off |n| |v|, and a covariance."""
    n, c = rng.normal(size=(2, 3)) * rng.uniform(0.6, 2.0)
    v = np.cross(n, c) / np.linalg.norm(n)
    v = v + off * np.linalg.norm(v) * n / np.linalg.norm(n)
    return np.concatenate([n, v]), random_covariance(rng, 6, 0.1)


tidied = table(
    "22.4 The condition that a correction does not keep",
    tidy_line,
    hints=(
        "d is a function of n and of v: two blocks of J. The first three rows say that n stays as it is.",
        "By v: I - n n' / n'n. By n: both factors of s n depend on n, and s is a fraction of which both parts do.",
        "D_n = -s I - n (v - 2 s n)' / n'n; J = [[I, 0], [D_n, D_v]].",
    ),
    returns="l, P",
    symbols="D_n, D_v = the derivatives of d by n and by v; S_n = the derivative of s by n",
    cases={
        "any": lambda rng: [case(rng, off) for off in (0.3, -0.6, 1.2)],
        "kept": lambda rng: [case(rng, 0.0) for _ in range(2)],
    },
    checks="""
    normal        | l[:3]      | any  | n stays as it is: it was measured.
    direction     | l          | any  | The part of v along n is taken away: d = v - (n'v / n'n) n, for an n of any length. What is left is across n: n'd = 0.
    block of n    | P[:3, :3]  | any  | n does not change, so its covariance does not.
    already there | P          | kept | With n'v = 0 the line stays as it is, d = v. P becomes J P J' there, too, J with the derivatives of d by n and by v: in the direction [v; n] nothing is left of it.
    covariance    | P          | any  | J P J', with J the derivative of [n; d] by [n; v]: that of d by n is found by the product rule.
    """,
    wrong="""
    n gives way: Here n was measured, and v was a prior. Take the part away from v, and leave n as it is.
        np.concatenate([n, v - s * n]) -> np.concatenate([n - (n @ v) / (v @ v) * v, v])
    n takes the step | np.concatenate([n, v - s * n]) -> np.concatenate([n - s * v, v]) | n stays as it is: it was measured. v gives way, by s n.
    length of n forgotten | s = n @ v / (n @ n) -> s = n @ v | n need not have the length one: s = n'v / n'n.
    divided by the length | s = n @ v / (n @ n) -> s = n @ v / np.linalg.norm(n) | Divide by n'n, the square of the length: once for the direction of n, once for the part.
    divided by the length in all: Divide by n'n, the square of the length: once for the direction of n, once for the part; so in the derivative by v.
        s = n @ v / (n @ n) -> s = n @ v / np.linalg.norm(n)
        np.eye(3) - np.outer(n, n) / (n @ n) -> np.eye(3) - np.outer(n, n) / np.linalg.norm(n)
    divided by v'v | s = n @ v / (n @ n) -> s = n @ v / (v @ v) | The part of v along n has n'n in the denominator; with v'v it is that of n along v.
    added | np.concatenate([n, v - s * n]) -> np.concatenate([n, v + s * n]) | The part along n is taken away: v - s n.
    only the state | J @ P @ J.T -> P | The state has changed by a function, so P changes to J P J'. Otherwise the filter goes on to take the condition for uncertain.
    D_n forgotten | [D_n, D_v]] -> [np.zeros((3, 3)), D_v]] | The new v depends on n, too: when the plane turns, v turns with it. J has a block by n in the rows of v.
    s taken for a constant | -s * np.eye(3) - np.outer(n, v - 2 * s * n) / (n @ n) -> -s * np.eye(3) | s depends on n as well: product rule, -s I - n (v - 2 s n)' / n'n.
    denominator taken for a constant | v - 2 * s * n) / (n @ n) -> v) / (n @ n) | n'n depends on n, too: its derivative brings -2 s n.
    s n: one factor only | -s * np.eye(3) - np.outer -> -np.outer | Product rule: d = v - s n changes with n even where s is held, by -s I.
    outer product turned round | np.outer(n, v - 2 * s * n) -> np.outer(v - 2 * s * n, n) | Rows are what comes out, columns what goes in: s n changes along n, so np.outer(n, v - 2 s n) / n'n.
    D_v the identity | np.eye(3) - np.outer(n, n) / (n @ n) -> np.eye(3) | The part of v along n is gone, also out of its covariance: by v, d has the derivative I - n n' / n'n.
    length of n in D_v | np.outer(n, n) / (n @ n) -> np.outer(n, n) | n need not have the length one: by v, d has the derivative I - n n' / n'n.
    J' P J | J @ P @ J.T -> J.T @ P @ J | The covariance of J l is J P J', in this order.
    n gives way, s taken for a constant: Here n was measured, and v was a prior. Take the part away from v, and leave n as it is.
        s = n @ v / (n @ n) -> s = n @ v / (v @ v)
        return np.concatenate([n, v - s * n]), -> J = np.eye(6); J[:3, 3:] = -s * np.eye(3); return np.concatenate([n - s * v, v]),
    s taken for a constant, by n and by v: s depends on n and on v: d = v - s n has the derivatives I - n n' / n'n by v, and -s I - n (v - 2 s n)' / n'n by n.
        D_v = np.eye(3) - np.outer(n, n) / (n @ n) -> D_v = np.eye(3)
        D_n = -s * np.eye(3) - np.outer(n, v - 2 * s * n) / (n @ n) -> D_n = -s * np.eye(3)
    brought to length one, too | return np.concatenate([n, v - s * n]), -> return np.concatenate([n, v - s * n]) / np.linalg.norm(n), | Nothing but the part of v along n is taken away: n keeps its length, and v is not divided by it.
    derivative at the tidied line: J is the derivative at the line that came in, where s is not zero yet: -s I - n (v - 2 s n)' / n'n by n.
        D_n = -s * np.eye(3) - np.outer(n, v - 2 * s * n) / (n @ n) -> D_n = -np.outer(n, v - s * n) / (n @ n)
    n gives way, in the derivative, too: Here n was measured, and v was a prior. Take the part away from v, and leave n as it is.
        J = np.block([[np.eye(3), np.zeros((3, 3))], [D_n, D_v]]) -> r = n @ v / (v @ v); J = np.block([[np.eye(3) - np.outer(v, v) / (v @ v), -r * np.eye(3) - np.outer(v, n - 2 * r * v) / (v @ v)], [np.zeros((3, 3)), np.eye(3)]])
        np.concatenate([n, v - s * n]) -> np.concatenate([n - r * v, v])
    only the covariance of v | J @ P @ J.T -> np.block([[P[:3, :3], P[:3, 3:]], [P[3:, :3], (J @ P @ J.T)[3:, 3:]]]) | n and the new v are correlated anew: the whole P goes through J, the blocks between n and v, too.
    n of length one | return np.concatenate([n, v - s * n]), -> return np.concatenate([n / np.linalg.norm(n), v - s * n]), | n stays as it is: it was measured.
    no covariance of n and v | v - s * n]), J @ P @ J.T -> v - s * n]), (J @ P @ J.T) * np.kron(np.eye(2), np.ones((3, 3))) | n and v are correlated: J P J' has blocks off the diagonal.
    v lost before J | v - 2 * s * n) / (n @ n) -> v - 3 * s * n) / (n @ n) | J is the derivative at the line that came in: v stands in it, not d. Keep v until J is there.
    """,
)
