"""Exercise 19.2: what to do with each detection of a scan: use it, start a tree, or leave it alone."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def sort_scan(D, gate, new_gate):
    """Decide about each detection of a scan: which tree it is, a new tree, or none of both.

    D, shape (k, n): squared Mahalanobis distances of k detections to n trees in the map; k and n may be 0.
    gate < new_gate: two limits of the squared distance.
    Return j, shape (k,), whole numbers: the index of its tree, if the two are each other's nearest and the distance is
    at most gate; -1, a new tree, if it is further than new_gate from every tree; -2, not used, in all other cases.
    """
    k, n = D.shape
    j = np.full(k, -2)
    j[D.min(axis=1, initial=np.inf) > new_gate] = -1
    if k and n:
        best, back = D.argmin(axis=1), D.argmin(axis=0)
        own = (back[best] == np.arange(k)) & (D[np.arange(k), best] <= gate)
        j[own] = best[own]
    return j


scan = Exercise(
    "19.2",
    "Tree, new tree, or neither",
    sort_scan,
    hints=(
        "Three answers, so three conditions. Which of them need the other detections of the scan, too?",
        "nearest = D.argmin(axis=1) and back = D.argmin(axis=0): the pair (i, nearest[i]) is mutual where "
        "back[nearest[i]] == i. New needs no partner: D.min(axis=1) > new_gate. All the rest stays -2.",
        "A detection that has lost its tree to a nearer detection is within the gate of a tree: neither its second "
        "best, "
        "nor new. With no tree in the map every detection is new; D.min(axis=1, initial=np.inf) does that, too.",
    ),
)


def case(rng, k=6, n=9):
    """Return distances from 0.1 to 1000, with some pairs that are near."""
    return np.exp(rng.uniform(-2, 7, (k, n)))


CASES = ((6, 9), (9, 4), (1, 1), (7, 7), (12, 2))


def _j(result, k):
    return expect.array(result, k, "j")


def _same(got, want, at):
    """Compare labels. They are no quantities: -1 instead of -2 is not half as much."""
    given, wanted = (", ".join(f"{v:g}" for v in j) for j in (got, want))
    expect.true(np.array_equal(got, want), f"j is [{given}] for {at}, it should be [{wanted}].")


@scan.link("one number for each detection", "Return j with one whole number for each row of D.")
def _(f, rng):
    for k, n in CASES:
        _j(f(case(rng, k, n), 9.2, 25.0), k)


@scan.link("by hand", "One detection, one tree: near, far, and in between.")
def _(f, rng):
    for d, want in ((1.0, 0), (9.0, 0), (12.0, -2), (24.0, -2), (26.0, -1), (900.0, -1)):
        got = _j(f(np.array([[d]]), 9.2, 25.0), 1)
        _same(got, [want], f"a distance of {d} and the limits 9.2 and 25")


@scan.link("empty", "A map without trees: all are new. A scan without detections: no numbers.")
def _(f, rng):
    _same(_j(f(np.zeros((3, 0)), 9.2, 25.0), 3), [-1, -1, -1], "a map without trees")
    _j(f(np.zeros((0, 5)), 9.2, 25.0), 0)


@scan.link("nearest", "The index of the tree with the least distance.")
def _(f, rng):
    D = np.array([[400.0, 2.0, 90.0], [1.0, 300.0, 80.0], [70.0, 60.0, 50.0]])
    _same(_j(f(D, 9.2, 25.0), 3), [1, 0, -1], "D = [[400, 2, 90], [1, 300, 80], [70, 60, 50]]")


@scan.link("two detections, one tree", "The nearer one gets it. The other is too near to a tree to be new: not used.")
def _(f, rng):
    D = np.array([[3.0, 400.0, 8.0], [1.0, 300.0, 500.0], [6.0, 700.0, 600.0]])
    _same(_j(f(D, 9.2, 25.0), 3), [-2, 0, -2], "D = [[3, 400, 8], [1, 300, 500], [6, 700, 600]]")


@scan.link("new is far from all", "One near tree is enough: then it is not new.")
def _(f, rng):
    D = np.array([[400.0, 12.0, 700.0], [30.0, 500.0, 26.0], [24.0, 900.0, 800.0]])
    _same(_j(f(D, 9.2, 25.0), 3), [-2, -1, -2], "D = [[400, 12, 700], [30, 500, 26], [24, 900, 800]]")


@scan.link("many scans", "Try your function on paper with a small D.")
def _(f, rng):
    for _ in range(12):
        k, n = int(rng.integers(1, 9)), int(rng.integers(1, 9))
        D, gate = case(rng, k, n), rng.uniform(2, 20)
        new = gate * rng.uniform(1.5, 20)
        got = _j(f(D, gate, new), k)
        _same(got, sort_scan(D, gate, new), f"k = {k}, n = {n}, limits {gate:.1f} and {new:.1f}")
        used = got[got >= 0]
        expect.true(len(set(used.tolist())) == len(used), "two detections have the same tree")


def _wrong(name, hint, answer):
    scan.wrong(name, hint)(answer)


def _loop(rule):
    """An answer from a rule(i, D, gate, new_gate) for one detection; no trees: all new."""

    def answer(D, gate, new_gate):
        if not D.size:
            return np.full(len(D), -1)
        return np.array([rule(i, D, gate, new_gate) for i in range(len(D))])

    return answer


def _mutual(i, D):
    return D[:, D[i].argmin()].argmin() == i


def _greedy(D, gate, new_gate):
    """Each detection in turn takes the nearest tree that is free."""
    j, taken = np.full(len(D), -2), set()
    for i, row in enumerate(D):
        if not len(row) or row.min() > new_gate:
            j[i] = -1
            continue
        for t in np.argsort(row):
            if row[t] <= gate and int(t) not in taken:
                j[i] = t
                taken.add(int(t))
                break
    return j


def _second_best(D, gate, new_gate):
    """Pairs by distance: the best pair first, then the best of what is left."""
    j = np.where(D.min(axis=1, initial=np.inf) > new_gate, -1, -2)
    E = D.copy()
    while E.size and E.min() <= gate:
        i, t = np.unravel_index(E.argmin(), E.shape)
        j[i] = t
        E[i], E[:, t] = np.inf, np.inf
    return j


# fmt: off
_wrong("each its nearest", "Two detections have taken the same tree. A pair counts only if each is the other's "
       "nearest.",
       _loop(lambda i, D, g, n: D[i].argmin() if D[i].min() <= g else -1 if D[i].min() > n else -2))
_wrong("one limit", "Between the two gates a detection is used for nothing: it may be a known tree that is a bit off, "
       "and "
       "a double of it does much harm.",
       _loop(lambda i, D, g, n: D[i].argmin() if D[i].min() <= g and _mutual(i, D) else -1 if D[i].min() > g else -2))
_wrong("whoever lost is new", "A detection that has lost its tree is near to one: not used, and not new.",
       _loop(lambda i, D, g, n: D[i].argmin() if D[i].min() <= g and _mutual(i, D) else
             -1 if D[i].min() > n or D[i].min() <= g else -2))
_wrong("all that is not matched is new", "New is only what is further than new_gate from *every* tree.",
       _loop(lambda i, D, g, n: D[i].argmin() if D[i].min() <= g and _mutual(i, D) else -1))
_wrong("new if far from one", "New is what is far from *every* tree: the least distance counts, not the largest.",
       _loop(lambda i, D, g, n: D[i].argmin() if D[i].min() <= g and _mutual(i, D) else -1 if D[i].max() > n else -2))
_wrong("gate of new trees for pairs", "A pair must be within the inner gate.",
       _loop(lambda i, D, g, n: -1 if D[i].min() > n else D[i].argmin() if _mutual(i, D) else -2))
_wrong("distances taken as not squared", "D holds squared distances, and the limits are squared, too.",
       lambda D, gate, new_gate: sort_scan(D, gate**2, new_gate**2))
_wrong("first come, first served", "Who comes first in the scan is chance. The two must be each other's "
       "nearest.", _greedy)
_wrong("second best", "A detection that has lost its nearest tree has no claim to another: that is wrong even more "
       "surely.",
       _second_best)
_wrong("new and unused exchanged", "-1 is a new tree, -2 is not used.",
       lambda D, gate, new_gate: np.where(sort_scan(D, gate, new_gate) < 0, -3 - sort_scan(D, gate, new_gate),
                                          sort_scan(D, gate, new_gate)))
_wrong("trees instead of detections", "One number for each *detection*, a row of D, not for each tree.",
       lambda D, gate, new_gate: sort_scan(D.T, gate, new_gate))
_wrong("counted from 1", "The first tree has the index 0.",
       lambda D, gate, new_gate: sort_scan(D, gate, new_gate) + (sort_scan(D, gate, new_gate) >= 0))
_wrong("never new", "A map must grow: further than new_gate from every tree is a new one.",
       lambda D, gate, new_gate: np.where(sort_scan(D, gate, new_gate) == -1, -2, sort_scan(D, gate, new_gate)))
# fmt: on


@scan.variant("a loop, a list")
def _(D, gate, new_gate):
    out = []
    for i, row in enumerate(D):
        if not len(row) or min(row) > new_gate:
            out.append(-1)
            continue
        t = min(range(len(row)), key=lambda c: row[c])
        rival = min(range(len(D)), key=lambda r: D[r][t])
        out.append(t if rival == i and row[t] <= gate else -2)
    return out


@scan.variant("as a mask, numbers with a point")
def _(D, gate, new_gate):
    k, n = D.shape
    if not D.size:
        return -np.ones(k)
    ok = (D == D.min(axis=1, keepdims=True)) & (D == D.min(axis=0, keepdims=True)) & (D <= gate)
    return np.where(ok.any(1), ok.argmax(1), np.where((D > new_gate).all(1), -1.0, -2.0))
