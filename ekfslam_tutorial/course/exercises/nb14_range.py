"""Exercise 14.1: where a new state finds room in the map."""

import numpy as np

from ..table import table


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
    n = len(used) - free
    return np.array([n, n + k])


def maps(*cases):
    """Return the case of maps written as '110' and sizes."""
    return lambda rng: [(np.array([c == "1" for c in text], dtype=bool), k) for text, k in cases]


roomy = table(
    "14.1 Room in the map",
    find_range,
    hints=(
        "Walk along the map and count how many free numbers you have seen in a row. What sets the count to zero?",
        "When the count reaches k at the place i, the range is [i + 1 - k, i + 1].",
        "At the end of the map the count is the number of free numbers there: the range begins at n - count.",
    ),
    returns="place",
    cases={
        "any": maps(("1111", 3), ("", 2)),
        "no gap": maps(("111", 6), ("1", 1), ("11111", 2)),
        "one gap": maps(("1001100", 2), ("11100011", 3), ("0011", 2), ("110001", 2), ("101", 1)),
        "one piece": maps(("10110011", 3), ("1010101", 2), ("1001001", 3)),
        "first gap": maps(("1001000011", 2), ("1010011000011", 3), ("100011001", 2), ("000", 3)),
        "free at the end": maps(("11100", 3), ("1000", 6), ("110000", 2), ("000", 5), ("1010", 1)),
        "many": lambda rng: [(rng.random(rng.integers(1, 25)) < 0.55, int(rng.integers(1, 7))) for _ in range(25)],
    },
    checks="""
    two numbers     | place | any       | Return [start, stop], with stop = start + k. Where nothing is free the state begins behind the last number in use, in an empty map at 0.
    no gap          | place | no gap    | Where nothing is free the map grows, and the state begins at n. Neighbours in use have no gap between them.
    one gap         | place | one gap   | A deleted landmark leaves a gap of k free numbers, or more. It may begin at any number, 0 included. start is the first number of the first such gap, stop = start + k.
    one piece       | place | one piece | A state lies in one piece. Here each gap has fewer than k free numbers: the state begins behind the last number in use.
    first gap       | place | first gap | Of the gaps that are long enough take the first. Where no number is in use the whole map is one gap.
    free at the end | place | free at the end | Free numbers at the end are a gap, too. Where no gap is long enough the state begins behind the last number in use, at the first of these, and the map grows.
    many maps       | place | many      | On paper with this map: the first k free numbers in a row, wherever they begin; else behind the last number in use.
    """,
    wrong="""
    always at the end | enumerate(used) -> enumerate(()) | Deleted landmarks leave gaps. A map that never uses them grows without end.
    first free number | if free == k: -> if not taken: | The first free number is not enough: k free numbers in a row are needed.
        [i + 1 - k, i + 1] -> [i, i + k]
    behind the last state | if free == k: -> if False: | That leaves the gaps between the states empty. Look for a gap first.
    free numbers at the end left alone | n = len(used) - free -> n = len(used) | Free numbers at the end of the map can be used: begin behind the last number in use.
    last number included | [i + 1 - k, i + 1] -> [i + 1 - k, i] | stop is one past the last number, as in a slice: stop = start + k.
        [n, n + k] -> [n, n + k - 1]
    behind the last number but one | n = len(used) - free -> n = max(len(used) - free - 1, 0) | Where nothing is free the state begins one *behind* the last number in use: its index + 1.
    one behind the end | n = len(used) - free -> n = len(used) - free + 1 | Where nothing is free the state begins right *behind* the last number in use, at its index + 1; with none in use at 0.
    counted from 1 | [i + 1 - k, i + 1] -> [i + 2 - k, i + 2] | The first number of the map has the index 0.
        [n, n + k] -> [n + 1, n + k + 1]
    gaps added up | free = 0 if taken else free + 1 -> free += not taken | The count begins anew behind each number in use: a state lies in one piece.
    one number to spare | if free == k: -> if free == k + 1: | A gap of exactly k numbers is long enough.
        [i + 1 - k, i + 1] -> [i - k, i]
    no gap before the first state | free = 0 if taken else free + 1 -> free = 0 if taken or any(used) and not any(used[:i]) else free + 1 | The map may begin with free numbers, too: a gap before the first state is one like the others.
    starts at multiples of k | if free == k: -> if free >= k and (i + 1) % k == 0: | A gap may begin at any number, not only at multiples of k.
    never at number 0 | if free == k: -> if free >= k and i >= k: | The map begins at number 0: a gap may begin there, too.
    free numbers behind the last state counted twice | n = len(used) - free -> n = len(used) - 2 * free | Where no gap is long enough the state begins at the first of the free numbers at the end: n minus their count.
    end of the gap | if free == k: -> if free >= k and (i + 1 == len(used) or used[i + 1]): | The state begins where the gap begins, not as far behind as it fits: its first k numbers.
    smallest gap that fits | if free == k: -> if free >= k and (i + 1 == len(used) or used[i + 1]) and free == min(len(g) for g in "".join("10"[int(not t)] for t in used).split("1") if len(g) >= k): | Of the gaps that are long enough take the *first*, not the one that fits best.
        [i + 1 - k, i + 1] -> [i + 1 - free, i + 1 - free + k]
    number of those in use | n = len(used) - free -> n = int(np.sum(used)) | How many numbers are in use says where the map ends only if there are no gaps: begin behind the *last* number in use.
    stop at n + k | np.array([n, n + k]) -> np.array([n, len(used) + k]) | stop = start + k: the state is k numbers long, also where the free numbers at the end are used.
    """,
)
