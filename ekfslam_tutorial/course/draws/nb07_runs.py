"""Runs of notebook 07: a robot that drives round a room and must find out which landmark is which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...analysis.consistency import nees
from ...ekf import Map
from ...geometry import Frame2, align
from ...models.landmarks import EucPnt
from ...models.motion import Odometry2
from ...models.sensors import RangeBearing
from ...simulation.simulator import SimObs
from ...simulation.streams import Streams, draw
from ...slam import KnownIds, Lmk, Options, Rob, Sen, correct_known_lmks, init_new_lmks, move, place, project_lmks
from .films import film, snapshot

SENSOR = RangeBearing(0.1, np.radians(1.5), max_range=6.0)  # all round: fov 360 degrees
AHEAD = RangeBearing(0.1, np.radians(1.5), max_range=5.0, fov=np.pi)
STEP = np.array([0.4, 0.0, 0.1])  # a circle of 4 m, 63 frames a round
U = np.diag(np.square([0.02, 0.005, np.radians(0.5)]))
START = np.array([4.0, 0.0, np.pi / 2])
SEED = 3


def room():
    """Landmarks near the walls of a room of 13 m x 13 m, and some inside. Shape (14, 2), m."""
    return np.array([
        (6.0, -1.0), (5.6, 2.4), (6.2, 5.0), (2.3, 6.1), (-0.8, 5.6), (-3.6, 6.2), (-6.0, 3.4),
        (-5.6, -0.4), (-6.1, -3.6), (-3.2, -5.8), (0.4, -6.0), (3.6, -5.6), (1.2, 1.6), (-1.6, -1.4),
    ])  # fmt: skip


@dataclass(frozen=True)
class Frame:
    """The filter after one frame; `origin` says which true landmark started each one in the map (-1: clutter)."""

    x: np.ndarray
    P: np.ndarray
    ranges: dict
    origin: dict
    truth: np.ndarray
    nees: float
    matches: int
    wrong: int


def run(*args, **options):
    """The run, kept: a list of `Frame`. The parameters are those of `frames`."""
    out = []
    for now, origin in frames(*args, **options):
        rob, map, truth = now.robs[0], now.map, now.truth[1]
        pairs = [
            (origin[o.lmk], int(now.raw[1].ids[o.index])) for o in now.obs.values() if o.updated and o.lmk in origin
        ]
        ranges = {id: lmk.r for id, lmk in now.lmks.items()}
        e = float(nees(rob.frame(map), map.P[rob.r, rob.r], Frame2(truth))) if now.k else np.nan
        wrong = sum(a != b for a, b in pairs)
        out.append(Frame(map.x.copy(), map.P.copy(), ranges, dict(origin), truth, e, len(pairs), wrong))
    return out


def frames(association=None, frames=126, *, swap_at=None, clutter=0.0, min_match_ratio=0.0, sensor=SENSOR):
    """EKF-SLAM round the room.

    Parameters
    ----------
    association : callable, optional
        Known ids if not given. Other associations do not look at the ids.
    frames : int
        63 are one round.
    swap_at : int, optional
        In this frame two measurements get each other's id.
    clutter : float
        Mean number of false measurements in each frame.
    min_match_ratio : float
        Landmarks that are found in less than this share of the searches are deleted.
    sensor : SensorModel
        As the filter has it.

    Yields
    ------
    now : Snapshot
        Of each frame; good until the next one is drawn.
    origin : dict
        Which true landmark started each one in the map.
    """
    association = association or KnownIds()
    opt = Options(lmk_type=EucPnt(2), association=association, min_match_ratio=min_match_ratio)
    streams, points, map, lmks, origin = Streams(SEED), room(), Map(), {}, {}
    rob = Rob(1, Odometry2(), U=U)
    sen = Sen(1, 1, sensor, Frame2, x=np.zeros(3))
    place(map, rob, START, np.zeros((3, 3)))
    truth = START
    for k in range(frames + 1):
        if k:
            truth = rob.motion.move(truth, STEP, 1.0)[0]
            rob.u = STEP + draw(streams_of(streams, k, "motion"), U)
            move(map, rob, 1.0)
        raw = scan(sensor, truth, points, streams_of(streams, k, "sensing"))
        if clutter:
            raw = with_clutter(raw, clutter, streams_of(streams, k, "clutter"))
        if k == swap_at:
            raw = swapped(raw, points)
        obs = {}
        events, new = correct_known_lmks(map, rob, sen, lmks, obs, raw, opt)
        for i in new:
            births = init_new_lmks(map, rob, sen, lmks, raw, [i], opt)
            origin |= {event.lmk: int(raw.ids[i]) for event in births}
            events += births
        yield snapshot(k, map, rob, sen, lmks, obs, raw, events, truth, points), origin


def replayed(title, **options):
    """State log of a run. The parameters are those of `frames`."""
    return film(title, (now for now, _ in frames(**options)))


def streams_of(streams, k, cause):
    """One stream for each cause of chance and each frame: the noise of a frame does not depend on the others."""
    return getattr(streams, cause)(k)


def scan(sensor, pose, points, rng):
    """Noisy measurements of the landmarks in range; `ids` are the true ones, 0, 1, ..."""
    p = Frame2(pose).to_frame(points)[0]
    y = sensor.project(p)[0]
    ids = np.flatnonzero(sensor.visible(y, p))
    return measured(ids, y[ids] + draw(rng, sensor.R, (len(points),))[ids])


def measured(ids, y):
    """Raw measurements, bearings between -pi and pi as a sensor gives them."""
    y = np.array(y, float).reshape(-1, 2)
    y[:, 1] = np.arctan2(np.sin(y[:, 1]), np.cos(y[:, 1]))
    return SimObs(1, np.asarray(ids, int), y)


def with_clutter(raw, rate, rng):
    """Add false measurements, evenly spread in range and bearing; their id is -1."""
    n = rng.poisson(rate)
    false = np.column_stack([rng.uniform(0.5, SENSOR.max_range, n), rng.uniform(-np.pi, np.pi, n)])
    return measured([*raw.ids, *[-1] * n], np.concatenate([raw.y, false]))


def swapped(raw, points):
    """Two measurements change their ids: those of the two landmarks in view that are nearest to each other."""
    p = points[raw.ids]
    d = np.linalg.norm(p[:, None] - p[None], axis=-1) + np.diag(np.full(len(p), np.inf))
    i, j = np.unravel_index(np.argmin(d), d.shape)
    y = raw.y.copy()
    y[[i, j]] = y[[j, i]]
    return SimObs(raw.sen, raw.ids, y)


def shape_error(frame):
    """Root mean square error of the map after the best shift and turn, m: what is wrong with its *shape*."""
    est = np.array([frame.x[r] for r in frame.ranges.values()])
    true = room()[[frame.origin[id] for id in frame.ranges]]
    moved = align(est, true).from_frame(est)[0]
    return float(np.sqrt(np.mean(np.sum((moved - true) ** 2, -1))))


# ---- one moment in a corridor ---------------------------------------------------------------------------------------

POSTS_STD, RANGE_STD, BEARING_STD = 0.05, 0.1, np.radians(1.0)


@dataclass(frozen=True)
class Scene:
    """A map, the expectations, and the measurements; measurement i belongs to landmark `true[i]`."""

    map: Map
    obs: list
    raw: SimObs
    sensor: RangeBearing
    true: list
    pose: np.ndarray


def corridor(slip=0.7, slip_std=0.4, n=4, spacing=1.0, missing=None):
    """A robot in a corridor with posts on both sides; its wheels have slipped.

    Parameters
    ----------
    slip : float
        Where the robot is, ahead of its estimate, m.
    slip_std : float
        How uncertain it is along the corridor, m.
    n : int
        Posts on each side.
    spacing : float
        Between posts, m.
    missing : list of int, optional
        Posts that are in the map and not seen.

    Returns
    -------
    Scene
    """
    sensor = RangeBearing(RANGE_STD, BEARING_STD)
    along = 3.0 + spacing * np.arange(n)
    points = np.array([(x, y) for x in along for y in (1.2, -1.2)])
    map, rng = Map(), np.random.default_rng(5)
    rob, sen = Rob(1, Odometry2()), Sen(1, 1, sensor, Frame2, x=np.zeros(3))
    place(map, rob, np.zeros(3), np.diag(np.square([slip_std, 0.1, np.radians(1)])))
    lmks = {}
    for id, p in enumerate(points):
        lmks[id] = Lmk(id, EucPnt(2), r=map.add(p + POSTS_STD * rng.standard_normal(2), POSTS_STD**2 * np.eye(2)))
    pose = np.array([slip, 0.0, 0.0])
    true = [i for i in range(len(points)) if i not in (missing or [])]
    y = sensor.project(Frame2(pose).to_frame(points[true])[0])[0] + draw(rng, sensor.R, (len(true),))
    return Scene(map, project_lmks(map, rob, sen, lmks.values()), measured([-1] * len(true), y), sensor, true, pose)


def judged(scene, association):
    """Pairs of an association as {measurement: landmark}, and how many of them are right."""
    pairs = {i: l for l, i in association(scene.map, scene.obs, scene.raw, scene.sensor).pairs.items()}
    return pairs, sum(scene.true[i] == l for i, l in pairs.items())


def map_nees(frame):
    """NEES of all landmarks together, divided by the number of their states: 1 for an honest map."""
    ids = list(frame.ranges)
    index = np.concatenate([np.arange(frame.ranges[i].start, frame.ranges[i].stop) for i in ids])
    e = frame.x[index] - room()[[frame.origin[i] for i in ids]].ravel()
    return float(e @ np.linalg.solve(frame.P[np.ix_(index, index)], e)) / len(index)
