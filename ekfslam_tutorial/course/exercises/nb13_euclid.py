"""Exercise 13.3: an inverse-depth landmark becomes a Euclidean point, and the whole map follows."""

import numpy as np

from ...models.landmarks.idp_pnt import py2vec
from .. import expect
from ..table import table
from .nb04_blocks import random_covariance


def idp2euc(x, P, i):
    """Turn one inverse-depth landmark of the map into a Euclidean point.

    x, shape (n,), and P, shape (n, n), are the whole map. x[i : i + 6] = [anchor; pitch; yaw; rho] is the landmark.
    `py2vec(py)` returns m, M_py: the unit direction, shape (3,), and its Jacobian by [pitch, yaw], shape (3, 2).
    The point is anchor + m / rho. It takes the place of the six numbers; nothing else moves.
    Return the new x, shape (n - 3,), and the new P, shape (n - 3, n - 3).
    """
    a, rho = x[i : i + 3], x[i + 5]
    m, M_py = py2vec(x[i + 3 : i + 5])
    p = a + m / rho
    P_l = np.column_stack([np.eye(3), M_py / rho, -m / rho**2])
    J = np.zeros((len(x) - 3, len(x)))
    J[:i, :i] = np.eye(i)
    J[i : i + 3, i : i + 6] = P_l
    J[i + 3 :, i + 6 :] = np.eye(len(x) - i - 6)
    x, P = np.concatenate([x[:i], p, x[i + 6 :]]), J @ P @ J.T
    return x, P


def case(rng, before=7, after=6, scale=1.0):
    """A map with the landmark between other states, all correlated; and the place of the landmark."""
    l = np.array([*rng.uniform(-3, 3, 3), rng.uniform(-1, 1), rng.uniform(-3, 3), rng.uniform(0.1, 0.8)])
    x = np.concatenate([rng.uniform(-2, 2, before), l, rng.uniform(-2, 2, after)])
    return x, random_covariance(rng, len(x), scale), before


def _only_cut(P, i):
    return np.delete(np.delete(P, range(i + 3, i + 6), 0), range(i + 3, i + 6), 1)


def _with_block(P, i, block):
    """P, with another block of the landmark."""
    P = P.copy()
    P[i : i + 3, i : i + 3] = block[i : i + 3, i : i + 3]
    return P


def _alone(P, i):
    """P, with the landmark not correlated with the others."""
    out = P.copy()
    out[i : i + 3], out[:, i : i + 3] = 0, 0
    return _with_block(out, i, P)


def _last(x, i):
    """The order in which the landmark comes last."""
    return [*range(i), *range(i + 3, len(x)), *range(i, i + 3)]


turned = table(
    "13.3 From inverse depth to a Euclidean point",
    idp2euc,
    hints=(
        "First the point. Then its Jacobian by the six numbers, three blocks of columns: anchor, angles, rho.",
        "P_l = [I, M_py / rho, -m / rho^2], shape (3, 6). The other states are copied: identity blocks around it.",
        "J is block diagonal: I (i), P_l, I (the rest). The new covariance of the whole map is J P J'.",
    ),
    returns="x, P",
    symbols="J = the derivative of the new map by the old one; P_l = the derivative of the point by the landmark; "
    "P_lm = P[i : i + 6, other states]; P_ll = P[i : i + 6, i : i + 6]",
    form="Return x, P: three numbers in the place of six, so x has n - 3 numbers, P has n - 3 rows and columns.",
    cases={
        "any": lambda rng: [case(rng, before, after) for before, after in ((7, 6), (3, 0), (0, 4), (2, 5))],
        "alone": lambda rng: [case(rng, 0, 0, scale) for scale in (1.0, 0.01)],
    },
    checks="""
    the point              | x | alone | The point is anchor + m / rho, in the place of the six numbers: x has n - 3 numbers, P has n - 3 rows and columns.
    the other states       | x | any   | The landmark x[i : i + 6] now stands among other states: the point takes its place, and all other numbers of x stay, in their order.
    alone in the map       | P | alone | P_l = [I, M_py / rho, -m / rho^2]: the covariance of the point is P_l P P_l'.
    covariance with the others | P | any | J P J' with J of the whole map: the landmark's rows and columns change by P_l; among the other states nothing changes, those behind it move up by three.
    """,
    wrong="""
    rho taken for the distance | a + m / rho -> a + m * rho | rho is one over the distance: the point is anchor + m / rho.
    anchor forgotten | a + m / rho -> m / rho | That is the way from the anchor to the point. Add the anchor.
    anchor divided, too | a + m / rho -> (a + m) / rho | Only the direction is divided by rho: anchor + m / rho.
    behind the anchor | a + m / rho -> a - m / rho | The direction points *from* the anchor to the point: plus, not minus.
    sign of the derivative by rho | -m / rho**2 -> m / rho**2 | A larger rho is a nearer point: d(m / rho) / d rho = -m / rho^2.
    rho taken as certain | -m / rho**2 -> 0 * m | rho is the most uncertain of the six: its column is -m / rho^2.
    rho not squared | -m / rho**2 -> -m / rho | d(1 / rho) / d rho = -1 / rho^2: the square is missing.
    column m | -m / rho**2 -> m | The derivative of m / rho by rho is -m / rho^2, not m.
    angles not scaled | M_py / rho -> M_py | The further the point, the more an angle moves it: M_py / rho.
    direction taken as certain | [np.eye(3), M_py / rho, -> [np.eye(3), 0 * M_py, | Pitch and yaw are uncertain, too: their block is M_py / rho.
    angles times rho | M_py / rho -> M_py * rho | The further the point, the more an angle moves it: M_py / rho, not M_py rho.
    anchor taken as certain | [np.eye(3), M_py -> [np.zeros((3, 3)), M_py | The anchor is a state like the others: its block is the identity.
    cross-covariances set to zero | J @ P @ J.T -> _alone(J @ P @ J.T, i) | The point keeps its correlations with robot and landmarks: J P J' of the *whole* map.
    cross-covariances not transformed | J @ P @ J.T -> _with_block(_only_cut(P, i), i, J @ P @ J.T) | The rows P_lm change like the landmark itself: P_l P_lm, not the first three of the old rows.
    P only cut | J @ P @ J.T -> _only_cut(P, i) | The covariance of a function of the state is J P J': cutting out three rows and columns is not enough.
    J applied once | J @ P @ J.T -> (J @ P)[:, : len(x) - 3] | A covariance is multiplied from both sides: J P J'.
    moved to the end | return x, P -> o = _last(x, i); return x[o], P[np.ix_(o, o)] | The point takes the place of the six numbers: the states behind it move up by three.
    pitch and yaw exchanged | py2vec(x[i + 3 : i + 5]) -> py2vec(x[i + 3 : i + 5][::-1]) | The landmark is [anchor; pitch; yaw; rho]: py2vec takes [pitch, yaw], in this order.
    pitch and yaw exchanged, in P_l, too: The landmark is [anchor; pitch; yaw; rho]: py2vec takes [pitch, yaw], in this order.
        py2vec(x[i + 3 : i + 5]) -> py2vec(x[i + 3 : i + 5][::-1])
        M_py / rho -> M_py[:, ::-1] / rho
    rho taken for the distance, in J, too: rho is one over the distance: the point is anchor + m / rho, and so are its derivatives.
        a + m / rho -> a + m * rho
        M_py / rho -> M_py * rho
        -m / rho**2 -> m
    anchor, angles and rho independent | J @ P @ J.T -> J @ (P * ~np.isin(np.add.outer(g := np.select([np.arange(len(P)) < i, np.arange(len(P)) < i + 3, np.arange(len(P)) < i + 5, np.arange(len(P)) < i + 6], [0, 1, 3, 9], 27), g), [4, 10, 12])) @ J.T | The numbers of one landmark are correlated: the whole 6 x 6 block goes through P_l.
    """,
)


@turned.link(
    "its own covariance",
    "In the new P the block of the point, P[i : i + 3, i : i + 3], is P_l P_ll P_l'.",
    1,
    before="covariance with the others",
)
def _(f, rng):
    for before, after in ((7, 6), (2, 5)):
        x, P, i = case(rng, before, after)
        s, n = slice(i, i + 3), len(x) - 3
        got = expect.array(expect.results(f(x, P, i), "x", "P")[1], (n, n), "P")
        expect.close(got[s, s], idp2euc(x, P, i)[1][s, s], "P of the point")
