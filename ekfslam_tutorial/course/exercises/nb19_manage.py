"""Exercise 19.3: which trees stay in the map."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def manage(searched, found, visible, matched, min_search, min_ratio):
    """Count what one scan says about each tree in the map, and name those that must go.

    searched and found, shape (n,): in how many scans each tree was looked for so far, and in how many it was found.
    visible, shape (n,), bool: it should be in view of this scan. matched, shape (n,), bool: it got a detection (only
    a tree that should be in view can get one). n may be 0.
    A tree that was looked for at least min_search times, this scan included, and found in less than min_ratio of them
    is deleted; but only in a scan in which it should be in view.
    Return the new searched, shape (n,), the new found, shape (n,), and the list of indices to delete, in rising order.
    """
    searched, found = searched + visible, found + matched
    bad = visible & (searched >= min_search) & (found < min_ratio * searched)
    return searched, found, np.flatnonzero(bad).tolist()


upkeep = Exercise(
    "19.3",
    "Who stays in the map",
    manage,
    hints=(
        "A tree behind the truck is not looked for. Whom does this scan say anything about?",
        "searched + visible, found + matched: new arrays, with True as 1. Then three conditions, joined by &.",
        "bad = visible & (searched >= min_search) & (found < min_ratio * searched), with the new counts; "
        "np.flatnonzero(bad).",
    ),
)


def case(rng, n=12):
    """Return counts, views and limits."""
    searched = rng.integers(0, 30, n)
    found = np.floor(searched * rng.random(n)).astype(int)
    visible = rng.random(n) < 0.6
    return searched, found, visible, visible & (rng.random(n) < 0.5), int(rng.integers(3, 15)), rng.uniform(0.2, 0.7)


def _three(result, n):
    searched, found, gone = expect.results(result, "searched", "found", "delete")
    expect.true(gone is not None, "delete is None: return a list, empty if nobody must go")
    gone = np.asarray(gone if isinstance(gone, np.ndarray) else list(gone))
    expect.true(gone.ndim == 1, "delete must be a list of indices")
    expect.true(gone.dtype.kind != "b", "delete is an array of True and False: return the indices, np.flatnonzero(...)")
    return expect.array(searched, n, "searched"), expect.array(found, n, "found"), gone


@upkeep.link("three results", "The function must end with `return searched, found, delete`.")
def _(f, rng):
    for n in (12, 1, 5):
        _three(f(*case(rng, n)), n)


@upkeep.link("searched", "A tree is looked for in every scan in which it should be in view, found or not.", part=0)
def _(f, rng):
    for n in (12, 4, 1):
        args = case(rng, n)
        expect.close(_three(f(*args), n)[0], manage(*args)[0], "searched", at=f"{n} trees")


@upkeep.link("found", "One more for each tree that got a detection.", part=1)
def _(f, rng):
    for n in (12, 4, 1):
        args = case(rng, n)
        expect.close(_three(f(*args), n)[1], manage(*args)[1], "found", at=f"{n} trees")


def _same(got, want, at):
    expect.true(got.tolist() == list(want), f"delete is {got.tolist()} for {at}, it should be {list(want)}")


@upkeep.link("who must go", "Looked for often enough, found too rarely, and in view of this scan.", part=2)
def _(f, rng):
    none, one = np.array([False]), np.array([True])
    for s, m, seen, got, want, why in (
        (20, 2, one, none, [0], "found in 2 of 21 searches"),
        (20, 15, one, none, [], "found in 15 of 21 searches"),
        (3, 0, one, none, [], "found in none of 4 searches: too few to tell"),
        (10, 3, one, none, [0], "found in 3 of 11 searches"),  # before the next: old counts fail here
        (9, 0, one, none, [0], "found in none of 10 searches, this scan included"),
        (8, 0, one, none, [], "found in none of 9 searches"),
        (20, 2, none, none, [], "2 of 20, but out of view now"),
        (9, 3, one, one, [], "found in 4 of 10 searches, this scan included"),
        (9, 3, one, none, [], "found in 3 of 10, exactly the share"),
    ):
        args = (np.array([s]), np.array([m]), seen, got, 10, 0.3)
        _same(_three(f(*args), 1)[2], want, f"a tree {why}")


@upkeep.link("many trees", "All trees at once, and the indices in rising order.", part=2)
def _(f, rng):
    for _ in range(10):
        args = case(rng, 25)
        _same(_three(f(*args), 25)[2], manage(*args)[2], f"25 trees, min_search {args[4]}, min_ratio {args[5]:.2f}")


@upkeep.link("empty", "A map without trees is a map, too.")
def _(f, rng):
    none = np.zeros(0, int), np.zeros(0, int), np.zeros(0, bool), np.zeros(0, bool), 10, 0.3
    expect.true(len(_three(f(*none), 0)[2]) == 0, "delete must be empty for a map without trees")


def _wrong(name, hint, counts=None, bad=None):
    """A misconception in the counts (searched, found, visible, matched), or in who must go."""

    @upkeep.wrong(name, hint)
    def _(searched, found, visible, matched, min_search, min_ratio):
        s, m = counts(searched, found, visible, matched) if counts else (searched + visible, found + matched)
        rule = bad or (lambda s, m, v, got, n, r: v & (s >= n) & (m < r * s))
        return s, m, np.flatnonzero(rule(s, m, visible, matched, min_search, min_ratio)).tolist()


# fmt: off
_wrong("out of view counts as missed", "A tree behind the truck is not looked for: only those in view are searched.",
       counts=lambda s, m, v, got: (s + 1, m + got))
_wrong("found trees are not searched", "A tree that is found was looked for, too: searched + visible.",
       counts=lambda s, m, v, got: (s + (v & ~got), m + got))
_wrong("searched only when found", "A tree that should be in view and is not found was looked for.",
       counts=lambda s, m, v, got: (s + got, m + got))
_wrong("in view taken as found", "In view is not found: a tree is found if it got a detection.",
       counts=lambda s, m, v, got: (s + v, m + v))
_wrong("counts left as they were", "Add this scan to the counts "
       "first.", counts=lambda s, m, v, got: (s.copy(), m.copy()))
_wrong("no trial", "A tree that is new and was missed once is out at once. Wait for min_search searches.",
       bad=lambda s, m, v, got, n, r: v & (m < r * s))
_wrong("counted in matches", "min_search is about how often it was looked for, not how often it was found.",
       bad=lambda s, m, v, got, n, r: v & (m >= n) & (m < r * s))
_wrong("more than min_search", "*At least* min_search: >=.", bad=lambda s, m, v, got, n, r: v & (s > n) & (m < r * s))
_wrong("count first, then test", "This scan counts, too: test the new counts, searched + visible and found + matched.",
       bad=lambda s, m, v, got, n, r: v & (s - v >= n) & (m - got < r * (s - v)))
_wrong("deleted out of view", "Only a tree that should be in view now may go: this scan says nothing about the others.",
       bad=lambda s, m, v, got, n, r: (s >= n) & (m < r * s))
_wrong("deleted when missed once", "One miss is no proof: a car may stand before it. The share over all searches "
       "counts.",
       bad=lambda s, m, v, got, n, r: v & ~got)
_wrong("good ones deleted", "Those that are found in *less* than min_ratio go.",
       bad=lambda s, m, v, got, n, r: v & (s >= n) & (m > r * s))
_wrong("share of the misses", "min_ratio is a share of finds: found < min_ratio * searched.",
       bad=lambda s, m, v, got, n, r: v & (s >= n) & (s - m < r * s))
_wrong("at most the share", "*Less* than min_ratio goes: exactly the share stays.",
       bad=lambda s, m, v, got, n, r: v & (s >= n) & (m <= r * s))
_wrong("not if found now", "A lucky find does not save a tree that was missed all the time: the share counts.",
       bad=lambda s, m, v, got, n, r: v & ~got & (s >= n) & (m < r * s))
# fmt: on


@upkeep.variant("a loop, lists")
def _(searched, found, visible, matched, min_search, min_ratio):
    s, m, gone = [], [], []
    for i in range(len(searched)):
        s.append(int(searched[i]) + int(visible[i]))
        m.append(int(found[i]) + int(matched[i]))
        if visible[i] and s[i] >= min_search and m[i] < min_ratio * s[i]:
            gone.append(i)
    return s, m, gone


@upkeep.variant("indices as an array")
def _(searched, found, visible, matched, min_search, min_ratio):
    s, m = np.where(visible, searched + 1, searched), np.where(matched, found + 1, found)
    return s, m, np.nonzero(visible & ~(s < min_search) & ~(m >= min_ratio * s))[0]
