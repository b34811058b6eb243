"""Make the small part of the recorded numbers that is kept here: `python -m tests.golden.extract DIR`.

DIR holds `functions/`, `runs/` and `exact/`. Written: `data/functions/*.json`, a record of each kind of call, and
`data/runs`, the first frames of some runs.
"""

import argparse
import json
from pathlib import Path

import numpy as np

DATA = Path(__file__).parent / "data"
FILES = ("rotations", "frames", "motion", "camera", "points")
RUNS = {"pnt_idp": 40, "pnt_idp_outliers": 40, "phd_euc": 10, "multi_2rob_4sen": 5, "constvel_noise": 8}
"""Name to number of frames."""
PARAMETERS = ("name", "branch", "Time", "Opt", "Robot", "Sensor", "senPar", "senFrame", "robSensors", "robCon")


def kind(record):
    """What makes a call of its own kind: function, version, and one point or many."""
    many = any(a.get("shape", [0, 1])[1] > 4 for a in record["args"])
    return record["fn"], record["branch"], many


def some(records):
    """The second record of each kind with all its outputs, or the only one. (The first is often the identity.)"""
    kinds = {}
    for record in sorted(records, key=lambda r: (bool(r.get("degenerate")), -r["nargout"])):
        kinds.setdefault(kind(record), []).append(record)
    return sorted((group[min(1, len(group) - 1)] for group in kinds.values()), key=lambda r: r["index"])


def extract_functions(source, target):
    """Copy some records of each file."""
    target.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        records = some(json.loads((source / f"{name}.json").read_text(encoding="utf-8")))
        lines = ",\n".join(json.dumps(record, separators=(",", ":")) for record in records)
        (target / f"{name}.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def extract_run(source, target, name, frames):
    """Copy the first frames of a run, without its world and its landmarks at the end."""
    data = json.loads((source / "runs" / f"{name}.json").read_text(encoding="utf-8"))
    kept = {key: data[key] for key in PARAMETERS}
    with np.load(source / "runs" / f"{name}.npz") as a:
        arrays = {key: a[key][:frames] for key in a.files if key.startswith(("u_rob", "est_x_rob")) or key == "frame"}
        arrays |= {key: a[key] for key in a.files if key.startswith("range_") or key in ("map_x0", "map_P0")}
        arrays["map_x"] = np.zeros((1, len(a["map_x0"])))
        arrays["ev_int"] = a["ev_int"][a["ev_int"][:, 1] <= frames].astype(np.int16)
        for off in (key for key in a.files if key.startswith("pts_") and key.endswith("_off")):
            arrays[off] = a[off][: frames + 1]
            for what in ("id", "y"):
                key = off.replace("off", what)
                arrays[key] = a[key][: arrays[off][-1]]
    (target / "runs").mkdir(parents=True, exist_ok=True)
    (target / "runs" / f"{name}.json").write_text(json.dumps(kept, separators=(",", ":")) + "\n", encoding="utf-8")
    np.savez_compressed(target / "runs" / f"{name}.npz", **arrays)

    with np.load(source / "exact" / f"{name}.npz") as a:
        (target / "exact").mkdir(exist_ok=True)
        ev = a["ev"][a["ev"][:, 1] <= frames].astype(np.int16)
        np.savez_compressed(target / "exact" / f"{name}.npz", ev=ev, poses=a["poses"][:frames])


def main(argv=None):
    parser = argparse.ArgumentParser(prog="python -m tests.golden.extract", description=__doc__.splitlines()[0])
    parser.add_argument("dir", type=Path, help="folder of the recorded numbers")
    source = parser.parse_args(argv).dir
    extract_functions(source / "functions", DATA / "functions")
    for name, frames in RUNS.items():
        extract_run(source, DATA, name, frames)


if __name__ == "__main__":
    main()
