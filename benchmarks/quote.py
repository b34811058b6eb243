"""`python -m benchmarks.quote`: write the figures of the stored run into README.md and docs/performance.md.

What stands there between `<!-- speed: NAME, ... -->` and `<!-- end of speed -->` is made here, from results.json alone.
"""

import re
import textwrap
from pathlib import Path

from .report import table
from .results import Results, ratio
from .ways import SIZES, ours, quickest, quickest_total

ROOT = Path(__file__).resolve().parent.parent
PAGES = ("README.md", "docs/performance.md")
PART = re.compile(r"(<!-- speed: (\w+), [^\n]* -->\n).*?(<!-- end of speed -->)", re.DOTALL)


def figure(value):
    """A ratio as a reader wants it: two or three digits; a dash where there is none."""
    if value is None:
        return "-"
    if value < 9.95:
        return f"{value:.1f}" if value >= 0.995 else f"{value:.2f}"
    return f"{value:.0f}" if value < 1000 else f"{round(value, -1):,.0f}"


def ms(us):
    """Microseconds as milliseconds."""
    return "-" if us is None else f"{us / 1000:.2f}" if us < 9950 else f"{us / 1000:.0f}"


def pair(show, numpy, compiled):
    """Both figures, numpy first: it is the worse one."""
    return f"{show(numpy)}; {show(compiled)}"


def readme(r):
    """The table of README.md and what is said about small maps."""
    step = lambda n, way: r.us(n, 10, f"step, {way}", "mean" if "compressed" in way else "median")
    two = lambda show, of: [pair(show, *(of(n, compiled) for compiled in ("", ", compiled"))) for n in SIZES]
    times = lambda us: two(figure, lambda n, c: ratio(us(n), step(n, f"joint{c}")))
    best = lambda peer: times(lambda n: quickest(r, n, 10, peer)[0])
    limit = lambda n, c: ratio(r.us(n, 10, f"filter, joint{c}"), r.limit(n, 10))
    total = lambda peer, way: two(figure, lambda n, c: circuit(r, n, peer, f"step, {way}{c}"))
    rows = [
        ["a whole step, ms", *two(ms, lambda n, c: step(n, f"joint{c}"))],
        ["the same with the compressed map, mean, ms", *two(ms, lambda n, c: step(n, f"joint, compressed{c}"))],
        ["the same by the readable steps, ms", *(ms(step(n, "joint, plain")) for n in SIZES)],
        ["times faster than filterpy, one joint update", *times(lambda n: r.us(n, 10, "filterpy, joint"))],
        ["... that and the motion by hand, its better way", *best("filterpy")],
        ["... ten updates, one by one", *times(lambda n: r.us(n, 10, "filterpy"))],
        ["times faster than PythonRobotics", *best("PythonRobotics")],
        ["times faster than Stone Soup's updater", *best("Stone Soup")],
        ["circuit from an empty map: times faster than MRPT (C++)", *total("MRPT", "joint")],
        ["circuit: times faster than GTSAM's iSAM2", *total("GTSAM iSAM2", "joint")],
        ["the same with the compressed map", *total("GTSAM iSAM2", "joint, compressed")],
        ["the filter alone, times what the machine allows", *two(figure, limit)],
    ]
    head = ["10 landmarks seen in each step, known ids, one core: numpy; compiled", *(f"N = {n}" for n in SIZES)]
    calls = {row["piece"]: row["calls"] + row["c_calls"] for row in r.rows("overhead", m=10)}
    late = next((row.get("late_us") for row in r.rows("circuit", n_lmks=10, variant="MRPT, one by one")), None)
    fifty = (figure(circuit(r, 50, "MRPT", f"step, joint{c}")) for c in ("", ", compiled"))
    text = (
        f"Small maps are the weak side: at N = 10 a step is {calls['whole step']} calls, or "
        f"{calls['whole step, compiled']} when it is compiled; MRPT, in C++, needs {ms(late)} ms there. A circuit of "
        f"50 landmarks takes MRPT {next(fifty)} times as long as the numpy steps, and {next(fifty)} times as long as "
        "the compiled ones."
    )
    return f"{table(head, rows)}\n{paragraph(text)}"


def circuit(r, n_lmks, peer, way):
    """How many times as long a peer in its better way takes for a whole circuit."""
    return ratio(quickest_total(r, n_lmks, peer), r.total(n_lmks, way))


def filterpy(r):
    """The sentence about dense matrices."""
    us = lambda way: ms(r.us(500, 10, way))
    return paragraph(
        f"At N = 500 and m = 10 the joint filter takes {us('filter, joint')} ms, or "
        f"{us('filter, joint, compiled')} ms compiled. "
        f"filterpy with its dense matrices takes {us('filterpy, joint')} ms for one joint update, "
        f"{us('filterpy, joint, motion by hand')} ms where the user writes down himself what a motion changes, and "
        f"{us('filterpy')} ms for ten updates, one by one."
    )


def compiled(r):
    """The table of when compiling pays."""
    us = lambda value: "-" if value is None else f"{value:.0f} us"
    rows = []
    for kind in "filter", "step":
        for n, m in (10, 1), (10, 10), (100, 10), (500, 10):
            rows.append([f"{kind}, N = {n}, m = {m}", *(us(ours(r, n, m, kind, how)) for how in (False, True))])
    for row in r.rows("circuit", n_lmks=200, variant="step, joint"):
        each = (ratio(r.total(200, f"step, joint{way}"), row["steps"] * 1e-6) for way in ("", ", compiled"))
        rows.append(["circuit from an empty map, 200 landmarks, a step", *map(us, each)])
    return table(["", "numpy", "compiled"], rows)


def peers(r):
    """Each peer in its better way, and the ways that were measured beside it."""
    rows = []
    for kind, m, peer in dict.fromkeys((row["kind"], row["m"], row["peer"]) for row in r.rows("fair")):
        found = {row["n_lmks"]: row for row in r.rows("fair", kind=kind, m=m, peer=peer)}
        if kind == "step" and (m == 10 or peer == "Robotics Toolbox"):
            cells = [pair(figure, found[n]["numpy"], found[n]["compiled"]) if n in found else "-" for n in SIZES]
            ways = dict.fromkeys(row["way"] for row in found.values())
            rows.append([f"{peer}, m = {m}", *cells, " / ".join(ways)])
    head = ["whole step: times faster than", *(f"N = {n}: numpy; compiled" for n in SIZES), "its better way"]
    return table(head, rows)


def paragraph(text):
    """Lines of at most 120 characters."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False) + "\n"


PARTS = {"table": readme, "filterpy": filterpy, "compiled": compiled, "peers": peers}


def quoted(page, r):
    """A page with the figures of a run.

    Parameters
    ----------
    page : str
        Its text.
    r : Results

    Returns
    -------
    str
    """
    return PART.sub(lambda found: f"{found[1]}\n{PARTS[found[2]](r)}\n{found[3]}", page)


def main():
    """Write the pages."""
    results = Results.load(Path(__file__).parent / "results.json")
    for name in PAGES:
        path = ROOT / name
        path.write_text(quoted(path.read_text(encoding="utf-8"), results), encoding="utf-8")
        print(f"Written: {name}")


if __name__ == "__main__":
    main()
