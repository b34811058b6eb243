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
    "19.3",
    "Who stays in the map",
    manage,
    hints=(
        "A tree behind the truck is not looked for. Whom does this scan say anything about?",
        "searched + visible, found + matched: new arrays, with True as 1. Then three conditions, joined by &.",
        "bad = visible & (searched >= min_search) & (found < min_ratio * searched), with the new counts; "
        "np.flatnonzero(bad).",
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
    who must go | delete   | one   | Looked for often enough, found too rarely, and in view of this scan.
    many trees  | delete   | many  | All trees at once, and the indices in rising order.
    empty       | delete   | empty | A map without trees is a map, too.
    """,
    wrong="""
    out of view counts as missed: A tree behind the truck is not looked for: only those in view are searched.
        searched + visible -> searched + 1
    found trees are not searched: A tree that is found was looked for, too: searched + visible.
        searched + visible -> searched + (visible & ~matched)
    searched only when found: A tree that should be in view and is not found was looked for.
        searched + visible -> searched + matched
    in view taken as found: In view is not found: a tree is found if it got a detection.
        found + matched -> found + visible
    counts left as they were: Add this scan to the counts first.
        searched + visible, found + matched -> searched.copy(), found.copy()
    no trial: A tree that is new and was missed once is out at once. Wait for min_search searches.
        visible & (searched >= min_search) & -> visible &
    counted in matches: min_search is about how often it was looked for, not how often it was found.
        searched >= min_search -> found >= min_search
    more than min_search: *At least* min_search: >=.
        searched >= min_search -> searched > min_search
    count first, then test: This scan counts, too: test the new counts, searched + visible and found + matched.
        (searched >= min_search) & (found < min_ratio * searched) -> (searched - visible >= min_search) & (found - matched < min_ratio * (searched - visible))
    deleted out of view: Only a tree that should be in view now may go: this scan says nothing about the others.
        bad = visible & (searched -> bad = (searched
    deleted when missed once: One miss is no proof: a car may stand before it. The share over all searches counts.
        visible & (searched >= min_search) & (found < min_ratio * searched) -> visible & ~matched
    good ones deleted: Those that are found in *less* than min_ratio go.
        found < min_ratio -> found > min_ratio
    share of the misses: min_ratio is a share of finds: found < min_ratio * searched.
        found < min_ratio -> searched - found < min_ratio
    at most the share: *Less* than min_ratio goes: exactly the share stays.
        found < min_ratio -> found <= min_ratio
    not if found now: A lucky find does not save a tree that was missed all the time: the share counts.
        visible & (searched >= -> visible & ~matched & (searched >=
    one is enough: All three conditions must hold: & (and), not | (or).
        visible & (searched >= min_search) & (found -> visible & (searched >= min_search) | (found
    truth values instead of indices: delete is a list of indices: np.flatnonzero turns truth values into indices.
        np.flatnonzero(bad).tolist() -> bad
    """,
)
