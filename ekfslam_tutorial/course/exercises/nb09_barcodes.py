"""Exercise 09.2: from barcodes to landmarks."""

import numpy as np

from ..table import table


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


def case(rng, m, s, n_robots, spurious=0.1):
    """Return rows, table and robots; some barcodes are also numbers of subjects."""
    codes = rng.choice(np.arange(1, 3 * s + 3), s + 2, replace=False)
    listed = np.column_stack([np.arange(1, s + 1), codes[:s]])
    seen = np.where(rng.random(m) < spurious, rng.choice(codes[s:], m), rng.choice(codes[:s], m))
    rows = np.column_stack([np.cumsum(rng.random(m)), seen, rng.uniform(0.5, 5, m), rng.uniform(-1, 1, m)])
    robots = rng.choice(np.arange(1, s + 1), n_robots, replace=False)
    return rows, listed[rng.permutation(s)], [int(r) for r in robots]


def nothing(rng, robots=False):
    """Return rows that all show robots, or a barcode that nobody wears."""
    rows, listed, found = case(rng, 6, 5, 2)
    rows[:, 1] = listed[listed[:, 0] == found[0], 1] if robots else 99
    return rows, listed, found


barcodes = table(
    "09.2 From barcodes to landmarks",
    landmarks_seen,
    hints=(
        "A barcode is a label that was stuck on a subject. The table says which.",
        "Make a dictionary from barcode to subject. A barcode that is not in it was misread.",
        "subject_of.get(barcode, -1) for each row; keep the rows where it is not -1 and not one of the robots.",
    ),
    returns="times, subjects, measurements",
    cases={
        "any": lambda rng: [
            case(rng, *sizes)
            for sizes in (
                (60, 8, 0, 0.0),
                (60, 20, 5),
                (40, 6, 2, 0.3),
                (25, 4, 1, 0.2),
                (50, 9, 3, 0.2),
                (2, 4, 0, 0.0),
            )
        ],
        "nothing": lambda rng: [nothing(rng), nothing(rng, robots=True)],
    },
    checks="""
    which rows stay | times        | any     | times is column 0 of the rows that stay, in the order of the file. Dropped are the rows whose barcode is not in the table, and those that show a robot; all others stay.
    subjects        | subjects     | any     | One subject for each row that stays, in the order of the rows: look its barcode up in column 1 of the table; the subject is in column 0.
    measurements    | measurements | any     | Columns 2 and 3 of the rows that stay: range and bearing.
    nothing left    | measurements | nothing | Here no row stays, k = 0: return three empty arrays of the shapes (0,), (0,) and (0, 2), np.zeros((0, 2)) for the measurements.
    """,
    wrong="""
    barcode taken for the subject | subject_of.get(barcode, -1) -> barcode | The number in the log is the barcode. Translate it with the table.
    only listed, not translated | subject_of.get(barcode, -1) -> barcode if barcode in subject_of else -1 | Return the subject that wears the barcode, not the barcode.
    columns swapped | {barcode: subject for -> {subject: barcode for | Column 1 of the table holds the barcodes, column 0 the subjects.
    row number for the subject | {barcode: subject for subject, barcode in table} -> {barcode: row + 1 for row, (_, barcode) in enumerate(table)} | The table may be in any order: take the subject from column 0, not the row.
    nearest barcode | subject_of.get(barcode, -1) -> table[np.argmin(abs(table[:, 1] - barcode)), 0] | A barcode that is not in the table was misread. The nearest number is not a better guess.
    searched in a table that is not sorted | subjects = np.array([subject_of.get(barcode, -1) for barcode in rows[:, 1]], int) -> k = np.minimum(np.searchsorted(table[:, 1], rows[:, 1]), len(table) - 1); subjects = np.where(table[k, 1] == rows[:, 1], table[k, 0], -1).astype(int) | np.searchsorted finds something in a sorted array only, and the table may be in any order: sort it by the barcodes first, or take a dictionary.
    misread rows kept | (subjects != -1) & ~np -> ~np | A misread sighting has no subject: drop the row. A wrong landmark would bend the map.
    robots kept | & ~np.isin(subjects, robots) -> & True | Robots move; a landmark must stand still. Drop the rows that show a robot.
    only the robots | (subjects != -1) & ~np -> np | The other way round: keep the landmarks, drop the robots.
    subjects above 5 | (subjects != -1) & ~np.isin(subjects, robots) -> subjects > 5 | Which subjects are robots is the third argument; 1 to 5 is one case only.
    bearing first | rows[keep, 2:] -> rows[keep, 3:1:-1] | The order is [range, bearing], as in the rows.
    robots taken for barcodes | np.isin(subjects, robots) -> np.isin(rows[:, 1], robots) | The list holds subjects, not barcodes: translate first, then drop them.
    all rows measured | rows[keep, 2:] -> rows[:, 2:] | The measurements belong to the rows that stay, too: rows[keep, 2:].
    one axis lost | rows[keep, 2:] -> np.array([row[2:] for row in rows[keep]]) | With no row that stays the measurements still have two columns: shape (0, 2), not (0,).
    stops at the first misread row | keep = (subjects != -1) -> keep = (np.cumsum(subjects == -1) == 0) | Only the misread row is dropped, the rows behind it stay: `continue`, not `break`.
    stops at the first robot | & ~np.isin(subjects, robots) -> & (np.cumsum(np.isin(subjects, robots)) == 0) | Only the rows that show a robot are dropped, those behind them stay: `continue`, not `break`.
    sorted by subject | return rows[keep, 0] -> keep = np.flatnonzero(keep)[np.argsort(subjects[keep], kind="stable")]; return rows[keep, 0] | The rows keep their order, that of time: do not sort them by subject.
    barcode and range for the measurement | rows[keep, 2:] -> rows[keep, 1:3] | The columns are [time, barcode, range, bearing]: range and bearing are the columns 2 and 3.
    misread barcodes kept as subjects | subject_of.get(barcode, -1) -> subject_of.get(barcode, barcode) | A barcode that is not in the table was misread: drop the row. The barcode is no subject.
    grouped by landmark | return rows[keep, 0] -> keep = np.array([k for b in table[:, 1] for k in np.flatnonzero(keep & (rows[:, 1] == b))], int); return rows[keep, 0] | These are the right rows in another order: keep the order of the file.
    all times | rows[keep, 0] -> rows[:, 0] | The times belong to the rows that stay, too: rows[keep, 0].
    times counted from the first row | rows[keep, 0] -> rows[keep, 0] - rows[0, 0] | The times are the stamps as they stand in the log: nothing is subtracted.
    number of the row for the time | rows[keep, 0] -> np.flatnonzero(keep) * 1.0 | The time is in column 0 of the row: rows[keep, 0].
    barcodes of the rows that stay | subjects[keep] -> rows[keep, 1].astype(int) | Return the subject that wears the barcode, not the barcode.
    first sighting only | return rows[keep, 0], -> keep &= np.isin(np.arange(len(rows)), [np.flatnonzero(keep & (subjects == s))[0] for s in set(subjects[keep].tolist())]); return rows[keep, 0], | A landmark is seen many times: each of its rows stays, not the first one only.
    bearing in degrees | rows[keep, 2:] -> rows[keep, 2:] * [1, 180 / np.pi] | The measurements stay as they are in the rows: the bearing in radians.
    first row of the table for not found | subject_of.get(barcode, -1) for barcode -> (subject_of.get(barcode, -1) if len(table) and barcode != table[0][0] else -1) for barcode | The subject in the first row of the table is missing. That row has the index 0, and 0 counts as False: ask whether a row was found, not for its number.
    subjects above the number of robots | ~np.isin(subjects, robots) -> (subjects > len(robots)) | The list says which subjects are robots, and that may be any: ask whether a subject is in the list.
    subjects above the highest robot | ~np.isin(subjects, robots) -> (subjects > max(robots, default=0)) | The list says which subjects are robots, and that may be any: ask whether a subject is in the list.
    """,
)
