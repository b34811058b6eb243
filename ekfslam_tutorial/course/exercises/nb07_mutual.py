"""Exercise 07.2: mutual nearest neighbours."""

import numpy as np

from .. import expect
from ..table import table


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


def tables(limit, *found):
    """Return these tables of distances, with one limit."""
    return [(np.array(D, float), limit) for D in found]


def sizes(*shapes, high=15, limit=9.0):
    """Return a case of tables of these shapes at random."""
    return lambda rng: [(rng.uniform(0, high, shape), limit) for shape in shapes]


GATED = [[1, 900, 900], [900, 12, 900], [900, 900, 500]]
FAR = [[500, 900], [900, 700]]  # of a row in which nothing passes, argmin is 0: so is that of the column

mutual = table(
    "07.2 Mutual nearest neighbours",
    mutual_nearest,
    hints=(
        "Each measurement has a nearest landmark (the least entry of its row), each landmark a nearest measurement (the least entry of its column).",
        "A pair (i, j) counts only if j is the best of row i *and* i is the best of column j, and D[i, j] is inside the gate.",
        "near = np.argmin(D[i]); accept if np.argmin(D[:, near]) == i and D[i, near] <= limit; all others stay -1.",
    ),
    returns="j",
    cases={
        "any": sizes((3, 4), (4, 2), (1, 1), high=20, limit=9.2),
        "clear": lambda rng: tables(
            9.2,
            [[50, 1, 60], [2, 70, 80], [40, 90, 3]],
            [[50, 60, 1, 70], [80, 2, 90, 40]],
            [[1, 90], [80, 70], [60, 3]],
        ),
        "gate": lambda rng: [*tables(9.2, GATED), *tables(13.8, GATED), *tables(12.0, GATED), *tables(9.2, FAR)],
        "one landmark": lambda rng: tables(9.2, [[4, 30], [1, 40]], [[2, 5, 6], [1, 40, 41]], [[1, 40], [4, 30]]),
        "one measurement": lambda rng: tables(9.2, [[4, 1]], [[1, 4]]),
        "nothing": lambda rng: tables(9.2, np.zeros((3, 0)), np.zeros((0, 3)), [[0.5]]),
        "many": sizes((5, 5), (3, 8), (8, 3), (6, 5)),
    },
    checks="""
    shape                          | j[:0] | any         | One entry for each measurement.
    clear pairs                    | j | clear           | Each measurement is near one landmark or none: the answer is the column of the least entry of its row, if that is at most the limit, else -1.
    the gate                       | j | gate            | A pair is kept if its entry of D is at most the limit: a distance of just the limit is kept, a larger one gives -1.
    a landmark is used once        | j | one landmark    | Two measurements want the same landmark: the nearer one gets it. The other one gets -1, also where another landmark is inside its gate.
    two landmarks, one measurement | j | one measurement | The measurement goes to the nearer of the two landmarks.
    nothing to match               | j | nothing         | No landmark in the map: each of the k measurements gets -1. No measurement: j is empty.
    many at random                 | j | many            | A pair counts if it is the least of its row and the least of its column, and at most the limit. All such pairs count, and no other pair.
    """,
    wrong="""
    each measurement for itself | np.argmin(D[:, near]) == i and D -> D | Two measurements may now get the same landmark. Ask the landmark, too: is this measurement its nearest?
    first come, first served | np.argmin(D[:, near]) == i -> near not in j | The first measurement takes the landmark from a nearer one that comes later: the answer must not depend on the order.
    both of a tie | np.argmin(D[:, near]) == i -> D[i, near] <= D[:, near].min() | Two measurements that are just as near both get the landmark. No landmark is used twice: argmin takes one of them.
    no gate | == i and D[i, near] <= limit: -> == i: | The nearest may be far away: compare with the limit.
    each landmark for itself | for i in range(k): -> for near in range(n if k else 0): | Each landmark has taken its nearest measurement. Ask the measurement, too: is this landmark its nearest?
        near = np.argmin(D[i]) -> i = np.argmin(D[:, near])
        np.argmin(D[:, near]) == i and D -> D
    the limit squared | <= limit: -> <= limit**2: | D holds squared distances, and the limit is for squared distances: compare them directly.
    the root of the limit | <= limit: -> <= np.sqrt(limit): | The limit is for squared distances already, such as 9.2: compare D with it, without a root.
    out at the limit itself | <= limit: -> < limit: | A pair is none if its distance is *larger* than the limit: at the limit itself it counts, <=.
    furthest | np.argmin(D[i]) -> np.argmax(D[i]) | Near means a *small* distance: argmin.
        np.argmin(D[:, near]) == i and D[i, near] <= limit: -> np.argmax(D[:, near]) == i:
    furthest measurement of the landmark | np.argmin(D[:, near]) -> np.argmax(D[:, near]) | The landmark asks for its *nearest* measurement, too: the least entry of its column, argmin.
    axes swapped: Row i belongs to measurement i, column j to landmark j: the nearest landmark of a measurement is the least entry of its row, argmin with axis=1.
        near = np.argmin(D[i]) -> near = np.argmin(D, axis=0)[i]
        np.argmin(D[:, near]) == i -> np.argmin(D, axis=1)[near] == i
    landmarks instead of measurements | <= limit: -> <= limit and near < k: | j has one entry for each *measurement*: which landmark it belongs to.
        j[i] = near -> j[near] = i
    None for no pair | np.full(k, -1) -> [None] * k | A measurement without a landmark gets the number -1, not None.
    0 for no pair | np.full(k, -1) -> np.zeros(k, int) | 0 is the first landmark. A measurement without a landmark gets the number -1.
    counted from 1 | j[i] = near -> j[i] = near + 1 | Landmarks are counted from 0.
    fails on an empty map | if n == 0: -> if False: | At the start there is no landmark: D has the shape (k, 0), and argmin has nothing to choose from.
    0 for no pair, but not in an empty map | np.full(k, -1) -> np.zeros(k, int) | 0 is the first landmark. A measurement without a landmark gets the number -1.
        if n == 0: -> if n == 0 and not j.fill(-1):
    none of two | np.argmin(D[:, near]) == i and -> np.sum(np.argmin(D, axis=1) == near) == 1 and np.argmin(D[:, near]) == i and | A landmark that two measurements want goes to the nearer one. The other stays unmatched, not both.
    claims of the landmark's own only | np.argmin(D[:, near]) == i -> D[i, near] <= min(D[a, near] for a in range(k) if np.argmin(D[a]) == near) | The nearest measurement of a landmark is the least of its *whole* column, also where that measurement prefers another landmark.
    given up where several are inside | np.argmin(D[:, near]) == i and -> np.sum(D[i] <= limit) == 1 and np.argmin(D[:, near]) == i and | Here a measurement with two landmarks inside its gate is not given up: it takes the nearer one, if that one's nearest is this measurement.
    stops at the first that is too far | for i in range(k): -> for i in range(next((a for a in range(k) if D[a].min() > limit), k)): | Where one measurement has no landmark, the next may have one: the loop goes on to the last measurement. `continue` does that, `break` and `return` end it.
    as many as landmarks | if n == 0: -> if n == 0 and not np.size(j := j[:0]): | Where there is no landmark each of the k measurements gets -1: j has the shape (k,), also if the map is empty.
    """,
)


@mutual.link("a tie", "Two measurements may be just as near to a landmark: still it is not used twice.")
def _(f, rng):
    j = expect.array(f(np.ones((2, 1)), 9.2), 2, "j")
    expect.true(np.sum(j == 0) < 2, f"j is {j.astype(int).tolist()} for D = [[1], [1]]: landmark 0 is used twice")


@mutual.wrong(
    "greedy, with the second best",
    "A measurement that has lost its landmark has no claim to the second best: it stays unmatched.",
)
def _(D, limit):
    j, used = np.full(len(D), -1), set()
    for i, near in sorted(np.ndindex(*D.shape), key=lambda p: D[p]):
        if j[i] < 0 and near not in used and D[i, near] <= limit:
            j[i] = near
            used.add(near)
    return j
