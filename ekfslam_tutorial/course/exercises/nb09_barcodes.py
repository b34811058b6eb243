"""Exercise 09.2: from barcodes to landmarks."""

import numpy as np

from .. import expect
from ..exercise import Exercise


def landmarks_seen(rows, table, robots):
    """Sightings of landmarks, with the number of each landmark instead of its barcode.

    rows, shape (m, 4): [time, barcode, range, bearing]. table, shape (s, 2): [subject, barcode], in any order.
    robots: list of the subjects that are robots; all other subjects are landmarks.
    Drop the rows whose barcode is not in the table (misread), and the rows that show a robot.
    Return times, shape (k,), subjects, shape (k,), and measurements [range, bearing], shape (k, 2), in the order of
    the rows. k may be 0.
    """
    subject_of = {barcode: subject for subject, barcode in table}
    subjects = np.array([subject_of.get(barcode, -1) for barcode in rows[:, 1]], int)
    keep = (subjects != -1) & ~np.isin(subjects, robots)
    return rows[keep, 0], subjects[keep], rows[keep, 2:]


barcodes = Exercise(
    "09.2",
    "From barcodes to landmarks",
    landmarks_seen,
    hints=(
        "A barcode is a label that was stuck on a subject. The table says which.",
        "Make a dictionary from barcode to subject. A barcode that is not in it was misread.",
        "subject_of.get(barcode, -1) for each row; keep the rows where it is not -1 and not one of the robots.",
    ),
)


def case(rng, m, s, n_robots, spurious=0.1):
    """Return rows, table and robots; some barcodes are also numbers of subjects."""
    codes = rng.choice(np.arange(1, 3 * s + 3), s + 2, replace=False)
    table = np.column_stack([np.arange(1, s + 1), codes[:s]])
    seen = rng.choice(codes[:s], m)
    bad = rng.random(m) < spurious
    seen = np.where(bad, rng.choice(codes[s:], m), seen)
    rows = np.column_stack([np.cumsum(rng.random(m)), seen, rng.uniform(0.5, 5, m), rng.uniform(-1, 1, m)])
    robots = rng.choice(np.arange(1, s + 1), n_robots, replace=False)
    return rows, table[rng.permutation(s)], [int(r) for r in robots]


def _three(result, k=None):
    t, ids, y = expect.results(result, "times", "subjects", "measurements")
    n = np.shape(t)[0] if k is None and np.ndim(t) else k
    ids, t = expect.array(ids, (n,), "subjects"), expect.array(t, (n,), "times")
    if n == 0 and np.size(y) == 0:
        return t, ids, np.zeros((0, 2))
    return t, ids, expect.array(y, (n, 2), "measurements")


@barcodes.link("three results", "The function must end with `return times, subjects, measurements`.")
def _(f, rng):
    for m, s, n in ((30, 8, 2), (5, 3, 1)):
        t, ids, y = expect.results(f(*case(rng, m, s, n)), "times", "subjects", "measurements")
        expect.true(np.ndim(t) == 1 and np.ndim(ids) == 1, "times and subjects must have one axis each")
        expect.true(
            len(t) == len(ids) == len(y), f"there are {len(t)} times, {len(ids)} subjects, {len(y)} measurements"
        )


@barcodes.link(
    "which rows stay", "Drop the barcodes that are not in the table, and the robots. Keep all others.", part=0
)
def _(f, rng):
    for m, s, n, share in ((60, 8, 0, 0.0), (60, 20, 5, 0.1), (40, 6, 2, 0.3), (25, 4, 1, 0.2), (50, 9, 3, 0.2)):
        rows, table, robots = case(rng, m, s, n, share)
        want = landmarks_seen(rows, table, robots)[0]
        got = np.asarray(expect.results(f(rows, table, robots), "times", "subjects", "measurements")[0], float)
        expect.true(got.shape == want.shape, f"{got.size} of {m} sightings stay, {want.size} should")
        expect.close(got, want, "times")


@barcodes.link("subjects", "Look the barcode up in column 1 of the table; the subject is in column 0.", part=1)
def _(f, rng):
    for m, s, n in ((60, 20, 5), (30, 6, 1), (40, 5, 0)):
        rows, table, robots = case(rng, m, s, n)
        want = landmarks_seen(rows, table, robots)[1]
        expect.close(_three(f(rows, table, robots), len(want))[1], want, "subjects")


@barcodes.link("measurements", "Columns 2 and 3 of the rows that stay: range and bearing.", part=2)
def _(f, rng):
    for m, s, n, share in ((40, 20, 5, 0.1), (30, 6, 1, 0.1), (2, 4, 0, 0.0), (5, 3, 1, 0.1)):
        rows, table, robots = case(rng, m, s, n, share)
        want = landmarks_seen(rows, table, robots)[2]
        expect.close(_three(f(rows, table, robots), len(want))[2], want, "measurements")


@barcodes.link("nothing left", "With no row that stays, return empty arrays, do not fail.")
def _(f, rng):
    rows, table, robots = case(rng, 6, 5, 2)
    rows[:, 1] = 99
    _three(f(rows, table, robots), 0)


def _wrong(name, hint, number, stays=lambda ids, robots: (ids != -1) & ~np.isin(ids, robots), columns=slice(2, 4)):
    """A misconception in the number that stands for a barcode, or in which rows stay."""

    @barcodes.wrong(name, hint)
    def _(rows, table, robots):
        ids = np.array([number(code, table) for code in rows[:, 1]], int).reshape(-1)
        keep = stays(ids, robots)
        return rows[keep, 0], ids[keep], rows[keep, columns]


def _right(code, table):
    at = np.flatnonzero(table[:, 1] == code)
    return table[at[0], 0] if len(at) else -1


# fmt: off
_wrong("barcode taken for the subject", "The number in the log is the barcode. Translate it with the table.",
       lambda c, table: c)
_wrong("only listed, not translated", "Return the subject that wears the barcode, not the barcode.",
       lambda c, table: c if c in table[:, 1] else -1)
_wrong("columns swapped", "Column 1 of the table holds the barcodes, column 0 the subjects.",
       lambda c, table: next((b for s, b in table if s == c), -1))
_wrong("row number for the subject", "The table may be in any order: take the subject from column 0, not the row.",
       lambda c, table: next((i + 1 for i, b in enumerate(table[:, 1]) if b == c), -1))
_wrong("nearest barcode", "A barcode that is not in the table was misread. The nearest number is not a better guess.",
       lambda c, table: table[np.argmin(abs(table[:, 1] - c)), 0])
_wrong("misread rows kept", "A misread sighting has no subject: drop the row. A wrong landmark would bend the map.",
       _right, lambda ids, robots: ~np.isin(ids, robots))
_wrong("robots kept", "Robots move; a landmark must stand still. Drop the rows that show a robot.",
       _right, lambda ids, robots: ids != -1)
_wrong("only the robots", "The other way round: keep the landmarks, drop the robots.",
       _right, lambda ids, robots: np.isin(ids, robots))
_wrong("subjects above 5", "Which subjects are robots is the third argument; 1 to 5 is one case only.",
       _right, lambda ids, robots: ids > 5)
_wrong("bearing first", "The order is [range, bearing], as in the rows.", _right, columns=slice(3, 1, -1))
# fmt: on


@barcodes.wrong("robots taken for barcodes", "The list holds subjects, not barcodes: translate first, then drop them.")
def _(rows, table, robots):
    ids = np.array([_right(c, table) for c in rows[:, 1]], int).reshape(-1)
    keep = (ids != -1) & ~np.isin(rows[:, 1], robots)
    return rows[keep, 0], ids[keep], rows[keep, 2:]


@barcodes.variant("a loop, lists")
def _(rows, table, robots):
    t, ids, y = [], [], []
    for time, code, r, b in rows:
        for subject, barcode in table:
            if barcode == code and subject not in list(robots):
                t.append(time)
                ids.append(int(subject))
                y.append([r, b])
    return t, ids, y


@barcodes.variant("comparison of all with all")
def _(rows, table, robots):
    landmarks = table[~np.isin(table[:, 0], robots)]
    row, entry = np.nonzero(rows[:, 1][:, None] == landmarks[:, 1])
    return rows[row, 0], landmarks[entry, 0], rows[row][:, [2, 3]]
