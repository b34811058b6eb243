"""Exercise 14.2: known landmarks first, then new ones; each measurement once."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def known_then_new(ids, known, n_inits):
    """Sort the measurements of one sensor in one frame: which correct the map, which start a landmark.

    ids, shape (m,): the landmark id of each measurement, -1 where nobody knows whose it is. known, shape (k,): the ids
    of the landmarks in the map, in any order. n_inits: most landmarks that may be started in this frame.
    A measurement is used once. One of a known landmark corrects. One of an unknown landmark, in the order of ids,
    starts it. Those with id -1, and those beyond n_inits, are not used.
    Return two arrays of indices into ids, in rising order: those that correct, and those that start a landmark.
    """
    correct = [i for i, id in enumerate(ids) if id >= 0 and id in known]
    start = [i for i, id in enumerate(ids) if id >= 0 and id not in known]
    return np.array(correct, dtype=int), np.array(start[:n_inits], dtype=int)


sorted_out = Exercise(
    "14.2",
    "Known first, then new",
    known_then_new,
    hints=(
        "Go through ids with enumerate. Two questions for each: is it -1? Is it known?",
        "An index goes into one of the two lists, or into neither. Never into both: that is double counting.",
        "Indices of known ids; then indices of ids that are neither known nor -1, cut off after n_inits.",
    ),
)


def _two(result, m, n):
    a, b = expect.results(result, "correct", "start")
    return expect.array(a, m, "correct"), expect.array(b, n, "start")


def _link(name, help, *cases):
    @sorted_out.link(name, help)
    def _(f, rng):
        for ids, known, n_inits in cases:
            _one(f, np.array(ids, dtype=int), np.array(known, dtype=int), n_inits)


def _one(f, ids, known, n_inits):
    want = known_then_new(ids, known, n_inits)
    at = f"ids = {ids.tolist()}, known = {known.tolist()}, n_inits = {n_inits}"
    got = expect.results(f(ids, known, n_inits), "correct", "start")
    for name, a, b in zip(("correct", "start"), got, want, strict=True):
        n = len(a) if isinstance(a, (list, tuple, np.ndarray)) and np.ndim(a) == 1 else -1
        expect.true(n in (-1, len(b)), f"{name} has {n} indices, it should be {b.tolist()}, for {at}")
        expect.close(expect.array(a, len(b), name), b, name, at=at)


_link("all known", "Measurements of known landmarks correct the map; nothing is started.", ([4, 7, 9], [7, 9, 4, 2], 5))
_link("all new", "With an empty map every measurement starts a landmark.", ([4, 7, 9], [], 5))
_link("both", "Known ones correct, the others start: each index in one list.", ([8, 3, 5, 2], [3, 2], 9),
      ([6, 1, 4], [4, 9, 6], 2))  # fmt: skip
_link("nobody's", "-1 says: nobody knows whose measurement it is.", ([-1, 3, -1, 6], [3], 9), ([-1, 5], [], 3))
_link("n_inits", "At most n_inits landmarks are started in a frame, those that come first.", ([9, 3, 8, 5, 7], [3], 2),
      ([9, 8], [], 0))  # fmt: skip


@sorted_out.link("many frames", "Try your function on paper with one of these frames.")
def _(f, rng):
    for _ in range(12):
        ids = rng.permutation(15)[: int(rng.integers(1, 12))]
        ids[rng.random(len(ids)) < 0.2] = -1
        _one(f, ids, rng.permutation(15)[: int(rng.integers(0, 10))], int(rng.integers(0, 5)))


def _wrong(name, hint, change):
    """A misconception: change(ids, known, n_inits) returns the two lists."""

    @sorted_out.wrong(name, hint)
    def _(ids, known, n_inits):
        a, b = change(list(ids), list(known), n_inits)
        return np.array(a, dtype=int), np.array(b, dtype=int)


def _plain(ids, known, n_inits):
    return [list(part) for part in known_then_new(np.array(ids), np.array(known), n_inits)]


# fmt: off
_wrong("used twice", "A measurement that has started a landmark is used up. Correcting with it again counts it twice, "
       "and halves the covariance for nothing.",
       lambda ids, known, n: (sorted(sum(_plain(ids, known, n), [])), _plain(ids, known, n)[1]))
_wrong("lists swapped", "Known landmarks *correct* the map, unknown ones are *started*: first list, second list.",
       lambda ids, known, n: (_plain(ids, known, n)[1], _plain(ids, known, n)[0]))
_wrong("ids instead of indices", "Return the places in `ids`, not the ids themselves: the measurement is found by it.",
       lambda ids, known, n: [[ids[i] for i in part] for part in _plain(ids, known, n)])
_wrong("n_inits not used", "n_inits limits how many landmarks are started in one frame.",
       lambda ids, known, n: _plain(ids, known, len(ids)))
_wrong("unknown measurements start landmarks", "-1 is no id: nobody knows whose measurement it is. It is not used.",
       lambda ids, known, n: (_plain(ids, known, n)[0], [i for i, a in enumerate(ids) if a not in known][:n]))
# fmt: on


@sorted_out.variant("with masks")
def _(ids, known, n_inits):
    ids = np.asarray(ids)
    old = np.isin(ids, known) & (ids >= 0)
    return np.flatnonzero(old), np.flatnonzero(~old & (ids >= 0))[:n_inits]


@sorted_out.variant("in one walk")
def _(ids, known, n_inits):
    old, new, there = [], [], {int(i) for i in known}
    for place, id in enumerate(ids):
        if int(id) in there and id != -1:
            old.append(place)
        elif id != -1 and len(new) < n_inits:
            new.append(place)
    return old, new
