"""`python -m benchmarks`: measure, then write RESULTS.md, results.json and speed.png."""

import argparse
import datetime
import sys
import time
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from threadpoolctl import threadpool_limits

from ekfslam_tutorial.analysis.progress import bar

from . import agreement, circuit, grid, machine, mono, monte_carlo, overhead, scenario, startup
from .peers.registry import find
from .plot import draw
from .report import write
from .results import Results
from .targets import targets
from .ways import fair

HERE = Path(__file__).parent
SECTIONS = ("grid", "circuit", "overhead", "monte_carlo", "mono", "scenario", "startup")


@dataclass(frozen=True)
class Plan:
    """How much is measured. Seconds are for one variant in one cell."""

    sizes: tuple
    seen: tuple
    circuits: tuple
    budget: float
    too_slow: float  # a step that should take longer is left out, s
    circuit_too_slow: float
    circuit_spend: float  # on one variant and size, s
    circuit_repeats: int
    repeats: int
    runs: tuple
    sizes_mb: tuple = machine.SIZES_MB


FULL = Plan(
    sizes=(10, 50, 100, 200, 500, 1000),
    seen=(1, 10),
    circuits=(10, 50, 100, 200, 500, 1000),
    budget=0.55,
    too_slow=2.0,
    circuit_too_slow=12.0,
    circuit_spend=1.5,
    circuit_repeats=9,
    repeats=5,
    runs=(10, 100, 1000),
)
QUICK = Plan(
    sizes=(10, 100, 500),
    seen=(1, 10),
    circuits=(10, 100),
    budget=0.08,
    too_slow=0.3,
    circuit_too_slow=2.0,
    circuit_spend=0.5,
    circuit_repeats=5,
    repeats=2,
    runs=(10, 1000),
)
SMOKE = Plan(
    sizes=(10,),
    seen=(1, 10),
    circuits=(10,),
    budget=0.005,
    too_slow=0.05,
    circuit_too_slow=0.5,
    circuit_spend=0.1,
    circuit_repeats=1,
    repeats=1,
    runs=(10,),
    sizes_mb=(1, 8),
)
PLANS = {"full": FULL, "quick": QUICK, "smoke": SMOKE}


def main(argv=None):
    """Run the benchmark; the exit code is 1 if a variant does not agree with the oracle."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--plan", choices=PLANS, default="full", help="how much is measured (default: full)")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS, metavar="SECTION", help=str(SECTIONS))
    parser.add_argument("--out", type=Path, default=HERE, help="folder for the three files (default: benchmarks/)")
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)

    results = Results()
    with threadpool_limits(1):
        complete = measure(results, PLANS[args.plan], args.plan, args.only)
    results.data["complete"] = complete
    results.data["fair"] = fair(results)
    results.data["targets"] = [target.row() for target in targets(results)]
    results.save(args.out / "results.json")
    draw(results, args.out / "speed.png")
    write(Results.load(args.out / "results.json"), args.out / "RESULTS.md")  # the numbers as they are stored
    print(f"Written: {args.out}/RESULTS.md, results.json, speed.png" + ("" if complete else " (stopped early)"))
    wrong = [row["variant"] for row in results.rows("agreement") if not row.get("ok")]
    wrong += results.data.get("failed", [])
    if wrong:
        sys.exit(f"Does not agree with the textbook, or failed: {', '.join(wrong)}")


def measure(results, plan, name, only):
    """Fill the results section by section; False if Ctrl-C ended it: what has been measured is kept then."""
    data, start = results.data, time.perf_counter()
    data["date"] = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
    data["plan"] = name
    data["machine"], data["versions"] = machine.describe(), machine.versions()
    cells = [(n, m) for n in plan.sizes for m in plan.seen] if "grid" in only else []
    total = 3 + len(cells) + len([s for s in only if s != "grid"])
    try:
        with bar(total, "parts", shown=sys.stderr.isatty()) as done:
            with part(done, "peers"):
                peers = find()
                data["versions"] |= peers.versions
                data["missing"] = [{"name": name, "reason": reason} for name, reason in peers.missing.items()]
            with part(done, "calibration"):
                data["calibration"] = machine.calibrate(plan.budget, plan.sizes_mb)
            with part(done, "agreement"):
                data["agreement"] = agreement.check(peers) + mono.check()
            sections(data, plan, only, peers, cells, done)
    except KeyboardInterrupt:
        return False
    finally:
        data["duration_s"] = time.perf_counter() - start
    return True


def sections(data, plan, only, peers, cells, done):
    """Grid, circuit and the others; each row is in the results as soon as it is there."""
    data["grid"], data["failed"], expected = [], {}, grid.Expected()
    for n, m in cells:
        with part(done, f"N = {n}, m = {m}"):
            data["grid"] += grid.cell(n, m, peers, plan.budget, expected, plan.too_slow)
    if "circuit" in only:
        with part(done, "circuit"):
            data["circuit"] = []
            tell = lambda n: done.tell(f"circuit, N = {n}")
            how = plan.circuit_repeats, plan.circuit_spend, plan.circuit_too_slow
            for row in circuit.run(plan.circuits, peers, *how, tell):
                data["circuit"].append(row)
    for name, run in (
        ("overhead", lambda: overhead.run(plan.budget)),
        ("monte_carlo", lambda: monte_carlo.run(plan.runs, peers, plan.budget)),
        ("mono", lambda: mono.run(plan.budget)),
        ("scenario", lambda: scenario.run(plan.repeats, frames=20 if plan is SMOKE else 200)),
        ("startup", lambda: startup.run(plan.repeats)),
    ):
        if name in only:
            with part(done, name):
                try:
                    data[name] = run()
                except Exception as error:  # the rest of ten minutes is not thrown away for it
                    data["failed"][name] = f"{type(error).__name__}: {error}"


@contextmanager
def part(done, text):
    """One part of the work on the progress bar."""
    done.tell(text)
    yield
    done.update()


if __name__ == "__main__":
    main()
