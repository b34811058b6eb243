"""What the drawings of notebook 15 compute: a shared landmark, a rumour, a meeting."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import block_diag

from ...analysis.consistency import md2
from ...geometry import Frame2, numerical_jacobian
from ...models.landmarks import EucPnt
from ...models.observation import observe, retro_project
from ...models.sensors import RangeBearing
from .. import fleet
from ..exercises.nb04_blocks import new_blocks
from ..exercises.nb04_moved import moved
from ..exercises.nb15_blocks import correct_blocks
from ..exercises.nb15_fuse import best_weight
from ..exercises.nb15_meet import map_in_map

# ---- one map, one landmark ------------------------------------------------------------------------------------------

ROBOTS = np.array([[-4.0, -1.0, 0.35], [4.0, -1.0, 2.8]])  # true poses
POINTS = np.array([[0.0, 1.5], [6.5, 1.5]])  # the landmark of robot 1, and one that only robot 2 sees
ONE, TWO = slice(0, 3), slice(3, 6)
STEPS = ("start", "robot 1 sees the landmark", "robot 2 sees a landmark", "robot 1 gets its place from a GPS")


def shared(step, same=True, std=1.0, seed=0):
    """Two robots in one map after some of the steps of `STEPS`; landmarks are x[6:8], and x[8:10] if not the same.

    Parameters
    ----------
    step : int
    same : bool
        Robot 2 sees the landmark of robot 1, and not another one.
    std : float
        Standard deviation of the robots' positions at the start, m.
    seed : int

    Returns
    -------
    x, P : ndarray
        Robots first: [x, y, theta] each.
    """
    rng = np.random.default_rng([15, seed])
    sensor = RangeBearing(0.1, np.radians(1))
    P = np.kron(np.eye(2), np.diag([std, std, np.radians(5)]) ** 2)
    x = ROBOTS.ravel() + np.sqrt(np.diag(P)) * rng.standard_normal(6)
    noise, at, seen = rng.standard_normal((3, 2)), Frame2(np.zeros(3)), {}
    for k, r in enumerate((ONE, TWO)[: min(step, 2)]):
        which = 0 if same else k
        y = sensor.project(Frame2(ROBOTS[k]).to_frame(POINTS[which])[0])[0] + noise[k] @ np.sqrt(sensor.R)
        if which in seen:
            l = seen[which]
            e, E_r, _, E_l = observe(Frame2(x[r]), at, sensor, EucPnt(2), x[l])
            x, P = correct_blocks(x, P, [(r, E_r), (l, E_l)], sensor.residual(y, e), sensor.R)
        else:
            new, L_r, _, L_y, _ = retro_project(Frame2(x[r]), at, sensor, EucPnt(2), y, np.zeros(0))
            P_lx, seen[which] = L_r @ P[r], slice(len(x), len(x) + 2)
            P = np.block([[P, P_lx.T], [P_lx, L_r @ P[r, r] @ L_r.T + L_y @ sensor.R @ L_y.T]])
            x = np.append(x, new)
    if step == 3:
        R = 0.05**2 * np.eye(2)
        z = ROBOTS[0, :2] + 0.05 * noise[2] - x[:2]
        x, P = correct_blocks(x, P, [(ONE, np.eye(3)[:2])], z, R)
    return x, P


# ---- a rumour -------------------------------------------------------------------------------------------------------

METHODS = (
    "one joint filter",
    "each alone",
    "average of both",
    "exchange, as if independent",
    "covariance intersection",
)


@dataclass
class Rumour:
    """Two trackers of one thing: errors of the answer in each run and frame, and the covariance claimed."""

    error: np.ndarray  # (frames, runs, 2)
    P: np.ndarray  # (frames, 2, 2)

    @property
    def nees(self):
        """NEES, shape (frames, runs), 2 degrees of freedom."""
        return md2(self.error, self.P[:, None])


def add_information(xa, Pa, xb, Pb):
    """Fuse as if the two estimates were independent; xa and xb may be (runs, 2)."""
    Ia, Ib = np.linalg.inv(Pa), np.linalg.inv(Pb)
    P = np.linalg.inv(Ia + Ib)
    return xa @ (P @ Ia).T + xb @ (P @ Ib).T, P


def _ci(xa, Pa, xb, Pb):
    """Covariance intersection of all runs at once: w depends on the covariances only."""
    P, w = best_weight(Pa, Pb)
    return xa @ (w * P @ np.linalg.inv(Pa)).T + xb @ ((1 - w) * P @ np.linalg.inv(Pb)).T, P


@cache
def rumour(method, every=1, walk=0.05, frames=30, runs=200, seed=0):
    """Two sensors, two filters, one thing that walks at random. All is linear: an honest filter is exactly honest.

    Sensor a is good in y and bad in x, sensor b the other way round. Both filters begin with the same estimate, and
    both know how fast the thing walks.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    every : int
        Frames between two exchanges.
    walk : float
        Standard deviation of a step, m.
    frames, runs, seed : int
    """
    streams = [np.random.default_rng(s) for s in np.random.SeedSequence([15, seed]).spawn(4)]
    draw = lambda i, std: streams[i].standard_normal((runs, 2)) * std
    Ra, Rb = np.diag([1.0, 0.2]) ** 2, np.diag([0.2, 1.0]) ** 2
    truth = np.zeros((runs, 2))
    x = draw(3, 1.0)
    estimates = [(x, np.eye(2)), (x, np.eye(2))]
    errors, claims = [], []
    fuse = {METHODS[3]: add_information, METHODS[4]: _ci}.get(method)
    for k in range(1, frames + 1):
        truth = truth + draw(0, walk)
        y = truth + draw(1, np.sqrt(np.diag(Ra))), truth + draw(2, np.sqrt(np.diag(Rb)))
        estimates = [(x, P + walk**2 * np.eye(2)) for x, P in estimates]
        a, b = (add_information(*e, y_i, R) for e, y_i, R in zip(estimates, y, (Ra, Rb), strict=True))
        if method == METHODS[0]:
            a = b = add_information(*a, y[1], Rb)
        elif fuse and k % every == 0:
            a = b = fuse(*a, *b)
        answer = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 4) if method == METHODS[2] else a
        estimates = [a, b]
        errors.append(answer[0] - truth)
        claims.append(answer[1])
    return Rumour(np.array(errors), np.array(claims))


# ---- a meeting ------------------------------------------------------------------------------------------------------

STARTS = np.array([[-6.0, 0.0, -np.pi / 2], [6.0, 0.0, np.pi / 2]])  # in the world, which is map 1 but for its origin
RADIUS, FRAMES = 3.0, 38  # less than half a round: they meet in the middle, some metres apart


def _landmarks():
    rng = np.random.default_rng(3)
    a = np.linspace(0, 2 * np.pi, 11)[:-1]
    rings = [c + r * np.array([np.cos(t), np.sin(t)]) for c in ([-3, 0], [3, 0]) for t, r in
             zip(a, 3 + rng.choice([-1.3, 1.3], 10), strict=True)]  # fmt: skip
    return np.array(rings)


LANDMARKS = _landmarks()


@cache
def own_map(robot, seed=0):
    """A robot's own map, from its own start: (x, P, ids of the landmarks in their order); the pose is x[:3]."""
    start = Frame2(STARTS[robot])
    points = start.to_frame(LANDMARKS)[0]
    step = np.array([0.2, 0.0, 0.2 / RADIUS])
    U = np.diag(np.square([0.02, 0.005, np.radians(0.5)]))
    s = fleet.Scenario(points, np.zeros(3), step, U, RangeBearing(0.1, np.radians(1), 4.0), FRAMES)
    result = fleet.run(s, {"moved": moved, "new_blocks": new_blocks}, 1, 100 * seed + robot, keep=(FRAMES,))
    x, P = result.states[FRAMES]
    return x, P, list(result.ranges), result.truth[-1]


def meeting(seed=0, bearing_std=1.0, range_std=0.1):
    """What the robots measure of each other at the end: y = [r, b12, b21] and its covariance R. Angles in degrees."""
    (F1, F2) = (Frame2(STARTS[i]).compose(Frame2(own_map(i, seed)[3]))[0] for i in range(2))
    seen, back = F1.to_frame(F2.t)[0], F2.to_frame(F1.t)[0]
    y = np.array([np.hypot(*seen), np.arctan2(*seen[::-1]), np.arctan2(*back[::-1])])
    std = np.array([range_std, *np.radians([bearing_std, bearing_std])])
    return y + std * np.random.default_rng([16, seed]).standard_normal(3), np.diag(std**2)


def join(x1, P1, x2, P2, y, R):
    """Two maps [pose, landmarks] become one by a meeting. Returns x and P of map 1, then of map 2 in the frame of 1."""
    n1, n2 = len(x1), len(x2)

    def g(v):
        """Both maps, in the frame of map 1, as a function of both maps and the meeting."""
        a, b, y = np.split(v, [n1, n1 + n2])
        M = Frame2(np.asarray(map_in_map(Frame2(a[:3]), Frame2(b[:3]), y)))
        return np.concatenate([a, M.compose(Frame2(b[:3]))[0].x, M.from_frame(b[3:].reshape(-1, 2))[0].ravel()])

    v = np.concatenate([x1, x2, y])
    J = numerical_jacobian(g, v)
    return g(v), J @ np.asarray(block_diag(P1, P2, R)) @ J.T


def same_landmarks(x, P, n1, ids1, ids2, std=1e-3):
    """Landmarks that are in both maps are one: correct with the measurement that their difference is zero."""
    common = [(ids1.index(i), ids2.index(i)) for i in ids1 if i in ids2]
    for i, j in common:
        a, b = slice(3 + 2 * i, 5 + 2 * i), slice(n1 + 3 + 2 * j, n1 + 5 + 2 * j)
        x, P = correct_blocks(x, P, [(a, np.eye(2)), (b, -np.eye(2))], x[b] - x[a], std**2 * np.eye(2))
    return x, P, len(common)


def joined(seed=0, bearing_std=1.0, stage=2):
    """Both maps in the frame of map 1 after 0: nothing (map 2 laid down as it is), 1: the meeting, 2: common landmarks.

    Returns
    -------
    x, P : ndarray
    n1 : int
        Length of map 1.
    ids : tuple of two lists
    truth : ndarray
        What x should be.
    common : int
        Landmarks in both maps.
    """
    (x1, P1, ids1, t1), (x2, P2, ids2, t2) = own_map(0, seed), own_map(1, seed)
    S1 = Frame2(STARTS[0])
    world = [Frame2(STARTS[i]).compose(Frame2(t))[0].x for i, t in enumerate((t1, t2))]
    back = S1.inverse()[0]
    poses = [back.compose(Frame2(w))[0].x for w in world]
    points = S1.to_frame(LANDMARKS)[0]
    truth = np.concatenate([poses[0], points[ids1].ravel(), poses[1], points[ids2].ravel()])
    n1, common = len(x1), len(set(ids1) & set(ids2))
    if stage == 0:
        return np.append(x1, x2), np.asarray(block_diag(P1, P2)), n1, (ids1, ids2), truth, common
    x, P = join(x1, P1, x2, P2, *meeting(seed, bearing_std))
    if stage == 2:
        x, P, _ = same_landmarks(x, P, n1, ids1, ids2)
    return x, P, n1, (ids1, ids2), truth, common
