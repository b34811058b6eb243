"""The filters of notebook 13: one depth from small parallax, landmarks born in one picture, a run in the cloister."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ...ekf import Map, augment
from ...geometry import Frame3, e2q
from ...models.landmarks import IdpPnt
from ...models.observation import retro_project
from ...models.sensors import PinHole
from ...toolbox import UserData, universal_slam
from ..exercises.nb13_depth import correct_rho

NEAR, FAR = 2.0, 100.0  # depths of the population, m
STEP, FRAMES = 0.05, 20  # the camera moves to the side, m and number of frames
VAR = np.radians(0.1) ** 2  # of an angle, rad^2
RHO, RHO_STD = 1 / (2 * NEAR), 1 / (4 * NEAR)  # prior: rho = 0 and rho = 1 / NEAR are both at 2 sigma
DEPTH, DEPTH_STD = (NEAR + FAR) / 2, (FAR - NEAR) / 4  # prior: NEAR and FAR are both at 2 sigma
FORWARD = np.concatenate([np.zeros(3), e2q(np.array([-np.pi / 2, 0, -np.pi / 2]))[0]])  # a camera that looks along x


def sights(n=20000, seed=1, step=STEP, frames=FRAMES, var=VAR):
    """Points between 2 and 100 m, each decade alike, and the angles under which they are seen.

    Returns
    -------
    d : ndarray, shape (n,)
        True depths, m.
    b : ndarray, shape (frames,)
        Where the camera is, m to the side of its start.
    y : ndarray, shape (frames, n)
        Measured angles, rad.
    """
    rng = [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2)]
    d, b = np.exp(rng[0].uniform(np.log(NEAR), np.log(FAR), n)), step * np.arange(1, frames + 1)
    return d, b, np.arctan2(b[:, None], d) + np.sqrt(var) * rng[1].standard_normal((frames, n))


def correct_depth(x, P, b, y, var):
    """One EKF correction of a depth: as `correct_rho`, with the state d instead of 1 / d."""
    H = -b / (x**2 + b**2)
    K = P * H / (H * P * H + var)
    return x + K * (y - np.arctan2(b, x)), (1 - K * H) * P


def one_point(d, step, frames, std, seed=0):
    """Both filters on one point, and the exact posterior.

    Returns
    -------
    depth, rho : tuple of (mean, variance)
    grid, log_density : ndarray
        Depths, and the exact log density of the logarithm of the depth, for depths that are alike in each decade.
    """
    rng, b = np.random.default_rng([13, seed]), step * np.arange(1, frames + 1)
    y = np.arctan2(b, d) + std * rng.standard_normal(frames)
    rho, x = (np.array([RHO]), np.array([RHO_STD**2])), (np.array([DEPTH]), np.array([DEPTH_STD**2]))
    for b_k, y_k in zip(b, y, strict=True):
        rho, x = correct_rho(*rho, b_k, y_k, std**2), correct_depth(*x, b_k, y_k, std**2)
    grid = np.geomspace(0.5, 1000, 1200)
    like = -((y[:, None] - np.arctan2(b[:, None], grid)) ** 2).sum(0) / (2 * std**2)
    like[(grid < NEAR) | (grid > FAR)] = -np.inf
    return tuple(float(v[0]) for v in x), tuple(float(v[0]) for v in rho), grid, like


def births(count, moved):
    """A map with one uncertain camera and `count` landmarks from its first picture, or from pictures on its way.

    Parameters
    ----------
    count : int
    moved : float
        Metres that the camera drives between two births, with new errors of its own.

    Returns
    -------
    Map, list of slice
        The last three ranges: 7 numbers of the camera first, then 6 of each landmark.
    """
    map, camera, rng = Map(), PinHole(), np.random.default_rng(14)
    pose = np.diag([0.1, 0.1, 0.1, 0, 0, 0, 0]) ** 2
    angle = np.diag([0.0, 0, 0, 0, 1, 1, 1]) * np.radians(1) ** 2 / 4
    r = map.add([0, 0, 0, 1, 0, 0, 0], pose + angle)
    ranges = [r]
    for _ in range(count):
        y, F = rng.uniform([100, 100], [540, 380]), Frame3(map.x[r])
        l, L_r, _, L_y, L_n = retro_project(F, Frame3(FORWARD), camera, IdpPnt(), y, np.array([RHO]))
        ranges.append(augment(map, l, [(r, L_r)], L_y @ camera.R @ L_y.T + L_n @ L_n.T * RHO_STD**2))
        map.x[r.start] += moved
        map.P[:3, :3] += np.eye(3) * (0.1 * moved) ** 2
    return map, ranges


@dataclass(frozen=True)
class Drive:
    """A run in the cloister: per frame, how many landmarks have six numbers and how many three; and its end."""

    six: np.ndarray
    three: np.ndarray
    used: int
    rejected: int
    errors: np.ndarray  # of the landmarks, m
    states: int
    robot: float  # position error, m


SCENARIO = {
    "name": "cloister",
    "time": {"dt": 0.1, "last": 60},
    "world": {"type": "cloister"},
    "robot": [
        {
            "motion": "odometry3",
            "position": [0.0, -5.0, 0.0],
            "dx": [0.08, 0.0, 0.0],
            "da_deg": [0.0, 0.0, 0.9],
            "dx_std": 0.005,
            "da_std_deg": 0.05,
        }
    ],
    "sensor": [{"type": "pin_hole", "position": [0, 0, 0.6], "orientation_deg": [-90, 0, -90], "pixel_std": 1.0}],
    "landmark": {"type": "idp_pnt", "non_obs_mean": 0.01, "non_obs_std": 0.5},
    "options": {
        "n_inits": [10, 1],
        "init_margin": 25.6,
        "n_updates": 10,
        "md2_threshold": 9.0,
        "reparametrize": True,
    },
}


@cache
def drive(seed=1, **changes):
    """One camera in the cloister, inverse-depth landmarks. `changes` are keys such as `lin_test`, of the options."""
    data = UserData.from_dict(SCENARIO, {f"options.{key}": value for key, value in changes.items()})
    six, three, used, matched, now = [], [], 0, 0, None
    for now in universal_slam(data, seed=seed):
        sizes = [lmk.type.size for lmk in now.lmks.values()]
        six.append(sizes.count(6))
        three.append(sizes.count(3))
        used += sum(o.updated for o in now.obs.values())
        matched += sum(o.matched for o in now.obs.values())
    assert now is not None
    true = dict(zip(now.sim_lmk.ids.tolist(), now.sim_lmk.points, strict=True))
    errors = np.array([np.linalg.norm(lmk.point(now.map)[0] - true[id]) for id, lmk in now.lmks.items()])
    rob = now.robs[0]
    off = float(np.linalg.norm(rob.frame(now.map).t - now.truth[rob.id][:3]))
    return Drive(np.array(six), np.array(three), used, matched - used, errors, now.map.n_used, off)
