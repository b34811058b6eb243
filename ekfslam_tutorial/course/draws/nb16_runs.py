"""Runs of notebook 16: where a sensor's methods are called, a beacon in the universal loop, a robot that passes one."""

import sys
from collections import Counter
from dataclasses import dataclass

import numpy as np

from ...analysis import anees_band
from ...models.sensors import RangeBearing
from ...toolbox import UserData, universal_slam
from ..exercises.nb16_birth import hypothesis
from ..exercises.nb16_weights import reweigh

METHODS = ("R", "project", "residual", "visible", "retro")
PHASES = {
    "sim_observation": "simulate",
    "correct_known_lmks": "correct known",
    "init_new_lmks": "start new",
    "__post_init__": "read user data",
}

# ---- entry points ---------------------------------------------------------------------------------------------------


def phase():
    """In which part of the loop the program is: the name of the outermost known function that is running."""
    frame, found = sys._getframe(2), ""
    while frame is not None:
        found = PHASES.get(frame.f_code.co_name, found)
        frame = frame.f_back
    return found


def spy(model, filled, calls):
    """A sensor class whose methods are counted; those that are not `filled` raise NotImplementedError."""

    def counted(name):
        """A method that counts its calls, or stops if it is still empty."""
        original = getattr(model, name)
        original = getattr(original, "func", original)  # a cached_property holds its function

        def method(self, *args):
            """The method in its place."""
            calls[name, phase()] += 1
            if name not in filled:
                raise NotImplementedError(f"{name}: your code here")
            return original(self, *args)

        return property(method) if name == "R" else method

    return type("MySensor", (model,), {name: counted(name) for name in METHODS})


def entry_points(filled, frames=3):
    """Run the universal loop with a range-bearing sensor of which only some methods are written.

    Returns
    -------
    calls : Counter
        How often each (method, phase) was called, until the end or the stop.
    stop : (str, str) or None
        Method and phase where the run stopped.
    """
    calls = Counter()
    sensor = spy(RangeBearing, filled, calls)
    scenario = SCENARIO | {"time": {"dt": 0.2, "last": frames}, "sensor": [{"type": "my_sensor", **NEAR}]}
    del scenario["sensor"][0]["max_range"]
    try:
        for _ in universal_slam(UserData.from_dict(scenario, models=[sensor]), engine="plain"):
            pass
    except NotImplementedError:
        return calls, next(reversed(calls))
    return calls, None


# ---- a run in the universal loop -------------------------------------------------------------------------------------

SCENARIO = {
    "name": "beacons",
    "time": {"dt": 0.2, "last": 120},
    "world": {"type": "random2", "n": 10},
    "robot": [
        {"motion": "odometry2", "position": [0, -3], "dx": [0.15, 0], "da_deg": 3, "dx_std": 0.02, "da_std_deg": 0.6}
    ],
}
NEAR = {"range_std": 0.1, "bearing_std_deg": 2.0, "max_range": 2.5, "fov_deg": 120.0}


@dataclass(frozen=True)
class Runs:
    """Ends of several runs: NEES and position error (m) of the robot."""

    nees: np.ndarray
    off: np.ndarray
    dof: int

    @property
    def anees(self):
        """Mean NEES of the robot."""
        return float(self.nees.mean())

    @property
    def rms(self):
        """Root of the mean squared position error, m."""
        return float(np.sqrt(np.mean(self.off**2)))

    @property
    def band(self):
        """Where the mean NEES of as many honest runs lies, in 99.9 % of the cases."""
        return anees_band(self.dof, len(self.nees), 0.999)

    def __str__(self):
        low, high = self.band
        verdict = "honest" if low <= self.anees <= high else "over-confident" if self.anees > high else "too cautious"
        n = f"{self.anees:.1f}" if self.anees < 1000 else f"{self.anees:.0e}"
        return f"robot off by {self.rms:.2f} m (RMS), ANEES {n}, band {low:.1f} to {high:.1f}: {verdict}"


# ---- ranges alone ---------------------------------------------------------------------------------------------------

STD, RANGES, STEP = 0.1, 25, 0.2  # noise of a range (m), how many, and the way between two (m)


def passes(n, way, seed=16):
    """Robots that pass a beacon, at known poses.

    Parameters
    ----------
    n : int
    way : str
        "straight", or "curve": a quarter of a circle of the same length.
    seed : int

    Returns
    -------
    x : ndarray, shape (RANGES, 3)
        Poses, the same for all.
    truth : ndarray, shape (n, 2)
        Beacons, 2 to 6 m from the start, on all sides.
    y : ndarray, shape (n, RANGES)
        Measured ranges, m.
    """
    rng = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2)]
    k = np.arange(RANGES)
    a = k / (RANGES - 1) * np.pi / 2 * (way == "curve")
    radius = STEP * (RANGES - 1) / (np.pi / 2)
    xy = np.stack([radius * np.sin(a), radius * (1 - np.cos(a))] if way == "curve" else [STEP * k, 0 * k], -1)
    r, b = rng[0].uniform(2, 6, n), rng[0].uniform(-np.pi, np.pi, n)
    truth = np.stack([r * np.cos(b), r * np.sin(b)], -1)
    y = np.linalg.norm(truth[:, None] - xy, axis=-1) + STD * rng[1].standard_normal((n, RANGES))
    return np.column_stack([xy, a]), truth, y


def start_ring(x, r, H, birth=hypothesis):
    """H hypotheses on the ring of one range: weights, points (H, 2), covariances (H, 2, 2). The pose is known."""
    width = 2 * np.pi / H
    born = [birth(x, np.zeros((3, 3)), r, STD**2, (i + 0.5) * width, width**2 / 12) for i in range(H)]
    return np.full(H, 1 / H), np.array([b[0] for b in born]), np.array([b[1] for b in born])


def correct_ring(w, m, P, x, y):
    """One range corrects each hypothesis by its own EKF, and their weights."""
    d = m - x[:2]
    r = np.linalg.norm(d, axis=-1)
    E = d / r[:, None]
    PE = (P @ E[:, :, None])[..., 0]
    Z, z = (E * PE).sum(-1) + STD**2, y - r
    w = reweigh(np.maximum(w, 1e-300), z, Z)
    m, P = m + PE * (z / Z)[:, None], P - PE[:, :, None] * PE[:, None, :] / Z[:, None, None]
    keep = w > 1e-4
    return w[keep] / w[keep].sum(), m[keep], P[keep]


def places(w, m):
    """Hypotheses that agree within 0.5 m, taken together: list of (place of the best of them, weight of all)."""
    found = []
    while len(w):
        best = m[np.argmax(w)]
        near = np.linalg.norm(m - best, axis=-1) < 0.5
        found.append((best, float(w[near].sum())))
        w, m = w[~near], m[~near]
    return found


def verdict(w, m, truth):
    """How far the best hypothesis is off (m), and how much weight lies within 0.5 m of it."""
    best, weight = places(np.asarray(w), np.asarray(m))[0]
    return float(np.linalg.norm(best - truth)), weight
