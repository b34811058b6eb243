"""Plaza: a mower on a lawn that hears four radio beacons, which tell it their range and nothing else.

The files `Plaza1_.mat` and `Plaza2_.mat` (J. Djugash, B. Hamner, S. Roth, "Navigating with ranging radios: five data
sets with ground truth", J. Field Robotics 26(9), 2009), as they also come with the Python package `gtsam`: increments
of the odometry, ranges, the true path by GPS, and where the beacons are.
"""

import numpy as np

from ..geometry import wrap
from ..models.motion import Odometry2
from ..simulation import SimLmk
from ..toolbox.recordings import ControlLog, RawLog, Recording
from .matlab import read_mat
from .odometry import OdometryNoise, steps
from .sources import get_file

FILES = {n: f"Plaza{n}_.mat" for n in (1, 2)}
SHA256 = {
    "Plaza1_.mat": "9ccbfec19942eabecfa3206bff983bf708b98d6c7db462d81c55376f92d75847",
    "Plaza2_.mat": "72f0abe0fea2050eb5ee1cffc8c43823266a35785b7cdecac4ec5eae727561a2",
}
WHEEL = "gtsam==4.3.0"
HOME = f"the wheel of a Python package, which has both files among its own: pip download --no-deps {WHEEL}"
COLUMNS = {"DR": 3, "TD": 4, "GT": 4, "TL": 3}
"""Array -> its columns: odometry t, ds, dtheta; ranges t, robot, beacon, range; true path t, x, y, theta; beacons."""

NOISE = OdometryNoise(along=0.05, across=0.04, turn=0.015, drift=0.005)
"""Of the odometry: wheels on grass, and a gyroscope whose zero wanders. Near the largest likelihood of the ranges of
set 1, which would have turns and drift half as large; errors of both sets were in view when this was chosen."""

STILL = 0.05
"""Slower than this the mower stands, m/s: what the gyroscope tells then is its zero."""

STEADY = 0.05
"""And as long as it turns more slowly than this, rad/s, it does not turn on the spot."""


def load(set=2, path=None, noise=NOISE):
    """A set as a recording of robot 1 and its radio, sensor 1.

    Parameters
    ----------
    set : int
        1 or 2.
    path : str or Path, optional
        The file, or a folder with it; without it, below the folders of `EKFSLAM_DATA`.
    noise : OdometryNoise

    Returns
    -------
    Recording
        A frame for each instant with a range; controls are those of `models.Odometry2`. Beacons have the ids of the
        file.

    Raises
    ------
    FileNotFoundError, ValueError
        Naming the file.
    """
    if set not in FILES:
        raise ValueError(f"set: Plaza has the sets 1 and 2, got {set}")
    file = get_file(f"Plaza {set}", FILES[set], path)
    m = _read(file)
    odometry, ranges, truth = m["DR"], m["TD"][np.argsort(m["TD"][:, 0], kind="stable")], m["GT"]
    times, first = np.unique(ranges[:, 0], return_index=True)
    if len(times) < 2 or len(odometry) < 2:
        raise ValueError(f"{file}: a run needs two ranges and two rows of odometry")

    zero, notes = _zero_of_gyroscope(odometry)
    t = odometry[:, 0]
    if not (np.diff(t) > 0).all():
        raise ValueError(f"{file}: the times of its odometry do not rise")
    dt = np.diff(t, prepend=t[0] - np.median(np.diff(t)))
    knots = np.append(t[0] - dt[0], t)  # row k of the odometry goes from instant k-1 to k
    speed, turn = np.append(odometry[:, 1] / dt, 0.0), np.append(odometry[:, 2] / dt - zero, 0.0)
    stands = (speed < STILL) & (abs(turn) < STEADY)  # then nothing has moved, whatever encoders and gyroscope tell
    speed[stands], turn[stands] = 0.0, 0.0
    u, U = steps(knots, speed, turn, times, noise)

    raw = RawLog(1, np.append(first, len(ranges)), ranges[:, 2].astype(int), ranges[:, 3:])
    beacons = SimLmk(m["TL"][:, 0].astype(int), m["TL"][:, 1:])
    log = {1: ControlLog(u, U)}
    return Recording(f"Plaza {set}", times - times[0], log, {1: raw}, {1: _true(truth, times)}, beacons, notes)


def twin(seed=1, n=700):
    """A simulated log of the same form, for those who do not have the file: white noise, beacons with a scale.

    Parameters
    ----------
    seed : int
        Of everything random.
    n : int
        Number of frames, four a second, each with one range.

    Returns
    -------
    Recording
    """
    rng, dt = np.random.default_rng(seed), 0.22
    beacons = np.array([[-35.0, 8.0], [-4.0, 59.0], [0.0, 17.0], [35.0, -16.0]])
    rates, q = _lanes(n, dt), np.array([NOISE.along, NOISE.across, NOISE.drift])
    truth, u, U = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3, 3))
    for k in range(1, n):
        v, w = rates[k]
        step = np.array([v * dt, 0.0, w * dt])
        truth[k] = Odometry2().move(truth[k - 1], step, dt)[0]
        U[k] = np.diag(q**2 * [v * dt, v * dt, dt]) + 1e-10 * np.eye(3)
        u[k] = step + rng.normal(0, np.sqrt(np.diag(U[k])))
    truth[:, 2] = wrap(truth[:, 2])
    heard = rng.integers(0, len(beacons), n)
    r = np.linalg.norm(beacons[heard] - truth[:, :2], axis=1)
    y = (1.07 * r + rng.normal(0, 0.6, n))[:, None]
    raw = RawLog(1, np.arange(n + 1), heard + 1, np.maximum(y, 0.1))
    notes = [f"simulated twin of Plaza, seed {seed}: no real robot was here"]
    landmarks = SimLmk(np.arange(1, len(beacons) + 1), beacons)
    return Recording("twin of Plaza", dt * np.arange(n), {1: ControlLog(u, U)}, {1: raw}, {1: truth}, landmarks, notes)


def _lanes(n, dt):
    """Speed and turn rate of a mower, shape (n, 2): lanes of 12 s, and half a turn of 3 s to the left or the right."""
    t = dt * np.arange(n) % 30.0
    turning = (t % 15.0) >= 12.0
    return np.stack([np.where(turning, 1.5, 3.5), np.where(turning, np.where(t < 15, 1.05, -1.0), 0.01)], -1)


def _zero_of_gyroscope(odometry):
    """The turn rate that the gyroscope tells while the robot stands, rad/s, and what was done in words."""
    dt = np.diff(odometry[:, 0])
    still = odometry[1:, 1] < STILL * dt
    if still.sum() < 20:
        return 0.0, []
    zero = float(np.median(odometry[1:, 2][still] / dt[still]))
    return zero, [f"zero of the gyroscope {zero:.5f} rad/s, from {still.sum()} rows in which the robot stands"]


def _true(path, times):
    """True poses at these times, NaN outside the path. The heading is the way it goes, not the one astern."""
    t, x, y, theta = path.T
    way = np.diff(path[:, 1:3], axis=0)
    long = np.hypot(*way.T) > 0.1
    off = np.arctan2(way[:, 1], way[:, 0]) - theta[:-1]
    off = np.arctan2(np.sin(off[long]).sum(), np.cos(off[long]).sum()) if long.any() else 0.0
    off = np.pi * np.round(off / np.pi)  # ahead, or astern
    poses = np.stack([np.interp(times, t, a, np.nan, np.nan) for a in (x, y, np.unwrap(theta) + off)], -1)
    poses[:, 2] = wrap(poses[:, 2])
    return poses


def _read(file):
    """The arrays of the file as floats, their shapes checked."""
    m = {k: np.asarray(v, float) for k, v in read_mat(file, COLUMNS).items()}
    missing = [k for k in COLUMNS if k not in m]
    if missing:
        raise ValueError(f"{file} is not a file of Plaza: it has no array {', '.join(missing)}")
    for name, columns in COLUMNS.items():
        if m[name].ndim != 2 or m[name].shape[1] != columns or not np.isfinite(m[name]).all():
            raise ValueError(f"{file}: {name} must have {columns} columns of finite numbers, got {m[name].shape}")
    return m
