"""The grid: time of one step for N landmarks in the map and m seen in each step, all variants side by side."""

from .clock import Variant, compare
from .given import given
from .machine import bandwidth_variant, gemm_variant, gflops, gigabytes, limit_us, triangle_bytes
from .oracle import Oracle
from .ours import FILTERS, STEPS
from .world import lap


def variants(world, peers):
    """Everything that can run on a lap.

    Kinds: filter (blocks given), step (models and bookkeeping included), peer (as a user would write it).
    """
    found = []

    def add(kind, name, make, singly=False):
        found.append(Variant(name, lambda: make().step, singly, {"kind": kind}))

    for kind, makers in (("filter", FILTERS), ("step", STEPS)):
        for name, make in makers.items():
            add(kind, name, lambda make=make: make(world), singly="compressed" in name)
    add("peer", "textbook numpy, sequential", lambda: Oracle(world, joint=False))
    if world.m > 1:
        add("peer", "textbook numpy, joint", lambda: Oracle(world, joint=True))
    if "filterpy_peer" in peers:
        add("peer", "filterpy", lambda: peers.filterpy_peer.FilterPy(world))
        if world.n_lmks <= 100:
            add("peer", "filterpy, blocks given", lambda: peers.filterpy_peer.FilterPyGiven(world, given))
        add("peer", "filterpy, joint", lambda: peers.filterpy_peer.FilterPyJoint(world))
        add("peer", "filterpy, joint, motion by hand", lambda: peers.filterpy_peer.FilterPyJoint(world, by_hand=True))
        given_joint = lambda: peers.filterpy_peer.FilterPyJointGiven(world, given)
        add("peer", "filterpy, joint, motion by hand, blocks given", given_joint)
    if "python_robotics" in peers:
        module = peers.modules["python_robotics"]
        make = module.PythonRobotics
        add("peer", "PythonRobotics", lambda: make(world, peers.python_robotics, known_ids=False))
        add("peer", "PythonRobotics, known ids", lambda: make(world, peers.python_robotics, known_ids=True))
        add("peer", "PythonRobotics, joint", lambda: module.Joint(world, peers.python_robotics))
    if "robotics_toolbox" in peers and world.m == 1:
        make = peers.robotics_toolbox.RoboticsToolbox
        add("peer", "Robotics Toolbox", lambda: make(world))
        add("peer", "Robotics Toolbox, joseph=False", lambda: make(world, joseph=False))
    if "stone_soup" in peers:
        add("peer", "Stone Soup updater", lambda: peers.stone_soup.StoneSoup(world))
        add("peer", "Stone Soup updater, tuned", lambda: peers.stone_soup.Tuned(world))
    if "compiled" in peers:
        add("peer", "numba loops", lambda: peers.compiled.Compiled(world))
        if world.m > 1:
            add("peer", "numba loops, joint", lambda: peers.compiled.CompiledJoint(world))
    return found


class Expected:
    """What a variant should need for the next N, from the last one: it is not run if that is too long."""

    def __init__(self):
        self.last = {}

    def seconds(self, name, n_lmks, m):
        """Linear in N while overhead rules, quadratic, then cubic as in a dense product; 0 if nothing is known."""
        n, seconds = self.last.get((name, m), (n_lmks, 0.0))
        return seconds * (n_lmks / n) ** (1 if seconds < 2e-3 else 2 if seconds < 5e-2 else 3)

    def learn(self, results, n_lmks, m):
        """Remember what was measured."""
        for name, result in results.items():
            if "cpu_us" in result:
                self.last[name, m] = n_lmks, 1e-6 * result["cpu_us"]["median"]


def cell(n_lmks, m, peers, budget, expected, too_slow):
    """Rows of one cell of the grid, the limit included: it is calibrated in turn with the filters.

    Returns
    -------
    list of dict
        n_lmks, n, m, variant, kind and the times; see README.md.
    """
    world, n = lap(n_lmks, m), 3 + 2 * n_lmks
    found = [*variants(world, peers), gemm_variant(), bandwidth_variant(triangle_bytes(n))]
    results = compare(found, budget, too_slow=too_slow, expect=lambda name: expected.seconds(name, n_lmks, m))
    rates = gflops(results.pop("dgemm")), gigabytes(results.pop("in place"))
    expected.learn(results, n_lmks, m)
    here = {"n_lmks": n_lmks, "n": n, "m": m}
    rows = [here | {"variant": name} | result for name, result in results.items()]
    for name, rank, times in ("limit, joint", 2 * m, 1), ("limit, sequential", 2, m):
        us = limit_us(n, rank, times, *rates)
        rows.append(
            here
            | {"variant": name, "kind": "limit", "cpu_us": {"median": us}, "gflops": rates[0], "gb_per_s": rates[1]}
        )
    return rows
