"""What one step of EKF-SLAM costs, measured: four ways to write the filter, and what the machine allows.

`python -m ekfslam_tutorial.course.draws.nb19_cost_runs` measures the stored table anew: half a minute, for which the
machine should have nothing else to do.
"""

from __future__ import annotations

import json
import platform
import time
from functools import cache
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ...analysis.fast_filter import CompressedMap, FastMap, predict, update
from ...geometry import Frame2
from ...models import observe
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...models.sensors import RangeBearing

TABLE = Path(__file__).with_name("nb19_cost.json")
SIZES, SEEN = (10, 20, 50, 100, 200, 500, 1000), (1, 10)
SENSOR, U = RangeBearing(0.1, 0.02), np.diag([0.02, 0.02, 0.005]) ** 2
STEP = np.array([1.0, 0.0, 0.0])


class World:
    """Landmarks on a circle, one per metre, all in the map; a robot drives inside it and sees the m next ones."""

    def __init__(self, n_lmks, m):
        a = 2 * np.pi * np.arange(n_lmks) / n_lmks
        self.lmks = max(4.0, n_lmks / (2 * np.pi)) * np.column_stack([np.cos(a), np.sin(a)])
        self.poses = np.column_stack([0.7 * self.lmks, a + np.pi / 2])
        self.m, self.n = m, 3 + 2 * n_lmks
        self.x = np.concatenate([self.poses[0], self.lmks.ravel()])
        self.P = 0.05**2 * (np.eye(self.n) + 1.0)  # everything shares a part of the error, as after a long run
        self.given = cache(self._given)

    def _given(self, k):
        """Step k: the robot's pose with X_x, X_u; ids (m,), z (m, 2), E_r (m, 2, 3) and E_l (m, 2, 2)."""
        pose, ids = self.poses[k], (k + np.arange(self.m)) % len(self.lmks)
        _, X_x, X_u = Odometry2().move(self.poses[k - 1], STEP, 1.0)
        _, E_r, _, E_l = observe(Frame2(pose), Frame2(np.zeros(3)), SENSOR, EucPnt(2), self.lmks[ids])
        return pose, X_x, X_u, ids, np.full((self.m, 2), 0.01), E_r, E_l


class Textbook:
    """Full matrices, one landmark after another: F P F' + Q and (I - K H) P, as in the formulas. n^3 operations."""

    def __init__(self, world):
        self.world, self.x, self.P, self.I = world, world.x.copy(), world.P.copy(), np.eye(world.n)

    def step(self, k):
        """One prediction and m corrections."""
        x, X_x, X_u, *seen = self.world.given(k)
        F, Q = self.I.copy(), np.zeros_like(self.P)
        F[:3, :3], Q[:3, :3], self.x[:3] = X_x, X_u @ U @ X_u.T, x
        self.P = F @ self.P @ F.T + Q
        for i, z, E_r, E_l in zip(*seen, strict=True):
            H = np.zeros((2, len(self.x)))
            H[:, :3], H[:, 3 + 2 * i : 5 + 2 * i] = E_r, E_l
            K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + SENSOR.R)
            self.x = self.x + K @ z
            self.P = (self.I - K @ H) @ self.P


class Blocks:
    """The same numbers, but only the blocks of F and H are multiplied: P - W W', W = P H' L^-T. n^2 operations."""

    def __init__(self, world):
        self.world, self.x, self.P = world, world.x.copy(), world.P.copy()

    def step(self, k):
        """One prediction and m corrections."""
        x, X_x, X_u, *seen = self.world.given(k)
        self.x[:3], self.P[:3] = x, X_x @ self.P[:3]
        self.P[:, :3] = self.P[:, :3] @ X_x.T
        self.P[:3, :3] += X_u @ U @ X_u.T
        for i, z, E_r, E_l in zip(*seen, strict=True):
            l = slice(3 + 2 * i, 5 + 2 * i)
            PHt = self.P[:, :3] @ E_r.T + self.P[:, l] @ E_l.T
            iL = np.linalg.inv(np.linalg.cholesky(E_r @ PHt[:3] + E_l @ PHt[l] + SENSOR.R))
            W = PHt @ iL.T
            self.x = self.x + W @ (iL @ z)
            self.P = self.P - W @ W.T


class Joint:
    """The package: all m landmarks in one correction, of one triangle of P."""

    Map = FastMap

    def __init__(self, world):
        self.world, self.map = world, self.Map()
        self.map.add(world.x, world.P)

    def step(self, k):
        """One prediction and one correction."""
        x, X_x, X_u, ids, z, E_r, E_l = self.world.given(k)
        robot, rows = slice(0, 3), 3 + 2 * ids[:, None] + np.arange(2)
        predict(self.map, robot, x, X_x, X_u, U)
        update(self.map, ((robot, E_r), (rows, E_l)), z, SENSOR.R)

    @property
    def P(self):
        """Covariance."""
        return self.map.P


class Compressed(Joint):
    """The package's compressed filter: only what is active is corrected at once, the rest now and then."""

    Map = CompressedMap


WAYS = {"textbook": Textbook, "blocks": Blocks, "joint": Joint, "compressed": Compressed}


@cache
def measured(n_lmks: int, m: int, budget: float = 0.1, slowest: float = 0.4) -> dict:
    """Microseconds of one step on this machine, on one processor. Measured once: the same question, the same answer.

    Parameters
    ----------
    n_lmks, m : int
        Landmarks in the map, and seen in a step.
    budget : float
        Seconds for each way.
    slowest : float
        A way is left out if by the stored table its step takes longer than this, in seconds.

    Returns
    -------
    dict of str to float
        By way, the median; of the compressed one, whose steps differ, the mean. And "limit".
    """
    world, found = World(n_lmks, m), {}
    with threadpool_limits(1):
        for name, way in WAYS.items():
            if expected(name, n_lmks, m) <= slowest:
                times = _times(way(world), len(world.lmks), budget, 120 if name == "compressed" and n_lmks > 40 else 3)
                found[name] = 1e6 * float(np.mean(times) if name == "compressed" else np.median(times))
        found["limit"] = _limit(world.n, m)
    return found


def _times(filter, around, budget, at_least):
    """Seconds of processor time of each step: for so long, and at least so many."""
    filter.step(0)
    times, k = [], 1
    while sum(times) < budget or (len(times) < at_least and sum(times) < 4 * budget):
        start = time.thread_time()
        filter.step(k % around)
        times.append(time.thread_time() - start)
        k += 1
    return times


def _limit(n, m):
    """Microseconds: n^2 2m operations at the speed of a matrix product, or 8 n^2 bytes read and written."""
    A, C, a = np.ones((400, 400)), np.empty((400, 400)), np.ones(max(n * n // 2, 8192))
    product = _least(lambda: np.matmul(A, A, out=C)) / (2 * 400**3)
    byte = _least(lambda: np.multiply(a, 1.0, out=a)) / (2 * a.nbytes)
    return 1e6 * max(n * n * 2 * m * product, 8 * n * n * byte)


def _least(do):
    times = []
    for _ in range(5):
        start = time.thread_time()
        for _ in range(4):
            do()
        times.append((time.thread_time() - start) / 4)
    return min(times)


@cache
def stored() -> dict:
    """The table that comes with the course: `machine`, and `rows` of n_lmks, m and microseconds by way."""
    return json.loads(TABLE.read_text(encoding="utf-8"))


def curve(name: str, m: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of landmarks and seconds of one step, from the stored table."""
    rows = [row for row in stored()["rows"] if row["m"] == m and name in row]
    return np.array([row["n_lmks"] for row in rows]), 1e-6 * np.array([row[name] for row in rows])


def expected(name: str, n_lmks: int, m: int) -> float:
    """Seconds of one step, read off the stored curve; 0 if there is none yet."""
    if not TABLE.exists():
        return 0.0
    n, seconds = curve(name, m)
    return float(np.exp(np.interp(np.log(n_lmks), np.log(n), np.log(seconds))))


def main():
    """Measure the table and store it."""
    rows = [{"n_lmks": n, "m": m, **measured(n, m, 0.5, np.inf)} for m in SEEN for n in SIZES]
    rows = [{k: v if isinstance(v, int) else float(f"{v:.3g}") for k, v in row.items()} for row in rows]
    table = {"machine": f"{_processor()}, one core", "date": time.strftime("%Y-%m-%d"), "rows": rows}
    TABLE.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


def _processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    return next((line.split(": ", 1)[1] for line in lines if line.startswith("model name")), platform.machine())


if __name__ == "__main__":
    main()
