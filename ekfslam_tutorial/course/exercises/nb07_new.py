"""Exercise 07.4: which measurements may start a landmark? With a bearing, behind the robot, too."""

import numpy as np
from scipy.stats import chi2

from ...geometry import wrap
from .. import expect
from ..exercise import Exercise
from .nb04_blocks import random_covariance


def new_ones(ys, es, Es, R, confidence):
    """Which measurements are far from every landmark in the map, and so may start a new one?

    ys, shape (k, 2): measurements [range, bearing]. R, shape (2, 2): their noise.
    es, shape (n, 2), and Es, shape (n, 2, 2): expectation of each landmark in the map, and its covariance; n may be 0.
    confidence: the gate of new landmarks; a measurement outside of *all* n gates is new.
    Return the list of the indices of the new ones; and D, shape (k, n), the squared Mahalanobis distances.
    """
    D = np.zeros((len(ys), len(es)))
    for i, y in enumerate(ys):
        for j, (e, E) in enumerate(zip(es, Es, strict=True)):
            z = np.array([y[0] - e[0], wrap(y[1] - e[1])])
            D[i, j] = z @ np.linalg.solve(E + R, z)
    limit = chi2.ppf(confidence, 2)
    return [i for i in range(len(ys)) if all(D[i] > limit)], D


new = Exercise(
    "07.4",
    "New landmarks",
    new_ones,
    hints=(
        "First the table D: each measurement against each expectation. What is the covariance of y - e?",
        "z = y - e with the bearing wrapped, Z = E + R. A measurement is new if its whole row of D is beyond the gate.",
        "z = [y[0] - e[0], wrap(y[1] - e[1])], D[i, j] = z' inv(E_j + R) z; new if all(D[i] > limit), with the limit "
        "chi2.ppf(confidence, 2). For an empty map every measurement is new: all([]) is True.",
    ),
)
FAR = 1 - 1e-6


def _case(rng, k, n, scale=1.0):
    es = np.column_stack([rng.uniform(2, 9, n), rng.uniform(-1.2, 1.2, n)])
    ys = np.column_stack([rng.uniform(2, 9, k), rng.uniform(-1.2, 1.2, k)])
    Es = np.array([random_covariance(rng, 2, 0.02 * scale) for _ in range(n)]).reshape(n, 2, 2)
    return ys, es, Es, random_covariance(rng, 2, 0.02 * scale)


def _out(result, k, n):
    found, D = expect.results(result, "new", "D")
    found = expect.array(found, np.shape(found), "the list of the new ones") if np.size(found) else np.zeros(0)
    expect.true(found.ndim == 1, "the first result must be the list of the indices of the new measurements")
    return [float(i) for i in found], expect.array(D, (k, n), "D")


def _truth(ys, es, Es, R):
    D = np.zeros((len(ys), len(es)))
    for i in range(len(ys)):
        for j in range(len(es)):
            z = ys[i] - es[j]
            z[1] = np.arctan2(np.sin(z[1]), np.cos(z[1]))
            w = np.linalg.solve(np.linalg.cholesky(Es[j] + R), z)
            D[i, j] = w @ w
    return D


def _is_new(f, args, confidence, what):
    k, n = len(args[0]), len(args[1])
    D = _truth(*args)
    want = [i for i in range(k) if (D[i] > chi2.ppf(confidence, 2)).all()]
    got, table = _out(f(*args, confidence), k, n)
    expect.true(got == want, f"{what}: the new ones are {want}, got {[int(i) if i == int(i) else i for i in got]}")
    return table, D


@new.link("two results", "End with `return new, D`: a list of indices and a table of k x n distances.")
def _(f, rng):
    for k, n in ((3, 4), (2, 1)):
        _out(f(*_case(rng, k, n), FAR), k, n)


@new.link("the distances", "D[i, j] = z' inv(Z) z, with z = y_i - e_j and Z = E_j + R.", part=1)
def _(f, rng):
    for k, n, scale in ((3, 4, 1.0), (5, 2, 0.01), (1, 1, 5.0)):
        args = _case(rng, k, n, scale)
        expect.close(_out(f(*args, FAR), k, n)[1], _truth(*args), "D")


@new.link("behind the robot", "At +-pi the difference of two bearings jumps by 2 pi: wrap it, here, too.", part=1)
def _(f, rng):
    for side, turns in ((1, 0), (-1, 0), (1, 1), (-1, -2)):
        es = np.array([[4.0, side * (np.pi - 0.02)], [5.0, 0.3]])
        ys = np.array([[4.05, -side * (np.pi - 0.01) + 2 * np.pi * turns], [5.0, 0.32 - 2 * np.pi]])
        args = ys, es, np.array([0.01 * np.eye(2)] * 2), np.diag([0.01, 0.001])
        got, D = _out(f(*args, FAR), 2, 2)[1], _truth(*args)
        expect.close(got[:, 0], D[:, 0], "the distance to a landmark straight behind", 1e-4)
        expect.close(got, D, "D")


@new.link("the range is no angle", "Wrap the bearing only: ranges may differ by more than pi metres.", part=1)
def _(f, rng):
    args = np.array([[9.0, 0.1]]), np.array([[2.0, 0.1]]), np.array([np.eye(2)]), 0.1 * np.eye(2)
    expect.close(_out(f(*args, 0.9), 1, 1)[1], _truth(*args), "D of two ranges that differ by 7 m")


@new.link("new is far from all", "A measurement is new if *every* landmark is too far, not if one of them is.", part=0)
def _(f, rng):
    es = np.array([[3.0, 0.0], [6.0, 0.5], [6.0, -0.5]])
    ys = np.array([[3.05, 0.01], [8.0, 1.0], [6.0, -0.48], [3.0, 2.5]])
    args = ys, es, np.array([0.01 * np.eye(2)] * 3), np.diag([0.01, 0.001])
    _is_new(f, args, FAR, "measurements 0 and 2 at landmarks, 1 and 3 far from all")
    _is_new(f, (ys[:1], *args[1:]), FAR, "one measurement at a landmark")


@new.link("an empty map", "At the start there is no landmark: every measurement is new, and D has no columns.")
def _(f, rng):
    ys = np.array([[3.0, 0.1], [4.0, -0.2]])
    _is_new(f, (ys, np.zeros((0, 2)), np.zeros((0, 2, 2)), np.eye(2)), FAR, "an empty map")


@new.link("the gate", "The limit is chi2.ppf(confidence, 2): what is between is neither old nor new.", part=0)
def _(f, rng):
    for confidence in (FAR, 0.99):
        k = np.sqrt(chi2.ppf(confidence, 2)) * np.array([0.97, 1.03])
        ys = np.column_stack([5 + 0.2 * k, [0.3, 0.3]])
        args = ys, np.array([[5.0, 0.3]]), np.array([np.diag([0.03, 0.001])]), np.diag([0.01, 0.001])
        _is_new(f, args, confidence, f"{k[0]:.2f} and {k[1]:.2f} sigma, confidence {confidence:g}")


@new.link(
    "behind the robot, as a whole", "A landmark straight behind is in the map already: it must not be born again."
)
def _(f, rng):
    y = np.column_stack([np.full(40, 4.0) + 0.05 * rng.normal(size=40), np.pi + 0.03 * rng.normal(size=40)])
    args = (
        wrap(y) + np.array([0.0, 0.0]),
        np.array([[4.0, np.pi]]),
        np.array([0.001 * np.eye(2)]),
        np.diag([0.0025, 0.0009]),
    )
    args[0][:, 0] = y[:, 0]
    _is_new(f, args, FAR, "40 measurements of one landmark straight behind")


def _plain(y, e):
    return np.array([y[0] - e[0], wrap(y[1] - e[1])])


def _wrong(name, hint, z=_plain, Z=lambda E, R: E + R, d=None, rule=None, limit=lambda c: chi2.ppf(c, 2)):
    @new.wrong(name, hint)
    def _(ys, es, Es, R, confidence):
        d2 = d or (lambda a, S: a @ np.linalg.solve(S, a))
        D = np.array([[d2(z(y, e), Z(E, R)) for e, E in zip(es, Es, strict=True)] for y in ys]).reshape(
            len(ys), len(es)
        )
        far = D > limit(confidence)
        return (np.flatnonzero(far.all(1)).tolist() if rule is None else rule(far, D)), D


# fmt: off
_wrong("bearing not wrapped", "A landmark straight behind is expected at +179 degrees and measured at -179: wrap the "
       "difference, or it is created again and again.", z=lambda y, e: y - e)
_wrong("range wrapped, too", "Only the bearing is an angle: do not wrap the range.", z=lambda y, e: wrap(y - e))
_wrong("bearings wrapped one by one", "Wrap the *difference*: two wrapped bearings can still differ by almost 2 pi.",
       z=lambda y, e: np.array([y[0] - e[0], wrap(y[1]) - wrap(e[1])]))
_wrong("absolute values of the bearings", "Left behind and right behind are not the same: wrap the difference.",
       z=lambda y, e: np.array([y[0] - e[0], np.abs(wrap(y[1])) - np.abs(wrap(e[1]))]))
_wrong("R forgotten", "y has noise, too: the covariance of y - e is E + R.", Z=lambda E, R: E)
_wrong("E forgotten", "The expectation is uncertain, too: the covariance of y - e is E + R.", Z=lambda E, R: R)
_wrong("Euclidean distance", "Range and bearing have different units and sigmas: use z' inv(Z) z.",
       d=lambda z, Z: z @ z)
_wrong("not squared", "The limit is for the squared distance: no root.",
       d=lambda z, Z: np.sqrt(z @ np.linalg.solve(Z, z)))
_wrong("diagonal of Z", "Use the whole Z: range and bearing may be correlated.",
       d=lambda z, Z: np.sum(z**2 / np.diag(Z)))
_wrong("far from one is enough", "Almost every measurement is far from some landmark. New means far from *all*.",
       rule=lambda far, D: np.flatnonzero(far.any(1) | (far.shape[1] == 0)).tolist())
_wrong("the old ones", "These are the measurements near a landmark: return the others.",
       rule=lambda far, D: np.flatnonzero(~far.all(1)).tolist())
_wrong("True and False", "Return the list of the indices, for instance [1, 3].",
       rule=lambda far, D: far.all(1).tolist())
_wrong("the measurements themselves", "Return indices, counted from 0; not how many there are.",
       rule=lambda far, D: [int(far.all(1).sum())])
_wrong("one degree of freedom", "Two numbers are compared: chi2 with 2 degrees of freedom.",
       limit=lambda c: chi2.ppf(c, 1))
_wrong("other tail", "chi2.ppf(confidence, 2), not of 1 - confidence.", limit=lambda c: chi2.ppf(1 - c, 2))
# fmt: on


@new.variant("all at once, with einsum")
def _(ys, es, Es, R, confidence):
    z = np.asarray(ys)[:, None] - np.asarray(es)[None]
    z[..., 1] = (z[..., 1] + np.pi) % (2 * np.pi) - np.pi
    D = np.einsum("kni,nij,knj->kn", z, np.linalg.inv(Es + R), z)
    return np.flatnonzero(D.min(1, initial=np.inf) > chi2.ppf(confidence, 2)), D


@new.variant("loops, lists, probabilities")
def _(ys, es, Es, R, confidence):
    if not len(es):
        return list(range(len(ys))), np.zeros((len(ys), 0))
    D = []
    for y in ys:
        zs = [_plain(y, e) for e in es]
        D.append([float(z @ np.linalg.inv(E + R) @ z) for z, E in zip(zs, Es, strict=True)])
    return [i for i, row in enumerate(D) if min(row) > chi2.ppf(confidence, 2)], D
