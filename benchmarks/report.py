"""RESULTS.md: the tables of a run."""

from .results import ratio
from .ways import SIZES, TOTALS, WAYS, ours, quickest, quickest_total

HEAD = """# Speed: results of a run

Written by `make bench`; do not edit. How it is measured, and what the words mean: [README.md](README.md). All numbers,
also the wall-clock times: [results.json](results.json).

![Time of a step and of a circuit over the number of landmarks, this package, other programs, and the limit](speed.png)
"""


def write(results, path):
    """Write the report of a run.

    Parameters
    ----------
    results : Results
    path : Path
    """
    parts = [HEAD, _machine(results), _fair(results), _targets(results)]
    for m in sorted({row["m"] for row in results.rows("grid")}, reverse=True):
        parts += [_grid(results, m), _ratios(results, m)]
    parts += [_circuit(results), _overhead(results), _monte_carlo(results), _mono(results), _scenario(results)]
    parts += [_agreement(results), _calibration(results)]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def table(head, rows, left=1):
    """A Markdown table; the first `left` columns are words, the others numbers."""
    rule = ["---"] * left + ["---:"] * (len(head) - left)
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in [head, rule, *rows]) + "\n"


def number(value, digits=3):
    """A number with three digits; a dash where there is none."""
    if value is None:
        return "-"
    if abs(value) >= 1000:
        return f"{round(value, digits - len(str(int(abs(value))))):,.0f}"
    return f"{value:.{digits}g}"


def _machine(r):
    d, m = r.data, r.data["machine"]
    blas = ", ".join(f"{one['internal_api']} {one['version']} ({one['architecture']})" for one in m["blas"][:1])
    lines = [
        f"* {d['date']}, plan `{d['plan']}`, {d['duration_s']:.0f} s"
        + ("" if d.get("complete", True) else "; **stopped early**"),
        f"* {m['cpu']}, {m['cores']} cores, {m['memory_gb']} GB, {m['system']}; one BLAS thread ({blas})",
        f"* Python {m['python']}; " + ", ".join(f"{name} {version}" for name, version in d["versions"].items()),
    ]
    lines += [f"* **Missing: {one['name']}**: {one['reason']}" for one in d.get("missing", [])]
    lines += [f"* **Failed: {name}**: {reason}" for name, reason in d.get("failed", {}).items()]
    if "calibration" in d:
        lines.append(f"* dgemm on one core: {d['calibration']['dgemm_gflops']:.1f} GFLOP/s")
    load = _load(r)
    if load:
        lines.append(f"* wall-clock time over CPU time, median of all cells: {load:.2f} (1 on an idle machine)")
    return "## This run\n\n" + "\n".join(lines) + "\n"


def _load(r):
    ratios = sorted(row["wall_us"]["median"] / row["cpu_us"]["median"] for row in r.rows("grid") if "wall_us" in row)
    return ratios[len(ratios) // 2] if ratios else None


FAIR = """## Times faster than each peer in its better way

The better way of a peer is the quickest of its variants in this run; the last column names it, and several where sizes
differ. The first figure is that of the numpy steps of this package, the second that of its compiled ones; below 1 the
peer is faster. `step` is all that a user pays; `filter`, with Jacobians given, against a peer that computes its own is
a part against a whole.
"""


def _fair(r):
    rows = []
    for kind, m, peer in dict.fromkeys((row["kind"], row["m"], row["peer"]) for row in r.rows("fair")):
        found = {row["n_lmks"]: row for row in r.rows("fair", kind=kind, m=m, peer=peer)}
        cells = [_pair(found.get(n)) for n in SIZES]
        ways = dict.fromkeys(row["way"] for row in found.values())
        rows.append([f"{kind}, m = {m}: {peer}", *cells, " / ".join(ways)])
    head = ["faster than", *(f"N = {n}: numpy; compiled" for n in SIZES), "its better way"]
    return f"{FAIR}\n{table(head, rows)}" if rows else ""


def _pair(row):
    return f"{number(row['numpy'])}; {number(row['compiled'])}" if row else ""


ASKED = """## Asked for, and measured

A peer stands here as it stood when that was asked for, filterpy and PythonRobotics one by one. Its better way is in the
table above, and here where a line says so.

"""


def _targets(r):
    rows = []
    for t in r.data.get("targets", []):
        met = {True: "yes", False: "**no**", None: "not measured"}[t["met"]]
        plain = "" if t.get("plain") in (None, t["value"]) else number(t["plain"])
        rows.append([t["what"], f"{t['sense']} {t['asked']:g} {t['unit']}", number(t["value"]), met, plain])
    head = ["what", "asked for", "measured", "met", "without the extra `compiled`"]
    return ASKED + table(head, rows)


def _cell(row):
    if row is None:
        return ""
    if "cpu_us" not in row:
        return "failed" if "failed" in row else "too slow"
    cpu = row["cpu_us"]
    return number(cpu["median"]) + (f" ({number(cpu['p10'])})" if "p10" in cpu else "")


def _grid(r, m):
    sizes = r.sizes("grid", m=m)
    rows = []
    for name in r.variants("grid", m=m):
        cells = [next(iter(r.rows("grid", m=m, n_lmks=n, variant=name)), None) for n in sizes]
        rows.append([name, *map(_cell, cells)])
        if "compressed" in name:
            rows.append([f"{name}: mean", *(number(r.us(n, m, name, "mean")) for n in sizes)])
            rows.append([f"{name}: longest", *(number(r.us(n, m, name, "max")) for n in sizes)])
    text = f"## One step, {m} landmark{'s' if m > 1 else ''} seen: microseconds of CPU, median (10 % quantile)\n\n"
    return text + table(["variant", *(f"N = {n}" for n in sizes)], rows)


def _ratios(r, m):
    sizes = r.sizes("grid", m=m)
    rows = []
    for kind, compiled in ("filter", False), ("step", False), ("step", True):
        mine, name = {n: ours(r, n, m, kind, compiled) for n in sizes}, f"{kind}, compiled" if compiled else kind
        for peer, ways in WAYS.items():
            if kind == "step" and "given" in peer:
                continue  # a part of theirs beside a whole of ours
            found = [ratio(quickest(r, n, m, peer)[0], mine[n]) for n in sizes]
            several = [way for way in ways if any(r.us(n, m, way) for n in sizes)]
            if any(found):
                better = f"{peer} in its better way" if len(several) > 1 else several[0]
                rows.append([f"{name}: faster than {better}", *map(number, found)])
            for way in several if len(several) > 1 else ():
                found = [ratio(r.us(n, m, way), mine[n]) for n in sizes]
                rows.append([f"{name}: faster than {way}", *map(number, found)])
        rows.append([f"{name}: times the limit", *(number(ratio(mine[n], r.limit(n, m))) for n in sizes)])
    word = "joint" if m > 1 else "joint or one by one, whichever is faster"
    return f"Ratios of this package ({word}), m = {m}:\n\n" + table(["", *(f"N = {n}" for n in sizes)], rows)


def _circuit(r):
    if not r.rows("circuit"):
        return ""
    sizes, names = r.sizes("circuit"), r.variants("circuit")
    one = lambda n, name: next(iter(r.rows("circuit", n_lmks=n, variant=name)), {})
    late = lambda f: f"{number(f['late_us'])} / {number(f['max_us'])}" if "late_us" in f else ""
    head = ["variant", *(f"N = {n}" for n in sizes)]
    text = "## The circuit, from an empty map: seconds of CPU in all\n\n"
    text += table(head, [[name, *(_total(one(n, name)) for n in sizes)] for name in names])
    text += "\nSteps at the end of it, microseconds: median of the last tenth / longest step of the whole circuit:\n\n"
    text += table(head, [[name, *(late(one(n, name)) for n in sizes)] for name in names])
    rows = []
    for mine in "step, joint", "step, joint, compressed", "step, joint, compiled", "step, joint, compressed, compiled":
        for peer in TOTALS:
            found = [ratio(quickest_total(r, n, peer), r.total(n, mine)) for n in sizes]
            if any(found):
                rows.append([f"{mine}: faster than {peer}", *map(number, found)])
    return f"{text}\nRatios of the totals (each peer in its better way; MRPT is told the sensor's reach):\n\n" + table(
        ["", *head[1:]], rows
    )


def _total(row):
    if "total_s" in row:
        return number(row["total_s"])
    return "too slow" if "skipped" in row else "failed"


def _overhead(r):
    if not r.rows("overhead"):
        return ""
    seen = sorted({row["m"] for row in r.rows("overhead")})
    rows = []
    for name in dict.fromkeys(row["piece"] for row in r.rows("overhead")):
        found = [next(iter(r.rows("overhead", piece=name, m=m)), {}) for m in seen]
        rows.append([name, *(number(f[key]) for f in found for key in ("us", "calls", "c_calls"))])
    head = ["piece", *(f"m = {m}: {word}" for m in seen for word in ("microseconds", "calls of Python", "compiled"))]
    text = "## What a step consists of at N = 10: CPU time and calls\n\n" + table(head, rows)
    mrpt = next((row for row in r.rows("circuit", n_lmks=10, variant="MRPT, one by one") if "late_us" in row), None)
    if mrpt:
        text += f"\nMRPT, all of it compiled: {number(mrpt['late_us'])} for a late step of the circuit, m = 10.\n"
    return text


def _monte_carlo(r):
    rows = [[row["variant"], number(row.get("steps_per_s"))] for row in r.rows("monte_carlo")]
    head = ["variant", "steps per second"]
    return "## Monte Carlo, N = 10, m = 1: steps of runs in a second of CPU\n\n" + table(head, rows) if rows else ""


def _mono(r):
    rows = [[row["variant"], _cell(row)] for row in r.rows("mono")]
    text = "## One frame in space, one camera: 100 inverse-depth landmarks, n = 613, 20 corrections\n\n"
    return text + table(["variant", "microseconds of CPU, median (10 % quantile)"], rows) if rows else ""


def _scenario(r):
    rows = [
        [row["variant"], *(number(row["cpu_us"][k] / 1000) for k in ("mean", "median", "max"))]
        for row in r.rows("scenario")
    ]
    text = "## Solà's point scenario, 200 frames: milliseconds of CPU for the estimation of one frame\n\n"
    return text + table(["variant", "mean", "median", "longest"], rows) if rows else ""


def _agreement(r):
    rows = []
    for row in r.rows("agreement"):
        found = row["failed"] if "failed" in row else f"{row['deviation']:.1e}"
        asked = f"{row['tolerance']:.0e}" if "tolerance" in row else ""
        rows.append([row["variant"], row["against"], found, asked])
    text = "## Agreement with the oracle, before any timing: largest deviation of mean and covariance, relative\n\n"
    return text + table(["variant", "against", "deviation", "allowed"], rows, 2)


def _calibration(r):
    if "calibration" not in r.data:
        return ""
    rows = [[f"{one['mb']:g}", number(one["gb_per_s"])] for one in r.data["calibration"]["in_place"]]
    text = "## An array multiplied in place on one core: bytes read and written\n\n"
    text += table(["MB", "GB/s"], rows, 0)
    for row in r.rows("startup"):
        text += f"\n`{row['what']}` takes {row['least_s']:.2f} s in a fresh process"
        text += "; matplotlib comes along.\n" if row["matplotlib"] else ", without matplotlib.\n"
    return text
