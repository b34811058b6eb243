"""The full circuit: from an empty map once round and a little further, 10 landmarks seen in each step."""

import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from .clock import quiet
from .oracle import Oracle
from .ours import STEPS
from .world import circuit

GROWTH = 3.2  # exponent of the total time in N from which the next one is guessed
MRPT = ("MRPT, joint", "naive"), ("MRPT, one by one", "davison")
UNTOLD = "MRPT, one by one, reach not told"
SHORT = 0.1  # s; a shorter circuit is driven twice. Most of it is overhead, which grows with the number of steps only


def makers(peers):
    """Variant name to a function of the world that returns seconds of CPU for each step."""
    found = {name: drive(make) for name, make in STEPS.items()}
    found["textbook numpy, joint"] = drive(lambda world: Oracle(world, joint=True))
    if "filterpy_peer" in peers:
        joint = peers.filterpy_peer.FilterPyJoint
        found["filterpy"] = drive(lambda world: peers.filterpy_peer.FilterPy(world))
        found["filterpy, joint"] = drive(lambda world: joint(world))
        found["filterpy, joint, motion by hand"] = drive(lambda world: joint(world, by_hand=True))
    if "gtsam_peer" in peers:
        found["GTSAM iSAM2"] = drive(lambda world: peers.gtsam_peer.Isam2(world))
        found["GTSAM iSAM2, partial check"] = drive(lambda world: peers.gtsam_peer.Isam2(world, partial=True))
        found["GTSAM batch"] = drive(lambda world: peers.gtsam_peer.Batch(world))
        found["GTSAM batch, Gauss-Newton"] = drive(lambda world: peers.gtsam_peer.GaussNewton(world))
    if peers.mrpt:
        for name, *how in (*MRPT, (UNTOLD, "davison", False)):
            found[name] = lambda world, how=how: mrpt(peers, world, *how)
    return found


def drive(make):
    """Time each step of a filter of this process.

    A short circuit is driven twice, and the second time counts: the first finds the caches full of another variant.
    """

    def seconds(world):
        with quiet():
            times = once(make(world), world)
            return times if times.sum() > SHORT else once(make(world), world)

    return seconds


def once(filter, world):
    """Seconds of each step of one circuit."""
    times = []
    for k in range(len(world.steps)):
        start = time.thread_time_ns()
        filter.step(k)
        times.append(1e-9 * (time.thread_time_ns() - start))
    return np.array(times)


def mrpt(peers, world, method, told=True):
    """The same in MRPT's own process, which is told how far the sensor sees, or not."""
    with TemporaryDirectory() as folder:
        return peers.modules["mrpt_peer"].run(peers.mrpt, world, method, Path(folder), told)[0]


def run(sizes, peers, repeats, spend, too_slow, tell=lambda n: None):
    """Drive the circuit for each N.

    Parameters
    ----------
    sizes : sequence of int
    peers : Peers
    repeats : int
        The median of so many circuits counts, or of fewer where they take long. All variants take turns: the machine
        has slow moments of some tenths of a second, and each has its share of them.
    spend : float
        No more circuits of a variant after so many seconds of them.
    too_slow : float
        What should take longer, in seconds, is left out, and said to be.
    tell : callable
        Gets each N before it begins.

    Yields
    ------
    dict
        n_lmks, variant, steps, total_s, late_us (median of the last tenth of the steps), max_us; or skipped, failed.
    """
    last = {}
    for n_lmks in sizes:
        tell(n_lmks)
        world = circuit(n_lmks)
        times = {name: [] for name in makers(peers)}
        failed = {}
        for _ in range(repeats):
            for name, seconds in makers(peers).items():
                n, total = last.get(name, (n_lmks, 0.0))
                guess = total * (n_lmks / n) ** (GROWTH if total > SHORT else 2)
                if guess > too_slow:
                    failed[name] = {"skipped": f"about {guess:.0f} s expected"}
                elif name not in failed and sum(t.sum() for t in times[name]) < spend:
                    try:
                        times[name].append(seconds(world))
                    except Exception as error:
                        failed[name] = {"failed": f"{type(error).__name__}: {error}"}
        for name, found in times.items():
            row = {"n_lmks": n_lmks, "variant": name, "steps": len(world.steps)}
            if name in failed:
                yield row | failed[name]
                continue
            totals = [float(t.sum()) for t in found]
            last[name] = n_lmks, min(totals)
            late = len(world.steps) // 10 + 1
            yield row | {
                "total_s": float(np.median(totals)),
                "least_s": min(totals),
                "late_us": 1e6 * float(np.median([np.median(t[-late:]) for t in found])),
                "max_us": 1e6 * float(np.median([t.max() for t in found])),
                "repeats": len(found),
            }
