"""The museum of notebook 20 at work: each exhibit on the world of the notebook, with the same noise; the instruments.

All runs are computed at once; the notebook has the same world, loop and instruments for one filter, the student's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ..analysis.consistency import Honesty, anees_band, honesty, md2
from ..geometry import Frame2, numerical_jacobian, wrap
from ..models.motion import Odometry2
from ..models.sensors import RangeBearing
from ..simulation import draw
from . import museum
from .exercises.nb20_guard import guard
from .fleet import Scenario

RUNS = 20


def world(loops=2.0, n=12, radius=6.0, max_range=4.0):
    """Two rounds of 6 m radius, 12 landmarks; noisy enough for a bug to show within a minute. It is the notebook's."""
    angle = 2 * np.pi * np.arange(n) / n
    away = radius + np.random.default_rng(7).uniform(-2.5, 2.5, n)
    step = np.array([0.3, 0.0, 0.3 / radius])
    return Scenario(
        points=away[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1),
        start=np.array([radius, 0, np.pi / 2]),
        step=step,
        U=np.diag(np.square([0.02, 0.005, np.radians(0.7)])),
        sensor=RangeBearing(0.15, np.radians(2), max_range),
        frames=round(loops * 2 * np.pi * radius / step[0]),
        dt=0.3,
    )


@dataclass(frozen=True)
class Readings:
    """What the instruments show of R runs of F frames.

    Attributes
    ----------
    error, nees : ndarray, shape (F, R)
        Position error, m, and NEES of the pose.
    nis : ndarray, shape (M, R)
        Of the M innovations; `nis_frame` (M,) says when.
    map_error : ndarray, shape (R,)
        RMSE of the map at the end, m.
    meter : Honesty
        Of all frames of all runs.
    broken : int
        Runs in which P had a negative eigenvalue, or was not finite.
    x, P : ndarray
        State of the first run at the end; landmarks from index 3 on.
    path, truth : ndarray, shape (F, 3)
        Poses of the first run, estimated and true.
    """

    error: np.ndarray
    nees: np.ndarray
    nis: np.ndarray
    nis_frame: np.ndarray
    map_error: np.ndarray
    meter: Honesty
    broken: int
    x: np.ndarray
    P: np.ndarray
    path: np.ndarray
    truth: np.ndarray

    @property
    def rmse(self) -> float:
        """Median over the runs of the RMSE of the position, m."""
        return float(np.median(np.sqrt(np.mean(self.error**2, 0))))

    @property
    def mean_nees(self) -> float:
        """Median over the runs of the mean NEES of the pose."""
        return _middle(self.nees)

    @property
    def mean_nis(self) -> float:
        """Median over the runs of the mean NIS."""
        return _middle(self.nis)


@cache
def readings(key="right", runs=RUNS, seed=20) -> Readings:
    """Run an exhibit."""
    return run(museum.mutant(key), runs, seed)


def run(filter: museum.Filter, runs=RUNS, seed=20) -> Readings:
    """Run a filter on the world of the museum; the noise does not depend on the filter."""
    s, f, robot = world(), filter, Odometry2()
    motion, sensing = (np.random.default_rng(q) for q in np.random.SeedSequence(seed).spawn(2))
    truth, x, P = s.start, np.tile(s.start, (runs, 1)), np.zeros((runs, 3, 3))
    U, R = f.told(s.U), s.sensor.R
    poses, covs, truths, innovations, frames, ranges, broken = [], [], [], [], [], {}, np.zeros(runs, bool)
    with np.errstate(all="ignore"):
        for k in range(s.frames):
            truth = robot.move(truth, s.step, s.dt)[0]
            x, P = f.predict(x, P, s.step + draw(motion, s.U, (runs,)), U)
            y = s.sensor.project(Frame2(truth).to_frame(s.points)[0])[0]
            seen = np.flatnonzero(y[:, 0] <= s.sensor.max_range).tolist()
            y = y + draw(sensing, R, (runs, len(y)))
            y[..., 1] = wrap(y[..., 1])
            for i in seen:
                known = i in ranges
                if not known:
                    n = x.shape[-1]
                    x, P = f.augment(x, P, y[:, i], R)
                    ranges[i] = slice(n, n + 2)
                if known or f.again:
                    e, H = f.observe(x, ranges[i])
                    z, Z = f.innovation(y[:, i], e), H @ P @ museum.T(H) + R
                    x, P = museum.correct(x, P, z, Z, H)
                    innovations.append((z, Z))
                    frames.append(k)
            poses.append(x[:, :3])
            covs.append(P[:, :3, :3])
            truths.append(truth)
            if k % 10 == 9:
                broken |= _no_covariance(P)
    e = np.array(poses) - np.array(truths)[:, None]
    e[..., 2] = wrap(e[..., 2])
    l = np.stack([x[:, r] for r in ranges.values()], 1)
    nis = md2(*(np.array(a) for a in zip(*innovations, strict=True)))
    covs = np.array(covs)
    return Readings(
        error=np.hypot(e[..., 0], e[..., 1]),
        nees=md2(e, covs),
        nis=nis,
        nis_frame=np.array(frames),
        map_error=np.sqrt(np.mean(np.sum((l - s.points[list(ranges)]) ** 2, -1), -1)),
        meter=honesty(e.reshape(-1, 3), covs.reshape(-1, 3, 3), nis.ravel(), map_P=P, runs=runs),
        broken=int(broken.sum()),
        x=x[0],
        P=P[0],
        path=np.array(poses)[:, 0],
        truth=np.array(truths),
    )


def _no_covariance(P):
    """Which of the covariances are none: an eigenvalue below zero by more than rounding, or not finite."""
    finite = np.isfinite(P).all((-1, -2))
    w = np.linalg.eigvalsh(np.where(finite[:, None, None], (P + museum.T(P)) / 2, np.eye(P.shape[-1])))
    return ~finite | (w[:, 0] < -1e-9 * np.abs(w).max(-1))


def _middle(a):
    """Median over the runs of the mean over time; numbers that do not exist are left out."""
    means = [run[np.isfinite(run)].mean() for run in a.T if np.isfinite(run).any()]
    return float(np.median(means)) if means else float("inf")


# ---- the filter taken to pieces ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Bench:
    """Parts of a filter tested alone, in many runs: mean NEES.

    Attributes
    ----------
    position, heading : float
        After half a round with the sensor covered: only predictions. Honest: 2 and 1.
    first : float
        Of a landmark seen once by a robot whose pose is known exactly. Honest: 2.
    first_lost : float
        Of a landmark seen once by a robot after that half round. Honest: 2.
    """

    position: float
    heading: float
    first: float
    first_lost: float


@cache
def bench(key="right", runs=400, seed=21) -> Bench:
    """Test prediction and initialisation of an exhibit alone."""
    s, f, robot = world(), museum.mutant(key), Odometry2()
    motion, sensing = (np.random.default_rng(q) for q in np.random.SeedSequence(seed).spawn(2))
    x, P = np.tile(s.start, (runs, 1)), np.zeros((runs, 3, 3))
    x_right, P_right, truth = x, P, s.start
    for _ in range(s.frames // 4):
        truth = robot.move(truth, s.step, s.dt)[0]
        u = s.step + draw(motion, s.U, (runs,))
        x, P = f.predict(x, P, u, f.told(s.U))
        x_right, P_right = museum.predict(x_right, P_right, u, s.U)
    e = x - truth
    e[:, 2] = wrap(e[:, 2])
    l = Frame2(truth).from_frame(np.array([3.0, 1.0]))[0]
    y = s.sensor.project(Frame2(truth).to_frame(l)[0])[0] + draw(sensing, s.sensor.R, (runs,))
    return Bench(
        position=_mean(md2(e[:, :2], P[:, :2, :2])),
        heading=_mean(md2(e[:, 2:], P[:, 2:, 2:])),
        first=_first_sight(f, np.tile(truth, (runs, 1)), np.zeros((runs, 3, 3)), y, s.sensor.R, l),
        first_lost=_first_sight(f, x_right, P_right, y, s.sensor.R, l),
    )


def _first_sight(f, x, P, y, R, l):
    """Mean NEES of a new landmark, whose true place is l."""
    x, P = f.augment(x, P, y, R)
    if f.again:
        e, H = f.observe(x, slice(3, 5))
        x, P = museum.correct(x, P, f.innovation(y, e), H @ P @ museum.T(H) + R, H)
    return _mean(md2(x[:, 3:] - l, P[:, 3:, 3:]))


def _mean(a):
    return float(np.mean(a[np.isfinite(a)])) if np.isfinite(a).any() else float("nan")


# ---- which test would have caught it -------------------------------------------------------------------------------

TESTS = {
    "runs to the end": "no exception, and numbers at the end",
    "picture": "position RMSE at most 1.5 times that of the right filter",
    "NIS": "in its 99.9 % band, 20 runs",
    "NEES": "in its 99.9 % band, 20 runs",
    "P >= 0": "no negative eigenvalue in 20 runs",
    "sensor covered": "NEES of half a round of predictions, 400 runs",
    "first sight": "NEES of a new landmark, with the pose known and after half a round, 400 runs each",
    "guard": "P of a prediction against finite differences (exercise 20.2)",
    "H": "H against finite differences",
    "seam": "an innovation is never larger than half a turn",
}


@cache
def caught(key="right") -> dict[str, bool]:
    """Which of the tests an exhibit fails."""
    f, r, b = museum.mutant(key), readings(key), bench(key)
    two, one = anees_band(2, 400, 0.999), anees_band(1, 400, 0.999)
    out = lambda value, band: not band[0] <= value <= band[1]
    says = r.meter.verdicts()
    return {
        "runs to the end": not np.isfinite(r.error).all(),
        "picture": not r.rmse <= 1.5 * readings("right").rmse,
        "NIS": says["nis"] != "as it should be",
        "NEES": says["nees"] != "as it should be",
        "P >= 0": r.broken > 0,
        "sensor covered": out(b.position, two) or out(b.heading, one),
        "first sight": out(b.first, two) or out(b.first_lost, two),
        "guard": _guard_rings(f),
        "H": _wrong_H(f),
        "seam": bool(np.abs(f.innovation(np.array([5.0, 3.1]), np.array([5.0, -3.1]))[1]) > np.pi),
    }


def mutant_case():
    """A state with two landmarks, all numbers different."""
    rng = np.random.default_rng(22)
    A, B = rng.normal(size=(7, 9)), 0.1 * rng.normal(size=(3, 4))
    return np.array([1.0, -2.0, 0.7, 4.0, 1.0, -3.0, 2.5]), A @ A.T, np.array([0.8, 0.1, 0.4]), B @ B.T


def _guard_rings(f):
    x, P, u, U = mutant_case()
    return bool(np.abs(guard(f.predict, x, P, u, U)).max() > 1e-5)


def _wrong_H(f):
    x, r = mutant_case()[0], slice(5, 7)
    return bool(np.abs(f.observe(x, r)[1] - numerical_jacobian(lambda x: f.observe(x, r)[0], x)).max() > 1e-6)
