"""A recording as a folder of CSV files.

===========================  =====================================================================================
recording.json               format, name, notes, by_event, names, t0 (see `Recording`), and the number of rows of each
                             file, which shows a cut-off file; only format and name are needed
frames.csv                   t: seconds since the start; one row for each frame, frame numbers count from 0
robot-N-controls.csv         frame, u1 ... and, if the covariances are recorded, their upper triangles U11 U12 ...
robot-N-truth.csv            frame, x, y, theta or x, y, z, a, b, c, d (quaternion, scalar first); nan where unknown
robot-N-fixes.csv            t, x, y and, in space, z: positions by a satellite receiver, seconds since the start
sensor-N.csv                 frame, id, y1 ... and, if recorded, R11 R12 ... and the descriptor d1 ...; one row for each
                             measurement, by frame
sensor-N-robots.csv          the same for measurements of other robots; the ids are those of robots
landmarks.csv                id, x, y and, in space, z
===========================  =====================================================================================

Units are SI and radians. Files of robots, sensors, truth and landmarks may be absent.
"""

import contextlib
import csv
import json
import os
import re
from pathlib import Path

import numpy as np

from ...simulation import SimLmk
from ..files.archives import brief, check_regular
from ..files.locks import only_here
from ..files.writing import beside, to_disk, written
from ..user_input import errors_at, short_text
from .logs import FORMAT, ControlLog, RawLog

HEAD, HALF = "recording.json", "ekfslam recording, half written"
NAMES = r"frames\.csv|landmarks\.csv|robot-\d+-(controls|truth|fixes)\.csv|sensor-\d+(-robots)?\.csv"
POSES = {3: ["x", "y", "theta"], 7: ["x", "y", "z", "a", "b", "c", "d"]}


def save_csv(rec, folder):
    """Write a recording into a folder, which is made if need be; the files of an older recording in it go.

    All files are written beside before the first of the old ones is touched: a full disk changes nothing. Whoever is
    stopped while they are moved leaves a folder that is no recording, never one that is of two.

    Raises
    ------
    ValueError
        If the folder holds files with such names that are of no recording.
    OSError
        If it cannot be written, or another program is writing there.
    """
    folder, tables = Path(folder), _tables(rec)
    folder.mkdir(parents=True, exist_ok=True)
    with only_here(folder):
        old = _files_of_recording(folder)
        with beside(folder) as new:
            for name, (header, columns) in tables.items():
                with open(new / name, "w", newline="", encoding="utf-8") as file:
                    writer = csv.writer(file, lineterminator="\n")
                    writer.writerow(header)
                    writer.writerows(zip(*(column.tolist() for column in columns), strict=True))
            rows = {name: len(columns[0]) for name, (_, columns) in tables.items()}
            head = {"format": FORMAT, "name": rec.name, "notes": rec.notes, "by_event": rec.by_event, "rows": rows}
            head |= ({"t0": rec.t0} if rec.t0 else {}) | ({"names": rec.names} if rec.names else {})
            (new / HEAD).write_text(json.dumps(head, indent=2) + "\n", encoding="utf-8")
            to_disk(*new.iterdir())
            _move(new, folder, tables, old)


def _move(new, folder, names, old):
    """Let the files of a recording take the place of those of another one."""
    with written(folder / HEAD, text=True) as file:
        file.write(json.dumps({"format": HALF, "rows": dict.fromkeys({*old, *names}, 0)}))
    for name in old - set(names):
        (folder / name).unlink()
    for name in names:
        os.replace(new / name, folder / name)
    to_disk(folder)
    os.replace(new / HEAD, folder / HEAD)
    to_disk(folder)


def _files_of_recording(folder):
    """The names of the files of the recording that is in a folder; anything else with such a name is refused."""
    there = {path.name for path in folder.iterdir() if re.fullmatch(NAMES, path.name)}
    head = None
    with contextlib.suppress(ValueError, FileNotFoundError):
        head = _json(folder / HEAD)
    if head is None and (there or (folder / HEAD).exists()):
        name = min(there, default=HEAD)
        raise ValueError(f"the folder {folder} holds {name}, which is of no recording; give another folder")
    return there


def _tables(rec):
    """Header and columns of each file, by name."""
    frames = np.arange(len(rec))
    if rec.starts or any(log.offsets is not None for log in rec.robots.values()):
        raise ValueError("CSV files have no place for many controls a frame, nor for starts; use .npz")
    tables = {"frames.csv": (["t"], [rec.t])}
    for i, log in rec.robots.items():
        tables[f"robot-{i}-controls.csv"] = _vectors_with_covariances([("frame", frames)], "u", log.u, "U", log.U)
    for i, x in rec.truth.items():
        tables[f"robot-{i}-truth.csv"] = (["frame", *POSES[x.shape[1]]], [frames, *x.T])
    for i, fixes in rec.fixes.items():
        tables[f"robot-{i}-fixes.csv"] = (["t", *"xyz"[: fixes.shape[1] - 1]], list(fixes.T))
    for ending, logs in (("", rec.raw), ("-robots", rec.met)):
        for i, log in logs.items():
            frame = np.repeat(frames, np.diff(log.offsets))
            tables[f"sensor-{i}{ending}.csv"] = _vectors_with_covariances(
                [("frame", frame), ("id", log.ids)], "y", log.y, "R", log.R
            )
            if log.d is not None:
                header, columns = tables[f"sensor-{i}{ending}.csv"]
                header += [f"d{j + 1}" for j in range(log.d.shape[1])]
                columns += list(log.d.T)
    if rec.landmarks is not None:
        points = rec.landmarks.points
        tables["landmarks.csv"] = (["id", *"xyz"[: points.shape[1]]], [rec.landmarks.ids, *points.T])
    return tables


def load_csv(folder):
    """Read a folder that `save_csv` wrote, or that was made to the same plan.

    Parameters
    ----------
    folder : path

    Returns
    -------
    dict
        The arguments of `Recording`.

    Raises
    ------
    FileNotFoundError
    ValueError
        With the file and the line that is wrong.
    """
    folder = Path(folder)
    head = _head(folder / HEAD)
    _check_names(folder, head.get("rows"))
    read = lambda name: _Table(folder / name, head.get("rows", {}).get(name))
    t = read("frames.csv").columns("t", ["t"])[:, 0]

    robots, truth, raw, met, fixes, landmarks = {}, {}, {}, {}, {}, None
    for i, name in _numbered(folder, r"robot-(\d+)-controls\.csv"):
        table = read(name)
        table.frames(len(t), each_once=True)
        u, U = table.vectors("u"), table.triangles("U", "u")
        with errors_at(table.path):
            robots[i] = ControlLog(u, U)
    for i, name in _numbered(folder, r"robot-(\d+)-truth\.csv"):
        table = read(name)
        table.frames(len(t), each_once=True)
        truth[i] = table.columns("pose", table.one_of(POSES.values(), skip=1), allow_nan=True)
    for i, name in _numbered(folder, r"robot-(\d+)-fixes\.csv"):
        table = read(name)
        fixes[i] = table.columns("fixes", ["t", *table.one_of(["xy", "xyz"], skip=1)])
    for pattern, logs in ((r"sensor-(\d+)\.csv", raw), (r"sensor-(\d+)-robots\.csv", met)):
        for i, name in _numbered(folder, pattern):
            table = read(name)
            counts = np.bincount(table.frames(len(t)), minlength=len(t))
            ids, y, R, d = table.integers("id"), table.vectors("y"), table.triangles("R", "y"), table.descriptors()
            with errors_at(table.path):
                logs[i] = RawLog(i, np.cumsum([0, *counts]), ids, y, R, d)
    if (folder / "landmarks.csv").exists():
        table = read("landmarks.csv")
        landmarks = SimLmk(table.integers("id"), table.columns("points", table.one_of(["xy", "xyz"], skip=1)))
    notes, by_event = head.get("notes", []), head.get("by_event", False)
    values = {"name": head["name"], "t": t, "robots": robots, "raw": raw, "truth": truth, "landmarks": landmarks}
    names = {int(id): name for id, name in head.get("names", {}).items()}
    values |= {"names": names, "t0": float(head.get("t0", 0.0))}
    return values | {"notes": notes, "met": met, "by_event": by_event, "fixes": fixes}


class _Table:
    """One CSV file; every complaint names the file and the line."""

    def __init__(self, path, n_rows=None):
        self.path = path
        if not path.exists():
            raise FileNotFoundError(f"{path} is missing")
        try:
            check_regular(path)
            text = path.read_text(encoding="utf-8-sig")
            lines = list(csv.reader(text.splitlines(), strict=True))
        except (csv.Error, ValueError) as error:
            raise ValueError(f"{path} is not a CSV file in UTF-8: {brief(error)}") from error
        if not lines:
            raise ValueError(f"{path}, line 1: the file is empty; its first line names the columns")
        self.header = [name.strip() for name in lines[0]]
        if len(self.header) == 1 and re.search(r"[;\t]", self.header[0]):
            raise self.error(1, f"columns are separated by commas, got {self.names()!r}")
        self.rows = [(number, row) for number, row in enumerate(lines[1:], start=2) if row]
        for number, row in self.rows:
            if len(row) != len(self.header):
                raise self.error(number, f"{len(row)} values, but there are {len(self.header)} columns: {self.names()}")
        if n_rows is not None and not text.endswith("\n"):
            raise self.error(len(lines), "the file breaks off in this line")
        if n_rows is not None and len(self.rows) != n_rows:
            last = self.rows[-1][0] if self.rows else 1
            raise self.error(last, f"the file ends here with {len(self.rows)} rows; recording.json says {n_rows}")

    def error(self, line, message):
        return ValueError(f"{self.path}, line {line}: {message}")

    def names(self, skip=0):
        """The names of the columns as a text of bounded length."""
        return ", ".join(self.header[skip:])[:100]

    def columns(self, what, names, kind=float, allow_nan=False):
        """Read some columns as an array (lines, len(names))."""
        missing = [name for name in names if name not in self.header]
        if missing:
            raise self.error(1, f"no column {missing[0]!r} for {what}; there are: {self.names()}")
        places = [self.header.index(name) for name in names]
        values = np.empty((len(self.rows), len(names)), kind)
        for i, (line, row) in enumerate(self.rows):
            for j, (column, name) in enumerate(zip(places, names, strict=True)):
                values[i, j] = self._value(line, name, row[column], kind, allow_nan)
        return values

    def _value(self, line, name, text, kind, allow_nan):
        try:
            value = kind(text)
            if kind is int:
                value_is_fine = abs(value) < 2**62
            else:
                value_is_fine = np.isfinite(value) or (allow_nan and value != value)
        except (ValueError, OverflowError):
            value, value_is_fine = None, False
        if not value_is_fine:
            wanted = "a whole number" if kind is int else "a finite number"
            raise self.error(line, f"{name} must be {wanted}, got {text.strip()[:40]!r}")
        return value

    def integers(self, name):
        return self.columns(name, [name], int)[:, 0]

    def vectors(self, letter):
        """Read the columns letter1, letter2, ..."""
        names = [name for name in self.header if re.fullmatch(rf"{letter}\d+", name) and len(name) == 2]
        expected = [f"{letter}{j}" for j in range(1, max(len(names), 1) + 1)]
        return self.columns(f"the vector {letter}", expected)

    def descriptors(self):
        """Read the columns d1, d2, ..., or None where there are none."""
        n = sum(bool(re.fullmatch(r"d\d+", name)) for name in self.header)
        return self.columns("the descriptor d", [f"d{j + 1}" for j in range(n)]) if n else None

    def triangles(self, letter, vector):
        """Read symmetric matrices from the columns of their upper triangle, or None where there are none."""
        if f"{letter}11" not in self.header:
            return None
        m = self.vectors(vector).shape[1]
        i, j = np.triu_indices(m)
        upper = self.columns(f"the covariance {letter}", _triangle(letter, m))
        matrices = np.zeros((len(upper), m, m))
        matrices[:, i, j] = matrices[:, j, i] = upper
        return matrices

    def frames(self, n, each_once=False):
        """Read the column of frame numbers: in 0 ... n-1, not falling, or each exactly once."""
        frame = self.integers("frame")
        for i, (line, _) in enumerate(self.rows):
            if not 0 <= frame[i] < n:
                raise self.error(
                    line, f"frame {frame[i]} does not exist; frames.csv has {f'0 to {n - 1}' if n else 'none'}"
                )
            if each_once and frame[i] != i:
                raise self.error(line, f"frame {frame[i]} where frame {i} was expected; each has one row, in order")
            if i and frame[i] < frame[i - 1]:
                raise self.error(line, f"frame {frame[i]} after frame {frame[i - 1]}; rows go by frame")
        if each_once and len(frame) != n:
            raise self.error(len(frame) + 1, f"the file ends after {len(frame)} of the {n} frames of frames.csv")
        return frame

    def one_of(self, choices, skip):
        """Find which of several lists of column names the header has after its first `skip` columns."""
        for names in choices:
            if self.header[skip:] == list(names):
                return list(names)
        possible = " or ".join(", ".join(names) for names in choices)
        raise self.error(1, f"columns {self.names(skip)}, but possible are {possible}")


def _triangle(letter, m):
    return [f"{letter}{i + 1}{j + 1}" for i, j in zip(*np.triu_indices(m), strict=True)]


def _vectors_with_covariances(first, v, vectors, c, matrices):
    """Header and columns: the first ones, then vectors v1 v2 ..., then the upper triangles of matrices."""
    m = vectors.shape[1]
    if m > 9:
        raise ValueError(f"CSV columns are numbered with one digit, but {v} has {m} numbers; use .npz")
    header = [name for name, _ in first] + [f"{v}{j + 1}" for j in range(m)]
    columns = [column for _, column in first] + list(vectors.T)
    if matrices is not None:
        header += _triangle(c, m)
        columns += list(matrices[:, *np.triu_indices(m)].T)
    return header, columns


def _numbered(folder, pattern):
    """Ids and names of the files of a folder that fit a pattern, by id."""
    found = [(re.fullmatch(pattern, path.name), path.name) for path in folder.iterdir()]
    return sorted((int(match[1]), name) for match, name in found if match)


def _check_names(folder, rows):
    """Refuse a file that recording.json does not know of, where it knows of any, and one that is missing."""
    if not rows:
        return
    there = {path.name for path in folder.iterdir() if re.fullmatch(NAMES, path.name)}
    for name in sorted(there - set(rows)):
        raise ValueError(
            f"{folder / name} is not in the rows of {HEAD}: is it of another recording? Delete one of them"
        )
    for name in sorted(set(rows) - there):
        raise FileNotFoundError(f"{short_text(name)[1:-1]} is missing in {folder}; {HEAD} has its number of rows")


def _json(path):
    """Read the head of a recording of any state; ValueError for anything else."""
    try:
        check_regular(path)
        head = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not JSON, or nested too deeply: {brief(error)}") from error
    if not isinstance(head, dict) or head.get("format") not in (FORMAT, HALF):
        raise ValueError(f"{path} is no head of a recording")
    return head


def _head(path):
    if not path.exists():
        raise FileNotFoundError(f"{path} is missing: this folder is not a recording")
    try:
        check_regular(path)
        head = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not JSON, or nested too deeply: {brief(error)}") from error
    if isinstance(head, dict) and head.get("format") == HALF:
        raise ValueError(f"{path.parent} is not a whole recording: whoever wrote it was stopped; write it anew")
    if not isinstance(head, dict) or not {"format", "name"} <= head.keys() or not isinstance(head["name"], str):
        raise ValueError(f"{path} must hold a name and the format {FORMAT!r}")
    if head["format"] != FORMAT:
        raise ValueError(f"{path}: its format is {short_text(head['format'])}, known is {FORMAT!r}")
    rows, notes = head.get("rows", {}), head.get("notes", [])
    if not isinstance(rows, dict) or not isinstance(notes, list):
        raise ValueError(f"{path}: rows must be a table of numbers and notes a list of texts")
    if not isinstance(head.get("by_event", False), bool):
        raise ValueError(f"{path}: by_event must be true or false, got {head['by_event']!r}")
    names, t0 = head.get("names", {}), head.get("t0", 0.0)
    if not isinstance(names, dict) or not all(k.isdecimal() and isinstance(v, str) for k, v in names.items()):
        raise ValueError(f'{path}: names must be texts by the ids of landmarks, {{"3": "T01"}}')
    if isinstance(t0, bool) or not isinstance(t0, int | float) or not abs(t0) < float("inf"):
        raise ValueError(f"{path}: t0 must be a number of seconds, got {short_text(t0)}")
    return head
