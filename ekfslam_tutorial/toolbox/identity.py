"""What decides the numbers of a run, in short texts: the same text means the same numbers, another text other ones.

Checkpoints and series keep these texts, part by part, so that who goes on with other inputs is told which of them has
changed.
"""

import ast
import hashlib
import inspect
import sys
import sysconfig
from dataclasses import fields, is_dataclass
from functools import cache, partial
from pathlib import Path
from types import CodeType, FunctionType

import numpy as np

from .. import __version__

PACKAGE = Path(__file__).resolve().parent.parent
DECIDE = "geometry", "models", "ekf", "slam", "fast", "simulation", "toolbox", "analysis", "datasets"
"""Folders of the package whose text decides the numbers."""
LIBRARIES = {PACKAGE.name, "numpy", "scipy", "builtins"}
"""Modules whose version says it all, or that no model of a user's is in."""
LENGTH = 24


@cache
def program():
    """Version of the package, and a digest of the text of all of it that computes."""
    digest = hashlib.sha256()
    for path in sorted(path for folder in DECIDE for path in (PACKAGE / folder).rglob("*.py")):
        digest.update(f"{path.relative_to(PACKAGE).as_posix()}\n{path.read_text(encoding='utf-8')}\n".encode())
    return f"{__version__} {digest.hexdigest()[:LENGTH]}"


def of_scenario(data):
    """A digest of each part of a scenario, and of each file that models of the user's own are in.

    Parameters
    ----------
    data : UserData
        Its name, its figure and its seed decide nothing, or are told apart by who asks.

    Returns
    -------
    dict of str to str
        By what it is of, in words.
    """
    seen = set()
    parts = {
        f"{f.name} of the scenario": _digest(_parts(getattr(data, f.name), seen))
        for f in fields(data)
        if f.name not in ("name", "seed", "figure")
    }
    return parts | _sources(seen)


def of_recording(recording):
    """A digest of each part of a recording: times, controls, measurements, truth, landmarks.

    Parameters
    ----------
    recording : Recording or None

    Returns
    -------
    dict of str to str
        By what it is of, in words; of a simulation nothing.
    """
    if recording is None:
        return {}
    landmarks = recording.landmarks
    parts = {
        "name of the recording": recording.name,
        "times of the recording": (recording.t, recording.by_event),
        "landmarks of the recording": None if landmarks is None else (landmarks.ids, landmarks.points),
    }
    parts |= {f"controls of robot {i}": (log.u, log.U, log.offsets, log.dt) for i, log in recording.robots.items()}
    for what, logs in (("measurements of sensor", recording.raw), ("sightings of robots by sensor", recording.met)):
        parts |= {f"{what} {i}": (log.offsets, log.ids, log.y, log.R) for i, log in logs.items()}
    parts |= {f"truth of robot {i}": x for i, x in recording.truth.items()}
    parts |= {f"fixes of robot {i}": table for i, table in recording.fixes.items()}
    parts |= {f"start of robot {i}": start for i, start in recording.starts.items()}
    return {what: _digest(_parts(value, set())) for what, value in parts.items()}


def changed(kept, now):
    """Return what differs between two such dictionaries, in words; an empty text if nothing does."""
    names = [what for what in [*now, *(what for what in kept if what not in now)] if kept.get(what) != now.get(what)]
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return ", ".join(names[:3]) + more


def _digest(parts):
    """Digest of nested tuples and lists of texts, numbers and bytes."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:LENGTH]


def _parts(value, seen):
    """A value as nested tuples of names and numbers; classes and functions that are met go to `seen`."""
    if isinstance(value, partial):
        return _parts((value.func, value.args, value.keywords), seen)
    if isinstance(value, dict):
        return [(repr(k), _parts(v, seen)) for k, v in value.items()]
    if isinstance(value, (list, tuple)):
        return [_parts(v, seen) for v in value]
    if isinstance(value, (set, frozenset)):
        return sorted(repr(_parts(v, seen)) for v in value)
    if isinstance(value, (np.ndarray, np.generic)):
        a = np.asarray(value)
        plain = a.dtype.kind in "biufcSU"
        return a.shape, a.dtype.str, hashlib.sha256(np.ascontiguousarray(a).tobytes()).digest() if plain else a.tolist()
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes, Path, slice)):
        return repr(value)
    if isinstance(value, (type, FunctionType)):
        seen.add(value)
        return value.__qualname__
    if inspect.ismethod(value):
        return _parts((value.__self__, value.__func__), seen)
    seen.add(type(value))
    name = type(value).__qualname__
    if is_dataclass(value):
        return name, [(f.name, _parts(getattr(value, f.name), seen)) for f in fields(value)]
    inside = getattr(value, "__dict__", None)
    return name, _parts(inside, seen) if inside else getattr(value, "__qualname__", None) or repr(value)


# --- the user's own models -------------------------------------------------------------------------------------------


def _sources(things):
    """A digest of each file that classes and functions are in, and of what it imports beside it."""
    found = {}
    for thing in things:
        for one in thing.__mro__ if isinstance(thing, type) else (thing,):
            if one.__module__.split(".")[0] in LIBRARIES or one.__module__ in sys.stdlib_module_names:
                continue
            file = getattr(sys.modules.get(one.__module__), "__file__", None)
            if file and one.__module__ != "__main__" and Path(file).is_file():
                found |= {path: path.read_bytes() for path in with_neighbours(Path(file).resolve())}
            else:  # of a notebook, or of a script, whose other lines may change
                found[one.__qualname__] = repr(_code_of(one, one.__module__, set())).encode()
    name = lambda at: f"own model {at.name if isinstance(at, Path) else at}"
    digests = {}
    for at, text in sorted(found.items(), key=lambda item: str(item[0])):
        digests.setdefault(name(at), hashlib.sha256()).update(text)
    return {what: digest.hexdigest()[:LENGTH] for what, digest in digests.items()}


def with_neighbours(file):
    """Return a Python file and those of the user's that it imports, beside it or elsewhere, and that these import.

    Parameters
    ----------
    file : Path

    Returns
    -------
    set of Path
    """
    found, left = set(), [file]
    while left:
        path = left.pop()
        if path in found:
            continue
        found.add(path)
        for name in _imported(path):
            places = (path.parent / Path(*name.split(".")[:n]) for n in range(1, name.count(".") + 2))
            for place in places:
                left += [p for p in (place.with_suffix(".py"), place / "__init__.py") if p.is_file()]
            elsewhere = getattr(sys.modules.get(name), "__file__", None)
            if elsewhere and _of_user(Path(elsewhere).resolve()):
                left.append(Path(elsewhere).resolve())
    return found


def _of_user(path):
    """Return True for a source file that is neither of Python, nor installed, nor of this package."""
    homes = [PACKAGE, *(Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib", "platlib"))]
    return path.suffix == ".py" and path.is_file() and not any(path.is_relative_to(home) for home in homes)


def _imported(path):
    """The dotted names that a file imports, as seen from its own folder."""
    try:
        tree = ast.parse(path.read_text(encoding="utf-8"))
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            home = f"{node.module}." if node.module else ""
            yield from (home + alias.name for alias in node.names if alias.name != "*" or home)


def _code_of(thing, module, seen):
    """Content of a class or function of a notebook: its code, and that of all it uses from the same module."""
    thing = inspect.unwrap(thing) if callable(thing) else thing
    if id(thing) in seen:
        return thing.__qualname__
    seen.add(id(thing))
    if isinstance(thing, type):
        inside = {
            name: getattr(value, "__func__", getattr(value, "fget", value)) for name, value in vars(thing).items()
        }
        return [
            (name, _code_of(value, module, seen) if isinstance(value, (FunctionType, type)) else _plain(value))
            for name, value in inside.items()
            if not name.startswith("__") or isinstance(value, FunctionType)
        ]
    code, used = thing.__code__, []
    for name in _names(code):
        value = thing.__globals__.get(name)
        if isinstance(value, (FunctionType, type)):
            mine = value.__module__ == module
            used.append((name, _code_of(value, module, seen) if mine else value.__qualname__))
        elif name in thing.__globals__:
            used.append((name, _plain(value)))
    cells = [_plain(cell.cell_contents) for cell in thing.__closure__ or ()]
    return _text_of(code), _plain(thing.__defaults__), _plain(thing.__kwdefaults__), cells, used


def _names(code):
    """All names that code uses, that of functions inside it included."""
    inner = [name for const in code.co_consts if isinstance(const, CodeType) for name in _names(const)]
    return sorted({*code.co_names, *inner})


def _text_of(code):
    """The code itself, without lines and places."""
    consts = [_text_of(const) if isinstance(const, CodeType) else _parts(const, set()) for const in code.co_consts]
    return code.co_code, consts, code.co_names, code.co_varnames


def _plain(value):
    """A number, text, array or container of such; of anything else its kind."""
    if isinstance(value, (np.ndarray, np.generic, dict, list, tuple, set, frozenset, int, float, complex, str, bytes)):
        return _parts(value, set())
    return type(value).__qualname__
