"""Values in one npz file: numbers, texts, containers, arrays, every bit kept; nothing that can be executed.

JSON holds the structure, the arrays lie beside it. A list of rows, tuples of equal kinds, is stored by columns. The
file carries a checksum: what has been cut off or changed is refused, never read as something else.
"""

import hashlib
import json
from typing import Any

import numpy as np

from .archives import DAMAGE, brief, read_npz
from .writing import written

SMALL = 64  # numbers; arrays up to here share one member of the file


def save(path, values):
    """Write values to a file, whole or not at all, and not only into the memory of the system.

    Parameters
    ----------
    path : path
    values : object
        None, bool, int, float, str, list, tuple, set, dict, slice, ndarray of numbers, nested as you like.

    Raises
    ------
    TypeError
        Naming a value of another kind.
    """
    arrays, small = {}, []
    tree = json.dumps(_encode(values, arrays, small))
    arrays["small"] = np.array(small, float)
    with written(path) as file:
        np.savez(file, allow_pickle=False, tree=tree, checksum=_checksum(tree, arrays), **arrays)


def load(path) -> Any:
    """Read what `save` has written.

    Raises
    ------
    ValueError
        If the file is damaged or something else.
    FileNotFoundError
    """
    try:
        arrays = read_npz(path)
        tree, checksum = str(arrays.pop("tree")), str(arrays.pop("checksum"))
        if checksum != _checksum(tree, arrays):
            raise ValueError("its checksum is wrong")
        return _decode(json.loads(tree), arrays)
    except FileNotFoundError:
        raise
    except (*DAMAGE, KeyError, RecursionError) as error:
        raise ValueError(f"{path} is damaged, or no file of this program: {brief(error)}") from error


def _checksum(tree, arrays):
    digest = hashlib.sha256(tree.encode())
    for name, a in sorted(arrays.items()):
        digest.update(f"{name} {a.dtype.str} {a.shape} {np.isfortran(a)}".encode())
        digest.update(a.tobytes("A"))
    return digest.hexdigest()


def _encode(value, arrays, small):
    """The structure for JSON; arrays go to where they are kept."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, (np.ndarray, np.generic)):
        return _keep(np.asarray(value), arrays, small)
    inside = lambda items: [_encode(v, arrays, small) for v in items]
    if isinstance(value, slice):
        return {"slice": inside([value.start, value.stop, value.step])}
    if isinstance(value, dict):
        return {"dict": [inside(pair) for pair in value.items()]}
    if type(value) in (list, tuple) and _is_table(value):
        columns = [np.array(column) for column in zip(*value, strict=True)]
        floats = [type(v) is float for v in value[0]]
        return {"table": type(value).__name__, "columns": inside(columns), "floats": floats}
    if type(value) in (list, tuple, set):
        return {type(value).__name__: inside(sorted(value) if isinstance(value, set) else value)}
    raise TypeError(f"a {type(value).__name__} cannot be kept in a file of plain values")


def _is_table(rows):
    """Return True if these are many tuples of floats and arrays, all alike."""
    if len(rows) < 2 or type(rows[0]) is not tuple or not rows[0]:
        return False
    kind = lambda row: [(type(v), getattr(v, "shape", None), getattr(v, "dtype", None)) for v in row]
    first = kind(rows[0])
    of_floats = all(t is float or (dtype is not None and dtype == np.float64) for t, _, dtype in first)
    return of_floats and all(type(row) is tuple and kind(row) == first for row in rows)


def _keep(a, arrays, small):
    if a.dtype.kind not in "biuf":
        raise TypeError(f"an array of {a.dtype} cannot be kept in a file of plain values")
    if a.dtype == float and a.size <= SMALL:
        start = len(small)
        small.extend(a.ravel())
        return {"small": [start, *a.shape]}
    name = f"a{len(arrays)}"
    arrays[name] = a
    return {"array": name}


def _decode(node, arrays) -> Any:
    if not isinstance(node, dict):
        return node
    inside = lambda items: [_decode(item, arrays) for item in items]
    if "small" in node:
        start, *shape = node["small"]
        return arrays["small"][start : start + int(np.prod(shape))].reshape(shape).copy()
    if "array" in node:
        return arrays[node["array"]]
    if "slice" in node:
        return slice(*inside(node["slice"]))
    if "dict" in node:
        return dict(inside(pair) for pair in node["dict"])
    if "table" in node:
        columns = [c.tolist() if f else c for c, f in zip(inside(node["columns"]), node["floats"], strict=True)]
        rows = list(zip(*columns, strict=True))
        return rows if node["table"] == "list" else tuple(rows)
    for kind in (list, tuple, set):
        if kind.__name__ in node:
            return kind(inside(node[kind.__name__]))
    raise ValueError(f"an unknown kind of value: {', '.join(node)[:80]}")
