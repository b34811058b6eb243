"""Monte-Carlo runs of a small map, N = 10 landmarks and m = 1 seen: how many steps of runs in a second."""

import numpy as np

from ekfslam_tutorial.fast import FastMap as Map

from .clock import Variant, compare
from .given import given
from .ours import Filter
from .world import R, U, lap

LMKS, SEEN = 10, 1


class Batched:
    """Many runs at once, blocks given: the same world, each run with measurements of its own."""

    def __init__(self, world, runs, seed=1):
        from ekfslam_tutorial.fast import Batch

        rng = np.random.default_rng(seed)
        n = len(world.x0)
        L = np.linalg.cholesky(world.P0)
        x = world.x0 + rng.normal(size=(runs, n)) @ L.T
        self.batch = Batch(x, np.tile(world.P0, (runs, 1, 1)))
        self.given = given(world)
        self.rob, self.runs = slice(0, 3), runs
        self.z = [g.z[0] + rng.normal(size=(runs, 2)) * np.sqrt(np.diag(R)) for g in self.given]

    def step(self, k):
        """One step of all runs."""
        k %= len(self.given)
        g, i = self.given[k], int(self.given[k].ids[0])
        self.batch.predict(self.rob, np.tile(g.x, (self.runs, 1)), g.X_x, g.X_u, U)
        self.batch.correct(((self.rob, g.H_r[0]), (slice(3 + 2 * i, 5 + 2 * i), g.H_l[0])), self.z[k], R)


class CompiledRuns:
    """numba: run after run, models included."""

    def __init__(self, compiled, world, runs):
        self.runs, self.compiled, self.world = runs, compiled, world
        self.x, self.P = np.tile(world.x0, (runs, 1)), np.tile(world.P0, (runs, 1, 1))
        self.W = np.zeros((2, len(world.x0)))

    def step(self, k):
        """One step of all runs."""
        s = self.world.steps[k % len(self.world.steps)]
        y = np.broadcast_to(s.y, (1, self.runs, *s.y.shape))
        self.compiled.runs(self.x, self.P, self.W, s.u[None], U, s.ids[None], y, R)


def run(sizes, peers, budget):
    """Rows: variant, runs, steps_per_s (steps of runs in a second of CPU, median), times of one step of all runs."""
    world = lap(LMKS, SEEN)
    variants = [Variant("one run at a time", lambda: Filter(world, Map()).step, info={"runs": 1})]
    for runs in sizes:
        make = lambda runs=runs: Batched(world, runs).step
        variants.append(Variant(f"batched, {runs} runs", make, info={"runs": runs}))
    if "compiled" in peers:
        make = lambda: CompiledRuns(peers.compiled, world, 100).step
        variants.append(Variant("numba loops, 100 runs", make, info={"runs": 100}))
    rows = []
    for name, result in compare(variants, budget).items():
        if "cpu_us" in result:
            result["steps_per_s"] = 1e6 * result["runs"] / result["cpu_us"]["median"]
        rows.append({"variant": name} | result)
    return rows
