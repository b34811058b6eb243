"""Files of anybody as tables: named columns of numbers, NaN where a cell has none."""

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ...geometry import q2e
from ...toolbox.files.archives import check_regular, read_npz
from ...toolbox.user_input import errors_at
from ..matlab import read_mat
from .bags import is_bag, read_bag
from .meaning import LINE, find

TEXT = {".csv", ".tsv", ".txt", ".dat", ".log", ""}
KNOWN = "text in columns (.csv, .tsv, .txt, .dat, .log), .mat, .npz, ROS bags (.bag, .mcap, .db3, or a folder)"
MOST_KINDS = 12
"""Lines that begin with one of so many words are of so many kinds."""
PROSE = {"readme", "license", "licence", "copying"}
"""Files of these names are for people."""
TUM = "t x y z qx qy qz qw"
HEX = re.compile(r"0x[0-9a-f]+", re.IGNORECASE)
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
        files = [p for p in sorted(path.iterdir()) if p.is_file() and p.suffix.lower() in TEXT | {".mat", ".npz"}]
        files = [p for p in files if p.suffix and p.stem.lower() not in PROSE]
        if not files:
            raise ValueError(f"the folder {path} holds no log; known are {KNOWN}")
        return with_common_words([table for file in files for table in read_tables(file)])
    kind = path.suffix.lower()
    if kind not in TEXT | {".mat", ".npz"}:
        raise ValueError(f"{path}: files {kind} are not known; known are {KNOWN}")
    with errors_at(path):
        check_regular(path)
    tables = _text(path) if kind in TEXT else _arrays(path, read_mat(path) if kind == ".mat" else _npz(path))
    if not any(len(table) for table in tables):
        raise ValueError(f"{path} holds no rows of numbers")
    return with_common_words([table for table in tables if len(table)])


def with_common_words(tables):
    """Tables in which a word has the same number everywhere: the places in the alphabet of all words of the log."""
    order = {word: n for n, word in enumerate(sorted({w for t in tables for ws in t.words.values() for w in ws}), 1)}

    def renumbered(table):
        """The table with the numbers of all."""
        columns, words = dict(table.columns), {}
        for name, old in table.words.items():
            new = np.full(len(old) + 1, np.nan)
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


def _text(path):
    """Tables of a text file: one, or one for each word that its lines begin with."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not text in UTF-8: byte {error.start}") from error
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise ValueError(f"{path} is empty")
    remarks = [line.lstrip("#%/ ") for line in lines if line.lstrip().startswith(("#", "%", "//"))]
    lines = [line for line in lines if not line.lstrip().startswith(("#", "%", "//"))]
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
    named = {}
    for k, column in enumerate(names):
        words = {row[k] for row in kept} - {""} if np.isnan(a[:, k]).all() else set()
        if words and all(map(HEX.fullmatch, words)):
            a[:, k] = [int(row[k], 16) if row[k] else np.nan for row in kept]
            notes.append(f"column {column} holds hexadecimal numbers")
        elif words:  # names of landmarks: each gets a number
            number = {word: n for n, word in enumerate(sorted(words), 1)}
            a[:, k] = [number.get(row[k], np.nan) for row in kept]
            if len(number) < len(kept):
                notes.append(f"column {column} holds words: {len(number)} different, numbered by the alphabet")
            named[column] = number
    table = dict(zip(names, a.T, strict=True))
    if names == TUM.split():
        table["yaw"] = q2e(a[:, [7, 4, 5, 6]])[0][:, 2]
    if numbers:
        table[LINE] = np.array([n for n, length in zip(numbers, lengths, strict=True) if length == usual], float)
    return Table(name, table, tuple(notes), words=named)


def _is_tum(rows):
    """Return True if rows without names are a time, a position and a unit quaternion each."""
    if len(rows[0]) != len(TUM.split()) or not all(_is_number(cell) for row in rows for cell in row):
        return False
    return bool(np.allclose(np.linalg.norm(np.array(rows, float)[:, 4:], axis=1), 1, atol=1e-3))


def _is_number(cell):
    return NUMBER.fullmatch(cell) is not None
