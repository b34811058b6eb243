"""Exercise 09.1: rows of a log in the order of time."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def by_time(rows):
    """Put the rows of a log into the order of time, and say what was wrong with them.

    rows, shape (m, c), m at least 2: column 0 is the time stamp in s, the other columns belong to it.
    Rows with the same stamp keep their order.
    Return the sorted rows, shape (m, c); how many rows have an earlier stamp than the row before them in the file;
    and the longest time between two neighbours after sorting, s.
    """
    late = np.sum(np.diff(rows[:, 0]) < 0)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return rows, late, np.max(np.diff(rows[:, 0]))


times = Exercise(
    "09.1",
    "Rows in the order of time",
    by_time,
    hints=(
        "The stamps decide the order; each row moves as a whole.",
        "np.argsort(..., kind='stable') gives the order of the rows. np.diff gives the steps from row to row.",
        "Count the negative steps of rows[:, 0] first. Then sort: rows[order]. The longest step of the sorted stamps "
        "is the gap.",
    ),
)


def log(rng, m, c, late=3, start=1.25e9):
    """Rows with stamps that rise, some equal, and a few rows that come too late."""
    t = start + np.cumsum(rng.choice([0.0, 0.125, 0.25, 1.5], m))
    order = np.arange(m)
    for k in rng.choice(np.arange(0, m - 3, 4), min(late, (m - 1) // 4), replace=False):
        order[k : k + 4] = np.roll(order[k : k + 4], 1)
    return np.column_stack([t, rng.normal(size=(m, c - 1))])[order]


def _three(result, rows):
    out, late, gap = expect.results(result, "rows", "late", "gap")
    return (
        expect.array(out, rows.shape, "rows"),
        float(expect.array(late, (), "late")),
        float(expect.array(gap, (), "gap")),
    )


@times.link("three results", "The function must end with `return rows, late, gap`: an array and two numbers.")
def _(f, rng):
    for m, c in ((30, 4), (8, 3), (2, 2)):
        rows = log(rng, m, c)
        _three(f(rows), rows)


@times.link("sorted", "Each row moves as a whole: find the order from column 0, then take rows[order].", part=0)
def _(f, rng):
    for m, c, start in (
        (40, 4, 1.25e9),
        (12, 3, 0.0),
        (25, 2, -3.0),
        (60, 1, 1e6),
        (30, 4, 5.0),
        (2, 2, 0.0),
        (4, 4, 9.0),
    ):
        rows = log(rng, m, c, start=start)
        expect.close(_three(f(rows), rows)[0], by_time(rows)[0], "rows", rtol=1e-11, at="a log with equal stamps")


@times.link("late rows", "Count the steps back in the *file*, before you sort: np.diff(...) < 0.", part=1)
def _(f, rng):
    rows = log(rng, 9, 2, 0)
    expect.close(_three(f(rows), rows)[1], 0, "late", at="a log in good order")
    for m, late in ((40, 5), (60, 12), (17, 1)):
        rows = log(rng, m, 3, late)
        expect.close(_three(f(rows), rows)[1], by_time(rows)[1], "late", at="a log with rows out of order")
    expect.close(_three(f(np.array([[3.0], [2.0], [1.0], [0.0]])), np.zeros((4, 1)))[1], 3, "late", at="3, 2, 1, 0 s")


@times.link("gap", "The longest step between neighbours *after* sorting, in seconds.", part=2)
def _(f, rng):
    for m in (40, 25, 5):
        rows = log(rng, m, 3, 4, start=100.0)
        expect.close(_three(f(rows), rows)[2], by_time(rows)[2], "gap", at="a log with gaps")
    rows = np.array([[5.0, 1.0], [0.0, 2.0], [9.0, 3.0]])
    expect.close(_three(f(rows), rows)[2], 5.0, "gap", at="stamps 5, 0, 9 s")


def _wrong(name, hint, order=None, late=None, gap=None):
    """A misconception in one of the three results, as functions of the rows."""

    @times.wrong(name, hint)
    def _(rows):
        a, b, c = by_time(rows)
        return order(rows) if order else a, late(rows) if late else b, gap(rows) if gap else c


_wrong(
    "each column sorted by itself",
    "np.sort(rows, axis=0) sorts every column alone: stamps and measurements no longer belong together.",
    lambda r: np.sort(r, axis=0),
)
_wrong("not sorted", "The rows still have the order of the file.", lambda r: r.copy())
_wrong("latest first", "Time must rise from row to row.", lambda r: by_time(r)[0][::-1].copy())
_wrong(
    "equal stamps lose their order",
    "Rows with the same stamp must keep their order: use a stable sort and the stamp alone.",
    lambda r: r[np.lexsort((*r.T[:0:-1], r[:, 0]))],
)
_wrong(
    "counted after sorting",
    "After sorting no row is late. Count the steps back in the rows as they come.",
    late=lambda r: 0,
)
_wrong(
    "rows that moved",
    "One late row pushes many others. Count rows whose stamp is earlier than that of the row before.",
    late=lambda r: np.sum(np.argsort(r[:, 0], kind="stable") != np.arange(len(r))),
)
_wrong(
    "equal stamps counted as late",
    "Two sightings in one picture have the same stamp: that is no fault. Count steps below zero only.",
    late=lambda r: np.sum(np.diff(r[:, 0]) <= 0),
)
_wrong(
    "gap before sorting",
    "Rows out of order make steps that never were. Sort first, then look for the longest step.",
    gap=lambda r: np.max(np.diff(r[:, 0])),
)
_wrong(
    "length of the log",
    "That is the time from the first row to the last, not the longest step between neighbours.",
    gap=lambda r: np.ptp(r[:, 0]),
)
_wrong(
    "typical step",
    "The longest step is wanted: np.max, not a mean.",
    gap=lambda r: np.ptp(r[:, 0]) / (len(r) - 1),
)


@times.variant("sorted with a key, loops, lists")
def _(rows):
    t = [row[0] for row in rows]
    out = sorted((list(row) for row in rows), key=lambda row: row[0])
    gap = max(b[0] - a[0] for a, b in zip(out, out[1:], strict=False))
    return [out, sum(b < a for a, b in zip(t, t[1:], strict=False)), gap]


@times.variant("lexsort with the row number")
def _(rows):
    order = np.lexsort((np.arange(len(rows)), rows[:, 0]))
    steps = np.ediff1d(rows[order, 0])
    return rows[order], np.count_nonzero(rows[1:, 0] < rows[:-1, 0]), steps.max()
