"""Make the small part of the recorded numbers that is kept here: `python -m tests.golden.extract DIR`.

DIR holds `functions/`, `runs/` and `exact/`. Written: `data/functions/*.json`, a record of each kind of call, and
`data/runs`, the first frames of some runs.
"""

import argparse
import json
from pathlib import Path

DATA = Path(__file__).parent / "data"
FILES = ("rotations", "frames", "motion", "camera", "points")


def kind(record):
    """What makes a call of its own kind: function, number of outputs, version, and one point or many."""
    many = any(a.get("shape", [0, 1])[1] > 4 for a in record["args"])
    return record["fn"], record["nargout"], record["branch"], many


def some(records):
    """The second record of each kind, or the only one; degenerate ones last. (The first is often the identity.)"""
    kinds = {}
    for record in sorted(records, key=lambda r: bool(r.get("degenerate"))):
        kinds.setdefault(kind(record), []).append(record)
    return sorted((group[min(1, len(group) - 1)] for group in kinds.values()), key=lambda r: r["index"])


def extract_functions(source, target):
    """Copy some records of each file."""
    target.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        records = some(json.loads((source / f"{name}.json").read_text(encoding="utf-8")))
        lines = ",\n".join(json.dumps(record, separators=(",", ":")) for record in records)
        (target / f"{name}.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def main(argv=None):
    parser = argparse.ArgumentParser(prog="python -m tests.golden.extract", description=__doc__.splitlines()[0])
    parser.add_argument("dir", type=Path, help="folder of the recorded numbers")
    source = parser.parse_args(argv).dir
    extract_functions(source / "functions", DATA / "functions")


if __name__ == "__main__":
    main()
