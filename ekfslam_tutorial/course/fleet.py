"""One SLAM scenario run many times at once, each time with fresh noise: the Monte-Carlo experiments of the lessons.

World and true path are the same in all runs. So in every frame all runs see the same landmarks, their states have the
same order, and all arrays carry the run as leading axis. The two formulas that the lessons are about are arguments,
written for one run: the student's own, or a wrong one whose effect is to be seen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..analysis.consistency import md2
from ..geometry import Frame2, wrap
from ..models.landmarks import EucPnt
from ..models.motion import Odometry2
from ..models.observation import observe, retro_project
from ..models.sensors import RangeBearing
from ..simulation import draw

AT_ROBOT = Frame2(np.zeros(3))  # the sensor sits at the robot's origin
POINT = EucPnt(2)


@dataclass(frozen=True)
class Scenario:
    """What all runs share.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        True landmarks, m.
    start : ndarray, shape (3,)
        First pose; every run knows it exactly: it is the origin of its map.
    step : ndarray, shape (3,)
        True odometry [dx, dy, dtheta] of each frame (m, m, rad).
    U : ndarray, shape (3, 3)
        Covariance of the measured odometry.
    sensor : RangeBearing
    frames : int
    dt : float
        Seconds between frames, for the time axis only.
    """

    points: np.ndarray
    start: np.ndarray
    step: np.ndarray
    U: np.ndarray
    sensor: RangeBearing
    frames: int
    dt: float = 0.1


def round_trip(loops: float = 2, n: int = 20, radius: float = 10.0, max_range: float = 5.0) -> Scenario:
    """A robot drives at 1 m/s along a circle, landmarks to its left and right.

    The landmarks stand every 360/n degrees, up to 4 m inside or outside the circle. The odometry is off by 1 cm and
    0.3 degrees (1 sigma) in each step of 10 cm, the sensor by 0.2 m and 2 degrees.
    """
    angle = 2 * np.pi * np.arange(n) / n
    away = radius + np.random.default_rng(7).uniform(-4, 4, n)
    points = away[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
    step = np.array([0.1, 0.0, 0.1 / radius])
    U = np.diag(np.square([0.01, 0.002, np.radians(0.3)]))
    sensor = RangeBearing(0.2, np.radians(2), max_range)
    return Scenario(points, np.array([radius, 0, np.pi / 2]), step, U, sensor, round(loops * 2 * np.pi * radius / 0.1))


@dataclass
class Result:
    """What came out of all runs: F frames, R runs.

    Attributes
    ----------
    t : ndarray, shape (F,)
        Seconds.
    truth : ndarray, shape (F, 3)
        True poses.
    nees : ndarray, shape (F, R)
        Of the pose, 3 degrees of freedom.
    nis : ndarray, shape (M, R)
        Of each of the M corrections, 2 degrees of freedom.
    nis_t : ndarray, shape (M,)
        Seconds: when each of them was.
    position_error : ndarray, shape (F, R)
        Metres.
    map_error : ndarray, shape (R, N)
        Of each landmark seen, at the end, metres.
    ranges : dict of int to slice
        Where each landmark is in the state, by its index; in the order of first sight.
    states : dict of int to (ndarray, ndarray)
        Mean and covariance of one run after the frames that were to be kept.
    """

    t: np.ndarray
    truth: np.ndarray
    nees: np.ndarray
    nis: np.ndarray
    nis_t: np.ndarray
    position_error: np.ndarray
    map_error: np.ndarray
    ranges: dict[int, slice]
    states: dict[int, tuple]

    @property
    def broken(self) -> int:
        """Number of runs in which P stopped being a covariance: it has no NEES, or Z no NIS."""
        return int(np.sum(np.isnan(self.nees).any(0) | np.isnan(self.nis).any(0)))

    def summary(self) -> dict[str, float]:
        """Return medians over the runs: RMSE of position and map (m), mean NEES of the pose, mean NIS."""
        rms = lambda e, axis: np.sqrt(np.mean(np.square(e), axis))
        return {
            "pose_rmse": float(np.median(rms(self.position_error, 0))),
            "map_rmse": float(np.median(rms(self.map_error, 1))),
            "nees": float(np.median(np.nanmean(self.nees, 0))),
            "nis": float(np.median(np.nanmean(self.nis, 0))),
        }


def run(
    scenario: Scenario, formulas: Mapping[str, Callable], runs: int = 20, seed: int = 0, keep=(), told=None, kept_run=0
) -> Result:
    """Run the scenario with the formulas under test.

    Parameters
    ----------
    scenario : Scenario
    formulas : mapping
        ``moved(P, X_x, X_u, U)`` returns the covariance after a motion; ``new_blocks(P, L_r, L_y, R)`` returns the
        covariance of a new landmark with the state so far, and with itself.
    runs : int
    seed : int
        Of the noise, which does not depend on the formulas: two results with one seed can be compared run by run.
    keep : collection of int
        Frames whose state is kept, of one run.
    told : RangeBearing, optional
        The sensor model that the filter uses, if it is not the true one.
    kept_run : int
        Which run that is.
    """
    s, rng, robot = scenario, np.random.default_rng(seed), Odometry2()
    moved, new_blocks = formulas["moved"], formulas["new_blocks"]
    truth, x, P, used = s.start, np.tile(s.start, (runs, 1)), np.zeros((runs, 3, 3)), told or s.sensor
    truths, poses, pose_covariances, innovations, when, ranges, states = [], [], [], [], [], {}, {}
    for k in range(1, s.frames + 1):
        truth = robot.move(truth, s.step, s.dt)[0]
        x[:, :3], X_x, X_u = robot.move(x[:, :3], s.step + draw(rng, s.U, (runs,)), s.dt)
        P = np.array([moved(*one, s.U) for one in zip(P, X_x, X_u, strict=True)], float)

        y = s.sensor.project(Frame2(truth).to_frame(s.points)[0])[0]
        seen = np.flatnonzero(y[:, 0] <= s.sensor.max_range).tolist()
        y = y + draw(rng, s.sensor.R, (runs, len(y)))
        y[..., 1] = wrap(y[..., 1])
        known = [i for i in seen if i in ranges]
        innovations += [correct(x, P, ranges[i], used, y[:, i]) for i in known]
        when += [k * s.dt] * len(known)
        for i in (i for i in seen if i not in ranges):
            x, P, ranges[i] = augment(x, P, used, y[:, i], new_blocks)

        truths.append(truth)
        poses.append(x[:, :3].copy())
        pose_covariances.append(P[:, :3, :3].copy())
        if k in keep:
            states[k] = x[kept_run].copy(), P[kept_run].copy()

    error = np.array(poses) - np.array(truths)[:, None]
    error[..., 2] = wrap(error[..., 2])
    l = np.stack([x[:, r] for r in ranges.values()], 1)
    return Result(
        t=np.arange(1, s.frames + 1) * s.dt,
        truth=np.array(truths),
        nees=md2(error, np.array(pose_covariances)),
        nis=md2(*(np.array(a) for a in zip(*innovations, strict=True))),
        nis_t=np.array(when),
        position_error=np.hypot(error[..., 0], error[..., 1]),
        map_error=np.linalg.norm(l - s.points[list(ranges)], axis=-1),
        ranges=ranges,
        states=states,
    )


def correct(x, P, r, sensor, y):
    """Correct all runs, in place, with a measurement of the landmark in range r; return innovations and covariances."""
    e, E_r, _, E_l = observe(Frame2(x[:, :3]), AT_ROBOT, sensor, POINT, x[:, r])
    PHt = P[:, :, :3] @ T(E_r) + P[:, :, r] @ T(E_l)
    Z = E_r @ PHt[:, :3] + E_l @ PHt[:, r] + sensor.R
    z = sensor.residual(y, e)
    K = T(np.linalg.solve(Z, T(PHt)))
    x += (K @ z[..., None])[..., 0]
    P -= K @ Z @ T(K)
    return z, Z


def augment(x, P, sensor, y, new_blocks):
    """Add a landmark to all runs; return x, P and its range."""
    l, L_r, _, L_y, _ = retro_project(Frame2(x[:, :3]), AT_ROBOT, sensor, POINT, y, np.zeros((len(x), 0)))
    blocks = [new_blocks(*one, sensor.R) for one in zip(P, L_r, L_y, strict=True)]
    P_lx, P_ll = (np.array([pair[j] for pair in blocks], float) for j in (0, 1))
    n = x.shape[1]
    P = np.concatenate([np.concatenate([P, T(P_lx)], -1), np.concatenate([P_lx, P_ll], -1)], -2)
    return np.concatenate([x, l], -1), P, slice(n, n + 2)


def T(A):
    """Return the transposes."""
    return np.swapaxes(A, -1, -2)
