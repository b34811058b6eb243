"""JSON lines, one object each, as rows of words: a table for each type of object, a row for each thing in a list."""

import json

LINES = {".jsonl", ".ndjson"}
TYPE = "type", "kind", "topic", "msg", "sensor"
"""Keys that say of what kind an object is."""
AXES = {2: "xy", 3: "xyz"}


def read_lines(path):
    """Read a file of JSON lines.

    Parameters
    ----------
    path : Path

    Returns
    -------
    list of (str, list of dict of str to str)
        Name of each table, and its rows: all have the same keys.

    Raises
    ------
    ValueError
        One sentence with the line that is wrong.
    """
    found = {}
    for n, line in enumerate(path.read_text(encoding="utf-8-sig", errors="replace").splitlines(), 1):
        if not line.strip():
            continue
        try:
            thing = json.loads(line)
        except (ValueError, RecursionError):
            raise ValueError(f"{path}, line {n}: it is no JSON") from None
        if not isinstance(thing, dict):
            raise ValueError(f"{path}, line {n}: an object {{...}} is needed in each line")
        key = next((key for key in TYPE if isinstance(thing.get(key), str)), None)
        found.setdefault(thing.pop(key) if key else "", []).extend(_rows(thing))
    if not any(found.values()):
        raise ValueError(f"{path} holds no rows of numbers")
    alone = len(found) == 1
    return [(path.name if alone else f"{path.name}/{kind}", _alike(rows)) for kind, rows in found.items() if rows]


def _rows(thing):
    """Rows of an object: one, or one for each thing in its list; none if the list is empty."""
    flat = dict(_cells(thing))
    lists = {key: a for key, a in flat.items() if isinstance(a, list)}
    same = {key: str(a) for key, a in flat.items() if key not in lists}
    if not lists:
        return [same]
    key, inner = next(iter(lists.items()))
    return [same | {f"{key}.{name}": str(a) for name, a in _cells(one) if not isinstance(a, list)} for one in inner]


def _cells(thing, above=""):
    """Names and values of an object: numbers in a list have their axis or place behind the name, before a unit."""
    for key, a in thing.items():
        name = f"{above}{key}"
        if isinstance(a, dict):
            yield from _cells(a, f"{name}.")
        elif isinstance(a, list) and not (a and all(isinstance(x, int | float) for x in a)):
            yield name, [x for x in a if isinstance(x, dict)]
        elif isinstance(a, list):
            stem, _, end = name.rpartition("_")
            if stem and sorted(end) == sorted("wxyz") and len(a) == len(end):  # quat_wxyz
                yield from ((f"{stem}_{axis}", x) for axis, x in zip(end, a, strict=True))
            else:
                axes = AXES.get(len(a), range(1, len(a) + 1))
                unit = f"_{end}" if stem and len(end) < 4 else ""
                yield from ((f"{name.removesuffix(unit)}_{axis}{unit}", x) for axis, x in zip(axes, a, strict=True))
        else:
            yield name, "nan" if a is None else a


def _alike(rows):
    """Rows that all have the keys of any of them."""
    keys = dict.fromkeys(key for row in rows for key in row)
    return [{key: row.get(key, "") for key in keys} for row in rows]
