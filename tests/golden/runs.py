"""Whole runs against recorded ones: `python -m tests.golden.runs DIR [NAME ...] [--engine fast]`.

DIR holds `runs/NAME.json` and `runs/NAME.npz`, recorded from another program, and `exact/NAME.npz`, from an independent
implementation of exact formulas. Controls and measurements are replayed, and one JSON line is printed for each
comparison: `run`, `against` and the scores of `scores.score`. `against` is

`exact`           where exact/NAME.npz is there
`recorded`        the recorded program
`recorded+birth`  the same, with landmark classes whose birth has the recorded program's approximate derivative
"""

import argparse
import json
import sys
import traceback
from pathlib import Path

from .replay import ENGINES, exact, recorded, replay
from .scenario import BIRTHS, Scenario
from .scores import score


def compare_run(folder, name, engine="plain"):
    """Replay one run and compare it with all its references.

    Parameters
    ----------
    folder : Path
        Holds `runs/` and `exact/`.
    name : str
    engine : str
        Whose steps replay it: "plain" or "fast".

    Yields
    ------
    dict
        One JSON line each.
    """
    scenario = Scenario.load(folder / "runs", name)
    run, reference = replay(scenario, engine=engine), recorded(scenario)
    path = folder / "exact" / f"{name}.npz"
    if path.exists():
        yield {"run": name, "against": "exact"} | score(run, exact(path))
    yield {"run": name, "against": "recorded"} | score(run, reference)
    if scenario.type in BIRTHS:
        yield {"run": name, "against": "recorded+birth"} | score(
            replay(scenario, births=True, engine=engine), reference
        )


def names(folder):
    """Names of the recorded runs in a folder."""
    return sorted(path.stem for path in (folder / "runs").glob("*.json") if path.with_suffix(".npz").exists())


def main(argv=None):
    """Print the lines; the exit code tells whether every run could be replayed."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden.runs", description=__doc__.splitlines()[0])
    parser.add_argument("dir", type=Path, help="folder that holds runs/ and exact/")
    parser.add_argument("names", nargs="*", help="runs to replay; all, if none is named")
    parser.add_argument("--engine", choices=ENGINES, default="plain", help="whose steps replay them (default: plain)")
    args = parser.parse_args(argv)
    there = names(args.dir)
    if not there:
        parser.error(f"{args.dir / 'runs'} holds no run (NAME.json with NAME.npz)")
    unknown = [name for name in args.names if name not in there]
    if unknown:
        parser.error(f"there is no run {unknown[0]!r}; there are: {', '.join(there)}")
    ok = True
    for name in args.names or there:
        try:
            for line in compare_run(args.dir, name, args.engine):
                print(json.dumps(line), flush=True)
        except Exception as error:
            ok = False
            traceback.print_exc()
            print(json.dumps({"run": name, "error": f"{type(error).__name__}: {error}"}), flush=True)
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
