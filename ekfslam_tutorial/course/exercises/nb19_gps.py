"""Exercise 19.4: a path compared with GPS, which is no truth."""

import numpy as np

from ..table import table


def gps_error(t, path, fixes, share):
    """How far a path is from GPS, when some of the fixes are wrong.

    t, shape (m,): times of the path, s, rising. path, shape (m, 2): positions, m. fixes, shape (g, 3): time, x, y of
    each GPS fix, in any order; some fixes are before or after the path, and tell nothing about it.
    Between two of its times the path is a straight line. share, above 0 and up to 1: the part of the fixes that is
    believed: of g fixes beside the path the int(share * g) that are nearest to it.
    Return the distance of each fix in the time of the path, in the order of fixes, shape (k,); and the root of the
    mean squared distance of those that are believed, m.
    """
    inside = fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])]
    at = np.column_stack([np.interp(inside[:, 0], t, path[:, i]) for i in (0, 1)])
    d = np.hypot(*(at - inside[:, 1:]).T)
    best = np.sort(d)[: int(share * len(d))]
    return d, np.sqrt(np.mean(best**2))


def case(rng, share, far=0.0, m=40, g=60, bad=6):
    """Return a path, fixes in time order but for two, some of them outside, some of them wrong, one very far."""
    t = 3.0 + np.cumsum(rng.uniform(0.1, 0.6, m))
    path = np.cumsum(rng.normal(size=(m, 2)) + [1.0, 0.3], axis=0)
    ft = np.sort(rng.uniform(t[0] - 4, t[-1] + 4, g))
    at = np.column_stack([np.interp(ft, t, path[:, i]) for i in (0, 1)]) + 0.5 * rng.normal(size=(g, 2))
    at[rng.choice(g, bad, replace=False)] += rng.uniform(20, 60, (bad, 2))
    at[g // 2] += far
    ft[[10, 20]], at[[10, 20]] = ft[[20, 10]], at[[20, 10]]
    return t, path, np.column_stack([ft, at]), share


HAND = np.array([[2.5, 2.5, 3.0], [5.0, 9.0, 3.0], [10.0, 10.0, 0.0], [0.0, 0.0, 1.0], [10.1, 10.0, 0.0]])

gps = table(
    "19.4 A path compared with GPS",
    gps_error,
    hints=(
        "Laser and GPS have different times. Which fixes can be compared at all, and where was the path then?",
        "np.interp interpolates x and y, but beyond the ends it repeats the last value without a word: drop those fixes before.",
        "d = distance of each fix that is left; np.sort(d)[: int(share * len(d))] are believed; root of the mean of their squares.",
    ),
    returns="d, error",
    cases={
        "any": lambda rng: [case(rng, share) for share in (0.95, 0.5, 1.0, 0.7, 0.29)],
        "by hand": lambda rng: [(np.array([0.0, 10.0]), np.array([[0.0, 0.0], [10.0, 0.0]]), HAND, 1.0)],
        "far": lambda rng: [case(rng, 0.8, 1000.0)],
    },
    checks="""
    in the time of the path | d     | by hand | One distance for each fix between the first and the last time of the path: from the path at that time, x and y, to columns 1 and 2 of the fix.
    distances               | d     | any     | Where was the path at the time of the fix? On the line between two of its positions. One distance, in metres, for each fix in the time of the path, in the order of fixes: their times may come in any order.
    error                   | error | any     | Sort the distances, keep the nearest, int(share * g) of them, then the root of the mean square.
    wrong fixes             | error | far     | Fixes that jump by 100 m must not change the error of the rest.
    """,
    wrong="""
    beyond the ends | fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])] -> fixes | np.interp repeats the last position beyond the ends, without a word. Drop the fixes before the first and after the last time.
    without the ends | (fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1]) -> (fixes[:, 0] > t[0]) & (fixes[:, 0] < t[-1]) | A fix at the first or the last time of the path is in its time: >= and <=.
    nearest time | at = np.column_stack([np.interp(inside[:, 0], t, path[:, i]) for i in (0, 1)]) -> at = path[np.abs(t - inside[:, :1]).argmin(1)] | Between two positions the truck has moved on: interpolate between them.
    last position before | at = np.column_stack([np.interp(inside[:, 0], t, path[:, i]) for i in (0, 1)]) -> at = path[np.searchsorted(t, inside[:, 0], side="right") - 1] | The truck has moved on since then: interpolate.
    nearest point of the path | np.hypot(*(at - inside[:, 1:]).T) -> np.linalg.norm(path - inside[:, None, 1:], axis=2).min(1) | GPS says when, too. The nearest point of the whole path hides errors along it.
    distances sorted | return d, -> return np.sort(d), | d is in the order of fixes: sort a copy for the error.
    squared distances | np.hypot(*(at - inside[:, 1:]).T) -> np.hypot(*(at - inside[:, 1:]).T) ** 2 | d is in metres: take the root.
    x and y added | np.hypot(*(at - inside[:, 1:]).T) -> np.abs(at - inside[:, 1:]).sum(1) | The distance is the root of dx^2 + dy^2.
    all fixes believed | best = np.sort(d)[: int(share * len(d))] -> best = d | Some fixes are wrong by 100 m, and squares make them loud: keep the nearest share only.
    first ones instead of nearest | np.sort(d)[: -> d[: | Sort the distances first: the nearest are believed, not the first.
    worst ones kept | np.sort(d)[: -> np.sort(d)[::-1][: | The *nearest* share is believed.
    the wrong share dropped | int(share * len(d)) -> max(int((1 - share) * len(d)), 1) | share is the part that is kept.
    rounded up | int(share * len(d)) -> int(np.ceil(share * len(d))) | int(share * g) drops the decimals: of 47.9 fixes 47 are believed.
    rounded to the nearest | int(share * len(d)) -> round(share * len(d)) | int(share * g) drops the decimals, round may go up: of 47.9 fixes 47 are believed.
    share of all fixes | int(share * len(d)) -> int(share * len(fixes)) | The share is of the fixes beside the path, not of all that were handed over.
    mean distance | np.sqrt(np.mean(best**2)) -> np.mean(best) | The root of the mean *square*.
    median | np.sqrt(np.mean(best**2)) -> np.median(best) | A median is a fine number, too, but asked is the root of the mean square.
    no root | np.sqrt(np.mean(best**2)) -> np.mean(best**2) | That is in square metres: take the root.
    divided by all | np.mean(best**2) -> np.sum(best**2) / len(d) | The mean is over those that are believed.
    limit of the quantile | np.sqrt(np.mean(best**2)) -> best[-1] | That is the largest distance believed, not their root mean square.
    sorted by time | inside = fixes -> fixes = fixes[np.argsort(fixes[:, 0])]; inside = fixes | d is in the order of fixes, as they were handed over: they are not sorted by their times.
    mean square for each axis | np.mean(best**2) -> np.mean(best**2) / 2 | The mean is over the fixes: dx^2 + dy^2 is one square, not two.
    trimmed on both sides | np.sort(d)[: int(share * len(d))] -> np.sort(d)[(len(d) - int(share * len(d))) // 2 :][: int(share * len(d))] | Only far fixes are dropped: the nearest are believed, all of them.
    """,
)
