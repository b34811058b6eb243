"""Exercise 13.3: an inverse-depth landmark becomes a Euclidean point, and the whole map follows."""

import numpy as np

from ...models.landmarks import IdpPnt
from ...models.landmarks.idp_pnt import py2vec
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def idp2euc(x, P, i):
    """Turn one inverse-depth landmark of the map into a Euclidean point.

    x, shape (n,), and P, shape (n, n), are the whole map. x[i : i + 6] = [anchor; pitch; yaw; rho] is the landmark.
    `py2vec(py)` returns m, M_py: the unit direction, shape (3,), and its Jacobian by [pitch, yaw], shape (3, 2).
    The point is anchor + m / rho. It takes the place of the six numbers; nothing else moves.
    Return the new x, shape (n - 3,), and the new P, shape (n - 3, n - 3).
    """
    l = x[i : i + 6]
    m, M_py = py2vec(l[3:5])
    p = l[:3] + m / l[5]
    P_l = np.column_stack([np.eye(3), M_py / l[5], -m / l[5] ** 2])
    J = np.zeros((len(x) - 3, len(x)))
    J[:i, :i] = np.eye(i)
    J[i : i + 3, i : i + 6] = P_l
    J[i + 3 :, i + 6 :] = np.eye(len(x) - i - 6)
    return np.concatenate([x[:i], p, x[i + 6 :]]), J @ P @ J.T


turned = Exercise(
    "13.3",
    "From inverse depth to a Euclidean point",
    idp2euc,
    hints=(
        "First the point. Then its Jacobian by the six numbers, three blocks of columns: anchor, angles, rho.",
        "P_l = [I, M_py / rho, -m / rho^2], shape (3, 6). The other states are copied: identity blocks around it.",
        "J is block diagonal: I (i), P_l, I (the rest). The new covariance of the whole map is J P J'.",
    ),
)


def case(rng, before=7, after=6, scale=1.0):
    """A map with the landmark between other states, all correlated; and the place of the landmark."""
    l = np.array([*rng.uniform(-3, 3, 3), rng.uniform(-1, 1), rng.uniform(-3, 3), rng.uniform(0.1, 0.8)])
    x = np.concatenate([rng.uniform(-2, 2, before), l, rng.uniform(-2, 2, after)])
    return x, random_covariance(rng, len(x), scale), before


def _map(result, n):
    x, P = expect.results(result, "x", "P")
    return expect.array(x, n, "x"), expect.array(P, (n, n), "P")


@turned.link("sizes", "Six numbers become three: x has n - 3 numbers, P has n - 3 rows and columns.")
def _(f, rng):
    for before, after in ((7, 6), (0, 0)):
        _map(f(*case(rng, before, after)), before + after + 3)


@turned.link("the point", "The point is anchor + m / rho, in the place of the six numbers.", part=0)
def _(f, rng):
    for before, after in ((0, 0), (7, 6), (3, 0), (0, 4)):
        x, P, i = case(rng, before, after)
        got = _map(f(x, P, i), len(x) - 3)[0]
        expect.close(got[i : i + 3], IdpPnt().point(x[i : i + 6])[0], "the point", at=f"i = {i}")


@turned.link("the other states", "All other numbers of x stay, in their order.", part=0)
def _(f, rng):
    for before, after in ((7, 6), (3, 0), (0, 4)):
        x, P, i = case(rng, before, after)
        expect.close(_map(f(x, P, i), len(x) - 3)[0], idp2euc(x, P, i)[0], "x", at=f"i = {i}")


@turned.link(
    "alone in the map", "P_l = [I, M_py / rho, -m / rho^2]: the covariance of the point is P_l P P_l'.", part=1
)
def _(f, rng):
    for scale in (1.0, 0.01):
        x, P, i = case(rng, 0, 0, scale)
        expect.close(_map(f(x, P, i), 3)[1], idp2euc(x, P, i)[1], "P of the point")


@turned.link("its own covariance", "The block of the landmark alone: P_l P_ll P_l'.", part=1)
def _(f, rng):
    for before, after in ((7, 6), (2, 5)):
        x, P, i = case(rng, before, after)
        s = slice(i, i + 3)
        expect.close(_map(f(x, P, i), len(x) - 3)[1][s, s], idp2euc(x, P, i)[1][s, s], "P of the point")


@turned.link("covariance with the others", "Rows and columns of the landmark change by the same Jacobian.", part=1)
def _(f, rng):
    for before, after in ((7, 6), (3, 0), (0, 4)):
        x, P, i = case(rng, before, after)
        got = _map(f(x, P, i), len(x) - 3)[1]
        expect.close(got, idp2euc(x, P, i)[1], "P", at=f"i = {i}")
        expect.symmetric(got, "P", 1e-7)


def _jacobian(x, i, P_l):
    """The Jacobian of the whole map, with the block P_l."""
    J = np.zeros((len(x) - 3, len(x)))
    J[:i, :i], J[i : i + 3, i : i + 6], J[i + 3 :, i + 6 :] = np.eye(i), P_l, np.eye(len(x) - i - 6)
    return J


def _blocks(l):
    m, M_py = py2vec(l[3:5])
    return m, M_py, l[5]


def _wrong_x(name, hint, point):
    """A misconception in the point: point(anchor, m, rho)."""

    @turned.wrong(name, hint)
    def _(x, P, i):
        l = x[i : i + 6]
        m, _, rho = _blocks(l)
        return np.concatenate([x[:i], point(l[:3], m, rho), x[i + 6 :]]), idp2euc(x, P, i)[1]


def _wrong_P(name, hint, P_l=None, change=None):
    """A misconception in the Jacobian P_l(m, M_py, rho), or in what is made with it, change(J, P, i)."""

    @turned.wrong(name, hint)
    def _(x, P, i):
        m, M_py, rho = _blocks(x[i : i + 6])
        block = P_l(m, M_py, rho) if P_l else np.column_stack([np.eye(3), M_py / rho, -m / rho**2])
        J = _jacobian(x, i, block)
        return idp2euc(x, P, i)[0], change(J, P, i) if change else J @ P @ J.T


I3, stack = np.eye(3), np.column_stack
# fmt: off
_wrong_x("rho taken for the distance", "rho is one over the distance: the point is anchor + m / rho.",
         lambda a, m, rho: a + m * rho)
_wrong_x("anchor forgotten", "That is the way from the anchor to the point. Add the anchor.", lambda a, m, rho: m / rho)
_wrong_x("anchor divided, too", "Only the direction is divided by rho: anchor + m / rho.",
         lambda a, m, rho: (a + m) / rho)
_wrong_x("behind the anchor", "The direction points *from* the anchor to the point: plus, not minus.",
         lambda a, m, rho: a - m / rho)
_wrong_P("sign of the derivative by rho", "A larger rho is a nearer point: d(m / rho) / d rho = -m / rho^2.",
         lambda m, M, rho: stack([I3, M / rho, m / rho**2]))
_wrong_P("rho taken as certain", "rho is the most uncertain of the six: its column is -m / rho^2.",
         lambda m, M, rho: stack([I3, M / rho, 0 * m]))
_wrong_P("rho not squared", "d(1 / rho) / d rho = -1 / rho^2: the square is missing.",
         lambda m, M, rho: stack([I3, M / rho, -m / rho]))
_wrong_P("column m", "The derivative of m / rho by rho is -m / rho^2, not m.",
         lambda m, M, rho: stack([I3, M / rho, m]))
_wrong_P("angles not scaled", "The further the point, the more an angle moves it: M_py / rho.",
         lambda m, M, rho: stack([I3, M, -m / rho**2]))
_wrong_P("angles times rho", "The further the point, the more an angle moves it: M_py / rho, not M_py rho.",
         lambda m, M, rho: stack([I3, M * rho, -m / rho**2]))
_wrong_P("anchor taken as certain", "The anchor is a state like the others: its block is the identity.",
         lambda m, M, rho: stack([0 * I3, M / rho, -m / rho**2]))
_wrong_P("cross-covariances set to zero", "The point keeps its correlations with robot and landmarks: J P J' of the "
         "*whole* map.", change=lambda J, P, i: _alone(J @ P @ J.T, i))
_wrong_P("cross-covariances not transformed", "The rows P_lm change like the landmark itself: P_l P_lm, not the first "
         "three of the old rows.", change=lambda J, P, i: _old_rows(J, P, i))
_wrong_P("P only cut", "The covariance of a function of the state is J P J': cutting out three rows and columns is not "
         "enough.", change=lambda J, P, i: np.delete(np.delete(P, range(i + 3, i + 6), 0), range(i + 3, i + 6), 1))
# fmt: on


def _alone(P, i):
    block = P[i : i + 3, i : i + 3].copy()
    P[i : i + 3], P[:, i : i + 3] = 0, 0
    P[i : i + 3, i : i + 3] = block
    return P


def _old_rows(J, P, i):
    out = np.delete(np.delete(P, range(i + 3, i + 6), 0), range(i + 3, i + 6), 1)
    out[i : i + 3, i : i + 3] = (J @ P @ J.T)[i : i + 3, i : i + 3]
    return out


@turned.wrong(
    "moved to the end", "The point takes the place of the six numbers: the states behind it move up by three."
)
def _(x, P, i):
    x, P = idp2euc(x, P, i)
    order = [*range(i), *range(i + 3, len(x)), *range(i, i + 3)]
    return x[order], P[np.ix_(order, order)]


@turned.variant("with the package's point")
def _(x, P, i):
    p, P_l = IdpPnt().point(np.asarray(x)[i : i + 6])
    rest = [k for k in range(len(x)) if not i <= k < i + 6]
    P_pm = P_l @ P[i : i + 6]
    out = np.insert(np.insert(P[np.ix_(rest, rest)], [i] * 3, 0, 0), [i] * 3, 0, 1)
    places = [k if k < i else k - 3 for k in rest]
    out[i : i + 3, places] = P_pm[:, rest]
    out[places, i : i + 3] = P_pm[:, rest].T
    out[i : i + 3, i : i + 3] = P_pm[:, i : i + 6] @ P_l.T
    return [*x[:i], *p, *x[i + 6 :]], out


@turned.variant("by central differences")
def _(x, P, i):
    def g(x):
        p, t, rho = x[i + 3], x[i + 4], x[i + 5]
        m = np.array([np.cos(p) * np.cos(t), np.cos(p) * np.sin(t), np.sin(p)])
        return np.concatenate([x[:i], x[i : i + 3] + m / rho, x[i + 6 :]])

    J = np.array([(g(x + 1e-6 * d) - g(x - 1e-6 * d)) / 2e-6 for d in np.eye(len(x))]).T
    return g(x), J @ P @ J.T
