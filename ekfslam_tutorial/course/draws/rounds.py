"""The lecture's world: its log for SLAM, and simulated rounds with fresh noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...analysis.consistency import md2
from ...datasets import lecture
from ...geometry import Frame2, wrap
from ...simulation import draw

ODOMETRY = np.diag(lecture.ODOMETRY_STD**2)  # covariance of one step


def truth():
    """True landmarks of the lecture's log, by id."""
    return dict(zip((int(i) for i in lecture.true_landmarks()[0]), lecture.true_landmarks()[1], strict=True))


def true_path():
    """True poses of the lecture's log, shape (50, 3)."""
    return np.array([lecture.get_pose(k) for k in range(1, lecture.n_steps() + 1)])


def odometry_path():
    """The steps of the odometry, added up, shape (50, 3)."""
    F = [Frame2(lecture.get_pose(1))]
    for k in range(2, lecture.n_steps() + 1):
        F.append(F[-1].compose(Frame2(lecture.odometry(k)))[0])
    return np.array([f.x for f in F])


@dataclass(frozen=True)
class Run:
    """The end of a simulated run: state, ids, true state in the same order; path of the filter and of the odometry."""

    x: np.ndarray
    P: np.ndarray
    ids: list
    truth: np.ndarray
    path: np.ndarray
    drift: np.ndarray

    @property
    def nees(self) -> float:
        """Of the whole state: robot and map."""
        d = self.x - self.truth
        d[2] = wrap(d[2])
        return float(md2(d, self.P))


def simulate(slam_frame, seed, frames=50, sensor=lecture.SENSOR, U=ODOMETRY, sight=lecture.SIGHT):
    """Drive the lecture's round among its landmarks with fresh noise, and filter it with `slam_frame`.

    Parameters
    ----------
    slam_frame : callable
        As in exercise 05.5.
    seed : int
    frames : int
        Time steps; 50 are one round.
    sensor : RangeBearing
        Its noise.
    U : ndarray, shape (3, 3)
        Noise of the odometry.
    sight : float
        Landmarks that are truly nearer are seen, m.

    Returns
    -------
    Run
    """
    real, l = true_path(), lecture.true_landmarks()[1]
    rng = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2)]
    x, P, ids, dead, path, drift = real[0].copy(), np.zeros((3, 3)), [], Frame2(real[0]), [], []
    for k in range(frames):
        here, gone = Frame2(real[k % len(real)]), Frame2(real[max(k - 1, 0) % len(real)])
        u = gone.inverse()[0].compose(here)[0].x + draw(rng[0], U)
        true = sensor.project(here.to_frame(l)[0])[0]
        ys = true + draw(rng[1], sensor.R, (len(true),))
        seen = np.flatnonzero(true[:, 0] < sight)
        x, P, ids = slam_frame(x, P, list(ids), u, U, [int(i) + 1 for i in seen], ys[seen], sensor.R)
        x, P, dead = np.asarray(x, float), np.asarray(P, float), dead.compose(Frame2(u))[0]
        path.append(x[:3].copy())
        drift.append(dead.x)
    truths = np.concatenate([here.x, *(l[int(i) - 1] for i in ids)])
    return Run(x, P, [int(i) for i in ids], truths, np.array(path), np.array(drift))
