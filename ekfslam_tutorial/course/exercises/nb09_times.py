"""Exercise 09.1: rows of a log in the order of time."""

import numpy as np

from .. import expect
from ..table import table


def by_time(rows):
    """Put the rows of a log into the order of time, and say what was wrong with them.

    rows, shape (m, c), m at least 2: column 0 is the time stamp in s, the other columns belong to it.
    Rows with the same stamp keep their order.
    Return the sorted rows, shape (m, c); how many rows have an earlier stamp than the row before them in the file;
    and the longest time between two neighbours after sorting, s.
    """
    late = int(np.sum(np.diff(rows[:, 0]) < 0))
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return rows, late, np.max(np.diff(rows[:, 0]))


SIZES = (40, 4, 5, 5.0), (12, 3, 3, 0.0), (25, 2, 3, -3.0), (60, 2, 12, 1e3), (17, 3, 1, 0)


def log(rng, m, c, late=3, start=0.0, steps=(0.0, 0.125, 0.25, 1.5)):
    """Rows with stamps that rise, some equal, and a few rows that come too late."""
    t = start + np.cumsum(rng.choice(steps, m))
    order = np.arange(m)
    for k in rng.choice(np.arange(0, m - 3, 4), min(late, (m - 1) // 4), replace=False):
        order[k : k + 4] = np.roll(order[k : k + 4], 1)
    return np.column_stack([t, rng.normal(size=(m, c - 1))])[order]


def shuffled(rng, m):
    """Rows in no order at all, with few different stamps: a sort that is not stable shows."""
    return np.column_stack([rng.integers(0, m // 8, m), rng.normal(size=(m, 2))])


times = table(
    "09.1 Rows in the order of time",
    by_time,
    hints=(
        "The stamps decide the order; each row moves as a whole.",
        "np.argsort(..., kind='stable') gives the order of the rows. np.diff gives the steps from row to row.",
        "Count the negative steps of rows[:, 0] first. Then sort: rows[order]. The longest step of the sorted stamps is the gap.",
    ),
    returns="rows, late, gap",
    cases={
        "any": lambda rng: [(log(rng, *size),) for size in SIZES],
        "no ties": lambda rng: [(log(rng, *size, (0.125, 0.25, 1.5)),) for size in SIZES],  # a sort of any kind will do
        "good order": lambda rng: [(log(rng, 9, 2, 0),), (log(rng, 2, 2, 0),)],
        "ties": lambda rng: [(shuffled(rng, m),) for m in (24, 200, 400)],
        "small": lambda rng: [
            (np.array(rows),)
            for rows in (
                [[3.0, 4.0], [2.0, 3.0], [1.0, 2.0], [0.0, 1.0]],
                [[5.0, 1.0], [0.0, 2.0], [9.0, 3.0]],
                [[9.0, 1.0], [0.0, 2.0], [1.0, 3.0], [2.0, 4.0]],  # the longest step is the last one; then the first
                [[9.0, 1.0], [0.0, 2.0], [8.0, 3.0]],
                [[1.0, 7.0], [0.0, 8.0]],
                [[2.0, 7.0], [2.0, 8.0]],
            )
        ],
        "stamps": lambda rng: [(np.array([[3.0], [2.0], [1.0], [0.0]]),), (log(rng, 60, 1, 12, 1e3),)],
    },
    checks="""
    good order  | rows | good order | These rows are in the order of time already: they come out as they are. Each row moves as a whole: find the order from column 0, then take rows[order].
    sorted      | rows | no ties    | The same rows, so that the stamps rise (or stay equal) from row to row: find the order from column 0, then take rows[order]. Each row moves as a whole.
    a few rows  | rows | small      | The same rows, so that the stamps rise (or stay equal) from row to row: find the order from column 0, then take rows[order]. Each row moves as a whole.
    a few rows: late | late | small      | late is how many rows have an earlier stamp than the row just before them, in the order of the file: count the steps with np.diff(...) < 0.
    equal stamps: rows | rows | ties      | Here the rows are in no order at all, and many have the same stamp. Sort them by the stamp; rows with the same stamp keep their order: kind="stable".
    equal stamps: late | late | ties      | Here the rows are in no order at all, and many have the same stamp. A row is late if its stamp is earlier than that of the row just before it in the file; an equal stamp is in order.
    none late   | late | good order | Here the rows are in the order of time: no row has an earlier stamp than the row just before it in the file, so late is 0.
    late rows   | late | any        | late is how many rows have an earlier stamp than the row just before them, in the order of the file: count the steps back, np.diff(...) < 0.
    gap         | gap  | any        | The longest step between two neighbours of the sorted rows, in seconds.
    stamps alone | rows, late, gap | stamps | A log of one column has stamps only: the same is asked of it.
    gap of few  | gap  | small      | The longest of the m - 1 steps between neighbours of the sorted rows, in seconds. Two rows have one step.
    """,
    wrong="""
    each column sorted by itself | rows = rows[np.argsort(rows[:, 0], kind="stable")] -> rows = np.sort(rows, axis=0) | Each column comes out sorted by itself, as np.sort(rows, axis=0) does it: stamps and measurements no longer belong together.
    not sorted | return rows, late -> return file, late | The rows still have the order of the file.
        late = int( -> file = rows; late = int(
    latest first | return rows, late -> return rows[::-1], late | Time must rise from row to row.
    equal stamps lose their order | np.argsort(rows[:, 0], kind="stable") -> np.lexsort((*rows.T[:0:-1], rows[:, 0])) | Rows with the same stamp must keep their order: use a stable sort and the stamp alone.
    a sort that is not stable | , kind="stable")] -> )] | np.argsort alone may put rows with the same stamp into another order: kind="stable".
    equal stamps turned round | rows = rows[np.argsort(rows[:, 0], kind="stable")] -> rows = rows[::-1][np.argsort(rows[::-1, 0], kind="stable")] | Rows with the same stamp must keep their order: yours comes out the other way round.
    rows of equal stamps dropped | np.argsort(rows[:, 0], kind="stable") -> np.unique(rows[:, 0], return_index=True)[1] | One row of each stamp is left, as np.unique does it. Two sightings in one picture have the same stamp: all rows stay.
    counted after sorting | int(np.sum(np.diff(rows[:, 0]) < 0)) -> 0 | After sorting no row is late. Count the steps back in the rows as they come.
    rows that moved | np.sum(np.diff(rows[:, 0]) < 0) -> np.sum(np.argsort(rows[:, 0], kind="stable") != np.arange(len(rows))) | One late row pushes many others. Count rows whose stamp is earlier than that of the row before.
    behind the latest so far | np.diff(rows[:, 0]) < 0 -> rows[:, 0] < np.maximum.accumulate(rows[:, 0]) | Compare each row with the row just before it in the file, not with the latest stamp so far.
    before the first | np.diff(rows[:, 0]) < 0 -> rows[1:, 0] < rows[0, 0] | Compare each row with the row just before it in the file, not with the first one.
    equal stamps counted as late | < 0 -> <= 0 | Two sightings in one picture have the same stamp: that is no fault. Count steps below zero only.
    gap before sorting | late, np.max(np.diff(rows[:, 0])) -> late, gap | Rows out of order make steps that never were. Sort first, then look for the longest step.
        late = int( -> gap = np.max(np.diff(rows[:, 0])); late = int(
    length of the log | np.max(np.diff(rows[:, 0])) -> np.ptp(rows[:, 0]) | That is the time from the first row to the last, not the longest step between neighbours.
    last step left out | np.max(np.diff(rows[:, 0])) -> np.max(np.diff(rows[:-1, 0]), initial=0) | m rows have m - 1 steps: yours leaves out the one to the last row.
    first step left out | np.max(np.diff(rows[:, 0])) -> np.max(np.diff(rows[1:, 0]), initial=0) | m rows have m - 1 steps: yours leaves out the one from the first row.
    typical step | np.max( -> np.mean( | The longest step is wanted: np.max, not a mean.
    latest first, else in order | return rows, late -> return rows[np.argsort(-rows[:, 0], kind="stable")], late | Time must rise from row to row.
    longest step of the file, either way | late, np.max(np.diff(rows[:, 0])) -> late, gap | Rows out of order make steps that never were. Sort first, then look for the longest step.
        late = int( -> gap = np.max(np.abs(np.diff(rows[:, 0]))); late = int(
    whether any is late | int(np.sum(np.diff(rows[:, 0]) < 0)) -> int(np.any(np.diff(rows[:, 0]) < 0)) | *How many* rows are late: count them. Yours says only whether there is one.
    rows in order counted | < 0)) -> >= 0)) | A row is late if its stamp is *earlier* than that of the row before: count the steps below zero.
    """,
)


@times.link("stamps of a computer", "Seconds since 1970 need all digits of a float.", 0, before="none late")
def _(f, rng):
    rows = log(rng, 30, 3, start=1.25e9)
    got = expect.array(expect.results(f(rows), "rows", "late", "gap")[0], rows.shape, "rows")
    expect.close(got, by_time(rows)[0], "rows", rtol=1e-11, at="stamps that begin at 1.25e9 s")
