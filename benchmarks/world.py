"""The workload: a robot drives a circle between landmarks, with noisy odometry, ranges and bearings.

`lap` starts with all N landmarks in the map and goes round as often as one likes: the grid.
`circuit` starts with an empty map and closes the loop after N steps: the circuit.
"""

from dataclasses import dataclass

import numpy as np

SPACING = 1.0  # one landmark per metre of the way
SIDE = 2.0  # they stand so far to the left and right of it, m
U = np.diag([0.02, 0.02, 0.005]) ** 2  # of a step [dx, dy, dtheta], m and rad
CALM = 50  # circuits of more landmarks than this are drawn with less noise
R = np.diag([0.1, 0.02]) ** 2  # of a measurement [range, bearing], m and rad


def wrap(a):
    """Angle in [-pi, pi)."""
    return (a + np.pi) % (2 * np.pi) - np.pi


@dataclass(frozen=True)
class Step:
    """What the robot gets in one step: control u (3,), ids (m,) and measurements y (m, 2); `pose` (3,) is the truth."""

    u: np.ndarray
    ids: np.ndarray
    y: np.ndarray
    pose: np.ndarray


@dataclass(frozen=True)
class World:
    """Landmarks (N, 2), steps, the start x0, P0 (of the robot alone, or with all landmarks), the sensor's reach."""

    lmks: np.ndarray
    m: int
    steps: list
    x0: np.ndarray
    P0: np.ndarray
    max_range: float

    @property
    def n_lmks(self):
        """N."""
        return len(self.lmks)


def lap(n_lmks, m, seed=1):
    """All landmarks are in the map; one round, to be driven again and again. m landmarks are seen in each step."""
    rng = np.random.default_rng(seed)
    lmks, poses, turn, radius = _scene(n_lmks, max(n_lmks, 20), rng)
    steps, reach = _drive(lmks, poses, turn, radius, m, rng)

    # A prior that could be the result of a run: everything shares the error of the common frame, and has its own.
    p = np.concatenate([poses[-1][None, :2], lmks])
    shared = np.zeros((3 + 2 * n_lmks, 3))
    at = np.r_[0:2, 3 : 3 + 2 * n_lmks].reshape(-1, 2)
    shared[at[:, 0], 0], shared[at[:, 1], 1] = 0.05, 0.05
    turned = 0.05 / radius  # rad: as far off on the other side of the circle
    shared[at[:, 0], 2], shared[at[:, 1], 2], shared[2, 2] = -p[:, 1] * turned, p[:, 0] * turned, turned
    own = np.full(len(shared), 0.05)
    own[2] = 0.01
    truth = np.concatenate([poses[-1], lmks.ravel()])
    x0 = truth + shared @ rng.normal(size=3) + own * rng.normal(size=len(own))
    return World(lmks, m, steps, x0, shared @ shared.T + np.diag(own**2), reach)


def circuit(n_lmks, m=10, rounds=1.1, seed=1):
    """An empty map; a robot at the origin looks round, then drives 1.1 rounds, so the loop is closed.

    The noise that is drawn is smaller than the one that filters assume, the longer the way the more: a robot that
    comes back is off by a metre or so, and sees its first landmarks about where it expects them. With the whole noise
    an EKF is off by 19 m for N = 300 and misses the loop: it would have less work than the others.
    """
    rng = np.random.default_rng(seed)
    lmks, poses, turn, radius = _scene(n_lmks, n_lmks, rng)
    m, n_steps = min(m, n_lmks), int(np.ceil(rounds * n_lmks))
    calm = min(1.0, CALM / n_lmks)
    first, reach0 = _look(lmks, np.zeros(3), np.zeros(3), m, rng, calm)
    steps, reach = _drive(lmks, poses, turn, radius, m, rng, calm)
    steps = [first, *(steps * (n_steps // n_lmks + 1))[: n_steps - 1]]
    return World(lmks, m, steps, np.zeros(3), 1e-8 * np.eye(3), max(reach, reach0))


def _scene(n_lmks, n_steps, rng):
    """Landmarks left and right of a circle that starts at the origin, along x; the poses after each step."""
    radius = max(4.0, n_lmks * SPACING / (2 * np.pi))
    a = 2 * np.pi * (np.arange(n_lmks) + 0.5) / n_lmks
    r = radius + SIDE * np.where(np.arange(n_lmks) % 2, 1, -1) * rng.uniform(0.75, 1.25, n_lmks)
    lmks = np.stack([r * np.sin(a), radius - r * np.cos(a)], -1)
    turn = 2 * np.pi / n_steps
    b = turn * np.arange(1, n_steps + 1)
    poses = np.stack([radius * np.sin(b), radius * (1 - np.cos(b)), wrap(b)], -1)
    return lmks, poses, turn, radius


def _drive(lmks, poses, turn, radius, m, rng, calm=1.0):
    """The steps of one round, and the reach that a sensor needs for them."""
    u, std = np.array([radius * np.sin(turn), radius * (1 - np.cos(turn)), turn]), calm * np.sqrt(np.diag(U))
    seen = [_look(lmks, pose, u + std * rng.normal(size=3), m, rng, calm) for pose in poses]
    steps, reach = zip(*seen, strict=True)
    return list(steps), max(reach)


def _look(lmks, pose, u, m, rng, calm=1.0):
    """One step: the m landmarks nearest to the pose are measured. Also the reach that a sensor needs for them."""
    d = lmks - pose[:2]
    r = np.hypot(*d.T)
    ids = np.sort(np.argsort(r)[:m])
    y = np.stack([r[ids], np.arctan2(d[ids, 1], d[ids, 0]) - pose[2]], -1)
    y += calm * np.sqrt(np.diag(R)) * rng.normal(size=(m, 2))
    y[:, 1] = wrap(y[:, 1])
    return Step(u, ids, y, pose), r[ids].max() + 0.5  # estimates are a little off: what is measured should be in reach
