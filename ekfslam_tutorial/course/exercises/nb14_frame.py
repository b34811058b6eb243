"""Exercise 14.2: known landmarks first, then new ones; each measurement once."""

import numpy as np

from ..table import table


def known_then_new(ids, known, n_inits):
    """Sort the measurements of one sensor in one frame: which correct the map, which start a landmark.

    ids, shape (m,): the landmark id of each measurement, none of them twice, and -1 where nobody knows whose it is.
    known, shape (k,): the ids of the landmarks in the map, in any order. n_inits: most landmarks that may be started in
    this frame.
    A measurement is used once. One of a known landmark corrects. One of an unknown landmark starts it, in the order in
    which they stand in ids. Those with id -1, and those beyond n_inits, are not used.
    Return two arrays of indices into ids, in rising order: those that correct, and those that start a landmark.
    """
    correct = [i for i, id in enumerate(ids) if id >= 0 and id in known]
    start = [i for i, id in enumerate(ids) if id >= 0 and id not in known]
    correct, start = np.array(correct, dtype=int), np.array(start[:n_inits], dtype=int)
    return correct, start


def frames(*cases):
    """Return the case of ids, known ids and most inits."""
    return lambda rng: [(np.array(ids, dtype=int), np.array(known, dtype=int), n) for ids, known, n in cases]


def some(rng):
    """A frame of up to 11 measurements, some of nobody's."""
    ids = rng.permutation(15)[: int(rng.integers(1, 12))]
    ids[rng.random(len(ids)) < 0.2] = -1
    return ids, rng.permutation(15)[: int(rng.integers(0, 10))], int(rng.integers(0, 5))


sorted_out = table(
    "14.2 Known first, then new",
    known_then_new,
    hints=(
        "Go through ids with enumerate. Two questions for each: is it -1? Is it known?",
        "An index goes into one of the two lists, or into neither. Never into both: that is double counting.",
        "Indices of known ids; then indices of ids that are neither known nor -1, cut off after n_inits.",
    ),
    returns="correct, start",
    cases={
        "any": frames(([4, 7, 9], [7, 9, 4, 2], 5)),
        "all new": frames(([4, 7, 9], [], 5), ([], [3], 2)),
        "both": frames(([8, 3, 5, 2], [3, 2], 9), ([6, 1, 4], [4, 9, 6], 2), ([0, 5, 3], [3, 0], 2), ([0, 5], [5], 1)),
        "nobody's": frames(([-1, 3, -1, 6], [3], 9), ([-1, 5], [], 3), ([2, -1, -1], [], 2)),
        "n_inits": frames(([9, 3, 8, 5, 7], [3], 2), ([9, 8], [], 0), ([3, 4, 9], [3, 4], 1)),
        "many": lambda rng: [some(rng) for _ in range(12)],
    },
    checks="""
    all known   | correct | any      | All three ids are known: their measurements correct the map, nothing is started. Return the places in `ids`, counted from 0, in rising order.
    all new     | start   | all new  | With an empty map nothing corrects, and the first n_inits measurements that have an id start landmarks: their places in ids. With no measurement both arrays are empty.
    both        | correct, start | both     | Known ones correct, unknown ones start, at most n_inits of them; 0 is an id like any other. Both lists hold places in `ids`, in rising order: the order of `ids`, whatever the order of `known`.
    nobody's    | start   | nobody's | -1 says: nobody knows whose measurement it is. Its place is in neither list; the others keep their places in `ids`.
    n_inits     | start   | n_inits  | At most n_inits landmarks are started in a frame, those that come first in `ids`; with n_inits = 0 none.
    many frames | correct, start | many     | All rules at once, on paper: a place is of a known landmark, or of a new one, or of nobody; of the new ones the first n_inits start.
    """,
    wrong="""
    used twice | return correct, start -> return np.sort(np.concatenate([correct, start])), start | A measurement that has started a landmark is used up. Correcting with it again counts it twice, and halves the covariance for nothing.
    lists swapped | return correct, start -> return start, correct | Known landmarks *correct* the map, unknown ones are *started*: first list, second list.
    ids instead of indices | return correct, start -> return ids[correct], ids[start] | Return the places in `ids`, not the ids themselves: the measurement is found by it.
    one landmark too many | start[:n_inits] -> start[: n_inits + 1] | n_inits are the most that may be started: the next one is one too many.
    n_inits not used | start[:n_inits] -> start | n_inits limits how many landmarks are started in one frame.
    unknown measurements start landmarks | id >= 0 and id not in known -> id not in known | -1 is no id: nobody knows whose measurement it is. It is not used.
    nobody's counted as new | id >= 0 and id not in known -> id not in known | -1 is no landmark: it does not count against n_inits. Leave it out first, then take the first n_inits.
        start[:n_inits] -> [i for i in start[:n_inits] if ids[i] >= 0]
    id 0 left out | id >= 0 and id in known -> id > 0 and id in known | The first landmark has the id 0: only -1 is nobody's.
        id >= 0 and id not in known -> id > 0 and id not in known
    first n_inits measurements | start[:n_inits] -> [i for i in start if i < n_inits] | n_inits counts the landmarks that are started, not the measurements that are looked at.
    known ones counted, too | start[:n_inits] -> [i for i in start if np.sum(np.asarray(ids)[:i] >= 0) < n_inits] | n_inits counts the landmarks that are started: a measurement of a known one does not count.
    no limit for zero | start[:n_inits] -> start[: n_inits or None] | n_inits = 0 is a limit, too: then no landmark is started.
    stops at the limit | correct, start = np.array(correct, dtype=int), -> correct, start = np.array([i for i in correct if [*start, *[len(ids)] * (n_inits + 1)][n_inits] > i], dtype=int), | n_inits limits what is started, not what corrects: behind the last start known landmarks are corrected all the same.
    the last ones | start[:n_inits] -> start[len(start) - n_inits :] if n_inits < len(start) else start | Those that come first are started: start[:n_inits].
    places in known | return correct, start -> return np.flatnonzero(np.isin(known, ids)), start | The places are those in `ids`, the measurements, not those in `known`.
    in the order of known | return correct, start -> return np.array([list(ids).index(id) for id in known if id in ids], dtype=int), start | The places rise, in the order of `ids`: yours come in the order of `known`.
    lowest ids first | correct, start = np.array(correct -> start = sorted(start, key=lambda i: ids[i]); correct, start = np.array(correct | Of the unknown ones those are started that come first in `ids`, not those with the lowest numbers.
        return correct, start -> return correct, np.sort(start)
    nobody's not counted: The places are those in `ids` as it came. Where the -1 are taken out first, all behind them move up.
        correct, start = np.array(correct, dtype=int), -> at = np.cumsum(np.asarray(ids) >= 0) - 1; start = [int(at[i]) for i in start]; correct, start = np.array([at[i] for i in correct], dtype=int),
    corrections use up places | start[:n_inits] -> start[: max(n_inits - len(correct), 0)] | n_inits limits what is started, and a correction starts nothing: it takes no place.
    searched in known as it stands: np.searchsorted finds something in a sorted array only, and `known` is in any order: sort it first, or take np.isin.
        id >= 0 and id in known] -> id >= 0 and len(known) and known[min(np.searchsorted(known, id), len(known) - 1)] == id]
        id >= 0 and id not in known] -> id >= 0 and not (len(known) and known[min(np.searchsorted(known, id), len(known) - 1)] == id)]
    """,
)
