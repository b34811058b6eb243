"""The run of notebook 06: a robot drives round a circle of landmarks, from an uncertain first pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...ekf import Map
from ...geometry import Frame2
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...models.sensors import RangeBearing
from ...simulation.simulator import SimObs
from ...simulation.streams import Streams, draw
from ...slam import Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place
from .films import film, snapshot

RADIUS, N, LAP = 10.0, 20, 126  # metres, landmarks, frames in a round
STEP = np.array([2 * np.pi * RADIUS / LAP, 0.0, 2 * np.pi / LAP])
U = np.diag(np.square([0.02, 0.005, np.radians(0.7)]))
SENSOR = RangeBearing(0.2, np.radians(2), max_range=5.0, fov=np.pi)  # it looks ahead
START = np.array([RADIUS, 0.0, np.pi / 2])
START_STD = 0.3  # m, of the first position
SEED = 1


def world():
    """20 landmarks, one every 18 degrees, up to 3 m inside or outside the path. Shape (20, 2)."""
    angle = 2 * np.pi * (np.arange(N) + 0.5) / N
    away = RADIUS + np.random.default_rng(7).uniform(-3, 3, N)
    return away[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)


@dataclass(frozen=True)
class Moment:
    """The filter after one frame: state, covariance, the range of each landmark by its index, the true pose.

    `seen` are the landmarks that were corrected or started in this frame.
    """

    x: np.ndarray
    P: np.ndarray
    ranges: dict
    truth: np.ndarray
    seen: tuple


@cache
def drive(start_std: float = START_STD, heading_std_deg: float = 0.0, rounds: int = 2, max_range: float = 5.0):
    """The run, kept: a list of `Moment`, one for each frame. The parameters are those of `frames`."""
    moments = []
    for now in frames(start_std, heading_std_deg, rounds, max_range):
        seen = tuple(e.lmk for e in now.events if e.kind in ("correction", "initialisation"))
        ranges = {id: lmk.r for id, lmk in now.lmks.items()}
        moments.append(Moment(now.map.x.copy(), now.map.P.copy(), ranges, now.truth[1], seen))
    return moments


def frames(start_std: float = START_STD, heading_std_deg: float = 0.0, rounds: int = 2, max_range: float = 5.0):
    """EKF-SLAM round a circle, ids known, from an uncertain first pose.

    Parameters
    ----------
    start_std : float
        Of the first position, m, in each direction.
    heading_std_deg : float
        Of the first heading, degrees.
    rounds : int
    max_range : float
        Of the sensor, m.

    Yields
    ------
    Snapshot
        Of each frame; good until the next one is drawn.
    """
    streams, opt, points = Streams(SEED), Options(lmk_type=EucPnt(2)), world()
    map, lmks, obs = Map(), {}, {}
    rob = Rob(1, Odometry2(), U=U)
    sen = Sen(1, 1, replace(SENSOR, max_range=max_range), Frame2, x=np.zeros(3))
    P0 = np.diag(np.square([start_std, start_std, np.radians(heading_std_deg)]))
    truth, motion, sensing = START, streams.motion(1), streams.sensing(1)
    place(map, rob, START + draw(motion, P0), P0)
    for k in range(rounds * LAP + 1):
        if k:
            truth = rob.motion.move(truth, STEP, 1.0)[0]
            rob.u = STEP + draw(motion, U)
            move(map, rob, 1.0)
        raw = scan(sen.model, truth, points, sensing)
        events, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        events += init_new_lmks(map, rob, sen, lmks, raw, new, opt)
        yield snapshot(k, map, rob, sen, lmks, obs, raw, events, truth, points)


def scan(sensor, pose, points, rng):
    """Noisy measurements of the points in range, with their ids 0, 1, ..."""
    noise = draw(rng, sensor.R, (len(points),))  # one per landmark, seen or not: the same draws in every run
    p = Frame2(pose).to_frame(points)[0]
    y = sensor.project(p)[0]
    ids = np.flatnonzero(sensor.visible(y, p))
    return SimObs(1, ids, y[ids] + noise[ids])


def closing(moments):
    """The frame in which landmark 0 is seen again for the first time."""
    for k in range(LAP // 2, len(moments)):
        if 0 in moments[k].seen:
            return k
    raise ValueError("the loop is not closed in this run")


def sigma(P, r):
    """Standard deviation of a point, m: root of the mean variance over its two directions."""
    return float(np.sqrt(np.trace(P[r, r]) / 2))


def sigma_between(P, a, b):
    """The same for the difference of two points."""
    D = P[a, a] + P[b, b] - P[a, b] - P[b, a]
    return float(np.sqrt(np.trace(D) / 2))


def replayed():
    """State log of the run, every second frame."""
    return film("Two rounds, first position known to 0.3 m", frames(), period=2)
