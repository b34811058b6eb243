"""Low-level functions against recorded values: `python -m tests.golden.functions DIR`.

DIR holds files of records (`rotations.json`, `frames.json`, ...). For each file one JSON line is printed: `records`,
`compared`, `passed`, and `skipped`, a count for each stated reason; compared and skipped add up to records. Of a
compared record single Jacobians may have been left out; `skipped_outputs` counts them. Failures go to stderr.
"""

import argparse
import collections
import json
import sys
from pathlib import Path

from .adapters_geometry import FRAMES, ROTATIONS
from .adapters_lines import LINES
from .adapters_models import CAMERA
from .adapters_motion import MATH, MOTION
from .adapters_points import OTHER, POINTS
from .records import compare

ADAPTERS = ROTATIONS | FRAMES | MOTION | MATH | CAMERA | POINTS | LINES | OTHER


def check_file(path):
    """Compare all records of a file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict
        The JSON line.
    list of str
        One line for each record that failed.
    """
    records = json.loads(path.read_text(encoding="utf-8"))
    counts, skipped, outputs, failures = collections.Counter(), collections.Counter(), collections.Counter(), []
    for record in records:
        try:
            result = compare(record, ADAPTERS)
        except Exception as error:
            result = {"worst": float("inf"), "skipped_outputs": [], "why": repr(error)}
        if "skip" in result:
            skipped[result["skip"]] += 1
            continue
        counts["compared"] += 1
        outputs.update(result["skipped_outputs"])
        if result["worst"] <= 1:
            counts["passed"] += 1
        else:
            failures.append(f"{path.name} {record['index']} {record['fn']}: {result['why']} {result['worst']:.3g}")
    line = {
        "file": path.stem,
        "records": len(records),
        "compared": counts["compared"],
        "passed": counts["passed"],
        "skipped": dict(skipped),
        "skipped_outputs": dict(outputs),
    }
    return line, failures


def main(argv=None):
    """Print one line per file; the exit code tells whether all compared records passed."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden.functions", description=__doc__.splitlines()[0])
    parser.add_argument("dir", type=Path, help="folder of the recorded files (*.json)")
    folder = parser.parse_args(argv).dir
    paths = sorted(path for path in folder.glob("*.json") if not path.name.startswith("_"))
    if not paths:
        parser.error(f"{folder} holds no file of records (*.json)")
    ok = True
    for path in paths:
        line, failures = check_file(path)
        print(json.dumps(line), flush=True)
        print(*failures, sep="\n", end="\n" if failures else "", file=sys.stderr)
        ok &= not failures
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
