"""A recording as one npz file: small, exact, fast. Nothing in it is ever executed."""

import re
from typing import Any

import numpy as np

from ...simulation import SimLmk
from ..files.archives import read_npz
from ..files.writing import written
from .logs import FORMAT, ControlLog, RawLog

CONTROLS = "u", "U", "offsets", "dt"


def save_npz(rec, path):
    """Write a recording into one npz file, whole or not at all."""
    with written(path) as file:
        np.savez_compressed(file, allow_pickle=False, **_to_arrays(rec))


def load_npz(path):
    """Read a file that `save_npz` wrote.

    Parameters
    ----------
    path : path

    Returns
    -------
    dict
        The arguments of `Recording`.

    Raises
    ------
    KeyError
        Naming an array that is missing.
    ValueError, ...
        All of `archives.DAMAGE`.
    """
    return _from_arrays(read_npz(path))


def _to_arrays(rec):
    arrays = {"format": FORMAT, "name": rec.name, "notes": np.array(rec.notes, dtype=str), "t": rec.t}
    arrays |= {
        "by_event": rec.by_event,
        "robots": np.array(list(rec.robots), int),
        "sensors": np.array(list(rec.raw), int),
    }
    for i, log in rec.robots.items():
        fields = {f"robot{i}_{name}": getattr(log, name) for name in CONTROLS}
        arrays |= {name: a for name, a in fields.items() if a is not None}
    for i, log in rec.raw.items():
        arrays |= _raw_arrays(f"sensor{i}", log)
    for i, log in rec.met.items():
        arrays |= _raw_arrays(f"sensor{i}_met", log)
    arrays |= {f"robot{i}_truth": x for i, x in rec.truth.items()}
    arrays |= {f"robot{i}_fixes": table for i, table in rec.fixes.items()}
    for i, (x, start_P) in rec.starts.items():
        arrays |= {f"robot{i}_start_x": x, f"robot{i}_start_P": start_P}
    if rec.landmarks is not None:
        arrays |= {"landmark_ids": rec.landmarks.ids, "landmark_points": rec.landmarks.points}
    if rec.t0:
        arrays["t0"] = rec.t0
    if rec.names:
        arrays |= {"name_ids": np.array(list(rec.names), int), "names": np.array(list(rec.names.values()), dtype=str)}
    return arrays | {"arrays": np.array(sorted(arrays))}  # a damaged name is noticed, too


def _raw_arrays(name, log):
    arrays = {f"{name}_offsets": log.offsets, f"{name}_ids": log.ids, f"{name}_y": log.y}
    return arrays | {f"{name}_{what}": a for what, a in (("R", log.R), ("d", log.d)) if a is not None}


def _raw_log(a, i, name):
    return RawLog(i, a[f"{name}_offsets"], a[f"{name}_ids"], a[f"{name}_y"], a.get(f"{name}_R"), a.get(f"{name}_d"))


def _from_arrays(a) -> dict[str, Any]:
    if str(a["format"]) != FORMAT:
        raise ValueError(f"its format is {str(a['format'])[:40]!r}, known is {FORMAT!r}")
    for name in a["arrays"].tolist() if "arrays" in a else ():
        a[name]  # a KeyError says which one is missing
    robots, sensors = (a[key].tolist() for key in ("robots", "sensors"))
    met = [int(key[6:].removesuffix("_met_ids")) for key in a if re.fullmatch(r"sensor\d+_met_ids", key)]
    return dict(
        name=str(a["name"]),
        t=a["t"],
        robots={i: ControlLog(a[f"robot{i}_u"], *(a.get(f"robot{i}_{name}") for name in CONTROLS[1:])) for i in robots},
        raw={i: _raw_log(a, i, f"sensor{i}") for i in sensors},
        truth={i: a[f"robot{i}_truth"] for i in robots if f"robot{i}_truth" in a},
        landmarks=SimLmk(a["landmark_ids"], a["landmark_points"]) if "landmark_ids" in a else None,
        notes=a["notes"].tolist(),
        met={i: _raw_log(a, i, f"sensor{i}_met") for i in met},
        by_event=bool(a.get("by_event", False)),
        fixes={i: a[f"robot{i}_fixes"] for i in robots if f"robot{i}_fixes" in a},
        starts={i: (a[f"robot{i}_start_x"], a[f"robot{i}_start_P"]) for i in robots if f"robot{i}_start_x" in a},
        names=dict(zip(a["name_ids"].tolist(), a["names"].tolist(), strict=True)) if "names" in a else {},
        t0=float(a.get("t0", 0.0)),
    )
