"""Exercise 19.2: what to do with each detection of a scan: use it, start a tree, or leave it alone."""

import numpy as np

from .. import expect
from ..table import table


def sort_scan(D, gate, new_gate):
    """Decide about each detection of a scan: which tree it is, a new tree, or neither.

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


def some(rng):
    """Distances from 0.1 to 1000, with some pairs that are near, and two limits."""
    gate = rng.uniform(2, 20)
    return np.exp(rng.uniform(-2, 7, rng.integers(1, 9, 2))), gate, gate * rng.uniform(1.5, 20)


def scans(*tables):
    """Return the case of these distances, with the limits 9.2 and 25."""
    return lambda rng: [(np.array(D, float), 9.2, 25.0) for D in tables]


scan = table(
    "19.2 Tree, new tree, or neither",
    sort_scan,
    hints=(
        "Three answers, so three conditions. Which of them need the other detections of the scan, too?",
        "nearest = D.argmin(axis=1) and back = D.argmin(axis=0): the pair (i, nearest[i]) is mutual where back[nearest[i]] == i. New needs no partner: D.min(axis=1) > new_gate. All the rest stays -2.",
        "A detection that has lost its tree to a nearer detection is within the gate of a tree: neither its second best, nor new. With no tree in the map every detection is new; D.min(axis=1, initial=np.inf) does that, too.",
    ),
    returns="j",
    form="Return j with one whole number for each row of D.",
    cases={"any": lambda rng: [some(rng) for _ in range(5)]},
    checks="",
    wrong="""
    each its nearest | (back[best] == np.arange(k)) & (D -> (D | Two detections have taken the same tree. A pair counts only if each is the other's nearest.
    one limit | > new_gate -> > gate | Between the two gates a detection is used for nothing: it may be a known tree that is a bit off, and a double of it does much harm.
    whoever lost is new | j[own] = best[own] -> j[D.min(axis=1) <= gate] = -1; j[own] = best[own] | A detection that has lost its tree is near to one: not used, and not new.
    all that is not matched is new | np.full(k, -2) -> np.full(k, -1) | New is only what is further than new_gate from *every* tree.
    new if far from one | D.min(axis=1, initial=np.inf) -> (D.max(axis=1) if n else np.full(k, np.inf)) | New is what is far from *every* tree: the least distance counts, not the largest.
    gate of new trees for pairs | <= gate) -> <= new_gate) | A pair must be within the inner gate.
    distances taken as not squared | k, n = D.shape -> gate, new_gate = gate**2, new_gate**2; k, n = D.shape | D holds squared distances, and the limits are limits of these: compare them as they are, no square and no root.
    first come, first served | return j -> return _greedy(D, gate, j) | Who comes first in the scan is chance. The two must be each other's nearest.
    nearest of the tree alone | return j -> return _trees_choose(D, gate, j) | A tree has taken its nearest detection, to which another tree is nearer. Each must be the other's nearest: in the column *and* in the row.
    second best | return j -> return _second_best(D, gate, j) | A detection that has lost its nearest tree has no claim to another: that is wrong even more surely.
    new and unused exchanged | return j -> return np.where(j < 0, -3 - j, j) | -1 is a new tree, -2 is not used.
    trees instead of detections | k, n = D.shape -> D = D.T; k, n = D.shape | One number for each *detection*, a row of D, not for each tree.
    counted from 1 | j[own] = best[own] -> j[own] = best[own] + 1 | The first tree has the index 0.
    never new | ] = -1 -> ] = -2 | A map must grow: further than new_gate from every tree is a new one.
    a pair at the gate | <= gate) -> < gate) | *At most* gate: a pair at just this distance is one, <=.
    new at the limit | > new_gate -> >= new_gate | *Further* than new_gate: a detection at just this distance is not new, >.
    the gate squared | <= gate) -> <= gate**2) | D holds squared distances, and the limits are limits of these: compare them as they are, no square and no root.
    nothing new in an empty map | j[D.min(axis=1, initial=np.inf) > new_gate] = -1 -> j[D.min(axis=1, initial=np.inf) > new_gate] = -1 if n else -2 | With no tree in the map each detection is further than new_gate from every tree: all are new.
    distances of the trees that are free: New is what is further than new_gate from *every* tree: those that have got a detection count, too.
        return j -> lost = np.setdiff1d(np.arange(n), j[j >= 0]); j[(j == -2) & (D[:, lost].min(axis=1, initial=np.inf) > new_gate)] = -1; return j
    given up where several are inside | own = (back -> own = (np.sum(D <= gate, axis=1) == 1) & (back | The two must be each other's nearest, and that is all: a second tree inside the gate does not matter.
    """,
)


def _same(j, args):
    """Compare labels. They are no quantities: -1 instead of -2 is not half as much."""
    D, gate, new_gate = args
    got, want = expect.array(j, len(D), "j"), sort_scan(D, gate, new_gate)
    given, wanted = (", ".join(f"{v:g}" for v in labels) for labels in (got, want))
    of = f"D = {D.round(1).tolist()}" if D.size <= 9 else f"a D of {D.shape[0]} detections and {D.shape[1]} trees"
    at = f"{of} and the limits {gate:.3g} and {new_gate:.3g}"
    expect.true(np.array_equal(got, want), f"j is [{given}] for {at}, it should be [{wanted}].")


def _link(name, help, cases):
    @scan.link(name, help)
    def _(f, rng):
        for args in cases(rng):
            _same(f(*args), args)


_link(
    "by hand",
    "One detection, one tree: near, far, and in between. At most gate: the tree, 0. Further than new_gate: new, -1. In between: -2.",
    scans(*([[d]] for d in (1.0, 9.0, 9.2, 12.0, 24.0, 25.0, 26.0, 900.0))),
)
_link(
    "empty",
    "A map without trees: all are new. A scan without detections: no numbers. (np.all of no numbers is True, np.any of no numbers is False.)",
    scans(np.zeros((3, 0)), np.zeros((0, 5))),
)
_link(
    "nearest",
    "The index of the tree with the least distance: the smallest entry of the row. Where every entry of the row is above new_gate: -1.",
    scans([[400, 2, 90], [1, 300, 80], [70, 60, 50]], [[400, 2], [1, 300]]),
)
_link(
    "two detections, one tree",
    "Each must be the other's nearest: the entry is the smallest of its row and of its column, and at most gate. A detection without such a partner, but with a tree at new_gate or nearer, is not used: -2.",
    scans([[3, 400, 8], [1, 300, 500], [6, 700, 600]], [[3, 400], [1, 300]], [[2], [4], [30]]),
)
_link(
    "new is far from all",
    "-1 where every entry of the row is above new_gate. One tree at new_gate or nearer is enough: then the detection is not new.",
    scans([[400, 12, 700], [30, 500, 26], [24, 900, 800]], [[400, 25], [30, 500]], [[9.2, 26]]),
)
_link(
    "many scans",
    "Any numbers of rows and columns, other limits. For each row: mutual nearest and at most gate, the tree; every entry above new_gate, -1; all else, -2. Try your function on paper with a small D.",
    lambda rng: [some(rng) for _ in range(12)],
)


def _greedy(D, gate, j):
    """Each detection in turn takes the nearest tree that is free."""
    j, taken = np.where(j == -1, -1, -2), set()
    for i in np.flatnonzero(j == -2):
        free = [int(t) for t in np.argsort(D[i]) if D[i, t] <= gate and int(t) not in taken]
        if free:
            j[i] = free[0]
            taken.add(free[0])
    return j


def _trees_choose(D, gate, j):
    """Each tree takes its nearest detection, whichever tree is the nearest to that."""
    j = np.where(j == -1, -1, -2)
    for t in range(D.shape[1] if len(D) else 0):
        i = D[:, t].argmin()
        j[i] = t if D[i, t] <= gate else j[i]
    return j


def _second_best(D, gate, j):
    """Pairs by distance: the best pair first, then the best of what is left."""
    j, E = np.where(j == -1, -1, -2), D.copy()
    while E.size and E.min() <= gate:
        i, t = np.unravel_index(E.argmin(), E.shape)
        j[i] = t
        E[i], E[:, t] = np.inf, np.inf
    return j
