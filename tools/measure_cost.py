"""Write the table of what a step of EKF-SLAM costs, for notebook 19: `python tools/measure_cost.py` (half a minute).

The four ways are those of the notebook's cells; the machine should have nothing else to do.
"""

import json
import platform
import time
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ekfslam_tutorial.course import registry
from ekfslam_tutorial.course.cells import experiment_of
from ekfslam_tutorial.course.draws.nb19_cost import SEEN, SIZES, TABLE


def notebook():
    """What the cells of notebook 19 define: `circle` and the ways."""
    answers = {"drive": "19.1", "sort_scan": "19.2", "manage": "19.3", "gps_error": "19.4"}
    return experiment_of("19", **{name: registry.get(id).reference for name, id in answers.items()})


def measured(cells, n_trees, m, budget=0.5):
    """Microseconds of one step on this machine, on one processor.

    Parameters
    ----------
    cells : dict
        From `notebook`.
    n_trees, m : int
        Trees in the map, and seen in a step.
    budget : float
        Seconds for each way.

    Returns
    -------
    dict of str to float
        By way, the median; of the compressed one, whose steps differ, the mean. And "limit".
    """
    found = {}
    with threadpool_limits(1):
        for name, way in cells["WAYS"].items():
            least = 120 if name == "compressed" and n_trees > 40 else 3
            times = step_times(way(*cells["circle"](n_trees, m)), budget, least)
            found[name] = 1e6 * float(np.mean(times) if name == "compressed" else np.median(times))
        found["limit"] = limit(3 + 2 * n_trees, m)
    return found


def step_times(step, budget, at_least):
    """Seconds of processor time of each step: for so long, and at least so many."""
    step(0)
    times, k = [], 1
    while sum(times) < budget or (len(times) < at_least and sum(times) < 4 * budget):
        start = time.thread_time()
        step(k)
        times.append(time.thread_time() - start)
        k += 1
    return times


def limit(n, m):
    """Microseconds: n^2 2m operations at the speed of a matrix product, or 8 n^2 bytes read and written."""
    A, C, a = np.ones((400, 400)), np.empty((400, 400)), np.ones(max(n * n // 2, 8192))
    product = least(lambda: np.matmul(A, A, out=C)) / (2 * 400**3)
    byte = least(lambda: np.multiply(a, 1.0, out=a)) / (2 * a.nbytes)
    return 1e6 * max(n * n * 2 * m * product, 8 * n * n * byte)


def least(do):
    """Seconds of a call, the best of five tries of four."""
    times = []
    for _ in range(5):
        start = time.thread_time()
        for _ in range(4):
            do()
        times.append((time.thread_time() - start) / 4)
    return min(times)


def main():
    """Measure the table and store it."""
    cells = notebook()
    rows = [{"n_lmks": n, "m": m, **measured(cells, n, m)} for m in SEEN for n in SIZES]
    rows = [{k: v if isinstance(v, int) else float(f"{v:.3g}") for k, v in row.items()} for row in rows]
    table = {"machine": f"{processor()}, one core", "date": time.strftime("%Y-%m-%d"), "rows": rows}
    TABLE.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


def processor():
    """Name of the processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    return next((line.split(": ", 1)[1] for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    main()
