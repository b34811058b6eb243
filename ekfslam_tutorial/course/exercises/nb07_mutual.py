"""Exercise 07.2: mutual nearest neighbours."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def mutual_nearest(D, limit):
    """Match measurements and landmarks that are each other's nearest.

    D, shape (k, n): squared Mahalanobis distances of k measurements to n landmarks; k and n may be 0.
    limit: the gate; a pair with a larger distance is none.
    Return j, shape (k,): for each measurement the index of its landmark, or -1. No landmark is used twice.
    """
    k, n = np.shape(D)
    j = np.full(k, -1)
    if n == 0:
        return j
    for i in range(k):
        near = np.argmin(D[i])
        if np.argmin(D[:, near]) == i and D[i, near] <= limit:
            j[i] = near
    return j


mutual = Exercise(
    "07.2",
    "Mutual nearest neighbours",
    mutual_nearest,
    hints=(
        "Each measurement has a nearest landmark (the least entry of its row), each landmark a nearest measurement "
        "(the least entry of its column).",
        "A pair (i, j) counts only if j is the best of row i *and* i is the best of column j, and D[i, j] is inside "
        "the gate.",
        "near = np.argmin(D[i]); accept if np.argmin(D[:, near]) == i and D[i, near] <= limit; all others stay -1.",
    ),
)


def _out(result, k):
    return expect.array(result, k, "j")


def _expected(D, limit):
    rows, columns = D == D.min(1, keepdims=True), D == D.min(0, keepdims=True)
    ok = rows & columns & (D <= limit)
    return np.where(ok.any(1), ok.argmax(1), -1)


def _is(f, D, limit, want, what):
    j = _out(f(np.array(D, float), limit), len(D))
    expect.true(np.array_equal(j, want), f"{what}: j must be {list(want)}, got {[round(float(v), 3) for v in j]}")


@mutual.link("shape", "One entry for each measurement.")
def _(f, rng):
    for k, n in ((3, 4), (4, 2), (1, 1)):
        _out(f(rng.uniform(0, 20, (k, n)), 9.2), k)


@mutual.link("clear pairs", "Each measurement near one landmark: take the least entry of its row.")
def _(f, rng):
    _is(f, [[50, 1, 60], [2, 70, 80], [40, 90, 3]], 9.2, [1, 0, 2], "three clear pairs")
    _is(f, [[50, 60, 1, 70], [80, 2, 90, 40]], 9.2, [2, 1], "two measurements, four landmarks")


@mutual.link("the gate", "The nearest landmark may still be too far: -1.")
def _(f, rng):
    D = [[1, 900, 900], [900, 12, 900], [900, 900, 500]]
    _is(f, D, 9.2, [0, -1, -1], "pairs at 1, 12 and 500, limit 9.2")
    _is(f, D, 13.8, [0, 1, -1], "pairs at 1, 12 and 500, limit 13.8")


@mutual.link("a landmark is used once", "Two measurements want the same landmark: only the nearer one gets it. The "
             "other has no claim to its second best.")  # fmt: skip
def _(f, rng):
    _is(f, [[4, 30], [1, 40]], 9.2, [-1, 0], "two measurements of one landmark")
    _is(f, [[2, 5, 6], [1, 40, 41]], 9.2, [-1, 0], "the loser's second best is inside the gate, too")


@mutual.link("two landmarks, one measurement", "The measurement goes to the nearer of the two landmarks.")
def _(f, rng):
    _is(f, [[4, 1]], 9.2, [1], "one measurement, two landmarks")


@mutual.link("nothing to match", "No landmark in the map, or no measurement: no pairs, and no error.")
def _(f, rng):
    _is(f, np.zeros((3, 0)), 9.2, [-1, -1, -1], "an empty map")
    _out(f(np.zeros((0, 3)), 9.2), 0)
    _is(f, [[0.5]], 9.2, [0], "one of each")


@mutual.link("many at random", "Rows and columns together: is each pair the least of its row and of its column?")
def _(f, rng):
    for k, n in ((5, 5), (3, 8), (8, 3), (6, 5)):
        D = rng.uniform(0, 15, (k, n))
        _is(f, D, 9.0, _expected(D, 9.0), f"{k} measurements, {n} landmarks")


def _from(D, limit, choose):
    k, n = np.shape(D)
    j = np.full(k, -1)
    if k and n:
        choose(np.asarray(D), limit, j)
    return j


def _wrong(name, hint):
    def add(choose):
        mutual.wrong(name, hint)(lambda D, limit: _from(D, limit, choose))
        return choose

    return add


@_wrong("each measurement for itself", "Two measurements may now get the same landmark. Ask the landmark, too: is this "
        "measurement its nearest?")  # fmt: skip
def _(D, limit, j):
    for i in range(len(D)):
        if D[i].min() <= limit:
            j[i] = D[i].argmin()


@_wrong("first come, first served", "The first measurement takes the landmark from a nearer one that comes later: the "
        "answer must not depend on the order.")  # fmt: skip
def _(D, limit, j):
    for i in range(len(D)):
        near = D[i].argmin()
        if D[i, near] <= limit and near not in j:
            j[i] = near


@_wrong("greedy, with the second best", "A measurement that has lost its landmark has no claim to the second best: it "
        "stays unmatched.")  # fmt: skip
def _(D, limit, j):
    used = set()
    for i, near in sorted(np.ndindex(*D.shape), key=lambda p: D[p]):
        if j[i] < 0 and near not in used and D[i, near] <= limit:
            j[i] = near
            used.add(near)


@_wrong("no gate", "The nearest may be far away: compare with the limit.")
def _(D, limit, j):
    for i in range(len(D)):
        if D[:, D[i].argmin()].argmin() == i:
            j[i] = D[i].argmin()


@_wrong("each landmark for itself", "Each landmark has taken its nearest measurement. Ask the measurement, too: is "
        "this landmark its nearest?")  # fmt: skip
def _(D, limit, j):
    for near in range(D.shape[1]):
        i = D[:, near].argmin()
        if D[i, near] <= limit:
            j[i] = near


@_wrong(
    "the limit squared", "D holds squared distances, and the limit is for squared distances: compare them directly."
)
def _(D, limit, j):
    for i in range(len(D)):
        near = D[i].argmin()
        if D[:, near].argmin() == i and D[i, near] <= limit**2:
            j[i] = near


@_wrong(
    "the root of the limit",
    "The limit is for squared distances already, such as 9.2: compare D with it, without a root.",
)
def _(D, limit, j):
    for i in range(len(D)):
        near = D[i].argmin()
        if D[:, near].argmin() == i and D[i, near] <= np.sqrt(limit):
            j[i] = near


@_wrong("furthest", "Near means a *small* distance: argmin.")
def _(D, limit, j):
    for i in range(len(D)):
        near = D[i].argmax()
        if D[:, near].argmax() == i:
            j[i] = near


@_wrong("landmarks instead of measurements", "j has one entry for each *measurement*: which landmark it belongs to.")
def _(D, limit, j):
    for i in range(len(D)):
        near = D[i].argmin()
        if D[:, near].argmin() == i and D[i, near] <= limit and near < len(j):
            j[near] = i


@mutual.wrong("None for no pair", "A measurement without a landmark gets the number -1, not None.")
def _(D, limit):
    j = _from(D, limit, lambda D, limit, j: j.__setitem__(slice(None), _expected(D, limit)))
    return [None if a < 0 else int(a) for a in j]


@mutual.wrong("fails on an empty map", "At the start there is no landmark: D has the shape (k, 0), and argmin has "
              "nothing to choose from.")  # fmt: skip
def _(D, limit):
    near, back = D.argmin(1), D.argmin(0)
    return np.array([a if back[a] == i and D[i, a] <= limit else -1 for i, a in enumerate(near)])


@mutual.variant("with masks, list")
def _(D, limit):
    D = np.asarray(D)
    return _expected(D, limit).tolist() if D.size else [-1] * len(D)


@mutual.variant("loops over all pairs")
def _(D, limit):
    k, n = len(D), len(D[0]) if len(D) else 0
    j = []
    for i in range(k):
        best = -1
        for a in range(n):
            row = all(D[i][a] <= D[i][b] for b in range(n))
            if row and all(D[i][a] <= D[c][a] for c in range(k)) and D[i][a] <= limit:
                best = a
        j.append(best)
    return j
