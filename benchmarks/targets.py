"""What the project wants of its speed, as ratios within one run, and what a run gives.

Each target names the variant of a peer that it was asked for with, and keeps it: filterpy and PythonRobotics one by
one, Stone Soup and Robotics Toolbox as their examples show them. `ways.py` has each peer in its better way.
"""

from dataclasses import dataclass

from .circuit import UNTOLD
from .results import least, ratio
from .scenario import OCTAVE_MS
from .ways import ours, quickest, quickest_total

ONE_BY_ONE = ("filterpy", "PythonRobotics, known ids")


@dataclass(frozen=True)
class Target:
    """One line of the table: `sense` is ">=" or "<="; `value` None means that it was not measured in this run.

    `plain` is the value without the extra `compiled`, where that makes a difference.
    """

    what: str
    sense: str
    asked: float
    unit: str
    value: float | None
    plain: float | None = None

    @property
    def met(self):
        """True, False, or None where it was not measured."""
        if self.value is None:
            return None
        return self.value >= self.asked if self.sense == ">=" else self.value <= self.asked

    def row(self):
        """For results.json."""
        return {"what": self.what, "sense": self.sense, "asked": self.asked, "unit": self.unit} | {
            "value": self.value,
            "plain": self.plain,
            "met": self.met,
        }


def targets(results):
    """All targets of a run.

    Parameters
    ----------
    results : Results

    Returns
    -------
    list of Target
    """
    r = results
    return [*_grid(r), *_circuit(r), *_limit(r), *_mono(r), *_others(r)]


def _grid(r):
    for kind, peer, asked in (
        ("filter", "filterpy", {(10, 1): 2.5, (10, 10): 6, (100, 10): 60, (500, 10): 1000}),
        ("step", "filterpy", {(10, 1): 1, (10, 10): 2, (100, 10): 30, (500, 10): 500}),
        ("step", "PythonRobotics, known ids", {(10, 10): 3, (100, 10): 25, (500, 10): 400}),
        ("step", "Robotics Toolbox", {(100, 1): 10, (500, 1): 250}),
        ("filter", "Stone Soup updater", {(100, 10): 14}),
    ):
        for (n, m), factor in asked.items():
            value, plain = (ratio(r.us(n, m, peer), ours(r, n, m, kind, compiled)) for compiled in (True, False))
            text = f"{kind}, N = {n}, m = {m}: faster than {peer}{', one by one' * (m > 1 and peer in ONE_BY_ONE)}"
            yield Target(text, ">=", factor, "x", value, plain)
    for n in 10, 100, 500:
        us = quickest(r, n, 10, "filterpy")[0]
        value, plain = (ratio(us, ours(r, n, 10, "step", compiled)) for compiled in (True, False))
        yield Target(f"step, N = {n}, m = 10: faster than filterpy in its better way", ">=", 1, "x", value, plain)
    peer, plain = r.us(500, 10, "filterpy"), r.us(500, 10, "filter, sequential")
    best = least(plain, r.us(500, 10, "filter, sequential, compiled"))
    text = "filter, one by one, N = 500, m = 10: faster than filterpy, one by one"
    yield Target(text, ">=", 500, "x", ratio(peer, best), ratio(peer, plain))


def _circuit(r):
    plain, compiled, compressed = "step, joint", "step, joint, compiled", "step, joint, compressed"
    isam = lambda n, *ways: ratio(r.total(n, "GTSAM iSAM2"), least(*(r.total(n, way) for way in ways)))
    yield Target(
        "circuit, N = 200: faster than GTSAM iSAM2", ">=", 1.5, "x", isam(200, plain, compiled), isam(200, plain)
    )
    for n in 500, 1000:
        value, text = isam(n, compressed, f"{compressed}, compiled"), f"circuit, compressed, N = {n}"
        yield Target(f"{text}: faster than GTSAM iSAM2", ">=", 4, "x", value, isam(n, compressed))
    for n, asked, peer, mrpt in (
        (50, 1, "MRPT", quickest_total(r, 50, "MRPT")),
        (100, 6, "MRPT", quickest_total(r, 100, "MRPT")),
        (100, 6, UNTOLD, r.total(100, UNTOLD)),
    ):
        value = ratio(mrpt, least(r.total(n, plain), r.total(n, compiled)))
        yield Target(f"circuit, N = {n}: faster than {peer}", ">=", asked, "x", value, ratio(mrpt, r.total(n, plain)))


def _limit(r):
    for n, m, asked in ((500, 10, 1.7), (1000, 10, 1.7), (1000, 1, 3)):
        value = ratio(ours(r, n, m, "filter"), r.limit(n, m))
        yield Target(f"filter, N = {n}, m = {m}: times the physical limit", "<=", asked, "x", value)
    name = "filter, joint, compressed"
    value = ratio(r.us(1000, 10, name, "mean"), r.limit(1000, 10))
    yield Target("compressed filter, N = 1000, m = 10, mean: times the limit of the direct update", "<=", 1, "x", value)
    value = ratio(r.us(1000, 10, name), r.us(200, 10, name))
    yield Target("compressed filter, m = 10: steady step at N = 1000 over that at N = 200", "<=", 1.25, "x", value)
    found = [row.get("deviation") for row in r.rows("agreement", variant=name)]
    yield Target("compressed filter: relative deviation from the textbook", "<=", 1e-12, "", (found or [None])[0])


def _mono(r):
    for way, asked in ("sequential", 5.0), ("joint", 2.0):
        rates = [row["gflops"] for row in r.rows("mono", kind="limit")]
        rows = (r.rows("mono", variant=f"whole frame, {way}{extra}") for extra in ("", ", compiled"))
        us = [row[0]["cpu_us"]["median"] if row and "cpu_us" in row[0] else None for row in rows]
        value, plain = (one * rates[0] / 50 / 1000 if one and rates else None for one in (least(*us), us[0]))
        yield Target(f"3D frame, n = 613, {way}, scaled to dgemm at 50 GFLOP/s", "<=", asked, "ms", value, plain)
    for way, asked in ("sequential", 10), ("joint", 20):
        rows = (r.rows("scenario", variant=f"{way}{extra}") for extra in ("", ", compiled"))
        plain, compiled = (1000 * OCTAVE_MS / row[0]["cpu_us"]["mean"] if row else None for row in rows)
        text = f"Solà's point scenario, {way}: faster than his toolbox in Octave (measured elsewhere)"
        yield Target(text, ">=", asked, "x", max(plain, compiled) if plain and compiled else plain, plain)


def _others(r):
    rows = [row for row in r.rows("monte_carlo", runs=1000) if "steps_per_s" in row]
    value = rows[0]["steps_per_s"] / 1000 if rows else None
    yield Target("Monte Carlo, N = 10, m = 1, 1000 runs at once: thousand steps per second", ">=", 700, "k/s", value)
    for what, asked in ("import ekfslam_tutorial", 0.3), ("first figure of notebook 00", 3.0):
        rows = r.rows("startup", what=what)
        yield Target(what, "<=", asked, "s", rows[0]["least_s"] if rows else None)
