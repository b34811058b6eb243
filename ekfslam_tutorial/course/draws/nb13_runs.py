"""What the widgets of notebook 13 compute: one depth from small parallax, landmarks born in one picture."""

import numpy as np

from ...ekf import Map, augment
from ...geometry import Frame3, e2q
from ...models.landmarks import IdpPnt
from ...models.observation import retro_project
from ...models.sensors import PinHole
from ..exercises.nb13_depth import correct_rho

NEAR, FAR = 2.0, 100.0  # depths of the population, m
FRAMES = 20  # of a camera that moves to the side
RHO, RHO_STD = 1 / (2 * NEAR), 1 / (4 * NEAR)  # prior: rho = 0 and rho = 1 / NEAR are both at 2 sigma
DEPTH, DEPTH_STD = (NEAR + FAR) / 2, (FAR - NEAR) / 4  # prior: NEAR and FAR are both at 2 sigma
FORWARD = np.concatenate([np.zeros(3), e2q(np.array([-np.pi / 2, 0, -np.pi / 2]))[0]])  # a camera that looks along x


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
