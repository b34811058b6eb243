"""Exercise 19.3: which trees stay in the map."""

import numpy as np

from ..table import table


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


def case(rng, n=12):
    """Return counts, views and limits."""
    searched = rng.integers(0, 30, n)
    found = np.floor(searched * rng.random(n)).astype(int)
    visible = rng.random(n) < 0.6
    return searched, found, visible, visible & (rng.random(n) < 0.5), int(rng.integers(3, 15)), rng.uniform(0.2, 0.7)


def tree(searched, found, visible, matched, min_ratio=0.3):
    """Return the arguments for one tree, with min_search 10."""
    return np.array([searched]), np.array([found]), np.array([visible]), np.array([matched]), 10, min_ratio


SEEN, HIDDEN, MATCHED, MISSED = True, False, True, False

upkeep = table(
    "19.3 Who stays in the map",
    manage,
    hints=(
        "A tree behind the truck is not looked for. Whom does this scan say anything about?",
        "searched + visible, found + matched: new arrays, with True as 1. Then three conditions, joined by &.",
        "bad = visible & (searched >= min_search) & (found < min_ratio * searched), with the new counts; np.flatnonzero(bad).",
    ),
    returns="searched, found, delete",
    cases={
        "any": lambda rng: [case(rng, n) for n in (12, 4, 1)],
        "one": lambda rng: [
            tree(20, 2, SEEN, MISSED),
            tree(20, 15, SEEN, MISSED),
            tree(3, 0, SEEN, MISSED),  # too few searches to tell
            tree(10, 3, SEEN, MISSED),  # before the next: old counts fail here
            tree(9, 0, SEEN, MISSED),  # ten searches with this scan
            tree(8, 0, SEEN, MISSED),
            tree(20, 2, HIDDEN, MISSED),
            tree(9, 3, SEEN, MATCHED),
            tree(9, 3, SEEN, MISSED),  # exactly the share
            tree(19, 2, SEEN, MATCHED),
            tree(9, 4, SEEN, MATCHED, 0.5),
        ],
        "many": lambda rng: [case(rng, 25) for _ in range(10)],
        "empty": lambda rng: [(np.zeros(0, int), np.zeros(0, int), np.zeros(0, bool), np.zeros(0, bool), 10, 0.3)],
    },
    checks="""
    searched    | searched | any   | A tree is looked for in every scan in which it should be in view, found or not.
    found       | found    | any   | One more for each tree that got a detection.
    who must go | delete   | one   | Searched at least min_search times, found in less than min_ratio of them (new found / new searched), and visible in this scan: all three.
    many trees  | delete   | many  | 25 trees at once, with other limits: the same three conditions for each tree, with min_search and min_ratio as given; the indices of all that must go, in rising order.
    empty       | delete   | empty | A map without trees is a map, too: the list to delete is empty.
    """,
    wrong="""
    out of view counts as missed | searched + visible -> searched + 1 | A tree behind the truck is not looked for: only those in view are searched.
    found trees are not searched | searched + visible -> searched + (visible & ~matched) | A tree that is found was looked for, too: searched + visible.
    searched only when found | searched + visible -> searched + matched | A tree that should be in view and is not found was looked for.
    in view taken as found | found + matched -> found + visible | In view is not found: a tree is found if it got a detection.
    counts left as they were | searched + visible, found + matched -> searched.copy(), found.copy() | Add this scan to the counts first.
    deleted trees left out of the counts | return searched, found, np.flatnonzero(bad).tolist() -> return searched[~bad], found[~bad], np.flatnonzero(bad).tolist() | Return the counts of all n trees, those that must go, too: the third result says who goes.
    no trial | visible & (searched >= min_search) & -> visible & | A tree that is new and was missed once is out at once. Wait for min_search searches.
    counted in matches | searched >= min_search -> found >= min_search | min_search is about how often it was looked for, not how often it was found.
    more than min_search | searched >= min_search -> searched > min_search | *At least* min_search: >=. A tree that was searched just so many times, this scan included, may go.
    count first, then test: This scan counts, too: test the new counts, searched + visible and found + matched.
        (searched >= min_search) & (found < min_ratio * searched) -> (searched - visible >= min_search) & (found - matched < min_ratio * (searched - visible))
    deleted out of view | bad = visible & (searched -> bad = (searched | Only a tree that should be in view now may go: this scan says nothing about the others.
    deleted when missed once | visible & (searched >= min_search) & (found < min_ratio * searched) -> visible & ~matched | One miss is no proof: a car may stand before it. The share over all searches counts.
    good ones deleted | found < min_ratio -> found > min_ratio | Those that are found in *less* than min_ratio go.
    share of the misses | found < min_ratio -> searched - found < min_ratio | min_ratio is a share of finds: found < min_ratio * searched.
    one minus the share | found < min_ratio -> found < (1 - min_ratio) | min_ratio is the share of finds below which a tree goes: found < min_ratio * searched, not 1 - min_ratio.
    at most the share | found < min_ratio -> found <= min_ratio | *Less* than min_ratio goes: exactly the share stays.
    not if found now | visible & (searched >= -> visible & ~matched & (searched >= | A lucky find does not save a tree that was missed all the time: the share counts.
    one is enough: All three conditions must hold: & (and), not | (or).
        visible & (searched >= min_search) & (found -> visible & (searched >= min_search) | (found
    truth values instead of indices | np.flatnonzero(bad).tolist() -> bad | delete is a list of indices: np.flatnonzero turns truth values into indices.
    finds before this scan | found < min_ratio -> found - matched < min_ratio | This scan counts, too: compare the *new* number of finds, found + matched.
    share of min_search | found < min_ratio * searched -> found < min_ratio * min_search | Found in less than min_ratio of the searches, of all of them: found < min_ratio * searched.
    indices among those in view | np.flatnonzero(bad).tolist() -> np.flatnonzero(bad[visible]).tolist() | The indices are those of *all* trees in the map. Among those in view they count otherwise.
    whole division | (found < min_ratio * searched) -> (found // np.maximum(searched, 1) < min_ratio) | A share needs its decimals (`//` and int make 0 of each share below one): compare found with min_ratio * searched.
    indices as if the others had gone | np.flatnonzero(bad).tolist() -> (np.flatnonzero(bad) - np.arange(np.sum(bad))).tolist() | The indices are those in the map as it is, before any tree goes.
    """,
)
