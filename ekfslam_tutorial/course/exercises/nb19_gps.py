"""Exercise 19.4: a path beside GPS, which is no truth."""

import numpy as np

from .. import expect
from ..exercise import Exercise


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


gps = Exercise(
    "19.4",
    "A path beside GPS",
    gps_error,
    hints=(
        "Laser and GPS have different times. Which fixes can be compared at all, and where was the path then?",
        "np.interp interpolates x and y, but beyond the ends it repeats the last value without a word: drop those "
        "fixes "
        "before.",
        "d = distance of each fix that is left; np.sort(d)[: int(share * len(d))] are believed; root of the mean of "
        "their squares.",
    ),
)


def case(rng, m=40, g=60, bad=6):
    """Return a path, fixes in time order but for two, some of them outside, some of them wrong."""
    t = 3.0 + np.cumsum(rng.uniform(0.1, 0.6, m))
    path = np.cumsum(rng.normal(size=(m, 2)) + [1.0, 0.3], axis=0)
    ft = np.sort(rng.uniform(t[0] - 4, t[-1] + 4, g))
    at = np.column_stack([np.interp(ft, t, path[:, i]) for i in (0, 1)]) + 0.5 * rng.normal(size=(g, 2))
    wrong = rng.choice(g, bad, replace=False)
    at[wrong] += rng.uniform(20, 60, (bad, 2))
    ft[[10, 20]], at[[10, 20]] = ft[[20, 10]], at[[20, 10]]
    return t, path, np.column_stack([ft, at])


def _two(result, k):
    d, error = expect.results(result, "d", "error")
    return expect.array(d, k, "d"), float(expect.array(error, (), "error"))


@gps.link("two results", "The function must end with `return d, error`.")
def _(f, rng):
    d, error = expect.results(f(*case(rng), 0.95), "d", "error")
    expect.true(d is not None and error is not None, "a result is None")


@gps.link(
    "in the time of the path", "One distance for each fix between the first and the last time of the path.", part=0
)
def _(f, rng):
    for _ in range(3):
        args = case(rng)
        d = expect.results(f(*args, 0.95), "d", "error")[0]
        want = len(gps_error(*args, 0.95)[0])
        expect.true(np.ndim(d) == 1 and len(d) == want, f"d has shape {np.shape(d)}: of {len(args[2])} fixes {want} "
       f"are "
                    "in the time of the path")  # fmt: skip


@gps.link("distances", "Where was the path at the time of the fix? On the line between two of its positions.", part=0)
def _(f, rng):
    for _ in range(3):
        args = case(rng)
        want = gps_error(*args, 0.9)[0]
        expect.close(_two(f(*args, 0.9), len(want))[0], want, "d", 1e-6)
    t, path = np.array([0.0, 10.0]), np.array([[0.0, 0.0], [10.0, 0.0]])
    fixes = np.array([[2.5, 2.5, 3.0], [5.0, 9.0, 3.0], [10.0, 10.0, 0.0], [0.0, 0.0, 1.0], [10.1, 10.0, 0.0]])
    expect.close(_two(f(t, path, fixes, 1.0), 4)[0], [3, 5, 0, 1], "d", at="a straight path and five fixes by hand")


@gps.link("error", "Sort the distances, keep the nearest, then the root of the mean square.", part=1)
def _(f, rng):
    for share in (0.95, 0.5, 1.0, 0.7):
        args = case(rng)
        d, want = gps_error(*args, share)
        expect.close(_two(f(*args, share), len(d))[1], want, "error", 1e-6, at=f"a share of {share}")


@gps.link("wrong fixes", "Fixes that jump by 100 m must not change the error of the rest.", part=1)
def _(f, rng):
    t, path, fixes = case(rng, bad=1)
    one = gps_error(t, path, fixes, 0.8)
    far = fixes.copy()
    inside = np.flatnonzero((fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1]))
    far[inside[np.argmax(one[0])], 1:] += 1000.0
    got = _two(f(t, path, far, 0.8), len(one[0]))[1]
    expect.close(got, gps_error(t, path, far, 0.8)[1], "error", 1e-6, at="one fix that is 1000 m off")


def _wrong(name, hint, d=None, error=None, inside=True):
    """A misconception in the distances d(t, path, fixes) or in error(d, share)."""

    @gps.wrong(name, hint)
    def _(t, path, fixes, share):
        f = fixes[(fixes[:, 0] >= t[0]) & (fixes[:, 0] <= t[-1])] if inside else fixes
        if d:
            far = d(t, path, f)
        else:
            far = np.hypot(*(np.column_stack([np.interp(f[:, 0], t, path[:, i]) for i in (0, 1)]) - f[:, 1:]).T)
        n = int(share * len(far))
        return far, error(far, share) if error else np.sqrt(np.mean(np.sort(far)[:n] ** 2))


def _at(pick):
    """Distances to the position of the path with the index pick(t, times)."""
    return lambda t, path, f: np.hypot(*(path[pick(t, f[:, 0])] - f[:, 1:]).T)


def _best(d, share):
    return np.sort(d)[: int(share * len(d))]


# fmt: off
_wrong("beyond the ends", "np.interp repeats the last position beyond the ends, without a word. Drop the fixes before "
       "the "
       "first and after the last time.", inside=False)
_wrong("nearest time", "At 3 m/s half a step is half a metre. Interpolate between the two positions.",
       d=_at(lambda t, f: abs(t[None] - f[:, None]).argmin(1)))
_wrong("last position before", "The truck has moved on since then: interpolate.",
       d=_at(lambda t, f: np.searchsorted(t, f, side="right") - 1))
_wrong("nearest point of the path", "GPS says when, too. The nearest point of the whole path hides errors along it.",
       d=lambda t, path, f: np.linalg.norm(path[None] - f[:, None, 1:], axis=2).min(1))
_wrong("distances sorted", "d is in the order of fixes: sort a copy for the error.",
       d=lambda t, path, f: np.sort(gps_error(t, path, f, 1.0)[0]))
_wrong("squared distances", "d is in metres: take the root.",
       d=lambda t, path, f: gps_error(t, path, f, 1.0)[0] ** 2)
_wrong("x and y added", "The distance is the root of dx^2 + dy^2.",
       d=lambda t, path, f: sum(abs(np.interp(f[:, 0], t, path[:, i]) - f[:, 1 + i]) for i in (0, 1)))
_wrong("all fixes believed", "Some fixes are wrong by 100 m, and squares make them loud: keep the nearest share only.",
       error=lambda d, share: np.sqrt(np.mean(d**2)))
_wrong("first ones instead of nearest", "Sort the distances first: the nearest are believed, not the first.",
       error=lambda d, share: np.sqrt(np.mean(d[: int(share * len(d))] ** 2)))
_wrong("worst ones kept", "The *nearest* share is believed.",
       error=lambda d, share: np.sqrt(np.mean(np.sort(d)[::-1][: int(share * len(d))] ** 2)))
_wrong("the wrong share dropped", "share is the part that is kept.",
       error=lambda d, share: np.sqrt(np.mean(np.sort(d)[: max(int((1 - share) * len(d)), 1)] ** 2)))
_wrong("mean distance", "The root of the mean *square*.", error=lambda d, share: np.mean(_best(d, share)))
_wrong("median", "A median is a fine number, too, but asked is the root of the mean square.",
       error=lambda d, share: np.median(_best(d, share)))
_wrong("no root", "That is in square metres: take the root.", error=lambda d, share: np.mean(_best(d, share) ** 2))
_wrong("divided by all", "The mean is over those that are believed.",
       error=lambda d, share: np.sqrt(np.sum(_best(d, share) ** 2) / len(d)))
_wrong("limit of the quantile", "That is the largest distance believed, not their root mean square.",
       error=lambda d, share: _best(d, share)[-1])
# fmt: on


@gps.variant("a loop over the fixes, lists")
def _(t, path, fixes, share):
    d = []
    for time, x, y in fixes:
        if t[0] <= time <= t[-1]:
            i = min(max(int(np.searchsorted(t, time)), 1), len(t) - 1)
            w = (time - t[i - 1]) / (t[i] - t[i - 1])
            p = (1 - w) * path[i - 1] + w * path[i]
            d.append(float(np.hypot(p[0] - x, p[1] - y)))
    best = sorted(d)[: int(share * len(d))]
    return d, (sum(v * v for v in best) / len(best)) ** 0.5


@gps.variant("complex numbers, partition")
def _(t, path, fixes, share):
    f = fixes[np.logical_and(fixes[:, 0] >= t[0], fixes[:, 0] <= t[-1])]
    p = np.interp(f[:, 0], t, path[:, 0]) + 1j * np.interp(f[:, 0], t, path[:, 1])
    d = abs(p - f[:, 1] - 1j * f[:, 2])
    n = int(share * len(d))
    return d, np.linalg.norm(np.partition(d, n - 1)[:n]) / np.sqrt(n)
