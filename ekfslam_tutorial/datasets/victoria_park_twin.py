"""A simulated twin of Victoria Park: the same log with the same troubles, but true way and true trees are known.

For those who do not have the real log, and for tests. A truck that slips drives rounds among trees that are not known
apart; some are hidden by others, some detections are none. Odometry and laser are off by what the real ones are off by,
so the same calibration puts them right. GPS wanders, jumps and has gaps.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..geometry import Frame2, wrap
from ..models.motion import Vehicle
from ..models.sensors.range_bearing import polar
from ..simulation import Streams
from .trees import NOTHING, TreeDetector
from .victoria_park import CALIBRATION, NOISE, ParkLog, recording
from .victoria_park_raw import ANGLES, OWN_CALIBRATION

TICK = 0.1  # s, of the simulation; the odometry has four rows in each
LOOK = 2  # ticks between two scans
START = np.array([-68.3, -40.6, np.radians(36.6)])  # that of the scenario
ROUTE = np.array([[0, 0], [38, 28], [62, 24], [58, 0], [24, -4], [2, -22], [-24, -20], [-26, -2]])  # m, from the start
EDGE, CLEAR, APART = 40.0, 3.0, 4.0  # m: trees to so far from the route, none so near to it, none so near to each other
N_TREES, FARTHEST = 130, 45.0  # m
DETECTED, CLUTTER = 0.6, 0.5  # probability to detect a tree in view; mean number of false detections in a scan
RANGE_STD, BEARING_STD = 0.06, np.radians(0.3)
BARK_STD = 0.03  # m, of a single beam
SLIP_STD, SPEED_STD, STEER_STD = np.radians(2.0), 0.1, np.radians(0.5)  # of the true motion, anew at each tick
STEER_WANDER, STEER_MEMORY = np.radians(1.0), 20.0  # a slow error of the steering, s that it lasts
GPS_STD, GPS_WANDER, GPS_MEMORY = 0.1, 0.8, 60.0  # m white, m of a slow error, s that it lasts


@dataclass(frozen=True)
class Park:
    """The true world of a twin.

    Parameters
    ----------
    trees : ndarray, shape (N, 3)
        x, y, diameter, m.
    poses : ndarray, shape (F, 3)
        Of the laser at the scans.
    """

    trees: np.ndarray
    poses: np.ndarray


def load(seed=1, duration=240.0, raw=False, noise=NOISE):
    """The twin as a recording, with the true poses. True trees have no ids that a filter could know: see `simulate`.

    Parameters
    ----------
    seed : int
        Of everything random.
    duration : float
        Length of the log, s; a round takes 80 s.
    raw : bool
        Take the trees that our detector finds in simulated scans, not simulated detections.
    noise : ParkNoise
        As for `victoria_park.load`.

    Returns
    -------
    Recording
    """
    log, park = simulate(seed, duration)
    if raw:
        offsets, trees = TreeDetector()(scans(park, seed), ANGLES)
        log = replace(log, offsets=offsets, detections=trees)
    rec = recording(log, OWN_CALIBRATION if raw else CALIBRATION, noise)
    rec.name, rec.truth = "twin of Victoria Park", {1: park.poses}
    rec.notes.insert(0, f"simulated twin of Victoria Park, seed {seed}: no real truck was here")
    return rec


def simulate(seed=1, duration=240.0):
    """The log of the truck, as its publisher's files have it, and the truth.

    Parameters
    ----------
    seed : int
    duration : float
        s.

    Returns
    -------
    log : ParkLog
    park : Park
    """
    if not duration > 10:
        raise ValueError(f"the twin needs more than 10 s to get under way, got {duration} s")
    streams = Streams(seed)
    trees = plant(streams.world)
    n = round(duration / TICK)
    commands, poses = _drive(streams.motion(1), n)
    scans = np.arange(LOOK, n, LOOK)
    off = CALIBRATION
    sensing, clutter = streams.sensing(1), streams.clutter(1)
    rows = [_look(poses[k], trees, sensing, clutter) for k in scans]
    detections = np.concatenate(rows)
    detections[:, 0] -= off.per_diameter * detections[:, 2]
    detections[:, 1] -= off.bearing
    t = np.arange(n) * TICK
    logged = np.column_stack([commands[:, 0], (commands[:, 1] - off.steer_offset) / off.steer_scale])
    odometry = np.column_stack([np.arange(4 * n) * TICK / 4 - off.delay, np.repeat(logged, 4, axis=0)])
    offsets = np.cumsum([0, *map(len, rows)])
    log = ParkLog(odometry, _fixes(t, poses, clutter), t[scans], offsets, detections)
    return log, Park(trees, poses[scans])


def scans(park, seed=1):
    """Raw scans (F, 361) of the true park by a laser that looks as much to the side as the real one: ranges, m."""
    rng, nothing = Streams(seed).sensing(2), NOTHING + 1.9
    ranges = np.full((len(park.poses), len(ANGLES)), nothing)
    for row, pose in zip(ranges, park.poses, strict=True):
        d, b = np.transpose(polar(Frame2(pose).to_frame(park.trees[:, :2])[0])[0])
        near = np.flatnonzero(d < FARTHEST)
        off = wrap(ANGLES[None] + CALIBRATION.bearing - b[near, None])  # (trees, beams)
        aside, radius = d[near, None] * np.sin(off), park.trees[near, 2:] / 2
        hits = (np.abs(aside) < radius) & (np.abs(off) < np.pi / 2)
        bark = d[near, None] * np.cos(off) - np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
        row[:] = np.where(hits, bark, nothing).min(0, initial=nothing)
        row[row < nothing] += BARK_STD * rng.normal(size=np.count_nonzero(row < nothing))
    return np.round(ranges, 2)


def plant(rng):
    """Trees (N, 3) around the route: position and diameter, m."""
    way = _round()
    low, high = way.min(0) - EDGE, way.max(0) + EDGE
    trees = np.zeros((0, 3))
    while len(trees) < N_TREES:
        p = rng.uniform(low, high)
        near_way, near_tree = (np.linalg.norm(a - p, axis=1).min(initial=np.inf) for a in (way, trees[:, :2]))
        if CLEAR < near_way < EDGE and near_tree > APART:
            trees = np.vstack([trees, [*p, rng.uniform(0.2, 0.9)]])
    return trees


def _round():
    """Points on the route, a metre apart."""
    corners = START[:2] + np.vstack([ROUTE, ROUTE[:1]])
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    s = np.arange(0, lengths.sum(), 1.0)
    return np.column_stack([np.interp(s, np.cumsum([0, *lengths]), c) for c in corners.T])


def _drive(rng, n):
    """Commands [v, steer] (n, 2), which hold for a tick each, and poses (n, 3) of the laser at their beginnings."""
    car, way, at = Vehicle(), _round(), 0
    bent = _wander(rng, n, STEER_WANDER, TICK / STEER_MEMORY)
    commands, poses, x = np.zeros((n, 2)), np.zeros((n, 3)), START
    for k in range(n):
        poses[k] = x
        while np.linalg.norm(way[at % len(way)] - x[:2]) < 8.0:  # it steers towards a point 8 m ahead on its way
            at += 1
        goal = Frame2(x).to_frame(way[at % len(way)])[0]
        steer = np.clip(np.arctan2(goal[1], goal[0] + car.ahead), -0.55, 0.55)
        stands = k * TICK < 3 or 60 < k * TICK < 64
        commands[k] = (0.0, 0.0) if stands else (3.5 - 3 * abs(steer), steer)
        if not stands:
            noise = [SPEED_STD, STEER_STD, SLIP_STD] * rng.normal(size=3)
            x = car.move(x, [*commands[k], 0.0] + noise + [0.0, bent[k], 0.0], TICK)[0]
    poses[:, 2] = wrap(poses[:, 2])
    return commands, poses


def _look(pose, trees, rng, clutter):
    """Detections [range, bearing, diameter] of one scan: trees in view that no nearer tree hides, and false ones."""
    y = polar(Frame2(pose).to_frame(trees[:, :2])[0])[0]
    half = np.arctan2(trees[:, 2] / 2, y[:, 0])
    beside = np.abs(wrap(y[:, None, 1] - y[None, :, 1]))
    hidden = ((beside < half[None, :]) & (y[None, :, 0] < y[:, None, 0])).any(axis=1)
    seen = (y[:, 0] < FARTHEST) & (np.abs(y[:, 1]) < np.radians(88)) & ~hidden & (rng.random(len(y)) < DETECTED)
    found = np.column_stack([y + rng.normal(size=y.shape) * [RANGE_STD, BEARING_STD], trees[:, 2]])[seen]
    n = clutter.poisson(CLUTTER)
    wrong = clutter.uniform([4, np.radians(-88), 0.1], [50, np.radians(88), 1.5], (n, 3))
    return np.concatenate([found, wrong])


def _fixes(t, poses, rng):
    """GPS (g, 3), two ticks apart: a slow error (Gauss-Markov), a white one, jumps, and three gaps."""
    k = np.arange(0, len(t), 2)
    slow = np.column_stack([_wander(rng, len(k), GPS_WANDER, 2 * TICK / GPS_MEMORY) for _ in "xy"])
    p = poses[k, :2] + slow + GPS_STD * rng.normal(size=(len(k), 2))
    p += (rng.random(len(k)) < 0.01)[:, None] * rng.uniform(-30, 30, (len(k), 2))
    seen = np.ones(len(k), bool)
    for start in rng.uniform(0.1, 0.9, 3) * t[-1]:
        seen &= (t[k] < start) | (t[k] > start + 8)
    return np.column_stack([t[k], p])[seen]


def _wander(rng, n, std, share):
    """A slow error (n,), a Gauss-Markov process: each step forgets this share of it."""
    keep, wander = np.exp(-share), np.zeros(n)
    steps = std * rng.normal(size=n)
    wander[0] = steps[0]
    for k in range(1, n):
        wander[k] = keep * wander[k - 1] + np.sqrt(1 - keep**2) * steps[k]
    return wander
