"""Files of anybody as tables: named columns of numbers, NaN where a cell has none."""

import re
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import takewhile
from pathlib import Path

import numpy as np

from ...geometry import q2e
from ...toolbox.files.archives import check_regular, read_npz
from ...toolbox.user_input import errors_at
from ..matlab import read_mat
from .bags import is_bag, read_bag
from .fleet import below
from .lines import LINES, read_lines
from .meaning import LINE, find, plain

TEXT = {".csv", ".tsv", ".txt", ".dat", ".log", ""}
KNOWN = (
    "text in columns (.csv, .tsv, .txt, .dat, .log), JSON lines (.jsonl), .mat, .npz, ROS bags (.bag, .mcap, .db3, or "
    "a folder)"
)
MOST_KINDS = 12
"""Lines that begin with one of so many words are of so many kinds."""
PROSE = {"readme", "license", "licence", "copying"}
"""Files of these names are for people."""
TUM = "t x y z qx qy qz qw"
HEX = re.compile(r"0x[0-9a-f]+", re.IGNORECASE)
DAY = 86400.0
CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(\.\d*)?)")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf)", re.IGNORECASE)


@dataclass(frozen=True)
class Table:
    """Columns of one file, of one kind of lines in it, or of one topic of a bag.

    Parameters
    ----------
    name : str
    columns : dict of str to ndarray, shape (n,)
        Columns without a name have their number, from "1".
    notes : list of str
        What a reader should know.
    kind : str
        Type of the messages of a topic.
    frame : str
        Frame in which they are, by their headers.
    mounts : dict of str to (str, ndarray)
        Of `/tf_static`: the frame that carries a frame, and its pose [t; q] there.
    words : dict of str to dict of str to int
        Of columns that hold words: the number that stands for each.
    """

    name: str
    columns: dict
    notes: tuple = ()
    kind: str = ""
    frame: str = ""
    mounts: dict = field(default_factory=dict)
    words: dict = field(default_factory=dict)

    def __len__(self):
        return len(next(iter(self.columns.values()), ()))


def read_tables(path):
    """Read a log.

    Parameters
    ----------
    path : path
        A file, or a folder of files.

    Returns
    -------
    list of Table

    Raises
    ------
    FileNotFoundError
    ValueError
        One sentence that names the file.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(f"there is no log {path}")
    if is_bag(path):
        return [Table(*parts) for parts in read_bag(path)]
    if path.is_dir():
        files = _files(path)
        if not files:
            return _of_folders(path)
        return with_common_words([table for file in files for table in read_tables(file)])
    kind = path.suffix.lower()
    if kind not in TEXT | LINES | {".mat", ".npz"}:
        raise ValueError(f"{path}: files {kind} are not known; known are {KNOWN}")
    with errors_at(path):
        check_regular(path)
    if kind in LINES:
        tables = [_table(path, name, [*rows[0]], [[*row.values()] for row in rows]) for name, rows in read_lines(path)]
    else:
        tables = _text(path) if kind in TEXT else _arrays(path, read_mat(path) if kind == ".mat" else _npz(path))
    tables = [part for table in tables for part in _unrolled(_by_signal(table))]
    if not any(len(table) for table in tables):
        raise ValueError(f"{path} holds no rows of numbers")
    return with_common_words([table for table in tables if len(table)])


def _of_folders(path):
    """Tables of a folder with a folder for each robot: those of the same name become one."""
    folders = [p for p in sorted(path.iterdir()) if p.is_dir() and _files(p)]
    if len(folders) < 2:
        hint = f"; but its folder {folders[0].name} does" if folders else f"; known are {KNOWN}"
        raise ValueError(f"the folder {path} holds no log{hint}")
    tables = [replace(t, name=f"{folder.name}/{t.name}") for folder in folders for t in read_tables(folder)]
    alike = {}
    for table in with_common_words(tables):
        folder, _, name = table.name.partition("/")
        alike.setdefault(name, {})[folder] = table
    if max(map(len, alike.values())) < 2:
        names = ", ".join(table.name for table in tables)
        raise ValueError(
            f"the folders of {path} have no file of the same name, got {names}; with a robot in each, name them alike"
        )
    return [below(name, of) if len(of) > 1 else next(iter(of.values())) for name, of in alike.items()]


def _files(folder):
    """The files of a folder that may be a part of a log."""
    files = [p for p in sorted(folder.iterdir()) if p.is_file() and p.suffix.lower() in TEXT | LINES | {".mat", ".npz"}]
    return [p for p in files if p.suffix and p.stem.lower() not in PROSE]


def with_common_words(tables):
    """Tables in which a word has the same number everywhere: the places in the alphabet of all words of the log."""
    order = {word: n for n, word in enumerate(sorted({w for t in tables for ws in t.words.values() for w in ws}), 1)}

    def renumbered(table):
        """The table with the numbers of all."""
        columns, words = dict(table.columns), {}
        for name, old in table.words.items():
            new = np.full(max(old.values()) + 1, np.nan)
            new[list(old.values())] = [order[word] for word in old]
            known = np.isfinite(columns[name])
            columns[name] = np.where(known, new[np.where(known, columns[name], 0).astype(int)], np.nan)
            words[name] = {word: order[word] for word in old}
        return replace(table, columns=columns, words=words)

    return [renumbered(table) if table.words else table for table in tables]


def _npz(path):
    with errors_at(path):
        return read_npz(path)


def _arrays(path, arrays):
    """Tables of the arrays of a file: a matrix is one, and all vectors of the same length are one."""
    tables, vectors = [], {}
    wide, rest = _wide(path, arrays)
    for name, a in rest.items():
        if a.dtype.kind not in "iufb" or not a.size:
            continue
        if a.ndim == 2 and min(a.shape) > 1:
            a = a.T if a.shape[0] < a.shape[1] and a.shape[0] <= 12 else a
            tables.append(Table(f"{path.name}/{name}", {str(k): c.astype(float) for k, c in enumerate(a.T, 1)}))
        else:
            vectors.setdefault(a.size, {})[name] = a.reshape(-1).astype(float)
    many = [(n, columns) for n, columns in vectors.items() if n > 1]
    for n, columns in many:
        tables.append(Table(path.name if len(many) == 1 else f"{path.name}/{n}", columns))
    return tables + wide


def _wide(path, arrays):
    """Tables of matrices with a row for each time and a column for each landmark, and of the landmarks; and the rest.

    So homework has it: r and b of shape (K, 17), t of length K, and l of shape (17, 2). Zero or NaN: not seen.
    """
    matrices = {n: a for n, a in arrays.items() if a.ndim == 2 and min(a.shape) > 1 and a.dtype.kind in "iuf"}
    time = next((n for n in arrays if find(Table("", {n: ()}), "t")), None)
    measured = {}
    for name, a in matrices.items():
        meaning = next((m for m in ("range", "bearing", "elevation") if find(Table("", {name: ()}), m)), None)
        if meaning and time is not None and a.shape[0] == arrays[time].size and meaning not in measured:
            measured[meaning] = name
    if "range" not in measured:
        return [], arrays
    shape = arrays[measured["range"]].shape
    names = [name for name in measured.values() if arrays[name].shape == shape]
    seen = np.any([np.nan_to_num(arrays[name]) != 0 for name in names], axis=0)
    rows, columns = np.nonzero(seen)
    found = {"t": arrays[time].reshape(-1)[rows].astype(float), "id": columns + 1.0}
    found |= {name: arrays[name][seen].astype(float) for name in names}
    note = f"{' and '.join(names)} have a column for each of {shape[1]} landmarks, ids 1 to {shape[1]}; 0: not seen"
    tables = [Table(f"{path.name}/{'+'.join(names)}", found, (note,))]
    places = [n for n, a in matrices.items() if a.shape in ((shape[1], 2), (shape[1], 3)) and n not in names]
    for name in places[:1]:
        axes = dict(zip("xyz", arrays[name].T.astype(float), strict=False))
        tables.append(Table(f"{path.name}/{name}", {"id": np.arange(1.0, shape[1] + 1)} | axes))
    return tables, {n: a for n, a in arrays.items() if n not in (*names, *places[:1])}


def _by_signal(table):
    """A table of times, names of signals and values, as of a CAN bus: a column for each signal, at all of its times.

    Between its own times a signal is interpolated; before the first and after the last there is none.
    """
    time, value = find(table, "t"), next((c for c in table.columns if plain(c)[0] in ("value", "val")), None)
    if time is None or value is None or len(table.columns) != 3 or len(table.words) != 1:
        return table
    ((signal, words),) = table.words.items()
    if len(words) > MOST_KINDS or {signal, time, value} != set(table.columns):
        return table
    there = np.isfinite(table.columns[time]) & np.isfinite(table.columns[value])
    t, a, which = (table.columns[name][there] for name in (time, value, signal))
    times = np.unique(t)
    columns, counts = {time: times}, []
    for word, number in words.items():
        own, first = np.unique(t[which == number], return_index=True)
        counts.append(f"{word} {len(own):,}")
        if len(own):
            columns[word] = np.interp(times, own, a[which == number][first], left=np.nan, right=np.nan)
    note = f"a column for each {signal}: {', '.join(counts)} times; interpolated in between"
    return replace(table, columns=columns, words={}, notes=(note,))


def _unrolled(table):
    """The table, and one of the things in it that have columns each: `id1 range1 bearing1 id2 range2 bearing2`.

    An empty cell is a thing that was not seen.
    """
    groups = {}
    for column in table.columns:
        if m := re.fullmatch(r"(.*[A-Za-z_])(\d{1,3})", column):
            groups.setdefault(m[1], {})[m[2]] = column
    time = find(table, "t")
    first = next((stem for stem in groups if find(Table("", {stem: ()}), "range")), None)
    if time is None or first is None or len(groups[first]) < 2:
        return [table]
    things = {stem: of for stem, of in groups.items() if [*of] == [*groups[first]]}
    if len(things) < 2:
        return [table]
    named = find(Table("", dict.fromkeys(things, ())), "id") is not None
    long = {name: [] for name in (time, *([] if named else ["id"]), *things)}
    for number in groups[first]:
        long[time].append(table.columns[time])
        if not named:  # the number behind the names is the id
            long["id"].append(np.full(len(table), float(number)))
        for stem, of in things.items():
            long[stem].append(table.columns[of[number]])
    columns = {name: np.concatenate(parts) for name, parts in long.items()}
    seen = np.isfinite(columns[first])
    used = {column for of in things.values() for column in of.values()}
    note = f"{', '.join(things)} have a column for each of {len(groups[first])} things; empty: not seen"
    rest = replace(table, columns={name: a for name, a in table.columns.items() if name not in used})
    return [rest, Table(f"{table.name}/{first}", {name: a[seen] for name, a in columns.items()}, (note,))]


def _text(path):
    """Tables of a text file: one, or one for each word that its lines begin with."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not text in UTF-8: byte {error.start}") from error
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise ValueError(f"{path} is empty")
    remark = lambda line: line.lstrip().startswith(("#", "%", "//"))
    remarks = [line.lstrip("#%/ ") for line in takewhile(remark, lines)]  # the last one above the rows may name them
    lines = [line for line in lines if not remark(line)]
    if not lines:
        raise ValueError(f"{path} holds nothing but remarks")
    middle = lines[len(lines) // 2]
    mark = next((c for c in ";\t|," if c in middle), None)
    comma = mark in (";", "\t", "|") and re.search(r"\d,\d", middle) is not None  # a decimal comma
    split = lambda line: [cell.strip().strip("\"'") for cell in line.split(mark)]
    rows = [split(line.replace(",", ".") if comma else line) for line in lines]
    head = None
    if not any(map(_is_number, rows[0])):
        head, rows = rows[0], rows[1:]
    elif remarks and len(split(remarks[-1])) == len(rows[0]) and not any(map(_is_number, split(remarks[-1]))):
        head = split(remarks[-1])
    if not rows:
        raise ValueError(f"{path} has a line of names and no rows")
    tags = [row[0] for row in rows]
    kinds = dict.fromkeys(tags)
    if head is None and not any(map(_is_number, tags)) and len(kinds) <= MOST_KINDS:
        of_kind = {tag: ([], []) for tag in kinds}
        for n, (tag, *row) in enumerate(rows, 1):
            of_kind[tag][0].append(row)
            of_kind[tag][1].append(n)
        return [_table(path, f"{path.name}/{tag}", None, *part) for tag, part in of_kind.items()]
    return [_table(path, path.name, head, rows)]


def _table(path, name, head, rows, numbers=None):
    """A table of rows of words: those of another length than most are left out, and noted.

    `numbers` are those of their lines, a column more.
    """
    lengths = [len(row) for row in rows]
    usual = len(head) if head else max(set(lengths), key=lengths.count)
    kept = [row for row in rows if len(row) == usual]
    notes = []
    if not kept:
        raise ValueError(f"{path}: {usual} names in its first line, but {lengths[0]} cells in the rows")
    if len(kept) < len(rows):
        first = next(k for k, n in enumerate(lengths) if n != usual) + 1
        notes.append(
            f"{len(rows) - len(kept)} of {len(rows):,} rows have not {usual} cells and are left out, row {first} first"
        )
    names: list = head or [*map(str, range(1, usual + 1))]
    if not head and _is_tum(kept):
        names = TUM.split()
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise ValueError(f"{path} has two columns of the name {twice!r}")
    cells = [[float(cell) if _is_number(cell) else np.nan for cell in row] for row in kept]
    a = np.array(cells, float).reshape(len(kept), usual)
    a[np.isinf(a)] = np.nan
    named = _numbered(names, kept, a, notes)
    notes += _hemispheres(names, a, named)
    table = dict(zip(names, a.T, strict=True))
    if names == TUM.split():
        table["yaw"] = q2e(a[:, [7, 4, 5, 6]])[0][:, 2]
    if numbers:
        table[LINE] = np.array([n for n, length in zip(numbers, lengths, strict=True) if length == usual], float)
    return Table(name, table, tuple(notes), words=named)


def _times(words):
    """Seconds of dates with a time, in UTC if no zone is said, or of times of the day; nothing if some are neither.

    The day after midnight goes on.
    """
    try:
        days = {word: CLOCK.fullmatch(word) for word in words}
        if words and all(days.values()):
            t = {word: 3600.0 * int(m[1]) + 60.0 * int(m[2]) + float(m[3]) for word, m in days.items() if m}
            over = max(t.values()) - min(t.values()) > DAY / 2
            return {word: s + DAY * (over and s < DAY / 2) for word, s in t.items()}
        dates = {w: datetime.fromisoformat(w.replace("Z", "+00:00")) for w in words if len(w) > len("2024-05-14")}
    except ValueError:
        return {}
    if len(dates) < len(words):
        return {}
    return {w: (d if d.tzinfo else d.replace(tzinfo=UTC)).timestamp() for w, d in dates.items()}


def _numbered(names, rows, a, notes):
    """Put numbers into `a` for columns of words: dates, hexadecimal numbers, names. Return the numbers of the names."""
    named = {}
    for k, column in enumerate(names):
        words = {row[k] for row in rows} - {""} if np.isnan(a[:, k]).all() else set()
        times = _times(words)
        if times:
            a[:, k] = [times.get(row[k], np.nan) for row in rows]
        elif words and all(map(HEX.fullmatch, words)):
            a[:, k] = [int(row[k], 16) if row[k] else np.nan for row in rows]
            notes.append(f"column {column} holds hexadecimal numbers")
        elif words:  # names of landmarks: each gets a number
            number = {word: n for n, word in enumerate(sorted(words), 1)}
            a[:, k] = [number.get(row[k], np.nan) for row in rows]
            if len(number) < len(rows):
                notes.append(f"column {column} holds words: {len(number)} different, numbered by the alphabet")
            named[column] = number
    return named


def _hemispheres(names, a, words):
    """Put latitudes and longitudes, with N or S, E or W in the next column, into degrees; words on ddmm.mmmm."""
    for name, number in words.items():
        k = names.index(name)
        letters = {"N", "S"} if set(number) <= {"N", "S"} else {"E", "W"}
        if not k or not set(number) <= letters:
            continue
        south = a[:, k] == number.get("S", number.get("W"))
        if np.nanmax(np.abs(a[:, k - 1]), initial=0) > 180:
            whole = np.floor(a[:, k - 1] / 100)
            a[:, k - 1] = whole + (a[:, k - 1] - 100 * whole) / 60
            yield f"column {names[k - 1]}: degrees and minutes, as receivers send them, {'/'.join(sorted(number))}"
        a[south, k - 1] *= -1


def _is_tum(rows):
    """Return True if rows without names are a time, a position and a unit quaternion each."""
    if len(rows[0]) != len(TUM.split()) or not all(_is_number(cell) for row in rows for cell in row):
        return False
    return bool(np.allclose(np.linalg.norm(np.array(rows, float)[:, 4:], axis=1), 1, atol=1e-3))


def _is_number(cell):
    return NUMBER.fullmatch(cell) is not None
