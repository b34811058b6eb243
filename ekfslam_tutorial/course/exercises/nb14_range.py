"""Exercise 14.1: where a new state finds room in the map."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def find_range(used, k):
    """Where a new state of k numbers goes in the map.

    used, shape (n,), bool: which numbers of the map belong to a state. The numbers of a deleted landmark are free.
    The state must lie in one piece: in the first gap of at least k free numbers, free numbers at the end included.
    If no gap is long enough the map grows: the state begins behind the last number that is in use.
    Return [start, stop], shape (2,): the numbers start, ..., stop - 1. stop may be larger than n.
    """
    free = 0
    for i, taken in enumerate(used):
        free = 0 if taken else free + 1
        if free == k:
            return np.array([i + 1 - k, i + 1])
    return np.array([len(used) - free, len(used) - free + k])


roomy = Exercise(
    "14.1",
    "Room in the map",
    find_range,
    hints=(
        "Walk along the map and count how many free numbers you have seen in a row. What sets the count to zero?",
        "When the count reaches k at the place i, the range is [i + 1 - k, i + 1].",
        "At the end of the map the count is the number of free numbers there: the range begins at n - count.",
    ),
)


def _range(result):
    return expect.array(result, 2, "[start, stop]")


def bits(text):
    """Return '110' as an array of bool."""
    return np.array([c == "1" for c in text], dtype=bool)


def _link(name, help, *cases):
    @roomy.link(name, help)
    def _(f, rng):
        for text, k in cases:
            want = find_range(bits(text), k)
            at = f"used = {text or 'empty'} and k = {k}"
            expect.close(_range(f(bits(text), k)), want, "[start, stop]", at=at)


_link("two numbers", "Return [start, stop], with stop = start + k.", ("1111", 3), ("", 2))
_link("no gap", "Nothing is free: the map grows, the state begins at n.", ("111", 6), ("1", 1), ("11111", 2))
_link(
    "one gap", "A deleted landmark leaves a gap: use it.", ("1001100", 2), ("11100011", 3), ("0011", 2), ("110001", 2)
)
_link(
    "one piece", "A state lies in one piece: two small gaps do not make a large one.", ("10110011", 3), ("1010101", 2)
)
_link("first gap", "Of the gaps that are long enough take the first.", ("1001000011", 2), ("1010011000011", 3))
_link("free at the end", "Free numbers at the end are a gap, too, and the map may grow behind them.", ("11100", 3),
      ("1000", 6), ("110000", 2), ("000", 5))  # fmt: skip


@roomy.link("many maps", "Try your function on paper with one of these maps.")
def _(f, rng):
    for _ in range(25):
        used, k = rng.random(int(rng.integers(1, 25))) < 0.55, int(rng.integers(1, 7))
        want, text = find_range(used, k), "".join("01"[int(u)] for u in used)
        expect.close(_range(f(used, k)), want, "[start, stop]", at=f"used = {text} and k = {k}")


@roomy.wrong("always at the end", "Deleted landmarks leave gaps. A map that never uses them grows without end.")
def _(used, k):
    return np.array([len(used), len(used) + k])


@roomy.wrong("first free number", "The first free number is not enough: k free numbers in a row are needed.")
def _(used, k):
    i = int(np.argmin(np.append(used, False)))
    return np.array([i, i + k])


@roomy.wrong("behind the last state", "That leaves the gaps between the states empty. Look for a gap first.")
def _(used, k):
    n = int(np.flatnonzero(np.append(True, used))[-1])
    return np.array([n, n + k])


@roomy.wrong("free numbers at the end left alone", "Free numbers at the end of the map can be used: begin behind the "
             "last number in use.")  # fmt: skip
def _(used, k):
    start, stop = find_range(used, k)
    return np.array([len(used), len(used) + k]) if stop > len(used) else np.array([start, stop])


@roomy.wrong("last number included", "stop is one past the last number, as in a slice: stop = start + k.")
def _(used, k):
    return find_range(used, k) - [0, 1]


@roomy.wrong("counted from 1", "The first number of the map has the index 0.")
def _(used, k):
    return find_range(used, k) + 1


@roomy.variant("by trying every start")
def _(used, k):
    for s in range(len(used) + 1):
        if not any(used[s : s + k]) and (s + k <= len(used) or not any(used[s:])):
            return [s, s + k]


@roomy.variant("as text")
def _(used, k):
    text = "".join("1" if u else "0" for u in used)
    s = text.find("0" * int(k))
    s = len(text.rstrip("0")) if s < 0 else s
    return np.array([s, s + k], dtype=float)
